//! The one table of named actions: what keys do, what the help panel and `sandbox list keys` print, what
//! scripts may press.

use std::fmt;
use std::str::FromStr;

/// A key as people name it: the character it types, in upper case, or a name such as `Space` or `F1`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Key {
    name: String,
    ctrl: bool,
    shift: bool,
}

/// Keys that are named and not typed.
const NAMED: [&str; 17] = [
    "Space",
    "Shift",
    "Alt",
    "Up",
    "Down",
    "Left",
    "Right",
    "PageUp",
    "PageDown",
    "Tab",
    "Escape",
    "Enter",
    "Backspace",
    "Delete",
    "F1",
    "F2",
    "F12",
];

impl Key {
    /// The key that types `character`.
    #[must_use]
    pub fn character(character: char) -> Self {
        Self { name: character.to_uppercase().collect(), ctrl: false, shift: false }
    }

    /// The same key with the control key held.
    #[must_use]
    pub fn with_ctrl(self, ctrl: bool) -> Self {
        Self { ctrl, ..self }
    }

    /// The same key with the shift key held, if it is a letter: elsewhere shift makes another character, which
    /// is a key of its own.
    #[must_use]
    pub fn with_shift(self, shift: bool) -> Self {
        let letter = self.name.chars().count() == 1 && self.name.chars().all(char::is_alphabetic);
        Self { shift: shift && letter, ..self }
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

    /// Whether it is a letter with the shift key.
    #[must_use]
    pub const fn shift(&self) -> bool {
        self.shift
    }

    /// Whether shift, if it is held, belongs to this key: to a row of its own such as `Shift+I`, or to a character such
    /// as `?`.
    #[must_use]
    pub fn takes_shift(&self) -> bool {
        let mut characters = self.name.chars();
        match (characters.next(), characters.next()) {
            (Some(one), None) if one.is_alphabetic() => self.shift && row(self).is_some(),
            (Some(_), None) => true,
            _ => false,
        }
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

/// What a person can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the table below documents each in the words that the person reads")]
pub enum Action {
    ToggleMode,
    ToggleGravity,
    ResetWorld,
    ResetCamera,
    FlyForward,
    FlyBack,
    FlyLeft,
    FlyRight,
    FlyUp,
    FlyDown,
    LockCamera,
    PushMinusZ,
    PushPlusZ,
    PushMinusX,
    PushPlusX,
    PushPlusY,
    PushMinusY,
    SelectImmovable,
    Pause,
    StepOnce,
    StepBack,
    Slower,
    Faster,
    PreviousScene,
    NextScene,
    FindScene,
    NextMethod,
    PreviousMethod,
    Settings,
    Effects,
    Cost,
    Ghosts,
    NextSolid,
    Ledger,
    Forecast,
    Timeline,
    SaveBundle,
    Help,
    VelocityArrows,
    ForceArrows,
    Springs,
    Trails,
    Screenshot,
    Cancel,
    Quit,
}

/// When an action's key means something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// In both modes.
    Always,
    /// While the camera flies.
    CameraMode,
    /// While the pointer is free to select.
    SelectionMode,
}

impl When {
    /// The words for it in tables.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Always => "always",
            Self::CameraMode => "camera mode",
            Self::SelectionMode => "selection mode",
        }
    }
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// What is done.
    pub action: Action,
    /// Its name in scripts.
    pub name: &'static str,
    /// The keys that do it.
    pub keys: &'static [&'static str],
    /// When they do.
    pub when: When,
    /// Whether it lasts while the key is held, instead of happening when it goes down.
    pub held: bool,
    /// What it does, for the person.
    pub what: &'static str,
}

const fn edge(
    action: Action,
    name: &'static str,
    keys: &'static [&'static str],
    what: &'static str,
) -> Binding {
    Binding { action, name, keys, when: When::Always, held: false, what }
}

const fn fly(
    action: Action,
    name: &'static str,
    keys: &'static [&'static str],
    what: &'static str,
) -> Binding {
    Binding { action, name, keys, when: When::CameraMode, held: true, what }
}

