//! The compiler of groups, from springs, soft bodies and mutual gravity.

use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;

use super::coupling::{Coupling, SheetRow};
use super::pull::{SpringRow, Springs};
use super::{Group, Groups};
use crate::laws::{MutualGravity, PrescribedMotion, SourceMass};
use crate::methods::markers::{mark_method, own_method};
use crate::state::archetypes::may_exist;
use crate::state::components::{Force, PhysicsBody, Quarantined, StableId, Transform};
use crate::state::coupling::{CouplingChanged, Grouped};
use crate::state::emitter::{Dormant, Particle};
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::state::springs::{Link, SoftBody, Spring};
use crate::state::substeps::{AutoSubsteps, OwnSubsteps};
use crate::state::switched_off::SpringsOff;
use crate::units::{Scalar, at_least_0};

/// Compiles the groups again if the coupling has changed: a spring was added or removed, a body was removed,
/// quarantined or became immovable. The order in which forces are summed follows from stable ids, not from the order
/// of spawning.
///
/// All members get the method and the number of substeps of the member with the lowest id.
pub fn compile_groups(world: &mut World) {
    update_groups(world, false);
}

/// Whether the coupling has changed since the groups were compiled.
pub(crate) fn is_outdated(world: &World) -> bool {
    world.get_resource::<CouplingChanged>().is_some_and(|changed| changed.0)
}

/// [`compile_groups`]; with `may_be_new`, also checks whether a world without groups needs them.
pub(crate) fn update_groups(world: &mut World, may_be_new: bool) {
    if may_be_new {
        let springs = may_exist::<Spring>(world) || may_exist::<SoftBody>(world);
        let springs = springs && !world.contains_resource::<SpringsOff>();
        let chooses = may_exist::<AutoSubsteps>(world);
        let wanted = springs || chooses || world.contains_resource::<MutualGravity>();
        if wanted && !world.contains_resource::<Groups>() {
            world.init_resource::<Groups>();
            world.insert_resource(CouplingChanged(true));
        }
        if !wanted && world.contains_resource::<Groups>() {
            compile(world);
            world.remove_resource::<Groups>();
            world.remove_resource::<CouplingChanged>();
        }
        let reasons = (springs, chooses, world.contains_resource::<MutualGravity>());
        if let Some(mut groups) = world.get_resource_mut::<Groups>()
            && groups.reasons != reasons
        {
            groups.reasons = reasons;
            CouplingChanged::set(world);
        }
    }
    if is_outdated(world) {
        compile(world);
    }
}

/// A coupling and its bodies by row.
pub(crate) type Coupled = (Coupling, Vec<Entity>);

/// The couplings that the groups of `world` will have; `None` if they are not outdated. Leaves the groups as they are, so
/// that observing changes nothing.
pub(crate) fn coming_couplings(world: &World) -> Option<Vec<Coupled>> {
    let mut groups = world.get_resource::<Groups>().into_iter().flat_map(|groups| &groups.list);
    let gone = groups.any(|group| group.bodies.iter().any(|body| world.get_entity(*body).is_err()));
    let attracts = world.contains_resource::<MutualGravity>();
    let graph = (gone || is_outdated(world)).then(|| Graph::of(world)).flatten();
    graph.map(|graph| graph.groups(attracts))
}

/// The couplings of `world` with their bodies by row; those in `coming` if it is given.
pub(crate) fn couplings<'a>(
    world: &'a World,
    coming: Option<&'a [Coupled]>,
) -> impl Iterator<Item = (&'a Coupling, &'a [Entity])> {
    let made = world.get_resource::<Groups>().filter(|_| coming.is_none());
    let made = made.into_iter().flat_map(|groups| &groups.list);
    let made = made.map(|group| (&group.coupling, &group.bodies[..]));
    made.chain(coming.unwrap_or_default().iter().map(|(coupling, bodies)| (coupling, &bodies[..])))
}

