//! Notes the compiler, for reports.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = Command::new(rustc).arg("--version").output();
    let version = version.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    let opt_level = std::env::var("OPT_LEVEL").unwrap_or_default();
    let compiler = version.unwrap_or_else(|_| "an unknown compiler".to_owned());
    println!("cargo::rustc-env=LAB_COMPILER={compiler}, opt-level {opt_level}");
}
