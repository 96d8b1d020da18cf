//! Scenes that a person made, as files.

use std::path::Path;

use crate::app::session::Session;
use crate::failure::Failure;
use crate::output::files::{make_folder, write};
use crate::view::stage::SceneFile;

/// Writes a scene of `session` into its file. A file that has the text already stays as it is; another one that is neither new
/// nor what was opened is never replaced.
pub(crate) fn save_scene(session: &mut Session, file: &SceneFile) -> Result<(), Failure> {
    let SceneFile { path, text, replaces, .. } = file;
    let there = path.exists().then(|| scene::read_text(path)).transpose()?;
    match there.as_deref() {
        Some(present) if *present == **text => {}
        Some(present) if Some(present) != replaces.as_deref() => {
            let what =
                "a file of this name exists, or it was changed since it was opened; save under another name";
            return Err(Failure::Usage(format!("{}: {what}", path.display())));
        }
        _ => {
            make_folder(path.parent().unwrap_or(Path::new("")))?;
            write(path, text.as_bytes())?;
        }
    }
    session.saved_scene(file);
    Ok(())
}
