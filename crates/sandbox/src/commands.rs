//! The command line.

mod ablate;
pub(crate) mod cost;
pub(crate) mod effects;
mod forecast;
mod lessons;
pub(crate) mod list;
mod merge;
pub mod plan;
mod recommend;
mod replay;
pub(crate) mod run;
mod stability;
mod sweep;

use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory as _, Parser, Subcommand};

use self::ablate::AblateArgs;
use self::cost::CostArgs;
use self::effects::EffectsArgs;
use self::forecast::ForecastArgs;
use self::lessons::LessonsArgs;
use self::list::ListArgs;
use self::merge::MergeArgs;
use self::plan::PlanArgs;
use self::recommend::RecommendArgs;
use self::replay::ReplayArgs;
use self::run::RunArgs;
use self::stability::StabilityArgs;
use self::sweep::SweepArgs;
use crate::args::positive;
pub use crate::failure::Failure;
use crate::output::files::remove_unfinished_files_on_signals;
use crate::window::{self, WindowArgs};

/// A physics sandbox: the scene of the tutorial "Physics - Linear Motion", and what can be built on it.
#[derive(Debug, Parser)]
#[command(name = "sandbox", version = VERSION, args_conflicts_with_subcommands = true, after_help = AFTER_HELP)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    /// Memory that a scene may take, GiB [default: what is free]
    #[arg(long, global = true, value_name = "GIB", allow_negative_numbers = true, value_parser = positive)]
    memory: Option<f64>,
    #[command(flatten)]
    window: WindowArgs,
}

/// The version; `scripts/package` gives one with the commit.
const VERSION: &str = match option_env!("INERTIA_VERSION") {
    Some(version) => version,
    None => env!("CARGO_PKG_VERSION"),
};

const AFTER_HELP: &str = "\
Examples:
  sandbox                             the tutorial in a window
  sandbox orbit --method yoshida_4    another scene by another method
  sandbox run tutorial --seconds 5    without a window

Exit codes: 0 fine, 1 an expectation failed, 2 bad flag, file or scene, 3 a body was quarantined, 4 no graphics \
adapter for pictures, 5 no display for a window";

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a scene without a window
    #[command(after_help = run::EXAMPLES)]
    Run(Box<RunArgs>),
    /// List scenes, hard cases, methods, laws or keys
    #[command(after_help = list::EXAMPLES)]
    List(ListArgs),
    /// List lessons, check one, or print all
    #[command(after_help = lessons::EXAMPLES)]
    Lessons(LessonsArgs),
    /// Print the systems of one tick, in order, as compiled
    #[command(after_help = plan::EXAMPLES)]
    Plan(PlanArgs),
    /// Print how far a scene is from instability before its first tick, and the natural modes of bodies joined by springs
    #[command(after_help = forecast::EXAMPLES)]
    Forecast(ForecastArgs),
    /// Print what each effect of a scene does and costs: the receipt
    #[command(after_help = effects::EXAMPLES)]
    Effects(EffectsArgs),
    /// Run a scene again without each of its effects and print what that changes
    #[command(after_help = ablate::EXAMPLES)]
    Ablate(AblateArgs),
    /// Run problems and scenes by every method at every step: what accuracy costs
    #[command(after_help = cost::EXAMPLES)]
    Cost(CostArgs),
    /// Measure which method and substeps suit each part of a scene: the cheapest below an error, or the most
    /// accurate within a time
    #[command(after_help = recommend::EXAMPLES)]
    Recommend(RecommendArgs),
    /// Run every method on every hard case: which survive
    #[command(after_help = stability::EXAMPLES)]
    Stability(StabilityArgs),
    /// Run a scene once for every combination of the given values: one table and one figure
    #[command(after_help = sweep::EXAMPLES)]
    Sweep(Box<SweepArgs>),
    /// Join the shards of a sweep to what one run would have made
    #[command(after_help = merge::EXAMPLES)]
    Merge(MergeArgs),
    /// Run a bundle again, and compare the state and the fault
    #[command(after_help = replay::EXAMPLES)]
    Replay(ReplayArgs),
}

