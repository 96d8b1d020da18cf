//! Bodies in plain arrays, without an entity component system.

mod bodies;
mod emitters;
mod entry_points;
mod environment;
mod groups;
mod of_world;
mod state;
mod tick;

use bodies::Individuals;
use emitters::Source;
use environment::Resources;
use groups::ArrayGroup;

use crate::groups::Scratch;
use crate::kernels::StepStatistics;
use crate::laws::damping::Damping;
use crate::laws::{Gravity, Law};
use crate::methods::table::Method;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::StableId;
use crate::state::method_state::CachedAcceleration;
use crate::state::range::Range;
use crate::state::substeps::Substeps;
use crate::units::{Scalar, Vector};

pub use of_world::{LawsOf, NotForArrays};
pub use state::BareState;

/// Bodies in plain arrays, integrated by the same kernels as those of a world.
///
/// ```
/// use motion::{Gravity, Method};
/// use motion::arrays::Bare;
///
/// let mut ball = Bare::new(Method::RungeKutta4, 1.0 / 64.0).with_law(Gravity::EARTH);
/// ball.add([0.0, 10.0, 0.0], [1.0, 0.0, 0.0], 1.0);
/// for _ in 0..64 {
///     ball.tick();
/// }
/// assert!((ball.positions[0][1] - (10.0 - 4.9)).abs() < 1e-12);
/// ```
///
/// [`Bare::of_world`] copies a whole world, with the options of single bodies and everything that acts between them.
#[derive(Debug)]
pub struct Bare {
    /// Position of every body, m.
    pub positions: Vec<[f64; 3]>,
    /// Velocity, m/s, and inverse mass, 1/kg, of every body. Bodies of a world that are immovable and at rest are not
    /// integrated: set velocities by [`Bare::set_velocity`].
    pub bodies: Vec<[f64; 4]>,
    /// Ids of the bodies of a world, ascending.
    ids: Vec<StableId>,
    forces: Vec<[f64; 3]>,
    /// Pushed rows as (0, row), ascending: kernels take (table, row).
    pushed: Vec<(usize, usize)>,
    method: Method,
    /// Length of a tick, s.
    step: Scalar,
    substeps: u32,
    resources: Resources,
    individuals: Individuals,
    sources: Vec<Source>,
    groups: Vec<ArrayGroup>,
    scratch: Scratch,
    clock: StepClock,
    last_steps: Vec<f64>,
    cached: Vec<CachedAcceleration>,
    statistics: StepStatistics,
    refused: Vec<usize>,
    has_failed: bool,
}

impl Bare {
    /// Makes arrays without bodies, to be integrated by `method` in ticks of `step` seconds.
    ///
    /// # Panics
    /// If `step` is negative or not finite.
    #[must_use]
    pub fn new(method: Method, step: f64) -> Self {
        TimeStep(step).check();
        Self {
            positions: Vec::new(),
            bodies: Vec::new(),
            ids: Vec::new(),
            forces: Vec::new(),
            pushed: Vec::new(),
            method,
            step,
            substeps: 1,
            resources: Resources::default(),
            individuals: Individuals::default(),
            sources: Vec::new(),
            groups: Vec::new(),
            scratch: Scratch::default(),
            clock: StepClock::default(),
            last_steps: Vec::new(),
            cached: Vec::new(),
            statistics: StepStatistics::default(),
            refused: Vec::new(),
            has_failed: false,
        }
    }

    /// Adds a law that acts on every body.
    #[must_use]
    pub fn with_law(mut self, law: impl Law) -> Self {
        self.resources.laws.push(Box::new(law));
        self
    }

    /// Sets damping.
    ///
    /// # Panics
    /// If its rate is below 0.
    #[must_use]
    pub fn with_damping(mut self, damping: Damping) -> Self {
        damping.check();
        self.resources.damping = Some(damping);
        self
    }

    /// Sets the range of states: a row that would leave it is refused.
    ///
    /// # Panics
    /// If a bound is not above 0.
    #[must_use]
    pub fn with_range(mut self, range: Range) -> Self {
        range.check();
        self.resources.range = Some(range);
        self
    }

    /// Sets the number of substeps per tick; bodies with their own number keep it.
    ///
    /// # Panics
    /// If `substeps` is 0 or above [`Substeps::MOST`].
    #[must_use]
    pub fn with_substeps(mut self, substeps: u32) -> Self {
        Substeps::check(substeps);
        self.substeps = substeps;
        self
    }

