//! The command line.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory as _, Parser, Subcommand};
use motion::effects::Effect;
use motion::{DampingModel, Method, Substeps};
use scene::{Scene, StepKind};

pub use crate::failure::Failure;
use crate::files::leave_nothing_when_ended;
use crate::instructions::TicksOf;
use crate::list::{Format, Listed, listed};
use crate::recommend::RecommendArgs;
use crate::session::Overrides;
use crate::window;
use crate::{ablate, cost, effects, headless, recommend, replay, stability};

/// A physics sandbox: the scene of the tutorial "Physics - Linear Motion", and what can be built on it.
#[derive(Debug, Parser)]
#[command(name = "sandbox", version, args_conflicts_with_subcommands = true, after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    /// Memory that a scene may take, GiB [default: what is free]
    #[arg(long, global = true, value_name = "GIB", allow_negative_numbers = true, value_parser = positive)]
    memory: Option<f64>,
    #[command(flatten)]
    window: WindowArgs,
}

const EXIT_CODES: &str = "Exit codes: 0 fine, 1 an expectation failed, 2 bad flag, file or scene, 3 a body was \
quarantined, 4 no graphics adapter for pictures, 5 no display for a window";

/// How a tick is taken.
#[derive(Args, Clone, Copy, Debug)]
pub(crate) struct StepArgs {
    /// Method of the scene; bodies with a method of their own keep it
    #[arg(long, value_name = "M", value_parser = method)]
    pub method: Option<Method>,
    /// Parts of a tick, in place of the scene's; bodies with substeps of their own keep them
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = substeps)]
    pub substeps: Option<u32>,
    /// Threads that integrate; states are the same for every number
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<usize>,
}

