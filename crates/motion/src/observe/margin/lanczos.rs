//! Largest eigenvalues of symmetric operators that are given as a function, by Lanczos's iteration.
//!
//! Written here, because a verdict needs a bound on the eigenvalue, which eigensolvers of libraries do not give, and the same bits
//! on every machine, which their linear algebra does not promise.

/// An eigenvalue and its vector of length 1.
pub(crate) type Pair = (f64, Vec<f64>);

/// Largest number of vectors in the basis.
const MOST_VECTORS: usize = 32;
/// Largest number of numbers in all vectors of the basis: the memory that a large group may take.
const MOST_NUMBERS: usize = 8_000_000;
/// Smallest number of vectors: with fewer, restarts would slow the iteration down.
const LEAST_VECTORS: usize = 8;

/// Largest number of products with the operator.
const MOST_PRODUCTS: usize = 400;
/// Largest number of numbers in the results of all products.
const MOST_WORK: usize = 100_000_000;
/// [`MOST_WORK`] when the iteration has to decide on which side of a threshold an eigenvalue is.
const MOST_WORK_TO_DECIDE: usize = 400_000_000;

/// Relative distances between the bounds of the largest eigenvalue at which the iteration stops, before and after
/// [`ENOUGH_WORK`]; the root of the eigenvalue is then known to half of that.
const TOLERANCES: [f64; 2] = [1e-3, 0.02];
/// Number of numbers in the results of products after which the larger of [`TOLERANCES`] is enough.
const ENOUGH_WORK: usize = 5_000_000;

/// Probability that a start vector has too small a share of the largest eigenvector.
const UNLIKELY: f64 = 1e-3;

/// The largest eigenpairs that were found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Largest {
    /// Ritz pairs, the largest first. Each value is a lower bound of the eigenvalue of the same rank.
    pub pairs: Vec<Pair>,
    /// Upper bound of the largest eigenvalue.
    pub at_most: f64,
}

/// Finds up to `count` of the largest eigenpairs of an operator on `n` numbers that is symmetric, positive
/// semidefinite, and has no eigenvalue above `bound` (Lanczos 1950, restarted with the best half of the basis: Wu,
/// Simon 2000). Finds fewer if `n` or the memory limits the basis. With a `threshold`, the iteration continues until the
/// largest eigenvalue is known to be above or below it, or to the first of [`TOLERANCES`].
pub(crate) fn largest(
    n: usize,
    count: usize,
    bound: f64,
    threshold: Option<f64>,
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
            // Numbers have overflowed.
            return Largest { pairs: Vec::new(), at_most: bound };
        }
        let m = basis.len();
        for (i, share) in shares.into_iter().enumerate() {
            (projected[i * most + m - 1], projected[(m - 1) * most + i]) = (share, share);
        }
        // The rest is rounding error: the basis spans every eigenvector that the start has a share of.
        let is_whole = m == n || length <= 1e-13 * size;
        if n < m * m * m && m < most && !is_whole {
            // Solving the projected problem would take longer than a product.
            next = product;
            continue;
        }
        ritz = symmetric_eigenpairs(
            projected.chunks(most).take(m).flat_map(|row| &row[..m]).copied().collect(),
            m,
        );
        let (value, residual) = (ritz[0].0, (length * ritz[0].1[m - 1]).abs());
        at_most = bound.min(if is_whole || residual <= TOLERANCES[0] * value {
            value + residual
        } else {
            value / (1.0 - missed(n, products)).max(0.0)
        });
        let may_end = m >= (2 * count).min(most);
        let work = products * n;
        let tolerance = TOLERANCES[usize::from(work >= ENOUGH_WORK && threshold.is_none())];
        let is_decided =
            threshold.is_some_and(|threshold| value >= threshold || at_most < threshold);
        let most_work = if threshold.is_some() { MOST_WORK_TO_DECIDE } else { MOST_WORK };
        let is_enough = at_most <= value * (1.0 + tolerance)
            || is_decided
            || products >= MOST_PRODUCTS
            || work >= most_work;
        if is_whole || may_end && is_enough {
            break;
        }
        if m == most {
            let best = &ritz[..m.div_ceil(2)];
            replace_basis(&mut basis, best);
            projected.fill(0.0);
            best.iter().enumerate().for_each(|(i, (value, _))| projected[i * most + i] = *value);
        }
        next = product;
    }
    let pairs = ritz.iter().take(count);
    let pairs = pairs.map(|(value, shares)| (value.max(0.0), combined(&basis, shares))).collect();
    Largest { pairs, at_most: at_most.max(0.0) }
}

