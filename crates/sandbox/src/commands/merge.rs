//! `sandbox merge`: joins the shards of a sweep to the files that one run would have made.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use lab::Shard;
use lab::sweep::Record;

use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{refuse_foreign_files, study_folder};
use crate::output::runs::{self, Runs, write_tables};
use crate::output::show;

pub(super) const EXAMPLES: &str = "\
Example:
  sandbox merge part1 part2 part3 --out all";

/// Joins the shards of a sweep.
#[derive(Args, Debug)]
pub(crate) struct MergeArgs {
    /// The folders of all shards, in any order
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Write the files of the whole sweep into this folder
    #[arg(long, value_name = "DIR", required = true)]
    pub out: PathBuf,
}

/// Greatest number of missing shards that a message names.
const SHOWN: usize = 20;

/// All shards of a sweep with their folders, in their order.
fn all_shards(
    folders: &[PathBuf],
    files: &mut CommandFiles,
) -> Result<Vec<(PathBuf, Record)>, Failure> {
    let mut shards: BTreeMap<Shard, (PathBuf, Record)> = BTreeMap::new();
    for folder in folders {
        let refused = |what: String, cure: &str| {
            Failure::Usage(format!("{}: {what}; {cure}", folder.display()))
        };
        let record = runs::record(folder)?.ok_or_else(|| {
            let what = "no shard of a sweep was written into this folder".to_owned();
            refused(what, "give the folders of --out of every shard")
        })?;
        if let Some((_, (other, first))) = shards.first_key_value()
            && let Some(differs) = first.differs(&record)
        {
            let words = format!("this is a sweep of {differs} than that in {}", other.display());
            return Err(refused(words, "give the shards of one sweep"));
        }
        let shard = record.shard;
        if !record.complete {
            let what = format!("shard {shard} is not complete");
            return Err(refused(what, "finish it with --resume"));
        }
        files.read("the record of a shard", &folder.join(runs::RECORD))?;
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

/// Does what `sandbox merge` says, in memory that does not grow with the runs.
pub(crate) fn run(args: &MergeArgs) -> Result<(), Failure> {
    let mut files = CommandFiles::default();
    let shards = all_shards(&args.folders, &mut files)?;
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

#[expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
#[cfg(test)]
mod tests;
