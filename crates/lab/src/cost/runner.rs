//! Things that run a subject: its world of entities, or plain arrays.
//!
//! Tests put runs of their own behind the same trait: a slow one and a broken one.

use std::borrow::Cow;
use std::collections::HashMap;

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::arrays::{Bare, NotForArrays};
use motion::groups::Groups;
use motion::real::Real;
use motion::{Evaluations, Law, Laws, Quarantine};
use scene::Scene;

use super::record::{Counts, Failure, Host, Precision, Setting};
use super::subject::Subject;
use crate::run::started;

/// Stable id, position, m, and velocity, m/s.
pub type Sample = (u32, DVec3, DVec3);

/// A run on its way.
pub trait Runner {
    /// Simulates one tick.
    fn tick(&mut self);
    /// The bodies with physics, in the order of their stable ids.
    fn states(&mut self) -> Vec<Sample>;
    /// Evaluations so far.
    fn counts(&mut self) -> Counts;
    /// Why it is no point, if it is none; non-finite states and large errors are looked for by who asks.
    fn failure(&mut self) -> Option<Failure>;
    /// Bytes of state that a step of a body reads or writes, where that is known.
    fn bytes_per_body(&self) -> Option<f64> {
        None
    }
}

/// Makes the run of a setting, or says why there is none.
pub type Make = dyn Fn(&Subject, Setting, Host) -> Result<Box<dyn Runner>, Failure> + Send;

/// The runs of the program itself.
///
/// # Errors
/// A method that cannot solve what the subject declares.
pub fn make(subject: &Subject, setting: Setting, host: Host) -> Result<Box<dyn Runner>, Failure> {
    if let Some(why) = subject.refusal(setting.method) {
        return Err(Failure::Unsolvable { why });
    }
    match host {
        Host::World => Ok(Box::new(subject.run(setting))),
        Host::Arrays => in_arrays(subject, setting),
    }
}

impl Subject {
    /// Its start, in a world.
    pub(crate) fn run(&self, setting: Setting) -> Simulation {
        let mut run = started(self.scene_with(setting), &self.without);
        if let Some(law) = self.problem.and_then(|problem| problem.law) {
            run.world.insert_resource(Laws(vec![Box::new(law)]));
            run.stepper.recompile(&mut run.world);
        }
        run
    }
}

impl Runner for Simulation {
    fn tick(&mut self) {
        Self::tick(self);
    }

    fn states(&mut self) -> Vec<Sample> {
        Self::states(self).collect()
    }

    fn counts(&mut self) -> Counts {
        let evaluations = self.world.resource::<Evaluations>();
        let (accelerations, newton, cg) =
            (evaluations.accelerations(), evaluations.newton_iterations(), evaluations.cg_iterations());
        Counts { accelerations, solver: newton + cg * mean_group(self) }
    }

    fn failure(&mut self) -> Option<Failure> {
        if let Some(record) = self.world.resource::<Quarantine>().records().first() {
            let id = self.world.get::<motion::StableId>(record.body).map_or(u32::MAX, |id| id.0);
            let body = self.scene.names.get(id).map_or_else(|| "a body".to_owned(), Cow::into_owned);
            return Some(Failure::Quarantined { body, tick: record.tick });
        }
        let steps = self.world.resource::<Evaluations>().unconverged_steps();
        (steps > 0).then_some(Failure::Unconverged { steps })
    }
}

/// A run of `subject` from its start in plain arrays: f64, f32 and compensated f32 by the same kernels.
fn in_arrays(subject: &Subject, setting: Setting) -> Result<Box<dyn Runner>, Failure> {
    Ok(match setting.precision {
        Precision::F64 => Box::new(ArraysRunner::<f64>::new(subject, setting)?),
        Precision::F32 => Box::new(ArraysRunner::<f32>::new(subject, setting)?),
        Precision::CompensatedF32 => {
            let ArraysRunner { bare, solves } = ArraysRunner::<f32>::new(subject, setting)?;
            Box::new(ArraysRunner { bare: bare.compensated(), solves })
        }
    })
}

/// Bodies of a group in the mean: an iteration of a solver is of one group.
fn mean_group(run: &Simulation) -> u64 {
    run.world.get_resource::<Groups>().map_or(0, |groups| groups.bodies() as u64 / groups.len().max(1) as u64)
}

/// Laws of single bodies of a run of `scene`, in the precision of the arrays.
pub(crate) fn laws_of_bodies<'a, T: Real>(
    scene: &'a Scene,
    run: &Simulation,
) -> impl Fn(Entity) -> Vec<Box<dyn Law<T>>> + use<'a, T> {
    let ids: HashMap<_, u32> = run.bodies.iter().copied().zip(0..).collect();
    move |body| {
        let spec = ids.get(&body).and_then(|id| scene.own_laws.get(id));
        spec.map_or_else(Vec::new, scene::OwnLawsSpec::laws)
    }
}

struct ArraysRunner<T: Real> {
    bare: Bare<T>,
    solves: u64,
}

/// Number types that plain arrays are compiled for.
trait Arithmetic: Real {
    fn arrays(subject: &Subject, setting: Setting, run: &mut Simulation) -> Result<Bare<Self>, NotForArrays>;
    fn tick(bare: &mut Bare<Self>);
}

macro_rules! arithmetic {
    ($($t:ty)*) => {$(
        impl Arithmetic for $t {
            fn arrays(subject: &Subject, setting: Setting, run: &mut Simulation) -> Result<Bare<Self>, NotForArrays> {
                let own = laws_of_bodies::<$t>(&subject.scene, run);
                let law = subject.problem.and_then(|problem| problem.law);
                let shared = law.map(|law| Box::new(law) as Box<dyn Law<Self>>);
                Bare::<Self>::of_world(&mut run.world, setting.method, &own, shared.into_iter().collect())
            }

            fn tick(bare: &mut Bare<Self>) {
                bare.tick();
            }
        }
    )*};
}

arithmetic!(f64 f32);

impl<T: Arithmetic> ArraysRunner<T> {
    fn new(subject: &Subject, setting: Setting) -> Result<Self, Failure> {
        let mut run = subject.run(setting);
        let solves = mean_group(&run);
        let bare = T::arrays(subject, setting, &mut run);
        let bare = bare.map_err(|error| Failure::Unsolvable { why: error.to_string() })?;
        Ok(Self { bare, solves })
    }
}

impl<T: Arithmetic> Runner for ArraysRunner<T> {
    fn tick(&mut self) {
        T::tick(&mut self.bare);
    }

    fn states(&mut self) -> Vec<Sample> {
        self.bare.states().map(|(id, x, v)| (id.0, x, v)).collect()
    }

    fn counts(&mut self) -> Counts {
        let solver = self.bare.newton().0 + self.bare.cg_iterations() * self.solves;
        Counts { accelerations: self.bare.evaluations(), solver }
    }

    fn failure(&mut self) -> Option<Failure> {
        let (_, steps) = self.bare.newton();
        if self.bare.has_failed() {
            Some(Failure::BlewUp)
        } else {
            (steps > 0).then_some(Failure::Unconverged { steps })
        }
    }

    fn bytes_per_body(&self) -> Option<f64> {
        Some(self.bare.bytes_per_body() as f64)
    }
}
