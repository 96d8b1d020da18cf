//! Cloths: rows and columns of points, braced by diagonals and against folding.

use glam::DVec3;

use super::soft::{Form, part, pinned, points, within_numbers};
use crate::check::Scope;
use crate::raw::coupled::RawSoftKeys;
use crate::scene::coupled::SoftKind;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

/// An edge or a corner: which ends of rows and of columns it has; `None` is all.
#[derive(Clone, Copy, Debug)]
struct Place {
    row: Option<Side>,
    column: Option<Side>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    First,
    Last,
}

const PLACES: [(&str, Place); 8] = {
    const FIRST: Option<Side> = Some(Side::First);
    const LAST: Option<Side> = Some(Side::Last);
    [
        ("left_edge", Place { row: None, column: FIRST }),
        ("right_edge", Place { row: None, column: LAST }),
        ("top_edge", Place { row: FIRST, column: None }),
        ("bottom_edge", Place { row: LAST, column: None }),
        ("top_left", Place { row: FIRST, column: FIRST }),
        ("top_right", Place { row: FIRST, column: LAST }),
        ("bottom_left", Place { row: LAST, column: FIRST }),
        ("bottom_right", Place { row: LAST, column: LAST }),
    ]
};

/// A checked cloth.
pub(super) struct Cloth {
    rows: u32,
    columns: u32,
    corner: DVec3,
    along: DVec3,
    down: DVec3,
    shear: bool,
    bend: bool,
    pinned: Vec<Place>,
}

impl Cloth {
    pub fn resolve(keys: &RawSoftKeys, scope: Scope, faults: &mut Faults) -> Self {
        for (key, given, cure) in [
            ("along_m", keys.along_m.is_some(), "say how a row goes, as in `along_m: (3.0, 0.0, 0.0)`"),
            ("down_m", keys.down_m.is_some(), "say how a column goes, as in `down_m: (0.0, -2.0, 0.0)`"),
        ] {
            if !given {
                faults.missing(scope.path(), key, cure);
            }
        }
        let corner = faults.vector((scope, "corner_m"), keys.corner_m, DVec3::ZERO);
        let along = faults.vector((scope, "along_m"), keys.along_m, DVec3::X);
        let down = faults.vector((scope, "down_m"), keys.down_m, DVec3::NEG_Y);
        let area = along.cross(down);
        if area == DVec3::ZERO || !within_numbers(&[corner, along, down, corner + along + down, area]) {
            let cure = "give two vectors that span an area, within 1e75 m";
            faults.add(scope.key("down_m"), "rows and columns make no cloth", cure);
        }
        Self {
            rows: points(keys.rows, (scope, "rows"), faults),
            columns: points(keys.columns, (scope, "columns"), faults),
            corner,
            along,
            down,
            shear: keys.shear == Some(true),
            bend: keys.bend == Some(true),
            pinned: pinned(keys, &PLACES, scope, faults),
        }
    }

    /// From a point to those that it is joined to, by rows and columns; each pair is met from one side only.
    fn steps(&self) -> Vec<(u32, i64)> {
        let structural: &[(u32, i64)] = &[(0, 1), (1, 0)];
        let shear: &[(u32, i64)] = if self.shear { &[(1, -1), (1, 1)] } else { &[] };
        let bend: &[(u32, i64)] = if self.bend { &[(0, 2), (2, 0)] } else { &[] };
        [structural, shear, bend].concat()
    }

    const fn row_and_column(&self, point: u32) -> (u32, u32) {
        (point / self.columns, point % self.columns)
    }
}

impl Form for Cloth {
    fn kind(&self) -> SoftKind {
        SoftKind::Cloth
    }

    fn count(&self) -> u64 {
        u64::from(self.rows) * u64::from(self.columns)
    }

    fn springs(&self) -> u64 {
        let [rows, columns] = [self.rows, self.columns].map(u64::from);
        let steps = self.steps();
        let places = |(down, along): &(u32, i64)| {
            rows.saturating_sub((*down).into()).saturating_mul(columns.saturating_sub(along.unsigned_abs()))
        };
        steps.iter().map(places).fold(0, u64::saturating_add)
    }

    fn numbering(&self) -> Numbering {
        Numbering::Sheet { columns: self.columns }
    }

    fn position(&self, point: u32) -> DVec3 {
        let (row, column) = self.row_and_column(point);
        self.corner + self.along * part(column, self.columns) + self.down * part(row, self.rows)
    }

    fn pinned(&self, point: u32) -> bool {
        let (row, column) = self.row_and_column(point);
        let at = |side: Option<Side>, number: u32, count: u32| match side {
            None => true,
            Some(Side::First) => number == 0,
            Some(Side::Last) => number + 1 == count,
        };
        self.pinned
            .iter()
            .any(|place| at(place.row, row, self.rows) && at(place.column, column, self.columns))
    }

    fn pairs(&self) -> Vec<[u32; 2]> {
        let steps = self.steps();
        let mut pairs = Vec::with_capacity(self.springs() as usize);
        for row in 0..self.rows {
            for column in 0..self.columns {
                for (down, along) in &steps {
                    let (r, c) = (u64::from(row) + u64::from(*down), i64::from(column) + along);
                    if r < u64::from(self.rows) && (0..i64::from(self.columns)).contains(&c) {
                        pairs.push([row * self.columns + column, r as u32 * self.columns + c as u32]);
                    }
                }
            }
        }
        pairs
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for row in 1..self.rows {
            for column in 1..self.columns {
                let (below, above) = (row * self.columns + column, (row - 1) * self.columns + column);
                let [a, b, c, d] = [above - 1, above, below - 1, below];
                // Diagonals in turn, so that the sheet folds as easily one way as the other.
                if (row + column) % 2 == 0 {
                    triangles.extend([[a, c, d], [a, d, b]]);
                } else {
                    triangles.extend([[a, c, b], [b, c, d]]);
                }
            }
        }
        triangles
    }
}
