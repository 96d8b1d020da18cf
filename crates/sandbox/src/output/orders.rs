//! Carries out the orders of a session: pictures and files written, other scenes opened, the end.

use std::path::{Path, PathBuf};

use render::Image;

use crate::app::session::Session;
use crate::failure::Failure;
use crate::output::bundle::write_bundle;
use crate::output::files::write;
use crate::output::pictures::write_picture;
use crate::stage::{Order, SceneFile};

/// Start and end of the name of a file that a person did not name.
pub(crate) type Kind = [&'static str; 2];

pub(crate) const SCREENSHOT: Kind = ["screenshot", "png"];
pub(crate) const GRAPH: Kind = ["graph", "csv"];
pub(crate) const BUNDLE: Kind = ["bundle", "zip"];

/// The program around a session: a window, or a run without one.
pub(crate) trait Program {
    /// The picture of the session; `None` without a camera.
    fn picture(&mut self, session: &mut Session) -> Result<Option<Image>, Failure>;

    /// Folder of what it writes.
    fn folder(&self) -> &Path;

    /// Name in that folder of a file that a person did not name.
    fn name(&self, kind: Kind, session: &Session) -> String;

    /// Writes a scene into its file.
    fn save_scene(&mut self, session: &mut Session, file: &SceneFile) -> Result<(), Failure>;

    /// Hears which file was written, or why an order was not carried out. An error ends the program.
    fn report(&mut self, session: &mut Session, outcome: Result<&Path, Failure>) -> Result<(), Failure>;

    /// Hears that the session has another scene.
    fn opened(&mut self, session: &mut Session) -> Result<(), Failure>;

    /// Goes on with the unsaved changes in a file.
    fn restore(&mut self, _: &mut Session, _draft: &Path) {}

    /// Deletes the unsaved changes in a file.
    fn forget(&mut self, _draft: &Path) {}
}

/// Carries out `orders`: what is written of the present scene first. Returns whether the program is to end. A scene that could not
/// be saved is not left.
pub(crate) fn carry_out(
    mut orders: Vec<Order>,
    session: &mut Session,
    program: &mut dyn Program,
) -> Result<bool, Failure> {
    orders.sort_by_key(|order| matches!(order, Order::Open(_) | Order::Quit | Order::Restore(_)));
    let mut unsaved = false;
    for order in orders {
        match order {
            Order::Screenshot(name) => {
                let name = name.unwrap_or_else(|| program.name(SCREENSHOT, session));
                let path = program.folder().join(name);
                if let Some(image) = program.picture(session)? {
                    let written = write_picture(&image, &path, &session.stage);
                    program.report(session, written.map(|()| &*path))?;
                }
            }
            Order::Bundle => {
                let path = new_path(program, BUNDLE, session);
                let image = program.picture(session)?;
                let written = write_bundle(&path, &session.stage, image.as_ref());
                program.report(session, written.map(|()| &*path))?;
            }
            Order::Table(text) => {
                let path = new_path(program, GRAPH, session);
                let written = write(&path, text.as_bytes());
                program.report(session, written.map(|()| &*path))?;
            }
            Order::Scene(file) => {
                let written = program.save_scene(session, &file);
                unsaved |= written.is_err();
                program.report(session, written.map(|()| &*file.path))?;
            }
            Order::Forget(draft) => program.forget(&draft),
            Order::Restore(draft) => program.restore(session, &draft),
            Order::Open(_) | Order::Quit if unsaved => {}
            Order::Open(name) => match scene::load(&name) {
                Ok(scene) => {
                    session.open(scene);
                    program.opened(session)?;
                }
                Err(error) => program.report(session, Err(error.into()))?,
            },
            Order::Quit => return Ok(true),
        }
    }
    Ok(false)
}

fn new_path(program: &dyn Program, kind: Kind, session: &Session) -> PathBuf {
    program.folder().join(program.name(kind, session))
}
