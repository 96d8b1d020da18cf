//! Which bodies a system integrates, chosen when the schedule is compiled: one system serves all methods.

use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;
use bevy_ecs::query::{QueryBuilder, QueryData, QueryFilter};
use bevy_ecs::system::QueryParamBuilder;

use crate::methods::markers::{OwnMethod, marker};
use crate::methods::table::Method;

/// Components that the bodies of a system have, and components that they lack.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyFilter {
    with: Vec<ComponentId>,
    without: Vec<ComponentId>,
}

impl BodyFilter {
    /// The bodies with this method of their own, or those that use the world's.
    pub fn of_method(world: &mut World, own: Option<Method>) -> Self {
        match own {
            Some(method) => Self { with: vec![marker(world, method)], without: Vec::new() },
            None => {
                Self { with: Vec::new(), without: vec![world.register_component::<OwnMethod>()] }
            }
        }
    }

    /// Restricts the filter to bodies that have `C`.
    #[must_use]
    pub fn with<C: Component>(mut self, world: &mut World) -> Self {
        self.with.push(world.register_component::<C>());
        self
    }

    /// Restricts the filter to bodies that lack `C`.
    #[must_use]
    pub fn without<C: Component>(mut self, world: &mut World) -> Self {
        self.without.push(world.register_component::<C>());
        self
    }

    /// A query of these bodies, for a system.
    pub fn query<D: QueryData, F: QueryFilter>(
        &self,
    ) -> QueryParamBuilder<impl FnOnce(&mut QueryBuilder<D, F>)> {
        QueryParamBuilder::new(|query: &mut QueryBuilder<D, F>| self.select(query))
    }

    /// Restricts a query to these bodies.
    pub fn select<D: QueryData, F: QueryFilter>(&self, query: &mut QueryBuilder<D, F>) {
        for component in &self.with {
            query.with_id(*component);
        }
        for component in &self.without {
            query.without_id(*component);
        }
    }
}
