//! Output files that are whole or absent: written beside their place, then renamed into it.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::fs::{self, File, Metadata, Permissions, TryLockError};
use std::io::{self, BufWriter, IsTerminal as _, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::mpsc::channel;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::de::DeserializeOwned;
use tempfile::NamedTempFile;
use xxhash_rust::xxh3::xxh3_64;

use crate::failure::Failure;

/// Unfinished files: [`end`] removes them, because no person would look for them.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// What a signal says when it ends the process.
static LAST_WORDS: Mutex<String> = Mutex::new(String::new());

/// How an interrupted study continues, with the option that continues it.
pub(crate) fn how_to_continue(option: &str) -> String {
    format!("what was run is in that folder, and the same command with {option} continues after it")
}

/// Makes an interrupt, a hang-up and a request to end say how the study in `folder` continues.
pub(crate) fn say_how_to_continue(folder: &Path, cure: &str) {
    let words = format!("{}: {cure}", folder.display());
    *LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner) = words;
}

/// Longest time for which the end of the process waits for standard error, which may be a full pipe.
const LAST_WORDS_TAKE: Duration = Duration::from_millis(100);

/// Ends the process for a signal.
fn end_by_signal(code: i32) -> ! {
    let _held = remove_unfinished();
    let words = LAST_WORDS.try_lock().map_or_else(|_| String::new(), |words| words.clone());
    if !words.is_empty() {
        let (done, written) = channel();
        let say = move || {
            // A bar may stand in the line.
            let start = if io::stderr().is_terminal() { "\r\x1b[K" } else { "" };
            let said = writeln!(io::stderr(), "{start}{}", report::terminal(&words));
            let _ = done.send(said);
        };
        let _ = std::thread::Builder::new().spawn(say);
        let _ = written.recv_timeout(LAST_WORDS_TAKE);
    }
    exit(code)
}

/// Makes them say nothing: a study is complete.
pub(crate) fn nothing_to_continue() {
    LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner).clear();
}

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes an interrupt, a hang-up and a request to end remove unfinished files.
pub(crate) fn remove_unfinished_files_on_signals() {
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        use signal_hook::iterator::Signals;
        ignore_large_files();
        // Ignored signals stay ignored: hang-ups under `nohup`, interrupts in the background of a script.
        let signals = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| !is_ignored(*signal));
        if let Ok(mut signals) = Signals::new(signals) {
            // Shells expect this code of a program that a signal ended.
            let wait = move || signals.forever().next().map(|signal| end_by_signal(128 + signal));
            // Without it, a signal ends the program at once.
            let _ = std::thread::Builder::new().spawn(wait);
        }
    }
    #[cfg(not(unix))]
    let _ = ctrlc::try_set_handler(|| end_by_signal(130));
}

/// Removes unfinished files and ends the process, whatever its threads are doing.
pub(crate) fn end(code: i32) -> ! {
    let _held = remove_unfinished();
    exit(code)
}

/// Removes unfinished files. No file is created as long as the lock is held.
fn remove_unfinished() -> Option<MutexGuard<'static, BTreeSet<PathBuf>>> {
    // A thread that ran out of memory may hold it already.
    let unfinished = (0..100).find_map(|_| {
        let unfinished = UNFINISHED.try_lock().ok();
        if unfinished.is_none() {
            std::thread::sleep(Duration::from_millis(10));
        }
        unfinished
    });
    for path in unfinished.iter().flat_map(|unfinished| unfinished.iter()) {
        let _ = fs::remove_file(path);
    }
    unfinished
}

/// Ends the process, whatever its threads are doing.
fn exit(code: i32) -> ! {
    // `process::exit` would unload the graphics driver below the threads that compile shaders, which crashes.
    #[cfg(unix)]
    signal_hook::low_level::exit(code);
    #[cfg(not(unix))]
    std::process::exit(code);
}

/// Ends the process in words because there is no memory left, and takes none for it.
pub fn end_without_memory() -> ! {
    thread_local! {
        static ENDS: Cell<bool> = const { Cell::new(false) };
    }
    if !ENDS.replace(true) {
        let words =
            b"sandbox: there is too little memory; close other programs, or give less to do\n";
        let _ = io::stderr().write_all(words);
        end(2);
    }
    exit(2)
}

