//! Laws of single bodies.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::prelude::*;

use crate::laws::Law;
use crate::units::Scalar;

/// Laws of this body alone, such as its engines. Present only on bodies that have some.
#[derive(Component, Debug)]
pub struct OwnLaws {
    laws: Vec<Box<dyn Law<Scalar>>>,
    /// The place of each law among all that the body was given: it is added up there also after it was off.
    places: Vec<usize>,
    version: u64,
}

impl OwnLaws {
    /// These laws, added up.
    #[must_use]
    pub fn new(laws: Vec<Box<dyn Law<Scalar>>>) -> Self {
        let places = (0..laws.len()).collect();
        Self { laws, places, version: next_version() }
    }

    /// The laws.
    #[must_use]
    pub fn laws(&self) -> &[Box<dyn Law<Scalar>>] {
        &self.laws
    }

    pub(crate) const fn version(&self) -> u64 {
        self.version
    }

    /// Those of that name, and the others; none of the two is empty.
    pub(crate) fn split(self, name: &str) -> (Option<Self>, Option<Self>) {
        let all = self.places.into_iter().zip(self.laws);
        let (named, others): (Vec<_>, Vec<_>) = all.partition(|(_, law)| law.name() == name);
        (Self::of_places(named), Self::of_places(others))
    }

    /// Both in the order in which the body was given them.
    pub(crate) fn merge(self, other: Self) -> Self {
        let mut all: Vec<_> = self.places.into_iter().zip(self.laws).collect();
        all.extend(other.places.into_iter().zip(other.laws));
        all.sort_by_key(|(place, _)| *place);
        let (places, laws) = all.into_iter().unzip();
        Self { laws, places, version: next_version() }
    }

    fn of_places(laws: Vec<(usize, Box<dyn Law<Scalar>>)>) -> Option<Self> {
        let (places, laws): (Vec<_>, Vec<_>) = laws.into_iter().unzip();
        (!laws.is_empty()).then(|| Self { laws, places, version: next_version() })
    }
}

/// No two lists of laws have the same version, also on different bodies and in different worlds: an acceleration of
/// the one is never taken for one of the other.
fn next_version() -> u64 {
    static VERSIONS: AtomicU64 = AtomicU64::new(1);
    VERSIONS.fetch_add(1, Ordering::Relaxed)
}
