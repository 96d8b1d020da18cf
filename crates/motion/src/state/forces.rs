//! Applied forces: a push reaches a body, acts for one tick and is cleared.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::state::components::Force;
use crate::units::Vector;

/// Bodies whose [`Force`] is cleared at the end of the tick, and the forces that came too late for it.
#[derive(Resource, Debug, Default)]
pub struct PushedBodies {
    /// The pushed bodies; a body that was pushed twice is listed twice.
    pub(crate) bodies: Vec<Entity>,
    /// Forces that were added after the integration, for the next tick.
    late: Vec<Push>,
    /// Whether the bodies of this tick are integrated; until the forces are cleared.
    is_closed: bool,
}

impl PushedBodies {
    /// Keeps forces that are added from now on for the next tick: this one is integrated.
    pub(crate) const fn close(&mut self) {
        self.is_closed = true;
    }

    /// The forces that were added for the coming tick.
    pub(crate) fn forces(world: &World) -> Vec<Push> {
        let mut bodies = world.resource::<Self>().bodies.clone();
        bodies.sort_unstable();
        bodies.dedup();
        let push = |body| Some(Push { body, newtons: world.get::<Force>(body)?.0 });
        bodies.into_iter().filter_map(push).collect()
    }

    /// Replaces the forces that were added for the coming tick.
    pub(crate) fn replace(world: &mut World, forces: &[Push]) {
        let before = std::mem::take(&mut world.resource_mut::<Self>().bodies);
        let none = before.into_iter().map(|body| Push { body, newtons: Vector::ZERO });
        for Push { body, newtons } in none.chain(forces.iter().copied()) {
            if let Some(mut force) = world.get_mut::<Force>(body) {
                force.0 = newtons;
            }
        }
        world.resource_mut::<Self>().bodies.extend(forces.iter().map(|push| push.body));
    }
}

/// The way for systems to write a [`Force`]: the tutorial's `AddForce`.
#[derive(SystemParam)]
pub struct Forces<'w, 's> {
    forces: Query<'w, 's, &'static mut Force>,
    pushed: ResMut<'w, PushedBodies>,
}

impl Forces<'_, '_> {
    /// Adds `newtons`, N, to the force on `body` in this tick, or in the next one if this one is integrated already. Does
    /// nothing if the entity has no physics or no longer exists.
    pub fn add(&mut self, body: Entity, newtons: Vector) {
        if self.pushed.is_closed {
            self.pushed.late.push(Push { body, newtons });
        } else if let Ok(mut force) = self.forces.get_mut(body) {
            force.bypass_change_detection().0 += newtons;
            self.pushed.bodies.push(body);
        }
    }

    /// Clears every force of the tick that is over, then adds those that came too late for it.
    pub(crate) fn clear(&mut self) {
        let PushedBodies { bodies, late, is_closed } = &mut *self.pushed;
        for body in bodies.drain(..) {
            if let Ok(mut force) = self.forces.get_mut(body) {
                force.bypass_change_detection().0 = Vector::ZERO;
            }
        }
        *is_closed = false;
        for Push { body, newtons } in std::mem::take(late) {
            self.add(body, newtons);
        }
    }
}

/// A force applied to a body.
///
/// `B` names a body, as in [`Request`](crate::Request).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push<B = Entity> {
    /// The body that is pushed.
    pub body: B,
    /// Force, N.
    pub newtons: Vector,
}

#[cfg(feature = "serde")]
crate::names::written_as_tuple!(Push<B> { body, newtons });

/// Sums the forces of `pushes` on each body, N.
pub(crate) fn sum_by_body(pushes: impl Iterator<Item = Push>) -> EntityHashMap<Vector> {
    let mut sums = EntityHashMap::<Vector>::default();
    pushes.for_each(|push| *sums.entry(push.body).or_default() += push.newtons);
    sums
}

/// The pushes for the next tick.
///
/// An edge push (a click) waits here for the next tick and acts in that tick only: it is neither lost in a frame
/// without a tick nor doubled in a frame with two. A sustained push (a held key) acts in every tick that begins while it is
/// in the queue.
#[derive(Resource, Debug, Default)]
pub struct PushQueue {
    edges: Vec<Push>,
    sustained: Vec<Push>,
}

impl PushQueue {
    /// Pushes `body` with `newtons` for exactly one tick, the next one.
    pub fn push_once(&mut self, body: Entity, newtons: Vector) {
        self.edges.push(Push { body, newtons });
    }

    /// Replaces the sustained pushes. These act in every tick until they are replaced again.
    pub fn sustain(&mut self, pushes: impl IntoIterator<Item = Push>) {
        self.sustained.clear();
        self.sustained.extend(pushes);
    }

    /// Number of edge pushes that wait for the next tick.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.edges.len()
    }

    /// The edge pushes that wait for the next tick.
    #[must_use]
    pub fn edges(&self) -> &[Push] {
        &self.edges
    }

    /// The sustained pushes.
    #[must_use]
    pub fn sustained(&self) -> &[Push] {
        &self.sustained
    }

    /// Every push that the next tick will apply.
    pub fn pending(&self) -> impl Iterator<Item = Push> + '_ {
        self.edges.iter().chain(&self.sustained).copied()
    }

    /// The pushes of the tick that begins: takes those of one tick, and leaves the sustained ones.
    pub(crate) fn take(&mut self) -> impl Iterator<Item = Push> + '_ {
        self.edges.drain(..).chain(self.sustained.iter().copied())
    }
}
