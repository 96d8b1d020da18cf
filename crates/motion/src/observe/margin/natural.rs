//! The natural modes of bodies joined by springs, each with its frequency and damping.

use bevy_ecs::prelude::*;

use super::lanczos::{Pair, combined, dot, orthogonalize, scattered, symmetric_eigenpairs};
use crate::groups::{LinearGroup, Terms, coming_couplings, couplings};
use crate::units::Scalar;

/// A natural mode: bodies joined by springs swing at one frequency, and all come to rest at the same times.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct NaturalMode {
    /// Its frequency without damping, rad/s, above 0.
    pub angular_frequency: Scalar,
    /// Damping over critical damping; 0 without damping. The mode swings at `angular_frequency sqrt(1 - damping_ratio²)` and
    /// decays as `exp(-damping_ratio angular_frequency t)`. The ratio is exact if damping is proportional to masses or to
    /// stiffnesses, and of first order in the damping otherwise.
    pub damping_ratio: Scalar,
    /// Whether the frequency is an upper bound: of a group of more than 40 bodies, only the restoring part of wells counts.
    pub is_upper_bound: bool,
    /// The bodies that move most, up to [`NaturalMode::BODIES`], with their amplitudes over that of the first.
    pub bodies: Vec<(Entity, Scalar)>,
}

impl NaturalMode {
    /// Most bodies that a mode names.
    pub const BODIES: usize = 3;
}

/// The slowest and the fastest natural modes of a world.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct NaturalModes {
    /// The slowest, ascending.
    pub lowest: Vec<NaturalMode>,
    /// The fastest that are not among the slowest, ascending.
    pub highest: Vec<NaturalMode>,
}

impl NaturalModes {
    /// Most modes of each kind.
    pub const MOST: usize = 20;
}

/// Most coordinates of a group all of whose modes are computed.
const MOST_WHOLE: usize = 120;

/// Squared frequencies below this, over the largest of the group, are rounding.
const LEAST: Scalar = 1e-11;

/// Computes up to `count` of the slowest and of the fastest natural modes of all groups of `world`, linearized in the
/// present state: springs, wells, drag and damping.
///
/// A motion without a restoring force has no frequency and is no mode: a free group drifts, and a spring at its rest length
/// has no stiffness across its axis. A compressed spring, whose stiffness across its axis is negative, counts as one at its
/// rest length there. Groups whose bodies attract each other have no modes. `count` is at most [`NaturalModes::MOST`].
///
/// Groups of up to 40 bodies are solved as a whole (Jacobi 1846), larger ones by block Krylov subspaces (Golub, Underwood 1977;
/// restarted with the best vectors: Wu, Simon 2000), for the slowest modes on shifted inverses, by conjugate gradients. In
/// larger groups a mode that is a thousand times slower than all others may be missed.
#[must_use]
pub fn natural_modes(world: &World, count: usize) -> NaturalModes {
    let count = count.min(NaturalModes::MOST);
    if count == 0 {
        return NaturalModes::default();
    }
    let (mut lowest, mut highest) = (Vec::new(), Vec::new());
    let coming = coming_couplings(world);
    for (at, (coupling, bodies)) in couplings(world, coming.as_deref()).enumerate() {
        if coupling.springs.is_empty() || coupling.attracts {
            continue;
        }
        let mut group = LinearGroup::of(world, coupling, bodies);
        let [low, high] = if group.coordinates() <= MOST_WHOLE {
            group = group.with_whole_wells(world, bodies);
            of_matrix(&group, count)
        } else {
            of_subspaces(&group, count)
        };
        let found =
            |(number, (squared, y)): Numbered| ((at, number), mode(&group, bodies, squared, &y));
        lowest.extend(low.into_iter().map(found));
        highest.extend(high.into_iter().map(found));
        keep(&mut lowest, count, |a, b| a.total_cmp(&b));
        // Twice as many: `count` of them may be among the slowest.
        keep(&mut highest, 2 * count, |a, b| b.total_cmp(&a));
    }
    highest.retain(|(number, _)| lowest.iter().all(|(other, _)| number != other));
    highest.truncate(count);
    highest.reverse();
    let modes = |found: Vec<Found>| found.into_iter().map(|(_, mode)| mode).collect();
    NaturalModes { lowest: modes(lowest), highest: modes(highest) }
}

/// A mode with its number in its group.
type Numbered = (usize, Pair);

/// A mode with its group and its number in it.
type Found = ((usize, usize), NaturalMode);

/// Keeps the first `count` modes in that order of their frequencies.
fn keep(found: &mut Vec<Found>, count: usize, order: fn(Scalar, Scalar) -> std::cmp::Ordering) {
    found.sort_by(|(_, a), (_, b)| order(a.angular_frequency, b.angular_frequency));
    found.truncate(count);
}

/// The product of the stiffness of a group with a vector.
fn stiffness(group: &LinearGroup<'_>) -> impl Fn(&[Scalar], &mut [Scalar]) + Copy {
    |y, out| group.apply_laws(Terms::STIFFNESS, y, out)
}

