//! Things that run a subject: its world of entities, or plain arrays.
//!
//! Tests put runs of their own behind the same trait: a slow one and a broken one.

use std::borrow::Cow;

use glam::DVec3;
use history::Simulation;
use motion::{Evaluations, Laws, Quarantine};
use scene::Names;

use super::record::{Counts, Failure, Host, Setting};
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
        Host::World => {
            let names = subject.scene.names.clone();
            Ok(Box::new(WorldRunner { run: subject.run(setting), names }))
        }
        Host::Arrays => super::arrays::make(subject, setting),
    }
}

impl Subject {
    /// Its start, in a world.
    pub(crate) fn run(&self, setting: Setting) -> Simulation {
        let mut run = started(self.scene_with(setting), &self.without);
        if let Some(extra) = self.law {
            run.world.insert_resource(Laws(vec![extra.law()]));
            run.stepper.recompile(&mut run.world);
        }
        run
    }
}

struct WorldRunner {
    run: Simulation,
    names: Names,
}

impl Runner for WorldRunner {
    fn tick(&mut self) {
        self.run.tick();
    }

    fn states(&mut self) -> Vec<Sample> {
        self.run.states().collect()
    }

    fn counts(&mut self) -> Counts {
        let evaluations = self.run.world.resource::<Evaluations>();
        let (accelerations, newton, cg) =
            (evaluations.accelerations(), evaluations.newton_iterations(), evaluations.cg_iterations());
        Counts { accelerations, solver: newton + cg * super::arrays::mean_group(&self.run) }
    }

    fn failure(&mut self) -> Option<Failure> {
        let world = &self.run.world;
        if let Some(record) = world.resource::<Quarantine>().records().first() {
            let id = world.get::<motion::StableId>(record.body).map_or(u32::MAX, |id| id.0);
            let body = self.names.get(id).map_or_else(|| "a body".to_owned(), Cow::into_owned);
            return Some(Failure::Quarantined { body, tick: record.tick });
        }
        let steps = world.resource::<Evaluations>().unconverged_steps();
        (steps > 0).then_some(Failure::Unconverged { steps })
    }
}
