//! The numbers that a loop computes in: double precision, single precision, and single precision with compensated sums.

use std::ops::{Add, Mul, Neg, Sub};

use glam::{DVec3, Vec3};
use motion::methods::Space;
use num_traits::Float;

/// A vector that formulas are written in.
pub(crate) trait Vector: Space + Neg<Output = Self> {
    /// A component.
    type Number: Float;

    fn of(vector: DVec3) -> Self;
    fn dot(self, other: Self) -> Self::Number;
    fn times(self, factor: Self::Number) -> Self;
    fn map(self, change: impl Fn(Self::Number) -> Self::Number) -> Self;
    fn to_double(self) -> DVec3;

    /// A number of a formula, rounded to nearest.
    #[inline(always)]
    fn number(number: f64) -> Self::Number {
        <Self::Number as num_traits::NumCast>::from(number).expect("every number has a nearest one")
    }
}

impl Vector for DVec3 {
    type Number = f64;

    #[inline(always)]
    fn of(vector: DVec3) -> Self {
        vector
    }

    #[inline(always)]
    fn dot(self, other: Self) -> f64 {
        self.dot(other)
    }

    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        self * factor
    }

    #[inline(always)]
    fn map(self, change: impl Fn(f64) -> f64) -> Self {
        Self::from_array(self.to_array().map(change))
    }

    #[inline(always)]
    fn to_double(self) -> DVec3 {
        self
    }
}

/// A vector of single precision.
#[derive(Clone, Copy, Default)]
pub(super) struct Single(Vec3);

impl Add for Single {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Single {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Neg for Single {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Mul<f64> for Single {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self(self.0 * factor as f32)
    }
}

impl Vector for Single {
    type Number = f32;

    #[inline(always)]
    fn of(vector: DVec3) -> Self {
        Self(vector.as_vec3())
    }

    #[inline(always)]
    fn dot(self, other: Self) -> f32 {
        self.0.dot(other.0)
    }

    #[inline(always)]
    fn times(self, factor: f32) -> Self {
        Self(self.0 * factor)
    }

    #[inline(always)]
    fn map(self, change: impl Fn(f32) -> f32) -> Self {
        Self(Vec3::from_array(self.0.to_array().map(change)))
    }

    #[inline(always)]
    fn to_double(self) -> DVec3 {
        self.0.as_dvec3()
    }
}

/// A sum of single precision and its rounding error so far.
#[derive(Clone, Copy, Default)]
pub(super) struct Compensated {
    sum: Single,
    residue: Single,
}

/// `a + b` and its exact rounding error (Knuth 1969, section 4.2.2).
#[inline(always)]
fn two_sum(a: Single, b: Single) -> (Single, Single) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

impl Add for Compensated {
    type Output = Self;

    /// Kahan 1965; Neumaier 1974. The residue is at most half a rounding of the sum.
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (sum, lost) = two_sum(self.sum, other.sum);
        let residue = self.residue + other.residue + lost;
        let total = sum + residue;
        Self { sum: total, residue: residue - (total - sum) }
    }
}

impl Sub for Compensated {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + Self { sum: -other.sum, residue: -other.residue }
    }
}

impl Mul<f64> for Compensated {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self { sum: self.sum * factor, residue: self.residue * factor }
    }
}

/// The space of the states of a loop, and how they lie in memory.
pub(super) trait LoopSpace: Space + Default + Send + 'static {
    /// What formulas see of a state.
    type Seen: Vector;
    /// Arrays of one number of every body each.
    type Columns: Default + Send;
    /// The same arrays, known to be equally long.
    type Rows<'a>;

    fn of(seen: Self::Seen) -> Self;
    fn seen(self) -> Self::Seen;
    fn push(self, columns: &mut Self::Columns);
    fn rows(columns: &mut Self::Columns, n: usize) -> Self::Rows<'_>;
    fn get(rows: &Self::Rows<'_>, i: usize) -> Self;
    fn set(self, rows: &mut Self::Rows<'_>, i: usize);
}

impl LoopSpace for DVec3 {
    type Seen = Self;
    type Columns = [Vec<f64>; 3];
    type Rows<'a> = [&'a mut [f64]; 3];

    #[inline(always)]
    fn of(seen: Self) -> Self {
        seen
    }

    #[inline(always)]
    fn seen(self) -> Self {
        self
    }

    fn push(self, columns: &mut Self::Columns) {
        columns.iter_mut().zip(self.to_array()).for_each(|(column, number)| column.push(number));
    }

    fn rows(columns: &mut Self::Columns, n: usize) -> Self::Rows<'_> {
        columns.each_mut().map(|column| &mut column[..n])
    }

    #[inline(always)]
    fn get([x, y, z]: &Self::Rows<'_>, i: usize) -> Self {
        Self::new(x[i], y[i], z[i])
    }

    #[inline(always)]
    fn set(self, [x, y, z]: &mut Self::Rows<'_>, i: usize) {
        (x[i], y[i], z[i]) = (self.x, self.y, self.z);
    }
}

