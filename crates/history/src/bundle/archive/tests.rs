//! Bundles as files: exact, open to other versions, closed to damage.

use ciborium::Value;
use motion::units::Vector;
use motion::{Evaluations, Iterations, Method, Request};
use scene::Scene;

use super::*;
use crate::bundle::{EnergyGrowth, EnergyLook, FaultEntry, Keyframe};
use crate::change::Change;
use crate::settings::Overrides;
use crate::simulation::Simulation;

const TEXT: &str =
    "(version: 1, step_hz: 100, method: velocity_verlet, wells: [(strength_m3_s2: 5)], bodies: [
    (name: \"a\", position_m: (2, 0, 0)), (position_m: (0, 3, 0), method: position_verlet, substeps: 2)],
    emitters: [(rate_per_s: 60, life_s: 1, speed_m_s: 2, position_m: (0, 9, 0))])";

/// A NaN with a payload.
const NAN: f64 = f64::from_bits(0x7ff4_dead_beef_0001);

fn bundle() -> Bundle {
    let scene = Scene::parse("test", TEXT).unwrap();
    let mut simulation = Simulation::new(scene.clone());
    simulation.run(20);
    let snapshot = simulation.snapshot();
    let event = |tick, what| Event { tick, what };
    Bundle {
        manifest: Manifest {
            format: BUNDLE_FORMAT,
            program: "sandbox 0".to_owned(),
            scene: scene.name.clone(),
            settings: Overrides::of(&scene),
            snapshot_tick: 20,
            end_tick: 25,
            end_state_hash: "0".repeat(16),
            keyframes: vec![Keyframe {
                tick: 20,
                state_hash: format!("{:016x}", snapshot.state_hash()),
            }],
            fault: Some(FaultEntry {
                tick: 25,
                body: Some("a".to_owned()),
                what: "lost".to_owned(),
            }),
        },
        scene: TEXT.to_owned(),
        snapshot,
        events: vec![
            event(20, Change::Method(Method::RungeKutta4)),
            event(21, Change::Requests(vec![Request::Remove(1), Request::SetInverseMass(0, 0.1)])),
            event(22, Change::Step(1e-3)),
            event(22, Change::Push(0, Vector::new(1e-320, -0.0, f64::INFINITY))),
        ],
        energy: Some(EnergyState {
            growth: Some(EnergyGrowth {
                since: 3,
                own_j: f64::INFINITY,
                total_j: Some(-0.1),
                elsewhere_j: 0.3,
                reported: true,
            }),
            look: Some(EnergyLook {
                since: 17,
                last: 19,
                invented_j: -1e-320,
                caused_j: 7.1,
                fed: true,
                total_j: Some(f64::NEG_INFINITY),
                grew: Some(17),
                jumped: Some(18),
                leapt_over_j: Some(0.7),
                leapt_from_j: Some(3.0),
                least_j: Some(4.0),
                most_j: Some(1e300),
            }),
            last_j: Some(0.2),
            grew_tick: Some(16),
            ..EnergyState::at(15, 0.1)
        }),
        picture: Some(vec![1, 2, 3]),
    }
}

#[test]
fn a_bundle_reads_back_to_the_last_bit_also_where_it_is_not_a_number() {
    let written = bundle();
    assert_eq!(Bundle::read(&written.write().unwrap()).unwrap(), written);
    let mut odd = bundle();
    odd.events =
        vec![Event { tick: 1, what: Change::Push(0, Vector::new(NAN, -NAN, f64::NEG_INFINITY)) }];
    let read = Bundle::read(&odd.write().unwrap()).unwrap();
    let Change::Push(_, newtons) = read.events[0].what else { panic!("{:?}", read.events) };
    let bits = newtons.to_array().map(f64::to_bits);
    assert_eq!(bits, [NAN.to_bits(), (-NAN).to_bits(), f64::NEG_INFINITY.to_bits()]);
}

