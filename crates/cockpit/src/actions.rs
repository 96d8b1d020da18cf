//! The table of named actions, shared by keys, buttons, the help panel, `sandbox list keys` and scripts.

use std::sync::LazyLock;

use glam::DVec3;

pub use crate::input::{Key, UnknownKey};
use crate::panels::{PANELS, Panel};

/// The modes in which a key works.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// In both modes.
    Always,
    /// In camera mode, while the camera flies.
    CameraMode,
    /// In selection mode, while the pointer is free to select.
    SelectionMode,
}

impl When {
    /// The name of the mode in tables.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Always => "always",
            Self::CameraMode => "camera mode",
            Self::SelectionMode => "selection mode",
        }
    }
}

/// How long an action lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lasts {
    /// Happens once, when the key goes down.
    Once,
    /// Happens when the key goes down, and repeats while it is held.
    Repeatedly,
    /// Lasts while the key is held.
    While(Hold),
}

/// The effect of a held key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// Flies in a direction: right, up, forward.
    Fly(DVec3),
    /// Pushes the selection in a direction.
    Push(DVec3),
    /// Lets clicks select immovable bodies.
    SelectImmovable,
    /// Makes the wheel always change the click force, and lets clicks select immovable bodies: an alternative to Alt, whose
    /// clicks some window managers intercept.
    ChangeForce,
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// The action.
    pub act: Act,
    /// The name of the action in scripts.
    pub name: &'static str,
    /// The keys of the action.
    pub keys: &'static [&'static str],
    /// The modes in which the keys work.
    pub when: When,
    /// Description of the action, for the person.
    pub what: &'static str,
    /// How long the action lasts.
    pub lasts: Lasts,
}

impl Binding {
    const fn new(
        (act, name): (Act, &'static str),
        keys: &'static [&'static str],
        when: When,
        lasts: Lasts,
        what: &'static str,
    ) -> Self {
        Self { act, name, keys, when, what, lasts }
    }

    /// Whether the action repeats while its key is held.
    pub fn repeats(&self) -> bool {
        self.lasts == Lasts::Repeatedly
    }

    /// The tooltip of the action's button: its description and its key.
    pub(crate) fn tooltip(&self) -> String {
        format!("{} ({})", self.what, self.keys[0])
    }
}

/// Generates the actions and their rows from one list. `[panels]` is the place of the panels' actions in the order of the help.
macro_rules! actions {
    (
        $($First:ident: $first:literal, $first_keys:tt, $first_when:ident, $first_lasts:expr, $first_what:literal;)*
        [panels]
        $($Last:ident: $last:literal, $last_keys:tt, $last_when:ident, $last_lasts:expr, $last_what:literal;)*
    ) => {
        /// A named action of a key, a button or a script's `press`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[expect(missing_docs, reason = "the rows say what each does")]
        pub enum Act {
            $($First,)*
            /// Opens or closes the panel.
            Panel(Panel),
            $($Last,)*
        }

        /// The rows of all actions; the panels' rows come from `PANELS`.
        pub static BINDINGS: LazyLock<Vec<Binding>> = LazyLock::new(|| {
            let first = [$(Binding::new(
                (Act::$First, $first), &$first_keys, When::$first_when, $first_lasts, $first_what,
            ),)*];
            let panels = PANELS.iter().map(|(panel, row)| {
                Binding::new((Act::Panel(*panel), row.name), row.keys, When::Always, Lasts::Once, row.what)
            });
            let last = [$(Binding::new(
                (Act::$Last, $last), &$last_keys, When::$last_when, $last_lasts, $last_what,
            ),)*];
            first.into_iter().chain(panels).chain(last).collect()
        });
    };
}

