//! The table of methods and what each claims: order, evaluations, stability, symplecticity, source.
//!
//! These claims are written nowhere else: `sandbox list methods`, the documents, the panel and the tests read this table.

use super::with_method;
use crate::units::Scalar;

/// A method of integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    /// Explicit Euler: [`ExplicitEuler`](crate::methods::ExplicitEuler).
    ExplicitEuler,
    /// Semi-implicit Euler: [`SemiImplicitEuler`](crate::methods::SemiImplicitEuler).
    #[default]
    SemiImplicitEuler,
    /// Implicit Euler: [`ImplicitEuler`](crate::methods::ImplicitEuler).
    ImplicitEuler,
    /// Position Verlet: [`PositionVerlet`](crate::methods::PositionVerlet).
    PositionVerlet,
    /// Velocity Verlet: [`VelocityVerlet`](crate::methods::VelocityVerlet).
    VelocityVerlet,
    /// Runge-Kutta 2, midpoint: [`RungeKutta2Midpoint`](crate::methods::RungeKutta2Midpoint).
    RungeKutta2Midpoint,
    /// Runge-Kutta 2, Heun: [`RungeKutta2Heun`](crate::methods::RungeKutta2Heun).
    RungeKutta2Heun,
    /// Runge-Kutta 4: [`RungeKutta4`](crate::methods::RungeKutta4).
    RungeKutta4,
    /// Yoshida 4: [`Yoshida4`](crate::methods::Yoshida4).
    Yoshida4,
}

/// The claims of a method. Order p means that the error falls as h^p for steps of h seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claims {
    /// The method.
    pub method: Method,
    /// Name in scene files, flags, panels and columns.
    pub name: &'static str,
    /// Name in prose and titles.
    pub title: &'static str,
    /// Order of the position under laws of position and time.
    pub position_order: u32,
    /// Order of the velocity under laws of position and time.
    pub velocity_order: u32,
    /// Order of the position, and at best of the velocity, under laws that depend on the velocity.
    pub order_with_velocity_laws: u32,
    /// Evaluations of the acceleration per step, without the iterations of a solver.
    pub evaluations: u32,
    /// Evaluations per step under laws that depend on the velocity.
    pub evaluations_with_velocity_laws: u32,
    /// Additional evaluations in the first step.
    pub start_up_evaluations: u32,
    /// Largest stable w h of `x'' = -w² x`: 0 if never stable, infinite if always.
    pub stability_limit: Scalar,
    /// Whether the method preserves areas in phase space, and with them an energy near the true one for exponentially
    /// long times.
    pub symplectic: bool,
    /// Whether a step with reversed velocities returns to the start, under laws of position.
    pub reversible: bool,
    /// How the damping models are applied.
    pub damping: &'static str,
    /// Authors and years.
    pub source: &'static str,
}

/// Damping within a step of the two explicit Eulers.
const IN_STEP: &str = "exact is in the velocity's update, clamped and implicit before and tutorial after the position's";
/// Damping of all other methods.
const AS_LAW: &str = "exact is the law a = -c v, evaluated at every stage; clamped and implicit multiply before, tutorial after a tick";

/// Default claims of a method of that order: as many evaluations per step, never stable, not symplectic, not reversible. Each
/// row overrides the claims in which its method differs.
const fn of_order(order: u32) -> Claims {
    Claims {
        method: Method::ExplicitEuler,
        name: "",
        title: "",
        position_order: order,
        velocity_order: order,
        order_with_velocity_laws: order,
        evaluations: order,
        evaluations_with_velocity_laws: order,
        start_up_evaluations: 0,
        stability_limit: 0.0,
        symplectic: false,
        reversible: false,
        damping: AS_LAW,
        source: "",
    }
}

/// One row per method, in the order of [`Method`].
pub const METHODS: [Claims; with_method!(@count)] = [
    Claims {
        method: Method::ExplicitEuler,
        name: "explicit_euler",
        title: "explicit Euler",
        damping: IN_STEP,
        source: "Euler 1768",
        ..of_order(1)
    },
    Claims {
        method: Method::SemiImplicitEuler,
        name: "semi_implicit_euler",
        title: "semi-implicit Euler",
        stability_limit: 2.0,
        symplectic: true,
        damping: IN_STEP,
        source: "de Vogelaere 1956; Hairer, Lubich, Wanner 2003",
        ..of_order(1)
    },
    Claims {
        method: Method::ImplicitEuler,
        name: "implicit_euler",
        title: "implicit Euler",
        stability_limit: Scalar::INFINITY,
        source: "Curtiss, Hirschfelder 1952",
        ..of_order(1)
    },
    Claims {
        method: Method::PositionVerlet,
        name: "position_verlet",
        title: "position Verlet",
        position_order: 2,
        stability_limit: 2.0,
        symplectic: true,
        reversible: true,
        source: "Stormer 1907; Verlet 1967",
        ..of_order(1)
    },
    Claims {
        method: Method::VelocityVerlet,
        name: "velocity_verlet",
        title: "velocity Verlet",
        evaluations: 1,
        start_up_evaluations: 1,
        stability_limit: 2.0,
        symplectic: true,
        reversible: true,
        source: "Swope et al. 1982; predicted velocity: Groot, Warren 1997, lambda = 1",
        ..of_order(2)
    },
    Claims {
        method: Method::RungeKutta2Midpoint,
        name: "runge_kutta_2_midpoint",
        title: "Runge-Kutta 2, midpoint",
        source: "Runge 1895",
        ..of_order(2)
    },
    Claims {
        method: Method::RungeKutta2Heun,
        name: "runge_kutta_2_heun",
        title: "Runge-Kutta 2, Heun",
        source: "Heun 1900",
        ..of_order(2)
    },
    Claims {
        method: Method::RungeKutta4,
        name: "runge_kutta_4",
        title: "Runge-Kutta 4",
        stability_limit: 2.0 * std::f64::consts::SQRT_2,
        source: "Kutta 1901",
        ..of_order(4)
    },
    Claims {
        method: Method::Yoshida4,
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
        ..of_order(4)
    },
];

impl Method {
    /// Every method.
    pub const ALL: [Self; METHODS.len()] = {
        let mut all = [Self::ExplicitEuler; METHODS.len()];
        let mut i = 0;
        while i < METHODS.len() {
            assert!(METHODS[i].method as usize == i, "the claims are in the order of the enum");
            all[i] = METHODS[i].method;
            i += 1;
        }
        all
    };

    /// The claims of the method.
    #[must_use]
    pub const fn claims(self) -> &'static Claims {
        &METHODS[self as usize]
    }

    /// Name in scene files, flags and panels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.claims().name
    }

    /// The method with that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }

    /// The next method in the table; after the last comes the first.
    #[must_use]
    pub const fn next(self) -> Self {
        Self::ALL[(self as usize + 1) % METHODS.len()]
    }

    /// The previous method in the table; before the first comes the last.
    #[must_use]
    pub const fn previous(self) -> Self {
        Self::ALL[(self as usize + METHODS.len() - 1) % METHODS.len()]
    }
}

#[cfg(feature = "serde")]
crate::names::written_by_name!(Method);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_its_row() {
        for method in Method::ALL {
            assert_eq!(method.claims().method, method);
            assert_eq!(Method::from_name(method.name()), Some(method));
            assert_eq!(method.next().previous(), method);
        }
        assert_eq!(Method::from_name("euler"), None);
    }
}
