//! The keys of a group in a scene's text, with their values, from which a form is made.

use std::fmt;

use glam::DVec3;

use crate::raw;
use crate::scene::Scene;
use crate::text::kinds::Kind;
use crate::text::tree::{Item, brackets};

/// A key of a group, and its value as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The key.
    pub key: &'static str,
    /// What kind of value it takes.
    pub kind: Kind,
    /// Its value, if the key is written.
    pub value: Option<Value>,
}

/// A value in the text of a scene. Its display is RON.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `true` or `false`.
    Flag(bool),
    /// A whole number.
    Count(u64),
    /// A number.
    Number(f64),
    /// Numbers in round brackets.
    Numbers(Vec<f64>),
    /// A text, without its quotes.
    Text(String),
    /// Anything else, as it is written.
    Written(String),
}

impl Value {
    /// Reads a value of that kind from its text.
    #[must_use]
    pub fn read(kind: Kind, written: &str) -> Self {
        let value = match kind {
            Kind::Flag => ron::from_str(written).ok().map(Self::Flag),
            // A field does not represent larger whole numbers exactly.
            Kind::Count => {
                ron::from_str(written).ok().filter(|count| *count < 1 << 53).map(Self::Count)
            }
            Kind::Number => ron::from_str(written)
                .ok()
                .filter(|number: &f64| number.is_finite())
                .map(Self::Number),
            Kind::Numbers(length) => {
                numbers(written).filter(|numbers| numbers.len() == length).map(Self::Numbers)
            }
            Kind::Text => ron::from_str(written).ok().map(Self::Text),
            Kind::Word | Kind::Group | Kind::Other => None,
        };
        value.unwrap_or_else(|| Self::Written(written.to_owned()))
    }
}

/// Finite numbers in round brackets.
fn numbers(written: &str) -> Option<Vec<f64>> {
    let number = |item: &Item<'_>| ron::from_str::<f64>(&written[item.value.clone()]).ok();
    let numbers: Option<Vec<f64>> =
        brackets(written, &[""]).get("")?.items.iter().map(number).collect();
    numbers.filter(|numbers| numbers.iter().all(|number| number.is_finite()))
}

impl From<DVec3> for Value {
    fn from(v: DVec3) -> Self {
        Self::Numbers(v.to_array().to_vec())
    }
}

impl fmt::Display for Value {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flag(flag) => write!(out, "{flag}"),
            Self::Count(count) => write!(out, "{count}"),
            Self::Number(number) => write!(out, "{number:?}"),
            Self::Numbers(numbers) => {
                let numbers: Vec<_> = numbers.iter().map(|number| format!("{number:?}")).collect();
                write!(out, "({})", numbers.join(", "))
            }
            Self::Text(text) => {
                let escaped = text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
                write!(out, "\"{escaped}\"")
            }
            Self::Written(written) => write!(out, "{written}"),
        }
    }
}

impl Scene {
    /// The keys of the group at `path` of the scene's text, as in `bodies[0].shape`; those of the scene itself for an
    /// empty path. Empty if the group is not written.
    #[must_use]
    pub fn fields(&self, path: &str) -> Vec<Field> {
        self.fields_of(&[path]).pop().unwrap_or_default()
    }

    /// [`Self::fields`] of each of `paths`, in one scan of the text.
    #[must_use]
    pub fn fields_of(&self, paths: &[&str]) -> Vec<Vec<Field>> {
        let tree = brackets(&self.text, paths);
        let fields = |path: &&str| {
            let Some(group) = tree.get(*path) else { return Vec::new() };
            let kind = group.word(&self.text);
            let field = |(key, kind)| {
                let written = group.key(key).map(|item| &self.text[item.value.clone()]);
                Field { key, kind, value: written.map(|written| Value::read(kind, written)) }
            };
            raw::kinds_at(path, kind).into_iter().map(field).collect()
        };
        paths.iter().map(fields).collect()
    }

    /// Number of entries that are written in a list of the scene.
    #[must_use]
    pub fn count(&self, list: &str) -> usize {
        let [count] = self.counts([list]);
        count
    }

    /// [`Self::count`] of each of `lists`, in one scan of the text.
    #[must_use]
    pub fn counts<const N: usize>(&self, lists: [&str; N]) -> [usize; N] {
        let tree = brackets(&self.text, &lists);
        lists.map(|list| tree.get(list).map_or(0, |list| list.items.len()))
    }

    /// The text of the group, entry or value at `path`, if it is written.
    #[must_use]
    pub fn written(&self, path: &str) -> Option<&str> {
        let (parent, key) = path.split_at(path.rfind(['.', '[']).unwrap_or(0));
        let tree = brackets(&self.text, &[parent]);
        let parent = tree.get(parent)?;
        let item = match key.strip_prefix('[') {
            Some(index) => parent.items.get(index.strip_suffix(']')?.parse::<usize>().ok()?)?,
            None => parent.key(key.strip_prefix('.').unwrap_or(key))?,
        };
        Some(&self.text[item.value.clone()])
    }
}
