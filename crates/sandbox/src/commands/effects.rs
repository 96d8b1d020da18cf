//! The output of `sandbox effects` and `sandbox ablate`.

use clap::Args;
use lab::{Absence, ByEffect, ReceiptLine};
use motion::effects::{Effect, EffectState};
use report::numbers::{count, json_number as number, length};
use scene::{Keeps, Scene};
use serde_json::{Value, json};

use crate::args::{SceneName, above_0, check_memory};
use crate::commands::list::Format;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::progress::Waiting;
use crate::output::show;
use cockpit::app::session::Session;
use cockpit::stage::options::Options;
use cockpit::tools::effects::{ENERGY_WATCH, picture_rows};

/// Default number of ticks of a report.
pub(crate) const DEFAULT_TICKS: u64 = 600;

pub(super) const EXAMPLES: &str = "\
Example:
  sandbox effects everything --ticks 1200";

/// Prints what effects do and cost.
#[derive(Args, Debug)]
pub(crate) struct EffectsArgs {
    /// A shipped scene or a file
    scene: SceneName,
    /// Ticks of the run
    #[arg(long, value_name = "N", default_value_t = DEFAULT_TICKS, allow_negative_numbers = true, value_parser = above_0)]
    ticks: u64,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Does what `sandbox effects` says.
pub(crate) fn run(args: &EffectsArgs) -> Result<(), Failure> {
    let scene = CommandFiles::default().named_scene(&args.scene)?;
    check_memory(&scene, Keeps { compared: Some(1), ..Keeps::default() })?;
    let _waiting = Waiting::begin("running the scene");
    show(&receipt(scene, args.ticks, args.format))
}

/// The receipt of `ticks` ticks of `scene`.
fn receipt(scene: Scene, ticks: u64, format: Format) -> String {
    let mut receipt = lab::receipt(&scene, ticks, &[]);
    let watch = lab::watch_time(&scene);
    let mut session = Session::new(scene, Options::default());
    session.view.see(&session.stage);
    // The window keeps a timeline, too.
    session.stage.keep_timeline();
    receipt.rows.extend(picture_rows(&session.stage, &session.view));
    if let Some(row) = receipt.rows.iter_mut().find(|row| row.name == ENERGY_WATCH) {
        (row.ns, row.share) = (Some(watch), Some(watch / receipt.ns));
    }
    let heading =
        ["effect", "state", "bodies", "evaluations", "ns per step", "share", "bytes", "because"];
    let line = |row: &ReceiptLine| {
        let part = |text: String| if row.state == EffectState::On { text } else { "-".to_owned() };
        let measured =
            |value: Option<f64>, text: fn(f64) -> String| part(value.map_or("-".to_owned(), text));
        vec![
            row.name.to_owned(),
            row.state.words().to_owned(),
            part(row.bodies.to_string()),
            part(count(row.evaluations)),
            measured(row.ns, |ns| format!("{ns:.0}")),
            measured(row.share, |share| format!("{:.0} %", share * 100.0)),
            row.bytes.to_string(),
            row.because.clone().unwrap_or_default(),
        ]
    };
    text(&receipt, format, &heading, row_json, line)
}

/// The output of both commands.
fn text<R>(
    found: &ByEffect<R>,
    format: Format,
    heading: &[&str],
    json: fn(&R) -> Value,
    line: impl Fn(&R) -> Vec<String>,
) -> String {
    let ByEffect { scene, method, ticks, ns, rows } = found;
    match format {
        Format::Json => {
            let report = json!({
                "scene": scene,
                "method": method.name(),
                "ticks": ticks,
                "ns_per_step": number(*ns),
                "effects": rows.iter().map(json).collect::<Vec<_>>(),
            });
            format!(
                "{}\n",
                serde_json::to_string_pretty(&report).expect("strings and numbers are JSON")
            )
        }
        Format::Table => {
            let head = heading.iter().map(|word| (*word).to_owned()).collect();
            let lines: Vec<_> = std::iter::once(head).chain(rows.iter().map(line)).collect();
            let title =
                format!("`{scene}`: {}, {ticks} ticks, {ns:.0} ns per step\n", method.name());
            title + &report::aligned(&lines, false)
        }
    }
}

fn row_json(row: &ReceiptLine) -> Value {
    json!({
        "effect": row.name,
        "state": row.state.words(),
        "because": row.because,
        "bodies": row.bodies,
        "evaluations_per_step": number(row.evaluations),
        "ns_per_step": row.ns.map(number),
        "share": row.share.map(number),
        "bytes": row.bytes,
    })
}

/// The report on the scene without each of its effects. `differs` says whether the picture without an effect differs; `None`
/// without pictures.
pub(crate) fn ablation(
    scene: &Scene,
    ticks: u64,
    format: Format,
    mut differs: impl FnMut(Effect) -> Option<bool>,
) -> String {
    let mut ablation = lab::ablate(scene, ticks);
    ablation.rows.iter_mut().for_each(|row| row.picture_differs = differs(row.effect));
    let heading =
        ["without", "farthest", "rms", "same bits", "saves ns", "saves evaluations", "picture", ""];
    let line = |row: &Absence| {
        let picture =
            row.picture_differs.map_or("-", |differs| if differs { "differs" } else { "same" });
        vec![
            row.effect.name().to_owned(),
            length(row.max_distance, 4),
            length(row.rms_distance, 4),
            if row.identical { "yes" } else { "no" }.to_owned(),
            format!("{:.0}", row.ns_saved),
            count(row.evaluations_saved),
            picture.to_owned(),
            if row.needed() { "" } else { "not needed" }.to_owned(),
        ]
    };
    text(&ablation, format, &heading, absence_json, line)
}

fn absence_json(row: &Absence) -> Value {
    json!({
        "effect": row.effect.name(),
        "max_distance_m": number(row.max_distance),
        "rms_distance_m": number(row.rms_distance),
        "identical": row.identical,
        "ns_saved_per_step": number(row.ns_saved),
        "evaluations_saved_per_step": number(row.evaluations_saved),
        "picture_differs": row.picture_differs,
        "needed": row.needed(),
    })
}
