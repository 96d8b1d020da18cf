//! A scene as a person writes it: every key optional, mass in kilograms, angles in degrees.
//!
//! The shape of the file and nothing else; defaults, units and faults are the resolver's.

pub(crate) mod coupled;
pub(crate) mod survival;

use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::{self, DeserializeOwned, MapAccess, VariantAccess, Visitor};

use crate::raw::coupled::{RawEmitter, RawSoftBody, RawSpring};
use crate::raw::survival::{RawMoment, RawSurvival};
use crate::text::syntax::{Name, Word, keys_of};

/// Three numbers in round brackets.
pub(crate) type Triple = [f64; 3];

macro_rules! scene {
    ($($(#[$attribute:meta])* $key:ident: $Value:ty,)*) => {
        #[derive(Debug, Deserialize)]
        #[serde(rename = "Scene")]
        pub(crate) struct RawScene {
            $($(#[$attribute])* pub $key: $Value,)*
        }

        impl RawScene {
            /// The path of a key, if the file gives it a value: for a list, that of the first entry.
            pub fn path(&self, key: &str) -> Option<String> {
                match key {
                    $(stringify!($key) => self.$key.path(key),)*
                    _ => None,
                }
            }
        }

        /// The keys that are known in a section, or in each entry of a list.
        fn keys_in(section: &str) -> &'static [&'static str] {
            match section {
                $(stringify!($key) => <$Value>::keys(),)*
                _ => &[],
            }
        }
    };
}

scene! {
        version: Option<u32>,
        name: Option<String>,
        description: Option<String>,
        step_hz: Option<f64>,
        step: Option<Word>,
        method: Option<Word>,
        substeps: Option<u32>,
        seed: Option<u64>,
        gravity: Option<RawGravity>,
        damping: Option<RawDamping>,
        drag: Option<RawDrag>,
        wind: Option<RawWind>,
        #[serde(default)]
        wells: Vec<RawWell>,
        mutual_gravity: Option<RawMutualGravity>,
        range: Option<RawRange>,
        #[serde(default)]
        thrusts: Vec<RawThrust>,
        push: Option<RawPush>,
        camera: Option<RawCamera>,
        light: Option<RawLight>,
        trails: Option<bool>,
        select_immovable: Option<bool>,
        #[serde(default)]
        bodies: Vec<RawBody>,
        #[serde(default)]
        grids: Vec<RawGrid>,
        #[serde(default)]
        clouds: Vec<RawCloud>,
        #[serde(default)]
        emitters: Vec<RawEmitter>,
        #[serde(default)]
        springs: Vec<RawSpring>,
        #[serde(default)]
        soft_bodies: Vec<RawSoftBody>,
        expect: Option<RawExpect>,
}

/// A value in the file: a section, a list of entries, or a single value.
trait Value {
    /// The keys that are known in it, or in each of its entries.
    fn keys() -> &'static [&'static str];

    /// Its path below `key`, if it is there.
    fn path(&self, key: &str) -> Option<String>;
}

impl<T: DeserializeOwned> Value for Option<T> {
    fn keys() -> &'static [&'static str] {
        keys_of::<T>()
    }

    fn path(&self, key: &str) -> Option<String> {
        self.is_some().then(|| key.to_owned())
    }
}

impl<T: DeserializeOwned> Value for Vec<T> {
    fn keys() -> &'static [&'static str] {
        keys_of::<T>()
    }

    fn path(&self, key: &str) -> Option<String> {
        (!self.is_empty()).then(|| format!("{key}[0]"))
    }
}

