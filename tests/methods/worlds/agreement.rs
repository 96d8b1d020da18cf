//! A body moves as in a world of one table, to the bit, whatever tables and options are beside it.

use bevy_ecs::prelude::*;
use motion::{
    AxisLocks, Damping, DampingModel, DampingRate, Drag, Gravity, GravityOff, Method, Orientation,
    OwnLaws, OwnSubsteps, SpeedLimit, StableId, Substeps, mark_method,
};

use super::{
    Bits, Environment, H, IMMOVABLE, add, bare_bits, crowd, engine, engines, pushes, starts, wells,
};
use crate::rigs::Lab;

const TICKS: usize = 200;

/// The one of the bodies that has an engine in a table of its own.
const ENGINE: usize = 3;

fn scenes() -> Vec<Environment> {
    let gravity = Some(Gravity::EARTH);
    let drag = |linear, quadratic| Some(Drag::new(linear, quadratic));
    let scenes = [
        Environment::falling(),
        Environment { gravity, drag: drag(0.3, 0.0), ..Environment::default() },
        Environment { gravity, drag: drag(0.1, 0.2), ..Environment::default() },
        Environment { gravity, wells: Some(wells()), ..Environment::default() },
        Environment { drag: drag(0.0, 0.1), wells: Some(wells()), ..Environment::default() },
    ];
    let dampings =
        [None].into_iter().chain(DampingModel::ALL.map(|model| Some(Damping { model, rate: 0.4 })));
    let dampings: Vec<_> = dampings.collect();
    let varied = |scene: &Environment| {
        let of_damping = |damping: &Option<Damping>| {
            [None, Some(3)].map(|substeps| Environment {
                damping: *damping,
                substeps,
                ..scene.clone()
            })
        };
        dampings.iter().flat_map(of_damping).collect::<Vec<_>>()
    };
    scenes.iter().flat_map(varied).collect()
}

/// Puts a body into a table of its own that changes nothing about how it moves.
fn set_apart(lab: &mut Lab, body: Entity, kind: usize) {
    let rate = lab.world.get_resource::<Damping>().map(|damping| damping.rate);
    let substeps = lab.world.get_resource::<Substeps>().map_or(1, |substeps| substeps.0);
    let method = lab.stepper.method();
    let body = &mut lab.world.entity_mut(body);
    match kind {
        1 => body.insert(Orientation::default()),
        2 => body.insert(SpeedLimit(1e30)),
        ENGINE => body.insert(engines()),
        4 => body.insert(OwnSubsteps(substeps)),
        6 => body.insert(OwnLaws::new(vec![])),
        7 => {
            mark_method(body, Some(method));
            body
        }
        8 => body.insert(DampingRate::new(rate.unwrap_or(0.0))),
        9 => body.insert((Orientation::default(), SpeedLimit(1e30), OwnSubsteps(substeps))),
        10 => body.insert(AxisLocks::default()),
        _ => body,
    };
}

/// The bodies at the end, in the order of [`starts`].
fn in_a_world(scene: &Environment, method: Method, apart: bool, seed: u64) -> Vec<Bits> {
    let starts = starts();
    let mut lab = scene.lab(method, H);
    let mut bodies = vec![Entity::PLACEHOLDER; starts.len()];
    // 7 and 11 have no common factor: every body once, in another order.
    for i in (0..starts.len()).map(|k| (7 * k + 3) % starts.len()) {
        bodies[i] = lab.spawn(starts[i]);
        lab.insert(bodies[i], StableId(u32::try_from(i).unwrap()));
        if apart {
            set_apart(&mut lab, bodies[i], i);
        }
    }
    for pushes in pushes(seed, TICKS, starts.len()) {
        for (body, newtons) in pushes {
            lab.push(bodies[body], newtons);
        }
        lab.run(1);
    }
    bodies.into_iter().map(|body| lab.bits(body)).collect()
}

