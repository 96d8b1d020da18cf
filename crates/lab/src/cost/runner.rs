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
        Host::Arithmetic => {
            let why = || Failure::Unsolvable { why: "no loop was written for it".to_owned() };
            subject.in_loop().map(|make| make(subject, setting)).ok_or_else(why)
        }
    }
}

impl Subject {
    /// Its start, in a world.
    pub(crate) fn run(&self, setting: Setting) -> Simulation {
        let mut run = Simulation::new(self.scene_with(setting));
        let laws = self.laws();
        if !laws.is_empty() {
            run.world.insert_resource(Laws(laws));
            run.stepper.recompile(&mut run.world);
        }
        run
    }

    /// The laws that no scene file can declare.
    fn laws<T: Real>(&self) -> Vec<Box<dyn Law<T>>> {
        let law = self.problem.and_then(|problem| problem.law);
        law.map(|law| Box::new(law) as Box<dyn Law<T>>).into_iter().collect()
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
    let Setting { method, precision, .. } = setting;
    let refused = |error: NotForArrays| Failure::Unsolvable { why: error.to_string() };
    let mut run = subject.run(setting);
    let solves = mean_group(&run);
    if precision == Precision::F64 {
        let own = laws_of_bodies(&subject.scene, &run);
        let bare = Bare::<f64>::of_world(&mut run.world, method, &own, subject.laws()).map_err(refused)?;
        return Ok(Box::new(ArraysRunner { bare, tick: Bare::<f64>::tick, solves }));
    }
    let own = laws_of_bodies(&subject.scene, &run);
    let bare = Bare::<f32>::of_world(&mut run.world, method, &own, subject.laws()).map_err(refused)?;
    let bare = if precision == Precision::CompensatedF32 { bare.compensated() } else { bare };
    Ok(Box::new(ArraysRunner { bare, tick: Bare::<f32>::tick, solves }))
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
    /// [`Bare`] has one for each number type that it is compiled for.
    tick: fn(&mut Bare<T>),
    solves: u64,
}

impl<T: Real> Runner for ArraysRunner<T> {
    fn tick(&mut self) {
        (self.tick)(&mut self.bare);
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
