//! Intents: keys, the pointer and panels make them, and the session carries them out.

use std::path::PathBuf;

use history::Change;
use lab::cost::Setting;
use scene::{Entry, Scene, TextEdit};

use crate::actions::Act;
use crate::input::SwitchedBy;
use crate::stage::Order;

/// Something that a person wants.
#[derive(Clone, Debug)]
pub enum Intent {
    /// Do an action, as its key does.
    Act(Act),
    /// Change the simulation.
    Change(Change, SwitchedBy),
    /// Tell the person that what was asked for is wrong, and the cure.
    Refuse(String),
    /// Use a method and substeps that a panel offers.
    ApplySetting(Setting),
    /// Simulate this many seconds per second.
    Pace(f64),
    /// Change the force of a click by notches of the wheel.
    TurnForce(f64),
    /// Go to the end of that tick.
    Seek(u64),
    /// Save everything that is recorded.
    SaveBundle,
    /// Save that text as a CSV file.
    SaveTable(String),
    /// Open the scene of that name.
    Open(String),
    /// Open the shipped lesson of that name.
    OpenLesson(String),
    /// Change the scene's text, and restart it with the entry of that path selected.
    Rewrite(Vec<TextEdit>, Option<String>),
    /// Restart with another text of the scene, with the entry of that path selected.
    Restart(Box<Scene>, Option<String>),
    /// Delete an entry of the scene, or only its body with that stable id.
    Delete(Entry, Option<u32>),
    /// Ask the person something.
    Ask(Question),
    /// Answer the question that is asked.
    Answer(Answer),
}

/// A question to the person, asked before anything else.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// What to do with unsaved changes that this order would lose.
    Leaving(Order),
    /// What to do with unsaved changes that were left in this file.
    LeftBehind(PathBuf),
    /// Whether to delete the body of that name, or all bodies of its entry.
    Deleting {
        /// Name of the body.
        name: String,
        /// Its entry.
        entry: Entry,
        /// Its stable id, if it can be deleted by itself.
        alone: Option<u32>,
    },
}

/// The answer of the person to a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Save the changes.
    Save,
    /// Open what was left.
    Open,
    /// Discard the changes.
    Discard,
    /// Delete one body alone.
    Alone,
    /// Delete all bodies of the entry.
    All,
    /// Do nothing.
    Cancel,
}
