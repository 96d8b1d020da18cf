//! `sandbox recommend`: a method and substeps for each part of a scene, from measurements on this machine.

use std::path::{Path, PathBuf};

use clap::Args;
use lab::cost::{Bench, Plan, Study, Subject};
use lab::recommend::{Goal, NextChoice, PartChoice, Point, Recommendation, Unit, recommend};
use motion::Method;
use report::numbers::{digits, duration, json_number as number, length, three_digits};
use scene::{Part, Scene, Source, StepKind};
use serde_json::{Value, json};

use crate::args::{SceneName, check_study, positive};
use crate::commands::list::Format;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{Output, OutputPath, output_file};
use crate::output::progress::Progress;
use crate::output::show;

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox recommend orbit --error 0.001
  sandbox recommend flag --budget-ms 1 --apply faster.ron";

/// Measures which method and substeps suit each part of a scene.
#[derive(Args, Debug)]
pub(crate) struct RecommendArgs {
    /// A shipped scene or a file
    pub scene: SceneName,
    #[command(flatten)]
    pub goal: GoalArgs,
    /// Simulated seconds over which errors are measured
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
    pub seconds: Option<f64>,
    /// Write the scene with the chosen settings into a new file, or into its own
    #[arg(long, value_name = "FILE")]
    pub apply: Option<PathBuf>,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Measure fewer and shorter runs
    #[arg(long)]
    pub quick: bool,
}

/// The goal: exactly one of the two.
#[derive(Args, Clone, Copy, Debug)]
#[group(required = true, multiple = false)]
pub(crate) struct GoalArgs {
    /// The cheapest with at most this position error after every tick, meters
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = positive)]
    pub error: Option<f64>,
    /// The most accurate within this thread CPU time for 1/60 s, milliseconds
    #[arg(long, value_name = "MS", allow_negative_numbers = true, value_parser = positive)]
    pub budget_ms: Option<f64>,
}

impl GoalArgs {
    fn goal(self) -> Goal {
        let budget = self.budget_ms.map(Goal::Budget);
        self.error.map(Goal::Error).or(budget).expect("one of the two is required")
    }
}

/// Does what `sandbox recommend` says.
pub(crate) fn run(args: &RecommendArgs) -> Result<(), Failure> {
    let mut files = CommandFiles::default();
    let scene = files.named_scene(&args.scene)?;
    let parts = scene.parts();
    check(&args.scene, &scene, &parts).map_err(Failure::Usage)?;
    check_study(&scene, args.seconds)?;
    // Opened before the runs, so that a file that cannot be written is an error now.
    let target =
        args.apply.as_deref().map(|path| Target::open(path, &scene, &mut files)).transpose()?;
    let studies = measure(&parts, args);
    let (found, studies) = choose(&parts, studies, args.goal.goal(), args.seconds)?;
    show(&match args.format {
        Format::Table => table(&scene, &found, &studies),
        Format::Json => json(&scene, &found, &parts, &studies),
    })?;
    target.map_or(Ok(()), |target| target.write(args, &scene, &parts, &found))
}

/// The text of the scene with the chosen settings.
fn with_choice(
    name: &str,
    scene: &Scene,
    parts: &[Part],
    found: &Recommendation,
) -> Result<String, Failure> {
    let settings = found.rows.iter().map(|row| row.pick.setting);
    let settings: Vec<_> = parts.iter().zip(settings).collect();
    let (common, own) = scene.methods_of_parts(&settings);
    Ok(scene.with_methods(name, common, &own)?)
}

/// Chooses a setting for each part. Also returns the studies, with a note on each setting that was left out: a setting that the
/// forecast finds a fault with is not chosen, because `run --refuse-unstable` would refuse it.
fn choose(
    parts: &[Part],
    mut studies: Vec<Study>,
    goal: Goal,
    seconds: Option<f64>,
) -> Result<(Recommendation, Vec<Study>), Failure> {
    let mut open = studies.clone();
    loop {
        let named: Vec<_> =
            parts.iter().zip(&open).map(|(part, study)| (part.name.as_str(), study)).collect();
        let found = recommend(&named, goal).map_err(|why| Failure::Expectation(why.to_string()))?;
        let has_fault = |(part, row): (&Part, &PartChoice)| {
            Subject::of_scene(part.scene.clone(), seconds).has_fault(row.pick.setting)
        };
        let Some(row) = parts.iter().zip(&found.rows).position(has_fault) else {
            return Ok((found, studies));
        };
        let left_out = found.rows[row].pick.setting;
        open[row].cells.retain(|cell| cell.setting != left_out);
        studies[row].notes.push(format!("{left_out} is left out: a forecast finds a fault"));
    }
}