/// Largest number of vectors of `n` numbers in the basis.
fn most_vectors(n: usize) -> usize {
    (MOST_NUMBERS / n.max(1)).clamp(LEAST_VECTORS, MOST_VECTORS).min(n)
}

/// Memory of the vectors for an operator on `n` numbers, bytes: the basis, the next vector, and the first result.
pub(crate) fn most_bytes(n: usize) -> usize {
    n.saturating_mul(size_of::<f64>() * (most_vectors(n) + 2))
}

/// Largest relative error of the first Ritz value after `products` products, for any operator and all but one start in a
/// thousand (Kuczynski, Wozniakowski 1992, theorem 4.2; restarts change this little).
#[expect(clippy::cast_precision_loss, reason = "a count of numbers")]
fn missed(n: usize, products: usize) -> f64 {
    let least = libm::log(1.648 * (n as f64).sqrt() / UNLIKELY) / (2.0 * products as f64 - 1.0);
    least * least
}

/// Replaces the basis by the Ritz vectors `best`, whose shares of the basis are given. It does so number by number,
/// because a second basis would be the largest part of the memory of the forecast.
fn replace_basis(basis: &mut Vec<Vec<f64>>, best: &[Pair]) {
    let mut row = vec![0.0; basis.len()];
    for i in 0..basis.first().map_or(0, Vec::len) {
        row.iter_mut().zip(&*basis).for_each(|(part, vector)| *part = vector[i]);
        basis.iter_mut().zip(best).for_each(|(vector, (_, shares))| vector[i] = dot(shares, &row));
    }
    basis.truncate(best.len());
}

/// The linear combination of the vectors of a basis with those factors.
pub(super) fn combined(basis: &[Vec<f64>], factors: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; basis.first().map_or(0, Vec::len)];
    for (factor, vector) in factors.iter().zip(basis) {
        sum.iter_mut().zip(vector).for_each(|(sum, part)| *sum += factor * part);
    }
    sum
}

