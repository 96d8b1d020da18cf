//! The results of a study in a few sentences.

use lab::cost::{
    Cell, Contest, Cost, Crossing, Drift, EnergyScale, FailedRuns, Failure, Fate, Host, Lead, SEEN,
    Study, Truth,
};
use motion::Method;
use scene::Substepping;

use super::numbers::{capital, fold, length, number, share};
use super::palette::ink;

/// Substeps beside the name of a method: `x4`, or the error that they are chosen for.
pub(crate) fn times(substeps: Substepping) -> String {
    let number = substeps.fixed().map(|number| format!("x{number}"));
    number.unwrap_or_else(|| format!("{substeps:#}"))
}

/// The results in sentences, the answer in one line first.
pub fn words(study: &Study) -> Vec<String> {
    let mut words = vec![headline(study)];
    if study.ranks() {
        words.extend(tutorial(study));
        words.extend(cheapest_by_time(study));
        words.extend(alone(study));
        words.extend(changes(study));
    }
    words.push(truth(study));
    words
}

/// The answer in one line: which method leads the front, and down to which error.
pub(crate) fn headline(study: &Study) -> String {
    if !study.moves() {
        return "Nothing moves here: every method is exact, and the cheapest will do.".to_owned();
    }
    if !study.has_finished() {
        return "No run finished, so there is nothing to compare.".to_owned();
    }
    if study.is_uncertain() {
        return format!(
            "The reference is itself uncertain by {}: over {} s this motion ranks no method. A shorter run may.",
            length(study.truth.own_error().1, 2),
            number(study.simulated_s, 3),
        );
    }
    let leads = study.leads(Cost::Evaluations);
    if leads.is_empty() {
        return "Every step that was run is too coarse: no error is below a tenth of the motion."
            .to_owned();
    }
    format!("Cheapest by evaluations: {}.", spans(&leads))
}

/// Names the methods and the error down to which each is the cheapest, with "=" between those that tie.
fn spans(leads: &[Lead]) -> String {
    let span = |Lead { methods, below_m, are_exact }: &Lead| {
        let names: Vec<_> = methods.iter().map(|method| title(*method)).collect();
        let until = if *are_exact {
            "(exact)".to_owned()
        } else {
            format!("down to {}", length(*below_m, 2))
        };
        format!("{} {until}", names.join(" = "))
    };
    leads.iter().map(span).collect::<Vec<_>>().join(", then ")
}

/// The tutorial's question: one step of Runge-Kutta 4, or four of semi-implicit Euler?
fn tutorial(study: &Study) -> Option<String> {
    let Contest { coarse, fine, one_wins } =
        study.contest(Method::RungeKutta4, Method::SemiImplicitEuler)?;
    let method = |cell: &Cell| cell.setting.method;
    let (better, worse) = (method(coarse.better), method(coarse.worse));
    let at = evaluations(study, coarse.evaluations);
    if let Some(fine) = fine.filter(|_| !one_wins) {
        return Some(format!(
            "At equal evaluations {} is more accurate with coarse steps, {} times at {at}, and {} with fine ones, {} times \
             at {}.",
            title(better),
            fold(coarse.times),
            title(method(fine.better)),
            fold(fine.times),
            number(fine.evaluations, 3),
        ));
    }
    if study.is_exact(better) {
        let error = study.error(coarse.worse, SEEN);
        let error = error.map_or_else(|| "failed".to_owned(), |error| length(error, 2));
        return Some(format!(
            "{} is exact here; {} has an error of {error} at {at}.",
            capital(&title(better)),
            title(worse)
        ));
    }
    let fine = fine.map_or_else(String::new, |fine| {
        format!(", {} times at {}", fold(fine.times), number(fine.evaluations, 3))
    });
    Some(format!(
        "At equal evaluations {} is more accurate than {} at every useful step: its error is {} times smaller at {at}{fine}.",
        title(better),
        title(worse),
        fold(coarse.times),
    ))
}

/// The ranking of methods by the time of a step, and where it changes: "A < B = C", of which B and C tie.
pub fn time_words(study: &Study) -> Vec<String> {
    let places = study.ranking(Host::World);
    let mut text = String::new();
    for place in &places {
        text += match (text.is_empty(), place.tied) {
            (true, _) => "",
            (_, true) => " = ",
            (_, false) => " < ",
        };
        text += ink(place.method).short;
    }
    let ranking = format!("Time of a step with {}: {text}", bodies(study.size()));
    places.first().map(|_| ranking).into_iter().chain(changes(study)).collect()
}

