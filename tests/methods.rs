//! The methods of integration against theory.
//!
//! What a method promises is written as checks, functions of a [`Stepper`]. The methods of the table pass them
//! all; each broken method in [`mutants`] is rejected by one of them, which is how the checks are checked.

mod conserved;
mod costs;
mod damping;
mod events;
pub(crate) mod fingerprint;
mod laws;
mod mutants;

pub(crate) mod oracle;
pub(crate) mod orders;
pub mod problems;
mod pushes;
mod symmetry;
mod verlet;
mod worlds;

use glam::DVec3;
use motion::methods::Integrator;
use motion::{Claims, Method};

use crate::rigs::Bare;

/// A unit vector along no axis, exact in decimals.
const SKEW: DVec3 = DVec3::new(0.48, 0.6, 0.64);

/// A method of the table, or a broken one that takes its place.
#[derive(Clone, Copy)]
pub struct Stepper {
    name: &'static str,
    /// Whose promises it is held to.
    method: Method,
    tick: fn(&mut Bare),
}

impl Stepper {
    const fn real(method: Method) -> Self {
        Self { name: method.name(), method, tick: Bare::tick }
    }

    const fn of<M: Integrator>(name: &'static str) -> Self {
        Self { name, method: M::METHOD, tick: Bare::tick_with::<M> }
    }

    fn all() -> impl Iterator<Item = Self> {
        Method::ALL.into_iter().map(Self::real)
    }

    fn claims(&self) -> &'static Claims {
        self.method.claims()
    }

    fn bare(&self, step: f64) -> Bare {
        Bare::new(self.method, step)
    }

    fn run(&self, bare: &mut Bare, ticks: u32) {
        for _ in 0..ticks {
            (self.tick)(bare);
        }
    }
}

type Check = Result<(), String>;

/// Fails on NaN as well.
fn within(what: impl FnOnce() -> String, error: f64, bound: f64) -> Check {
    if error <= bound { Ok(()) } else { Err(format!("{}: {error:e}, at most {bound:e}", what())) }
}

/// Fails on NaN as well.
fn beyond(what: impl FnOnce() -> String, error: f64, bound: f64) -> Check {
    if error >= bound { Ok(()) } else { Err(format!("{}: {error:e}, at least {bound:e}", what())) }
}

/// Every method of the table passes.
fn all_pass(check: fn(&Stepper) -> Check) {
    let failures: Vec<String> = Stepper::all()
        .filter_map(|stepper| {
            check(&stepper).err().map(|why| stepper.name.to_owned() + ": " + &why)
        })
        .collect();
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

fn position(bare: &Bare, body: usize) -> DVec3 {
    DVec3::from_array(bare.positions[body])
}

fn velocity(bare: &Bare, body: usize) -> DVec3 {
    let [x, y, z, _] = bare.bodies[body];
    DVec3::new(x, y, z)
}
