//! A NaN written into each component before each system of a tick, in every shipped scene: the record names component
//! and system, the body keeps numbers, and no other body notices, bit for bit.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;
use glam::DVec3;
use history::Simulation;
use motion::internals::Grouped;
use motion::snapshot::LastStep;
use motion::{
    Damping, DampingModel, DampingRate, Dormant, Fault, Forces, Method, OwnLaws, Particle,
    PhysicsBody, Request, RidesOn, RidingWell, SpeedLimit, StableId, Static, Transform, own_method,
};
use scene::Scene;

use super::rig::{Harm, bits, is_finite, records, run, run_harmed, scenes, start, systems};
use crate::rigs::{Bits, Formula};

/// Ticks before the one that is disturbed, and ticks that are compared.
const LEAD: u64 = 3;
const AFTER: u64 = 3;

/// A component, with its field, that is overwritten.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Position,
    Velocity,
    InverseMass,
    Force,
    DampingRate,
    SpeedLimit,
    LastStep,
    OwnLaws,
}

impl Place {
    /// With the names that records have.
    const ALL: [(Self, &str); 8] = [
        (Self::Position, "Transform.position"),
        (Self::Velocity, "PhysicsBody.velocity"),
        (Self::InverseMass, "PhysicsBody.inverse_mass"),
        (Self::Force, "Force"),
        (Self::DampingRate, "DampingRate"),
        (Self::SpeedLimit, "SpeedLimit"),
        (Self::LastStep, "LastStep"),
        (Self::OwnLaws, "OwnLaws"),
    ];

    fn harm(self, body: Entity) -> Harm {
        Box::new(move |world| match self {
            Self::Position => world.get_mut::<Transform>(body).unwrap().position.y = f64::NAN,
            Self::Velocity => world.get_mut::<PhysicsBody>(body).unwrap().velocity.z = f64::NAN,
            Self::InverseMass => {
                world.get_mut::<PhysicsBody>(body).unwrap().inverse_mass = f64::NAN;
            }
            Self::Force => {
                SystemState::<Forces>::new(world)
                    .get_mut(world)
                    .unwrap()
                    .add(body, DVec3::X * f64::NAN);
            }
            Self::DampingRate => {
                world.entity_mut(body).insert(DampingRate::new(f64::NAN));
            }
            Self::SpeedLimit => {
                world.entity_mut(body).insert(SpeedLimit(f64::NAN));
            }
            Self::LastStep => world.get_mut::<LastStep>(body).unwrap().0 = f64::NAN,
            Self::OwnLaws => {
                let nowhere = Formula::new("nowhere", |_, _| DVec3::NAN);
                world.entity_mut(body).insert(OwnLaws::new(vec![Box::new(nowhere)]));
            }
        })
    }
}

/// A body that is harmed.
#[derive(Clone, Copy, Debug)]
struct Victim {
    body: Entity,
    id: StableId,
    method: Option<Method>,
    grouped: bool,
    /// It holds a group and does not move.
    anchor: bool,
    lawful: bool,
}

impl Victim {
    /// One of each kind that the world has.
    fn of(rig: &mut Simulation) -> Vec<Self> {
        let (mut kinds, mut found) = (Vec::new(), Vec::new());
        let mut bodies = rig
            .world
            .query_filtered::<(Entity, &StableId), (With<PhysicsBody>, Without<Dormant>)>();
        let mut all: Vec<_> = bodies.iter(&rig.world).map(|(body, id)| (*id, body)).collect();
        all.sort_unstable();
        // Where a carrier is, what rides on it acts: others would notice.
        let mut carriers: Vec<_> =
            rig.world.query::<&RidesOn>().iter(&rig.world).map(|rides| rides.0).collect();
        let mut own = rig.world.query::<&OwnLaws>();
        let laws = own.iter(&rig.world).flat_map(OwnLaws::laws);
        carriers.extend(laws.filter_map(|law| law.riding_well()).map(RidingWell::carrier));
        all.retain(|(_, body)| !carriers.contains(body));
        let springs = rig.world.contains_resource::<motion::internals::Groups>();
        for (id, body) in all {
            let entity = rig.world.entity(body);
            let rests = entity.contains::<Static>();
            let victim = Self {
                body,
                id,
                method: own_method(entity),
                grouped: entity.contains::<Grouped>(),
                anchor: rests && springs && is_held_by(&rig.world, body),
                lawful: entity.contains::<OwnLaws>(),
            };
            let movable = entity.get::<PhysicsBody>().is_some_and(|body| body.inverse_mass > 0.0);
            let Self { method, grouped, anchor, lawful, .. } = victim;
            let kind = (entity.contains::<Particle>(), method, grouped, anchor, lawful);
            if (movable || anchor) && !kinds.contains(&kind) {
                kinds.push(kind);
                found.push(victim);
            }
        }
        found
    }

    /// Whether the system integrates this body, or hangs others on it.
    fn is_of(&self, system: &str) -> bool {
        let who = self
            .method
            .map_or("Without<OwnMethod>".to_owned(), |method| format!("With<{method:?}>"));
        match base(system) {
            "integrate_groups" => self.anchor || self.grouped && system.contains(&who),
            "integrate" => !self.grouped && !self.anchor && system.contains(&who),
            "integrate_acceleration" | "integrate_velocity" | "integrate_in_one_pass" => {
                !self.grouped && !self.anchor && self.method.is_none()
            }
            _ => false,
        }
    }

