//! The field of a block of bodies with laws that are called.

use glam::DMat3;

use super::block::{Block, BlockSpace, fill};
use super::drive::TickField;
use super::record::Recorder;
use super::{
    AppliedForces, BodyOptions, Row, RowOptions, StepStatistics, TickParameters, restrain,
};
use crate::laws::damping::{Decay, SNAP};
use crate::laws::tick_times::Segment;
use crate::laws::{BLOCK_BODIES, BodyBlock, BodyState, EvaluationTime, Law};
use crate::methods::{Field, Integrator, Newton, NewtonField, StepState, newton_velocity};
use crate::simd::vectorize;
use crate::units::Vector;

/// The field of the `N` bodies of a block, whose states are elements of the space `X`.
pub(super) struct BlockField<'a, X: BlockSpace<N>, const N: usize> {
    pub parameters: &'a TickParameters<'a>,
    /// The options of the bodies.
    pub options: &'a BodyOptions<'a>,
    /// The options of every row of the batch, where the own laws of bodies differ.
    pub rows: Option<&'a dyn RowOptions>,
    /// The own laws of every body and their version.
    pub own_laws: [(&'a [Box<dyn Law>], u64); N],
    /// Axes along which bodies can be accelerated.
    open: [bool; 3],
    gravity: [f64; 3],
    decay: Decay,
    h: f64,
    segment: Option<Segment>,
    /// Whether a law that is called depends on the velocity.
    calls_with_velocity: bool,
    /// Whether linear drag acts or a called law depends on the velocity.
    drags: bool,
    /// Magnitude below which velocities snap to 0.
    least: f64,
    /// The inverse masses, 1/kg.
    pub w: [f64; N],
    /// Bodies of the block, at most `N`.
    len: usize,
    /// Whether every body can be accelerated along every axis.
    all_move: bool,
    /// Whether a force is applied to a body.
    pushed: bool,
    applied: Block<N>,
    /// Sum of the called laws in the last evaluation.
    pub called: Block<N>,
    pub statistics: &'a mut StepStatistics,
    /// Number of movable bodies of the block, whose evaluations are counted.
    movable: u64,
    /// Evaluations of the block in this tick.
    evaluations: u64,
    /// Evaluations of single bodies in earlier blocks that are not yet counted by law: looking up the names takes time.
    counted: u64,
    /// Where the states are stored.
    pub memory: X::Memory,
}

impl<'a, X: BlockSpace<N>, const N: usize> BlockField<'a, X, N> {
    /// A field for blocks of bodies with equal options. If their own laws differ, `rows` has the options of each row. Call
    /// [`Self::enter_block`] next.
    pub fn new<M: Integrator>(
        parameters: &'a TickParameters<'a>,
        options: &'a BodyOptions<'a>,
        rows: Option<&'a dyn RowOptions>,
        statistics: &'a mut StepStatistics,
        memory: X::Memory,
    ) -> Self {
        let closed = options.closed_axes(M::LIMITS_AFTER_KICK);
        Self {
            parameters,
            options,
            rows,
            own_laws: [(options.laws, options.laws_version); N],
            open: closed.map_or([true; 3], |closed| [!closed.x, !closed.y, !closed.z]),
            // Adding 0 turns -0 into 0: a row gets the same bits whether its block has a force or not.
            gravity: parameters.gravity.to_array().map(|g| g + 0.0),
            decay: parameters.decay,
            h: parameters.times.substep(),
            segment: None,
            calls_with_velocity: parameters.calls_with_velocity(options.laws.iter()),
            drags: false,
            least: 0.0,
            w: [0.0; N],
            len: 0,
            all_move: false,
            pushed: false,
            applied: Block::ZERO,
            called: Block::ZERO,
            statistics,
            movable: 0,
            evaluations: 0,
            counted: 0,
            memory,
        }
    }

    /// Enters a block of `bodies`, (velocity, inverse mass) each, at most `N`, with the forces applied to them; `first` is
    /// the row of the first.
    #[inline(never)]
    pub fn enter_block(
        &mut self,
        first: usize,
        bodies: &[Row],
        applied: Option<AppliedForces<'_>>,
    ) {
        self.len = bodies.len();
        if let Some(rows) = self.rows {
            for (k, own) in self.own_laws[..bodies.len()].iter_mut().enumerate() {
                let BodyOptions { laws, laws_version, .. } = rows.row(first + k);
                *own = (laws, laws_version);
            }
        }
        self.segment = None;
        self.evaluations = 0;
        self.h = self.parameters.times.substep();
        // Before the first segment, velocities snap only under damping or linear drag.
        self.drags = self.parameters.rate > 0.0;
        self.set_decay(self.parameters.decay);
        self.drags |= self.calls_with_velocity;
        self.movable = vectorize(
            #[inline(always)]
            || {
                load_inverse_masses(&mut self.w, bodies);
                self.w.iter().fold(0_u64, |count, w| count + u64::from(*w > 0.0))
            },
        );
        let all = self.movable == N as u64;
        self.all_move = all && self.open == [true; 3];
        if bodies.len() < N {
            self.movable = self.w[..bodies.len()].iter().filter(|w| **w > 0.0).count() as u64;
        }
        if self.pushed {
            self.applied = Block::ZERO;
        }
        self.pushed = false;
        if let Some(AppliedForces { forces, rows, offset }) = applied {
            for row in rows.iter().map(|(_, row)| row - offset) {
                self.pushed = true;
                for (axis, force) in forces[row].iter().enumerate() {
                    let is_open = self.open[axis] && self.w[row] > 0.0;
                    self.applied.0[axis][row] = if is_open { *force * self.w[row] } else { 0.0 };
                }
            }
        }
    }

    fn set_decay(&mut self, decay: Decay) {
        self.decay = decay;
        self.least = if decay.multiplies() || self.drags { SNAP } else { 0.0 };
    }

    /// Sets velocities that decayed below [`SNAP`] to 0.
    #[inline(never)]
    pub fn snap(&self, v: X) -> X {
        let least = self.least;
        v.map(|_, _, v| snapped(v, least))
    }

    /// Acceleration by all laws, from the sum of the called ones, and with `PUSHED` by the applied forces.
    #[inline(always)]
    fn accelerated<const PUSHED: bool>(&self, called: &Block<N>, v: X) -> X {
        let Self { gravity, open, w, applied, .. } = self;
        let (gravity, open, rate) = (*gravity, *open, self.parameters.rate);
        let laws = |axis: usize, k: usize, v: f64| (gravity[axis] - v * rate) + called.0[axis][k];
        if self.all_move && !PUSHED {
            return v.map(laws);
        }
        v.map(|axis, k, v| {
            // A selection, not a factor: NaN times 0 would be NaN.
            let a = if open[axis] & (w[k] > 0.0) { laws(axis, k, v) } else { 0.0 };
            if PUSHED { a + applied.0[axis][k] } else { a }
        })
    }

    /// Acceleration by all laws, from the sum of the called ones.
    #[inline(never)]
    pub fn laws_from(&self, called: &Block<N>, v: X) -> X {
        self.accelerated::<false>(called, v)
    }

    /// The laws that are called for body `k`: those of all bodies and its own.
    fn laws_of(&self, k: usize) -> impl Iterator<Item = &'a dyn Law> + Clone + use<'a, X, N> {
        self.parameters.laws.iter().copied().chain(self.own_laws[k].0.iter().map(|law| &**law))
    }

    /// The laws that are called for all of the bodies alike.
    fn called_laws(&self) -> impl Iterator<Item = &'a dyn Law> + Clone + use<'a, X, N> {
        let own = if self.rows.is_some() { &[] } else { self.options.laws };
        self.parameters.laws.iter().copied().chain(own.iter().map(|law| &**law))
    }

    /// Counts the evaluations of all blocks so far.
    pub fn count(&mut self) {
        let rows = std::mem::take(&mut self.counted);
        self.statistics.count(rows, self.called_laws());
    }

    /// Counts the evaluations of the block.
    pub fn count_block(&mut self) {
        self.counted += self.movable * self.evaluations;
        if self.rows.is_some() {
            self.count();
            for k in (0..self.len).filter(|k| self.w[*k] > 0.0) {
                for law in self.own_laws[k].0 {
                    self.statistics.count_law(law.name(), self.evaluations);
                }
            }
        }
    }

    /// Sums the called laws at the time `at`.
    #[inline(never)]
    fn call(&mut self, at: EvaluationTime, x: X, v: X) {
        self.evaluations += 1;
        let laws = self.called_laws();
        let own_laws = if self.rows.is_some() { &self.own_laws[..self.len] } else { &[] };
        let Self { w, called, .. } = self;
        *called = Block::ZERO;
        x.read_both(v, |x, v| {
            if let (Some(positions), Some(velocities), Some(inverse_masses), Some(sum)) =
                (x.axes(), v.axes(), w.as_slice().try_into().ok(), called.axes_mut())
            {
                let bodies = BodyBlock { positions, velocities, inverse_masses };
                laws.for_each(|law| law.accelerate(at, &bodies, sum));
            } else {
                (0..N).for_each(|k| add_one(laws.clone(), at, k, x, v, w, called));
            }
            for (k, (own, _)) in own_laws.iter().enumerate() {
                add_one(own.iter().map(|law| &**law), at, k, x, v, w, called);
            }
        });
    }

    /// Acceleration by all laws at the time `at` in one pass less, if one law is called, every body can move along every axis and
    /// no force is applied. The bits are the same: the sum of the called laws has one term.
    #[inline(always)]
    fn acceleration_by_one(&mut self, at: EvaluationTime, x: X, v: X) -> Option<X> {
        if N != BLOCK_BODIES || self.rows.is_some() {
            return None;
        }
        let mut laws = self.called_laws();
        let law = laws.next().filter(|_| laws.next().is_none() && self.all_move && !self.pushed)?;
        let inverse_masses: &[f64; BLOCK_BODIES] = self.w.as_slice().try_into().ok()?;
        let (gravity, rate) = (self.gravity, self.parameters.rate);
        let a = x.write(v, |x, v, a| {
            if let (Some(positions), Some(velocities), Some(sum)) =
                (x.axes(), v.axes(), a.axes_mut())
            {
                if rate == 0.0 {
                    sum.iter_mut().zip(gravity).for_each(|(sum, g)| sum.fill(g));
                } else {
                    vectorize(
                        #[inline(always)]
                        || fill(sum, |axis, k| gravity[axis] - velocities[axis][k] * rate),
                    );
                }
                law.accelerate(at, &BodyBlock { positions, velocities, inverse_masses }, sum);
            }
        });
        self.evaluations += 1;
        Some(a)
    }

    /// Sums the called laws of body `k` alone, and counts them.
    fn call_one(&mut self, at: EvaluationTime, k: usize, x: &Block<N>, v: &Block<N>) {
        self.statistics.count(u64::from(self.w[k] > 0.0), self.laws_of(k));
        (0..3).for_each(|axis| self.called.0[axis][k] = 0.0);
        add_one(self.laws_of(k), at, k, x, v, &self.w, &mut self.called);
    }

    /// Acceleration by all laws at the time `at`, where [`Self::called`] has the sum of the called laws for the bodies that are
    /// `known`. Calls the laws for the others.
    #[inline(never)]
    pub fn laws_known(&mut self, at: EvaluationTime, x: X, v: X, known: &[bool; N]) -> X {
        if known.contains(&false) {
            x.read_both(v, |x, v| {
                (0..N).filter(|k| !known[*k]).for_each(|k| self.call_one(at, k, x, v));
            });
        }
        self.laws_from(&self.called, v)
    }

    /// `v` times a factor of damping.
    #[inline(never)]
    fn times(&self, v: X, factor: f64) -> X {
        let least = self.least;
        v.map(|_, _, v| snapped(v * factor, least))
    }

    fn evaluation_time(&self, part: f64) -> EvaluationTime {
        match self.segment {
            Some(segment) => segment.evaluation_time(part),
            None => EvaluationTime { time: 0.0, within_step: 0.0 },
        }
    }
}

/// Sets `w` to the inverse masses of `bodies`; the rest of the block is like its first body.
#[inline(always)]
fn load_inverse_masses<const N: usize>(w: &mut [f64; N], bodies: &[Row]) {
    if let Ok(bodies) = <&[Row; N]>::try_from(bodies) {
        (0..N).for_each(|k| w[k] = bodies[k][3]);
    } else {
        *w = [bodies[0][3]; N];
        w.iter_mut().zip(bodies).for_each(|(w, body)| *w = body[3]);
    }
}

/// `number`, or 0 if its magnitude is below `least`.
#[inline(always)]
fn snapped(number: f64, least: f64) -> f64 {
    // Not `number.abs() >= least`, which is false for NaN: NaN must stay, to be found.
    if number.abs() < least { 0.0 } else { number }
}

/// Body `k` of the states (`x`, `v`) and the inverse masses `w`.
fn body_of<const N: usize>(k: usize, x: &Block<N>, v: &Block<N>, w: &[f64; N]) -> BodyState {
    let [position, velocity] = [x, v].map(|block| Vector::from_array(block.body(k)));
    BodyState { position, velocity, inverse_mass: w[k] }
}

/// Adds the accelerations of body `k` by `laws` to `sum`.
fn add_one<'l, const N: usize>(
    laws: impl Iterator<Item = &'l dyn Law>,
    at: EvaluationTime,
    k: usize,
    x: &Block<N>,
    v: &Block<N>,
    w: &[f64; N],
    sum: &mut Block<N>,
) {
    if w[k] > 0.0 {
        let body = body_of(k, x, v, w);
        for law in laws {
            let a = law.acceleration(at, body).to_array();
            (0..3).for_each(|axis| sum.0[axis][k] += a[axis]);
        }
    }
}

