//! Compensated sums: the rounding error of the state is stored beside it and added with the next increment.

use std::ops::{Add, Mul, Neg, Sub};

use super::Terms;
use super::block::{Block, BlockSpace};
use super::block_field::BlockField;
use super::drive::{TickField, drive};
use crate::laws::damping::Decay;
use crate::laws::tick_times::{Segment, Segments};
use crate::methods::{Field, Integrator, Newton, NewtonField, StepState, newton_velocity};
use crate::real::Real;

/// `a + b` and its exact rounding error (Knuth 1969, section 4.2.2).
#[inline(always)]
fn two_sum<X: Copy + Add<Output = X> + Sub<Output = X>>(a: X, b: X) -> (X, X) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// The sum and the residue of `sum + residue + more + left`: a compensated addition (Kahan 1965; Neumaier 1974) of an
/// increment that may itself have a residue, `left`. The residue is at most half a rounding of the sum.
#[inline(always)]
pub(crate) fn add_compensated<X: Copy + Add<Output = X> + Sub<Output = X>>(
    (sum, residue): (X, X),
    (more, left): (X, X),
) -> (X, X) {
    let (sum, lost) = two_sum(sum, more);
    let residue = residue + left + lost;
    let total = sum + residue;
    (total, residue - (total - sum))
}

/// Bodies and their residues.
#[derive(Clone, Copy)]
struct Compensated<X> {
    sum: X,
    residue: X,
}

impl<X: Copy + Add<Output = X> + Sub<Output = X>> Add for Compensated<X> {
    type Output = Self;

    // Not inlined: every method would contain many copies.
    #[inline(never)]
    fn add(self, other: Self) -> Self {
        let (sum, residue) = add_compensated((self.sum, self.residue), (other.sum, other.residue));
        Self { sum, residue }
    }
}

impl<X: Copy + Add<Output = X> + Sub<Output = X> + Neg<Output = X>> Sub for Compensated<X> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + Self { sum: -other.sum, residue: -other.residue }
    }
}

impl<T: Copy, X: Mul<T, Output = X>> Mul<T> for Compensated<X> {
    type Output = Self;

    fn mul(self, factor: T) -> Self {
        Self { sum: self.sum * factor, residue: self.residue * factor }
    }
}

/// The field of a block whose states are compensated sums; laws see the sums.
struct CompensatedField<'f, 'a, T: Real, X: BlockSpace<T, N>, const N: usize> {
    inner: &'f mut BlockField<'a, T, X, N>,
    decay: Decay<T>,
    zero: X,
}

/// [`drive`] in compensated sums; `residues` are those of (`x`, `v`), and then those of the new state.
pub(super) fn drive_compensated<'a, M: Integrator, T: Real, X: BlockSpace<T, N>, const N: usize>(
    field: &mut BlockField<'a, T, X, N>,
    terms: &Terms<'_, T>,
    segments: &Segments,
    (x, v): (X, X),
    residues: [&mut [[T; 3]]; 2],
    step_state: &mut StepState<BlockField<'a, T, X, N>>,
) -> (X, X) {
    let memory = field.memory;
    let [rx, rv] = residues.each_ref().map(|rows| X::load(memory, |block| block.load(rows)));
    let (x, v) = (Compensated { sum: x, residue: rx }, Compensated { sum: v, residue: rv });
    let zero = X::of(memory, &Block::ZERO);
    let mut field = CompensatedField { inner: field, decay: terms.decay, zero };
    let start = step_state.start.map(|start| field.exact(start));
    let mut own = StepState { last_step: step_state.last_step, start };
    let (x, v) = drive::<M, _>(&mut field, terms, segments, x, v, &mut own);
    for (rows, residue) in residues.into_iter().zip([x.residue, v.residue]) {
        residue.read(|block| rows.iter_mut().enumerate().for_each(|(k, row)| *row = block.body(k)));
    }
    (step_state.last_step, step_state.start) = (own.last_step, own.start.map(|start| start.sum));
    (x.sum, v.sum)
}

impl<T: Real, X: BlockSpace<T, N>, const N: usize> CompensatedField<'_, '_, T, X, N> {
    /// `sum` without a residue.
    const fn exact(&self, sum: X) -> Compensated<X> {
        Compensated { sum, residue: self.zero }
    }

    /// `v` times a factor, given as the factor minus 1: rounding the factor itself would add the same error in every
    /// step.
    fn changed(&self, v: Compensated<X>, change: Option<T>) -> Compensated<X> {
        let Some(change) = change else { return v };
        self.snap(v + v * change)
    }

    fn snap(&self, v: Compensated<X>) -> Compensated<X> {
        Compensated { sum: self.inner.snap(v.sum), residue: self.inner.snap(v.residue) }
    }

