//! The field of a block of bodies, in registers.

use fearless_simd::{Simd, prelude::*};

use super::lanes::{Rows, each_row};
use super::{StepStatistics, Terms};
use crate::kernels::record::{Note, vector};
use crate::laws::damping::{Decay, Factor};
use crate::laws::tick_times::Segment;
use crate::laws::{BodyState, EvaluationTime, Law};
use crate::methods::{Field, Newton, NewtonField, newton_velocity};
use crate::real::{Lanes as _, Real, RealMatrix as _, RealVector as _};
use crate::state::components::AxisLocks;

/// Parts of the arithmetic that a kernel is compiled with; parts that are left out cost nothing.
pub(crate) mod parts {
    /// Exact damping inside the kick.
    pub const KEEP: u8 = 1;
    /// A factor before the move.
    pub const BEFORE: u8 = 2;
    /// A factor after the move.
    pub const AFTER: u8 = 4;
    /// Linear drag.
    pub const DRAG: u8 = 8;
    /// Laws that are called, and the options of single bodies.
    pub const CALLS: u8 = 16;
}

use parts::{AFTER, BEFORE, CALLS, DRAG, KEEP};

/// Numbers that are the same for every body of a batch, in registers: loaded once, because the compiler must assume
/// that stores of rows change memory.
pub(crate) struct Constants<T: Real, S: Simd> {
    simd: S,
    gravity: T::Lanes<S>,
    rate: T::Lanes<S>,
    keep: T::Lanes<S>,
    before: T::Lanes<S>,
    after: T::Lanes<S>,
    immovable: T::Lanes<S>,
    least: T::Lanes<S>,
    gain: T,
    h: T,
    /// Which of `KEEP`, `BEFORE`, `AFTER` and `DRAG` act.
    slows: u8,
}

impl<T: Real, S: Simd> Clone for Constants<T, S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Real, S: Simd> Copy for Constants<T, S> {}

impl<T: Real, S: Simd> Constants<T, S> {
    #[inline(always)]
    pub fn new(simd: S, terms: &Terms<'_, T>) -> Self {
        let three = |number: T, fourth: T| T::Lanes::of(simd, [number, number, number, fourth]);
        let [x, y, z] = terms.gravity.to_array();
        let mut constants = Self {
            simd,
            // Adding 0 turns -0 into 0: a row gets the same bits whether its block has a force or not.
            gravity: T::Lanes::of(simd, [x + T::ZERO, y + T::ZERO, z + T::ZERO, T::ZERO]),
            rate: three(terms.rate, T::ZERO),
            keep: three(T::ONE, T::ONE),
            before: three(T::ONE, T::ONE),
            after: three(T::ONE, T::ONE),
            // No inverse mass is above infinity, so the last lane, the inverse mass itself, is never accelerated.
            immovable: three(T::ZERO, T::INFINITY),
            least: three(T::ZERO, T::ZERO),
            slows: if terms.rate > T::ZERO { DRAG } else { 0 },
            gain: T::ZERO,
            h: terms.times.substep(),
        };
        constants.set_decay(terms.decay);
        constants
    }

    #[inline(always)]
    fn set_decay(&mut self, decay: Decay<T>) {
        let factor = |factor: Option<Factor<T>>| {
            let k = factor.map_or(T::ONE, |factor| factor.whole);
            T::Lanes::of(self.simd, [k, k, k, T::ONE])
        };
        (self.keep, self.before, self.after) =
            (factor(decay.keep), factor(decay.before_move), factor(decay.after_move));
        self.gain = decay.gain;
        let Decay { keep, before_move, after_move, .. } = decay;
        for (part, factor) in [(KEEP, keep), (BEFORE, before_move), (AFTER, after_move)] {
            self.slows = if factor.is_some() { self.slows | part } else { self.slows & !part };
        }
        // No inverse mass is below 0, so the last lane is never snapped; neither are velocities that do not decay.
        let least = if self.slows == 0 { T::ZERO } else { T::SNAP };
        self.least = T::Lanes::of(self.simd, [least, least, least, T::ZERO]);
    }

