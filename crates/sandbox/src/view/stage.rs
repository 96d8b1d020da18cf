//! A simulation and how it is looked at: all that the picture, the words in it and the tools are made from.

use std::collections::HashMap;
use std::num::NonZero;
use std::path::{Path, PathBuf, absolute};
use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use history::Simulation;
use motion::clock::{StepClock, TickClock};
use motion::{
    Evaluations, PhysicsBody, PreviousPosition, Push, PushQueue, Quarantine, Request, Threads, Transform,
};
use pick::{SoftTargets, Targets};
use scene::{BodySpec, PushSpec, Scene};

use crate::view::camera::Camera;
use crate::view::ground::Ground;
use crate::view::notices::Notices;
use crate::view::options::Options;
use crate::view::pull::Pull;
use crate::view::recorded::Recorded;
use crate::view::trails::Trails;

/// Simulated time that one frame may catch up with, s; what a longer frame owes is dropped and reported.
pub(crate) const CATCH_UP: f64 = 0.25;

/// What the pointer is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// The mouse turns the camera, keys fly it, the pointer is grabbed.
    #[default]
    Camera,
    /// The pointer is free and selects.
    Selection,
}

/// What the window shell measured; a headless run has none, so that its pictures depend on nothing but input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Frames per second.
    pub frames_per_second: f64,
    /// Time of a tick, s.
    pub tick: f64,
    /// Simulated seconds per second.
    pub simulated_over_real: f64,
}

/// A body that was quarantined, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct QuarantinedBody {
    /// Name in the scene.
    pub body: String,
    /// The tick that it did not survive.
    pub tick: u64,
    /// What happened, as a sentence.
    pub what: String,
    /// The system that noticed.
    pub system: &'static str,
    /// The component or resource at fault.
    pub component: &'static str,
    /// What had happened to it: a word, with the name of the law or of the body at the other end of the spring.
    pub cause: String,
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
    /// Load the scene of that name and go on with it.
    Open(String),
    /// Go on with the unsaved changes in that file.
    Restore(PathBuf),
    /// Delete those unsaved changes.
    Forget(PathBuf),
    /// Leave.
    Quit,
}

/// The start of `scene`, as `options` want it.
pub(crate) fn start(scene: impl Into<Arc<Scene>>, options: Options) -> Simulation {
    Simulation::prepared(scene, |world, bodies| prepare(world, bodies.len(), options))
}

/// Lets the `next` simulation go on with the time and the counts of another: it is the same run.
pub(crate) fn hand_over(world: &mut World, next: &mut World) {
    let mut clock = *world.resource::<StepClock>();
    clock.begin_scene();
    next.insert_resource(clock);
    next.insert_resource(std::mem::take(&mut *world.resource_mut::<Evaluations>()));
}