impl<X: BlockSpace<N>, const N: usize> Field for BlockField<'_, X, N> {
    type Space = X;

    #[inline(always)]
    fn step(&self) -> f64 {
        self.h
    }

    #[inline(never)]
    fn laws(&mut self, part: f64, x: X, v: X) -> X {
        self.call(self.evaluation_time(part), x, v);
        self.laws_from(&self.called, v)
    }

    #[inline(never)]
    fn applied(&self) -> X {
        X::of(self.memory, &self.applied)
    }

    /// An acceleration by laws is never -0, so adding 0 would change no bits.
    #[inline(always)]
    fn plus_applied(&self, a: X) -> X {
        if self.pushed { a + self.applied() } else { a }
    }

    #[inline(never)]
    fn acceleration(&mut self, part: f64, x: X, v: X) -> X {
        let at = self.evaluation_time(part);
        if let Some(a) = self.acceleration_by_one(at, x, v) {
            return a;
        }
        self.call(at, x, v);
        if self.pushed {
            self.accelerated::<true>(&self.called, v)
        } else {
            self.laws_from(&self.called, v)
        }
    }

    #[inline(always)]
    fn depends_on_velocity(&self) -> bool {
        self.parameters.rate != 0.0 || self.calls_with_velocity
    }

    #[inline(always)]
    fn is_constant(&self) -> bool {
        self.linear_rate() == Some(0.0)
    }

    #[inline(never)]
    fn kick(&mut self, v: X, a: X) -> X {
        let Decay { keep, gain, .. } = self.decay;
        let least = if keep.is_some() || self.drags { self.least } else { 0.0 };
        let kicked = match keep {
            Some(keep) => v.zip(a, |_, _, [v, a]| snapped(v * keep + a * gain, least)),
            None if least == 0.0 => v + a * gain,
            None => v.zip(a, |_, _, [v, a]| snapped(v + a * gain, least)),
        };
        if self.statistics.record.is_some() {
            self.record_kick(v, a, kicked);
        }
        kicked
    }

    #[inline(always)]
    fn before_move(&mut self, v: X) -> X {
        self.damp_and_limit(v)
    }

    #[inline(always)]
    fn after_move(&mut self, v: X) -> X {
        self.damp(v, |decay| decay.after_move)
    }

    #[inline(always)]
    fn laws_before_jump(&mut self, x: X, v: X) -> Option<X> {
        let segment = self.segment.filter(|segment| segment.jump)?;
        let called = std::mem::replace(&mut self.called, Block::ZERO);
        self.call(segment.before(), x, v);
        let before = std::mem::replace(&mut self.called, called);
        Some(self.laws_from(&before, v))
    }

    #[inline(always)]
    fn implicit_velocity(&mut self, x: X, v: X) -> X {
        let solved = newton_velocity(self, x, v);
        self.record_solved(v, solved);
        solved
    }
}

