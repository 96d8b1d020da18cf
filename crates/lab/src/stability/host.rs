//! What a row is run in: a world of entities, or plain arrays of single precision.

use std::collections::VecDeque;

use history::{Input, Simulation};
use motion::arrays::Bare;
use motion::clock::StepClock;
use motion::ledger::Ledger;
use motion::units::Vector;
use motion::{Damping, DampingModel, Evaluations, Gravity, Quarantine, Request, StableId, TimeStep};
use scene::{Action, Names, Scene, Step, SurvivalRow, When};

use crate::cost::{Sample, laws_of_bodies};

/// A run on its way.
pub(super) struct Host {
    engine: Engine,
    script: VecDeque<(When, Input)>,
    lengths: scene::Lengths,
    names: Names,
    /// Length of the last tick, s.
    length: f64,
    clock: StepClock,
}

enum Engine {
    World { simulation: Box<Simulation>, ledger: Option<Box<Ledger>> },
    Single(Box<Bare<f32>>),
}

impl Host {
    /// The start of `scene`, which is that of `row`; in single precision where the row says so.
    ///
    /// # Errors
    /// What keeps a world out of plain arrays.
    pub fn new(scene: &Scene, row: &SurvivalRow, with_ledger: bool) -> Result<Self, String> {
        let mut simulation = Simulation::new(scene.clone());
        let engine = if row.single {
            let laws = laws_of_bodies::<f32>(scene, &simulation);
            let bare = Bare::<f32>::of_world(&mut simulation.world, scene.method, &laws, Vec::new());
            Engine::Single(Box::new(bare.map_err(|error| error.to_string())?))
        } else {
            let ledger = with_ledger.then(|| Box::new(Ledger::open(&mut simulation.world)));
            Engine::World { simulation: Box::new(simulation), ledger }
        };
        let script = row.script.iter().filter_map(|step| Some((step.when, input(step, scene)?))).collect();
        Ok(Self {
            engine,
            script,
            lengths: row.lengths(),
            names: scene.names.clone(),
            length: 1.0 / scene.step_hz,
            clock: StepClock::default(),
        })
    }

    /// Ticks so far.
    pub const fn ticks(&self) -> u64 {
        self.clock.ticks()
    }

    /// Simulates one tick of the row's own length with what its script does in it.
    pub fn tick(&mut self) {
        let mut inputs = Vec::new();
        let length = self.lengths.next().unwrap_or(self.length);
        let start = self.clock.seconds();
        while let Some((_, input)) =
            self.script.pop_front_if(|(when, _)| when.has_come(self.clock.ticks(), start, length))
        {
            inputs.push(input);
        }
        let changed = length.to_bits() != self.length.to_bits();
        match &mut self.engine {
            Engine::World { simulation, ledger } => {
                if changed {
                    simulation.world.insert_resource(TimeStep(length));
                }
                simulation.give(inputs);
                match ledger {
                    Some(ledger) => ledger.tick(&mut simulation.stepper, &mut simulation.world),
                    None => simulation.tick(),
                }
            }
            Engine::Single(bare) => {
                if changed {
                    // Rounding is what is looked at.
                    bare.set_step(length as f32);
                }
                inputs.into_iter().for_each(|input| act(bare, input));
                bare.tick();
            }
        }
        self.length = length;
        self.clock.count(length);
    }

    /// Stable id, position and velocity of every body with physics.
    pub fn states(&mut self) -> Vec<Sample> {
        match &mut self.engine {
            Engine::World { simulation, .. } => simulation.states().collect(),
            Engine::Single(bare) => bare.states().map(|(id, x, v)| (id.0, x, v)).collect(),
        }
    }

    /// The books, where they are kept.
    pub fn ledger(&self) -> Option<&Ledger> {
        match &self.engine {
            Engine::World { ledger, .. } => ledger.as_deref(),
            Engine::Single(_) => None,
        }
    }

    /// What turned non-finite, if something did.
    pub fn failure(&self) -> Option<String> {
        match &self.engine {
            Engine::World { simulation, .. } => {
                let record = simulation.world.resource::<Quarantine>().records().first()?;
                let id = record.id.map_or(u32::MAX, |id| id.0);
                Some(format!("{}: {} in tick {}", self.name(id), record.cause.what(), record.tick))
            }
            Engine::Single(bare) => bare.has_failed().then(|| {
                let row = bare.refused().first().copied().unwrap_or_default();
                let id = bare.states().nth(row).map_or(u32::MAX, |(id, ..)| id.0);
                format!(
                    "{}: position or velocity would turn non-finite in tick {}",
                    self.name(id),
                    self.clock.ticks()
                )
            }),
        }
    }

    /// Implicit steps that were taken as the last iteration left them.
    pub fn unconverged(&self) -> u64 {
        match &self.engine {
            Engine::World { simulation, .. } => {
                simulation.world.resource::<Evaluations>().unconverged_steps()
            }
            Engine::Single(bare) => bare.newton().1,
        }
    }

    fn name(&self, id: u32) -> String {
        self.names.get(id).map_or_else(|| "a body".to_owned(), std::borrow::Cow::into_owned)
    }
}

/// A step of a script as what it asks for; `None` for what is no experiment, which no row has.
fn input(step: &Step, scene: &Scene) -> Option<Input> {
    let id = |name: &str| scene.names.find(name);
    Some(Input::Request(match &step.action {
        Action::Push(body, newtons) => return Some(Input::Push(id(body)?, *newtons)),
        Action::Impulse(body, impulse) => Request::Impulse(id(body)?, *impulse),
        Action::SetVelocity(body, velocity) => Request::SetVelocity(id(body)?, *velocity),
        Action::SetPosition(body, position) => Request::SetPosition(id(body)?, *position),
        Action::Remove(body) => Request::Remove(id(body)?),
        Action::SetGravity(acceleration) => Request::SetGravity(*acceleration),
        Action::SetDamping(rate) => {
            let model = scene.damping.map_or(DampingModel::Exact, |damping| damping.model);
            Request::SetDamping(Damping { model, rate: *rate })
        }
        Action::ReverseVelocities => Request::ReverseVelocities,
        Action::SwitchEffect(effect, on) => Request::Switch(*effect, *on),
        _ => return None,
    }))
}

/// Does to arrays what an input does to a world; rows in single precision ask for nothing else.
fn act(bare: &mut Bare<f32>, input: Input) {
    let mut change = |body, to: Vector, change: fn(&mut Bare<f32>, usize, [f32; 3])| {
        if let Some(row) = bare.row_of(StableId(body)) {
            // Rounding is what is looked at.
            change(bare, row, to.to_array().map(|part| part as f32));
        }
    };
    match input {
        Input::Push(body, newtons) => change(body, newtons, Bare::push),
        Input::Request(Request::Impulse(body, impulse)) => change(body, impulse, Bare::give_impulse),
        Input::Request(Request::SetVelocity(body, velocity)) => change(body, velocity, Bare::set_velocity),
        Input::Request(Request::SetGravity(acceleration)) => {
            let on = bare.gravity().is_none_or(|gravity| gravity.on);
            bare.set_gravity(Some(Gravity { acceleration, on }));
        }
        Input::Request(Request::SetDamping(damping)) => bare.set_damping(Some(damping)),
        Input::Request(Request::ReverseVelocities) => bare.reverse_velocities(),
        Input::Request(_) => {}
    }
}