/// Lets threads share a large world, and movable bodies be drawn between two ticks.
pub(crate) fn prepare(world: &mut World, bodies: usize, options: Options) {
    if bodies >= Threads::FROM {
        let usual = || std::thread::available_parallelism().map_or(1, NonZero::get);
        world.insert_resource(Threads::new(options.threads.unwrap_or_else(usual)));
    }
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

/// What belongs to one world; another world has another one.
pub(crate) struct Seen {
    /// Stable id of every body.
    pub ids: HashMap<Entity, u32>,
    pub selection: Option<Entity>,
    /// What the camera follows.
    pub locked: Option<Entity>,
    pub targets: Targets,
    pub soft: SoftTargets,
    pub targets_current: bool,
    pub trails: Trails,
    /// What the left button went down on, and where, pixels, until that becomes a click or a pull.
    pub pressed: Option<(DVec2, Pull)>,
    /// What the pointer pulls.
    pub pull: Option<Pull>,
    /// Pushes of the last tick, N.
    pub acting: HashMap<Entity, DVec3>,
    /// Where between the last two ticks bodies are drawn, in [0, 1].
    pub alpha: f64,
    /// Quarantined bodies of this world that have been noted.
    pub records_seen: usize,
    /// Implicit steps that had not converged before; `None` once the person was told of one.
    pub unconverged_before: Option<u64>,
}

impl Seen {
    pub fn of(sim: &Simulation) -> Self {
        Self {
            ids: (0..).zip(&sim.bodies).map(|(id, entity)| (*entity, id)).collect(),
            selection: None,
            locked: None,
            targets: Targets::default(),
            soft: SoftTargets::default(),
            targets_current: false,
            trails: Trails::default(),
            pressed: None,
            pull: None,
            acting: HashMap::new(),
            alpha: 1.0,
            records_seen: sim.world.resource::<Quarantine>().records().len(),
            unconverged_before: Some(sim.world.resource::<Evaluations>().unconverged_steps()),
        }
    }
}

/// How one scene is looked at and handled, whatever world of it there is.
pub(crate) struct View {
    pub camera: Camera,
    pub mode: Mode,
    /// In selection mode, pixels from the top left.
    pub pointer: DVec2,
    pub paused: bool,
    pub click_force: f64,
    pub push: PushSpec,
    pub velocity_arrows: bool,
    pub force_arrows: bool,
    /// Every spring is drawn, and not the surfaces that springs hold.
    pub springs: bool,
    pub trails: bool,
    /// Newtons of a force arrow of one meter, while these are drawn.
    pub force_scale: Option<f64>,
    /// The causes of those arrows.
    pub force_causes: Vec<&'static str>,
    /// Words beside bodies, by stable id.
    pub labels: Vec<(u32, String)>,
    pub ground: Ground,
}

/// What lasts from scene to scene.
#[derive(Default)]
pub(crate) struct Run {
    pub options: Options,
    /// The part of the picture that shows the scene, if panels take the rest: left, top, width and height, pixels.
    pub view_px: Option<[u32; 4]>,
    /// Red, green and blue of what is around it.
    pub surround: [u8; 3],
    pub measured: Option<Measured>,
    /// No picture of the coming frame is seen: its panels are not laid out.
    pub unseen: bool,
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

/// A simulation and how it is looked at.
pub struct Stage {
    pub(crate) sim: Simulation,
    pub(crate) seen: Seen,
    pub(crate) view: View,
    /// The last minute, if it is recorded.
    pub(crate) past: Option<Box<Recorded>>,
    pub(crate) clock: TickClock,
    pub(crate) notices: Notices,
    /// What was asked for and not done, lately.
    pub(crate) refusals: Vec<String>,
    pub(crate) orders: Vec<Order>,
    pub(crate) run: Run,
}

/// From the scene's camera to the middle of what moves, m; not finite where nothing does.
fn distance_of(scene: &Scene) -> f64 {
    let moves = |body: &&BodySpec| body.inverse_mass.is_some_and(|inverse| inverse > 0.0);
    let places = || scene.bodies.iter().filter(moves).map(|body| body.position);
    let (least, most) = (places().reduce(DVec3::min), places().reduce(DVec3::max));
    let middle = least.zip(most).map(|(least, most)| (least + most) / 2.0);
    middle.map_or(f64::NAN, |middle| middle.distance(scene.camera.position))
}

impl Stage {
    /// Starts `scene`.
    pub(crate) fn new(mut scene: Scene, run: Run) -> Self {
        run.options.overrides.apply(&mut scene);
        let catch_up = run.options.catch_up.unwrap_or(CATCH_UP);
        let clock =
            TickClock::new(scene.step_hz, catch_up).expect("a resolved scene has a positive, finite rate");
        let push = scene.push.unwrap_or(PushSpec::TUTORIAL);
        let view = View {
            camera: Camera::new(scene.camera).at_distance(distance_of(&scene)),
            mode: Mode::default(),
            pointer: DVec2::ZERO,
            paused: run.options.paused,
            click_force: push.start,
            push,
            velocity_arrows: false,
            force_arrows: false,
            springs: false,
            trails: scene.trails,
            force_scale: None,
            force_causes: Vec::new(),
            labels: scene.labels.clone(),
            ground: Ground::of(&scene),
        };
        let sim = start(scene, run.options);
        Self {
            seen: Seen::of(&sim),
            sim,
            view,
            past: None,
            clock,
            notices: Notices::default(),
            refusals: Vec::new(),
            orders: Vec::new(),
            run,
        }
    }

    /// Lets the stage of the next scene go on with the time and the counts of this one: it is the same run.
    pub(crate) fn hand_over(&mut self, next: &mut Self) {
        hand_over(&mut self.sim.world, &mut next.sim.world);
        next.seen = Seen::of(&next.sim);
    }

    /// Goes on with another world.
    pub(crate) fn replace(&mut self, sim: Simulation) {
        self.sim = sim;
        self.seen = Seen::of(&self.sim);
    }

    /// Asks for a change at the start of the next tick.
    pub(crate) fn ask(&mut self, request: Request) {
        self.sim.request(request);
    }

    /// Notes the pushes of the coming tick. They are shown until the next one: a frame without a tick changes nothing.
    pub(crate) fn note_pushes(&mut self) {
        self.seen.acting.clear();
        for Push { body, newtons } in self.sim.world.resource::<PushQueue>().pending() {
            *self.seen.acting.entry(body).or_default() += newtons;
        }
    }

    /// Lets the camera follow what it is locked to.
    pub(crate) fn follow_locked(&mut self) {
        if let Some(body) = self.seen.locked {
            match self.drawn_position(body) {
                Some(position) => self.view.camera.follow(position),
                None => self.seen.locked = None,
            }
        }
    }
}