    /// Sets velocities that decayed below [`Real::SNAP`] to 0.
    #[inline(always)]
    pub fn snap<const N: usize>(&self, mut v: Rows<T, S, N>) -> Rows<T, S, N> {
        each_row!(k in N {
            // Not "unless it is at least": NaN must stay, to be found.
            v.0[k] = v.0[k].except(v.0[k].abs().simd_lt(self.least));
        });
        v
    }

    #[inline(always)]
    fn times<const N: usize>(&self, mut v: Rows<T, S, N>, factor: T::Lanes<S>) -> Rows<T, S, N> {
        each_row!(k in N {
            v.0[k] *= factor;
        });
        self.snap(v)
    }
}

/// The options of a body, and the laws that are called.
pub(crate) struct Calls<'a, T: Real> {
    /// Laws of every body, besides gravity and linear drag.
    pub laws: &'a [&'a dyn Law<T>],
    /// The body's own laws.
    pub own: &'a [Box<dyn Law<T>>],
    pub limit: Option<T>,
    pub locks: Option<AxisLocks>,
    /// Axes along which nothing accelerates the body.
    pub closed: Option<AxisLocks>,
    pub statistics: &'a mut StepStatistics,
    /// Movable bodies of the block, which are counted.
    pub rows: u64,
}

/// Applies a speed limit and axis locks to a row.
pub(crate) fn restrain<T: Real>([x, y, z, _]: &mut [T; 4], limit: Option<T>, locks: Option<AxisLocks>) {
    if let Some(limit) = limit {
        // Not by the sum of squares, which overflows for speeds that are still finite.
        let speed = x.hypot(*y).hypot(*z);
        // Not "if above": a limit of NaN must be found, not skipped.
        if !speed.is_at_most(limit) {
            let factor = limit / speed;
            (*x, *y, *z) = (*x * factor, *y * factor, *z * factor);
        }
    }
    if let Some(locks) = locks {
        for (v, locked) in [(x, locks.x), (y, locks.y), (z, locks.z)] {
            if locked {
                *v = T::ZERO;
            }
        }
    }
}

/// The field of the `N` bodies of a block.
pub(crate) struct BlockField<'a, T: Real, S: Simd, const N: usize, const PARTS: u8, const PUSHED: bool> {
    pub constants: Constants<T, S>,
    movable: [<T::Lanes<S> as SimdBase<S>>::Mask; N],
    applied: Rows<T, S, N>,
    depends_on_velocity: bool,
    linear: Option<T>,
    calls: Option<Calls<'a, T>>,
    segment: Option<Segment<T>>,
    /// Sum of the called laws in the last evaluation.
    pub called: Rows<T, S, N>,
}

