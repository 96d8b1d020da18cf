//! The keys of a group in a scene's text, with their values, from which a form is made.

use std::fmt;

use glam::DVec3;

use super::bracket::Bracket;
use crate::raw;
use crate::scene::Scene;
use crate::text::kinds::Kind;
use crate::text::locate;

/// A key of a group, and what is written there.
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
    /// The value of that kind that is written so.
    #[must_use]
    pub fn read(kind: Kind, written: &str) -> Self {
        let value = match kind {
            Kind::Flag => ron::from_str(written).ok().map(Self::Flag),
            // Fields hold no larger numbers exactly.
            Kind::Count => ron::from_str(written).ok().filter(|count| *count < 1 << 53).map(Self::Count),
            Kind::Number => {
                ron::from_str(written).ok().filter(|number: &f64| number.is_finite()).map(Self::Number)
            }
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
    let inside = Bracket::at(written, 0)?;
    let number = |item: &super::bracket::Item| ron::from_str::<f64>(&written[item.value.clone()]).ok();
    let numbers: Option<Vec<f64>> = inside.items.iter().map(number).collect();
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
    /// The keys of the group at `path` of the scene's text, as in `bodies[0].shape`; those of the scene itself for an empty
    /// path. Nothing if the group is not written.
    #[must_use]
    pub fn fields(&self, path: &str) -> Vec<Field> {
        let Some(group) = self.bracket(path) else { return Vec::new() };
        let kind = group.word(&self.text);
        let field = |(key, kind)| {
            let written = group.key(key).map(|item| &self.text[item.value.clone()]);
            Field { key, kind, value: written.map(|written| Value::read(kind, written)) }
        };
        raw::kinds_at(path, kind).into_iter().map(field).collect()
    }

    /// How many entries are written in a list of the scene.
    #[must_use]
    pub fn count(&self, list: &str) -> usize {
        self.bracket(list).map_or(0, |list| list.items.len())
    }

    /// The text of the group, entry or value at `path`, if it is written.
    #[must_use]
    pub fn written(&self, path: &str) -> Option<&str> {
        let (group, key) = path.rsplit_once('.').unwrap_or(("", path));
        let item = match key.strip_suffix(']').and_then(|key| key.split_once('[')) {
            Some((list, index)) => {
                let list = if group.is_empty() { list.to_owned() } else { format!("{group}.{list}") };
                self.bracket(&list)?.items.into_iter().nth(index.parse().ok()?)?.value
            }
            None => self.bracket(group)?.key(key)?.value.clone(),
        };
        Some(&self.text[item])
    }

    /// The group or list at `path`.
    pub(super) fn bracket(&self, path: &str) -> Option<Bracket> {
        let written = locate::written(&self.text, "", [path]);
        super::rewrite::value_at(&self.text, *written.get(path)?)
    }
}
