//! Forms of soft bodies: points along up to three axes, the springs between them, and where they are held.

use glam::{DVec3, IVec3, UVec3};

use crate::check::{STIFFNESS, Scope};
use crate::raw;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;
use crate::text::nearest::one_of;
use crate::text::syntax::Word;

/// The form of a soft body of any kind. The last axis is the inner loop of the numbers of points.
pub(super) struct Form {
    /// Whether its surface is a sheet, against which air flows.
    pub sheet: bool,
    pub numbering: Numbering,
    /// Points along each axis: 1 without such an axis, 0 if they cannot be counted.
    pub points: UVec3,
    /// Offsets from a point to the points that it is joined to, so that each pair occurs once.
    pub steps: Vec<IVec3>,
    /// Stiffness of the springs of each of these steps, N/m, if not that of the body.
    pub stiffness: Vec<Option<f64>>,
    /// Places whose points are immovable.
    pub pinned: Vec<Place>,
    /// The position of a point, m, by its fraction along each axis, 0 to 1.
    pub position: Box<dyn Fn([f64; 3]) -> DVec3>,
    /// The width of the blades as which its lines of points along the second axis are drawn, m, if so.
    pub width: Option<f64>,
    /// Its surface, by numbers of points.
    pub triangles: fn(&Self) -> Vec<[u32; 3]>,
}

/// A corner, an edge or a side, by the end of each axis that it is at; `None` is all of the axis.
pub(super) type Place = [Option<End>; 3];

/// An end of an axis.
#[derive(Clone, Copy)]
pub(super) enum End {
    First,
    Last,
    /// The first two points.
    Root,
}

pub(super) const ALL: Option<End> = None;
pub(super) const FIRST: Option<End> = Some(End::First);
pub(super) const LAST: Option<End> = Some(End::Last);
pub(super) const ROOT: Option<End> = Some(End::Root);

impl Form {
    /// Number of points; 0 if they cannot be counted.
    pub fn count(&self) -> u64 {
        self.points.to_array().into_iter().map(u64::from).fold(1, u64::saturating_mul)
    }

    /// Number of springs: as many as [`Form::pairs`].
    pub fn springs(&self) -> u64 {
        // A step of n along an axis has n fewer starting points there.
        let places = |step: &IVec3| {
            let along = self.points.saturating_sub(step.abs().as_uvec3()).to_array();
            along.into_iter().map(u64::from).fold(1, u64::saturating_mul)
        };
        self.steps.iter().map(places).fold(0, u64::saturating_add)
    }

    /// The ends of every spring and the number of its step, sorted by the first end.
    pub fn pairs(&self) -> Vec<([u32; 2], usize)> {
        let mut pairs = Vec::with_capacity(self.springs() as usize);
        for point in 0..self.count() as u32 {
            let place = self.place(point).as_ivec3();
            for (number, step) in self.steps.iter().enumerate() {
                let to = (place + *step).as_uvec3();
                // A negative coordinate becomes a number far above all numbers of points.
                if to.cmplt(self.points).all() {
                    pairs.push(([point, self.number(to)], number));
                }
            }
        }
        pairs
    }

    /// The position of a point, m.
    pub fn position(&self, point: u32) -> DVec3 {
        let place = self.place(point);
        let part = |axis: usize| f64::from(place[axis]) / f64::from((self.points[axis] - 1).max(1));
        (self.position)([0, 1, 2].map(part))
    }

    /// Whether a point is immovable.
    pub fn is_pinned(&self, point: u32) -> bool {
        let place = self.place(point);
        let at = |(axis, end): (usize, &Option<End>)| match end {
            None => true,
            Some(End::First) => place[axis] == 0,
            Some(End::Last) => place[axis] + 1 == self.points[axis],
            Some(End::Root) => place[axis] < 2,
        };
        self.pinned.iter().any(|held| held.iter().enumerate().all(at))
    }

    /// The number of the point with these indices along the axes.
    pub const fn number(&self, place: UVec3) -> u32 {
        (place.x * self.points.y + place.y) * self.points.z + place.z
    }

    fn place(&self, point: u32) -> UVec3 {
        let UVec3 { y, z, .. } = self.points;
        UVec3::new(point / (y * z), point / z % y, point % z)
    }
}

/// Springs that brace a soft body, and that it has only if they are asked for.
pub(super) struct Braces {
    /// The key that asks for them, and its value.
    pub given: (&'static str, Option<bool>),
    /// The key of their own stiffness, which asks for them too, and its value, N/m.
    pub stiffness: (&'static str, Option<f64>),
    pub steps: &'static [IVec3],
}

impl Braces {
    /// Appends them to the steps of a body and their stiffnesses, if they are asked for.
    pub fn add(
        self,
        steps: &mut Vec<IVec3>,
        stiffness: &mut Vec<Option<f64>>,
        scope: Scope,
        faults: &mut Faults,
    ) {
        let Self { given: (key, given), stiffness: (own, n_m), steps: more } = self;
        if given == Some(false) && n_m.is_some() {
            let what = format!("there are no such springs by `{key}: false`");
            faults.refuse(scope, own, what, format!("remove it, or `{key}`"));
        }
        let n_m = faults.optional(scope, own, n_m, STIFFNESS);
        if given == Some(true) || n_m.is_some() {
            steps.extend(more);
            stiffness.extend(more.iter().map(|_| n_m));
        }
    }
}

/// Resolves the places of `pinned`, each of them one of `known`.
pub(super) fn pinned(
    keys: &raw::SoftKeys,
    known: &[(&str, Place)],
    scope: Scope,
    faults: &mut Faults,
) -> Vec<Place> {
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

/// A number of points along a line, at least 2; 0 if it is missing or invalid.
pub(super) fn points(value: Option<u32>, scope: Scope, key: &str, faults: &mut Faults) -> u32 {
    const CURE: &str = "give a whole number from 2 up";
    match value {
        Some(points) if points >= 2 => return points,
        Some(points) => faults.refuse(scope, key, format!("{points} makes no spring"), CURE),
        None => faults.missing(scope.path(), key, CURE),
    }
    0
}

/// Whether these extents of a soft body have finite squares.
pub(super) fn within_numbers(places: &[DVec3]) -> bool {
    places.iter().all(|place| place.length().is_finite())
}