impl<'a, T: Real, S: Simd, const N: usize, const PARTS: u8, const PUSHED: bool>
    BlockField<'a, T, S, N, PARTS, PUSHED>
{
    /// The field of `bodies`, (velocity, inverse mass) each, with `forces` if they are pushed.
    #[inline(always)]
    pub fn new(
        mut constants: Constants<T, S>,
        terms: &Terms<'_, T>,
        bodies: &[[T; 4]; N],
        forces: Option<&Rows<T, S, N>>,
        calls: Option<Calls<'a, T>>,
    ) -> Self {
        let simd = constants.simd;
        let zero = Rows::splat(T::Lanes::splat(simd, T::ZERO));
        let mut least = constants.immovable;
        if PARTS & CALLS != 0
            && let Some(Calls { closed: Some(AxisLocks { x, y, z }), .. }) = calls
        {
            // Along a closed axis nothing is accelerated: no inverse mass is above infinity.
            let zero_or_infinity = |locked: bool| if locked { T::INFINITY } else { T::ZERO };
            let [x, y, z] = [x, y, z].map(zero_or_infinity);
            least = T::Lanes::of(simd, [x, y, z, T::INFINITY]);
        }
        // A selection, not a factor: NaN times 0 would be NaN.
        let mut movable = [least.simd_gt(least); N];
        let mut applied = zero;
        each_row!(k in N {
            // From memory: broadcasting a lane of a register takes shuffles.
            let w = T::Lanes::splat(simd, bodies[k][3]);
            movable[k] = w.simd_gt(least);
            if PUSHED && let Some(forces) = forces {
                applied.0[k] = (forces.0[k] * w).only(movable[k]);
            }
        });
        let (mut depends_on_velocity, mut linear) = (PARTS & DRAG != 0, Some(terms.rate));
        if PARTS & CALLS != 0
            && let Some(calls) = &calls
        {
            let called = terms.calls_with_velocity(calls.own);
            depends_on_velocity = terms.rate != T::ZERO || called;
            // Makes every segment snap.
            constants.slows |= if called { DRAG } else { 0 };
            linear = (terms.laws.is_empty() && calls.own.is_empty()).then_some(terms.rate);
        }
        Self { constants, movable, applied, depends_on_velocity, linear, calls, segment: None, called: zero }
    }

    /// Whether velocities decay in this way. Known at compile time except in kernels with calls, where bodies differ.
    #[inline(always)]
    const fn decays(&self, part: u8) -> bool {
        (if PARTS & CALLS == 0 { PARTS } else { self.constants.slows }) & part != 0
    }

    /// Enters a segment of the tick. Only kernels with calls have segments.
    pub fn set_segment(&mut self, segment: Segment<T>, decay: Decay<T>) {
        self.constants.h = segment.length;
        self.constants.set_decay(decay);
        self.segment = Some(segment);
    }

    /// Acceleration by gravity and linear drag.
    #[inline(always)]
    fn affine(&self, v: Rows<T, S, N>) -> Rows<T, S, N> {
        let mut a = Rows::splat(self.constants.gravity);
        if PARTS & (DRAG | CALLS) != 0 {
            each_row!(k in N {
                a.0[k] -= v.0[k] * self.constants.rate;
            });
        }
        a
    }

    #[inline(always)]
    fn movable(&self, mut a: Rows<T, S, N>) -> Rows<T, S, N> {
        each_row!(k in N {
            a.0[k] = a.0[k].only(self.movable[k]);
        });
        a
    }

    /// Acceleration by all laws, from the sum of the called ones.
    #[inline(always)]
    pub fn laws_from(&self, called: Rows<T, S, N>, v: Rows<T, S, N>) -> Rows<T, S, N> {
        self.movable(self.affine(v) + called)
    }

    /// Sums the called laws at the time `at`.
    fn call(&mut self, at: EvaluationTime<T>, x: Rows<T, S, N>, v: Rows<T, S, N>) -> Rows<T, S, N> {
        let mut sum = [[T::ZERO; 4]; N];
        if let Some(Calls { laws, own, statistics, rows, .. }) = &mut self.calls {
            let (x, v) = (x.rows(), v.rows());
            statistics.accelerations += *rows;
            for (law, calls) in laws.iter().zip(statistics.calls.as_mut_slice()) {
                law.accelerate(at, &x, &v, &mut sum);
                *calls += *rows;
            }
            for law in *own {
                law.accelerate(at, &x, &v, &mut sum);
                statistics.count_own(law.name(), *rows);
            }
        }
        Rows::of(self.constants.simd, &sum)
    }

    /// Applies speed limit and axis locks.
    pub fn restrain(&self, v: Rows<T, S, N>) -> Rows<T, S, N> {
        let Some(Calls { limit, locks, .. }) = &self.calls else { return v };
        let mut rows = v.rows();
        rows.iter_mut().for_each(|row| restrain(row, *limit, *locks));
        Rows::of(self.constants.simd, &rows)
    }

    /// Applies and records speed limit and axis locks.
    pub fn limited(&mut self, v: Rows<T, S, N>) -> Rows<T, S, N> {
        let limited = self.restrain(v);
        self.record_change(v, limited, &|record, _, from, to| record.limits.turn(from, to));
        limited
    }

    /// Records a change of velocities, if a ledger wants it. Only kernels with calls do.
    #[inline(always)]
    pub fn record_change(&mut self, from: Rows<T, S, N>, to: Rows<T, S, N>, note: Note<'_>) {
        if PARTS & CALLS != 0
            && let Some(Calls { statistics, .. }) = &mut self.calls
            && let Some(record) = &mut statistics.record
        {
            record.note(&from.rows(), &to.rows(), note);
        }
    }

    /// Records a kick.
    #[inline(always)]
    fn record_kick(&mut self, v: Rows<T, S, N>, a: Rows<T, S, N>, kicked: Rows<T, S, N>) {
        if PARTS & CALLS == 0 {
            return;
        }
        let Constants { keep, gain, h, .. } = self.constants;
        let h = h.to_f64();
        if self.decays(KEEP) {
            let q = h * (1.0 - keep.row()[0].to_f64()) / gain.to_f64();
            let a = a.rows();
            self.record_change(v, kicked, &|record, k, from, to| {
                record.damped_kick(h, q, vector(&a[k]), from, to);
            });
        } else {
            self.record_change(v, kicked, &|record, _, from, to| record.kick(h, from, to));
        }
    }

    /// Applies the factor before the move.
    #[inline(always)]
    pub fn decay_before(&self, v: Rows<T, S, N>) -> Rows<T, S, N> {
        self.constants.times(v, self.constants.before)
    }

    /// Applies the factor after the move.
    #[inline(always)]
    pub fn decay_after(&self, v: Rows<T, S, N>) -> Rows<T, S, N> {
        self.constants.times(v, self.constants.after)
    }

    /// Snaps velocities if there is drag.
    #[inline(always)]
    pub fn snap_drag(&self, v: Rows<T, S, N>) -> Rows<T, S, N> {
        if self.constants.slows & DRAG == 0 { v } else { self.constants.snap(v) }
    }

    fn evaluation_time(&self, part: T) -> EvaluationTime<T> {
        match self.segment {
            Some(segment) => segment.evaluation_time(part),
            None => EvaluationTime { time: T::ZERO, within_step: T::ZERO },
        }
    }
}

