//! Unsaved changes as files, so that a crash loses none: each window keeps one, and offers those of windows that are gone.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::output::files::write;

/// The unsaved changes of this window.
pub(super) struct Draft {
    folder: PathBuf,
    /// Is locked while this window is there.
    lock: (PathBuf, File),
    path: PathBuf,
    /// What the file has.
    written: Option<Arc<str>>,
}

impl Draft {
    /// Begins a draft in the user's folder for state; `None` where that cannot be written: nothing is kept then.
    pub fn begin() -> Option<Self> {
        let state = dirs::state_dir().or_else(dirs::data_local_dir)?;
        Self::begin_in(state.join("inertia/drafts"))
    }

    fn begin_in(folder: PathBuf) -> Option<Self> {
        fs::create_dir_all(&folder).ok()?;
        // The number of a process comes again: what an earlier one left behind is not its own.
        let name = |i: u32| folder.join(format!("{}-{i}.ron", std::process::id()));
        let path = (0..).map(name).find(|path| !path.exists())?;
        let lock = path.with_extension("lock");
        let file = File::create(&lock).ok()?;
        file.try_lock().ok()?;
        Some(Self { path, lock: (lock, file), folder, written: None })
    }

    /// Keeps these unsaved changes in place of those before; whether they are kept.
    pub fn keep(&mut self, unsaved: Option<&Arc<str>>) -> bool {
        let same = match (&self.written, unsaved) {
            (Some(written), Some(unsaved)) => Arc::ptr_eq(written, unsaved),
            (written, unsaved) => written.is_none() && unsaved.is_none(),
        };
        if same {
            return true;
        }
        // A full disk must not stop the window: what cannot be kept is still on the screen.
        let kept = match unsaved {
            Some(text) => write(&self.path, text.as_bytes()).map_err(drop),
            None => fs::remove_file(&self.path).map_err(drop),
        };
        if kept.is_ok() {
            self.written = unsaved.cloned();
        }
        kept.is_ok()
    }

    /// The drafts of windows that are gone, the newest first.
    pub fn left_behind(&self) -> Vec<PathBuf> {
        let files = fs::read_dir(&self.folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let drafts =
            files.filter(|path| path.extension().is_some_and(|end| end == "ron") && *path != self.path);
        let mut left: Vec<_> = drafts.filter(|path| is_left(path)).collect();
        left.sort_by_key(|path| fs::metadata(path).and_then(|file| file.modified()).ok());
        left.reverse();
        left
    }

    /// Ends the draft of a window that is closed.
    pub fn end(self) {
        drop(self.lock.1);
        let _ = fs::remove_file(self.lock.0);
    }
}

/// Whether the window of the draft is gone.
fn is_left(draft: &Path) -> bool {
    let Ok(lock) = File::open(draft.with_extension("lock")) else { return true };
    !matches!(lock.try_lock(), Err(TryLockError::WouldBlock))
}

/// Deletes a draft that was left behind.
pub(super) fn delete(draft: &Path) {
    let _ = fs::remove_file(draft);
    let _ = fs::remove_file(draft.with_extension("lock"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draft_is_there_while_changes_are_unsaved_and_is_offered_once_its_window_is_gone() {
        let folder = tempfile::tempdir().expect("a folder that can be written");
        let mut draft = Draft::begin_in(folder.path().to_owned()).expect("a folder that can be written");
        let text: Arc<str> = "(version: 1)".into();
        draft.keep(Some(&text));
        assert_eq!(fs::read_to_string(&draft.path).expect("a folder that can be written"), "(version: 1)");
        // Those of a window that is there are not offered to another one.
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
        draft.keep(None);
        assert!(!own.exists());
        draft.keep(Some(&text));
        let lock = draft.lock.0.clone();
        draft.end();
        assert!(own.exists() && !lock.exists());
    }
}
