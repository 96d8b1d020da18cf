//! A scene as the program uses it: plain data, SI units, no absent numbers.

pub(crate) mod coupled;
pub(crate) mod names;
pub(crate) mod survival;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DQuat, DVec3};
use motion::effects::Effect;
use motion::{
    AxisLocks, BodyDrag, Damping, DampingModel, Elastic, Gravity, Law, Method, MutualGravity,
    PrescribedMotion, Range, Thrust, Well, Wells, WorldLaws,
};
use pick::Shape;

use crate::scene::coupled::{Declaration, EmitterSpec, SoftBodySpec, SpringSpec};
use crate::scene::names::Names;
use crate::scene::survival::SurvivalRow;
use crate::substepping::Substepping;

/// Version of the scene format that this program reads.
pub const SCENE_VERSION: u32 = 1;

/// A resolved scene, from which any number of worlds can be spawned.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The text that it was read from.
    pub text: Arc<str>,
    /// The memory that reading it took.
    pub reading: Reading,
    /// The name of the scene, or of its file if it declares none.
    pub name: String,
    /// One line for the scene list; may be empty.
    pub description: String,
    /// Where the scene came from.
    pub source: Source,
    /// Ticks per second, positive and finite.
    pub step_hz: f64,
    /// Simulated seconds per second of watching, above 0.
    pub pace: f64,
    /// The length of ticks.
    pub step: StepKind,
    /// Integration method of every body without its own.
    pub method: Method,
    /// Substeps of every body without its own.
    pub substeps: Substepping,
    /// The seed of the generators.
    pub seed: u64,
    /// Uniform gravity, if the scene declares it.
    pub gravity: Option<Gravity>,
    /// Damping, if the scene or a body of it declares it.
    pub damping: Option<Damping>,
    /// The other laws of every body that the scene declares.
    pub laws: WorldLaws,
    /// Gravity between bodies, if the scene declares it.
    pub mutual_gravity: Option<MutualGravity>,
    /// The range that bodies have to stay in, if the scene declares one.
    pub range: Option<Range>,
    /// Own laws of bodies, by stable id.
    pub own_laws: BTreeMap<u32, OwnLawsSpec>,
    /// Motions that immovable bodies follow, by stable id.
    pub motions: BTreeMap<u32, PrescribedMotion>,
    /// Pushes by pointer, if the scene declares them.
    pub push: Option<PushSpec>,
    /// The camera at the start and after a reset.
    pub camera: CameraSpec,
    /// The light, if the scene declares one.
    pub light: Option<LightSpec>,
    /// Whether trails are shown from the start.
    pub trails: bool,
    /// Whether a click also selects bodies that cannot be moved, as in the tutorial.
    pub select_immovable: bool,
    /// Every body in the order of the stable id: the written ones, then those of grids, clouds, rings, emitters and soft
    /// bodies.
    pub bodies: Vec<BodySpec>,
    /// The name of every body, by stable id.
    pub names: Names,
    /// Texts that are drawn beside bodies, by stable id, ascending; each is one line of at most 60 characters.
    pub labels: Vec<(u32, String)>,
    /// Sources of particles, in the order of the file.
    pub emitters: Vec<EmitterSpec>,
    /// Springs between single bodies, in the order of the file.
    pub springs: Vec<SpringSpec>,
    /// Chains, cloths and lattices, in the order of the file.
    pub soft_bodies: Vec<SoftBodySpec>,
    /// Effects that are switched off at the start.
    pub off_at_start: Vec<Effect>,
    /// The key that declares each effect of the scene, in the order of the receipt.
    pub declared: Vec<Declaration>,
    /// The bounds that `run --assert` checks, if the scene has any.
    pub expect: Option<ExpectSpec>,
    /// Rows of the survival matrix, at least one, if the scene is a hard case.
    pub survival: Option<Vec<SurvivalRow>>,
}

impl SurvivalRow {
    /// The scene with the step, substeps, damping and offset of this row, and without methods or substeps of single
    /// bodies.
    #[must_use]
    pub fn scene(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        (scene.step_hz, scene.substeps, scene.damping) =
            (self.step_hz, self.substeps, self.damping);
        for body in &mut scene.bodies {
            body.position += self.offset;
            // Only position Verlet reads a previous position, and would start from another state than the other
            // methods.
            (body.method, body.substeps, body.verlet_previous) = (None, None, None);
        }
        let own = scene.own_laws.values_mut().flat_map(|laws| &mut laws.wells);
        let wells = scene.laws.wells.iter_mut().flat_map(|wells| &mut wells.0);
        wells.chain(own).for_each(|well| well.position += self.offset);
        let fixed = scene.emitters.iter_mut().filter(|emitter| emitter.rides_on.is_none());
        fixed.for_each(|emitter| emitter.position += self.offset);
        scene
    }
}

