//! What a script can do, and when: every input of a person, and changes of the simulation.

use std::fmt;

use glam::DVec3;
use motion::effects::Effect;
use motion::{Method, Substeps};
use serde::{Deserialize, Serialize};

/// One thing that a script does. In a file an action is written as its name in snake case: `press("G")`,
/// `move_mouse(640, 360)`, `set_gravity((0, -1.6, 0))`.
///
/// Names of keys and actions are the key table's, which is not this crate's to know; numbers of changes may
/// be non-finite on purpose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Presses the key of that name in this frame and lets it go in the next; one that pushes acts for one tick.
    Press(String),
    /// Holds a key for so many seconds, above 0; one that pushes acts in the ticks of that time.
    Hold(String, f64),
    /// Does nothing for so many seconds, above 0; in lessons.
    Wait(f64),
    /// Presses a key and leaves it down; for recordings.
    KeyDown(String),
    /// Lets a key go; for recordings.
    KeyUp(String),
    /// The time at which the next key goes down or up, s, at least 0, within its frame; for recordings.
    At(f64),
    /// Types characters into the field that has the focus; for recordings.
    Text(String),
    /// Puts the pointer on a pixel in selection mode; turns the camera by as much in camera mode.
    MoveMouse(f64, f64),
    /// Presses a mouse button.
    MouseDown(MouseButton),
    /// Lets a mouse button go.
    MouseUp(MouseButton),
    /// Presses a mouse button in this frame and lets it go in the next.
    Click(MouseButton),
    /// Turns the wheel by so many notches, away from the person positive.
    Wheel(f64),
    /// The window loses the focus: every key and button is let go.
    FocusLost,
    /// The window gets a new size, px, each 1 to 16384.
    Resize(u32, u32),
    /// The display has so many pixels a point of the panels, above 0.
    Scale(f64),
    /// The dock gets that width, points, above 0.
    DockWidth(f64),
    /// Arranges the panels as that text says, which is what the window remembers; for recordings.
    Arrange(String),
    /// Pushes a body for one tick, N.
    Push(String, #[serde(with = "triple")] DVec3),
    /// Gives a body an impulse, N s.
    Impulse(String, #[serde(with = "triple")] DVec3),
    /// Sets the acceleration of gravity, m/s².
    SetGravity(#[serde(with = "triple")] DVec3),
    /// Sets the scene's damping rate, 1/s.
    SetDamping(f64),
    /// Sets a body's velocity, m/s.
    SetVelocity(String, #[serde(with = "triple")] DVec3),
    /// Sets a body's position, m.
    SetPosition(String, #[serde(with = "triple")] DVec3),
    /// Turns every velocity round.
    ReverseVelocities,
    /// Removes a body.
    Remove(String),
    /// Writes the picture of this frame under that plain file name, which ends in `.png`.
    Screenshot(String),
    /// Writes that line below pictures with captions from now on, in place of the description of the scene.
    Caption(String),
    /// Changes the method of the scene: of every body without one of its own.
    SetMethod(#[serde(with = "method")] Method),
    /// Changes the substeps of the scene: of every body without its own, 1 to [`Substeps::MOST`].
    SetSubsteps(u32),
    /// Gives a body a method of its own.
    SetBodyMethod(String, #[serde(with = "method")] Method),
    /// Switches an effect that the scene declares on or off.
    SwitchEffect(#[serde(with = "effect")] Effect, bool),
}

/// A button of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MouseButton {
    /// Selects.
    Left,
    /// Pushes.
    Right,
    /// The wheel, pressed.
    Middle,
}

/// Most characters of a caption.
const LONGEST_CAPTION: usize = 300;

/// Largest side of a window, px: what graphics devices commonly offer.
const LARGEST_SIDE: u32 = 16_384;

impl Action {
    /// The body that the action names, if it names one.
    #[must_use]
    pub fn body(&self) -> Option<&str> {
        match self {
            Self::Push(body, _)
            | Self::Impulse(body, _)
            | Self::SetVelocity(body, _)
            | Self::SetPosition(body, _)
            | Self::Remove(body)
            | Self::SetBodyMethod(body, _) => Some(body),
            _ => None,
        }
    }

    /// The effect of the scene that the action changes, if it changes one.
    #[must_use]
    pub const fn effect(&self) -> Option<Effect> {
        match self {
            Self::SetGravity(_) => Some(Effect::Gravity),
            Self::SetDamping(_) => Some(Effect::Damping),
            Self::SwitchEffect(effect, _) => Some(*effect),
            _ => None,
        }
    }

    /// Whether the action changes bodies, laws or methods, as no input of a person does.
    #[must_use]
    pub const fn is_change(&self) -> bool {
        matches!(
            self,
            Self::Push(..)
                | Self::Impulse(..)
                | Self::SetGravity(_)
                | Self::SetDamping(_)
                | Self::SetVelocity(..)
                | Self::SetPosition(..)
                | Self::ReverseVelocities
                | Self::Remove(_)
                | Self::SetMethod(_)
                | Self::SetSubsteps(_)
                | Self::SetBodyMethod(..)
                | Self::SwitchEffect(..)
        )
    }

    /// The key or named action that the action presses or lets go, if it does.
    #[must_use]
    pub fn key(&self) -> Option<&str> {
        match self {
            Self::Press(key) | Self::Hold(key, _) | Self::KeyDown(key) | Self::KeyUp(key) => Some(key),
            _ => None,
        }
    }

    /// What is wrong with the action's values, and what would be right.
    pub(crate) fn fault(&self) -> Option<(String, String)> {
        let (what, cure) = match self {
            Self::Press(key) | Self::Hold(key, _) | Self::KeyDown(key) | Self::KeyUp(key)
                if key.is_empty() =>
            {
                ("the name of the key is empty".to_owned(), "give the name of a key")
            }
            Self::Hold(_, seconds) if !(*seconds > 0.0 && seconds.is_finite()) => {
                (format!("{seconds} is not a time to hold a key"), "give a positive number of seconds")
            }
            Self::Wait(seconds) if !(*seconds > 0.0 && seconds.is_finite()) => {
                (format!("{seconds} is not a time to wait"), "give a positive number of seconds")
            }
            Self::At(time) if !(*time >= 0.0 && time.is_finite()) => {
                (format!("{time} s is not a time of a key"), "give a number of seconds, at least 0")
            }
            Self::MoveMouse(x, y) if !(x.is_finite() && y.is_finite()) => {
                (format!("({x}, {y}) is not a pixel"), "give two finite numbers")
            }
            Self::Wheel(notches) if !notches.is_finite() => {
                (format!("{notches} is not a number of notches"), "give a finite number")
            }
            Self::SetDamping(rate) if *rate < 0.0 => {
                (format!("{rate} is not a rate"), "give a number of 1/s, at least 0")
            }
            Self::Scale(scale) if !(scale.is_finite() && *scale > 0.0) => {
                (format!("{scale} is not a scale"), "give a positive number")
            }
            Self::DockWidth(points) if !(points.is_finite() && *points > 0.0) => {
                (format!("{points} is not a width"), "give a positive number of points")
            }
            Self::Resize(x, y) if ![x, y].into_iter().all(|side| (1..=LARGEST_SIDE).contains(side)) => {
                (format!("{x} x {y} is not a window size"), "give two numbers of pixels from 1 to 16384")
            }
            Self::SetSubsteps(substeps) if !(1..=Substeps::MOST).contains(substeps) => {
                (format!("{substeps} is not a number of substeps"), "give a whole number from 1 to 100000")
            }
            Self::Caption(words)
                if words.chars().count() > LONGEST_CAPTION || words.contains(char::is_control) =>
            {
                (format!("{words:?} is not a caption"), "give a line of at most 300 characters")
            }
            Self::Screenshot(name) if !is_picture_name(name) => (
                format!("{name:?} is not a plain file name that ends in .png"),
                "give one such as \"push.png\"",
            ),
            _ => return None,
        };
        Some((what, cure.to_owned()))
    }
}

/// What happens, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// When it is due.
    pub when: When,
    /// What happens.
    pub action: Action,
}

impl Step {
    /// Whether the step waits for a tick, so that what it does is the same for all frames: changes do, unless they have the
    /// number of a frame.
    #[must_use]
    pub const fn is_of_ticks(&self) -> bool {
        self.action.is_change() && !matches!(self.when, When::Frame(_))
    }
}

/// The moment from which a step is due.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// Seconds from the start, finite and at least 0.
    Seconds(f64),
    /// So many ticks done.
    Tick(u64),
    /// The frame of that number, from 0.
    Frame(u64),
}

impl When {
    /// Whether it has come for the tick that starts at `start` seconds and lasts `length` seconds, after `ticks` others.
    #[must_use]
    pub fn has_come(self, ticks: u64, start: f64, length: f64) -> bool {
        match self {
            // A start is a product that was rounded, and what a person writes is another one.
            Self::Seconds(at) => at - start <= (1e-6 * length).max(4.0 * f64::EPSILON * start),
            Self::Tick(at) => at <= ticks,
            Self::Frame(_) => true,
        }
    }

    /// Whether it comes before `other`; `None` if that is a moment of another kind.
    pub(crate) fn precedes(self, other: Self) -> Option<bool> {
        match (self, other) {
            (Self::Seconds(at), Self::Seconds(other)) => Some(at < other),
            (Self::Tick(at), Self::Tick(other)) | (Self::Frame(at), Self::Frame(other)) => Some(at < other),
            _ => None,
        }
    }
}

impl fmt::Display for When {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Seconds(seconds) => write!(out, "{seconds} s"),
            Self::Tick(tick) => write!(out, "tick {tick}"),
            Self::Frame(frame) => write!(out, "frame {frame}"),
        }
    }
}

/// A picture must not leave the folder that was asked for, on any system.
fn is_picture_name(name: &str) -> bool {
    let plain =
        |c: char| !c.is_control() && !matches!(c, '/' | '\\' | ':' | '*' | '?' | '"' | '<' | '>' | '|');
    name.strip_suffix(".png").is_some_and(|stem| !stem.is_empty())
        && !name.starts_with('.')
        && !name.contains("..")
        && name.chars().all(plain)
}

mod triple {
    //! A vector as three numbers in round brackets.

    use glam::DVec3;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(v: &DVec3, serializer: S) -> Result<S::Ok, S::Error> {
        v.to_array().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<DVec3, D::Error> {
        <[f64; 3]>::deserialize(deserializer).map(DVec3::from_array)
    }
}

pub(crate) mod method {
    //! A method of integration as its bare name.

    use std::sync::LazyLock;

    use motion::Method;
    use serde::{Deserialize, Deserializer, Serializer, de};

    use crate::text::syntax::Word;

    static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| Method::ALL.map(Method::name).to_vec());

    pub(crate) fn serialize<S: Serializer>(method: &Method, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_unit_variant("Method", *method as u32, method.name())
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Method, D::Error> {
        let Word(word) = Word::deserialize(deserializer)?;
        Method::from_name(&word).ok_or_else(|| de::Error::unknown_variant(&word, &NAMES))
    }
}

mod effect {
    //! An effect as its name in quotes.

    use std::sync::LazyLock;

    use motion::effects::Effect;
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    static NAMES: LazyLock<Vec<&str>> = LazyLock::new(|| Effect::ALL.map(Effect::name).to_vec());

    pub(super) fn serialize<S: Serializer>(effect: &Effect, serializer: S) -> Result<S::Ok, S::Error> {
        effect.name().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Effect, D::Error> {
        let name = String::deserialize(deserializer)?;
        Effect::from_name(&name).ok_or_else(|| de::Error::unknown_variant(&name, &NAMES))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tick starts at a product or a quotient of its number, which may round to the number beside the time.
    #[test]
    fn a_late_time_comes_with_the_tick_that_starts_at_it_and_not_before() {
        let length = 1.0 / 120.0;
        for at in [0.5_f64, 1e4, 1e8, 3e8] {
            let when = When::Seconds(at);
            for start in [at, at.next_down(), at.next_up(), (at * 120.0) * length] {
                assert!(when.has_come(0, start, length), "{at} s, tick at {start:?} s");
            }
            assert!(!when.has_come(0, at - length, length), "{at} s");
        }
    }
}
