//! `sandbox sweep`: a scene run once for every combination of values, one table and one figure.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::Args;
use lab::cost::Machine;
use lab::sweep::{Axis, FORMAT, Measure, Outcome, Plan, Record, Row, Sweep};
use lab::{Shard, Value};
use report::numbers::{NONE, digits};
use xxhash_rust::xxh3::xxh3_64;

use crate::args::{SceneName, check_seconds, cores, once, positive, threads};
use crate::commands::list::Format;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{
    how_to_continue, nothing_to_continue, refuse_foreign_files, say_how_to_continue, study_folder,
};
use crate::output::on_device::refuse_alone;
use crate::output::progress::runs_bar;
use crate::output::runs::{self, Journal};
use crate::output::{show, tell};

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox sweep oscillator --vary method=all --vary step_hz=10,20,40
  sandbox sweep flag --vary soft_bodies[0].stiffness_n_m=100,1000,10000 --vary substeps=1,4 --out stiffness
  sandbox sweep orbit --vary step_hz=30,60 --measure error,drift --out orbits --shard 1/2";

/// Runs a sweep.
#[derive(Args, Debug)]
pub(crate) struct SweepArgs {
    /// A shipped scene or a file
    pub scene: SceneName,
    /// A place in the scene and its values: a list, `1e2..1e6 log 20`, `1..2 lin 5`, `1..2 random 20 seed 7`, or
    /// `all` methods; may be given several times, for every combination
    #[arg(long = "vary", value_name = "PLACE=VALUES", required = true, value_parser = Axis::parse)]
    pub axes: Vec<Axis>,
    /// Simulated seconds of each run
    #[arg(long, value_name = "S", default_value_t = 10.0, allow_negative_numbers = true, value_parser = positive)]
    pub seconds: f64,
    /// What is measured: error, drift, survives, largest_speed, largest_distance, evaluations, unconverged, state_hash, time;
    /// the figure shows the first
    #[arg(long = "measure", value_name = "MEASURE,...", value_delimiter = ',', default_values = ["survives", "drift", "largest_speed"], value_parser = measure)]
    pub measures: Vec<Measure>,
    /// Write runs.csv, sweep.svg and sweep.json into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Continue the sweep that was interrupted in that folder
    #[arg(long, requires = "out")]
    pub resume: bool,
    /// Run only part K of N, for `sandbox merge`
    #[arg(long, value_name = "K/N", requires = "out", default_value_t = Shard::WHOLE)]
    pub shard: Shard,
    /// Runs side by side [default: one per core]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub threads: Option<usize>,
    /// Allow more than 10 million runs
    #[arg(long)]
    pub yes: bool,
    /// As a table or as JSON, without --out
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Greatest number of runs without `--yes`.
const MANY: u64 = 10_000_000;

/// Greatest number of runs that are printed.
const PRINTED: u64 = 10_000;

/// Does what `sandbox sweep` says.
pub(crate) fn run(args: &SweepArgs) -> Result<(), Failure> {
    let mut files = CommandFiles::default();
    let scene = files.named_scene(&args.scene)?;
    refuse_alone(&scene)?;
    check_seconds(args.seconds, scene.step_hz)?;
    let plan =
        Plan { axes: args.axes.clone(), seconds: args.seconds, measures: once(&args.measures) };
    let all = count(&plan, args.yes)?;
    let (runs, shard) = (args.shard.count(all), args.shard);
    if args.out.is_none() && runs > PRINTED {
        let what = format!("{runs} runs are too many to print");
        return Err(Failure::Usage(format!("{what}; give a folder for them with --out")));
    }
    let sweep = Sweep::new(&scene, plan.clone())?;
    let [shared, each] = sweep.estimated_bytes();
    let most = args.threads.unwrap_or_else(cores);
    let most = most.min(usize::try_from(runs).unwrap_or(most)).max(1);
    let threads = scene::runs_that_fit(shared, each, most).map_err(|what| {
        let cure = "measure less, give fewer bodies, or give more with --memory";
        Failure::Usage(format!("{}: {what}; {cure}", args.scene))
    })?;
    if threads < most {
        tell(&format!("{threads} of {most} runs side by side fit into the memory"));
    }
    let earlier = args.out.as_deref().map(runs::record).transpose()?.flatten();
    let Some(folder) = &args.out else {
        let mut rows = Vec::new();
        let bar = runs_bar(runs);
        sweep.run(shard, 0, threads, |row| {
            bar.inc(1);
            rows.push(row);
            ControlFlow::Continue(())
        });
        bar.finish_and_clear();
        return match args.format {
            Format::Table => show(&table(&plan, &rows)),
            Format::Json => show(&json(&plan, &rows)),
        };
    };
    let record = Record {
        format: FORMAT,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        scene: scene.name.clone(),
        scene_hash: format!("{:016x}", xxh3_64(scene.text.as_bytes())),
        plan,
        shard,
        processors: vec![Machine::here().processor],
        complete: false,
        table_hash: None,
    };
    files.refuse_names(folder, runs::is_file, "the sweep in that folder; give another folder")?;
    refuse_foreign_files(folder, earlier.is_some(), runs::is_file, "give another folder")?;
    let _lock = study_folder(folder)?;
    let Some((record, mut journal, done)) = begin(args, record, earlier, folder, &files)? else {
        return show(&format!("{}: this sweep is complete\n", folder.display()));
    };
    let cure = how_to_continue("--resume");
    say_how_to_continue(folder, &cure);
    let bar = runs_bar(runs);
    bar.set_position(done);
    let (mut failure, mut outcomes) = (None, BTreeMap::new());
    sweep.run(shard, done, threads, |row| {
        bar.inc(1);
        *outcomes.entry(row.outcome).or_insert(0_u64) += 1;
        match journal.add(&row) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                failure = Some(error);
                ControlFlow::Break(())
            }
        }
    });
    bar.finish_and_clear();
    nothing_to_continue();
    let written = failure.map_or_else(|| journal.finish(&record, folder, &files), Err);
    if let Err(failure) = written {
        return Err(Failure::Usage(format!("{failure}; {cure}")));
    }
    let words = [
        (Outcome::Finished, "finished"),
        (Outcome::Quarantined, "lost a body"),
        (Outcome::Refused, "were refused"),
    ];
    let mut counts: Vec<_> = words
        .iter()
        .filter_map(|(outcome, word)| Some(format!("{} {word}", outcomes.get(outcome)?)))
        .collect();
    if done > 0 {
        counts.insert(0, format!("{done} were done before"));
    }
    if counts.is_empty() {
        return show(&format!("{}: shard {shard} has no runs\n", folder.display()));
    }
    show(&format!("{}: of {runs} runs {}\n", folder.display(), counts.join(", ")))
}

