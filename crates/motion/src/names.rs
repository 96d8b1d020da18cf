//! Serde helpers that write methods, effects and laws to files by name.

use serde::{Deserialize, Deserializer, Serializer, de, ser};

/// Writes `name`; an error if it is not `known`.
pub(crate) fn write<S: Serializer>(name: &str, known: bool, out: S) -> Result<S::Ok, S::Error> {
    // The name of an embedder's own law could not be read again.
    if known { out.serialize_str(name) } else { Err(ser::Error::custom(unknown(name))) }
}

/// Reads a name; `find` returns what it names.
pub(crate) fn read<'de, D: Deserializer<'de>, T>(
    source: D,
    find: impl FnOnce(&str) -> Option<T>,
) -> Result<T, D::Error> {
    let name = String::deserialize(source)?;
    find(&name).ok_or_else(|| de::Error::custom(unknown(&name)))
}

fn unknown(name: &str) -> String {
    format!("this program knows no `{name}`")
}

/// Implements the traits of serde for an enum with `name` and `from_name`.
macro_rules! written_by_name {
    ($Choice:ty) => {
        impl serde::Serialize for $Choice {
            fn serialize<S: serde::Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
                $crate::names::write(self.name(), true, out)
            }
        }

        impl<'de> serde::Deserialize<'de> for $Choice {
            fn deserialize<D: serde::Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
                $crate::names::read(source, Self::from_name)
            }
        }
    };
}
pub(crate) use written_by_name;

/// A module for `#[serde(with)]` of a name that is one of `$names`.
macro_rules! one_of {
    ($(#[$doc:meta])* $module:ident, $names:expr) => {
        $(#[$doc])*
        pub(crate) mod $module {
            pub(crate) fn serialize<S: serde::Serializer>(
                name: &&'static str,
                out: S,
            ) -> Result<S::Ok, S::Error> {
                $crate::names::write(name, $names.any(|known| known == *name), out)
            }

            pub(crate) fn deserialize<'de, D: serde::Deserializer<'de>>(
                source: D,
            ) -> Result<&'static str, D::Error> {
                $crate::names::read(source, |name| $names.find(|known| *known == name))
            }
        }
    };
}
pub(crate) use one_of;

/// Implements the traits of serde for a struct that is written as the tuple of its fields.
macro_rules! written_as_tuple {
    ($Struct:ident $(<$B:ident>)? { $($field:ident),+ }) => {
        impl $(<$B: serde::Serialize>)? serde::Serialize for $Struct $(<$B>)? {
            fn serialize<S: serde::Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
                let Self { $($field),+ } = self;
                ($($field),+).serialize(out)
            }
        }

        impl<'de $(, $B: serde::Deserialize<'de>)?> serde::Deserialize<'de> for $Struct $(<$B>)? {
            fn deserialize<D: serde::Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
                let ($($field),+) = serde::Deserialize::deserialize(source)?;
                Ok(Self { $($field),+ })
            }
        }
    };
}
pub(crate) use written_as_tuple;
