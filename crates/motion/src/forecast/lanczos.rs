//! Largest eigenvalues of symmetric operators without a matrix.

/// An eigenvalue and its vector of length 1.
pub(crate) type Pair = (f64, Vec<f64>);

/// Vectors kept at most, and numbers in all of them: what a large net may cost.
const MOST_VECTORS: usize = 32;
const MOST_NUMBERS: usize = 8_000_000;
/// Vectors without which it goes nowhere.
const LEAST_VECTORS: usize = 3;

/// How often the iteration starts anew from the best vector that it has.
const MOST_CYCLES: usize = 12;

/// Residual, relative to the eigenvalue, at which it stops: the root of the value is then within half of it.
const TOLERANCE: f64 = 1e-3;

/// What was found of the largest eigenpairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Largest {
    /// The largest first.
    pub pairs: Vec<Pair>,
    /// Whether the first is within 1e-3; all are bounds from below.
    pub converged: bool,
}

/// At most `count` of the largest eigenpairs of an operator on `n` numbers that is symmetric and positive semidefinite
/// (Lanczos 1950; power iteration that forgets nothing). Fewer where `n` leaves no room for so many.
pub(crate) fn largest(n: usize, count: usize, mut apply: impl FnMut(&[f64], &mut [f64])) -> Largest {
    if n == 0 {
        return Largest { pairs: Vec::new(), converged: true };
    }
    let vectors = MOST_VECTORS.min(n).min((MOST_NUMBERS / n).max(LEAST_VECTORS));
    let mut start = scattered(n);
    let mut found = Largest::default();
    for _ in 0..MOST_CYCLES {
        let (basis, alpha, beta) = tridiagonal(start, vectors, &mut apply);
        let m = basis.len();
        // None where numbers have grown out of their range.
        let Some(end) = m.checked_sub(1) else { break };
        let mut dense = vec![0.0; m * m];
        for i in 0..m {
            dense[i * m + i] = alpha[i];
            if i + 1 < m {
                (dense[i * m + i + 1], dense[(i + 1) * m + i]) = (beta[i], beta[i]);
            }
        }
        let eigen = symmetric(dense, m);
        let left = beta.get(end).copied().unwrap_or(0.0);
        let residual = eigen.first().map_or(0.0, |(_, s)| (left * s[end]).abs());
        let value = eigen.first().map_or(0.0, |(value, _)| *value);
        let combine = |s: &[f64]| {
            let mut vector = vec![0.0; n];
            for (factor, basis) in s.iter().zip(&basis) {
                vector.iter_mut().zip(basis).for_each(|(sum, part)| *sum += factor * part);
            }
            vector
        };
        found.pairs = eigen.iter().take(count).map(|(value, s)| (value.max(0.0), combine(s))).collect();
        found.converged = residual <= TOLERANCE * value || m == n;
        if found.converged {
            break;
        }
        start = found.pairs.first().map_or_else(|| scattered(n), |(_, vector)| vector.clone());
    }
    found
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

/// Takes out of a vector what an orthonormal basis has of it (Gram-Schmidt).
pub(super) fn orthogonalize(vector: &mut [f64], basis: &[Vec<f64>]) {
    // Twice: what rounding leaves of a large share would come back as a copy of it.
    for _ in 0..2 {
        for other in basis {
            let share = dot(other, vector);
            vector.iter_mut().zip(other).for_each(|(part, other)| *part -= share * other);
        }
    }
}

/// An orthonormal basis in which the operator has three diagonals: `alpha`, and `beta` beside it.
fn tridiagonal(
    mut next: Vec<f64>,
    vectors: usize,
    apply: &mut impl FnMut(&[f64], &mut [f64]),
) -> (Vec<Vec<f64>>, Vec<f64>, Vec<f64>) {
    let (mut basis, mut alpha, mut beta) = (Vec::<Vec<f64>>::new(), Vec::new(), Vec::new());
    let mut size: f64 = 0.0;
    loop {
        let length = dot(&next, &next).sqrt();
        if !basis.is_empty() {
            beta.push(length);
        }
        // What is left is rounding: the basis has all that the start has something of.
        if basis.len() == vectors || length <= 1e-13 * size || !length.is_finite() {
            return (basis, alpha, beta);
        }
        next.iter_mut().for_each(|part| *part /= length);
        let mut product = vec![0.0; next.len()];
        apply(&next, &mut product);
        let diagonal = dot(&next, &product);
        size = size.max(dot(&product, &product).sqrt());
        alpha.push(diagonal);
        basis.push(next);
        orthogonalize(&mut product, &basis);
        next = product;
    }
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
            let Largest { pairs, converged } = largest(n as usize, 3, chain);
            assert!(converged, "{n}");
            let exact = 2.0 + 2.0 * libm::cos(std::f64::consts::PI / f64::from(n + 1));
            let (value, vector) = &pairs[0];
            assert!((value / exact - 1.0).abs() <= TOLERANCE, "{n}: {value} for {exact}");
            assert!((dot(vector, vector) - 1.0).abs() < 1e-9, "{n}");
            assert!(pairs.is_sorted_by(|a, b| a.0 >= b.0));
        }
    }

    #[test]
    fn nothing_is_the_largest_of_nothing() {
        assert!(largest(0, 3, |_, _| ()).pairs.is_empty());
        assert_eq!(largest(4, 2, |_, out| out.fill(0.0)).pairs[0].0, 0.0);
    }

    #[test]
    fn what_is_no_number_has_no_largest() {
        for wrong in [f64::NAN, f64::INFINITY, 1e300] {
            let found =
                largest(5, 2, |x, out| out.iter_mut().zip(x).for_each(|(out, x)| *out = wrong * wrong * x));
            assert!(
                !found.converged || found.pairs.iter().all(|(value, _)| !value.is_finite()),
                "{wrong}: {found:?}"
            );
        }
    }
}
