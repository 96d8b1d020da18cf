//! Unsaved changes as files, so that a crash loses none: each window keeps one, and offers those of windows that are gone.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::failure::Failure;
use crate::output::files::{OutputPath, claim, sweep, write};
use cockpit::app::session::Session;
use cockpit::stage::notices::Topic;

/// A scene file, and its text when it was opened or saved last.
type OwnFile = (PathBuf, Arc<str>);

/// Extension of the file beside a draft that has the path of the scene file in its first line, and its text when it was opened or
/// saved last.
const FILE: &str = "file";

/// The unsaved changes of this window.
pub(super) struct Drafts {
    /// The draft of this window, or why it has none; `None` if it keeps none.
    own: Option<Result<Draft, Failure>>,
    /// Whether a person was told that changes are not kept.
    told: bool,
}

/// A file with unsaved changes.
struct Draft {
    folder: PathBuf,
    /// Locked as long as this window is open.
    lock: (PathBuf, File),
    path: PathBuf,
    /// The text that the file has.
    written: Option<Arc<str>>,
}

impl Drafts {
    /// Begins a draft in the user's folder for state.
    pub fn begin() -> Self {
        let state = dirs::state_dir().or_else(dirs::data_local_dir);
        let no_folder = || Failure::Usage("there is no home folder; set XDG_STATE_HOME".to_owned());
        let own = state.ok_or_else(no_folder).and_then(|state| {
            let folder = state.join("inertia/drafts");
            Draft::begin(&folder).map_err(|error| Failure::file("write into", &folder, &error))
        });
        Self { own: Some(own), told: false }
    }

    /// Keeps no draft, because the next user is another person.
    pub const fn none() -> Self {
        Self { own: None, told: false }
    }

    /// Keeps the unsaved changes of `session` in case of a crash, instead of earlier ones. Returns whether they are kept.
    pub fn keep(&mut self, session: &mut Session) -> bool {
        let unsaved = session.unsaved();
        let file = unsaved.as_ref().and_then(|_| session.tools.own_file());
        self.keep_text(unsaved.as_ref(), file.as_ref(), |words| {
            session.stage.notices.say(Topic::FileError, words);
        })
    }

    /// Calls `tell` once, with the reason, if changes are not kept.
    fn keep_text(
        &mut self,
        unsaved: Option<&Arc<str>>,
        file: Option<&OwnFile>,
        tell: impl FnOnce(String),
    ) -> bool {
        let kept = match &mut self.own {
            Some(Ok(draft)) => draft.keep(unsaved, file).map_err(|failure| failure.to_string()),
            Some(Err(failure)) if unsaved.is_some() => Err(failure.to_string()),
            Some(Err(_)) | None => Ok(()),
        };
        if let (Err(why), false) = (&kept, self.told) {
            self.told = true;
            tell(format!("a crash would lose your unsaved changes: {why}"));
        }
        kept.is_ok()
    }

    /// The drafts of windows that are gone, the newest first.
    pub fn left_behind(&self) -> Vec<PathBuf> {
        self.own.iter().flatten().flat_map(Draft::left_behind).collect()
    }

    /// Ends the draft of a window that is closed.
    pub fn end(self) {
        if let Some(Ok(Draft { lock: (path, file), .. })) = self.own {
            drop(file);
            let _ = fs::remove_file(path);
        }
    }
}

