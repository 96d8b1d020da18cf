//! The files that remember, from window to window, how the panels were arranged and which scene files were opened last.

use std::fs;
use std::path::{PathBuf, absolute};

use scene::lesson::Lesson;

use crate::output::files::{OutputPath, write};
use cockpit::app::arrangement::{self, FIRST_START};

/// Longest file that is read, bytes: an arrangement has a few hundred.
const MOST: u64 = 65_536;

/// Greatest number of scene files that are remembered.
const MOST_FILES: usize = 12;

/// Name of the file with the arrangement of the panels.
pub(super) const ARRANGEMENT: &str = "window";

/// Name of the file with the scene files, one per line, the newest last.
const FILES: &str = "files";

/// Path of the file of that name in the user's folder for settings.
fn path(name: &str) -> Option<PathBuf> {
    Some(dirs::config_dir()?.join("inertia").join(name))
}

/// The files in that folder that a window reads and writes.
pub(super) fn paths() -> impl Iterator<Item = PathBuf> {
    [ARRANGEMENT, FILES].into_iter().filter_map(path)
}

/// The text that the last window left under that name; empty if there is no such file, or if it cannot be read.
pub(super) fn read(name: &str) -> String {
    let small =
        |path: &PathBuf| fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() <= MOST);
    path(name).filter(small).and_then(|path| fs::read_to_string(path).ok()).unwrap_or_default()
}

/// Whether no window has shown the welcome card yet.
pub(super) fn is_first() -> bool {
    let waits = || read(ARRANGEMENT).contains(FIRST_START);
    path(ARRANGEMENT).is_some_and(|path| !path.exists() || waits())
}

/// Records whether the welcome card has been shown, however this window ends.
pub(super) fn note_first(shown: bool) {
    let others = read(ARRANGEMENT).replace(FIRST_START, "");
    keep(ARRANGEMENT, &if shown { others } else { others + FIRST_START });
}

/// Remembers the lines of the arrangement that changed from `before` to `now`; another window may have remembered other lines.
pub(super) fn keep_arrangement(before: &str, now: &str) {
    let there = read(ARRANGEMENT);
    let all = arrangement::with_changes(&there, before, now);
    if all != there {
        keep(ARRANGEMENT, &all);
    }
}

/// Writes the file of that name, whole or not at all. A failure is told and changes nothing: the next window starts as if this
/// one had not been.
pub(super) fn keep(name: &str, text: &str) {
    let Some(path) = path(name) else { return };
    let folder = path.parent().map_or(Ok(()), fs::create_dir_all);
    let written = folder.map_err(|error| error.to_string());
    let written = written.and_then(|()| {
        write(&OutputPath::of_program(&path), text.as_bytes())
            .map_err(|failure| failure.to_string())
    });
    if let Err(error) = written {
        eprintln!("{} is not written: {error}", path.display());
    }
}

/// The files of lessons in the person's own folder, by their names, and the title of each.
pub(super) fn lessons() -> Vec<(PathBuf, String)> {
    let folder = dirs::data_dir().map(|data| data.join("inertia/lessons"));
    let entries = folder.and_then(|folder| fs::read_dir(folder).ok());
    let paths = entries.into_iter().flatten().flatten().map(|entry| entry.path());
    let mut lessons: Vec<_> = paths
        .filter(|path| path.extension().is_some_and(|end| end == "ron") && path.is_file())
        .collect();
    lessons.sort();
    let titled = |path: PathBuf| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let lesson =
            fs::read_to_string(&path).ok().and_then(|text| Lesson::parse(&name, &text).ok());
        (path, lesson.map_or(name, |lesson| lesson.title))
    };
    lessons.into_iter().map(titled).collect()
}

/// The scene files of earlier windows that are still there, the newest last.
pub(super) fn files() -> Vec<PathBuf> {
    read(FILES).lines().map(PathBuf::from).filter(|path| path.is_file()).collect()
}

/// Remembers the files that are new in `files`, the newest last, compared with `before`; another window may have remembered
/// others.
pub(super) fn keep_files(before: &[PathBuf], files: &[PathBuf]) {
    let all = with_new(self::files(), before, files);
    let newest = &all[all.len().saturating_sub(MOST_FILES)..];
    let lines: Vec<_> = newest
        .iter()
        .filter_map(|path| path.to_str())
        .filter(|path| !path.contains('\n'))
        .collect();
    keep(FILES, &lines.join("\n"));
}

fn with_new(mut all: Vec<PathBuf>, before: &[PathBuf], files: &[PathBuf]) -> Vec<PathBuf> {
    for path in files.iter().filter(|path| !before.contains(path) || files.last() == Some(path)) {
        let Ok(path) = absolute(path) else { continue };
        all.retain(|other| *other != path);
        all.push(path);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_window_remembered_meanwhile_stays() {
        let paths = |names: &[&str]| -> Vec<_> { names.iter().map(PathBuf::from).collect() };
        let all = |there, before, files| with_new(paths(there), &paths(before), &paths(files));
        // One that is new, and one that is opened again.
        assert_eq!(all(&["/a", "/other"], &["/a"], &["/a", "/b"]), paths(&["/a", "/other", "/b"]));
        assert_eq!(
            all(&["/a", "/b", "/other"], &["/a", "/b"], &["/b", "/a"]),
            paths(&["/b", "/other", "/a"])
        );
    }
}