/// A body that may be part of a group.
#[derive(Clone, Copy)]
struct Node {
    entity: Entity,
    inverse_mass: Scalar,
    /// Mass as a source of gravity, kg, of an immovable body.
    source: Scalar,
    /// Whether it chooses its substeps: then it is a group, even alone.
    auto: bool,
}

/// The graph of springs, sheets and mutual gravity between bodies.
#[derive(Default)]
struct Graph {
    nodes: Vec<Node>,
    springs: Springs,
    /// Triangles in air. Their masses are computed once the groups are known.
    sheets: Vec<SheetRow>,
    /// The prescribed motions of immovable nodes, by node.
    motions: Vec<(usize, PrescribedMotion)>,
}

/// Compiles the groups.
fn compile(world: &mut World) {
    register(world);
    let graph = Graph::of(world).expect("its components are registered");
    graph.check();
    warn_inert_springs(world);
    let attracts = world.contains_resource::<MutualGravity>();
    let list = graph.groups(attracts);
    mark(world, &list);
    let group = |(coupling, bodies)| Group { coupling, bodies, ..Group::default() };
    let mut list: Vec<_> = list.into_iter().map(group).collect();
    agree(world, &mut list);
    let mut groups = world.resource_mut::<Groups>();
    groups.list = list;
    // The next tick looks for their rows.
    groups.forget_places();
    world.resource_mut::<CouplingChanged>().0 = false;
}

/// Logs, once per world, that springs to particles are inert.
fn warn_inert_springs(world: &mut World) {
    /// Inserted once the warning is logged.
    #[derive(Resource)]
    struct InertSpringsLogged;

    if !may_exist::<Particle>(world) || world.contains_resource::<InertSpringsLogged>() {
        return;
    }
    let mut springs = world.query::<(Entity, &Spring)>();
    let is_particle = |end: &Entity| world.get::<Particle>(*end).is_some();
    let ends = springs.iter(world).find_map(|(spring, Spring { ends, .. })| {
        ends.iter().find(|end| is_particle(end)).map(|end| (spring, *end))
    });
    if let Some((spring, end)) = ends {
        log::warn!(
            "the spring {spring} is inert: its end {end} is a particle of an emitter; join bodies that are in no pool"
        );
        world.insert_resource(InertSpringsLogged);
    }
}

/// Registers the components that [`Graph::of`] reads.
fn register(world: &mut World) {
    world.register_component::<PhysicsBody>();
    world.register_component::<Transform>();
    world.register_component::<Force>();
    world.register_component::<StableId>();
    world.register_component::<SourceMass>();
    world.register_component::<PrescribedMotion>();
    world.register_component::<AutoSubsteps>();
    world.register_component::<Quarantined>();
    world.register_component::<Particle>();
    world.register_component::<Dormant>();
    world.register_component::<Spring>();
    world.register_component::<SoftBody>();
}

