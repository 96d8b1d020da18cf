//! Runs without a window: the same session and renderer, a constant or given frame time, files as output.

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use lab::AttractionTick;
use motion::DampingModel;
use motion::effects::Effect;
use render::Quality;
use scene::Scene;

use crate::args::{
    SceneName, StepArgs, above_0, damping, effect, once, positive, rate, size, whole,
};
use crate::commands::lessons::demonstration::Demonstration;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::orders::carry_out;
use crate::output::progress::{Loading, progress_bar};
use crate::output::report::Summary;
use crate::output::states::{Quantity, Selection};
use crate::output::tell;
use cockpit::app::player::Player;
use cockpit::app::session::Session;
use cockpit::clock::FrameClock;
use cockpit::input::InputFrame;
use cockpit::stage::{Simulated, Stage};

mod film;
mod outputs;
mod setup;

use outputs::{OutputPaths, Outputs};
use report::ForecastRow;
use report::numbers::long_duration;
use setup::{FrameEnds, Setup};

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox run tutorial --seconds 5 --state states.csv
  sandbox run oscillator --method yoshida_4 --ledger --summary run.json
  sandbox run tutorial --script assets/scripts/tour.ron --seconds 6 --frames pictures";

/// Runs a scene without a window.
#[derive(Args, Debug)]
pub(crate) struct RunArgs {
    /// A shipped scene or a file
    pub scene: SceneName,
    /// Simulated seconds [default: those of 10 s of frames, or to the end of the frame times]
    #[arg(long, value_name = "S", conflicts_with = "ticks", allow_negative_numbers = true, value_parser = positive)]
    pub seconds: Option<f64>,
    /// Ticks
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole)]
    pub ticks: Option<u64>,
    /// Ticks per second; overrides the scene
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = rate)]
    pub hz: Option<f64>,
    #[command(flatten)]
    pub step: StepArgs,
    /// Damping model: tutorial, clamped, implicit or exact; overrides the scene
    #[arg(long, value_name = "MODEL", value_parser = damping)]
    pub damping: Option<DampingModel>,
    /// Start with this effect switched off; may be given several times
    #[arg(long, value_name = "EFFECT", value_parser = effect)]
    pub without: Vec<Effect>,
    /// Frames per second for scripts and pictures [default: 60]
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = rate)]
    pub fps: Option<f64>,
    /// Simulated seconds per second of frames [default: that of the scene]
    #[arg(long, value_name = "P", allow_negative_numbers = true, value_parser = rate)]
    pub pace: Option<f64>,
    /// A file with one frame time in seconds per line, instead of --fps
    #[arg(long, value_name = "FILE", conflicts_with = "fps")]
    pub frame_times: Option<PathBuf>,
    /// Play a script or a recording
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Show this lesson, of the program or a file, whose scene this is: each step is read, then done by its solution
    #[arg(long, value_name = "LESSON", conflicts_with_all = ["script", "frame_times"])]
    pub lesson: Option<String>,
    /// Check what the scene expects
    #[arg(long)]
    pub assert: bool,
    /// Keep a ledger of energy, momentum and angular momentum for the summary
    #[arg(long)]
    pub ledger: bool,
    /// Exit with code 1 before the first tick if the forecast finds something unstable
    #[arg(long)]
    pub refuse_unstable: bool,
    /// Write the state of every body as CSV
    #[arg(long, value_name = "FILE.csv")]
    pub state: Option<PathBuf>,
    /// Columns of the state file: position, velocity, acceleration, force, forces (each by its cause), energies, momentum, angular_momentum,
    /// distance:BODY
    #[arg(long, value_name = "COLUMN,...", value_delimiter = ',', requires = "state", default_values = ["position", "velocity"], value_parser = Quantity::parse)]
    pub columns: Vec<Quantity>,
    /// Only bodies whose names match: * stands for any letters, ? for one
    #[arg(long, value_name = "PATTERN,...", value_delimiter = ',', requires = "state")]
    pub bodies: Vec<String>,
    /// Ticks between two states
    #[arg(long, value_name = "K", default_value_t = 1, requires = "state", allow_negative_numbers = true, value_parser = above_0)]
    pub every: u64,
    /// Stop at the first fault, a quarantined body or energy from nowhere, and write a bundle for `sandbox replay`
    #[arg(long, value_name = "FILE")]
    pub black_box: Option<PathBuf>,
    /// Write the summary as JSON
    #[arg(long, value_name = "FILE.json")]
    pub summary: Option<PathBuf>,
    /// Write pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub frames: Option<PathBuf>,
    /// Frames between two pictures
    #[arg(long, value_name = "K", default_value_t = 1, requires = "frames", allow_negative_numbers = true, value_parser = above_0)]
    pub frame_every: u64,
    /// Write all frames as one animated PNG or GIF, without words but labels; --fps says how many per second [GIF: 25]
    #[arg(long, value_name = "FILE.png|FILE.gif")]
    pub film: Option<PathBuf>,
    /// Write what the scene or the lesson says, the time and a scale bar into the pictures, which have the program's own look
    #[arg(long, conflicts_with = "no_hud")]
    pub captions: bool,
    /// Size of the pictures, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// How pictures are drawn: fixed is the same on every machine, high has smooth edges, round balls and fine shadows
    #[arg(long, value_enum, default_value_t)]
    pub quality: PictureQuality,
    /// Leave the words out of the pictures, which have the program's own look then
    #[arg(long)]
    pub no_hud: bool,
}

