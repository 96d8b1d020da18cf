//! Plays a script: turns its steps into the input of frames and of ticks.

use std::collections::VecDeque;

use scene::{Action, ChangeAction, InputAction, Step, When};

use crate::input::{Input, Key};

/// Greatest number of frames that a paused run waits for the next step of its script.
const MOST_PAUSED_FRAMES: u64 = 100_000;

/// Steps with their places in the list.
type Steps = VecDeque<(usize, Step)>;

/// A script that is being played.
#[derive(Clone, Debug)]
pub struct Player {
    of_frames: Steps,
    of_ticks: Steps,
    /// Releases in the next frame that complete clicks.
    afterwards: Vec<Input>,
    /// Keys held until that time, s; each key once.
    held: Vec<(f64, Key)>,
    /// Number of frames, from the first one on, in which the steps of a recording name the chosen settings.
    named_frames: u64,
}

impl Player {
    /// Makes a player of `steps`, which name keys by their own names and, in the first `named_frames` frames, the chosen
    /// settings.
    pub(crate) fn of(steps: Vec<Step>, named_frames: u64) -> Self {
        let (of_ticks, of_frames) =
            steps.into_iter().enumerate().partition(|(_, step)| step.is_of_ticks());
        Self { of_frames, of_ticks, afterwards: Vec::new(), held: Vec::new(), named_frames }
    }

    /// Whether steps name the settings that are chosen in frame number `frame`.
    pub(crate) const fn names_settings(&self, frame: u64) -> bool {
        frame < self.named_frames
    }

    /// Whether every step was carried out, and nothing is held.
    #[must_use]
    pub fn finished(&self) -> bool {
        self.left().next().is_none() && self.afterwards.is_empty() && self.held.is_empty()
    }

    /// The steps that were not carried out, with their places in the list.
    pub fn left(&self) -> impl Iterator<Item = (usize, &Step)> {
        self.of_frames.iter().chain(&self.of_ticks).map(|(place, step)| (*place, step))
    }

    /// The time that a run, paused after `frames` frames and `ticks` ticks, would wait for forever at `rate` frames per second: a
    /// tick, or a frame that is too far ahead. `None` if there is no such wait.
    #[must_use]
    pub fn waits_forever(&self, frames: u64, ticks: u64, rate: f64) -> Option<When> {
        #[expect(clippy::cast_precision_loss, reason = "counts of frames")]
        let last = frames.saturating_add(MOST_PAUSED_FRAMES) as f64;
        if !self.afterwards.is_empty() || self.held.iter().any(|(until, _)| until * rate <= last) {
            return None;
        }
        let Some((_, Step { when, .. })) = self.of_frames.front() else {
            let key = self.held.first().map(|(until, _)| When::Seconds(*until));
            return self.of_ticks.front().map(|(_, step)| step.when).or(key);
        };
        #[expect(clippy::cast_precision_loss, reason = "a count of frames")]
        let forever = match *when {
            When::Tick(tick) => tick > ticks,
            When::Frame(frame) => frame as f64 > last,
            When::Seconds(time) => time * rate > last,
        };
        forever.then_some(*when)
    }

    /// The input of frame number `frame`, which begins after `ticks` ticks and at `start` seconds, and ends at `total` seconds.
    ///
    /// A step is due in the first frame that ends at its time or later, or begins with that many ticks done.
    pub fn of_frame(&mut self, frame: u64, ticks: u64, start: f64, total: f64) -> Vec<Input> {
        let mut events = std::mem::take(&mut self.afterwards);
        // Frame times are quotients: the frame that ends at 0.5 s may end a rounding earlier.
        let reached = |time: f64| time - total <= 1e-9_f64.max(4.0 * f64::EPSILON * total);
        let over = self.held.extract_if(.., |(until, _)| reached(*until));
        events.extend(over.map(|(_, key)| Input::KeyUp(key)));
        while let Some((_, step)) = self.of_frames.pop_front_if(|(_, step)| match step.when {
            When::Seconds(time) => reached(time),
            When::Tick(tick) => tick <= ticks,
            When::Frame(number) => number <= frame,
        }) {
            // A key with a time acts from that time on, whatever the frames are; a key with a frame acts from the start of the
            // frame on.
            let at = if let When::Seconds(time) = step.when { Some(time.max(start)) } else { None };
            let names_key = step.action.key().is_some();
            events.extend(at.filter(|_| names_key).map(Input::At));
            events.extend(self.input(step.action, [at.unwrap_or(start), total]));
        }
        events
    }

