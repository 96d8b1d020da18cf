//! Arrays of rows aligned to cache lines, in the two layouts in which groups are integrated.

use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

use crate::laws::{Axes, BLOCK_BODIES};
use crate::units::Vector;

/// (x, y, z, 0).
pub(crate) type Row = [f64; 4];

/// The row of a vector.
pub(crate) fn row_of(v: Vector) -> Row {
    [v.x, v.y, v.z, 0.0]
}

/// An element of an array: the row of one group, or the same row of several groups side by side.
pub(crate) trait Element: Pod + Default + Send + Sync {
    /// The number of groups.
    const LANES: usize;

    /// Element and lane of a row of a group, where each row has `width` elements.
    #[inline(always)]
    fn place(width: usize, row: usize, group: usize) -> (usize, usize) {
        (row * width + group / Self::LANES, group % Self::LANES)
    }

    /// The numbers of all groups along an axis.
    fn axis(&self, axis: usize) -> &[f64];

    /// [`Element::axis`] to write to.
    fn axis_mut(&mut self, axis: usize) -> &mut [f64];

    /// The row of one group.
    #[inline(always)]
    fn row(&self, lane: usize) -> Row {
        [self.axis(0)[lane], self.axis(1)[lane], self.axis(2)[lane], 0.0]
    }

    /// Sets the row of one group.
    #[inline(always)]
    fn set_row(&mut self, lane: usize, [x, y, z, _]: Row) {
        (self.axis_mut(0)[lane], self.axis_mut(1)[lane], self.axis_mut(2)[lane]) = (x, y, z);
    }
}

impl Element for Row {
    const LANES: usize = 1;

    #[inline(always)]
    fn axis(&self, axis: usize) -> &[f64] {
        std::slice::from_ref(&self[axis])
    }

    #[inline(always)]
    fn axis_mut(&mut self, axis: usize) -> &mut [f64] {
        std::slice::from_mut(&mut self[axis])
    }
}

impl Element for Axes {
    const LANES: usize = BLOCK_BODIES;

    #[inline(always)]
    fn axis(&self, axis: usize) -> &[f64] {
        &self[axis]
    }

    #[inline(always)]
    fn axis_mut(&mut self, axis: usize) -> &mut [f64] {
        &mut self[axis]
    }
}

/// Whether rows do not move, given their velocities.
pub(crate) fn are_at_rest(velocities: &[Row]) -> bool {
    velocities.iter().all(|[x, y, z, _]| [*x, *y, *z] == [0.0; 3])
}

/// All numbers of an array.
#[inline(always)]
pub(super) fn numbers<E: Element>(elements: &[E]) -> &[f64] {
    bytemuck::cast_slice(elements)
}

/// [`numbers`] to write to.
#[inline(always)]
pub(super) fn numbers_mut<E: Element>(elements: &mut [E]) -> &mut [f64] {
    bytemuck::cast_slice_mut(elements)
}

/// A cache line.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// An array of elements that begins at a cache line: rows then never cross one, which would take loads and stores twice
/// as long.
pub(crate) struct Array<E> {
    lines: Vec<Line>,
    len: usize,
    element: PhantomData<E>,
}

/// An array of rows of one group.
pub(crate) type RowArray = Array<Row>;

impl<E> Default for Array<E> {
    fn default() -> Self {
        Self { lines: Vec::new(), len: 0, element: PhantomData }
    }
}

impl<E: Element> Array<E> {
    /// Sets the length to `len`; new elements have arbitrary content. Never frees memory.
    pub fn resize(&mut self, len: usize) {
        let lines = (len * size_of::<E>()).div_ceil(size_of::<Line>());
        if lines > self.lines.len() {
            self.lines.resize(lines, Line([0; 64]));
        }
        self.len = len;
    }

    /// Copies `elements`.
    pub fn copy(&mut self, elements: &[E]) {
        self.resize(elements.len());
        self.copy_from_slice(elements);
    }
}

impl<E: Element> Deref for Array<E> {
    type Target = [E];

    #[inline(always)]
    fn deref(&self) -> &[E] {
        // Not all of the bytes: a cast needs a whole number of elements.
        let bytes: &[u8] = bytemuck::cast_slice(&self.lines);
        bytemuck::cast_slice(&bytes[..self.len * size_of::<E>()])
    }
}

impl<E: Element> DerefMut for Array<E> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [E] {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut self.lines);
        bytemuck::cast_slice_mut(&mut bytes[..self.len * size_of::<E>()])
    }
}

impl<E: Element + fmt::Debug> fmt::Debug for Array<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}
