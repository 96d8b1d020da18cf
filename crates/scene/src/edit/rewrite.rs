//! Writes keys and entries into the text of a scene.

use std::collections::BTreeMap;

use super::bracket::{Piece, indent_at};
use crate::text::faults::{Faults, SceneError};
use crate::text::tree::{Bracket, brackets};

/// A change of the text of a scene. Values are RON, as a person writes them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextEdit {
    /// Sets a key of a group, or removes it.
    Set {
        /// Key path of the group, as in `bodies[0].shape`; empty for the scene itself.
        group: String,
        /// The key.
        key: String,
        /// Its value; `None` removes the key.
        value: Option<String>,
    },
    /// Adds an entry at the end of a list of the scene.
    Add {
        /// The list, as in `bodies`.
        list: String,
        /// The entry.
        entry: String,
    },
    /// Removes an entry from a list of the scene.
    Remove {
        /// The list, as in `bodies`.
        list: String,
        /// Its index in the list, from 0.
        index: usize,
    },
}

impl TextEdit {
    /// Sets `key` of `group` to `value`.
    pub fn set(group: impl Into<String>, key: impl Into<String>, value: impl Into<String>) -> Self {
        Self::Set { group: group.into(), key: key.into(), value: Some(value.into()) }
    }

    /// Adds `entry` to `list`.
    pub fn add(list: impl Into<String>, entry: impl Into<String>) -> Self {
        Self::Add { list: list.into(), entry: entry.into() }
    }
}

/// Edits the text of a scene and keeps its comments and layout; messages call the text `name`. Paths and indices
/// refer to the text before the edits. The result need not be a valid scene: [`crate::Scene::parse`] checks it.
///
/// ```
/// use scene::{TextEdit, rewrite};
///
/// let text = "(version: 1, // the first\n bodies: [(mass_kg: 2)])";
/// let edits = [TextEdit::set("bodies[0]", "mass_kg", "3.0"), TextEdit::add("bodies", "()")];
/// assert_eq!(
///     rewrite("ball.ron", text, &edits).expect("there is such a body"),
///     "(version: 1, // the first\n bodies: [(mass_kg: 3.0), ()])",
/// );
/// ```
///
/// # Errors
///
/// If a group, a key or an entry is not in the text.
pub fn rewrite(name: &str, text: &str, edits: &[TextEdit]) -> Result<String, SceneError> {
    let mut groups: BTreeMap<&str, Vec<(&str, Option<&str>)>> = BTreeMap::new();
    let mut lists: BTreeMap<&str, ListEdit<'_>> = BTreeMap::new();
    for edit in edits {
        match edit {
            TextEdit::Set { group, key, value } => {
                groups.entry(group).or_default().push((key, value.as_deref()));
            }
            TextEdit::Add { list, entry } => lists.entry(list).or_default().added.push(entry),
            TextEdit::Remove { list, index } => lists.entry(list).or_default().removed.push(*index),
        }
    }
    let paths: Vec<&str> = groups.keys().chain(lists.keys()).copied().chain([""]).collect();
    let tree = brackets(text, &paths);
    let mut pieces = Vec::new();
    let removed = |path: &str| {
        let of = |index: &usize, list: &str| {
            let entry = format!("{list}[{index}]");
            path == entry || path.starts_with(&format!("{entry}."))
        };
        lists.iter().any(|(list, edit)| edit.removed.iter().any(|index| of(index, list)))
    };
    for (path, keys) in groups.into_iter().filter(|(path, _)| !removed(path)) {
        let group = tree.get(path).ok_or_else(|| missing(name, path, "there is no such group"))?;
        set(name, text, path, group, &keys, &mut pieces)?;
    }
    let scene = tree.get("").ok_or_else(|| missing(name, "", "the text is no group"))?;
    for (list, edit) in lists {
        change_list(name, text, scene, tree.get(list), list, edit, &mut pieces)?;
    }
    Ok(apply(text, pieces))
}

/// The edits of one list: the entries to add, and the indices of those to remove.
#[derive(Default)]
struct ListEdit<'a> {
    added: Vec<&'a str>,
    removed: Vec<usize>,
}

/// The keys of a scene after which its method is inserted. In other groups only the last two count, so that method
/// and substeps are side by side.
const BEFORE_METHOD: [&str; 7] =
    ["version", "name", "description", "step_hz", "step", "substeps", "method"];

fn set(
    name: &str,
    text: &str,
    path: &str,
    group: &Bracket<'_>,
    keys: &[(&str, Option<&str>)],
    pieces: &mut Vec<Piece>,
) -> Result<(), SceneError> {
    let (mut absent, mut gone) = (Vec::new(), Vec::new());
    for (key, value) in keys {
        let index = group.index(key);
        match (index, value) {
            (Some(index), Some(value)) => {
                pieces.push((group.items[index].value.clone(), (*value).to_owned()));
            }
            (Some(index), None) => {
                gone.push(index);
                pieces.push((group.remove(text, index), String::new()));
            }
            (None, Some(value)) => absent.push(format!("{key}: {value}")),
            (None, None) => {
                let path =
                    if path.is_empty() { (*key).to_owned() } else { format!("{path}.{key}") };
                return Err(missing(name, &path, "there is no such key"));
            }
        }
    }
    if !absent.is_empty() {
        let methods =
            absent.iter().all(|key| key.starts_with("method: ") || key.starts_with("substeps: "));
        let after = match (methods, path) {
            (true, "") => &BEFORE_METHOD[..],
            (true, _) => &BEFORE_METHOD[BEFORE_METHOD.len() - 2..],
            (false, _) => &[],
        };
        pieces.extend(group.insert(text, &absent, after, &gone));
    }
    Ok(())
}

fn change_list(
    name: &str,
    text: &str,
    scene: &Bracket<'_>,
    written: Option<&Bracket<'_>>,
    list: &str,
    ListEdit { added, mut removed }: ListEdit<'_>,
    pieces: &mut Vec<Piece>,
) -> Result<(), SceneError> {
    removed.sort_unstable();
    removed.dedup();
    for &index in &removed {
        let there = written.filter(|written| index < written.items.len());
        let there = there
            .ok_or_else(|| missing(name, &format!("{list}[{index}]"), "there is no such entry"))?;
        pieces.push((there.remove(text, index), String::new()));
    }
    if added.is_empty() {
        return Ok(());
    }
    let added: Vec<String> = added.iter().map(|entry| (*entry).to_owned()).collect();
    if let Some(written) = written {
        pieces.extend(written.insert(text, &added, &[], &removed));
        return Ok(());
    }
    let lined = scene.items.last().filter(|last| last.own_line(text).is_some());
    let value = match lined {
        Some(last) => {
            let (break_, indent) =
                (super::bracket::line_break(text), indent_at(text, last.value.start));
            let lines: String =
                added.iter().map(|entry| format!("{break_}{indent}    {entry},")).collect();
            format!("[{lines}{break_}{indent}]")
        }
        None => format!("[{}]", added.join(", ")),
    };
    pieces.extend(scene.insert(text, &[format!("{list}: {value}")], &[], &[]));
    Ok(())
}

/// The error for a path that is not in the text.
fn missing(name: &str, path: &str, what: &str) -> SceneError {
    let mut faults = Faults::default();
    faults.add(path, what, "give the path of one that is written in the text");
    faults.into_error(name, "", "")
}

/// Replaces pieces of the text. Only pieces that are removed may overlap.
pub(super) fn apply(text: &str, mut edits: Vec<Piece>) -> String {
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
