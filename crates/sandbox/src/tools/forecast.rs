//! The forecast: how near everything is to instability.

mod panel;
mod state;

pub use state::ForecastRow;
pub(crate) use state::{Forecast, rows};