/// Refuses a scene in which methods cannot be compared.
fn check(name: &str, scene: &Scene, parts: &[Part]) -> Result<(), String> {
    if parts.is_empty() {
        let what =
            "no body of it can move, so that there is no method to choose; give another scene";
        return Err(format!("{name}: {what}"));
    }
    // Each method would start the body with another velocity.
    let Some(body) = scene.bodies.iter().position(|body| body.verlet_previous.is_some()) else {
        return Ok(());
    };
    Err(format!(
        "{name}: bodies[{body}].verlet_previous_position_m: only position_verlet starts from it, so that methods \
         cannot be compared; give velocity_m_s instead"
    ))
}

/// The file for the scene with the chosen settings.
struct Target<'a> {
    path: &'a Path,
    file: Output,
}

impl<'a> Target<'a> {
    fn open(path: &'a Path, scene: &Scene, files: &mut CommandFiles) -> Result<Self, Failure> {
        let own = match &scene.source {
            Source::File(file) => file.canonicalize().ok(),
            Source::Shipped(_) | Source::Text => None,
        };
        let is_own = own.is_some() && path.canonicalize().ok() == own;
        if path.is_file() && !is_own {
            let what =
                "there is a file already, and not that of the scene; give --apply another name";
            return Err(Failure::Usage(format!("{}: {what}", path.display())));
        }
        let output =
            if is_own { OutputPath::of_program(path) } else { files.claim("--apply", path)? };
        Ok(Self { path, file: output_file(&output)? })
    }

    fn write(
        self,
        args: &RecommendArgs,
        scene: &Scene,
        parts: &[Part],
        found: &Recommendation,
    ) -> Result<(), Failure> {
        let text = with_choice(&args.scene, scene, parts, found)?;
        let written = self.file.finish_with(text.as_bytes());
        written.map_err(|error| Failure::file("write", self.path, &error))
    }
}

/// Studies each of `parts`.
fn measure(parts: &[Part], args: &RecommendArgs) -> Vec<Study> {
    let plan = plan(parts.len(), args.quick);
    let progress = Progress::new(parts.len());
    let mut studies = Vec::new();
    for part in parts {
        progress.say(part.name.as_str());
        let mut bench =
            Bench::new(Subject::of_scene(part.scene.clone(), args.seconds), plan.clone());
        let Ok(()) =
            progress.follow(studies.len(), &mut bench, |_| Ok::<_, std::convert::Infallible>(()));
        studies.push(bench.study().clone());
    }
    studies
}

/// The plan for each of `parts` parts, without runs that a choice does not need.
fn plan(parts: usize, quick: bool) -> Plan {
    let full = Plan::full();
    #[expect(clippy::cast_precision_loss, reason = "a count of parts")]
    let share = 1.0 / parts as f64;
    let (patience, timed) = (full.patience * share, full.timed * share.max(0.2));
    let plan = if quick { Plan::quick(parts) } else { Plan { patience, timed, ..full } };
    Plan { longer: 0, rates: false, ..plan }
}

fn table(scene: &Scene, found: &Recommendation, studies: &[Study]) -> String {
    let price = match found.unit {
        Unit::Milliseconds => "ms",
        Unit::Evaluations => "evaluations",
    };
    let span = Span::of(scene);
    let heading = [
        "part",
        "bodies",
        "over s",
        "method",
        "substeps",
        "error",
        "rms",
        "reference's own",
        price,
        "share",
    ];
    let heading = heading.map(str::to_owned).to_vec();
    let line = |(row, study): (&PartChoice, &Study)| {
        vec![
            row.part.clone(),
            row.bodies.to_string(),
            digits(study.simulated_s),
            row.pick.setting.method.name().to_owned(),
            format!("{:#}", row.pick.setting.substeps),
            length(row.pick.error_m, 3),
            length(row.pick.rms_m, 3),
            length(row.reference_error_m, 2),
            three_digits(row.pick.price * span.times),
            format!("{:.0} %", row.share * 100.0),
        ]
    };
    let lines: Vec<_> =
        std::iter::once(heading).chain(found.rows.iter().zip(studies).map(line)).collect();
    let mut text = format!(
        "`{}`: {price} for {}, in ticks of {}\n{}",
        scene.name,
        span.words,
        duration(1e9 / scene.step_hz, 3),
        report::aligned(&lines, false)
    );
    text += &format!("total {} {price}\n", three_digits(found.total * span.times));
    let dearest = &found.rows[found.dearest];
    text +=
        &format!("the price is set by {}: {:.0} % of it\n", dearest.part, dearest.share * 100.0);
    text += &found.rows.iter().map(|row| tie_words(row, price, &span)).collect::<String>();
    text += &next_words(found, price, &span);
    text += &found.rows.iter().map(|row| row_notes(row, scene)).collect::<String>();
    for (row, study) in found.rows.iter().zip(studies) {
        study.notes.iter().for_each(|note| text += &format!("{}: {note}\n", row.part));
    }
    text
}

