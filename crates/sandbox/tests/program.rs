//! The program starts. Cargo builds the binary because of this test, and the acceptance tests run it.

use std::process::Command;

#[test]
fn it_tells_its_version() {
    let output = Command::new(env!("CARGO_BIN_EXE_sandbox"))
        .arg("--version")
        .output()
        .expect("it was just built");
    assert_eq!(
        String::from_utf8_lossy(&output.stdout),
        format!("sandbox {}\n", env!("CARGO_PKG_VERSION"))
    );
    assert!(output.status.success());
}
