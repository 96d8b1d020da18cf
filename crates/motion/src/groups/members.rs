//! Queries of the bodies of groups, and their options by row.

use bevy_ecs::prelude::*;

use crate::kernels::{BodyOptions, RowOptions};
use crate::state::components::{Force, PhysicsBody, Quarantined, Transform};
use crate::state::coupling::Grouped;
use crate::state::method_state::LastStep;
use crate::tick::columns::OptionColumns;

/// The bodies of a system that move in groups.
pub(super) type Members<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static mut Transform,
        &'static mut PhysicsBody,
        &'static Force,
        Option<&'static mut LastStep>,
    ),
    (With<Grouped>, Without<Quarantined>),
>;

/// The anchors of groups.
pub(super) type Anchors<'w, 's> =
    Query<'w, 's, (Entity, &'static Transform, &'static PhysicsBody), Without<Grouped>>;

/// The options of members.
pub(super) type MemberOptions<'w, 's> = Query<'w, 's, OptionColumns, With<Grouped>>;

/// Looks options up by row.
pub(super) struct ByRow<'a, 'w, 's> {
    pub bodies: &'a [Entity],
    pub options: &'a MemberOptions<'w, 's>,
}

/// The options of a body.
pub(super) fn of_body<'a>(options: &'a MemberOptions, body: Entity) -> BodyOptions<'a> {
    options.get(body).map_or(BodyOptions::NONE, |columns| columns.options())
}

impl RowOptions for ByRow<'_, '_, '_> {
    fn row(&self, row: usize) -> BodyOptions<'_> {
        of_body(self.options, self.bodies[row])
    }
}
