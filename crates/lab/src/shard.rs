//! The parts that a study is divided into for several machines.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Most parts of a study.
const MOST: u32 = 1_000_000;

/// One of the parts of a study. It has the pieces of work whose index, from 0, is `number - 1` modulo `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Shard {
    number: u32,
    of: u32,
}

impl Shard {
    /// The whole study.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Which part it is, from 1.
    #[must_use]
    pub const fn number(self) -> u32 {
        self.number
    }

    /// How many parts there are.
    #[must_use]
    pub const fn of(self) -> u32 {
        self.of
    }

    /// Whether piece of work `index` is in it.
    #[must_use]
    pub const fn has(self, index: u64) -> bool {
        index % self.of as u64 == self.number as u64 - 1
    }

    /// How many of `all` pieces of work are in it.
    #[must_use]
    pub const fn count(self, all: u64) -> u64 {
        let of = self.of as u64;
        all / of + (all % of >= self.number as u64) as u64
    }

    /// The index, in the whole study, of the `place`-th piece of this part, from 0.
    #[must_use]
    pub const fn nth(self, place: u64) -> u64 {
        place * self.of as u64 + self.number as u64 - 1
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text
            .split_once('/')
            .and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        match parts {
            Some((number, of)) if 0 < number && number <= of && of <= MOST => {
                Ok(Self { number, of })
            }
            _ => Err(format!(
                "give which part of how many, as in 2/3, from 1/N to N/N, with N up to {MOST}"
            )),
        }
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_of_work_is_in_one_part() {
        for (of, all) in [(1, 5), (3, 7), (7, 7), (7, 3), (4, 0)] {
            let shards: Vec<Shard> =
                (1..=of).map(|number| format!("{number}/{of}").parse().unwrap()).collect();
            let mut found: Vec<u64> = shards
                .iter()
                .flat_map(|shard| (0..shard.count(all)).map(|place| shard.nth(place)))
                .collect();
            found.sort_unstable();
            assert_eq!(found, (0..all).collect::<Vec<_>>(), "{of} parts of {all}");
            assert!(
                (0..all).all(|index| shards.iter().filter(|shard| shard.has(index)).count() == 1)
            );
        }
    }

    #[test]
    fn a_part_that_is_none_is_refused() {
        for text in ["1/1000001", "0/3", "4/3", "1/0", "1", "a/b", "-1/2", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
