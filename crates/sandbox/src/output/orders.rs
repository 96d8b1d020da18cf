//! Carries out the orders of a session: pictures and files written, other scenes opened, the end.

use std::path::Path;

use lab::lesson::{RunLimit, run_lesson};
use render::Image;
use scene::lesson::beside;

use crate::failure::Failure;
use crate::output::bundle::write_bundle;
use crate::output::command_files::CommandFiles;
use crate::output::files::{OutputPath, write};
use crate::output::pictures::write_picture;
use cockpit::app::session::Session;
use cockpit::stage::{Order, SceneFile};

/// Start and end of the name of a file that a person did not name.
pub(crate) type Kind = [&'static str; 2];

pub(crate) const SCREENSHOT: Kind = ["screenshot", "png"];
pub(crate) const GRAPH: Kind = ["graph", "csv"];
pub(crate) const BUNDLE: Kind = ["bundle", "zip"];

/// The program around a session: a window, or a run without one.
pub(crate) trait Program {
    /// The picture of the session; `None` without a camera.
    fn picture(&mut self, session: &mut Session) -> Result<Option<Image>, Failure>;

    /// Folder for the files that the program writes; `None` if it writes nothing.
    fn folder(&self) -> Option<&Path>;

    /// The files that the program has read.
    fn files(&mut self) -> &mut CommandFiles;

    /// Called if a file was not written because there is no folder.
    fn left_out(&self, _: Kind) {}

    /// Name in the folder for a file that a person did not name.
    fn name(&self, kind: Kind, session: &Session) -> String;

    /// Writes a scene into its file.
    fn save_scene(&mut self, session: &mut Session, file: &SceneFile) -> Result<(), Failure>;

    /// Called with the file that was written, or with the reason why an order was not carried out. An error ends the program.
    fn report(
        &mut self,
        session: &mut Session,
        outcome: Result<&Path, Failure>,
    ) -> Result<(), Failure>;

    /// Called after the session has opened another scene.
    fn opened(&mut self, session: &mut Session) -> Result<(), Failure>;

    /// Restores the unsaved changes in a file.
    fn restore(&mut self, _: &mut Session, _draft: &Path) {}

    /// Deletes the unsaved changes in a file.
    fn forget(&mut self, _draft: &Path) {}
}

/// Carries out `orders`, those that leave the scene last. Returns whether the program is to end. Neither opens another scene nor
/// ends if the scene could not be saved.
pub(crate) fn carry_out(
    mut orders: Vec<Order>,
    session: &mut Session,
    program: &mut dyn Program,
) -> Result<bool, Failure> {
    orders.sort_by_key(|order| order.leaves_scene());
    let mut unsaved = false;
    for order in orders {
        match order {
            Order::Screenshot(name) => {
                if let Some(path) = output_path(program, SCREENSHOT, name, session)?
                    && let Some(image) = program.picture(session)?
                {
                    let written = write_picture(&image, &path, &session.stage);
                    program.report(session, written.map(|()| path.as_ref()))?;
                }
            }
            Order::Bundle => {
                let Some(path) = output_path(program, BUNDLE, None, session)? else { continue };
                let image = program.picture(session)?;
                let written = write_bundle(&path, &session.stage, image.as_ref());
                program.report(session, written.map(|()| path.as_ref()))?;
            }
            Order::Table(text) => {
                let Some(path) = output_path(program, GRAPH, None, session)? else { continue };
                let written = write(&path, text.as_bytes());
                program.report(session, written.map(|()| path.as_ref()))?;
            }
            Order::Scene(file) => {
                let written = program.save_scene(session, &file);
                unsaved |= written.is_err();
                program.report(session, written.map(|()| &*file.path))?;
            }
            Order::Forget(draft) => program.forget(&draft),
            Order::Restore(draft) => program.restore(session, &draft),
            Order::Open(_) | Order::Lesson(_) | Order::Quit if unsaved => {}
            Order::Open(name) => {
                let opened = open(&name, session, program.files());
                told(opened, session, program)?;
            }
            Order::Lesson(name) => {
                let opened = open_lesson(&name, RunLimit::USUAL, session, program.files());
                told(opened, session, program)?;
            }
            Order::Quit => return Ok(true),
        }
    }
    Ok(false)
}

/// Tells `program` whether another scene was opened.
fn told(
    opened: Result<(), Failure>,
    session: &mut Session,
    program: &mut dyn Program,
) -> Result<(), Failure> {
    match opened {
        Ok(()) => program.opened(session),
        Err(failure) => program.report(session, Err(failure)),
    }
}

/// The runs of a lesson whose file is opened in a window.
const WHILE_A_WINDOW_WAITS: RunLimit =
    RunLimit { seconds: 5.0, cure: "`sandbox --lesson FILE` waits longer for them" };

/// Opens a scene, or a lesson with its scene, by the name of a scene in the program or the path of a file.
fn open(name: &str, session: &mut Session, files: &mut CommandFiles) -> Result<(), Failure> {
    let path = Path::new(name);
    if scene::embedded(name).is_some() || !scene::lesson::is_file(path) {
        session.open(files.scene(name)?);
        return Ok(());
    }
    open_lesson(name, WHILE_A_WINDOW_WAITS, session, files)?;
    session.stage.files.note(path);
    Ok(())
}

/// Opens a lesson with its scene.
fn open_lesson(
    name: &str,
    limit: RunLimit,
    session: &mut Session,
    files: &mut CommandFiles,
) -> Result<(), Failure> {
    let lesson = files.lesson(name)?;
    let scene = files.scene(&beside(&lesson.name, &lesson.scene))?;
    let of_runs = run_lesson(&lesson, 1.0, limit)?;
    session.open(scene);
    session.begin_lesson(lesson, of_runs);
    Ok(())
}

/// The path for a file of that kind, called `name` if the person gave one; `None` if nothing is written.
fn output_path(
    program: &mut dyn Program,
    kind: Kind,
    name: Option<String>,
    session: &mut Session,
) -> Result<Option<OutputPath>, Failure> {
    let Some(folder) = program.folder() else {
        program.left_out(kind);
        return Ok(None);
    };
    let path = folder.join(name.unwrap_or_else(|| program.name(kind, session)));
    match program.files().unread(&path) {
        Ok(path) => Ok(Some(path)),
        Err(failure) => program.report(session, Err(failure)).map(|()| None),
    }
}
