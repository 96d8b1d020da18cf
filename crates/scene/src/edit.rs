//! Methods and substeps written into the text of a scene, which keeps its comments and layout.

mod bracket;
mod entries;
mod fields;
mod rewrite;

use std::collections::HashMap;
use std::sync::Arc;

use motion::Method;

use crate::entries::Entry;
use crate::parts::Part;
use crate::resolve::springs::unsolvable;
use crate::scene::Scene;
use crate::text::faults::{Faults, SceneError};
pub use crate::text::kinds::Kind;
use crate::text::locate;
use bracket::{Bracket, Piece};
pub use entries::moved_place;
pub use fields::{Field, Value};
pub use rewrite::{TextEdit, rewrite};

/// A method and substeps for a scene, or for one entry of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// Key path of the entry, as in `soft_bodies[0]`; `None` for the scene itself.
    pub path: Option<String>,
    /// The method that it gets.
    pub method: Method,
    /// Into how many parts a tick is divided, 1 to 100,000.
    pub substeps: u32,
}

/// What to change for the bodies of each part to have the method and substeps that stand beside it.
///
/// The scene itself gets those of the free bodies, unless no scene with mutual gravity can have them; entries
/// differ from it only where they have to.
#[must_use]
pub fn changes(scene: &Scene, settings: &[(&Part, (Method, u32))]) -> Vec<Change> {
    let common = settings.iter().rev().map(|(_, setting)| *setting);
    let common = common
        .chain([(scene.method, scene.substeps)])
        .find(|(method, _)| unsolvable(*method, scene.mutual_gravity.is_some()).is_none())
        .unwrap_or((scene.method, scene.substeps));
    let mut changes = vec![Change { path: None, method: common.0, substeps: common.1 }];
    for (part, setting) in settings {
        let differs = |entry: &&Entry| {
            let body = &scene.bodies[entry.bodies.start as usize];
            *setting != common || body.method.is_some() || body.substeps.is_some()
        };
        let own = part.entries.iter().filter(differs);
        changes.extend(own.map(|entry| Change {
            path: Some(entry.path()),
            method: setting.0,
            substeps: setting.1,
        }));
    }
    changes
}

/// The method of a scene stands behind the last of these keys.
const BEFORE_METHOD: [&str; 5] = ["version", "name", "description", "step_hz", "step"];

/// Writes methods and substeps into the text of a scene; `name` is what messages call it.
///
/// A key that would say what holds without it is not written.
///
/// ```
/// use motion::Method;
/// use scene::{Change, edit};
///
/// let text = "(version: 1, // the first\n bodies: [(mass_kg: 2)])";
/// let path = Some("bodies[0]".to_owned());
/// let change = Change { path, method: Method::RungeKutta4, substeps: 3 };
/// let edited = edit("ball.ron", text, &[change]).expect("there is such a body");
/// assert_eq!(
///     edited,
///     "(version: 1, // the first\n bodies: [(mass_kg: 2, method: runge_kutta_4, substeps: 3)])",
/// );
/// ```
///
/// # Errors
///
/// If the text is no scene, or has no such entry; if the edited text would be no scene, or one in which anything but
/// these methods and substeps is different: nothing is written then.
pub fn edit(name: &str, text: &str, changes: &[Change]) -> Result<String, SceneError> {
    let before = Scene::parse(name, text)?;
    let entries = targets(name, &before, changes)?;
    let paths: Vec<&str> = changes.iter().map(|change| change.path.as_deref().unwrap_or("")).collect();
    let written = locate::written(text, "", paths.iter().copied());
    let root = changes.iter().find(|change| change.path.is_none());
    let inherited = root.map_or((before.method, before.substeps), |root| (root.method, root.substeps));
    let mut edits = Vec::new();
    for (change, path) in changes.iter().zip(paths) {
        let group = written.get(path).and_then(|offset| Bracket::at(text, *offset));
        let group = group.ok_or_else(|| missing(name, path))?;
        let default = if change.path.is_none() { (Method::default(), 1) } else { inherited };
        set(text, &group, change, default, &mut edits);
    }
    let edited = apply(text, edits);
    check(name, before, Scene::parse(name, &edited)?, changes, &entries)?;
    Ok(edited)
}

