//! Single precision: where smaller steps make it worse.

use lab::cost::{Accuracy, Plan, Precision, Study, Subject};
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
fn single_precision_takes_half_the_bytes() {
    let study = study();
    let bytes = |precision| study.curve(Method::RungeKutta4, precision).next().unwrap().bytes_per_body_step;
    assert!(bytes(Precision::F32).unwrap() > 0.0);
    assert!(bytes(Precision::CompensatedF32) > bytes(Precision::F32));
}
