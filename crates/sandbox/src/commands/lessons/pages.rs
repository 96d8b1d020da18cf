//! Pages of lessons, to be printed: each lesson is played by its solution.

use std::path::Path;

use render::Quality;
use report::{Handout, HandoutStep, answers, handout};
use scene::lesson::{Goal, Lesson, shipped};

use super::pupil::{Pupil, Runs, frame_bodies};
use crate::failure::Failure;
use crate::output::files::{make_folder, write as write_file};
use crate::output::pictures::{Camera, write_picture};
use crate::output::tell;
use crate::stage::options::{Options, Words};

/// Size of a picture, pixels.
const SIZE: [u32; 2] = [960, 540];

/// Writes the pages of all lessons and the sheet of answers into `folder`.
pub(super) fn write(folder: &Path) -> Result<(), Failure> {
    make_folder(folder)?;
    let mut camera = Camera::new(SIZE, Quality::HIGH)?;
    let mut pages = Vec::new();
    for (name, text) in shipped() {
        let lesson = Lesson::parse(name, text)?;
        let page = played(&lesson, folder, &mut camera)?;
        write_file(&folder.join(format!("{name}.html")), handout(&page).as_bytes())?;
        tell(&format!("{name}.html"));
        pages.push(page);
    }
    write_file(&folder.join("answers.html"), answers(&pages).as_bytes())?;
    tell("answers.html");
    Ok(())
}

/// Plays `lesson` and writes a picture of each step.
fn played(lesson: &Lesson, folder: &Path, camera: &mut Camera) -> Result<Handout, Failure> {
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
        write_picture(&image, &folder.join(&picture), &pupil.session.stage)?;
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
