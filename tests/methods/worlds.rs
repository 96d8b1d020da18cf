//! What is proven of [`Bare`] holds for worlds: the same bits, and what only a world has.

mod agreement;
mod counts;
mod engines;
mod frozen;
mod kept;
mod limits;
mod mixed;
mod newcomers;
mod requests;
mod switches;
mod threads;

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::arrays::Bare;
use motion::{
    Curve, Damping, Drag, Gravity, Method, OwnLaws, PhysicsBody, Request, Requests, Substeps, Thrust,
    TimeStep, Transform, Well, Wells,
};

use super::numbers;
use crate::dice::Dice;
use crate::harness::{Bits, Lab, bits};

const H: f64 = 1.0 / 60.0;

/// A body at the start of a run.
#[derive(Clone, Copy)]
struct Start {
    x: DVec3,
    v: DVec3,
    w: f64,
}

impl Start {
    fn components(self) -> (Transform, PhysicsBody) {
        (Transform::at(self.x), PhysicsBody { velocity: self.v, inverse_mass: self.w })
    }
}

/// The one of [`starts`] that is immovable.
const IMMOVABLE: usize = 5;

/// Eleven bodies, so that blocks of four leave a rest.
fn starts() -> Vec<Start> {
    let mut dice = Dice(7);
    let start = |i: usize| {
        let (x, v) = (dice.vector() * 3.0 + DVec3::X * 2.0, dice.vector() * 2.0);
        if i == IMMOVABLE {
            Start { x, v: DVec3::ZERO, w: 0.0 }
        } else {
            Start { x, v, w: 1.0 / (1.0 + i as f64) }
        }
    };
    (0..11).map(start).collect()
}

/// Two wells, softened, so that no orbit is hard to integrate.
fn wells() -> Wells {
    let well = |position, strength| Well { position, strength, softening: 0.5 };
    Wells(vec![well(DVec3::ZERO, 3.0), well(DVec3::new(1.0, -2.0, 0.5), -1.0)])
}

/// An engine that comes on inside the third tick and goes off inside the fourth second.
fn engine() -> Thrust {
    let curve = Curve::Polynomial(vec![DVec3::new(4.0, -2.0, 1.0), DVec3::new(-1.0, 3.0, 0.5)]);
    Thrust::new(curve, 2.3 * H, 3.0 + 0.4 * H)
}

fn engines() -> OwnLaws {
    OwnLaws::new(vec![Box::new(engine())])
}

/// What acts on all bodies.
#[derive(Clone, Debug, Default)]
struct Scene {
    gravity: Option<Gravity>,
    drag: Option<Drag>,
    wells: Option<Wells>,
    damping: Option<Damping>,
    substeps: Option<u32>,
}

impl Scene {
    fn falling() -> Self {
        Self { gravity: Some(Gravity::EARTH), ..Self::default() }
    }

    fn orbiting() -> Self {
        Self { wells: Some(wells()), ..Self::default() }
    }

    /// A world without bodies yet.
    fn lab(&self, method: Method, step: f64) -> Lab {
        let mut lab = Lab::new(method, step);
        let Self { gravity, drag, wells, damping, substeps } = self.clone();
        if let Some(gravity) = gravity {
            lab.world.insert_resource(gravity);
        }
        if let Some(drag) = drag {
            lab.world.insert_resource(drag);
        }
        if let Some(wells) = wells {
            lab.world.insert_resource(wells);
        }
        if let Some(damping) = damping {
            lab.world.insert_resource(damping);
        }
        if let Some(substeps) = substeps {
            lab.world.insert_resource(Substeps(substeps));
        }
        lab.stepper.recompile(&mut lab.world);
        lab
    }

    /// The same without entities.
    fn bare(&self, method: Method, step: f64) -> Bare<f64> {
        let mut bare = Bare::new(method, step).with_substeps(self.substeps.unwrap_or(1));
        if let Some(gravity) = self.gravity {
            bare = bare.with_law(gravity);
        }
        if let Some(drag) = self.drag {
            bare = bare.with_law(drag);
        }
        if let Some(wells) = self.wells.clone() {
            bare = bare.with_law(wells);
        }
        match self.damping {
            Some(damping) => bare.with_damping(damping),
            None => bare,
        }
    }
}

impl Lab {
    fn spawn(&mut self, start: Start) -> Entity {
        self.world.spawn(start.components()).id()
    }

    fn all_bits(&self, bodies: &[Entity]) -> Vec<Bits> {
        bodies.iter().map(|body| self.bits(*body)).collect()
    }

    fn ask(&mut self, request: Request) {
        self.world.resource_mut::<Requests>().ask(request);
    }

    /// Asks and has it carried out, without a tick.
    fn have(&mut self, request: Request) {
        self.ask(request);
        self.stepper.carry_out_requests(&mut self.world);
    }

    fn set_step(&mut self, step: f64) {
        self.world.insert_resource(TimeStep(step));
    }
}

fn add(bare: &mut Bare<f64>, start: Start) -> usize {
    bare.add(numbers(start.x), numbers(start.v), start.w)
}

fn bare_bits(bare: &Bare<f64>, body: usize) -> Bits {
    bits(super::position(bare, body), super::velocity(bare, body))
}

/// Pushes at some ticks of a run: tick, body, N.
fn pushes(seed: u64, ticks: usize, bodies: usize) -> Vec<(usize, usize, DVec3)> {
    let mut dice = Dice(seed);
    let mut pushes: Vec<_> =
        (0..ticks / 3).map(|_| (dice.below(ticks), dice.below(bodies), dice.vector() * 30.0)).collect();
    pushes.sort_by_key(|(tick, ..)| *tick);
    pushes
}