/// The bytes of the test bundle, with each file replaced by the result of `change`.
fn repacked(change: impl Fn(&str, Vec<u8>) -> Vec<u8>) -> Vec<u8> {
    let bytes = bundle().write().unwrap();
    let mut archive = ZipArchive::new(Cursor::new(&bytes[..])).unwrap();
    let files = [&SCENE, &MANIFEST, &STATE]
        .map(|member| (member, change(member.name, file(&mut archive, member).unwrap().unwrap())));
    let mut bytes = pack(&files.each_ref().map(|(member, bytes)| (*member, &bytes[..]))).unwrap();
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
            // An enumeration is a map with one key and stays as it is.
            if pairs.len() > 1 {
                pairs.push((
                    Value::Text("of_later".to_owned()),
                    Value::Array(vec![Value::Float(1.5)]),
                ));
            }
        }
        Value::Array(items) => items.iter_mut().for_each(add_keys),
        _ => {}
    }
}

fn in_state(change: impl Fn(&mut Value)) -> Vec<u8> {
    repacked(|name, bytes| {
        if name != STATE.name {
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
        "manifest.json" => {
            let text = String::from_utf8(bytes).unwrap();
            text.replacen('{', "{\"of_later\": {\"a\": [1]},", 1).into_bytes()
        }
        _ => bytes,
    });
    assert_eq!(Bundle::read(&later).unwrap(), plain);
}

#[test]
fn keys_of_an_earlier_program_that_are_gone_are_passed_over_and_those_that_it_did_not_write_are_empty()
 {
    let earlier = in_state(|state| {
        let Value::Map(state) = state else { panic!("{state:?}") };
        state.retain(|(key, _)| key.as_text() != Some("energy"));
        let snapshot = state.iter_mut().find(|(key, _)| key.as_text() == Some("snapshot"));
        let Some((_, Value::Map(snapshot))) = snapshot else { panic!("a snapshot") };
        let before = snapshot.len();
        snapshot.retain(|(key, _)| key.as_text() != Some("emissions"));
        assert_eq!(snapshot.len(), before - 1);
        // Accelerations that an earlier program cached.
        let numbers = |count| Value::Array(vec![Value::Float(0.5); count]);
        let map = |pairs: Vec<(&str, Value)>| {
            Value::Map(
                pairs
                    .into_iter()
                    .map(|(key, value)| (Value::Text(key.to_owned()), value))
                    .collect(),
            )
        };
        let body = map(vec![("at", numbers(4)), ("time_s", 0.2.into()), ("called", numbers(4))]);
        let bodies =
            [(0, body), (2, Value::Null)].map(|(id, kept)| Value::Array(vec![id.into(), kept]));
        let group = map(vec![
            ("bodies", Value::Array(vec![0.into(), 1.into()])),
            ("accelerations", Value::Array(vec![numbers(4), numbers(4)])),
            ("time_s", 0.2.into()),
            ("kinds", u64::MAX.into()),
        ]);
        snapshot.push((Value::Text("kept".to_owned()), Value::Array(bodies.into())));
        snapshot.push((Value::Text("kept_groups".to_owned()), Value::Array(vec![group])));
    });
    let read = Bundle::read(&earlier).unwrap();
    let mut expected = Bundle { picture: None, energy: Some(EnergyState::at(20, 0.1)), ..bundle() };
    assert!(!expected.snapshot.state.emissions.is_empty());
    expected.snapshot.state.emissions = Vec::new();
    assert_eq!(read, expected);
    let scene = read.scene("test").unwrap();
    Simulation::restore(scene, &read.snapshot).unwrap();
}

#[test]
fn text_that_would_steer_a_terminal_or_forge_a_line_is_refused() {
    type Change = fn(&mut Manifest, String);
    let fault = |manifest: &mut Manifest, what| manifest.fault.as_mut().unwrap().what = what;
    let body = |manifest: &mut Manifest, body| manifest.fault.as_mut().unwrap().body = Some(body);
    let changes: [(&str, Change); 4] = [
        ("program", |manifest, text| manifest.program = text),
        ("scene", |manifest, text| manifest.scene = text),
        ("fault.what", fault),
        ("fault.body", body),
    ];
    for (key, change) in changes {
        for text in ["\u{1b}]0;title\u{7}", "lost\nthe same state, hash 0123456789abcdef"] {
            let forged = repacked(|name, bytes| match name {
                "manifest.json" => {
                    let mut manifest = serde_json::from_slice(&bytes).unwrap();
                    change(&mut manifest, text.to_owned());
                    serde_json::to_vec(&manifest).unwrap()
                }
                _ => bytes,
            });
            let error = Bundle::read(&forged).expect_err(key).to_string();
            assert!(error.contains(&format!("`{key}`")) && !error.contains(text), "{error}");
        }
    }
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
            assert!(error.contains("damaged") || error.contains("not a bundle"), "{error}");
        }
        Bundle::read(&good[..place]).expect_err("a cut file");
    }
    for more in [&b"0"[..], b"\0", b"PK"] {
        let longer = [&good[..], more].concat();
        Bundle::read(&longer).expect_err("a longer file");
    }
}

