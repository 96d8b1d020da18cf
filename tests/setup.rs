//! `scripts/setup` on made-up machines: every program that it asks about the machine is a fake.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::PathBuf;
use std::process::Command;

use tempfile::TempDir;

use crate::rigs::{output, root};

/// A folder that stands for all of `PATH`.
struct Machine(TempDir);

impl Machine {
    /// A Debian-like machine with everything there, used by root.
    fn new() -> Self {
        let machine = Self(TempDir::new().unwrap());
        let path = std::env::var_os("PATH").unwrap();
        for name in ["bash", "dirname", "env", "head", "sed", "sh", "sort"] {
            let found = std::env::split_paths(&path)
                .map(|folder| folder.join(name))
                .find(|file| file.exists());
            symlink(found.unwrap(), machine.path(name)).unwrap();
        }
        machine.fake("cargo", "echo 'cargo 1.95.0 (0123456 2026-01-01)'");
        machine.fake("uname", "echo Linux");
        machine.fake("id", "echo 0");
        machine.fake("dpkg-query", "echo installed");
        machine.fake("apt-get", "echo apt-get $* >>\"$0.log\"");
        machine
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn fake(&self, name: &str, script: &str) {
        fs::write(self.path(name), format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(self.path(name), PermissionsExt::from_mode(0o755)).unwrap();
    }

    fn lacks(&self, package: &str) {
        self.fake("dpkg-query", &format!("[ $4 != {package} ] && echo installed"));
    }

    /// Runs `scripts/setup` with the words of `line`: settings, then `run`, `test` or `systems`.
    fn setup(&self, line: &str) -> Said {
        let mut setup = Command::new(self.path("env"));
        setup.env_clear().env("PATH", self.0.path()).env("HOME", self.0.path());
        let (settings, purpose) = line.rsplit_once(' ').unwrap_or(("", line));
        setup
            .args(settings.split_whitespace())
            .arg("bash")
            .arg(root().join("scripts/setup"))
            .arg(purpose);
        let said = output(&mut setup);
        let log = fs::read_to_string(self.path("apt-get.log")).unwrap_or_default();
        let install = "apt-get -q install -y --no-install-recommends ";
        Said {
            code: said.code,
            text: said.err,
            installed: log
                .lines()
                .find_map(|line| line.strip_prefix(install))
                .unwrap_or_default()
                .to_owned(),
        }
    }
}

struct Said {
    code: i32,
    text: String,
    installed: String,
}

impl Said {
    /// Fails unless all was there.
    #[track_caller]
    fn is_silent(&self) {
        assert_eq!((self.code, &*self.text, &*self.installed), (0, "", ""));
    }

    /// Fails unless `packages` were installed.
    #[track_caller]
    fn installs(&self, packages: &str) {
        assert_eq!((self.code, &*self.installed), (0, packages), "{}", self.text);
    }

    /// Fails unless setup stopped with a message that has each of `words`.
    #[track_caller]
    fn stops(&self, words: &[&str]) {
        assert_eq!(self.code, 1, "{}", self.text);
        for words in words {
            assert!(self.text.contains(words), "{} lacks {words}", self.text);
        }
    }
}

#[test]
fn a_machine_with_everything_is_left_alone() {
    Machine::new().setup("run").is_silent();
    Machine::new().setup("test").is_silent();
    Machine::new().setup("systems").is_silent();
}

#[test]
fn missing_rust_and_old_rust_name_rustup() {
    let machine = Machine::new();
    machine.lacks("gcc");
    fs::remove_file(machine.path("cargo")).unwrap();
    let said = machine.setup("run");
    said.stops(&["Rust is not installed", "https://sh.rustup.rs"]);
    assert_eq!(said.installed, "");

    let machine = Machine::new();
    machine.fake("cargo", "echo 'cargo 1.65.0'");
    let minimum = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let minimum = minimum.split("rust-version = \"").nth(1).unwrap().split('"').next().unwrap();
    machine.setup("run").stops(&[
        "1.65.0",
        &format!("Rust {minimum} or newer"),
        "https://sh.rustup.rs",
    ]);
    machine.fake("cargo", "echo 'cargo 1.100.0-nightly'");
    machine.setup("run").is_silent();
    machine.fake("cargo", "echo no such toolchain >&2; exit 1");
    machine.setup("run").stops(&["no such toolchain", "RUSTUP_TOOLCHAIN"]);
}

#[test]
fn root_and_a_sudo_without_a_password_install() {
    let machine = Machine::new();
    machine.lacks("gcc");
    machine.setup("run").installs("gcc");

    let machine = Machine::new();
    machine.lacks("xvfb");
    machine.setup("run").is_silent();
    machine.setup("test").installs("xvfb");

    let machine = Machine::new();
    machine.lacks("rust-web-src");
    machine.setup("test").is_silent();
    machine.setup("systems").installs("rust-web-src");

    let machine = Machine::new();
    machine.lacks("libxi6");
    machine.fake("id", "echo 1000");
    machine.fake("true", "");
    machine.fake("sudo", "[ $1 = -n ] && shift && exec \"$@\"");
    machine.setup("run").installs("libxi6");
}

#[test]
fn whoever_may_not_install_is_told_what_to_type() {
    let machine = Machine::new();
    machine.lacks("libxi6");
    machine.fake("id", "echo 1000");
    let command = "\n    sudo apt-get install --no-install-recommends libxi6\n";
    machine.setup("run").stops(&[command, "SKIP_SETUP=1"]);
    machine.fake("sudo", "exit 1");
    let said = machine.setup("run");
    said.stops(&[command]);
    assert_eq!(said.installed, "");
    machine.setup("SKIP_SETUP=1 run").is_silent();

    let machine = Machine::new();
    machine.lacks("libxi6");
    machine.fake("apt-get", "exit 100");
    machine.setup("run").stops(&["\n    apt-get install --no-install-recommends libxi6\n"]);
}

#[test]
fn other_systems_need_programs() {
    let machine = Machine::new();
    fs::remove_file(machine.path("apt-get")).unwrap();
    machine.setup("run").stops(&["cc", "docs/install.md"]);
    machine.fake("cc", "");
    machine.setup("run").is_silent();
    machine.setup("test").stops(&["kill Xvfb xdotool", "docs/install.md"]);
    machine.fake("uname", "echo Darwin");
    machine.setup("test").is_silent();
}
