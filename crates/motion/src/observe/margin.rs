//! The forecast of instability: which springs, dampers, drag and wells are too stiff for the step, before it is taken.

mod cure;
mod flight;
mod groups;
mod joined;
mod judged;
mod lanczos;
mod many;
mod matrix;
mod modes;
mod natural;
mod orbit;
mod single_bodies;

use bevy_ecs::prelude::*;
use modes::Stepping;
pub use natural::{NaturalMode, NaturalModes, natural_modes};
pub use orbit::LASTING_TURNS;
pub(crate) use single_bodies::restoring_rate;

use crate::groups::{Group, Groups, compile_groups};
use crate::laws::damping::Damping;
use crate::laws::own::OwnLaws;
use crate::laws::{MutualGravity, SharedLaws};
use crate::methods::markers::own_method;
use crate::methods::table::Method;
use crate::state::archetypes::may_exist;
use crate::state::clock::TimeStep;
use crate::state::substeps::Substeps;
use crate::units::Scalar;

/// The part of a world that limits a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitingPart {
    /// A spring between two bodies.
    Spring([Entity; 2]),
    /// The damping of a spring between two bodies.
    Damper([Entity; 2]),
    /// Drag on a body, or on a triangle of a sheet, by one of its corners.
    Drag(Entity),
    /// The scene's damping of a body.
    Damping(Entity),
    /// A well, by its number, at the position of a body.
    Well(usize, Entity),
    /// Another law, by its name, on a body.
    Law(&'static str, Entity),
    /// The mutual gravity of two bodies.
    MutualGravity([Entity; 2]),
}

/// The state in which a margin has its value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Occasion {
    /// The present state.
    #[default]
    Now,
    /// The closest approach to come, by energy and angular momentum.
    ClosestApproach,
    /// The largest value that the true motion meets.
    Met,
    /// The terminal speed of a fall.
    TerminalSpeed,
    /// The fastest gust.
    Gust,
    /// The birth of a particle.
    Birth,
}

/// How a method deviates from the true motion without growing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deviation {
    /// The velocity changes its sign.
    Reverses,
    /// The velocity settles on this multiple of the true one.
    Settles(Scalar),
    /// The velocity never settles: its least and largest multiple of the true one.
    Alternates([Scalar; 2]),
}

/// The fate of a motion under the method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Fate {
    /// It stays near the true motion.
    #[default]
    Holds,
    /// It does not grow, but is wrong.
    Wrong(Deviation),
    /// An orbit leaves the range from half to twice its size after this many turns, up to [`LASTING_TURNS`].
    Drifts(Scalar),
    /// It grows in every step.
    Grows,
}

/// The changes that would make an unstable part stable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cure {
    /// Smallest stable number of substeps of the same method, if there is one up to [`Substeps::MOST`].
    pub substeps: Option<u32>,
    /// A method that is stable at the same step: the first of the table whose order is not lower, or else implicit
    /// Euler.
    pub method: Option<Method>,
}

