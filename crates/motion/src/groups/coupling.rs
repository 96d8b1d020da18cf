//! The coupling of a group: springs, air on sheets, mutual gravity.

use super::pull::{SpringRow, Springs};
use super::rows::Row;
use crate::laws::{Air, Drag, MutualGravity};
use crate::real::{Real, RealVector};
use crate::state::components::AxisLocks;

/// A triangle of a sheet between three rows, and its share of their mass, kg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SheetRow<T> {
    pub corners: [u32; 3],
    pub mass: T,
}

/// What acts between the rows of a group: first the movable rows, then the anchors.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Coupling<T> {
    /// The number of rows, anchors included.
    pub rows: usize,
    /// The number of movable rows, which come first.
    pub movable: usize,
    /// Springs.
    pub springs: Springs<T>,
    /// Triangles that air acts on.
    pub sheets: Vec<SheetRow<T>>,
    /// Masses of the movable rows, kg, if there are triangles.
    pub masses: Vec<T>,
    /// Rows in triangles, ascending: no other drag acts on them.
    pub in_sheets: Vec<u32>,
    /// Whether all rows attract each other.
    pub attracts: bool,
    /// Masses of the anchors as sources of gravity, kg; 0 for none.
    pub sources: Vec<T>,
}

/// Whether a row with these locks moves along an axis.
pub(crate) fn is_open(locks: Option<AxisLocks>, axis: usize) -> bool {
    locks.is_none_or(|locks| ![locks.x, locks.y, locks.z][axis])
}

#[inline(always)]
pub(super) fn vector<T: Real>(row: &Row<T>) -> T::Vector {
    T::Vector::from_array([row[0], row[1], row[2]])
}

#[inline(always)]
pub(super) fn add<T: Real>(row: &mut Row<T>, v: T::Vector) {
    let [x, y, z] = v.to_array();
    row[0] += x;
    row[1] += y;
    row[2] += z;
}

/// `c + k |u| + k (u·n)² / |u|`, 1/s: the derivative of the drag on a triangle with normal n by its velocity u along
/// n.
pub(super) fn rate_along<T: Real>(drag: &Drag, u: T::Vector, n: T::Vector) -> T {
    // The limit of (u·n)² / |u| in still air is 0.
    let (across, speed) = (u.dot(n), u.dot(u).sqrt());
    let across = if speed > T::ZERO { across * across / speed } else { T::ZERO };
    drag.rate::<T>(u) + T::of(drag.quadratic) * across
}

/// Velocity of a triangle relative to the air, m/s, and its unit normal; `None` if it has no area.
pub(super) fn in_air<T: Real>(
    air: Option<&Air<T>>,
    corners: [u32; 3],
    x: &[Row<T>],
    v: &[Row<T>],
) -> Option<(T::Vector, T::Vector)> {
    let [a, b, c] = corners.map(|corner| vector(&x[corner as usize]));
    let ([px, py, pz], [qx, qy, qz]) = ((b - a).to_array(), (c - a).to_array());
    let normal = T::Vector::from_array([py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx]);
    let length = normal.dot(normal).sqrt();
    if !(length > T::ZERO && length.is_finite()) {
        return None;
    }
    let third = T::of(1.0 / 3.0);
    let mean = |rows: &[Row<T>]| {
        let [a, b, c] = corners.map(|corner| vector(&rows[corner as usize]));
        (a + b + c) * third
    };
    let mut u = mean(v);
    if let Some(air) = air {
        u = u - air.at(mean(x));
    }
    Some((u, normal * (T::ONE / length)))
}

impl<T: Real> Coupling<T> {
    /// Adds the forces of air on sheets, N: the drag on a point of the same mass, its part along the normal, a third
    /// to each corner.
    pub fn blow(&self, drag: &Drag, time: T, x: &[Row<T>], v: &[Row<T>], forces: &mut [Row<T>]) {
        let air = drag.wind.map(|wind| wind.air(time));
        for SheetRow { corners, mass } in &self.sheets {
            if let Some((u, n)) = in_air(air.as_ref(), *corners, x, v) {
                let force = n * (-(*mass * drag.rate(u) * u.dot(n)) * T::of(1.0 / 3.0));
                corners.iter().for_each(|corner| add(&mut forces[*corner as usize], force));
            }
        }
    }

    /// Force of mutual gravity on the first of two masses, N; `None` at the same position.
    #[inline(always)]
    fn attraction(
        &self,
        law: &MutualGravity,
        [mass, other]: [T; 2],
        [from, to]: [T::Vector; 2],
    ) -> Option<T::Vector> {
        let (r, inverse) = self.reach(law, from, to)?;
        Some(r * (T::of(law.constant) * mass * other * inverse * inverse * inverse))
    }

