//! Arrays of rows aligned to cache lines.

use std::fmt;
use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

use crate::real::Real;
use crate::units::{Scalar, Vector};

/// (x, y, z, 0).
pub(crate) type Row<T> = [T; 4];

/// The row of a vector.
pub(crate) fn row_of(v: Vector) -> Row<Scalar> {
    [v.x, v.y, v.z, 0.0]
}

/// A cache line.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// An array of rows of which none crosses a cache line: loads and stores of those take twice as long.
pub(crate) struct RowArray<T> {
    lines: Vec<Line>,
    rows: usize,
    of: std::marker::PhantomData<T>,
}

impl<T: Real> RowArray<T> {
    /// Sets the length to `rows`; new rows have arbitrary content. Never frees memory.
    pub fn resize(&mut self, rows: usize) {
        let lines = (rows * size_of::<Row<T>>()).div_ceil(size_of::<Line>());
        if lines > self.lines.len() {
            self.lines.resize(lines, Line([0; 64]));
        }
        self.rows = rows;
    }

    /// Copies `rows`.
    pub fn copy(&mut self, rows: &[Row<T>]) {
        self.resize(rows.len());
        self.copy_from_slice(rows);
    }
}

impl<T> Default for RowArray<T> {
    fn default() -> Self {
        Self { lines: Vec::new(), rows: 0, of: std::marker::PhantomData }
    }
}

impl<T: Real> Deref for RowArray<T> {
    type Target = [Row<T>];

    #[inline(always)]
    fn deref(&self) -> &[Row<T>] {
        let numbers: &[T] = bytemuck::cast_slice(&self.lines);
        &numbers.as_chunks().0[..self.rows]
    }
}

impl<T: Real> DerefMut for RowArray<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Row<T>] {
        let numbers: &mut [T] = bytemuck::cast_slice_mut(&mut self.lines);
        &mut numbers.as_chunks_mut().0[..self.rows]
    }
}

impl<T: Real> fmt::Debug for RowArray<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}
