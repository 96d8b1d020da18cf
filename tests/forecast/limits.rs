//! The largest stable steps, measured by running the methods, beside their closed forms.

mod limit;
mod nets;
mod oscillator;
mod theory;

use std::f64::consts::PI;

use limit::{Criterion, Limit};
use motion::{DampingModel, Method};
pub use nets::Net;
use oscillator::Oscillator;
use theory::Damped;

/// Damping ratios that are measured; 0 for no damping.
const RATIOS: [f64; 6] = [0.0, 0.05, 0.2, 0.5, 1.0, 2.0];

/// The oscillators whose limits are measured: by every method without damping and with drag of every ratio, and by the two
/// explicit Eulers with every model of damping.
fn oscillators() -> Vec<Oscillator> {
    let drag = RATIOS
        .into_iter()
        .flat_map(|ratio| Method::ALL.map(|method| (method, Damped::by_drag(ratio))));
    let models = DampingModel::ALL.into_iter().flat_map(|model| {
        let damped =
            RATIOS[1..].iter().map(move |ratio| Damped { ratio: *ratio, model: Some(model) });
        damped.flat_map(|damped| Method::ALL[..2].iter().map(move |method| (*method, damped)))
    });
    drag.chain(models).map(|(method, damped)| Oscillator { method, damped }).collect()
}

/// The nets whose limits are measured: chains with a last mass of 1, 1e6, 1e-3 and 1e-6 kg, then this number of
/// random nets.
fn nets(random: u64) -> Vec<Net> {
    let chains = [1.0, 1e6, 1e-3, 1e-6].map(Net::chain);
    chains.into_iter().chain((0..random).map(Net::random)).collect()
}

/// All that are farther from theory than `bound`.
fn far(limits: &[Limit], bound: f64) -> Vec<String> {
    // Not "above": a difference that is no number is far as well.
    let near = |limit: &Limit| limit.relative_difference().abs() <= bound;
    let far = limits.iter().filter(|limit| !near(limit));
    far.map(|limit| {
        format!("{} {}: {} {}", limit.system, limit.method, limit.measured, limit.theory)
    })
    .collect()
}

#[test]
fn limits_of_oscillators_are_their_closed_forms() {
    let limits: Vec<_> = oscillators().iter().map(Oscillator::limit).collect();
    assert_eq!(limits.len(), 6 * Method::ALL.len() + 2 * DampingModel::ALL.len() * 5);
    let far = far(&limits, 0.002);
    assert!(far.is_empty(), "{far:#?}");
    let judged = |criterion| limits.iter().filter(|limit| limit.criterion == criterion).count();
    assert!(judged(Criterion::Amplitude) > 30 && judged(Criterion::SpectralRadius) > 10);
    let heun =
        |limit: &&Limit| limit.system == "oscillator" && limit.method == "runge_kutta_2_heun";
    let heun = limits.iter().find(heun).unwrap();
    assert_eq!((heun.measured, heun.theory, heun.criterion), (0.0, 0.0, Criterion::SpectralRadius));
}

#[test]
fn limits_of_nets_are_those_of_their_fastest_mode() {
    let nets = nets(20);
    let limits: Vec<_> =
        nets.iter().flat_map(|net| Method::ALL.map(|method| net.limit(method))).collect();
    assert_eq!(limits.len(), 24 * Method::ALL.len());
    let judged = |criterion| limits.iter().filter(|limit| limit.criterion == criterion).count();
    assert_eq!((judged(Criterion::Amplitude), judged(Criterion::Energy)), (24 * 6, 24 * 3));
    let far = far(&limits, 0.002);
    assert!(far.is_empty(), "{far:#?}");
}

#[test]
fn the_fastest_mode_of_a_chain_has_a_closed_form() {
    // 2 sqrt(k / m) cos(pi / (2 n + 1)) of n bodies that hang on one end.
    let (found, closed) = (Net::chain(1.0).largest_frequency(), 20.0 * (PI / 21.0).cos());
    assert!((found / closed - 1.0).abs() <= 1e-9, "{found} for {closed}");
}
