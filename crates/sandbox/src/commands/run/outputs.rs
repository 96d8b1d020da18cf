//! What a run without a window writes: pictures, the states of its ticks, a summary, a bundle, and how it ended.

use std::io::Write as _;
use std::path::Path;

use motion::Totals;
use motion::ledger::Ledger;
use render::{Film, Image, Quality};
use scene::{Action, Script};
use serde_json::Value;

use crate::app::session::Session;
use crate::commands::run::RunArgs;
use crate::failure::Failure;
use crate::output::black_box::{self, BlackBox};
use crate::output::files::{Output, output_file, place};
use crate::output::pictures::{Camera, with_settings};
use crate::output::report::{self, STATE_HEADER, Summary};
use crate::output::{show, tell};
use crate::stage::Stage;

/// What a run is written into when it is over.
pub(super) struct Outputs<'a> {
    pub args: &'a RunArgs,
    pub watch: Watch,
    pub camera: Option<Camera>,
    pub film: Option<(Film, Output)>,
    pub summary: Option<Output>,
    pub black_box: Option<Output>,
}

impl Outputs<'_> {
    /// Writes all of it, and says how the run of `session` ended, which began with `start`; `refused` is why it was not
    /// gone on with.
    pub fn finish(
        self,
        mut session: Session,
        start: Totals,
        refused: Result<(), Failure>,
    ) -> Result<(), Failure> {
        let Self { args, mut watch, camera, film, summary: summary_file, black_box: box_file } = self;
        if let Err(failure) = watch.finish(&session.stage, args.state.as_deref()) {
            if session.stage.fault().is_none() && session.stage.all_quarantined().is_empty() {
                return Err(failure);
            }
            // What went wrong in the run is worse, and is written where that can be done.
            tell(&failure.to_string());
        }
        let adapter = camera.as_ref().map(|camera| camera.gpu.info.to_string());
        let pictures = camera.as_ref().map_or(0, |camera| camera.pictures);
        let mut summary = Summary::of(&mut session, start, pictures, adapter);
        let picture = |session: &mut Session| still(session, camera);
        let mut black_box = None;
        if let Some((path, file)) = args.black_box.as_deref().zip(box_file) {
            black_box = black_box::write(path, file, &mut session, picture);
            summary.add("black_box", black_box.as_ref().map_or(Value::Null, BlackBox::json));
        }
        let shown = show(&summary.to_table());
        let unconverged = session.stage.evaluations().unconverged_steps();
        if unconverged > 0 {
            eprintln!(
                "{unconverged} implicit steps did not converge; a higher step rate or more substeps may help"
            );
        }
        let mut written = shown;
        if let (Some(path), Some((film, file))) = (&args.film, film) {
            let finished =
                with_settings(&session.stage, |text| film.png(text)).and_then(|png| file.finish_with(&png));
            written = written.and(finished.map_err(|error| Failure::file("write", path, &error)));
        }
        if let (Some(path), Some(file)) = (&args.summary, summary_file) {
            let summary = file.finish_with(summary.to_json().as_bytes());
            written = written.and(summary.map_err(|error| Failure::file("write", path, &error)));
        }
        // A run that waits forever names its step itself.
        let left = if refused.is_ok() { steps_left(args, &session) } else { None };
        let verdict = match black_box {
            Some(black_box) => Err(black_box.verdict()),
            None => verdict(args, &session).and(refused),
        };
        let verdict = match left {
            Some(left) if args.assert && verdict.is_ok() => Err(Failure::Expectation(left)),
            left => {
                left.iter().for_each(|left| tell(left));
                verdict
            }
        };
        if let (Err(_), Err(failure)) = (&verdict, &written) {
            tell(&failure.to_string());
        }
        verdict.and(written)
    }
}

/// The steps of the script that the run ended before, as a sentence.
fn steps_left(args: &RunArgs, session: &Session) -> Option<String> {
    let player = session.player()?;
    let (first, step) = player.left().min_by_key(|(place, _)| *place)?;
    let others = match player.left().count() - 1 {
        0 => " was".to_owned(),
        others => format!(", and {others} more were"),
    };
    let script = args.script.as_deref().unwrap_or(Path::new("")).display();
    let (when, tick, seconds) = (step.when, session.stage.ticks(), session.stage.simulated());
    Some(format!(
        "{script}: steps[{first}], at {when}{others} not reached: the run ended at tick {tick}, {seconds} s; let it last longer"
    ))
}

fn verdict(args: &RunArgs, session: &Session) -> Result<(), Failure> {
    let quarantined = session.stage.all_quarantined();
    if let Some(first) = quarantined.first() {
        let count = quarantined.len();
        let more = if count > 1 { format!(" and {} more", count - 1) } else { String::new() };
        return Err(Failure::Quarantined(format!(
            "{}{more} quarantined in tick {}: {}",
            first.body, first.tick, first.what
        )));
    }
    // A run that went back from a fault, and was not gone on with, has not got past it.
    if let Some(fault) = session.stage.fault().filter(|fault| fault.tick > session.stage.ticks()) {
        return Err(Failure::Expectation(fault.named(&session.stage.scene().names).to_string()));
    }
    let Some(expect) = session.stage.scene().expect.filter(|_| args.assert) else { return Ok(()) };
    let Some(bound) = expect.energy_drift_below else { return Ok(()) };
    let drift = session.tools.ledger().map_or(f64::NAN, Ledger::relative_residual);
    // Written so that a drift that is not a number fails.
    if drift < bound {
        Ok(())
    } else {
        Err(Failure::Expectation(format!("energy drifted by {drift:.3e}, not below {bound:e}")))
    }
}

