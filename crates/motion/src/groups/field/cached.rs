//! The cached accelerations of a group.

use super::GroupField;
use super::classes::Class;
use crate::groups::combination::{CACHED, Combination, FIRST, POSITION, VELOCITY};
use crate::groups::rows::RowArray;
use crate::kernels::add_compensated;
use crate::laws::MutualGravity;
use crate::methods::Field as _;
use crate::real::Real;
use crate::units::Scalar;

/// The accelerations at the end of a tick, which the next tick starts with if nothing has changed.
#[derive(Debug, Default)]
pub(crate) struct GroupCache<T: Real> {
    x: RowArray<T>,
    w: Vec<T>,
    a: RowArray<T>,
    time: Option<Scalar>,
    epoch: u64,
    own: u64,
    attraction: Option<MutualGravity>,
    classes: Vec<Class<T>>,
    class_of: Vec<u32>,
}

impl<T: Real> GroupField<'_, T> {
    /// The length of the last step of all rows. If rows differ, because a velocity was set or a body is new, all
    /// velocities are synchronized with their positions, and the method restarts.
    pub(super) fn common_last_step(&mut self, last: &mut [T]) -> T {
        let Some(first) = last.first().copied() else { return T::ZERO };
        if last.iter().all(|step| *step == first) {
            return first;
        }
        let (x, v) = (Combination::of(POSITION), Combination::of(VELOCITY));
        let a = self.laws(T::ZERO, x, v);
        let a = a.slot().unwrap_or(FIRST);
        for (row, (step, v)) in last.iter().zip(self.rows.v.iter_mut()).enumerate() {
            for (axis, part) in v[..3].iter_mut().enumerate() {
                let more = self.scratch.slots[a][row][axis] * *step * T::of(0.5);
                match &mut self.rows.residues {
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

    /// A hash that changes whenever own laws of rows change.
    pub(super) fn versions(&self) -> u64 {
        let own = self.rows.with_laws.iter().map(|row| self.options.row(*row as usize).laws_version);
        own.fold(0, |sum, version| sum.wrapping_add(version).wrapping_mul(0x100_0000_01b3))
    }

    pub(super) fn recall(&mut self, cache: &GroupCache<T>, own: u64) -> Option<Combination<T>> {
        let terms = &self.environment.terms;
        let fits = cache.time == Some(terms.times.start)
            && (cache.epoch, cache.own) == (terms.epoch, own)
            && cache.attraction.as_ref() == self.environment.shared.attraction
            && cache.classes == self.scratch.classes
            && cache.class_of == self.scratch.class_of
            && cache.w == self.rows.w
            && *cache.x == *self.rows.x;
        fits.then(|| {
            self.scratch.slots[CACHED].copy(&cache.a);
            Combination::of(CACHED)
        })
    }

    pub(super) fn note(&self, cache: &mut GroupCache<T>, own: u64, is_cached: bool) {
        let terms = &self.environment.terms;
        cache.time = is_cached.then_some(terms.times.end);
        if is_cached {
            (cache.epoch, cache.own) = (terms.epoch, own);
            cache.attraction = self.environment.shared.attraction.copied();
            cache.classes.clone_from(&self.scratch.classes);
            cache.class_of.clone_from(&self.scratch.class_of);
            cache.x.copy(self.rows.x);
            cache.w.clear();
            cache.w.extend_from_slice(self.rows.w);
            cache.a.copy(&self.scratch.slots[CACHED]);
        }
    }
}
