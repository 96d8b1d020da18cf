//! Forces that are shown are those that acted: for every body they sum up to its mass times the change of its velocity.

use std::collections::BTreeSet;

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::effects::Effect;
use motion::internals::Solver;
use motion::{
    BodyState, Damping, DampingModel, Dormant, EvaluationTime, ForceCause, Jacobians, Laws,
    METHODS, Method, OwnLaws, PhysicsBody, Push, PushQueue, Quarantined, Request, Requests,
    SpeedLimit, StableId, TimeStep, Transform,
};
use scene::Scene;

use crate::rigs::{Formula, scene_of};

/// Toomre and Toomre 1972: a passing mass draws a bridge and a tail out of a disk that turns as it passes, and none out of one
/// that turns the other way.
#[test]
fn tides_of_a_passing_galaxy_tear_at_the_disk_that_turns_with_it() {
    let text = scene::shipped().iter().find(|scene| scene.name == "galaxies").unwrap().text;
    let turned = text.replace(".0, speed_m_s", ".0, axis: (0.0, -1.0, 0.0), speed_m_s");
    assert_eq!(turned.matches("axis: (0.0, -1.0, 0.0), speed").count(), 10);
    // Stars of the outermost ring, which began at 13 m, by their distance from the core 9 s later.
    let far = |text: &str| {
        let mut run = Simulation::new(scene_of(text));
        run.run(286);
        let place = |run: &Simulation, name: &str| {
            run.world.get::<Transform>(run.named(name).unwrap()).unwrap().position
        };
        let [core, visitor] = ["core", "visitor"].map(|name| place(&run, name));
        assert!((core.distance(visitor) - 20.0).abs() < 0.1, "{}", core.distance(visitor));
        run.run(254);
        let core = place(&run, "core");
        let stars: Vec<_> =
            (0..182).map(|star| place(&run, &format!("ring10.{star}")).distance(core)).collect();
        (
            stars.iter().filter(|meters| **meters > 20.0).count(),
            stars.into_iter().fold(0.0, f64::max),
        )
    };
    let ((torn, _), (whole, farthest)) = (far(text), far(&turned));
    assert!(torn > 45, "{torn} of 182 stars beyond 20 m");
    assert_eq!(whole, 0, "{farthest} m");
}

/// A step that is short against everything that moves, s.
const SHORT: f64 = 1.0 / (1_u64 << 27) as f64;

/// Bodies of a scene that are looked at.
const SAMPLE: usize = 400;

fn run_of(scene: &Scene, method: Method) -> Simulation {
    Simulation::new(Scene { method, ..scene.clone() })
}

fn forces_on(run: &mut Simulation, body: usize) -> Vec<(ForceCause, DVec3)> {
    motion::forces_on(&run.world, run.bodies[body])
}

fn names_on(run: &mut Simulation, body: usize) -> BTreeSet<&'static str> {
    forces_on(run, body).into_iter().map(|(cause, _)| cause.name()).collect()
}

/// The velocity of a body that forces move.
fn moving(world: &World, body: Entity) -> Option<PhysicsBody> {
    let body = world.get_entity(body).ok()?;
    let state = *body.get::<PhysicsBody>()?;
    let free = !body.contains::<Quarantined>() && !body.contains::<Dormant>();
    (free && state.inverse_mass > 0.0).then_some(state)
}

fn is_at_its_limit(world: &World, body: Entity) -> bool {
    let limit = world.get::<SpeedLimit>(body).map_or(f64::INFINITY, |limit| limit.0);
    moving(world, body).is_some_and(|state| state.velocity.length() >= limit * (1.0 - 1e-12))
}

