//! Blocks of bodies as structures of arrays, as a space for methods.

use std::any::Any;
use std::ops::{Add, Mul, Sub};

use super::Row;
use crate::laws::Axes;
use crate::real::Real;

/// x, y and z of `N` bodies.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Block<T, const N: usize>(pub [[T; N]; 3]);

impl<T: Real, const N: usize> Block<T, N> {
    pub const ZERO: Self = Self([[T::ZERO; N]; 3]);

    /// The first bodies from triples; the others are like the first one, so that no law sees a state that no body has.
    #[inline(always)]
    pub fn of<const M: usize>(rows: &[[T; M]]) -> Self {
        let mut block = Self::ZERO;
        if let Ok(rows) = <&[[T; M]; N]>::try_from(rows) {
            for (k, row) in rows.iter().enumerate() {
                (block.0[0][k], block.0[1][k], block.0[2][k]) = (row[0], row[1], row[2]);
            }
            return block;
        }
        for axis in 0..3 {
            block.0[axis] = [rows[0][axis]; N];
            block.0[axis].iter_mut().zip(rows).for_each(|(lane, row)| *lane = row[axis]);
        }
        block
    }

    /// The numbers of body `k`.
    #[inline(always)]
    pub const fn body(&self, k: usize) -> [T; 3] {
        let [x, y, z] = &self.0;
        [x[k], y[k], z[k]]
    }

    /// All bodies as rows, the fourth number of which is 0.
    pub fn rows(&self) -> [Row<T>; N] {
        std::array::from_fn(|k| {
            let [x, y, z] = self.body(k);
            [x, y, z, T::ZERO]
        })
    }

    /// The block as laws see it, if it has as many bodies as they take.
    #[inline(always)]
    pub fn axes(&self) -> Option<&Axes<T>> {
        (&self.0 as &dyn Any).downcast_ref()
    }

    /// [`Block::axes`] to write to.
    #[inline(always)]
    pub fn axes_mut(&mut self) -> Option<&mut Axes<T>> {
        (&mut self.0 as &mut dyn Any).downcast_mut()
    }

    /// Changes every number by `change`, which gets its axis and body.
    #[inline(always)]
    pub fn map(mut self, change: impl Fn(usize, usize, T) -> T) -> Self {
        for axis in 0..3 {
            for k in 0..N {
                self.0[axis][k] = change(axis, k, self.0[axis][k]);
            }
        }
        self
    }
}

impl<T: Real, const N: usize> Add for Block<T, N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.map(|axis, k, number| number + other.0[axis][k])
    }
}

impl<T: Real, const N: usize> Sub for Block<T, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.map(|axis, k, number| number - other.0[axis][k])
    }
}

impl<T: Real, const N: usize> Mul<T> for Block<T, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        self.map(|_, _, number| number * factor)
    }
}
