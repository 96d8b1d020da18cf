//! Files that the program writes: whole or absent.

pub(crate) mod black_box;
pub(crate) mod bundle;
pub(crate) mod command_files;
pub(crate) mod files;
pub(crate) mod on_device;
pub(crate) mod orders;
pub(crate) mod pictures;
pub(crate) mod progress;
pub mod report;
pub(crate) mod runs;
pub(crate) mod scenes;
pub(crate) mod states;

use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;

/// Whether the program was started with standard output closed. Rust opens `/dev/null` in its place, where everything is lost
/// without an error.
static STDOUT_IS_CLOSED: AtomicBool = AtomicBool::new(false);

/// Checks whether standard output is open, before Rust opens `/dev/null` in place of a closed one.
#[cfg(target_os = "linux")]
#[used]
#[expect(unsafe_code, reason = "the linker calls what is in this section before `main`")]
#[unsafe(link_section = ".init_array")]
static BEFORE_MAIN: extern "C" fn() = {
    extern "C" fn look_at_stdout() {
        #[expect(unsafe_code, reason = "no library asks whether a file is open")]
        let flags = unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_GETFD) };
        STDOUT_IS_CLOSED.store(flags == -1, Ordering::Relaxed);
    }
    look_at_stdout
};

/// Prints a message on standard error.
pub fn tell(message: &str) {
    eprintln!("{}", ::report::terminal(message));
}

/// Prints results on standard error.
pub(crate) fn tell_all(text: &str) {
    eprint!("{}", ::report::terminal(text));
}

/// Prints results. A closed pipe (`| head`) is no failure.
pub(crate) fn show(text: &str) -> Result<(), Failure> {
    if STDOUT_IS_CLOSED.load(Ordering::Relaxed) {
        let what =
            "cannot write standard output: it is closed; redirect it to a file, or to /dev/null";
        return Err(Failure::Usage(what.to_owned()));
    }
    let mut out = std::io::stdout().lock();
    match out.write_all(::report::terminal(text).as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::file("write", Path::new("standard output"), &error))
        }
        _ => Ok(()),
    }
}
