//! Largest eigenvalues of symmetric operators without a matrix.

/// An eigenvalue and its vector of length 1.
pub(crate) type Pair = (f64, Vec<f64>);

/// Vectors kept at most, and numbers in all of them: what a large net may cost.
const MOST_VECTORS: usize = 32;
const MOST_NUMBERS: usize = 8_000_000;
/// Vectors below which restarts would slow the iteration down.
const LEAST_VECTORS: usize = 8;

/// Products with the operator at most, and numbers in all of their results.
const MOST_PRODUCTS: usize = 400;
const MOST_WORK: usize = 100_000_000;

/// How far apart the bounds of the largest eigenvalue may be when it stops, relative to it: the root of the eigenvalue is
/// then known to half of that. The second one where the first would take more than [`ENOUGH_WORK`].
const TOLERANCES: [f64; 2] = [1e-3, 0.02];
const ENOUGH_WORK: usize = 5_000_000;

/// How likely a start is that has too little of the largest eigenvector.
const UNLIKELY: f64 = 1e-3;

/// The largest eigenpairs, as far as they were found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Largest {
    /// Ritz pairs, the largest first: no value is above the eigenvalue of its place.
    pub pairs: Vec<Pair>,
    /// What the largest eigenvalue is at most.
    pub at_most: f64,
}

/// At most `count` of the largest eigenpairs of an operator on `n` numbers that is symmetric, positive semidefinite, and
/// has no eigenvalue above `bound` (Lanczos 1950, restarted with the best half of the basis: Wu, Simon 2000). Fewer where
/// `n` leaves no room for so many.
pub(crate) fn largest(
    n: usize,
    count: usize,
    bound: f64,
    mut apply: impl FnMut(&[f64], &mut [f64]),
) -> Largest {
    if n == 0 {
        return Largest::default();
    }
    let most = most_vectors(n);
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(most);
    let mut projected = vec![0.0; most * most];
    let mut ritz: Vec<Pair> = Vec::new();
    let (mut at_most, mut size) = (bound, 0.0_f64);
    let mut next = scattered(n);
    let mut length = dot(&next, &next).sqrt();
    for products in 1.. {
        next.iter_mut().for_each(|part| *part /= length);
        let mut product = vec![0.0; n];
        apply(&next, &mut product);
        size = size.max(dot(&product, &product).sqrt());
        basis.push(next);
        let shares = orthogonalize(&mut product, &basis);
        length = dot(&product, &product).sqrt();
        if !length.is_finite() {
            // Numbers have grown out of their range.
            return Largest { pairs: Vec::new(), at_most: bound };
        }
        let m = basis.len();
        for (i, share) in shares.into_iter().enumerate() {
            (projected[i * most + m - 1], projected[(m - 1) * most + i]) = (share, share);
        }
        // What is left is rounding: the basis has all that the start has something of.
        let is_whole = m == n || length <= 1e-13 * size;
        if n < m * m * m && m < most && !is_whole {
            // A look would take longer than a product.
            next = product;
            continue;
        }
        ritz = symmetric(projected.chunks(most).take(m).flat_map(|row| &row[..m]).copied().collect(), m);
        let (value, residual) = (ritz[0].0, (length * ritz[0].1[m - 1]).abs());
        at_most = bound.min(if is_whole || residual <= TOLERANCES[0] * value {
            value + residual
        } else {
            value / (1.0 - missed(n, products)).max(0.0)
        });
        let may_end = m >= (2 * count).min(most);
        let work = products * n;
        let tolerance = TOLERANCES[usize::from(work >= ENOUGH_WORK)];
        let is_enough =
            at_most <= value * (1.0 + tolerance) || products >= MOST_PRODUCTS || work >= MOST_WORK;
        if is_whole || may_end && is_enough {
            break;
        }
        if m == most {
            let best = &ritz[..m.div_ceil(2)];
            turn(&mut basis, best);
            projected.fill(0.0);
            best.iter().enumerate().for_each(|(i, (value, _))| projected[i * most + i] = *value);
        }
        next = product;
    }
    let pairs = ritz.iter().take(count);
    let pairs = pairs.map(|(value, shares)| (value.max(0.0), combined(&basis, shares))).collect();
    Largest { pairs, at_most: at_most.max(0.0) }
}

/// How many vectors of `n` numbers the basis has at most.
fn most_vectors(n: usize) -> usize {
    (MOST_NUMBERS / n.max(1)).clamp(LEAST_VECTORS, MOST_VECTORS).min(n)
}