/// How pictures are drawn.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum PictureQuality {
    #[default]
    Fixed,
    High,
}

impl From<PictureQuality> for Quality {
    fn from(quality: PictureQuality) -> Self {
        match quality {
            PictureQuality::Fixed => Self::FIXED,
            PictureQuality::High => Self::HIGH,
        }
    }
}

impl RunArgs {
    /// The columns and the bodies of the state file.
    fn selection(&self) -> Selection {
        Selection { quantities: once(&self.columns), bodies: self.bodies.clone() }
    }
}

/// Does what `sandbox run` says.
pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
    let loading = Loading::begin();
    let mut files = CommandFiles::default();
    let mut setup = Setup::new(args, &mut files)?;
    let paths = OutputPaths::claim(args, setup.script.as_ref(), &mut files)?;
    setup.check_memory(args)?;
    loading.next();
    let goes_back = setup.goes_back;
    let demonstration = setup.demonstration.take();
    let (mut session, ends, ticks) = setup.begin(args)?;
    if let Some(demonstration) = &demonstration {
        demonstration.begin(&mut session)?;
    }
    // The forecast comes before anything is written, because it may refuse the run.
    loading.next();
    let longest_frame = ends.longest();
    let told = forecast_start(args, &mut session, longest_frame)?;
    let long = ticks.and_then(|ticks| long_ticks(&session, ticks));
    told.iter().chain(&long).for_each(|line| loading.tell(line));
    let mut outputs = Outputs::open(args, &paths, files, &session, longest_frame)?;
    loading.next();
    let start = Summary::totals_at_start(&session.stage);
    drop(loading);
    keep_ledger(args, &mut session);
    if args.black_box.is_some() {
        session.stage.keep_black_box();
        if !session.stage.recorder().is_on() {
            let what = "too many bodies for a black box; leave --black-box out";
            return Err(Failure::Usage(format!("{}: {what}", args.scene)));
        }
    } else if goes_back {
        session.stage.keep_timeline();
    }
    simulate(args, &mut session, &mut outputs, ends, ticks, demonstration)?;
    outputs.finish(session, start)
}

