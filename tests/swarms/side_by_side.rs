//! The same emitter on the device and on the processor.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::effects::Effect;
use motion::{Dormant, Transform};
use sandbox::input::Input;
use sandbox::{Options, Session};
use scene::ChangeAction;

use super::{Device, scene_text, ticks};
use crate::rigs::{Drive, scene_of};

/// Both runs.
struct Pair<'d> {
    device: &'d mut Device,
    swarm: Drive,
    bodies: Drive,
    slots: usize,
    body_ids: Vec<Entity>,
}

const SLOTS: usize = 400;

impl<'d> Pair<'d> {
    fn of(device: &'d mut Device, keys: &str, emitter: &str, method: &str) -> Self {
        let layout = if method == "position_verlet" { "positions" } else { "velocity" };
        let emitter = format!("capacity: {SLOTS}, {emitter} method: {method},");
        let drive = |on: &str| {
            let options = Options { pictures: false, interpolate: false, ..Options::default() };
            Drive::with(scene_of(&scene_text(keys, &format!("{emitter} {on}"))), options)
                .recording()
        };
        let (swarm, bodies) = (drive(&format!("on: gpu, layout: {layout}")), drive("on: cpu"));
        let id = |slot: usize| bodies.session.stage.sim().named(&format!("e.{slot}")).unwrap();
        let body_ids = (0..SLOTS).map(id).collect();
        Self { device, swarm, bodies, slots: SLOTS, body_ids }
    }

    fn ticks(&mut self, count: u32) {
        ticks(&mut self.swarm, count);
        ticks(&mut self.bodies, count);
    }

    fn act(&mut self, action: &ChangeAction) {
        for drive in [&mut self.swarm, &mut self.bodies] {
            drive.give([Input::Change(action.clone())]);
        }
    }

    fn places(session: &Session, body: Entity) -> Option<DVec3> {
        let body = session.stage.sim().world.entity(body);
        (!body.contains::<Dormant>()).then(|| body.get::<Transform>().unwrap().position)
    }

    /// The largest distance between a particle and its body, m. Both live or neither does.
    #[track_caller]
    fn compare(&mut self) -> f64 {
        let living = self.device.living(&mut self.swarm.session);
        let mut there = vec![None; self.slots];
        living
            .iter()
            .for_each(|(number, place)| there[*number as usize % self.slots] = Some(*place));
        let mut largest = 0.0_f64;
        for (slot, there) in there.into_iter().enumerate() {
            match (there, Self::places(&self.bodies.session, self.body_ids[slot])) {
                (Some(there), Some(body)) => largest = largest.max(there.distance(body)),
                (None, None) => {}
                (there, body) => {
                    let now = self.swarm.session.stage.sim().ticks();
                    panic!(
                        "slot {slot} after tick {now}: {there:?} on the device, {body:?} as a body"
                    );
                }
            }
        }
        assert!(!living.is_empty());
        largest
    }
}

const SPRAY: &str = "rate_per_s: 250, life_s: 1.3, position_m: (1, 2, 3), direction: (0.2, 1, 0), spread_deg: 20, speed_m_s: 9,";
const GRAVITY: &str = "gravity: (acceleration_m_s2: (0, -9.8, 0)),";
const AIR: &str = "drag: (linear_per_s: 0.4, quadratic_per_m: 0.05), wind: (velocity_m_s: (4, 0, -3), gust_m_s: 2, gust_hz: 0.7),";
const WELLS: &str = "wells: [(position_m: (4, 8, 3), strength_m3_s2: 60, softening_m: 1), \
                     (position_m: (-5, 6, 0), strength_m3_s2: -30, softening_m: 0.5)],";
const METHODS: [&str; 3] = ["position_verlet", "semi_implicit_euler", "velocity_verlet"];

/// Rounding errors of single precision, m. Positions of up to 16 m have digits of 1e-6 m. Position Verlet loses up to one in the
/// velocity of each of some 80 steps, with any sign: 80^1.5 of them in the position of the last. The others lose one in each position.
const DIGIT: f64 = 1e-6;

fn bound(method: &str) -> f64 {
    if method == "position_verlet" { 80.0_f64.powf(1.5) * DIGIT } else { 80.0 * DIGIT }
}

#[test]
fn every_law_acts_on_a_swarm_as_on_bodies() {
    let mut device = Device::new();
    let linear = "drag: (linear_per_s: 0.7), wind: (velocity_m_s: (4, 0, -3)),".to_owned();
    let all = format!("{GRAVITY}{AIR}{WELLS}");
    for keys in [GRAVITY, &linear, AIR, WELLS, &all] {
        for method in METHODS {
            let mut pair = Pair::of(&mut device, keys, SPRAY, method);
            for _ in 0..4 {
                pair.ticks(40);
                let error = pair.compare();
                assert!(error < bound(method), "{method}: {error:e} m with {keys}");
            }
        }
    }
}

