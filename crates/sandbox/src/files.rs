//! Output files that are whole or absent: written beside their place, then renamed into it.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use crate::failure::Failure;

/// Files that are not finished, and that nobody would look for.
static BEGUN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn begun() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    BEGUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a shell takes for a program that was interrupted: 128 and the number of the signal.
const INTERRUPTED: i32 = 130;

/// Lets an interrupt leave no file that is not finished.
pub(crate) fn leave_nothing_when_interrupted() {
    let clear = || {
        for path in &*begun() {
            let _ = fs::remove_file(path);
        }
        process::exit(INTERRUPTED);
    };
    // Where interrupts are ignored, as in the background of a script, they stay so.
    let _ = ctrlc::try_set_handler(clear);
}

/// A file that is not finished.
struct Begun(PathBuf);

impl Begun {
    fn new(file: &NamedTempFile) -> Self {
        begun().insert(file.path().to_owned());
        Self(file.path().to_owned())
    }
}

impl Drop for Begun {
    fn drop(&mut self) {
        begun().remove(&self.0);
    }
}

/// A file that appears under its name when it is finished.
pub struct Output {
    writer: Writer,
}

enum Writer {
    /// Renamed to `path` at the end.
    Beside { path: PathBuf, file: BufWriter<NamedTempFile>, begun: Begun },
    /// Devices and pipes such as `/dev/stdout`: renaming over one would destroy it.
    Straight(BufWriter<File>),
}

impl Output {
    /// Starts the file `path` in a folder that exists.
    ///
    /// # Errors
    /// A folder that is missing or not writable; a `path` that is a folder itself.
    pub fn create(path: &Path) -> io::Result<Self> {
        if path.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        if fs::metadata(path).is_ok_and(|there| !there.is_file()) {
            let file = File::options().write(true).open(path)?;
            return Ok(Self { writer: Writer::Straight(BufWriter::new(file)) });
        }
        // A link stays a link: what it leads to is replaced.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let file = tempfile::Builder::new().prefix(".sandbox-").tempfile_in(folder)?;
        let begun = Begun::new(&file);
        Ok(Self { writer: Writer::Beside { path, file: BufWriter::new(file), begun } })
    }

    /// Writes the rest, and puts the file in its place.
    ///
    /// # Errors
    /// As [`Self::finish`].
    pub fn finish_with(mut self, rest: &[u8]) -> io::Result<()> {
        self.write_all(rest)?;
        self.finish()
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// A full disk, or a place that cannot be renamed into; nothing is left behind.
    pub fn finish(self) -> io::Result<()> {
        let (path, file, begun) = match self.writer {
            Writer::Beside { path, file, begun } => (path, file, begun),
            Writer::Straight(mut file) => return file.flush(),
        };
        let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.as_file().sync_all()?;
        // Temporary files are private; an output is not.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            file.as_file().set_permissions(fs::Permissions::from_mode(0o644))?;
        }
        file.persist(path).map_err(|error| error.error)?;
        drop(begun);
        Ok(())
    }
}

/// Starts an output file, and makes its folder.
pub(crate) fn output_file(path: &Path) -> Result<Output, Failure> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|error| Failure::file("make the folder", folder, &error))?;
    }
    Output::create(path).map_err(|error| Failure::file("write", path, &error))
}

/// Writes a whole file.
///
/// # Errors
/// As [`Output`].
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let written = Output::create(path).and_then(|file| file.finish_with(bytes));
    written.map_err(|error| Failure::file("write", path, &error))
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.writer {
            Writer::Beside { file, .. } => file.write(bytes),
            Writer::Straight(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.writer {
            Writer::Beside { file, .. } => file.flush(),
            Writer::Straight(file) => file.flush(),
        }
    }
}