impl Graph {
    /// The bodies and springs of `world`; `None` if groups were never compiled in it.
    fn of(world: &World) -> Option<Self> {
        let mut bodies = world.try_query_filtered::<(
            Entity,
            &PhysicsBody,
            Option<&StableId>,
            Option<&SourceMass>,
            Has<AutoSubsteps>,
            Option<&PrescribedMotion>,
        ), (
            With<Transform>,
            With<Force>,
            Without<Quarantined>,
            Without<Particle>,
            Without<Dormant>,
        )>()?;
        let mut nodes: Vec<_> = bodies
            .iter(world)
            .map(|(entity, body, id, source, auto, motion)| {
                let node = Node {
                    entity,
                    inverse_mass: if motion.is_some() { 0.0 } else { body.inverse_mass },
                    source: source.map_or(0.0, |source| source.0),
                    auto,
                };
                ((id.map_or(u32::MAX, |id| id.0), entity), node)
            })
            .collect();
        nodes.sort_unstable_by_key(|(order, _)| *order);
        let nodes: Vec<_> = nodes.into_iter().map(|(_, node)| node).collect();
        let number: EntityHashMap<u32> =
            (0..).zip(&nodes).map(|(i, node)| (node.entity, i)).collect();
        let mut motions = world.try_query::<(Entity, &PrescribedMotion)>()?;
        let motions = motions
            .iter(world)
            .filter_map(|(body, motion)| Some((*number.get(&body)? as usize, motion.clone())));
        let motions = motions.collect();
        let mut graph = Self { nodes, motions, ..Self::default() };
        if world.contains_resource::<SpringsOff>() {
            return Some(graph);
        }
        let room: usize =
            world.try_query::<&SoftBody>()?.iter(world).map(|soft| soft.springs.len()).sum();
        let mut springs: Vec<_> = world
            .try_query::<&Spring>()?
            .iter(world)
            .filter_map(|spring| {
                let [a, b] = spring.ends.map(|end| number.get(&end).copied());
                Some(SpringRow { ends: [a?, b?], elastic: spring.elastic })
            })
            .collect();
        // Springs with equal keys are interchangeable.
        springs.sort_unstable_by_key(|SpringRow { ends: [a, b], elastic }| {
            (*a.min(b), *a.max(b), elastic.bits())
        });
        graph.springs = Springs::with_room(springs.len() + room);
        springs.into_iter().for_each(|spring| graph.add_spring(spring));
        let mut softs: Vec<_> = world
            .try_query::<&SoftBody>()?
            .iter(world)
            .map(|soft| {
                let points: Vec<_> =
                    soft.points.iter().map(|point| number.get(point).copied()).collect();
                (points, soft)
            })
            .collect();
        // Soft bodies with equal keys are interchangeable, as single springs are.
        let pulls = |link: &Link| (link.ends, link.elastic.bits());
        softs.sort_by(|(points, soft), (others, other)| {
            let lowest = |points: &[Option<u32>]| points.iter().flatten().copied().min();
            let by_points = || lowest(points).cmp(&lowest(others)).then_with(|| points.cmp(others));
            by_points()
                .then_with(|| soft.springs.iter().map(pulls).cmp(other.springs.iter().map(pulls)))
        });
        for (points, soft) in softs {
            graph.add_soft_body(&points, soft);
        }
        Some(graph)
    }

    /// # Panics
    /// If a number is out of its range; the message names it.
    fn check(&self) {
        self.springs.iter().for_each(|spring| spring.elastic.check());
        self.nodes
            .iter()
            .for_each(|node| at_least_0(node.source, "the mass of a source of gravity", "kg"));
    }

    fn add_spring(&mut self, spring: SpringRow) {
        if spring.ends[0] != spring.ends[1] {
            self.springs.push(spring);
        }
    }

    fn add_soft_body(&mut self, points: &[Option<u32>], soft: &SoftBody) {
        let point = |i: u32| points.get(i as usize).copied().flatten();
        for link in &*soft.springs {
            if let [Some(a), Some(b)] = link.ends.map(point) {
                self.add_spring(SpringRow { ends: [a, b], elastic: link.elastic });
            }
        }
        if !soft.sheet {
            return;
        }
        let triangles: Vec<[u32; 3]> = soft
            .triangles
            .iter()
            .filter_map(|corners| {
                let [a, b, c] = corners.map(point);
                Some([a?, b?, c?])
            })
            .collect();
        let moves = |corner: &u32| self.nodes[*corner as usize].inverse_mass > 0.0;
        let blown = triangles.into_iter().filter(|corners| corners.iter().any(moves));
        self.sheets.extend(blown.map(|corners| SheetRow { corners, mass: 0.0 }));
    }