const fn push(
    action: Action,
    name: &'static str,
    keys: &'static [&'static str],
    what: &'static str,
) -> Binding {
    Binding { action, name, keys, when: When::SelectionMode, held: true, what }
}

/// Every action that has a key.
pub const BINDINGS: &[Binding] = &[
    edge(Action::ToggleMode, "toggle_mode", &["Q"], "change between camera mode and selection mode"),
    edge(Action::ToggleGravity, "toggle_gravity", &["G"], "gravity on or off"),
    edge(
        Action::ResetWorld,
        "reset_world",
        &["F1"],
        "reset the world and the speed; camera, gravity and click force stay",
    ),
    edge(Action::ResetCamera, "reset_camera", &["F2"], "reset the camera and release its lock"),
    fly(Action::FlyForward, "fly_forward", &["W"], "fly forward, level, at 100 m/s"),
    fly(Action::FlyBack, "fly_back", &["S"], "fly back"),
    fly(Action::FlyLeft, "fly_left", &["A"], "fly left"),
    fly(Action::FlyRight, "fly_right", &["D"], "fly right"),
    fly(Action::FlyUp, "fly_up", &["Space"], "fly up"),
    fly(Action::FlyDown, "fly_down", &["Shift"], "fly down"),
    edge(Action::LockCamera, "lock_camera", &["L"], "lock the camera to the selection, or unlock it"),
    push(Action::PushMinusZ, "push_minus_z", &["Up"], "push the selection with 10 N along -z"),
    push(Action::PushPlusZ, "push_plus_z", &["Down"], "push the selection with 10 N along +z"),
    push(Action::PushMinusX, "push_minus_x", &["Left"], "push the selection with 10 N along -x"),
    push(Action::PushPlusX, "push_plus_x", &["Right"], "push the selection with 10 N along +x"),
    push(Action::PushPlusY, "push_plus_y", &["PageUp"], "push the selection with 10 N along +y"),
    push(Action::PushMinusY, "push_minus_y", &["PageDown"], "push the selection with 10 N along -y"),
    push(
        Action::SelectImmovable,
        "select_immovable",
        &["Alt"],
        "held, a click selects also what cannot be moved",
    ),
    edge(Action::Pause, "pause", &["P"], "pause or go on"),
    edge(Action::StepOnce, "step", &["."], "pause and simulate one tick"),
    edge(Action::StepBack, "step_back", &[","], "pause and go one tick back, up to a minute"),
    edge(Action::Slower, "slower", &["-"], "half the speed; the tick stays the same"),
    edge(Action::Faster, "faster", &["="], "twice the speed; the tick stays the same"),
    edge(Action::PreviousScene, "previous_scene", &["["], "previous scene"),
    edge(Action::NextScene, "next_scene", &["]"], "next scene"),
    edge(Action::FindScene, "find_scene", &["Ctrl+O"], "find a scene by name"),
    edge(Action::NextMethod, "next_method", &["I"], "next method of integration of the scene"),
    edge(Action::PreviousMethod, "previous_method", &["Shift+I"], "previous method of integration"),
    edge(
        Action::Settings,
        "settings",
        &["Tab"],
        "settings: gravity, damping, tick rate, methods, the selection's mass and velocity",
    ),
    edge(
        Action::Effects,
        "toggle_effects_panel",
        &["E"],
        "effects: what acts, why, on how many bodies, at what cost; on and off",
    ),
    edge(
        Action::Cost,
        "toggle_cost_panel",
        &["C"],
        "accuracy and cost: one dot a method and step, measured on a copy of the scene; a click takes it",
    ),
    edge(
        Action::Ghosts,
        "toggle_ghosts",
        &["T"],
        "ghosts: the same run by every method, and how far each is from a fine reference",
    ),
    edge(Action::NextSolid, "next_solid", &["Shift+T"], "the next method becomes the solid one among ghosts"),
    edge(
        Action::Ledger,
        "toggle_ledger_panel",
        &["B"],
        "ledger: where energy and momentum go, and what the method invents",
    ),
    edge(
        Action::Forecast,
        "toggle_forecast_panel",
        &["V"],
        "forecast: how near every spring, damper and well is to instability, and what would help",
    ),
    edge(
        Action::Timeline,
        "toggle_timeline_panel",
        &["R"],
        "timeline: go anywhere in the last minute; what went wrong, and saving it",
    ),
    edge(
        Action::SaveBundle,
        "save_bundle",
        &["Ctrl+S"],
        "save the last minute as a bundle, for `sandbox replay`",
    ),
    edge(Action::Help, "help", &["H", "?"], "this help"),
    edge(Action::VelocityArrows, "velocity_arrows", &["1"], "velocity arrows"),
    edge(Action::ForceArrows, "force_arrows", &["2"], "force arrows: weight violet, the rest red"),
    edge(Action::Springs, "springs", &["3"], "springs, colored by strain, in place of what they carry"),
    edge(Action::Trails, "trails", &["7"], "trails"),
    edge(Action::Screenshot, "screenshot", &["F12"], "write a screenshot"),
    edge(
        Action::Cancel,
        "cancel",
        &["Escape"],
        "close what was opened last, a list before its panel; else clear the selection",
    ),
    edge(Action::Quit, "quit", &["Ctrl+Q"], "quit, as the window's close button does"),
];