impl Draft {
    fn begin(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        // Files of windows that were killed without unsaved changes.
        sweep(folder, |path| {
            (is(path, "lock") || is(path, FILE)) && !path.with_extension("ron").exists()
        });
        // Process ids come again: a draft that an earlier process left behind is not this window's.
        for path in (0..).map(|i: u32| folder.join(format!("{}-{i}.ron", std::process::id()))) {
            let lock = path.with_extension("lock");
            // Only files are opened: a pipe would wait for its other end.
            let is_free = lock.symlink_metadata().map_or(true, |there| there.is_file());
            if !path.exists() && is_free {
                // Nothing is written, and what a link leads to stays as it is.
                let file = File::options().write(true).create(true).truncate(false).open(&lock)?;
                if claim(&file, &lock) {
                    return Ok(Self {
                        path,
                        lock: (lock, file),
                        folder: folder.to_owned(),
                        written: None,
                    });
                }
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    fn keep(&mut self, unsaved: Option<&Arc<str>>, file: Option<&OwnFile>) -> Result<(), Failure> {
        if self.written.as_ref().map(Arc::as_ptr) != unsaved.map(Arc::as_ptr) {
            match unsaved {
                Some(text) => {
                    match file {
                        Some((file, had)) => {
                            let note = format!("{}\n{had}", file.display());
                            write(
                                &OutputPath::of_program(&self.path.with_extension(FILE)),
                                note.as_bytes(),
                            )?;
                        }
                        None => drop(fs::remove_file(self.path.with_extension(FILE))),
                    }
                    write(&OutputPath::of_program(&self.path), text.as_bytes())?;
                }
                None => {
                    drop(fs::remove_file(self.path.with_extension(FILE)));
                    fs::remove_file(&self.path)
                        .map_err(|error| Failure::file("remove", &self.path, &error))?;
                }
            }
            self.written = unsaved.cloned();
        }
        Ok(())
    }

    fn left_behind(&self) -> Vec<PathBuf> {
        let files =
            fs::read_dir(&self.folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut left: Vec<_> =
            files.filter(|path| is(path, "ron") && *path != self.path && is_left(path)).collect();
        left.sort_by_key(|path| fs::metadata(path).and_then(|file| file.modified()).ok());
        left.reverse();
        left
    }
}

fn is(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|end| end == extension)
}

/// Whether the window of the draft is gone.
fn is_left(draft: &Path) -> bool {
    let path = draft.with_extension("lock");
    // Opening a pipe would wait for its other end.
    if !path.is_file() {
        return true;
    }
    let Ok(lock) = File::open(path) else { return true };
    !matches!(lock.try_lock(), Err(TryLockError::WouldBlock))
}

/// The scene file that the changes of a draft were made in.
pub(super) fn file_of(draft: &Path) -> Option<OwnFile> {
    let note = fs::read_to_string(draft.with_extension(FILE)).ok()?;
    let (file, had) = note.split_once('\n')?;
    Some((PathBuf::from(file), had.into()))
}

/// Deletes a draft that was left behind.
pub(super) fn delete(draft: &Path) {
    let _ = fs::remove_file(draft);
    let _ = fs::remove_file(draft.with_extension(FILE));
    let _ = fs::remove_file(draft.with_extension("lock"));
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, SystemTime};

    use super::*;

    fn begin(folder: &Path) -> Draft {
        Draft::begin(folder).expect("a folder that can be written")
    }

    #[test]
    fn a_draft_is_there_while_changes_are_unsaved_and_is_offered_once_its_window_is_gone() {
        let folder = tempfile::tempdir().expect("a folder that can be written");
        let mut draft = begin(folder.path());
        let text: Arc<str> = "(version: 1)".into();
        draft.keep(Some(&text), None).expect("a folder that can be written");
        assert_eq!(
            fs::read_to_string(&draft.path).expect("a folder that can be written"),
            "(version: 1)"
        );
        // The draft of an open window is not offered to another one.
        let own = draft.path.clone();
        let (other, its_lock) = (folder.path().join("1.ron"), folder.path().join("1.lock"));
        fs::write(&other, "other").expect("a folder that can be written");
        let held = File::create(&its_lock).expect("a folder that can be written");
        held.try_lock().expect("a folder that can be written");
        assert_eq!(draft.left_behind(), [] as [PathBuf; 0]);
        drop(held);
        assert_eq!(draft.left_behind(), std::slice::from_ref(&other));
        delete(&other);
        assert!(draft.left_behind().is_empty() && !its_lock.exists());
        draft.keep(None, None).expect("it was there");
        assert!(!own.exists());
        draft.keep(Some(&text), None).expect("a folder that can be written");
        let lock = draft.lock.0.clone();
        Drafts { own: Some(Ok(draft)), told: false }.end();
        assert!(own.exists() && !lock.exists());
    }

    #[test]
    fn a_draft_remembers_the_file_that_its_changes_were_made_in() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut draft = begin(folder.path());
        let file: OwnFile = (PathBuf::from("scenes/mine.ron"), "(version: 1)\n// kept\n".into());
        let keep = |draft: &mut Draft, text: &str, file| {
            draft.keep(Some(&text.into()), file).expect("a folder");
        };
        keep(&mut draft, "a", Some(&file));
        assert_eq!(file_of(&draft.path).as_ref(), Some(&file));
        keep(&mut draft, "b", None);
        assert_eq!(file_of(&draft.path), None, "it is another scene");
        draft.keep(None, None).expect("it was there");
        assert!(!draft.path.with_extension(FILE).exists());
    }

    #[test]
    fn the_newest_draft_is_offered_first() {
        let folder = tempfile::tempdir().expect("a folder that can be written");
        let draft = begin(folder.path());
        let now = SystemTime::now();
        // Neither in the order of their names nor in that of their making.
        for (name, age_s) in [("2", 30), ("3", 10), ("1", 20)] {
            let file =
                File::create(folder.path().join(name).with_extension("ron")).expect("a folder");
            file.set_modified(now - Duration::from_secs(age_s)).expect("a file of its own");
        }
        let names: Vec<_> = draft
            .left_behind()
            .into_iter()
            .filter_map(|path| path.file_stem()?.to_str()?.parse::<u32>().ok())
            .collect();
        assert_eq!(names, [3, 1, 2]);
    }

    #[test]
    fn locks_without_drafts_are_swept_and_those_of_windows_that_are_there_stay() {
        let folder = tempfile::tempdir().expect("a folder that can be written");
        for name in ["1.lock", "2.lock", "2.ron"] {
            File::create(folder.path().join(name)).expect("a folder that can be written");
        }
        let first = begin(folder.path());
        let second = begin(folder.path());
        let there = |name: &str| folder.path().join(name).exists();
        assert_eq!(["1.lock", "2.lock", "2.ron"].map(there), [false, true, true]);
        assert!(first.lock.0.exists() && first.lock.0 != second.lock.0);
        assert_eq!(first.left_behind(), [folder.path().join("2.ron")]);
    }

    #[test]
    #[cfg(unix)]
    fn a_pipe_among_the_drafts_blocks_no_start() {
        let folder = tempfile::tempdir().expect("a folder that can be written");
        let pipe = |name: &str| {
            let made = std::process::Command::new("mkfifo").arg(folder.path().join(name)).status();
            assert!(made.is_ok_and(|made| made.success()));
        };
        pipe("1.lock");
        pipe(&format!("{}-0.lock", std::process::id()));
        fs::write(folder.path().join("1.ron"), "(version: 1)")
            .expect("a folder that can be written");
        let draft = begin(folder.path());
        assert_eq!(draft.left_behind(), [folder.path().join("1.ron")]);
    }

    #[test]
    fn changes_that_cannot_be_kept_are_told_once() {
        let folder = tempfile::tempdir().expect("a folder that can be written");
        let [first, second]: [Arc<str>; 2] = ["(version: 1)".into(), "(version: 1, )".into()];
        let file = folder.path().join("file");
        fs::write(&file, "").expect("a folder that can be written");
        let own =
            Some(Draft::begin(&file).map_err(|error| Failure::file("write into", &file, &error)));
        let mut none = Drafts { own, told: false };
        let mut gone = Drafts { own: Some(Ok(begin(&folder.path().join("gone")))), told: false };
        fs::remove_dir_all(folder.path().join("gone")).expect("a folder of its own");
        for drafts in [&mut none, &mut gone] {
            let mut told = Vec::new();
            assert!(
                drafts.keep_text(None, None, |words| told.push(words)),
                "there is nothing to keep"
            );
            assert_eq!(told, [] as [String; 0]);
            for text in [&first, &first, &second] {
                assert!(!drafts.keep_text(Some(text), None, |words| told.push(words)));
            }
            let [words] = &told[..] else { panic!("{told:?}") };
            assert!(
                words.starts_with("a crash would lose your unsaved changes: cannot write "),
                "{words}"
            );
        }
    }
}
