//! Only what a scene calls for: the compiled schedule and the world of every shipped scene hold what it declares, and
//! nothing more.

use std::collections::BTreeSet;

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::effects::Effect;
use motion::{
    Curve, Damping, Drag, Elastic, Gravity, LawTexts, Laws, Method, OwnLaws, PhysicsBody, Stepper,
    Thrust, Well, Wells, Wind,
};
use sandbox::{Options, Overrides, Session};
use scene::Scene;

use crate::rigs::{Drive, H, Lab, Start, assert_expected};

/// A shipped scene as a headless run without pictures has it, a few ticks on.
fn session(name: &str) -> Session {
    let options = Options { pictures: false, interpolate: false, ..Options::default() };
    let mut drive = Drive::with(scene::load(name).unwrap(), options);
    drive.frames(12);
    drive.session
}

fn shipped() -> Vec<&'static str> {
    scene::shipped().iter().map(|scene| scene.name).collect()
}

/// The last word of a type's path.
fn word(path: &str) -> String {
    let name = path.split('<').next().unwrap_or(path);
    name.rsplit("::").next().unwrap_or(name).to_owned()
}

/// Components of all kinds of body of which there is one.
fn columns(world: &World) -> BTreeSet<String> {
    let body = world.components().component_id::<PhysicsBody>().unwrap();
    world
        .archetypes()
        .iter()
        .filter(|kind| !kind.is_empty() && kind.contains(body))
        .flat_map(|kind| kind.components().to_vec())
        .map(|component| word(&world.components().get_info(component).unwrap().name().to_string()))
        .collect()
}

fn systems(stepper: &Stepper) -> BTreeSet<String> {
    stepper.systems().iter().map(|system| word(system)).collect()
}

fn declares(scene: &Scene, effect: Effect) -> bool {
    scene.declared.iter().any(|declared| declared.effect == effect)
}

/// Methods that a scene's bodies have.
fn methods(session: &mut Session) -> BTreeSet<Method> {
    session.stage.sim().bodies_per_method().into_iter().map(|(method, _)| method).collect()
}

#[test]
fn laws_are_named_with_their_numbers() {
    let mut world = World::new();
    assert_eq!(LawTexts::of(&world), LawTexts::default());
    world.insert_resource(Gravity::EARTH);
    let wind = Wind { velocity: DVec3::X, gust: 0.5, gust_hz: 2.0 };
    world.insert_resource(Drag { wind: Some(wind), ..Drag::new(0.1, 0.02) });
    let well = Well { position: DVec3::ZERO, strength: 1.0, softening: 0.0 };
    world.insert_resource(Wells(vec![well; 2]));
    let thrust = || Thrust::new(Curve::Polynomial(vec![DVec3::X]), 0.0, 1.0);
    world.insert_resource(Laws(vec![Box::new(thrust())]));
    world.spawn(OwnLaws::new(vec![Box::new(thrust())]));
    world.insert_resource(Damping::TUTORIAL);
    let LawTexts { on_bodies, damping, .. } = LawTexts::of(&world);
    let expected = [
        "gravity (0, -9.8, 0) m/s², on",
        "drag 0.1 1/s, 0.02 1/m; wind (1, 0, 0) m/s, gusts 0.5 m/s at 2 Hz",
        "wells: 2",
        "thrusts",
        "thrusts: 1",
    ];
    assert_eq!(on_bodies, expected);
    assert_eq!(damping.as_deref(), Some("damping tutorial 0.4 1/s"));
}

#[test]
fn plans_of_shipped_scenes_are_the_golden_ones() {
    let plan = |name| sandbox::plan::text(scene::load(name).unwrap(), Overrides::default());
    assert_expected("plans", &shipped().into_iter().map(plan).collect::<String>());
}

/// Whether bodies of the scene choose their substeps.
fn chooses(scene: &Scene) -> bool {
    scene
        .bodies
        .iter()
        .filter_map(|body| body.substeps)
        .chain([scene.substeps])
        .any(|substeps| substeps.fixed().is_none())
}

fn is_grouped(scene: &Scene) -> bool {
    declares(scene, Effect::Springs) || declares(scene, Effect::MutualGravity) || chooses(scene)
}

#[test]
fn a_world_has_the_columns_that_its_scene_calls_for_and_no_others() {
    for name in shipped() {
        let mut session = session(name);
        let methods = methods(&mut session);
        let scene = session.stage.sim().scene.clone();
        let found = columns(&session.stage.sim().world);
        let coupled = is_grouped(&scene);
        let any = |has: fn(&scene::BodySpec) -> bool| scene.bodies.iter().any(has);
        let called = scene.laws.wells.is_some()
            || scene.laws.drag.is_some_and(|drag| drag.quadratic != 0.0)
            || !scene.own_laws.is_empty();
        let keeps =
            methods.contains(&Method::VelocityVerlet) || methods.contains(&Method::Yoshida4);
        // Column, whether it must be there, whether it may.
        let emits = scene.emitters.iter().any(|emitter| emitter.on_device.is_none());
        let own_laws = !scene.own_laws.is_empty();
        let verlet = methods.contains(&Method::PositionVerlet);
        // All immovable bodies of such scenes move.
        let follows = !scene.motions.is_empty();
        let expected = [
            ("SpeedLimit", declares(&scene, Effect::SpeedLimits)),
            ("AxisLocks", declares(&scene, Effect::AxisLocks)),
            ("DampingRate", any(|body| body.damping_rate.is_some())),
            ("GravityOff", any(|body| body.gravity_off)),
            ("OwnLaws", own_laws),
            ("OwnSubsteps", any(|body| body.substeps.is_some())),
            ("AutoSubsteps", chooses(&scene)),
            ("OwnMethod", any(|body| body.method.is_some())),
            ("LastStep", verlet),
            ("Grouped", coupled),
            ("Particle", emits),
            ("PointRadius", emits),
            ("Static", scene.bodies.iter().any(|body| body.inverse_mass == Some(0.0)) && !follows),
            ("PrescribedMotion", follows),
            ("SourceMass", any(|body| body.source_mass.is_some())),
            ("Orientation", any(|body| body.orientation.is_some() && body.inverse_mass.is_some())),
            ("PreviousPosition", false),
            ("Quarantined", false),
        ];
        for (column, there) in expected {
            assert_eq!(found.contains(column), there, "{name}: {column} in {found:?}");
        }
        let of_others = ["LastAcceleration", "Dormant"];
        if found.contains("LastAcceleration") {
            assert!(keeps && called, "{name}: {found:?}");
        }
        let plain = ["Transform", "PhysicsBody", "Force", "StableId", "Appearance", "Shape"];
        let markers = Method::ALL.map(|method| format!("{method:?}"));
        for column in &found {
            let known = plain.contains(&column.as_str())
                || of_others.contains(&column.as_str())
                || expected.iter().any(|(name, _)| name == column)
                || markers.contains(column) && any(|body| body.method.is_some());
            assert!(known, "{name}: nobody called for {column}");
        }
    }
}

