//! The forces of springs, four at a time.

use std::ops::Range;

use fearless_simd::{Simd, f64x4, prelude::*};

use super::rows::Row;
use crate::kernels::record::vector;
use crate::simd::{Lanes as _, with_simd};
use crate::state::springs::Elastic;
use crate::state::threads::{Job, Threads};
use crate::units::Vector;

/// Number of springs that are computed at once: four square roots and divisions take hardly longer than one.
pub(super) const AT_ONCE: usize = 4;

/// A spring between two rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpringRow {
    pub ends: [u32; 2],
    pub elastic: Elastic,
}

impl SpringRow {
    /// Force on the first end, N, for ends at `x` with velocities `v`, with the bits of [`Springs::pull`].
    pub fn force(&self, x: [Row; 2], v: [Row; 2]) -> Row {
        let mut one = Springs::default();
        one.push(Self { ends: [0, 1], ..*self });
        let mut forces = [[0.0; 4]; 2];
        one.pull(None, &x, &v, &mut forces);
        let [d, u] = [x, v].map(|[a, b]| vector(&b) - vector(&a));
        let is_slack = self.elastic.pull_only && !pulls(&self.elastic, d, u);
        if is_slack { [0.0; 4] } else { forces[0] }
    }
}

/// Whether a spring pulls while its second end is at `d` from the first and moves at `u` relative to it.
pub(crate) fn pulls(elastic: &Elastic, d: Vector, u: Vector) -> bool {
    let length = d.dot(d).sqrt();
    length > 0.0 && elastic.tension(length, d.dot(u) / length) > 0.0
}

/// Four springs. Those that fill up the last block join row 0 to itself, without stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpringBlock {
    ends: [[u32; AT_ONCE]; 2],
    stiffness: [f64; AT_ONCE],
    damping: [f64; AT_ONCE],
    rest_length: [f64; AT_ONCE],
}

/// The properties of four springs.
#[derive(Clone, Copy)]
pub(super) struct FourElastic<S: Simd> {
    /// N/m.
    pub stiffness: f64x4<S>,
    /// N s/m.
    pub damping: f64x4<S>,
    /// m.
    pub rest_length: f64x4<S>,
}

/// Four springs: their reciprocal lengths, 0 for one without a length, and their stiffness across their axes as a fraction
/// of their stiffness, at least 0.
pub(crate) type AxisBlock = [[f64; AT_ONCE]; 2];

/// The direction of a spring whose second end is at `d` from the first, and the ratio of its stiffness across that direction
/// to its stiffness. The ratio is negative for a spring shorter than at rest. A spring whose ends coincide has no direction:
/// it is isotropic if its rest length is 0, and is skipped otherwise.
pub(super) fn axis(d: Vector, rest_length: f64) -> (Vector, f64) {
    let length = d.dot(d).sqrt();
    if length > 0.0 {
        (d * (1.0 / length), 1.0 - rest_length / length)
    } else {
        (Vector::ZERO, if rest_length == 0.0 { 1.0 } else { 0.0 })
    }
}

/// The [axes](AxisBlock) of four springs whose ends are `d` apart, as [`axis`] but at least 0.
#[inline(always)]
pub(super) fn axes<S: Simd>(
    simd: S,
    [x, y, z]: [f64x4<S>; 3],
    rest_length: f64x4<S>,
) -> [f64x4<S>; 2] {
    let splat = |number: f64| f64x4::splat(simd, number);
    let length = (x * x + y * y + z * z).sqrt();
    let has_length = length.simd_gt(splat(0.0));
    let inverse = (splat(1.0) / length).only(has_length);
    let without_length = splat(1.0).only(rest_length.simd_eq(splat(0.0)));
    let taut = has_length.select(splat(1.0) - rest_length / length, without_length);
    [inverse, taut.only(taut.simd_gt(splat(0.0)))]
}

/// A number, or 0 if it is negative or NaN.
pub(super) fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}

