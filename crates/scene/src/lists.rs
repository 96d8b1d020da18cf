//! Lists of scene files, read into no more memory than is allowed.

use std::ops::Deref;

use serde::de::{Deserialize, Deserializer};

pub use motion::lists::{counted_within, list, list_bytes, within};

/// A list of a file, read as by [`list`].
#[derive(Debug)]
pub(crate) struct List<T>(Vec<T>);

impl<T> Default for List<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Deref for List<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for List<T> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        list(source).map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(serde::Deserialize)]
    struct Nested(#[serde(deserialize_with = "list")] Vec<u64>);

    #[test]
    fn entries_count_by_their_size_in_memory_those_of_nested_lists_too() {
        let text = "[([1, 2]), ([]), ([3])]";
        let read = |bytes| {
            within(bytes, || list::<_, Nested>(&mut ron::Deserializer::from_str(text).unwrap()))
                .map(|lists| lists.into_iter().map(|Nested(list)| list).collect::<Vec<_>>())
        };
        let bytes = 3 * size_of::<Nested>() + 3 * size_of::<u64>();
        assert_eq!(read(bytes).unwrap(), [vec![1, 2], vec![], vec![3]]);
        assert!(read(bytes - 1).unwrap_err().to_string().starts_with("it takes too much memory"));
        assert!(read(usize::MAX).is_ok());
    }
}
