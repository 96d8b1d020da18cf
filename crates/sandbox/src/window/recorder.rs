//! Records inputs and frame times, so that `sandbox run --script` ends in the same state.
//!
//! The file is a valid recording from the first frame on. The first of its two lists, the ends of the frames, is followed by
//! blanks: a frame is written over some of them, and its steps over the end of the file. When the blanks are used up, the whole
//! file is written again, with as many blanks as the ends of the frames have bytes, but at least [`LEAST_ROOM`].

use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write as _};

use motion::Method;
use scene::{Recording, RecordingText, Step, When};

use crate::failure::Failure;
use crate::output::files::{Output, OutputPath, output_file};
use cockpit::app::player::recorded;
use cockpit::input::Input;

/// Least number of blanks after the ends of the frames, bytes: a minute of frames.
const LEAST_ROOM: usize = 1 << 16;

/// A recording in progress, and its file.
pub(super) struct Recorder {
    path: OutputPath,
    text: RecordingText,
    last_end: Option<f64>,
    file: RecordingFile,
}

enum RecordingFile {
    /// An older recording stays until the first frame; a device gets the whole text at the end.
    Waiting(Output),
    /// The file has everything up to the last frame.
    Growing(Growing),
    /// The file could not be written. Its contents stay valid, and the end of the recording tries again.
    Failed,
}

/// A file with room for more frames, and how much of the text it has, bytes.
struct Growing {
    file: File,
    ends: usize,
    steps: usize,
    room: usize,
}

impl Growing {
    /// Puts `text` in the place of `output`.
    fn start(mut output: Output, text: &RecordingText) -> io::Result<Self> {
        let (ends, steps) = (text.ends().1.len(), text.steps(0).1.len());
        let room = ends.max(LEAST_ROOM);
        output.write_all(text.whole(room).as_bytes())?;
        Ok(Self { file: output.put_in_place()?, ends, steps, room })
    }

    /// Writes what `text` has beyond the file. Returns `false` if there is no room for it.
    fn grow(&mut self, text: &RecordingText) -> io::Result<bool> {
        let (start, ends) = text.ends();
        let Some(room) = self.room.checked_sub(ends.len() - self.ends) else { return Ok(false) };
        // Steps first, so that every frame in the file has its steps.
        let (steps_start, steps) = text.steps(room);
        let end = steps_start + self.steps;
        if steps.len() > self.steps
            && let Err(error) =
                self.write_at(end, &[&steps[self.steps..], RecordingText::END].concat())
        {
            self.write_at(end, RecordingText::END)?;
            self.file.set_len((end + RecordingText::END.len()) as u64)?;
            return Err(error);
        }
        self.steps = steps.len();
        self.write_at(start + self.ends, &ends[self.ends..])?;
        (self.ends, self.room) = (ends.len(), room);
        Ok(true)
    }

    fn write_at(&mut self, place: usize, text: &str) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(place as u64))?;
        self.file.write_all(text.as_bytes())
    }
}

impl Recorder {
    /// Starts a recording that will be written to `path`.
    pub fn new(
        path: OutputPath,
        scene: &str,
        method: Option<Method>,
        size: [u32; 2],
    ) -> Result<Self, Failure> {
        // Opened now, so that a file that cannot be written is an error before a person has played for an hour.
        let output = output_file(&path)?;
        let recording = Recording {
            scene: scene.to_owned(),
            method,
            size_px: size.into(),
            names_settings: true,
            frame_ends_s: Vec::new(),
        };
        let text = RecordingText::new(&recording);
        Ok(Self { path, text, last_end: None, file: RecordingFile::Waiting(output) })
    }