    /// Applies speed limits and axis locks.
    fn restrain(&self, v: Compensated<X>) -> Compensated<X> {
        let sum = self.inner.restrain(v.sum);
        let same = v.sum.read_both(sum, |before, after| {
            std::array::from_fn::<_, N, _>(|k| before.body(k) == after.body(k))
        });
        let residue = v.residue.map(|_, k, residue| if same[k] { residue } else { T::ZERO });
        Compensated { sum, residue }
    }
}

impl<T: Real, X: BlockSpace<T, N>, const N: usize> Field for CompensatedField<'_, '_, T, X, N> {
    type Real = T;
    type Space = Compensated<X>;

    fn step(&self) -> T {
        self.inner.step()
    }

    fn laws(&mut self, part: T, x: Self::Space, v: Self::Space) -> Self::Space {
        let laws = self.inner.laws(part, x.sum, v.sum);
        self.exact(laws)
    }

    fn applied(&self) -> Self::Space {
        self.exact(self.inner.applied())
    }

    fn depends_on_velocity(&self) -> bool {
        self.inner.depends_on_velocity()
    }

    fn is_constant(&self) -> bool {
        self.inner.is_constant()
    }

    fn kick(&mut self, v: Self::Space, a: Self::Space) -> Self::Space {
        self.changed(v, self.decay.keep.map(|keep| keep.change)) + a * self.decay.gain
    }

    fn before_move(&mut self, v: Self::Space) -> Self::Space {
        self.restrain(self.changed(v, self.decay.before_move.map(|factor| factor.change)))
    }

    fn after_move(&mut self, v: Self::Space) -> Self::Space {
        self.changed(v, self.decay.after_move.map(|factor| factor.change))
    }

    fn laws_before_jump(&mut self, x: Self::Space, v: Self::Space) -> Option<Self::Space> {
        self.inner.laws_before_jump(x.sum, v.sum).map(|laws| self.exact(laws))
    }

    fn implicit_velocity(&mut self, x: Self::Space, v: Self::Space) -> Self::Space {
        newton_velocity(self, x, v)
    }
}

impl<T: Real, X: BlockSpace<T, N>, const N: usize> NewtonField for CompensatedField<'_, '_, T, X, N> {
    fn linear_rate(&self) -> Option<T> {
        self.inner.linear_rate()
    }

    fn correction(&mut self, x: Self::Space, v: Self::Space, residual: Self::Space) -> Self::Space {
        let correction = self.inner.correction(x.sum, v.sum, residual.sum);
        self.exact(correction)
    }

    fn size(&self, v: Self::Space) -> T {
        self.inner.size(v.sum)
    }

    fn report(&mut self, newton: Newton) {
        self.inner.report(newton);
    }
}

impl<T: Real, X: BlockSpace<T, N>, const N: usize> TickField for CompensatedField<'_, '_, T, X, N> {
    fn enter<M: Integrator>(&mut self, segment: Segment<T>, decay: Decay<T>) {
        self.inner.set_segment(segment, decay);
        self.decay = decay;
    }

    fn recycle(&mut self, x: &mut Self::Space, v: &mut Self::Space, step_state: &mut StepState<Self>) {
        let start = step_state.start.map_or(x.sum, |start| start.sum);
        let mut kept = [x.sum, x.residue, v.sum, v.residue, start, self.zero];
        X::recycle(self.inner.memory, &mut kept);
        [x.sum, x.residue, v.sum, v.residue, _, self.zero] = kept;
        step_state.start = step_state.start.map(|_| self.exact(kept[4]));
    }

    fn before_tick(&mut self, x: Self::Space, v: Self::Space) -> (Self::Space, Self::Space) {
        (x, self.before_move(v))
    }

    fn after_step<M: Integrator>(
        &mut self,
        x: Self::Space,
        v: Self::Space,
        _: &mut StepState<Self>,
    ) -> (Self::Space, Self::Space) {
        (x, v)
    }

    fn after_tick(&mut self, x: Self::Space, v: Self::Space) -> (Self::Space, Self::Space) {
        let v = self.after_move(v);
        (x, self.restrain(v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost_of_a_sum() {
        for (a, b) in [(1.0_f32, 1e-9), (1e-9, 1.0), (3.0e7, -3.3), (0.1, 0.2), (-5.0, 5.0)] {
            let (sum, left) = two_sum(a, b);
            assert_eq!(sum, a + b);
            assert_eq!(f64::from(sum) + f64::from(left), f64::from(a) + f64::from(b), "{a} + {b}");
        }
    }

    #[test]
    fn small_increments_are_added_up() {
        let (mut plain, mut sum) = (1.0_f32, (1.0_f32, 0.0));
        for _ in 0..1_000_000 {
            plain += 1e-8;
            sum = add_compensated(sum, (1e-8, 0.0));
        }
        assert_eq!(plain, 1.0);
        assert!((sum.0 - 1.01).abs() <= f32::EPSILON, "{}", sum.0);
    }
}
