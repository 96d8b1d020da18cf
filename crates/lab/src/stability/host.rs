//! What a row is run in: a world of entities, whose states may be rounded to single precision.

use std::collections::VecDeque;

use history::{Input, Simulation};
use motion::clock::StepClock;
use motion::ledger::Ledger;
use motion::units::Vector;
use motion::{Damping, DampingModel, Evaluations, PhysicsBody, Quarantine, Request, TimeStep, Transform};
use scene::{Action, Names, Scene, Step, SurvivalRow, When};

use crate::cost::Sample;

/// A run on its way.
pub(super) struct Host {
    simulation: Box<Simulation>,
    ledger: Option<Box<Ledger>>,
    /// Whether positions and velocities are rounded to single precision at the start and after every tick.
    single: bool,
    script: VecDeque<(When, Input)>,
    lengths: scene::Lengths,
    names: Names,
    /// Length of the last tick, s.
    length: f64,
    clock: StepClock,
}

impl Host {
    /// The start of `scene`, which is that of `row`.
    pub fn new(scene: &Scene, row: &SurvivalRow, with_ledger: bool) -> Self {
        let mut simulation = Box::new(Simulation::new(scene.clone()));
        if row.single {
            round(&mut simulation);
        }
        let ledger = with_ledger.then(|| Box::new(Ledger::open(&mut simulation.world)));
        let script = row.script.iter().filter_map(|step| Some((step.when, input(step, scene)?))).collect();
        Self {
            simulation,
            ledger,
            single: row.single,
            script,
            lengths: row.lengths(),
            names: scene.names.clone(),
            length: 1.0 / scene.step_hz,
            clock: StepClock::default(),
        }
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
        let Self { simulation, ledger, .. } = self;
        if length.to_bits() != self.length.to_bits() {
            simulation.world.insert_resource(TimeStep(length));
        }
        simulation.give(inputs);
        match ledger {
            Some(ledger) => ledger.tick(&mut simulation.stepper, &mut simulation.world),
            None => simulation.tick(),
        }
        if self.single {
            round(simulation);
        }
        self.length = length;
        self.clock.count(length);
    }

    /// Stable id, position and velocity of every body with physics.
    pub fn states(&mut self) -> Vec<Sample> {
        self.simulation.states().collect()
    }

    /// The books, where they are kept.
    pub fn ledger(&self) -> Option<&Ledger> {
        self.ledger.as_deref()
    }

    /// What turned non-finite, if something did.
    pub fn failure(&self) -> Option<String> {
        let record = self.simulation.world.resource::<Quarantine>().records().first()?;
        let id = record.id.map_or(u32::MAX, |id| id.0);
        let name = self.names.get(id).map_or_else(|| "a body".to_owned(), std::borrow::Cow::into_owned);
        Some(format!("{name}: {} in tick {}", record.cause.what(), record.tick))
    }

    /// Implicit steps that were taken as the last iteration left them.
    pub fn unconverged(&self) -> u64 {
        self.simulation.world.resource::<Evaluations>().unconverged_steps()
    }
}

/// Rounds every position and velocity to single precision. One beyond its range becomes infinite.
fn round(simulation: &mut Simulation) {
    let single = |vector: Vector| vector.as_vec3().as_dvec3();
    let world = &mut simulation.world;
    for (mut transform, mut body) in world.query::<(&mut Transform, &mut PhysicsBody)>().iter_mut(world) {
        transform.position = single(transform.position);
        body.velocity = single(body.velocity);
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