/// The margin of stability of bodies that are integrated together, or alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// The part that limits the step most.
    pub part: LimitingPart,
    /// Number of bodies.
    pub bodies: usize,
    /// Method of the bodies.
    pub method: Method,
    /// Substeps per tick.
    pub substeps: u32,
    /// w h of springs and attraction, or c h of damping, of the fastest mode for a step of h seconds. For springs, in the
    /// present state, this is a lower bound: a mode that is predicted to grow does grow.
    pub value: Scalar,
    /// The value in the present state, which differs from `value` if that belongs to another state.
    pub now: Scalar,
    /// The state that has `value`.
    pub occasion: Occasion,
    /// Upper bound of the value. It is within 1 % of the value, except for groups of more than some 30,000 bodies
    /// without a regular structure. If the limit is in between, the search continues until it is not, or until the bound
    /// is within 0.1 %; for groups of more than a million bodies it may end earlier.
    pub at_most: Scalar,
    /// The value above which the mode grows: the next such limit above the current value if that is stable. 0 if no
    /// step is stable, or if the limit is below 5e-3, or below 0.05 for several modes under a method that is not of order 1;
    /// infinite if every step is stable. Yoshida 4 with damping is stable again at some longer steps.
    pub limit: Scalar,
    /// The value of a circular orbit above which the method does not keep it within half and twice its radius for
    /// [`LASTING_TURNS`]; 0 if the method keeps none. `None` if the motion is not an orbit.
    pub lasts: Option<Scalar>,
    /// The fate of the motion.
    pub fate: Fate,
    /// Factor of growth per second, after many seconds; 1 if it does not grow. For an orbit, a factor of 2 in the turns after
    /// which the method leaves it; infinite if the growth accelerates.
    pub growth_per_s: Scalar,
    /// Factor of growth per tick.
    pub growth_per_tick: Scalar,
    /// The changes that would make it stable, even if the value is its upper bound. Empty if it is known to be stable.
    pub cure: Cure,
}

impl Margin {
    /// Whether the value is known within 1 %.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.at_most <= 1.01 * self.value || self.at_most == self.value
    }

    /// Whether the motion grows, or drifts out of its orbit.
    #[must_use]
    pub const fn is_unstable(&self) -> bool {
        matches!(self.fate, Fate::Grows | Fate::Drifts(_))
    }

    /// Whether it is unknown if the mode grows: the limit is between the value and its upper bound.
    #[must_use]
    pub fn may_be_unstable(&self) -> bool {
        !self.is_unstable() && (self.value..self.at_most).contains(&self.limit)
    }

    /// Value over the limit that is reached first.
    #[must_use]
    pub fn ratio(&self) -> Scalar {
        let limit = self.lasts.unwrap_or(Scalar::INFINITY).min(self.limit);
        if limit == 0.0 { Scalar::INFINITY } else { self.value / limit }
    }

    /// Whether the instability shows within [`LASTING_TURNS`]: the motion at least doubles or leaves its orbit. Runge-Kutta 2 is
    /// never quite stable.
    #[must_use]
    pub fn is_reported(&self) -> bool {
        match self.fate {
            // The method leaves an orbit within these turns, which may take far longer than those at its closest approach.
            Fate::Grows => self.lasts.is_some() || self.growth_in_turns() >= 2.0,
            Fate::Drifts(_) => true,
            Fate::Holds | Fate::Wrong(_) => false,
        }
    }

    /// Factor of growth in [`LASTING_TURNS`] turns of w, or in as many ticks if those are longer.
    #[must_use]
    pub fn growth_in_turns(&self) -> Scalar {
        // value = w h with h = tick / substeps.
        let ticks = std::f64::consts::TAU / (self.value * Scalar::from(self.substeps));
        let ticks = if ticks.is_finite() { ticks.max(1.0) } else { 1.0 };
        libm::pow(self.growth_per_tick, LASTING_TURNS * ticks)
    }
}

/// The margin of stability of a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringMargin {
    /// The bodies that the spring joins.
    pub ends: [Entity; 2],
    /// The [ratio](Margin::ratio) of its group times the spring's share in it, which is 1 for the spring with the
    /// largest bound.
    pub ratio: Scalar,
}

/// Largest number of groups whose motion is computed ahead.
const MOST_AHEAD: usize = 32;

/// A forecast of instability: the stability margins of all bodies. Springs and dampers are linearized in the present state.
/// Attraction is taken at the closest approach to come, drag at the fastest speed; for these the method itself steps the body
/// under all of its laws, beside the true motion.
///
/// The method itself steps the linear system, so that a tick is a matrix. The system is stable if no eigenvalue of the
/// matrix exceeds 1 in magnitude. The system of a group is reduced to its fastest modes, by stiffness and damping
/// together, which Lanczos's iteration finds. The single fastest mode suffices without damping, or with the same
/// damping everywhere. Groups of up to four bodies are not reduced.
///
/// Mutual gravity is that of the pair that comes nearest to its limit, alone. The forecast does not combine mutual gravity with
/// the springs of a group.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forecast {
    margins: Vec<Margin>,
    springs: Vec<SpringMargin>,
}