    /// Adds a body at `position`, m, moving at `velocity`, m/s; returns its row. An `inverse_mass`, 1/kg, of 0 is
    /// immovable.
    pub fn add(&mut self, position: [f64; 3], velocity: [f64; 3], inverse_mass: f64) -> usize {
        let [x, y, z] = velocity;
        self.positions.push(position);
        self.bodies.push([x, y, z, inverse_mass]);
        self.individuals.add();
        self.bodies.len() - 1
    }

    /// Pushes a body with `newtons` during the next tick; pushes of a tick add up.
    pub fn push(&mut self, body: usize, newtons: [f64; 3]) {
        self.forces.resize(self.bodies.len(), [0.0; 3]);
        self.forces[body].iter_mut().zip(newtons).for_each(|(sum, newtons)| *sum += newtons);
        if let Err(place) = self.pushed.binary_search(&(0, body)) {
            self.pushed.insert(place, (0, body));
        }
    }

    /// The row of the body with this id, for bodies of a world.
    #[must_use]
    pub fn row_of(&self, id: StableId) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }

    /// Id, position, m, and velocity, m/s, of every body of a world, immovable ones included, in the order of ids.
    /// Bodies without an id come last, as [`u32::MAX`].
    pub fn states(&self) -> impl Iterator<Item = (StableId, Vector, Vector)> + '_ {
        let rows = self.positions.iter().zip(&self.bodies);
        self.ids.iter().zip(rows).map(|(id, (x, [a, b, c, _]))| {
            (*id, Vector::from_array(*x), Vector::from_array([*a, *b, *c]))
        })
    }

    /// Sets the present velocity of a body, m/s. Restarts position Verlet.
    pub fn set_velocity(&mut self, body: usize, velocity: [f64; 3]) {
        self.bodies[body][..3].copy_from_slice(&velocity);
        if let Some(last) = self.last_steps.get_mut(body) {
            *last = 0.0;
        }
        self.individuals.outdated = true;
    }

    /// Applies an impulse J, N s, to a body: `v += J w`.
    pub fn give_impulse(&mut self, body: usize, impulse: [f64; 3]) {
        let w = self.bodies[body][3];
        for (axis, impulse) in impulse.into_iter().enumerate().filter(|_| w > 0.0) {
            self.bodies[body][axis] += impulse * w;
        }
    }

    /// Reverses every velocity.
    pub fn reverse_velocities(&mut self) {
        for body in &mut self.bodies {
            body[..3].iter_mut().for_each(|v| *v = 0.0 - *v);
        }
        self.last_steps.iter_mut().for_each(|step| *step = -*step);
    }

    /// Sets the length of a tick, s.
    ///
    /// # Panics
    /// If it is negative or not finite.
    pub fn set_step(&mut self, step: f64) {
        TimeStep(step).check();
        self.step = step;
    }

    /// Gravity, if it was declared.
    #[must_use]
    pub const fn gravity(&self) -> Option<Gravity> {
        self.resources.gravity
    }

    /// Simulated time, s; for a world, since the scene began.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.scene_seconds()
    }

    /// Evaluations of the acceleration of one body by all laws so far, as [`Evaluations`](crate::Evaluations) counts
    /// them.
    #[must_use]
    pub const fn evaluations(&self) -> u64 {
        self.statistics.accelerations
    }

    /// Newton iterations of implicit steps of single bodies so far, and number of steps of a body or group that did
    /// not converge.
    #[must_use]
    pub const fn newton(&self) -> (u64, u64) {
        (self.statistics.iterations.newton, self.statistics.iterations.unconverged_steps)
    }

    /// Iterations of conjugate gradients of implicit steps of groups so far.
    #[must_use]
    pub const fn cg_iterations(&self) -> u64 {
        self.statistics.iterations.cg
    }

    /// Rows that were refused in the last tick, because they would have turned non-finite or left the range: they
    /// keep their state. For a group this is the row that failed first; the whole group keeps its state.
    #[must_use]
    pub fn refused(&self) -> &[usize] {
        &self.refused
    }

    /// Whether a row was refused in any tick. There is no quarantine here: states after that are meaningless.
    #[must_use]
    pub const fn has_failed(&self) -> bool {
        self.has_failed
    }

    fn forget_accelerations(&mut self) {
        self.cached.clear();
        self.groups.iter_mut().for_each(ArrayGroup::forget);
    }
}

#[cfg(test)]
mod tests;