/// Makes writing more than `ulimit -f` allows an error, instead of the end of the process.
#[cfg(unix)]
fn ignore_large_files() {
    #[expect(unsafe_code, reason = "no library lets a signal be ignored")]
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Whether the program was started with `signal` ignored.
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

/// Locks `file`, which was created at `path`, for as long as it is open: [`sweep`] leaves locked files alone. `false` if a
/// sweep came first. On file systems without locks nothing is swept.
pub(crate) fn claim(file: &File, path: &Path) -> bool {
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) && path.exists()
}

/// Removes the files of `folder` that are `left` by a run that was killed: those that no program has locked.
pub(crate) fn sweep(folder: &Path, left: impl Fn(&Path) -> bool) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let files = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    for path in files.map(|file| file.path()).filter(|path| left(path)) {
        // Open and locked until it is gone, so that no other run claims it meanwhile.
        if let Ok(file) = File::open(&path)
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(path);
        }
    }
}

/// A file that is not finished.
#[derive(Debug)]
struct Unfinished(PathBuf);

impl Unfinished {
    /// How the names of unfinished files start and end.
    const NAME: [&str; 2] = [".sandbox-", ".part"];

    /// Creates a file in `folder` with the permissions of the file that it will replace, if there is one.
    fn create(folder: &Path, replaces: Option<&Metadata>) -> io::Result<(NamedTempFile, Self)> {
        Self::sweep_once(folder);
        let mut builder = tempfile::Builder::new();
        builder.prefix(Self::NAME[0]).suffix(Self::NAME[1]);
        match replaces {
            Some(replaces) => builder.permissions(plain(replaces.permissions())),
            // Less the bits of the umask.
            #[cfg(unix)]
            None => builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)),
            #[cfg(not(unix))]
            None => &mut builder,
        };
        let mut unfinished = unfinished();
        loop {
            let file = builder.tempfile_in(folder)?;
            if claim(file.as_file(), file.path()) {
                let path = file.path().to_owned();
                unfinished.insert(path.clone());
                return Ok((file, Self(path)));
            }
        }
    }

    /// Removes what killed runs left in `folder`, the first time that this run writes there.
    fn sweep_once(folder: &Path) {
        static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
        if SWEPT.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_owned()) {
            let [start, end] = Self::NAME;
            sweep(folder, |path| {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                name.starts_with(start) && name.ends_with(end)
            });
        }
    }
}

/// Permissions without the setuid, setgid and sticky bits: outputs are not programs.
fn plain(permissions: Permissions) -> Permissions {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        Permissions::from_mode(permissions.mode() & 0o777)
    }
    #[cfg(not(unix))]
    permissions
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        unfinished().remove(&self.0);
    }
}

/// The path of an output that replaces nothing that was read.
#[derive(Clone, Debug)]
pub(crate) struct OutputPath(PathBuf);

impl OutputPath {
    /// Takes a path that was compared with all files that were read: see `CommandFiles`.
    pub(super) fn unread(path: &Path) -> Self {
        Self(path.to_owned())
    }

    /// Takes the path of a file of the program, such as its settings, or of a scene that a person saves into its own file.
    pub(crate) fn of_program(path: &Path) -> Self {
        Self(path.to_owned())
    }
}

impl AsRef<Path> for OutputPath {
    fn as_ref(&self) -> &Path {
        &self.0
    }
}

/// A file that appears under its name when it is finished.
#[derive(Debug)]
pub(crate) struct Output {
    writer: Writer,
}

#[derive(Debug)]
enum Writer {
    /// Renamed to `path` at the end.
    Beside {
        path: PathBuf,
        replaces: Option<Box<Metadata>>,
        file: BufWriter<NamedTempFile>,
        unfinished: Unfinished,
    },
    /// Devices and pipes such as `/dev/stdout`: renaming over one would destroy it.
    Straight(BufWriter<File>),
}