impl Scene {
    /// The push of a click: the scene's, or the tutorial's.
    #[must_use]
    pub fn push_spec(&self) -> PushSpec {
        self.push.unwrap_or(PushSpec::TUTORIAL)
    }

    /// Whether the body of that stable id is a particle of an emitter.
    #[must_use]
    pub fn is_particle(&self, id: u32) -> bool {
        self.emitters.iter().any(|emitter| emitter.pool.contains(&id))
    }

    /// Ticks in `seconds`, to the nearest; 0 for less than half a tick.
    #[must_use]
    pub fn ticks_in(&self, seconds: f64) -> u64 {
        (seconds * self.step_hz).round() as u64
    }

    /// All springs, those of soft bodies too: the stable ids of their ends, and their numbers.
    pub fn all_springs(&self) -> impl Iterator<Item = ([u32; 2], Elastic)> + '_ {
        let links = self.soft_bodies.iter().flat_map(|soft| {
            let first = soft.points.start;
            soft.links.iter().map(move |link| (link.ends.map(|end| first + end), link.elastic))
        });
        self.springs.iter().map(|spring| (spring.ends, spring.elastic)).chain(links)
    }

    /// The emitters whose particles are on a graphics device, by their place in [`Scene::emitters`].
    pub fn on_device(&self) -> impl Iterator<Item = (usize, &EmitterSpec)> {
        self.emitters.iter().enumerate().filter(|(_, emitter)| emitter.on_device.is_some())
    }

    /// Number of particles on a graphics device for which there is room.
    #[must_use]
    pub fn particles_on_device(&self) -> usize {
        self.emitters.iter().map(EmitterSpec::particles_on_device).sum()
    }

    /// Number of bodies in the pools of emitters.
    #[must_use]
    pub fn particles_in_pools(&self) -> usize {
        self.emitters.iter().map(|emitter| emitter.pool.len()).sum()
    }

    /// The scene with the damping that its methods approximate: the law, in place of a model that damps per tick.
    #[must_use]
    pub fn damped_by_law(mut self) -> Self {
        if let Some(damping) = &mut self.damping {
            damping.model = DampingModel::Exact;
        }
        self
    }
}

/// The source of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The shipped scene of that name, embedded in the program.
    Shipped(&'static str),
    /// A file.
    File(PathBuf),
    /// A text without a file.
    Text,
}

impl Source {
    /// The file, if it is one.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Shipped(_) | Self::Text => None,
        }
    }
}

/// The length of ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StepKind {
    /// Ticks of `1 / step_hz` seconds, as many as are due.
    #[default]
    Fixed,
    /// One tick of the frame's own length, as the tutorial's text has it.
    Frame,
}

/// Strength of pushes with the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PushSpec {
    /// Strength at the start, N; a negative one pulls.
    pub start: f64,
    /// Strength that one notch of the wheel adds, N.
    pub per_notch: f64,
    /// Distance from the place that the pointer hits within which other bodies are pushed, too, m: at distance d with
    /// (1 - d²/r²)² of the force.
    pub radius: Option<f64>,
}

impl PushSpec {
    /// The tutorial's click force.
    pub const TUTORIAL: Self = Self { start: 10.0, per_notch: 100.0, radius: None };
}

/// A camera: right-handed, y up, looking along -z at yaw 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSpec {
    /// Position of the eye, m.
    pub position: DVec3,
    /// Turn about the camera's right, degrees, -90 to 90; positive looks up.
    pub pitch_deg: f64,
    /// Turn about the vertical, degrees; positive turns left.
    pub yaw_deg: f64,
    /// Vertical field of view, degrees, above 0 and below 180.
    pub fov_y_deg: f64,
    /// Nearest distance drawn, m, above 0.
    pub near: f64,
    /// Farthest distance drawn, m, above `near`.
    pub far: f64,
}

impl CameraSpec {
    /// The tutorial's camera, which is also the default.
    pub const TUTORIAL: Self = Self {
        position: DVec3::new(-60.0, 40.0, 60.0),
        pitch_deg: -15.0,
        yaw_deg: 315.0,
        fov_y_deg: 45.0,
        near: 0.1,
        far: 500.0,
    };
}

/// A point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSpec {
    /// Position, m.
    pub position: DVec3,
    /// Linear red, green and blue, each at least 0.
    pub color: [f32; 3],
    /// Whether it casts shadows.
    pub shadows: bool,
}

impl LightSpec {
    /// The tutorial's light.
    pub const TUTORIAL: Self =
        Self { position: DVec3::new(-200.0, 60.0, -200.0), color: [0.8, 0.8, 0.5], shadows: true };
}

