//! The input of a frame: the same events from a window, a script or a test.

pub mod keyboard;

use std::fmt;
use std::str::FromStr;

use scene::{ChangeAction, PictureAction};
pub use scene::{MouseButton as Button, TouchPhase};

/// A key as people name it: the character it types, in upper case, or a name such as `Space` or `F1`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Key {
    name: String,
    ctrl: bool,
    shift: bool,
}

/// Keys that are named and not typed.
const NAMED: [&str; 25] = [
    "Space",
    "Shift",
    "Alt",
    "Ctrl",
    "Up",
    "Down",
    "Left",
    "Right",
    "PageUp",
    "PageDown",
    "Home",
    "End",
    "Tab",
    "Escape",
    "Enter",
    "Backspace",
    "Delete",
    "F1",
    "F2",
    "F6",
    "F7",
    "F8",
    "F9",
    "F10",
    "F12",
];

impl Key {
    /// The key that types `character`.
    #[must_use]
    pub fn character(character: char) -> Self {
        let mut upper = character.to_uppercase();
        // The upper case of some letters is several of them, which no key types.
        let name = if upper.len() == 1 { upper.next() } else { None };
        Self { name: name.unwrap_or(character).to_string(), ctrl: false, shift: false }
    }

    /// The same key with the control key held.
    #[must_use]
    pub fn with_ctrl(self, ctrl: bool) -> Self {
        Self { ctrl, ..self }
    }

    /// The same key with the shift key held, if it is a letter or Tab: elsewhere shift makes another character,
    /// which is a key of its own.
    #[must_use]
    pub fn with_shift(self, shift: bool) -> Self {
        let letter = self.name.chars().count() == 1 && self.name.chars().all(char::is_alphabetic);
        Self { shift: shift && (letter || self.name == "Tab"), ..self }
    }

    /// The name without the control and the shift key.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the control key is held with it.
    #[must_use]
    pub const fn ctrl(&self) -> bool {
        self.ctrl
    }

    /// Whether it is a letter or Tab with the shift key.
    #[must_use]
    pub const fn shift(&self) -> bool {
        self.shift
    }
}

impl fmt::Display for Key {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ctrl = if self.ctrl { "Ctrl+" } else { "" };
        let shift = if self.shift { "Shift+" } else { "" };
        write!(out, "{ctrl}{shift}{}", self.name)
    }
}

/// A word that names no key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownKey(pub String);

impl fmt::Display for UnknownKey {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "there is no key or action `{}`; `sandbox list keys` names them all", self.0)
    }
}

impl std::error::Error for UnknownKey {}

impl FromStr for Key {
    type Err = UnknownKey;

    fn from_str(text: &str) -> Result<Self, UnknownKey> {
        let (ctrl, rest) = text.strip_prefix("Ctrl+").map_or((false, text), |rest| (true, rest));
        let (shift, name) = rest.strip_prefix("Shift+").map_or((false, rest), |name| (true, name));
        let mut characters = name.chars();
        let key = match (characters.next(), characters.next()) {
            (Some(one), None) if !one.is_whitespace() => Self::character(one).with_ctrl(ctrl),
            _ => match NAMED.iter().find(|known| **known == name) {
                Some(known) => Self { name: (*known).to_owned(), ctrl, shift: false },
                None => return Err(UnknownKey(text.to_owned())),
            },
        };
        let key = key.with_shift(shift);
        if key.shift == shift { Ok(key) } else { Err(UnknownKey(text.to_owned())) }
    }
}

/// One event.
#[derive(Clone, Debug)]
pub enum Input {
    /// A key went down.
    KeyDown(Key),
    /// A key went down that comes up in a later frame. Its push ends at that time, s of frame time, but not before one tick.
    KeyDownUntil(Key, f64),
    /// A key went up.
    KeyUp(Key),
    /// The next key goes down or up at this time, s of frame time; without it, at the start of the frame.
    At(f64),
    /// Text was typed; read only by a text field that has the focus.
    Text(String),
    /// An input method composes this text; read only by a text field that has the focus.
    Compose(String),
    /// Assistive technology asks a control for something: an `ActionRequest` of AccessKit as JSON.
    Assist(String),
    /// In selection mode the pointer is at this pixel, from the top left; in camera mode the mouse moved by this many counts,
    /// right and down.
    Mouse(f64, f64),
    /// A button went down.
    ButtonDown(Button),
    /// A button went up.
    ButtonUp(Button),
    /// The wheel turned by this many notches, away from the person.
    Wheel(f64),
    /// The finger of this number touches, moves on or leaves the screen at this pixel, from the top left.
    Touch(u64, TouchPhase, f64, f64),
    /// The window lost the keyboard: nothing is held any more.
    FocusLost,
    /// The picture has this many pixels now.
    Resized([u32; 2]),
    /// The display has this many pixels per point of the panels.
    Scaled(f64),
    /// The dock gets this width, points.
    DockWidth(f64),
    /// The panels are arranged as that text says.
    Arrange(String),
    /// An action of a script that is no input of a person: a change of the simulation, or a picture.
    Change(ChangeAction),
    /// Something about the picture, by a script.
    Picture(PictureAction),
}

/// The cause of the switch of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SwitchedBy {
    /// The key G.
    Key,
    /// A step of a script.
    Script,
    /// A box in the panel of effects.
    Panel,
    /// The settings, where gravity and damping have values.
    Settings,
    /// A flag of the command line.
    Flag,
}

impl SwitchedBy {
    /// The words for it in receipts.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Key => "switched by G",
            Self::Script => "switched by script",
            Self::Panel => "switched in the panel",
            Self::Settings => "changed in the settings",
            Self::Flag => "switched by --without",
        }
    }
}

/// Everything that happened since the last frame, in order.
#[derive(Clone, Debug, Default)]
pub struct InputFrame {
    /// The events.
    pub events: Vec<Input>,
}

impl InputFrame {
    /// A frame in which nothing happened.
    pub const NOTHING: Self = Self { events: Vec::new() };
}

impl FromIterator<Input> for InputFrame {
    fn from_iter<I: IntoIterator<Item = Input>>(events: I) -> Self {
        Self { events: events.into_iter().collect() }
    }
}
