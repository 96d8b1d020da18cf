//! Files that the program writes: whole or absent.

pub(crate) mod black_box;
pub(crate) mod bundle;
pub mod files;
pub(crate) mod pictures;
pub(crate) mod progress;
pub mod report;
pub(crate) mod scenes;

use std::io::Write as _;
use std::path::Path;

use crate::failure::Failure;

/// Prints a message on standard error.
pub fn tell(message: &str) {
    eprintln!("{}", ::report::terminal(message));
}

/// Prints results. A closed pipe (`| head`) is no failure.
pub(crate) fn show(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(::report::terminal(text).as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::file("write", Path::new("standard output"), &error))
        }
        _ => Ok(()),
    }
}