#[test]
fn damping_substeps_and_far_places_too() {
    let mut device = Device::new();
    let far = SPRAY.replace("(1, 2, 3)", "(100000, 2, -300000)");
    let damping = |model: &str| format!("damping: (model: {model}, rate_per_s: 0.8),");
    for method in METHODS {
        for (keys, emitter) in [
            (format!("{GRAVITY}{AIR}substeps: 3,"), SPRAY.to_owned()),
            (format!("{GRAVITY}{AIR}"), format!("{SPRAY}substeps: 4,")),
            (format!("{GRAVITY}{AIR}"), far.clone()),
            (GRAVITY.to_owned() + &damping("tutorial"), SPRAY.to_owned()),
            (GRAVITY.to_owned() + &damping("clamped"), SPRAY.to_owned()),
            (GRAVITY.to_owned() + &damping("implicit") + "substeps: 2,", SPRAY.to_owned()),
            (GRAVITY.to_owned() + &damping("exact"), SPRAY.to_owned()),
        ] {
            // On bodies, semi-implicit Euler solves exact damping in the step.
            if method == "semi_implicit_euler" && keys.contains("exact") {
                continue;
            }
            let mut pair = Pair::of(&mut device, &keys, &emitter, method);
            for _ in 0..2 {
                pair.ticks(70);
                let error = pair.compare();
                // Rounded at every substep.
                assert!(
                    error < 12.0 * bound(method),
                    "{method}: {error:e} m with {keys} {emitter}"
                );
            }
        }
    }
}

#[test]
fn switches_and_other_changes_act_from_their_tick_on() {
    let mut device = Device::new();
    let keys = format!("{GRAVITY}{AIR}{WELLS}");
    for method in METHODS {
        let mut pair = Pair::of(&mut device, &keys, SPRAY, method);
        pair.ticks(30);
        for action in [
            ChangeAction::SetGravity(DVec3::new(0.0, 3.0, 1.0)),
            ChangeAction::SwitchEffect(Effect::Gravity, false),
            ChangeAction::SwitchEffect(Effect::Wells, false),
            ChangeAction::SwitchEffect(Effect::Emitters, false),
            ChangeAction::SwitchEffect(Effect::Wind, false),
            ChangeAction::SwitchEffect(Effect::Emitters, true),
            ChangeAction::SwitchEffect(Effect::Drag, false),
            ChangeAction::ReverseVelocities,
            ChangeAction::SwitchEffect(Effect::Wells, true),
            ChangeAction::SetSubsteps(3.into()),
            ChangeAction::SetSubsteps(1.into()),
        ] {
            pair.act(&action);
            pair.ticks(7);
            let error = pair.compare();
            assert!(error < 4.0 * bound(method), "{method}: {error:e} m after {action:?}");
        }
    }
}

#[test]
fn a_full_pool_replaces_its_oldest_and_a_carrier_takes_its_emitter_along() {
    let mut device = Device::new();
    let crowded = SPRAY.replace("rate_per_s: 250", "rate_per_s: 500");
    let riding =
        SPRAY.replace("position_m: (1, 2, 3)", "position_m: (0, 0.5, 0), rides_on: \"cart\"");
    let cart = format!(
        "{GRAVITY}bodies: [(name: \"cart\", position_m: (3, 1, 0), velocity_m_s: (2, 6, 1))],"
    );
    for method in METHODS {
        for (keys, emitter) in [(GRAVITY, &crowded), (&cart, &riding)] {
            let mut pair = Pair::of(&mut device, keys, emitter, method);
            for _ in 0..3 {
                pair.ticks(50);
                let error = pair.compare();
                assert!(error < bound(method), "{method}: {error:e} m with {keys} {emitter}");
            }
        }
    }
}

#[test]
fn nothing_is_born_of_a_carrier_that_is_gone_and_what_is_due_ends_what_lived() {
    let mut device = Device::new();
    let crowded = SPRAY.replace("rate_per_s: 250", "rate_per_s: 500");
    let riding =
        crowded.replace("position_m: (1, 2, 3)", "position_m: (0, 0.5, 0), rides_on: \"cart\"");
    let cart = format!(
        "{GRAVITY}bodies: [(name: \"cart\", position_m: (3, 1, 0), velocity_m_s: (2, 6, 1))],"
    );
    let mut pair = Pair::of(&mut device, &cart, &riding, "position_verlet");
    pair.ticks(70);
    pair.compare();
    pair.act(&ChangeAction::Remove("cart".to_owned()));
    pair.ticks(20);
    let error = pair.compare();
    assert!(error < bound("position_verlet"), "{error:e} m");
    pair.ticks(30);
    assert!(pair.device.living(&mut pair.swarm.session).len() < 20);
}

#[test]
fn a_short_tick_loses_no_velocity() {
    let mut device = Device::new();
    let keys = format!("{GRAVITY}step: frame,");
    for method in METHODS {
        let mut pair = Pair::of(&mut device, &keys, SPRAY, method);
        for length in [1.0 / 60.0, 1e-5, 1e-8, 1.0 / 60.0, 3e-4, 1e-9, 1.0 / 60.0, 1.0 / 144.0] {
            for _ in 0..8 {
                pair.swarm.frame(length, []);
                pair.bodies.frame(length, []);
            }
            let error = pair.compare();
            assert!(error < 2.0 * bound(method), "{method}: {error:e} m after ticks of {length} s");
        }
    }
}
