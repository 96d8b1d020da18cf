//! Soft bodies: what chains, cloths and lattices have in common, and the making of their points and springs.

use glam::DVec3;
use motion::{Elastic, Link};

use super::chain::Chain;
use super::cloth::Cloth;
use super::lattice::Lattice;
use crate::check::DAMPING_RATE;
use crate::check::{Scope, not_negative, positive};
use crate::raw::coupled::{KINDS, RawSoftBody, RawSoftKeys};
use crate::scene::BodySpec;
use crate::scene::coupled::{SoftBodySpec, SoftKind};
use crate::scene::names::Numbering;
use crate::text::faults::Faults;
use crate::text::nearest::one_of;
use crate::text::syntax::Word;

/// What a kind of soft body is made of: points by number, and what joins them.
pub(super) trait Form {
    fn kind(&self) -> SoftKind;

    /// How many points there are; 0 where they cannot be counted.
    fn count(&self) -> u64;

    /// How many springs there are: as many as [`Form::pairs`].
    fn springs(&self) -> u64;

    fn numbering(&self) -> Numbering;

    fn position(&self, point: u32) -> DVec3;

    /// Whether the point is immovable.
    fn pinned(&self, point: u32) -> bool;

    /// The ends of every spring, all that begin at one point together.
    fn pairs(&self) -> Vec<[u32; 2]>;

    fn triangles(&self) -> Vec<[u32; 3]>;
}

/// A checked soft body.
pub(super) struct Soft {
    pub form: Box<dyn Form>,
    stiffness: f64,
    damping: f64,
    velocity: DVec3,
    /// What every point is, its place aside.
    pub body: BodySpec,
}

/// Checks soft body `index` of the list; `None` if it is of no known kind.
pub(super) fn soft(raw: &RawSoftBody, index: usize, faults: &mut Faults) -> Option<Soft> {
    let scope = Scope::item("soft_bodies", index);
    for key in raw.strange_keys() {
        faults.add(scope.key(key), format!("a {} has no `{key}`", raw.word), "remove it");
    }
    let keys = &raw.keys;
    if keys.stiffness_n_m.is_none() {
        faults.missing(scope.path(), "stiffness_n_m", "add one such as `stiffness_n_m: 100.0`");
    }
    let (stiffness, damping) = elastic(keys.stiffness_n_m, keys.damping_n_s_m, scope, faults);
    let form: Option<Box<dyn Form>> = match raw.word.as_str() {
        "chain" => Some(Box::new(Chain::resolve(keys, scope, faults))),
        "cloth" => Some(Box::new(Cloth::resolve(keys, scope, faults))),
        "lattice" => Some(Box::new(Lattice::resolve(keys, scope, faults))),
        word => {
            let cure = format!("give {}", one_of(&KINDS.map(|(kind, _)| kind)));
            faults.add(scope.path(), format!("unknown soft body `{word}`"), cure);
            None
        }
    };
    let points = form.as_ref().map_or(1, |form| form.count().max(1)) as f64;
    let usable = |mass: f64| positive(mass) && (points / mass).is_finite();
    let mass = ("a mass", "give a positive number of kilograms for all points together");
    let inverse_mass = points / faults.number((scope, "mass_kg"), keys.mass_kg, 1.0, usable, mass);
    let body = BodySpec {
        inverse_mass: Some(inverse_mass),
        color: faults.color((scope, "color"), keys.color, BodySpec::DEFAULT.color, 1.0),
        method: faults.method(scope, keys.method.as_ref()),
        substeps: faults.substeps(scope, keys.substeps),
        damping_rate: keys
            .damping_per_s
            .map(|rate| faults.number((scope, "damping_per_s"), Some(rate), 0.0, not_negative, DAMPING_RATE)),
        gravity_off: keys.gravity_off == Some(true),
        ..BodySpec::DEFAULT
    };
    let velocity = faults.vector((scope, "velocity_m_s"), keys.velocity_m_s, DVec3::ZERO);
    form.map(|form| Soft { form, stiffness, damping, velocity, body })
}

