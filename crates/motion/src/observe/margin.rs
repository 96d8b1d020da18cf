//! Margins of stability: how near the springs, dampers, drag and wells of a world are to the limit of the method, linearized in
//! the present state.

mod cure;
mod groups;
mod lanczos;
mod matrix;
mod modes;
mod natural;
mod single_bodies;

use bevy_ecs::prelude::*;
pub use cure::as_good_as;
use modes::{MOST_COORDINATES, Stepping};
pub use natural::{NaturalMode, NaturalModes, natural_modes};
pub(crate) use single_bodies::restoring_rate;

use crate::groups::{Coupling, Groups, coming_couplings, couplings};
use crate::laws::damping::Damping;
use crate::laws::own::OwnLaws;
use crate::laws::{MutualGravity, SharedLaws};
use crate::methods::markers::own_method;
use crate::methods::table::Method;
use crate::state::archetypes::may_exist;
use crate::state::clock::TimeStep;
use crate::state::substeps::{AutoSubsteps, OwnSubsteps, Substeps};
use crate::tick::columns::NO_STEPPER;
use crate::units::Scalar;

/// The part of a world that limits a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
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

impl LimitingPart {
    /// Its bodies: one or two.
    #[must_use]
    pub fn bodies(&self) -> &[Entity] {
        match self {
            Self::Spring(ends) | Self::Damper(ends) | Self::MutualGravity(ends) => ends,
            Self::Drag(body) | Self::Damping(body) | Self::Well(_, body) | Self::Law(_, body) => {
                std::slice::from_ref(body)
            }
        }
    }
}

/// The changes that would make an unstable part stable.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Cure {
    /// Smallest stable number of substeps of the same method, if there is one up to [`Substeps::MOST`].
    pub substeps: Option<u32>,
    /// An error of a tick, m, for which substeps can be chosen, if that was tried and takes less than half of that number.
    pub error: Option<Scalar>,
    /// A method that is stable at the same step: the first of the table whose order is not lower, or else implicit
    /// Euler.
    pub method: Option<Method>,
}

/// The margin of stability of bodies that are integrated together, or alike.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Margin {
    /// The part that limits the step most.
    pub part: LimitingPart,
    /// Number of bodies.
    pub bodies: usize,
    /// Method of the bodies.
    pub method: Method,
    /// Substeps per tick; the most of bodies that choose.
    pub substeps: u32,
    /// w h of springs and attraction, or c h of damping, of the fastest mode for a step of h seconds. For springs this is a lower
    /// bound: a mode that is predicted to grow does grow.
    pub value: Scalar,
    /// Upper bound of the value. It is within 1 % of the value, except for groups of more than some 30,000 bodies
    /// without a regular structure. If the limit is in between, the search continues until it is not, or until the bound
    /// is within 0.1 %; for groups of more than a million bodies it may end earlier.
    pub at_most: Scalar,
    /// The value above which the mode grows: the next such limit above the current value if that is stable. 0 if no
    /// step is stable, or if the limit is below 5e-3, or below 0.05 for several modes under a method that is not of order 1;
    /// infinite if every step is stable. Yoshida 4 with damping is stable again at some longer steps.
    pub limit: Scalar,
    /// Whether the laws are linear, so that the growth of the mode is that of the motion. Where wells, mutual gravity, quadratic
    /// drag, cords or laws of your own act, the margin holds for small motions about the present state only: run the world ahead
    /// to learn more.
    pub is_linear: bool,
    /// Factor of growth of the mode per second, after many seconds; 1 if it does not grow.
    pub growth_per_s: Scalar,
    /// Factor of growth of the mode per tick.
    pub growth_per_tick: Scalar,
    /// The changes that would make it stable, even if the value is its upper bound. Empty if it is known to be stable, or if the
    /// laws are not linear.
    pub cure: Cure,
}

/// Number of turns of a mode within which growth counts: Runge-Kutta 2 is never quite stable.
const COUNTED_TURNS: Scalar = 100.0;

