//! The one table of named actions: what keys do, what the help panel and `sandbox list keys` print, what
//! scripts may press.

use std::sync::LazyLock;

use glam::DVec3;
use motion::Method;

use crate::app::held::Hold;
use crate::app::session::Session;
pub use crate::input::{Key, UnknownKey};
use crate::tools::{Panel, TOOLS};
use crate::view::stage::Order;

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

/// What an action does.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Does {
    /// Lasts while the key is held.
    While(Hold),
    /// Happens when the key goes down.
    Once(fn(&mut Session)),
    /// Happens when the key goes down, and again and again while it is held.
    Repeatedly(fn(&mut Session)),
    /// Opens or closes a panel.
    Open(Panel),
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Its name in scripts.
    pub name: &'static str,
    /// The keys that do it.
    pub keys: &'static [&'static str],
    /// When they do.
    pub when: When,
    /// What it does, for the person.
    pub what: &'static str,
    pub(crate) does: Does,
}

impl Binding {
    /// Whether its key does it again and again while it is held.
    pub(crate) const fn repeats(&self) -> bool {
        matches!(self.does, Does::Repeatedly(_))
    }
}

type Keys = &'static [&'static str];

const fn once(name: &'static str, keys: Keys, what: &'static str, does: fn(&mut Session)) -> Binding {
    Binding { name, keys, when: When::Always, what, does: Does::Once(does) }
}

const fn repeated(name: &'static str, keys: Keys, what: &'static str, does: fn(&mut Session)) -> Binding {
    Binding { name, keys, when: When::Always, what, does: Does::Repeatedly(does) }
}

const fn fly(name: &'static str, keys: Keys, what: &'static str, along: DVec3) -> Binding {
    Binding { name, keys, when: When::CameraMode, what, does: Does::While(Hold::Fly(along)) }
}

const fn push(name: &'static str, keys: Keys, what: &'static str, along: DVec3) -> Binding {
    Binding { name, keys, when: When::SelectionMode, what, does: Does::While(Hold::Push(along)) }
}

/// The actions before those of tools.
const FIRST: &[Binding] = &[
    once("toggle_mode", &["Q"], "change between camera mode and selection mode", Session::toggle_mode),
    once("toggle_gravity", &["G"], "gravity on or off", Session::toggle_gravity),
    once(
        "reset_world",
        &["F1"],
        "reset the world and the speed; camera, gravity and click force stay",
        Session::reset_world,
    ),
    once("reset_camera", &["F2"], "reset the camera and release its lock", Session::reset_camera),
    fly(
        "fly_forward",
        &["W"],
        "fly forward, level, at 100 m/s; in smaller and larger scenes slower and faster",
        DVec3::Z,
    ),
    fly("fly_back", &["S"], "fly back", DVec3::NEG_Z),
    fly("fly_left", &["A"], "fly left", DVec3::NEG_X),
    fly("fly_right", &["D"], "fly right", DVec3::X),
    fly("fly_up", &["Space"], "fly up", DVec3::Y),
    fly("fly_down", &["Shift"], "fly down", DVec3::NEG_Y),
    once("lock_camera", &["L"], "lock the camera to the selection, or unlock it", |session| {
        session.seen.locked = session.seen.selection.filter(|_| session.seen.locked.is_none());
    }),
    push("push_minus_z", &["Up"], "push the selection with 10 N along -z", DVec3::NEG_Z),
    push("push_plus_z", &["Down"], "push the selection with 10 N along +z", DVec3::Z),
    push("push_minus_x", &["Left"], "push the selection with 10 N along -x", DVec3::NEG_X),
    push("push_plus_x", &["Right"], "push the selection with 10 N along +x", DVec3::X),
    push("push_plus_y", &["PageUp"], "push the selection with 10 N along +y", DVec3::Y),
    push("push_minus_y", &["PageDown"], "push the selection with 10 N along -y", DVec3::NEG_Y),
    Binding {
        name: "select_immovable",
        keys: &["Alt"],
        when: When::SelectionMode,
        what: "held, a click selects also what cannot be moved",
        does: Does::While(Hold::SelectImmovable),
    },
    once("next_body", &["K"], "select the next body that can be moved", |session| session.select_neighbor(1)),
    once("previous_body", &["Shift+K"], "select the previous body that can be moved", |session| {
        session.select_neighbor(-1);
    }),
    Binding {
        name: "change_force",
        keys: &["Ctrl"],
        when: When::Always,
        what: "held, the wheel changes the click force, and a click selects also what cannot be moved",
        does: Does::While(Hold::ChangeForce),
    },
    once("frame", &["F"], "frame the selection, or everything that moves", Session::frame_view),
    once("pause", &["P"], "pause or go on", |session| session.view.paused ^= true),
    repeated("step", &["."], "pause and simulate one tick; held, one after the other", |session| {
        session.view.paused = true;
        session.hands.steps_asked += 1;
    }),
    repeated(
        "step_back",
        &[","],
        "pause and go one tick back, up to a minute; held, one after the other",
        Session::step_back,
    ),
    once("slower", &["-"], "half the speed; the tick stays the same", |session| session.set_pace(0.5)),
    once("faster", &["="], "twice the speed; the tick stays the same", |session| session.set_pace(2.0)),
    once("previous_scene", &["["], "previous scene", |session| session.open_neighbor(-1)),
    once("next_scene", &["]"], "next scene", |session| session.open_neighbor(1)),
    once("next_method", &["I"], "next method of integration of the scene", |session| {
        session.change_method(Method::next);
    }),
    once("previous_method", &["Shift+I"], "previous method of integration", |session| {
        session.change_method(Method::previous);
    }),
];

