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

    pub fn record<'a>(&mut self, frame: u64, end: f64, events: impl IntoIterator<Item = &'a Input>) {
        self.frame_ends_s.push(end);
        let steps =
            events.into_iter().filter_map(recorded).map(|action| Step { when: When::Frame(frame), action });
        self.script.steps.extend(steps);
    }

    /// Records what was chosen in the last frame as a frame that takes no time.
    pub fn record_end(&mut self, frame: u64, chosen: &[Input]) {
        if let Some(end) = self.frame_ends_s.last().copied().filter(|_| !chosen.is_empty()) {
            self.record(frame, end, chosen);
        }
    }

    /// Writes the recording.
    pub fn finish(self) -> Result<(), Failure> {
        let recording = Recording {
            scene: self.scene,
            method: self.method,
            size_px: self.size_px,
            names_settings: true,
            frame_ends_s: self.frame_ends_s,
        };
        let script = Script { recording: Some(recording), ..self.script };
        let written = self.output.finish_with(script.to_ron().as_bytes());
        written.map_err(|error| Failure::file("write", &self.path, &error))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use lab::cost::{Bench, Plan, Setting, Subject};
    use motion::clock::FrameClock;

    use super::*;
    use crate::app::player::Player;
    use crate::app::session::Session;
    use crate::app::ui::Control;
    use crate::input::{Button, InputFrame, Key};
    use crate::output::report::state_hash;
    use crate::tools::tool::Edit;
    use crate::view::options::Options;

    const SIZE: [u32; 2] = [1280, 1200];

    fn load(scene: &str) -> scene::Scene {
        scene::load(scene).expect("it is shipped")
    }

    fn session() -> Session {
        Session::new(load("orbit"), Options { pictures: false, size_px: SIZE, ..Options::default() })
    }

    /// How fast the machine is that measures what a panel offers.
    #[derive(Clone, Copy, Debug)]
    enum Machine {
        /// It never comes to a result.
        Slow,
        Usual,
        Fast,
    }

    impl Machine {
        fn measure(self, session: &mut Session) {
            let Some(live) = &mut session.tools.cost.live else { return };
            match self {
                Self::Slow => {
                    live.bench = Bench::new(Subject::of_scene(load("thousand"), None), Plan::live());
                }
                Self::Usual => {}
                Self::Fast => {
                    live.bench.work(0.02);
                }
            }
        }
    }

    /// A session that is recorded as the window does it.
    struct Live {
        session: Session,
        clock: FrameClock,
        recorder: Recorder,
    }

    impl Live {
        fn frame(&mut self, events: Vec<Input>) {
            let time = self.clock.advance_by(0.05).expect("time goes on");
            let (frame, chosen) = (self.session.frames(), &self.session.chosen);
            self.recorder.record(frame, time.total(), chosen.iter().chain(&events));
            self.session.advance(&InputFrame { events }, time);
        }

        fn press(&mut self, key: &str) {
            let key: Key = key.parse().expect("a key");
            self.frame(vec![Input::KeyDown(key.clone())]);
            self.frame(vec![Input::KeyUp(key)]);
            self.frame(Vec::new());
        }

        /// The settings that are offered and not the present one.
        fn offered(&self) -> Vec<Control> {
            let Setting { method, substeps, .. } = self.session.setting();
            let present = format!("{} x {substeps}", method.claims().title);
            let offered = |control: &Control| {
                control.role == "Button" && control.name.contains(" x ") && control.name != present
            };
            self.session.controls().into_iter().filter(offered).collect()
        }
    }

    /// Method and substeps and the state at the end of a recording that is repeated on a machine.
    fn repeated(script: Script, machine: Machine) -> (Setting, u64) {
        let (mut session, mut clock) = (session(), FrameClock::default());
        let ends = script.recording.clone().expect("a recording").frame_ends_s;
        session.play(Player::new(script).expect("keys that there are"));
        for end in ends {
            machine.measure(&mut session);
            let time = clock.advance_to(end).expect("time goes on");
            session.advance(&InputFrame::NOTHING, time);
        }
        assert!(session.player().is_some_and(Player::finished));
        (session.setting(), state_hash(&session))
    }

    #[test]
    fn a_setting_that_was_chosen_in_a_panel_is_the_same_wherever_the_recording_is_repeated() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("recording.ron");
        let recorder = Recorder::new(&path, "orbit", None, SIZE).expect("a file");
        let mut live = Live { session: session(), clock: FrameClock::default(), recorder };
        let start = live.session.setting();
        let _ = live.session.controls();
        live.press("F10");
        live.press("C");
        while live.offered().len() < 3 {
            live.frame(Vec::new());
        }
        let Some(Control { rect_px: [left, top, right, bottom], .. }) = live.offered().pop() else { return };
        let DVec2 { x, y } = DVec2::new(left + right, top + bottom) / 2.0;
        live.frame(vec![Input::Mouse(x, y)]);
        live.frame(vec![Input::ButtonDown(Button::Left)]);
        live.frame(vec![Input::ButtonUp(Button::Left)]);
        let clicked = live.session.setting();
        assert_ne!(clicked, start);
        (0..10).for_each(|_| live.frame(Vec::new()));

        // The last control before the edge of the dock is the list of settings.
        for key in ["F6", "Shift+Tab", "Shift+Tab"] {
            live.press(key);
        }
        let focused = |live: &Live| live.session.controls().into_iter().find(|control| control.focused);
        let first = focused(&live).expect("a control");
        assert!(first.role == "ListBox" && first.name.starts_with("on the front: "), "{first:?}");
        live.press("Right");
        let second = focused(&live).expect("a control");
        assert!(second.role == "ListBox" && second.name != first.name, "{second:?}");
        live.press("Enter");
        let chosen = live.session.setting();
        let title = format!("on the front: {} x {}", chosen.method.claims().title, chosen.substeps);
        assert_eq!(second.name, title);
        live.press("Escape");
        // One more in the very last frame.
        live.session.edit(Edit::ApplySetting(Setting { substeps: 7, ..clicked }));
        live.recorder.record_end(live.session.frames(), &live.session.chosen);
        live.recorder.finish().expect("a file");
        let end = (live.session.setting(), state_hash(&live.session));
        assert_ne!(end.0, chosen);

        let text = std::fs::read_to_string(&path).expect("it was written");
        let script = Script::parse("recording.ron", &text).expect("it was written by this program");
        for machine in [Machine::Slow, Machine::Usual, Machine::Fast] {
            assert_eq!(repeated(script.clone(), machine), end, "{machine:?}");
        }
        // Without the steps that name it, a click where nothing was measured chooses nothing.
        let mut unnamed = script;
        unnamed.steps.retain(|step| !step.action.is_experiment());
        assert_eq!(repeated(unnamed, Machine::Slow).0, start);
    }

    #[test]
    fn what_is_clicked_chooses_nothing_in_a_recording_that_names_settings_and_does_in_an_older_one() {
        let chosen = |names_settings: bool, frames: usize| {
            let recording = Recording {
                scene: "orbit".to_owned(),
                method: None,
                size_px: SIZE.into(),
                names_settings,
                frame_ends_s: vec![0.0; frames],
            };
            let script = Script { steps: Vec::new(), recording: Some(recording) };
            let mut session = session();
            session.play(Player::new(script).expect("no keys"));
            session.edit(Edit::ApplySetting(Setting { substeps: 3, ..session.setting() }));
            session.setting().substeps == 3
        };
        assert!(!chosen(true, 1) && chosen(false, 1));
        assert!(chosen(true, 0), "after its end");
    }
}
