//! Single precision: where smaller steps make it worse, and what compensated sums give back.

use lab::cost::{Accuracy, Host, Plan, Precision, Sample, Setting, Study, Subject, make, problem};
use motion::Method;

use super::{plain, studied};

fn study() -> Study {
    let methods = [Method::RungeKutta4];
    let rungs: Vec<_> = (0..10).map(|octave| 1 << octave).collect();
    let plan = Plan { single: methods.to_vec(), ..plain(&methods, rungs) };
    studied(Subject::oscillator(1).unwrap(), plan).study().clone()
}

#[test]
fn runge_kutta_4_of_single_precision_is_best_at_about_128_steps_a_period() {
    let study = study();
    let errors = |precision| -> Vec<(u32, f64)> {
        let curve = study.curve(Method::RungeKutta4, precision);
        // Eight ticks are a period.
        curve
            .map(|cell| (cell.setting.substeps * 8, study.error(cell, Accuracy::Relative).unwrap()))
            .collect()
    };
    let single = errors(Precision::F32);
    let (best, least) = single.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!((64..=256).contains(&best), "{single:?}");
    let (steps, finest) = *single.last().unwrap();
    assert!(steps == 4096 && finest > 2.0 * least, "{single:?}");

    let compensated = errors(Precision::CompensatedF32);
    let (_, finest_compensated) = *compensated.last().unwrap();
    assert!(finest_compensated < finest / 5.0, "{compensated:?}");
    // At coarse steps the method's own error is all there is.
    let double = errors(Precision::F64);
    for (f32, f64) in single[..3].iter().zip(&double) {
        assert!((f32.1 / f64.1 - 1.0).abs() < 0.02, "{f32:?} {f64:?}");
    }
    assert!(double.last().unwrap().1 < least / 100.0);
}

#[test]
fn single_precision_takes_as_many_evaluations() {
    let study = study();
    let counts = |precision| -> Vec<_> {
        study.curve(Method::RungeKutta4, precision).map(|cell| cell.counts.accelerations).collect()
    };
    let double = counts(Precision::F64);
    assert!(!double.is_empty() && counts(Precision::F32) == double, "{double:?}");
    assert_eq!(counts(Precision::CompensatedF32), double);
}

/// The state of the problem after that many steps of a 60th of a second.
fn after(name: &str, method: Method, precision: Precision, steps: u32) -> Sample {
    let subject = Subject::of_problem(problem(name).unwrap()).unwrap();
    // Its ticks are a quarter of a second.
    let subject = subject.of_bodies(1, 15);
    let mut run = make(&subject, Setting { method, substeps: 1, precision }, Host::Arithmetic).unwrap();
    (0..steps).for_each(|_| run.tick());
    assert_eq!(run.failure(), None, "{name} by {method:?}");
    run.states()[0]
}

#[test]
fn a_fall_of_ten_minutes_is_exact_to_roundings_in_compensated_sums_and_not_without() {
    // Half the distance from 1 to the next number.
    let eps = f64::from(f32::EPSILON) / 2.0;
    for method in Method::ALL {
        for seconds in [10, 60, 600] {
            let fall = |precision| after("free_fall", method, precision, 60 * seconds).1;
            let exact = fall(Precision::F64);
            let error = (fall(Precision::CompensatedF32) - exact).length();
            // The length of a step is rounded, and gravity is.
            let allowed = 8.0 * eps * exact.length();
            assert!(error <= allowed, "{method:?} after {seconds} s: {error:e} m, at most {allowed:e}");
            let plain = (fall(Precision::F32) - exact).length();
            assert!(seconds < 600 || plain >= 10.0 * error, "{method:?}: {plain:e} m, compensated {error:e}");
        }
    }
}

#[test]
fn implicit_steps_converge_in_single_precision() {
    // `after` looks for steps that did not.
    for name in ["harmonic_oscillator", "damped_oscillator", "duffing", "elastic_pendulum"] {
        for precision in Precision::ALL {
            let (_, x, _) = after(name, Method::ImplicitEuler, precision, 600);
            let (_, exact, _) = after(name, Method::ImplicitEuler, Precision::F64, 600);
            assert!((x - exact).length() <= 1e-4, "{name} in {}: {x} {exact}", precision.name());
        }
    }
}
