//! Scripts and recordings: what happens when, read from and written to RON.

use std::collections::HashMap;

use motion::Method;
use serde::Deserialize;

use crate::action::{Action, ChangeAction, InputAction, Step, Target, When};
use crate::scene::Scene;
use crate::text::faults::{Faults, SceneError, shown};
use crate::text::locate;
use crate::text::syntax::{self, Word, keys_of};

/// Version of recordings that this program reads and writes.
pub const SCRIPT_VERSION: u32 = 2;

/// The first version, in which keys have no times: what a key pushes acts in whole frames.
const FIRST_VERSION: u32 = 1;

/// Steps in the order of their list; a recording has a header too.
///
/// A step of frames is carried out at the start of a frame, one of ticks before a tick (see [`Step::is_of_ticks`]): each when its
/// time has come and all steps of its kind before it in the list are done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    /// What happens, in order; moments of one kind never go backwards.
    pub steps: Vec<Step>,
    /// The header, if this is a recording.
    pub recording: Option<Recording>,
}

/// The header of a recording: what a session needs beside the inputs to repeat another session to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Name of the scene, or path of its file.
    pub scene: String,
    /// The method that replaced those of the scenes, if one did.
    pub method: Option<Method>,
    /// Size of the window at the start, px.
    pub size_px: (u32, u32),
    /// Whether steps name the settings that were chosen in panels, in place of the clicks on them: a panel offers
    /// what its machine measured, so the same click could choose another setting. Steps of older recordings do not.
    pub names_settings: bool,
    /// End of every frame since the start, s, finite, at least 0, never going backwards.
    pub frame_ends_s: Vec<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Recording")]
struct RawRecording<'a> {
    version: Option<u32>,
    scene: Option<String>,
    method: Option<Word>,
    size_px: Option<(u32, u32)>,
    #[serde(default)]
    names_settings: bool,
    frame_ends_s: Option<Vec<f64>>,
    #[serde(borrow, default)]
    steps: Vec<RawStep<'a>>,
}

/// A step whose action is still text, so that a bad action does not hide the next one.
#[derive(Debug, Deserialize)]
#[serde(rename = "Step")]
struct RawStep<'a> {
    at_s: Option<f64>,
    at_tick: Option<u64>,
    at_frame: Option<u64>,
    #[serde(borrow, rename = "do")]
    action: Option<&'a ron::value::RawValue>,
}

impl Script {
    /// Reads a script, which is a list, or a recording, which is a group with a header.
    ///
    /// ```
    /// let script = scene::Script::parse("fall.ron", r#"[(at_s: 0.5, do: press("G"))]"#).expect("it is a script");
    /// assert_eq!(script.steps[0].when, scene::When::Seconds(0.5));
    /// ```
    ///
    /// # Errors
    ///
    /// If the text is not RON or a moment has the wrong type: that one place. Otherwise every fault of the text.
    pub fn parse(name: &str, text: &str) -> Result<Self, SceneError> {
        let text = locate::spell_nan(text);
        let text = text.as_str();
        let mut faults = Faults::default();
        let root = root_of(text);
        let fail = |error| syntax::error(name, text, root, &error);
        let (raw_steps, unknown, recording) = if root.is_empty() {
            let (raw, unknown) = syntax::read::<RawRecording<'_>>(text, root).map_err(fail)?;
            let recording = header(&raw, &mut faults);
            (raw.steps, unknown, Some(recording))
        } else {
            let (steps, unknown) = syntax::read::<Vec<RawStep<'_>>>(text, root).map_err(fail)?;
            (steps, unknown, None)
        };
        for path in unknown {
            let is_header = !path.contains('.');
            let keys =
                if is_header { keys_of::<RawRecording<'_>>() } else { keys_of::<RawStep<'_>>() };
            faults.unknown_key(&path, keys);
        }
        let mut earlier = Vec::new();
        let mut steps = Vec::with_capacity(raw_steps.len());
        for (i, raw) in raw_steps.iter().enumerate() {
            let when = when(raw, i, &mut earlier, &mut faults);
            let action = action(raw, i, text, root, &mut faults);
            if let (Some(when), Some(action)) = (when, action) {
                steps.push(Step { when, action });
            }
        }
        faults.check(name, text, root)?;
        Ok(Self { steps, recording })
    }

