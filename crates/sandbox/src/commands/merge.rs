//! `sandbox merge`: joins the shards of a study to the report that one run would have made.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use lab::Shard;
use lab::cost::{Report, Study};
use lab::part::{Found, Part};
use lab::stability::Matrix;
use lab::sweep::Record;

use crate::commands::{cost, recommend, stability};
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{refuse_foreign_files, study_folder};
use crate::output::parts;
use crate::output::runs::{self, Runs, write_tables};
use crate::output::show;

pub(super) const EXAMPLES: &str = "\
Example:
  sandbox merge part1 part2 part3 --out all";

/// Joins the shards of a sweep, a study, a matrix or a recommendation.
#[derive(Args, Debug)]
pub(crate) struct MergeArgs {
    /// The folders of all shards, in any order
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Write the files of the whole study into this folder
    #[arg(long, value_name = "DIR", required = true)]
    pub out: PathBuf,
}

/// Greatest number of missing shards that a message names.
const SHOWN: usize = 20;

/// Does what `sandbox merge` says.
pub(crate) fn run(args: &MergeArgs) -> Result<(), Failure> {
    let Some(first) = args.folders.first() else { return Ok(()) };
    if parts::part(first)?.is_some() { merge_parts(args) } else { merge_sweeps(args) }
}

/// The functions that read and compare shards of one kind.
struct Kind<S> {
    /// Name of the file that describes a shard.
    file: &'static str,
    /// The word for what the shards are parts of.
    what: &'static str,
    read: fn(&Path) -> Result<Option<S>, Failure>,
    /// The place of the shard, and whether all of it was run.
    state: fn(&S) -> (Shard, bool),
    /// The reason why two shards are not of one study, as the end of a sentence.
    differs: fn(&S, &S) -> Option<&'static str>,
}

const SWEEPS: Kind<Record> = Kind {
    file: runs::RECORD,
    what: "sweep",
    read: runs::record,
    state: |record| (record.shard, record.complete),
    differs: Record::differs,
};

const STUDIES: Kind<Part> = Kind {
    file: parts::PART,
    what: "study",
    read: parts::part,
    state: |part| (part.shard, part.complete),
    differs: Part::differs,
};

/// All shards of a study with their folders, in their order.
fn all_shards<S>(
    kind: &Kind<S>,
    folders: &[PathBuf],
    files: &mut CommandFiles,
) -> Result<Vec<(PathBuf, S)>, Failure> {
    let mut shards: BTreeMap<Shard, (PathBuf, S)> = BTreeMap::new();
    let Kind { file, what, read, state, differs } = kind;
    for folder in folders {
        let refused = |what: String, cure: &str| {
            Failure::Usage(format!("{}: {what}; {cure}", folder.display()))
        };
        let record = read(folder)?.ok_or_else(|| {
            let what = "no shard of a sweep or a study was written into this folder".to_owned();
            refused(what, "give the folders of --out of every shard")
        })?;
        if let Some((_, (other, first))) = shards.first_key_value()
            && let Some(differs) = differs(first, &record)
        {
            let words = format!("this is a {what} of {differs} than that in {}", other.display());
            return Err(refused(words, &format!("give the shards of one {what}")));
        }
        let (shard, is_complete) = state(&record);
        if !is_complete {
            let what = format!("shard {shard} is not complete");
            return Err(refused(what, "finish it with --resume"));
        }
        files.read("the record of a shard", &folder.join(file))?;
        if let Some((other, _)) = shards.insert(shard, (folder.clone(), record)) {
            let what = format!("shard {shard} is here and in {}", other.display());
            return Err(refused(what, "leave one of them out"));
        }
    }
    let of = shards.keys().next().map_or(1, |shard| shard.of());
    let is_missing = |number: &u32| !shards.keys().any(|shard| shard.number() == *number);
    let missing = u64::from(of) - shards.len() as u64;
    if missing > 0 {
        let named = (1..=of).filter(is_missing).take(SHOWN).map(|number| format!("{number}/{of}"));
        let named = named.collect::<Vec<_>>().join(", ");
        let more = missing.saturating_sub(SHOWN as u64);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        return Err(Failure::Usage(format!(
            "missing shards: {named}{more}; give the folders of all"
        )));
    }
    Ok(shards.into_values().collect())
}

