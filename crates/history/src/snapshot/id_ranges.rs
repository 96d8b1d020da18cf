//! Lists of stable ids as ranges of consecutive ones.

use serde::{Deserialize, Serialize};

use scene::lists::{list, list_bytes};

/// Stable ids in their order, as ranges: the first id of each, and its length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct IdRanges(#[serde(deserialize_with = "list")] pub Vec<[u32; 2]>);

impl IdRanges {
    /// The ranges of `ids`.
    pub fn of(ids: impl IntoIterator<Item = u32>) -> Self {
        let mut ranges: Vec<[u32; 2]> = Vec::new();
        for id in ids {
            match ranges.last_mut() {
                Some([first, count]) if first.checked_add(*count) == Some(id) => *count += 1,
                _ => ranges.push([id, 1]),
            }
        }
        Self(ranges)
    }

    /// The ids.
    pub fn ids(&self) -> impl Iterator<Item = u32> + '_ {
        self.0.iter().flat_map(|[first, count]| *first..first.saturating_add(*count))
    }

    /// The ids, if there are at most `count`, each is below it, and no range is empty.
    pub fn below(&self, count: usize) -> Option<Vec<u32>> {
        let mut all = Vec::new();
        for [first, length] in &self.0 {
            let end = first.checked_add(*length).filter(|end| *end as usize <= count)?;
            if *length == 0 || all.len() + *length as usize > count {
                return None;
            }
            all.extend(*first..end);
        }
        Some(all)
    }

    /// Bytes of the list as it is allocated.
    pub const fn bytes(&self) -> usize {
        list_bytes(&self.0)
    }
}
