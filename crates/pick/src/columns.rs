//! The columns that change every frame: drawn positions in f32, relative to the anchor.

use bevy_ecs::entity::Entity;
use glam::{DVec3, Vec3};
use motion::{PreviousPosition, Transform};

use crate::dispatch::dispatched;
use crate::scan::{BLOCK, Balls};

/// Positions and bounding radii as structure of arrays, padded to whole blocks with balls that nothing meets.
#[derive(Debug, Default)]
pub(crate) struct Columns {
    len: usize,
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    radius: Vec<f32>,
}

/// A run of rows of the position columns, all of one length.
pub(crate) struct Positions<'a> {
    pub(crate) x: &'a mut [f32],
    pub(crate) y: &'a mut [f32],
    pub(crate) z: &'a mut [f32],
}

impl Columns {
    pub(crate) fn resize(&mut self, len: usize) {
        let padded = len.next_multiple_of(BLOCK);
        for column in [&mut self.x, &mut self.y, &mut self.z, &mut self.radius] {
            column.truncate(len);
            column.resize(padded, f32::NAN);
        }
        self.len = len;
    }

    pub(crate) fn set_radius(&mut self, row: usize, radius: f32) {
        self.radius[row] = radius;
    }

    pub(crate) fn positions(&self) -> (&[f32], &[f32], &[f32]) {
        (&self.x[..self.len], &self.y[..self.len], &self.z[..self.len])
    }

    pub(crate) fn center(&self, row: usize) -> Vec3 {
        Vec3::new(self.x[row], self.y[row], self.z[row])
    }

    pub(crate) fn rows_mut(&mut self, from: usize, to: usize) -> Positions<'_> {
        Positions { x: &mut self.x[from..to], y: &mut self.y[from..to], z: &mut self.z[from..to] }
    }

    pub(crate) fn balls(&self) -> Balls<'_> {
        let [x, y, z, radius] = [&self.x, &self.y, &self.z, &self.radius].map(|c| c.as_chunks().0);
        Balls { x, y, z, radius }
    }
}

/// Drawn position of one row, world space, m.
#[inline(always)]
fn drawn(current: &Transform, previous: &PreviousPosition, alpha: f64) -> DVec3 {
    previous.0 + (current.position - previous.0) * alpha
}

/// The rows to write: a run of rows of one table.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a> {
    pub(crate) transforms: &'a [Transform],
    pub(crate) previous: Option<&'a [PreviousPosition]>,
}

impl Rows<'_> {
    /// Drawn position of `row`, world space, m.
    pub(crate) fn drawn(&self, row: usize, alpha: f64) -> DVec3 {
        let current = &self.transforms[row];
        self.previous.map_or(current.position, |previous| drawn(current, &previous[row], alpha))
    }
}

/// Parameters of a write.
#[derive(Clone, Copy)]
pub(crate) struct Writing {
    /// How far from the previous to the current position things are drawn.
    pub(crate) alpha: f64,
    /// Anchor of the positions that are in the columns before the write, m.
    pub(crate) old_anchor: DVec3,
    /// Anchor of the positions to write, m.
    pub(crate) anchor: DVec3,
    /// Number of moved things above which counting stops; `None` to count none.
    pub(crate) enough: Option<usize>,
}

/// Rows between two checks of whether enough have been counted.
const STRIDE: usize = 256;

dispatched!(write(to: Positions<'_>, rows: Rows<'_>, writing: Writing) -> usize, write_rows);

/// Writes the drawn positions and returns how many of them have moved, or some number above `enough`: counting costs
/// as much as writing, and is not needed if most things move.
///
/// Positions are compared relative to the old anchor. This distinguishes things at rest from moving ones without a second
/// copy of the world, however the camera flies.
#[inline(always)]
fn write_rows(to: Positions<'_>, rows: Rows<'_>, writing: Writing) -> usize {
    let mut moved = 0;
    let columns = to.x.chunks_mut(STRIDE).zip(to.y.chunks_mut(STRIDE)).zip(to.z.chunks_mut(STRIDE));
    let transforms = rows.transforms.chunks(STRIDE);
    match rows.previous {
        None => {
            for (((x, y), z), transforms) in columns.zip(transforms) {
                let drawn = transforms.iter().map(|t| t.position);
                moved += write_stride(
                    Positions { x, y, z },
                    drawn,
                    writing.enough.is_some_and(|e| moved <= e),
                    writing,
                );
            }
        }
        Some(previous) => {
            let previous = previous.chunks(STRIDE);
            for ((((x, y), z), transforms), previous) in columns.zip(transforms).zip(previous) {
                let drawn =
                    transforms.iter().zip(previous).map(|(t, p)| drawn(t, p, writing.alpha));
                moved += write_stride(
                    Positions { x, y, z },
                    drawn,
                    writing.enough.is_some_and(|e| moved <= e),
                    writing,
                );
            }
        }
    }
    moved
}

