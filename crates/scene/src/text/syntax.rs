//! RON through serde: values, the keys that nothing knows, and syntax errors in words.

use std::marker::PhantomData;

use ron::error::{Error, SpannedError};
use ron::extensions::Extensions;
use serde::Deserialize;
use serde::de::{self, Visitor};
use serde_ignored::Path;

use crate::text::faults::{Faults, SceneError};
use crate::text::locate::{self, Position};
use crate::text::nearest;
use crate::text::tokens::Tokens;

/// Reads a `T` and the paths of all keys that `T` does not know. `root` is what the outermost value is called
/// in paths.
pub(crate) fn read<'de, T: Deserialize<'de>>(
    text: &'de str,
    root: &str,
) -> Result<(T, Vec<String>), SpannedError> {
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    let mut ron = ron::Deserializer::from_str_with_options(text, &options)?;
    let mut unknown = Vec::new();
    let mut note = |path: Path<'_>| unknown.push(written(&path, root));
    // By pointer, so that readers of different types share the code for the values that they have in common.
    let value = serde_ignored::deserialize(&mut ron, &mut note as &mut dyn FnMut(Path<'_>));
    let value =
        value.and_then(|value| ron.end().map(|()| value)).map_err(|error| ron.span_error(error))?;
    Ok((value, unknown))
}

/// The path as messages have it: `bodies[3].mass_kg`.
fn written(path: &Path<'_>, root: &str) -> String {
    match path {
        Path::Root => root.to_owned(),
        Path::Seq { parent, index } => format!("{}[{index}]", written(parent, root)),
        Path::Map { parent, key } => match written(parent, root) {
            parent if parent.is_empty() => key.clone(),
            parent => format!("{parent}.{key}"),
        },
        Path::Some { parent }
        | Path::NewtypeStruct { parent }
        | Path::NewtypeVariant { parent } => written(parent, root),
    }
}

/// The error for a text that is not RON, or that has a value of the wrong type.
pub(crate) fn error(name: &str, text: &str, root: &str, error: &SpannedError) -> SceneError {
    let mut faults = Faults::default();
    fault(&mut faults, text, root, 0..text.len(), error);
    faults.into_error(name, text, root)
}

/// Adds the fault of a piece of the text that was read on its own.
#[expect(clippy::wildcard_enum_match_arm, reason = "errors without a span of their own")]
pub(crate) fn fault(
    faults: &mut Faults,
    text: &str,
    root: &str,
    piece: std::ops::Range<usize>,
    error: &SpannedError,
) {
    // A value that was read and then refused begins at the start of the span; one that could not be read, at its end.
    let refused = matches!(
        error.code,
        Error::NoSuchEnumVariant { .. }
            | Error::DuplicateStructField { .. }
            | Error::ExpectedDifferentStructName { .. }
            | Error::IntegerOutOfBounds
            | Error::InvalidValueForType { .. }
    );
    let at = if refused { error.span.start } else { error.span.end };
    let at = Position { line: at.line, column: at.col };
    let offset = piece.start + locate::offset_of(&text[piece], at);
    let mut offset = offset + leading_blank(&text[offset..]);
    // A sign is read apart from its digits.
    if refused && text[..offset].ends_with(['-', '+']) {
        offset -= 1;
    }
    let code = match &error.code {
        Error::UnclosedBlockComment | Error::ExpectedStringEnd => &error.code,
        // Whatever was expected next, the text has ended, unless it has nothing but blanks and comments.
        _ if offset >= text.trim_end().len() && Tokens::new(text).next().is_some() => &Error::Eof,
        // The parser takes the 1 of 1.5 for a whole number and then misses a comma.
        Error::ExpectedComma if text[offset..].starts_with('.') => &Error::ExpectedInteger,
        code => code,
    };
    let (mut what, cure) = explain(code);
    let mut path = locate::path_at(text, root, offset);
    // What is wrong is the list, not its last item, whose path `path_at` gives.
    if matches!(code, Error::ExpectedDifferentLength { .. } | Error::ExpectedComma)
        && path.ends_with(']')
    {
        path.truncate(path.rfind('[').unwrap_or(path.len()));
    }
    if matches!(code, Error::ExpectedDifferentLength { .. }) && path.ends_with(".between") {
        // The only tuple that is not of numbers.
        what = what.replace("numbers", "names");
    }
    faults.add_at(Some(path), offset, what, cure);
}

/// Length of the white space at the start of `text`, 0 if nothing follows: a span that starts before it means what
/// follows.
fn leading_blank(text: &str) -> usize {
    let blank = text.len() - text.trim_start().len();
    if blank == text.len() { 0 } else { blank }
}

/// Describes what is wrong, and what would be right.
#[expect(clippy::wildcard_enum_match_arm, reason = "the words of `ron`")]
fn explain(error: &Error) -> (String, String) {
    let (what, cure) = match error {
        Error::Eof => ("the text ends too early", "close every `(`, `[` and `\"` that was opened"),
        Error::ExpectedFloat => ("a number is expected here", "write one such as 1.5"),
        Error::ExpectedInteger | Error::InvalidIntegerDigit { .. } => {
            ("a whole number is expected here", "write one such as 3")
        }
        Error::IntegerOutOfBounds => {
            ("this whole number is out of range", "write one from 0 up that fits")
        }
        Error::ExpectedBoolean => ("a truth value is expected here", "write true or false"),
        Error::ExpectedString => ("a text is expected here", "put it in double quotes"),
        Error::ExpectedStringEnd => ("this text does not end", "close it with a double quote"),
        Error::ExpectedIdentifier => ("a bare word is expected here", "write it without quotes"),
        Error::SuggestRawIdentifier(_) => {
            ("a key is expected here", "write an entry as `key: value`")
        }
        Error::ExpectedComma => ("a comma is expected here", "put one between two entries"),
        Error::ExpectedMapColon => ("a colon is expected here", "write an entry as `key: value`"),
        Error::ExpectedStructLike
        | Error::ExpectedNamedStructLike(_)
        | Error::ExpectedDifferentStructName { .. } => {
            ("a group in round brackets is expected here", "open it with `(`")
        }
        Error::ExpectedStructLikeEnd => {
            ("the end of a group is expected here", "close it with `)`")
        }
        Error::ExpectedArray => ("a list is expected here", "open it with `[`"),
        Error::ExpectedArrayEnd => ("the end of a list is expected here", "close it with `]`"),
        Error::UnclosedBlockComment => ("this comment does not end", "close it with `*/`"),
        Error::TrailingCharacters => {
            ("there is more text after the end", "remove it, or look for a `)` too many")
        }
        Error::ExceededRecursionLimit => ("brackets are nested too deeply", "remove some"),
        Error::DuplicateStructField { field, .. } => {
            return (format!("the key `{field}` is given twice"), "keep one of them".to_owned());
        }
        Error::ExpectedDifferentLength { expected, found } => {
            // Serde expects `an array of length 3` or `a tuple of size 2`.
            let wanted = expected.rsplit(' ').next().unwrap_or(expected);
            return (
                format!("{found} of {wanted} numbers are given"),
                format!("give all {wanted}"),
            );
        }
        Error::NoSuchEnumVariant { expected, found, .. } => {
            return (format!("unknown word `{found}`"), nearest::suggest(found, expected));
        }
        Error::Message(what) => return (what.clone(), "correct it here".to_owned()),
        other => return (format!("this is not RON: {other}"), "correct it here".to_owned()),
    };
    (what.to_owned(), cure.to_owned())
}

/// Three numbers in round brackets.
pub(crate) type Triple = [f64; 3];

/// A bare word, such as `fixed`; the resolver checks whether it is known, so that this fault is reported beside all
/// others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Word(pub String);

impl<'de> Deserialize<'de> for Word {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_enum("", &[], WordVisitor)
    }
}

struct WordVisitor;

impl<'de> Visitor<'de> for WordVisitor {
    type Value = Word;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a bare word")
    }

    fn visit_enum<A: de::EnumAccess<'de>>(self, data: A) -> Result<Word, A::Error> {
        let (Name(name), variant) = data.variant()?;
        de::VariantAccess::unit_variant(variant)?;
        Ok(Word(name))
    }
}

