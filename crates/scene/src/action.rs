//! Actions of a script and their times: every input of a person, and changes of the simulation.

use std::fmt;

use glam::DVec3;
use motion::Method;
use motion::effects::Effect;
use serde::{Deserialize, Serialize};

use crate::substepping::Substepping;
use crate::text::faults::shown;
use crate::text::syntax::enum_of_enums;

/// Makes an enum from a table with a row for each action: its variant, what it is about, and what is wrong with its values, if
/// anything is.
macro_rules! actions {
    ($(#[$of_all:meta])* $name:ident, $(#[$about_doc:meta])* $about:ident -> $kind:ty: $(
        $(#[$doc:meta])*
        $variant:ident $(($($(#[$with:meta])* $value:ident: $type:ty),+))? => $target:expr, $fault:expr;
    )+) => {
        $(#[$of_all])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name {
            $($(#[$doc])* $variant $(($($(#[$with])* $type),+))?,)+
        }

        impl $name {
            $(#[$about_doc])*
            #[must_use]
            #[allow(unused_variables, reason = "a row names all its values")]
            pub fn $about(&self) -> $kind {
                match self {
                    $(Self::$variant $(($($value),+))? => $target,)+
                }
            }

            /// What is wrong with the action's values, and what would be right.
            #[allow(unused_variables, reason = "a row names all its values")]
            fn fault(&self) -> Option<Fault> {
                match self {
                    $(Self::$variant $(($($value),+))? => $fault,)+
                }
            }
        }
    };
}

/// One thing that a script does. In a file an action is written as its name in snake case: `press("G")`, `move_mouse(640, 360)`,
/// `set_gravity((0, -1.6, 0))`.
///
/// The names of keys and actions are in the key table of another crate, so they are not checked here; numbers of changes may be
/// non-finite on purpose.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Action {
    /// Input of a person.
    Input(InputAction),
    /// A change of bodies, laws or methods, which no input of a person makes.
    Change(ChangeAction),
    /// Something about the picture.
    Picture(PictureAction),
}

enum_of_enums!(Action: Input(InputAction), Change(ChangeAction), Picture(PictureAction));

actions! {
    /// Input of a person, in the window.
    InputAction,
    /// The key or named action that it presses or releases, if it does.
    key -> Option<&str>:

    /// Presses the key of that name in this frame and releases it in the next; a key that pushes acts for one tick.
    Press(key: String) => Some(key), nameless(key);
    /// Holds a key for a number of seconds, above 0; a key that pushes acts in the ticks of that time.
    Hold(key: String, seconds: f64) => Some(key), nameless(key).or_else(|| timeless(*seconds, "hold a key"));
    /// Does nothing for a number of seconds, above 0; for lessons.
    Wait(seconds: f64) => None, timeless(*seconds, "wait");
    /// Presses a key and leaves it down; for recordings.
    KeyDown(key: String) => Some(key), nameless(key);
    /// Releases a key; for recordings.
    KeyUp(key: String) => Some(key), nameless(key);
    /// The time at which the next key goes down or up, s, at least 0, within its frame; for recordings.
    At(time: f64) => None, unless(
        *time >= 0.0 && time.is_finite(),
        || format!("{} s is not a time of a key", shown(*time)),
        "give a number of seconds, at least 0",
    );
    /// Types characters into the field that has the focus; for recordings.
    Text(text: String) => None, None;
    /// Shows text that an input method composes in the field that has the focus; for recordings.
    Compose(text: String) => None, None;
    /// Asks a control for something, as assistive technology does: an `ActionRequest` of AccessKit as JSON; for recordings.
    Assist(request: String) => None, None;
    /// Moves the pointer to a pixel in selection mode; turns the camera by as much in camera mode.
    MoveMouse(x: f64, y: f64) => None, unless(
        x.is_finite() && y.is_finite(),
        || format!("({x}, {y}) is not a pixel"),
        "give two finite numbers",
    );
    /// Presses a mouse button.
    MouseDown(button: MouseButton) => None, None;
    /// Releases a mouse button.
    MouseUp(button: MouseButton) => None, None;
    /// Presses a mouse button in this frame and releases it in the next.
    Click(button: MouseButton) => None, None;
    /// Turns the wheel by a number of notches, positive away from the person.
    Wheel(notches: f64) => None, unless(
        notches.is_finite(),
        || format!("{notches} is not a number of notches"),
        "give a finite number",
    );
    /// Puts a finger, known by its number, onto a pixel of a touch screen, moves it or lifts it.
    Touch(finger: u64, phase: TouchPhase, x: f64, y: f64) => None, unless(
        x.is_finite() && y.is_finite(),
        || format!("({x}, {y}) is not a pixel"),
        "give two finite numbers",
    );
    /// Takes the focus from the window: every key and button is released.
    FocusLost => None, None;
    /// Resizes the window, px, each side 1 to 16384.
    Resize(width: u32, height: u32) => None, unless(
        [width, height].into_iter().all(|side| (1..=LARGEST_SIDE).contains(side)),
        || format!("{width} x {height} is not a window size"),
        "give two numbers of pixels from 1 to 16384",
    );
    /// Sets the pixels per point of the panels, above 0.
    Scale(scale: f64) => None, unless(
        scale.is_finite() && *scale > 0.0,
        || format!("{} is not a scale", shown(*scale)),
        "give a positive number",
    );
    /// Sets the width of the dock, points, above 0.
    DockWidth(points: f64) => None, unless(
        points.is_finite() && *points > 0.0,
        || format!("{} is not a width", shown(*points)),
        "give a positive number of points",
    );
    /// Arranges the panels as that text says, which is what the window remembers; for recordings.
    Arrange(text: String) => None, None;
}

actions! {
    /// A change of bodies, laws or methods.
    ChangeAction,
    /// What it changes.
    target -> Target<'_>:

    /// Pushes a body for one tick, N.
    Push(body: String, #[serde(with = "triple")] newtons: DVec3) => Target::Body(body), None;
    /// Gives a body an impulse, N s.
    Impulse(body: String, #[serde(with = "triple")] impulse: DVec3) => Target::Body(body), None;
    /// Sets the acceleration of gravity, m/s².
    SetGravity(#[serde(with = "triple")] acceleration: DVec3) => Target::Effect(Effect::Gravity), None;
    /// Sets the scene's damping rate, 1/s.
    SetDamping(rate: f64) => Target::Effect(Effect::Damping), unless(
        rate.is_nan() || *rate >= 0.0,
        || format!("{} is not a rate", shown(*rate)),
        "give a number of 1/s, at least 0",
    );
    /// Sets a body's velocity, m/s.
    SetVelocity(body: String, #[serde(with = "triple")] velocity: DVec3) => Target::Body(body), None;
    /// Sets a body's position, m.
    SetPosition(body: String, #[serde(with = "triple")] position: DVec3) => Target::Body(body), None;
    /// Reverses every velocity.
    ReverseVelocities => Target::Scene, None;
    /// Removes a body.
    Remove(body: String) => Target::Body(body), None;
    /// Changes the method of the scene: of every body without one of its own.
    SetMethod(#[serde(with = "method")] method: Method) => Target::Scene, None;
    /// Changes the substeps of the scene: of every body without its own.
    SetSubsteps(substeps: Substepping) => Target::Scene, substeps.fault();
    /// Gives a body a method of its own.
    SetBodyMethod(body: String, #[serde(with = "method")] method: Method) => Target::Body(body), None;
    /// Switches an effect that the scene declares on or off.
    SwitchEffect(#[serde(with = "effect")] effect: Effect, on: bool) => Target::Effect(*effect), None;
}

actions! {
    /// Something about the picture.
    PictureAction,
    /// The name of the file that it writes, if it writes one.
    file -> Option<&str>:

    /// Writes the picture of this frame under that plain file name, which ends in `.png`.
    Screenshot(name: String) => Some(name), unless(
        is_picture_name(name),
        || format!("{name:?} is not a plain file name that ends in .png"),
        "give one such as \"push.png\"",
    );
    /// Writes that line below pictures with captions from now on, in place of the description of the scene.
    Caption(words: String) => None, unless(
        words.chars().count() <= LONGEST_CAPTION && !words.contains(char::is_control),
        || format!("{words:?} is not a caption"),
        "give a line of at most 300 characters",
    );
}

/// What a change changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target<'a> {
    /// The body of that name.
    Body(&'a str),
    /// An effect of the scene.
    Effect(Effect),
    /// The scene as a whole.
    Scene,
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

/// The motion of a finger on a touch screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TouchPhase {
    /// It touches the screen.
    Down,
    /// It moves on the screen.
    Move,
    /// It leaves the screen.
    Up,
    /// The system took it for something else.
    Cancel,
}

/// Most characters of a caption.
const LONGEST_CAPTION: usize = 300;

/// Largest side of a window, px: what graphics devices commonly offer.
const LARGEST_SIDE: u32 = 16_384;

/// A fault of a value, and its cure.
type Fault = (String, String);

/// The fault of a value that is not valid.
fn unless(valid: bool, what: impl FnOnce() -> String, cure: &str) -> Option<Fault> {
    (!valid).then(|| (what(), cure.to_owned()))
}

fn nameless(key: &str) -> Option<Fault> {
    unless(!key.is_empty(), || "the name of the key is empty".to_owned(), "give the name of a key")
}

fn timeless(seconds: f64, what_for: &str) -> Option<Fault> {
    let valid = seconds > 0.0 && seconds.is_finite();
    unless(
        valid,
        || format!("{} is not a time to {what_for}", shown(seconds)),
        "give a positive number of seconds",
    )
}

impl Action {
    /// The change that it is, if it is one.
    #[must_use]
    pub const fn change(&self) -> Option<&ChangeAction> {
        if let Self::Change(change) = self { Some(change) } else { None }
    }

    /// The key or named action that it presses or releases, if it does.
    #[must_use]
    pub fn key(&self) -> Option<&str> {
        if let Self::Input(input) = self { input.key() } else { None }
    }

    /// What is wrong with the action's values, and what would be right.
    pub(crate) fn fault(&self) -> Option<Fault> {
        match self {
            Self::Input(input) => input.fault(),
            Self::Change(change) => change.fault(),
            Self::Picture(picture) => picture.fault(),
        }
    }

    /// The body that a change is of, if it is of one.
    pub(crate) fn body(&self) -> Option<&str> {
        self.change().and_then(ChangeAction::body)
    }
}

impl ChangeAction {
    /// The body that it names, if it names one.
    #[must_use]
    pub fn body(&self) -> Option<&str> {
        if let Target::Body(body) = self.target() { Some(body) } else { None }
    }

    /// The method that it sets, if it sets one.
    #[must_use]
    pub const fn method(&self) -> Option<Method> {
        if let Self::SetMethod(method) | Self::SetBodyMethod(_, method) = self {
            Some(*method)
        } else {
            None
        }
    }
}

/// An action and its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// When it is due.
    pub when: When,
    /// What happens.
    pub action: Action,
}

impl Step {
    /// Whether the step is due at a tick, so that its effect does not depend on frames: changes are, unless they have
    /// the number of a frame.
    #[must_use]
    pub fn is_of_ticks(&self) -> bool {
        self.action.change().is_some() && !matches!(self.when, When::Frame(_))
    }
}

/// The time from which a step is due.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// Seconds from the start, finite and at least 0.
    Seconds(f64),
    /// After that number of ticks.
    Tick(u64),
    /// The frame of that number, from 0.
    Frame(u64),
}

impl When {
    /// Whether the time has come for the tick that starts at `start` seconds and lasts `length` seconds, after
    /// `ticks` others. The caller counts frames: a step of a frame is always due here.
    #[must_use]
    pub fn is_due(self, ticks: u64, start: f64, length: f64) -> bool {
        match self {
            // The start of a tick is a rounded product, and the time that a person writes is rounded differently.
            Self::Seconds(at) => at - start <= (1e-6 * length).max(4.0 * f64::EPSILON * start),
            Self::Tick(at) => at <= ticks,
            Self::Frame(_) => true,
        }
    }

    /// Whether it is before `other`; `None` if the two are of different kinds.
    pub(crate) fn precedes(self, other: Self) -> Option<bool> {
        match (self, other) {
            (Self::Seconds(at), Self::Seconds(other)) => Some(at < other),
            (Self::Tick(at), Self::Tick(other)) | (Self::Frame(at), Self::Frame(other)) => {
                Some(at < other)
            }
            (Self::Seconds(_) | Self::Tick(_) | Self::Frame(_), _) => None,
        }
    }
}

impl fmt::Display for When {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Seconds(seconds) => write!(out, "{} s", shown(*seconds)),
            Self::Tick(tick) => write!(out, "tick {tick}"),
            Self::Frame(frame) => write!(out, "frame {frame}"),
        }
    }
}

/// Whether a picture has a plain name that ends in `.png`: it must not leave the requested folder, on any system.
fn is_picture_name(name: &str) -> bool {
    let plain = |c: char| {
        !c.is_control() && !matches!(c, '/' | '\\' | ':' | '*' | '?' | '"' | '<' | '>' | '|')
    };
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

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<DVec3, D::Error> {
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

    pub(crate) fn serialize<S: Serializer>(
        method: &Method,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.serialize_unit_variant("Method", *method as u32, method.name())
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Method, D::Error> {
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

    pub(super) fn serialize<S: Serializer>(
        effect: &Effect,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        effect.name().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Effect, D::Error> {
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
                assert!(when.is_due(0, start, length), "{at} s, tick at {start:?} s");
            }
            assert!(!when.is_due(0, at - length, length), "{at} s");
        }
    }
}
