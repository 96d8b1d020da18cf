//! Bundles as files: exact, open to other versions, closed to damage.

use bevy_ecs::world::World;
use ciborium::Value;
use motion::units::Vector;
use motion::{Method, Request, Stepper, TimeStep};

use super::*;
use crate::bundle::{Event, FaultEntry, Happening, Keyframe, Settings};
use crate::{Scene, Snapshot};

const TEXT: &str = "(version: 1, method: velocity_verlet, wells: [(strength_m3_s2: 5)], bodies: [
    (name: \"a\", position_m: (2, 0, 0)), (position_m: (0, 3, 0), method: position_verlet, substeps: 2)],
    emitters: [(rate_per_s: 60, life_s: 1, speed_m_s: 2, position_m: (0, 9, 0))])";

/// A NaN with a payload.
const NAN: f64 = f64::from_bits(0x7ff4_dead_beef_0001);

fn bundle() -> Bundle {
    let scene = Scene::parse("test", TEXT).unwrap();
    let mut world = World::new();
    scene.spawn(&mut world);
    let mut stepper = Stepper::new(&mut world, scene.method, TimeStep(0.01));
    (0..20).for_each(|_| stepper.tick(&mut world));
    let snapshot = Snapshot::of(&mut world, stepper.method());
    let event = |tick, what| Event { tick, what };
    Bundle {
        manifest: Manifest {
            format: BUNDLE_FORMAT,
            program: "sandbox 0".to_owned(),
            scene: scene.name.clone(),
            settings: Settings::of(&scene),
            snapshot_tick: 20,
            end_tick: 25,
            end_state_hash: "0".repeat(16),
            keyframes: vec![Keyframe { tick: 20, state_hash: format!("{:016x}", snapshot.state_hash()) }],
            fault: Some(FaultEntry { tick: 25, body: Some("a".to_owned()), what: "lost".to_owned() }),
        },
        scene: TEXT.to_owned(),
        snapshot,
        events: vec![
            event(20, Happening::Method(Method::RungeKutta4)),
            event(21, Happening::Requests(vec![Request::Remove(1), Request::SetInverseMass(0, 0.1)])),
            event(22, Happening::Step(1e-3)),
            event(22, Happening::Push(0, Vector::new(1e-320, -0.0, f64::INFINITY))),
        ],
        energy_scale_j: Some(0.1),
        picture: Some(vec![1, 2, 3]),
    }
}

#[test]
fn a_bundle_reads_back_to_the_last_bit_also_where_it_is_not_a_number() {
    let written = bundle();
    assert_eq!(Bundle::read(&written.write().unwrap()).unwrap(), written);
    let mut odd = bundle();
    odd.events = vec![Event { tick: 1, what: Happening::Push(0, Vector::new(NAN, -NAN, f64::NEG_INFINITY)) }];
    let read = Bundle::read(&odd.write().unwrap()).unwrap();
    let Happening::Push(_, newtons) = read.events[0].what else { panic!("{:?}", read.events) };
    let bits = newtons.to_array().map(f64::to_bits);
    assert_eq!(bits, [NAN.to_bits(), (-NAN).to_bits(), f64::NEG_INFINITY.to_bits()]);
}

/// The bundle with other files in place of its own.
fn repacked(change: impl Fn(&str, Vec<u8>) -> Vec<u8>) -> Vec<u8> {
    let bytes = bundle().write().unwrap();
    let mut archive = ZipArchive::new(Cursor::new(&bytes[..])).unwrap();
    let files = [SCENE, MANIFEST, STATE]
        .map(|name| (name, change(name, file(&mut archive, name, MOST_STATE).unwrap().unwrap())));
    let mut bytes = pack(&files).unwrap();
    let end = bytes.len() - DIGITS;
    let sum = checksum(&bytes[..end]);
    bytes[end..].copy_from_slice(sum.as_bytes());
    bytes
}

/// Adds a key to every map of a CBOR value.
fn add_keys(value: &mut Value) {
    match value {
        Value::Map(pairs) => {
            pairs.iter_mut().for_each(|(_, value)| add_keys(value));
            // An enumeration is a map of one word.
            if pairs.len() > 1 {
                pairs.push((Value::Text("of_later".to_owned()), Value::Array(vec![Value::Float(1.5)])));
            }
        }
        Value::Array(items) => items.iter_mut().for_each(add_keys),
        _ => {}
    }
}