/// The `count` slowest and twice as many of the fastest modes of a group, as squared frequencies and vectors of length 1, from
/// the whole matrix.
fn of_matrix(group: &LinearGroup<'_>, count: usize) -> [Vec<Numbered>; 2] {
    let n = group.coordinates();
    let unit = |j: usize| (0..n).map(|i| if i == j { 1.0 } else { 0.0 }).collect::<Vec<_>>();
    // Symmetric: its columns are its rows.
    let matrix: Vec<_> = (0..n).flat_map(|j| image(&stiffness(group), &unit(j))).collect();
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return Default::default();
    }
    let mut pairs = symmetric_eigenpairs(matrix, n);
    let least = LEAST * pairs.first().map_or(0.0, |(largest, _)| *largest);
    pairs.retain(|(value, _)| *value > least);
    pairs.reverse();
    let all: Vec<_> = pairs.into_iter().enumerate().collect();
    let slow = all.iter().take(count).cloned().collect();
    [slow, all.into_iter().rev().take(2 * count).collect()]
}

/// The `count` slowest and as many of the fastest modes of a group that has far more, as [`of_matrix`] gives them, from Krylov
/// subspaces.
fn of_subspaces(group: &LinearGroup<'_>, count: usize) -> [Vec<Numbered>; 2] {
    let (n, stiffness) = (group.coordinates(), stiffness(group));
    // Products with the stiffness: they have no share of motions without a restoring force.
    let start = || {
        let numbers = scattered(n * (count + BESIDE).min(n));
        numbers.chunks(n).map(|numbers| image(&stiffness, numbers)).collect::<Vec<_>>()
    };
    let mut fast = extreme(start(), count, MOST_RESTARTS[0], stiffness);
    let Some((largest, _)) = fast.first() else { return Default::default() };
    let least = LEAST * largest;
    // The largest values of `p / (p + s)²` belong to the smallest p above s. Motions without a frequency have the value 0, and
    // rounding lets in little of them while s is not far below the p that are searched for.
    let mut shift = 1e-3 * largest;
    let mut basis: Vec<Vec<Scalar>> = Vec::new();
    let slow = loop {
        let shifted = |y: &[Scalar], out: &mut [Scalar]| {
            stiffness(y, out);
            out.iter_mut().zip(y).for_each(|(out, y)| *out += shift * y);
        };
        let found = extreme(start(), count, MOST_RESTARTS[1], |y, out| {
            let [mut once, mut twice] = [vec![0.0; n], vec![0.0; n]];
            solve(&shifted, y, &mut once);
            solve(&shifted, &once, &mut twice);
            stiffness(&twice, out);
        });
        // Modes near a shift are the most accurate: the basis collects those of all shifts.
        found.into_iter().for_each(|(_, y)| add(&mut basis, y));
        let mut slow = ritz(&basis, stiffness);
        slow.reverse();
        slow.retain(|(value, _)| *value > least);
        slow.truncate(count);
        match slow.first() {
            Some((slowest, _)) if *slowest < 500.0 * shift && shift > least => shift /= 100.0,
            _ => break slow,
        }
    };
    // In a group with few modes the fastest are among the slowest.
    let share = |y: &[Scalar], (_, other): &Pair| dot(y, other) * dot(y, other);
    let is_slow = |y: &[Scalar]| slow.iter().map(|other| share(y, other)).sum::<Scalar>() > 0.5;
    fast.retain(|(value, y)| *value > least && !is_slow(y));
    let slow: Vec<_> = slow.into_iter().enumerate().collect();
    // Their numbers continue those of the slowest.
    let fast = fast.into_iter().enumerate().map(|(number, pair)| (count + number, pair));
    [slow, fast.collect()]
}

/// A mode in physical quantities; `squared` is the square of its angular frequency.
fn mode(group: &LinearGroup<'_>, bodies: &[Entity], squared: Scalar, y: &[Scalar]) -> NaturalMode {
    let angular_frequency = squared.sqrt();
    let mut product = vec![0.0; y.len()];
    group.apply(Terms::DAMPING, y, &mut product);
    let damping_ratio = dot(y, &product).max(0.0) / (2.0 * angular_frequency);
    let mut moved: Vec<_> = bodies.iter().copied().zip(group.amplitudes(y)).collect();
    moved.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    moved.truncate(NaturalMode::BODIES);
    let most = moved.first().map_or(1.0, |(_, most)| *most);
    moved.retain_mut(|(_, amplitude)| {
        *amplitude /= most;
        *amplitude > 1e-6
    });
    let is_upper_bound = group.coordinates() > MOST_WHOLE && group.largest_pull() > 0.0;
    NaturalMode { angular_frequency, damping_ratio, is_upper_bound, bodies: moved }
}

/// Vectors of a block in addition to the modes that are searched for: a repeated eigenvalue is found as often as it occurs, up
/// to this many more times.
const BESIDE: usize = 4;

/// Number of blocks in the basis.
const BLOCKS: usize = 4;

/// Most restarts for the fastest modes, and for the slowest ones at each shift.
const MOST_RESTARTS: [usize; 2] = [300, 30];