/// `word(key: value, ...)` with any word, so that an unknown one is reported beside all other faults.
pub(crate) struct Worded<T> {
    pub word: String,
    pub keys: T,
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Worded<T> {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_enum("", &[], WordedVisitor(PhantomData))
    }
}

struct WordedVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for WordedVisitor<T> {
    type Value = Worded<T>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a word with keys and values")
    }

    fn visit_enum<A: de::EnumAccess<'de>>(self, data: A) -> Result<Worded<T>, A::Error> {
        let (Name(word), variant) = data.variant()?;
        let keys = de::VariantAccess::struct_variant(variant, &[], KeysVisitor(PhantomData))?;
        Ok(Worded { word, keys })
    }
}

struct KeysVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for KeysVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("keys and values")
    }

    fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(de::value::MapAccessDeserializer::new(map))
    }
}

/// The name of a variant or of a key, whatever it is.
pub(crate) struct Name(pub String);

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameVisitor;
        impl Visitor<'_> for NameVisitor {
            type Value = Name;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a bare word")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<Name, E> {
                Ok(Name(name.to_owned()))
            }
        }
        deserializer.deserialize_identifier(NameVisitor)
    }
}

/// The keys or, of an enum, the variants that a derived `T` knows, so that no separate list is needed.
pub(crate) fn keys_of<'de, T: Deserialize<'de>>() -> &'static [&'static str] {
    /// Asks for nothing but the names that serde's derive hands over.
    struct Ask<'a>(&'a mut &'static [&'static str]);

    impl<'de> de::Deserializer<'de> for Ask<'_> {
        type Error = de::value::Error;

        fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
            Err(de::Error::custom("only asked"))
        }

        fn deserialize_struct<V: Visitor<'de>>(
            self,
            _: &'static str,
            fields: &'static [&'static str],
            _: V,
        ) -> Result<V::Value, Self::Error> {
            *self.0 = fields;
            Err(de::Error::custom("only asked"))
        }

        fn deserialize_enum<V: Visitor<'de>>(
            self,
            _: &'static str,
            variants: &'static [&'static str],
            _: V,
        ) -> Result<V::Value, Self::Error> {
            *self.0 = variants;
            Err(de::Error::custom("only asked"))
        }

        serde::forward_to_deserialize_any! {
            bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct
            newtype_struct seq tuple tuple_struct map identifier ignored_any
        }
    }

    let mut keys: &'static [&'static str] = &[];
    // The answer is in `keys`; reading always ends in the error above.
    let _ = T::deserialize(Ask(&mut keys));
    keys
}

