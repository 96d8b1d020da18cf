//! Turns scene files and scripts into worlds. This is the only crate that parses what people write.
//!
//! In order of importance, this crate is for: messages that say what would be right, every fault of a file at once; one place for
//! defaults and units; the same world from the same file, always.
//!
//! From text to world, in this order:
//!
//! - `text`: RON with the places of its keys, and faults, each with its place and its cure ([`SceneError`]).
//! - `raw`: a scene as a person writes it; every key is optional.
//! - `resolve`: fills in defaults, converts units and finds faults. Nothing after it sees an absent number. `check` has the checks
//!   of single values.
//! - `generate`: the bodies of grids, clouds, rings, emitters and soft bodies. `random` draws their random numbers.
//! - [`Scene`]: a scene as the program uses it; `scene` has its parts, such as [`BodySpec`], and [`Names`] of bodies.
//! - `spawn`: entities from a scene, each with the components that it needs and no others.
//!
//! Beside it:
//!
//! - [`Script`] and [`Recording`]: what happens when; [`Action`] lists what can happen. [`parse_frame_times`]: lengths of frames.
//! - [`lesson`]: what a lesson shows, asks and measures.
//! - [`TextEdit`] and [`rewrite`]: changes of the text of a scene, which keeps its comments and layout. [`VariedScene`]:
//!   scenes that differ from one text in some values.
//! - [`Entry`] and [`Part`]: which entry a body comes from, and which bodies act on each other.
//! - [`lists`]: lists of files, read into no more memory than is allowed.
//! - [`memory`](memory()): the memory that a scene takes, estimated before any of it is allocated.
//! - [`shipped`](shipped()): the scenes and hard cases in the program, and scenes by name or path.
//!
//! The stable id of a body is its place in the file: first `bodies`, then `grids`, `clouds`, `rings`, `emitters` and
//! `soft_bodies`, each in the order in which they are written; in a grid and in a lattice x is the outer loop, in a
//! cloth the row.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test"))]

mod action;
mod check;
mod edit;
mod entries;
mod frame_times;
mod generate;
pub mod lesson;
pub mod lists;
mod memory;
mod parts;
mod random;
mod raw;
mod resolve;
mod scene;
mod script;
mod shipped;
mod spawn;
mod substepping;
mod text;

pub use action::{
    Action, ChangeAction, InputAction, MouseButton, PictureAction, Step, Target, TouchPhase, When,
};
pub use check::{BODY_MASS, COMPONENT, DAMPING_RATE, Rule, STEP_RATE, broken};
pub use edit::{Field, Kind, Setting, TextEdit, Value, VariedScene, moved_place, rewrite};
pub use entries::Entry;
pub use frame_times::parse_frame_times;
pub use generate::BODY_LIMIT;
pub use memory::{
    Keeps, TIMELINE_BYTES, address_space, allow_memory, byte_words, memory, runs_that_fit,
};
pub use parts::{FREE_BODIES, Part};
pub use resolve::declared::key_of_law;
pub use resolve::springs::unsolvable;
pub use resolve::survival::EXPLODES;
pub use scene::coupled::{Declaration, EmitterSpec, SoftBodySpec, SpringSpec};
pub use scene::names::Names;
pub use scene::survival::{Bounds, Lengths, Measure, SurvivalRow, TickLengths};
pub use scene::{
    BodySpec, CameraSpec, ExpectSpec, LightSpec, OwnLawsSpec, PushSpec, Reading, SCENE_VERSION,
    Scene, Source, StepKind,
};
pub use script::{Recording, RecordingText, SCRIPT_VERSION, Script};
pub use shipped::{
    FILE_LIMIT, ShippedScene, cases, embedded, find, io_words, load, load_case, load_path,
    read_text, shipped,
};
pub use spawn::{Appearance, FileIndex, PointRadius, SoftBodyName};
pub use substepping::{Choice, Substepping};
pub use text::faults::{Fault, SceneError, shown};
pub use text::nearest::{did_you_mean, nearest};

/// A scene with these keys.
#[cfg(test)]
fn parse(keys: &str) -> Scene {
    Scene::parse("t", &format!("(version: 1, {keys})")).unwrap_or_else(|error| panic!("{error}"))
}

/// Fails unless the file below `src` has `answer` of every text in it; UPDATE_EXPECT=1 writes the answers.
///
/// A case is a line `----`, a text, a line `=>`, and the answer to the text.
#[cfg(test)]
#[track_caller]
fn answers(file: &str, answer: impl Fn(&str) -> String) {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(file);
    let file = expect_test::expect_file![path];
    let answered = |case: &str| {
        let (text, _) =
            case.split_once("\n=>\n").expect("a case is a text, an arrow and an answer");
        format!("----\n{text}\n=>\n{}\n", answer(text).trim_end())
    };
    let stored = file.data();
    assert!(stored.starts_with("----\n"), "{file:?} has no case");
    file.assert_eq(&stored.split("----\n").skip(1).map(answered).collect::<String>());
}