/// The actions after those of tools.
const LAST: &[Binding] = &[
    once(
        "next_solid",
        &["Shift+T"],
        "the next method becomes the solid one among ghosts",
        Session::next_solid,
    ),
    once(
        "save_bundle",
        &["Ctrl+S"],
        "save: the scene if it has unsaved changes, else the last minute as a bundle, for `sandbox replay`",
        Session::save,
    ),
    once(
        "save_scene",
        &["Ctrl+Shift+S"],
        "save the scene as a file, under the name in the editor",
        |session| {
            session.save_scene();
        },
    ),
    once("undo", &["Ctrl+Z"], "undo the last change of the scene in the editor", Session::undo),
    once("redo", &["Ctrl+Shift+Z", "Ctrl+Y"], "redo what was undone", Session::redo),
    once(
        "duplicate",
        &["Ctrl+D"],
        "with the editor open: a copy of the selection beside it",
        Session::duplicate,
    ),
    once("delete", &["Delete"], "with the editor open: remove the selection", Session::delete),
    once("velocity_arrows", &["1"], "velocity arrows", |session| session.view.velocity_arrows ^= true),
    once("force_arrows", &["2"], "force arrows, one per cause, and their sum in white", |session| {
        session.view.force_arrows ^= true;
    }),
    once("springs", &["3"], "springs, colored by strain, in place of what they carry", |session| {
        session.view.springs ^= true;
    }),
    once("trails", &["7"], "trails", |session| {
        session.view.trails ^= true;
        session.seen.trails = Default::default();
    }),
    once(
        "focus_panels",
        &["F6"],
        "the keyboard moves to the next part: bar, scenes, dock, scene",
        Session::focus_panels,
    ),
    once("larger", &["Ctrl+=", "Ctrl++"], "make the panels larger", |session| session.zoom_panels(1)),
    once("smaller", &["Ctrl+-"], "make the panels smaller", |session| session.zoom_panels(-1)),
    once("toggle_theme", &["F7"], "light or dark panels", Session::toggle_theme),
    once("toggle_browser", &["F8"], "show or hide the scenes at the left", Session::toggle_browser),
    once("toggle_dock", &["F9"], "show or hide the tools at the right", |session| {
        session.ui.cockpit.dock ^= true;
    }),
    once(
        "toggle_cockpit",
        &["F10"],
        "show or hide the bars and the dock around the view",
        Session::toggle_cockpit,
    ),
    once("screenshot", &["F12"], "write a screenshot", |session| {
        session.orders.push(Order::Screenshot(None));
    }),
    once(
        "cancel",
        &["Escape"],
        "close what was opened last, a list before its panel; else clear the selection",
        Session::cancel,
    ),
    once("quit", &["Ctrl+Q"], "quit, as the window's close button does", |session| {
        session.leave(Order::Quit);
    }),
];