/// Enough of a file to tell which version of the format it is written in.
#[derive(Debug, Deserialize)]
#[serde(rename = "Scene")]
pub(crate) struct RawVersion {
    pub version: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Gravity")]
pub(crate) struct RawGravity {
    pub acceleration_m_s2: Option<Triple>,
    pub on_at_start: Option<bool>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Damping")]
pub(crate) struct RawDamping {
    pub model: Option<Word>,
    pub rate_per_s: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Drag")]
pub(crate) struct RawDrag {
    pub linear_per_s: Option<f64>,
    pub quadratic_per_m: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Wind")]
pub(crate) struct RawWind {
    pub velocity_m_s: Option<Triple>,
    pub gust_m_s: Option<f64>,
    pub gust_hz: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Well")]
pub(crate) struct RawWell {
    pub position_m: Option<Triple>,
    pub strength_m3_s2: Option<f64>,
    pub softening_m: Option<f64>,
    pub bodies: Option<Vec<String>>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "MutualGravity")]
pub(crate) struct RawMutualGravity {
    pub constant_m3_kg_s2: Option<f64>,
    pub softening_m: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Range")]
pub(crate) struct RawRange {
    pub position_m: Option<f64>,
    pub speed_m_s: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Thrust")]
pub(crate) struct RawThrust {
    pub body: Option<String>,
    pub curve: Option<RawCurve>,
    pub from_s: Option<f64>,
    pub until_s: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Push")]
pub(crate) struct RawPush {
    pub start_n: Option<f64>,
    pub newtons_per_notch: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Camera")]
pub(crate) struct RawCamera {
    pub position_m: Option<Triple>,
    pub pitch_deg: Option<f64>,
    pub yaw_deg: Option<f64>,
    pub fov_y_deg: Option<f64>,
    pub near_m: Option<f64>,
    pub far_m: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Light")]
pub(crate) struct RawLight {
    pub position_m: Option<Triple>,
    pub color: Option<Triple>,
    pub shadows: Option<bool>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Body")]
pub(crate) struct RawBody {
    pub name: Option<String>,
    pub shape: Option<RawShape>,
    pub position_m: Option<Triple>,
    pub rotation_deg: Option<Triple>,
    pub velocity_m_s: Option<Triple>,
    pub verlet_previous_position_m: Option<Triple>,
    pub mass_kg: Option<f64>,
    pub immovable: Option<bool>,
    pub scenery: Option<bool>,
    pub texture: Option<Word>,
    pub color: Option<Triple>,
    pub label: Option<String>,
    pub method: Option<Word>,
    pub substeps: Option<u32>,
    pub damping_per_s: Option<f64>,
    pub max_speed_m_s: Option<f64>,
    pub locked_axes: Option<Vec<Word>>,
    pub gravity_off: Option<bool>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Grid")]
pub(crate) struct RawGrid {
    pub name: Option<String>,
    pub kind: Option<Word>,
    pub rows: Option<u32>,
    pub columns: Option<u32>,
    pub spacing_m: Option<[f64; 2]>,
    pub origin_m: Option<Triple>,
    pub mass_kg: Option<f64>,
    pub color: Option<Triple>,
    pub method: Option<Word>,
    pub substeps: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Cloud")]
pub(crate) struct RawCloud {
    pub name: Option<String>,
    pub count: Option<u32>,
    pub center_m: Option<Triple>,
    pub half_extents_m: Option<Triple>,
    pub speed_m_s: Option<f64>,
    pub mass_kg: Option<f64>,
    pub color: Option<Triple>,
    pub method: Option<Word>,
    pub substeps: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename = "Expect")]
pub(crate) struct RawExpect {
    pub energy_drift_below: Option<f64>,
    pub finite: Option<bool>,
    pub survival: Option<RawSurvival>,
}

/// `word(key: value, ...)` with any word, so that an unknown shape is reported beside all other faults.
#[derive(Debug)]
pub(crate) struct RawShape {
    pub word: String,
    pub sizes: RawSizes,
}

/// The keys of all shapes together; which belong to which is for the resolver to say.
#[derive(Debug, Deserialize)]
pub(crate) struct RawSizes {
    pub half_extents_m: Option<Triple>,
    pub radius_m: Option<f64>,
}

impl<'de> Deserialize<'de> for RawShape {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ShapeVisitor;
        impl<'de> Visitor<'de> for ShapeVisitor {
            type Value = RawShape;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a shape")
            }

