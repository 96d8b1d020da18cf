//! Lattices: a block of cells, every point joined to all that share a cell with it.

use glam::{DVec3, IVec3, UVec3};

use super::form::{ALL, FIRST, Form, LAST, Place, pinned, within_numbers};
use crate::check::{Scope, positive, shown_vector};
use crate::raw;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

const SIDES: [(&str, Place); 6] = [
    ("left", [FIRST, ALL, ALL]),
    ("right", [LAST, ALL, ALL]),
    ("bottom", [ALL, FIRST, ALL]),
    ("top", [ALL, LAST, ALL]),
    ("back", [ALL, ALL, FIRST]),
    ("front", [ALL, ALL, LAST]),
];

pub(super) fn form(keys: &raw::SoftKeys, scope: Scope, faults: &mut Faults) -> Form {
    let cells = UVec3::from_array(keys.cells.unwrap_or([1; 3]));
    let cure = "give three whole numbers from 1 up, as in `cells: (3, 3, 3)`";
    let countable = cells.min_element() > 0 && cells.max_element() < u32::MAX;
    faults.require(keys.cells.is_some(), scope, "cells", cure);
    if !countable {
        let what = format!("({}, {}, {}) makes no block of cells", cells.x, cells.y, cells.z);
        faults.refuse(scope, "cells", what, cure);
    }
    faults.require(
        keys.size_m.is_some(),
        scope,
        "size_m",
        "give one such as `size_m: (1.0, 1.0, 1.0)`",
    );
    let center = faults.vector(scope, "center_m", keys.center_m, DVec3::ZERO);
    let size = keys.size_m.map_or(DVec3::ONE, DVec3::from_array);
    if !size.to_array().into_iter().all(positive) || !within_numbers(&[center, size, center + size])
    {
        let cure = "give three positive numbers of meters";
        faults.refuse(scope, "size_m", format!("{} is not a size", shown_vector(size)), cure);
    }
    let points = if countable { cells + 1 } else { UVec3::ZERO };
    // The 13 of the 26 neighbors that come later: edges, diagonals of faces and diagonals of cells.
    let steps = (14..27).map(|i| IVec3::new(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1));
    Form {
        sheet: false,
        numbering: Numbering::Lattice { y: points.y, z: points.z },
        points,
        steps: steps.collect(),
        stiffness: Vec::new(),
        pinned: pinned(keys, &SIDES, scope, faults),
        position: Box::new(move |parts| center + size * (DVec3::from_array(parts) - 0.5)),
        width: None,
        triangles,
    }
}

fn triangles(form: &Form) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for (axis, far) in [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)] {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let level = if far { form.points[axis].saturating_sub(1) } else { 0 };
        for i in 1..form.points[u] {
            for j in 1..form.points[v] {
                let corner = |i: u32, j: u32| {
                    let mut place = UVec3::ZERO;
                    (place[axis], place[u], place[v]) = (level, i, j);
                    form.number(place)
                };
                let [a, b, c, d] =
                    [corner(i - 1, j - 1), corner(i, j - 1), corner(i, j), corner(i - 1, j)];
                // a, b, c, d goes round counterclockwise as seen from the far side of the axis.
                if far {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, c, b], [a, d, c]]);
                }
            }
        }
    }
    triangles
}