#[test]
fn what_no_state_can_be_is_said_in_words() {
    let deep = [vec![0x81; 5000], vec![0x80]].concat();
    for (state, words) in [
        (&b"\x1c"[..], "state.cbor: it is not CBOR from byte 0 on"),
        (b"\xa1\x66events\x82", "state.cbor: it ends too early"),
        (b"\xa1\x66events\x01", "state.cbor: invalid type: "),
        (&[&b"\xa1\x66events"[..], &deep].concat(), "state.cbor: "),
    ] {
        let bytes = repacked(|name, whole| if name == STATE.name { state.to_vec() } else { whole });
        let said = said(&bytes);
        assert!(said.contains(words), "{said}");
        assert!(
            !["Semantic", "Limit", "Syntax", "Io("].iter().any(|debug| said.contains(debug)),
            "{said}"
        );
    }
}

#[test]
fn lies_about_lengths_are_errors_and_take_no_memory() {
    // A list of 2^60 items, then a text and a byte string of 2^60 bytes.
    for lie in
        [&b"\x9b\x10\0\0\0\0\0\0\0"[..], b"\x7b\x10\0\0\0\0\0\0\0", b"\x5b\x10\0\0\0\0\0\0\0"]
    {
        let key = b"\xa1\x66events";
        let bytes = [&key[..], lie].concat();
        let error = Bundle::read(&repacked(
            |name, whole| if name == STATE.name { bytes.clone() } else { whole },
        ));
        assert!(error.unwrap_err().to_string().starts_with("the bundle cannot be read"));
    }
    let nested = vec![0x81; 1 << 20];
    let error = Bundle::read(&repacked(
        |name, whole| if name == STATE.name { nested.clone() } else { whole },
    ));
    assert!(error.is_err());
}

#[test]
fn a_newer_format_is_named() {
    let newer = repacked(|name, bytes| match name {
        "manifest.json" => b"{\"format\": 9}".to_vec(),
        _ => bytes,
    });
    let error = Bundle::read(&newer).unwrap_err().to_string();
    let expected = "format 9 of the bundle is newer than this program, which reads format 1; use a newer program";
    assert_eq!(error, expected);
}

/// The test bundle with a changed manifest.
fn with_manifest(change: impl Fn(&mut serde_json::Map<String, serde_json::Value>)) -> Vec<u8> {
    repacked(|name, bytes| {
        if name != MANIFEST.name {
            return bytes;
        }
        let mut manifest = serde_json::from_slice(&bytes).unwrap();
        change(&mut manifest);
        serde_json::to_vec(&manifest).unwrap()
    })
}

fn said(bytes: &[u8]) -> String {
    Bundle::read(bytes).map_or_else(|error| error.to_string(), |_| "fine".to_owned())
}

#[test]
fn a_manifest_without_a_format_is_refused() {
    let none = "manifest.json in the bundle has no format; get an undamaged copy";
    assert_eq!(said(&with_manifest(|manifest| drop(manifest.remove("format")))), none);
    assert_eq!(
        said(&with_manifest(|manifest| drop(manifest.insert("format".to_owned(), 0.into())))),
        none
    );
    assert_eq!(said(&with_manifest(serde_json::Map::clear)), none);
    let mut bundle = bundle();
    bundle.manifest.format = 0;
    assert!(bundle.write().is_err());
}