/// Opens the window.
#[derive(Args, Debug)]
pub(crate) struct WindowArgs {
    /// A shipped scene, a file or a bundle [default: tutorial]
    pub scene: Option<String>,
    /// Start paused
    #[arg(long)]
    pub paused: bool,
    /// Play a script
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Size of the window, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    #[command(flatten)]
    pub step: StepArgs,
    /// Record inputs and frame times, for `run --script`
    #[arg(long, value_name = "FILE", conflicts_with_all = ["script", "paused", "substeps"])]
    pub record: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a scene without a window
    Run(Box<RunArgs>),
    /// List scenes, hard cases, methods, laws or keys
    List {
        /// What to list
        #[arg(value_enum, default_value_t)]
        what: Listed,
        /// As a table or as JSON
        #[arg(long, value_enum, default_value_t)]
        format: Format,
    },
    /// Print the systems of one step, in order, as compiled
    Plan {
        /// A shipped scene or a file
        scene: String,
        /// Method of the scene; bodies with a method of their own keep it
        #[arg(long, value_name = "M", value_parser = method)]
        method: Option<Method>,
    },
    /// Print what each effect of a scene does and costs: the receipt
    Effects {
        /// A shipped scene or a file
        scene: String,
        /// Ticks of the run
        #[arg(long, value_name = "N", default_value_t = effects::DEFAULT_TICKS, allow_negative_numbers = true, value_parser = above_0)]
        ticks: u64,
        /// As a table or as JSON
        #[arg(long, value_enum, default_value_t)]
        format: Format,
    },
    /// Run a scene again without each of its effects and print what that changes
    Ablate(AblateArgs),
    /// Run problems and scenes by every method at every step: what accuracy costs
    Cost(CostArgs),
    /// Measure which method and substeps suit each part of a scene: the cheapest below an error, or the most
    /// accurate within a time
    Recommend(RecommendArgs),
    /// Run every method on every hard case: what survives what
    Stability(StabilityArgs),
    /// Run a bundle again: to the same state and the same fault, or not
    Replay {
        /// What `run --black-box` or Ctrl+S has written
        bundle: PathBuf,
        /// Write scene.ron, state.csv of the end, the picture and summary.json into this folder
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// Runs the survival matrix.
#[derive(Args, Debug)]
pub(crate) struct StabilityArgs {
    /// Hard cases, or scene files that say what survival is [default: all of `sandbox list cases`]
    #[arg(value_name = "CASE")]
    pub cases: Vec<String>,
    /// This method alone; may be given several times
    #[arg(long = "method", value_name = "M", value_parser = method)]
    pub methods: Vec<Method>,
    /// Ticks of a run at most
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = above_0)]
    pub ticks: Option<u64>,
    /// Write stability.html, matrix.svg, matrix.csv, matrix.md and matrix.json into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Measures accuracy against cost.
#[derive(Args, Debug)]
pub(crate) struct CostArgs {
    /// Problems, shipped scenes or files [default: harmonic_oscillator kepler tetrahedron flag tutorial]
    #[arg(value_name = "PROBLEM|SCENE")]
    pub subjects: Vec<String>,
    /// Simulated seconds of a scene [default: 10]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
    pub seconds: Option<f64>,
    /// Bodies that methods are ranked by time at, as copies of a problem; a scene is timed as it is [default: 1000]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = bodies)]
    pub bodies: Option<u32>,
    /// Fewer rungs and curves: an answer within a minute
    #[arg(long)]
    pub quick: bool,
    /// Write report.html, figures and tables into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on with the report that was interrupted in that folder
    #[arg(long, requires = "out")]
    pub resume: bool,
    /// Count instructions as well, with callgrind; needs valgrind
    #[arg(long)]
    pub instructions: bool,
    /// Run nothing but so many ticks of a setting: what is counted
    #[arg(long, hide = true, value_name = "METHOD:SUBSTEPS:TICKS", value_parser = TicksOf::parse)]
    pub ticks_of: Option<TicksOf>,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Runs a scene again without each of its effects.
#[derive(Args, Debug)]
pub(crate) struct AblateArgs {
    /// A shipped scene or a file
    pub scene: String,
    /// Simulated seconds, in place of --ticks
    #[arg(long, value_name = "S", conflicts_with = "ticks", allow_negative_numbers = true, value_parser = positive)]
    pub seconds: Option<f64>,
    /// Ticks of each run
    #[arg(long, value_name = "N", default_value_t = effects::DEFAULT_TICKS, allow_negative_numbers = true, value_parser = above_0)]
    pub ticks: u64,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Do not compare the pictures at the end
    #[arg(long)]
    pub no_pictures: bool,
}

/// Runs a scene without a window.
#[derive(Args, Debug)]
pub(crate) struct RunArgs {
    /// A shipped scene or a file
    pub scene: String,
    /// Simulated seconds [default: 10, or to the end of the frame times]
    #[arg(long, value_name = "S", conflicts_with = "ticks", allow_negative_numbers = true, value_parser = positive)]
    pub seconds: Option<f64>,
    /// Ticks
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole)]
    pub ticks: Option<u64>,
    /// Ticks a second, in place of the scene's
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = rate)]
    pub hz: Option<f64>,
    #[command(flatten)]
    pub step: StepArgs,
    /// Damping model, in place of the scene's: tutorial, clamped or exact
    #[arg(long, value_name = "MODEL", value_parser = damping)]
    pub damping: Option<DampingModel>,
    /// Start with this effect switched off; may be given several times
    #[arg(long, value_name = "EFFECT", value_parser = effect)]
    pub without: Vec<Effect>,
    /// Frames a second for scripts and pictures [default: 60]
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = rate)]
    pub fps: Option<f64>,
    /// A file with one frame time in seconds a line, instead of --fps
    #[arg(long, value_name = "FILE", conflicts_with = "fps")]
    pub frame_times: Option<PathBuf>,
    /// Play a script or a recording
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Check what the scene expects
    #[arg(long)]
    pub assert: bool,
    /// Keep books of energy and momentum, for the summary
    #[arg(long)]
    pub ledger: bool,
    /// Exit with code 1 before the first tick if something would grow without bound
    #[arg(long)]
    pub refuse_unstable: bool,
    /// Write the state of every body as CSV
    #[arg(long, value_name = "FILE.csv")]
    pub state: Option<PathBuf>,
    /// Ticks between two states
    #[arg(long, value_name = "K", default_value_t = 1, requires = "state", allow_negative_numbers = true, value_parser = above_0)]
    pub every: u64,
    /// Stop at the first fault, a quarantined body or a jump of energy, and write a bundle for `sandbox replay`
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
    /// Write all frames as one animated PNG; --fps says how many per second
    #[arg(long, value_name = "FILE.png")]
    pub film: Option<PathBuf>,
    /// Size of the pictures, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
}