    /// Checks that the script fits `scene`: every body that it names exists and was not removed before, `is_key` is
    /// true for every key, `is_request` for every request of assistive technology, and every effect is declared.
    /// `brings_back` says whether removed bodies may exist again after a key. Messages call the script `name`; `text` is
    /// its text.
    ///
    /// # Errors
    /// With every step that does not fit.
    pub fn check(
        &self,
        name: &str,
        text: &str,
        scene: &Scene,
        is_key: impl Fn(&str) -> bool,
        is_request: impl Fn(&str) -> bool,
        brings_back: impl Fn(&str) -> bool,
    ) -> Result<(), SceneError> {
        let mut faults = Faults::default();
        let mut removed = Removed::default();
        for (i, step) in self.steps.iter().enumerate() {
            let mut found = Vec::new();
            match step.action.key() {
                Some(key) if !is_key(key) => {
                    let cure = "`sandbox list keys` names them all".to_owned();
                    found.push((format!("there is no key or action `{key}`"), cure));
                }
                Some(key) if brings_back(key) => removed = Removed::default(),
                _ => {}
            }
            if matches!(&step.action, Action::Input(InputAction::Assist(request)) if !is_request(request))
            {
                let what = "this is no `ActionRequest` of AccessKit as JSON".to_owned();
                found.push((what, "take it from a recording".to_owned()));
            }
            found.extend(undeclared(&step.action, scene));
            found.extend(
                match step.action.body().filter(|body| scene.names.find(body).is_none()) {
                    Some(stranger) => Some(scene.names.stranger(stranger)),
                    None => removed.check(i, step),
                },
            );
            for (what, cure) in found {
                faults.add(format!("steps[{i}].do"), what, cure);
            }
        }
        faults.check(name, text, root_of(text))
    }

    /// The script as RON that [`Self::parse`] reads back to the same value, every number to the last bit.
    #[must_use]
    pub fn to_ron(&self) -> String {
        let Some(recording) = &self.recording else {
            return format!(
                "[\n{}]\n",
                self.steps.iter().map(|step| line_of(step, "    ")).collect::<String>()
            );
        };
        let mut text = RecordingText::new(recording);
        recording.frame_ends_s.iter().for_each(|end| text.add_frame(*end));
        self.steps.iter().for_each(|step| text.add_step(step));
        text.whole(0)
    }
}

/// A recording as RON, frame by frame.
#[derive(Clone, Debug)]
pub struct RecordingText {
    /// Text before the ends of the frames.
    head: String,
    ends: String,
    steps: String,
}

impl RecordingText {
    /// Text between the ends of the frames and the steps.
    const BETWEEN: &str = "    ],\n    steps: [\n";
    /// Text after the steps.
    pub const END: &str = "    ],\n)\n";

    /// A recording with that header and no frames.
    #[must_use]
    pub fn new(
        Recording { scene, method, size_px: (width, height), names_settings, .. }: &Recording,
    ) -> Self {
        let method =
            method.map(|method| format!("    method: {},\n", method.name())).unwrap_or_default();
        let named = if *names_settings { "    names_settings: true,\n" } else { "" };
        let head = format!(
            "(\n    version: {SCRIPT_VERSION},\n    scene: {},\n{method}    size_px: ({width}, {height}),\n\
             {named}    frame_ends_s: [\n",
            written(scene)
        );
        Self { head, ends: String::new(), steps: String::new() }
    }

    /// Adds a frame that ends at `end` seconds.
    pub fn add_frame(&mut self, end: f64) {
        self.ends.push_str(&format!("        {end:?},\n"));
    }