impl Margin {
    /// Whether the value is known within 1 %.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.at_most <= 1.01 * self.value || self.at_most == self.value
    }

    /// Whether the mode grows.
    #[must_use]
    pub const fn grows(&self) -> bool {
        self.growth_per_tick > 1.0
    }

    /// Whether the motion grows: the mode does, and the laws are linear.
    #[must_use]
    pub const fn is_unstable(&self) -> bool {
        self.grows() && self.is_linear
    }

    /// Whether it is unknown if the motion grows: the limit is between the value and its upper bound.
    #[must_use]
    pub fn may_be_unstable(&self) -> bool {
        self.is_linear && !self.grows() && (self.value..self.at_most).contains(&self.limit)
    }

    /// Value over limit.
    #[must_use]
    pub fn ratio(&self) -> Scalar {
        if self.limit == 0.0 { Scalar::INFINITY } else { self.value / self.limit }
    }

    /// Whether the motion at least doubles within 100 turns of the mode, or may.
    #[must_use]
    pub fn is_reported(&self) -> bool {
        self.may_be_unstable() || self.is_unstable() && self.growth_in_turns() >= 2.0
    }

    /// Factor of growth in 100 turns of the mode, or in as many ticks if those are longer.
    #[must_use]
    pub fn growth_in_turns(&self) -> Scalar {
        // value = w h with h = tick / substeps.
        let ticks = std::f64::consts::TAU / (self.value * Scalar::from(self.substeps));
        let ticks = if ticks.is_finite() { ticks.max(1.0) } else { 1.0 };
        libm::pow(self.growth_per_tick, COUNTED_TURNS * ticks)
    }

    /// The bound of the angular frequency or of the rate, 1/s, for ticks of `tick` seconds.
    #[must_use]
    pub fn rate(&self, tick: Scalar) -> Scalar {
        self.at_most * Scalar::from(self.substeps) / tick
    }
}

/// The margin of stability of a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct SpringMargin {
    /// The bodies that the spring joins.
    pub ends: [Entity; 2],
    /// The [ratio](Margin::ratio) of its group times the spring's share in it, which is 1 for the spring with the
    /// largest bound.
    pub ratio: Scalar,
}

/// The margins of stability of all bodies of a world, linearized in its present state.
///
/// The method itself steps the linear system, so that a tick is a matrix. The system is stable if no eigenvalue of the
/// matrix exceeds 1 in magnitude. The system of a group is reduced to its fastest modes, by stiffness and damping
/// together, which Lanczos's iteration finds. The single fastest mode suffices without damping, or with the same
/// damping everywhere. Groups of up to four bodies are not reduced. Mutual gravity is that of the pair with the highest
/// frequency.
///
/// ```
/// use bevy_ecs::prelude::*;
/// use motion::margin::Margins;
/// use motion::prelude::*;
///
/// let mut world = World::new();
/// let wall = world.spawn(PhysicsBody::IMMOVABLE).id();
/// let mass = world.spawn((motion::Transform::at(Vector::X), PhysicsBody::with_mass(1.0))).id();
/// world.spawn(Spring { ends: [wall, mass], elastic: Elastic::new(1e4, 1.0) });
/// let mut stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(1.0 / 60.0));
/// let margins = Margins::of(&world, stepper.method());
/// assert!(!margins.list()[0].is_unstable()); // w h = 100 / 60, and the limit is 2.
///
/// world.insert_resource(TimeStep(1.0 / 30.0));
/// let margins = Margins::of(&world, stepper.method());
/// assert!(margins.list()[0].is_unstable());
/// assert_eq!(margins.list()[0].cure.substeps, Some(2));
/// # stepper.tick(&mut world);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Margins {
    list: Vec<Margin>,
    springs: Vec<SpringMargin>,
}

impl Margins {
    /// Computes the margins of `world`, where `method` is that of bodies without their own.
    ///
    /// # Panics
    /// If no stepper was made for `world`.
    #[must_use]
    pub fn of(world: &World, method: Method) -> Self {
        Self::compute(world, method, false)
    }

    /// Computes the margins with [`Self::springs`], a list that is long in a large world.
    #[must_use]
    pub fn with_springs(world: &World, method: Method) -> Self {
        Self::compute(world, method, true)
    }

    fn compute(world: &World, method: Method, with_springs: bool) -> Self {
        let mut margins = MarginsInParts::new(with_springs);
        margins.advance(world, method, usize::MAX);
        margins.into_margins()
    }

