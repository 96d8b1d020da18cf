//! What single precision costs, and what compensated sums give back.

use glam::DVec3;
use motion::arrays::Bare;
use motion::{Damping, DampingModel, Method};

use super::{Precision, run, states};
use crate::environment::pull;
use crate::groups::lab::{Environment, Net, Start, elastic};

/// Half the distance from 1 to the next number of single precision.
const EPS: f64 = 5.960_464_477_539_063e-8;

/// Distance between two numbers of single precision at `x`.
fn ulp(x: f64) -> f64 {
    2.0 * EPS * 2.0_f64.powi(x.abs().log2().floor() as i32)
}

/// A net in plain arrays.
fn bare<T: Precision>(net: &Net, method: Method, step: f64, substeps: u32) -> Bare<T> {
    damped_bare(net, None, method, step, substeps)
}

fn damped_bare<T: Precision>(
    net: &Net,
    damping: Option<Damping>,
    method: Method,
    step: f64,
    substeps: u32,
) -> Bare<T> {
    let around = Environment { damping, substeps: Some(substeps), ..Environment::default() };
    T::of_world(&mut net.lab(&around, method, step).world, method, &|_| Vec::new()).unwrap()
}

/// Bodies of 1 kg, each on a spring of no length to the origin that turns it by w rad/s.
fn oscillators(w: &[f64], x: DVec3, v: impl Fn(f64) -> DVec3) -> Net {
    let bodies = w.iter().map(|w| Start::of(1.0, x, v(*w)));
    Net {
        bodies: std::iter::once(Start::held(DVec3::ZERO)).chain(bodies).collect(),
        springs: (1..).zip(w).map(|(body, w)| ([0, body], elastic(w * w, 0.0))).collect(),
    }
}

/// Height of a body thrown up at 100 m/s after `ticks` at 60 Hz; what is not exact in single precision is rounded
/// first.
fn thrown<T: Precision>(method: Method, ticks: u32, compensate: fn(Bare<T>) -> Bare<T>) -> f64 {
    let number = |x: f64| T::of(f64::from(x as f32));
    let gravity = pull(DVec3::Y * f64::from(-9.8_f32));
    let mut bare = Bare::new(method, number(1.0 / 60.0)).with_law(gravity);
    bare.add([T::ZERO; 3], [T::ZERO, number(100.0), T::ZERO], T::ONE);
    let mut bare = compensate(bare);
    run(&mut bare, ticks);
    bare.positions[0][1].to_f64()
}

#[test]
fn a_fall_of_ten_minutes_is_exact_to_roundings_in_compensated_sums() {
    for method in Method::ALL {
        for seconds in [10, 60, 600] {
            let exact = thrown::<f64>(method, 60 * seconds, |bare| bare);
            let error = (thrown(method, 60 * seconds, Bare::<f32>::compensated) - exact).abs();
            let t = f64::from(seconds);
            let allowed = match method {
                // It goes 4.4 steps there and back in each, in parts that are rounded for velocity and position.
                Method::Yoshida4 => 8.8 * EPS * (100.0 * t + 4.9 * t * t),
                _ => 2.0 * ulp(exact),
            };
            assert!(error <= allowed, "{method:?} after {seconds} s: {error:e} m, at most {allowed:e}");
        }
    }
}

#[test]
fn a_fall_in_plain_single_precision_is_as_wrong_as_expected() {
    // Numbers of a transcription to C.
    for (seconds, expected) in [(10, 0.004), (60, 0.16), (600, 307.0)] {
        let method = Method::PositionVerlet;
        let exact = thrown::<f64>(method, 60 * seconds, |bare| bare);
        let error = (thrown::<f32>(method, 60 * seconds, |bare| bare) - exact).abs();
        let ratio = error / expected;
        assert!((1.0 / 3.0..=3.0).contains(&ratio), "after {seconds} s: {error:e} m, not {expected}");
    }
}

