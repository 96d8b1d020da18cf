//! Yoshida's composition.

use bevy_ecs::prelude::*;

use super::verlet::kick_drift_kick;
use super::{Carry, Field, Integrator, Memory};
use crate::methods::markers::OwnMethod;
use crate::methods::table::Method;
use crate::real::Real;

/// Three steps of velocity Verlet, the middle one backwards, whose errors of third order cancel (Yoshida 1990,
/// eq. 2.11): order 4, keeps a nearby energy. Stages lie outside the step: from 1.35 h to -0.35 h.
///
/// Under laws of the velocity the inner steps are no longer their own reverses, and order 3 is left; the step
/// backwards anti-damps, so that linear drag c is stable only below c h = 0.89.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct Yoshida4;

/// `1 / (2 - 2^(1/3))`.
const OUTER: f64 = 1.351_207_191_959_657_6;
/// `-2^(1/3) / (2 - 2^(1/3))`: the three add up to 1.
const INNER: f64 = 1.0 - 2.0 * OUTER;

impl Integrator for Yoshida4 {
    const METHOD: Method = Method::Yoshida4;
    const MEMORY: Memory = Memory::LastAcceleration;

    #[inline(always)]
    fn step<F: Field>(field: &mut F, x: F::Space, v: F::Space, carry: &mut Carry<F>) -> (F::Space, F::Space) {
        let h = field.step();
        let (outer, inner) = (F::Real::of(OUTER), F::Real::of(INNER));
        let (x, v) = kick_drift_kick(field, F::Real::ZERO, outer * h, x, v, carry);
        let (x, v) = kick_drift_kick(field, outer, inner * h, x, v, carry);
        kick_drift_kick(field, outer + inner, outer * h, x, v, carry)
    }
}
