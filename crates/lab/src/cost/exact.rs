//! Closed forms of motion.

/// Jacobi's functions sn, cn, dn at `u` for the parameter `m` in [0, 1), by the arithmetic-geometric mean
/// (Abramowitz, Stegun 1964, 16.4).
pub fn jacobi(u: f64, m: f64) -> (f64, f64, f64) {
    let (mut a, mut b, mut c) = (vec![1.0_f64], (1.0 - m).sqrt(), vec![m.sqrt()]);
    while c[c.len() - 1].abs() > 1e-16 && a.len() < 32 {
        let last = a[a.len() - 1];
        c.push((last - b) / 2.0);
        a.push((last + b) / 2.0);
        b = (last * b).sqrt();
    }
    let n = a.len() - 1;
    let scale = f64::from(u32::try_from(n).unwrap_or(u32::MAX)).exp2();
    let mut phi = scale * a[n] * u;
    for k in (1..=n).rev() {
        phi = (phi + (c[k] / a[k] * phi.sin()).asin()) / 2.0;
    }
    let (sn, cn) = phi.sin_cos();
    // Never 0 below m = 1; the usual quotient of cosines loses its digits where both are small.
    (sn, cn, (1.0 - m * sn * sn).sqrt())
}

/// Eccentric anomaly E of `E - e sin E = mean`, by Newton's method from a start on the safe side.
pub fn eccentric_anomaly(mean: f64, e: f64) -> f64 {
    let mean = mean.rem_euclid(std::f64::consts::TAU);
    let mut anomaly = if e < 0.8 { mean } else { std::f64::consts::PI };
    for _ in 0..60 {
        let step = (anomaly - e * anomaly.sin() - mean) / (1.0 - e * anomaly.cos());
        anomaly -= step;
        if step.abs() < 1e-16 {
            break;
        }
    }
    anomaly
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_of_duffings_equation_has_the_known_digits() {
        // x'' = -x - 2 x³ from 1: cn(sqrt(3) t, 1/3).
        let (sn, cn, dn) = jacobi(3.0_f64.sqrt() * 3.0, 1.0 / 3.0);
        assert!((cn - -0.004_570_930_199_922_41).abs() < 1e-14, "{cn}");
        assert!((sn * sn + cn * cn - 1.0).abs() < 1e-14);
        assert!((dn * dn + sn * sn / 3.0 - 1.0).abs() < 1e-13);
    }

    #[test]
    fn keplers_equation_is_solved() {
        for e in [0.0, 0.3, 0.6, 0.9, 0.99] {
            for i in 0_i32..62 {
                let anomaly = f64::from(i) * 0.1;
                let mean = anomaly - e * anomaly.sin();
                assert!((eccentric_anomaly(mean, e) - anomaly).abs() < 1e-12, "{e} {anomaly}");
            }
        }
    }
}
