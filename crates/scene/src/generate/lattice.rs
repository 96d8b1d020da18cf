//! Lattices: a block of cells, every point joined to all that share a cell with it.

use glam::{DVec3, IVec3, UVec3};

use super::soft::{Form, part, pinned, within_numbers};
use crate::check::{Scope, positive, shown_vector};
use crate::raw::coupled::RawSoftKeys;
use crate::scene::coupled::SoftKind;
use crate::scene::names::Numbering;
use crate::text::faults::Faults;

/// A side of the block: its axis, and whether it is the one of the larger coordinate.
type Side = (usize, bool);

const SIDES: [(&str, Side); 6] = [
    ("left", (0, false)),
    ("right", (0, true)),
    ("bottom", (1, false)),
    ("top", (1, true)),
    ("back", (2, false)),
    ("front", (2, true)),
];

/// A checked lattice.
pub(super) struct Lattice {
    /// Points along each axis, at least 2, or 0 where they cannot be counted.
    points: UVec3,
    center: DVec3,
    size: DVec3,
    pinned: Vec<Side>,
}

impl Lattice {
    pub fn resolve(keys: &RawSoftKeys, scope: Scope, faults: &mut Faults) -> Self {
        let cells = UVec3::from_array(keys.cells.unwrap_or([1; 3]));
        let cure = "give three whole numbers from 1 up, as in `cells: (3, 3, 3)`";
        let countable = cells.min_element() > 0 && cells.max_element() < u32::MAX;
        if keys.cells.is_none() {
            faults.missing(scope.path(), "cells", cure);
        } else if !countable {
            let what = format!("({}, {}, {}) makes no block of cells", cells.x, cells.y, cells.z);
            faults.add(scope.key("cells"), what, cure);
        }
        if keys.size_m.is_none() {
            faults.missing(scope.path(), "size_m", "give one such as `size_m: (1.0, 1.0, 1.0)`");
        }
        let center = faults.vector((scope, "center_m"), keys.center_m, DVec3::ZERO);
        let size = keys.size_m.map_or(DVec3::ONE, DVec3::from_array);
        if !size.to_array().into_iter().all(positive) || !within_numbers(&[center, size, center + size]) {
            let cure = "give three positive numbers of meters";
            faults.add(scope.key("size_m"), format!("{} is not a size", shown_vector(size)), cure);
        }
        Self {
            points: if countable { cells + 1 } else { UVec3::ZERO },
            center,
            size,
            pinned: pinned(keys, &SIDES, scope, faults),
        }
    }

    fn place(&self, point: u32) -> UVec3 {
        let UVec3 { y, z, .. } = self.points;
        UVec3::new(point / (y * z), point / z % y, point % z)
    }

    const fn number(&self, place: UVec3) -> u32 {
        (place.x * self.points.y + place.y) * self.points.z + place.z
    }
}

impl Form for Lattice {
    fn kind(&self) -> SoftKind {
        SoftKind::Lattice
    }

    fn count(&self) -> u64 {
        self.points.to_array().into_iter().fold(1, |count: u64, points| count.saturating_mul(points.into()))
    }

    fn springs(&self) -> u64 {
        let [x, y, z] = self.points.to_array().map(u64::from);
        // A step along an axis has one place fewer there.
        let [cx, cy, cz] = [x, y, z].map(|points| points.saturating_sub(1));
        let edges = [[cx, y, z], [x, cy, z], [x, y, cz]];
        let faces = [[cx, cy, z], [cx, y, cz], [x, cy, cz]].map(|[a, b, c]| [a, b, c.saturating_mul(2)]);
        let cells = [cx, cy, cz.saturating_mul(4)];
        let product = |sides: [u64; 3]| sides.into_iter().fold(1, u64::saturating_mul);
        let all = edges.into_iter().chain(faces).chain([cells]);
        all.map(product).fold(0, u64::saturating_add)
    }

    fn numbering(&self) -> Numbering {
        Numbering::Lattice { y: self.points.y, z: self.points.z }
    }

    fn position(&self, point: u32) -> DVec3 {
        let place = self.place(point).to_array();
        let parts = std::array::from_fn(|axis| part(place[axis], self.points[axis]) - 0.5);
        self.center + self.size * DVec3::from_array(parts)
    }

    fn pinned(&self, point: u32) -> bool {
        let place = self.place(point);
        self.pinned.iter().any(|&(axis, far)| place[axis] == if far { self.points[axis] - 1 } else { 0 })
    }

    fn pairs(&self) -> Vec<[u32; 2]> {
        // Of the 26 neighbors, the 13 that come later: edges, diagonals of faces and diagonals of cells.
        let steps: Vec<[i32; 3]> =
            (0..27).map(|i| [i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1]).filter(|step| *step > [0, 0, 0]).collect();
        let mut pairs = Vec::with_capacity(self.springs() as usize);
        for point in 0..self.count() as u32 {
            let place = self.place(point).as_ivec3();
            for step in &steps {
                let to = (place + IVec3::from_array(*step)).as_uvec3();
                // What is below 0 is far above all numbers of points.
                if to.cmplt(self.points).all() {
                    pairs.push([point, self.number(to)]);
                }
            }
        }
        pairs
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for (_, (axis, far)) in SIDES {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let level = if far { self.points[axis].saturating_sub(1) } else { 0 };
            for i in 1..self.points[u] {
                for j in 1..self.points[v] {
                    let corner = |i: u32, j: u32| {
                        let mut place = UVec3::ZERO;
                        (place[axis], place[u], place[v]) = (level, i, j);
                        self.number(place)
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
}
