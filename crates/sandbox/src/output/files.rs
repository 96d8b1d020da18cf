//! Output files that are whole or absent: written beside their place, then renamed into it.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use crate::failure::Failure;

/// Files that are not finished, and that no person would look for.
static BEGUN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn begun() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    BEGUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Lets an interrupt, a hang-up and a request to end leave no file that is not finished.
pub(crate) fn leave_nothing_when_ended() {
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        use signal_hook::iterator::Signals;
        // Ignored signals stay ignored: hang-ups under `nohup`, interrupts in the background of a script.
        let signals = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| !is_ignored(*signal));
        if let Ok(mut signals) = Signals::new(signals) {
            std::thread::spawn(move || signals.forever().next().map(end_by));
        }
    }
    #[cfg(not(unix))]
    let _ = ctrlc::try_set_handler(|| end_by(2));
}

/// Removes what is not finished, and ends as a shell expects of a program that a signal ended.
fn end_by(signal: i32) {
    // Nothing is begun from here on: this lock is held until the process ends.
    let begun = begun();
    for path in &*begun {
        let _ = fs::remove_file(path);
    }
    process::exit(128 + signal);
}

/// Whether the program was started with that signal ignored.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let mut now = std::mem::MaybeUninit::<libc::sigaction>::uninit();
    #[expect(
        unsafe_code,
        reason = "no library asks without changing it; where there is no new action nothing changes"
    )]
    unsafe {
        libc::sigaction(signal, std::ptr::null(), now.as_mut_ptr()) == 0
            && now.assume_init().sa_sigaction == libc::SIG_IGN
    }
}

/// A file that is not finished.
struct Begun(PathBuf);

impl Begun {
    fn in_folder(folder: &Path) -> io::Result<(NamedTempFile, Self)> {
        let mut begun = begun();
        let file = tempfile::Builder::new().prefix(".sandbox-").tempfile_in(folder)?;
        begun.insert(file.path().to_owned());
        let path = file.path().to_owned();
        Ok((file, Self(path)))
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
        let (file, begun) = Begun::in_folder(folder)?;
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

/// Makes the folder of an output where it is missing, and says so.
pub(crate) fn make_folder(folder: &Path) -> Result<(), Failure> {
    if folder.as_os_str().is_empty() || folder.is_dir() {
        return Ok(());
    }
    fs::create_dir_all(folder).map_err(|error| Failure::file("make the folder", folder, &error))?;
    eprintln!("made the folder {}", folder.display());
    Ok(())
}

/// Starts an output file, and makes its folder.
pub(crate) fn output_file(path: &Path) -> Result<Output, Failure> {
    make_folder(path.parent().unwrap_or(Path::new("")))?;
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
