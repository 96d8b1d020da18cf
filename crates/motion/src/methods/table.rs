//! The table of methods, and what a method can claim: order, evaluations, stability, symplecticity, source.
//!
//! The claims themselves are beside the step of each method, and nowhere else: `sandbox list methods`, the documents, the panel and
//! the tests read this table.

use super::with_method;
use crate::units::Scalar;

/// The claims of a method. Order p means that the error falls as h^p for steps of h seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
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
pub(super) const IN_STEP: &str = "exact is in the velocity's update, clamped and implicit before and tutorial after the position's";
/// Damping of all other methods.
const AS_LAW: &str = "exact is the law a = -c v, evaluated at every stage; clamped and implicit multiply before, tutorial after a tick";

/// Default claims of a method of that order: as many evaluations per step, never stable, not symplectic, not reversible. Each
/// method overrides the claims in which it differs.
pub(super) const fn of_order(method: Method, order: u32) -> Claims {
    Claims {
        method,
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

with_method!(@table);

impl Default for Method {
    /// The method of the tutorial.
    fn default() -> Self {
        Self::SemiImplicitEuler
    }
}

impl Method {
    /// Every method.
    pub const ALL: [Self; METHODS.len()] = {
        let mut all = [Self::ExplicitEuler; METHODS.len()];
        let mut i = 0;
        while i < METHODS.len() {
            assert!(METHODS[i].method as usize == i, "a method claims to be itself");
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
