//! The matrix of a step of each method on `x'' = -k x - c x'`, from which limits, damping and conserved quantities follow.

use motion::Method;

/// Rows and columns are position and velocity.
pub type Matrix = [[f64; 2]; 2];

const IDENTITY: Matrix = [[1.0, 0.0], [0.0, 1.0]];

/// The matrix of these columns.
pub const fn by_columns([[a, c], [b, d]]: Matrix) -> Matrix {
    [[a, b], [c, d]]
}

pub fn product(a: Matrix, b: Matrix) -> Matrix {
    [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

/// `1 / (2 - 2^(1/3))` and `1 - 2 / (2 - 2^(1/3))`: Yoshida's steps.
pub fn yoshida_steps() -> (f64, f64) {
    let outer = 1.0 / (2.0 - 2.0_f64.cbrt());
    (outer, 1.0 - 2.0 * outer)
}

/// The first terms of the exponential of `h L`, with L of `x' = v, v' = -k x - c v`.
fn taylor(h: f64, [k, c]: [f64; 2], terms: u32) -> Matrix {
    let l = [[0.0, h], [-h * k, -h * c]];
    let (mut sum, mut term) = (IDENTITY, IDENTITY);
    for order in 1..=terms {
        term = product(term, l).map(|row| row.map(|entry| entry / f64::from(order)));
        sum = [0, 1].map(|i| [0, 1].map(|j| sum[i][j] + term[i][j]));
    }
    sum
}

/// Velocity Verlet with the end evaluated at `v + a h`.
fn velocity_verlet(h: f64, [k, c]: [f64; 2]) -> Matrix {
    let image = |x: f64, v: f64| {
        let a = -k * x - c * v;
        let x1 = x + h * v + h * h / 2.0 * a;
        let b = -k * x1 - c * (v + h * a);
        [x1, v + h / 2.0 * (a + b)]
    };
    by_columns([image(1.0, 0.0), image(0.0, 1.0)])
}

/// One step of `h` seconds of `x'' = -k x - c x'`. Position Verlet's is that of a step after another, its velocity being the
/// mean one of the last step.
pub fn step_matrix(method: Method, h: f64, law: [f64; 2]) -> Matrix {
    let [k, c] = law;
    match method {
        Method::ExplicitEuler => taylor(h, law, 1),
        // Position Verlet evaluates drag at its velocity, which is half a step behind.
        Method::SemiImplicitEuler | Method::PositionVerlet => {
            let (by_x, by_v) = (-h * k, 1.0 - h * c);
            [[1.0 + h * by_x, h * by_v], [by_x, by_v]]
        }
        Method::ImplicitEuler => {
            let whole = 1.0 + h * c + h * h * k;
            [[(1.0 + h * c) / whole, h / whole], [-h * k / whole, 1.0 / whole]]
        }
        Method::VelocityVerlet => velocity_verlet(h, law),
        Method::RungeKutta2Midpoint | Method::RungeKutta2Heun => taylor(h, law, 2),
        Method::RungeKutta4 => taylor(h, law, 4),
        Method::Yoshida4 => {
            let (outer, inner) = yoshida_steps();
            let last = velocity_verlet(outer * h, law);
            product(last, product(velocity_verlet(inner * h, law), last))
        }
    }
}
