//! Blocks of bodies as structures of arrays, and the spaces that methods compute in.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::ops::{Add, Mul, Neg, Sub};

use super::Row;
use crate::laws::{Axes, BLOCK_BODIES};
use crate::methods::Space;
use crate::real::{Real, vectorize};

/// x, y and z of `N` bodies.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Block<T, const N: usize>(pub [[T; N]; 3]);

impl<T: Real, const N: usize> Block<T, N> {
    pub const ZERO: Self = Self([[T::ZERO; N]; 3]);

    /// The first bodies from triples; the others are like the first one, so that no law sees a state that no body has.
    pub fn of<const M: usize>(rows: &[[T; M]]) -> Self {
        let mut block = Self::ZERO;
        block.load(rows);
        block
    }

    /// [`Block::of`] into this block.
    #[inline(always)]
    pub fn load<const M: usize>(&mut self, rows: &[[T; M]]) {
        let [x, y, z] = &mut self.0;
        if let Ok(rows) = <&[[T; M]; N]>::try_from(rows) {
            for (k, row) in rows.iter().enumerate() {
                (x[k], y[k], z[k]) = (row[0], row[1], row[2]);
            }
            return;
        }
        for (axis, numbers) in self.0.iter_mut().enumerate() {
            *numbers = [rows[0][axis]; N];
            numbers.iter_mut().zip(rows).for_each(|(number, row)| *number = row[axis]);
        }
    }

    /// Stores the row of each body that `row` makes of its numbers.
    #[inline(always)]
    pub fn store<const M: usize>(&self, rows: &mut [[T; M]], row: impl Fn([T; 3], usize) -> [T; M]) {
        let (chunks, rest) = rows.as_chunks_mut::<4>();
        let whole = 4 * chunks.len();
        for (chunk, rows) in chunks.iter_mut().enumerate().take(N / 4) {
            *rows = std::array::from_fn(
                #[inline(always)]
                |k| row(self.body(4 * chunk + k), 4 * chunk + k),
            );
        }
        for (k, place) in (whole..N).zip(rest) {
            *place = row(self.body(k), k);
        }
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
}

/// Numbers that are computed before the first of them is stored: two vectors of f64, one of f32.
const VECTORS: usize = 8;

/// Sets every number to `number` of its axis and body.
#[inline(always)]
pub(super) fn fill<T: Real>(axes: &mut Axes<T>, number: impl Fn(usize, usize) -> T) {
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
pub(super) trait BlockSpace<T: Real, const N: usize>: Space<T> + Neg<Output = Self> {
    /// Where elements are stored.
    type Memory: Copy;

    /// A new element, set by `write`.
    fn load(memory: Self::Memory, write: impl FnOnce(&mut Block<T, N>)) -> Self;

    /// An element with the numbers of `block`.
    #[inline(always)]
    fn of(memory: Self::Memory, block: &Block<T, N>) -> Self {
        Self::load(memory, |new| *new = *block)
    }

    /// Calls `read` with the numbers of two elements.
    fn read_both<R>(self, other: Self, read: impl FnOnce(&Block<T, N>, &Block<T, N>) -> R) -> R;

    /// Calls `read` with the numbers.
    #[inline(always)]
    fn read<R>(self, read: impl FnOnce(&Block<T, N>) -> R) -> R {
        self.read_both(self, |block, _| read(block))
    }

    /// A new element, set by `write`, which also gets the numbers of two elements.
    fn write(self, other: Self, write: impl FnOnce(&Block<T, N>, &Block<T, N>, &mut Block<T, N>)) -> Self;

    /// Changes every number by `change`, which gets its axis and body.
    fn map(self, change: impl Fn(usize, usize, T) -> T) -> Self;

    /// [`Self::map`] of the numbers of this element and of `other`.
    fn zip(self, other: Self, change: impl Fn(usize, usize, [T; 2]) -> T) -> Self;

    /// Frees the memory of all elements but `kept`, which move.
    fn recycle(memory: Self::Memory, kept: &mut [Self]);
}

/// The space of single bodies: in registers.
impl<T: Real> BlockSpace<T, 1> for Block<T, 1> {
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
    fn map(mut self, change: impl Fn(usize, usize, T) -> T) -> Self {
        (0..3).for_each(|axis| self.0[axis][0] = change(axis, 0, self.0[axis][0]));
        self
    }

    #[inline(always)]
    fn zip(self, other: Self, change: impl Fn(usize, usize, [T; 2]) -> T) -> Self {
        self.map(|axis, k, number| change(axis, k, [number, other.0[axis][k]]))
    }

    #[inline(always)]
    fn recycle((): (), _: &mut [Self]) {}
}

impl<T: Real> Add for Block<T, 1> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |_, _, [a, b]| a + b)
    }
}

impl<T: Real> Sub for Block<T, 1> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |_, _, [a, b]| a - b)
    }
}

impl<T: Real> Neg for Block<T, 1> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|_, _, number| -number)
    }
}

impl<T: Real> Mul<T> for Block<T, 1> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        self.map(|_, _, number| number * factor)
    }
}

type Full<T> = Block<T, BLOCK_BODIES>;

/// The memory of a step: one block after another. Each sum or law writes the next one, so that nothing is copied, and so
/// that the arithmetic of blocks is compiled once for all methods.
#[derive(Default)]
pub(super) struct Slots<T: Real> {
    blocks: RefCell<Vec<Full<T>>>,
    used: Cell<usize>,
}

