//! Mistakes that are easily made in the sources, and for each the test that has to fail.
//!
//! `cargo run -p acceptance --bin mutants` lists them. With `--run`, or `--run WORDS` for those that have these words, it
//! makes one after the other in a copy under `target/mutants` and fails if a test passes, or if the text that a mistake
//! replaces has changed: then correct it in `tests/mutants.rs`. Mistakes in a method are in `tests/methods/mutants`, and
//! rejected in every test run.
#![allow(clippy::print_stdout, reason = "it is a program")]

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

use acceptance::mutants::{MUTANTS, Mutant};

fn main() -> ExitCode {
    let arguments: Vec<_> = env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => {
            for (number, Mutant { mistake, file, killed_by, .. }) in (1..).zip(MUTANTS) {
                println!("{number:>2}. {mistake}\n    in {file}, killed by {killed_by}");
            }
            ExitCode::SUCCESS
        }
        ["--run"] => run(""),
        ["--run", words] => run(words),
        _ => {
            eprintln!("usage: mutants [--run [WORDS OF A MISTAKE]]");
            ExitCode::from(2)
        }
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default()
}

fn run(words: &str) -> ExitCode {
    let copy = root().join("target/mutants/copy");
    let mut failed = false;
    for mutant in MUTANTS.iter().filter(|mutant| mutant.mistake.contains(words)) {
        println!("{}", mutant.mistake);
        copy_sources(&copy);
        let verdict = make(&copy, mutant).and_then(|()| verdict(&copy, mutant.killed_by));
        failed |= verdict.is_err();
        println!("    {}", verdict.unwrap_or_else(|why| why));
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
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
        fs::create_dir_all(to.parent().expect("a file is in a folder"))
            .expect("folders can be made");
        fs::write(&to, text).expect("files can be written");
    }
}

fn make(copy: &Path, mutant: &Mutant) -> Result<(), String> {
    let Mutant { file, from, to, .. } = mutant;
    let path = copy.join(file);
    let text = fs::read_to_string(&path).map_err(|error| format!("{file}: {error}"))?;
    match text.matches(from).count() {
        1 => fs::write(&path, text.replace(from, to)).map_err(|error| format!("{file}: {error}")),
        times => Err(format!("{file} has {times} times {from:?}; correct it in tests/mutants.rs")),
    }
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
    let build = cargo(&["build", "--locked", "-p", "inertia-sandbox"]);
    let tests =
        cargo(&["test", "--locked", "-p", "acceptance", "--test", "acceptance", "--no-run"]);
    if !build.status.success() || !tests.status.success() {
        let text = [build.stderr, tests.stderr].concat();
        return Err(format!("does not compile:\n{}", String::from_utf8_lossy(&text)));
    }
    let result = cargo(&[
        "test",
        "--locked",
        "-p",
        "acceptance",
        "--test",
        "acceptance",
        "--",
        "--exact",
        test,
    ]);
    let said = String::from_utf8_lossy(&result.stdout);
    if said.contains("1 passed") {
        Err(format!("SURVIVED {test}"))
    } else if said.contains("1 failed") {
        Ok(format!("killed by {test}"))
    } else {
        Err(format!("{test} was not run:\n{said}"))
    }
}
