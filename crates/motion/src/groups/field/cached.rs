//! The cached accelerations of a group.

use super::classes::Classes;
use super::{GroupField, GroupRows, Layout};
use crate::groups::combination::{CACHED, Combination, POSITION, VELOCITY};
use crate::groups::rows::{Array, Element, Row, numbers};
use crate::laws::{Axes, MutualGravity};
use crate::state::threads::Threads;
use crate::units::Scalar;

/// The accelerations at the end of a tick, which the next tick starts with if nothing has changed.
#[derive(Debug, Default)]
pub(crate) struct GroupCache<E: Element = Row> {
    x: Array<E>,
    w: Vec<f64>,
    a: Array<E>,
    classes: Classes,
    /// The key of each group; empty if there are no accelerations.
    keys: Vec<Option<CacheKey>>,
}

impl GroupCache {
    /// Whether it has accelerations of the time `time`, s.
    pub fn is_of(&self, time: Scalar) -> bool {
        self.keys.iter().flatten().any(|key| key.time == time)
    }
}

impl GroupCache<Axes> {
    /// Moves the cache of one group, of `rows` rows in blocks of `width` elements, to `cache`.
    pub fn move_group_to(
        &mut self,
        width: usize,
        rows: usize,
        group: usize,
        cache: &mut GroupCache,
    ) {
        let Some(key) = self.keys.get_mut(group).and_then(Option::take) else { return };
        cache.keys.clear();
        cache.keys.push(Some(key));
        cache.classes.clone_from(&self.classes);
        cache.x.resize(rows);
        cache.a.resize(rows);
        cache.w.resize(rows, 0.0);
        for row in 0..rows {
            let (element, lane) = Axes::place(width, row, group);
            cache.x[row] = self.x[element].row(lane);
            cache.a[row] = self.a[element].row(lane);
            cache.w[row] = self.w[element * Axes::LANES + lane];
        }
    }

    /// Moves the cache of one group out of `cache` into this one. Leaves it there and returns `false` if there are caches of
    /// other groups whose rows are in other classes.
    #[must_use]
    pub fn move_group_from(&mut self, width: usize, group: usize, cache: &mut GroupCache) -> bool {
        if self.keys.len() <= group {
            self.keys.resize(group + 1, None);
        }
        self.keys[group] = None;
        let Some(key @ Some(_)) = cache.keys.last().copied() else { return true };
        let elements = cache.x.len() * width;
        if self.keys.iter().all(Option::is_none) {
            self.classes.clone_from(&cache.classes);
            self.x.resize(elements);
            self.a.resize(elements);
            self.w.resize(elements * Axes::LANES, 0.0);
        }
        if self.classes != cache.classes {
            return false;
        }
        cache.keys.clear();
        self.keys[group] = key;
        for row in 0..cache.x.len() {
            let (element, lane) = Axes::place(width, row, group);
            self.x[element].set_row(lane, cache.x[row]);
            self.a[element].set_row(lane, cache.a[row]);
            self.w[element * Axes::LANES + lane] = cache.w[row];
        }
        true
    }
}

/// The inputs of the accelerations besides the rows and their classes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CacheKey {
    time: Scalar,
    /// Changes whenever the laws do.
    epoch: u64,
    /// A hash that changes whenever own laws of rows change.
    own: u64,
    attraction: Option<MutualGravity>,
}