/// Parses the command line and does what it says.
///
/// # Errors
/// Whatever keeps the program from ending with exit code 0; bad flags end the process in clap.
pub fn run() -> Result<(), Failure> {
    leave_nothing_when_ended();
    let Cli { command, memory, window } = Cli::try_parse().unwrap_or_else(|error| worded(error).exit());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a positive number of bytes")]
    if let Some(gib) = memory {
        scene::allow_memory((gib * (1_u64 << 30) as f64) as u64);
    }
    match command {
        None => window::open(&window),
        Some(Command::Run(args)) => headless::run(&args),
        Some(Command::List { what, format }) => show(&listed(what, format)),
        Some(Command::Plan { scene, method }) => {
            let overrides = Overrides { method, ..Overrides::default() };
            let scene = scene::load(&scene)?;
            overrides.check(&scene)?;
            show(&crate::plan::text(scene, overrides))
        }
        Some(Command::Effects { scene, ticks, format }) => {
            show(&effects::receipt(scene::load(&scene)?, ticks, format))
        }
        Some(Command::Ablate(args)) => ablate::ablate(&args),
        Some(Command::Cost(args)) => cost::cost(&args),
        Some(Command::Recommend(args)) => recommend::run(&args),
        Some(Command::Stability(args)) => stability::run(&args),
        Some(Command::Replay { bundle, out }) => replay::replay(&bundle, out.as_deref()),
    }
}

/// clap takes the second of two scenes for a subcommand, and says so.
fn worded(error: clap::Error) -> clap::Error {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else { return error };
    let mut program = Cli::command();
    if error.kind() != ErrorKind::ArgumentConflict || program.find_subcommand(word).is_some() {
        return error;
    }
    let commands: Vec<_> = program.get_subcommands().map(clap::Command::get_name).collect();
    let what = format!("'{word}' is one argument too many; the commands are {}", commands.join(", "));
    program.error(ErrorKind::UnknownArgument, what)
}

/// Prints results; a reader who has seen enough (`| head`) is no failure.
pub(crate) fn show(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::file("write", Path::new("standard output"), &error))
        }
        _ => Ok(()),
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parse = |text: &str| text.parse().ok().filter(|side| (1..=16_384).contains(side));
    match text.split_once('x').map(|(width, height)| (parse(width), parse(height))) {
        Some((Some(width), Some(height))) => Ok([width, height]),
        _ => Err("give width and height from 1 to 16384 pixels, as in 1280x720".to_owned()),
    }
}

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a finite number above 0".to_owned()),
    }
}

fn rate(text: &str) -> Result<f64, String> {
    // The step is the reciprocal.
    match positive(text) {
        Ok(value) if (1.0 / value).is_infinite() => Err("give a number farther above 0".to_owned()),
        other => other,
    }
}

fn whole(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| "give a whole number from 0 up".to_owned())
}

fn above_0(text: &str) -> Result<u64, String> {
    match whole(text) {
        Ok(value) if value > 0 => Ok(value),
        _ => Err("give a whole number from 1 up".to_owned()),
    }
}

fn substeps(text: &str) -> Result<u32, String> {
    let found = text.parse().ok().filter(|parts| (1..=Substeps::MOST).contains(parts));
    found.ok_or_else(|| format!("give a whole number from 1 to {}", Substeps::MOST))
}

/// More copies of a problem than this are not timed.
const MOST_BODIES: u32 = 100_000;

fn bodies(text: &str) -> Result<u32, String> {
    let found = text.parse().ok().filter(|bodies| (1..=MOST_BODIES).contains(bodies));
    found.ok_or_else(|| format!("give a whole number from 1 to {MOST_BODIES}"))
}

/// More threads than this only wait for each other.
const MOST_THREADS: usize = 256;

fn threads(text: &str) -> Result<usize, String> {
    let found = text.parse().ok().filter(|threads| (1..=MOST_THREADS).contains(threads));
    found.ok_or_else(|| format!("give a whole number from 1 to {MOST_THREADS}"))
}

fn method(text: &str) -> Result<Method, String> {
    Method::from_name(text).ok_or_else(|| format!("the methods are {}", names(Method::ALL.map(Method::name))))
}

fn effect(text: &str) -> Result<Effect, String> {
    Effect::from_name(text).ok_or_else(|| format!("the effects are {}", names(Effect::ALL.map(Effect::name))))
}

fn damping(text: &str) -> Result<DampingModel, String> {
    let found = DampingModel::ALL.into_iter().find(|model| model.name() == text);
    found.ok_or_else(|| format!("the models are {}", names(DampingModel::ALL.map(DampingModel::name))))
}

fn names<const N: usize>(names: [&str; N]) -> String {
    names.join(", ")
}

/// Whether ticks follow the frames.
pub(crate) const fn follows_frames(scene: &Scene) -> bool {
    matches!(scene.step, StepKind::Frame)
}
