//! Blocks of bodies as structures of arrays, and the spaces that methods compute in.

use std::cell::{Cell, RefCell};
use std::ops::{Add, Mul, Neg, Sub};

use super::Row;
use crate::laws::{Axes, BLOCK_BODIES};
use crate::methods::Space;
use crate::simd::vectorize;

/// x, y and z of `N` bodies.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Block<const N: usize>(pub [[f64; N]; 3]);

impl<const N: usize> Block<N> {
    pub const ZERO: Self = Self([[0.0; N]; 3]);

    /// Makes a block from rows; the first row fills up the rest, so that no law sees a state that no body has.
    pub fn of<const M: usize>(rows: &[[f64; M]]) -> Self {
        let mut block = Self::ZERO;
        block.load(rows);
        block
    }

    /// [`Block::of`] into this block.
    #[inline(always)]
    pub fn load<const M: usize>(&mut self, rows: &[[f64; M]]) {
        if let Ok(rows) = <&[[f64; M]; N]>::try_from(rows) {
            load_axes(&mut self.0, rows);
            return;
        }
        for (axis, numbers) in self.0.iter_mut().enumerate() {
            *numbers = [rows[0][axis]; N];
            numbers.iter_mut().zip(rows).for_each(|(number, row)| *number = row[axis]);
        }
    }

    /// Stores the row of each body that `row` makes of its numbers.
    #[inline(always)]
    pub fn store<const M: usize>(
        &self,
        rows: &mut [[f64; M]],
        row: impl Fn([f64; 3], usize) -> [f64; M],
    ) {
        store_axes(&self.0, rows, row);
    }

    /// The numbers of body `k`.
    #[inline(always)]
    pub const fn body(&self, k: usize) -> [f64; 3] {
        let [x, y, z] = &self.0;
        [x[k], y[k], z[k]]
    }

    /// All bodies as rows, the fourth number of which is 0.
    pub fn rows(&self) -> [Row; N] {
        std::array::from_fn(|k| {
            let [x, y, z] = self.body(k);
            [x, y, z, 0.0]
        })
    }

    /// The block as laws see it, if it has as many bodies as they take.
    #[inline(always)]
    pub fn axes(&self) -> Option<&Axes> {
        self.0.as_flattened().as_chunks().0.try_into().ok()
    }

    /// [`Block::axes`] to write to.
    #[inline(always)]
    pub fn axes_mut(&mut self) -> Option<&mut Axes> {
        self.0.as_flattened_mut().as_chunks_mut().0.try_into().ok()
    }
}

/// Turns rows into axes.
#[inline(always)]
pub(crate) fn load_axes<const N: usize, const M: usize>(
    axes: &mut [[f64; N]; 3],
    rows: &[[f64; M]; N],
) {
    let [x, y, z] = axes;
    for (k, row) in rows.iter().enumerate() {
        (x[k], y[k], z[k]) = (row[0], row[1], row[2]);
    }
}

/// Stores the row of each body that `row` makes of its numbers.
#[inline(always)]
pub(crate) fn store_axes<const N: usize, const M: usize>(
    [x, y, z]: &[[f64; N]; 3],
    rows: &mut [[f64; M]],
    row: impl Fn([f64; 3], usize) -> [f64; M],
) {
    let of = |k: usize| row([x[k], y[k], z[k]], k);
    let (chunks, rest) = rows.as_chunks_mut::<4>();
    let whole = 4 * chunks.len();
    for (chunk, rows) in chunks.iter_mut().enumerate().take(N / 4) {
        *rows = std::array::from_fn(
            #[inline(always)]
            |k| of(4 * chunk + k),
        );
    }
    for (k, place) in (whole..N).zip(rest) {
        *place = of(k);
    }
}

/// Numbers that are computed before the first of them is stored: two vectors.
const VECTORS: usize = 8;

/// Sets every number to `number` of its axis and body.
#[inline(always)]
pub(super) fn fill(axes: &mut Axes, number: impl Fn(usize, usize) -> f64) {
    for (axis, numbers) in axes.iter_mut().enumerate() {
        for (chunk, places) in numbers.as_chunks_mut::<VECTORS>().0.iter_mut().enumerate() {
            // Not one by one: the compiler would have to assume that each place overlaps with what `number` reads.
            *places = std::array::from_fn(
                #[inline(always)]
                |k| number(axis, VECTORS * chunk + k),
            );
        }
    }
}

/// A space whose elements are blocks of `N` bodies.
pub(super) trait BlockSpace<const N: usize>: Space + Neg<Output = Self> {
    /// Where elements are stored.
    type Memory: Copy;

