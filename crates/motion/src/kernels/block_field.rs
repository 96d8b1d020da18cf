//! The field of a block of bodies with laws that are called.

use std::any::Any;

use super::block::Block;
use super::drive::TickField;
use super::record::{Note, TickRecord, vector};
use super::{BodyOptions, StepStatistics, Terms, restrain};
use crate::laws::damping::Decay;
use crate::laws::tick_times::Segment;
use crate::laws::{BodyBlock, BodyState, EvaluationTime, Law};
use crate::methods::{Field, Integrator, Newton, NewtonField, StepState, newton_velocity};
use crate::real::{Real, RealMatrix as _, RealVector as _};
use crate::state::components::AxisLocks;

/// The field of the `N` bodies of a block.
pub(super) struct BlockField<'a, T: Real, const N: usize> {
    terms: &'a Terms<'a, T>,
    options: &'a BodyOptions<'a, T>,
    /// Axes along which nothing accelerates the bodies.
    closed: Option<AxisLocks>,
    gravity: [T; 3],
    decay: Decay<T>,
    h: T,
    segment: Option<Segment<T>>,
    /// Whether drag or a law that is called slows bodies.
    drags: bool,
    /// Magnitude below which velocities snap to 0.
    least: T,
    depends_on_velocity: bool,
    w: [T; N],
    /// What an inverse mass must be above for the body to be accelerated along an axis: 0, or infinity if it is closed.
    least_w: [T; 3],
    applied: Block<T, N>,
    /// Sum of the called laws in the last evaluation.
    pub called: Block<T, N>,
    statistics: &'a mut StepStatistics,
    /// Movable bodies of the block, which are counted.
    movable: u64,
}

impl<'a, T: Real, const N: usize> BlockField<'a, T, N> {
    /// The field of bodies of the inverse masses `w`, pushed by `forces`; `movable` of them can be accelerated.
    #[inline(always)]
    pub fn new(
        terms: &'a Terms<'a, T>,
        options: &'a BodyOptions<'a, T>,
        closed: Option<AxisLocks>,
        statistics: &'a mut StepStatistics,
        (w, forces): ([T; N], Block<T, N>),
        movable: u64,
    ) -> Self {
        let (infinite, none) = (T::INFINITY, T::ZERO);
        let least_w = closed.map_or([none; 3], |AxisLocks { x, y, z }| {
            [x, y, z].map(|locked| if locked { infinite } else { none })
        });
        let called = terms.calls_with_velocity(options.laws);
        let mut field = Self {
            terms,
            options,
            closed,
            // Adding 0 turns -0 into 0: a row gets the same bits whether its block has a force or not.
            gravity: terms.gravity.to_array().map(|g| g + T::ZERO),
            decay: terms.decay,
            h: terms.times.substep(),
            segment: None,
            drags: terms.rate > T::ZERO,
            least: T::ZERO,
            depends_on_velocity: terms.rate != T::ZERO || called,
            w,
            least_w,
            applied: Block::ZERO,
            called: Block::ZERO,
            statistics,
            movable,
        };
        field.set_decay(terms.decay);
        // Only now: what precedes the tick snaps only where something linear slows.
        field.drags |= called;
        field.applied = field.movable(forces.map(|_, k, force| force * field.w[k]));
        field
    }

    fn set_decay(&mut self, decay: Decay<T>) {
        self.decay = decay;
        let decays = decay.keep.is_some() || decay.before_move.is_some() || decay.after_move.is_some();
        self.least = if decays || self.drags { T::SNAP } else { T::ZERO };
    }

    /// Enters a segment of the tick.
    pub fn set_segment(&mut self, segment: Segment<T>, decay: Decay<T>) {
        self.h = segment.length;
        self.segment = Some(segment);
        self.set_decay(decay);
    }

    #[inline(always)]
    pub fn inverse_mass(&self, k: usize) -> T {
        self.w[k]
    }

