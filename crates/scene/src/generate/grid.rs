//! Grids: rows and columns of cubes and spheres, as in the tutorial.

use glam::DVec3;
use pick::Shape;
use rand::RngExt;

use super::entry::{GeneratedEntry, count, shared};
use crate::check::{MASS, Scope, positive, shown};
use crate::raw;
use crate::scene::BodySpec;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

/// Half an edge of a grid's cubes, and the radius of its spheres, m, as in the tutorial.
const GRID_SIZE: f64 = 1.0;
/// Distance of a grid's bodies where none is given, m, as in the tutorial.
const GRID_SPACING: f64 = 3.5;
/// Mass of a grid's bodies where none is given, kg; its reciprocal is exactly the tutorial's 10.
const GRID_MASS: f64 = 0.1;

/// Resolves grid `index` of the list.
pub(super) fn grid(raw: &raw::Grid, index: usize, faults: &mut Faults) -> GeneratedEntry {
    const CUBE: Shape = Shape::Cuboid { half_extents: DVec3::splat(GRID_SIZE) };
    const SPHERE: Shape = Shape::Sphere { radius: GRID_SIZE };
    let scope = Scope::item("grids", index);
    // The shapes of a `mixed` grid are drawn at random.
    let kinds = [("mixed", None), ("cubes", Some(CUBE)), ("spheres", Some(SPHERE))];
    let shape = faults.word(scope, "kind", raw.kind.as_ref(), None, &kinds);
    let rows = count(raw.rows, scope, "rows", faults);
    let columns = count(raw.columns, scope, "columns", faults);
    let spacing = raw.spacing_m.unwrap_or([GRID_SPACING; 2]);
    let [along_x, along_z] = spacing;
    let origin = faults.vector(scope, "origin_m", raw.origin_m, DVec3::ZERO);
    let span = DVec3::new(f64::from(columns) * along_x, 0.0, f64::from(rows) * along_z);
    if !spacing.into_iter().all(positive) {
        let what = format!("({}, {}) is not a spacing", shown(along_x), shown(along_z));
        faults.refuse(scope, "spacing_m", what, "give two positive numbers of meters");
    } else if !(origin + span).is_finite() {
        faults.refuse(
            scope,
            "spacing_m",
            "the grid reaches beyond all numbers",
            "give a smaller spacing",
        );
    }
    let (body, own) = shared(&raw.shared(), scope, GRID_MASS, 1.0, MASS, faults);
    let body = BodySpec { checker: true, ..body };
    GeneratedEntry::new(
        scope,
        own,
        u64::from(rows) * u64::from(columns),
        Numbering::Grid { rows },
        body,
        move |_, bodies, random| {
            for x in 0..columns {
                for z in 0..rows {
                    let shape = shape
                        .unwrap_or_else(|| if random.random::<bool>() { CUBE } else { SPHERE });
                    let offset = DVec3::new(f64::from(x) * along_x, 0.0, f64::from(z) * along_z);
                    bodies.bodies.push(BodySpec {
                        shape: Some(shape),
                        position: origin + offset,
                        ..body
                    });
                }
            }
        },
    )
}
