//! A script that a session plays.
//!
//! Its keys and pointer act at the start of a frame, as a person's do. Its other steps act between two ticks, so that they
//! act in the same tick whatever the frames are.

use std::path::Path;

use egui::accesskit::ActionRequest;
use scene::{Action, InputAction, Recording, Scene, Script, Source, Step, When};

use crate::actions::{self, Act};
use crate::app::player::Player;
use crate::input::UnknownKey;
use crate::panels::Panel;
use crate::refused::Refused;

impl Player {
    /// Prepares `script` and checks its key names.
    ///
    /// # Errors
    /// The index and the word of every step that names an unknown key.
    pub fn new(script: Script) -> Result<Self, Vec<(usize, UnknownKey)>> {
        let named = script.recording.filter(|recording| recording.names_settings);
        let named_frames = named.map_or(0, |recording| recording.frame_ends_s.len() as u64);
        let (mut steps, mut unknown) = (script.steps, Vec::new());
        for (number, step) in steps.iter_mut().enumerate() {
            let Action::Input(
                InputAction::Press(word)
                | InputAction::Hold(word, _)
                | InputAction::KeyDown(word)
                | InputAction::KeyUp(word),
            ) = &mut step.action
            else {
                continue;
            };
            match actions::key_of_word(word) {
                Ok(key) => *word = key.to_string(),
                Err(error) => unknown.push((number, error)),
            }
        }
        if unknown.is_empty() { Ok(Self::of(steps, named_frames)) } else { Err(unknown) }
    }
}

/// How long an action lasts by itself, s.
pub(super) fn length_s(action: &Action) -> f64 {
    match action {
        Action::Input(InputAction::Hold(_, seconds) | InputAction::Wait(seconds)) => *seconds,
        Action::Input(_) | Action::Change(_) | Action::Picture(_) => 0.0,
    }
}

/// The time between two actions that a person watches, s.
const APART_S: f64 = 0.7;

/// Players of `actions` of a lesson, each with its frame time, s: from `at` on, so slowly that a person can follow.
pub(super) fn shown(actions: &[Action], mut at: f64) -> Vec<(f64, Player)> {
    let player = |action: &Action| {
        let steps = vec![Step { when: When::Frame(0), action: action.clone() }];
        at += APART_S;
        let player = (at, Player::new(Script { steps, recording: None }).ok()?);
        at += length_s(action);
        Some(player)
    };
    actions.iter().filter_map(player).collect()
}

/// Actions that may bring removed bodies back.
const BRING_BACK: [Act; 6] = [
    Act::ResetWorld,
    Act::PreviousScene,
    Act::NextScene,
    Act::Panel(Panel::Finder),
    Act::StepBack,
    Act::Panel(Panel::Timeline),
];

/// Reads the text of a script or a recording and checks its keys, and its bodies against those of a scene. `name` is that of its
/// file.
///
/// # Errors
/// If it cannot be read or names something that is not there.
pub fn read_script(name: &str, text: &str, scene: &Scene) -> Result<Script, Refused> {
    let script = Script::parse(name, text)?;
    if let Some(recording) = &script.recording {
        check_scene(recording, name, scene)?;
    }
    let is_key = |word: &str| actions::key_of_word(word).is_ok();
    let is_request = |text: &str| serde_json::from_str::<ActionRequest>(text).is_ok();
    let brings_back = |word: &str| actions::presses_one_of(word, &BRING_BACK);
    script.check(name, text, scene, is_key, is_request, brings_back)?;
    Ok(script)
}

/// Refuses a recording of another scene. Compares file names without their folders, because files move.
fn check_scene(recording: &Recording, name: &str, scene: &Scene) -> Result<(), Refused> {
    let stem = |path: &Path| path.file_stem().map(std::ffi::OsStr::to_owned);
    let opened = match &scene.source {
        Source::Shipped(name) => Path::new(name),
        Source::File(path) => path,
        Source::Text => return Ok(()),
    };
    let recorded = &recording.scene;
    if stem(Path::new(recorded)) == stem(opened) {
        return Ok(());
    }
    let opened = opened.display();
    Err(Refused(format!(
        "{name}: this was recorded in {recorded}, not in {opened}; open {recorded}"
    )))
}

/// A player for a script that was loaded.
pub fn player_of(script: Script) -> Player {
    Player::new(script).expect("the keys of a loaded script are checked")
}