/// Compares the forces on a sample of the bodies with what a short step does to their velocities; gives how many
/// were compared. `push` is asked for pushes in that step.
fn check(run: &mut Simulation, what: &str, push: impl Fn(usize) -> Option<DVec3>) -> usize {
    run.world.insert_resource(TimeStep(SHORT));
    // The kick of position Verlet is half of this step's and half of the last one's.
    run.tick();
    let all = run.bodies.iter().copied().filter(|body| moving(&run.world, *body).is_some());
    let all: Vec<_> = all.filter(|body| !is_at_its_limit(&run.world, *body)).collect();
    let sample: Vec<_> = all.iter().copied().step_by(all.len().div_ceil(SAMPLE).max(1)).collect();
    let push = |(place, body): (usize, &Entity)| Some(Push { body: *body, newtons: push(place)? });
    let pushes: Vec<_> = sample.iter().enumerate().filter_map(push).collect();
    let mut queue = run.world.resource_mut::<PushQueue>();
    pushes.iter().for_each(|push| queue.push_once(push.body, push.newtons));
    let mut sums = vec![(DVec3::ZERO, 0.0); sample.len()];
    motion::each_force(&run.world, &pushes, &sample, |place, _, newtons| {
        let (sum, size) = &mut sums[place];
        *sum += newtons;
        *size += newtons.length();
    });
    let before: Vec<_> = sample.iter().map(|body| moving(&run.world, *body).unwrap()).collect();
    run.tick();
    let mut ends = vec![DVec3::ZERO; sample.len()];
    motion::each_force(&run.world, &pushes, &sample, |place, _, newtons| ends[place] += newtons);
    let mut compared = 0;
    for (place, body) in sample.iter().enumerate() {
        let Some(after) = moving(&run.world, *body).filter(|_| !is_at_its_limit(&run.world, *body))
        else {
            continue;
        };
        let (before, (start, size), end) = (before[place], sums[place], ends[place]);
        let acted = (after.velocity - before.velocity) / SHORT * before.mass();
        // What rounding the velocity leaves of its change, and rounding places of springs at rest.
        let rounding =
            8.0 * f64::EPSILON * before.velocity.length() / SHORT * before.mass() + 1e-12;
        // A method evaluates at the start of a step, at its end, or between, which tells something where they differ little.
        let allowed = 1e-6 * size + rounding;
        let apart = |shown: DVec3| (acted - shown).length();
        let change = end - start;
        let part = (acted - start).dot(change) / change.length_squared().max(f64::MIN_POSITIVE);
        let between = apart(start + change * part.clamp(0.0, 1.0));
        // A support that moves stretches a spring at rest within the step, by less than a micronewton.
        let by_supports = if run.scene.motions.is_empty() { 0.0 } else { 1e-6 };
        let differ_little = change.length() <= 1e-3 * size + rounding + by_supports;
        assert!(
            apart(start) <= allowed || apart(end) <= allowed || differ_little && between <= allowed,
            "{what}, body {:?}: {acted} N acted, {start} to {end} N are shown, {between:e} apart, of {size:e}",
            run.world.get::<StableId>(*body)
        );
        compared += 1;
    }
    run.world.insert_resource(TimeStep(1.0 / run.scene.step_hz));
    compared
}

const NO_PUSH: fn(usize) -> Option<DVec3> = |_| None;

#[test]
fn in_every_shipped_scene_the_forces_shown_are_those_that_act() {
    for shipped in scene::shipped() {
        let scene = shipped.load().unwrap();
        let mut run = run_of(&scene, scene.method);
        let size = scene.bodies.len();
        let movable =
            scene.bodies.iter().filter(|body| body.inverse_mass.is_some_and(|w| w > 0.0)).count();
        let emits = scene.declared.iter().any(|declared| declared.effect == Effect::Emitters);
        for ticks in if size > 5_000 { [0, 5, 20] } else { [0, 50, 250] } {
            let what = format!("{} after {ticks} more ticks", scene.name);
            run.run(ticks);
            let compared = check(&mut run, &what, NO_PUSH);
            // Particles are not born yet, and a body may be at its limit of speed.
            assert!(emits || movable == 0 || compared > 0, "{what}");
            let kick = |place: usize| place.is_multiple_of(3).then_some(DVec3::new(0.3, -2.0, 5.0));
            run.tick();
            check(&mut run, &format!("{what}, pushed"), kick);
        }
    }
}

/// Anything but a law of this program: `a = (0.1 y, -0.2 x, 0.3 vz) + (0, 0, t)`.
fn embedded() -> Box<Formula> {
    let acceleration = |at: EvaluationTime, body: BodyState| {
        let (x, v) = (body.position, body.velocity);
        DVec3::new(0.1 * x.y, -0.2 * x.x, 0.3 * v.z + at.time)
    };
    let jacobians = |_: BodyState| {
        let position = glam::DMat3::from_cols(DVec3::Y * -0.2, DVec3::X * 0.1, DVec3::ZERO);
        Jacobians { position, velocity: glam::DMat3::from_diagonal(DVec3::Z * 0.3) }
    };
    Box::new(Formula::new("embedded", acceleration).with_jacobians(jacobians).of_velocity(true))
}