/// Every action that has a key: those of tools come from their list.
pub static BINDINGS: LazyLock<Vec<Binding>> = LazyLock::new(|| {
    let tools = TOOLS.iter().map(|(panel, row)| Binding {
        name: row.name,
        keys: row.keys,
        when: When::Always,
        what: row.what,
        does: Does::Open(*panel),
    });
    FIRST.iter().copied().chain(tools).chain(LAST.iter().copied()).collect()
});

/// What the mouse does: input, when, what.
pub const MOUSE: &[(&str, When, &str)] = &[
    ("move", When::CameraMode, "look around, 0.07 degrees per count"),
    (
        "left button",
        When::SelectionMode,
        "select what is under the pointer and can be moved; held, without the bars around the view, select continuously",
    ),
    ("left drag", When::SelectionMode, "with the bars around the view: pull the body by a damped spring"),
    (
        "right button",
        When::Always,
        "push the selection along the ray with the click force, if the ray meets it first",
    ),
    ("right drag", When::SelectionMode, "with the bars around the view, beside the selection: orbit"),
    ("middle drag", When::SelectionMode, "with the bars around the view: pan"),
    (
        "wheel",
        When::Always,
        "change the click force, 100 N per notch, a negative force pulls; with the bars around the view and nothing to push, zoom",
    ),
];

/// Input, what it does and when, for every key and for the mouse.
pub(crate) fn rows() -> Vec<(String, &'static str, &'static str)> {
    let keys = BINDINGS.iter().map(|row| (row.keys.join("  "), row.what, row.when.words()));
    let mouse = MOUSE.iter().map(|(input, when, what)| ((*input).to_owned(), *what, when.words()));
    keys.chain(mouse).collect()
}

fn row(key: &Key) -> Option<&'static Binding> {
    let name = key.to_string();
    BINDINGS.iter().find(|binding| binding.keys.contains(&name.as_str()))
}

/// The row of the action of that name, if there is one.
pub(crate) fn named(name: &str) -> Option<&'static Binding> {
    BINDINGS.iter().find(|binding| binding.name == name)
}

/// The row of the key, if it has one.
#[must_use]
pub fn binding(key: &Key) -> Option<&'static Binding> {
    // Shift flies down while other keys fly on: it changes only the keys that have a row with it.
    row(key).or_else(|| row(&key.clone().with_shift(false)))
}

/// Whether shift, if it is held, belongs to the key: to a row of its own such as `Shift+I`, or to a character such as
/// `?`.
pub(crate) fn takes_shift(key: &Key) -> bool {
    let mut characters = key.name().chars();
    match (characters.next(), characters.next()) {
        (Some(one), None) if one.is_alphabetic() => key.shift() && row(key).is_some(),
        (Some(_), None) => true,
        _ => false,
    }
}

/// The key that a script means: a key's own name, or the name of an action.
///
/// # Errors
/// A word that is neither.
pub fn key_of_word(word: &str) -> Result<Key, UnknownKey> {
    match named(word) {
        Some(binding) => binding.keys[0].parse(),
        None => word.parse(),
    }
}

/// Whether a script's word for a key means one of those actions.
pub(crate) fn is_one_of(word: &str, names: &[&str]) -> bool {
    let key = key_of_word(word).ok();
    key.and_then(|key| binding(&key)).is_some_and(|binding| names.contains(&binding.name))
}

/// The table in Markdown, as docs/keys.md has it.
#[must_use]
pub fn markdown() -> String {
    let mut table =
        String::from("| key | when | what it does | name in scripts |\n| --- | --- | --- | --- |\n");
    for binding in BINDINGS.iter() {
        let keys = binding.keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(" ");
        table += &format!("| {keys} | {} | {} | `{}` |\n", binding.when.words(), binding.what, binding.name);
    }
    for (input, when, what) in MOUSE {
        table += &format!("| {input} | {} | {what} | |\n", when.words());
    }
    table
}
