//! The cached accelerations of a group.

use super::classes::Classes;
use super::{GroupField, GroupRows};
use crate::groups::combination::{CACHED, Combination, FIRST, POSITION, VELOCITY};
use crate::groups::rows::RowArray;
use crate::laws::MutualGravity;
use crate::methods::Field as _;
use crate::state::threads::Threads;
use crate::units::Scalar;

/// The accelerations at the end of a tick, which the next tick starts with if nothing has changed.
#[derive(Debug, Default)]
pub(crate) struct GroupCache {
    x: RowArray,
    w: Vec<f64>,
    a: RowArray,
    classes: Classes,
    key: Option<CacheKey>,
}

/// The inputs of the accelerations besides the rows and their classes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CacheKey {
    time: Scalar,
    epoch: u64,
    /// A hash that changes whenever own laws of rows change.
    own: u64,
    attraction: Option<MutualGravity>,
}

impl GroupField<'_> {
    /// The length of the last step of all rows. If rows differ, because a velocity was set or a body is new, all
    /// velocities are synchronized with their positions, and the method restarts.
    pub(super) fn common_last_step(&mut self) -> f64 {
        let Some(first) = self.rows.last.first().copied() else { return 0.0 };
        if self.rows.last.iter().all(|step| *step == first) {
            return first;
        }
        let (x, v) = (Combination::of(POSITION), Combination::of(VELOCITY));
        let a = self.laws(0.0, x, v);
        let a = a.slot().unwrap_or(FIRST);
        let GroupRows { v, last, .. } = &mut self.rows;
        for (row, (step, v)) in last.iter().zip(v.iter_mut()).enumerate() {
            for (axis, part) in v[..3].iter_mut().enumerate() {
                *part += self.scratch.slots[a][row][axis] * *step * 0.5;
            }
        }
        self.next = FIRST;
        0.0
    }

    fn cache_key(&self, time: Scalar) -> CacheKey {
        let versions = self.rows.with_laws.iter().map(|row| self.options.row(*row as usize).laws_version);
        CacheKey {
            time,
            epoch: self.environment.parameters.epoch,
            own: versions.fold(0, |sum, version| sum.wrapping_add(version).wrapping_mul(0x100_0000_01b3)),
            attraction: self.environment.shared.attraction.copied(),
        }
    }

    /// Takes the accelerations out of the cache, if they are those of this state.
    pub(super) fn recall(&mut self, cache: &mut GroupCache) -> Option<Combination> {
        let fits = cache.key.take() == Some(self.cache_key(self.environment.parameters.times.start))
            && cache.classes == self.scratch.classes
            && cache.w == self.rows.w
            && *cache.x == *self.rows.x;
        fits.then(|| {
            std::mem::swap(&mut self.scratch.slots[CACHED], &mut cache.a);
            Combination::of(CACHED)
        })
    }

    pub(super) fn note(&mut self, cache: &mut GroupCache, is_cached: bool) {
        cache.key = is_cached.then(|| self.cache_key(self.environment.parameters.times.end));
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