/// Simulates frame by frame, to the last tick or the first reason to end before it.
fn simulate(
    args: &RunArgs,
    session: &mut Session,
    outputs: &mut Outputs<'_>,
    mut ends: FrameEnds,
    ticks: Option<u64>,
    mut demonstration: Option<Demonstration>,
) -> Result<(), Failure> {
    outputs.watch.look(&session.stage);
    let progress = progress_bar(ticks);
    if let Some(ticks) = ticks {
        session.stage.playback_mut().limit_ticks(ticks);
    }
    let mut clock = FrameClock::default();
    while ticks.is_none_or(|ticks| session.stage.sim().ticks() < ticks)
        || session.stage.playback().frames() == 0
    {
        if let Some(demonstration) = &mut demonstration {
            demonstration.before_frame(session)?;
        }
        let Some(time) = ends.next(&mut clock, session.stage.playback().frames()) else { break };
        session.advance_watched(&InputFrame::NOTHING, time, &mut |stage: &Stage, simulated| {
            if simulated == Simulated::New {
                outputs.watch.after_tick(stage);
            }
            ControlFlow::Continue(())
        });
        let drawn = outputs.after_frame(session, time.total());
        let orders = session.stage.take_orders();
        let quits = match drawn.and_then(|()| carry_out(orders, session, outputs)) {
            // The device was lost: the outputs so far are still written.
            Err(failure @ Failure::NoAdapter(_)) => {
                outputs.refused = Err(failure);
                break;
            }
            quits => quits?,
        };
        for refusal in session.stage.notices.take_refusals() {
            tell(&format!("{}: {refusal}", session.stage.sim().scene.name));
        }
        let found_fault = args.black_box.is_some() && session.stage.recorder().fault().is_some();
        if quits || found_fault || outputs.watch.error.is_some() || outputs.refused.is_err() {
            break;
        }
        progress.set_position(session.stage.sim().ticks());
        if let FrameEnds::Constant { rate } = ends
            && session.stage.playback().paused()
            && !session.stage.recorder().is_seeking()
        {
            let shows = demonstration.as_ref().is_some_and(|shown| shown.waits(session));
            if session.player().is_none_or(Player::finished) && !shows {
                // No script is left that could continue the run.
                break;
            }
            outputs.refused = refuse_endless_wait(args, session, rate);
            if outputs.refused.is_err() {
                break;
            }
        }
    }
    progress.finish_and_clear();
    if let Some(left) = demonstration.and_then(|demonstration| demonstration.left(session)) {
        tell(&left);
    }
    Ok(())
}

/// Returns an error if the next step of the script of the paused `session` would never come.
fn refuse_endless_wait(args: &RunArgs, session: &Session, rate: f64) -> Result<(), Failure> {
    let now = session.stage.sim().ticks();
    let waits =
        |player: &Player| player.waits_forever(session.stage.playback().frames(), now, rate);
    match session.player().and_then(waits) {
        None => Ok(()),
        Some(when) => Err(Failure::Usage(format!(
            "{}: the run is paused at tick {now}, and the next step of the script waits for {when}; let one before it press P",
            args.scene
        ))),
    }
}

/// Greatest number of lines about what would grow: more of them say the same.
const MOST_WARNINGS: usize = 3;

/// Returns warnings about everything that would grow without bound, or an error if `--refuse-unstable` asks for it.
fn forecast_start(
    args: &RunArgs,
    session: &mut Session,
    frame: f64,
) -> Result<Vec<String>, Failure> {
    let scene = session.stage.sim().scene.name.clone();
    let rows = session.tools.forecast_start(&mut session.stage, frame);
    let line = |row: &ForecastRow| format!("{scene} is {}: {}", row.verdict(), row.line());
    let mut lines: Vec<_> = rows.iter().take(MOST_WARNINGS).map(line).collect();
    // The worst is first: what is wrong without growing comes last.
    if args.refuse_unstable && rows.first().is_some_and(|row| !row.settles_wrongly()) {
        return Err(Failure::Expectation(lines.swap_remove(0)));
    }
    let more = rows.len() - lines.len();
    if more > 0 {
        lines.push(format!(
            "{scene}: {more} more are unstable or wrong; key V in the window lists them"
        ));
    }
    Ok(lines)
}

/// Keeps a ledger if one was asked for, or if a bound of the energy is checked by it.
fn keep_ledger(args: &RunArgs, session: &mut Session) {
    if keeps_ledger(args, &session.stage.sim().scene) {
        session.tools.keep_ledger(&session.stage);
    }
}

fn keeps_ledger(args: &RunArgs, scene: &Scene) -> bool {
    let bounds_energy = scene.expect.is_some_and(|expect| expect.energy_drift_below.is_some());
    args.ledger || args.assert && bounds_energy
}

/// Least estimated time of a run that is announced, s.
const LONG: f64 = 10.0;

/// Announces a long run of bodies that all attract each other.
fn long_ticks(session: &Session, ticks: u64) -> Option<String> {
    let scene = &session.stage.sim().scene;
    let AttractionTick { bodies, seconds } = lab::attraction_tick(scene)?;
    #[expect(clippy::cast_precision_loss, reason = "a count of ticks")]
    let all = seconds * ticks as f64;
    let (name, tick, run) = (&scene.name, long_duration(seconds), long_duration(all));
    (all >= LONG).then(|| {
        format!("{name}: {bodies} bodies attract each other: a tick takes about {tick}, the run about {run}")
    })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
mod tests;