    /// Whether the system looks at that component of this body.
    fn is_seen(&self, place: Place, system: &str, exact: bool) -> bool {
        let sees = match (base(system), place) {
            ("integrate_acceleration", Place::DampingRate) => exact,
            ("integrate_velocity", Place::DampingRate) => !exact,
            ("integrate_acceleration", Place::SpeedLimit)
            | ("integrate_velocity", Place::Force) => false,
            _ => true,
        };
        sees && self.is_of(system)
    }

    fn has(&self, place: Place, world: &World) -> bool {
        match place {
            Place::Position | Place::Velocity => true,
            _ if self.anchor => false,
            Place::InverseMass | Place::Force | Place::SpeedLimit => true,
            Place::DampingRate => world.contains_resource::<Damping>(),
            Place::LastStep => world.entity(self.body).contains::<LastStep>(),
            Place::OwnLaws => self.lawful,
        }
    }
}

fn is_held_by(world: &World, body: Entity) -> bool {
    let ends = |entity: EntityRef<'_>| {
        entity.get::<motion::Spring>().is_some_and(|spring| spring.ends.contains(&body))
            || entity.get::<motion::SoftBody>().is_some_and(|soft| soft.points.contains(&body))
    };
    world.iter_entities().any(ends)
}

fn base(system: &str) -> &str {
    system.split('<').next().unwrap_or(system)
}

/// The states of all other bodies from the tick on in which one is removed.
type Reference = Vec<Vec<(u32, Bits)>>;

fn without(scene: &Scene, victim: &Victim, tick: u64) -> Reference {
    let mut rig = start(scene);
    run(&mut rig, tick - 1);
    rig.request(Request::Remove(victim.body));
    let states = (0..AFTER).map(|_| {
        run(&mut rig, 1);
        bits(&rig, victim.id)
    });
    states.collect()
}

/// The tick and the system by which it has to be noticed, if at all.
fn expected(
    victim: &Victim,
    place: Place,
    at: usize,
    systems: &[String],
    exact: bool,
) -> Option<(u64, String)> {
    let first = |systems: &[String]| {
        systems.iter().find(|system| victim.is_seen(place, system, exact)).cloned()
    };
    if let Some(system) = first(&systems[at..]) {
        return Some((LEAD + 1, system));
    }
    // A force that came too late is cleared; one that came after that acts in the next tick.
    let cleared = systems[at..].iter().any(|system| system == "clear_forces");
    (place != Place::Force || !cleared)
        .then(|| first(systems))
        .flatten()
        .map(|system| (LEAD + 2, system))
}

/// Harms one body in the middle of a tick and looks at what becomes of all.
fn check(
    name: &str,
    scene: &Scene,
    victim: &Victim,
    (place, component): (Place, &str),
    at: usize,
    kept: &mut HashMap<u64, Reference>,
) {
    let what = format!("{name}: {place:?} of {:?} before system {at}", victim.id);
    let mut rig = start(scene);
    run(&mut rig, LEAD);
    let systems = systems(&mut rig);
    let exact = rig
        .world
        .get_resource::<Damping>()
        .is_some_and(|damping| damping.model == DampingModel::Exact);
    let before = rig.world.get::<Transform>(victim.body).unwrap().position;
    run_harmed(&mut rig, at, place.harm(victim.body));
    let Some((tick, system)) = expected(victim, place, at, &systems, exact) else {
        run(&mut rig, AFTER);
        assert_eq!(records(&rig), [], "{what}");
        return;
    };
    let reference = kept.entry(tick).or_insert_with(|| without(scene, victim, tick));
    for (i, others) in reference.iter().enumerate() {
        if i > 0 || tick > LEAD + 1 {
            run(&mut rig, 1);
        }
        assert!(is_finite(&mut rig), "{what}, {i} ticks later");
        assert!(bits(&rig, victim.id) == *others, "{what}: others notice, {i} ticks later");
    }
    let records = records(&rig);
    assert_eq!(records.len(), 1, "{what}: {records:?}");
    assert_eq!((records[0].body, records[0].tick), (victim.body, tick), "{what}: {records:?}");
    let cause = records[0].cause;
    assert_eq!(cause.component, component, "{what}: {cause:?}");
    let fault = if place == Place::OwnLaws { Fault::Law("nowhere") } else { Fault::Found };
    assert_eq!(cause.fault, fault, "{what}: {cause:?}");
    match base(&system) {
        // Of an Euler step in one pass, one of its halves.
        "integrate_in_one_pass" => {
            assert!(cause.system.starts_with("integrate_"), "{what}: {cause:?}");
        }
        "integrate" if system.contains("plicitEuler") => {
            assert!(cause.system.starts_with("integrate"), "{what}: {cause:?}");
        }
        base => assert_eq!(cause.system, base, "{what}"),
    }
    let state = rig.world.entity(victim.body);
    if place == Place::Position && tick == LEAD + 1 {
        assert_eq!(
            state.get::<Transform>().unwrap().position,
            before,
            "{what}: it stays where it was"
        );
    }
    if place == Place::Velocity {
        assert_eq!(state.get::<PhysicsBody>().unwrap().velocity, DVec3::ZERO, "{what}");
    }
}

#[test]
fn a_nan_in_any_component_before_any_system_of_any_scene_is_named_and_harms_no_other() {
    let mut checked = 0;
    for (name, scene) in scenes() {
        let mut rig = start(&scene);
        run(&mut rig, LEAD);
        let systems = systems(&mut rig);
        for victim in Victim::of(&mut rig) {
            let mut kept = HashMap::new();
            for place in Place::ALL {
                if !victim.has(place.0, &rig.world) {
                    continue;
                }
                for at in 0..systems.len() {
                    check(name, &scene, &victim, place, at, &mut kept);
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 1_500, "{checked}");
}
