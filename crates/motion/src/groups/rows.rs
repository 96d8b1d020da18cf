//! Arrays of rows aligned to cache lines.

use std::fmt;
use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

use crate::units::Vector;

/// (x, y, z, 0).
pub(crate) type Row = [f64; 4];

/// The row of a vector.
pub(crate) fn row_of(v: Vector) -> Row {
    [v.x, v.y, v.z, 0.0]
}

/// A cache line.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// An array of rows that never cross a cache line: loads and stores across one take twice as long.
#[derive(Default)]
pub(crate) struct RowArray {
    lines: Vec<Line>,
    rows: usize,
}

impl RowArray {
    /// Sets the length to `rows`; new rows have arbitrary content. Never frees memory.
    pub fn resize(&mut self, rows: usize) {
        let lines = (rows * size_of::<Row>()).div_ceil(size_of::<Line>());
        if lines > self.lines.len() {
            self.lines.resize(lines, Line([0; 64]));
        }
        self.rows = rows;
    }

    /// Copies `rows`.
    pub fn copy(&mut self, rows: &[Row]) {
        self.resize(rows.len());
        self.copy_from_slice(rows);
    }
}

impl Deref for RowArray {
    type Target = [Row];

    #[inline(always)]
    fn deref(&self) -> &[Row] {
        let numbers: &[f64] = bytemuck::cast_slice(&self.lines);
        &numbers.as_chunks().0[..self.rows]
    }
}

impl DerefMut for RowArray {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Row] {
        let numbers: &mut [f64] = bytemuck::cast_slice_mut(&mut self.lines);
        &mut numbers.as_chunks_mut().0[..self.rows]
    }
}

impl fmt::Debug for RowArray {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}
