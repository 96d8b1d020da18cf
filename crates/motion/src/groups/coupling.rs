//! The coupling of a group: springs, air on sheets, mutual gravity.

use super::pull::{SpringRow, Springs};
use super::rows::Row;
use crate::kernels::record::vector;
use crate::laws::{Air, Drag, MutualGravity, PrescribedMotion};
use crate::state::components::AxisLocks;
use crate::units::Vector;

/// A triangle of a sheet between three rows, and its share of their mass, kg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SheetRow {
    pub corners: [u32; 3],
    pub mass: f64,
}

/// Springs, air on sheets and mutual gravity of a group. Its rows are first the movable ones, then the anchors.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Coupling {
    /// The number of rows, anchors included.
    pub rows: usize,
    /// The number of movable rows, which come first.
    pub movable: usize,
    /// Springs.
    pub springs: Springs,
    /// Triangles that air acts on.
    pub sheets: Vec<SheetRow>,
    /// Masses of the movable rows, kg, if there are triangles.
    pub masses: Vec<f64>,
    /// Rows in triangles, ascending: no other drag acts on them.
    pub in_sheets: Vec<u32>,
    /// Whether all rows attract each other.
    pub attracts: bool,
    /// Masses of the anchors as sources of gravity, kg; 0 for none.
    pub sources: Vec<f64>,
    /// The anchors that follow a prescribed motion, by row.
    pub motions: Vec<(usize, PrescribedMotion)>,
}

/// Whether a row with these locks moves along an axis.
pub(crate) fn is_open(locks: Option<AxisLocks>, axis: usize) -> bool {
    locks.is_none_or(|locks| ![locks.x, locks.y, locks.z][axis])
}

#[inline(always)]
pub(super) fn add(row: &mut Row, v: Vector) {
    let [x, y, z] = v.to_array();
    row[0] += x;
    row[1] += y;
    row[2] += z;
}

/// `c + k |u| + k (u·n)² / |u|`, 1/s: the derivative of the drag on a triangle with normal n by its velocity u along
/// n.
pub(super) fn rate_along(drag: &Drag, u: Vector, n: Vector) -> f64 {
    // The limit of (u·n)² / |u| in still air is 0.
    let (across, speed) = (u.dot(n), u.dot(u).sqrt());
    let across = if speed > 0.0 { across * across / speed } else { 0.0 };
    drag.rate(u) + drag.quadratic * across
}

/// Velocity of a triangle relative to the air, m/s, and its unit normal; `None` if it has no area.
pub(super) fn in_air(
    air: Option<&Air>,
    corners: [u32; 3],
    x: &[Row],
    v: &[Row],
) -> Option<(Vector, Vector)> {
    let [a, b, c] = corners.map(|corner| vector(&x[corner as usize]));
    let ([px, py, pz], [qx, qy, qz]) = ((b - a).to_array(), (c - a).to_array());
    let normal = Vector::from_array([py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx]);
    let length = normal.dot(normal).sqrt();
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    let third = 1.0 / 3.0;
    let mean = |rows: &[Row]| {
        let [a, b, c] = corners.map(|corner| vector(&rows[corner as usize]));
        (a + b + c) * third
    };
    let mut u = mean(v);
    if let Some(air) = air {
        u -= air.at(mean(x));
    }
    Some((u, normal * (1.0 / length)))
}

impl Coupling {
    /// Adds the forces of air on sheets, N: the drag on a point of the same mass, its part along the normal, a third
    /// to each corner.
    pub fn blow(&self, drag: &Drag, time: f64, x: &[Row], v: &[Row], forces: &mut [Row]) {
        let air = drag.wind.map(|wind| wind.air(time));
        for SheetRow { corners, mass } in &self.sheets {
            if let Some((u, n)) = in_air(air.as_ref(), *corners, x, v) {
                let force = n * (-(*mass * drag.rate(u) * u.dot(n)) * (1.0 / 3.0));
                corners.iter().for_each(|corner| add(&mut forces[*corner as usize], force));
            }
        }
    }

