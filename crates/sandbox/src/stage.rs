//! A run of a scene: the simulation with its clock, its recording, its selection and its notices. Independent of drawing.
//!
//! Changes of the simulation are [`Change`](history::Change)s; those of a person, a script or a panel come through
//! [`Stage::change`]. The ticks of a frame lie between [`Stage::begin_ticks`] and [`Stage::end_ticks`].

mod accessors;
mod change;
pub(crate) mod forces;
mod going_back;
pub(crate) mod messages;
pub(crate) mod notices;
pub(crate) mod options;
pub(crate) mod pull;
mod recording;
pub(crate) mod soft;
pub(crate) mod things;
pub(crate) mod ticks;
pub(crate) mod timeline;

use std::collections::{BTreeMap, HashMap};
use std::num::NonZero;
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
    Quarantine, Quarantined, SoftBody, Spring, Swarm, SwarmLog, Threads, Transform,
};
use pick::Shape;
use scene::{Appearance, FileIndex, PointRadius, PushSpec, Scene, SoftBodyName};

use self::notices::{Notices, QuarantinedBody};
use self::options::Options;
use self::pull::Pull;
use self::timeline::Recorded;
use crate::clock::TickClock;
use crate::input::SwitchedBy;

/// Longest frame time that is caught up with, s. The excess of a longer frame is dropped and reported.
pub(crate) const CATCH_UP: f64 = 0.25;

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
    /// Restore the unsaved changes in this file.
    Restore(PathBuf),
    /// Delete the unsaved changes in this file.
    Forget(PathBuf),
    /// Quit the program.
    Quit,
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
    pub of: Arc<str>,
}

/// The reaction of a stage to a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OnFault {
    /// Goes back to the last good tick, pauses and selects the body.
    Pause,
    /// Stops simulating.
    Stop,
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
pub(crate) fn start(scene: impl Into<Arc<Scene>>, options: Options) -> Simulation {
    Simulation::prepared(scene, |world, bodies| prepare(world, bodies.len(), options))
}

