//! Emitters, springs and soft bodies as a person writes them.

use serde::Deserialize;
use serde::de::{self, VariantAccess, Visitor};

use crate::raw::{KeysVisitor, Triple};
use crate::text::syntax::{Name, Word, keys_of};

#[derive(Debug, Deserialize)]
#[serde(rename = "Emitter")]
pub(crate) struct RawEmitter {
    pub name: Option<String>,
    pub rate_per_s: Option<f64>,
    pub position_m: Option<Triple>,
    pub direction: Option<Triple>,
    pub spread_deg: Option<f64>,
    pub speed_m_s: Option<f64>,
    pub life_s: Option<f64>,
    pub capacity: Option<u32>,
    pub mass_kg: Option<f64>,
    pub color: Option<Triple>,
    pub method: Option<Word>,
    pub substeps: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Spring")]
pub(crate) struct RawSpring {
    pub between: Option<[String; 2]>,
    pub stiffness_n_m: Option<f64>,
    pub damping_n_s_m: Option<f64>,
    pub rest_length_m: Option<f64>,
    pub color: Option<Triple>,
}

/// `word(key: value, ...)` with any word, so that an unknown kind is reported beside all other faults.
#[derive(Debug)]
pub(crate) struct RawSoftBody {
    pub word: String,
    pub keys: RawSoftKeys,
}

/// The keys of all kinds of soft bodies together; which belong to which is in [`KINDS`].
#[derive(Debug, Deserialize)]
pub(crate) struct RawSoftKeys {
    pub name: Option<String>,
    pub points: Option<u32>,
    pub from_m: Option<Triple>,
    pub to_m: Option<Triple>,
    pub rows: Option<u32>,
    pub columns: Option<u32>,
    pub corner_m: Option<Triple>,
    pub along_m: Option<Triple>,
    pub down_m: Option<Triple>,
    pub shear: Option<bool>,
    pub bend: Option<bool>,
    pub cells: Option<[u32; 3]>,
    pub center_m: Option<Triple>,
    pub size_m: Option<Triple>,
    pub mass_kg: Option<f64>,
    pub stiffness_n_m: Option<f64>,
    pub damping_n_s_m: Option<f64>,
    pub pinned: Option<Vec<Word>>,
    pub velocity_m_s: Option<Triple>,
    pub color: Option<Triple>,
    pub method: Option<Word>,
    pub substeps: Option<u32>,
    pub damping_per_s: Option<f64>,
    pub gravity_off: Option<bool>,
}

/// The kinds of soft bodies, each with the keys that no other kind has.
pub(crate) const KINDS: [(&str, &[&str]); 3] = [
    ("chain", &["points", "from_m", "to_m"]),
    ("cloth", &["rows", "columns", "corner_m", "along_m", "down_m", "shear", "bend"]),
    ("lattice", &["cells", "center_m", "size_m"]),
];

impl RawSoftBody {
    /// The kind that alone has `key`, if it is not every kind's.
    fn owner(key: &str) -> Option<&'static str> {
        KINDS.iter().find(|(_, own)| own.contains(&key)).map(|(kind, _)| *kind)
    }

    /// Whether `key` is one of this kind; a kind that nobody knows has every key.
    fn has(&self, key: &str) -> bool {
        let known = KINDS.iter().any(|(kind, _)| *kind == self.word);
        !known || Self::owner(key).is_none_or(|kind| kind == self.word)
    }

    /// The keys of this kind.
    pub fn known_keys(&self) -> Vec<&'static str> {
        keys_of::<RawSoftKeys>().iter().copied().filter(|key| self.has(key)).collect()
    }

    /// The keys that are given and are another kind's.
    pub fn strange_keys(&self) -> impl Iterator<Item = &'static str> {
        let keys = &self.keys;
        let given = [
            ("points", keys.points.is_some()),
            ("from_m", keys.from_m.is_some()),
            ("to_m", keys.to_m.is_some()),
            ("rows", keys.rows.is_some()),
            ("columns", keys.columns.is_some()),
            ("corner_m", keys.corner_m.is_some()),
            ("along_m", keys.along_m.is_some()),
            ("down_m", keys.down_m.is_some()),
            ("shear", keys.shear.is_some()),
            ("bend", keys.bend.is_some()),
            ("cells", keys.cells.is_some()),
            ("center_m", keys.center_m.is_some()),
            ("size_m", keys.size_m.is_some()),
        ];
        given.into_iter().filter(|(key, given)| *given && !self.has(key)).map(|(key, _)| key)
    }
}

impl<'de> Deserialize<'de> for RawSoftBody {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct SoftBodyVisitor;
        impl<'de> Visitor<'de> for SoftBodyVisitor {
            type Value = RawSoftBody;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a soft body")
            }

            fn visit_enum<A: de::EnumAccess<'de>>(self, data: A) -> Result<RawSoftBody, A::Error> {
                let (Name(word), variant) = data.variant()?;
                let keys = variant.struct_variant(&[], KeysVisitor::new())?;
                Ok(RawSoftBody { word, keys })
            }
        }
        deserializer.deserialize_enum("", &[], SoftBodyVisitor)
    }
}
