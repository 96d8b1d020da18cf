//! `sandbox lessons`: the lessons in the program, and a lesson played by its own solution and by wrong ones.

pub(super) mod demonstration;
mod pages;

use std::path::PathBuf;

use clap::{Args, Subcommand};
use report::aligned;
use scene::lesson::{Lesson, shipped};

use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::progress::Waiting;
use crate::output::show;
use cockpit::app::pupil::check;

pub(super) const EXAMPLES: &str = "\
Examples:
  sandbox lessons
  sandbox lessons check force
  sandbox lessons --html pages
  sandbox lessons --html pages --page https://example.org/inertia/play.html
  sandbox lessons --html pages my.ron";

/// Lists lessons, checks one, or writes pages of all.
#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct LessonsArgs {
    #[command(subcommand)]
    what: Option<What>,
    /// Write a page for each lesson, to be printed, one with the answers, and an index
    #[arg(long, value_name = "DIR")]
    html: Option<PathBuf>,
    /// Address of play.html of the web page, to link the pages to: see docs/web.md
    #[arg(long, value_name = "URL", requires = "html")]
    page: Option<String>,
    /// The lessons of the pages: names or files [default: all of the program]
    #[arg(value_name = "LESSON", requires = "html")]
    lessons: Vec<String>,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Play a lesson by its solution, which has to be accepted, and by its wrong ways, which must not; at two step sizes
    Check {
        /// A lesson of the program, or a file
        lesson: String,
    },
}

/// Does what `sandbox lessons` says.
pub(crate) fn run(args: &LessonsArgs) -> Result<(), Failure> {
    let mut files = CommandFiles::default();
    match (&args.what, &args.html) {
        (Some(What::Check { lesson }), _) => {
            let lesson = files.lesson(lesson)?;
            let waiting = Waiting::begin("playing the lesson");
            let report = check(&lesson)?;
            drop(waiting);
            show(&report)
        }
        (None, Some(folder)) => {
            let lessons = args
                .lessons
                .iter()
                .map(|name| files.lesson(name))
                .collect::<Result<Vec<_>, _>>()?;
            pages::write(folder, lessons, args.page.as_deref(), &files)
        }
        (None, None) => {
            let rows = shipped().iter().map(|(name, text)| {
                let lesson = Lesson::parse(name, text)?;
                Ok(vec![
                    (*name).to_owned(),
                    format!("{} min", lesson.minutes),
                    lesson.title,
                    lesson.about,
                ])
            });
            show(&aligned(&rows.collect::<Result<Vec<_>, Failure>>()?, false))
        }
    }
}