/// Prepares `world` for `options`: threads share a large world, movable bodies can be drawn between two ticks, and pictures
/// need no mutable world.
pub(crate) fn prepare(world: &mut World, bodies: usize, options: Options) {
    if bodies >= Threads::FROM {
        let usual = || std::thread::available_parallelism().map_or(1, NonZero::get);
        world.insert_resource(Threads::new(options.threads.unwrap_or_else(usual)));
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
    world.register_component::<FileIndex>();
    world.register_component::<Spring>();
    world.register_component::<Emitter>();
    world.register_component::<Emission>();
    world.register_component::<Swarm>();
    world.register_component::<SwarmLog>();
}

/// State of a stage that is replaced with the world.
pub(crate) struct PerWorld {
    /// Number of earlier worlds of the stage.
    pub number: u64,
    /// Whether a seek restored the world; otherwise it began at the start of its scene.
    pub sought: bool,
    pub selection: Option<Entity>,
    /// The pull of the pointer.
    pub pull: Option<Pull>,
    /// How many times a person or a script changed the run; a drag and a held key count once.
    pub interventions: u64,
    /// Pushes of the last tick, N.
    pub pushes: HashMap<Entity, DVec3>,
    /// Interpolation between the last two ticks for drawing, in [0, 1].
    pub alpha: f64,
    /// Changes that the tools have not received yet.
    pub given: Vec<Change>,
    /// Number of quarantined bodies of this world that have been noted.
    pub records_seen: usize,
    /// Number of unconverged implicit steps at the start of this world; `None` once the person was told of another.
    pub unconverged_before: Option<u64>,
}

impl PerWorld {
    fn of(sim: &Simulation, number: u64, sought: bool) -> Self {
        Self {
            number,
            sought,
            selection: None,
            pull: None,
            interventions: 0,
            pushes: HashMap::new(),
            alpha: 1.0,
            given: Vec::new(),
            records_seen: sim.world.resource::<Quarantine>().records().len(),
            unconverged_before: Some(sim.world.resource::<Evaluations>().unconverged_steps()),
        }
    }
}

/// State of a session that is kept from scene to scene.
#[derive(Default)]
pub(crate) struct Run {
    pub options: Options,
    /// The reaction to a fault, if the last minute is recorded.
    pub recording: Option<OnFault>,
    /// Whether the next fault of this scene orders a bundle.
    pub saves_faults: bool,
    /// Ticks left to simulate, if they are limited.
    pub ticks_left: Option<u64>,
    pub frames: u64,
    /// Scene files that were opened or saved, the newest last.
    pub files: Vec<PathBuf>,
    /// Time dropped in hitches, s.
    pub dropped: f64,
    /// Time dropped in the last frame, s.
    pub dropped_lately: f64,
    pub quarantined: Vec<QuarantinedBody>,
    /// Number of bodies in `quarantined` that belong to earlier worlds.
    pub quarantined_before: usize,
}

impl Run {
    /// Remembers a scene file.
    pub fn note_file(&mut self, path: &Path) {
        let same = |other: &PathBuf| absolute(other).ok() == absolute(path).ok();
        self.files.retain(|other| !same(other));
        self.files.push(path.to_owned());
    }
}

/// The reason why setting a pace cannot fail.
const PACE: &str = "a checked pace is positive and finite";

/// A run of a scene.
pub struct Stage {
    sim: Simulation,
    pub(crate) here: PerWorld,
    /// Increases whenever the drawn positions may change; results computed at another version are out of date.
    pub(crate) version: u64,
    pub(crate) paused: bool,
    /// Number of single ticks requested.
    pub(crate) steps_asked: u64,
    /// Pushes of held keys, N, applied in every tick.
    pub(crate) held: Vec<Push>,
    /// The source of the last change of each effect.
    pub(crate) switched: BTreeMap<Effect, SwitchedBy>,
    /// The last minute, if it is recorded.
    pub(crate) past: Option<Box<Recorded>>,
    pub(crate) clock: TickClock,
    /// Notices for the person.
    pub notices: Notices,
    pub(crate) orders: Vec<Order>,
    /// Caption from a script, shown below pictures instead of the description of the scene.
    pub(crate) caption: Option<String>,
    pub(crate) run: Run,
}

impl Stage {
    /// Starts `scene`.
    pub(crate) fn new(mut scene: Scene, run: Run) -> Self {
        run.options.overrides.apply(&mut scene);
        let catch_up = run.options.catch_up.unwrap_or(CATCH_UP);
        let mut clock = TickClock::new(scene.step_hz, catch_up)
            .expect("a resolved scene has a positive, finite rate");
        clock.set_pace(run.options.pace.unwrap_or(scene.pace)).expect(PACE);
        let sim = start(scene, run.options);
        Self {
            here: PerWorld::of(&sim, 0, false),
            sim,
            version: 0,
            paused: run.options.paused,
            steps_asked: 0,
            held: Vec::new(),
            switched: BTreeMap::new(),
            past: None,
            clock,
            notices: Notices::default(),
            orders: Vec::new(),
            caption: None,
            run,
        }
    }

    /// Opens another scene in the same run, whose time and counts continue.
    pub(crate) fn open(&mut self, scene: Scene) {
        self.forget_ahead();
        let mut run = std::mem::take(&mut self.run);
        run.options.paused = false;
        run.quarantined_before = run.quarantined.len();
        let mut next = Self::new(scene, run);
        hand_over(&mut self.sim.world, &mut next.sim.world);
        next.here = PerWorld::of(&next.sim, self.here.number + 1, false);
        next.version = self.version + 1;
        next.clock.start_at(self.clock.now());
        next.notices = std::mem::take(&mut self.notices);
        next.notices.retract_run();
        next.orders = std::mem::take(&mut self.orders);
        *self = next;
        self.restart_recording();
    }

    /// Rebuilds the world. Keeps gravity, damping, the switched-off effects, the method and the step; clears the selection.
    pub(crate) fn reset(&mut self) {
        self.forget_ahead();
        self.run.quarantined_before = self.run.quarantined.len();
        let settings = RunSettings::of(&mut self.sim);
        let mut next = start(Arc::clone(&self.sim.scene), self.run.options);
        hand_over(&mut self.sim.world, &mut next.world);
        settings.put(&mut next);
        self.replace(next, false);
        self.notices.retract_run();
        self.clock.set_pace(self.usual_pace()).expect(PACE);
        self.restart_recording();
    }

    /// Simulated seconds per second of frame time, until a person changes the pace.
    pub(crate) fn usual_pace(&self) -> f64 {
        self.run.options.pace.unwrap_or(self.sim.scene.pace)
    }

    /// Replaces the world.
    fn replace(&mut self, sim: Simulation, sought: bool) {
        self.sim = sim;
        self.held.clear();
        self.here = PerWorld::of(&self.sim, self.here.number + 1, sought);
        self.version += 1;
    }

    /// The push of a click.
    pub(crate) fn push_spec(&self) -> PushSpec {
        self.sim.scene.push.unwrap_or(PushSpec::TUTORIAL)
    }
}

/// Moves the time and the counts of `world` to the `next` world of the same run.
fn hand_over(world: &mut World, next: &mut World) {
    let mut clock = *world.resource::<StepClock>();
    clock.begin_scene();
    next.insert_resource(clock);
    next.insert_resource(std::mem::take(&mut *world.resource_mut::<Evaluations>()));
}
