//! The arrays of a step: claimed, computed, stored.

use super::classes::Class;
use super::{GroupField, Scratch};
use crate::groups::combination::{APPLIED, CACHED, Combination, FIRST, POSITION, SLOTS, VELOCITY};
use crate::groups::rows::{Row, RowArray};
use crate::kernels::restrain;
use crate::laws::damping::{Decay, SNAP};
use crate::state::threads::Threads;

impl GroupField<'_> {
    pub(super) fn claim(&mut self) -> usize {
        let slot = self.next;
        self.next += 1;
        self.scratch.slots[slot].resize(self.coupling.rows);
        slot
    }

    pub(crate) fn array(&self, slot: usize) -> &[Row] {
        match slot {
            POSITION => self.rows.x,
            VELOCITY => self.rows.v,
            _ => &self.scratch.slots[slot],
        }
    }

    /// Computes a combination into `out`.
    pub(super) fn compute(&self, sum: &Combination, out: &mut RowArray) {
        out.resize(self.coupling.rows);
        let mut parts: [(&[Row], f64); SLOTS] = [(&[], 0.0); SLOTS];
        let mut count = 0;
        // The state comes last: its increments are small, and are summed first.
        for slot in (0..SLOTS).rev() {
            if sum.factors[slot] != 0.0 {
                parts[count] = (self.array(slot), sum.factors[slot]);
                count += 1;
            }
        }
        Threads::share(self.threads, out, |first, out| {
            let mut of_rows = parts;
            of_rows[..count].iter_mut().for_each(|(array, _)| *array = &array[first..]);
            add_up(&of_rows[..count], out);
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
        debug_assert!(of_position == 0.0 || !of_position.is_finite(), "a velocity is not made of positions");
        let mut parts: [(&[Row], f64, f64); SLOTS] = [(&[], 0.0, 0.0); SLOTS];
        let mut count = 0;
        for slot in (APPLIED..SLOTS).rev() {
            if x.factors[slot] != 0.0 || v.factors[slot] != 0.0 {
                parts[count] = (&self.scratch.slots[slot], x.factors[slot], v.factors[slot]);
                count += 1;
            }
        }
        let own = [x.factors[POSITION], x.factors[VELOCITY], v.factors[VELOCITY]];
        let parts = &parts[..count];
        Threads::share_two(self.threads, self.rows.x, self.rows.v, |first, x, v| {
            let mut of_rows = [(&[][..], 0.0, 0.0); SLOTS];
            for (of_rows, (array, of_x, of_v)) in of_rows.iter_mut().zip(parts) {
                *of_rows = (&array[first..], *of_x, *of_v);
            }
            advance(x, v, own, &of_rows[..count]);
        });
        self.next = FIRST;
    }

    /// [`Self::finish`], unless the velocity has not changed.
    pub(super) fn finish_if_changed(&mut self, x: Combination, v: Combination) {
        if v != Combination::of(VELOCITY) {
            self.finish(x, v);
        }
        self.next = FIRST;
    }

    /// Caches an acceleration for the next step.
    pub(super) fn keep(&mut self, a: Combination) -> Option<Combination> {
        let slot = a.slot()?;
        self.scratch.slots.swap(slot, CACHED);
        Some(Combination::of(CACHED))
    }

    /// A velocity or acceleration with every movable row multiplied by the factor of its class, if there is one.
    pub(super) fn each_row(&mut self, v: Combination, factor: impl Fn(&Class) -> Option<f64>) -> Combination {
        let slot = self.own_array(&v);
        let Scratch { slots, classes, .. } = &mut *self.scratch;
        for (row, v) in slots[slot][..self.coupling.movable].iter_mut().enumerate() {
            if let Some(factor) = factor(classes.of(row)) {
                v[..3].iter_mut().for_each(|part| *part *= factor);
            }
        }
        Combination::of(slot)
    }

    /// A velocity with the factors of damping that `factor` picks.
    pub(super) fn decayed(&mut self, v: Combination, factor: impl Fn(&Decay) -> Option<f64>) -> Combination {
        if self.scratch.classes.list.iter().all(|class| factor(&class.decay).is_none()) {
            return v;
        }
        match self.scratch.classes.uniform() {
            Some(class) if self.anchors_rest => factor(&class.decay).map_or(v, |factor| v * factor),
            _ => self.each_row(v, |class| factor(&class.decay)),
        }
    }

    /// Applies speed limits and axis locks.
    pub(super) fn restrain(&mut self, v: Combination) -> Combination {
        if self.scratch.classes.list.iter().all(|class| class.limit.is_none() && class.locks.is_none()) {
            return v;
        }
        let slot = self.own_array(&v);
        let Scratch { slots, classes, .. } = &mut *self.scratch;
        for row in self.rows.with_options {
            let row = *row as usize;
            let Class { limit, locks, .. } = *classes.of(row);
            restrain(&mut slots[slot][row], limit, locks);
        }
        Combination::of(slot)
    }

    /// Sets velocities that decayed below [`SNAP`] to 0.
    pub(super) fn snap(&mut self) {
        if self.decays() {
            Threads::share(self.threads, &mut self.rows.v[..self.coupling.movable], |_, rows| {
                for row in rows {
                    for part in &mut row[..3] {
                        if part.abs() < SNAP {
                            *part = 0.0;
                        }
                    }
                }
            });
        }
    }
}

/// `out = f1 a1 + f2 a2 + ...`, the last part added last.
fn add_up(parts: &[(&[Row], f64)], out: &mut [Row]) {
    fn of<const N: usize>(parts: &[(&[Row], f64)], out: &mut [Row]) {
        let out = out.as_flattened_mut();
        let arrays: [&[f64]; N] = std::array::from_fn(|part| &parts[part].0.as_flattened()[..out.len()]);
        let factors: [f64; N] = std::array::from_fn(|part| parts[part].1);
        for (i, out) in out.iter_mut().enumerate() {
            let mut sum = arrays[0][i] * factors[0];
            for part in 1..N {
                sum += arrays[part][i] * factors[part];
            }
            *out = sum;
        }
    }
    match parts.len() {
        0 => out.fill([0.0; 4]),
        1 => of::<1>(parts, out),
        2 => of::<2>(parts, out),
        3 => of::<3>(parts, out),
        4 => of::<4>(parts, out),
        5 => of::<5>(parts, out),
        6 => of::<6>(parts, out),
        _ => {
            out.fill([0.0; 4]);
            for (array, factor) in parts {
                let rows = out.as_flattened_mut().iter_mut().zip(array.as_flattened());
                rows.for_each(|(sum, part)| *sum += *part * *factor);
            }
        }
    }
}

/// `x = xx x + xv v + ...; v = vv v + ...` in place, the states added last.
fn advance(x: &mut [Row], v: &mut [Row], own: [f64; 3], parts: &[(&[Row], f64, f64)]) {
    fn of<const N: usize>(x: &mut [f64], v: &mut [f64], own: [f64; 3], parts: &[(&[Row], f64, f64)]) {
        let n = x.len();
        let v = &mut v[..n];
        let arrays: [&[f64]; N] = std::array::from_fn(|part| &parts[part].0.as_flattened()[..n]);
        let factors: [(f64, f64); N] = std::array::from_fn(|part| (parts[part].1, parts[part].2));
        let [xx, xv, vv] = own;
        for i in 0..n {
            let (mut dx, mut dv) = (0.0, 0.0);
            for part in 0..N {
                dx += arrays[part][i] * factors[part].0;
                dv += arrays[part][i] * factors[part].1;
            }
            x[i] = x[i] * xx + (v[i] * xv + dx);
            v[i] = v[i] * vv + dv;
        }
    }
    let (x, v) = (x.as_flattened_mut(), v.as_flattened_mut());
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
                    dx += array.as_flattened()[i] * *of_x;
                    dv += array.as_flattened()[i] * *of_v;
                }
                *x = *x * own[0] + (*v * own[1] + dx);
                *v = *v * own[2] + dv;
            }
        }
    }
}
