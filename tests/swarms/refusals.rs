//! What a swarm cannot have or do.

use cockpit::view::on_device::swarms;
use glam::DMat3;
use motion::units::Vector;
use motion::{BodyState, EvaluationTime, Jacobians, Law, Laws};
use render::RenderError;
use sandbox::input::Input;
use scene::ChangeAction;
use swarm::{Swarm, SwarmError, SwarmLaws, Swarms};

use super::{Device, scene_text};
use crate::rigs::{Drive, scene_of, summarized};

const EMITTER: &str = "on: gpu, rate_per_s: 9, life_s: 1, speed_m_s: 1";

#[test]
fn an_adapter_says_how_many_particles_it_can_have() {
    let device = Device::new();
    Swarms::check(&device.gpu, Swarm::MOST).unwrap();
    let error = Swarms::check(&device.gpu, 1 << 40).unwrap_err();
    assert!(matches!(error, SwarmError::TooLarge { .. }));
    let words = error.to_string();
    assert!(words.contains("1099511627776 particles") && words.ends_with("or on: cpu"), "{words}");
}

/// A spring to the origin, of which no shader knows.
#[derive(Debug)]
struct Harmonic;

impl Law for Harmonic {
    fn name(&self) -> &'static str {
        "harmonic"
    }

    fn acceleration(&self, _: EvaluationTime, body: BodyState) -> Vector {
        -body.position
    }

    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians { position: -DMat3::IDENTITY, ..Jacobians::zero() }
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }
}

#[test]
#[should_panic(expected = "the law `harmonic` has no form for a graphics device")]
fn an_own_law_is_refused_by_name() {
    let scene = scene_of(&scene_text("", EMITTER));
    let mut simulation = history::Simulation::prepared(scene, |world, _| {
        world.insert_resource(Laws(vec![Box::new(Harmonic)]));
    });
    simulation.tick();
}

#[test]
fn a_particle_on_the_device_has_no_name_and_is_not_picked() {
    let mut drive = Drive::text(&scene_text("", EMITTER));
    drive.run(30, 1.0 / 60.0);
    assert_eq!(drive.session.stage.sim().named("e.0"), None);
    assert_eq!(drive.session.stage.sim().remaining_bodies().count(), 0);
    drive.give([Input::Change(ChangeAction::Remove("e.0".to_owned()))]);
    assert_eq!(drive.session.stage.notices.take_refusals(), ["there is no body e.0 any more"]);
}

#[test]
fn a_lost_device_is_an_error_and_no_panic() {
    let mut device = Device::new();
    let mut drive = Drive::text(&scene_text("gravity: (),", EMITTER));
    drive.run(30, 1.0 / 60.0);
    assert!(!device.living(&mut drive.session).is_empty());
    device.gpu.check().unwrap();
    device.gpu.device.destroy();
    let error = device.gpu.check().unwrap_err();
    assert!(matches!(error, RenderError::Lost { .. }));
    assert!(error.to_string().contains("was lost"), "{error}");
    drive.run(30, 1.0 / 60.0);
    device.swarms.follow(&device.gpu, &swarms(&drive.session.stage));
    assert!(device.swarms.read(&device.gpu, 0).is_err());
}

#[test]
fn a_scene_that_expects_finite_states_fails_where_particles_are_not() {
    let text =
        scene_text("gravity: (acceleration_m_s2: (0, -1e39, 0)), expect: (finite: true),", EMITTER);
    let (said, summary) = summarized([("x.ron", text.as_str())], "run x.ron --seconds 2 --assert");
    let said = said.ends(1);
    assert!(
        said.err.contains("8 particles on the graphics device are not finite any more"),
        "{}",
        said.err
    );
    assert_eq!(
        (&summary["swarms"][0]["living"], &summary["swarms"][0]["failed"]),
        (&0.into(), &8.into())
    );
}

#[test]
fn rows_of_states_are_refused() {
    let text = scene_text("", EMITTER);
    let (said, _) = summarized([("x.ron", text.as_str())], "run x.ron --seconds 2 --state s.csv");
    let said = said.ends(2).err;
    assert!(
        said.contains(
            "emitters[0]: its particles are on the graphics device and have no rows for --state"
        ),
        "{said}"
    );
}

#[test]
fn limits_of_scenes_are_those_of_the_device() {
    let many = "(strength_m3_s2: 1),".repeat(SwarmLaws::WELLS);
    scene_of(&scene_text(&format!("wells: [{many}],"), EMITTER));
    let text = scene_text(&format!("wells: [{many} (strength_m3_s2: 1)],"), EMITTER);
    let error = scene::Scene::parse("t", &text).unwrap_err().to_string();
    assert!(error.contains("65 wells are too many for particles on a graphics device"), "{error}");
    let memory = |keeps| scene_of(&scene_text("", EMITTER)).estimated_bytes(keeps);
    let kept = memory(scene::Keeps { black_box: true, ..scene::Keeps::default() });
    assert!(kept - memory(scene::Keeps::default()) >= Swarm::KEPT_BYTES);
}
