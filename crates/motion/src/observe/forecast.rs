//! Which steps are too long for what acts, before they are taken.

mod cure;
mod groups;
mod lanczos;
mod matrix;
mod modes;
mod single_bodies;

use bevy_ecs::prelude::*;

use crate::groups::{Groups, compile_groups};
use crate::laws::damping::Damping;
use crate::laws::own::OwnLaws;
use crate::laws::{Drag, Laws, MutualGravity, Wells};
use crate::methods::markers::own_method;
use crate::methods::table::Method;
use crate::state::archetypes::may_exist;
use crate::state::clock::TimeStep;
use crate::state::substeps::Substeps;
use crate::units::Scalar;

use modes::Pace;

/// What of a world limits a step.
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
    /// A well, by its number, at the place of a body.
    Well(usize, Entity),
    /// Another law, by its name, on a body.
    Law(&'static str, Entity),
}

/// What makes an unstable part stable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cure {
    /// The least number of substeps by the same method, if one up to [`Substeps::MOST`] is enough.
    pub substeps: Option<u32>,
    /// A method that is stable as it is: the first of the table with no lower order, or else implicit Euler.
    pub method: Option<Method>,
}

/// How far from instability something is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// What limits the step most, of all that is integrated together.
    pub part: LimitingPart,
    /// ForecastQuery that are integrated together, or alike.
    pub bodies: usize,
    /// Their method.
    pub method: Method,
    /// Their parts of a tick.
    pub substeps: u32,
    /// w h of springs and wells, c h of damping: of the fastest mode at present, for a step of h seconds. Never more
    /// than it is: what is said to grow does grow.
    pub value: Scalar,
    /// What it is at most. Where it is more than 1 % above the value, no more than these two is known: of groups of
    /// more than some 30,000 bodies that have no regular structure.
    pub at_most: Scalar,
    /// The value from which on it grows, the next one above where it is stable now; 0 for never stable, as is a limit below
    /// 5e-3 of one mode or 0.05 of several; infinite for no limit. Yoshida 4 with damping is stable again at some longer
    /// steps.
    pub limit: Scalar,
    /// Whether it grows at present.
    pub is_unstable: bool,
    /// By what factor it grows in a second when many have passed, 1 for not at all.
    pub growth_per_s: Scalar,
    /// What would help, if it grows: also if the value is the largest that it may be.
    pub cure: Cure,
}

impl Margin {
    /// Whether the value is known to 1 %.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.at_most <= 1.01 * self.value || self.at_most == self.value
    }

    /// Value over limit: above 1 it grows.
    #[must_use]
    pub fn ratio(&self) -> Scalar {
        if self.limit == 0.0 { Scalar::INFINITY } else { self.value / self.limit }
    }
}

/// How far from instability a spring is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringMargin {
    /// The bodies that it joins.
    pub ends: [Entity; 2],
    /// The ratio of all that is integrated with it, times how much this spring has to do with it: 1 for the one with the
    /// largest bound.
    pub ratio: Scalar,
}

/// How far everything is from instability, as it is at present: springs and their dampers linearised, drag at the present
/// velocities, wells at the present distances.
///
/// A linear system is stepped by the method itself, and its tick is a matrix; it is stable if no eigenvalue of that is
/// above 1. Of groups the system is reduced to the modes that matter: the fastest ones by stiffness and damping together,
/// found by Lanczos's iteration; without damping, or with one that is the same everywhere, that is the fastest one alone.
/// In groups of up to four bodies nothing is reduced.
///
/// Not looked at: mutual gravity, and wells and laws of single bodies together with springs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forecast {
    margins: Vec<Margin>,
    springs: Vec<SpringMargin>,
}

impl Forecast {
    /// Of `world`, in which bodies without their own method have `method`. Groups are made anew if it is time to.
    #[must_use]
    pub fn of(world: &mut World, method: Method) -> Self {
        Self::look(world, method, false)
    }

    /// The same with [`Self::springs`], of which a large world has many.
    #[must_use]
    pub fn with_springs(world: &mut World, method: Method) -> Self {
        Self::look(world, method, true)
    }

    fn look(world: &mut World, method: Method, springs: bool) -> Self {
        compile_groups(world);
        let tick = world.get_resource::<TimeStep>().map_or(0.0, |step| step.0);
        if tick <= 0.0 || !may_be_stiff(world) {
            return Self::default();
        }
        let substeps = Substeps::parts(world.get_resource());
        let scenes = Pace { method, tick, substeps };
        let attracts = world.contains_resource::<MutualGravity>();
        let solvable = |method| !attracts || method != Method::ImplicitEuler;
        let mut forecast = Self::default();
        forecast.look_at_single_bodies(world, scenes, &solvable);
        forecast.look_at_groups(world, scenes, springs, &solvable);
        forecast.margins.sort_by(|a, b| {
            let by_ratio = b.ratio().total_cmp(&a.ratio());
            b.is_unstable.cmp(&a.is_unstable).then(by_ratio).then(b.value.total_cmp(&a.value))
        });
        forecast
    }

    /// Bytes that looking at a group of so many bodies takes at most.
    #[must_use]
    pub fn most_bytes(bodies: u64) -> u64 {
        let numbers = usize::try_from(bodies.saturating_mul(3)).unwrap_or(usize::MAX);
        lanczos::most_bytes(numbers) as u64
    }

    /// The worst first.
    #[must_use]
    pub fn margins(&self) -> &[Margin] {
        &self.margins
    }

    /// Those that grow, the worst first.
    pub fn unstable(&self) -> impl Iterator<Item = &Margin> {
        self.margins.iter().filter(|margin| margin.is_unstable)
    }

    /// Every spring, group by group; none without [`Self::with_springs`].
    #[must_use]
    pub fn springs(&self) -> &[SpringMargin] {
        &self.springs
    }

    fn look_at_groups(
        &mut self,
        world: &World,
        scenes: Pace,
        springs: bool,
        solvable: &dyn Fn(Method) -> bool,
    ) {
        let Some(groups) = world.get_resource::<Groups>() else { return };
        for (coupling, bodies, substeps) in groups.parts() {
            let first = bodies.first().and_then(|body| world.get_entity(*body).ok());
            let pace = Pace {
                method: first.and_then(own_method).unwrap_or(scenes.method),
                substeps: substeps.unwrap_or(scenes.substeps),
                ..scenes
            };
            let tell = springs.then_some(&mut self.springs);
            self.margins.extend(groups::look(world, coupling, bodies, pace, solvable, tell));
        }
    }
}

/// Whether there is anything to look at.
fn may_be_stiff(world: &World) -> bool {
    world.contains_resource::<Groups>()
        || world.contains_resource::<Drag>()
        || world.contains_resource::<Wells>()
        || world.contains_resource::<Damping>()
        || world.contains_resource::<Laws>()
        || may_exist::<OwnLaws>(world)
}
