//! Why a session does not do something.

use std::fmt;

use scene::SceneError;

/// Why something is refused, and the cure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(pub String);

impl fmt::Display for Refused {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

impl From<SceneError> for Refused {
    fn from(error: SceneError) -> Self {
        Self(error.to_string())
    }
}