    /// Force of mutual gravity on the first of two rows, N; `None` at the same position.
    pub fn attraction_between(
        &self,
        law: &MutualGravity,
        rows: [usize; 2],
        x: &[Row<T>],
        w: &[T],
    ) -> Option<T::Vector> {
        self.attraction(law, rows.map(|row| self.mass(row, w)), rows.map(|row| vector(&x[row])))
    }

    /// Square of the angular frequency, 1/s², at which two rows would orbit each other at their distance; 0 at the same
    /// position.
    pub fn squared_frequency(&self, law: &MutualGravity, rows: [usize; 2], x: &[Row<T>], w: &[T]) -> T {
        let [from, to] = rows.map(|row| vector(&x[row]));
        // A row that does not move follows no other.
        let [mass, other] = [[0, 1], [1, 0]].map(|[of, by]| {
            let follows = rows[by] < self.movable && w[rows[by]] > T::ZERO;
            if follows { self.mass(rows[of], w) } else { T::ZERO }
        });
        self.reach(law, from, to).map_or(T::ZERO, |(_, inverse)| {
            T::of(law.constant) * (mass + other) * inverse * inverse * inverse
        })
    }

    /// The vector r from one body to another and `(r² + s²)^(-1/2)`; `None` at the same position.
    fn reach(&self, law: &MutualGravity, from: T::Vector, to: T::Vector) -> Option<(T::Vector, T)> {
        let (r, s) = (to - from, T::of(law.softening));
        let squared = r.dot(r);
        (squared > T::ZERO).then(|| (r, T::ONE / (squared + s * s).sqrt()))
    }

    /// Mass of a row as a source of gravity, kg.
    pub fn mass(&self, row: usize, w: &[T]) -> T {
        match row.checked_sub(self.movable) {
            Some(anchor) => self.sources[anchor],
            None if w[row] > T::ZERO => T::ONE / w[row],
            None => T::ZERO,
        }
    }

    /// Potential energy of springs and mutual gravity at `x`, J.
    pub fn potential_energy(&self, gravity: Option<&MutualGravity>, x: &[Row<T>], w: &[T]) -> T {
        self.attraction_energy(gravity, x, w, self.elastic_energy(x))
    }

    /// Potential energy of springs at `x`, J.
    pub fn elastic_energy(&self, x: &[Row<T>]) -> T {
        let mut sum = T::ZERO;
        for SpringRow { ends: [a, b], elastic } in self.springs.iter() {
            let d = vector(&x[b as usize]) - vector(&x[a as usize]);
            let stretch = d.dot(d).sqrt() - elastic.rest_length;
            sum += T::of(0.5) * elastic.stiffness * stretch * stretch;
        }
        sum
    }

    /// `sum` and the potential energy of mutual gravity at `x`, J.
    pub fn attraction_energy(&self, gravity: Option<&MutualGravity>, x: &[Row<T>], w: &[T], mut sum: T) -> T {
        if let (true, Some(law)) = (self.attracts, gravity) {
            for a in 0..self.movable {
                for b in a + 1..self.rows {
                    if let Some((_, inverse)) = self.reach(law, vector(&x[a]), vector(&x[b])) {
                        sum = sum - T::of(law.constant) * self.mass(a, w) * self.mass(b, w) * inverse;
                    }
                }
            }
        }
        sum
    }

    /// The same coupling in another precision.
    pub fn at<U: Real>(&self) -> Coupling<U> {
        let numbers = |numbers: &[T]| numbers.iter().map(|number| U::of(number.to_f64())).collect();
        let Self { rows, movable, springs, sheets, masses, in_sheets, attracts, sources } = self;
        let sheet =
            |sheet: &SheetRow<T>| SheetRow { corners: sheet.corners, mass: U::of(sheet.mass.to_f64()) };
        Coupling {
            rows: *rows,
            movable: *movable,
            springs: springs.at(),
            sheets: sheets.iter().map(sheet).collect(),
            masses: numbers(masses),
            in_sheets: in_sheets.clone(),
            attracts: *attracts,
            sources: numbers(sources),
        }
    }

    /// Bytes of its lists.
    pub fn bytes(&self) -> usize {
        let numbers = self.masses.capacity() + self.sources.capacity();
        self.springs.bytes()
            + self.sheets.capacity() * size_of::<SheetRow<T>>()
            + self.in_sheets.capacity() * size_of::<u32>()
            + numbers * size_of::<T>()
    }

    /// Whether the coupling depends on velocities; `drag` tells whether there is drag.
    pub fn depends_on_velocity(&self, drag: bool) -> bool {
        self.springs.damped() || drag && !self.sheets.is_empty()
    }
}
