//! The arrays of a step: claimed, computed, stored.

use super::classes::Class;
use super::{GroupField, Layout, Scratch};
use crate::groups::combination::{APPLIED, CACHED, Combination, FIRST, POSITION, SLOTS, VELOCITY};
use crate::groups::rows::{Array, numbers, numbers_mut};
use crate::laws::damping::SNAP;
use crate::simd::vectorize_many;
use crate::state::threads::Threads;

impl<E: Layout> GroupField<'_, E> {
    pub(super) fn claim(&mut self) -> usize {
        let slot = self.next;
        self.next += 1;
        self.scratch.slots[slot].resize(self.rows.x.len());
        slot
    }

    /// Makes all arrays free again that were [claimed](Self::claim).
    pub(super) const fn release_slots(&mut self) {
        self.next = FIRST;
    }

    pub(crate) fn array(&self, slot: usize) -> &[E] {
        match slot {
            POSITION => self.rows.x,
            VELOCITY => self.rows.v,
            _ => &self.scratch.slots[slot],
        }
    }

    /// Computes a combination into `out`.
    pub(super) fn compute(&self, sum: &Combination, out: &mut Array<E>) {
        out.resize(self.rows.x.len());
        let mut parts: [(&[E], f64); SLOTS] = [(&[], 0.0); SLOTS];
        let mut count = 0;
        // The state comes last: its increments are small, and are summed first.
        for slot in (0..SLOTS).rev() {
            if sum.factors[slot] != 0.0 {
                parts[count] = (self.array(slot), sum.factors[slot]);
                count += 1;
            }
        }
        // Anchors at rest stay where they are.
        let of_position = sum.factors[POSITION];
        let (moving, still) =
            match self.rows.anchors_rest && (of_position == 0.0 || of_position == 1.0) {
                true => out.split_at_mut(self.movable()),
                false => out.split_at_mut(self.rows.x.len()),
            };
        if of_position == 1.0 {
            still.copy_from_slice(&self.rows.x[moving.len()..]);
        } else {
            numbers_mut(still).fill(0.0);
        }
        Threads::share(self.threads, moving, |first, out| {
            let mut of_rows = [(&[][..], 0.0); SLOTS];
            for (of_rows, (array, factor)) in of_rows.iter_mut().zip(&parts[..count]) {
                *of_rows = (numbers(&array[first..]), *factor);
            }
            add_up(&of_rows[..count], numbers_mut(out));
        });
    }

    /// Computes a combination into a new array.
    pub(crate) fn own_array(&mut self, sum: &Combination) -> usize {
        let slot = self.claim();
        let mut out = std::mem::take(&mut self.scratch.slots[slot]);
        self.compute(sum, &mut out);
        self.scratch.slots[slot] = out;
        slot
    }

    /// Stores the state at the end of a step, as the start of the next one.
    pub(super) fn finish(&mut self, x: Combination, v: Combination) {
        // NaN if a factor of the step is infinite.
        let of_position = v.factors[POSITION];
        debug_assert!(
            of_position == 0.0 || !of_position.is_finite(),
            "a velocity is not made of positions"
        );
        let mut parts: [(&[E], f64, f64); SLOTS] = [(&[], 0.0, 0.0); SLOTS];
        let mut count = 0;
        for slot in (APPLIED..SLOTS).rev() {
            if x.factors[slot] != 0.0 || v.factors[slot] != 0.0 {
                parts[count] = (&self.scratch.slots[slot], x.factors[slot], v.factors[slot]);
                count += 1;
            }
        }
        let own = [x.factors[POSITION], x.factors[VELOCITY], v.factors[VELOCITY]];
        let parts = &parts[..count];
        // Anchors at rest stay where they are.
        let moving = if self.rows.anchors_rest && own[0] == 1.0 {
            self.movable()
        } else {
            self.rows.x.len()
        };
        let (x, v) = (&mut self.rows.x[..moving], &mut self.rows.v[..moving]);
        Threads::share_two(self.threads, x, v, |first, x, v| {
            let mut of_rows = [(&[][..], 0.0, 0.0); SLOTS];
            for (of_rows, (array, of_x, of_v)) in of_rows.iter_mut().zip(parts) {
                *of_rows = (numbers(&array[first..]), *of_x, *of_v);
            }
            advance(numbers_mut(x), numbers_mut(v), own, &of_rows[..count]);
        });
        self.release_slots();
    }

    /// Caches an acceleration for the next step.
    pub(super) fn keep(&mut self, a: Combination) -> Option<Combination> {
        let slot = a.slot()?;
        self.scratch.slots.swap(slot, CACHED);
        Some(Combination::of(CACHED))
    }

    /// A velocity or acceleration with every movable row multiplied by the factor of its class, if there is one.
    pub(super) fn each_row(
        &mut self,
        v: Combination,
        factor: impl Fn(&Class) -> Option<f64>,
    ) -> Combination {
        let slot = self.own_array(&v);
        let elements = self.movable();
        let Scratch { slots, classes, .. } = &mut *self.scratch;
        for (element, v) in slots[slot][..elements].iter_mut().enumerate() {
            if let Some(factor) = factor(classes.of(element / self.width)) {
                (0..3)
                    .for_each(|axis| v.axis_mut(axis).iter_mut().for_each(|part| *part *= factor));
            }
        }
        Combination::of(slot)
    }

    /// Sets velocities that decayed below [`SNAP`] to 0.
    pub(super) fn snap(&mut self) {
        if self.decays() {
            let elements = self.movable();
            Threads::share(self.threads, &mut self.rows.v[..elements], |_, rows| {
                let numbers = numbers_mut(rows);
                vectorize_many(
                    numbers.len(),
                    #[inline(always)]
                    || {
                        for part in numbers {
                            // Not `!(part.abs() >= SNAP)`: NaN must stay, to be found.
                            *part = if part.abs() < SNAP { 0.0 } else { *part };
                        }
                    },
                );
            });
        }
    }
}