/// The number of runs; refuses more than [`MANY`] without `yes`.
fn count(plan: &Plan, yes: bool) -> Result<u64, Failure> {
    match plan.runs() {
        Some(runs) if runs <= MANY || yes => Ok(runs),
        Some(runs) => Err(Failure::Usage(format!(
            "these values make {runs} runs, which is more than {MANY}; give fewer values, or --yes"
        ))),
        None => {
            let what = "these values make more than 10^19 runs; give fewer values";
            Err(Failure::Usage(what.to_owned()))
        }
    }
}

/// Begins or resumes the journal of a sweep in `folder`. Also returns the number of runs in it; `None` if it has all of them.
fn begin(
    args: &SweepArgs,
    mut record: Record,
    earlier: Option<Record>,
    folder: &Path,
    files: &CommandFiles,
) -> Result<Option<(Record, Journal, u64)>, Failure> {
    let refused = |what: &str, cure: &str| {
        Err(Failure::Usage(format!("{}: {what}; {cure}", folder.join(runs::RECORD).display())))
    };
    let continues = if let Some(earlier) = earlier {
        let other =
            record.differs(&earlier).or((record.shard != earlier.shard).then_some("another shard"));
        if let Some(other) = other {
            return refused(
                &format!("the sweep in this folder is of {other}"),
                "give another folder, or remove it",
            );
        }
        match (earlier.complete, args.resume) {
            (false, false) => {
                return refused(
                    "this sweep is not complete",
                    "--resume continues it; or give another folder",
                );
            }
            (false, true) => {
                let here = std::mem::replace(&mut record.processors, earlier.processors);
                let is_new = |name: &String| !record.processors.contains(name);
                let new: Vec<_> = here.into_iter().filter(is_new).collect();
                record.processors.extend(new);
                true
            }
            (true, true) if runs::are_there(&earlier, folder) => return Ok(None),
            (true, _) => false,
        }
    } else {
        false
    };
    runs::write_record(&record, folder, files)?;
    let (journal, done) = Journal::begin(&record, folder, files, continues)?;
    Ok(Some((record, journal, done)))
}

fn measure(text: &str) -> Result<Measure, String> {
    Measure::from_name(text)
        .ok_or_else(|| format!("the measures are {}", Measure::ALL.map(Measure::name).join(", ")))
}

/// The rows for a terminal.
fn table(plan: &Plan, rows: &[Row]) -> String {
    let shown = |value: &Value| match value {
        Value::Number(number) if number.is_finite() => digits(*number),
        Value::Number(_) | Value::Absent => NONE.to_owned(),
        other @ (Value::Count(_) | Value::Flag(_) | Value::Text(_)) => other.to_string(),
    };
    let header = plan.columns().into_iter().map(|column| column.name).collect();
    let lines = rows.iter().map(|row| row.values.iter().map(shown).collect());
    report::aligned(&std::iter::once(header).chain(lines).collect::<Vec<_>>(), true)
}

/// The rows as a list of objects.
fn json(plan: &Plan, rows: &[Row]) -> String {
    use serde_json::{Map, Value as Json};
    let value = |value: &Value| match value {
        Value::Number(number) => {
            serde_json::Number::from_f64(*number).map_or(Json::Null, Json::Number)
        }
        Value::Count(count) => Json::from(*count),
        Value::Flag(flag) => Json::from(*flag),
        Value::Text(text) => Json::from(text.clone()),
        Value::Absent => Json::Null,
    };
    let columns = plan.columns();
    let object = |row: &Row| -> Map<String, Json> {
        columns.iter().map(|column| column.name.clone()).zip(row.values.iter().map(value)).collect()
    };
    let objects: Vec<_> = rows.iter().map(object).collect();
    serde_json::to_string_pretty(&objects).expect("rows are plain data") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cure_of_too_many_runs_helps() {
        let said = |axes: usize, yes| {
            let axis = |number| Axis::parse(&format!("bodies[{number}].mass_kg=1..10 lin 10"));
            let axes = (0..axes).map(axis).collect::<Result<_, _>>().expect("axes");
            count(&Plan { axes, seconds: 1.0, measures: Vec::new() }, yes)
                .map_err(|f| f.to_string())
        };
        assert_eq!(said(7, false), Ok(10_000_000));
        assert_eq!(said(8, true), Ok(100_000_000));
        assert!(said(8, false).is_err_and(|said| said.ends_with("give fewer values, or --yes")));
        assert!(said(20, true).is_err_and(|said| said.ends_with("10^19 runs; give fewer values")));
    }
}