/// The time of the scene that prices are for.
struct Span {
    words: &'static str,
    /// The time as a multiple of 1/60 s, the unit of prices.
    times: f64,
}

impl Span {
    /// A frame or, for a scene whose ticks are longer, a tick.
    fn of(scene: &Scene) -> Self {
        if scene.step_hz < 60.0 {
            Self { words: "a tick of it", times: 60.0 / scene.step_hz }
        } else {
            Self { words: "1/60 s of it", times: 1.0 }
        }
    }
}

/// Notes on a choice, besides its error and its price.
fn row_notes(row: &PartChoice, scene: &Scene) -> String {
    let mut text = String::new();
    if let Some(times) = row.longer_ticks.filter(|_| scene.step != StepKind::Frame) {
        text += &format!(
            "{}: by the order of its method, ticks {times} times as long would do where they are stable; try step_hz: {}\n",
            row.part,
            digits(scene.step_hz / times)
        );
    }
    if row.pick.setting.method == Method::PositionVerlet {
        text += &format!(
            "{}: the velocities of position Verlet are half a step behind, and of order 1\n",
            row.part
        );
    }
    text
}

/// Names the settings that cost the same as the choice.
fn tie_words(row: &PartChoice, price: &str, span: &Span) -> String {
    let tie = |point: &Point| {
        format!(
            "{} ({}, {} {price})",
            point.setting,
            length(point.error_m, 3),
            three_digits(point.price * span.times)
        )
    };
    let ties: Vec<_> = row.ties.iter().map(tie).collect();
    if ties.is_empty() {
        String::new()
    } else {
        format!("{} ties with {}\n", row.part, ties.join(", "))
    }
}

fn next_words(found: &Recommendation, price: &str, span: &Span) -> String {
    let Some(NextChoice { error_m, total, picks }) = &found.next else {
        return "nothing more accurate was measured, or could be told from the references' own errors\n"
            .to_owned();
    };
    let change =
        |(row, point): &(usize, Point)| format!("{} by {}", found.rows[*row].part, point.setting);
    let changes: Vec<_> = picks.iter().map(change).collect();
    let with = if changes.is_empty() { "the same".to_owned() } else { changes.join(", ") };
    let (error, total) = (length(*error_m, 3), three_digits(*total * span.times));
    format!("an error of {error} costs {total} {price}, with {with}\n")
}

fn json(scene: &Scene, found: &Recommendation, parts: &[Part], studies: &[Study]) -> String {
    let point = |point: &Point| {
        json!({
            "method": point.setting.method.name(),
            "substeps": point.setting.substeps,
            "error_m": number(point.error_m),
            "rms_m": number(point.rms_m),
            "price": number(point.price),
        })
    };
    let row = |((row, part), study): ((&PartChoice, &Part), &Study)| {
        json!({
            "part": row.part,
            "entries": part.entries.iter().map(scene::Entry::path).collect::<Vec<_>>(),
            "bodies": row.bodies,
            "pick": point(&row.pick),
            "ties": row.ties.iter().map(point).collect::<Vec<_>>(),
            "share": number(row.share),
            "longer_ticks": row.longer_ticks.map_or(Value::Null, number),
            "reference_error_m": number(row.reference_error_m),
            "study": study,
        })
    };
    let rows: Vec<_> = found.rows.iter().zip(parts).zip(studies).map(row).collect();
    let next_choice = |next: &NextChoice| {
        let picks = next
            .picks
            .iter()
            .map(|(row, new)| json!({ "part": found.rows[*row].part, "pick": point(new) }));
        json!({
            "error_m": number(next.error_m),
            "total": number(next.total),
            "changes": picks.collect::<Vec<_>>(),
        })
    };
    let report = json!({
        "scene": scene.name,
        "unit": match found.unit {
            Unit::Milliseconds => "ms",
            Unit::Evaluations => "evaluations",
        },
        "total": number(found.total),
        "sets_the_price": found.rows[found.dearest].part,
        "largest_error": found.rows[found.limiting].part,
        "next": found.next.as_ref().map_or(Value::Null, next_choice),
        "parts": rows,
    });
    format!("{}\n", serde_json::to_string_pretty(&report).expect("strings and numbers are JSON"))
}
