//! What a reader types from the README does what it says there.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::harness::{output, program, root, sandbox};
use crate::tidy::cargo_metadata;

/// The commands of each block of shell lines, without their comments.
fn blocks() -> Vec<Vec<String>> {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let block = |text: &str| {
        let (commands, _) = text.split_once("\n```").unwrap();
        let commands = commands.lines().map(|line| line.split('#').next().unwrap().trim());
        commands.filter(|line| !line.is_empty()).map(str::to_owned).collect()
    };
    readme.split("```sh\n").skip(1).map(block).collect()
}

/// The binary that `cargo run` builds here if no flag names one; `None` where it would ask for a flag.
fn binary_of_cargo_run() -> Option<String> {
    let metadata = cargo_metadata(&["--no-deps"]);
    let packages = metadata["packages"].as_array().unwrap();
    let defaults: Vec<_> = packages.iter().filter_map(|package| package["default_run"].as_str()).collect();
    let targets = packages.iter().flat_map(|package| package["targets"].as_array().unwrap());
    let binaries = targets.filter(|target| target["kind"][0] == "bin");
    let all: Vec<_> = binaries.filter_map(|target| target["name"].as_str()).collect();
    match (&defaults[..], &all[..]) {
        ([one], _) | ([], [one]) => Some((*one).to_owned()),
        _ => None,
    }
}

/// The arguments of the program in a line that cargo runs.
fn arguments(line: &str) -> Option<&str> {
    line.strip_prefix("cargo run --release -- ")
}

#[test]
fn cargo_run_finds_the_program() {
    assert_eq!(binary_of_cargo_run().as_deref(), Some("sandbox"));
}

#[test]
#[cfg(unix)]
fn the_first_command_of_each_block_runs_as_it_is_typed() {
    let mut run = 0;
    for block in blocks() {
        let Some(line) = arguments(&block[0]) else { continue };
        // The root of the repository, with room for what is written there.
        let folder = TempDir::new().unwrap();
        std::os::unix::fs::symlink(root().join("assets"), folder.path().join("assets")).unwrap();
        let said = sandbox(folder.path(), line);
        assert!(said.status.success(), "{line}: {}", String::from_utf8_lossy(&said.stderr));
        run += 1;
    }
    assert!(run > 0, "the README runs nothing");
}

#[test]
fn every_command_is_one() {
    let blocks = blocks();
    for line in blocks.iter().flatten() {
        if let Some(arguments) = arguments(line) {
            // The help comes once the arguments before it were understood.
            let said = output(Command::new(program()).args(arguments.split_whitespace()).arg("--help"));
            assert!(said.status.success(), "{line}: {}", String::from_utf8_lossy(&said.stderr));
        } else {
            let script = root().join(Path::new(line.split_whitespace().next().unwrap()));
            assert!(script.is_file(), "{line}: there is no such script");
            let said = output(Command::new("bash").arg("-n").arg(&script));
            assert!(said.status.success(), "{line}: {}", String::from_utf8_lossy(&said.stderr));
        }
    }
}