/// Bytes of the vectors for an operator on `n` numbers: the basis, the next one, and the first of the results.
pub(crate) fn most_bytes(n: usize) -> usize {
    n.saturating_mul(size_of::<f64>() * (most_vectors(n) + 2))
}

/// What part of the largest eigenvalue the first Ritz value lacks at most after so many products, but for one start in a
/// thousand, whatever the operator (Kuczynski, Wozniakowski 1992, theorem 4.2; restarts cost next to nothing of it).
#[expect(clippy::cast_precision_loss, reason = "a count of numbers")]
fn missed(n: usize, products: usize) -> f64 {
    let least = libm::log(1.648 * (n as f64).sqrt() / UNLIKELY) / (2.0 * products as f64 - 1.0);
    least * least
}

/// Puts the Ritz vectors `best` in the place of the basis that they are shares of, number by number: a second basis would
/// be the largest part of what the forecast of a large world takes.
fn turn(basis: &mut Vec<Vec<f64>>, best: &[Pair]) {
    let mut row = vec![0.0; basis.len()];
    for i in 0..basis.first().map_or(0, Vec::len) {
        row.iter_mut().zip(&*basis).for_each(|(part, vector)| *part = vector[i]);
        basis.iter_mut().zip(best).for_each(|(vector, (_, shares))| vector[i] = dot(shares, &row));
    }
    basis.truncate(best.len());
}

/// The sum of the vectors of a basis, each times its factor.
fn combined(basis: &[Vec<f64>], factors: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; basis.first().map_or(0, Vec::len)];
    for (factor, vector) in factors.iter().zip(basis) {
        sum.iter_mut().zip(vector).for_each(|(sum, part)| *sum += factor * part);
    }
    sum
}

/// Numbers in [-1, 1) that have something of every eigenvector (`SplitMix64`).
fn scattered(n: usize) -> Vec<f64> {
    let mut state = 0_u64;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let upper = ((z ^ (z >> 31)) >> 32) as u32;
        f64::from(upper) / f64::from(1_u32 << 31) - 1.0
    };
    (0..n).map(|_| next()).collect()
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes out of a vector what an orthonormal basis has of it (Gram-Schmidt), and says how much that was. The newest
/// first, of which a product has most: in the other order the rounding of each step would be several times that of the
/// step before.
pub(super) fn orthogonalize(vector: &mut [f64], basis: &[Vec<f64>]) -> Vec<f64> {
    let mut shares = vec![0.0; basis.len()];
    let mut before = dot(vector, vector);
    // Again where so much was taken out that what rounding leaves of it would come back as a copy.
    for _ in 0..2 {
        for (other, sum) in basis.iter().zip(&mut shares).rev() {
            let share = dot(other, vector);
            vector.iter_mut().zip(other).for_each(|(part, other)| *part -= share * other);
            *sum += share;
        }
        let after = dot(vector, vector);
        if after > 1e-4 * before {
            break;
        }
        before = after;
    }
    shares
}

/// Eigenpairs of a symmetric matrix by rows, the largest first (Jacobi 1846).
fn symmetric(mut a: Vec<f64>, n: usize) -> Vec<Pair> {
    let mut vectors = vec![0.0; n * n];
    (0..n).for_each(|i| vectors[i * n + i] = 1.0);
    for _ in 0..40 {
        let outside: f64 =
            (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i * n + j] * a[i * n + j]).sum();
        let inside: f64 = (0..n).map(|i| a[i * n + i] * a[i * n + i]).sum();
        if outside <= 1e-30 * inside {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                rotate(&mut a, &mut vectors, n, p, q);
            }
        }
    }
    let mut pairs: Vec<Pair> = (0..n).map(|i| (a[i * n + i], vectors[i * n..(i + 1) * n].to_vec())).collect();
    pairs.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    pairs
}