    /// Sets velocities that decayed below [`Real::SNAP`] to 0.
    #[inline(always)]
    pub fn snap(&self, v: Block<T, N>) -> Block<T, N> {
        // Not "unless it is at least": NaN must stay, to be found.
        v.map(|_, _, v| if v.abs() < self.least { T::ZERO } else { v })
    }

    /// Sets the acceleration of what cannot be accelerated to 0. A selection, not a factor: NaN times 0 would be NaN.
    #[inline(always)]
    fn movable(&self, a: Block<T, N>) -> Block<T, N> {
        a.map(|axis, k, a| if self.w[k] > self.least_w[axis] { a } else { T::ZERO })
    }

    /// Acceleration by all laws, from the sum of the called ones.
    #[inline(always)]
    pub fn laws_from(&self, called: &Block<T, N>, v: &Block<T, N>) -> Block<T, N> {
        let rate = self.terms.rate;
        self.movable(v.map(|axis, k, v| (self.gravity[axis] - v * rate) + called.0[axis][k]))
    }

    /// The laws that are called, and whether each is one of all bodies.
    fn called_laws(&self) -> impl Iterator<Item = &'a dyn Law<T>> + use<'a, T, N> {
        let own: &'a [Box<dyn Law<T>>] = self.options.laws;
        self.terms.laws.iter().copied().chain(own.iter().map(|law| &**law))
    }

    fn count(&mut self, bodies: u64) {
        self.statistics.accelerations += bodies;
        self.statistics.calls.iter_mut().for_each(|calls| *calls += bodies);
        for law in self.options.laws {
            self.statistics.count_own(law.name(), bodies);
        }
    }

    /// Sums the called laws at the time `at`.
    #[inline(never)]
    fn call(&mut self, at: EvaluationTime<T>, x: &Block<T, N>, v: &Block<T, N>) {
        self.count(self.movable);
        let mut called = Block::ZERO;
        let w: &dyn Any = &self.w;
        if let (Some(positions), Some(velocities), Some(inverse_masses), Some(sum)) =
            (x.axes(), v.axes(), w.downcast_ref(), called.axes_mut())
        {
            let bodies = BodyBlock { positions, velocities, inverse_masses };
            self.called_laws().for_each(|law| law.accelerate(at, &bodies, sum));
        } else {
            (0..N).for_each(|k| self.add_one(at, k, (x, v), &mut called));
        }
        self.called = called;
    }

    /// Sums the called laws of body `k` alone, and counts them.
    pub fn call_one(
        &mut self,
        at: EvaluationTime<T>,
        k: usize,
        state: (&Block<T, N>, &Block<T, N>),
        sum: &mut Block<T, N>,
    ) {
        self.count(u64::from(self.w[k] > T::ZERO));
        (0..3).for_each(|axis| sum.0[axis][k] = T::ZERO);
        self.add_one(at, k, state, sum);
    }

    fn add_one(
        &self,
        at: EvaluationTime<T>,
        k: usize,
        (x, v): (&Block<T, N>, &Block<T, N>),
        sum: &mut Block<T, N>,
    ) {
        if self.w[k] > T::ZERO {
            let body = self.body(k, x, v);
            for law in self.called_laws() {
                let a = law.acceleration(at, body).to_array();
                (0..3).for_each(|axis| sum.0[axis][k] += a[axis]);
            }
        }
    }

    fn body(&self, k: usize, x: &Block<T, N>, v: &Block<T, N>) -> BodyState<T> {
        let [position, velocity] = [x, v].map(|block| T::Vector::from_array(block.body(k)));
        BodyState { position, velocity, inverse_mass: self.w[k] }
    }

    /// Applies speed limit and axis locks.
    #[inline(always)]
    pub fn restrain(&self, v: Block<T, N>) -> Block<T, N> {
        let BodyOptions { speed_limit, locks, .. } = *self.options;
        if speed_limit.is_none() && locks.is_none() {
            return v;
        }
        let mut restrained = v;
        for k in 0..N {
            let [x, y, z] = v.body(k);
            let mut row = [x, y, z, T::ZERO];
            restrain(&mut row, speed_limit.map(T::of), locks);
            (0..3).for_each(|axis| restrained.0[axis][k] = row[axis]);
        }
        restrained
    }