    /// Records a frame. Returns an error, once, if the file cannot be written.
    pub fn record<'a>(
        &mut self,
        frame: u64,
        end: f64,
        events: impl IntoIterator<Item = &'a Input>,
    ) -> Result<(), Failure> {
        self.add(frame, end, events);
        self.write().map_err(|error| {
            self.file = RecordingFile::Failed;
            Failure::file("write", self.path.as_ref(), &error)
        })
    }

    fn add<'a>(&mut self, frame: u64, end: f64, events: impl IntoIterator<Item = &'a Input>) {
        self.last_end = Some(end);
        self.text.add_frame(end);
        for action in events.into_iter().filter_map(recorded) {
            self.text.add_step(&Step { when: When::Frame(frame), action });
        }
    }

    fn write(&mut self) -> io::Result<()> {
        let done = match &mut self.file {
            RecordingFile::Waiting(output) => output.is_device_or_pipe(),
            RecordingFile::Growing(file) => file.grow(&self.text)?,
            RecordingFile::Failed => true,
        };
        if !done {
            let output = match std::mem::replace(&mut self.file, RecordingFile::Failed) {
                RecordingFile::Waiting(output) => output,
                RecordingFile::Growing(_) | RecordingFile::Failed => Output::create(&self.path)?,
            };
            self.file = RecordingFile::Growing(Growing::start(output, &self.text)?);
        }
        Ok(())
    }

    /// Records what was chosen in the last frame as a frame that takes no time, and writes the recording without blanks.
    pub fn finish(mut self, frame: u64, chosen: &[Input]) -> Result<(), Failure> {
        if let Some(end) = self.last_end.filter(|_| !chosen.is_empty()) {
            self.add(frame, end, chosen);
        }
        let output = match self.file {
            RecordingFile::Waiting(output) => Ok(output),
            RecordingFile::Growing(_) | RecordingFile::Failed => Output::create(&self.path),
        };
        let written = output.and_then(|output| output.finish_with(self.text.whole(0).as_bytes()));
        written.map_err(|error| Failure::file("write", self.path.as_ref(), &error))
    }
}

#[cfg(test)]
mod tests {
    use cockpit::clock::FrameClock;
    use glam::DVec2;
    use lab::cost::{Bench, Plan, Setting, Subject};
    use scene::Script;

    use super::*;
    use crate::output::report::state_hash;
    use cockpit::app::player::Player;
    use cockpit::app::session::Session;
    use cockpit::app::ui::Control;
    use cockpit::input::{Button, InputFrame, Key};
    use cockpit::intent::Intent;
    use cockpit::stage::options::Options;

    const SIZE: [u32; 2] = [1280, 1200];

    fn load(scene: &str) -> scene::Scene {
        scene::load(scene).expect("it is shipped")
    }

    fn session() -> Session {
        Session::new(
            load("orbit"),
            Options { pictures: false, size_px: SIZE, ..Options::default() },
        )
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
            let Some(study) = session.tools.study() else { return };
            match self {
                Self::Slow => {
                    *study = Bench::new(Subject::of_scene(load("thousand"), None), Plan::live());
                }
                Self::Usual => {}
                Self::Fast => {
                    study.work(0.02);
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
            let time = self.clock.advance_by(0.05).expect("time does not go back");
            let (frame, chosen) = (self.session.stage.playback().frames(), &self.session.chosen);
            self.recorder
                .record(frame, time.total(), chosen.iter().chain(&events))
                .expect("a file");
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
            let Setting { method, substeps, .. } = self.session.stage.setting();
            let present = format!("{} x {substeps:#}", method.claims().title);
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
            let time = clock.advance_to(end).expect("time does not go back");
            session.advance(&InputFrame::NOTHING, time);
        }
        assert!(session.player().is_some_and(Player::finished));
        (session.stage.setting(), state_hash(&session.stage))
    }

    #[test]
    fn a_setting_that_was_chosen_in_a_panel_is_the_same_wherever_the_recording_is_repeated() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("recording.ron");
        let recorder =
            Recorder::new(OutputPath::of_program(&path), "orbit", None, SIZE).expect("a file");
        let mut live = Live { session: session(), clock: FrameClock::default(), recorder };
        let start = live.session.stage.setting();
        let _ = live.session.controls();
        live.press("F10");
        live.press("C");
        while live.offered().len() < 3 {
            live.frame(Vec::new());
        }
        let Some(Control { rect_px: [left, top, right, bottom], .. }) = live.offered().pop() else {
            return;
        };
        let DVec2 { x, y } = DVec2::new(left + right, top + bottom) / 2.0;
        live.frame(vec![Input::Mouse(x, y)]);
        live.frame(vec![Input::ButtonDown(Button::Left)]);
        live.frame(vec![Input::ButtonUp(Button::Left)]);
        let clicked = live.session.stage.setting();
        assert_ne!(clicked, start);
        (0..10).for_each(|_| live.frame(Vec::new()));

        // The last controls before the edge of the dock are the list of settings and the details.
        for key in ["F6", "Shift+Tab", "Shift+Tab", "Shift+Tab"] {
            live.press(key);
        }
        let focused =
            |live: &Live| live.session.controls().into_iter().find(|control| control.focused);
        let first = focused(&live).expect("a control");
        assert!(first.role == "ListBox" && first.name.starts_with("on the front: "), "{first:?}");
        live.press("Right");
        let second = focused(&live).expect("a control");
        assert!(second.role == "ListBox" && second.name != first.name, "{second:?}");
        live.press("Enter");
        let chosen = live.session.stage.setting();
        let title = format!("on the front: {} x {}", chosen.method.claims().title, chosen.substeps);
        assert_eq!(second.name, title);
        live.press("Escape");
        // One more in the very last frame.
        live.session.carry_out(Intent::ApplySetting(Setting { substeps: 7.into(), ..clicked }));
        live.recorder
            .finish(live.session.stage.playback().frames(), &live.session.chosen)
            .expect("a file");
        let end = (live.session.stage.setting(), state_hash(&live.session.stage));
        assert_ne!(end.0, chosen);

        let text = std::fs::read_to_string(&path).expect("it was written");
        let script = Script::parse("recording.ron", &text).expect("it was written by this program");
        for machine in [Machine::Slow, Machine::Usual, Machine::Fast] {
            assert_eq!(repeated(script.clone(), machine), end, "{machine:?}");
        }
        // Without the steps that name it, a click where nothing was measured chooses nothing.
        let mut unnamed = script;
        unnamed.steps.retain(|step| step.action.change().is_none());
        assert_eq!(repeated(unnamed, Machine::Slow).0, start);
    }

