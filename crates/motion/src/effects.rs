//! The effects that a scene may declare: gravity and damping, as resources and as per-body components.

use bevy_ecs::prelude::*;

use crate::units::{Scalar, Vector};

/// Uniform gravity: the same acceleration for every movable body, whatever its mass (Galilei). Present only if
/// the scene declares it; switching it off keeps the value.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Gravity {
    /// Acceleration of free fall, m/s².
    pub acceleration: Vector,
    /// Whether it acts in this tick.
    pub on: bool,
}

impl Gravity {
    /// Gravity near the ground as the tutorial has it: 9.8 m/s² downwards.
    pub const EARTH: Self = Self { acceleration: Vector::new(0.0, -9.8, 0.0), on: true };

    /// What acts now: the acceleration, m/s², or `None` while it is off.
    #[must_use]
    pub fn acting(&self) -> Option<Vector> {
        self.on.then_some(self.acceleration)
    }
}

/// How velocity decays. Every model takes a rate c in 1/s; q = c h is the decay of one step of h seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DampingModel {
    /// `v *= 1 - q` after the move, unclamped, as the tutorial teaches it: the sign flips above q = 1 and the
    /// speed diverges above q = 2. The body moves at the right terminal speed a / c and stores (1 - q) of it.
    Tutorial,
    /// `v *= max(0, 1 - q)` after the force and before speed limit, locks and move (PhysX,
    /// `DyBodyCoreIntegrator.h`): terminal speed (1 - q) a / c, and a body deaf to every force from q = 1 on.
    Clamped,
    /// The exact solution of `v' = a - c v` over the step, a constant: `v = v e^-q + (a / c)(1 - e^-q)`. Right
    /// decay and right terminal speed at every step size.
    #[default]
    Exact,
}

impl DampingModel {
    /// Every model, in the order of the documentation.
    pub const ALL: [Self; 3] = [Self::Tutorial, Self::Clamped, Self::Exact];

    /// The word for it in scene files, flags and panels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tutorial => "tutorial",
            Self::Clamped => "clamped",
            Self::Exact => "exact",
        }
    }
}

/// Damping of the whole scene. Present only if the scene, or a body of it, declares damping.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// How velocity decays.
    pub model: DampingModel,
    /// Decay rate c of every body that has no [`DampingRate`] of its own, 1/s, at least 0.
    pub rate: Scalar,
}

impl Damping {
    /// The tutorial's damping: `v *= 1 - 0.4 h` after every move.
    pub const TUTORIAL: Self = Self { model: DampingModel::Tutorial, rate: 0.4 };

    /// What one step of `h` seconds does to velocities.
    pub(crate) fn factors(self, h: Scalar) -> Decay {
        let q = self.rate * h;
        match self.model {
            DampingModel::Tutorial => Decay { after_move: Some(1.0 - q), ..Decay::none(h) },
            DampingModel::Clamped => Decay { before_move: Some((1.0 - q).max(0.0)), ..Decay::none(h) },
            DampingModel::Exact => {
                // (1 - e^-q) / q by expm1: the plain form loses every digit as q goes to 0.
                let gain = if q == 0.0 { h } else { h * (-libm::expm1(-q) / q) };
                Decay { keep: Some(libm::exp(-q)), gain, ..Decay::none(h) }
            }
        }
    }
}

/// The body's own damping rate, in place of the scene's. Present only on bodies that ask for it.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct DampingRate {
    rate: Scalar,
    /// Factors of the last step; an exponential per body and step would cost more than the step.
    known: Option<(DampingModel, Scalar, Decay)>,
}

impl DampingRate {
    /// A body that decays at `rate` c, 1/s, at least 0.
    #[must_use]
    pub const fn new(rate: Scalar) -> Self {
        Self { rate, known: None }
    }

    /// Decay rate c, 1/s.
    #[must_use]
    pub const fn rate(&self) -> Scalar {
        self.rate
    }

    /// Changes the decay rate c, 1/s, at least 0.
    pub const fn set_rate(&mut self, rate: Scalar) {
        *self = Self::new(rate);
    }

    pub(crate) fn factors(&mut self, model: DampingModel, h: Scalar) -> Decay {
        match self.known {
            Some((for_model, for_h, decay)) if for_model == model && for_h == h => decay,
            _ => {
                let decay = Damping { model, rate: self.rate }.factors(h);
                self.known = Some((model, h, decay));
                decay
            }
        }
    }
}

/// What a step of h seconds does to a velocity, with every model in one form: `v = v keep + a gain`, then
/// `v *= before_move`, move, `v *= after_move`; `None` is a factor that is not applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Decay {
    pub keep: Option<Scalar>,
    pub gain: Scalar,
    pub before_move: Option<Scalar>,
    pub after_move: Option<Scalar>,
}

impl Decay {
    /// No damping at all over `h` seconds.
    pub const fn none(h: Scalar) -> Self {
        Self { keep: None, gain: h, before_move: None, after_move: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_factors_solve_the_equation_at_every_step_size() {
        for q in [1e-300, 1e-12, 1e-3, 0.5, 30.0, 800.0] {
            let decay = Damping { model: DampingModel::Exact, rate: q }.factors(1.0);
            let keep = decay.keep.expect("the exact model always decays");
            assert!((keep - (-q).exp()).abs() <= 2e-16);
            // The fixed point of v = v keep + a gain is the terminal speed a / c.
            assert!((decay.gain * q + keep - 1.0).abs() <= 4e-16, "q = {q}");
        }
        assert_eq!(Damping { model: DampingModel::Exact, rate: 0.0 }.factors(0.25).gain, 0.25);
    }

    #[test]
    fn a_bodys_own_factors_follow_the_model_and_the_step() {
        let mut own = DampingRate::new(2.0);
        for (model, h) in
            [(DampingModel::Tutorial, 0.1), (DampingModel::Exact, 0.1), (DampingModel::Exact, 0.2)]
        {
            for _ in 0..2 {
                assert_eq!(own.factors(model, h), Damping { model, rate: 2.0 }.factors(h));
            }
        }
        own.set_rate(3.0);
        let expected = Damping { model: DampingModel::Exact, rate: 3.0 }.factors(0.2);
        assert_eq!(own.factors(DampingModel::Exact, 0.2), expected);
    }
}