            fn visit_enum<A: de::EnumAccess<'de>>(self, data: A) -> Result<RawShape, A::Error> {
                let (Name(word), variant) = data.variant()?;
                let sizes = variant.struct_variant(&[], KeysVisitor::new())?;
                Ok(RawShape { word, sizes })
            }
        }
        deserializer.deserialize_enum("", &[], ShapeVisitor)
    }
}

/// A force over time, as `word(...)`.
#[derive(Debug)]
pub(crate) enum RawCurve {
    /// `polynomial([(x, y, z), ...])`.
    Polynomial(Vec<Triple>),
    /// `sine(amplitude_n: (x, y, z), ...)`.
    Sine(RawSine),
    /// `table([(t, (x, y, z)), ...])`.
    Table(Vec<(f64, Triple)>),
}

#[derive(Debug, Deserialize)]
pub(crate) struct RawSine {
    pub amplitude_n: Option<Triple>,
    pub angular_frequency_rad_s: Option<f64>,
    pub phase_rad: Option<f64>,
}

impl<'de> Deserialize<'de> for RawCurve {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct CurveVisitor;
        impl<'de> Visitor<'de> for CurveVisitor {
            type Value = RawCurve;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a curve")
            }

            fn visit_enum<A: de::EnumAccess<'de>>(self, data: A) -> Result<RawCurve, A::Error> {
                let (Name(word), variant) = data.variant()?;
                match word.as_str() {
                    "polynomial" => variant.newtype_variant().map(RawCurve::Polynomial),
                    "sine" => variant.struct_variant(&[], KeysVisitor::new()).map(RawCurve::Sine),
                    "table" => variant.newtype_variant().map(RawCurve::Table),
                    // What stands behind an unknown word cannot be read past, so this fault comes alone.
                    _ => Err(de::Error::unknown_variant(&word, &["polynomial", "sine", "table"])),
                }
            }
        }
        deserializer.deserialize_enum("", &[], CurveVisitor)
    }
}

/// Reads `(key: value, ...)` behind a word.
pub(crate) struct KeysVisitor<T>(PhantomData<T>);

impl<T> KeysVisitor<T> {
    pub const fn new() -> Self {
        Self(PhantomData)
    }
}

impl<'de, T: Deserialize<'de>> Visitor<'de> for KeysVisitor<T> {
    type Value = T;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("keys and values")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::deserialize(de::value::MapAccessDeserializer::new(map))
    }
}

/// The keys that are known at the path of a group, if the path leads to one. Those of a soft body are those of its
/// kind, which stands in `raw`.
pub(crate) fn keys_at(raw: &RawScene, path: &str) -> Option<Vec<&'static str>> {
    let item = path.split_once('[').and_then(|(list, rest)| {
        let (index, key) = rest.split_once(']')?;
        Some((list, index.parse().ok(), key))
    });
    let (list, index, key) = item.unwrap_or((path, None::<usize>, ""));
    let keys = match (list, key) {
        ("", "") => keys_of::<RawScene>(),
        ("thrusts", ".curve") => keys_of::<RawSine>(),
        ("expect.survival" | "expect.survival.rows", "") => keys_of::<RawSurvival>(),
        ("expect.survival.script", "") => keys_of::<RawMoment>(),
        ("bodies", ".shape") => keys_of::<RawSizes>(),
        ("soft_bodies", "") => return Some(raw.soft_bodies.get(index?)?.known_keys()),
        (section, "") => keys_in(section),
        _ => &[],
    };
    (!keys.is_empty()).then(|| keys.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_known_keys_are_those_of_the_structs() {
        let (raw, _) =
            crate::text::syntax::read::<RawScene>("(soft_bodies: [chain(points: 2), cloth()])", "").unwrap();
        let keys = |path| keys_at(&raw, path);
        assert_eq!(keys("damping"), Some(vec!["model", "rate_per_s"]));
        assert_eq!(keys("bodies[12].shape"), Some(vec!["half_extents_m", "radius_m"]));
        assert_eq!(keys("clouds[0]").map(|keys| keys.len()), Some(9));
        assert_eq!(keys("nothing"), None);
        let of_chain = keys("soft_bodies[0]").unwrap();
        assert!(of_chain.contains(&"points") && of_chain.contains(&"mass_kg") && !of_chain.contains(&"rows"));
        assert!(keys("soft_bodies[1]").unwrap().contains(&"shear") && keys("soft_bodies[2]").is_none());
    }
}
