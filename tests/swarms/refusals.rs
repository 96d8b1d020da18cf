//! What a swarm cannot have or do.

use glam::DMat3;
use motion::units::Vector;
use motion::{BodyState, EvaluationTime, Jacobians, Law, Laws};
use render::RenderError;
use sandbox::input::Input;
use scene::Action;

use super::{Device, scene_text};
use crate::rigs::{Drive, scene_of};

const EMITTER: &str = "on: gpu, rate_per_s: 9, life_s: 1, speed_m_s: 1";

#[test]
fn an_adapter_says_how_many_particles_it_can_have() {
    let device = Device::new();
    device.gpu.check_swarm(scene::SWARM_LIMIT).unwrap();
    let error = device.gpu.check_swarm(1 << 40).unwrap_err();
    assert!(matches!(error, RenderError::Swarm { .. }));
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
    assert_eq!(drive.session.stage.body("e.0"), None);
    assert_eq!(drive.session.stage.things().count(), 0);
    drive.give([Input::Act(Action::Remove("e.0".to_owned()))]);
    assert_eq!(drive.session.stage.take_refusals(), ["there is no body e.0 any more"]);
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
    let frame = drive.session.picture();
    device.swarms.follow(&device.gpu, &frame.swarms);
    assert!(device.swarms.read(&device.gpu, 0).is_err());
}
