//! Own laws: the laws of a single body.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::laws::{Law, RidingWells};

/// Laws of this body alone, such as its engines. Present only on bodies with their own laws.
#[derive(Component, Debug)]
#[component(on_insert = move_wells)]
pub struct OwnLaws {
    laws: Vec<Box<dyn Law>>,
    /// Index of each law among all that the body was given: a law that is switched on again is summed at its old place.
    places: Vec<usize>,
    version: u64,
}

/// Lets the wells of a body that ride on others move with them.
fn move_wells(mut world: DeferredWorld<'_>, context: HookContext) {
    let laws = world.get::<OwnLaws>(context.entity).into_iter().flat_map(|own| &own.laws);
    let wells = laws.filter_map(|law| law.riding_well().cloned()).collect();
    RidingWells::add_those_of(&mut world, context.entity, wells);
}

impl OwnLaws {
    /// Makes a component of laws whose accelerations are summed in this order.
    #[must_use]
    pub fn new(laws: Vec<Box<dyn Law>>) -> Self {
        let places = (0..laws.len()).collect();
        Self { laws, places, version: next_version() }
    }

    /// The laws, in the order in which they are summed.
    #[must_use]
    pub fn laws(&self) -> &[Box<dyn Law>] {
        &self.laws
    }

    pub(crate) fn version(&self) -> u64 {
        // Shifted above the version numbers of lists, which stay far smaller.
        let of_laws = self.laws.iter().filter_map(|law| law.version());
        of_laws.fold(self.version, |sum, version| sum.wrapping_add(version << 40))
    }

    /// Splits the laws into those with that name and the others; `None` instead of an empty list.
    pub(crate) fn split(self, name: &str) -> (Option<Self>, Option<Self>) {
        let all = self.places.into_iter().zip(self.laws);
        let (named, others): (Vec<_>, Vec<_>) = all.partition(|(_, law)| law.name() == name);
        (Self::of_places(named), Self::of_places(others))
    }

    /// Joins two lists of laws in the order in which the body was given them.
    pub(crate) fn merge(self, other: Self) -> Self {
        let mut all: Vec<_> = self.places.into_iter().zip(self.laws).collect();
        all.extend(other.places.into_iter().zip(other.laws));
        all.sort_by_key(|(place, _)| *place);
        let (places, laws) = all.into_iter().unzip();
        Self { laws, places, version: next_version() }
    }

    fn of_places(laws: Vec<(usize, Box<dyn Law>)>) -> Option<Self> {
        let (places, laws): (Vec<_>, Vec<_>) = laws.into_iter().unzip();
        (!laws.is_empty()).then(|| Self { laws, places, version: next_version() })
    }
}

/// A new version number. No two lists of laws share one, not even on different bodies or in different worlds, so that
/// no cached acceleration is used with other laws.
fn next_version() -> u64 {
    static VERSIONS: AtomicU64 = AtomicU64::new(1);
    VERSIONS.fetch_add(1, Ordering::Relaxed)
}
