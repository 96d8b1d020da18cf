//! The program as a child process, and the files that it reads and writes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use expect_test::{ExpectFile, expect_file};
use process_control::{ChildExt as _, Control as _};
use scene::Scene;
use tempfile::TempDir;

/// The program, built beside these tests.
///
/// # Panics
/// When it is not there: say how to build it.
pub fn program() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    let program = tests
        .parent()
        .unwrap()
        .parent()
        .unwrap()
        .join(format!("sandbox{}", std::env::consts::EXE_SUFFIX));
    assert!(
        program.exists(),
        "{} is missing; build it with `cargo build -p inertia-sandbox`",
        program.display()
    );
    program
}

/// Longest that a test waits for a program, many times what any of them takes.
const DEADLINE: Duration = Duration::from_secs(600);

/// What a program said: exit code, or -1 if a signal ended it, standard output and standard error.
#[derive(Debug)]
pub struct Said {
    pub command: String,
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// Runs `command`, which reads nothing, to its end.
///
/// # Panics
/// When it does not end by itself: it is killed.
#[track_caller]
pub fn output(command: &mut Command) -> Said {
    output_within(DEADLINE, command)
}

/// Runs `command` for at most `deadline`: see [`output`].
#[track_caller]
fn output_within(deadline: Duration, command: &mut Command) -> Said {
    let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let child = child.unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let ended =
        child.controlled_with_output().time_limit(deadline).terminate_for_timeout().wait().unwrap();
    let ended = ended
        .unwrap_or_else(|| panic!("{command:?} did not end within {deadline:?}"))
        .into_std_lossy();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let code = ended.status.code().unwrap_or(-1);
    Said { command: format!("{command:?}"), code, out: text(ended.stdout), err: text(ended.stderr) }
}

/// Looks again and again until there is something.
///
/// # Panics
/// When it does not come.
#[track_caller]
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < DEADLINE, "gave up waiting for {what}");
        sleep(Duration::from_millis(20));
    }
}

/// Runs `sandbox line` in `folder`: see [`output`].
#[track_caller]
pub fn sandbox(folder: impl AsRef<Path>, line: &str) -> Said {
    output(Command::new(program()).args(line.split_whitespace()).current_dir(folder.as_ref()))
}

/// The commands, as the help lists them.
pub fn commands() -> Vec<String> {
    let help = sandbox(".", "--help").fine();
    let listed = help.split_once("\nCommands:\n").unwrap().1.split_once("\n\n").unwrap().0;
    let names = listed.lines().map(|line| line.split_whitespace().next().unwrap().to_owned());
    names.filter(|name| name != "help").collect()
}

/// Runs `sandbox line` in a folder with these files: what it said, and the summary that it wrote, or null.
#[track_caller]
pub fn summarized<'a>(
    files: impl IntoIterator<Item = (&'a str, impl AsRef<[u8]>)>,
    line: &str,
) -> (Said, serde_json::Value) {
    let folder = folder(files);
    let said = sandbox(&folder, &format!("{line} --summary summary.json"));
    let summary = fs::read(folder.path().join("summary.json")).unwrap_or_default();
    (said, serde_json::from_slice(&summary).unwrap_or_default())
}

impl Said {
    /// For messages of tests.
    pub fn all(&self) -> String {
        let Self { command, code, out, err } = self;
        format!("{command} ended with {code}\n{out}{err}")
    }

    /// The same, of a program that must have ended with that exit code.
    #[track_caller]
    pub fn ends(self, code: i32) -> Self {
        assert_eq!(self.code, code, "{}", self.all());
        self
    }

    /// Fails unless the program ended with that exit code and said exactly `err` on standard error.
    #[track_caller]
    pub fn says(&self, code: i32, err: &str) {
        assert_eq!((self.code, self.err.as_str()), (code, err), "{}", self.all());
    }

    /// What was printed, by a program that must have succeeded.
    #[track_caller]
    pub fn fine(self) -> String {
        self.ends(0).out
    }