impl<X: BlockSpace<N>, const N: usize> NewtonField for BlockField<'_, X, N> {
    #[inline(always)]
    fn linear_rate(&self) -> Option<f64> {
        (self.parameters.laws.is_empty() && self.options.laws.is_empty())
            .then_some(self.parameters.rate)
    }

    #[inline]
    fn correction(&mut self, x: X, v: X, residual: X) -> X {
        let (h, at, rate) = (self.h, self.evaluation_time(1.0), self.parameters.rate);
        let open = self.open;
        let (x, v, mut solved) = (x.read(|x| *x), v.read(|v| *v), residual.read(|r| *r));
        let immovable = self.w.map(|w| w <= 0.0);
        for k in (0..N).filter(|k| !immovable[*k]) {
            let body = body_of(k, &x, &v, &self.w);
            let (mut by_x, mut by_v) = (DMat3::ZERO, DMat3::IDENTITY * -rate);
            for law in self.laws_of(k) {
                let jacobians = law.jacobians(at, body);
                (by_x, by_v) = (by_x + jacobians.position, by_v + jacobians.velocity);
            }
            let slope = by_v * h + by_x * (h * h);
            let unit = |axis: usize| {
                let mut unit = [0.0; 3];
                unit[axis] = 1.0;
                unit
            };
            let columns = [0, 1, 2].map(|axis| {
                let column = (slope * Vector::from_array(unit(axis))).to_array();
                let unit = unit(axis);
                // Nothing accelerates along a closed axis, so no derivative is left there.
                let entry =
                    |row: usize| if open[row] { unit[row] - column[row] } else { unit[row] };
                Vector::from_array([0, 1, 2].map(entry))
            });
            let residual = Vector::from_array(solved.body(k));
            let parts = solve(columns, residual).to_array();
            (0..3).for_each(|axis| solved.0[axis][k] = parts[axis]);
        }
        X::of(self.memory, &solved)
    }

    #[inline(always)]
    fn size(&self, v: X) -> f64 {
        let mut size: f64 = 0.0;
        v.read(|v| {
            for part in (0..N).flat_map(|k| v.body(k)) {
                // NaN stays.
                size = if part.abs() <= size || size.is_nan() { size } else { part.abs() };
            }
        });
        size
    }

    fn report(&mut self, Newton { iterations, converged }: Newton) {
        // One body is solved at a time: an immovable one counts as no row.
        let all = &mut self.statistics.iterations;
        all.newton += u64::from(iterations) * self.movable;
        all.unconverged_steps += u64::from(!converged) * self.movable;
    }
}