/// A variant whose name was read already.
pub(crate) struct Variant<A>(pub String, pub A);

impl<'de, A: de::VariantAccess<'de>> de::EnumAccess<'de> for Variant<A> {
    type Error = A::Error;
    type Variant = A;

    fn variant_seed<V: de::DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, A), A::Error> {
        Ok((seed.deserialize(de::IntoDeserializer::into_deserializer(self.0))?, self.1))
    }
}

/// Reads an enum of enums: in a file, the names of all their variants are of one list.
macro_rules! enum_of_enums {
    ($name:ident: $($variant:ident($inner:ty)),+) => {
        $(impl From<$inner> for $name {
            fn from(inner: $inner) -> Self {
                Self::$variant(inner)
            }
        })+

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                use $crate::text::syntax::{Name, Variant, keys_of};

                static NAMES: std::sync::LazyLock<Vec<&'static str>> =
                    std::sync::LazyLock::new(|| [$(keys_of::<$inner>()),+].concat());

                struct OfName;

                impl<'de> serde::de::Visitor<'de> for OfName {
                    type Value = $name;

                    fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                        out.write_str("a bare word")
                    }

                    fn visit_enum<A: serde::de::EnumAccess<'de>>(
                        self,
                        data: A,
                    ) -> Result<$name, A::Error> {
                        let (Name(name), values) = data.variant()?;
                        $(if keys_of::<$inner>().contains(&&*name) {
                            let variant = Variant(name, values);
                            let inner = serde::de::value::EnumAccessDeserializer::new(variant);
                            return <$inner>::deserialize(inner).map($name::$variant);
                        })+
                        Err(serde::de::Error::unknown_variant(&name, &NAMES))
                    }
                }

                from.deserialize_enum(stringify!($name), &NAMES, OfName)
            }
        }
    };
}
pub(crate) use enum_of_enums;