/// Length of the residual of an eigenpair over its eigenvalue at which the pair counts as found: the relative error of the
/// eigenvalue is at most that.
const FOUND: Scalar = 1e-6;

/// Finds `count` of the largest eigenpairs of a symmetric positive semidefinite operator, the largest first, in the Krylov
/// subspaces of the block `next`, with at most `most_restarts` restarts.
fn extreme(
    mut next: Vec<Vec<Scalar>>,
    count: usize,
    most_restarts: usize,
    apply: impl Fn(&[Scalar], &mut [Scalar]),
) -> Vec<Pair> {
    let (block, n) = (next.len(), next.first().map_or(0, Vec::len));
    let most = (BLOCKS * block).min(n);
    let (mut basis, mut images): (Vec<Vec<Scalar>>, Vec<Vec<Scalar>>) = Default::default();
    let mut found = Vec::new();
    for _ in 0..most_restarts {
        while basis.len() < most && !next.is_empty() {
            let mut added = Vec::new();
            for mut vector in std::mem::take(&mut next) {
                let before = dot(&vector, &vector).sqrt();
                orthogonalize(&mut vector, &basis);
                let length = dot(&vector, &vector).sqrt();
                // The remainder of other vectors is rounding error.
                if basis.len() < most && length > 1e-5 * before && length.is_finite() {
                    vector.iter_mut().for_each(|part| *part /= length);
                    images.push(image(&apply, &vector));
                    added.push(images[basis.len()].clone());
                    basis.push(vector);
                }
            }
            next = added;
        }
        let m = basis.len();
        let projected =
            basis.iter().flat_map(|row| images.iter().map(|image| dot(row, image))).collect();
        let best: Vec<_> = symmetric_eigenpairs(projected, m).into_iter().take(block).collect();
        let vectors: Vec<_> = best.iter().map(|(_, shares)| combined(&basis, shares)).collect();
        images = best.iter().map(|(_, shares)| combined(&images, shares)).collect();
        found =
            best.iter().map(|(value, _)| *value).zip(vectors.iter().cloned()).take(count).collect();
        let mut is_found = true;
        next = Vec::new();
        for (number, (((value, _), vector), image)) in
            best.iter().zip(&vectors).zip(&images).enumerate()
        {
            let left: Vec<_> =
                image.iter().zip(vector).map(|(image, part)| image - value * part).collect();
            let size = dot(&left, &left).sqrt();
            is_found &= number >= count || size <= FOUND * value.abs();
            // The residual of a pair that is found is rounding error.
            if size > 0.1 * FOUND * value.abs() {
                next.push(left);
            }
        }
        if is_found || m == n {
            break;
        }
        basis = vectors;
    }
    found
}

/// The product of an operator with a vector.
fn image(apply: &impl Fn(&[Scalar], &mut [Scalar]), y: &[Scalar]) -> Vec<Scalar> {
    let mut out = vec![0.0; y.len()];
    apply(y, &mut out);
    out
}

/// Extends an orthonormal basis by the normalized part of a vector that the basis does not span.
fn add(basis: &mut Vec<Vec<Scalar>>, mut vector: Vec<Scalar>) {
    orthogonalize(&mut vector, basis);
    let length = dot(&vector, &vector).sqrt();
    if length > 1e-7 {
        vector.iter_mut().for_each(|part| *part /= length);
        basis.push(vector);
    }
}

/// The eigenpairs of an operator in the span of an orthonormal basis, the largest first.
fn ritz(basis: &[Vec<Scalar>], apply: impl Fn(&[Scalar], &mut [Scalar])) -> Vec<Pair> {
    let images: Vec<_> = basis.iter().map(|y| image(&apply, y)).collect();
    let projected =
        basis.iter().flat_map(|row| images.iter().map(|image| dot(row, image))).collect();
    let pairs = symmetric_eigenpairs(projected, basis.len()).into_iter();
    pairs.map(|(value, shares)| (value, combined(basis, &shares))).collect()
}

/// Most products for a solution.
const MOST_PRODUCTS: usize = 20_000;

/// Solves `apply(x) = right` for a positive definite operator by conjugate gradients.
fn solve(apply: &impl Fn(&[Scalar], &mut [Scalar]), right: &[Scalar], x: &mut [Scalar]) {
    x.fill(0.0);
    let (mut left, mut along, mut product) =
        (right.to_vec(), right.to_vec(), vec![0.0; right.len()]);
    let (mut size, enough) = (dot(right, right), 1e-16 * dot(right, right));
    for _ in 0..MOST_PRODUCTS {
        apply(&along, &mut product);
        let curvature = dot(&along, &product);
        if size <= enough || curvature <= 0.0 || !curvature.is_finite() {
            break;
        }
        let by = size / curvature;
        x.iter_mut().zip(&along).for_each(|(x, along)| *x += by * along);
        left.iter_mut().zip(&product).for_each(|(left, product)| *left -= by * product);
        let before = std::mem::replace(&mut size, dot(&left, &left));
        let share = size / before;
        along.iter_mut().zip(&left).for_each(|(along, left)| *along = left + share * *along);
    }
}
