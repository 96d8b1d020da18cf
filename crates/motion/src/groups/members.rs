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
    (Entity, &'static mut Transform, &'static mut PhysicsBody, &'static Force, Option<&'static mut LastStep>),
    (With<Grouped>, Without<Quarantined>),
>;

/// The options of members.
pub(super) type MemberOptions<'w, 's> = Query<'w, 's, OptionColumns, With<Grouped>>;

/// Looks options up by row.
pub(super) struct ByRow<'a, 'w, 's> {
    pub bodies: &'a [Entity],
    pub options: &'a MemberOptions<'w, 's>,
}

impl RowOptions for ByRow<'_, '_, '_> {
    fn row(&self, row: usize) -> BodyOptions<'_> {
        self.options.get(self.bodies[row]).map_or(BodyOptions::NONE, |columns| columns.options())
    }
}
