//! A run: the simulation with its clock, its recording, its selection, and what is said about it. It knows no picture.
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

/// Simulated time that one frame may catch up with, s; what a longer frame owes is dropped and reported.
pub(crate) const CATCH_UP: f64 = 0.25;

/// What the program outside has to do after a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// Write the picture of this frame; a name if a script gave one.
    Screenshot(Option<String>),
    /// Write the run into a file: a black box.
    Bundle,
    /// Write that text as a CSV file.
    Table(String),
    /// Write the text of a scene into a file.
    Scene(SceneFile),
    /// Load the scene of that name.
    Open(String),
    /// Restore the unsaved changes in that file.
    Restore(PathBuf),
    /// Delete those unsaved changes.
    Forget(PathBuf),
    /// Leave.
    Quit,
}

/// A scene to be written into a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneFile {
    /// The file, which is new or has the text that it `replaces`.
    pub path: PathBuf,
    /// What the file gets.
    pub text: Arc<str>,
    /// What the file has.
    pub replaces: Option<Arc<str>>,
    /// The text of the scene at that time, from which `text` differs by what was set without the editor.
    pub of: Arc<str>,
}

/// What a stage does when something goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OnFault {
    /// It goes back to the last good tick, pauses and selects the body.
    Pause,
    /// It simulates no further.
    Stop,
}

/// A tick that is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simulated {
    /// One of the run; the stage is at its end.
    New,
    /// One that a seek simulates; the stage does not show it.
    Again,
}

/// The start of `scene`, as `options` want it.
pub(crate) fn start(scene: impl Into<Arc<Scene>>, options: Options) -> Simulation {
    Simulation::prepared(scene, |world, bodies| prepare(world, bodies.len(), options))
}

/// Lets threads share a large world, movable bodies be drawn between two ticks, and pictures be taken without changing the
/// world.
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

/// A query of a world that is not mutable. Its components have to be registered: see [`register_drawn`].
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

/// What belongs to one world; another world has its own.
pub(crate) struct PerWorld {
    /// How many worlds the stage had before.
    pub number: u64,
    /// Whether it was restored by a seek; else it began at the start of its scene.
    pub sought: bool,
    pub selection: Option<Entity>,
    /// What the pointer pulls.
    pub pull: Option<Pull>,
    /// How many times a person or a script changed the run; a drag and a held key count once.
    pub interventions: u64,
    /// Pushes of the last tick, N.
    pub pushes: HashMap<Entity, DVec3>,
    /// Where between the last two ticks bodies are drawn, in [0, 1].
    pub alpha: f64,
    /// Changes that the tools have not been told of.
    pub given: Vec<Change>,
    /// Quarantined bodies of this world that have been noted.
    pub records_seen: usize,
    /// Implicit steps that had not converged before; `None` once the person was told of one.
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

/// What lasts from scene to scene.
#[derive(Default)]
pub(crate) struct Run {
    pub options: Options,
    /// Whether the last minute is recorded, and what a fault does.
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
    /// That of the last frame, s.
    pub dropped_lately: f64,
    pub quarantined: Vec<QuarantinedBody>,
    /// How many of them are of other worlds.
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

/// Why a pace cannot be refused.
const PACE: &str = "a checked pace is positive and finite";

/// A run of a scene.
pub struct Stage {
    sim: Simulation,
    pub(crate) here: PerWorld,
    /// Rises whenever things may be drawn elsewhere; what was computed at another version is out of date.
    pub(crate) version: u64,
    pub(crate) paused: bool,
    /// Ticks that were asked for one by one.
    pub(crate) steps_asked: u64,
    /// Pushes of held keys, N, which act in every tick.
    pub(crate) held: Vec<Push>,
    /// What switched an effect last.
    pub(crate) switched: BTreeMap<Effect, SwitchedBy>,
    /// The last minute, if it is recorded.
    pub(crate) past: Option<Box<Recorded>>,
    pub(crate) clock: TickClock,
    /// What the person is told.
    pub notices: Notices,
    pub(crate) orders: Vec<Order>,
    /// What a script wrote below pictures, in place of the description of the scene.
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

    /// Opens another scene in the same run: its time and its counts continue.
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

    /// Builds the world again; gravity, damping, what is switched off, method and step stay, the selection does not.
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

    /// Simulated seconds per second of frame time, until a person changes that.
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

    /// How a click pushes.
    pub(crate) fn push_spec(&self) -> PushSpec {
        self.sim.scene.push.unwrap_or(PushSpec::TUTORIAL)
    }
}

/// Gives the `next` world the time and the counts of another: it is the same run.
fn hand_over(world: &mut World, next: &mut World) {
    let mut clock = *world.resource::<StepClock>();
    clock.begin_scene();
    next.insert_resource(clock);
    next.insert_resource(std::mem::take(&mut *world.resource_mut::<Evaluations>()));
}