/// One thread's share of the forces of springs: the forces on some rows, by every spring that ends at one of them, in the
/// order of springs. A spring between two shares is computed twice, so that the bits do not depend on the shares.
#[derive(Clone, Debug)]
pub(crate) struct Share {
    rows: Range<usize>,
    /// Numbers of the blocks in which a spring ends at one of the rows.
    blocks: Vec<Range<usize>>,
}

/// Threads and their shares, if the springs are shared.
pub(crate) type Shares<'a> = Option<(&'a Threads, &'a [Share])>;

impl Share {
    /// Calls `pull` for each share with its rows of `forces`, all at the same time. `forces` may lack the anchors.
    pub fn each<R: Send>(
        threads: &Threads,
        shares: &[Self],
        forces: &mut [R],
        pull: impl Fn(&Self, &mut [R]) + Sync,
    ) {
        let (mut rest, pull) = (forces, &pull);
        let mut jobs: Vec<Job<'_>> = Vec::new();
        for share in shares {
            let (own, others) = rest.split_at_mut(share.rows.len().min(rest.len()));
            jobs.push(Box::new(move || pull(share, own)));
            rest = others;
        }
        threads.run(jobs);
    }

    /// The first of its rows.
    pub const fn first(&self) -> usize {
        self.rows.start
    }
}

/// Row number `row` among the rows of a share, which begin at `first`; `None` if it belongs to another share.
#[inline(always)]
pub(super) fn own_row<R>(rows: &mut [R], first: usize, row: usize) -> Option<&mut R> {
    // A lower row wraps around to beyond the end.
    rows.get_mut(row.wrapping_sub(first))
}

/// Springs, in the order in which their forces are summed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Springs {
    blocks: Vec<SpringBlock>,
    len: usize,
    damped: bool,
    /// Numbers of the springs that only pull, ascending.
    cords: Vec<u32>,
}

impl Springs {
    /// No springs, with capacity for `springs`.
    pub fn with_room(springs: usize) -> Self {
        Self { blocks: Vec::with_capacity(springs.div_ceil(AT_ONCE)), ..Self::default() }
    }

    /// Renumbers all ends.
    pub fn renumber(&mut self, mut row: impl FnMut(u32) -> u32) {
        for i in 0..self.len {
            for ends in &mut self.blocks[i / AT_ONCE].ends {
                ends[i % AT_ONCE] = row(ends[i % AT_ONCE]);
            }
        }
    }

    pub fn push(&mut self, spring: SpringRow) {
        let at = self.len % AT_ONCE;
        if at == 0 {
            let zero = [0.0; AT_ONCE];
            let ends = [[0; AT_ONCE]; 2];
            self.blocks.push(SpringBlock {
                ends,
                stiffness: zero,
                damping: zero,
                rest_length: zero,
            });
        }
        if let Some(block) = self.blocks.last_mut() {
            let Elastic { stiffness, damping, rest_length, pull_only } = spring.elastic;
            if pull_only {
                self.cords.push(self.len as u32);
            }
            (block.ends[0][at], block.ends[1][at]) = (spring.ends[0], spring.ends[1]);
            (block.stiffness[at], block.damping[at], block.rest_length[at]) =
                (stiffness, damping, rest_length);
            self.damped |= damping != 0.0;
        }
        self.len += 1;
    }

    /// Splits the forces on `rows` rows into shares for `count` threads, each with about the same number of spring ends.
    pub fn shares(&self, rows: usize, count: usize) -> Vec<Share> {
        let mut ends = vec![0_usize; rows];
        self.iter().flat_map(|spring| spring.ends).for_each(|end| ends[end as usize] += 1);
        let (mut shares, mut sum, mut start) = (Vec::new(), 0, 0);
        for (row, ends) in ends.iter().enumerate() {
            sum += ends;
            let is_full =
                shares.len() + 1 < count && sum * count >= 2 * self.len * (shares.len() + 1);
            if is_full || row + 1 == rows {
                shares.push(Share { rows: start..row + 1, blocks: Vec::new() });
                start = row + 1;
            }
        }
        for (number, block) in self.blocks.iter().enumerate() {
            for share in &mut shares {
                let is_own = |end: &u32| share.rows.contains(&(*end as usize));
                if !block.ends.iter().flatten().any(is_own) {
                    continue;
                }
                match share.blocks.last_mut() {
                    Some(blocks) if blocks.end == number => blocks.end += 1,
                    _ => share.blocks.push(number..number + 1),
                }
            }
        }
        shares
    }