/// Number of results that are computed before the first of them is stored. One by one, the compiler would have to assume
/// that each store overlaps with the inputs of the next result.
const AT_ONCE: usize = 4;

/// The first `len` numbers of an array, in parts of [`AT_ONCE`].
fn parts_of(numbers: &[f64], len: usize) -> &[[f64; AT_ONCE]] {
    numbers[..len].as_chunks().0
}

/// `out = f1 a1 + f2 a2 + ...`, the last part added last.
fn add_up(parts: &[(&[f64], f64)], out: &mut [f64]) {
    fn of<const N: usize>(parts: &[(&[f64], f64)], out: &mut [f64]) {
        let len = out.len();
        let arrays: [_; N] = std::array::from_fn(|part| parts_of(parts[part].0, len));
        let factors: [f64; N] = std::array::from_fn(|part| parts[part].1);
        vectorize_many(
            len,
            #[inline(always)]
            || {
                for (i, out) in out.as_chunks_mut::<AT_ONCE>().0.iter_mut().enumerate() {
                    let mut sums = arrays[0][i];
                    (0..AT_ONCE).for_each(|k| sums[k] *= factors[0]);
                    for part in 1..N {
                        let numbers = arrays[part][i];
                        (0..AT_ONCE).for_each(|k| sums[k] += numbers[k] * factors[part]);
                    }
                    *out = sums;
                }
            },
        );
    }
    match parts.len() {
        0 => out.fill(0.0),
        1 => of::<1>(parts, out),
        2 => of::<2>(parts, out),
        3 => of::<3>(parts, out),
        4 => of::<4>(parts, out),
        5 => of::<5>(parts, out),
        6 => of::<6>(parts, out),
        _ => {
            out.fill(0.0);
            for (array, factor) in parts {
                out.iter_mut().zip(*array).for_each(|(sum, part)| *sum += *part * *factor);
            }
        }
    }
}

/// `x = xx x + xv v + ...; v = vv v + ...` in place, the states added last.
fn advance(x: &mut [f64], v: &mut [f64], own: [f64; 3], parts: &[(&[f64], f64, f64)]) {
    fn of<const N: usize>(
        x: &mut [f64],
        v: &mut [f64],
        own: [f64; 3],
        parts: &[(&[f64], f64, f64)],
    ) {
        let len = x.len();
        let arrays: [_; N] = std::array::from_fn(|part| parts_of(parts[part].0, len));
        let factors: [(f64, f64); N] = std::array::from_fn(|part| (parts[part].1, parts[part].2));
        let [xx, xv, vv] = own;
        vectorize_many(
            len,
            #[inline(always)]
            || {
                let rows =
                    x.as_chunks_mut::<AT_ONCE>().0.iter_mut().zip(v.as_chunks_mut::<AT_ONCE>().0);
                for (i, (x, v)) in rows.enumerate() {
                    let (mut dx, mut dv) = ([0.0; AT_ONCE], [0.0; AT_ONCE]);
                    for part in 0..N {
                        let numbers = arrays[part][i];
                        (0..AT_ONCE).for_each(|k| dx[k] += numbers[k] * factors[part].0);
                        (0..AT_ONCE).for_each(|k| dv[k] += numbers[k] * factors[part].1);
                    }
                    let (old_x, old_v) = (*x, *v);
                    (0..AT_ONCE).for_each(|k| dx[k] = old_x[k] * xx + (old_v[k] * xv + dx[k]));
                    (0..AT_ONCE).for_each(|k| dv[k] += old_v[k] * vv);
                    (*x, *v) = (dx, dv);
                }
            },
        );
    }
    match parts.len() {
        0 => of::<0>(x, v, own, parts),
        1 => of::<1>(x, v, own, parts),
        2 => of::<2>(x, v, own, parts),
        3 => of::<3>(x, v, own, parts),
        4 => of::<4>(x, v, own, parts),
        5 => of::<5>(x, v, own, parts),
        6 => of::<6>(x, v, own, parts),
        7 => of::<7>(x, v, own, parts),
        8 => of::<8>(x, v, own, parts),
        _ => {
            for (i, (x, v)) in x.iter_mut().zip(&mut *v).enumerate() {
                let (mut dx, mut dv) = (0.0, 0.0);
                for (array, of_x, of_v) in parts {
                    dx += array[i] * *of_x;
                    dv += array[i] * *of_v;
                }
                *x = *x * own[0] + (*v * own[1] + dx);
                *v = *v * own[2] + dv;
            }
        }
    }
}