impl<E: Layout> GroupField<'_, E> {
    /// Synchronizes all velocities with their positions, so that the method restarts, if the last steps of rows differ,
    /// because a velocity was set or a body is new. Returns the length of the last step of all rows.
    pub(super) fn synchronize_last_steps(&mut self) -> f64 {
        let Some(first) = self.rows.last.first().copied() else { return 0.0 };
        if self.rows.last.iter().all(|step| *step == first) {
            return first;
        }
        let (x, v) = (Combination::of(POSITION), Combination::of(VELOCITY));
        let a = self.accelerate(self.segment.evaluation_time(0.0), x, v);
        let GroupRows { v, last, .. } = &mut self.rows;
        let elements = v.iter_mut().zip(&*self.scratch.slots[a]).zip(last.chunks(E::LANES));
        for ((v, a), steps) in elements {
            for axis in 0..3 {
                let rows = v.axis_mut(axis).iter_mut().zip(a.axis(axis)).zip(steps);
                rows.for_each(|((part, a), step)| *part += a * step * 0.5);
            }
        }
        self.release_slots();
        0.0
    }

    fn cache_key(&self, time: Scalar) -> CacheKey {
        let versions =
            self.rows.with_laws.iter().map(|row| self.options.row(*row as usize).laws_version);
        CacheKey {
            time,
            epoch: self.environment.parameters.epoch,
            own: versions
                .fold(0, |sum, version| sum.wrapping_add(version).wrapping_mul(0x100_0000_01b3)),
            attraction: self.environment.shared.attraction.copied(),
        }
    }

    /// Takes the accelerations out of the cache, if they belong to this state. Computes those of groups whose state differs;
    /// `None` if it differs for all groups.
    pub(super) fn recall(&mut self, cache: &mut GroupCache<E>) -> Option<Combination> {
        let now = Some(self.cache_key(self.environment.parameters.times.start));
        cache.keys.resize(self.rows.groups, None);
        // Accelerations from before a jump are invalid after it.
        let is_usable = cache.classes == self.scratch.classes && !self.segment.jump;
        let all_match =
            is_usable && cache.w == self.rows.w && numbers(&cache.x) == numbers(self.rows.x);
        let mut to_compute = std::mem::take(&mut self.scratch.not_cached);
        if !(all_match && cache.keys.iter().all(|key| *key == now)) {
            let fits = |group: usize| {
                is_usable && cache.keys[group] == now && (all_match || self.is_in(cache, group))
            };
            to_compute.extend((0..self.rows.groups).filter(|group| !fits(*group)));
        }
        let all_differ = to_compute.len() == self.rows.groups;
        to_compute.retain(|group| !all_differ && self.rows.apart.binary_search(group).is_err());
        self.scratch.not_cached = to_compute;
        // Empty until the tick stores new ones: it may fail.
        cache.keys.clear();
        if all_differ {
            return None;
        }
        self.compute_not_cached(cache);
        std::mem::swap(&mut self.scratch.slots[CACHED], &mut cache.a);
        Some(Combination::of(CACHED))
    }

    /// Whether a group is in the state of its cached accelerations.
    fn is_in(&self, cache: &GroupCache<E>, group: usize) -> bool {
        (0..self.coupling.rows).all(|row| {
            let (element, lane) = self.place(row, group);
            let weight = element * E::LANES + lane;
            cache.w.get(weight) == Some(&self.rows.w[weight])
                && cache.x[element].row(lane) == self.rows.x[element].row(lane)
        })
    }

    /// Computes the accelerations of the groups that are not cached.
    fn compute_not_cached(&mut self, cache: &mut GroupCache<E>) {
        if self.scratch.not_cached.is_empty() {
            return;
        }
        let (x, v) = (Combination::of(POSITION), Combination::of(VELOCITY));
        let computed = self.accelerate(self.segment.evaluation_time(0.0), x, v);
        // [`Self::count`] counts it for these groups alone.
        self.evaluations -= 1;
        self.release_slots();
        for group in &self.scratch.not_cached {
            for row in 0..self.coupling.rows {
                let (element, lane) = self.place(row, *group);
                cache.a[element].set_row(lane, self.scratch.slots[computed][element].row(lane));
            }
        }
    }

    /// Stores the accelerations at the end of the tick in `cache` if the method has cached them, or else clears it.
    pub(super) fn store_or_clear(&mut self, cache: &mut GroupCache<E>, is_cached: bool) {
        cache.keys.clear();
        if is_cached {
            let key = self.cache_key(self.environment.parameters.times.end);
            cache.keys.resize(self.rows.groups, Some(key));
            // Allocates nothing once the lists have their lengths.
            cache.classes.clone_from(&self.scratch.classes);
            cache.w.clear();
            cache.w.extend_from_slice(self.rows.w);
            std::mem::swap(&mut self.scratch.slots[CACHED], &mut cache.a);
            let (x, rows) = (&mut cache.x, &*self.rows.x);
            x.resize(rows.len());
            Threads::share(self.threads, x, |first, x| {
                x.copy_from_slice(&rows[first..first + x.len()]);
            });
        }
    }
}