    pub const fn len(&self) -> usize {
        self.len
    }

    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Allocated bytes.
    pub fn bytes(&self) -> usize {
        self.blocks.capacity() * size_of::<SpringBlock>() + self.cords.capacity() * size_of::<u32>()
    }

    /// Numbers of the springs that only pull, ascending.
    pub fn cords(&self) -> &[u32] {
        &self.cords
    }

    /// Spring number `number`.
    pub fn get(&self, number: u32) -> SpringRow {
        let (block, at) = (number as usize / AT_ONCE, number as usize % AT_ONCE);
        let mut spring = self.blocks[block].springs()[at];
        spring.elastic.pull_only = self.cords.binary_search(&number).is_ok();
        spring
    }

    /// Copies all springs of `other`; allocates nothing once there is room.
    pub fn copy(&mut self, other: &Self) {
        self.blocks.clone_from(&other.blocks);
        self.cords.clone_from(&other.cords);
        (self.len, self.damped) = (other.len, other.damped);
    }

    /// Sets stiffness and damping of a spring to those of `elastic`.
    pub fn tune(&mut self, number: u32, elastic: &Elastic) {
        let at = number as usize % AT_ONCE;
        let block = &mut self.blocks[number as usize / AT_ONCE];
        (block.stiffness[at], block.damping[at]) = (elastic.stiffness, elastic.damping);
    }

    /// Whether a spring has damping.
    pub const fn damped(&self) -> bool {
        self.damped
    }

    pub fn iter(&self) -> impl Iterator<Item = SpringRow> + '_ {
        let mut cords = self.cords.iter().peekable();
        let springs = self.blocks.iter().flat_map(SpringBlock::springs).take(self.len);
        (0..).zip(springs).map(move |(number, mut spring)| {
            spring.elastic.pull_only = cords.next_if(|cord| **cord == number).is_some();
            spring
        })
    }

    /// Adds the forces in the state (`x`, `v`) to `forces`, N. Velocities are read only if springs have damping.
    pub fn pull(&self, shares: Shares<'_>, x: &[Row], v: &[Row], forces: &mut [Row]) {
        if self.damped {
            self.add(shares, &Tension::<true> { x, v }, forces);
        } else {
            self.add(shares, &Tension::<false> { x, v }, forces);
        }
    }

    /// Adds `end_forces` of all springs to `forces`.
    pub fn add(&self, shares: Shares<'_>, end_forces: &impl EndForces, forces: &mut [Row]) {
        match shares {
            Some((threads, shares)) => Share::each(threads, shares, forces, |share, forces| {
                for blocks in &share.blocks {
                    self.add_blocks::<_, true>(blocks.clone(), end_forces, share.first(), forces);
                }
            }),
            None => self.add_blocks::<_, false>(0..self.blocks.len(), end_forces, 0, forces),
        }
    }

    /// Adds the forces of some blocks; if `SHARED`, only those on the rows of a share, which start at `first`.
    fn add_blocks<F: EndForces, const SHARED: bool>(
        &self,
        numbers: Range<usize>,
        end_forces: &F,
        first: usize,
        forces: &mut [Row],
    ) {
        let blocks = numbers.clone().zip(&self.blocks[numbers]);
        with_simd!(simd => add_with::<_, _, SHARED>(simd, blocks, end_forces, first, forces));
    }

    /// Sets `axes` to those of all springs at the positions `x`.
    pub fn find_axes(&self, threads: Option<&Threads>, x: &[Row], axes: &mut Vec<AxisBlock>) {
        axes.resize(self.blocks.len(), [[0.0; AT_ONCE]; 2]);
        Threads::share(threads, axes, |first, axes| {
            let blocks = self.blocks[first..].iter().zip(axes);
            with_simd!(simd => find_axes(simd, blocks, x));
        });
    }
}

