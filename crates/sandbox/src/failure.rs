//! Why the program ends without success, and with which exit code.

use std::fmt;
use std::path::Path;

use cockpit::Refused;
use cockpit::app::pupil::Unplayed;
use render::RenderError;
use scene::SceneError;

/// The reason of an exit code that is not 0.
#[derive(Debug)]
pub enum Failure {
    /// Exit code 1: an expectation of the scene did not hold.
    Expectation(String),
    /// Exit code 2: a bad flag, file or scene.
    Usage(String),
    /// Exit code 3: a body was quarantined.
    Quarantined(String),
    /// Exit code 4: no graphics adapter where pictures were asked for.
    NoAdapter(String),
    /// Exit code 5: no display for a window.
    NoDisplay(String),
}

impl Failure {
    /// A file that could not be read or written.
    #[must_use]
    #[expect(clippy::wildcard_enum_match_arm, reason = "kinds of errors of the system")]
    pub fn file(doing: &str, path: &Path, error: &std::io::Error) -> Self {
        use std::io::ErrorKind as Kind;
        let why = match error.kind() {
            Kind::NotFound => "no such file or folder; check the path",
            Kind::PermissionDenied => "it is not permitted; give another path",
            Kind::ReadOnlyFilesystem => "nothing can be written there; give another path",
            Kind::StorageFull => "the disk is full; make room, or give another path",
            Kind::IsADirectory => "it is a folder; give the path of a file",
            // For example the path of an existing folder, with a slash at its end.
            Kind::AlreadyExists | Kind::NotADirectory if names_folder(path) => {
                "the path ends with a folder separator; give the path of a file"
            }
            Kind::AlreadyExists | Kind::NotADirectory => "a file is in the way; give another path",
            Kind::InvalidFilename => {
                "the name is too long, or has characters that no name can have; give another"
            }
            Kind::InvalidData if doing == "read" => "it is not UTF-8 text; give another path",
            Kind::BrokenPipe => "nothing reads it any more; start its reader first",
            Kind::FileTooLarge => {
                "the file would be larger than is allowed; see `ulimit -f`, or write less"
            }
            Kind::OutOfMemory => {
                "there is too little memory; close other programs, or give less to do"
            }
            _ => {
                return Self::Usage(format!(
                    "cannot {doing} {}: {}",
                    path.display(),
                    scene::io_words(error)
                ));
            }
        };
        Self::Usage(format!("cannot {doing} {}: {why}", path.display()))
    }

    /// The code that the process exits with.
    #[must_use]
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Expectation(_) => 1,
            Self::Usage(_) => 2,
            Self::Quarantined(_) => 3,
            Self::NoAdapter(_) => 4,
            Self::NoDisplay(_) => 5,
        }
    }
}

/// Whether a path ends with the separator of folders.
fn names_folder(path: &Path) -> bool {
    path.as_os_str()
        .as_encoded_bytes()
        .last()
        .is_some_and(|last| std::path::is_separator(char::from(*last)))
}

impl fmt::Display for Failure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Expectation(text)
            | Self::Usage(text)
            | Self::Quarantined(text)
            | Self::NoAdapter(text)
            | Self::NoDisplay(text) => out.write_str(text),
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Usage(error.to_string())
    }
}

impl From<Unplayed> for Failure {
    fn from(unplayed: Unplayed) -> Self {
        match unplayed {
            Unplayed::Unreadable(what) => Self::Usage(what),
            Unplayed::Wrong(what) => Self::Expectation(what),
        }
    }
}

impl From<Refused> for Failure {
    fn from(Refused(what): Refused) -> Self {
        Self::Usage(what)
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Size { .. } => Self::Usage(format!("--size: {error}")),
            RenderError::NoAdapter { .. }
            | RenderError::NoSuchAdapter { .. }
            | RenderError::Device { .. }
            | RenderError::Lost { .. }
            | RenderError::Surface { .. }
            | RenderError::ReadBack { .. } => Self::NoAdapter(error.to_string()),
        }
    }
}
