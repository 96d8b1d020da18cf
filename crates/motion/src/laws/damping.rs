//! Damping: the scene's as a resource, a body's own rate as a component.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::state::switched_off::OffResource;
use crate::units::{Scalar, at_least_0};

/// How velocity decays. Every model takes a rate c in 1/s; q = c h is the decay of one step of h seconds.
///
/// In explicit and semi-implicit Euler the models are part of the step, as their formulas show. In every other method
/// `Exact` is the law `a = -c v`, of the method's own order, `Clamped` and `Implicit` multiply before a tick and
/// `Tutorial` after it.
///
/// Errors under semi-implicit Euler after 2 s at 30, 60, 120 and 240 Hz (measured in `tests/methods/damping.rs`):
///
/// | model | speed, coasting, c = 0.4 /s | position, c = 30 /s, a = 800 m/s² |
/// |---|---|---|
/// | `Tutorial` | -0.54, -0.27, -0.13, -0.07 % | +1.7, +0.85, +0.42, +0.21 % |
/// | `Clamped` | the same | -100, -49.6, -24.7, -12.3 % |
/// | `Implicit` | +0.53, +0.27, +0.13, +0.07 % | 0 |
/// | `Exact` | 0 | that of the method (order 1) |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum DampingModel {
    /// `v *= 1 - q` after the move, unclamped, as in the tutorial. The sign flips above q = 1 and the speed diverges
    /// above q = 2. The body moves at the correct terminal speed a / c and stores (1 - q) times that.
    Tutorial,
    /// `v *= max(0, 1 - q)` after the force and before speed limit, locks and move (PhysX, `DyBodyCoreIntegrator.h`).
    /// The terminal speed is (1 - q) a / c; from q = 1 on no force moves the body.
    Clamped,
    /// `v /= 1 + q` after the force and before speed limit, locks and move: the backward Euler step of `v' = a - c v`, as in
    /// Box2D, MuJoCo, DART and Drake. No step size changes the sign of a velocity, and the terminal speed of
    /// semi-implicit Euler is a / c.
    Implicit,
    /// The exact solution of `v' = a - c v` for constant a: `v = v e^-q + (a / c)(1 - e^-q)`. In the two explicit Eulers
    /// decay and terminal speed are correct at every step size, and the position is of order 1.
    #[default]
    Exact,
}

impl DampingModel {
    /// Every model, in the order of the enum.
    pub const ALL: [Self; 4] = [Self::Tutorial, Self::Clamped, Self::Implicit, Self::Exact];

    /// Name in scene files, flags and panels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tutorial => "tutorial",
            Self::Clamped => "clamped",
            Self::Implicit => "implicit",
            Self::Exact => "exact",
        }
    }

    /// The model of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }
}

#[cfg(feature = "serde")]
crate::names::written_by_name!(DampingModel);

/// Damping of the scene. Present only if the scene or one of its bodies declares damping.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Resource))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Damping {
    /// How velocity decays.
    pub model: DampingModel,
    /// Decay rate c of every body without a [`DampingRate`], 1/s, at least 0.
    pub rate: Scalar,
}

#[cfg(feature = "serde")]
crate::names::written_as_tuple!(Damping { model, rate });

impl Damping {
    /// Reads damping, and refuses a rate below 0.
    #[cfg(feature = "serde")]
    pub(crate) fn read_checked<'de, D: serde::Deserializer<'de>>(
        source: D,
    ) -> Result<Self, D::Error> {
        let damping: Self = serde::Deserialize::deserialize(source)?;
        if damping.rate < 0.0 {
            return Err(serde::de::Error::custom("a damping rate is below 0"));
        }
        Ok(damping)
    }

    /// Damping by that model at that [`rate`](Self::rate), 1/s.
    #[must_use]
    pub const fn new(model: DampingModel, rate: Scalar) -> Self {
        Self { model, rate }
    }

    /// The tutorial's damping: `v *= 1 - 0.4 h` after every move.
    pub const TUTORIAL: Self = Self { model: DampingModel::Tutorial, rate: 0.4 };