/// Largest change of the momentum of a ring of 8, in units of sum(|m v|) at the start, looked at now and then over
/// `ticks`.
fn momentum_drift(ticks: u32, compensate: fn(Bare<f32>) -> Bare<f32>) -> f64 {
    let mut net = Net::default();
    for i in 0..8 {
        let turn = std::f64::consts::TAU * f64::from(i) / 8.0;
        let noise = |k: f64| (12.9 * f64::from(i) + 78.2 * k).sin();
        let v = DVec3::new(noise(1.0), noise(2.0), noise(3.0)) * 0.3;
        let x = DVec3::new(turn.cos(), turn.sin(), 0.1 * noise(4.0));
        net.bodies.push(Start::of(1.0 + 0.9 * noise(5.0), x, v));
        net.springs.push(([i as usize, (i as usize + 1) % 8], elastic(40.0, 0.7)));
    }
    let mut bare = compensate(bare(&net, Method::VelocityVerlet, 1.0 / 60.0, 1));
    let momenta = |bare: &Bare<f32>| -> Vec<DVec3> {
        bare.bodies
            .iter()
            .map(|body| DVec3::from_slice(&body.map(f64::from)[..3]) / f64::from(body[3]))
            .collect()
    };
    let sum = |momenta: Vec<DVec3>| momenta.into_iter().sum::<DVec3>();
    let (start, size) = (sum(momenta(&bare)), momenta(&bare).iter().map(|p| p.length()).sum::<f64>());
    let mut worst = 0.0_f64;
    for _ in 0..ticks / 997 {
        run(&mut bare, 997);
        let drift = (sum(momenta(&bare)) - start).length() / size;
        worst = if drift <= worst { worst } else { drift };
    }
    worst
}

#[test]
fn compensated_sums_keep_the_momentum_of_a_ring_of_springs() {
    let ticks = 10_000_000_u32;
    let unit = f64::from(ticks).sqrt() * EPS;
    let plain = momentum_drift(ticks, |bare| bare) / unit;
    let compensated = momentum_drift(ticks, Bare::<f32>::compensated) / unit;
    assert!(compensated <= 0.15, "compensated: {compensated} sqrt(N) eps");
    assert!(plain <= 2.0 && plain >= 3.0 * compensated, "plain: {plain} sqrt(N) eps");
}

/// Largest relative change of the nearby energy of four oscillators, z = w h, over `steps`, times `1 - z² / 4`.
fn nearby_energy_drift(method: Method, steps: u32, compensate: fn(Bare<f32>) -> Bare<f32>) -> f64 {
    let interval = 9_973;
    let z = [0.01, 0.1, 1.5, 1.9];
    let net = oscillators(&z, DVec3::new(0.48, 0.6, 0.64), |z| DVec3::new(0.6, -0.48, 0.2) * (0.7 * z));
    let mut bare = compensate(bare(&net, method, f64::from(interval), interval));
    let energies = |bare: &Bare<f32>| -> Vec<f64> {
        let energy = |((_, x, v), z): (&(u32, DVec3, DVec3), f64)| {
            let w2 = f64::from((z * z) as f32);
            match method {
                Method::VelocityVerlet => v.dot(*v) + w2 * (1.0 - w2 / 4.0) * x.dot(*x),
                _ => v.dot(*v) + w2 * x.dot(*x) - w2 * x.dot(*v),
            }
        };
        states(bare)[1..].iter().zip(z).map(energy).collect()
    };
    let (start, mut worst) = (energies(&bare), 0.0_f64);
    for _ in 0..steps / interval {
        run(&mut bare, 1);
        for (z, (now, start)) in z.iter().zip(energies(&bare).into_iter().zip(&start)) {
            let drift = (now / start - 1.0).abs() * (1.0 - z * z / 4.0);
            worst = if drift <= worst { worst } else { drift };
        }
    }
    worst
}

#[test]
fn nearby_energies_stay_in_single_precision() {
    for method in [Method::VelocityVerlet, Method::SemiImplicitEuler] {
        let plain = nearby_energy_drift(method, 1_000_000, |bare| bare);
        let compensated = nearby_energy_drift(method, 1_000_000, Bare::<f32>::compensated);
        // What acts is rounded either way, which is the larger part.
        assert!(plain <= 5e-4 && compensated <= 1e-4, "{method:?}: {plain:e}, compensated {compensated:e}");
    }
}

/// Root mean square of the errors after a period of 64 oscillators of 2 rad/s, each in another phase, in `steps`
/// steps of RK4, against the solution at the time that the rounded steps add up to.
fn oscillator_error(steps: u32, compensate: fn(Bare<f32>) -> Bare<f32>) -> f64 {
    let w = 2.0;
    let step = std::f64::consts::TAU / w / f64::from(steps);
    let mut net = oscillators(&[w; 64], DVec3::ZERO, |_| DVec3::ZERO);
    for (i, body) in net.bodies.iter_mut().enumerate().skip(1) {
        let (sin, cos) = (0.37 * i as f64).sin_cos();
        (body.x.x, body.v.x) = (f64::from(cos as f32), f64::from((w * sin) as f32));
    }
    let mut bare = compensate(bare(&net, Method::RungeKutta4, step, 1));
    run(&mut bare, steps);
    let (sin, cos) = (w * f64::from(step as f32) * f64::from(steps)).sin_cos();
    let square = |(Start { x, v, .. }, (_, after_x, after_v)): (&Start, &(u32, DVec3, DVec3))| {
        let (exact_x, exact_v) = (x.x * cos + v.x / w * sin, v.x * cos - w * x.x * sin);
        (after_x.x - exact_x).powi(2) + ((after_v.x - exact_v) / w).powi(2)
    };
    (net.bodies.iter().zip(&states(&bare)).skip(1).map(square).sum::<f64>() / 64.0).sqrt()
}

