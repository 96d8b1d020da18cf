//! Writes the bundle of `run --black-box` if a run goes wrong.

use std::path::{Path, PathBuf};

use history::FaultEntry;
use render::Image;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::output::bundle::finish_bundle;
use crate::output::files::Output;
use crate::output::report::fault_json;
use crate::output::tell;
use cockpit::app::session::Session;

/// The fault of a run, and the bundle that repeats it.
pub(crate) struct BlackBox {
    /// Where the bundle was written, or why not.
    written: Result<PathBuf, Failure>,
    /// The last good tick, or the oldest that is kept.
    tick: u64,
    fault: FaultEntry,
    /// Whether a body was quarantined; otherwise energy came from nowhere, or bodies became free.
    quarantined: bool,
}

/// Goes back to the last good tick of a run that went wrong, and writes a bundle into `file`, which was begun at `path`, with a
/// `picture` of that tick. `None` if nothing went wrong.
pub(crate) fn write(
    path: &Path,
    file: Output,
    session: &mut Session,
    picture: impl FnOnce(&mut Session) -> Result<Image, Failure>,
) -> Option<BlackBox> {
    let fault = session.stage.recorder().fault()?.clone();
    session.rewind_before(&fault);
    let image = picture(session);
    if let Err(failure) = &image {
        tell(&format!("the bundle has no picture: {failure}"));
    }
    let written = finish_bundle(path, file, &session.stage, image.ok().as_ref());
    Some(BlackBox {
        written: written.map(|()| path.to_owned()),
        tick: session.stage.sim().ticks(),
        quarantined: fault.quarantined,
        fault: fault.named(&session.stage.sim().scene.names),
    })
}

impl BlackBox {
    /// The black box in the summary of a run.
    pub(crate) fn json(&self) -> Value {
        let path = self.written.as_ref().ok().map(|path| path.display().to_string());
        json!({ "path": path, "tick": self.tick, "fault": fault_json(Some(&self.fault)) })
    }

    /// The failure that ends the run: its fault, even if the bundle could not be written.
    pub(crate) fn verdict(&self) -> Failure {
        let Self { written, tick, fault, quarantined } = self;
        let file = match written {
            Ok(path) => format!("{} holds the run, for `sandbox replay`", path.display()),
            Err(failure) => failure.to_string(),
        };
        let which = if *tick < fault.tick { "last good one" } else { "oldest that is kept" };
        let what = format!("{fault}; tick {tick} is the {which}; {file}");
        if *quarantined { Failure::Quarantined(what) } else { Failure::Expectation(what) }
    }
}
