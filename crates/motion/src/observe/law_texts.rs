//! The laws of a world as text.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use crate::groups::Groups;
use crate::laws::damping::Damping;
use crate::laws::own::OwnLaws;
use crate::laws::{Law, MutualGravity, laws};
use crate::state::archetypes::values;

/// The laws of a world as text, with their parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct LawTexts {
    /// Forces between bodies: groups, springs, mutual gravity.
    pub between_bodies: Vec<String>,
    /// The laws of every body, in the order in which they are summed, then the number of own laws by name.
    pub on_bodies: Vec<String>,
    /// The damping model and its rate.
    pub damping: Option<String>,
}

impl LawTexts {
    /// Describes the laws of `world`.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let mut own = BTreeMap::new();
        for law in values::<OwnLaws>(world).flat_map(OwnLaws::laws) {
            *own.entry(law.name()).or_insert(0) += 1;
        }
        let own = own.into_iter().map(|(name, count)| format!("{name}: {count}"));
        Self {
            between_bodies: between_bodies(world),
            on_bodies: laws(world).map(Law::text).chain(own).collect(),
            damping: world
                .get_resource()
                .map(|Damping { model, rate }| format!("damping {} {rate} 1/s", model.name())),
        }
    }
}

fn between_bodies(world: &World) -> Vec<String> {
    let Some(groups) = world.get_resource::<Groups>() else { return Vec::new() };
    let count =
        |count: usize, one: &str| format!("{count} {one}{}", if count == 1 { "" } else { "s" });
    let bodies = if groups.bodies() == 1 { "body" } else { "bodies" };
    let mut texts =
        vec![count(groups.len(), "group") + &format!(" of {} {bodies}", groups.bodies())];
    if groups.springs() > 0 {
        texts.push(count(groups.springs(), "spring"));
    }
    if let Some(MutualGravity { constant, softening }) = world.get_resource() {
        texts.push(format!("mutual gravity {constant} m³/(kg s²), softened over {softening} m"));
    }
    texts
}