#[test]
fn smaller_steps_make_single_precision_worse_and_compensated_sums_do_not() {
    let ladder: Vec<u32> = (4..=12).map(|k| 1 << k).collect();
    let errors = |compensate| -> Vec<f64> {
        ladder.iter().map(|steps| oscillator_error(*steps, compensate)).collect()
    };
    let (plain, compensated) = (errors(|bare| bare), errors(Bare::<f32>::compensated));
    let best = (0..ladder.len()).min_by(|a, b| plain[*a].total_cmp(&plain[*b])).unwrap();
    assert!([64, 128, 256].contains(&ladder[best]), "least at {} steps: {plain:?}", ladder[best]);
    for (steps, (plain_error, compensated)) in ladder.iter().zip(plain.iter().zip(&compensated)) {
        let floor = *steps >= 512;
        assert!(!floor || *compensated <= EPS, "{steps} steps, compensated: {compensated:e}");
        assert!(*steps < 4096 || *plain_error >= 5.0 * plain[best], "{steps} steps: {plain:?}");
    }
}

/// Factor of the velocity after 200,000 steps of 1 microsecond under damping of 0.4 /s, alone and in a group.
fn damped(model: DampingModel, compensate: fn(Bare<f32>) -> Bare<f32>) -> [f64; 2] {
    let v = DVec3::new(3.0, -2.0, 1.0);
    let net = Net {
        bodies: [0.0, 5.0, 6.0].map(|x| Start::of(1.0, DVec3::X * x, v)).to_vec(),
        springs: vec![([1, 2], elastic(10.0, 1.0))],
    };
    let damping = Some(Damping { model, rate: 0.4 });
    let mut bare = compensate(damped_bare(&net, damping, Method::SemiImplicitEuler, 0.01, 10_000));
    run(&mut bare, 20);
    let states = states(&bare);
    [0, 1].map(|body| states[body].2.length() / v.length())
}

#[test]
fn a_factor_near_one_is_not_rounded_away_in_compensated_sums() {
    for model in DampingModel::ALL {
        let exact = (-0.08_f64).exp();
        for (plain, compensated) in
            damped(model, |bare| bare).into_iter().zip(damped(model, Bare::<f32>::compensated))
        {
            let wrong = |factor: f64| (factor / exact - 1.0).abs();
            assert!(wrong(plain) >= 1e-3, "{model:?}: {plain} should be wrong by the rounding of 1 - 4e-7");
            assert!(wrong(compensated) <= 1e-6, "{model:?}: {compensated}, not {exact}");
        }
    }
}

#[test]
fn the_time_of_laws_is_rounded_once() {
    let mut bare = Bare::<f32>::new(Method::RungeKutta4, 1.0 / 60.0);
    run(&mut bare, 1_000_000);
    assert_eq!(bare.time(), (f64::from(1.0_f32 / 60.0) * 1e6) as f32);
}

#[test]
fn a_saved_state_is_gone_back_to() {
    let net = oscillators(&[2.0, 3.0], DVec3::new(0.48, 0.6, 0.64), |w| DVec3::X * w);
    for method in Method::ALL {
        let mut bare = bare::<f32>(&net, method, 1.0 / 60.0, 2).compensated();
        run(&mut bare, 10);
        let (saved, before) = (bare.save(), bare.time());
        run(&mut bare, 10);
        let (once, after) = (states(&bare), bare.time());
        bare.restore(&saved);
        assert_eq!(bare.time(), before);
        run(&mut bare, 10);
        assert_eq!((states(&bare), bare.time()), (once, after), "{method:?}");
    }
}

#[test]
fn a_body_takes_what_a_tick_reads_and_writes_of_it() {
    let net = oscillators(&[2.0], DVec3::X, |_| DVec3::ZERO);
    let bytes = |bare: Bare<f32>| bare.bytes_per_body();
    let method = Method::RungeKutta4;
    assert_eq!(bare::<f64>(&net, method, 0.1, 1).bytes_per_body(), 7 * 8);
    assert_eq!(bytes(bare(&net, method, 0.1, 1)), 7 * 4);
    assert_eq!(bytes(bare(&net, method, 0.1, 1).compensated()), 13 * 4);
    let mut verlet = bare::<f32>(&net, Method::PositionVerlet, 0.1, 1);
    run(&mut verlet, 1);
    assert_eq!(bytes(verlet), 8 * 4);
}
