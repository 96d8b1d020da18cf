//! The cached accelerations of a group.

use super::GroupField;
use super::classes::Class;
use crate::groups::combination::{CACHED, Combination, FIRST, POSITION, VELOCITY};
use crate::groups::rows::{Row, RowArray};
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
    /// A hash in place of the classes of rows, if the cache comes from another world.
    kinds: Option<u64>,
}

impl<T: Real> GroupCache<T> {
    /// The cache of rows at `x` of inverse masses `w`.
    pub fn of(x: &[Row<T>], w: Vec<T>, a: &[Row<T>], time: Scalar, kinds: u64) -> Self {
        let mut cache = Self { w, time: Some(time), kinds: Some(kinds), ..Self::default() };
        cache.x.copy(x);
        cache.a.copy(a);
        cache
    }

    /// A hash of the versions of own laws.
    pub fn versions(laws: impl Iterator<Item = u64>) -> u64 {
        laws.fold(0, |sum, version| sum.wrapping_add(version).wrapping_mul(0x100_0000_01b3))
    }

    /// Sets the laws that it was computed with.
    pub fn under(&mut self, epoch: u64, own: u64, attraction: Option<MutualGravity>) {
        (self.epoch, self.own, self.attraction) = (epoch, own, attraction);
    }

    /// Whether it was computed with these laws.
    pub fn is_under(&self, epoch: u64, own: u64, attraction: Option<&MutualGravity>) -> bool {
        (self.epoch, self.own) == (epoch, own) && self.attraction.as_ref() == attraction
    }

    /// Whether it was computed at the positions `x` and inverse masses `w`.
    pub fn is_of(&self, x: &[Row<T>], w: &[T]) -> bool {
        self.w == w && *self.x == *x
    }

    /// Time of the accelerations, s; `None` if nothing is cached.
    pub const fn time(&self) -> Option<Scalar> {
        self.time
    }

    /// The accelerations, m/s².
    pub fn accelerations(&self) -> &[Row<T>] {
        &self.a
    }

    /// A hash of the classes of rows, the same in every world.
    pub fn kinds(&self) -> u64 {
        self.kinds.unwrap_or_else(|| kinds(&self.classes, &self.class_of))
    }
}

/// An FNV-1a hash of the classes of rows, of their debug text.
fn kinds<T: Real>(classes: &[Class<T>], class_of: &[u32]) -> u64 {
    struct Fnv(u64);
    impl std::fmt::Write for Fnv {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            for byte in text.bytes() {
                self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
            }
            Ok(())
        }
    }
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    // Different finite numbers have different texts.
    let _ = std::fmt::write(&mut hash, format_args!("{classes:?}{class_of:?}"));
    hash.0
}

impl<T: Real> GroupField<'_, T> {
    /// The length of the last step of all rows. If rows differ, because a velocity was set or a body is new, all
    /// velocities are synchronized with their positions, and all rows start anew with a step of length 0.
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
        GroupCache::<T>::versions(
            self.rows.with_laws.iter().map(|row| self.options.row(*row as usize).laws_version),
        )
    }

    pub(super) fn recall(&mut self, cache: &GroupCache<T>, own: u64) -> Option<Combination<T>> {
        let terms = &self.environment.terms;
        let fits = cache.time == Some(terms.times.start)
            && (cache.epoch, cache.own) == (terms.epoch, own)
            && cache.attraction.as_ref() == self.environment.shared.attraction
            && match cache.kinds {
                None => cache.classes == self.scratch.classes && cache.class_of == self.scratch.class_of,
                Some(given) => given == kinds(&self.scratch.classes, &self.scratch.class_of),
            }
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
            cache.kinds = None;
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