/// What the mouse does: input, when, what.
pub const MOUSE: &[(&str, When, &str)] = &[
    ("move", When::CameraMode, "look around, 0.07 degrees a count"),
    (
        "left button",
        When::SelectionMode,
        "select what is under the pointer and can be moved; held, select continuously",
    ),
    (
        "right button",
        When::Always,
        "push the selection along the ray with the click force, if the ray meets it first",
    ),
    ("wheel", When::Always, "change the click force, 100 N a notch; a negative force pulls"),
];

impl Action {
    /// Whether bodies that were removed may be there again after it.
    pub(crate) const fn brings_back(self) -> bool {
        matches!(
            self,
            Self::ResetWorld
                | Self::PreviousScene
                | Self::NextScene
                | Self::FindScene
                | Self::StepBack
                | Self::Timeline
        )
    }
}

fn row(key: &Key) -> Option<&'static Binding> {
    let name = key.to_string();
    BINDINGS.iter().find(|binding| binding.keys.contains(&name.as_str()))
}

/// The row of the key, if it has one.
#[must_use]
pub fn binding(key: &Key) -> Option<&'static Binding> {
    // Shift flies down while other keys fly on: it changes only the keys that have a row with it.
    row(key).or_else(|| row(&key.clone().with_shift(false)))
}

/// The key that a script means: a key's own name, or the name of an action.
///
/// # Errors
/// A word that is neither.
pub fn key_of_word(word: &str) -> Result<Key, UnknownKey> {
    match BINDINGS.iter().find(|binding| binding.name == word) {
        Some(binding) => binding.keys[0].parse(),
        None => word.parse(),
    }
}

/// Whether a script's word for a key means an action that is so.
pub(crate) fn is_bound(word: &str, is_so: impl Fn(Action) -> bool) -> bool {
    let key = key_of_word(word).ok();
    key.and_then(|key| binding(&key)).is_some_and(|binding| is_so(binding.action))
}

/// The table in Markdown, as docs/keys.md has it.
#[must_use]
pub fn markdown() -> String {
    let mut table =
        String::from("| key | when | what it does | name in scripts |\n| --- | --- | --- | --- |\n");
    for binding in BINDINGS {
        let keys = binding.keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(" ");
        table += &format!("| {keys} | {} | {} | `{}` |\n", binding.when.words(), binding.what, binding.name);
    }
    for (input, when, what) in MOUSE {
        table += &format!("| {input} | {} | {what} | |\n", when.words());
    }
    table
}
