//! A body on a spring of no rest length to a post: what each method invents, from the closed form of its discrete
//! solution.

use glam::DVec3;
use motion::Method;
use motion::ledger::LedgerLines;

use super::Kept;
use crate::methods::oracle;

/// w h.
const Z: f64 = 0.1;
/// w, 1/s: 2 kg on 8 N/m.
const W: f64 = 2.0;
const STEP: f64 = Z / W;
/// Five periods and a bit.
const TICKS: u32 = 320;

/// 2 kg on a spring of no rest length, 8 N/m, to a post.
const SCENE: &str = "bodies: [
        (name: \"post\", position_m: (1.0, -2.0, 0.5), immovable: true),
        (name: \"ball\", position_m: (1.5, -2.0, 0.5), velocity_m_s: (0.0, 0.3, -0.4), mass_kg: 2.0),
    ],
    springs: [(between: (\"post\", \"ball\"), stiffness_n_m: 8.0, rest_length_m: 0.0)]";

/// Energy over that at the start, after n steps.
fn energy(method: Method, n: u32) -> f64 {
    let z2 = Z * Z;
    let factor: f64 = match method {
        Method::ExplicitEuler => 1.0 + z2,
        Method::ImplicitEuler => 1.0 / (1.0 + z2),
        Method::RungeKutta2Midpoint | Method::RungeKutta2Heun => 1.0 + z2 * z2 / 4.0,
        Method::RungeKutta4 => 1.0 - z2.powi(3) / 72.0 + z2.powi(4) / 576.0,
        _ => return by_solution(method, n),
    };
    factor.powi(n.cast_signed())
}

fn by_solution(method: Method, n: u32) -> f64 {
    // Along x the ball starts at rest, 0.5 m out; along y and z in the middle.
    let start = [DVec3::X * (0.5 * W), DVec3::new(0.0, 0.3, -0.4)];
    let [x, v] = oracle::image(oracle::after(method, Z, n), start);
    (x.length_squared() + v.length_squared()) / (1.0 + 0.25)
}

#[test]
fn the_closed_forms_agree_with_the_discrete_solution() {
    for method in Method::ALL {
        for n in [1, 2, 17, 200] {
            let (closed, solved) = (energy(method, n), by_solution(method, n));
            assert!((closed - solved).abs() < 1e-12 * closed, "{method:?}, {n}: {closed} {solved}");
        }
    }
}

#[test]
fn the_residual_is_what_each_method_invents_on_the_oscillator() {
    for method in Method::ALL {
        let mut kept = Kept::of(SCENE, method, 1.0 / STEP, 1);
        let start = kept.ledger.energies_at_opening().total();
        assert!((start - 1.25).abs() < 1e-15);
        let largest = (1..=TICKS).map(|n| (energy(method, n) - 1.0).abs()).fold(0.0, f64::max);
        let mut worst = 0.0_f64;
        for n in 1..=TICKS {
            let residual = kept.tick().residual() / start;
            worst = worst.max((residual - (energy(method, n) - 1.0)).abs());
        }
        // Within 1 % would do; what is left is rounding.
        assert!(worst <= 1e-6 * largest, "{method:?}: {worst:e} of {largest:e}");
        assert!(largest > 1e-7, "{method:?} invents enough to be seen");
        let books = kept.check().ledger.since_opening();
        let invented = LedgerLines { residual: books.energy.residual, ..LedgerLines::default() };
        assert_eq!(books.energy, invented, "nothing does work");
        let mean = kept.residual() / (f64::from(TICKS) * STEP);
        assert!((kept.ledger.mean_residual_rate() - mean).abs() <= 1e-9 * mean.abs(), "{method:?}");
    }
}
