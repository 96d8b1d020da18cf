//! The view of a stage: functions from a stage and a camera to a picture, and to the places of things in it. They do not change
//! the stage.

pub(crate) mod arrows;
pub(crate) mod art;
pub(crate) mod camera;
pub(crate) mod card;
pub(crate) mod flash;
mod ground;
pub(crate) mod hud;
pub(crate) mod inks;
pub(crate) mod labels;
pub(crate) mod marks;
pub(crate) mod navigation;
pub mod on_device;
mod passes;
pub(crate) mod picking;
pub(crate) mod picture;
pub(crate) mod pull;
pub(crate) mod springs;
mod trails;

use glam::DVec2;
use motion::TimeStep;
use pick::{SoftTargets, Targets};
use scene::Scene;

use self::art::Lamp;
use self::camera::Camera;
use self::flash::Flash;
use self::ground::Ground;
use self::passes::Passes;
use self::picture::Point;
use self::trails::Trails;
use crate::stage::Stage;
use crate::stage::options::Words;
use crate::stage::things::Thing;

/// The use of the pointer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// The mouse turns the camera, keys fly it, the pointer is grabbed.
    #[default]
    Camera,
    /// The pointer is free and selects.
    Selection,
}

/// Measurements of the window shell. A headless run has none, so that its pictures depend on nothing but input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Frames per second.
    pub frames_per_second: f64,
    /// Time of a tick, s.
    pub tick: f64,
    /// Simulated seconds per second.
    pub simulated_over_real: f64,
}

/// The places where things of one state are drawn, which is where rays find them.
#[derive(Default)]
struct Seen {
    targets: Targets,
    soft: SoftTargets,
    points: Vec<Point>,
    /// Number of the state, as the stage counts states; `None` before the first.
    version: Option<u64>,
}

/// The view of a stage: camera, pointer, and what is drawn.
pub struct View {
    pub(crate) camera: Camera,
    pub(crate) mode: Mode,
    /// Place of the pointer in selection mode, pixels from the top left.
    pub(crate) pointer: DVec2,
    /// Size of the picture, pixels.
    pub(crate) size_px: [u32; 2],
    /// The part of the picture that shows the scene, if panels take the rest: left, top, width and height, pixels.
    pub(crate) view_px: Option<[u32; 4]>,
    /// Red, green and blue of the area around that part.
    pub(crate) surround: [u8; 3],
    pub(crate) measured: Option<Measured>,
    pub(crate) click_force: f64,
    /// Whether the last input was a finger, for the words that say what to do.
    pub by_finger: bool,
    pub(crate) velocity_arrows: bool,
    pub(crate) force_arrows: bool,
    /// Whether every spring is drawn, instead of the surfaces that springs hold.
    pub(crate) springs: bool,
    pub(crate) trails: bool,
    /// Scale of force arrows, N per m, while they are drawn.
    pub(crate) force_scale: Option<f64>,
    /// Whether springs have the colors of their margins of stability.
    pub(crate) margins: bool,
    /// The causes of the force arrows that are drawn.
    pub(crate) force_causes: Vec<&'static str>,
    /// A push by a click, while it is shown.
    pub(crate) flash: Option<Flash>,
    /// Words beside bodies, by stable id.
    pub(crate) labels: Vec<(u32, String)>,
    pub(crate) ground: Ground,
    lamp: Lamp,
    /// The thing that the camera follows.
    pub(crate) locked: Option<Thing>,
    seen: Seen,
    trail: Trails,
    passes: Passes,
}

impl View {
    /// Makes the view of a stage at its start, in a picture of `size_px`.
    pub(crate) fn new(stage: &Stage, size_px: [u32; 2]) -> Self {
        let scene: &Scene = &stage.sim().scene;
        Self {
            camera: Camera::new(scene.camera).at_distance(navigation::distance_of(scene)),
            mode: Mode::default(),
            pointer: DVec2::ZERO,
            size_px,
            view_px: None,
            surround: [0; 3],
            measured: None,
            click_force: stage.sim().scene.push_spec().start,
            by_finger: false,
            velocity_arrows: false,
            force_arrows: false,
            springs: false,
            trails: scene.trails,
            force_scale: None,
            margins: false,
            force_causes: Vec::new(),
            flash: None,
            labels: scene.labels.clone(),
            ground: Ground::of(scene),
            lamp: Lamp::of(scene),
            locked: None,
            seen: Seen::default(),
            trail: Trails::default(),
            passes: Passes::default(),
        }
    }