/// Laws that act on one body alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OwnLawsSpec {
    /// Its own drag.
    pub drag: Option<BodyDrag>,
    /// Wells that name the body.
    pub wells: Vec<Well>,
    /// Wells that name it and ride on another body.
    pub riding_wells: Vec<RidingWellSpec>,
    /// Its engines; their forces add up.
    pub thrusts: Vec<Thrust>,
}

/// A well that rides on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RidingWellSpec {
    /// Stable id of the body.
    pub rides_on: u32,
    /// Its strength, m³/s².
    pub strength: f64,
    /// Its softening, m.
    pub softening: f64,
}

impl OwnLawsSpec {
    /// The same laws for bodies with other ids, without wells that ride on a body without a new id.
    #[must_use]
    pub fn renumbered(&self, id: impl Fn(u32) -> Option<u32>) -> Self {
        let riding =
            |well: &RidingWellSpec| Some(RidingWellSpec { rides_on: id(well.rides_on)?, ..*well });
        Self { riding_wells: self.riding_wells.iter().filter_map(riding).collect(), ..self.clone() }
    }

    /// The laws themselves, without wells that ride on bodies.
    #[must_use]
    pub fn laws(&self) -> Vec<Box<dyn Law>> {
        let drag = self.drag.map(|drag| Box::new(drag) as Box<dyn Law>);
        let wells =
            (!self.wells.is_empty()).then(|| Box::new(Wells(self.wells.clone())) as Box<dyn Law>);
        let thrusts = self.thrusts.iter().map(|thrust| Box::new(thrust.clone()) as Box<dyn Law>);
        drag.into_iter().chain(wells).chain(thrusts).collect()
    }
}

/// The memory that reading a scene takes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// Bytes of the text.
    pub text: u64,
    /// Bytes of the entries of its lists while it is read.
    pub entries: u64,
    /// Bodies that are written as entries of their own.
    pub bodies: u64,
    /// Bytes of their names and labels.
    pub name_bytes: u64,
}

impl PartialEq for Reading {
    /// Always equal: two texts of one scene may be read differently.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// One body, or one piece of scenery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodySpec {
    /// What rays hit and what is drawn; `None` is a particle.
    pub shape: Option<Shape>,
    /// Center, m.
    pub position: DVec3,
    /// Its rotation, if it has one.
    pub orientation: Option<DQuat>,
    /// Velocity at the start, m/s; zero for scenery and immovable bodies.
    pub velocity: DVec3,
    /// Position one substep before the start, m, from which position Verlet starts.
    pub verlet_previous: Option<DVec3>,
    /// Reciprocal of the mass, 1/kg; 0 is immovable, `None` is scenery: a collision volume without physics.
    pub inverse_mass: Option<f64>,
    /// Mass of an immovable body as a source of mutual gravity, kg, above 0, if it is one.
    pub source_mass: Option<f64>,
    /// Linear red, green and blue, each 0 to 1.
    pub color: [f32; 3],
    /// Whether it has the checker texture.
    pub checker: bool,
    /// Integration method in place of the scene's.
    pub method: Option<Method>,
    /// Substeps in place of the scene's.
    pub substeps: Option<Substepping>,
    /// Decay rate in place of the scene's, 1/s, at least 0.
    pub damping_rate: Option<f64>,
    /// Largest speed, m/s, at least 0.
    pub max_speed: Option<f64>,
    /// Axes along which it cannot move.
    pub locks: AxisLocks,
    /// Whether gravity does not act on it.
    pub gravity_off: bool,
}

impl BodySpec {
    /// A white particle of 1 kg at rest at the origin: the body of an entry without keys.
    pub const DEFAULT: Self = Self {
        shape: None,
        position: DVec3::ZERO,
        orientation: None,
        velocity: DVec3::ZERO,
        verlet_previous: None,
        inverse_mass: Some(1.0),
        source_mass: None,
        color: [1.0; 3],
        checker: false,
        method: None,
        substeps: None,
        damping_rate: None,
        max_speed: None,
        locks: AxisLocks { x: false, y: false, z: false },
        gravity_off: false,
    };

    /// Whether it has physics and is not immovable.
    #[must_use]
    pub fn is_movable(&self) -> bool {
        self.inverse_mass.is_some_and(|inverse_mass| inverse_mass > 0.0)
    }
}

/// Bounds of the scene's run, checked by `run --assert`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExpectSpec {
    /// Bound of the relative energy drift, above 0.
    pub energy_drift_below: Option<f64>,
    /// Whether every body stays finite.
    pub finite: Option<bool>,
}
