//! Printable pages of lessons; each lesson is played by its solution.

use std::path::Path;

use render::Quality;
use report::{Handout, HandoutStep, answers, handout as handout_page, index};
use scene::lesson::{Goal, Lesson, is_shipped, shipped};

use crate::args::cores;
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{make_folder, refuse_foreign_files, write as write_file};
use crate::output::pictures::Camera;
use crate::output::tell;
use cockpit::app::pictures::png;
use cockpit::app::pupil::{Pupil, Runs, frame_bodies};
use cockpit::stage::options::{Options, Words};

/// Size of a picture, pixels.
const SIZE: [u32; 2] = [960, 540];

/// Writes the pages of `lessons`, or of all in the program, the sheet of answers and the index into `folder`.
pub(super) fn write(
    folder: &Path,
    mut lessons: Vec<Lesson>,
    page: Option<&str>,
    files: &CommandFiles,
) -> Result<(), Failure> {
    if lessons.is_empty() {
        lessons = shipped()
            .iter()
            .map(|(name, text)| Lesson::parse(name, text))
            .collect::<Result<_, _>>()?;
    }
    let names: Vec<_> = lessons.iter().map(|lesson| file_stem(&lesson.name)).collect();
    if let Some((_, twice)) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name))
    {
        let what =
            format!("two lessons would have the page {}; rename the file of one", page_name(twice));
        return Err(Failure::Usage(what));
    }
    let is_of = |file: &str, name: &str| {
        file == page_name(name) || file.ends_with(".png") && file.starts_with(&format!("{name}-"))
    };
    let known = || names.iter().map(String::as_str).chain(shipped().iter().map(|(name, _)| *name));
    let is_page =
        |file: &str| [ANSWERS, INDEX].contains(&file) || known().any(|name| is_of(file, name));
    // An earlier sheet of answers begins as this one does.
    let sheet = answers(&[]);
    let head = sheet.split("</title>").next().unwrap_or_default();
    let earlier = std::fs::read_to_string(folder.join(ANSWERS)).unwrap_or_default();
    refuse_foreign_files(folder, earlier.starts_with(head), is_page, "give another folder")?;
    make_folder(folder)?;
    let mut camera = Camera::new(SIZE, Quality::HIGH)?;
    let (mut pages, mut written) = (Vec::new(), Vec::new());
    for (name, lesson) in names.iter().zip(&lessons) {
        let mut handout = played(lesson, name, &mut written, &mut camera)?;
        // A web page has the lessons of the program.
        let address = page.filter(|_| is_shipped(&lesson.name));
        handout.played_at = address.map(|page| format!("{page}#lesson={}", lesson.name));
        written.push((page_name(name), handout_page(&handout).into_bytes()));
        tell(&page_name(name));
        pages.push(handout);
    }
    written.push((INDEX.to_owned(), index(&pages, ANSWERS).into_bytes()));
    tell(INDEX);
    // First, because this file marks the folder as one that the program filled.
    written.insert(0, (ANSWERS.to_owned(), answers(&pages).into_bytes()));
    tell(ANSWERS);
    written
        .iter()
        .try_for_each(|(name, bytes)| write_file(&files.unread(&folder.join(name))?, bytes))
}

/// File name of the sheet of answers.
const ANSWERS: &str = "answers.html";
/// File name of the index of all pages.
const INDEX: &str = "index.html";

/// The start of the file names of a lesson: its name, or the stem of its file.
fn file_stem(lesson: &str) -> String {
    let stem = Path::new(lesson).file_stem();
    stem.map_or_else(|| lesson.to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// File name of the page of a lesson.
fn page_name(lesson: &str) -> String {
    format!("{lesson}.html")
}

/// Plays `lesson` and adds a picture of each step to what is written.
fn played(
    lesson: &Lesson,
    name: &str,
    written: &mut Vec<(String, Vec<u8>)>,
    camera: &mut Camera,
) -> Result<Handout, Failure> {
    let options =
        Options { size_px: SIZE, words: Words::Paper, threads: cores(), ..Options::default() };
    let mut pupil = Pupil::begin(lesson, &Runs::new(lesson, 1.0)?, options)?;
    frame_bodies(&mut pupil.session);
    let mut steps = Vec::new();
    for (number, step) in lesson.steps.iter().enumerate() {
        if !pupil.solve(lesson)? {
            let what = format!("{}: the solution of steps[{number}] is not accepted", lesson.name);
            return Err(Failure::Expectation(what));
        }
        let depends = matches!(step.goal, Goal::Done { .. });
        let picture = depends.then(|| format!("{name}-{}.png", number + 1));
        if let Some(picture) = &picture {
            let image = camera.picture(&mut pupil.session)?;
            written.push((picture.clone(), png(&image, &pupil.session.stage)));
        }
        let (choices, unit, answer) = match &step.goal {
            Goal::Done { .. } => (Vec::new(), None, None),
            Goal::Number { unit, solution, .. } => {
                (Vec::new(), Some(unit.clone()), Some(solution.clone()))
            }
            Goal::Choice { choices, solution } => (
                choices.iter().map(|choice| choice.say.clone()).collect(),
                None,
                Some(solution.clone()),
            ),
        };
        let measured =
            pupil.session.tools.lesson().and_then(|state| state.said).unwrap_or_default();
        let (task, watch) = (step.task.clone(), step.watch.clone());
        steps.push(HandoutStep { task, watch, choices, unit, picture, measured, depends, answer });
    }
    Ok(Handout {
        title: lesson.title.clone(),
        about: lesson.about.clone(),
        belongs_to: lesson.page.clone(),
        minutes: lesson.minutes,
        page: page_name(name),
        played_at: None,
        steps,
    })
}