actions! {
    ToggleMode: "toggle_mode", ["Q"], Always, Lasts::Once, "change between camera mode and selection mode";
    ToggleGravity: "toggle_gravity", ["G"], Always, Lasts::Once, "gravity on or off";
    ResetWorld: "reset_world", ["F1"], Always, Lasts::Once, "reset the world and the speed; camera, gravity and click force stay";
    ResetCamera: "reset_camera", ["F2"], Always, Lasts::Once, "reset the camera and release its lock";
    FlyForward: "fly_forward", ["W"], CameraMode, Lasts::While(Hold::Fly(DVec3::Z)), "fly forward, level, at 100 m/s; in smaller and larger scenes slower and faster";
    FlyBack: "fly_back", ["S"], CameraMode, Lasts::While(Hold::Fly(DVec3::NEG_Z)), "fly back";
    FlyLeft: "fly_left", ["A"], CameraMode, Lasts::While(Hold::Fly(DVec3::NEG_X)), "fly left";
    FlyRight: "fly_right", ["D"], CameraMode, Lasts::While(Hold::Fly(DVec3::X)), "fly right";
    FlyUp: "fly_up", ["Space"], CameraMode, Lasts::While(Hold::Fly(DVec3::Y)), "fly up";
    FlyDown: "fly_down", ["Shift"], CameraMode, Lasts::While(Hold::Fly(DVec3::NEG_Y)), "fly down";
    LockCamera: "lock_camera", ["L"], Always, Lasts::Once, "lock the camera to the selection, or unlock it";
    PushMinusZ: "push_minus_z", ["Up"], SelectionMode, Lasts::While(Hold::Push(DVec3::NEG_Z)), "push the selection with 10 N along -z";
    PushPlusZ: "push_plus_z", ["Down"], SelectionMode, Lasts::While(Hold::Push(DVec3::Z)), "push the selection with 10 N along +z";
    PushMinusX: "push_minus_x", ["Left"], SelectionMode, Lasts::While(Hold::Push(DVec3::NEG_X)), "push the selection with 10 N along -x";
    PushPlusX: "push_plus_x", ["Right"], SelectionMode, Lasts::While(Hold::Push(DVec3::X)), "push the selection with 10 N along +x";
    PushPlusY: "push_plus_y", ["PageUp"], SelectionMode, Lasts::While(Hold::Push(DVec3::Y)), "push the selection with 10 N along +y";
    PushMinusY: "push_minus_y", ["PageDown"], SelectionMode, Lasts::While(Hold::Push(DVec3::NEG_Y)), "push the selection with 10 N along -y";
    SelectImmovable: "select_immovable", ["Alt"], SelectionMode, Lasts::While(Hold::SelectImmovable), "held, a click selects also what cannot be moved; Ctrl does the same where the window manager takes Alt";
    NextBody: "next_body", ["K"], Always, Lasts::Once, "select the next body that can be moved";
    PreviousBody: "previous_body", ["Shift+K"], Always, Lasts::Once, "select the previous body that can be moved";
    ChangeForce: "change_force", ["Ctrl"], Always, Lasts::While(Hold::ChangeForce), "held, the wheel changes the click force, and a click selects also what cannot be moved";
    Frame: "frame", ["F"], Always, Lasts::Once, "frame the selection, or everything that moves";
    Pause: "pause", ["P"], Always, Lasts::Once, "pause or continue";
    Step: "step", ["."], Always, Lasts::Repeatedly, "pause and simulate one tick; held, one after the other";
    StepBack: "step_back", [","], Always, Lasts::Repeatedly, "pause and go one tick back, up to a minute; held, one after the other";
    Slower: "slower", ["-"], Always, Lasts::Once, "half the speed; the tick stays the same";
    Faster: "faster", ["="], Always, Lasts::Once, "twice the speed; the tick stays the same";
    PreviousScene: "previous_scene", ["["], Always, Lasts::Once, "previous scene";
    NextScene: "next_scene", ["]"], Always, Lasts::Once, "next scene";
    NextMethod: "next_method", ["I"], Always, Lasts::Once, "next method of integration of the scene";
    PreviousMethod: "previous_method", ["Shift+I"], Always, Lasts::Once, "previous method of integration";
    [panels]
    NextSolid: "next_solid", ["Shift+T"], Always, Lasts::Once, "the next method becomes the solid one among ghosts";
    SaveBundle: "save_bundle", ["Ctrl+S"], Always, Lasts::Once, "save: the scene if it has unsaved changes, else the last minute as a bundle, for `sandbox replay`";
    SaveScene: "save_scene", ["Ctrl+Shift+S"], Always, Lasts::Once, "save the scene as a file, under the name in the editor";
    Undo: "undo", ["Ctrl+Z"], Always, Lasts::Once, "undo the last change of the scene in the editor";
    Redo: "redo", ["Ctrl+Shift+Z", "Ctrl+Y"], Always, Lasts::Once, "redo what was undone";
    Duplicate: "duplicate", ["Ctrl+D"], Always, Lasts::Once, "with the editor open: a copy of the selection beside it";
    Delete: "delete", ["Delete"], Always, Lasts::Once, "with the editor open: remove the selection";
    VelocityArrows: "velocity_arrows", ["1"], Always, Lasts::Once, "velocity arrows";
    ForceArrows: "force_arrows", ["2"], Always, Lasts::Once, "force arrows, one per cause, and their sum in white";
    Springs: "springs", ["3"], Always, Lasts::Once, "springs, colored by strain, in place of what they carry";
    Trails: "trails", ["7"], Always, Lasts::Once, "trails";
    FocusPanels: "focus_panels", ["F6"], Always, Lasts::Once, "the keyboard moves to the next part: bar, scenes, dock, scene";
    Larger: "larger", ["Ctrl+=", "Ctrl++"], Always, Lasts::Once, "make the panels larger";
    Smaller: "smaller", ["Ctrl+-"], Always, Lasts::Once, "make the panels smaller";
    ToggleTheme: "toggle_theme", ["F7"], Always, Lasts::Once, "light or dark panels";
    ToggleBrowser: "toggle_browser", ["F8"], Always, Lasts::Once, "show or hide the scenes at the left";
    ToggleDock: "toggle_dock", ["F9"], Always, Lasts::Once, "show or hide the tools at the right";
    ToggleCockpit: "toggle_cockpit", ["F10"], Always, Lasts::Once, "show or hide the bars and the dock around the view";
    Screenshot: "screenshot", ["F12"], Always, Lasts::Once, "write a screenshot";
    Cancel: "cancel", ["Escape"], Always, Lasts::Once, "close what was opened last, a list before its panel; else clear the selection";
    Quit: "quit", ["Ctrl+Q"], Always, Lasts::Once, "quit, as the window's close button does";
}

