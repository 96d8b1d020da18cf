//! A run of a scene: the simulation with its clock, its recording, its selection and its notices. Independent of drawing.
//!
//! Changes of the simulation are [`Change`]s; those of a person, a script or a panel come through
//! [`Stage::change`]. The ticks of a frame lie between `begin_ticks` and `end_ticks`.

mod accessors;
mod change;
pub(crate) mod forces;
mod going_back;
pub mod notices;
pub mod options;
pub mod playback;
pub(crate) mod pull;
pub mod quarantines;
pub(crate) mod recorder;
pub(crate) mod soft;
pub mod things;
pub(crate) mod ticks;
pub(crate) mod timeline;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf, absolute};
use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_ecs::query::{QueryData, QueryFilter};
use glam::DVec3;
use history::{Change, RunSettings, Simulation};
use motion::clock::StepClock;
use motion::effects::Effect;
use motion::{
    Dormant, Emission, Emitter, Evaluations, Orientation, PhysicsBody, PreviousPosition, Push,
    PushQueue, Quarantined, SoftBody, Spring, Threads, TimeStep, Transform,
};
use pick::{Blades, Shape};
use scene::{Appearance, FileIndex, PointRadius, Scene, SoftBodyName};

use self::notices::Notices;
use self::options::Options;
use self::playback::Playback;
use self::pull::Pull;
use self::quarantines::Quarantines;
use self::recorder::Recorder;
use crate::input::SwitchedBy;

/// An order that the program carries out after a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// Write the picture of this frame, under the name from a script, if any.
    Screenshot(Option<String>),
    /// Write the recorded run into a bundle.
    Bundle,
    /// Write the text as a CSV file.
    Table(String),
    /// Write the text of a scene into a file.
    Scene(SceneFile),
    /// Load the scene with this name.
    Open(String),
    /// Measure the runs of the shipped lesson with this name, and begin it in its scene.
    Lesson(String),
    /// Restore the unsaved changes in this file.
    Restore(PathBuf),
    /// Delete the unsaved changes in this file.
    Forget(PathBuf),
    /// Quit the program.
    Quit,
}

impl Order {
    /// Whether it ends the scene that is open.
    #[must_use]
    pub const fn leaves_scene(&self) -> bool {
        match self {
            Self::Open(_) | Self::Lesson(_) | Self::Restore(_) | Self::Quit => true,
            Self::Screenshot(_)
            | Self::Bundle
            | Self::Table(_)
            | Self::Scene(_)
            | Self::Forget(_) => false,
        }
    }
}

/// A scene to be written into a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneFile {
    /// The file, which is new or has the text `replaces`.
    pub path: PathBuf,
    /// The text to write.
    pub text: Arc<str>,
    /// The text that an existing file is expected to have.
    pub replaces: Option<Arc<str>>,
    /// The text of the scene when the file was ordered. `text` adds the changes made outside the editor.
    pub scene_text: Arc<str>,
}

/// The kind of a completed tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simulated {
    /// A tick of the run; the stage is at its end.
    New,
    /// A tick that a seek simulates; the stage does not show it.
    Again,
}

/// Builds the start of `scene` with `options`.
pub fn start(scene: impl Into<Arc<Scene>>, options: Options) -> Simulation {
    Simulation::prepared(scene, |world, bodies| prepare(world, bodies.len(), options))
}

/// Prepares `world` for `options`: threads share a large world, movable bodies can be drawn between two ticks, and pictures
/// need no mutable world.
pub(crate) fn prepare(world: &mut World, bodies: usize, options: Options) {
    if bodies >= Threads::FROM {
        world.insert_resource(Threads::new(options.threads));
    }
    register_drawn(world);
    if options.interpolate {
        let movable: Vec<_> = world
            .query_filtered::<(Entity, &Transform, &PhysicsBody), Without<PreviousPosition>>()
            .iter(world)
            .filter(|(_, _, body)| body.inverse_mass > 0.0)
            .map(|(entity, transform, _)| (entity, PreviousPosition(transform.position)))
            .collect();
        world.insert_batch(movable);
    }
}

