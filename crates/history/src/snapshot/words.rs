//! Methods, effects and other choices as words in files: for `#[serde(with = "words")]`.

use motion::effects::Effect;
use motion::{Cause, DampingModel, LAWS, Method};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser};

/// A choice that has a word.
pub trait Worded: Copy {
    /// Its word.
    fn word(self) -> &'static str;
    /// The choice of that word.
    fn of_word(word: &str) -> Option<Self>;
}

/// A choice that is written as its word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(bound = "T: Worded", transparent)]
pub(crate) struct Name<T>(#[serde(serialize_with = "serialize", deserialize_with = "deserialize")] pub T);

/// Writes a choice as its word.
///
/// # Errors
///
/// If it could not be read again.
pub fn serialize<T: Worded, S: Serializer>(choice: &T, serializer: S) -> Result<S::Ok, S::Error> {
    let word = choice.word();
    // The name of an embedder's own law could not be read again.
    T::of_word(word).ok_or_else(|| ser::Error::custom(unknown(word)))?;
    serializer.serialize_str(word)
}

/// Reads a choice from its word.
///
/// # Errors
///
/// If no choice has that word.
pub fn deserialize<'de, T: Worded, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    let word = String::deserialize(deserializer)?;
    T::of_word(&word).ok_or_else(|| de::Error::custom(unknown(&word)))
}

/// A choice that may be absent, as its word.
pub(crate) mod optional {
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    use super::{Name, Worded};

    pub(crate) fn serialize<T: Worded, S: Serializer>(
        choice: &Option<T>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        choice.map(Name).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, T: Worded, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<T>, D::Error> {
        Ok(Option::<Name<T>>::deserialize(deserializer)?.map(|Name(choice)| choice))
    }
}

fn unknown(word: &str) -> String {
    format!("this program knows no `{word}`")
}

impl Worded for Method {
    fn word(self) -> &'static str {
        self.name()
    }

    fn of_word(word: &str) -> Option<Self> {
        Self::from_name(word)
    }
}

impl Worded for Effect {
    fn word(self) -> &'static str {
        self.name()
    }

    fn of_word(word: &str) -> Option<Self> {
        Self::from_name(word)
    }
}

impl Worded for DampingModel {
    fn word(self) -> &'static str {
        self.name()
    }

    fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == word)
    }
}

/// A law, a system or a component of this program.
impl Worded for &'static str {
    fn word(self) -> &'static str {
        self
    }

    fn of_word(word: &str) -> Option<Self> {
        LAWS.iter().map(|(name, _)| *name).chain(Cause::names()).find(|name| *name == word)
    }
}