/// Solves the equations with these columns by Cramer's rule: the next Newton iteration corrects its error for an
/// ill-conditioned matrix. The result is not finite if the matrix is singular.
fn solve([x, y, z]: [Vector; 3], right: Vector) -> Vector {
    let minors = Vector::new(y.cross(z).dot(right), z.cross(x).dot(right), x.cross(y).dot(right));
    minors * (1.0 / x.dot(y.cross(z)))
}

impl<X: BlockSpace<N>, const N: usize> TickField for BlockField<'_, X, N> {
    type Rows = [Row; N];

    fn enter<M: Integrator>(&mut self, segment: Segment, decay: Decay) {
        self.h = segment.length;
        self.segment = Some(segment);
        self.set_decay(decay);
    }

    fn recycle(&mut self, x: &mut X, v: &mut X, step_state: &mut StepState<Self>) {
        let start = step_state.start.unwrap_or(*v);
        let mut kept = [*x, *v, start];
        X::recycle(self.memory, &mut kept);
        [*x, *v, _] = kept;
        step_state.start = step_state.start.map(|_| kept[2]);
    }

    /// Snaps as the affine kernel does after each step, so that subnormal numbers are the same.
    #[inline(always)]
    fn after_step<M: Integrator>(&mut self, x: X, v: X, _: &mut StepState<Self>) -> (X, X) {
        (x, if M::DAMPS_INSIDE || !self.drags { v } else { self.snap(v) })
    }

    #[inline(always)]
    fn decayed(&mut self, v: X, factor: impl Fn(&Decay) -> Option<f64>) -> X {
        factor(&self.decay).map_or(v, |factor| self.times(v, factor))
    }

    #[inline(never)]
    fn restrain(&mut self, v: X) -> X {
        let BodyOptions { speed_limit, locks, .. } = *self.options;
        if speed_limit.is_none() && locks.is_none() {
            return v;
        }
        let mut block = v.read(|v| *v);
        for k in 0..N {
            let [x, y, z] = block.body(k);
            let mut row = [x, y, z, 0.0];
            restrain(&mut row, speed_limit, locks);
            (0..3).for_each(|axis| block.0[axis][k] = row[axis]);
        }
        X::of(self.memory, &block)
    }

    #[inline(always)]
    fn recorder(&mut self) -> &mut Option<Recorder> {
        &mut self.statistics.record
    }

    fn rows(&self, element: X) -> [Row; N] {
        element.read(Block::rows)
    }

    fn exact_damping(&self, _: usize) -> Option<f64> {
        self.decay.keep.map(|keep| self.h * (1.0 - keep) / self.decay.gain)
    }
}
