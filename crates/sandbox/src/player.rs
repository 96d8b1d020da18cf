//! Plays a script: turns its steps into the input of frames.

use motion::Request;
use motion::units::Vector;
use scene::{Action, MouseButton, Script, Step, When};

use crate::actions::{self, Key, UnknownKey};
use crate::input::{Button, Experiment, Input, InputFrame};
use crate::session::Session;

/// Frames that a paused run waits for the next step of its script.
const MOST_PAUSED_FRAMES: u64 = 100_000;

/// A script on its way.
#[derive(Clone, Debug)]
pub struct Player {
    steps: std::vec::IntoIter<Step>,
    next: Option<Step>,
    /// Inputs that a press or a click leaves for the next frame.
    afterwards: Vec<Input>,
    /// Keys held until that time, s.
    held: Vec<(f64, Key)>,
}

impl Player {
    /// Prepares `script`, all key names checked.
    ///
    /// # Errors
    /// Every step that names no key: its index and the word.
    pub fn new(script: Script) -> Result<Self, Vec<(usize, UnknownKey)>> {
        let unknown: Vec<_> = script
            .steps
            .iter()
            .enumerate()
            .filter_map(|(i, step)| match &step.action {
                Action::Press(word) | Action::Hold(word, _) | Action::KeyDown(word) | Action::KeyUp(word) => {
                    actions::key_of_word(word).err().map(|error| (i, error))
                }
                _ => None,
            })
            .collect();
        if !unknown.is_empty() {
            return Err(unknown);
        }
        let mut steps = script.steps.into_iter();
        let next = steps.next();
        Ok(Self { steps, next, afterwards: Vec::new(), held: Vec::new() })
    }

    /// Whether every step was carried out.
    #[must_use]
    pub fn finished(&self) -> bool {
        self.next.is_none() && self.afterwards.is_empty() && self.held.is_empty()
    }

    /// What a run that is paused after `session`'s last frame waits for in vain, at `rate` frames a second: a tick, or a
    /// frame that is too far ahead for anybody to wait.
    #[must_use]
    pub fn waits_in_vain(&self, session: &Session, rate: f64) -> Option<String> {
        #[expect(clippy::cast_precision_loss, reason = "counts of frames")]
        let last = session.frames().saturating_add(MOST_PAUSED_FRAMES) as f64;
        let next = self.next.as_ref().filter(|_| self.afterwards.is_empty() && self.held.is_empty())?;
        match next.when {
            When::Tick(tick) if tick > session.ticks() => Some(format!("tick {tick}")),
            #[expect(clippy::cast_precision_loss, reason = "a count of frames")]
            When::Frame(frame) if frame as f64 > last => Some(format!("frame {frame}")),
            When::Seconds(time) if time * rate > last => Some(format!("{time} s")),
            _ => None,
        }
    }

    /// The input of the frame that ends at `total` seconds, the session's next.
    ///
    /// A step is due in the first frame that ends at its time or later, or starts with that many ticks done.
    pub fn input(&mut self, session: &Session, total: f64) -> InputFrame {
        let mut events = std::mem::take(&mut self.afterwards);
        // Frame times are quotients: the frame that ends at 0.5 s may end a rounding earlier.
        let reached = |time: f64| time <= total + 1e-9;
        for (until, key) in std::mem::take(&mut self.held) {
            if reached(until) {
                events.push(Input::KeyUp(key));
            } else {
                self.held.push((until, key));
            }
        }
        while let Some(step) = self.next.take_if(|step| match step.when {
            When::Seconds(time) => reached(time),
            When::Tick(tick) => tick <= session.ticks(),
            When::Frame(frame) => frame <= session.frames(),
        }) {
            self.carry_out(step.action, total, &mut events);
            self.next = self.steps.next();
        }
        InputFrame { events }
    }

    fn carry_out(&mut self, action: Action, total: f64, events: &mut Vec<Input>) {
        let key = |word: &str| actions::key_of_word(word).expect("checked when the script was read");
        let experiment = |experiment| Input::Experiment(experiment);
        let of_body =
            |name, request, value: Vector| experiment(Experiment::OfBody(name, request, value.to_array()));
        events.push(match action {
            Action::Press(word) => {
                self.afterwards.push(Input::KeyUp(key(&word)));
                Input::KeyDown(key(&word))
            }
            Action::Hold(word, seconds) => {
                self.held.push((total + seconds, key(&word)));
                Input::KeyDown(key(&word))
            }
            Action::KeyDown(word) => Input::KeyDown(key(&word)),
            Action::KeyUp(word) => Input::KeyUp(key(&word)),
            Action::Text(text) => Input::Text(text),
            Action::MoveMouse(x, y) => Input::Mouse(x, y),
            Action::MouseDown(button) => Input::ButtonDown(button_of(button)),
            Action::MouseUp(button) => Input::ButtonUp(button_of(button)),
            Action::Click(button) => {
                self.afterwards.push(Input::ButtonUp(button_of(button)));
                Input::ButtonDown(button_of(button))
            }
            Action::Wheel(notches) => Input::Wheel(notches),
            Action::FocusLost => Input::FocusLost,
            Action::Resize(width, height) => Input::Resized([width, height]),
            Action::Scale(scale) => Input::Scaled(scale),
            Action::Push(body, newtons) => experiment(Experiment::Push(body, newtons.to_array())),
            Action::Impulse(body, value) => of_body(body, Request::Impulse, value),
            Action::SetVelocity(body, value) => of_body(body, Request::SetVelocity, value),
            Action::SetPosition(body, value) => of_body(body, Request::SetPosition, value),
            Action::SetGravity(value) => experiment(Experiment::OfWorld(Request::SetGravity(value))),
            Action::SetDamping(rate) => experiment(Experiment::DampingRate(rate)),
            Action::ReverseVelocities => experiment(Experiment::OfWorld(Request::ReverseVelocities)),
            Action::Remove(body) => experiment(Experiment::Remove(body)),
            Action::Screenshot(name) => experiment(Experiment::Screenshot(name)),
            Action::SetBodyMethod(body, method) => experiment(Experiment::BodyMethod(body, Some(method))),
            Action::SetMethod(method) => experiment(Experiment::Method(method)),
            Action::SwitchEffect(effect, on) => experiment(Experiment::SwitchEffect(effect, on)),
        });
    }
}

const fn button_of(button: MouseButton) -> Button {
    match button {
        MouseButton::Left => Button::Left,
        MouseButton::Right => Button::Right,
        MouseButton::Middle => Button::Middle,
    }
}

/// The script's word for an input, for recordings; `None` for what only a script does.
#[must_use]
pub fn recorded(input: &Input) -> Option<Action> {
    let button = |button: Button| match button {
        Button::Left => MouseButton::Left,
        Button::Right => MouseButton::Right,
        Button::Middle => MouseButton::Middle,
    };
    Some(match input {
        Input::KeyDown(key) => Action::KeyDown(key.to_string()),
        Input::KeyUp(key) => Action::KeyUp(key.to_string()),
        Input::Text(text) => Action::Text(text.clone()),
        Input::Mouse(x, y) => Action::MoveMouse(*x, *y),
        Input::ButtonDown(which) => Action::MouseDown(button(*which)),
        Input::ButtonUp(which) => Action::MouseUp(button(*which)),
        Input::Wheel(notches) => Action::Wheel(*notches),
        Input::FocusLost => Action::FocusLost,
        Input::Resized([width, height]) => Action::Resize(*width, *height),
        Input::Scaled(scale) => Action::Scale(*scale),
        Input::Experiment(_) => return None,
    })
}