impl LoopSpace for Single {
    type Seen = Self;
    type Columns = [Vec<f32>; 3];
    type Rows<'a> = [&'a mut [f32]; 3];

    #[inline(always)]
    fn of(seen: Self) -> Self {
        seen
    }

    #[inline(always)]
    fn seen(self) -> Self {
        self
    }

    fn push(self, columns: &mut Self::Columns) {
        columns.iter_mut().zip(self.0.to_array()).for_each(|(column, number)| column.push(number));
    }

    fn rows(columns: &mut Self::Columns, n: usize) -> Self::Rows<'_> {
        columns.each_mut().map(|column| &mut column[..n])
    }

    #[inline(always)]
    fn get([x, y, z]: &Self::Rows<'_>, i: usize) -> Self {
        Self(Vec3::new(x[i], y[i], z[i]))
    }

    #[inline(always)]
    fn set(self, [x, y, z]: &mut Self::Rows<'_>, i: usize) {
        (x[i], y[i], z[i]) = (self.0.x, self.0.y, self.0.z);
    }
}

impl LoopSpace for Compensated {
    type Seen = Single;
    type Columns = [<Single as LoopSpace>::Columns; 2];
    type Rows<'a> = [<Single as LoopSpace>::Rows<'a>; 2];

    #[inline(always)]
    fn of(seen: Single) -> Self {
        Self { sum: seen, residue: Single::default() }
    }

    #[inline(always)]
    fn seen(self) -> Single {
        self.sum
    }

    fn push(self, [sums, residues]: &mut Self::Columns) {
        self.sum.push(sums);
        self.residue.push(residues);
    }

    fn rows(columns: &mut Self::Columns, n: usize) -> Self::Rows<'_> {
        columns.each_mut().map(|columns| Single::rows(columns, n))
    }

    #[inline(always)]
    fn get([sums, residues]: &Self::Rows<'_>, i: usize) -> Self {
        Self { sum: Single::get(sums, i), residue: Single::get(residues, i) }
    }

    #[inline(always)]
    fn set(self, [sums, residues]: &mut Self::Rows<'_>, i: usize) {
        self.sum.set(sums, i);
        self.residue.set(residues, i);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single(number: f64) -> Single {
        <Single as Vector>::of(DVec3::splat(number))
    }

    #[test]
    fn nothing_is_lost_of_a_sum() {
        for (a, b) in [(1.0, 1e-9), (1e-9, 1.0), (3.0e7, -3.3), (0.1, 0.2), (-5.0, 5.0)] {
            let (a, b) = (single(a), single(b));
            let (sum, lost) = two_sum(a, b);
            assert_eq!(sum.0, a.0 + b.0);
            assert_eq!(sum.to_double() + lost.to_double(), a.to_double() + b.to_double());
        }
    }

    #[test]
    fn small_increments_are_added_up() {
        let (mut plain, mut sum) = (single(1.0), Compensated::of(single(1.0)));
        for _ in 0..1_000_000 {
            plain = plain + single(1e-8);
            sum = sum + Compensated::of(single(1e-8));
        }
        assert_eq!(plain.to_double(), DVec3::ONE);
        let off = (sum.seen().to_double() - DVec3::splat(1.01)).abs().max_element();
        assert!(off <= f32::EPSILON.into(), "{off}");
    }
}
