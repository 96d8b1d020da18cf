//! Swarms after going back, after a reset, on another device, and from a bundle.

use cockpit::view::on_device::swarms;
use sandbox::Options;
use sandbox::input::Input;
use scene::ChangeAction;
use swarm::SwarmParticle;

use super::{Device, scene_text, ticks};
use crate::rigs::{Drive, Studio, scene_of};

fn storm() -> Drive {
    let keys = "gravity: (), drag: (quadratic_per_m: 0.05), wind: (velocity_m_s: (4, 0, -3), gust_m_s: 2, gust_hz: 0.7),";
    let emitter =
        "on: gpu, rate_per_s: 400, life_s: 1.2, direction: (0, 1, 0), spread_deg: 20, speed_m_s: 9";
    Drive::text(&scene_text(keys, emitter)).recording()
}

/// The bits of living particles.
fn bits(device: &mut Device, drive: &mut Drive) -> Vec<Option<[u32; 6]>> {
    let living = device.living(&mut drive.session);
    assert!(!living.is_empty());
    let slots = device.slots(&mut drive.session);
    let count = slots.len() as u64;
    let mut bits = vec![None; slots.len()];
    for (number, _) in living {
        #[expect(clippy::cast_possible_truncation, reason = "below the number of slots")]
        let slot = (number % count) as usize;
        let SwarmParticle { position: [x, y, z], other: [u, v, w], .. } = slots[slot].unwrap();
        bits[slot] = Some([x, y, z, u, v, w].map(f32::to_bits));
    }
    bits
}

/// Bits are no words: what differs is counted.
#[track_caller]
fn same(here: &[Option<[u32; 6]>], there: &[Option<[u32; 6]>], what: &str) {
    let different = here.iter().zip(there).filter(|(here, there)| here != there).count();
    assert!(here.len() == there.len() && different == 0, "{what}: {different} of {}", here.len());
}

#[test]
fn one_adapter_gives_equal_bits_after_every_way() {
    let (mut device, mut drive) = (Device::new(), storm());
    let mut then = Vec::new();
    for tick in 0..200_u64 {
        ticks(&mut drive, 1);
        if tick == 120 {
            drive.give([Input::Change(ChangeAction::SetGravity(glam::DVec3::new(0.0, 2.0, 0.0)))]);
        }
        assert_eq!(drive.session.stage.sim().ticks(), tick + 1);
        then.push(bits(&mut device, &mut drive));
    }
    // Back, forth, and back by a tick.
    for tick in [150, 60, 199, 121, 122, 200, 1] {
        drive.session.seek(tick);
        assert_eq!(drive.session.stage.sim().ticks(), tick);
        let before = device.swarms.dispatches();
        same(&bits(&mut device, &mut drive), &then[tick as usize - 1], &format!("tick {tick}"));
        // From the nearest state that was kept, not from the first birth.
        assert!(device.swarms.dispatches() - before <= 34, "tick {tick}");
    }
    drive.session.seek(100);
    drive.press(",").frame(1.0 / 60.0, []);
    same(&bits(&mut device, &mut drive), &then[98], "a tick back");
    // On a device that has seen nothing of it.
    same(&bits(&mut Device::new(), &mut drive), &then[98], "another device");
    // On from there, without the change at tick 121, which is dropped.
    drive.press("P");
    for tick in drive.session.stage.sim().ticks()..121 {
        ticks(&mut drive, 1);
        same(&bits(&mut device, &mut drive), &then[tick as usize], &format!("tick {tick}"));
    }
}

#[test]
fn a_state_that_was_kept_is_drawn_as_it_was() {
    // Whose births and deaths are those of the tick that is drawn, and not of the one that was left: particles live for a tick.
    let emitter = "on: gpu, rate_per_s: 60, life_s: 0.02, radius_m: 0.3, speed_m_s: 0";
    let keys = "camera: (position_m: (0, 0, 4), pitch_deg: 0, yaw_deg: 0),";
    let options = Options { pictures: false, interpolate: false, ..Options::default() };
    let mut drive = Drive::with(scene_of(&scene_text(keys, emitter)), options).recording();
    let mut studio = Studio::new([1280, 720]);
    let mut seen = Vec::new();
    for _ in 0..100 {
        ticks(&mut drive, 1);
        seen.push(studio.draw_bodies(&mut drive.session).rgba);
    }
    assert!(seen[95] != Studio::new([1280, 720]).draw_bodies(&mut Drive::bodies("").session).rgba);
    for tick in [96, 99, 64, 32, 65] {
        drive.session.seek(tick);
        let picture = studio.draw_bodies(&mut drive.session).rgba;
        let off = picture.iter().zip(&seen[tick as usize - 1]).filter(|(a, b)| a != b).count();
        assert_eq!(off, 0, "tick {tick}");
    }
}

#[test]
fn a_reset_begins_again_with_the_same_bits() {
    let (mut device, mut drive) = (Device::new(), storm());
    ticks(&mut drive, 40);
    let then = bits(&mut device, &mut drive);
    ticks(&mut drive, 60);
    bits(&mut device, &mut drive);
    drive.press("F1");
    assert_eq!(swarms(&drive.session.stage)[0].ticks, []);
    ticks(&mut drive, 40);
    same(&bits(&mut device, &mut drive), &then, "after a reset");
}

#[test]
fn a_bundle_brings_its_swarm_along() {
    let (mut device, mut drive) = (Device::new(), storm());
    // Longer than the timeline reaches back, and the life of a particle more.
    ticks(&mut drive, 62 * 60 + 17);
    let then = bits(&mut device, &mut drive);
    let bundle = drive.session.stage.bundle(None).unwrap();
    assert!(bundle.snapshot.ticks() > 60, "{}", bundle.snapshot.ticks());
    let bundle = history::Bundle::read(&bundle.write().unwrap()).unwrap();
    let (mut session, repetition) =
        sandbox::Session::of_bundle(&bundle, "b", Options::default(), &mut |_| {}).unwrap();
    assert_eq!(repetition.first_different_tick, None);
    let mut opened = Drive::of(scene::Scene::clone(&session.stage.sim().scene));
    std::mem::swap(&mut opened.session, &mut session);
    same(&bits(&mut device, &mut opened), &then, "at its end");
    let early = opened.session.stage.sim().ticks() - 3500;
    opened.session.seek(early);
    drive.session.seek(early);
    same(&bits(&mut device, &mut opened), &bits(&mut Device::new(), &mut drive), "a minute back");
}

#[test]
fn a_state_is_kept_as_its_words() {
    let mut drive = storm();
    ticks(&mut drive, 90);
    let sim = drive.session.stage.world_mut();
    let log = sim.query::<&swarm::SwarmLog>().single(sim).unwrap();
    // No longer than the life of a particle, in ticks.
    assert_eq!(log.ticks.len(), 72);
    assert_eq!(log.ticks.back().unwrap().key, log.key);
}