    /// Applies and records speed limit and axis locks.
    #[inline(always)]
    fn limited(&mut self, v: Block<T, N>) -> Block<T, N> {
        let limited = self.restrain(v);
        self.record_change(&v, &limited, &|record, _, from, to| record.limits.turn(from, to));
        limited
    }

    /// Records a change of velocities, if a ledger wants it.
    #[inline(always)]
    fn record_change(&mut self, from: &Block<T, N>, to: &Block<T, N>, note: Note<'_>) {
        if let Some(record) = &mut self.statistics.record {
            record.note(&from.rows(), &to.rows(), note);
        }
    }

    #[cold]
    fn record_kick(&mut self, v: &Block<T, N>, a: &Block<T, N>, kicked: &Block<T, N>) {
        let h = self.h.to_f64();
        let Some(keep) = self.decay.keep else {
            self.record_change(v, kicked, &|record, _, from, to| record.kick(h, from, to));
            return;
        };
        let q = h * (1.0 - keep.whole.to_f64()) / self.decay.gain.to_f64();
        let a = a.rows();
        let damped = |record: &mut TickRecord, k: usize, from, to| {
            record.damped_kick(h, q, vector(&a[k]), from, to);
        };
        self.record_change(v, kicked, &damped);
    }

    /// `v` times a factor of damping.
    #[inline(always)]
    fn times(&self, v: Block<T, N>, factor: T) -> Block<T, N> {
        self.snap(v * factor)
    }

    fn evaluation_time(&self, part: T) -> EvaluationTime<T> {
        match self.segment {
            Some(segment) => segment.evaluation_time(part),
            None => EvaluationTime { time: T::ZERO, within_step: T::ZERO },
        }
    }
}

impl<T: Real, const N: usize> Field for BlockField<'_, T, N> {
    type Real = T;
    type Space = Block<T, N>;

    #[inline(always)]
    fn step(&self) -> T {
        self.h
    }

    #[inline(always)]
    fn laws(&mut self, part: T, x: Self::Space, v: Self::Space) -> Self::Space {
        self.call(self.evaluation_time(part), &x, &v);
        self.laws_from(&self.called, &v)
    }

    #[inline(always)]
    fn applied(&self) -> Self::Space {
        self.applied
    }

    /// In one pass.
    #[inline(always)]
    fn acceleration(&mut self, part: T, x: Self::Space, v: Self::Space) -> Self::Space {
        self.call(self.evaluation_time(part), &x, &v);
        let rate = self.terms.rate;
        v.map(|axis, k, v| {
            let laws = (self.gravity[axis] - v * rate) + self.called.0[axis][k];
            (if self.w[k] > self.least_w[axis] { laws } else { T::ZERO }) + self.applied.0[axis][k]
        })
    }

    #[inline(always)]
    fn depends_on_velocity(&self) -> bool {
        self.depends_on_velocity
    }

    #[inline(always)]
    fn is_constant(&self) -> bool {
        self.linear_rate() == Some(T::ZERO)
    }

    #[inline(always)]
    fn kick(&mut self, v: Self::Space, a: Self::Space) -> Self::Space {
        let Decay { keep, gain, .. } = self.decay;
        let kicked = match keep {
            Some(keep) => v.map(|axis, k, v| v * keep.whole + a.0[axis][k] * gain),
            None => v.map(|axis, k, v| v + a.0[axis][k] * gain),
        };
        let kicked = if keep.is_some() || self.drags { self.snap(kicked) } else { kicked };
        if self.statistics.record.is_some() {
            self.record_kick(&v, &a, &kicked);
        }
        kicked
    }

    #[inline(always)]
    fn before_move(&mut self, v: Self::Space) -> Self::Space {
        let decayed = self.decay.before_move.map_or(v, |factor| self.times(v, factor.whole));
        self.record_change(&v, &decayed, &|record, _, from, to| record.damping.turn(from, to));
        self.limited(decayed)
    }

    #[inline(always)]
    fn after_move(&mut self, v: Self::Space) -> Self::Space {
        let decayed = self.decay.after_move.map_or(v, |factor| self.times(v, factor.whole));
        self.record_change(&v, &decayed, &|record, _, from, to| record.damping.turn(from, to));
        decayed
    }

    #[inline(always)]
    fn laws_before_jump(&mut self, x: Self::Space, v: Self::Space) -> Option<Self::Space> {
        let segment = self.segment.filter(|segment| segment.jump)?;
        let called = std::mem::replace(&mut self.called, Block::ZERO);
        self.call(segment.before(), &x, &v);
        let before = std::mem::replace(&mut self.called, called);
        Some(self.laws_from(&before, &v))
    }

    #[inline(always)]
    fn implicit_velocity(&mut self, x: Self::Space, v: Self::Space) -> Self::Space {
        let solved = newton_velocity(self, x, v);
        let h = self.h.to_f64();
        self.record_change(&v, &solved, &|record, _, from, to| record.kick(h, from, to));
        solved
    }
}

