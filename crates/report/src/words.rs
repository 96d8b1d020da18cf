//! What a study found, in sentences whose every number is the study's.

mod accuracy;
mod duels;
mod health;
mod time;

use motion::Method;

pub(crate) use duels::tutorial_rounds;
pub use time::time_words;

use super::choice::{Lead, leads};
use super::numbers::{capital, length, number};
use super::reading::{self, SEEN};
use lab::cost::{Cell, Cost, Precision, Study};

/// What sentences are about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Topic {
    Line,
    Tutorial,
    Cheapest,
    Time,
    Verlet,
    Never,
    Precision,
    Orders,
    Energy,
    Failures,
    Truth,
}

impl Topic {
    pub(crate) const fn title(self) -> &'static str {
        match self {
            Self::Line => "In one line",
            Self::Tutorial => "Four small steps or one large",
            Self::Cheapest => "Cheapest for an error",
            Self::Time => "Time",
            Self::Verlet => "Verlet against Runge-Kutta",
            Self::Never => "Never worth it",
            Self::Precision => "Single precision",
            Self::Orders => "Orders",
            Self::Energy => "Energy",
            Self::Failures => "Failures",
            Self::Truth => "The truth",
        }
    }
}

/// What was found, in whole sentences, the most asked-for first.
#[must_use]
pub fn words(study: &Study) -> Vec<String> {
    topics(study).into_iter().flat_map(|(_, sentences)| sentences).collect()
}

/// The same by topics, those that have anything to say.
pub(crate) fn topics(study: &Study) -> Vec<(Topic, Vec<String>)> {
    let mut topics = vec![(Topic::Line, vec![headline(study)])];
    if reading::moves(study) && finished(study) && !reading::doubtful(study) {
        topics.extend([
            (Topic::Tutorial, duels::tutorial(study)),
            (Topic::Cheapest, accuracy::cheapest(study)),
            (Topic::Time, time::time(study)),
            (Topic::Verlet, duels::verlet(study)),
            (Topic::Never, accuracy::never(study)),
            (Topic::Precision, accuracy::single_precision(study)),
            (Topic::Orders, accuracy::orders(study)),
        ]);
    }
    topics.push((Topic::Energy, health::energy(study)));
    topics.push((Topic::Failures, health::failures(study)));
    topics.push((Topic::Truth, vec![health::truth(study)]));
    topics.retain(|(_, sentences)| !sentences.is_empty());
    topics
}

fn finished(study: &Study) -> bool {
    study.cells.iter().any(|cell| cell.setting.precision == Precision::F64 && cell.errors().is_some())
}

/// The answer in one line: who leads the front, and down to which error.
pub(crate) fn headline(study: &Study) -> String {
    if !reading::moves(study) {
        return "Nothing moves here: every method is exact, and the cheapest will do.".to_owned();
    }
    if !finished(study) {
        return "No run in double precision went through: there is nothing to compare.".to_owned();
    }
    if reading::doubtful(study) {
        return format!(
            "The reference is itself uncertain by {}: over {} s this motion ranks no method. A shorter run may.",
            length(study.truth.own_error().1, 2),
            number(study.simulated_s, 3),
        );
    }
    match &leads(study, Cost::Evaluations)[..] {
        [] => "Every step that was run is too coarse: no error is below a tenth of the motion.".to_owned(),
        [one] if reading::exact(study, one.method) => {
            format!("{} is the cheapest, and exact here.", capital(&title(one.method)))
        }
        [one] => {
            format!("{} is the cheapest at every accuracy that was reached.", capital(&title(one.method)))
        }
        leads => format!("Cheapest by evaluations: {}.", spans(study, leads)),
    }
}

/// Who leads down to which error.
fn spans(study: &Study, leads: &[Lead]) -> String {
    let Some((last, before)) = leads.split_last() else { return String::new() };
    let span = |lead: &Lead| format!("{} down to {}", title(lead.method), length(lead.down_to_m, 2));
    let spans: Vec<_> = before.iter().map(span).collect();
    match (reading::exact(study, last.method), spans.is_empty()) {
        (_, true) => format!("{} at every accuracy", title(last.method)),
        (true, _) => format!("{}; {} is exact", spans.join(", then "), title(last.method)),
        _ => format!("{}; {} below", spans.join(", then "), title(last.method)),
    }
}

/// The name in the middle of a sentence, where a comma would part it.
pub(crate) fn title(method: Method) -> String {
    method.claims().title.replace(',', "")
}

/// A setting with its steps a second.
pub(crate) fn setting(study: &Study, cell: &Cell) -> String {
    let hz = study.step_hz * f64::from(cell.setting.substeps);
    format!("{} at {} Hz (x {})", title(cell.setting.method), number(hz, 3), cell.setting.substeps)
}

/// Evaluations per second, and per period where there is one.
pub(crate) fn evaluations(study: &Study, per_second: f64) -> String {
    let of_a_period = |period| format!(" ({} per period)", number(per_second * period, 3));
    let per_period = study.period_s.map(of_a_period).unwrap_or_default();
    format!("{} evaluations per second{per_period}", number(per_second, 3))
}

/// "1 body", "1,000 bodies".
pub(crate) fn bodies(count: usize) -> String {
    #[expect(clippy::cast_precision_loss, reason = "a count of bodies")]
    let digits = number(count as f64, 9);
    format!("{digits} {}", if count == 1 { "body" } else { "bodies" })
}

fn error_of(study: &Study, cell: &Cell) -> String {
    study.error(cell, SEEN).map_or_else(|| "failed".to_owned(), |error| length(error, 2))
}
