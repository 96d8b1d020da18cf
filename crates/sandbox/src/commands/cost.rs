//! `sandbox cost`: every method at every step, its error beside its cost.

use std::path::{Path, PathBuf};

use clap::Args;
use lab::cost::{
    Bench, FORMAT, Machine, PROBLEMS, Plan, Report, Study, Subject, problem,
    take_real_time_priority,
};
use scene::shown;

use crate::args::{bodies, check_study, positive};
use crate::commands::list::Format;
use crate::output::{show, tell};

use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{
    how_to_continue, nothing_to_continue, read_record, refuse_foreign_files, say_how_to_continue,
    sealed, study_folder, write,
};
use crate::output::on_device::refuse_alone;
use crate::output::progress::Progress;

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox cost kepler --quick
  sandbox cost flag --seconds 5 --out report";

/// Measures accuracy against cost.
#[derive(Args, Debug)]
pub(crate) struct CostArgs {
    /// Problems, shipped scenes or files [default: harmonic_oscillator kepler tetrahedron flag tutorial]
    #[arg(value_name = "PROBLEM|SCENE")]
    pub subjects: Vec<String>,
    /// Simulated seconds of a scene [default: 10]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
    pub seconds: Option<f64>,
    /// Copies of a problem that are timed together; a scene is timed as it is [default: 1000]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = bodies)]
    pub bodies: Option<u32>,
    /// Fewer and shorter runs: an answer within a minute
    #[arg(long)]
    pub quick: bool,
    /// Write report.html, figures and tables into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Continue the report that was interrupted in that folder
    #[arg(long, requires = "out")]
    pub resume: bool,
    /// Write over the report of another command, version or machine in that folder
    #[arg(long, requires = "out", conflicts_with = "resume")]
    pub replace: bool,
    /// As a table or as JSON
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Problems and scenes studied by default: an oscillator, an orbit, things that stretch, and the tutorial.
const DEFAULT: [&str; 5] = ["harmonic_oscillator", "kepler", "tetrahedron", "flag", "tutorial"];

/// Message if the program cannot get real-time priority.
const DISTURBED: &str = "other programs disturb these times; with real-time priority they are more repeatable: sudo chrt -f 1 sandbox cost ...";

/// Number of looks at a study between two saves of an unfinished report.
const SAVE: u32 = 20;

/// The machine-readable part of a report, which `--resume` reads.
const FILE: &str = "report.json";

/// Does what `sandbox cost` says.
pub(crate) fn run(args: &CostArgs) -> Result<(), Failure> {
    let names = names(args);
    if args.bodies.is_some() && !names.iter().any(|name| problem(name).is_some()) {
        let what =
            "--bodies is for problems: a scene is timed with the bodies that it has; leave it out";
        return Err(Failure::Usage(what.to_owned()));
    }
    if args.seconds.is_some() && names.iter().all(|name| problem(name).is_some()) {
        let what = "--seconds is for scenes: a problem has a length of its own; leave it out";
        return Err(Failure::Usage(what.to_owned()));
    }
    let mut files = CommandFiles::default();
    let subjects = subjects(&names, args.seconds, &mut files)?;
    let mut plan = if args.quick { Plan::quick(subjects.len()) } else { Plan::full() };
    plan.bodies = args.bodies.unwrap_or(plan.bodies);
    if let Some(folder) = &args.out {
        // A report may be there already: `earlier` checks whose it is.
        let cure = "give another folder, or --replace to write over it";
        claim_folder(folder, args.replace || folder.join(FILE).exists(), cure, &files)?;
    }
    let _lock = args.out.as_deref().map(study_folder).transpose()?;
    let earlier = earlier(args, &subjects)?;
    let target = Target { folder: args.out.as_deref(), files: &files };
    let mut report = Report {
        format: FORMAT,
        command: command(args),
        machine: Machine::here(),
        complete: false,
        studies: Vec::new(),
    };
    if take_real_time_priority() == Some(false) {
        tell(DISTURBED);
    }
    target.save(&report)?;
    let option = if args.replace { "--resume, in place of --replace," } else { "--resume" };
    let cure = how_to_continue(option);
    args.out.iter().for_each(|folder| say_how_to_continue(folder, &cure));
    let progress = Progress::new(names.len());
    for (number, subject) in subjects.into_iter().enumerate() {
        progress.say(subject.name());
        let mut bench = Bench::new(subject, plan.clone());
        if let Some(study) = earlier.iter().find(|study| study.subject == bench.study().subject) {
            bench.resume(study);
        }
        report.studies.push(bench.study().clone());
        let mut looks = 0;
        progress.follow(number, &mut bench, |bench| {
            looks += 1;
            if looks % SAVE != 0 {
                return Ok(());
            }
            report.studies[number].clone_from(bench.study());
            target.save(&report)
        })?;
        report.studies[number].clone_from(bench.study());
        target.save(&report)?;
    }
    drop(progress);
    report.complete = true;
    target.finish(&report)?;
    nothing_to_continue();
    match args.format {
        Format::Table => report.studies.iter().try_for_each(|study| show(&report::text(study))),
        Format::Json => show(&report::json(&report)),
    }
}

fn names(args: &CostArgs) -> Vec<&str> {
    match &args.subjects[..] {
        [] => DEFAULT.to_vec(),
        named => named.iter().map(String::as_str).collect(),
    }
}

/// Loads the problems and scenes called `names`.
fn subjects(
    names: &[&str],
    seconds: Option<f64>,
    files: &mut CommandFiles,
) -> Result<Vec<Subject>, Failure> {
    let mut subject = |name: &str| match problem(name) {
        Some(problem) => Ok(Subject::of_problem(problem)?),
        None => match files.scene(name) {
            Ok(scene) => {
                check_study(&scene, seconds)?;
                refuse_alone(&scene)?;
                Ok(Subject::of_scene(scene, seconds))
            }
            Err(error) => {
                let problems: Vec<_> = PROBLEMS.iter().map(|problem| problem.name).collect();
                let near = scene::nearest(name, problems.iter().copied());
                let guess = scene::did_you_mean(near.map(|near| format!("the problem {near}")));
                Err(Failure::Usage(format!(
                    "{error}\n{guess}the problems are {}",
                    problems.join(", ")
                )))
            }
        },
    };
    names.iter().copied().map(&mut subject).collect()
}

/// The studies in the folder, to be resumed. A report that would be lost is an error, unless `--replace` allows it.
fn earlier(args: &CostArgs, subjects: &[Subject]) -> Result<Vec<Study>, Failure> {
    let Some(folder) = args.out.as_ref().filter(|_| !args.replace) else { return Ok(Vec::new()) };
    let path = folder.join(FILE);
    let cure = "give another folder, or --replace to write over it";
    let other = |what: &str| Err(Failure::Usage(format!("{}: {what}; {cure}", path.display())));
    let Some(report) = read_record::<Report>(&path, "report", cure)? else {
        return Ok(Vec::new());
    };
    if report.format != FORMAT || report.machine != Machine::here() {
        return other("this report was made by another version or on another machine");
    }
    if !args.resume {
        if report.command != command(args) {
            return other(&format!("this is the report of `{}`", report.command));
        }
        if !report.complete {
            let what = "this report is not complete; --resume continues it";
            return Err(Failure::Usage(format!(
                "{}: {what}, --replace writes over it",
                path.display()
            )));
        }
        return Ok(Vec::new());
    }
    let is_asked_for =
        |study: &&Study| subjects.iter().any(|subject| subject.name() == study.subject);
    match report.studies.iter().find(|study| !is_asked_for(study)) {
        Some(study) => {
            other(&format!("this report has a study of {}, which is not asked for", study.subject))
        }
        None => Ok(report.studies),
    }
}

/// The command that makes the report again.
fn command(args: &CostArgs) -> String {
    let mut command = "sandbox cost".to_owned();
    for subject in &args.subjects {
        command += &format!(" {subject}");
    }
    if let Some(bodies) = args.bodies {
        command += &format!(" --bodies {bodies}");
    }
    if args.quick {
        command += " --quick";
    }
    if let Some(seconds) = args.seconds {
        command += &format!(" --seconds {}", shown(seconds));
    }
    command
}

/// The place where a report is written.
struct Target<'a> {
    folder: Option<&'a Path>,
    files: &'a CommandFiles,
}