/// A start vector of random numbers in [-1, 1), which has a share of every eigenvector (`SplitMix64`).
pub(super) fn scattered(n: usize) -> Vec<f64> {
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

/// Subtracts from a vector its projection on an orthonormal basis (Gram-Schmidt) and returns the shares. The newest
/// vector comes first because a product has its largest share there: in the other order rounding errors would grow
/// several times with each step.
pub(super) fn orthogonalize(vector: &mut [f64], basis: &[Vec<f64>]) -> Vec<f64> {
    let mut shares = vec![0.0; basis.len()];
    let mut before = dot(vector, vector);
    // Twice if the projection was nearly all of the vector: the rounding error of the first pass would dominate the
    // rest.
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
pub(super) fn symmetric_eigenpairs(mut a: Vec<f64>, n: usize) -> Vec<Pair> {
    let mut vectors = vec![0.0; n * n];
    (0..n).for_each(|i| vectors[i * n + i] = 1.0);
    for _ in 0..40 {
        let outside: f64 = (0..n)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| a[i * n + j] * a[i * n + j])
            .sum();
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
    let mut pairs: Vec<Pair> =
        (0..n).map(|i| (a[i * n + i], vectors[i * n..(i + 1) * n].to_vec())).collect();
    pairs.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    pairs
}

/// Rotates one entry to 0, and the rows of `vectors` with it.
fn rotate(a: &mut [f64], vectors: &mut [f64], n: usize, p: usize, q: usize) {
    let off = a[p * n + q];
    if off == 0.0 {
        return;
    }
    let theta = (a[q * n + q] - a[p * n + p]) / (2.0 * off);
    let t = 1.0_f64.copysign(theta) / (theta.abs() + (theta * theta + 1.0).sqrt());
    let cos = 1.0 / (t * t + 1.0).sqrt();
    let sin = t * cos;
    let rotate_pair = |a: &mut [f64], i: usize, j: usize| {
        let (x, y) = (a[i], a[j]);
        (a[i], a[j]) = (cos * x - sin * y, sin * x + cos * y);
    };
    for k in 0..n {
        rotate_pair(a, k * n + p, k * n + q);
    }
    for k in 0..n {
        rotate_pair(a, p * n + k, q * n + k);
        rotate_pair(vectors, p * n + k, q * n + k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain between two walls, whose eigenvalues are `2 - 2 cos` of multiples of pi / (n + 1).
    fn chain(x: &[f64], out: &mut [f64]) {
        for i in 0..x.len() {
            let before = if i == 0 { 0.0 } else { x[i - 1] };
            out[i] = 2.0 * x[i] - before - x.get(i + 1).copied().unwrap_or(0.0);
        }
    }

    #[test]
    fn the_largest_of_a_chain_is_its_closed_form() {
        for n in [1_u32, 2, 5, 40, 300] {
            let Largest { pairs, at_most } = largest(n as usize, 3, f64::INFINITY, None, chain);
            let exact = 2.0 + 2.0 * libm::cos(std::f64::consts::PI / f64::from(n + 1));
            let (value, vector) = &pairs[0];
            assert!((value / exact - 1.0).abs() <= TOLERANCES[0], "{n}: {value} for {exact}");
            assert!(exact <= at_most * (1.0 + 1e-12) && at_most <= value * 1.002, "{n}: {at_most}");
            assert!((dot(vector, vector) - 1.0).abs() < 1e-9, "{n}");
            assert!(pairs.is_sorted_by(|a, b| a.0 >= b.0));
        }
    }

    /// The method has no threshold of size: more numbers only widen the bounds, to 1 % of the root.
    #[test]
    fn the_largest_of_a_long_chain_lies_between_its_bounds() {
        for n in [3_000_u32, 30_000, 300_000, 3_000_000] {
            let exact = 2.0 + 2.0 * libm::cos(std::f64::consts::PI / f64::from(n + 1));
            for bound in [4.0, 6.0] {
                let mut products = 0;
                let Largest { pairs, at_most } = largest(n as usize, 1, bound, None, |x, out| {
                    products += 1;
                    chain(x, out);
                });
                let value = pairs[0].0;
                assert!(
                    value <= exact * (1.0 + 1e-12) && exact <= at_most,
                    "{n}: {value} {exact} {at_most}"
                );
                assert!(
                    at_most <= bound && (bound > 4.0 || at_most <= 1.02 * value),
                    "{n}: {value} {at_most}"
                );
                assert!(value >= 0.98 * exact, "{n}: {value} in {products}");
            }
        }
    }

    #[test]
    fn a_threshold_near_the_largest_of_a_long_chain_is_decided() {
        let n = 300_000_u32;
        let exact = 2.0 + 2.0 * libm::cos(std::f64::consts::PI / f64::from(n + 1));
        let find = |threshold| largest(n as usize, 1, 6.0, threshold, chain);
        let Largest { pairs, at_most } = find(None);
        // Without a threshold it is not decided.
        let (below, above) = (0.9 * pairs[0].0 + 0.1 * exact, at_most.midpoint(exact));
        assert!(pairs[0].0 < below && above < at_most, "{below} {above}");
        assert!(find(Some(below)).pairs[0].0 >= below);
        assert!(find(Some(above)).at_most < above);
    }

    /// Ritz values of a basis that has lost orthogonality would exceed every eigenvalue.
    #[test]
    fn no_value_is_above_the_largest_of_an_operator_that_has_few_eigenvalues() {
        // A third of the numbers is a chain, the others map to 0.
        let apply = |x: &[f64], out: &mut [f64]| {
            out.fill(0.0);
            let (part, rest) = (x.len() / 3, x.len() / 3 * 3);
            let third: Vec<f64> = x[..rest].iter().step_by(3).copied().collect();
            let mut product = vec![0.0; part];
            chain(&third, &mut product);
            out[..rest]
                .iter_mut()
                .step_by(3)
                .zip(product)
                .for_each(|(out, product)| *out = product);
        };
        for third in [20_u32, 39, 60, 200] {
            let found = largest(3 * third as usize, 12, f64::INFINITY, None, apply);
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
        assert!(largest(0, 3, f64::INFINITY, None, |_, _| ()).pairs.is_empty());
        assert_eq!(largest(4, 2, f64::INFINITY, None, |_, out| out.fill(0.0)).pairs[0].0, 0.0);
    }

    #[test]
    fn what_is_not_finite_has_no_largest() {
        for wrong in [f64::NAN, f64::INFINITY, 1e300] {
            let found = largest(5, 2, f64::INFINITY, None, |x, out| {
                out.iter_mut().zip(x).for_each(|(out, x)| *out = wrong * wrong * x);
            });
            assert!(found.pairs.is_empty() && found.at_most == f64::INFINITY, "{wrong}: {found:?}");
        }
    }
}
