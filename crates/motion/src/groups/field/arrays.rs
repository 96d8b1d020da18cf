//! The arrays of a step: claimed, computed, stored.

use super::classes::Class;
use super::{GroupField, Scratch};
use crate::groups::combination::{APPLIED, CACHED, CHANGE, Combination, FIRST, POSITION, SLOTS, VELOCITY};
use crate::groups::rows::{Row, RowArray};
use crate::kernels::{add_compensated, restrain};
use crate::laws::damping::{Decay, Factor};
use crate::real::Real;
use crate::state::threads::Threads;

impl<T: Real> GroupField<'_, T> {
    pub(super) fn claim(&mut self) -> usize {
        let slot = self.next;
        self.next += 1;
        self.scratch.slots[slot].resize(self.coupling.rows);
        slot
    }

    pub(crate) fn array(&self, slot: usize) -> &[Row<T>] {
        match slot {
            POSITION => self.rows.x,
            VELOCITY | CHANGE => self.rows.v,
            _ => &self.scratch.slots[slot],
        }
    }

    /// Computes a combination into `out`.
    pub(super) fn compute(&self, sum: &Combination<T>, out: &mut RowArray<T>) {
        out.resize(self.coupling.rows);
        let mut parts: [(&[Row<T>], T); SLOTS] = [(&[], T::ZERO); SLOTS];
        let mut count = 0;
        // The state comes last: its increments are small, and are summed first.
        for slot in (0..SLOTS).rev() {
            if sum.factors[slot] != T::ZERO {
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
    pub(crate) fn own_array(&mut self, sum: &Combination<T>) -> usize {
        let slot = self.claim();
        let mut out = std::mem::take(&mut self.scratch.slots[slot]);
        self.compute(sum, &mut out);
        self.scratch.slots[slot] = out;
        slot
    }

    /// Stores the state at the end of a step, as the start of the next one.
    pub(super) fn finish(&mut self, x: Combination<T>, v: Combination<T>) {
        // NaN if a factor of the step is infinite.
        let of_position = v.factors[POSITION];
        debug_assert!(
            of_position == T::ZERO || !of_position.is_finite(),
            "a velocity is not made of positions"
        );
        let mut parts: [(&[Row<T>], T, T); SLOTS] = [(&[], T::ZERO, T::ZERO); SLOTS];
        let mut count = 0;
        for slot in (APPLIED..SLOTS).rev() {
            if x.factors[slot] != T::ZERO || v.factors[slot] != T::ZERO {
                parts[count] = (&self.scratch.slots[slot], x.factors[slot], v.factors[slot]);
                count += 1;
            }
        }
        let own = [x.factors[POSITION], x.factors[VELOCITY], v.factors[VELOCITY]];
        let parts = &parts[..count];
        match &mut self.rows.residues {
            None => Threads::share_two(self.threads, self.rows.x, self.rows.v, |first, x, v| {
                let mut of_rows = [(&[][..], T::ZERO, T::ZERO); SLOTS];
                for (of_rows, (array, of_x, of_v)) in of_rows.iter_mut().zip(parts) {
                    *of_rows = (&array[first..], *of_x, *of_v);
                }
                advance(x, v, own, &of_rows[..count]);
            }),
            Some([rx, rv]) => {
                let change = [x.factors[CHANGE], v.factors[CHANGE]];
                advance_compensated([self.rows.x, self.rows.v], [rx, rv], own, change, parts);
            }
        }
        self.next = FIRST;
    }

    /// [`Self::finish`], unless the velocity has not changed.
    pub(super) fn finish_if_changed(&mut self, x: Combination<T>, v: Combination<T>) {
        if v != Combination::of(VELOCITY) {
            self.finish(x, v);
        }
        self.next = FIRST;
    }

    /// Caches an acceleration for the next step.
    pub(super) fn keep(&mut self, a: Combination<T>) -> Option<Combination<T>> {
        let slot = a.slot()?;
        self.scratch.slots.swap(slot, CACHED);
        Some(Combination::of(CACHED))
    }

    /// A velocity times a factor, if there is one.
    pub(super) fn times(&self, v: Combination<T>, factor: Option<Factor<T>>) -> Combination<T> {
        match factor {
            None => v,
            Some(Factor { change, .. }) if self.rows.residues.is_some() => v.changed(change),
            Some(Factor { whole, .. }) => v * whole,
        }
    }

    /// A velocity with every movable row multiplied by the factor of its class, if there is one.
    pub(super) fn each_velocity(
        &mut self,
        v: Combination<T>,
        factor: impl Fn(&Class<T>) -> Option<Factor<T>>,
    ) -> Combination<T> {
        if self.rows.residues.is_none() {
            return self.each_row(v, |class| factor(class).map(|factor| factor.whole));
        }
        let zero = Some(T::ZERO);
        let change = self.each_row(v, |class| factor(class).map_or(zero, |factor| Some(factor.change)));
        if let Some(slot) = change.slot() {
            // Anchors are not multiplied.
            self.scratch.slots[slot][self.coupling.movable..].fill([T::ZERO; 4]);
        }
        v + change
    }

    /// A velocity or acceleration with every movable row multiplied by the factor of its class, if there is one.
    pub(super) fn each_row(
        &mut self,
        v: Combination<T>,
        factor: impl Fn(&Class<T>) -> Option<T>,
    ) -> Combination<T> {
        let slot = self.own_array(&v);
        let Scratch { slots, classes, .. } = &mut *self.scratch;
        for (row, v) in slots[slot][..self.coupling.movable].iter_mut().enumerate() {
            if let Some(factor) = factor(classes.of(row)) {
                v[..3].iter_mut().for_each(|part| *part = *part * factor);
            }
        }
        Combination::of(slot)
    }

    /// A velocity with the factors of damping that `factor` picks.
    pub(super) fn decayed(
        &mut self,
        v: Combination<T>,
        factor: impl Fn(&Decay<T>) -> Option<Factor<T>>,
    ) -> Combination<T> {
        if self.scratch.classes.list.iter().all(|class| factor(&class.decay).is_none()) {
            return v;
        }
        match self.scratch.classes.uniform() {
            Some(class) if self.anchors_rest => self.times(v, factor(&class.decay)),
            _ => self.each_velocity(v, |class| factor(&class.decay)),
        }
    }

    /// Applies speed limits and axis locks.
    pub(super) fn restrain(&mut self, v: Combination<T>) -> Combination<T> {
        if self.scratch.classes.list.iter().all(|class| class.limit.is_none() && class.locks.is_none()) {
            return v;
        }
        let slot = self.own_array(&v);
        let compensated = self.rows.residues.is_some();
        if compensated {
            // Only the change is needed.
            std::mem::swap(&mut self.scratch.slots[slot], &mut self.scratch.stage[1]);
            self.scratch.slots[slot].resize(self.coupling.rows);
            self.scratch.slots[slot].fill([T::ZERO; 4]);
        }
        let Scratch { slots, stage, classes, .. } = &mut *self.scratch;
        for row in self.rows.with_options {
            let row = *row as usize;
            let Class { limit, locks, .. } = *classes.of(row);
            if compensated {
                let (before, mut after) = (stage[1][row], stage[1][row]);
                restrain(&mut after, limit, locks);
                slots[slot][row] = std::array::from_fn(|axis| after[axis] - before[axis]);
            } else {
                restrain(&mut slots[slot][row], limit, locks);
            }
        }
        if compensated { v + Combination::of(slot) } else { Combination::of(slot) }
    }

    /// Sets velocities that decayed below [`Real::SNAP`] to 0.
    pub(super) fn snap(&mut self) {
        if self.decays() {
            Threads::share(self.threads, &mut self.rows.v[..self.coupling.movable], |_, rows| {
                for row in rows {
                    for part in &mut row[..3] {
                        if part.abs() < T::SNAP {
                            *part = T::ZERO;
                        }
                    }
                }
            });
            if let Some([_, residues]) = &mut self.rows.residues {
                // These are smaller still.
                for part in residues[..self.coupling.movable].as_flattened_mut() {
                    if part.abs() < T::SNAP {
                        *part = T::ZERO;
                    }
                }
            }
        }
    }
}

/// `out = f1 a1 + f2 a2 + ...`, the last part added last.
fn add_up<T: Real>(parts: &[(&[Row<T>], T)], out: &mut [Row<T>]) {
    fn of<T: Real, const N: usize>(parts: &[(&[Row<T>], T)], out: &mut [Row<T>]) {
        let out = out.as_flattened_mut();
        let arrays: [&[T]; N] = std::array::from_fn(|part| &parts[part].0.as_flattened()[..out.len()]);
        let factors: [T; N] = std::array::from_fn(|part| parts[part].1);
        for (i, out) in out.iter_mut().enumerate() {
            let mut sum = arrays[0][i] * factors[0];
            for part in 1..N {
                sum += arrays[part][i] * factors[part];
            }
            *out = sum;
        }
    }
    match parts.len() {
        0 => out.fill([T::ZERO; 4]),
        1 => of::<T, 1>(parts, out),
        2 => of::<T, 2>(parts, out),
        3 => of::<T, 3>(parts, out),
        4 => of::<T, 4>(parts, out),
        5 => of::<T, 5>(parts, out),
        6 => of::<T, 6>(parts, out),
        _ => {
            out.fill([T::ZERO; 4]);
            for (array, factor) in parts {
                let rows = out.as_flattened_mut().iter_mut().zip(array.as_flattened());
                rows.for_each(|(sum, part)| *sum += *part * *factor);
            }
        }
    }
}

/// `x = xx x + xv v + ...; v = vv v + ...` in place, the states added last.
fn advance<T: Real>(x: &mut [Row<T>], v: &mut [Row<T>], own: [T; 3], parts: &[(&[Row<T>], T, T)]) {
    fn of<T: Real, const N: usize>(x: &mut [T], v: &mut [T], own: [T; 3], parts: &[(&[Row<T>], T, T)]) {
        let n = x.len();
        let v = &mut v[..n];
        let arrays: [&[T]; N] = std::array::from_fn(|part| &parts[part].0.as_flattened()[..n]);
        let factors: [(T, T); N] = std::array::from_fn(|part| (parts[part].1, parts[part].2));
        let [xx, xv, vv] = own;
        for i in 0..n {
            let (mut dx, mut dv) = (T::ZERO, T::ZERO);
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
        0 => of::<T, 0>(x, v, own, parts),
        1 => of::<T, 1>(x, v, own, parts),
        2 => of::<T, 2>(x, v, own, parts),
        3 => of::<T, 3>(x, v, own, parts),
        4 => of::<T, 4>(x, v, own, parts),
        5 => of::<T, 5>(x, v, own, parts),
        6 => of::<T, 6>(x, v, own, parts),
        7 => of::<T, 7>(x, v, own, parts),
        8 => of::<T, 8>(x, v, own, parts),
        _ => {
            for (i, (x, v)) in x.iter_mut().zip(&mut *v).enumerate() {
                let (mut dx, mut dv) = (T::ZERO, T::ZERO);
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

/// [`advance`] in compensated sums; `change` are the factors of the old velocity as an increment of both.
fn advance_compensated<T: Real>(
    [x, v]: [&mut [Row<T>]; 2],
    [rx, rv]: [&mut [Row<T>]; 2],
    [xx, xv, vv]: [T; 3],
    [cx, cv]: [T; 2],
    parts: &[(&[Row<T>], T, T)],
) {
    let mut arrays: [&[T]; SLOTS] = [&[]; SLOTS];
    arrays.iter_mut().zip(parts).for_each(|(flat, (array, ..))| *flat = array.as_flattened());
    let positions = x.as_flattened_mut().iter_mut().zip(rx.as_flattened_mut());
    let velocities = v.as_flattened_mut().iter_mut().zip(rv.as_flattened_mut());
    for (i, ((x, rx), (v, rv))) in positions.zip(velocities).enumerate() {
        let (mut dx, mut dv) = (T::ZERO, T::ZERO);
        for (array, (_, of_x, of_v)) in arrays.iter().zip(parts) {
            dx += array[i] * *of_x;
            dv += array[i] * *of_v;
        }
        let moved = add_compensated((*v * xv, *rv * xv), (*v * cx + dx, *rv * cx));
        (*x, *rx) = add_compensated((*x * xx, *rx * xx), moved);
        (*v, *rv) = add_compensated((*v * vv, *rv * vv), (*v * cv + dv, *rv * cv));
    }
}
