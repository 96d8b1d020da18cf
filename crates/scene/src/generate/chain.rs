//! Chains: points in a line, each joined to the next, and copies of them over an area.

use glam::DVec3;
use motion::SoftForm;

use super::form::{ALL, Braces, FIRST, Form, LAST, Place, ROOT, pinned, points, within_numbers};
use crate::check::{Rule, Scope, positive, rule};
use crate::raw;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

const ENDS: [(&str, Place); 3] =
    [("first", [ALL, FIRST, ALL]), ("last", [ALL, LAST, ALL]), ("root", [ALL, ROOT, ALL])];

const WIDTH: Rule = rule(positive, "a width", "give a positive number of meters");

/// Steps of a sequence that fills a square evenly along x and z (Roberts 2018: powers of the reciprocal of the plastic number),
/// and a height with the golden section.
const EVENLY: DVec3 =
    DVec3::new(0.754_877_666_246_692_7, 0.618_033_988_749_895, 0.569_840_290_998_053_2);

pub(super) fn form(keys: &raw::SoftKeys, scope: Scope, faults: &mut Faults) -> Form {
    let from = faults.vector(scope, "from_m", keys.from_m, DVec3::ZERO);
    faults.require(keys.to_m.is_some(), scope, "to_m", "say where the chain ends");
    let to = faults.vector(scope, "to_m", keys.to_m, from + DVec3::X);
    if from == to || !within_numbers(&[from, to, to - from]) {
        let cure = "give a place other than from_m, within 1e150 m";
        faults.refuse(scope, "to_m", "a chain cannot reach from there to there", cure);
    }
    let over = faults.vector(scope, "over_m", keys.over_m, DVec3::ZERO);
    if keys.copies == Some(0) {
        faults.refuse(scope, "copies", "0 copies are no chain", "give a whole number from 1 up");
    }
    if keys.copies.is_some() != keys.over_m.is_some() {
        let cure = "give both, as in `copies: 100, over_m: (10.0, 0.0, 10.0)`, or neither";
        faults.refuse(scope, "over_m", "copies need room, and room needs copies", cure);
    }
    let count = points(keys.points, scope, "points", faults);
    let copies = keys.copies.unwrap_or(1);
    let form = SoftForm::ropes(copies, count, move |[copy, part]| {
        let number = (copy * f64::from(copies.saturating_sub(1))).round();
        from + (to - from) * part + over * ((EVENLY * number + 0.5).fract() - 0.5)
    });
    let bend = Braces {
        given: ("bend", keys.bend),
        stiffness: ("bend_n_m", keys.bend_n_m),
        add: SoftForm::with_bend,
    };
    Form {
        shape: bend.add_to(form, scope, faults),
        numbering: match keys.copies {
            None => Numbering::Line,
            Some(_) => Numbering::Sheet { columns: count },
        },
        pinned: pinned(keys, &ENDS, scope, faults),
        width: faults.optional(scope, "width_m", keys.width_m, WIDTH),
    }
}