#[inline(always)]
fn find_axes<'b, S: Simd>(
    simd: S,
    blocks: impl Iterator<Item = (&'b SpringBlock, &'b mut AxisBlock)>,
    x: &[Row],
) {
    for (block, of_block) in blocks {
        let rest_length = f64x4::simd_from(simd, block.rest_length);
        *of_block = axes(simd, columns(block.differences(simd, x)), rest_length).map(Into::into);
    }
}

#[inline(always)]
fn add_with<'b, S: Simd, F: EndForces, const SHARED: bool>(
    simd: S,
    blocks: impl Iterator<Item = (usize, &'b SpringBlock)>,
    end_forces: &F,
    first: usize,
    forces: &mut [Row],
) {
    for (number, block) in blocks {
        let pulls = end_forces.of(simd, number, block);
        for (i, pull) in pulls.into_iter().enumerate() {
            let [a, b] = [block.ends[0][i] as usize, block.ends[1][i] as usize];
            if SHARED {
                if let Some(force) = own_row(forces, first, a) {
                    (f64x4::simd_from(simd, *force) + pull).store_slice(force);
                }
                if let Some(force) = own_row(forces, first, b) {
                    (f64x4::simd_from(simd, *force) - pull).store_slice(force);
                }
            } else {
                let sum = f64x4::simd_from(simd, forces[a]) + pull;
                sum.store_slice(&mut forces[a]);
                let sum = f64x4::simd_from(simd, forces[b]) - pull;
                sum.store_slice(&mut forces[b]);
            }
        }
    }
}

/// Forces of springs on their first ends; the second ends get the opposite forces.
pub(crate) trait EndForces: Sync {
    /// A row for each spring of block `number`.
    fn of<S: Simd>(&self, simd: S, number: usize, block: &SpringBlock) -> [f64x4<S>; AT_ONCE];
}

/// The forces in the state (`x`, `v`).
struct Tension<'a, const DAMPED: bool> {
    x: &'a [Row],
    v: &'a [Row],
}

impl<const DAMPED: bool> EndForces for Tension<'_, DAMPED> {
    #[inline(always)]
    fn of<S: Simd>(&self, simd: S, _: usize, block: &SpringBlock) -> [f64x4<S>; AT_ONCE] {
        let d = block.differences(simd, self.x);
        let u = if DAMPED { columns(block.differences(simd, self.v)) } else { columns(d) };
        let tension: [f64; AT_ONCE] =
            tension::<_, DAMPED>(simd, block.elastic(simd), columns(d), u).into();
        let mut pulls = d;
        for i in 0..AT_ONCE {
            pulls[i] = d[i] * f64x4::splat(simd, tension[i]);
        }
        pulls
    }
}

/// The forces of four springs over their lengths, N/m, if their second ends are at `d` from the first and move at `u`
/// relative to them.
#[inline(always)]
pub(super) fn tension<S: Simd, const DAMPED: bool>(
    simd: S,
    FourElastic { stiffness, damping, rest_length }: FourElastic<S>,
    [dx, dy, dz]: [f64x4<S>; 3],
    [ux, uy, uz]: [f64x4<S>; 3],
) -> f64x4<S> {
    let squared = dx * dx + dy * dy + dz * dz;
    // A spring without a length has no direction and no force: a plain reciprocal would give 0 times infinity.
    let pulls = squared.simd_gt(f64x4::splat(simd, 0.0));
    let inverse = (f64x4::splat(simd, 1.0) / squared.sqrt()).only(pulls);
    let stretched = f64x4::splat(simd, 1.0) - rest_length * inverse;
    let mut tension = stiffness * stretched;
    if DAMPED {
        let rate = dx * ux + dy * uy + dz * uz;
        // In this order: the square of the reciprocal of a very short length is infinite.
        tension += damping * (rate * inverse) * inverse;
    }
    tension
}