/// Files at one place would be written over each other, or over what is read.
pub(super) fn refuse_same_files(args: &RunArgs, script: Option<&Script>) -> Result<(), Failure> {
    let scene = Path::new(&args.scene);
    let files = [
        ("the scene", Some(scene).filter(|scene| scene.is_file())),
        ("--script", args.script.as_deref()),
        ("--frame-times", args.frame_times.as_deref()),
        ("--state", args.state.as_deref()),
        ("--summary", args.summary.as_deref()),
        ("--black-box", args.black_box.as_deref()),
        ("--film", args.film.as_deref()),
    ];
    let files: Vec<_> = files.into_iter().filter_map(|(name, path)| Some((name, place(path?)))).collect();
    for (number, (flag, path)) in files.iter().enumerate() {
        if let Some((other, _)) = files[..number].iter().find(|(_, other)| other == path)
            && !INPUTS.contains(flag)
        {
            return Err(Failure::Usage(format!("{other} and {flag} name the same file; give two")));
        }
    }
    if args.frames.is_none() && script.is_none() {
        return Ok(());
    }
    let folder = place(pictures_folder(args));
    let shots = script.iter().flat_map(|script| &script.steps).filter_map(|step| match &step.action {
        Action::Screenshot(name) => Some(&**name),
        _ => None,
    });
    let shots: Vec<_> = shots.collect();
    for (flag, path) in &files {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.parent() == Some(&folder) && (shots.contains(&&*name) || is_numbered(&name)) {
            let what = "is a name of the pictures and files that the run makes there; give another";
            return Err(Failure::Usage(format!("{flag}: {} {what}", path.display())));
        }
    }
    Ok(())
}

/// Inputs may be read twice.
const INPUTS: [&str; 2] = ["--script", "--frame-times"];

/// Where pictures are written, and what keys of a script write.
pub(super) fn pictures_folder(args: &RunArgs) -> &Path {
    args.frames.as_deref().unwrap_or(Path::new("."))
}

/// Files that a frame writes, as the start and the end of their names.
pub(super) const PICTURE: [&str; 2] = ["frame", "png"];
pub(super) const SCREENSHOT: [&str; 2] = ["screenshot", "png"];
pub(super) const GRAPH: [&str; 2] = ["graph", "csv"];
pub(super) const BUNDLE: [&str; 2] = ["bundle", "zip"];

/// The name of such a file of that frame.
pub(super) fn numbered([what, extension]: [&str; 2], frame: u64) -> String {
    format!("{what}_{frame:06}.{extension}")
}

/// Whether a frame may write a file of that name.
fn is_numbered(name: &str) -> bool {
    let digits = name.trim_matches(|c: char| !c.is_ascii_digit());
    let is_of =
        |frame| [PICTURE, SCREENSHOT, GRAPH, BUNDLE].iter().any(|what| numbered(*what, frame) == name);
    digits.parse().is_ok_and(is_of)
}

/// A picture of the present state, by `camera` if there is one already.
fn still(session: &mut Session, camera: Option<Camera>) -> Result<Image, Failure> {
    let mut camera = match camera {
        Some(camera) => camera,
        None => Camera::without_folder(session.view.size_px(), Quality::FIXED)?,
    };
    session.lay_out_still();
    camera.picture(session)
}

/// Looks at every tick: rows of the state file.
pub(super) struct Watch {
    state: Option<Output>,
    every: u64,
    last: Option<u64>,
    pub error: Option<std::io::Error>,
}

impl Watch {
    pub const fn new(state: Option<Output>, every: u64) -> Self {
        Self { state, every, last: None, error: None }
    }

    pub fn after_tick(&mut self, stage: &Stage) {
        if stage.ticks().is_multiple_of(self.every) {
            self.look(stage);
        }
    }

    pub fn look(&mut self, stage: &Stage) {
        if let (Some(state), None) = (&mut self.state, &self.error) {
            self.error = report::write_state(stage, state).err();
            self.last = Some(stage.ticks());
        }
    }

    fn finish(&mut self, stage: &Stage, path: Option<&Path>) -> Result<(), Failure> {
        if self.state.is_some() && self.last != Some(stage.ticks()) {
            self.look(stage);
        }
        let finished = match (self.error.take(), self.state.take()) {
            (Some(error), _) => Err(error),
            (None, Some(state)) => state.finish(),
            (None, None) => Ok(()),
        };
        finished.map_err(|error| Failure::file("write", path.unwrap_or(Path::new("")), &error))
    }
}

/// Starts the file with the state of every so many ticks.
pub(super) fn state_file(path: &Path) -> Result<Output, Failure> {
    let mut state = output_file(path)?;
    writeln!(state, "{STATE_HEADER}").map_err(|error| Failure::file("write", path, &error))?;
    Ok(state)
}