/// Builds a query of an immutable world. Its components must be registered: see [`register_drawn`].
pub(crate) fn query<D: QueryData, F: QueryFilter>(world: &World) -> QueryState<D, F> {
    world.try_query_filtered().expect("`register_drawn` names the components of pictures")
}

/// Registers every component that a [`query`] may name.
pub(crate) fn register_drawn(world: &mut World) {
    world.register_component::<Transform>();
    world.register_component::<PreviousPosition>();
    world.register_component::<PhysicsBody>();
    world.register_component::<Quarantined>();
    world.register_component::<Dormant>();
    world.register_component::<Shape>();
    world.register_component::<Orientation>();
    world.register_component::<Appearance>();
    world.register_component::<PointRadius>();
    world.register_component::<SoftBody>();
    world.register_component::<SoftBodyName>();
    world.register_component::<Blades>();
    world.register_component::<FileIndex>();
    world.register_component::<Spring>();
    world.register_component::<Emitter>();
    world.register_component::<Emission>();
}

/// Where a world came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The start of its scene.
    Start,
    /// A seek, which restored it.
    Seek,
}

/// State of a stage that is replaced with the world.
pub struct PerWorld {
    /// Number of earlier worlds of the stage.
    pub number: u64,
    /// Increases whenever the drawn positions may change; results computed at another version are out of date.
    pub version: u64,
    /// Where the world came from.
    pub origin: Origin,
    selection: Option<Entity>,
    /// The pull of the pointer.
    pub(crate) pull: Option<Pull>,
    /// How many times a person or a script changed the run; a drag and a held key count once.
    pub interventions: u64,
    /// Pushes of the last tick, N.
    pushes: HashMap<Entity, DVec3>,
    /// Interpolation between the last two ticks for drawing, in [0, 1].
    pub alpha: f64,
    /// Changes that the tools have not received yet.
    untold: Vec<Change>,
    /// Number of unconverged implicit steps when this world began; `None` once the person was told that there are more.
    unconverged_before: Option<u64>,
    /// Whether the person was told that chosen substeps do not suffice.
    told_of_excess: bool,
}

impl PerWorld {
    fn of(sim: &Simulation, origin: Origin) -> Self {
        Self {
            number: 0,
            version: 0,
            origin,
            selection: None,
            pull: None,
            interventions: 0,
            pushes: HashMap::new(),
            alpha: 1.0,
            untold: Vec::new(),
            unconverged_before: Some(sim.world.resource::<Evaluations>().unconverged_steps()),
            told_of_excess: false,
        }
    }

    /// The pushes of the last tick, N.
    pub fn pushes(&self) -> Vec<Push> {
        let push = |(body, newtons): (&Entity, &DVec3)| Push { body: *body, newtons: *newtons };
        self.pushes.iter().map(push).collect()
    }

    /// Notes the pushes of the coming tick. They are shown until the next tick: a frame without a tick does not change them.
    fn note_pushes(&mut self, world: &World) {
        self.pushes.clear();
        for Push { body, newtons } in world.resource::<PushQueue>().pending() {
            *self.pushes.entry(body).or_default() += newtons;
        }
    }

    /// The time at which bodies are drawn, between the last two ticks of `sim`, s.
    pub fn drawn_at(&self, sim: &Simulation) -> f64 {
        sim.seconds() - (1.0 - self.alpha) * sim.world.resource::<TimeStep>().0
    }
}

/// Scene files that were opened or saved, the newest last.
#[derive(Default)]
pub struct RecentFiles(Vec<PathBuf>);

impl RecentFiles {
    /// All of them.
    #[must_use]
    pub fn all(&self) -> &[PathBuf] {
        &self.0
    }

