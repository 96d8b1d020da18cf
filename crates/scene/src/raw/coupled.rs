//! Emitters, springs and soft bodies as a person writes them.

use std::collections::BTreeSet;

use serde::Deserialize;

use crate::lists::List;
use crate::substepping::Substepping;
use crate::text::kinds::{Kind, kinds_of};
use crate::text::syntax::{Triple, Word, Worded};

#[derive(Deserialize)]
pub(crate) struct Emitter {
    pub name: Option<String>,
    pub rate_per_s: Option<f64>,
    pub rides_on: Option<String>,
    pub position_m: Option<Triple>,
    pub direction: Option<Triple>,
    pub spread_deg: Option<f64>,
    pub speed_m_s: Option<f64>,
    pub life_s: Option<f64>,
    pub capacity: Option<u32>,
    pub on: Option<Word>,
    pub layout: Option<Word>,
    pub radius_m: Option<f64>,
    pub mass_kg: Option<f64>,
    pub color: Option<Triple>,
    pub method: Option<Word>,
    pub substeps: Option<u32>,
}

#[derive(Deserialize)]
pub(crate) struct Spring {
    pub between: Option<[String; 2]>,
    pub stiffness_n_m: Option<f64>,
    pub damping_n_s_m: Option<f64>,
    pub rest_length_m: Option<f64>,
    pub pull_only: Option<bool>,
    pub color: Option<Triple>,
}

/// Any word and the keys of all kinds.
pub(crate) type SoftBody = Worded<SoftKeys>;

/// The keys of all kinds of soft bodies together; [`KINDS`] says which belong to which kind.
#[derive(Deserialize)]
pub(crate) struct SoftKeys {
    pub name: Option<String>,
    pub points: Option<u32>,
    pub from_m: Option<Triple>,
    pub to_m: Option<Triple>,
    pub copies: Option<u32>,
    pub over_m: Option<Triple>,
    pub width_m: Option<f64>,
    pub rows: Option<u32>,
    pub columns: Option<u32>,
    pub corner_m: Option<Triple>,
    pub along_m: Option<Triple>,
    pub down_m: Option<Triple>,
    pub shear: Option<bool>,
    pub shear_n_m: Option<f64>,
    pub bend: Option<bool>,
    pub bend_n_m: Option<f64>,
    pub cells: Option<[u32; 3]>,
    pub center_m: Option<Triple>,
    pub size_m: Option<Triple>,
    pub mass_kg: Option<f64>,
    pub stiffness_n_m: Option<f64>,
    pub stiffness_of_whole_n_m: Option<f64>,
    pub damping_n_s_m: Option<f64>,
    pub pull_only: Option<bool>,
    pub pinned: Option<List<Word>>,
    pub velocity_m_s: Option<Triple>,
    pub color: Option<Triple>,
    pub method: Option<Word>,
    pub substeps: Option<Substepping>,
    pub damping_per_s: Option<f64>,
    pub gravity_off: Option<bool>,
}

macro_rules! kinds {
    ($($kind:ident: $($key:ident),+;)+) => {
        /// The kinds of soft bodies, each with the keys that not all kinds have.
        pub(crate) const KINDS: [(&str, &[&str]); 3] = [$((stringify!($kind), &[$(stringify!($key)),+])),+];

        impl SoftKeys {
            /// The keys of single kinds, and whether they are given.
            fn of_kinds(&self) -> impl Iterator<Item = (&'static str, bool)> {
                [$($((stringify!($key), self.$key.is_some())),+),+].into_iter()
            }
        }
    };
}

kinds! {
    chain: points, from_m, to_m, copies, over_m, width_m, stiffness_of_whole_n_m, pull_only, bend, bend_n_m;
    cloth: rows, columns, corner_m, along_m, down_m, shear, shear_n_m, bend, bend_n_m;
    lattice: cells, center_m, size_m;
}

impl SoftBody {
    /// The keys that are given but belong to another kind.
    pub fn keys_of_other_kinds(&self) -> impl Iterator<Item = &'static str> {
        let given = self.keys.of_kinds().filter(|(key, given)| *given && !has(&self.word, key));
        // A key of several kinds is listed at each.
        given.map(|(key, _)| key).collect::<BTreeSet<_>>().into_iter()
    }
}

/// Whether soft bodies of that kind have `key`; an unknown kind has every key.
fn has(kind: &str, key: &str) -> bool {
    let own = KINDS.iter().find(|(other, _)| *other == kind);
    own.is_none_or(|(_, own)| own.contains(&key))
        || !KINDS.iter().any(|(_, own)| own.contains(&key))
}

/// The keys of a kind of soft bodies, and what they take.
pub(super) fn kinds_of_soft(kind: &str) -> Vec<(&'static str, Kind)> {
    kinds_of::<SoftKeys>().into_iter().filter(|(key, _)| has(kind, key)).collect()
}