impl Output {
    /// Starts the file `path` in a folder that exists.
    ///
    /// # Errors
    /// A folder that is missing or not writable; a `path` that is a folder itself, or a file that may not be written.
    pub fn create(path: &OutputPath) -> io::Result<Self> {
        let path = path.as_ref();
        if let Some(stream) = standard_stream(path) {
            return Ok(Self { writer: Writer::Straight(BufWriter::new(stream?)) });
        }
        let replaces = match fs::metadata(path) {
            Ok(there) if there.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
            Ok(there) => {
                // Checked here: in a writable folder, renaming replaces a read-only file, and an administrator may open it.
                if there.is_file() && there.permissions().readonly() {
                    return Err(io::ErrorKind::PermissionDenied.into());
                }
                let file = File::options().write(true).open(path)?;
                if !there.is_file() {
                    return Ok(Self { writer: Writer::Straight(BufWriter::new(file)) });
                }
                Some(Box::new(there))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        let path = resolve_links(path);
        let (file, unfinished) = Unfinished::create(folder_of(&path), replaces.as_deref())?;
        Ok(Self {
            writer: Writer::Beside { path, replaces, file: BufWriter::new(file), unfinished },
        })
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
        self.put_in_place().map(drop)
    }

    /// Puts the file in its place. Returns it, open for further writing.
    ///
    /// # Errors
    /// As [`Self::finish`].
    pub(crate) fn put_in_place(self) -> io::Result<File> {
        let (path, replaces, file, unfinished) = match self.writer {
            Writer::Beside { path, replaces, file, unfinished } => {
                (path, replaces, file, unfinished)
            }
            Writer::Straight(file) => {
                return file.into_inner().map_err(io::IntoInnerError::into_error);
            }
        };
        let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        if let Some(replaces) = replaces {
            // Only an administrator may give a file away.
            #[cfg(unix)]
            {
                use std::os::unix::fs::{MetadataExt as _, fchown};
                let _ = fchown(file.as_file(), Some(replaces.uid()), Some(replaces.gid()));
            }
            file.as_file().set_permissions(plain(replaces.permissions()))?;
        }
        file.as_file().sync_all()?;
        let file = file.persist(&path).map_err(|error| error.error)?;
        drop(unfinished);
        // So that a power cut does not bring the old file back. Not every system opens folders.
        if let Ok(folder) = File::open(folder_of(&path)) {
            let _ = folder.sync_all();
        }
        Ok(file)
    }

    /// Whether this is a device or a pipe, which takes what is written as it comes.
    pub(crate) const fn is_device_or_pipe(&self) -> bool {
        matches!(self.writer, Writer::Straight(_))
    }
}

/// Whether `path` names standard output.
pub(crate) fn is_standard_output(path: &Path) -> bool {
    cfg!(unix)
        && ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"]
            .iter()
            .any(|name| path == Path::new(name))
}

/// The standard output or error that `path` names. If a shell redirects the stream to a file, opening it by name would give a
/// second stream that writes over the first, or a file to replace.
#[cfg(unix)]
fn standard_stream(path: &Path) -> Option<io::Result<File>> {
    use std::os::fd::AsFd as _;
    let is = |names: [&str; 3]| names.iter().any(|name| path == Path::new(name));
    let stream = if is_standard_output(path) {
        io::stdout().as_fd().try_clone_to_owned()
    } else if is(["/dev/stderr", "/dev/fd/2", "/proc/self/fd/2"]) {
        io::stderr().as_fd().try_clone_to_owned()
    } else {
        return None;
    };
    Some(stream.map(File::from))
}

#[cfg(not(unix))]
const fn standard_stream(_: &Path) -> Option<io::Result<File>> {
    None
}

/// Greatest number of symbolic links in a chain, as in Linux: more are a cycle.
const MOST_LINKS: usize = 40;

/// Follows the symbolic links of `path`, even to a file that does not exist yet: so a link stays a link when its file is written.
fn resolve_links(path: &Path) -> PathBuf {
    let mut place = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(to) = fs::read_link(&place) else { return place };
        place = folder_of(&place).join(to);
    }
    path.to_owned()
}

/// The place of a file that exists or will exist: the same for all names of one file, even in folders that do not exist yet.
#[expect(clippy::wildcard_enum_match_arm, reason = "parts of a path that stay")]
pub(crate) fn place(path: &Path) -> PathBuf {
    let path = resolve_links(path);
    let mut place = PathBuf::new();
    for part in std::path::absolute(&path).unwrap_or(path).components() {
        match part {
            Component::ParentDir => drop(place.pop()),
            Component::CurDir => {}
            other => {
                place.push(other);
                // Links are resolved before the parts that follow them, as the system does.
                place = fs::canonicalize(&place).unwrap_or(place);
            }
        }
    }
    place
}

/// The folder that `path` is in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
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

/// Refuses a `folder` with a file that has the name of an output and that a person may have made. Accepts a folder that `is_own`,
/// because an earlier run filled it.
pub(crate) fn refuse_foreign_files(
    folder: &Path,
    is_own: bool,
    is_written: impl Fn(&str) -> bool,
    cure: &str,
) -> Result<(), Failure> {
    if is_own {
        return Ok(());
    }
    let there = fs::read_dir(place(folder)).into_iter().flatten().flatten();
    let mut names: Vec<_> =
        there.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort_unstable();
    match names.iter().find(|name| is_written(name)) {
        Some(name) => {
            let what = "this file exists, and nothing says that it was written by an earlier run";
            Err(Failure::Usage(format!("{}: {what}; {cure}", folder.join(name).display())))
        }
        None => Ok(()),
    }
}

/// What comes before the checksum in a JSON that is sealed.
const SEAL: &str = ",\n  \"checksum\": \"";

/// Adds the XXH3-64 of all text before it to an object in JSON, as its last key.
pub(crate) fn sealed(json: &str) -> String {
    let json = json.trim_end().strip_suffix("\n}").unwrap_or_default();
    format!("{json}{SEAL}{:016x}\"\n}}\n", xxh3_64(json.as_bytes()))
}

/// Reads the [sealed] JSON that an earlier run wrote into the file at `path`, if it exists.
pub(crate) fn read_record<T: DeserializeOwned>(
    path: &Path,
    what: &str,
    cure: &str,
) -> Result<Option<T>, Failure> {
    let bytes = match fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(Failure::file("read", path, &error)),
    };
    let refused = |why: &str| {
        Failure::Usage(format!("{}: not a {what} of this version: {why}; {cure}", path.display()))
    };
    let text = String::from_utf8(bytes).unwrap_or_default();
    let is_whole = |(json, _): (&str, &str)| sealed(&format!("{json}\n}}")) == text;
    if !text.rsplit_once(SEAL).is_some_and(is_whole) {
        return Err(refused("its checksum is missing or wrong, so it may be damaged"));
    }
    serde_json::from_str(&text)
        .map(Some)
        .map_err(|error| refused(&format!("it is another from line {} on", error.line())))
}

/// Makes the folder of a study where it is missing, and keeps other studies out of it as long as the lock is held.
pub(crate) fn study_folder(folder: &Path) -> Result<Option<File>, Failure> {
    make_folder(folder)?;
    // Not every system opens folders, or locks them.
    let Ok(lock) = File::open(folder) else { return Ok(None) };
    if matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
        let what =
            "another study writes into this folder; wait for its end, or give another folder";
        return Err(Failure::Usage(format!("{}: {what}", folder.display())));
    }
    Ok(Some(lock))
}

/// Starts an output file, and makes its folder.
pub(crate) fn output_file(path: &OutputPath) -> Result<Output, Failure> {
    make_folder(path.as_ref().parent().unwrap_or(Path::new("")))?;
    Output::create(path).map_err(|error| Failure::file("write", path.as_ref(), &error))
}

/// Writes a whole file.
///
/// # Errors
/// As [`Output`].
pub(crate) fn write(path: &OutputPath, bytes: &[u8]) -> Result<(), Failure> {
    let written = Output::create(path).and_then(|file| file.finish_with(bytes));
    written.map_err(|error| Failure::file("write", path.as_ref(), &error))
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