#[inline(always)]
fn write_stride(
    to: Positions<'_>,
    from: impl Iterator<Item = DVec3>,
    counting: bool,
    Writing { old_anchor, anchor, .. }: Writing,
) -> usize {
    let rows = to.x.iter_mut().zip(to.y).zip(to.z).zip(from);
    let mut moved = 0;
    if counting {
        for (((x, y), z), position) in rows {
            moved += u32::from(differs((position - old_anchor).as_vec3(), (x, y, z)));
            let is = (position - anchor).as_vec3();
            (*x, *y, *z) = (is.x, is.y, is.z);
        }
    } else {
        for (((x, y), z), position) in rows {
            let is = (position - anchor).as_vec3();
            (*x, *y, *z) = (is.x, is.y, is.z);
        }
    }
    moved as usize
}

/// Number of rows that [`next_moved`] checks together.
pub(crate) const SPAN: usize = 64;

/// Known positions relative to `frame`, a run of rows of a table.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    pub(crate) frame: DVec3,
    pub(crate) x: &'a [f32],
    pub(crate) y: &'a [f32],
    pub(crate) z: &'a [f32],
}

dispatched!(
    next_moved(known: Known<'_>, rows: Rows<'_>, alpha: f64, from: usize) -> Option<usize>,
    next_moved_span
);

/// The first span of [`SPAN`] rows at or after span `from` in which a drawn position differs from the known one.
#[inline(always)]
fn next_moved_span(known: Known<'_>, rows: Rows<'_>, alpha: f64, from: usize) -> Option<usize> {
    let columns = known.x.chunks(SPAN).zip(known.y.chunks(SPAN)).zip(known.z.chunks(SPAN));
    let spans = columns.zip(rows.transforms.chunks(SPAN)).enumerate().skip(from);
    match rows.previous {
        None => {
            for (span, (columns, transforms)) in spans {
                if any_moved(columns, transforms.iter().map(|t| t.position), known.frame) {
                    return Some(span);
                }
            }
        }
        Some(previous) => {
            for ((span, (columns, transforms)), previous) in
                spans.zip(previous.chunks(SPAN).skip(from))
            {
                let drawn = transforms.iter().zip(previous).map(|(t, p)| drawn(t, p, alpha));
                if any_moved(columns, drawn, known.frame) {
                    return Some(span);
                }
            }
        }
    }
    None
}

#[inline(always)]
fn any_moved(
    ((x, y), z): ((&[f32], &[f32]), &[f32]),
    drawn: impl Iterator<Item = DVec3>,
    frame: DVec3,
) -> bool {
    let mut moved = 0_u32;
    for (((x, y), z), position) in x.iter().zip(y).zip(z).zip(drawn) {
        moved += u32::from(differs((position - frame).as_vec3(), (x, y, z)));
    }
    moved != 0
}

/// Whether a position differs from the one in the columns in any bit. By bits, so that a position of NaN can be at rest.
#[inline(always)]
pub(crate) fn differs(is: Vec3, (x, y, z): (&f32, &f32, &f32)) -> bool {
    let off = |a: f32, b: &f32| a.to_bits() ^ b.to_bits();
    off(is.x, x) | off(is.y, y) | off(is.z, z) != 0
}

dispatched!(same(known: &[Entity], now: &[Entity]) -> bool, same_in_full);

/// Whether `known` starts with `now`.
///
/// Does not stop early: comparing everything with vector instructions is faster than stopping at a rare difference.
#[inline(always)]
fn same_in_full(known: &[Entity], now: &[Entity]) -> bool {
    known.iter().zip(now).fold(0, |off, (a, b)| off | (a.to_bits() ^ b.to_bits())) == 0
}
