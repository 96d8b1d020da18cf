//! Finds what kind of value each key of a derived type takes by querying the type, so that no separate list is
//! needed.

use serde::Deserialize;
use serde::de::{self, DeserializeSeed, Deserializer, Error as _, Visitor};

/// A kind of value in a scene file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `true` or `false`.
    Flag,
    /// A whole number from 0 up.
    Count,
    /// A number.
    Number,
    /// A tuple of that many numbers, in round brackets.
    Numbers(usize),
    /// A text in double quotes.
    Text,
    /// A bare word such as `fixed`, with keys and values or without.
    Word,
    /// A group `(key: value, ...)`.
    Group,
    /// A list `[value, ...]`, or any other kind.
    Other,
}

type Fault = de::value::Error;

/// The keys that a derived `T` knows, in its order, with the kinds of their values.
pub(crate) fn kinds_of<'de, T: Deserialize<'de>>() -> Vec<(&'static str, Kind)> {
    let kind = |key| {
        let mut kind = Kind::Other;
        // The answer is in `kind`; reading always ends in an error.
        let _ =
            T::deserialize(de::value::MapAccessDeserializer::new(OneKey { key, kind: &mut kind }));
        (key, kind)
    };
    super::syntax::keys_of::<T>().iter().copied().map(kind).collect()
}

/// A map of one key that records which kind of value is requested for it.
struct OneKey<'a> {
    key: &'static str,
    kind: &'a mut Kind,
}

impl<'de> de::MapAccess<'de> for OneKey<'_> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Fault> {
        seed.deserialize(de::value::StrDeserializer::new(self.key)).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        seed.deserialize(Asked(self.kind))
    }
}

/// Records which kind of value is requested; never gives a value.
struct Asked<'a>(&'a mut Kind);

macro_rules! notes {
    ($($asked:ident: $kind:ident;)*) => {
        $(fn $asked<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Fault> {
            *self.0 = Kind::$kind;
            Err(Fault::custom("only asked"))
        })*
    };
}

macro_rules! notes_named {
    ($($asked:ident: $kind:ident;)*) => {
        $(fn $asked<V: Visitor<'de>>(
            self,
            _: &'static str,
            _: &'static [&'static str],
            _: V,
        ) -> Result<V::Value, Fault> {
            *self.0 = Kind::$kind;
            Err(Fault::custom("only asked"))
        })*
    };
}

impl<'de> Deserializer<'de> for Asked<'_> {
    type Error = Fault;

    notes! {
        deserialize_any: Other;
        deserialize_bool: Flag;
        deserialize_u32: Count;
        deserialize_u64: Count;
        deserialize_f64: Number;
        deserialize_string: Text;
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let mut of_one = Kind::Other;
        let _ = visitor.visit_seq(Alike(&mut of_one));
        *self.0 = if of_one == Kind::Number { Kind::Numbers(length) } else { Kind::Other };
        Err(Fault::custom("only asked"))
    }

    notes_named! {
        deserialize_struct: Group;
        deserialize_enum: Word;
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 f32 char str bytes byte_buf unit unit_struct newtype_struct seq tuple_struct map
        identifier ignored_any
    }
}

/// A sequence that records the kind of its first value.
struct Alike<'a>(&'a mut Kind);

impl<'de> de::SeqAccess<'de> for Alike<'_> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Fault> {
        seed.deserialize(Asked(self.0)).map(Some)
    }
}
