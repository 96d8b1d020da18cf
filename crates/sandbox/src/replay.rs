//! `sandbox replay`: a bundle, simulated again without a window to the same hash and the same fault.

use std::fs;
use std::io::Read as _;
use std::path::Path;

use lab::{ENERGY_JUMP, Fault, Replay, Watch};
use motion::Ledger;
use scene::{Bundle, FaultEntry, Scene};

use crate::PROGRAM;
use crate::cli::show;
use crate::failure::Failure;

/// Largest file that is read, bytes.
const MOST_BYTES: u64 = 1 << 30;

/// What came out.
struct Outcome {
    /// The first tick whose state hash was another one.
    diverged_at: Option<u64>,
    faults: Vec<FaultEntry>,
    hash: String,
}

/// Does what `sandbox replay` says.
pub(crate) fn replay(path: &Path) -> Result<(), Failure> {
    let bundle = read(path)?;
    let name = path.display().to_string();
    let scene = bundle.scene(&format!("{name}: scene.ron"))?;
    let outcome = repeat(&bundle, &scene).map_err(|what| Failure::Usage(format!("{name}: {what}")))?;
    let manifest = &bundle.manifest;
    let (from, to) = (manifest.snapshot_tick, manifest.end_tick);
    show(&format!("{}, ticks {from} to {to}, written by {}\n", manifest.scene, manifest.program));
    let mut differences = Vec::new();
    if let Some(tick) = outcome.diverged_at {
        differences.push(format!("the state differs from tick {tick} on"));
    } else if outcome.hash != manifest.end_state_hash {
        differences.push(format!("the state differs at the end, tick {to}"));
    }
    let same = match &manifest.fault {
        Some(fault) => outcome.faults.contains(fault),
        None => outcome.faults.is_empty(),
    };
    if !same {
        let words = |fault: Option<&FaultEntry>| fault.map_or("no fault".to_owned(), words);
        let (now, then) = (outcome.faults.first(), manifest.fault.as_ref());
        differences.push(format!("{} instead of {}", words(now), words(then)));
    }
    if differences.is_empty() {
        let fault = manifest
            .fault
            .as_ref()
            .map_or("no fault, as then".to_owned(), |fault| format!("the same fault, {}", words(fault)));
        show(&format!("the same state, hash {}; {fault}\n", outcome.hash));
        return Ok(());
    }
    if manifest.program != PROGRAM {
        differences.push(format!("it was written by {}, this is {PROGRAM}", manifest.program));
    }
    Err(Failure::Expectation(format!("{name}: {}", differences.join("; "))))
}

fn read(path: &Path) -> Result<Bundle, Failure> {
    let cannot = |error: std::io::Error| Failure::file("read", path, &error);
    if path.is_dir() {
        return Err(cannot(std::io::ErrorKind::IsADirectory.into()));
    }
    let mut bytes = Vec::new();
    fs::File::open(path).and_then(|file| file.take(MOST_BYTES).read_to_end(&mut bytes)).map_err(cannot)?;
    Bundle::read(&bytes).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))
}

fn words(fault: &FaultEntry) -> String {
    let body = fault.body.as_ref().map_or(String::new(), |body| format!("{body}, "));
    format!("{body}tick {}: {}", fault.tick, fault.what)
}

fn repeat(bundle: &Bundle, scene: &Scene) -> Result<Outcome, String> {
    let manifest = &bundle.manifest;
    let mut replay = Replay::of(scene, &bundle.snapshot).map_err(|error| {
        format!("the snapshot in the bundle is none of its scene: {error}; get an undamaged copy")
    })?;
    if replay.ticks() != manifest.snapshot_tick || manifest.end_tick < manifest.snapshot_tick {
        return Err("the ticks of the bundle contradict each other; get an undamaged copy".to_owned());
    }
    let mut ledger = bundle.energy_scale_j.map(|_| Ledger::open(&mut replay.world));
    let mut watch = Watch::new(&replay.world, ledger.as_ref(), bundle.energy_scale_j, ENERGY_JUMP);
    let mut events = bundle.events.iter().peekable();
    let mut keyframes = manifest.keyframes.iter().peekable();
    let (mut diverged_at, mut faults) = (None, Vec::new());
    loop {
        if let Some(keyframe) = keyframes.next_if(|keyframe| keyframe.tick == replay.ticks()) {
            let hash = format!("{:016x}", replay.state_hash());
            if hash != keyframe.state_hash && diverged_at.is_none() {
                diverged_at = Some(keyframe.tick);
            }
        }
        if replay.ticks() >= manifest.end_tick {
            break;
        }
        replay.tick(&mut events, ledger.as_mut());
        faults.extend(watch.look(&replay.world, ledger.as_ref()));
    }
    let faults = faults.iter().map(|fault: &Fault| fault.named(&scene.names)).collect();
    Ok(Outcome { diverged_at, faults, hash: format!("{:016x}", replay.state_hash()) })
}
