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

    fn of(seen: Self::Seen) -> Self;
    fn seen(self) -> Self::Seen;
    fn push(self, columns: &mut Self::Columns);
    fn get(columns: &Self::Columns, i: usize) -> Self;
    /// Changes `x` and `v` of every body by `step`, which also gets `field`.
    fn each<F>(
        columns: [&mut Self::Columns; 2],
        field: F,
        step: impl Fn(&mut F, [Self; 2]) -> [Self; 2],
    ) -> F;
    /// Changes `x`, `v` and `a` of every body.
    fn each_with<F>(
        columns: [&mut Self::Columns; 3],
        field: F,
        step: impl Fn(&mut F, [Self; 3]) -> [Self; 3],
    ) -> F;
}

/// x, y and z of every body.
type Three<T> = [Vec<T>; 3];

/// A step of every body, whose position and velocity are three numbers each.
///
/// Six arrays are six arguments of a function that is not inlined, so the compiler knows that they do not overlap; the field
/// is moved in and out, so that it is in registers. Otherwise it would be luck whether vector instructions are taken.
#[expect(clippy::too_many_arguments, reason = "an argument is known not to overlap with another one")]
#[inline(never)]
fn step_six<T: Copy, F>(
    x: &mut [T],
    y: &mut [T],
    z: &mut [T],
    a: &mut [T],
    b: &mut [T],
    c: &mut [T],
    mut field: F,
    step: impl Fn(&mut F, [[T; 3]; 2]) -> [[T; 3]; 2],
) -> F {
    let n = x.len();
    let (y, z, a, b, c) = (&mut y[..n], &mut z[..n], &mut a[..n], &mut b[..n], &mut c[..n]);
    for i in 0..n {
        [[x[i], y[i], z[i]], [a[i], b[i], c[i]]] = step(&mut field, [[x[i], y[i], z[i]], [a[i], b[i], c[i]]]);
    }
    field
}

/// [`step_six`] of nine arrays.
#[expect(clippy::too_many_arguments, reason = "an argument is known not to overlap with another one")]
#[inline(never)]
fn step_nine<T: Copy, F>(
    x: &mut [T],
    y: &mut [T],
    z: &mut [T],
    a: &mut [T],
    b: &mut [T],
    c: &mut [T],
    d: &mut [T],
    e: &mut [T],
    f: &mut [T],
    mut field: F,
    step: impl Fn(&mut F, [[T; 3]; 3]) -> [[T; 3]; 3],
) -> F {
    let n = x.len();
    let (y, z, a, b, c) = (&mut y[..n], &mut z[..n], &mut a[..n], &mut b[..n], &mut c[..n]);
    let (d, e, f) = (&mut d[..n], &mut e[..n], &mut f[..n]);
    for i in 0..n {
        [[x[i], y[i], z[i]], [a[i], b[i], c[i]], [d[i], e[i], f[i]]] =
            step(&mut field, [[x[i], y[i], z[i]], [a[i], b[i], c[i]], [d[i], e[i], f[i]]]);
    }
    field
}

macro_rules! in_three_columns {
    ($space:ty, $number:ty, $of:expr, $numbers:expr) => {
        impl LoopSpace for $space {
            type Seen = Self;
            type Columns = Three<$number>;

            #[inline(always)]
            fn of(seen: Self) -> Self {
                seen
            }

            #[inline(always)]
            fn seen(self) -> Self {
                self
            }

            fn push(self, columns: &mut Self::Columns) {
                columns.iter_mut().zip($numbers(self)).for_each(|(column, number)| column.push(number));
            }

            fn get([x, y, z]: &Self::Columns, i: usize) -> Self {
                $of([x[i], y[i], z[i]])
            }

            fn each<F>(
                [[x, y, z], [a, b, c]]: [&mut Self::Columns; 2],
                field: F,
                step: impl Fn(&mut F, [Self; 2]) -> [Self; 2],
            ) -> F {
                let step = |field: &mut F, body: [[$number; 3]; 2]| step(field, body.map($of)).map($numbers);
                step_six(x, y, z, a, b, c, field, step)
            }

            fn each_with<F>(
                [[x, y, z], [a, b, c], [d, e, f]]: [&mut Self::Columns; 3],
                field: F,
                step: impl Fn(&mut F, [Self; 3]) -> [Self; 3],
            ) -> F {
                let step = |field: &mut F, body: [[$number; 3]; 3]| step(field, body.map($of)).map($numbers);
                step_nine(x, y, z, a, b, c, d, e, f, field, step)
            }
        }
    };
}

in_three_columns!(DVec3, f64, DVec3::from_array, |vector: DVec3| vector.to_array());
in_three_columns!(Single, f32, |numbers| Single(Vec3::from_array(numbers)), |Single(vector)| vector
    .to_array());

impl LoopSpace for Compensated {
    type Seen = Single;
    type Columns = Vec<Self>;

    #[inline(always)]
    fn of(seen: Single) -> Self {
        Self { sum: seen, residue: Single::default() }
    }

    #[inline(always)]
    fn seen(self) -> Single {
        self.sum
    }

    fn push(self, column: &mut Self::Columns) {
        column.push(self);
    }

    fn get(column: &Self::Columns, i: usize) -> Self {
        column[i]
    }

    fn each<F>(
        [x, v]: [&mut Self::Columns; 2],
        mut field: F,
        step: impl Fn(&mut F, [Self; 2]) -> [Self; 2],
    ) -> F {
        x.iter_mut().zip(v).for_each(|(x, v)| [*x, *v] = step(&mut field, [*x, *v]));
        field
    }

    fn each_with<F>(
        [x, v, a]: [&mut Self::Columns; 3],
        mut field: F,
        step: impl Fn(&mut F, [Self; 3]) -> [Self; 3],
    ) -> F {
        let all = x.iter_mut().zip(v).zip(a);
        all.for_each(|((x, v), a)| [*x, *v, *a] = step(&mut field, [*x, *v, *a]));
        field
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
