//! Bodies in plain arrays, without an entity component system.

use crate::blocks::{self, Account, Applied, Known, MemoryRows, Table, Terms};
use crate::course::Course;
use crate::effects::Damping;
use crate::integrate::Synchronise;
use crate::laws::{Affine, Law};
use crate::method::Method;
use crate::methods::{Integrator, Memory, with_method};
use crate::real::Real;

/// Bodies in plain arrays, f64 or f32, integrated by the same kernels as those of a world.
///
/// ```
/// use motion::{Bare, Gravity, Method};
///
/// let mut ball = Bare::<f32>::new(Method::RungeKutta4, 1.0 / 64.0).with_law(Gravity::EARTH);
/// ball.add([0.0, 10.0, 0.0], [1.0, 0.0, 0.0], 1.0);
/// for _ in 0..64 {
///     ball.tick();
/// }
/// assert!((ball.positions[0][1] - (10.0 - 4.9)).abs() < 1e-5);
/// ```
#[derive(Debug)]
pub struct Bare<T: Real> {
    /// Position of every body, m.
    pub positions: Vec<[T; 3]>,
    /// Velocity, m/s, and inverse mass, 1/kg, of every body.
    pub bodies: Vec<[T; 4]>,
    forces: Vec<[T; 3]>,
    /// Rows that were pushed, in the form that the kernels take.
    pushed: Vec<(usize, usize)>,
    method: Method,
    step: T,
    substeps: u32,
    laws: Vec<Box<dyn Law<T>>>,
    /// Changes with the laws.
    epoch: u64,
    damping: Option<Damping>,
    /// Ticks since the step was changed last, and the time then, s.
    ticks: u64,
    since: T,
    last_steps: Vec<T>,
    known: Vec<Known<T>>,
    account: Account,
    refused: Vec<usize>,
}

impl<T: Real> Bare<T> {
    /// No bodies yet, to be integrated by `method` in ticks of `step` seconds.
    #[must_use]
    pub fn new(method: Method, step: T) -> Self {
        Self {
            positions: Vec::new(),
            bodies: Vec::new(),
            forces: Vec::new(),
            pushed: Vec::new(),
            method,
            step,
            substeps: 1,
            laws: Vec::new(),
            epoch: 0,
            damping: None,
            ticks: 0,
            since: T::ZERO,
            last_steps: Vec::new(),
            known: Vec::new(),
            account: Account::default(),
            refused: Vec::new(),
        }
    }

    /// With a law that acts on every body.
    #[must_use]
    pub fn with_law(mut self, law: impl Law<T>) -> Self {
        self.laws.push(Box::new(law));
        self
    }

    /// With damping.
    #[must_use]
    pub const fn with_damping(mut self, damping: Damping) -> Self {
        self.damping = Some(damping);
        self
    }

    /// With ticks divided into `substeps`, at least 1.
    #[must_use]
    pub fn with_substeps(mut self, substeps: u32) -> Self {
        self.substeps = substeps.max(1);
        self
    }

    /// Adds a body at `position`, m, moving at `velocity`, m/s; an `inverse_mass`, 1/kg, of 0 is immovable. Gives
    /// its row.
    pub fn add(&mut self, position: [T; 3], velocity: [T; 3], inverse_mass: T) -> usize {
        let [x, y, z] = velocity;
        self.positions.push(position);
        self.bodies.push([x, y, z, inverse_mass]);
        self.bodies.len() - 1
    }

    /// Pushes a body for the next tick with `newtons`; pushes of a tick add up.
    pub fn push(&mut self, body: usize, newtons: [T; 3]) {
        self.forces.resize(self.bodies.len(), [T::ZERO; 3]);
        self.forces[body].iter_mut().zip(newtons).for_each(|(sum, newtons)| *sum += newtons);
        if let Err(place) = self.pushed.binary_search(&(0, body)) {
            self.pushed.insert(place, (0, body));
        }
    }

    /// Replaces every law.
    pub fn set_laws(&mut self, laws: Vec<Box<dyn Law<T>>>) {
        // What was kept was kept under the old ones.
        self.leave();
        self.laws = laws;
        self.epoch += 1;
    }

