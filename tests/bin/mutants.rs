//! `cargo run -p acceptance --bin mutants`: lists the mutants and the test that kills each. With `--run` it makes those that
//! are edits of the sources, one after the other in a copy under `target/mutants`, and fails if a test does not.
#![allow(clippy::print_stdout, reason = "it is a program")]

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

use acceptance::mutants::{Edit, MUTANTS, Made, Mutant};

fn main() -> ExitCode {
    let arguments: Vec<_> = env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => {
            list();
            ExitCode::SUCCESS
        }
        ["--run"] => run(""),
        ["--run", part] => run(part),
        _ => {
            eprintln!("usage: mutants [--run [PART OF A MISTAKE]]");
            ExitCode::from(2)
        }
    }
}

fn list() {
    for (number, Mutant { mistake, made, killed_by }) in (1..).zip(MUTANTS) {
        println!("{number:>2}. {mistake}\n    killed by {killed_by}");
        match made {
            Made::BesideTheTests(file, names) => println!("    made in {file}: {}", names.join("; ")),
            Made::ByEdits(edits) => {
                edits.iter().for_each(|edit| println!("    made in {}: {}", edit.file, edit.to.trim()));
            }
        }
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
}

/// Makes the mutants whose mistake contains `part`.
fn run(part: &str) -> ExitCode {
    let copy = root().join("target/mutants/copy");
    let mut survivors = 0;
    for mutant in MUTANTS.iter().filter(|mutant| mutant.mistake.contains(part)) {
        let Made::ByEdits(edits) = mutant.made else { continue };
        println!("{}", mutant.mistake);
        copy_sources(&copy);
        edits.iter().for_each(|edit| make(&copy, edit));
        let verdict = verdict(&copy, mutant.killed_by);
        survivors += u32::from(verdict.is_err());
        println!("    {}", verdict.unwrap_or_else(|why| why));
    }
    if survivors == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Makes the copy equal to the files that git knows here; files that are equal keep their times, and need no build.
fn copy_sources(copy: &Path) {
    let files = Command::new("git").arg("-C").arg(root()).args(["ls-files", "-z"]).output();
    let files = files.expect("git lists the sources").stdout;
    for file in String::from_utf8_lossy(&files).split('\0').filter(|file| !file.is_empty()) {
        let (from, to) = (root().join(file), copy.join(file));
        let Ok(text) = fs::read(&from) else { continue };
        if fs::read(&to).is_ok_and(|old| old == text) {
            continue;
        }
        fs::create_dir_all(to.parent().expect("a file is in a folder")).expect("folders can be made");
        fs::write(&to, text).expect("files can be written");
    }
}

fn make(copy: &Path, edit: &Edit) {
    let path = copy.join(edit.file);
    let text = fs::read_to_string(&path).expect("the file is there");
    assert_eq!(text.matches(edit.from).count(), 1, "{} has not once {:?}", edit.file, edit.from);
    fs::write(&path, text.replace(edit.from, edit.to)).expect("files can be written");
}

/// What becomes of the test; an error if it does not fail.
fn verdict(copy: &Path, test: &str) -> Result<String, String> {
    let cargo = |arguments: &[&str]| {
        Command::new(env!("CARGO"))
            .args(arguments)
            .current_dir(copy)
            .env("CARGO_TARGET_DIR", root().join("target/mutants/build"))
            .output()
            .expect("cargo can be started")
    };
    let build = cargo(&["build", "--locked", "-p", "sandbox"]);
    let tests = cargo(&["test", "--locked", "-p", "acceptance", "--test", "acceptance", "--no-run"]);
    if !build.status.success() || !tests.status.success() {
        let text = [build.stderr, tests.stderr].concat();
        return Err(format!("does not compile:\n{}", String::from_utf8_lossy(&text)));
    }
    let result =
        cargo(&["test", "--locked", "-p", "acceptance", "--test", "acceptance", "--", "--exact", test]);
    let said = String::from_utf8_lossy(&result.stdout);
    if said.contains("1 passed") {
        Err(format!("SURVIVED {test}"))
    } else if said.contains("1 failed") {
        Ok(format!("killed by {test}"))
    } else {
        Err(format!("{test} was not run:\n{said}"))
    }
}