    /// A new element, set by `write`.
    fn load(memory: Self::Memory, write: impl FnOnce(&mut Block<N>)) -> Self;

    /// An element with the numbers of `block`.
    #[inline(always)]
    fn of(memory: Self::Memory, block: &Block<N>) -> Self {
        Self::load(memory, |new| *new = *block)
    }

    /// Calls `read` with the numbers of two elements.
    fn read_both<R>(self, other: Self, read: impl FnOnce(&Block<N>, &Block<N>) -> R) -> R;

    /// Calls `read` with the numbers.
    #[inline(always)]
    fn read<R>(self, read: impl FnOnce(&Block<N>) -> R) -> R {
        self.read_both(self, |block, _| read(block))
    }

    /// A new element, set by `write`, which also gets the numbers of two elements.
    fn write(self, other: Self, write: impl FnOnce(&Block<N>, &Block<N>, &mut Block<N>)) -> Self;

    /// Changes every number by `change`, which gets its axis and body.
    fn map(self, change: impl Fn(usize, usize, f64) -> f64) -> Self;

    /// [`Self::map`] of the numbers of this element and of `other`.
    fn zip(self, other: Self, change: impl Fn(usize, usize, [f64; 2]) -> f64) -> Self;

    /// Frees the memory of all elements but `kept`, which move.
    fn recycle(memory: Self::Memory, kept: &mut [Self]);
}

/// The space of single bodies: in registers.
impl BlockSpace<1> for Block<1> {
    type Memory = ();

    #[inline(always)]
    fn load((): (), write: impl FnOnce(&mut Self)) -> Self {
        let mut block = Self::ZERO;
        write(&mut block);
        block
    }

    #[inline(always)]
    fn read_both<R>(self, other: Self, read: impl FnOnce(&Self, &Self) -> R) -> R {
        read(&self, &other)
    }

    #[inline(always)]
    fn write(self, other: Self, write: impl FnOnce(&Self, &Self, &mut Self)) -> Self {
        let mut block = Self::ZERO;
        write(&self, &other, &mut block);
        block
    }

    #[inline(always)]
    fn map(mut self, change: impl Fn(usize, usize, f64) -> f64) -> Self {
        (0..3).for_each(|axis| self.0[axis][0] = change(axis, 0, self.0[axis][0]));
        self
    }

    #[inline(always)]
    fn zip(self, other: Self, change: impl Fn(usize, usize, [f64; 2]) -> f64) -> Self {
        self.map(|axis, k, number| change(axis, k, [number, other.0[axis][k]]))
    }

    #[inline(always)]
    fn recycle((): (), _: &mut [Self]) {}
}

impl Add for Block<1> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |_, _, [a, b]| a + b)
    }
}

impl Sub for Block<1> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |_, _, [a, b]| a - b)
    }
}

impl Neg for Block<1> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|_, _, number| -number)
    }
}

impl Mul<f64> for Block<1> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.map(|_, _, number| number * factor)
    }
}

type Full = Block<BLOCK_BODIES>;

/// The memory of a step: one block after another. Each sum or law writes the next one, so that nothing is copied, and so
/// that the arithmetic of blocks is compiled once for all methods.
#[derive(Default)]
pub(super) struct Slots {
    blocks: RefCell<Vec<Full>>,
    used: Cell<usize>,
    factors: RefCell<Vec<f64>>,
}

/// A block of [`Slots`], times a factor. Two words, because three would be passed through memory.
#[derive(Clone, Copy)]
pub(super) struct Slot<'s> {
    slots: &'s Slots,
    /// The number of the block, and above [`FACTOR`] the number of its factor, from 1 on.
    code: u64,
}

/// The bit of [`Slot::code`] at which the number of the factor begins.
const FACTOR: u32 = 32;

thread_local! {
    /// Slots that are not in use, so that a tick allocates nothing.
    static SPARE: RefCell<Vec<Slots>> = const { RefCell::new(Vec::new()) };
}

impl Slots {
    /// Calls `run` with slots that are kept for the next call on this thread.
    pub fn lend(run: impl FnOnce(&Self)) {
        let slots = SPARE.with_borrow_mut(Vec::pop).unwrap_or_default();
        run(&slots);
        SPARE.with_borrow_mut(|spare| spare.push(slots));
    }