impl<T: Real, const N: usize> NewtonField for BlockField<'_, T, N> {
    #[inline(always)]
    fn linear_rate(&self) -> Option<T> {
        (self.terms.laws.is_empty() && self.options.laws.is_empty()).then_some(self.terms.rate)
    }

    fn correction(&mut self, x: Self::Space, v: Self::Space, residual: Self::Space) -> Self::Space {
        let (h, at, rate) = (self.h, self.evaluation_time(T::ONE), self.terms.rate);
        let open = self.closed.map_or([true; 3], |closed| [!closed.x, !closed.y, !closed.z]);
        let mut solved = residual;
        for k in (0..N).filter(|k| !self.w[*k].is_at_most(T::ZERO)) {
            let body = self.body(k, &x, &v);
            let (mut by_x, mut by_v) = (T::Matrix::ZERO, T::Matrix::IDENTITY * -rate);
            for law in self.called_laws() {
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
            let residual = T::Vector::from_array(residual.body(k));
            let parts = T::Matrix::from_columns(columns).solve(residual).to_array();
            (0..3).for_each(|axis| solved.0[axis][k] = parts[axis]);
        }
        solved
    }

    #[inline(always)]
    fn size(&self, v: Self::Space) -> T {
        let mut size = T::ZERO;
        for k in 0..N {
            for part in v.body(k) {
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
        let all = &mut self.statistics.iterations;
        all.newton += u64::from(iterations) * self.movable;
        all.unconverged_steps += u64::from(!converged) * self.movable;
    }
}

impl<T: Real, const N: usize> TickField for BlockField<'_, T, N> {
    fn enter<M: Integrator>(&mut self, segment: Segment<T>, decay: Decay<T>) {
        self.set_segment(segment, decay);
    }

    #[inline(always)]
    fn before_tick(&mut self, x: Self::Space, v: Self::Space) -> (Self::Space, Self::Space) {
        let v = self.before_move(v);
        self.record_change(&v, &v, &|record, _, v, _| record.begin(v));
        (x, v)
    }

    /// As the affine kernel after each of its steps, so that subnormal numbers are the same.
    #[inline(always)]
    fn after_step<M: Integrator>(
        &mut self,
        x: Self::Space,
        v: Self::Space,
        _: &mut StepState<Self>,
    ) -> (Self::Space, Self::Space) {
        (x, if M::DAMPS_INSIDE || !self.drags { v } else { self.snap(v) })
    }

    #[inline(always)]
    fn after_tick(&mut self, x: Self::Space, v: Self::Space) -> (Self::Space, Self::Space) {
        self.record_change(&v, &v, &|record, _, v, _| record.end(v));
        let decayed = self.after_move(v);
        (x, self.limited(decayed))
    }
}