    /// Force of mutual gravity on the first of two rows, N; `None` at the same position.
    pub fn attraction_between(
        &self,
        law: &MutualGravity,
        [row, other]: [usize; 2],
        x: &[Row],
        w: &[f64],
    ) -> Option<Vector> {
        let (r, inverse) = self.reach(law, vector(&x[row]), vector(&x[other]))?;
        let masses = law.constant * self.mass(row, w) * self.mass(other, w);
        Some(r * (masses * inverse * inverse * inverse))
    }

    /// The gravitational parameter mu of the motion of two rows relative to each other, m³/s²: `G (m1 + m2)`, where a mass
    /// counts only if the other row is movable.
    pub fn pair_strength(&self, law: &MutualGravity, rows: [usize; 2], w: &[f64]) -> f64 {
        let [mass, other] = [[0, 1], [1, 0]].map(|[of, by]| {
            let follows = rows[by] < self.movable && w[rows[by]] > 0.0;
            if follows { self.mass(rows[of], w) } else { 0.0 }
        });
        law.constant * (mass + other)
    }

    /// The vector r from one body to another and `(r² + s²)^(-1/2)`; `None` at the same position.
    fn reach(&self, law: &MutualGravity, from: Vector, to: Vector) -> Option<(Vector, f64)> {
        let (r, s) = (to - from, law.softening);
        let squared = r.dot(r);
        (squared > 0.0).then(|| (r, 1.0 / (squared + s * s).sqrt()))
    }

    /// Mass of a row as a source of gravity, kg.
    pub fn mass(&self, row: usize, w: &[f64]) -> f64 {
        match row.checked_sub(self.movable) {
            Some(anchor) => self.sources[anchor],
            None if w[row] > 0.0 => 1.0 / w[row],
            None => 0.0,
        }
    }

    /// Potential energy of springs and mutual gravity at `x`, J.
    pub fn potential_energy(&self, gravity: Option<&MutualGravity>, x: &[Row], w: &[f64]) -> f64 {
        let springs = self.elastic_energy(x);
        gravity.filter(|_| self.attracts).map_or(springs, |law| {
            self.attraction_energies(law, x, w).fold(springs, |sum, (_, energy)| sum + energy)
        })
    }

    /// Potential energy of springs at `x`, J.
    pub fn elastic_energy(&self, x: &[Row]) -> f64 {
        self.elastic_energies(x).fold(0.0, |sum, (_, energy)| sum + energy)
    }

    /// The rows that each spring joins, and its potential energy at `x`, J.
    pub fn elastic_energies(&self, x: &[Row]) -> impl Iterator<Item = ([usize; 2], f64)> {
        self.springs.iter().map(|SpringRow { ends, elastic }| {
            let [a, b] = ends.map(|end| end as usize);
            let d = vector(&x[b]) - vector(&x[a]);
            ([a, b], elastic.energy(d.dot(d).sqrt()))
        })
    }

    /// Every pair of rows whose first is movable, with the potential energy of their mutual gravity at `x`, J. Skips pairs at
    /// the same position.
    pub fn attraction_energies(
        &self,
        law: &MutualGravity,
        x: &[Row],
        w: &[f64],
    ) -> impl Iterator<Item = ([usize; 2], f64)> {
        let pairs = (0..self.movable).flat_map(|a| (a + 1..self.rows).map(move |b| [a, b]));
        pairs.filter_map(move |[a, b]| {
            let (_, inverse) = self.reach(law, vector(&x[a]), vector(&x[b]))?;
            Some(([a, b], -law.constant * self.mass(a, w) * self.mass(b, w) * inverse))
        })
    }

    /// Allocated bytes of the lists.
    pub fn bytes(&self) -> usize {
        let numbers = self.masses.capacity() + self.sources.capacity();
        self.springs.bytes()
            + self.sheets.capacity() * size_of::<SheetRow>()
            + self.in_sheets.capacity() * size_of::<u32>()
            + numbers * size_of::<f64>()
    }

    /// Whether the coupling depends on velocities; `drag` tells whether there is drag.
    pub fn depends_on_velocity(&self, drag: bool) -> bool {
        self.springs.damped() || drag && !self.sheets.is_empty()
    }
}
