//! Command lines and what the program says to them, as text files.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

use super::{Said, assert_expected, expected, folder, listing, output, program, root};

/// Runs `sandbox line` where no display can be found, and fails if it panics or names a place of its source.
#[track_caller]
pub fn without_display(folder: &Path, line: &str, variables: &[(&str, &str)]) -> Said {
    let runtime = TempDir::new().unwrap();
    let mut command = Command::new(program());
    command.args(line.split_whitespace()).current_dir(folder);
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET", "RUST_LOG"] {
        command.env_remove(variable);
    }
    command.env("XDG_RUNTIME_DIR", runtime.path()).envs(variables.iter().copied());
    let said = output(&mut command);
    let folder = folder.canonicalize().unwrap();
    let text = |text: &str| text.replace(folder.to_str().unwrap(), "FOLDER");
    let said = Said { out: text(&said.out), err: text(&said.err), ..said };
    for leak in ["panicked", "RUST_BACKTRACE", ".rs:", ".cargo", root().to_str().unwrap()] {
        let all = said.all();
        assert!(!said.out.contains(leak) && !said.err.contains(leak), "`{leak}` in {all}");
    }
    said
}

/// Everything in a folder, with what is in the files and where links lead.
pub fn contents(folder: &Path) -> Vec<(PathBuf, Option<Vec<u8>>)> {
    let target =
        |path: &Path| fs::read_link(path).map(|to| to.into_os_string().into_encoded_bytes());
    let read = |path: PathBuf| (target(&path).or_else(|_| fs::read(&path)).ok(), path);
    listing(folder).into_iter().map(read).map(|(bytes, path)| (path, bytes)).collect()
}

/// Runs the command lines of `tests/expected/NAME.txt` one after the other in a folder, and fails unless the program
/// does what is written there.
///
/// `= NAME` makes a file of the indented lines below it, `= NAME -> PATH` a link, `$ LINE` runs `sandbox LINE`; blank lines
/// and comments stay. The rest is written: what is printed on standard output after `|` and on standard error
/// after `!`, what appears, changes or goes in the folder after `+`, `~` or `-`, and the exit code in brackets unless it
/// is 0. `> /dev/null` at the end leaves out standard output.
#[track_caller]
pub fn command_lines(name: &str) {
    let stored = expected(name).data();
    assert!(stored.contains("$ "), "{name} has no command line");
    let folder = folder([("", ""); 0]);
    let (mut text, mut file) = (String::new(), None);
    for line in stored.lines().filter(|line| !line.starts_with(['|', '!', '+', '~', '-', '['])) {
        writeln!(text, "{line}").unwrap();
        if let Some(content) = line.strip_prefix("  ") {
            let (path, lines): &mut (PathBuf, Vec<&str>) = file.as_mut().unwrap();
            lines.push(content);
            fs::write(path, lines.join("\n")).unwrap();
        } else if let Some(name) = line.strip_prefix("= ") {
            let (name, target) = name.split_once(" -> ").unwrap_or((name, ""));
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            #[cfg(unix)]
            if !target.is_empty() {
                std::os::unix::fs::symlink(target, path).unwrap();
                continue;
            }
            assert!(target.is_empty(), "{target}: links need Unix");
            fs::write(&path, "").unwrap();
            file = Some((path, Vec::new()));
        } else if let Some(line) = line.strip_prefix("$ ") {
            run(folder.path(), line, &mut text);
        }
    }
    assert_expected(name, &text);
}

/// Runs a line of a file and appends what came of it.
#[track_caller]
fn run(folder: &Path, line: &str, text: &mut String) {
    let before = contents(folder);
    let (line, quiet) =
        line.strip_suffix(" > /dev/null").map_or((line, false), |line| (line, true));
    let said = without_display(folder, line, &[]);
    let after = contents(folder);
    let version = concat!("sandbox ", env!("CARGO_PKG_VERSION"));
    let out = said.out.replace(version, "sandbox VERSION");
    let out = out.lines().filter(|_| !quiet).map(|line| format!("| {line}"));
    // What differs from machine to machine: the adapter, and how far a forecast tries in its time.
    let drawing = |line: &str| line.strip_prefix("drawing with ").map(|_| "drawing with ADAPTER");
    let err = said.err.lines().filter(|line| !line.contains("; tried "));
    let err = err.map(|line| format!("! {}", drawing(line).unwrap_or(line)));
    let gone = before.iter().filter(|(path, _)| after.iter().all(|(other, _)| other != path));
    let changed = after.iter().filter(|entry| !before.contains(entry));
    let changed = changed.map(|(path, _)| {
        let is_new = before.iter().all(|(other, _)| other != path);
        (if is_new { '+' } else { '~' }, path)
    });
    let changes = gone.map(|(path, _)| ('-', path)).chain(changed);
    let changes = changes
        .map(|(sign, path)| format!("{sign} {}", path.strip_prefix(folder).unwrap().display()));
    for line in out.chain(err).chain(changes) {
        writeln!(text, "{}", line.trim_end()).unwrap();
    }
    if said.code != 0 {
        writeln!(text, "[{}]", said.code).unwrap();
    }
}
