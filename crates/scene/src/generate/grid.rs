//! Grids: rows and columns of cubes and spheres, as in the tutorial.

use glam::DVec3;
use pick::Shape;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::count;
use crate::check::{Scope, positive, shown};
use crate::raw::RawGrid;
use crate::scene::BodySpec;
use crate::text::faults::Faults;

/// Half an edge of a grid's cubes, and the radius of its spheres, m, as in the tutorial.
const GRID_SIZE: f64 = 1.0;
/// Distance of a grid's bodies where none is given, m, as in the tutorial.
const GRID_SPACING: f64 = 3.5;
/// Mass of a grid's bodies where none is given, kg; its reciprocal is exactly the tutorial's 10.
const GRID_MASS: f64 = 0.1;

#[derive(Clone, Copy, Debug)]
enum GridKind {
    Mixed,
    Cubes,
    Spheres,
}

/// A checked grid.
pub(super) struct Grid {
    kind: GridKind,
    pub columns: u32,
    pub rows: u32,
    spacing: [f64; 2],
    origin: DVec3,
    pub body: BodySpec,
}

/// Checks grid `index` of the list.
pub(super) fn grid(raw: &RawGrid, index: usize, faults: &mut Faults) -> Grid {
    let scope = Scope::item("grids", index);
    let kinds = [("mixed", GridKind::Mixed), ("cubes", GridKind::Cubes), ("spheres", GridKind::Spheres)];
    let kind = faults.word((scope, "kind"), raw.kind.as_ref(), GridKind::Mixed, &kinds);
    let rows = count(raw.rows, (scope, "rows"), faults);
    let columns = count(raw.columns, (scope, "columns"), faults);
    let spacing = raw.spacing_m.unwrap_or([GRID_SPACING; 2]);
    if !spacing.into_iter().all(positive) {
        let [x, z] = spacing;
        faults.add(
            scope.key("spacing_m"),
            format!("({}, {}) is not a spacing", shown(x), shown(z)),
            "give two positive numbers of meters",
        );
    }
    let origin = faults.vector((scope, "origin_m"), raw.origin_m, DVec3::ZERO);
    let [x, z] = spacing;
    let span = DVec3::new(f64::from(columns) * x, 0.0, f64::from(rows) * z);
    if spacing.into_iter().all(positive) && !(origin + span).is_finite() {
        faults.add(scope.key("spacing_m"), "the grid reaches beyond all numbers", "give a smaller spacing");
    }
    let body = BodySpec {
        inverse_mass: Some(faults.inverse_mass(
            scope,
            raw.mass_kg,
            GRID_MASS,
            "give a positive number of kilograms",
        )),
        color: faults.color((scope, "color"), raw.color, BodySpec::DEFAULT.color, 1.0),
        checker: true,
        method: faults.method(scope, raw.method.as_ref()),
        substeps: faults.substeps(scope, raw.substeps),
        ..BodySpec::DEFAULT
    };
    Grid { kind, columns, rows, spacing, origin, body }
}

impl Grid {
    pub fn generate(&self, random: &mut Pcg64, bodies: &mut Vec<BodySpec>) {
        let cube = Shape::Cuboid { half_extents: DVec3::splat(GRID_SIZE) };
        let sphere = Shape::Sphere { radius: GRID_SIZE };
        for x in 0..self.columns {
            for z in 0..self.rows {
                let shape = match self.kind {
                    GridKind::Cubes => cube,
                    GridKind::Spheres => sphere,
                    GridKind::Mixed => {
                        if random.random::<bool>() {
                            cube
                        } else {
                            sphere
                        }
                    }
                };
                let offset = DVec3::new(f64::from(x) * self.spacing[0], 0.0, f64::from(z) * self.spacing[1]);
                bodies.push(BodySpec { shape: Some(shape), position: self.origin + offset, ..self.body });
            }
        }
    }
}