impl<T: Real, S: Simd, const N: usize, const PARTS: u8, const PUSHED: bool> Field
    for BlockField<'_, T, S, N, PARTS, PUSHED>
{
    type Real = T;
    type Space = Rows<T, S, N>;

    #[inline(always)]
    fn step(&self) -> T {
        self.constants.h
    }

    #[inline(always)]
    fn laws(&mut self, part: T, x: Self::Space, v: Self::Space) -> Self::Space {
        if PARTS & CALLS == 0 {
            return self.movable(self.affine(v));
        }
        self.called = self.call(self.evaluation_time(part), x, v);
        self.laws_from(self.called, v)
    }

    #[inline(always)]
    fn applied(&self) -> Self::Space {
        self.applied
    }

    #[inline(always)]
    fn acceleration(&mut self, part: T, x: Self::Space, v: Self::Space) -> Self::Space {
        let laws = self.laws(part, x, v);
        if PUSHED { laws + self.applied } else { laws }
    }

    #[inline(always)]
    fn depends_on_velocity(&self) -> bool {
        self.depends_on_velocity
    }

    #[inline(always)]
    fn is_constant(&self) -> bool {
        PARTS & (CALLS | DRAG) == 0 || self.linear == Some(T::ZERO)
    }

    #[inline(always)]
    fn kick(&mut self, v: Self::Space, a: Self::Space) -> Self::Space {
        let mut kicked = v;
        let Constants { keep, gain, .. } = self.constants;
        each_row!(k in N {
            let kept = if self.decays(KEEP) { v.0[k] * keep } else { v.0[k] };
            kicked.0[k] = kept + a.0[k] * gain;
        });
        let kicked = if self.decays(KEEP | DRAG) { self.constants.snap(kicked) } else { kicked };
        self.record_kick(v, a, kicked);
        kicked
    }

    #[inline(always)]
    fn before_move(&mut self, v: Self::Space) -> Self::Space {
        let decayed = if self.decays(BEFORE) { self.decay_before(v) } else { v };
        self.record_change(v, decayed, &|record, _, from, to| record.damping.turn(from, to));
        if PARTS & CALLS == 0 { decayed } else { self.limited(decayed) }
    }

    #[inline(always)]
    fn after_move(&mut self, v: Self::Space) -> Self::Space {
        let decayed = if self.decays(AFTER) { self.decay_after(v) } else { v };
        self.record_change(v, decayed, &|record, _, from, to| record.damping.turn(from, to));
        decayed
    }

    #[inline(always)]
    fn laws_before_jump(&mut self, x: Self::Space, v: Self::Space) -> Option<Self::Space> {
        if PARTS & CALLS == 0 {
            return None;
        }
        let segment = self.segment.filter(|segment| segment.jump)?;
        let called = self.call(segment.before(), x, v);
        Some(self.laws_from(called, v))
    }

    #[inline(always)]
    fn implicit_velocity(&mut self, x: Self::Space, v: Self::Space) -> Self::Space {
        let solved = newton_velocity(self, x, v);
        let h = self.constants.h.to_f64();
        self.record_change(v, solved, &|record, _, from, to| record.kick(h, from, to));
        solved
    }
}

