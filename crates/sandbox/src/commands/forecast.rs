//! `sandbox forecast`: how far a scene is from instability, and how it swings, before its first tick.

use clap::Args;
use history::Overrides;
use motion::margin::{NaturalMode, NaturalModes, natural_modes};
use motion::groups::Groups;
use report::numbers::{NONE, digits, json_number as number};
use scene::StepKind;
use serde_json::{Value, json};

use crate::app::session::{DEFAULT_FPS, Session};
use crate::args::{SceneName, StepArgs, check_time, modes_count, rate};
use crate::commands::list::Format;
use crate::commands::run::refuse_rate_of_frames;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::progress::Waiting;
use crate::output::report::forecast_json;
use crate::output::show;
use crate::stage::Stage;
use crate::stage::options::{Options, check};
use crate::tools::forecast::{ForecastRow, rows_at_start};

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox forecast flag
  sandbox forecast bridge --modes 5";

/// Forecasts a scene.
#[derive(Args, Debug)]
pub(crate) struct ForecastArgs {
    /// A shipped scene or a file
    scene: SceneName,
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
    let options =
        Options { pictures: false, interpolate: false, overrides, threads, ..Options::default() };
    let mut session = Session::new(scene, options);
    let stage = &mut session.stage;
    let rows = rows_at_start(stage, 1.0 / DEFAULT_FPS);
    let found = args.modes.map(|count| modes(&args.scene, stage, count)).transpose()?;
    show(&match args.format {
        Format::Table => table(stage, &rows, found.as_ref()),
        Format::Json => json(stage, &rows, found.as_ref()),
    })
}

/// Estimated time for the natural modes of a group, s per squared number of coordinates and per mode.
const MODE: f64 = 1e-7;

fn modes(name: &str, stage: &mut Stage, count: usize) -> Result<NaturalModes, Failure> {
    let bodies = stage.sim().world.get_resource::<Groups>().map_or(0, Groups::bodies);
    let seconds = MODE * (3.0 * bodies as f64).powi(2) * count as f64;
    check_time(&format!("{name}: natural modes of {bodies} bodies"), seconds)?;
    let _waiting = Waiting::begin("computing natural modes", seconds);
    Ok(natural_modes(&mut stage.sim_mut().world, count))
}

fn table(stage: &Stage, rows: &[ForecastRow], found: Option<&NaturalModes>) -> String {
    let mut text = format!(
        "forecast of `{}`, in ticks at {} Hz\n",
        stage.sim().scene.name,
        digits(tick_rate(stage))
    );
    if rows.is_empty() {
        text += "nothing in this scene limits the step\n";
    } else {
        let heading = ["part", "method", "substeps", "", "value", "limit", "verdict", "cure"];
        let line = |row: &ForecastRow| {
            let limit = row.margin.lasts.unwrap_or(row.margin.limit).min(row.margin.limit);
            vec![
                row.element.clone(),
                row.margin.method.name().to_owned(),
                row.margin.substeps.to_string(),
                row.symbol().to_owned(),
                row.value(),
                if limit.is_infinite() { NONE.to_owned() } else { digits(limit) },
                row.verdict().to_owned(),
                if row.cure.is_empty() { NONE.to_owned() } else { row.cure.clone() },
            ]
        };
        text += &aligned(&heading, rows.iter().map(line));
    }
    let Some(NaturalModes { lowest, highest }) = found else { return text };
    if lowest.is_empty() {
        return text + "\nno natural modes: no springs hold a body that can move\n";
    }
    let heading = ["mode", "frequency Hz", "period s", "damping ratio", "these move most"];
    let line = |kind: &'static str, mode: &NaturalMode| {
        let hz = frequency_hz(mode);
        let bodies = mode.bodies.iter().map(|(body, by)| format!("{} {by:.2}", stage.name(*body)));
        vec![
            kind.to_owned(),
            digits(hz),
            digits(1.0 / hz),
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

fn json(stage: &Stage, rows: &[ForecastRow], found: Option<&NaturalModes>) -> String {
    let mode = |mode: &NaturalMode| {
        let body =
            |(body, by): &(_, f64)| json!({ "body": stage.name(*body), "amplitude": number(*by) });
        json!({
            "frequency_hz": number(frequency_hz(mode)),
            "period_s": number(1.0 / frequency_hz(mode)),
            "damping_ratio": number(mode.damping_ratio),
            "bodies": mode.bodies.iter().map(body).collect::<Vec<_>>(),
        })
    };
    let modes = |of: &[NaturalMode]| of.iter().map(mode).collect::<Vec<_>>();
    let modes = found.map_or(
        Value::Null,
        |found| json!({ "lowest": modes(&found.lowest), "highest": modes(&found.highest) }),
    );
    let report = json!({
        "scene": stage.sim().scene.name,
        "step_hz": number(tick_rate(stage)),
        "forecast": rows.iter().map(forecast_json).collect::<Vec<_>>(),
        "modes": modes,
    });
    format!("{}\n", serde_json::to_string_pretty(&report).expect("strings and numbers are JSON"))
}

/// Ticks per second; frames per second where a tick is a frame.
fn tick_rate(stage: &Stage) -> f64 {
    if stage.sim().scene.step == StepKind::Frame { DEFAULT_FPS } else { stage.playback().step_hz() }
}

fn frequency_hz(mode: &NaturalMode) -> f64 {
    mode.angular_frequency / std::f64::consts::TAU
}
