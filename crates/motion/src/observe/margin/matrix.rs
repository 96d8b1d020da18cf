//! Small square matrices: products, powers and the spectral radius.

/// A square matrix, by rows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Matrix {
    n: usize,
    entries: Vec<f64>,
}

/// Number of squarings for the spectral radius: after 2^32 steps a factor of 1e6 between the largest entry and the
/// radius is an error of 3e-9.
const SQUARINGS: u32 = 32;

impl Matrix {
    pub fn zero(n: usize) -> Self {
        Self { n, entries: vec![0.0; n * n] }
    }

    /// `factor` times the identity matrix.
    pub fn scalar(n: usize, factor: f64) -> Self {
        let mut matrix = Self::zero(n);
        (0..n).for_each(|i| matrix.entries[i * n + i] = factor);
        matrix
    }

    pub const fn size(&self) -> usize {
        self.n
    }

    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.entries[i * self.n + j]
    }

    pub fn set(&mut self, i: usize, j: usize, entry: f64) {
        self.entries[i * self.n + j] = entry;
    }

    pub fn is_zero(&self) -> bool {
        self.entries.iter().all(|entry| *entry == 0.0)
    }

    /// Adds `factor` times `other`.
    pub fn add(&mut self, other: &Self, factor: f64) {
        self.entries.iter_mut().zip(&other.entries).for_each(|(sum, entry)| *sum += factor * entry);
    }

    pub fn times(&self, other: &Self) -> Self {
        let n = self.n;
        let mut product = Self::zero(n);
        let rows = product.entries.chunks_exact_mut(n).zip(self.entries.chunks_exact(n));
        for (sums, row) in rows {
            for (factor, other) in row.iter().zip(other.entries.chunks_exact(n)) {
                sums.iter_mut().zip(other).for_each(|(sum, entry)| *sum += factor * entry);
            }
        }
        product
    }

    pub fn power(&self, mut exponent: u32) -> Self {
        let (mut power, mut square) = (Self::scalar(self.n, 1.0), self.clone());
        while exponent > 0 {
            if exponent & 1 == 1 {
                power = power.times(&square);
            }
            exponent >>= 1;
            if exponent > 0 {
                square = square.times(&square);
            }
        }
        power
    }

    /// Solves `self x = right` for x in place, by elimination without pivoting: for positive definite matrices.
    pub fn solve(&self, right: &mut [f64]) {
        let (n, mut rows) = (self.n, self.entries.clone());
        for pivot in 0..n {
            for row in pivot + 1..n {
                let factor = rows[row * n + pivot] / rows[pivot * n + pivot];
                (pivot..n).for_each(|j| rows[row * n + j] -= factor * rows[pivot * n + j]);
                right[row] -= factor * right[pivot];
            }
        }
        for row in (0..n).rev() {
            let known: f64 = (row + 1..n).map(|j| rows[row * n + j] * right[j]).sum();
            right[row] = (right[row] - known) / rows[row * n + row];
        }
    }

    fn largest(&self) -> f64 {
        self.entries.iter().map(|entry| entry.abs()).fold(0.0, f64::max)
    }

    /// Spectral radius, the largest magnitude of an eigenvalue: by formula for two rows, else from the size of a high
    /// power (Gelfand 1941). Infinite if an entry is not finite.
    pub fn radius(&self) -> f64 {
        if !self.entries.iter().all(|entry| entry.is_finite()) {
            return f64::INFINITY;
        }
        if self.n == 2 { self.radius_of_two() } else { self.radius_by_powers() }
    }

    fn radius_of_two(&self) -> f64 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| self.entries[i]);
        let (half, determinant) = ((a + d) / 2.0, a * d - b * c);
        // Not half² - determinant, which cancels if both eigenvalues are near 1.
        let apart = (a - d) / 2.0;
        let discriminant = apart * apart + b * c;
        if discriminant < 0.0 { determinant.abs().sqrt() } else { half.abs() + discriminant.sqrt() }
    }

    fn radius_by_powers(&self) -> f64 {
        let mut power = self.clone();
        let (mut logarithm, mut weight) = (0.0, 1.0);
        for _ in 0..SQUARINGS {
            let size = power.largest();
            if size == 0.0 {
                return 0.0;
            }
            power.entries.iter_mut().for_each(|entry| *entry /= size);
            logarithm += weight * libm::log(size);
            power = power.times(&power);
            weight /= 2.0;
        }
        libm::exp(logarithm + weight * libm::log(power.largest()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(n: usize, entries: &[f64]) -> Matrix {
        Matrix { n, entries: entries.to_vec() }
    }

    #[test]
    fn the_radius_of_a_rotation_a_shear_and_a_stretch() {
        let (sin, cos) = libm::sincos(0.3);
        for (matrix, radius) in [
            (of(2, &[cos, sin, -sin, cos]), 1.0),
            (of(2, &[1.0, 1.0, 0.0, 1.0]), 1.0),
            (of(2, &[-3.0, 1.0, 0.0, 0.5]), 3.0),
            (of(3, &[cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 0.9]), 1.0),
            (of(3, &[0.9, 1e3, 0.0, 0.0, 0.9, 0.0, 0.0, 0.0, 0.2]), 0.9),
            (of(4, &[0.0; 16]), 0.0),
        ] {
            let found = matrix.radius();
            assert!((found - radius).abs() <= 1e-7, "{found} for {radius}");
        }
    }

    #[test]
    fn a_power_is_a_product_and_a_solution_solves() {
        let matrix = of(3, &[4.0, 1.0, 0.5, 1.0, 3.0, 0.25, 0.5, 0.25, 2.0]);
        let third = matrix.times(&matrix).times(&matrix);
        assert_eq!(matrix.power(3), third);
        assert_eq!(matrix.power(0), Matrix::scalar(3, 1.0));
        let mut x = [1.0, -2.0, 0.5];
        matrix.solve(&mut x);
        for (i, right) in [1.0, -2.0, 0.5].into_iter().enumerate() {
            let product: f64 = (0..3).map(|j| matrix.at(i, j) * x[j]).sum();
            assert!((product - right).abs() <= 1e-15);
        }
    }
}