/// The entry of each change; `None` for the scene itself.
fn targets(name: &str, scene: &Scene, changes: &[Change]) -> Result<Vec<Option<Entry>>, SceneError> {
    let entries: HashMap<_, _> = scene.entries().into_iter().map(|entry| (entry.path(), entry)).collect();
    let target = |change: &Change| match &change.path {
        None => Ok(None),
        Some(path) => entries.get(path).cloned().map(Some).ok_or_else(|| missing(name, path)),
    };
    changes.iter().map(target).collect()
}

fn missing(name: &str, path: &str) -> SceneError {
    let cure = "give the path of a body, a grid, a cloud, an emitter or a soft body";
    not_there(name, path, "there is no such entry", cure)
}

/// The error for a path that is not in the text.
fn not_there(name: &str, path: &str, what: &str, cure: &str) -> SceneError {
    let mut faults = Faults::default();
    faults.add(path, what, cure);
    faults.into_error(name, "", "")
}

/// Adds the pieces that give the group the method and substeps of `change`; `inherited` holds without them.
fn set(text: &str, group: &Bracket, change: &Change, inherited: (Method, u32), pieces: &mut Vec<Piece>) {
    let (method, substeps) = (change.method.name().to_owned(), change.substeps.to_string());
    let values = [
        ("method", method, change.method == inherited.0),
        ("substeps", substeps, change.substeps == inherited.1),
    ];
    let mut absent = Vec::new();
    for (name, value, holds_anyway) in values {
        match group.key(name) {
            Some(key) => pieces.push((key.value.clone(), value)),
            None if holds_anyway => {}
            None => absent.push(format!("{name}: {value}")),
        }
    }
    if !absent.is_empty() {
        let before: &[&str] = if change.path.is_none() { &BEFORE_METHOD } else { &[] };
        // Method and substeps stand side by side.
        let after = [before, &["substeps", "method"]].concat();
        pieces.extend(group.insert(text, &absent, &after, &[]));
    }
}

/// Replaces pieces of the text that do not overlap, but for what is taken out.
fn apply(text: &str, mut edits: Vec<Piece>) -> String {
    edits.sort_by_key(|(range, _)| range.start);
    let (mut edited, mut done) = (String::with_capacity(text.len()), 0);
    for (range, new) in edits {
        edited.push_str(&text[done..range.start.max(done)]);
        edited.push_str(&new);
        done = range.end.max(done);
    }
    edited.push_str(&text[done..]);
    edited
}

/// Fails unless `after` is `before` with the changes and nothing else.
fn check(
    name: &str,
    mut before: Scene,
    mut after: Scene,
    changes: &[Change],
    entries: &[Option<Entry>],
) -> Result<(), SceneError> {
    let mut right = true;
    for (change, entry) in changes.iter().zip(entries) {
        let Some(entry) = entry else { continue };
        for id in entry.bodies.clone() {
            let body = after.bodies[id as usize];
            right &= body.method.unwrap_or(after.method) == change.method
                && body.substeps.unwrap_or(after.substeps) == change.substeps;
            for scene in [&mut before, &mut after] {
                let body = &mut scene.bodies[id as usize];
                (body.method, body.substeps) = (None, None);
            }
        }
    }
    if let Some(change) = changes.iter().find(|change| change.path.is_none()) {
        (before.method, before.substeps) = (change.method, change.substeps);
    }
    // The text is another one, and lines move down where one comes in.
    for scene in [&mut before, &mut after] {
        scene.text = Arc::default();
        scene.declared.iter_mut().for_each(|declaration| declaration.line = None);
    }
    if right && before == after {
        return Ok(());
    }
    let what = "methods and substeps cannot be written into this text without changing more than them";
    Err(SceneError::of_file(name, what, "write them by hand"))
}

#[cfg(test)]
mod tests;