    /// The inputs before the tick that starts at `start` seconds and lasts `length` seconds, after `ticks` earlier ticks.
    pub fn of_tick(&mut self, ticks: u64, start: f64, length: f64) -> Vec<Input> {
        let mut inputs = Vec::new();
        while let Some((_, step)) =
            self.of_ticks.pop_front_if(|(_, step)| step.when.is_due(ticks, start, length))
        {
            inputs.extend(self.input(step.action, [start; 2]));
        }
        inputs
    }

    /// Presses `key`, and releases it in the first frame that ends at `until` or later; its push ends at `pushes_until`. A key
    /// that is held already is released at the later of its two times.
    fn hold(&mut self, key: Key, until: f64, pushes_until: f64) -> Input {
        match self.held.iter_mut().find(|(_, held)| *held == key) {
            Some((end, _)) => *end = end.max(until),
            None => self.held.push((until, key.clone())),
        }
        Input::KeyDownUntil(key, pushes_until)
    }

    /// Converts `action` to an input at `at` seconds, in a frame that ends at `end` seconds; `None` if it waits.
    fn input(&mut self, action: Action, [at, end]: [f64; 2]) -> Option<Input> {
        let key = |word: &str| word.parse::<Key>().expect("checked when the script was read");
        let input = match action {
            Action::Input(input) => input,
            Action::Change(change) => return Some(Input::Change(change)),
            Action::Picture(picture) => return Some(Input::Picture(picture)),
        };
        Some(match input {
            InputAction::Wait(_) => return None,
            // Held until the next frame; it pushes for one tick.
            InputAction::Press(word) => self.hold(key(&word), end, at),
            InputAction::Hold(word, seconds) => self.hold(key(&word), end + seconds, at + seconds),
            InputAction::KeyDown(word) => Input::KeyDown(key(&word)),
            InputAction::KeyUp(word) => Input::KeyUp(key(&word)),
            InputAction::At(time) => Input::At(time),
            InputAction::Text(text) => Input::Text(text),
            InputAction::Compose(text) => Input::Compose(text),
            InputAction::Assist(request) => Input::Assist(request),
            InputAction::MoveMouse(x, y) => Input::Mouse(x, y),
            InputAction::MouseDown(button) => Input::ButtonDown(button),
            InputAction::MouseUp(button) => Input::ButtonUp(button),
            InputAction::Click(button) => {
                self.afterwards.push(Input::ButtonUp(button));
                Input::ButtonDown(button)
            }
            InputAction::Wheel(notches) => Input::Wheel(notches),
            InputAction::Touch(finger, phase, x, y) => Input::Touch(finger, phase, x, y),
            InputAction::FocusLost => Input::FocusLost,
            InputAction::Resize(width, height) => Input::Resized([width, height]),
            InputAction::Scale(scale) => Input::Scaled(scale),
            InputAction::DockWidth(points) => Input::DockWidth(points),
            InputAction::Arrange(text) => Input::Arrange(text),
        })
    }
}

/// The script action that records `input`; `None` for inputs that only a script makes.
#[must_use]
pub fn recorded(input: &Input) -> Option<Action> {
    Some(Action::Input(match input {
        Input::KeyDown(key) => InputAction::KeyDown(key.to_string()),
        Input::KeyUp(key) => InputAction::KeyUp(key.to_string()),
        Input::At(time) => InputAction::At(*time),
        Input::Text(text) => InputAction::Text(text.clone()),
        Input::Compose(text) => InputAction::Compose(text.clone()),
        Input::Assist(request) => InputAction::Assist(request.clone()),
        Input::Mouse(x, y) => InputAction::MoveMouse(*x, *y),
        Input::ButtonDown(which) => InputAction::MouseDown(*which),
        Input::ButtonUp(which) => InputAction::MouseUp(*which),
        Input::Wheel(notches) => InputAction::Wheel(*notches),
        Input::Touch(finger, phase, x, y) => InputAction::Touch(*finger, *phase, *x, *y),
        Input::FocusLost => InputAction::FocusLost,
        Input::Resized([width, height]) => InputAction::Resize(*width, *height),
        Input::Scaled(scale) => InputAction::Scale(*scale),
        Input::Change(change @ (ChangeAction::SetMethod(_) | ChangeAction::SetSubsteps(_))) => {
            return Some(Action::Change(change.clone()));
        }
        Input::DockWidth(points) => InputAction::DockWidth(*points),
        Input::Arrange(text) => InputAction::Arrange(text.clone()),
        Input::KeyDownUntil(..) | Input::Change(_) | Input::Picture(_) => return None,
    }))
}