impl Act {
    /// The row of the action.
    #[must_use]
    pub fn binding(self) -> &'static Binding {
        BINDINGS
            .iter()
            .find(|binding| binding.act == self)
            .expect("the list has a row for every action")
    }

    /// The name of the action in scripts.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.binding().name
    }

    /// The first key of the action.
    pub fn key(self) -> Key {
        self.binding().keys[0].parse().expect("the table has keys that there are")
    }
}

/// The uses of the mouse: input, mode, description.
pub const MOUSE: &[(&str, When, &str)] = &[
    ("move", When::CameraMode, "look around, 0.07 degrees per count"),
    (
        "left button",
        When::SelectionMode,
        "select what is under the pointer and can be moved; held, without the bars around the view, select continuously",
    ),
    (
        "left drag",
        When::SelectionMode,
        "with the bars around the view: pull the body by a damped spring",
    ),
    (
        "right button",
        When::Always,
        "push the selection along the ray with the click force, if the ray meets it first",
    ),
    (
        "right drag",
        When::SelectionMode,
        "with the bars around the view, beside the selection: orbit",
    ),
    ("one finger", When::Always, "the left button; in camera mode, look around"),
    ("a finger that rests", When::Always, "after half a second, a click of the right button"),
    (
        "two fingers",
        When::SelectionMode,
        "with the bars around the view: orbit; once they change their distance, zoom and pan",
    ),
    ("middle drag", When::SelectionMode, "with the bars around the view: pan"),
    (
        "wheel",
        When::Always,
        "change the click force, 100 N per notch, a negative force pulls; with the bars around the view and nothing to push, zoom",
    ),
];

/// A row of the help: an input and its description.
#[derive(Clone, Copy)]
pub struct InputRow {
    /// The keys of one action, or one use of the mouse.
    pub inputs: &'static [&'static str],
    /// The modes in which the input works.
    pub when: When,
    /// Description of the input, for the person.
    pub what: &'static str,
    /// The name of the action in scripts; `None` for the mouse.
    pub name: Option<&'static str>,
}

/// The rows of all keys and all uses of the mouse, in the order of the help.
pub fn input_rows() -> impl Iterator<Item = InputRow> {
    let keys = BINDINGS.iter().map(|&Binding { name, keys, when, what, .. }| InputRow {
        inputs: keys,
        when,
        what,
        name: Some(name),
    });
    let mouse = MOUSE.iter().map(|(input, when, what)| InputRow {
        inputs: std::slice::from_ref(input),
        when: *when,
        what,
        name: None,
    });
    keys.chain(mouse)
}

/// The row with exactly this key and these modifiers.
fn exact_binding(key: &Key) -> Option<&'static Binding> {
    let name = key.to_string();
    BINDINGS.iter().find(|binding| binding.keys.contains(&name.as_str()))
}

/// The row of the key, if any.
#[must_use]
pub fn binding(key: &Key) -> Option<&'static Binding> {
    // Shift flies down while other keys are held, so it is ignored for keys without a row with Shift.
    exact_binding(key).or_else(|| exact_binding(&key.clone().with_shift(false)))
}

/// Whether a held Shift is part of this key, as in `Shift+I` or `?`, and so does not also fly down.
pub(crate) fn shift_is_part_of(key: &Key) -> bool {
    let mut characters = key.name().chars();
    match (characters.next(), characters.next()) {
        (Some(one), None) if one.is_alphabetic() => key.shift() && exact_binding(key).is_some(),
        (Some(_), None) => true,
        _ => false,
    }
}

/// The key for a word of a script, which is the name of a key or of an action.
///
/// # Errors
/// A word that is neither.
pub fn key_of_word(word: &str) -> Result<Key, UnknownKey> {
    match BINDINGS.iter().find(|binding| binding.name == word) {
        Some(binding) => binding.keys[0].parse(),
        None => word.parse(),
    }
}

/// Whether a script's word for a key presses one of `acts`.
pub fn presses_one_of(word: &str, acts: &[Act]) -> bool {
    let key = key_of_word(word).ok();
    key.and_then(|key| binding(&key)).is_some_and(|binding| acts.contains(&binding.act))
}

/// The table in Markdown, as docs/keys.md has it.
#[must_use]
pub fn markdown() -> String {
    let mut table = String::from(
        "| key | when | what it does | name in scripts |\n| --- | --- | --- | --- |\n",
    );
    for InputRow { inputs, when, what, name } in input_rows() {
        let when = when.words();
        table += &match name {
            Some(name) => {
                let keys =
                    inputs.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(" ");
                format!("| {keys} | {when} | {what} | `{name}` |\n")
            }
            None => format!("| {} | {when} | {what} | |\n", inputs.join(" ")),
        };
    }
    table
}