fn in_state(change: impl Fn(&mut Value)) -> Vec<u8> {
    repacked(|name, bytes| {
        if name != STATE {
            return bytes;
        }
        let mut value: Value = ciborium::from_reader(&bytes[..]).unwrap();
        change(&mut value);
        cbor(&value).unwrap()
    })
}

#[test]
fn keys_of_a_later_program_are_passed_over() {
    let plain = Bundle { picture: None, ..bundle() };
    assert_eq!(Bundle::read(&in_state(add_keys)).unwrap(), plain);
    let later = repacked(|name, bytes| match name {
        MANIFEST => {
            let text = String::from_utf8(bytes).unwrap();
            text.replacen('{', "{\"of_later\": {\"a\": [1]},", 1).into_bytes()
        }
        _ => bytes,
    });
    assert_eq!(Bundle::read(&later).unwrap(), plain);
}

#[test]
fn keys_of_an_earlier_program_that_it_did_not_write_are_empty() {
    let earlier = in_state(|state| {
        let Value::Map(state) = state else { panic!("{state:?}") };
        state.retain(|(key, _)| key.as_text() != Some("energy_scale_j"));
        let snapshot = state.iter_mut().find(|(key, _)| key.as_text() == Some("snapshot"));
        let Some((_, Value::Map(snapshot))) = snapshot else { panic!("a snapshot") };
        let before = snapshot.len();
        snapshot.retain(|(key, _)| !["kept", "kept_groups"].contains(&key.as_text().unwrap_or_default()));
        assert_eq!(snapshot.len(), before - 2);
    });
    let read = Bundle::read(&earlier).unwrap();
    let mut expected = Bundle { picture: None, energy_scale_j: None, ..bundle() };
    assert!(!expected.snapshot.kept.is_empty());
    (expected.snapshot.kept, expected.snapshot.kept_groups) = (Vec::new(), Vec::new());
    assert_eq!(read, expected);
    let scene = read.scene("test").unwrap();
    read.snapshot.restore(&scene).unwrap();
}

#[test]
fn a_flipped_cut_or_longer_file_is_refused() {
    let good = Bundle { picture: None, ..bundle() }.write().unwrap();
    Bundle::read(&good).unwrap();
    for place in 0..good.len() {
        for bit in [0x01, 0x20, 0x80] {
            let mut bad = good.clone();
            bad[place] ^= bit;
            let error = Bundle::read(&bad).expect_err("a flipped bit").to_string();
            assert!(error.contains("damaged") || error.contains("no bundle"), "{error}");
        }
        Bundle::read(&good[..place]).expect_err("a cut file");
    }
    for more in [&b"0"[..], b"\0", b"PK"] {
        let longer = [&good[..], more].concat();
        Bundle::read(&longer).expect_err("a longer file");
    }
}

#[test]
fn lies_about_lengths_are_errors_and_take_no_memory() {
    // A list of 2^60 numbers, and text of as many bytes.
    for lie in [&b"\x9b\x10\0\0\0\0\0\0\0"[..], b"\x7b\x10\0\0\0\0\0\0\0", b"\x5b\x10\0\0\0\0\0\0\0"] {
        let key = b"\xa1\x66events";
        let bytes = [&key[..], lie].concat();
        let error = Bundle::read(&repacked(|name, whole| if name == STATE { bytes.clone() } else { whole }));
        assert!(error.unwrap_err().to_string().starts_with("the bundle cannot be read"));
    }
    let nested = vec![0x81; 1 << 20];
    let error = Bundle::read(&repacked(|name, whole| if name == STATE { nested.clone() } else { whole }));
    assert!(error.is_err());
}

#[test]
fn a_newer_format_is_named() {
    let newer = repacked(|name, bytes| match name {
        MANIFEST => b"{\"format\": 9}".to_vec(),
        _ => bytes,
    });
    let error = Bundle::read(&newer).unwrap_err().to_string();
    let expected =
        "format 9 of the bundle is newer than this program, which reads format 1; use a newer program";
    assert_eq!(error, expected);
}