    /// The recording in the file at `path`, if it is one.
    fn read(path: &std::path::Path) -> Result<Script, scene::SceneError> {
        Script::parse("recording.ron", &std::fs::read_to_string(path).expect("a file"))
    }

    #[test]
    fn the_file_is_a_recording_of_all_frames_after_each_of_them_and_at_the_end_as_short_as_can_be()
    {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("recording.ron");
        std::fs::write(&path, "older").expect("a folder");
        let mut recorder =
            Recorder::new(OutputPath::of_program(&path), "orbit", None, SIZE).expect("a file");
        assert_eq!(
            std::fs::read_to_string(&path).expect("a file"),
            "older",
            "until the first frame"
        );
        let (mut ends, mut steps, mut longest) = (Vec::new(), Vec::new(), 0);
        // Some 17 bytes for each of them: the room is used up, and used up again.
        for frame in 0..10_000_u32 {
            let end = f64::from(frame) / 3.0;
            let wheel = (frame % 5 == 0).then(|| Input::Wheel(f64::from(frame)));
            recorder.record(u64::from(frame), end, &wheel).expect("a file");
            ends.push(end);
            steps.extend(wheel.iter().filter_map(recorded));
            longest = longest.max(std::fs::metadata(&path).expect("a file").len());
            if frame % 500 < 2 {
                let script = read(&path).unwrap_or_else(|error| panic!("frame {frame}: {error}"));
                assert_eq!(script.recording.expect("a recording").frame_ends_s, ends);
                assert!(script.steps.into_iter().map(|step| step.action).eq(steps.iter().cloned()));
            }
        }
        assert!(longest < 600_000, "{longest} bytes");
        recorder.finish(10_000, &[]).expect("a file");
        let text = std::fs::read_to_string(&path).expect("a file");
        assert_eq!(text, read(&path).expect("a recording").to_ron());
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_recording_into_a_device_is_written_at_its_end() {
        let on = |device: &str| {
            Recorder::new(OutputPath::of_program(device.as_ref()), "orbit", None, SIZE)
        };
        let mut recorder = on("/dev/null").expect("a device");
        recorder.record(0, 0.1, &[]).expect("a device");
        recorder.finish(1, &[]).expect("a device");
        let mut recorder = on("/dev/full").expect("a device");
        recorder.record(0, 0.1, &[]).expect("nothing is written yet");
        assert!(recorder.finish(1, &[]).is_err());
    }

    #[test]
    fn what_is_clicked_chooses_nothing_in_a_recording_that_names_settings_and_does_in_an_older_one()
    {
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
            session.carry_out(Intent::ApplySetting(Setting {
                substeps: 3.into(),
                ..session.stage.setting()
            }));
            session.stage.setting().substeps == 3.into()
        };
        assert!(!chosen(true, 1) && chosen(false, 1));
        assert!(chosen(true, 0), "after its end");
    }
}
