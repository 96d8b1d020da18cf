//! Chains: points in a line, each joined to the next.

use glam::{DVec3, IVec3, UVec3};

use super::form::{ALL, FIRST, Form, LAST, Place, pinned, points, within_numbers};
use crate::check::Scope;
use crate::raw;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

const ENDS: [(&str, Place); 2] = [("first", [FIRST, ALL, ALL]), ("last", [LAST, ALL, ALL])];

pub(super) fn form(keys: &raw::SoftKeys, scope: Scope, faults: &mut Faults) -> Form {
    let from = faults.vector(scope, "from_m", keys.from_m, DVec3::ZERO);
    faults.require(keys.to_m.is_some(), scope, "to_m", "say where the chain ends");
    let to = faults.vector(scope, "to_m", keys.to_m, from + DVec3::X);
    if from == to || !within_numbers(&[from, to, to - from]) {
        let cure = "give a place other than from_m, within 1e150 m";
        faults.refuse(scope, "to_m", "a chain cannot reach from there to there", cure);
    }
    Form {
        sheet: false,
        numbering: Numbering::Line,
        points: UVec3::new(points(keys.points, scope, "points", faults), 1, 1),
        steps: vec![IVec3::X],
        stiffness: Vec::new(),
        pinned: pinned(keys, &ENDS, scope, faults),
        position: Box::new(move |[part, ..]| from + (to - from) * part),
        triangles: |_| Vec::new(),
    }
}
