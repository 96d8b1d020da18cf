//! `sandbox stability`: the survival matrix, every method on every hard case.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use lab::stability::{Matrix, StabilityRun};
use motion::Method;
use scene::{Scene, cases};
use serde_json::Value;

use crate::args::{above_0, method, once};
use crate::commands::list::Format;
use crate::output::show;

use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{refuse_foreign_files, study_folder, write};
use crate::output::progress::{PIECE, Progress};

pub(super) const EXAMPLES: &str = "\
Example:
  sandbox stability --method semi_implicit_euler --method implicit_euler";

/// Runs the survival matrix.
#[derive(Args, Debug)]
pub(crate) struct StabilityArgs {
    /// Hard cases, or scene files that define survival [default: all of `sandbox list cases`]
    #[arg(value_name = "CASE")]
    pub cases: Vec<String>,
    /// Only this method; may be given several times
    #[arg(long = "method", value_name = "M", value_parser = method)]
    pub methods: Vec<Method>,
    /// Most ticks of a run
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = above_0)]
    pub ticks: Option<u64>,
    /// Write stability.html, matrix.svg, matrix.csv, matrix.md and matrix.json into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Does what `sandbox stability` says.
pub(crate) fn run(args: &StabilityArgs) -> Result<(), Failure> {
    let methods = methods(&args.methods);
    let mut files = CommandFiles::default();
    let scenes = scenes(&args.cases, &mut files)?;
    if let Some(folder) = &args.out {
        claim_folder(folder, &files)?;
    }
    let _lock = args.out.as_deref().map(study_folder).transpose()?;
    if let Some(folder) = &args.out {
        // A folder that cannot be written is an error now, and not after minutes.
        tempfile::tempfile_in(folder)
            .map_err(|error| Failure::file("write into", folder, &error))?;
    }
    let mut run = StabilityRun::new(scenes, &methods, args.ticks);
    let progress = Progress::new(1);
    loop {
        progress.say(run.now().unwrap_or_default());
        if run.work(PIECE) {
            break;
        }
        progress.show(run.progress());
    }
    drop(progress);
    let matrix = run.matrix();
    // First, so that the result is not lost if a file cannot be written.
    match args.format {
        Format::Table => show(&report::stability::table(matrix).aligned())?,
        Format::Json => show(&matrix.json())?,
    }
    args.out.as_ref().map_or(Ok(()), |folder| write_matrix(matrix, folder, &files))
}

/// Refuses a folder in which a matrix would write over files of a person.
fn claim_folder(folder: &Path, files: &CommandFiles) -> Result<(), Failure> {
    files.refuse_names(
        folder,
        report::stability::is_file,
        "the matrix in that folder; give another folder",
    )?;
    let earlier = fs::read_to_string(folder.join("matrix.json")).unwrap_or_default();
    let is_own =
        serde_json::from_str::<Value>(&earlier).is_ok_and(|matrix| matrix["rows"].is_array());
    let is_text = |name: &str| report::stability::is_file(name) && !name.ends_with(".svg");
    refuse_foreign_files(folder, is_own, is_text, "give another folder")
}

/// Writes the files of a matrix.
fn write_matrix(matrix: &Matrix, folder: &Path, files: &CommandFiles) -> Result<(), Failure> {
    for (name, bytes) in report::stability::files(matrix) {
        write(&files.unread(&folder.join(name))?, &bytes)?;
    }
    Ok(())
}

/// The requested methods, each once and in the order of the table; all methods if none is requested.
fn methods(asked: &[Method]) -> Vec<Method> {
    Method::ALL.into_iter().filter(|method| asked.is_empty() || asked.contains(method)).collect()
}

/// The requested cases, each once; all cases if none is requested.
fn scenes(asked: &[String], files: &mut CommandFiles) -> Result<Vec<Scene>, Failure> {
    if asked.is_empty() {
        return cases().iter().map(|case| Ok(case.load()?)).collect();
    }
    once(asked).iter().map(|name| files.case(name)).collect()
}