/// Linearized changes of the forces of springs: `times (across u + n (n·u) (along - across))`, where u is the move of the
/// second end relative to the first and n the direction of the spring. A spring of stiffness k, damping c, length L and rest
/// length L0 has `along = stiffness k + damping c` and `across = stiffness k (1 - L0 / L)`, at least 0.
pub(crate) struct Linearized<'a> {
    /// The positions.
    pub x: &'a [Row],
    /// The [axes](Springs::find_axes) at these positions, if they were computed.
    pub axes: Option<&'a [AxisBlock]>,
    /// The moves.
    pub moves: &'a [Row],
    pub stiffness: f64,
    pub damping: f64,
    pub times: f64,
}

impl EndForces for Linearized<'_> {
    #[inline(always)]
    fn of<S: Simd>(&self, simd: S, number: usize, block: &SpringBlock) -> [f64x4<S>; AT_ONCE] {
        let splat = |number: f64| f64x4::splat(simd, number);
        let elastic = block.elastic(simd);
        let (d, u) = (block.differences(simd, self.x), block.differences(simd, self.moves));
        let ([dx, dy, dz], [ux, uy, uz]) = (columns(d), columns(u));
        let [inverse, taut] = match self.axes {
            Some(axes) => axes[number].map(|numbers| f64x4::simd_from(simd, numbers)),
            None => axes(simd, [dx, dy, dz], elastic.rest_length),
        };
        let [across, beyond] = stiffnesses(simd, elastic, taut, self.stiffness, self.damping);
        let toward = (dx * inverse) * ux + (dy * inverse) * uy + (dz * inverse) * uz;
        let [inverse, across, beyond]: [[f64; AT_ONCE]; 3] =
            [inverse.into(), across.into(), (toward * beyond).into()];
        let mut pulls = u;
        for i in 0..AT_ONCE {
            let n = d[i] * splat(inverse[i]);
            pulls[i] = (u[i] * splat(across[i]) + n * splat(beyond[i])) * splat(self.times);
        }
        pulls
    }
}

/// `across` and `along - across` of four linearized springs, as in [`Linearized`].
#[inline(always)]
pub(super) fn stiffnesses<S: Simd>(
    simd: S,
    FourElastic { stiffness, damping, .. }: FourElastic<S>,
    taut: f64x4<S>,
    of_stiffness: f64,
    of_damping: f64,
) -> [f64x4<S>; 2] {
    let along = f64x4::splat(simd, of_stiffness) * stiffness;
    let across = along * taut;
    let along = along + f64x4::splat(simd, of_damping) * damping;
    [across, along - across]
}

impl SpringBlock {
    fn springs(&self) -> [SpringRow; AT_ONCE] {
        let Self { ends: [a, b], stiffness, damping, rest_length } = *self;
        std::array::from_fn(|i| SpringRow {
            ends: [a[i], b[i]],
            elastic: Elastic {
                stiffness: stiffness[i],
                damping: damping[i],
                rest_length: rest_length[i],
                pull_only: false,
            },
        })
    }

    #[inline(always)]
    fn elastic<S: Simd>(&self, simd: S) -> FourElastic<S> {
        FourElastic {
            stiffness: f64x4::simd_from(simd, self.stiffness),
            damping: f64x4::simd_from(simd, self.damping),
            rest_length: f64x4::simd_from(simd, self.rest_length),
        }
    }

    /// Rows of the second ends minus rows of the first.
    #[inline(always)]
    fn differences<S: Simd>(&self, simd: S, rows: &[Row]) -> [f64x4<S>; AT_ONCE] {
        let mut differences = [f64x4::splat(simd, 0.0); AT_ONCE];
        for (i, difference) in differences.iter_mut().enumerate() {
            let [a, b] = [self.ends[0][i] as usize, self.ends[1][i] as usize];
            *difference = f64x4::simd_from(simd, rows[b]) - f64x4::simd_from(simd, rows[a]);
        }
        differences
    }
}

/// x, y and z of four rows.
#[inline(always)]
fn columns<S: Simd>([a, b, c, d]: [f64x4<S>; AT_ONCE]) -> [f64x4<S>; 3] {
    let (low, high) = (a.zip_low(c), b.zip_low(d));
    let z = a.zip_high(c).zip_low(b.zip_high(d));
    [low.zip_low(high), low.zip_high(high), z]
}