/// Merges the shards of a sweep, in memory that does not grow with its runs.
fn merge_sweeps(args: &MergeArgs) -> Result<(), Failure> {
    let mut files = CommandFiles::default();
    let shards = all_shards(&SWEEPS, &args.folders, &mut files)?;
    let Some((_, first)) = shards.first() else { return Ok(()) };
    let mut record = Record {
        shard: Shard::WHOLE,
        processors: Vec::new(),
        complete: false,
        table_hash: None,
        ..first.clone()
    };
    let mut sources = Vec::new();
    for (folder, of_shard) in &shards {
        sources.push(Runs::of_folder(of_shard, folder)?);
        record.processors.extend(of_shard.processors.iter().cloned());
    }
    record.processors.sort_unstable();
    record.processors.dedup();
    files.refuse_names(
        &args.out,
        runs::is_file,
        "the sweep in that folder; give another folder",
    )?;
    let earlier = runs::record(&args.out)?;
    let is_own = earlier.is_some_and(|earlier| record.differs(&earlier).is_none());
    refuse_foreign_files(&args.out, is_own, runs::is_file, "give another folder")?;
    let _lock = study_folder(&args.out)?;
    write_tables(&record, sources, &args.out, &files)?;
    let (runs, of) = (record.plan.runs().unwrap_or_default(), shards.len());
    let processors = record.processors.join(", ");
    show(&format!("{}: {runs} runs of {of} shards, run on {processors}\n", args.out.display()))
}

/// Merges the shards of a study of cost, a survival matrix or a recommendation.
fn merge_parts(args: &MergeArgs) -> Result<(), Failure> {
    let mut files = CommandFiles::default();
    let shards = all_shards(&STUDIES, &args.folders, &mut files)?;
    let (mut rows, mut studies) = (BTreeMap::new(), BTreeMap::new());
    let machines: Vec<_> = shards.iter().map(|(_, part)| part.machine.clone()).collect();
    let (Some((folder, first)), Some(machine)) = (shards.first(), machines.first()) else {
        return Ok(());
    };
    let command = first.command.clone();
    for (folder, part) in &shards {
        let place = |at: usize| part.shard.nth(at as u64);
        match &part.found {
            Found::Stability { rows: own, .. } => {
                rows.extend(own.iter().enumerate().map(|(at, row)| (place(at), row.clone())));
            }
            Found::Recommend { .. } if part.machine.processor != machine.processor => {
                let what = format!(
                    "this shard was timed on {}, another one on {}",
                    part.machine.processor, machine.processor
                );
                let cure = "times of different processors are not compared: measure all shards on one kind";
                return Err(Failure::Usage(format!("{}: {what}; {cure}", folder.display())));
            }
            Found::Cost(own) | Found::Recommend { studies: own, .. } => {
                // Each study is ranked by itself, with the times of one machine.
                let other = (part.machine != *machine).then(|| part.machine.clone());
                let of = |study: &Study| Study { machine: other.clone(), ..study.clone() };
                studies.extend(own.iter().enumerate().map(|(at, study)| (place(at), of(study))));
            }
        }
    }
    let is_whole =
        |places: Vec<u64>| places.into_iter().eq(0..rows.len().max(studies.len()) as u64);
    if !is_whole(rows.keys().chain(studies.keys()).copied().collect()) {
        let cure = "these files were changed since they were written: run the shards again";
        return Err(Failure::Usage(format!(
            "{}: some parts are missing; {cure}",
            folder.display()
        )));
    }
    let studies: Vec<_> = studies.into_values().collect();
    match &first.found {
        Found::Stability { .. } => {
            stability::claim_folder(&args.out, &files)?;
            let _lock = study_folder(&args.out)?;
            let matrix =
                Matrix { format: lab::stability::FORMAT, rows: rows.into_values().collect() };
            stability::write_matrix(&matrix, &args.out, &files)?;
            said(args, matrix.rows.len(), "rows", shards.len())
        }
        Found::Cost(_) => {
            let report = Report {
                format: lab::cost::FORMAT,
                command,
                machine: machine.clone(),
                complete: true,
                studies,
            };
            let is_own = cost::has_report_of(&args.out, &report.command);
            cost::claim_folder(&args.out, is_own, "give another folder", &files)?;
            let _lock = study_folder(&args.out)?;
            cost::write_report(&report, &args.out, &files)?;
            said(args, report.studies.len(), "studies", shards.len())
        }
        Found::Recommend { scene, goal, seconds, .. } => {
            let recommended = recommend::of_studies(scene, *goal, *seconds, studies)?;
            recommend::write(&recommended, &args.out, &files)?;
            show(&recommended.table)
        }
    }
}

fn said(args: &MergeArgs, count: usize, of: &str, shards: usize) -> Result<(), Failure> {
    show(&format!("{}: {count} {of} of {shards} shards\n", args.out.display()))
}

#[expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
#[cfg(test)]
mod tests;
