//! Records inputs and frame times, so that `sandbox run --script` comes to the same state.

use std::path::{Path, PathBuf};

use motion::Method;
use scene::{Recording, Script, Step, When};

use crate::app::player::recorded;
use crate::failure::Failure;
use crate::input::Input;
use crate::output::files::Output;

/// What was recorded so far.
pub(super) struct Recorder {
    path: PathBuf,
    output: Output,
    script: Script,
    frame_ends_s: Vec<f64>,
    scene: String,
    method: Option<Method>,
    size_px: (u32, u32),
}

impl Recorder {
    /// Starts a recording that will be written to `path`.
    pub fn new(path: &Path, scene: &str, method: Option<Method>, size: [u32; 2]) -> Result<Self, Failure> {
        // Found out before a person has played for an hour; an older recording stays until then.
        let output = Output::create(path).map_err(|error| Failure::file("write", path, &error))?;
        Ok(Self {
            path: path.to_owned(),
            output,
            script: Script::default(),
            method,
            frame_ends_s: Vec::new(),
            scene: scene.to_owned(),
            size_px: size.into(),
        })
    }

    pub fn record(&mut self, frame: u64, end: f64, events: &[Input]) {
        self.frame_ends_s.push(end);
        let steps =
            events.iter().filter_map(recorded).map(|action| Step { when: When::Frame(frame), action });
        self.script.steps.extend(steps);
    }

    /// Writes the recording.
    pub fn finish(self) -> Result<(), Failure> {
        let recording = Recording {
            scene: self.scene,
            method: self.method,
            size_px: self.size_px,
            frame_ends_s: self.frame_ends_s,
        };
        let script = Script { recording: Some(recording), ..self.script };
        let written = self.output.finish_with(script.to_ron().as_bytes());
        written.map_err(|error| Failure::file("write", &self.path, &error))
    }
}