    /// # Panics
    /// If its rate is below 0.
    pub(crate) fn check(&self) {
        at_least_0(self.rate, "a damping rate", "1/s");
    }

    /// Whether the model is a law of linear drag, either solved in the step or evaluated.
    pub(crate) fn is_exact(&self) -> bool {
        self.model == DampingModel::Exact
    }

    /// The factors of a step of `h` seconds, for methods in which damping is part of the step.
    pub(crate) fn factors(self, h: f64) -> Decay {
        let q = self.rate * h;
        match self.model {
            DampingModel::Tutorial => Decay { after_move: Some(1.0 - q), ..Decay::none(h) },
            DampingModel::Clamped => {
                let factor = if q > 1.0 { 0.0 } else { 1.0 - q };
                Decay { before_move: Some(factor), ..Decay::none(h) }
            }
            DampingModel::Implicit => {
                Decay { before_move: Some((1.0 + q).recip()), ..Decay::none(h) }
            }
            DampingModel::Exact => {
                // (1 - e^-q) / q by expm1: the plain form loses every digit as q goes to 0.
                let gain = if q == 0.0 { h } else { h * (-libm::expm1(-q) / q) };
                Decay { keep: Some(libm::exp(-q)), gain, ..Decay::none(h) }
            }
        }
    }

    /// The factors around a tick of `tick` seconds, and the rate of linear drag of the exact model, 1/s, for methods in
    /// which damping is not part of the step.
    pub(crate) fn factors_around_tick(self, tick: f64) -> (Decay, f64) {
        match self.model {
            DampingModel::Exact => (Decay::none(tick), self.rate),
            DampingModel::Tutorial | DampingModel::Clamped | DampingModel::Implicit => {
                (self.factors(tick), 0.0)
            }
        }
    }
}

/// A body's own damping rate c, in place of the scene's, 1/s, at least 0. Present only on bodies with their own rate.
///
/// In a world without [`Damping`] the first rate declares it, with the default model and the rate 0 for every other body.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(on_insert = declare_damping)]
pub struct DampingRate(Scalar);

fn declare_damping(mut world: DeferredWorld, _: HookContext) {
    let is_declared =
        world.contains_resource::<Damping>() || world.contains_resource::<OffResource<Damping>>();
    if !is_declared {
        world.commands().insert_resource(Damping { model: DampingModel::default(), rate: 0.0 });
    }
}

impl DampingRate {
    /// Makes a damping rate of `rate`, 1/s, at least 0.
    ///
    /// # Panics
    /// If `rate` is below 0.
    #[must_use]
    pub fn new(rate: Scalar) -> Self {
        at_least_0(rate, "a damping rate", "1/s");
        Self(rate)
    }

    /// Decay rate c, 1/s.
    #[must_use]
    pub const fn rate(&self) -> Scalar {
        self.0
    }
}

/// Magnitude below which a decaying velocity component snaps to zero, m/s. Without it damping would end in subnormal
/// numbers and stay there, and arithmetic on those is many times slower.
pub(crate) const SNAP: f64 = 1e-290;

/// The factors of a step of h seconds, one form for every model: `v = v keep + a gain`, then `v *= before_move`, move,
/// `v *= after_move`. A factor that is `None` is not applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Decay {
    pub keep: Option<f64>,
    pub gain: f64,
    pub before_move: Option<f64>,
    pub after_move: Option<f64>,
}

impl Decay {
    /// No damping over `h` seconds.
    pub const fn none(h: f64) -> Self {
        Self { keep: None, gain: h, before_move: None, after_move: None }
    }

    /// Whether a factor is applied.
    pub fn multiplies(&self) -> bool {
        self.keep.or(self.before_move).or(self.after_move).is_some()
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
            assert!((keep - libm::exp(-q)).abs() <= 2e-16);
            // The fixed point of v = v keep + a gain is the terminal speed a / c.
            assert!((decay.gain * q + keep - 1.0).abs() <= 4e-16, "q = {q}");
        }
        assert_eq!(Damping { model: DampingModel::Exact, rate: 0.0 }.factors(0.25).gain, 0.25);
    }
}