    /// Restarts for the next scene. Keeps the mode and the layout of the window.
    pub(crate) fn open(&mut self, stage: &Stage) {
        let next = Self::new(stage, self.size_px);
        *self = Self {
            mode: self.mode,
            pointer: self.pointer,
            view_px: self.view_px,
            surround: self.surround,
            measured: self.measured,
            by_finger: self.by_finger,
            ..next
        };
    }

    /// Continues with another text of the scene `before`. Keeps everything about which the texts agree.
    pub(crate) fn reopen(&mut self, stage: &Stage, before: &Scene) {
        let next = Self::new(stage, self.size_px);
        let scene = &stage.sim().scene;
        if scene.camera != before.camera {
            self.camera = next.camera;
        }
        if scene.push != before.push {
            self.click_force = next.click_force;
        }
        if scene.trails != before.trails {
            self.trails = next.trails;
        }
        (self.labels, self.lamp) = (next.labels, next.lamp);
        self.ground = self.ground.changed_to(next.ground);
        self.locked = None;
        self.forget_world();
    }

    /// Whether the picture has the program's own look, and not the tutorial's: with bars around it, or without words.
    pub(crate) fn is_own_look(&self, stage: &Stage) -> bool {
        self.has_bars() || stage.options().words != Words::All
    }

    /// Forgets what belonged to another world.
    pub(crate) fn forget_world(&mut self) {
        (self.seen, self.trail, self.flash) = (Seen::default(), Trails::default(), None);
        self.passes = Passes::default();
    }

    /// Starts or stops drawing trails.
    pub(crate) fn toggle_trails(&mut self) {
        self.trails ^= true;
        self.trail = Trails::default();
    }

    /// Records where bodies are at the end of a tick.
    pub(crate) fn after_tick(&mut self, stage: &Stage) {
        if self.trails {
            self.trail.after_tick(
                &stage.sim().world,
                stage.sim().seconds(),
                stage.playback().usual_pace(),
            );
        }
        if let Some(height) = self.ground_to_pass(stage) {
            let tick = stage.sim().world.resource::<TimeStep>().0;
            self.passes.after_tick(&stage.sim().world, height, stage.sim().seconds(), tick);
        }
    }

    /// Whether the positions of bodies before a tick are needed for every tick, and not only for the last one of a frame.
    pub(crate) fn follows_ticks(&self, stage: &Stage) -> bool {
        stage.options().interpolate && (self.trails || self.ground_to_pass(stage).is_some())
    }

    /// The height of the ground, m, if rings show the bodies that pass it.
    fn ground_to_pass(&self, stage: &Stage) -> Option<f64> {
        self.ground.height(self.is_own_look(stage)).filter(|_| stage.options().interpolate)
    }

    /// Moves the camera after the thing to which it is locked.
    pub(crate) fn follow_locked(&mut self, stage: &Stage) {
        let Some(thing) = self.locked else { return };
        match thing.entity(stage.sim()).and_then(|entity| stage.drawn_position(entity)) {
            Some(position) => self.camera.follow(position),
            None => self.locked = None,
        }
    }

    /// Camera or selection mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// The camera.
    #[must_use]
    pub const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Changes the force of a click by notches of the wheel.
    pub(crate) fn turn_force(&mut self, stage: &Stage, notches: f64) {
        self.click_force += notches * stage.sim().scene.push_spec().per_notch;
    }

    /// Force of a click, N.
    #[must_use]
    pub const fn click_force(&self) -> f64 {
        self.click_force
    }

    /// Size of the picture, pixels.
    #[must_use]
    pub const fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Whether bars and a dock are around the view.
    pub const fn has_bars(&self) -> bool {
        self.view_px.is_some()
    }

    /// Whether the pointer is to be hidden and held by the window.
    #[must_use]
    pub fn grabs_pointer(&self) -> bool {
        self.mode == Mode::Camera
    }

    /// Bodies that rays can find, and the bytes of their poses.
    pub(crate) fn targets(&self) -> (usize, usize) {
        let targets = &self.seen.targets;
        let (entities, (xs, ys, zs)) = (targets.entities(), targets.positions());
        (
            entities.len(),
            size_of_val(entities) + size_of_val(xs) + size_of_val(ys) + size_of_val(zs),
        )
    }
}
