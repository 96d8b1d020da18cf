//! Cloths: rows and columns of points, braced by diagonals and against folding.

use glam::DVec3;
use motion::SoftForm;

use super::form::{ALL, Braces, FIRST, Form, LAST, Place, pinned, points, within_numbers};
use crate::check::Scope;
use crate::raw;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

/// Edges and corners, by ends of rows and of columns.
const PLACES: [(&str, Place); 8] = [
    ("left_edge", [ALL, FIRST, ALL]),
    ("right_edge", [ALL, LAST, ALL]),
    ("top_edge", [FIRST, ALL, ALL]),
    ("bottom_edge", [LAST, ALL, ALL]),
    ("top_left", [FIRST, FIRST, ALL]),
    ("top_right", [FIRST, LAST, ALL]),
    ("bottom_left", [LAST, FIRST, ALL]),
    ("bottom_right", [LAST, LAST, ALL]),
];

pub(super) fn form(keys: &raw::SoftKeys, scope: Scope, faults: &mut Faults) -> Form {
    let cure = "say how a row goes, as in `along_m: (3.0, 0.0, 0.0)`";
    faults.require(keys.along_m.is_some(), scope, "along_m", cure);
    let cure = "say how a column goes, as in `down_m: (0.0, -2.0, 0.0)`";
    faults.require(keys.down_m.is_some(), scope, "down_m", cure);
    let corner = faults.vector(scope, "corner_m", keys.corner_m, DVec3::ZERO);
    let along = faults.vector(scope, "along_m", keys.along_m, DVec3::X);
    let down = faults.vector(scope, "down_m", keys.down_m, DVec3::NEG_Y);
    let area = along.cross(down);
    if area == DVec3::ZERO || !within_numbers(&[corner, along, down, corner + along + down, area]) {
        let cure = "give two vectors that span an area, within 1e75 m";
        faults.refuse(scope, "down_m", "rows and columns make no cloth", cure);
    }
    let rows = points(keys.rows, scope, "rows", faults);
    let columns = points(keys.columns, scope, "columns", faults);
    let mut form = SoftForm::cloth(corner, along, down, rows, columns);
    for braces in [
        Braces {
            given: ("shear", keys.shear),
            stiffness: ("shear_n_m", keys.shear_n_m),
            add: SoftForm::with_shear,
        },
        Braces {
            given: ("bend", keys.bend),
            stiffness: ("bend_n_m", keys.bend_n_m),
            add: SoftForm::with_bend,
        },
    ] {
        form = braces.add_to(form, scope, faults);
    }
    Form {
        shape: form,
        numbering: Numbering::Sheet { columns },
        pinned: pinned(keys, &PLACES, scope, faults),
        width: None,
    }
}
