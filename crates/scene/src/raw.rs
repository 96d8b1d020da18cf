//! A scene as a person writes it: every key optional, mass in kilograms, angles in degrees.
//!
//! This is only the shape of the file; the resolver handles defaults, units and faults.

mod coupled;
mod survival;

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::lists::List;
use crate::substepping::Substepping;
use crate::text::kinds::{Kind, kinds_of};
use crate::text::syntax::{Triple, Word, Worded};
pub(crate) use coupled::{Emitter, KINDS, SoftBody, SoftKeys, Spring};
pub(crate) use survival::{Step, Steps, Survival};

macro_rules! scene {
    ($($key:ident: $Value:ty,)*) => {
        #[derive(Default, Deserialize)]
        #[serde(default)]
        pub(crate) struct Scene {
            $(pub $key: $Value,)*
        }

        impl Scene {
            /// The path of a key, if the file gives it a value: for a list, that of the first entry.
            pub fn path(&self, key: &str) -> Option<String> {
                match key {
                    $(stringify!($key) => self.$key.path(key),)*
                    _ => None,
                }
            }
        }

        /// The keys that are known in a section, or in each entry of a list.
        fn kinds_in(section: &str) -> Vec<(&'static str, Kind)> {
            match section {
                $(stringify!($key) => <$Value>::kinds(),)*
                _ => Vec::new(),
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
    pace: Option<f64>,
    method: Option<Word>,
    substeps: Option<Substepping>,
    seed: Option<u64>,
    gravity: Option<Gravity>,
    damping: Option<Damping>,
    drag: Option<Drag>,
    wind: Option<Wind>,
    wells: List<Well>,
    mutual_gravity: Option<MutualGravity>,
    range: Option<Range>,
    thrusts: List<Drive>,
    moves: List<Drive>,
    push: Option<Push>,
    camera: Option<Camera>,
    light: Option<Light>,
    trails: Option<bool>,
    select_immovable: Option<bool>,
    off_at_start: Option<List<Word>>,
    bodies: List<Body>,
    grids: List<Grid>,
    clouds: List<Cloud>,
    rings: List<Ring>,
    emitters: List<Emitter>,
    springs: List<Spring>,
    soft_bodies: List<SoftBody>,
    expect: Option<Expect>,
}

/// A value in the file: a section, a list of entries, or a single value.
trait Value {
    /// The keys that are known in it, or in each of its entries, and what they take.
    fn kinds() -> Vec<(&'static str, Kind)>;

    /// Its path below `key`, if it is given.
    fn path(&self, key: &str) -> Option<String>;
}

impl<T: DeserializeOwned> Value for Option<T> {
    fn kinds() -> Vec<(&'static str, Kind)> {
        kinds_of::<T>()
    }

    fn path(&self, key: &str) -> Option<String> {
        self.is_some().then(|| key.to_owned())
    }
}

impl<T: DeserializeOwned> Value for List<T> {
    fn kinds() -> Vec<(&'static str, Kind)> {
        kinds_of::<T>()
    }

    fn path(&self, key: &str) -> Option<String> {
        (!self.is_empty()).then(|| format!("{key}[0]"))
    }
}

/// Enough of a file to tell which version of the format it is written in.
#[derive(Deserialize)]
#[serde(rename = "Scene")]
pub(crate) struct Version {
    pub version: Option<u32>,
}

#[derive(Deserialize)]
pub(crate) struct Gravity {
    pub acceleration_m_s2: Option<Triple>,
    pub on_at_start: Option<bool>,
}

#[derive(Deserialize)]
pub(crate) struct Damping {
    pub model: Option<Word>,
    pub rate_per_s: Option<f64>,
    pub share_kept_per_s: Option<f64>,
}

#[derive(Deserialize)]
pub(crate) struct Drag {
    pub linear_per_s: Option<f64>,
    pub quadratic_per_m: Option<f64>,
}

#[derive(Deserialize)]
pub(crate) struct Wind {
    pub velocity_m_s: Option<Triple>,
    pub gust_m_s: Option<f64>,
    pub gust_hz: Option<f64>,
}

#[derive(Deserialize)]
pub(crate) struct Well {
    pub rides_on: Option<String>,
    pub position_m: Option<Triple>,
    pub strength_m3_s2: Option<f64>,
    pub softening_m: Option<f64>,
    pub bodies: Option<List<String>>,
}

#[derive(Deserialize)]
pub(crate) struct MutualGravity {
    pub constant_m3_kg_s2: Option<f64>,
    pub softening_m: Option<f64>,
}

#[derive(Deserialize)]
pub(crate) struct Range {
    pub position_m: Option<f64>,
    pub speed_m_s: Option<f64>,
}

/// A body and the curve of its thrust or of its motion.
#[derive(Deserialize)]
pub(crate) struct Drive {
    pub body: Option<String>,
    pub curve: Option<Curve>,
    pub from_s: Option<f64>,
    pub until_s: Option<f64>,
}

#[derive(Deserialize)]
pub(crate) struct Push {
    pub start_n: Option<f64>,
    pub newtons_per_notch: Option<f64>,
    pub radius_m: Option<f64>,
}

#[derive(Deserialize)]
pub(crate) struct Camera {
    pub position_m: Option<Triple>,
    pub pitch_deg: Option<f64>,
    pub yaw_deg: Option<f64>,
    pub fov_y_deg: Option<f64>,
    pub near_m: Option<f64>,
    pub far_m: Option<f64>,
}

#[derive(Deserialize)]
pub(crate) struct Light {
    pub position_m: Option<Triple>,
    pub color: Option<Triple>,
    pub shadows: Option<bool>,
}

#[derive(Deserialize)]
pub(crate) struct Body {
    pub name: Option<String>,
    pub shape: Option<Shape>,
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
    pub substeps: Option<Substepping>,
    pub damping_per_s: Option<f64>,
    pub linear_drag_kg_s: Option<f64>,
    pub quadratic_drag_kg_m: Option<f64>,
    pub drag_area_m2: Option<f64>,
    pub max_speed_m_s: Option<f64>,
    pub locked_axes: Option<List<Word>>,
    pub gravity_off: Option<bool>,
}

impl Body {
    /// The keys of its own drag, and their values.
    pub const fn drags(&self) -> [(&'static str, Option<f64>); 3] {
        [
            ("linear_drag_kg_s", self.linear_drag_kg_s),
            ("quadratic_drag_kg_m", self.quadratic_drag_kg_m),
            ("drag_area_m2", self.drag_area_m2),
        ]
    }

    /// The first key of its own drag, if it has some.
    pub fn drag_key(&self) -> Option<&'static str> {
        self.drags().into_iter().find_map(|(key, value)| value.map(|_| key))
    }
}

#[derive(Deserialize)]
pub(crate) struct Grid {
    pub name: Option<String>,
    pub kind: Option<Word>,
    pub rows: Option<u32>,
    pub columns: Option<u32>,
    pub spacing_m: Option<[f64; 2]>,
    pub origin_m: Option<Triple>,
    pub mass_kg: Option<f64>,
    pub color: Option<Triple>,
    pub method: Option<Word>,
    pub substeps: Option<Substepping>,
}

#[derive(Deserialize)]
pub(crate) struct Cloud {
    pub name: Option<String>,
    pub count: Option<u32>,
    pub center_m: Option<Triple>,
    pub half_extents_m: Option<Triple>,
    pub radius_m: Option<f64>,
    pub speed_m_s: Option<f64>,
    pub mass_kg: Option<f64>,
    pub color: Option<Triple>,
    pub method: Option<Word>,
    pub substeps: Option<Substepping>,
}

#[derive(Deserialize)]
pub(crate) struct Ring {
    pub name: Option<String>,
    pub count: Option<u32>,
    pub center_m: Option<Triple>,
    pub radius_m: Option<f64>,
    pub axis: Option<Triple>,
    pub speed_m_s: Option<f64>,
    pub mass_kg: Option<f64>,
    pub color: Option<Triple>,
    pub method: Option<Word>,
    pub substeps: Option<Substepping>,
}

/// The keys that are common to all entries that make many bodies.
pub(crate) struct SharedKeys<'a> {
    pub mass_kg: Option<f64>,
    pub color: Option<Triple>,
    pub method: Option<&'a Word>,
    pub substeps: Option<Substepping>,
}

macro_rules! share_keys {
    ($($Entry:ty)*) => {
        $(impl $Entry {
            pub fn shared(&self) -> SharedKeys<'_> {
                let Self { mass_kg, color, method, substeps, .. } = self;
                SharedKeys { mass_kg: *mass_kg, color: *color, method: method.as_ref(), substeps: substeps.map(Into::into) }
            }
        })*
    };
}

share_keys!(Grid Cloud Ring Emitter SoftKeys);

#[derive(Deserialize)]
pub(crate) struct Expect {
    pub energy_drift_below: Option<f64>,
    pub finite: Option<bool>,
    pub survival: Option<Survival>,
}

/// Any word and the keys of all shapes.
pub(crate) type Shape = Worded<Sizes>;

/// The keys of all shapes together; the resolver checks which belong to which shape.
#[derive(Deserialize)]
pub(crate) struct Sizes {
    pub half_extents_m: Option<Triple>,
    pub radius_m: Option<f64>,
}

/// A force or a displacement over time. The parser cannot continue after an unknown word, so that fault is reported alone.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Curve {
    /// `polynomial([(x, y, z), ...])`.
    Polynomial(List<Triple>),
    /// `sine(amplitude_n: (x, y, z), ...)`, or `amplitude_m`.
    Sine {
        amplitude_n: Option<Triple>,
        amplitude_m: Option<Triple>,
        angular_frequency_rad_s: Option<f64>,
        phase_rad: Option<f64>,
    },
    /// `table([(t, (x, y, z)), ...])`.
    Table(List<(f64, Triple)>),
}

impl Curve {
    /// Number of points of a table, or of coefficients.
    pub fn points(&self) -> usize {
        match self {
            Self::Polynomial(coefficients) => coefficients.len(),
            Self::Sine { .. } => 0,
            Self::Table(points) => points.len(),
        }
    }
}

/// The keys of a sine, of which `amplitude` is one.
fn kinds_of_sine(amplitude: &'static str) -> Vec<(&'static str, Kind)> {
    vec![
        (amplitude, Kind::Numbers(3)),
        ("angular_frequency_rad_s", Kind::Number),
        ("phase_rad", Kind::Number),
    ]
}

/// The keys that are known at the path of a group, and what they take; none if the path leads to no group. Those of a soft
/// body are those of its `kind`.
pub(crate) fn kinds_at(path: &str, kind: &str) -> Vec<(&'static str, Kind)> {
    let item = path.split_once('[').and_then(|(list, rest)| Some((list, rest.split_once(']')?.1)));
    match item.unwrap_or((path, "")) {
        ("", "") => kinds_of::<Scene>(),
        ("thrusts", ".curve") => kinds_of_sine("amplitude_n"),
        ("moves", ".curve") => kinds_of_sine("amplitude_m"),
        ("expect.survival" | "expect.survival.rows", "") => kinds_of::<Survival>(),
        ("expect.survival.script", "") => kinds_of::<Step>(),
        ("bodies", ".shape") => kinds_of::<Sizes>(),
        ("soft_bodies", "") => coupled::kinds_of_soft(kind),
        (section, "") => kinds_in(section),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_known_keys_are_those_of_the_structs() {
        let keys = |path| kinds_at(path, "");
        let rates = ["rate_per_s", "share_kept_per_s"].map(|key| (key, Kind::Number));
        assert_eq!(keys("damping"), [("model", Kind::Word), rates[0], rates[1]]);
        assert_eq!(
            keys("bodies[12].shape"),
            [("half_extents_m", Kind::Numbers(3)), ("radius_m", Kind::Number)],
        );
        assert_eq!(keys("clouds[0]").len(), 10);
        assert_eq!(keys("nothing"), []);
        let (of_chain, of_cloth) =
            (kinds_at("soft_bodies[0]", "chain"), kinds_at("soft_bodies[1]", "cloth"));
        assert!(
            of_chain.contains(&("points", Kind::Count))
                && of_chain.contains(&("mass_kg", Kind::Number))
        );
        assert!(
            !of_chain.iter().any(|(key, _)| *key == "rows")
                && of_cloth.contains(&("shear", Kind::Flag))
        );
        let of_scene = keys("");
        for known in [
            ("name", Kind::Text),
            ("gravity", Kind::Group),
            ("method", Kind::Word),
            ("bodies", Kind::Other),
        ] {
            assert!(of_scene.contains(&known), "{known:?}");
        }
    }
}