#[test]
fn ticks_that_contradict_each_other_or_never_end_are_refused() {
    let with = |key: &'static str, tick: u64| {
        said(&with_manifest(move |manifest| drop(manifest.insert(key.to_owned(), tick.into()))))
    };
    let contradiction = "the ticks of the bundle contradict each other; get an undamaged copy";
    assert_eq!(with("end_tick", 19), contradiction);
    assert_eq!(with("snapshot_tick", 19), contradiction);
    assert_eq!(with("snapshot_tick", 21), contradiction);
    assert_eq!(with("end_tick", 20), "fine");
    assert_eq!(with("end_tick", 1_000_000_020), "fine");
    let endless = |ticks: u64| {
        let cure = "save a run of fewer ticks per second";
        format!("the bundle is of {ticks} ticks, which are more than 1000000000; {cure}")
    };
    assert_eq!(with("end_tick", 1_000_000_021), endless(1_000_000_001));
    assert_eq!(with("end_tick", u64::MAX), endless(u64::MAX - 20));

    let keyframes = |ticks: &[u64]| {
        let keyframes: Vec<_> =
            ticks.iter().map(|tick| serde_json::json!({ "tick": tick })).collect();
        said(&with_manifest(|manifest| {
            drop(manifest.insert("keyframes".to_owned(), keyframes.clone().into()));
        }))
    };
    for contradicting in [&[19][..], &[21], &[20, 26], &[20, 20], &[20, 23, 22]] {
        assert_eq!(keyframes(contradicting), contradiction, "{contradicting:?}");
    }
    for fine in [&[][..], &[20], &[20, 25], &[20, 21, 25]] {
        assert_eq!(keyframes(fine), "fine", "{fine:?}");
    }
}

#[test]
fn what_would_be_refused_is_not_written() {
    let refused = |bundle: Bundle| bundle.write().unwrap_err().to_string();
    let large = |most: u64| vec![b' '; usize::try_from(most + 1).unwrap()];
    let scene = String::from_utf8(large(SCENE.most)).unwrap();
    let cure = "make it of fewer bodies";
    let expected = format!("scene.ron in the bundle would be larger than 67108864 bytes; {cure}");
    assert_eq!(refused(Bundle { scene, ..bundle() }), expected);
    let expected =
        format!("picture.png in the bundle would be larger than 268435456 bytes; {cure}");
    assert_eq!(refused(Bundle { picture: Some(large(PICTURE.most)), ..bundle() }), expected);
    let mut many = bundle();
    many.snapshot.state.dormant.reserve_exact(MOST_MEMORY / 4);
    assert_eq!(
        refused(many),
        format!("the state of the bundle takes more than 268435456 bytes of memory; {cure}")
    );
    let mut late = bundle();
    late.manifest.end_tick = u64::MAX;
    assert!(refused(late).contains("which are more than 1000000000"));
    let mut own_law = bundle();
    own_law.snapshot.state.evaluations =
        Evaluations::from_counts(0, [("harmonic", 1)], Iterations::default());
    let expected = "this program knows no `harmonic`";
    assert!(refused(own_law).contains(expected));
}

#[test]
fn what_is_short_in_the_file_and_long_in_memory_is_an_error() {
    // Entries of 3 bytes in the file and 72 bytes in memory: a little more than the limit allows.
    let entries = MOST_MEMORY / 72 + 1;
    let mut state = b"\xa1\x68snapshot\xa1\x69emissions\x9a".to_vec();
    state.extend(u32::try_from(entries).unwrap().to_be_bytes());
    state.extend([0x82, 0x00, 0xa0].repeat(entries));
    assert_eq!(size_of_val(&bundle().snapshot.state.emissions[..1]), 72);
    let bytes = repacked(|name, whole| if name == STATE.name { state.clone() } else { whole });
    assert!(said(&bytes).contains("it takes too much memory"), "{}", said(&bytes));
}

#[test]
fn an_empty_run_of_things_is_refused_by_its_scene() {
    let bytes = in_state(|state| {
        let Value::Map(state) = state else { panic!("{state:?}") };
        let Some((_, Value::Map(snapshot))) = state.first_mut() else { panic!("a snapshot") };
        let things = snapshot.iter_mut().find(|(key, _)| key.as_text() == Some("things")).unwrap();
        let run = |first: u8, count: u8| Value::Array(vec![first.into(), count.into()]);
        things.1 = Value::Array(vec![run(1, 0), run(0, 1)]);
    });
    let bundle = Bundle::read(&bytes).unwrap();
    let error = Simulation::restore(bundle.scene("test").unwrap(), &bundle.snapshot).err().unwrap();
    assert_eq!(error.to_string(), "it has things that the scene lacks");
}
