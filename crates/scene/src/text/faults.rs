//! What is wrong with a file: every fault at once, each with its place and its cure.

use std::fmt;

use crate::text::locate;
use crate::text::nearest::suggest;

/// One thing that is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The key, as in `bodies[3].mass_kg`; `None` if the fault is the file's as a whole.
    pub path: Option<String>,
    /// The line, from 1, where it can be known.
    pub line: Option<usize>,
    /// The column in characters, from 1, where it can be known.
    pub column: Option<usize>,
    /// What is wrong, as a clause.
    pub what: String,
    /// What would be right, as an instruction.
    pub cure: String,
}

/// A file that cannot be used, with all of its faults in the order of its lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    /// The file, shipped scene or text that is at fault, as the reader knows it.
    pub name: String,
    /// The faults, at least one.
    pub faults: Vec<Fault>,
}

impl SceneError {
    /// An error with one fault that belongs to the file as a whole.
    #[must_use]
    pub fn of_file(name: &str, what: impl Into<String>, cure: impl Into<String>) -> Self {
        let fault =
            Fault { path: None, line: None, column: None, what: what.into(), cure: cure.into() };
        Self { name: name.to_owned(), faults: vec![fault] }
    }
}

/// Most faults that a message lists; the reader fixes these first.
const SHOWN: usize = 20;

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.faults.iter().take(SHOWN).enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            f.write_str(&self.name)?;
            for number in [fault.line, fault.column].into_iter().flatten() {
                write!(f, ":{number}")?;
            }
            if let Some(path) = fault.path.as_deref().filter(|path| !path.is_empty()) {
                write!(f, ": {path}")?;
            }
            write!(f, ": {}; {}", fault.what, fault.cure)?;
        }
        match self.faults.len().saturating_sub(SHOWN) {
            0 => Ok(()),
            more => write!(f, "\n{}: and {} more", self.name, in_groups(more)),
        }
    }
}

impl std::error::Error for SceneError {}

/// A number as a person would write it: `{}` alone spells 1e-310 with three hundred zeros.
#[must_use]
pub fn shown(v: f64) -> String {
    let plain = v == 0.0 || !v.is_finite() || (1e-6..1e15).contains(&v.abs());
    if plain { format!("{v}") } else { format!("{v:e}") }
}

/// A number with a comma before each group of three digits.
fn in_groups(number: usize) -> String {
    let digits = number.to_string();
    let groups = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join(",")
}

/// Faults that are collected for a [`SceneError`], with the byte offsets of those whose paths do not determine their
/// places. Lines are looked up once, at the end, if there are any.
#[derive(Debug, Default)]
pub(crate) struct Faults(Vec<(Option<usize>, Fault)>);

impl Faults {
    /// Adds a fault of the key at `path`.
    pub fn add(
        &mut self,
        path: impl Into<String>,
        what: impl Into<String>,
        cure: impl Into<String>,
    ) {
        self.push(None, Some(path.into()), what.into(), cure.into());
    }

    /// Adds the fault of a key at `path` that its group does not have; `known` are the keys that the group has.
    pub fn unknown_key(&mut self, path: &str, known: &[&str]) {
        let key = path.rsplit_once('.').map_or(path, |(_, key)| key);
        let cure = if known.is_empty() { "remove it".to_owned() } else { suggest(key, known) };
        self.add(path, format!("unknown key `{key}`"), cure);
    }

    /// Adds a fault at byte `offset` of the text.
    pub fn add_at(&mut self, path: Option<String>, offset: usize, what: String, cure: String) {
        self.push(Some(offset), path, what, cure);
    }

    fn push(&mut self, offset: Option<usize>, path: Option<String>, what: String, cure: String) {
        self.0.push((offset, Fault { path, line: None, column: None, what, cure }));
    }

    /// Fails if there are any: see [`Self::into_error`].
    pub fn check(self, name: &str, text: &str, root: &str) -> Result<(), SceneError> {
        if self.0.is_empty() { Ok(()) } else { Err(self.into_error(name, text, root)) }
    }

    /// The error for the file `name`, whose outermost value is known as `root` in the paths.
    pub fn into_error(mut self, name: &str, text: &str, root: &str) -> SceneError {
        let paths: Vec<&str> =
            self.0.iter().map(|(_, fault)| fault.path.as_deref().unwrap_or(root)).collect();
        let offsets = locate::offsets(text, root, &paths);
        for ((offset, _), of_path) in self.0.iter_mut().zip(offsets) {
            *offset = offset.or(of_path);
        }
        self.0.sort_by_key(|(offset, _)| *offset);
        let ascending: Vec<usize> = self.0.iter().filter_map(|(offset, _)| *offset).collect();
        let placed = self.0.iter_mut().filter(|(offset, _)| offset.is_some());
        for ((_, fault), at) in placed.zip(locate::positions(text, &ascending)) {
            (fault.line, fault.column) = (Some(at.line), Some(at.column));
        }
        SceneError {
            name: name.to_owned(),
            faults: self.0.into_iter().map(|(_, fault)| fault).collect(),
        }
    }
}

#[cfg(test)]
mod tests;
