//! The file that remembers how the panels were arranged when the window was closed.

use std::fs;
use std::path::PathBuf;

use crate::output::files::write;

/// Longest file that is read, bytes: an arrangement has a few hundred.
const MOST: u64 = 4096;

/// Where it lies in the user's folder for settings.
fn path() -> Option<PathBuf> {
    Some(dirs::config_dir()?.join("inertia/window"))
}

/// What the last window left; nothing if there is no such file, or it cannot be read.
pub(super) fn read() -> String {
    let small = |path: &PathBuf| fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() <= MOST);
    path().filter(small).and_then(|path| fs::read_to_string(path).ok()).unwrap_or_default()
}

/// Writes it, whole or not at all. A failure is told and changes nothing: the next window starts as if none had been before.
pub(super) fn keep(arrangement: &str) {
    let Some(path) = path() else { return };
    let folder = path.parent().map_or(Ok(()), fs::create_dir_all);
    let written = folder.map_err(|error| error.to_string());
    let written =
        written.and_then(|()| write(&path, arrangement.as_bytes()).map_err(|failure| failure.to_string()));
    if let Err(error) = written {
        eprintln!("the arrangement of the panels is not remembered: {error}");
    }
}
