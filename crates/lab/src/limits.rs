//! The largest stable steps, measured by running the methods, beside their closed forms.

mod maps;
mod nets;
mod oscillator;
mod theory;

use motion::{DampingModel, Method};
use serde::{Serialize, Serializer};

pub use maps::{Class, Map, damping_map, stiffness_map};
pub use nets::{Net, Stepped};
pub use oscillator::{Damped, Oscillator};
pub use theory::{chain_frequency, oscillator_limit};

/// Damping ratios that are measured; 0 is none.
pub const RATIOS: [f64; 6] = [0.0, 0.05, 0.2, 0.5, 1.0, 2.0];

/// How a run is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// It exceeds a thousand times its start within a number of ticks.
    Amplitude,
    /// The spectral radius of one tick is above 1: for explicit Euler, whose weakly damped runs grow too slowly for
    /// a bound, and for methods that are never stable.
    SpectralRadius,
}

/// One largest stable step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// What was stepped.
    pub system: String,
    /// By which method, by its name.
    pub method: &'static str,
    /// How it was judged.
    pub criterion: Criterion,
    /// The largest stable w h that was found, w being the largest frequency without damping: 0 for none, infinite for
    /// no limit up to 1e6.
    #[serde(serialize_with = "number")]
    pub measured: f64,
    /// The same by its closed form.
    #[serde(serialize_with = "number")]
    pub theory: f64,
}

impl Limit {
    /// How far the measured one is from the closed form, relative to it; 0 where both are none or infinite.
    #[must_use]
    pub fn relative_difference(&self) -> f64 {
        if self.measured == self.theory { 0.0 } else { self.measured / self.theory - 1.0 }
    }
}

impl Limit {
    /// System, method, measured, closed form and difference in percent, as a row of a table.
    #[must_use]
    pub fn cells(&self) -> [String; 5] {
        let word = |value: f64| match value {
            0.0 => "never".to_owned(),
            value if value.is_infinite() => "always".to_owned(),
            value => format!("{value:.4}"),
        };
        let difference = format!("{:+.3} %", 100.0 * self.relative_difference());
        [self.system.clone(), self.method.to_owned(), word(self.measured), word(self.theory), difference]
    }
}

/// A number, or its name where JSON has none.
fn number<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() { serializer.serialize_f64(*value) } else { serializer.serialize_str("inf") }
}

/// Limits of one oscillator: every method without damping and with drag of every ratio, and the two explicit Eulers
/// with every model of damping.
#[must_use]
pub fn oscillator_limits() -> Vec<Limit> {
    let drag =
        RATIOS.into_iter().flat_map(|ratio| Method::ALL.map(|method| (method, Damped::by_drag(ratio))));
    let models = DampingModel::ALL.into_iter().flat_map(|model| {
        let damped = RATIOS[1..].iter().map(move |ratio| Damped { ratio: *ratio, model: Some(model) });
        damped.flat_map(|damped| Method::ALL[..2].iter().map(move |method| (*method, damped)))
    });
    drag.chain(models).map(|(method, damped)| Oscillator { method, damped }.limit()).collect()
}

/// Limits of random nets of springs, by number, and of chains with a last mass of 1, 1e6, 1e-3 and 1e-6 kg, by every
/// method that has one.
#[must_use]
pub fn net_limits(nets: u64) -> Vec<Limit> {
    let chains = [1.0, 1e6, 1e-3, 1e-6].map(Net::chain);
    let nets: Vec<_> = chains.into_iter().chain((0..nets).map(Net::random)).collect();
    let limited = |method: &Method| {
        let limit = method.claims().stability_limit;
        limit > 0.0 && limit.is_finite()
    };
    nets.iter()
        .flat_map(|net| Method::ALL.into_iter().filter(limited).map(|method| net.limit(method)))
        .collect()
}

/// The table of `limits` as Markdown: system, method, measured, closed form, difference in percent.
#[must_use]
pub fn table(limits: &[Limit]) -> String {
    let head =
        "| system | method | measured w h | closed form | difference |\n| --- | --- | ---: | ---: | ---: |\n";
    let row = |limit: &Limit| format!("| {} |\n", limit.cells().join(" | "));
    limits.iter().map(row).fold(head.to_owned(), |table, row| table + &row)
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
