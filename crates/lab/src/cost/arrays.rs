//! Runs in plain arrays: f64, f32 and compensated f32 by the same kernels.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use history::Simulation;
use motion::Law;
use motion::arrays::{Bare, NotForArrays};
use motion::groups::Groups;
use motion::real::Real;
use scene::Scene;

use super::record::{Counts, Failure, Precision, Setting};
use super::runner::{Runner, Sample};
use super::subject::Subject;

/// A run of `subject` from its start.
pub(super) fn make(subject: &Subject, setting: Setting) -> Result<Box<dyn Runner>, Failure> {
    let refused = |error: NotForArrays| Failure::Unsolvable { why: error.to_string() };
    let mut run = subject.run(setting);
    let solves = mean_group(&run);
    Ok(match setting.precision {
        Precision::F64 => {
            let bare = f64::arrays(subject, setting, &mut run).map_err(refused)?;
            Box::new(ArraysRunner { bare, solves })
        }
        Precision::F32 => {
            let bare = f32::arrays(subject, setting, &mut run).map_err(refused)?;
            Box::new(ArraysRunner { bare, solves })
        }
        Precision::CompensatedF32 => {
            let bare = f32::arrays(subject, setting, &mut run).map_err(refused)?.compensated();
            Box::new(ArraysRunner { bare, solves })
        }
    })
}

/// Bodies of a group in the mean: an iteration of a solver is of one group.
pub(super) fn mean_group(run: &Simulation) -> u64 {
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
                let shared = subject.law.map(|extra| extra.law::<Self>());
                Bare::<Self>::of_world(&mut run.world, setting.method, &own, shared.into_iter().collect())
            }

            fn tick(bare: &mut Bare<Self>) {
                bare.tick();
            }
        }
    )*};
}

arithmetic!(f64 f32);

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

    #[expect(clippy::cast_precision_loss, reason = "some hundred bytes")]
    fn bytes_per_body(&self) -> Option<f64> {
        Some(self.bare.bytes_per_body() as f64)
    }
}
