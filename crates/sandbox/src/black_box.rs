//! What `run --black-box` writes of a run that went wrong.

use std::path::{Path, PathBuf};

use render::Image;
use scene::FaultEntry;

use crate::bundle::finish_bundle;
use crate::failure::Failure;
use crate::files::Output;
use crate::session::Session;

/// What was written.
pub(crate) struct BlackBox {
    pub path: PathBuf,
    /// The last good tick.
    pub tick: u64,
    pub fault: FaultEntry,
    /// Whether a body was; else energy jumped.
    quarantined: bool,
}

/// Goes back to the last good tick of a run that went wrong, and writes it into `file`, which was begun at `path`, with a
/// `picture` of that tick; `None` where nothing went wrong.
pub(crate) fn write(
    path: &Path,
    file: Output,
    session: &mut Session,
    picture: impl FnOnce(&mut Session) -> Result<Image, Failure>,
) -> Result<Option<BlackBox>, Failure> {
    let Some(fault) = session.fault().cloned() else { return Ok(None) };
    session.rewind_before(&fault);
    let image = picture(session);
    if let Err(failure) = &image {
        eprintln!("the bundle has no picture: {failure}");
    }
    finish_bundle(path, file, session, image.ok().as_ref())?;
    Ok(Some(BlackBox {
        path: path.to_owned(),
        tick: session.ticks(),
        quarantined: fault.quarantined,
        fault: fault.named(&session.scene().names),
    }))
}

impl BlackBox {
    /// How the run ends.
    pub(crate) fn verdict(&self) -> Failure {
        let Self { path, tick, fault, quarantined } = self;
        let path = path.display();
        let what =
            format!("{fault}; tick {tick} is the last good one; {path} holds the run, for `sandbox replay`");
        if *quarantined { Failure::Quarantined(what) } else { Failure::Expectation(what) }
    }
}