    /// Largest memory that the margin of a group of `bodies` bodies takes, bytes.
    #[doc(hidden)]
    #[must_use]
    pub fn most_bytes(bodies: u64) -> u64 {
        let numbers = usize::try_from(bodies.saturating_mul(3)).unwrap_or(usize::MAX);
        lanczos::most_bytes(numbers) as u64
    }

    /// All margins, the worst first.
    #[must_use]
    pub fn list(&self) -> &[Margin] {
        &self.list
    }

    /// The margins of all springs, group by group; empty without [`Self::with_springs`].
    #[must_use]
    pub fn springs(&self) -> &[SpringMargin] {
        &self.springs
    }
}

/// Margins of stability that are computed some groups at a time: those of thousands of groups take a second.
#[derive(Clone, Debug)]
pub struct MarginsInParts {
    margins: Margins,
    with_springs: bool,
    /// Number of groups that are done.
    groups: usize,
}

impl MarginsInParts {
    /// Margins of which none is computed yet, with [`Margins::springs`] if `with_springs`.
    #[must_use]
    pub const fn new(with_springs: bool) -> Self {
        let margins = Margins { list: Vec::new(), springs: Vec::new() };
        Self { margins, with_springs, groups: 0 }
    }

    /// Continues with the next groups of `world` until `work` is used up: some 200 units per group of two bodies, and 2,000 per larger
    /// one, at least one group. Returns whether all groups are done. If the groups of the world change in between, begin again.
    ///
    /// # Panics
    /// If no stepper was made for `world`.
    pub fn advance(&mut self, world: &World, method: Method, work: usize) -> bool {
        let TimeStep(tick) = *world.get_resource().expect(NO_STEPPER);
        if tick <= 0.0 || !may_be_stiff(world) {
            return true;
        }
        let substeps = Substeps::count(world.get_resource());
        let may_be_implicit = !world.contains_resource::<MutualGravity>();
        let scenes = Stepping { method, tick, substeps, may_be_implicit };
        let coming = coming_couplings(world);
        if self.groups == 0 {
            self.margins.add_single_bodies(world, scenes, coming.as_deref());
        }
        let mut used = 0;
        for (coupling, bodies) in couplings(world, coming.as_deref()).skip(self.groups) {
            if used >= work {
                return false;
            }
            used += (3 * coupling.movable).min(MOST_COORDINATES).pow(3);
            self.add_group(world, scenes, coupling, bodies);
            self.groups += 1;
        }
        self.margins.list.sort_by(|a, b| {
            let rank = |margin: &Margin| (margin.is_unstable(), margin.may_be_unstable());
            let by_ratio = b.ratio().total_cmp(&a.ratio());
            rank(b).cmp(&rank(a)).then(by_ratio).then(b.value.total_cmp(&a.value))
        });
        true
    }

    fn add_group(
        &mut self,
        world: &World,
        scenes: Stepping,
        coupling: &Coupling,
        bodies: &[Entity],
    ) {
        // The others get the method and substeps of the first.
        let first = bodies.first().and_then(|body| world.get_entity(*body).ok());
        let own = first.and_then(|body| Some(body.get::<OwnSubsteps>()?.0.max(1)));
        // What grows makes a group choose more.
        let most = first.and_then(|body| Some(body.get::<AutoSubsteps>()?.most));
        let stepping = Stepping {
            method: first.and_then(own_method).unwrap_or(scenes.method),
            substeps: most.or(own).unwrap_or(scenes.substeps),
            ..scenes
        };
        let Margins { list, springs } = &mut self.margins;
        let springs = self.with_springs.then_some(springs);
        list.extend(groups::margin(world, coupling, bodies, stepping, springs));
        list.extend(groups::attraction_margin(world, coupling, bodies, stepping));
    }

    /// The margins of the groups that are done.
    #[must_use]
    pub fn into_margins(self) -> Margins {
        self.margins
    }
}

/// Whether the world has anything that can limit a step.
fn may_be_stiff(world: &World) -> bool {
    world.contains_resource::<Groups>()
        || world.contains_resource::<Damping>()
        || SharedLaws::of(world).all().next().is_some()
        || may_exist::<OwnLaws>(world)
}
