//! Yoshida 4: three steps of velocity Verlet.

use bevy_ecs::prelude::*;

use super::verlet::kick_drift_kick;
use super::{Field, Integrator, MethodStateKind, StepState};
use crate::methods::markers::OwnMethod;
use crate::methods::table::{Claims, Method, of_order};

/// Yoshida 4 (Yoshida 1990, eq. 2.11): three steps of velocity Verlet, the middle one backward, whose errors of third
/// order cancel. Order 4; conserves an energy near the true one. Stages lie outside the step, at up to 1.35 h and -0.35
/// h.
///
/// Under laws that depend on the velocity the inner steps are not reversible and order 3 remains. The backward step
/// amplifies what drag damps, so that linear drag c is stable only below c h = 0.89.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct Yoshida4;

/// `1 / (2 - 2^(1/3))`.
const OUTER: f64 = 1.351_207_191_959_657_6;
/// `-2^(1/3) / (2 - 2^(1/3))`: the three fractions sum to 1.
const INNER: f64 = 1.0 - 2.0 * OUTER;

impl Yoshida4 {
    /// The claims of the method.
    pub(super) const CLAIMS: Claims = Claims {
        name: "yoshida_4",
        title: "Yoshida 4",
        order_with_velocity_laws: 3,
        evaluations: 3,
        evaluations_with_velocity_laws: 6,
        start_up_evaluations: 1,
        stability_limit: 1.573_401_947_435_3,
        symplectic: true,
        reversible: true,
        source: "Yoshida 1990",
        ..of_order(Method::Yoshida4, 4)
    };
}

impl Integrator for Yoshida4 {
    const METHOD: Method = Method::Yoshida4;
    const STATE: MethodStateKind = MethodStateKind::LastAcceleration;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        step_state: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let h = field.step();
        let (x, v) = kick_drift_kick(field, 0.0, OUTER * h, x, v, step_state);
        let (x, v) = kick_drift_kick(field, OUTER, INNER * h, x, v, step_state);
        kick_drift_kick(field, OUTER + INNER, OUTER * h, x, v, step_state)
    }
}