    /// Adds a step after the others.
    pub fn add_step(&mut self, step: &Step) {
        self.steps.push_str(&line_of(step, "        "));
    }

    /// The whole text, with `room` blanks after the last frame.
    #[must_use]
    pub fn whole(&self, room: usize) -> String {
        let Self { head, ends, steps } = self;
        format!("{head}{ends}{}{}{steps}{}", " ".repeat(room), Self::BETWEEN, Self::END)
    }

    /// The lines of the frames, and where they begin in the whole text.
    #[must_use]
    pub fn ends(&self) -> (usize, &str) {
        (self.head.len(), &self.ends)
    }

    /// The lines of the steps, and where they begin in the whole text with `room` blanks.
    #[must_use]
    pub fn steps(&self, room: usize) -> (usize, &str) {
        (self.head.len() + self.ends.len() + room + Self::BETWEEN.len(), &self.steps)
    }
}

/// A step in a line of its own.
fn line_of(Step { when, action }: &Step, indent: &str) -> String {
    let when = match when {
        When::Seconds(seconds) => format!("at_s: {seconds:?}"),
        When::Tick(tick) => format!("at_tick: {tick}"),
        When::Frame(frame) => format!("at_frame: {frame}"),
    };
    format!("{indent}({when}, do: {}),\n", written(action))
}

/// The path of the outermost value of a script: steps of a bare list have the same paths as those of a recording.
fn root_of(text: &str) -> &'static str {
    if locate::is_group(text, "Recording") { "" } else { "steps" }
}

/// What is wrong with an action of an effect that `scene` does not declare.
pub(crate) fn undeclared(action: &Action, scene: &Scene) -> Option<(String, String)> {
    let declares = |effect| scene.declared.iter().any(|declared| declared.effect == effect);
    let Target::Effect(effect) = action.change()?.target() else { return None };
    if declares(effect) {
        return None;
    }
    let what = format!("this scene declares no effect `{effect}`");
    Some((what, "declare it in the scene, or leave this step out".to_owned()))
}

/// Bodies that earlier steps have removed, separately for steps of frames and of ticks, which have no common order.
#[derive(Default)]
pub(crate) struct Removed<'a>(HashMap<(bool, &'a str), usize>);

impl<'a> Removed<'a> {
    /// Records step number `i`. Returns what is wrong with it, if its body was removed before.
    pub fn check(&mut self, i: usize, step: &'a Step) -> Option<(String, String)> {
        let body = (step.is_of_ticks(), step.action.body()?);
        let before = self.0.get(&body).copied();
        if matches!(step.action, Action::Change(ChangeAction::Remove(_))) {
            self.0.entry(body).or_insert(i);
        }
        let what = format!("steps[{}] has removed \"{}\" before", before?, body.1);
        Some((what, "leave this step out, or put it first".to_owned()))
    }
}

fn written<T: serde::Serialize>(value: &T) -> String {
    ron::to_string(value).expect("texts and actions are plain values, which RON can write")
}

