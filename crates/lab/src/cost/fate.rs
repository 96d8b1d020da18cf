//! How the energy of a run develops.

use super::record::Drift;

/// How the energy of a run developed. Shares are of [`Drift::scale`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// The run failed.
    Failed,
    /// The residual is rounding.
    RoundOff,
    /// At the end the method has lost more than half of the scale; the value is the largest residual.
    Lost(f64),
    /// The energy grows exponentially; the value is its ratio to the start.
    Exponential(f64),
    /// The residual grows as a power of the time; the values are the power and the largest residual.
    Power(f64, f64),
    /// The residual grows in another way, to this share.
    Grows(f64),
    /// The residual does not grow, but is above a tenth.
    Varies(f64),
    /// The residual does not grow, and is at most a tenth.
    Within(f64),
}

impl Drift {
    /// How the energy developed.
    pub fn fate(&self) -> Fate {
        let Some(largest) = self.largest else { return Fate::Failed };
        if largest < ROUND_OFF {
            return Fate::RoundOff;
        }
        let Some((_, residual)) = self.series.last().copied() else { return Fate::Failed };
        match growth(self, largest) {
            _ if residual < -0.5 => Fate::Lost(largest),
            Some(Growth::Exponential) => Fate::Exponential(1.0 + residual / self.start),
            Some(Growth::Power(power)) => Fate::Power(power, largest),
            Some(Growth::Other) => Fate::Grows(largest),
            None if largest > 0.1 => Fate::Varies(largest),
            None => Fate::Within(largest),
        }
    }
}

/// Share of the energy below which a residual is rounding.
const ROUND_OFF: f64 = 1e-11;

/// How a residual of energy grows.
enum Growth {
    /// The energy is the exponential of the time.
    Exponential,
    /// The residual is a power of the time.
    Power(f64),
    /// Neither fits.
    Other,
}

/// Mean deviation of the logarithm of a residual up to which a curve fits it.
const FIT_TOLERANCE: f64 = 0.3;

/// Growth, relative to the start, below which an exponential cannot be told from a line.
const LEAST_EXPONENTIAL: f64 = 0.3;

/// How the largest residual so far grows; `None` if it does not.
fn growth(drift: &Drift, largest: f64) -> Option<Growth> {
    let (end, _) = drift.series.last()?;
    let (mut envelope, mut largest_so_far) = (Vec::with_capacity(drift.series.len()), 0.0_f64);
    for (time, residual) in &drift.series {
        largest_so_far = largest_so_far.max(residual.abs());
        envelope.push((*time, largest_so_far));
    }
    // A run settles before it grows.
    envelope.retain(|(time, size)| *time > 0.1 * end && *size > 0.0);
    let points = envelope;
    let (_, early) = points.iter().rfind(|(time, _)| *time <= 0.5 * end)?;
    // Samples in phase with the motion miss its peaks and say nothing about growth.
    if largest_so_far <= 0.5 * largest || largest_so_far <= 1.3 * early {
        return None;
    }
    let mean =
        |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|(time, _)| time.ln()), mean(&|(_, size)| size.ln()));
    let power = mean(&|(time, size)| (time.ln() - x) * (size.ln() - y))
        / mean(&|(time, _)| (time.ln() - x).powi(2));
    let off_power = mean(&|(time, size)| (size.ln() - y - power * (time.ln() - x)).abs());
    let start = drift.start;
    let off_exponential = if start > 0.0 && largest_so_far > LEAST_EXPONENTIAL * start {
        let rate =
            mean(&|(time, size)| time * (size / start).ln_1p()) / mean(&|(time, _)| time * time);
        mean(&|(time, size)| (size.ln() - (start * (rate * time).exp_m1()).ln()).abs())
    } else {
        f64::INFINITY
    };
    Some(match off_power.min(off_exponential) {
        off if off > FIT_TOLERANCE => Growth::Other,
        off if off < off_power => Growth::Exponential,
        _ => Growth::Power(power),
    })
}