#[test]
fn a_schedule_has_the_systems_that_its_scene_calls_for_and_no_others() {
    for name in shipped() {
        let session = session(name);
        let scene = &session.stage.sim().scene;
        let found = systems(&session.stage.sim().stepper);
        let coupled = is_grouped(scene);
        assert_eq!(found.contains("integrate_groups"), coupled, "{name}: {found:?}");
        let on_device =
            |on: bool| scene.emitters.iter().any(|emitter| emitter.on_device.is_some() == on);
        assert_eq!(found.contains("emit_particles"), on_device(false), "{name}: {found:?}");
        assert_eq!(found.contains("advance_swarms"), on_device(true), "{name}: {found:?}");
        let rides = scene.own_laws.values().any(|laws| !laws.riding_wells.is_empty());
        assert_eq!(found.contains("carry_wells"), rides, "{name}: {found:?}");
        let follows = !scene.motions.is_empty();
        assert_eq!(found.contains("follow_motion"), follows, "{name}: {found:?}");
        let always = ["apply_forces", "clear_forces", "quarantine_bodies"];
        assert!(always.iter().all(|system| found.contains(*system)), "{name}: {found:?}");
        let known = "integrate_groups emit_particles integrate integrate_in_one_pass integrate_acceleration \
            integrate_velocity remember_steps remember_accelerations apply_deferred carry_wells follow_motion advance_swarms";
        let known: Vec<_> = known.split(' ').collect();
        for system in &found {
            assert!(always.iter().chain(&known).any(|known| known == system), "{name}: {system}");
        }
        let free = found
            .iter()
            .any(|system| system.starts_with("integrate") && system != "integrate_groups");
        assert!(free || coupled, "{name}: nothing moves: {found:?}");
    }
}

#[test]
fn resources_of_undeclared_effects_are_not_there() {
    for name in shipped() {
        let session = session(name);
        let (scene, world) = (&session.stage.sim().scene, &session.stage.sim().world);
        let there = [
            (Effect::Gravity, world.contains_resource::<Gravity>()),
            (Effect::Damping, world.contains_resource::<Damping>()),
            (Effect::Wind, world.get_resource::<Drag>().is_some_and(|drag| drag.wind.is_some())),
            (Effect::MutualGravity, world.contains_resource::<motion::MutualGravity>()),
        ];
        for (effect, there) in there {
            assert_eq!(there, declares(scene, effect), "{name}: {effect}");
        }
        // Of single bodies they are own laws.
        let drags = scene.laws.drag.is_some() && !scene.off_at_start.contains(&Effect::Drag);
        assert_eq!(world.contains_resource::<Drag>(), drags, "{name}");
        assert_eq!(world.contains_resource::<Wells>(), scene.laws.wells.is_some(), "{name}");
        let coupled = is_grouped(scene);
        assert_eq!(world.contains_resource::<motion::internals::Groups>(), coupled, "{name}");
    }
}

#[test]
fn evaluations_of_absent_effects_are_none() {
    for name in shipped() {
        let session = session(name);
        for (law, evaluations) in session.stage.sim().evaluations().laws() {
            let declared = Effect::ALL.iter().find(|effect| effect.name() == *law);
            let declared =
                declared.is_some_and(|effect| declares(&session.stage.sim().scene, *effect));
            assert!(
                declared || *evaluations == 0,
                "{name}: {law} was evaluated {evaluations} times"
            );
        }
    }
}

#[test]
fn one_spring_among_free_particles_adds_one_law_and_one_system() {
    let mut lab = Lab::new(Method::SemiImplicitEuler, H);
    for i in 0..4 {
        lab.spawn(Start::of(1.0, DVec3::X * f64::from(i), DVec3::ZERO));
    }
    let before = systems(&lab.run(1).stepper);
    assert!(lab.counts().1.iter().all(|(_, count)| *count == 0));
    let spring = lab.spring([0, 1], Elastic::new(1.0, 0.5));
    let with = systems(&lab.run(1).stepper);
    let added: Vec<_> = with.difference(&before).collect();
    assert_eq!(added, ["integrate_groups"]);
    assert!(before.is_subset(&with));
    // Two of the four bodies, one evaluation.
    assert_eq!(lab.evaluations().laws(), [("springs", 2)]);
    lab.world.despawn(spring);
    assert_eq!(systems(&lab.run(1).stepper), before, "the last spring takes its system with it");
}