/// Stiffness, N/m, and damping, N s/m, of springs.
pub(crate) fn elastic(
    stiffness: Option<f64>,
    damping: Option<f64>,
    scope: Scope,
    faults: &mut Faults,
) -> (f64, f64) {
    let words = ("a stiffness", "give a number of N/m from 0 up");
    let stiffness = faults.number((scope, "stiffness_n_m"), stiffness, 0.0, not_negative, words);
    let words = ("a damping", "give a number of N s/m from 0 up");
    (stiffness, faults.number((scope, "damping_n_s_m"), damping, 0.0, not_negative, words))
}

/// The places of `pinned`, each of them one of `known`.
pub(super) fn pinned<T: Copy>(
    keys: &RawSoftKeys,
    known: &[(&str, T)],
    scope: Scope,
    faults: &mut Faults,
) -> Vec<T> {
    let mut places = Vec::new();
    let words = keys.pinned.as_deref().unwrap_or_default();
    for (i, Word(word)) in words.iter().enumerate() {
        let path = || scope.key(&format!("pinned[{i}]"));
        if words[..i].iter().any(|Word(before)| before == word) {
            faults.add(path(), format!("`{word}` is named twice"), "keep one of them");
        } else if let Some((_, place)) = known.iter().find(|(name, _)| name == word) {
            places.push(*place);
        } else {
            let all: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
            faults.add(path(), format!("unknown word `{word}`"), format!("give {}", one_of(&all)));
        }
    }
    places
}

/// A number of points along a line, at least 2; 0 where there is none.
pub(super) fn points(value: Option<u32>, (scope, key): (Scope, &str), faults: &mut Faults) -> u32 {
    const CURE: &str = "give a whole number from 2 up";
    match value {
        Some(points) if points >= 2 => return points,
        Some(points) => faults.add(scope.key(key), format!("{points} makes no spring"), CURE),
        None => faults.missing(scope.path(), key, CURE),
    }
    0
}

/// How far `number` is along a line of `points`, 0 to 1.
pub(super) fn part(number: u32, points: u32) -> f64 {
    f64::from(number) / f64::from(points - 1)
}

/// Whether a soft body of these extents lies within numbers whose squares are numbers.
pub(super) fn within_numbers(places: &[DVec3]) -> bool {
    places.iter().all(|place| place.length().is_finite())
}

impl Soft {
    /// Notes the fault of one that is held at every point. To be asked where points can be counted.
    pub fn check_movable(&self, index: usize, faults: &mut Faults) {
        let count = self.form.count() as u32;
        if count > 0 && (0..count).all(|point| self.form.pinned(point)) {
            let cure = "leave at least one point free";
            let path = Scope::item("soft_bodies", index).key("pinned");
            faults.add(path, "every point is pinned, so none can move", cure);
        }
    }

    /// Adds the points to `bodies`.
    pub fn generate(&self, name: String, bodies: &mut Vec<BodySpec>) -> SoftBodySpec {
        let first = bodies.len();
        bodies.extend((0..self.form.count() as u32).map(|point| {
            let position = self.form.position(point);
            if self.form.pinned(point) {
                BodySpec { position, inverse_mass: Some(0.0), ..self.body }
            } else {
                BodySpec { position, velocity: self.velocity, ..self.body }
            }
        }));
        let points = &bodies[first..];
        let link = |ends: [u32; 2]| {
            // Measured as a step measures it, so that nothing pulls at the start.
            let [from, to] = ends.map(|end| points[end as usize].position);
            let rest_length = (to - from).length();
            Link { ends, elastic: Elastic { stiffness: self.stiffness, damping: self.damping, rest_length } }
        };
        SoftBodySpec {
            name,
            kind: self.form.kind(),
            links: self.form.pairs().into_iter().map(link).collect(),
            triangles: self.form.triangles(),
            points: first as u32..bodies.len() as u32,
            color: self.body.color,
        }
    }
}

#[cfg(test)]
mod tests;