    /// Changes the length of a tick, s.
    pub fn set_step(&mut self, step: T) {
        (self.since, self.ticks, self.step) = (self.time(), 0, step);
    }

    /// Changes the method: what the old one kept is turned into what the new one starts from.
    pub fn set_method(&mut self, method: Method) {
        self.leave();
        self.method = method;
    }

    /// Turns every velocity round.
    pub fn reverse_velocities(&mut self) {
        for body in &mut self.bodies {
            body[..3].iter_mut().for_each(|v| *v = -*v);
        }
        self.last_steps.iter_mut().for_each(|step| *step = -*step);
    }

    /// Forgets what the method keeps, with velocities that any other can start from: those of the positions'
    /// own time.
    pub fn leave(&mut self) {
        if self.last_steps.iter().any(|step| *step != T::ZERO) {
            self.run::<Synchronise>();
        }
        self.last_steps.clear();
        self.known.clear();
    }

    /// Integrates a tick by another method than that of the table, such as one of one's own. A tick of no length
    /// is none.
    pub fn tick_with<M: Integrator>(&mut self) {
        if self.step == T::ZERO {
            return;
        }
        self.run::<M>();
        self.ticks += 1;
        for (_, row) in self.pushed.drain(..) {
            self.forces[row] = [T::ZERO; 3];
        }
    }

    /// Simulated time, s.
    #[must_use]
    pub fn time(&self) -> T {
        self.time_of(self.ticks)
    }

    /// Accelerations of one body evaluated by called laws so far.
    #[must_use]
    pub const fn evaluations(&self) -> u64 {
        self.account.accelerations
    }

    /// Newton iterations of implicit steps so far, and steps of a body that did not converge.
    #[must_use]
    pub const fn newton(&self) -> (u64, u64) {
        (self.account.newton_iterations, self.account.unconverged)
    }

    /// Rows that were left as they were in the last tick, because they would have turned non-finite.
    #[must_use]
    pub fn refused(&self) -> &[usize] {
        &self.refused
    }

    fn time_of(&self, tick: u64) -> T {
        #[expect(clippy::cast_precision_loss, reason = "2^53 ticks are some two million years at 120 Hz")]
        let ticks = T::of(tick as f64);
        self.since + ticks * self.step
    }

    fn run<M: Integrator>(&mut self) {
        let laws = || self.laws.iter().map(|law| &**law);
        let called: Vec<_> = laws().filter(|law| law.affine().is_none()).collect();
        let (start, end) = (self.time_of(self.ticks), self.time_of(self.ticks + 1));
        let course = Course { start, end, tick: self.step, substeps: self.substeps };
        let terms = Terms::new::<M>(Affine::sum(laws()), self.damping, &called, self.epoch, course);
        let rows = self.bodies.len();
        let memory = match M::MEMORY {
            Memory::None => MemoryRows::None,
            Memory::LastStep => {
                self.last_steps.resize(rows, T::ZERO);
                MemoryRows::LastStep(&mut self.last_steps)
            }
            Memory::LastAcceleration if !called.is_empty() => {
                self.known.resize(rows, Known::default());
                MemoryRows::Known(&mut self.known)
            }
            Memory::LastAcceleration => MemoryRows::None,
        };
        let table = Table { positions: &mut self.positions, bodies: &mut self.bodies, memory };
        self.forces.resize(rows, [T::ZERO; 3]);
        let applied = (!self.pushed.is_empty()).then_some(Applied {
            forces: &self.forces,
            rows: &self.pushed,
            offset: 0,
        });
        let refused = &mut self.refused;
        refused.clear();
        blocks::integrate::<T, M>(&terms, table, applied, &mut self.account, &mut |row| refused.push(row));
    }
}

macro_rules! ticks {
    ($($t:ty)*) => {$(
        // Not generic, so that the kernels are compiled here, optimised as this crate is.
        impl Bare<$t> {
            /// Integrates a tick.
            pub fn tick(&mut self) {
                with_method!(self.method, M => self.tick_with::<M>());
            }
        }
    )*};
}

ticks!(f64 f32);