/// Bodies that ask for something, alone and joined, and a cloth in gusts.
const EVERYTHING: &str = "version: 1, step_hz: 1000, seed: 3, gravity: (), drag: (linear_per_s: 0.3, quadratic_per_m: 0.2),
    wind: (velocity_m_s: (4, 0, 1), gust_m_s: 2, gust_hz: 0.7),
    wells: [(position_m: (9, 1, 2), strength_m3_s2: 30, softening_m: 0.2), (strength_m3_s2: 5, bodies: [\"b\"])],
    thrusts: [(body: \"a\", curve: sine(amplitude_n: (0, 3, 1), angular_frequency_rad_s: 6)),
              (body: \"c\", curve: polynomial([(1, 0, 0), (0, 2, 0)]), until_s: 0.3)],
    bodies: [
        (name: \"a\", position_m: (1, 2, 3), velocity_m_s: (1, -2, 0.5), mass_kg: 2),
        (name: \"b\", position_m: (-2, 1, 3), velocity_m_s: (3, 1, -0.5), mass_kg: 0.5, gravity_off: true, damping_per_s: 3),
        (name: \"c\", position_m: (-2, -4, 3), velocity_m_s: (0, 1, 2), mass_kg: 4, locked_axes: [y]),
        (name: \"d\", position_m: (5, -4, 3), velocity_m_s: (0, 1, 2), mass_kg: 4, max_speed_m_s: 50),
        (name: \"rock\", position_m: (0, 0, 0), immovable: true, mass_kg: 100),
        (name: \"wall\", shape: sphere(radius_m: 1), position_m: (9, 9, 9), scenery: true),
    ],
    soft_bodies: [cloth(name: \"flag\", rows: 4, columns: 5, corner_m: (0, 8, 0), along_m: (3, 0.5, 0), down_m: (0.2, -2, 0.4),
        mass_kg: 0.5, stiffness_n_m: 200, damping_n_s_m: 0.3, velocity_m_s: (0, 0.3, 1), pinned: [left_edge])],
    springs: [
        (between: (\"a\", \"flag.r1.c4\"), stiffness_n_m: 5, damping_n_s_m: 0.5, rest_length_m: 1),
        (between: (\"b\", \"rock\"), stiffness_n_m: 50, damping_n_s_m: 2, rest_length_m: 1),
        (between: (\"c\", \"b\"), stiffness_n_m: 7, rest_length_m: 9),
    ]";

fn everything(more: &str) -> Scene {
    scene_of(&format!("({EVERYTHING}, {more})"))
}

#[test]
fn under_every_method_and_damping_model_the_forces_of_all_causes_are_those_that_act() {
    for claims in METHODS {
        for model in DampingModel::ALL {
            let implicit = claims.method == Method::ImplicitEuler;
            let attract = if implicit { "" } else { "mutual_gravity: (constant_m3_kg_s2: 2), " };
            let damping = format!("damping: (model: {}, rate_per_s: 0.4)", model.name());
            let mut run = run_of(&everything(&format!("{attract}{damping}")), claims.method);
            run.world.insert_resource(Laws(vec![embedded()]));
            run.world.insert_resource(Solver {
                tolerance: 1e-13,
                newton_iterations: 12,
                ..Solver::default()
            });
            run.stepper.recompile(&mut run.world);
            for ticks in [0, 100, 150] {
                let what = format!("{:?}, {model:?}, {ticks} ticks", claims.method);
                let push =
                    |place: usize| place.is_multiple_of(2).then_some(DVec3::new(-3.0, 20.0, 8.0));
                run.run(ticks);
                assert!(check(&mut run, &what, push) > 15);
            }
            let shared = ["damping", "embedded", "wells"];
            let more = if implicit { vec![] } else { vec!["mutual_gravity"] };
            let all = |own: &[&'static str]| -> BTreeSet<_> {
                shared.iter().chain(&more).chain(own).copied().collect()
            };
            assert_eq!(names_on(&mut run, 0), all(&["gravity", "drag", "thrusts", "springs"]));
            assert_eq!(names_on(&mut run, 1), all(&["drag", "springs"]), "gravity passes it by");
            assert_eq!(names_on(&mut run, 3), all(&["gravity", "drag"]), "nothing holds it");
        }
    }
}

#[test]
fn springs_are_told_by_their_other_end_and_pull_both_alike() {
    let mut run = run_of(&everything("mutual_gravity: ()"), Method::RungeKutta4);
    run.run(30);
    let springs = |run: &mut Simulation, body| -> Vec<_> {
        let forces = forces_on(run, body).into_iter();
        forces
            .filter_map(|(cause, newtons)| match cause {
                ForceCause::Spring(other) => Some((other, newtons)),
                _ => None,
            })
            .collect()
    };
    let (b, c) = (springs(&mut run, 1), springs(&mut run, 2));
    let ends: BTreeSet<_> = b.iter().map(|(other, _)| *other).collect();
    assert_eq!(ends, BTreeSet::from([run.bodies[2], run.bodies[4]]));
    let (_, on_b) = *b.iter().find(|(other, _)| *other == run.bodies[2]).unwrap();
    let x = |body: usize| run.world.get::<Transform>(run.bodies[body]).unwrap().position;
    let d = x(2) - x(1);
    let pull = d.normalize() * (7.0 * (d.length() - 9.0));
    assert!((on_b - pull).length() < 1e-12 * pull.length(), "{on_b} {pull}");
    // Nothing moves along the locked axis.
    assert_eq!(c, [(run.bodies[1], -DVec3::new(on_b.x, 0.0, on_b.z))]);
}

#[test]
fn what_does_not_move_has_no_forces_and_what_is_off_exerts_none() {
    let mut run =
        run_of(&everything("damping: (rate_per_s: 0.4), mutual_gravity: ()"), Method::RungeKutta4);
    run.run(3);
    for still in [4, 5] {
        assert_eq!(forces_on(&mut run, still), []);
    }
    let of_all = |run: &mut Simulation| {
        (0..run.bodies.len()).flat_map(|body| names_on(run, body)).collect::<BTreeSet<_>>()
    };
    let mut names = of_all(&mut run);
    let names_of_effects =
        ["gravity", "drag", "wells", "thrusts", "damping", "mutual_gravity", "springs"];
    for effect in names_of_effects.map(|name| Effect::from_name(name).unwrap()) {
        run.world.resource_mut::<Requests>().ask(Request::Switch(effect, false));
        run.stepper.carry_out_requests(&mut run.world);
        assert!(names.remove(effect.name()), "{effect} acted");
        assert_eq!(of_all(&mut run), names, "without {effect}");
        assert!(check(&mut run, &format!("without {effect}"), NO_PUSH) > 15);
    }
    // As soon as it is quarantined, before the next tick compiles the groups again.
    let mut run = run_of(&everything("mutual_gravity: ()"), Method::RungeKutta4);
    run.run(3);
    let quarantined = run.bodies[1];
    run.world.get_mut::<PhysicsBody>(quarantined).unwrap().velocity = DVec3::NAN;
    run.tick();
    assert!(run.world.get::<Quarantined>(quarantined).is_some());
    assert_eq!(forces_on(&mut run, 1), []);
    let springs = forces_on(&mut run, 2)
        .into_iter()
        .filter(|(cause, _)| *cause == ForceCause::Spring(quarantined));
    assert_eq!(springs.count(), 0);
    assert!(check(&mut run, "without what is quarantined", NO_PUSH) > 15);
}

#[test]
fn an_engine_is_seen_from_the_side_on_which_the_next_step_begins() {
    let text = "(version: 1, step_hz: 64, bodies: [(name: \"ship\", mass_kg: 2)],
        thrusts: [(body: \"ship\", curve: polynomial([(4, 0, 0)]), from_s: 0.25, until_s: 0.5)])";
    let mut run = run_of(&scene_of(text), Method::RungeKutta4);
    let thrust =
        |run: &mut Simulation| forces_on(run, 0).iter().map(|(_, newtons)| newtons.x).sum::<f64>();
    let mut on = Vec::new();
    for tick in 0..40 {
        let before = run.world.get::<PhysicsBody>(run.bodies[0]).unwrap().velocity.x;
        let shown = thrust(&mut run);
        run.tick();
        let acted =
            (run.world.get::<PhysicsBody>(run.bodies[0]).unwrap().velocity.x - before) * 64.0 * 2.0;
        assert_eq!(shown, acted, "tick {tick}");
        on.push(shown > 0.0);
    }
    assert_eq!(on.iter().filter(|on| **on).count(), 16);
}

#[test]
fn looking_at_forces_changes_nothing() {
    let scene = scene::load("bridge").unwrap();
    let hash = |look: bool| {
        let mut run = run_of(&scene, Method::VelocityVerlet);
        for tick in 0..40 {
            if tick == 20 {
                run.world.entity_mut(run.bodies[5]).insert(OwnLaws::new(vec![embedded()]));
                run.world.despawn(run.bodies[3]);
            }
            if look {
                let bodies = run.bodies.clone();
                motion::each_force(&run.world, &[], &bodies, |_, _, _| {});
            }
            run.tick();
        }
        let states = run.bodies.iter().filter_map(|body| moving(&run.world, *body));
        let bits: Vec<_> =
            states.map(|state| state.velocity.to_array().map(f64::to_bits)).collect();
        (bits, run.world.resource::<motion::Evaluations>().clone())
    };
    assert_eq!(hash(true), hash(false));
}

#[test]
fn damping_that_multiplies_velocities_counts_as_the_force_that_it_comes_to() {
    for model in DampingModel::ALL {
        let text = "(version: 1, bodies: [(velocity_m_s: (0, 0, 3), mass_kg: 2)])";
        let mut run = run_of(&scene_of(text), Method::SemiImplicitEuler);
        run.world.insert_resource(Damping { model, rate: 0.5 });
        let expected = [(ForceCause::Law("damping"), DVec3::new(-0.0, -0.0, -3.0))];
        assert_eq!(forces_on(&mut run, 0), expected, "{model:?}");
    }
}