impl<T: Real, S: Simd, const N: usize, const PARTS: u8, const PUSHED: bool> NewtonField
    for BlockField<'_, T, S, N, PARTS, PUSHED>
{
    #[inline(always)]
    fn linear_rate(&self) -> Option<T> {
        self.linear
    }

    fn correction(&mut self, x: Self::Space, v: Self::Space, residual: Self::Space) -> Self::Space {
        let (h, at) = (self.constants.h, self.evaluation_time(T::ONE));
        let (x, v, mut rows) = (x.rows(), v.rows(), residual.rows());
        let rate = self.constants.rate.row()[0];
        let Some(Calls { laws, own, closed, .. }) = &self.calls else { return residual };
        let open = closed.map_or([true; 3], |closed| [!closed.x, !closed.y, !closed.z]);
        for k in 0..N {
            let body = BodyState::of_rows(&x[k], &v[k]);
            if body.inverse_mass.is_at_most(T::ZERO) {
                continue;
            }
            let (mut by_x, mut by_v) = (T::Matrix::ZERO, T::Matrix::IDENTITY * -rate);
            for law in laws.iter().copied().chain(own.iter().map(|law| &**law)) {
                let jacobians = law.jacobians(at, body);
                (by_x, by_v) = (by_x + jacobians.position, by_v + jacobians.velocity);
            }
            let slope = by_v * h + by_x * (h * h);
            let unit = |axis: usize| {
                let mut unit = [T::ZERO; 3];
                unit[axis] = T::ONE;
                unit
            };
            let columns = [0, 1, 2].map(|axis| {
                let column = slope.times(T::Vector::from_array(unit(axis))).to_array();
                let unit = unit(axis);
                // Nothing accelerates along a closed axis, so no derivative is left there.
                let entry = |row: usize| if open[row] { unit[row] - column[row] } else { unit[row] };
                T::Vector::from_array([0, 1, 2].map(entry))
            });
            let residual = T::Vector::from_array([rows[k][0], rows[k][1], rows[k][2]]);
            let [dx, dy, dz] = T::Matrix::from_columns(columns).solve(residual).to_array();
            rows[k] = [dx, dy, dz, T::ZERO];
        }
        Rows::of(self.constants.simd, &rows)
    }

    #[inline(always)]
    fn size(&self, v: Self::Space) -> T {
        let mut size = T::ZERO;
        for [x, y, z, _] in v.rows() {
            for part in [x, y, z] {
                // NaN stays.
                if !part.abs().is_at_most(size) && size.is_at_most(size) {
                    size = part.abs();
                }
            }
        }
        size
    }

    fn report(&mut self, Newton { iterations, converged }: Newton) {
        // One body is solved at a time: an immovable one counts as no row.
        if let Some(Calls { statistics, rows, .. }) = &mut self.calls {
            statistics.iterations.newton += u64::from(iterations) * *rows;
            statistics.iterations.unconverged_steps += u64::from(!converged) * *rows;
        }
    }
}