impl Forecast {
    /// Computes the forecast of `world`, where `method` is that of bodies without their own. Compiles the groups again
    /// if they changed.
    #[must_use]
    pub fn of(world: &mut World, method: Method) -> Self {
        Self::compute(world, method, false)
    }

    /// Computes the forecast with [`Self::springs`], a list that is long in a large world.
    #[must_use]
    pub fn with_springs(world: &mut World, method: Method) -> Self {
        Self::compute(world, method, true)
    }

    fn compute(world: &mut World, method: Method, springs: bool) -> Self {
        compile_groups(world);
        let tick = world.get_resource::<TimeStep>().map_or(0.0, |step| step.0);
        if tick <= 0.0 || !may_be_stiff(world) {
            return Self::default();
        }
        let substeps = Substeps::count(world.get_resource());
        let may_be_implicit = !world.contains_resource::<MutualGravity>();
        let scenes = Stepping { method, tick, substeps, may_be_implicit };
        let mut forecast = Self::default();
        forecast.add_single_bodies(world, scenes);
        forecast.add_groups(world, scenes, springs);
        forecast.margins.sort_by(|a, b| {
            let by_ratio = b.ratio().total_cmp(&a.ratio());
            let rank = |margin: &Margin| {
                (margin.is_unstable(), margin.may_be_unstable(), margin.fate != Fate::Holds)
            };
            rank(b).cmp(&rank(a)).then(by_ratio).then(b.value.total_cmp(&a.value))
        });
        forecast
    }

    /// Largest memory that the forecast of a group of `bodies` bodies takes, bytes.
    #[must_use]
    pub fn most_bytes(bodies: u64) -> u64 {
        let numbers = usize::try_from(bodies.saturating_mul(3)).unwrap_or(usize::MAX);
        lanczos::most_bytes(numbers) as u64
    }

    /// All margins, the worst first.
    #[must_use]
    pub fn margins(&self) -> &[Margin] {
        &self.margins
    }

    /// The margins of modes that grow, the worst first.
    pub fn unstable(&self) -> impl Iterator<Item = &Margin> {
        self.margins.iter().filter(|margin| margin.is_unstable())
    }

    /// The margins of all springs, group by group; empty without [`Self::with_springs`].
    #[must_use]
    pub fn springs(&self) -> &[SpringMargin] {
        &self.springs
    }

    fn add_groups(&mut self, world: &World, scenes: Stepping, springs: bool) {
        let Some(groups) = world.get_resource::<Groups>() else { return };
        let looks_ahead = groups.list.len() <= MOST_AHEAD;
        for Group { coupling, bodies, substeps, .. } in &groups.list {
            let first = bodies.first().and_then(|body| world.get_entity(*body).ok());
            let stepping = Stepping {
                method: first.and_then(own_method).unwrap_or(scenes.method),
                substeps: substeps.unwrap_or(scenes.substeps),
                ..scenes
            };
            let spring_margins = springs.then_some(&mut self.springs);
            self.margins.extend(groups::margin(
                world,
                coupling,
                bodies,
                stepping,
                spring_margins,
                looks_ahead,
            ));
            self.margins.extend(groups::attraction_margin(world, coupling, bodies, stepping));
        }
    }
}

/// Whether the world has anything that can limit a step.
fn may_be_stiff(world: &World) -> bool {
    world.contains_resource::<Groups>()
        || world.contains_resource::<Damping>()
        || SharedLaws::of(world).all().next().is_some()
        || may_exist::<OwnLaws>(world)
}
