//! Free fall of ten minutes is what the formula of the scheme says, to the last bit where every number has one.

use crate::rigs::Bare;
use glam::DVec3;
use motion::Method;

use crate::rigs::pull;

/// Height after `n` steps of h seconds, in exact arithmetic: `x0 + v0 n h + g h² c`, with c twice that of the scheme.
fn closed_form(method: Method, n: i128, [x0, v0, g]: [i128; 3]) -> i128 {
    // In units of 2^-15 m with h = 1/64 s, and x0, v0 and g in quarters.
    let twice = match method {
        Method::ExplicitEuler => n * (n - 1),
        Method::SemiImplicitEuler | Method::ImplicitEuler => n * (n + 1),
        _ => n * n,
    };
    // x0 / 4 = x0 2^13 units; v0 n h / 4 = v0 n 2^7; g c h² / 8 = g c.
    x0 * (1 << 13) + v0 * n * (1 << 7) + g * twice
}

/// Whether every number that the method multiplies by is a whole number of halves, quarters and so on.
fn is_dyadic(method: Method) -> bool {
    !matches!(method, Method::RungeKutta4 | Method::Yoshida4)
}

#[test]
fn ten_minutes_of_free_fall_are_exact_to_the_scheme() {
    let (h, n) = (1.0 / 64.0, 38_400);
    for method in Method::ALL {
        let mut bare = Bare::new(method, h).with_law(pull(DVec3::Y * -9.75));
        bare.add([0.0, 10.25, 0.0], [1.5, 100.75, 0.0], 0.1);
        (0..n).for_each(|_| bare.tick());
        let exact = closed_form(method, i128::from(n), [41, 403, -39]) as f64 / 2.0_f64.powi(15);
        let (y, error) = (bare.positions[0][1], (bare.positions[0][1] - exact).abs());
        if is_dyadic(method) {
            // Position Verlet keeps the mean velocity of its last step.
            let until = if method == Method::PositionVerlet { 600.0 - h / 2.0 } else { 600.0 };
            assert_eq!((y, bare.bodies[0][1]), (exact, 100.75 - 9.75 * until), "{method:?}");
            assert_eq!(bare.positions[0][0], 900.0, "{method:?}");
        } else {
            // Thirds are not exact: each step rounds position and velocity by half a unit in the last place at most, and
            // the error of the velocity adds up over the steps that are left.
            let (unit, steps) = (f64::EPSILON / 2.0, f64::from(n));
            let of_position = steps * 4.0 * unit * exact.abs();
            let of_velocity = steps * 4.0 * unit * 5_750.0 * 600.0;
            assert!(error <= of_position + of_velocity, "{method:?}: {error:e}");
        }
    }
}