    /// The connected components, each with its bodies.
    fn groups(self, attracts: bool) -> Vec<Coupled> {
        let Self { nodes, mut springs, sheets, motions } = self;
        // NaN counts as attracting, so that the failure is found.
        let pulls = |source: Scalar| source > 0.0 || source.is_nan();
        let joined =
            |node: usize, used: &[bool]| used[node] || attracts && pulls(nodes[node].source);
        let mut used = vec![attracts; nodes.len()];
        for (node, used) in nodes.iter().zip(&mut used) {
            *used = (*used || node.auto) && node.inverse_mass > 0.0;
        }
        springs.iter().flat_map(|spring| spring.ends).for_each(|end| used[end as usize] = true);
        sheets
            .iter()
            .flat_map(|sheet| sheet.corners)
            .for_each(|corner| used[corner as usize] = true);
        let moves = |node: &usize| nodes[*node].inverse_mass > 0.0;
        let all = (0..nodes.len()).filter(|node| joined(*node, &used));
        let (movable, held): (Vec<_>, Vec<_>) = all.partition(moves);
        let order: Vec<usize> = movable.iter().chain(&held).copied().collect();
        let mut rows = vec![u32::MAX; nodes.len()];
        for (row, node) in (0..).zip(&order) {
            rows[*node] = row;
        }
        let row = |node: u32| rows[node as usize];
        springs.renumber(row);
        let whole = Coupling {
            rows: order.len(),
            movable: movable.len(),
            springs,
            sheets: sheets
                .iter()
                .map(|sheet| SheetRow { corners: sheet.corners.map(row), mass: sheet.mass })
                .collect(),
            attracts,
            masses: movable.iter().map(|node| 1.0 / nodes[*node].inverse_mass).collect(),
            sources: held.iter().map(|node| nodes[*node].source).collect(),
            motions: motions
                .into_iter()
                .filter(|(node, _)| rows[*node] != u32::MAX)
                .map(|(node, motion)| (rows[node] as usize, motion))
                .collect(),
            ..Coupling::default()
        };
        let bodies = |rows: &[usize]| rows.iter().map(|row| nodes[order[*row]].entity).collect();
        whole.into_parts().into_iter().map(|part| (part.coupling, bodies(&part.rows))).collect()
    }
}

/// The movable bodies of couplings, in the order of rows.
pub(crate) fn members(list: &[Coupled]) -> impl Iterator<Item = Entity> {
    list.iter().flat_map(|(coupling, bodies)| bodies[..coupling.movable].iter().copied())
}

/// Marks exactly the bodies that move in groups.
fn mark(world: &mut World, list: &[Coupled]) {
    let now: EntityHashSet = members(list).collect();
    let mut marked = world.query_filtered::<Entity, With<Grouped>>();
    let before: EntityHashSet = marked.iter(world).collect();
    for body in before.difference(&now) {
        world.entity_mut(*body).remove::<Grouped>();
    }
    // In the order of rows, so that consecutive rows of a group are consecutive in a table.
    let new: Vec<_> =
        members(list).filter(|body| !before.contains(body)).map(|body| (body, Grouped)).collect();
    world.insert_batch(new);
}

/// Gives every member the method and substeps of the first.
fn agree(world: &mut World, list: &mut [Group]) {
    for group in list {
        let Some(first) = group.bodies.first().copied() else { continue };
        let method = own_method(world.entity(first));
        group.substeps = world.get::<OwnSubsteps>(first).map(|substeps| substeps.0.max(1));
        let substeps = world.get::<OwnSubsteps>(first).copied();
        let auto = world.get::<AutoSubsteps>(first).copied();
        group.chooses_substeps = auto.is_some();
        for body in &group.bodies[1..group.coupling.movable] {
            if own_method(world.entity(*body)) != method {
                // The new method cannot use the state of the old one.
                let mut body = world.entity_mut(*body);
                body.remove::<(LastStep, LastAcceleration)>();
                mark_method(&mut body, method);
            }
            set(world, *body, substeps);
            set(world, *body, auto);
        }
    }
}

/// Gives a body this value of a component, or takes the component away, if it differs.
fn set<C: Component + Copy + PartialEq>(world: &mut World, body: Entity, value: Option<C>) {
    if world.get::<C>(body).copied() != value {
        let mut body = world.entity_mut(body);
        match value {
            Some(value) => body.insert(value),
            None => body.remove::<C>(),
        };
    }
}
