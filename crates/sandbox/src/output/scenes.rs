//! Scenes that a person made, as files.

use std::path::Path;
use std::sync::Arc;

use crate::app::session::Session;
use crate::failure::Failure;
use crate::output::files::{make_folder, write};

/// Writes the text of the scene of `session` into the file `path`: a new one, or one that still has the text that it
/// `replaces`. One that has the text already stays as it is.
pub(crate) fn save_scene(
    session: &mut Session,
    path: &Path,
    text: &Arc<str>,
    replaces: Option<&str>,
) -> Result<(), Failure> {
    let there = path.exists().then(|| scene::read_text(path)).transpose()?;
    match there.as_deref() {
        Some(present) if *present == **text => {}
        Some(present) if Some(present) != replaces => {
            let what = "there is another file of this name, or it was changed since it was opened; save under another name";
            return Err(Failure::Usage(format!("{}: {what}", path.display())));
        }
        _ => {
            make_folder(path.parent().unwrap_or(Path::new("")))?;
            write(path, text.as_bytes())?;
        }
    }
    session.saved_scene(path, text);
    Ok(())
}