/// Makes one entry 0; the rows of `vectors` are turned along.
fn rotate(a: &mut [f64], vectors: &mut [f64], n: usize, p: usize, q: usize) {
    let off = a[p * n + q];
    if off == 0.0 {
        return;
    }
    let theta = (a[q * n + q] - a[p * n + p]) / (2.0 * off);
    let t = 1.0_f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
    let cos = 1.0 / (t * t + 1.0).sqrt();
    let sin = t * cos;
    let turn = |a: &mut [f64], i: usize, j: usize| {
        let (x, y) = (a[i], a[j]);
        (a[i], a[j]) = (cos * x - sin * y, sin * x + cos * y);
    };
    for k in 0..n {
        turn(a, k * n + p, k * n + q);
    }
    for k in 0..n {
        turn(a, p * n + k, q * n + k);
        turn(vectors, p * n + k, q * n + k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain between two walls: `2 - 2 cos` of multiples of pi / (n + 1).
    fn chain(x: &[f64], out: &mut [f64]) {
        for i in 0..x.len() {
            let before = if i == 0 { 0.0 } else { x[i - 1] };
            out[i] = 2.0 * x[i] - before - x.get(i + 1).copied().unwrap_or(0.0);
        }
    }

    #[test]
    fn the_largest_of_a_chain_is_its_closed_form() {
        for n in [1_u32, 2, 5, 40, 300] {
            let Largest { pairs, at_most } = largest(n as usize, 3, f64::INFINITY, chain);
            let exact = 2.0 + 2.0 * libm::cos(std::f64::consts::PI / f64::from(n + 1));
            let (value, vector) = &pairs[0];
            assert!((value / exact - 1.0).abs() <= TOLERANCES[0], "{n}: {value} for {exact}");
            assert!(exact <= at_most * (1.0 + 1e-12) && at_most <= value * 1.002, "{n}: {at_most}");
            assert!((dot(vector, vector) - 1.0).abs() < 1e-9, "{n}");
            assert!(pairs.is_sorted_by(|a, b| a.0 >= b.0));
        }
    }

    /// No sizes at which another way is taken: more numbers only widen what is known, to 1 % of the root.
    #[test]
    fn the_largest_of_a_long_chain_lies_between_its_bounds() {
        for n in [3_000_u32, 30_000, 300_000, 3_000_000] {
            let exact = 2.0 + 2.0 * libm::cos(std::f64::consts::PI / f64::from(n + 1));
            for bound in [4.0, 6.0] {
                let mut products = 0;
                let Largest { pairs, at_most } = largest(n as usize, 1, bound, |x, out| {
                    products += 1;
                    chain(x, out);
                });
                let value = pairs[0].0;
                assert!(value <= exact * (1.0 + 1e-12) && exact <= at_most, "{n}: {value} {exact} {at_most}");
                assert!(
                    at_most <= bound && (bound > 4.0 || at_most <= 1.02 * value),
                    "{n}: {value} {at_most}"
                );
                assert!(value >= 0.98 * exact, "{n}: {value} in {products}");
            }
        }
    }

    /// Ritz values of a basis that is not orthogonal any more would be above every eigenvalue.
    #[test]
    fn no_value_is_above_the_largest_of_an_operator_that_has_few_eigenvalues() {
        // A third of the numbers is a chain, the others are nothing.
        let apply = |x: &[f64], out: &mut [f64]| {
            out.fill(0.0);
            let (part, rest) = (x.len() / 3, x.len() / 3 * 3);
            let third: Vec<f64> = x[..rest].iter().step_by(3).copied().collect();
            let mut product = vec![0.0; part];
            chain(&third, &mut product);
            out[..rest].iter_mut().step_by(3).zip(product).for_each(|(out, product)| *out = product);
        };
        for third in [20_u32, 39, 60, 200] {
            let found = largest(3 * third as usize, 12, f64::INFINITY, apply);
            let exact = 2.0 + 2.0 * libm::cos(std::f64::consts::PI / f64::from(third + 1));
            let value = found.pairs[0].0;
            assert!(
                (1.0 - TOLERANCES[0]..=1.0 + 1e-12).contains(&(value / exact)),
                "{third}: {value} {exact}"
            );
        }
    }

    #[test]
    fn nothing_is_the_largest_of_nothing() {
        assert!(largest(0, 3, f64::INFINITY, |_, _| ()).pairs.is_empty());
        assert_eq!(largest(4, 2, f64::INFINITY, |_, out| out.fill(0.0)).pairs[0].0, 0.0);
    }

    #[test]
    fn what_is_not_finite_has_no_largest() {
        for wrong in [f64::NAN, f64::INFINITY, 1e300] {
            let found = largest(5, 2, f64::INFINITY, |x, out| {
                out.iter_mut().zip(x).for_each(|(out, x)| *out = wrong * wrong * x);
            });
            assert!(found.pairs.is_empty() && found.at_most == f64::INFINITY, "{wrong}: {found:?}");
        }
    }
}