/// Parses the command line and does what it says.
///
/// # Errors
/// Whatever keeps the program from ending with exit code 0; bad flags end the process in clap.
pub fn run() -> Result<(), Failure> {
    remove_unfinished_files_on_signals();
    let Cli { command, memory, window } =
        Cli::try_parse().unwrap_or_else(|error| worded(error).exit());
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a positive number of bytes"
    )]
    if let Some(gib) = memory {
        scene::allow_memory((gib * (1_u64 << 30) as f64) as u64);
    }
    match command {
        None => {
            check_word(
                window.scene.as_ref().filter(|scene| scene.path().is_none()).map(|scene| &**scene),
            )?;
            window::open(&window)
        }
        Some(Command::Run(args)) => run::run(&args),
        Some(Command::Lessons(args)) => lessons::run(&args),
        Some(Command::List(args)) => list::run(args),
        Some(Command::Plan(args)) => plan::run(&args),
        Some(Command::Forecast(args)) => forecast::run(&args),
        Some(Command::Effects(args)) => effects::run(&args),
        Some(Command::Ablate(args)) => ablate::run(&args),
        Some(Command::Cost(args)) => cost::run(&args),
        Some(Command::Recommend(args)) => recommend::run(&args),
        Some(Command::Stability(args)) => stability::run(&args),
        Some(Command::Sweep(args)) => sweep::run(&args),
        Some(Command::Merge(args)) => merge::run(&args),
        Some(Command::Replay(args)) => replay::run(&args),
    }
}

/// Refuses a word that names no scene and looks like a misspelled command.
fn check_word(scene: Option<&str>) -> Result<(), Failure> {
    let Some(word) =
        scene.filter(|word| scene::embedded(word).is_none() && !Path::new(word).exists())
    else {
        return Ok(());
    };
    let program = Cli::command();
    let commands: Vec<_> = program.get_subcommands().map(clap::Command::get_name).collect();
    let scenes = scene::shipped().iter().map(|scene| scene.name);
    match scene::nearest(word, commands.iter().copied().chain(scenes)) {
        Some(near) if commands.contains(&near) => Err(Failure::Usage(format!(
            "{word}: no such scene or command; did you mean `sandbox {near}`?"
        ))),
        _ => Ok(()),
    }
}

/// Rewords clap's error for a command line with two scenes, the second of which clap takes for a subcommand.
fn worded(error: clap::Error) -> clap::Error {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else {
        return error;
    };
    let mut program = Cli::command();
    if error.kind() != ErrorKind::ArgumentConflict || program.find_subcommand(word).is_some() {
        return error;
    }
    let commands: Vec<_> = program.get_subcommands().map(clap::Command::get_name).collect();
    // After a flag of the window, clap takes a command for a scene.
    let mut words = std::env::args_os().skip(1).filter_map(|word| word.into_string().ok());
    let command = words.find(|word| commands.contains(&word.as_str()));
    if let Some(command) = command {
        let what = format!(
            "'{command}' is a command: flags before a command belong to the window; put the flags of the command after it"
        );
        return program.error(ErrorKind::ArgumentConflict, what);
    }
    let what =
        format!("'{word}' is one argument too many; the commands are {}", commands.join(", "));
    program.error(ErrorKind::UnknownArgument, what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_examples_that_are_right() {
        let program = Cli::command();
        for command in program.get_subcommands().chain([&program]) {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let examples: Vec<_> =
                help.lines().filter(|line| line.starts_with("  sandbox")).collect();
            assert!(!examples.is_empty(), "{} has no example", command.get_name());
            for example in examples {
                let line = example.trim().split("   ").next().unwrap_or_default();
                let parsed = Cli::try_parse_from(line.split_whitespace());
                assert!(parsed.is_ok(), "{example}: {parsed:?}");
            }
        }
    }
}
