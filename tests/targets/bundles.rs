//! Whatever a bundle holds: it is read and can be run, or it is refused.

use std::io::{Cursor, Read as _, Write as _};

use arbitrary::{Result, Unstructured};
use history::{BUNDLE_FORMAT, Bundle, Change, Event, Manifest, Overrides, Simulation};
use motion::Method;
use sandbox::{Options, Session};
use scene::Scene;
use xxhash_rust::xxh3::xxh3_64;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use super::numbers::{any_vector, at_least_0};
use super::scenes;
use super::step::assert_finite;

/// What there is time for.
const MOST_TICKS: u64 = 50;
const MOST_BODIES: usize = 200;

/// Hexadecimal digits of the checksum at the end.
const DIGITS: usize = 16;

/// Any bytes, and a bundle in which some bytes were changed behind the back of its checksums.
pub fn bundle(bytes: &[u8]) {
    read(bytes);
    let mut u = Unstructured::new(bytes);
    if let Ok(Some((bundle, scene))) = whole(&mut u) {
        let written = bundle.write().expect("it is small");
        let again = Bundle::read(&written).expect("it was written").write();
        // By bytes: what is not a number equals nothing, itself neither.
        assert!(again.as_ref() == Ok(&written), "it is read as it was written");
        assert!(goes_on(&bundle, &scene), "it is refused by its own scene");
        if let Ok(damaged) = damaged(&mut u, &written)
            && let Some(bundle) = read(&damaged)
        {
            goes_on(&bundle, &scene);
            opens(&bundle);
        }
    }
}

fn read(bytes: &[u8]) -> Option<Bundle> {
    let read = Bundle::read(bytes);
    if let Err(error) = &read {
        assert!(!error.to_string().trim().is_empty(), "an error without words");
    }
    read.ok()
}

/// Runs a bundle's snapshot for some ticks in `scene`; `false`: it was refused.
fn goes_on(bundle: &Bundle, scene: &Scene) -> bool {
    let _ = bundle.snapshot.state_hash();
    match Simulation::restore(scene.clone(), &bundle.snapshot) {
        Ok(mut run) => {
            // A false number of substeps is allowed, and takes its time.
            if run.world.get_resource::<motion::Substeps>().is_none_or(|parts| parts.0 <= 8) {
                run.run(2);
                assert_finite(&mut run.world);
            }
            true
        }
        Err(error) => {
            assert!(!error.to_string().trim().is_empty(), "an error without words");
            false
        }
    }
}

/// Opens what was read as the program does, with its own scene and settings.
fn opens(bundle: &Bundle) {
    let Manifest { snapshot_tick, end_tick, .. } = bundle.manifest;
    let short = end_tick.saturating_sub(snapshot_tick) <= MOST_TICKS;
    let few = |scene: &Scene| {
        let substeps = scene.bodies.iter().filter_map(|body| body.substeps).chain([scene.substeps]);
        substeps.max() <= Some(8.into()) && scene.bodies.len() <= MOST_BODIES
    };
    if !short || !bundle.scene("any").is_ok_and(|scene| few(&scene)) {
        return;
    }
    let options = Options { pictures: false, ..Options::default() };
    match Session::of_bundle(bundle, "any", options, &mut |_| ()) {
        Ok((mut session, _)) => {
            session.rewind_before_fault();
            assert!(session.stage.bundle(None).is_some(), "what was opened can be saved");
        }
        Err(failure) => assert!(!failure.to_string().trim().is_empty(), "an error without words"),
    }
}

/// A bundle of a random scene, some ticks on.
fn whole(u: &mut Unstructured<'_>) -> Result<Option<(Bundle, Scene)>> {
    let text = scenes::text(u)?;
    let Ok(scene) = Scene::parse("any", &text) else { return Ok(None) };
    let mut run = Simulation::new(scene.clone());
    run.run(u.int_in_range(0..=3)?);
    let snapshot = run.snapshot();
    let what = match u.int_in_range(0..=3)? {
        0 => Change::Push(0, any_vector(u)?),
        1 => Change::Method(*u.choose(&Method::ALL)?),
        2 => Change::Step(at_least_0(u)?),
        _ => Change::Requests(vec![motion::Request::SetVelocity(0, any_vector(u)?)]),
    };
    let (format, settings, tick) = (BUNDLE_FORMAT, Overrides::of(&scene), snapshot.ticks());
    let manifest =
        Manifest { format, settings, snapshot_tick: tick, end_tick: tick, ..Manifest::default() };
    // What is not a number equals nothing, itself neither.
    let finite = !format!("{what:?}").contains("NaN");
    let events = if finite { vec![Event { tick: snapshot.ticks(), what }] } else { Vec::new() };
    Ok(Some((
        Bundle { scene: text, manifest, snapshot, events, energy: None, picture: None },
        scene,
    )))
}

/// The same archive with some bytes of its files changed, and all checksums right.
fn damaged(u: &mut Unstructured<'_>, bundle: &[u8]) -> Result<Vec<u8>> {
    let mut files = Vec::new();
    let mut archive = ZipArchive::new(Cursor::new(bundle)).expect("it is an archive");
    for i in 0..archive.len() {
        let mut file = archive.by_index(i).expect("it is there");
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).expect("it is whole");
        let name = file.name().expect("names are UTF-8").into_owned();
        files.push((name, bytes));
    }
    for _ in 0..u.int_in_range(1..=4)? {
        let file = u.choose_index(files.len())?;
        let (_, bytes) = &mut files[file];
        let at = u.int_in_range(0..=bytes.len().saturating_sub(1))?;
        match u.int_in_range(0..=3)? {
            0 => bytes.truncate(at),
            1 => bytes.insert(at, u.arbitrary()?),
            _ if at < bytes.len() => bytes[at] = u.arbitrary()?,
            _ => {}
        }
    }
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        archive.start_file(name, SimpleFileOptions::default()).expect("memory takes it");
        archive.write_all(&bytes).expect("memory takes it");
    }
    archive.set_comment("0".repeat(DIGITS)).expect("it is short");
    let mut bytes = archive.finish().expect("memory takes it").into_inner();
    let end = bytes.len() - DIGITS;
    let checksum = format!("{:016x}", xxh3_64(&bytes[..end]));
    bytes[end..].copy_from_slice(checksum.as_bytes());
    Ok(bytes)
}