/// The methods that the arithmetic alone would choose, and the overhead of this program.
fn alone(study: &Study) -> Option<String> {
    let (leads, over) = (study.leads(Cost::Arithmetic), study.over_arithmetic());
    let over = || over.iter().map(|over| over.times);
    let (least, most) = (over().reduce(f64::min)?, over().reduce(f64::max)?);
    let cheapest = if leads.is_empty() {
        String::new()
    } else {
        format!("Cheapest by the arithmetic alone, a loop over arrays: {}. ", spans(&leads))
    };
    Some(format!(
        "{cheapest}This program takes {} to {} times as long as the arithmetic alone with {}.",
        number(least, 2),
        number(most, 2),
        bodies(study.size())
    ))
}

/// Names the method that leads by time for each error, and the sizes at which others lead.
fn cheapest_by_time(study: &Study) -> Option<String> {
    let mut leads = study.leads_by_size().into_iter();
    let words = |(size, leads): (usize, Vec<Lead>)| format!("{}: {}", bodies(size), spans(&leads));
    let here = leads.next().map(words)?;
    let elsewhere: String = leads.map(|there| format!(". With {}", words(there))).collect();
    Some(format!("Cheapest by time with {here}{elsewhere}."))
}

/// The sizes at which two methods change places by the time of a step.
fn changes(study: &Study) -> Option<String> {
    let sizes = study.sizes();
    let change = |Crossing { above, below, body_steps }: &Crossing| {
        let from = if sizes.is_empty() {
            format!("{} substeps per tick", number(body_steps / study.size() as f64, 2))
        } else {
            bodies(body_steps.ceil() as usize)
        };
        format!("{} is faster than {} from {from} on", title(*above), title(*below))
    };
    let changes: Vec<_> = study.crossings().iter().map(change).collect();
    match &sizes[..] {
        _ if !changes.is_empty() => {
            Some(format!("The ranking by the time of a step changes: {}.", changes.join("; ")))
        }
        [least, .., most] => Some(format!(
            "The ranking by the time of a step is the same from {} to {}, ties aside.",
            bodies(*least),
            bodies(*most)
        )),
        _ => None,
    }
}

/// Says what errors are measured against.
fn truth(study: &Study) -> String {
    match &study.truth {
        Truth::ClosedForm { source } => {
            format!("Errors are measured against a closed form: {source}.")
        }
        Truth::Reference { method, substeps, position_error_m, exact_damping, .. } => format!(
            "Errors are measured against a run of {} with {substeps} substeps per tick, whose own error is {}{}.",
            title(*method),
            length(*position_error_m, 2),
            if *exact_damping {
                "; damping that multiplies once per tick is replaced there by its law"
            } else {
                ""
            },
        ),
    }
}

/// The title of a method without commas, for the middle of a sentence.
pub(crate) fn title(method: Method) -> String {
    method.claims().title.replace(',', "")
}

/// A setting with its steps per second.
pub(crate) fn setting(study: &Study, cell: &Cell) -> String {
    let hz = study.step_hz * study.steps(cell);
    format!(
        "{} at {} Hz (x {:#})",
        title(cell.setting.method),
        number(hz, 3),
        cell.setting.substeps
    )
}

/// Evaluations per second, and per period where there is one.
pub(crate) fn evaluations(study: &Study, per_second: f64) -> String {
    let of_a_period = |period| format!(" ({} per period)", number(per_second * period, 3));
    let per_period = study.period_s.map(of_a_period).unwrap_or_default();
    format!("{} evaluations per second{per_period}", number(per_second, 3))
}

/// "1 body", "1,000 bodies".
pub(crate) fn bodies(count: usize) -> String {
    let digits = number(count as f64, 9);
    format!("{digits} {}", if count == 1 { "body" } else { "bodies" })
}

/// What became of energy, in words, and what the numbers are relative to.
pub(crate) fn fate(drift: &Drift) -> String {
    let whole = match (drift.fate(), drift.scale) {
        (Fate::Failed | Fate::RoundOff, _) => return short_fate(drift),
        (Fate::Exponential(_), _) => "the energy at the start",
        (_, EnergyScale::Start) => "of the energy at the start",
        (_, EnergyScale::PeakKinetic) => "of the peak kinetic energy",
    };
    format!("{} {whole}", short_fate(drift))
}

