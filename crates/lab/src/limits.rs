//! The largest stable steps, measured by running the methods, beside their closed forms.

mod limit;
mod maps;
mod nets;
mod oscillator;
mod theory;

use motion::{DampingModel, Method};

pub use limit::{Criterion, Limit};
pub use maps::{LongRun, Map, Panel, damping_map, stiffness_map};
pub use nets::{Net, Stepped};
pub use oscillator::Oscillator;
pub use theory::{Damped, oscillator_limit};

/// Damping ratios that are measured; 0 for no damping.
pub const RATIOS: [f64; 6] = [0.0, 0.05, 0.2, 0.5, 1.0, 2.0];

/// The oscillators whose limits are measured: by every method without damping and with drag of every ratio, and by the two
/// explicit Eulers with every model of damping.
pub fn oscillators() -> Vec<Oscillator> {
    let drag =
        RATIOS.into_iter().flat_map(|ratio| Method::ALL.map(|method| (method, Damped::by_drag(ratio))));
    let models = DampingModel::ALL.into_iter().flat_map(|model| {
        let damped = RATIOS[1..].iter().map(move |ratio| Damped { ratio: *ratio, model: Some(model) });
        damped.flat_map(|damped| Method::ALL[..2].iter().map(move |method| (*method, damped)))
    });
    drag.chain(models).map(|(method, damped)| Oscillator { method, damped }).collect()
}

/// The nets whose limits are measured: chains with a last mass of 1, 1e6, 1e-3 and 1e-6 kg, then this number of
/// random nets.
pub fn nets(random: u64) -> Vec<Net> {
    let chains = [1.0, 1e6, 1e-3, 1e-6].map(Net::chain);
    chains.into_iter().chain((0..random).map(Net::random)).collect()
}
