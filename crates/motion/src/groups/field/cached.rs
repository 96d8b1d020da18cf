//! The cached accelerations of a group.

use super::classes::Classes;
use super::{GroupField, GroupRows};
use crate::groups::combination::{CACHED, Combination, FIRST, POSITION, VELOCITY};
use crate::groups::rows::RowArray;
use crate::kernels::add_compensated;
use crate::laws::MutualGravity;
use crate::methods::Field as _;
use crate::real::Real;
use crate::state::threads::Threads;
use crate::units::Scalar;

/// The accelerations at the end of a tick, which the next tick starts with if nothing has changed.
#[derive(Debug, Default)]
pub(crate) struct GroupCache<T: Real> {
    x: RowArray<T>,
    w: Vec<T>,
    a: RowArray<T>,
    classes: Classes<T>,
    conditions: Option<Conditions>,
}

/// What the accelerations depend on besides the rows and their classes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Conditions {
    time: Scalar,
    epoch: u64,
    /// A hash that changes whenever own laws of rows change.
    own: u64,
    attraction: Option<MutualGravity>,
}

impl<T: Real> GroupField<'_, T> {
    /// The length of the last step of all rows. If rows differ, because a velocity was set or a body is new, all
    /// velocities are synchronized with their positions, and the method restarts.
    pub(super) fn common_last_step(&mut self) -> T {
        let Some(first) = self.rows.last.first().copied() else { return T::ZERO };
        if self.rows.last.iter().all(|step| *step == first) {
            return first;
        }
        let (x, v) = (Combination::of(POSITION), Combination::of(VELOCITY));
        let a = self.laws(T::ZERO, x, v);
        let a = a.slot().unwrap_or(FIRST);
        let GroupRows { v, last, residues, .. } = &mut self.rows;
        for (row, (step, v)) in last.iter().zip(v.iter_mut()).enumerate() {
            for (axis, part) in v[..3].iter_mut().enumerate() {
                let more = self.scratch.slots[a][row][axis] * *step * T::of(0.5);
                match residues {
                    None => *part += more,
                    Some([_, residues]) => {
                        let residue = &mut residues[row][axis];
                        (*part, *residue) = add_compensated((*part, *residue), (more, T::ZERO));
                    }
                }
            }
        }
        self.next = FIRST;
        T::ZERO
    }

    fn conditions(&self, time: Scalar) -> Conditions {
        let versions = self.rows.with_laws.iter().map(|row| self.options.row(*row as usize).laws_version);
        Conditions {
            time,
            epoch: self.environment.terms.epoch,
            own: versions.fold(0, |sum, version| sum.wrapping_add(version).wrapping_mul(0x100_0000_01b3)),
            attraction: self.environment.shared.attraction.copied(),
        }
    }

    /// Takes the accelerations out of the cache, if they are those of this state.
    pub(super) fn recall(&mut self, cache: &mut GroupCache<T>) -> Option<Combination<T>> {
        let fits = cache.conditions.take() == Some(self.conditions(self.environment.terms.times.start))
            && cache.classes == self.scratch.classes
            && cache.w == self.rows.w
            && *cache.x == *self.rows.x;
        fits.then(|| {
            std::mem::swap(&mut self.scratch.slots[CACHED], &mut cache.a);
            Combination::of(CACHED)
        })
    }

    pub(super) fn note(&mut self, cache: &mut GroupCache<T>, is_cached: bool) {
        cache.conditions = is_cached.then(|| self.conditions(self.environment.terms.times.end));
        if is_cached {
            // Allocates nothing once the lists have their lengths.
            cache.classes.list.clone_from(&self.scratch.classes.list);
            cache.classes.of_row.clone_from(&self.scratch.classes.of_row);
            cache.w.clear();
            cache.w.extend_from_slice(self.rows.w);
            std::mem::swap(&mut self.scratch.slots[CACHED], &mut cache.a);
            let (x, rows) = (&mut cache.x, &*self.rows.x);
            x.resize(rows.len());
            Threads::share(self.threads, x, |first, x| x.copy_from_slice(&rows[first..first + x.len()]));
        }
    }
}
