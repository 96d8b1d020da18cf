//! The ledger of energy and momentum, against what theory says that each method invents.

mod angular;
mod damping;
mod fall;
mod interventions;
mod laws;
mod liars;
mod momentum;
mod oscillator;
mod pushes;
mod runs;

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::ledger::Ledger;
use motion::{Method, PhysicsBody, Request, Transform, totals};
use scene::Scene;

use crate::rigs::scene_of;

/// A scene whose books are kept.
pub struct Kept {
    pub simulation: Simulation,
    pub ledger: Ledger,
}

impl Kept {
    /// The scene with those sections, `hz` ticks a second, each of `substeps` parts.
    pub fn of(sections: &str, method: Method, hz: f64, substeps: u32) -> Self {
        let scene = scene_of(&format!("(version: 1, {sections})"));
        Self::of_scene(Scene { method, step_hz: hz, substeps: substeps.into(), ..scene })
    }

    pub fn of_scene(scene: Scene) -> Self {
        let simulation = Simulation::new(scene);
        let ledger = Ledger::open(&simulation.world);
        Self { simulation, ledger }
    }

    pub fn tick(&mut self) -> &mut Self {
        self.simulation.tick_with(&mut self.ledger);
        self
    }

    pub fn run(&mut self, ticks: u32) -> &mut Self {
        for _ in 0..ticks {
            self.tick();
        }
        self
    }

    pub fn body(&self, name: &str) -> Entity {
        self.simulation.named(name).unwrap()
    }

    pub fn x(&self, name: &str) -> DVec3 {
        self.simulation.world.get::<Transform>(self.body(name)).unwrap().position
    }

    pub fn v(&self, name: &str) -> DVec3 {
        self.simulation.world.get::<PhysicsBody>(self.body(name)).unwrap().velocity
    }

    pub fn push(&mut self, name: &str, newtons: DVec3) -> &mut Self {
        let body = self.body(name);
        self.simulation.push(body, newtons);
        self
    }

    pub fn ask(&mut self, request: Request) -> &mut Self {
        self.simulation.request(request);
        self
    }

    /// The residual of the energy since the opening, J.
    pub fn residual(&self) -> f64 {
        self.ledger.since_opening().energy.residual
    }

    /// Fails unless the books agree with the world: energies and momentum are those of the totals, and all lines
    /// together are what they changed by.
    #[track_caller]
    pub fn check(&mut self) -> &mut Self {
        let now = totals(&self.simulation.world);
        let ledger = &self.ledger;
        let books = ledger.since_opening();
        let energy = now.kinetic_energy + now.potential_energy;
        let sum: f64 = ledger.energies().potential.iter().map(|(_, energy)| energy.abs()).sum();
        let scale =
            1e-12 * (sum + ledger.energies().kinetic + ledger.energies_at_opening().total().abs());
        assert!((ledger.energies().total() - energy).abs() <= scale, "{ledger:?} {now:?}");
        let change = energy - ledger.energies_at_opening().total();
        let size = books.energy.laws.iter().map(|(_, work)| work.abs()).sum::<f64>()
            + books.energy.pushes.abs();
        let scale =
            scale + 1e-12 * (size + books.energy.interventions.abs() + books.energy.damping.abs());
        assert!((books.energy.change() - change).abs() <= scale, "{change}, {:?}", books.energy);
        let change = now.momentum - ledger.momentum_at_opening();
        let sizes = books.momentum.laws.iter().map(|(_, impulse)| impulse.length()).sum::<f64>();
        let scale =
            1e-12 * (sizes + now.momentum.length() + books.momentum.interventions.length() + 1.0);
        assert!(
            books.momentum.change().distance(change) <= scale,
            "{change}, {:?}",
            books.momentum
        );
        let angular = &books.angular_momentum;
        let change = now.angular_momentum - ledger.angular_momentum_at_opening();
        let sizes = angular.laws.iter().map(|(_, impulse)| impulse.length()).sum::<f64>();
        let scale =
            1e-12 * (sizes + now.angular_momentum.length() + angular.interventions.length() + 1.0);
        assert!(angular.change().distance(change) <= scale, "{change}, {angular:?}");
        self
    }
}

/// The methods, those that solve a constant acceleration exactly, and by how much the others are off: invented
/// energy a step in `m a² h² / 2`.
pub const FALLING: [(Method, f64); 9] = [
    (Method::ExplicitEuler, 1.0),
    (Method::SemiImplicitEuler, -1.0),
    (Method::ImplicitEuler, -1.0),
    (Method::PositionVerlet, -1.0),
    (Method::VelocityVerlet, 0.0),
    (Method::RungeKutta2Midpoint, 0.0),
    (Method::RungeKutta2Heun, 0.0),
    (Method::RungeKutta4, 0.0),
    (Method::Yoshida4, 0.0),
];
