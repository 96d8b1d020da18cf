//! The harmonic oscillator: everything that a study finds about it is known beforehand.

use std::sync::LazyLock;

use lab::cost::{Accuracy, Cost, Plan, Study, Subject};
use motion::{METHODS, Method};

use super::{plain, studied};

/// A study without times.
fn study(periods: u32, rungs: Vec<u32>, methods: &[Method]) -> Study {
    studied(Subject::oscillator(periods).unwrap(), plain(methods, rungs)).study().clone()
}

/// Five periods by every method in many numbers of substeps.
fn by_all_methods() -> &'static Study {
    static STUDY: LazyLock<Study> = LazyLock::new(|| study(5, octaves(8, 4096), &Method::ALL));
    &STUDY
}

fn octaves(from: u32, to: u32) -> Vec<u32> {
    std::iter::successors(Some(from), |rung| Some(rung * 2))
        .take_while(|rung| *rung <= to)
        .collect()
}

#[test]
fn fitted_orders_are_those_of_the_table() {
    let study = by_all_methods();
    for claims in METHODS {
        let both = f64::from(claims.position_order.min(claims.velocity_order));
        let expected = [
            (Accuracy::Position, f64::from(claims.position_order)),
            (Accuracy::Velocity, f64::from(claims.velocity_order)),
            (Accuracy::Relative, both),
        ];
        for (accuracy, expected) in expected {
            let order = study.order(claims.method, accuracy).expect("no method is exact here");
            assert!((order - expected).abs() < 0.05, "{}: {accuracy:?} {order}", claims.name);
        }
    }
}

#[test]
fn evaluations_are_counted_exactly() {
    let study = study(5, octaves(8, 64), &Method::ALL);
    for cell in Method::ALL.into_iter().flat_map(|method| study.curve(method)) {
        let claims = cell.setting.method.claims();
        let steps = 8 * u64::from(cell.setting.substeps.least());
        let expected =
            steps * u64::from(claims.evaluations) + u64::from(claims.start_up_evaluations);
        assert_eq!(cell.counts.accelerations, expected, "{}", cell.setting);
        assert_eq!(
            cell.counts.solver > 0,
            claims.method == Method::ImplicitEuler,
            "{}",
            cell.setting
        );
    }
}

/// Where the curve of `second` begins to be the more accurate one at equal evaluations: (cost, error).
pub fn overtakes(
    study: &Study,
    second: Method,
    first: Method,
    accuracy: Accuracy,
) -> Option<(f64, f64)> {
    let error = |method, cost| study.error_at(method, accuracy, Cost::Evaluations, cost);
    let mut better = None;
    for cost in (0..8000).map(|i| 1e5 * 0.998_f64.powi(i)) {
        match (error(second, cost), error(first, cost)) {
            (Some(second), Some(first)) if second > first => return better,
            (Some(second), Some(_)) => better = Some((cost, second)),
            _ => {}
        }
    }
    None
}

#[test]
fn runge_kutta_4_overtakes_verlet_at_45_evaluations_a_period() {
    for periods in [1, 2, 3, 4, 5, 8, 10] {
        let rungs = (1..=150).filter(|steps| (5..=120).contains(&(steps * 8 / periods))).collect();
        let study = study(periods, rungs, &[Method::VelocityVerlet, Method::RungeKutta4]);
        let (fourth, verlet) = (Method::RungeKutta4, Method::VelocityVerlet);
        let (cost, error) = overtakes(&study, fourth, verlet, Accuracy::Relative).expect("it does");
        let a_period = cost * std::f64::consts::PI;
        let grid = 4.0 * 8.0 / f64::from(periods);
        assert!(error < 0.1, "{periods} periods: {error} at {a_period}");
        assert!((a_period - 45.0).abs() < 4.0 + grid, "{periods} periods: {a_period}");
    }
}

#[test]
fn runge_kutta_2_is_16_times_worse_than_verlet_at_equal_cost() {
    // Phase errors z²/24 and (2 z)²/6 for steps twice as long: 4 times 4.
    let methods = [Method::VelocityVerlet, Method::RungeKutta2Midpoint, Method::RungeKutta2Heun];
    let study = study(5, (30..=300).collect(), &methods);
    let error = |method, substeps: u32| {
        let cell =
            study.curve(method).find(|cell| cell.setting.substeps == substeps.into()).unwrap();
        (study.error(cell, Accuracy::Relative).unwrap(), cell.counts.accelerations)
    };
    let mut seen = 0;
    for steps in 30..=150_u32 {
        for heun in &methods[1..] {
            let ((verlet, cost), (heun, same)) =
                (error(Method::VelocityVerlet, 2 * steps), error(*heun, steps));
            // Verlet's first step takes one more.
            assert_eq!(cost, same + 1);
            if heun < 0.1 {
                assert!((heun / verlet / 16.0 - 1.0).abs() < 0.2, "{steps}: {}", heun / verlet);
                seen += 1;
            }
        }
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn explicit_euler_is_never_on_the_front() {
    let study = by_all_methods();
    for accuracy in [Accuracy::Relative, Accuracy::Position, Accuracy::Velocity] {
        let front = study.front(accuracy, Cost::Evaluations);
        let sound = |method| front.iter().any(|cell| cell.setting.method == method);
        let least = front
            .iter()
            .filter_map(|cell| study.error(cell, accuracy))
            .filter(|error| *error < 0.5);
        assert!(!sound(Method::ExplicitEuler) && least.count() > 4, "{accuracy:?}: {front:?}");
        assert!(sound(Method::PositionVerlet) && sound(Method::RungeKutta4), "{accuracy:?}");
    }
}

#[test]
fn energy_that_is_lost_and_energy_that_is_invented_have_opposite_signs() {
    let plan = Plan { longer: 1, ..plain(&[Method::ExplicitEuler, Method::ImplicitEuler], [32]) };
    let bench = studied(Subject::oscillator(5).unwrap(), plan);
    let end = |method| {
        let mut drifts = bench.study().drifts.iter().filter(|drift| drift.setting.method == method);
        let drift = drifts.next().expect("its books were kept");
        let (_, residual) = *drift.series.last().expect("it was sampled");
        assert!(drift.largest.unwrap() >= residual.abs(), "{drift:?}");
        residual
    };
    let (invented, lost) = (end(Method::ExplicitEuler), end(Method::ImplicitEuler));
    assert!(invented > 0.5 && lost < -0.5, "{invented} {lost}");
}

/// Their positions are the same, and so are velocities at the time of the positions.
#[test]
fn position_verlet_keeps_the_energy_of_velocity_verlet() {
    let plan = Plan { longer: 1, ..plain(&[Method::PositionVerlet, Method::VelocityVerlet], [32]) };
    let bench = studied(Subject::oscillator(5).unwrap(), plan);
    let largest = |method| {
        let mut drifts = bench.study().drifts.iter().filter(|drift| drift.setting.method == method);
        drifts.next().and_then(|drift| drift.largest).expect("its books were kept")
    };
    let (position, velocity) = (largest(Method::PositionVerlet), largest(Method::VelocityVerlet));
    assert!((position / velocity - 1.0).abs() < 1e-3, "{position} {velocity}");
}