    /// A new element, set by `write`, which also gets all elements before it.
    #[inline(always)]
    fn add(&self, write: impl FnOnce(&[Full], &mut Full)) -> Slot<'_> {
        let number = self.used.get();
        let blocks = &mut *self.blocks.borrow_mut();
        if number >= blocks.len() {
            grow(blocks);
        }
        let (before, next) = blocks.split_at_mut(number);
        write(before, &mut next[0]);
        self.used.set(number + 1);
        Slot { slots: self, code: number as u64 }
    }

    /// A new element with `number` of every axis and body; `number` also gets the elements `a` and `b`.
    #[inline(always)]
    fn fill(
        &self,
        [a, b]: [usize; 2],
        number: impl Fn(usize, usize, &Full, &Full) -> f64,
    ) -> Slot<'_> {
        self.add(
            #[inline(always)]
            |before, next| {
                let (a, b) = (&before[a], &before[b]);
                vectorize(
                    #[inline(always)]
                    || fill(&mut next.0, |axis, k| number(axis, k, a, b)),
                );
            },
        )
    }
}

#[cold]
fn grow(blocks: &mut Vec<Full>) {
    blocks.push(Block::ZERO);
}

impl Slot<'_> {
    /// The number of the block, without its factor.
    #[inline(always)]
    const fn number(self) -> usize {
        self.code as u32 as usize
    }

    #[inline(always)]
    fn factor(self) -> f64 {
        match self.code >> FACTOR {
            0 => 1.0,
            factor => self.slots.factors.borrow()[factor as usize - 1],
        }
    }

    /// The same element without a factor.
    #[inline(always)]
    fn plain(self) -> Self {
        if self.code >> FACTOR == 0 { self } else { self.multiplied() }
    }

    #[inline(never)]
    fn multiplied(self) -> Self {
        let factor = self.factor();
        self.slots.fill([self.number(); 2], |axis, k, a, _| a.0[axis][k] * factor)
    }

    /// The sum, in one pass with the factors.
    #[inline(never)]
    fn sum(self, other: Self) -> Self {
        let (pair, p, q) = ([self.number(), other.number()], self.factor(), other.factor());
        if p == 1.0 {
            self.slots.fill(pair, |axis, k, a, b| a.0[axis][k] + b.0[axis][k] * q)
        } else {
            self.slots.fill(pair, |axis, k, a, b| a.0[axis][k] * p + b.0[axis][k] * q)
        }
    }

    /// The block times `factor`.
    #[inline(always)]
    fn scaled(self, factor: f64) -> Self {
        let factors = &mut *self.slots.factors.borrow_mut();
        factors.push(factor);
        Self { code: self.number() as u64 | (factors.len() as u64) << FACTOR, ..self }
    }
}

impl<'s> BlockSpace<BLOCK_BODIES> for Slot<'s> {
    type Memory = &'s Slots;

    #[inline(always)]
    fn load(memory: &'s Slots, write: impl FnOnce(&mut Full)) -> Self {
        memory.add(|_, next| write(next))
    }

    #[inline(always)]
    fn read_both<R>(self, other: Self, read: impl FnOnce(&Full, &Full) -> R) -> R {
        let (a, b) = (self.plain(), other.plain());
        let blocks = self.slots.blocks.borrow();
        read(&blocks[a.number()], &blocks[b.number()])
    }

    #[inline(always)]
    fn write(self, other: Self, write: impl FnOnce(&Full, &Full, &mut Full)) -> Self {
        let (a, b) = (self.plain().number(), other.plain().number());
        self.slots.add(|before, next| write(&before[a], &before[b], next))
    }

    #[inline(always)]
    fn map(self, change: impl Fn(usize, usize, f64) -> f64) -> Self {
        let number = self.plain().number();
        self.slots.fill([number; 2], |axis, k, a, _| change(axis, k, a.0[axis][k]))
    }

    #[inline(always)]
    fn zip(self, other: Self, change: impl Fn(usize, usize, [f64; 2]) -> f64) -> Self {
        let (a, b) = (self.plain(), other.plain());
        self.slots.fill([a.number(), b.number()], |axis, k, a, b| {
            change(axis, k, [a.0[axis][k], b.0[axis][k]])
        })
    }

    fn recycle(memory: &'s Slots, kept: &mut [Self]) {
        kept.iter_mut().for_each(|slot| *slot = slot.plain());
        memory.factors.borrow_mut().clear();
        for place in 0..kept.len() {
            let from = kept[place].code;
            let to = place as u64;
            // Two elements of `kept` may be the same slot.
            if from < to {
                continue;
            }
            memory.blocks.borrow_mut().swap(place, kept[place].number());
            for slot in &mut *kept {
                slot.code = match slot.code {
                    code if code == from => to,
                    code if code == to => from,
                    code => code,
                };
            }
        }
        memory.used.set(kept.len());
    }
}

impl Add for Slot<'_> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.sum(other)
    }
}

impl Sub for Slot<'_> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Slot<'_> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.scaled(-self.factor())
    }
}

impl Mul<f64> for Slot<'_> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.plain().scaled(factor)
    }
}
