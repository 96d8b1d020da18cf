//! The largest stable steps, measured by running the methods, beside their closed forms.

mod maps;
mod nets;
mod oscillator;
mod theory;

use motion::{DampingModel, Method};

pub use maps::{LongRun, Map, Panel, damping_map, stiffness_map};
pub use nets::{Net, Stepped};
pub use oscillator::Oscillator;
pub use theory::{Damped, oscillator_limit};

/// Damping ratios that are measured; 0 is none.
pub const RATIOS: [f64; 6] = [0.0, 0.05, 0.2, 0.5, 1.0, 2.0];

/// How a run is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// It exceeds a thousand times its start within a number of ticks.
    Amplitude,
    /// The spectral radius of one tick is above 1: of oscillators whose runs grow too slowly for a bound.
    SpectralRadius,
    /// Energy grows in one tick: of nets that grow too slowly for a bound.
    Energy,
}

impl Criterion {
    /// What it is called in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Amplitude => "amplitude",
            Self::SpectralRadius => "spectral_radius",
            Self::Energy => "energy",
        }
    }
}

/// One largest stable step.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// What was stepped.
    pub system: String,
    /// By which method, by its name.
    pub method: &'static str,
    /// How it was judged.
    pub criterion: Criterion,
    /// The largest stable w h that was found, w being the largest frequency without damping: 0 for none, infinite for
    /// no limit up to 1e6.
    pub measured: f64,
    /// The same by its closed form.
    pub theory: f64,
}

impl Limit {
    /// How far the measured one is from the closed form, relative to it; 0 where both are none or infinite.
    pub fn relative_difference(&self) -> f64 {
        if self.measured == self.theory { 0.0 } else { self.measured / self.theory - 1.0 }
    }

    /// System, method, measured, closed form, difference in percent and criterion, as a row of a table.
    pub fn cells(&self) -> [String; 6] {
        let word = |value: f64| match value {
            0.0 => "never".to_owned(),
            value if value.is_infinite() => "always".to_owned(),
            value => format!("{value:.4}"),
        };
        let difference = format!("{:+.3} %", 100.0 * self.relative_difference());
        let [measured, theory] = [self.measured, self.theory].map(word);
        let criterion = self.criterion.name().replace('_', " ");
        [self.system.clone(), self.method.to_owned(), measured, theory, difference, criterion]
    }
}

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

/// The nets whose limits are measured: so many random ones, by number, after chains with a last mass of 1, 1e6, 1e-3 and
/// 1e-6 kg.
pub fn nets(random: u64) -> Vec<Net> {
    let chains = [1.0, 1e6, 1e-3, 1e-6].map(Net::chain);
    chains.into_iter().chain((0..random).map(Net::random)).collect()
}

/// The largest stable value: from `start` up in steps of `by`, and of 10 beyond 10, then by halving to 1 in 5,000. Infinite
/// where all up to 1e6 are stable, 0 where `start` is not.
fn largest_stable(start: f64, by: f64, mut stable: impl FnMut(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, start);
    while stable(high) {
        (low, high) = (high, high * if high > 10.0 { 10.0 } else { by });
        if high > 1e6 {
            return f64::INFINITY;
        }
    }
    if low == 0.0 {
        return 0.0;
    }
    while high - low > 2e-4 * high {
        let middle = f64::midpoint(low, high);
        if stable(middle) { low = middle } else { high = middle }
    }
    f64::midpoint(low, high)
}