/// The same in one table, or the body with an engine alone, because no other body has its law.
fn in_one_table(scene: &Environment, method: Method, alone: Option<usize>, seed: u64) -> Vec<Bits> {
    let mut bare = scene.bare(method, H);
    if alone.is_some() {
        bare = bare.with_law(engine());
    }
    let starts = starts();
    let bodies: Vec<_> =
        (0..starts.len()).filter(|i| alone.is_none_or(|only| only == *i)).collect();
    for i in &bodies {
        add(&mut bare, starts[*i]);
    }
    for pushes in pushes(seed, TICKS, starts.len()) {
        for (body, newtons) in pushes {
            if let Some(row) = bodies.iter().position(|i| *i == body) {
                bare.push(row, newtons.to_array());
            }
        }
        bare.tick();
    }
    (0..bodies.len()).map(|row| bare_bits(&bare, row)).collect()
}

fn named(i: usize, [x, y, z, u, v, w]: Bits) -> String {
    format!("{i}: {:?}", [x, y, z, u, v, w].map(f64::from_bits))
}

fn same(world: &[Bits], arrays: &[Bits], what: &dyn Fn() -> String) {
    for (i, (world, arrays)) in world.iter().zip(arrays).enumerate() {
        assert_eq!(named(i, *world), named(i, *arrays), "{}", what());
    }
    let start = starts()[IMMOVABLE];
    assert_eq!(world[IMMOVABLE], super::bits(start.x, start.v), "{}", what());
}

#[test]
fn tables_and_options_beside_change_no_bit() {
    for method in Method::ALL {
        for (seed, scene) in scenes().iter().enumerate() {
            let seed = seed as u64;
            let what = |why: &str| format!("{method:?} {why} {scene:?}");
            let mut arrays = in_one_table(scene, method, None, seed);
            same(&in_a_world(scene, method, false, seed), &arrays, &|| what("in one table"));
            arrays[ENGINE] = in_one_table(scene, method, Some(ENGINE), seed)[0];
            same(&in_a_world(scene, method, true, seed), &arrays, &|| what("in many tables"));
        }
    }
}

#[test]
fn gravity_that_is_off_for_a_body_is_no_gravity() {
    for method in Method::ALL {
        for scene in scenes() {
            let mut floating = crowd(&Environment { gravity: None, ..scene.clone() }, method);
            let mut lab = scene.lab(method, H);
            let mut off = Vec::new();
            for start in starts() {
                lab.spawn(start);
                off.push(lab.world.spawn((start.components(), GravityOff, StableId(0))).id());
            }
            floating.run(50);
            lab.run(50);
            let off: Vec<_> = off.into_iter().map(|body| lab.bits(body)).collect();
            assert_eq!(off, floating.all_bits(&[]), "{method:?} {scene:?}");
        }
    }
}

/// Linear drag that an embedder adds is the scene's own drag.
#[test]
fn drag_among_other_laws_is_drag() {
    for method in Method::ALL {
        for damping in [None].into_iter().chain(DampingModel::ALL.map(Some)) {
            let drag = Drag::new(0.7, 0.0);
            let run = |as_resource: bool| {
                let damping = damping.map(|model| Damping { model, rate: 0.4 });
                let own = as_resource.then_some(drag);
                let mut lab =
                    Environment { drag: own, damping, ..Environment::falling() }.lab(method, H);
                if !as_resource {
                    lab.world.insert_resource(motion::Laws(vec![Box::new(drag)]));
                }
                lab.recompile();
                for start in starts() {
                    lab.spawn(start);
                }
                lab.run(20).all_bits(&[])
            };
            assert_eq!(run(true), run(false), "{method:?} {damping:?}");
        }
    }
}

/// In a world of few bodies and of many.
#[test]
fn substeps_change_from_tick_to_tick() {
    for method in Method::ALL {
        for scene in [
            Environment::falling(),
            Environment { gravity: Some(Gravity::EARTH), ..Environment::orbiting() },
        ] {
            for copies in [1, 30] {
                let mut lab = Environment { substeps: Some(1), ..scene.clone() }.lab(method, H);
                let mut bare = scene.bare(method, H);
                for start in starts().repeat(copies) {
                    lab.spawn(start);
                    add(&mut bare, start);
                }
                for substeps in [1, 3, 2] {
                    lab.world.resource_mut::<Substeps>().0 = substeps;
                    bare = bare.with_substeps(substeps);
                    lab.run(10);
                    (0..10).for_each(|_| bare.tick());
                    for row in 0..lab.bodies.len() {
                        assert_eq!(
                            lab.bits(row),
                            bare_bits(&bare, row),
                            "{method:?} {substeps} {scene:?}"
                        );
                    }
                }
            }
        }
    }
}