    /// Fails unless the program ended with that exit code and said `words`, among others, on standard error.
    #[track_caller]
    pub fn warns(&self, code: i32, words: &str) {
        let said = self.code == code && self.err.contains(words);
        assert!(said, "not {code} with {words:?}: {}", self.all());
    }

    /// The same, and fails if it printed results.
    #[track_caller]
    pub fn fails(&self, code: i32, words: &str) {
        self.warns(code, words);
        assert_eq!(self.out, "", "{}", self.command);
    }
}

/// A folder with these files.
pub fn folder<'a>(files: impl IntoIterator<Item = (&'a str, impl AsRef<[u8]>)>) -> TempDir {
    let folder = TempDir::new().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    folder
}

/// The scene that `text` describes.
///
/// # Panics
/// When it describes none.
#[track_caller]
pub fn scene_of(text: &str) -> Scene {
    Scene::parse("test", text).unwrap_or_else(|error| panic!("{error}"))
}

/// A text in JSON with a checksum, as the program writes what it reads again.
pub fn sealed(json: &str) -> String {
    let mut value: serde_json::Value = serde_json::from_str(json).unwrap();
    value.as_object_mut().unwrap().remove("checksum");
    let text = serde_json::to_string_pretty(&value).unwrap();
    let text = text.strip_suffix("\n}").unwrap();
    let hash = xxhash_rust::xxh3::xxh3_64(text.as_bytes());
    format!("{text},\n  \"checksum\": \"{hash:016x}\"\n}}\n")
}

/// The JSON in a file.
#[track_caller]
pub fn json(path: impl AsRef<Path>) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
#[cfg(unix)]
#[should_panic = "did not end within"]
fn a_program_that_waits_for_ever_is_ended() {
    output_within(Duration::from_millis(50), Command::new("tail").args(["-f", "/dev/null"]));
}

/// Whether this run writes the pictures that other runs compare with.
pub fn blesses() -> bool {
    std::env::var("BLESS").is_ok_and(|value| value == "1")
}

/// Fails unless `text` is what the file at `path` from the root has; UPDATE_EXPECT=1 writes it.
#[track_caller]
pub fn assert_stored(path: &str, text: &str) {
    expect_file![root().join(path)].assert_eq(text);
}

/// The file `tests/expected/NAME.txt`.
pub fn expected(name: &str) -> ExpectFile {
    expect_file![root().join(format!("tests/expected/{name}.txt"))]
}

/// Fails unless `text` is what `tests/expected/NAME.txt` has; UPDATE_EXPECT=1 writes it.
#[track_caller]
pub fn assert_expected(name: &str, text: &str) {
    expected(name).assert_eq(text);
}

/// Fails unless `tests/expected/NAME.txt` has `answer` of every text in it; UPDATE_EXPECT=1 writes the answers.
///
/// A case is a line `----`, a text, a line `=>`, and the answer to the text.
#[track_caller]
pub fn answers(name: &str, answer: impl Fn(&str) -> String) {
    let answered = |case: &str| {
        let text = case.split_once("=>\n").unwrap().0.trim_end_matches('\n');
        format!("----\n{text}\n=>\n{}\n", answer(text).trim_end())
    };
    let stored = expected(name).data();
    assert!(stored.starts_with("----\n"), "{name} has no case");
    assert_expected(name, &stored.split("----\n").skip(1).map(answered).collect::<String>());
}

/// Root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// What cargo says of the workspace.
pub fn cargo_metadata(flags: &[&str]) -> serde_json::Value {
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .args(["metadata", "--format-version", "1", "--manifest-path"])
        .arg(root().join("Cargo.toml"));
    serde_json::from_str(&output(cargo.args(flags)).fine()).unwrap()
}

/// Everything in a folder, the folders in it too.
pub fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // A link is an entry like any other, wherever it leads.
        if path.is_dir() && !path.is_symlink() {
            found.extend(listing(&path));
        }
        found.push(path);
    }
    found.sort();
    found
}
