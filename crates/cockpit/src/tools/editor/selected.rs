//! The selection as an entry of the scene's text.

use bevy_ecs::entity::Entity;
use motion::SoftBody;
use scene::{Entry, FileIndex};

use crate::stage::Stage;
use crate::stage::things::Thing;

/// The entry of the selection, and the name of the selection.
pub(crate) fn selected_entry(stage: &Stage) -> Option<(Entry, String)> {
    let thing = stage.selection()?;
    let points = stage.sim().world.get::<SoftBody>(thing).map(|soft| &soft.points);
    let body = points.map_or(Some(&thing), |points| points.first())?;
    let entry = stage.sim().scene.entry_of(stage.sim().id(*body)?)?;
    Some((entry, stage.name(thing)))
}

/// The path of the entry of the selection.
pub(super) fn selected_path(stage: &Stage) -> Option<String> {
    selected_entry(stage).map(|(entry, _)| entry.path())
}

/// Which body of the entry at `path` is selected, from 0.
pub(crate) fn offset_in_entry(stage: &Stage, path: Option<&str>) -> u32 {
    let offset = || {
        let (entry, _) = selected_entry(stage).filter(|(entry, _)| Some(&*entry.path()) == path)?;
        Some(stage.sim().id(stage.selection()?)? - entry.bodies.start)
    };
    offset().unwrap_or(0)
}

/// A body of the entry at `path`, or the soft body that it makes.
pub(crate) fn entity_at(stage: &Stage, path: &str, offset: u32) -> Option<Entity> {
    let entry = stage.sim().scene.entry_at(path)?;
    let thing = match entry.list {
        "soft_bodies" => Thing::Soft(FileIndex(u32::try_from(entry.index).ok()?)),
        _ => Thing::Body((entry.bodies.start + offset).min(entry.bodies.end.saturating_sub(1))),
    };
    thing.entity(stage.sim())
}