    /// Adds a file, or makes it the newest.
    pub fn note(&mut self, path: &Path) {
        let same = |other: &PathBuf| absolute(other).ok() == absolute(path).ok();
        self.0.retain(|other| !same(other));
        self.0.push(path.to_owned());
    }

    /// Adds files of earlier windows, the newest last.
    pub fn remember(&mut self, mut files: Vec<PathBuf>) {
        files.append(&mut self.0);
        files.iter().for_each(|file| self.note(file));
    }
}

/// A run of a scene.
pub struct Stage {
    sim: Simulation,
    here: PerWorld,
    options: Options,
    playback: Playback,
    recorder: Recorder,
    quarantines: Quarantines,
    /// Pushes of held keys, N, applied in every tick.
    held: Vec<Push>,
    /// The source of the last change of each effect.
    switched: BTreeMap<Effect, SwitchedBy>,
    /// Caption from a script, shown below pictures instead of the description of the scene.
    pub(crate) caption: Option<String>,
    /// Notices for the person.
    pub notices: Notices,
    /// Orders for the program.
    pub orders: Vec<Order>,
    /// Scene files of the session.
    pub files: RecentFiles,
}

impl Stage {
    /// Starts `scene`.
    pub(crate) fn new(mut scene: Scene, options: Options) -> Self {
        options.overrides.apply(&mut scene);
        let sim = start(scene, options);
        Self {
            here: PerWorld::of(&sim, Origin::Start),
            playback: Playback::new(&sim.scene, &options),
            options,
            recorder: Recorder::default(),
            quarantines: Quarantines::default(),
            held: Vec::new(),
            switched: BTreeMap::new(),
            caption: None,
            notices: Notices::default(),
            orders: Vec::new(),
            files: RecentFiles::default(),
            sim,
        }
    }

    /// Opens another scene in the same run, whose time and counts continue. The scene already has the overrides.
    pub(crate) fn open(&mut self, scene: Scene) {
        self.playback = self.playback.next(&scene, &self.options);
        self.switched.clear();
        self.caption = None;
        self.begin_world(start(scene, self.options), None);
    }

    /// Rebuilds the world. Keeps gravity, damping, the switched-off effects, the method and the step; clears the selection.
    pub(crate) fn reset(&mut self) {
        let settings = RunSettings::of(&self.sim);
        let next = start(Arc::clone(&self.sim.scene), self.options);
        self.playback.reset_pace();
        self.begin_world(next, Some(settings));
    }

    /// Replaces the world with `next`, the start of a scene, with `settings`. Time and counts continue.
    fn begin_world(&mut self, mut next: Simulation, settings: Option<RunSettings>) {
        let mut clock = *self.sim.world.resource::<StepClock>();
        clock.begin_scene();
        next.world.insert_resource(clock);
        let evaluations = std::mem::take(&mut *self.sim.world.resource_mut::<Evaluations>());
        next.world.insert_resource(evaluations);
        // `Evaluations` is in place: another method may evaluate laws at once, and those count.
        settings.into_iter().for_each(|settings| settings.put(&mut next));
        self.quarantines.begin_world();
        self.replace(next, Origin::Start);
        self.notices.retract_run();
        self.restart_recording();
    }

    /// Gives the scene the substeps of the world: a reset and what starts from the scene have them, too.
    fn keep_substeps(&mut self) {
        let substeps = self.sim.substeps();
        if self.sim.scene.substeps != substeps {
            Arc::make_mut(&mut self.sim.scene).substeps = substeps;
        }
    }

    /// Replaces the world.
    fn replace(&mut self, sim: Simulation, origin: Origin) {
        self.sim = sim;
        self.keep_substeps();
        self.held.clear();
        let PerWorld { number, version, .. } = self.here;
        let next = PerWorld::of(&self.sim, origin);
        self.here = PerWorld { number: number + 1, version: version + 1, ..next };
        self.quarantines.follow(&self.sim);
    }
}
