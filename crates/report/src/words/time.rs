//! Who is the cheapest by time, and at which sizes that changes.

use super::{bodies, spans, title};
use crate::choice::{Lead, leads};
use crate::numbers::number;
use crate::palette::ink;
use lab::cost::{Cost, Crossing, Study};

pub(super) fn time(study: &Study) -> Vec<String> {
    by_accuracy(study).into_iter().chain(changes(study)).collect()
}

/// The ranking of methods by the time of a step, and where it changes: "A < B = C", of which B and C tie.
#[must_use]
pub fn time_words(study: &Study) -> Vec<String> {
    let places = study.ranking();
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

/// Who leads by time for which error, and the sizes at which others do.
fn by_accuracy(study: &Study) -> Option<String> {
    let here = leads(study, Cost::Time);
    if here.is_empty() {
        return None;
    }
    let methods = |leads: &[Lead]| leads.iter().map(|lead| lead.method).collect::<Vec<_>>();
    let mut text = format!("Cheapest by time with {}: {}", bodies(study.size()), spans(study, &here));
    let mut last = methods(&here);
    for size in study.sizes().into_iter().filter(|size| *size != study.size()) {
        let there = leads(&study.at_size(size), Cost::Time);
        if methods(&there) != methods(&here) && methods(&there) != last {
            text += &format!(". With {}: {}", bodies(size), spans(study, &there));
        }
        last = methods(&there);
    }
    Some(text + ".")
}

/// The sizes at which two methods change places by the time of a step.
#[expect(clippy::cast_precision_loss, reason = "a count of bodies")]
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