impl Target<'_> {
    /// Writes the report so far.
    fn save(&self, report: &Report) -> Result<(), Failure> {
        let Some(folder) = self.folder else { return Ok(()) };
        let text = sealed(&report::json(report));
        write(&self.files.unread(&folder.join(FILE))?, text.as_bytes())
    }

    /// Writes the complete report.
    fn finish(&self, report: &Report) -> Result<(), Failure> {
        self.folder.map_or(Ok(()), |folder| write_report(report, folder, self.files))
    }
}

/// Refuses a folder in which a report would write over files of a person, unless it `is_own`.
fn claim_folder(
    folder: &Path,
    is_own: bool,
    cure: &str,
    files: &CommandFiles,
) -> Result<(), Failure> {
    files.refuse_names(
        folder,
        report::is_file,
        "the report in that folder; give another folder",
    )?;
    refuse_foreign_files(
        folder,
        is_own,
        |name| report::is_file(name) && !name.ends_with(".svg"),
        cure,
    )
}

/// Writes the files of a report.
fn write_report(report: &Report, folder: &Path, files: &CommandFiles) -> Result<(), Failure> {
    report::files(report).try_for_each(|(name, bytes)| {
        let sealed = (name == FILE).then(|| sealed(&report::json(report)).into_bytes());
        write(&files.unread(&folder.join(name))?, &sealed.unwrap_or(bytes))
    })
}
