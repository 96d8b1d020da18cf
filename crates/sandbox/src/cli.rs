//! The command line.

use std::io::Write as _;
use std::path::PathBuf;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory as _, Parser, Subcommand, ValueEnum};
use motion::{DampingModel, Method};
use scene::{Scene, StepKind};
use serde_json::json;

use crate::actions::{BINDINGS, MOUSE};
pub use crate::failure::Failure;
use crate::headless;
use crate::session::Overrides;
use crate::window;

/// A physics sandbox: the scene of the tutorial "Physics - Linear Motion", and what can be built on it.
#[derive(Debug, Parser)]
#[command(name = "sandbox", version, args_conflicts_with_subcommands = true, after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    window: WindowArgs,
}

const EXIT_CODES: &str = "Exit codes: 0 fine, 1 an expectation failed, 2 bad flag, file or scene, 3 a body was \
quarantined, 4 no graphics adapter for pictures, 5 no display for a window";

/// Opens the window.
#[derive(Args, Debug)]
pub(crate) struct WindowArgs {
    /// A shipped scene or a file [default: tutorial]
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
    /// Integration method
    #[arg(long, value_name = "M", value_parser = method)]
    pub method: Option<Method>,
    /// Record inputs and frame times, for `run --script`
    #[arg(long, value_name = "FILE", conflicts_with_all = ["script", "paused"])]
    pub record: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a scene without a window
    Run(Box<RunArgs>),
    /// List scenes, methods or keys
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
        /// Integration method
        #[arg(long, value_name = "M", value_parser = method)]
        method: Option<Method>,
    },
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Listed {
    #[default]
    Scenes,
    Methods,
    Keys,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Format {
    #[default]
    Table,
    Json,
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
    /// Integration method
    #[arg(long, value_name = "M", value_parser = method)]
    pub method: Option<Method>,
    /// Damping model, in place of the scene's: tutorial, clamped or exact
    #[arg(long, value_name = "MODEL", value_parser = damping)]
    pub damping: Option<DampingModel>,
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
    /// Write the state of every body as CSV
    #[arg(long, value_name = "FILE.csv")]
    pub state: Option<PathBuf>,
    /// Ticks between two states
    #[arg(long, value_name = "K", default_value_t = 1, requires = "state", allow_negative_numbers = true, value_parser = above_0)]
    pub every: u64,
    /// Write the summary as JSON
    #[arg(long, value_name = "FILE.json")]
    pub summary: Option<PathBuf>,
    /// Write pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub frames: Option<PathBuf>,
    /// Frames between two pictures
    #[arg(long, value_name = "K", default_value_t = 1, requires = "frames", allow_negative_numbers = true, value_parser = above_0)]
    pub frame_every: u64,
    /// Size of the pictures, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
}

/// Parses the command line and does what it says.
///
/// # Errors
/// Whatever keeps the program from ending with exit code 0; bad flags end the process in clap.
pub fn run() -> Result<(), Failure> {
    let Cli { command, window } = Cli::try_parse().unwrap_or_else(|error| worded(error).exit());
    match command {
        None => window::open(&window),
        Some(Command::Run(args)) => headless::run(&args),
        Some(Command::List { what, format }) => {
            list(what, format);
            Ok(())
        }
        Some(Command::Plan { scene, method }) => {
            let overrides = Overrides { method, ..Overrides::default() };
            show(&crate::plan::text(scene::load(&scene)?, overrides));
            Ok(())
        }
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

fn list(what: Listed, format: Format) {
    let rows: Vec<Vec<(&str, String)>> = match what {
        Listed::Scenes => scene::shipped()
            .iter()
            .map(|shipped| {
                let description =
                    shipped.load().map_or_else(|error| error.to_string(), |scene| scene.description);
                vec![("scene", shipped.name.to_owned()), ("description", description)]
            })
            .collect(),
        Listed::Methods => {
            Method::ALL.iter().map(|method| vec![("method", method.name().to_owned())]).collect()
        }
        Listed::Keys => {
            let keys = BINDINGS.iter().map(|row| (row.keys.join(" "), row.when, row.what, row.name));
            let mouse = MOUSE.iter().map(|(input, when, what)| ((*input).to_owned(), *when, *what, ""));
            keys.chain(mouse)
                .map(|(input, when, what, name)| {
                    let when = when.words().to_owned();
                    vec![
                        ("input", input),
                        ("when", when),
                        ("name", name.to_owned()),
                        ("what", what.to_owned()),
                    ]
                })
                .collect()
        }
    };
    match format {
        Format::Json => {
            let objects: Vec<_> = rows
                .into_iter()
                .map(|row| row.into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect())
                .map(serde_json::Value::Object)
                .collect();
            show(&format!("{}\n", serde_json::to_string_pretty(&objects).expect("strings are JSON")));
        }
        Format::Table => {
            let width =
                |column: usize| rows.iter().map(|row| row[column].1.chars().count()).max().unwrap_or(0);
            for row in &rows {
                let cells = row.iter().enumerate().map(|(i, (_, value))| format!("{value:<0$}", width(i)));
                show(&format!("{}\n", cells.collect::<Vec<_>>().join("  ").trim_end()));
            }
        }
    }
}

/// Prints results; a reader who has seen enough (`| head`) is no failure.
pub(crate) fn show(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parse = |text: &str| text.parse().ok().filter(|side| (1..=16_384).contains(side));
    match text.split_once('x').map(|(width, height)| (parse(width), parse(height))) {
        Some((Some(width), Some(height))) => Ok([width, height]),
        _ => Err("give width and height from 1 to 16384 pixels, as in 1280x720".to_owned()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
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

fn method(text: &str) -> Result<Method, String> {
    Method::from_name(text).ok_or_else(|| format!("the methods are {}", names(Method::ALL.map(Method::name))))
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
