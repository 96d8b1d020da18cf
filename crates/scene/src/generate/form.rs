//! What a scene says of the forms of soft bodies: where they are held, braces, and numbers of points.

use glam::DVec3;
use motion::SoftForm;

use crate::check::{STIFFNESS, Scope};
use crate::raw;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;
use crate::text::nearest::one_of;
use crate::text::syntax::Word;

/// The form of a soft body of any kind. What cannot be counted is a fault, and small.
pub(super) struct Form {
    pub shape: SoftForm,
    pub numbering: Numbering,
    /// Places whose points are immovable.
    pub pinned: Vec<Place>,
    /// The width of the blades as which its ropes are drawn, m, if so.
    pub width: Option<f64>,
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
    /// Whether a point is immovable.
    pub fn is_pinned(&self, point: u32) -> bool {
        let (place, points) = (self.shape.place(point), self.shape.points());
        let at = |(axis, end): (usize, &Option<End>)| match end {
            None => true,
            Some(End::First) => place[axis] == 0,
            Some(End::Last) => place[axis] + 1 == points[axis],
            Some(End::Root) => place[axis] < 2,
        };
        self.pinned.iter().any(|held| held.iter().enumerate().all(at))
    }
}

/// Springs that brace a soft body, and that it has only if they are asked for.
pub(super) struct Braces {
    /// The key that asks for them, and its value.
    pub given: (&'static str, Option<bool>),
    /// The key of their own stiffness, which asks for them too, and its value, N/m.
    pub stiffness: (&'static str, Option<f64>),
    /// Adds them with that stiffness, or that of the body.
    pub add: fn(SoftForm, Option<f64>) -> SoftForm,
}

impl Braces {
    /// Adds them to `form`, if they are asked for.
    pub fn add_to(self, form: SoftForm, scope: Scope, faults: &mut Faults) -> SoftForm {
        let Self { given: (key, given), stiffness: (own, n_m), add } = self;
        if given == Some(false) && n_m.is_some() {
            let what = format!("there are no such springs by `{key}: false`");
            faults.refuse(scope, own, what, format!("remove it, or `{key}`"));
        }
        let n_m = faults.optional(scope, own, n_m, STIFFNESS);
        if given == Some(true) || n_m.is_some() { add(form, n_m) } else { form }
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