fn header(raw: &RawRecording<'_>, faults: &mut Faults) -> Recording {
    match raw.version {
        None => faults.add(
            "version",
            "the version is missing",
            format!("add `version: {SCRIPT_VERSION}`"),
        ),
        Some(FIRST_VERSION..=SCRIPT_VERSION) => {}
        Some(other) => faults.add(
            "version",
            format!("version {other} of recordings is not one that this program reads"),
            format!("record again with this program, which writes version {SCRIPT_VERSION}"),
        ),
    }
    if raw.scene.is_none() {
        faults.add(
            "scene",
            "the scene is missing",
            "add the name of a scene, such as `scene: \"tutorial\"`",
        );
    }
    let method = raw.method.as_ref().and_then(|Word(word)| Method::from_name(word));
    if let (Some(Word(word)), None) = (&raw.method, method) {
        let names = Method::ALL.map(Method::name).join(", ");
        faults.add(
            "method",
            format!("there is no method `{word}`"),
            format!("the methods are {names}"),
        );
    }
    if !raw.size_px.is_some_and(|(width, height)| width > 0 && height > 0) {
        faults.add("size_px", "the window has no size", "give one such as `size_px: (1280, 720)`");
    }
    if raw.frame_ends_s.is_none() {
        faults.add(
            "frame_ends_s",
            "the frames are missing",
            "add the end of every frame in seconds",
        );
    }
    let ends = raw.frame_ends_s.as_deref().unwrap_or_default();
    let mut last = 0.0;
    for (i, &end) in ends.iter().enumerate() {
        if !(end >= last && end.is_finite()) {
            let what = format!(
                "a frame cannot end at {} s after one that ended at {} s",
                shown(end),
                shown(last)
            );
            faults.add(
                format!("frame_ends_s[{i}]"),
                what,
                "give finite times that never go backwards",
            );
        } else {
            last = end;
        }
    }
    Recording {
        scene: raw.scene.clone().unwrap_or_default(),
        method,
        size_px: raw.size_px.unwrap_or_default(),
        names_settings: raw.names_settings,
        frame_ends_s: ends.to_vec(),
    }
}

/// When a step is due; `earlier` has the moments of the steps before it.
fn when(raw: &RawStep<'_>, i: usize, earlier: &mut Vec<When>, faults: &mut Faults) -> Option<When> {
    let step = format!("steps[{i}]");
    let (key, when) = match (raw.at_s, raw.at_tick, raw.at_frame) {
        (Some(at), None, None) => ("at_s", When::Seconds(at)),
        (None, Some(at), None) => ("at_tick", When::Tick(at)),
        (None, None, Some(at)) => ("at_frame", When::Frame(at)),
        (None, None, None) => {
            faults.add(step, "the step has no time", "add at_s, at_tick or at_frame");
            return None;
        }
        _ => {
            faults.add(
                step,
                "the step has several times",
                "keep one of at_s, at_tick and at_frame",
            );
            return None;
        }
    };
    let key = format!("{step}.{key}");
    let before = earlier.iter().rev().find_map(|latest| Some((latest, when.precedes(*latest)?)));
    match (when, before) {
        (When::Seconds(at), _) if !(at >= 0.0 && at.is_finite()) => {
            faults.add(key, format!("{} is not a time", shown(at)), "give seconds from 0 up");
            return None;
        }
        (_, Some((latest, true))) => {
            let what = format!("{when} comes after {latest}");
            faults.add(key, what, "give times that never go backwards");
            return None;
        }
        _ => {}
    }
    earlier.push(when);
    Some(when)
}

fn action(
    raw: &RawStep<'_>,
    i: usize,
    text: &str,
    root: &str,
    faults: &mut Faults,
) -> Option<Action> {
    let Some(piece) = raw.action.map(ron::value::RawValue::get_ron) else {
        faults.add(
            format!("steps[{i}]"),
            "the step does nothing",
            "add an action such as `do: press(\"G\")`",
        );
        return None;
    };
    match syntax::read::<Action>(piece, "") {
        Ok((Action::Input(InputAction::Wait(_)), _)) => {
            let cure = "give the next step a later time";
            faults.add(
                format!("steps[{i}].do"),
                "a script does not wait: its steps have times",
                cure,
            );
            None
        }
        Ok((action, _)) => match action.fault() {
            Some((what, cure)) => {
                faults.add(format!("steps[{i}].do"), what, cure);
                None
            }
            None => Some(action),
        },
        Err(error) => {
            // The piece borrows from the text, so the difference of the addresses is its offset.
            let start = (piece.as_ptr() as usize).saturating_sub(text.as_ptr() as usize);
            syntax::fault(faults, text, root, start..start + piece.len(), &error);
            None
        }
    }
}

#[cfg(test)]
mod tests;