/// What became of energy, without what the numbers are relative to.
pub(crate) fn short_fate(drift: &Drift) -> String {
    let part = |part: f64| share(part, 2);
    match drift.fate() {
        Fate::Failed => "failed".to_owned(),
        Fate::RoundOff => "round-off".to_owned(),
        Fate::Lost(largest) => format!("loses {}", part(largest)),
        Fate::Exponential(times) => format!("grows exponentially to {} times", fold(times)),
        Fate::Power(power, largest) => format!("grows as t^{power:.1} to {}", part(largest)),
        Fate::Grows(largest) => format!("grows to {}", part(largest)),
        Fate::Varies(largest) => format!("varies by up to {}", part(largest)),
        Fate::Within(largest) => format!("within {}", part(largest)),
    }
}

/// The common reason of these runs.
pub(crate) fn why(failed: &FailedRuns<'_>) -> String {
    let of = |failure: &&Failure| match failure {
        Failure::Quarantined { tick, .. } => *tick,
        Failure::Unconverged { steps } => *steps,
        Failure::BlewUp | Failure::NotRun | Failure::Unsolvable { .. } => 0,
    };
    let failures = || failed.runs.iter().map(|(_, failure)| *failure);
    match (failures().min_by_key(of), failures().max_by_key(of)) {
        (
            Some(Failure::Unconverged { steps: least }),
            Some(Failure::Unconverged { steps: most }),
        ) if least < most => {
            format!("{least} to {most} steps did not converge")
        }
        (Some(first @ Failure::Quarantined { .. }), _) if failed.runs.len() > 1 => {
            format!("bodies were quarantined; the first: {first}")
        }
        (Some(first), _) => first.to_string(),
        (None, _) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use lab::cost::Setting;

    use super::*;

    fn drift(scale: EnergyScale, start: f64, residual: impl Fn(f64) -> f64) -> Drift {
        let series: Vec<_> =
            (1..=200).map(|i| f64::from(i) / 20.0).map(|t| (t, residual(t))).collect();
        Drift {
            setting: Setting { method: Method::ExplicitEuler, substeps: 1.into() },
            long: false,
            simulated_s: 10.0,
            scale,
            start,
            largest: series.iter().map(|(_, residual)| residual.abs()).reduce(f64::max),
            series,
        }
    }

    #[test]
    fn an_exponential_growth_is_called_one_and_shares_say_of_what() {
        // The energy grows by 162 %, to which the peak kinetic energy comes near.
        let rate = 2.62_f64.ln() / 10.0;
        let grown = drift(EnergyScale::PeakKinetic, 0.4, |t| 0.4 * (rate * t).exp_m1());
        assert_eq!(fate(&grown), "grows exponentially to 2.6 times the energy at the start");
        assert_eq!(short_fate(&grown), "grows exponentially to 2.6 times");
        // Growth cannot be relative to an energy of 0 at the start.
        let from_nothing = Drift { start: 0.0, ..grown };
        assert!(
            fate(&from_nothing).ends_with("% of the peak kinetic energy"),
            "{}",
            fate(&from_nothing)
        );
        let line = drift(EnergyScale::Start, 1.0, |t| 1e-3 * t);
        assert_eq!(fate(&line), "grows as t^1.0 to 1 % of the energy at the start");
        let root = drift(EnergyScale::PeakKinetic, -0.5, |t| 1e-3 * t.sqrt());
        assert_eq!(fate(&root), "grows as t^0.5 to 0.32 % of the peak kinetic energy");
        let swing = drift(EnergyScale::Start, -1.0, |t| 1e-3 * (7.0 * t).sin());
        assert_eq!(fate(&swing), "within 0.1 % of the energy at the start");
        assert_eq!(short_fate(&swing), "within 0.1 %");
        let jump = drift(EnergyScale::Start, 1.0, |t| if t > 8.0 { 0.2 } else { 1e-6 });
        assert_eq!(fate(&jump), "grows to 20 % of the energy at the start");
        let lost = drift(EnergyScale::Start, 1.0, |t| (-t).exp_m1());
        assert_eq!(fate(&lost), "loses 100 % of the energy at the start");
    }
}
