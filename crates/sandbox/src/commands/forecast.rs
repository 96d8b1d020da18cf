//! `sandbox forecast`: how far a scene is from instability, how it goes on, and how it swings, before its first tick.

use clap::Args;
use history::{Overrides, Simulation};
use lab::trial::{Ahead, Trial};
use motion::TimeStep;
use motion::margin::{Margins, NaturalMode, NaturalModes, natural_modes};
use report::numbers::{NONE, digits, json_number as number, tick_rate};
use report::{ForecastRow, tried_in_words};
use scene::StepKind;
use serde_json::{Value, json};

use crate::args::{SceneName, StepArgs, cores, modes_count, positive, rate, refuse_rate_of_frames};
use crate::commands::list::Format;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::progress::{Progress, Waiting};
use crate::output::show;
use cockpit::app::session::DEFAULT_FPS;
use cockpit::stage::options::{Options, check};
use cockpit::stage::start;
use cockpit::stage::things::name;

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox forecast flag
  sandbox forecast solar --ahead 3e9
  sandbox forecast bridge --modes 5";

/// Forecasts a scene.
#[derive(Args, Debug)]
pub(crate) struct ForecastArgs {
    /// A shipped scene or a file
    scene: SceneName,
    /// Try S seconds ahead, however long that takes; without it a hundred turns of the slowest orbit or spring, as far as some
    /// tenths of a second allow
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
    ahead: Option<f64>,
    /// Also the N slowest and the N fastest natural modes of what springs join, 1 to 20
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = modes_count)]
    modes: Option<usize>,
    /// Ticks per second; overrides the scene
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = rate)]
    hz: Option<f64>,
    #[command(flatten)]
    step: StepArgs,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Does what `sandbox forecast` says.
pub(crate) fn run(args: &ForecastArgs) -> Result<(), Failure> {
    let mut scene = CommandFiles::default().named_scene(&args.scene)?;
    refuse_rate_of_frames(&args.scene, &scene, args.hz, "leave --hz out")?;
    let StepArgs { method, substeps, threads } = args.step;
    let overrides = Overrides { method, step_hz: args.hz, substeps, damping: None };
    check(overrides, &scene)?;
    overrides.apply(&mut scene);
    let threads = threads.unwrap_or_else(cores);
    let options =
        Options { pictures: false, interpolate: false, overrides, threads, ..Options::default() };
    let mut simulation = start(scene, options);
    if simulation.scene.step == StepKind::Frame {
        simulation.world.insert_resource(TimeStep(1.0 / DEFAULT_FPS));
    }
    let rows = rows(&simulation, args.ahead);
    let found = args.modes.map(|count| {
        let _waiting = Waiting::begin("computing natural modes");
        natural_modes(&simulation.world, count)
    });
    show(&match args.format {
        Format::Table => table(&simulation, &rows, found.as_ref()),
        Format::Json => json(&simulation, &rows, found.as_ref()),
    })
}

/// Work of the trial between two steps of the bar.
const WORK_OF_BAR: f64 = 1e6;

/// The rows of the forecast, faults first.
fn rows(simulation: &Simulation, ahead: Option<f64>) -> Vec<ForecastRow> {
    let method = simulation.method();
    let margins = Margins::of(&simulation.world, method);
    let mut trial = Trial::new(simulation, Ahead { seconds: ahead, ..Ahead::DEFAULT });
    let progress = Progress::new(1);
    progress.say("trying how the scene goes on");
    while !trial.advance(WORK_OF_BAR) {
        progress.show(trial.progress());
    }
    drop(progress);
    ForecastRow::of(simulation, &margins, &trial)
}

fn table(simulation: &Simulation, rows: &[ForecastRow], found: Option<&NaturalModes>) -> String {
    let TimeStep(tick) = *simulation.world.resource();
    let mut text =
        format!("forecast of `{}`, in ticks at {}\n", simulation.scene.name, tick_rate(tick));
    if rows.is_empty() {
        text += "nothing in this scene limits the step\n";
    }
    let line = |row: &ForecastRow| {
        let (method, substeps) = row.setting();
        let finding = match row.tried() {
            Some(tried) if !row.is_fault() => tried_in_words(tried),
            Some(_) => row.finding(),
            None => format!("{}, {}", row.value(), row.finding()),
        };
        vec![
            row.element.clone(),
            method.name().to_owned(),
            substeps.to_string(),
            row.instrument().to_owned(),
            row.verdict().to_owned(),
            finding,
            if row.cure_words.is_empty() { NONE.to_owned() } else { row.cure_words.clone() },
        ]
    };
    if !rows.is_empty() {
        let heading = ["part", "method", "substeps", "by", "verdict", "finding", "cure"];
        text += &aligned(&heading, rows.iter().map(line));
    }
    let Some(NaturalModes { lowest, highest }) = found else { return text };
    if lowest.is_empty() {
        return text + "\nno natural modes: no springs hold a body that can move\n";
    }
    let heading = ["mode", "frequency Hz", "period s", "damping ratio", "these move most"];
    let line = |kind: &'static str, mode: &NaturalMode| {
        let hz = frequency_hz(mode);
        let bodies =
            mode.bodies.iter().map(|(body, by)| format!("{} {by:.2}", name(simulation, *body)));
        let [below, above] = if mode.is_upper_bound { ["at most ", "at least "] } else { [""; 2] };
        vec![
            kind.to_owned(),
            format!("{below}{}", digits(hz)),
            format!("{above}{}", digits(1.0 / hz)),
            digits(mode.damping_ratio),
            bodies.collect::<Vec<_>>().join(", "),
        ]
    };
    let slow = lowest.iter().map(|mode| line("slow", mode));
    let fast = highest.iter().map(|mode| line("fast", mode));
    text + "\nnatural modes at the start\n" + &aligned(&heading, slow.chain(fast))
}

fn aligned(heading: &[&str], lines: impl Iterator<Item = Vec<String>>) -> String {
    let heading = heading.iter().map(|word| (*word).to_owned()).collect();
    report::aligned(&std::iter::once(heading).chain(lines).collect::<Vec<_>>(), false)
}

fn json(simulation: &Simulation, rows: &[ForecastRow], found: Option<&NaturalModes>) -> String {
    let mode = |mode: &NaturalMode| {
        let body = |(body, by): &(_, f64)| json!({ "body": name(simulation, *body), "amplitude": number(*by) });
        json!({
            "frequency_hz": number(frequency_hz(mode)),
            "period_s": number(1.0 / frequency_hz(mode)),
            "damping_ratio": number(mode.damping_ratio),
            "is_upper_bound": mode.is_upper_bound,
            "bodies": mode.bodies.iter().map(body).collect::<Vec<_>>(),
        })
    };
    let modes = |of: &[NaturalMode]| of.iter().map(mode).collect::<Vec<_>>();
    let modes = found.map_or(
        Value::Null,
        |found| json!({ "lowest": modes(&found.lowest), "highest": modes(&found.highest) }),
    );
    let TimeStep(tick) = *simulation.world.resource();
    let report = json!({
        "scene": simulation.scene.name,
        "step_hz": number(history::rate_of(tick)),
        "forecast": rows.iter().map(ForecastRow::json).collect::<Vec<_>>(),
        "modes": modes,
    });
    format!("{}\n", serde_json::to_string_pretty(&report).expect("strings and numbers are JSON"))
}

fn frequency_hz(mode: &NaturalMode) -> f64 {
    mode.angular_frequency / std::f64::consts::TAU
}
