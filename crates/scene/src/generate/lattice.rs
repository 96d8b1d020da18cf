//! Lattices: a block of cells, every point joined to all that share a cell with it.

use glam::{DVec3, UVec3};
use motion::SoftForm;

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
    let form = SoftForm::block(center, size, if countable { cells.to_array() } else { [1; 3] });
    let UVec3 { y, z, .. } = form.points();
    Form {
        shape: form,
        numbering: Numbering::Lattice { y, z },
        pinned: pinned(keys, &SIDES, scope, faults),
        width: None,
    }
}