/// A block of [`Slots`], times a factor.
#[derive(Clone, Copy)]
pub(super) struct Slot<'s, T: Real> {
    slots: &'s Slots<T>,
    number: usize,
    factor: T,
}

thread_local! {
    /// Slots of both precisions that are not in use, so that a tick allocates nothing.
    static SPARE: RefCell<Vec<Box<dyn Any>>> = const { RefCell::new(Vec::new()) };
}

impl<T: Real> Slots<T> {
    /// Calls `run` with slots that are kept for the next call on this thread.
    pub fn lend(run: impl FnOnce(&Self)) {
        let mut slots = SPARE.with_borrow_mut(|spare| {
            let found = spare.iter().position(|slots| slots.is::<Self>());
            found.map_or_else(|| Box::<Self>::default() as Box<dyn Any>, |found| spare.swap_remove(found))
        });
        if let Some(slots) = slots.downcast_mut() {
            run(slots);
        }
        SPARE.with_borrow_mut(|spare| spare.push(slots));
    }

    /// A new element, set by `write`, which also gets all elements before it.
    #[inline(always)]
    fn add(&self, write: impl FnOnce(&[Full<T>], &mut Full<T>)) -> Slot<'_, T> {
        let number = self.used.get();
        let blocks = &mut *self.blocks.borrow_mut();
        if number >= blocks.len() {
            grow(blocks);
        }
        let (before, next) = blocks.split_at_mut(number);
        write(before, &mut next[0]);
        self.used.set(number + 1);
        Slot { slots: self, number, factor: T::ONE }
    }

    /// `number` of every axis and body, which also gets the elements `a` and `b`.
    #[inline(always)]
    fn fill(
        &self,
        [a, b]: [usize; 2],
        number: impl Fn(usize, usize, &Full<T>, &Full<T>) -> T,
    ) -> Slot<'_, T> {
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
fn grow<T: Real>(blocks: &mut Vec<Full<T>>) {
    blocks.push(Block::ZERO);
}

impl<T: Real> Slot<'_, T> {
    /// The same element without a factor.
    #[inline(always)]
    fn plain(self) -> Self {
        if self.factor == T::ONE { self } else { self.multiplied() }
    }

    #[inline(never)]
    fn multiplied(self) -> Self {
        let Self { slots, number, factor } = self;
        slots.fill([number; 2], |axis, k, a, _| a.0[axis][k] * factor)
    }

    /// The sum, in one pass with the factors.
    #[inline(never)]
    fn sum(self, other: Self) -> Self {
        let (pair, p, q) = ([self.number, other.number], self.factor, other.factor);
        if p == T::ONE {
            self.slots.fill(pair, |axis, k, a, b| a.0[axis][k] + b.0[axis][k] * q)
        } else {
            self.slots.fill(pair, |axis, k, a, b| a.0[axis][k] * p + b.0[axis][k] * q)
        }
    }
}

impl<'s, T: Real> BlockSpace<T, BLOCK_BODIES> for Slot<'s, T> {
    type Memory = &'s Slots<T>;

    #[inline(always)]
    fn load(memory: &'s Slots<T>, write: impl FnOnce(&mut Full<T>)) -> Self {
        memory.add(|_, next| write(next))
    }

    #[inline(always)]
    fn read_both<R>(self, other: Self, read: impl FnOnce(&Full<T>, &Full<T>) -> R) -> R {
        let (a, b) = (self.plain(), other.plain());
        let blocks = self.slots.blocks.borrow();
        read(&blocks[a.number], &blocks[b.number])
    }

    #[inline(always)]
    fn write(self, other: Self, write: impl FnOnce(&Full<T>, &Full<T>, &mut Full<T>)) -> Self {
        let (a, b) = (self.plain().number, other.plain().number);
        self.slots.add(|before, next| write(&before[a], &before[b], next))
    }

    #[inline(always)]
    fn map(self, change: impl Fn(usize, usize, T) -> T) -> Self {
        let Self { slots, number, .. } = self.plain();
        slots.fill([number; 2], |axis, k, a, _| change(axis, k, a.0[axis][k]))
    }

    #[inline(always)]
    fn zip(self, other: Self, change: impl Fn(usize, usize, [T; 2]) -> T) -> Self {
        let (a, b) = (self.plain(), other.plain());
        self.slots.fill([a.number, b.number], |axis, k, a, b| change(axis, k, [a.0[axis][k], b.0[axis][k]]))
    }

    fn recycle(memory: &'s Slots<T>, kept: &mut [Self]) {
        kept.iter_mut().for_each(|slot| *slot = slot.plain());
        for place in 0..kept.len() {
            let from = kept[place].number;
            // Two of them may be one.
            if from < place {
                continue;
            }
            memory.blocks.borrow_mut().swap(place, from);
            for slot in &mut *kept {
                slot.number = match slot.number {
                    number if number == from => place,
                    number if number == place => from,
                    number => number,
                };
            }
        }
        memory.used.set(kept.len());
    }
}

impl<T: Real> Add for Slot<'_, T> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.sum(other)
    }
}

impl<T: Real> Sub for Slot<'_, T> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<T: Real> Neg for Slot<'_, T> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { factor: -self.factor, ..self }
    }
}

impl<T: Real> Mul<T> for Slot<'_, T> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self { factor, ..self.plain() }
    }
}
