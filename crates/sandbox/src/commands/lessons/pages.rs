//! Pages of lessons, to be printed: each lesson is played by its solution.

use std::path::Path;

use render::Quality;
use report::{Handout, HandoutStep, answers, handout};
use scene::lesson::{Goal, Lesson, shipped};

use super::pupil::{Pupil, Runs, frame_bodies};
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::files::{make_folder, refuse_others_files, write as write_file};
use crate::output::pictures::{Camera, png};
use crate::output::tell;
use crate::stage::options::{Options, Words};

/// Size of a picture, pixels.
const SIZE: [u32; 2] = [960, 540];

/// Writes the pages of all lessons and the sheet of answers into `folder`.
pub(super) fn write(folder: &Path, files: &CommandFiles) -> Result<(), Failure> {
    let is_of = |file: &str, name: &str| {
        file == page_name(name) || file.ends_with(".png") && file.starts_with(&format!("{name}-"))
    };
    let is_page = |file: &str| file == ANSWERS || shipped().iter().any(|(name, _)| is_of(file, name));
    // An earlier sheet of answers begins as this one does.
    let sheet = answers(&[]);
    let head = sheet.split("</title>").next().unwrap_or_default();
    let earlier = std::fs::read_to_string(folder.join(ANSWERS)).unwrap_or_default();
    refuse_others_files(folder, earlier.starts_with(head), is_page, "give another folder")?;
    make_folder(folder)?;
    let mut camera = Camera::new(SIZE, Quality::HIGH)?;
    let (mut pages, mut written) = (Vec::new(), Vec::new());
    for (name, text) in shipped() {
        let lesson = Lesson::parse(name, text)?;
        let page = played(&lesson, &mut written, &mut camera)?;
        written.push((page_name(name), handout(&page).into_bytes()));
        tell(&page_name(name));
        pages.push(page);
    }
    // First: it tells the folder from one that a person filled.
    written.insert(0, (ANSWERS.to_owned(), answers(&pages).into_bytes()));
    tell(ANSWERS);
    written.iter().try_for_each(|(name, bytes)| write_file(&files.unread(&folder.join(name))?, bytes))
}

/// The sheet of answers.
const ANSWERS: &str = "answers.html";

/// The page of a lesson.
fn page_name(lesson: &str) -> String {
    format!("{lesson}.html")
}

/// Plays `lesson` and adds a picture of each step to what is written.
fn played(
    lesson: &Lesson,
    written: &mut Vec<(String, Vec<u8>)>,
    camera: &mut Camera,
) -> Result<Handout, Failure> {
    let options = Options { size_px: SIZE, words: Words::Labels, ..Options::default() };
    let mut pupil = Pupil::begin(lesson, &Runs::new(lesson, 1.0)?, options)?;
    frame_bodies(&mut pupil.session);
    let mut steps = Vec::new();
    for (number, step) in lesson.steps.iter().enumerate() {
        if !pupil.solve(lesson)? {
            let what = format!("{}: the solution of steps[{number}] is not accepted", lesson.name);
            return Err(Failure::Expectation(what));
        }
        let picture = format!("{}-{}.png", lesson.name, number + 1);
        let image = camera.picture(&mut pupil.session)?;
        written.push((picture.clone(), png(&image, &pupil.session.stage)));
        let (choices, unit, answer) = match &step.goal {
            Goal::Done { .. } => (Vec::new(), None, None),
            Goal::Number { unit, solution, .. } => (Vec::new(), Some(unit.clone()), Some(solution.clone())),
            Goal::Choice { choices, solution } => {
                (choices.iter().map(|(say, _)| say.clone()).collect(), None, Some(solution.clone()))
            }
        };
        let measured = pupil.session.tools.lesson().and_then(|state| state.said).unwrap_or_default();
        let (task, watch) = (step.task.clone(), step.watch.clone());
        steps.push(HandoutStep { task, watch, choices, unit, picture, measured, answer });
    }
    Ok(Handout {
        title: lesson.title.clone(),
        about: lesson.about.clone(),
        belongs_to: lesson.page.clone(),
        steps,
    })
}
