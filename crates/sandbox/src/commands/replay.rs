//! `sandbox replay`: simulates a bundle again without a window, and compares the hash and the fault.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use history::Bundle;
use serde_json::{Value, json};

use crate::args::cores;
use crate::failure::Failure;
use crate::output::bundle::repeated;
use crate::output::command_files::CommandFiles;
use crate::output::files::{make_folder, refuse_foreign_files, write};
use crate::output::report::fault_json;
use crate::output::show;
use crate::output::states;
use cockpit::app::bundle::{PROGRAM, Repetition};
use cockpit::app::session::Session;
use cockpit::stage::options::Options;

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox replay bundle_001.zip
  sandbox replay fault.zip --out fault";

/// Runs a bundle again.
#[derive(Args, Debug)]
pub(crate) struct ReplayArgs {
    /// The bundle that `run --black-box` or Ctrl+S wrote
    bundle: PathBuf,
    /// Write scene.ron, state.csv of the end, the picture and summary.json into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Does what `sandbox replay` says.
pub(crate) fn run(args: &ReplayArgs) -> Result<(), Failure> {
    let (path, out) = (&args.bundle, args.out.as_deref());
    let mut files = CommandFiles::default();
    let bundle = files.bundle(path)?;
    if let Some(folder) = out {
        let is_written = |name: &str| FILES.contains(&name);
        files.refuse_names(
            folder,
            is_written,
            "the files that --out writes; give another folder",
        )?;
        let earlier = fs::read_to_string(folder.join(SUMMARY)).unwrap_or_default();
        let is_own = earlier.contains("\"first_different_tick\"");
        refuse_foreign_files(folder, is_own, is_written, "give another folder")?;
    }
    let name = path.display().to_string();
    let options =
        Options { pictures: false, interpolate: false, threads: cores(), ..Options::default() };
    let (session, repetition) = repeated(&bundle, &name, options)?;
    let manifest = &bundle.manifest;
    if let Some(folder) = out {
        make_folder(folder)?;
        unpack(folder, &files, &bundle, &session, &summary(&name, &bundle, &repetition))?;
    }
    let (from, to) = (manifest.snapshot_tick, manifest.end_tick);
    show(&format!("{}, ticks {from} to {to}, written by {}\n", manifest.scene, manifest.program))?;
    if !repetition.same() {
        return Err(Failure::Expectation(format!(
            "{name}: {}",
            repetition.differences(manifest).join("; ")
        )));
    }
    let fault = repetition
        .fault
        .as_ref()
        .map_or("no fault in either run".to_owned(), |fault| format!("the same fault, {fault}"));
    show(&format!("the same state, hash {:016x}; {fault}\n", repetition.state_hash))
}

fn summary(name: &str, bundle: &Bundle, repetition: &Repetition) -> Value {
    let manifest = &bundle.manifest;
    json!({
        "bundle": name,
        "scene": manifest.scene,
        "same": repetition.same(),
        "first_different_tick": repetition.first_different_tick,
        "snapshot_tick": manifest.snapshot_tick,
        "end_tick": manifest.end_tick,
        "state_hash": { "then": manifest.end_state_hash, "now": format!("{:016x}", repetition.state_hash) },
        "fault": {
            "then": fault_json(manifest.fault.as_ref()), "now": fault_json(repetition.fault.as_ref()),
        },
        "program": { "then": manifest.program, "now": PROGRAM },
        "picture": bundle.picture.as_ref().map(|_| PICTURE),
    })
}

const PICTURE: &str = "picture.png";

/// The files that `--out` writes.
const FILES: [&str; 4] = ["scene.ron", "state.csv", PICTURE, SUMMARY];

const SUMMARY: &str = "summary.json";

/// Writes the files of `--out`. The summary comes last: if it exists, the others do.
fn unpack(
    folder: &Path,
    files: &CommandFiles,
    bundle: &Bundle,
    session: &Session,
    summary: &Value,
) -> Result<(), Failure> {
    let state =
        states::csv_of(&session.stage).map_err(|error| Failure::file("write", folder, &error))?;
    let write = |name: &str, bytes: &[u8]| write(&files.unread(&folder.join(name))?, bytes);
    let [scene_file, state_file, picture_file, summary_file] = FILES;
    write(scene_file, bundle.scene.as_bytes())?;
    write(state_file, &state)?;
    if let Some(picture) = &bundle.picture {
        write(picture_file, picture)?;
    }
    let summary =
        serde_json::to_string_pretty(summary).expect("numbers and strings are JSON") + "\n";
    write(summary_file, summary.as_bytes())
}
