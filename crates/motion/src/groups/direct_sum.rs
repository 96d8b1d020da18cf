//! The direct sum of mutual gravity, four bodies at a time, on all threads.

use fearless_simd::{Simd, f64x4, prelude::*};

use super::rows::Row;
use crate::laws::MutualGravity;
use crate::simd::{Lanes as _, with_simd};
use crate::state::threads::Threads;

/// Number of bodies whose forces are summed at once.
const AT_ONCE: usize = 4;

/// Number of pairs of a body and a source from which on sharing them among threads is faster.
const SHARED_FROM: usize = 1 << 17;

/// The direct sum over rows that attract each other.
///
/// Each force is computed twice, once per body of a pair: every body sums over the other rows in row order, so the bits do
/// not depend on the vector width or on the threads. The factors of a force are multiplied in the same order both times, so
/// that action and reaction have the same bits.
#[derive(Clone, Copy)]
pub(super) struct DirectSum<'a> {
    pub law: &'a MutualGravity,
    pub x: &'a [Row],
    /// Masses, kg, of every row.
    pub masses: &'a [f64],
}

impl DirectSum<'_> {
    /// Adds the forces on the first rows to `forces`, N.
    pub fn attract(self, threads: Option<&Threads>, forces: &mut [Row]) {
        let threads = threads.filter(|_| forces.len() * self.x.len() >= SHARED_FROM);
        Threads::share(threads, forces, |first, forces| self.attract_from(first, forces));
    }

    /// Adds the forces on the rows from `first` on.
    fn attract_from(self, first: usize, forces: &mut [Row]) {
        with_simd!(simd => self.attract_with(simd, first, forces));
    }

    #[inline(always)]
    fn attract_with<S: Simd>(self, simd: S, first: usize, forces: &mut [Row]) {
        let mut start = first;
        for forces in forces.chunks_mut(AT_ONCE) {
            let end = start + forces.len();
            let mut four = Four::of(simd, self, start, forces);
            for source in 0..start {
                four.add(source, four.masses(source, true));
            }
            for source in start..end {
                let (before, after): ([f64; 4], [f64; 4]) =
                    (four.masses(source, true).into(), four.masses(source, false).into());
                let masses =
                    std::array::from_fn(|k| if source < start + k { before[k] } else { after[k] });
                four.add(source, f64x4::simd_from(simd, masses));
            }
            for source in end..self.x.len() {
                four.add(source, four.masses(source, false));
            }
            // Not by `into`: the compiler would keep the sums in halves of registers.
            let mut columns = [[0.0; AT_ONCE]; 3];
            for (axis, column) in columns.iter_mut().enumerate() {
                four.forces[axis].store_slice(column);
            }
            for (k, force) in forces.iter_mut().enumerate() {
                (0..3).for_each(|axis| force[axis] = columns[axis][k]);
            }
            start = end;
        }
    }
}

/// Four rows, as columns. If there are fewer, the last one fills the other lanes.
struct Four<'a, S: Simd> {
    simd: S,
    all: DirectSum<'a>,
    x: [f64x4<S>; 3],
    masses: f64x4<S>,
    /// G, m³/(kg s²).
    constant: f64x4<S>,
    /// Square of the softening, m².
    softened: f64x4<S>,
    forces: [f64x4<S>; 3],
}

impl<'a, S: Simd> Four<'a, S> {
    /// Loads the rows from `start` on; the sums start at `forces`.
    #[inline(always)]
    fn of(simd: S, all: DirectSum<'a>, start: usize, forces: &[Row]) -> Self {
        let own = |k: usize| k.min(forces.len() - 1);
        let column = |number: &dyn Fn(usize) -> f64| {
            f64x4::simd_from(simd, std::array::from_fn(|k| number(own(k))))
        };
        let softening = all.law.softening;
        Self {
            simd,
            all,
            x: std::array::from_fn(|axis| column(&|k| all.x[start + k][axis])),
            masses: column(&|k| all.masses[start + k]),
            constant: f64x4::splat(simd, all.law.constant),
            softened: f64x4::splat(simd, softening * softening),
            forces: std::array::from_fn(|axis| column(&|k| forces[k][axis])),
        }
    }

    /// Product of G, the mass of the earlier row and that of the later row, in this order. `earlier`: whether the source is the
    /// earlier row.
    #[inline(always)]
    fn masses(&self, source: usize, earlier: bool) -> f64x4<S> {
        let mass = f64x4::splat(self.simd, self.all.masses[source]);
        if earlier {
            self.constant * mass * self.masses
        } else {
            self.constant * self.masses * mass
        }
    }

    /// Adds the forces of a source; `masses` are the products of G and the two masses.
    #[inline(always)]
    fn add(&mut self, source: usize, masses: f64x4<S>) {
        let splat = |number: f64| f64x4::splat(self.simd, number);
        let [x, y, z, _] = self.all.x[source];
        let [x, y, z] = [splat(x) - self.x[0], splat(y) - self.x[1], splat(z) - self.x[2]];
        let squared = x * x + y * y + z * z;
        let inverse = splat(1.0) / (squared + self.softened).sqrt();
        let factor = masses * inverse * inverse * inverse;
        // Bodies at the same position, as a body and itself are, do not attract each other.
        let apart = squared.simd_gt(splat(0.0));
        self.forces[0] += (x * factor).only(apart);
        self.forces[1] += (y * factor).only(apart);
        self.forces[2] += (z * factor).only(apart);
    }
}
