//! What a study found, in a few sentences.

use lab::cost::{Answer, Cell, Cost, Crossing, Host, Study, Truth};
use motion::Method;

use super::numbers::{capital, fold, length, number};
use super::palette::ink;
use super::reading::{self, SEEN, exact, finished, ranks, rounds};

/// What was found in sentences, the answer in one line first.
pub fn words(study: &Study) -> Vec<String> {
    let mut words = vec![headline(study)];
    if ranks(study) {
        words.extend(tutorial(study));
        words.extend(cheapest_by_time(study));
        words.extend(alone(study));
        words.extend(changes(study));
    }
    words.push(truth(study));
    words
}

/// The answer in one line: who leads the front, and down to which error.
pub(crate) fn headline(study: &Study) -> String {
    if !reading::moves(study) {
        return "Nothing moves here: every method is exact, and the cheapest will do.".to_owned();
    }
    if !finished(study) {
        return "No run in double precision went through: there is nothing to compare.".to_owned();
    }
    if study.is_uncertain() {
        return format!(
            "The reference is itself uncertain by {}: over {} s this motion ranks no method. A shorter run may.",
            length(study.truth.own_error().1, 2),
            number(study.simulated_s, 3),
        );
    }
    let answers = answers(study, Cost::Evaluations);
    if answers.is_empty() {
        return "Every step that was run is too coarse: no error is below a tenth of the motion.".to_owned();
    }
    format!("Cheapest by evaluations: {}.", spans(study, &answers))
}

/// What is cheapest for errors of powers of ten, where methods can be ranked: the rows of the table of the cheapest settings.
pub(crate) fn answers(study: &Study, cost: Cost) -> Vec<Answer<'_>> {
    if ranks(study) { study.answers(cost) } else { Vec::new() }
}

/// Names the methods and the error down to which each is the cheapest, with "=" between those that tie.
fn spans(study: &Study, answers: &[Answer<'_>]) -> String {
    let methods = |answer: &Answer<'_>| answer.cheapest.methods();
    let spans = answers.chunk_by(|a, b| methods(a) == methods(b)).filter_map(|span| {
        let last = span.last()?;
        let names: Vec<_> = methods(last).into_iter().map(title).collect();
        let is_exact = methods(last).into_iter().all(|method| exact(study, method));
        let until =
            if is_exact { "(exact)".to_owned() } else { format!("down to {}", length(last.below_m, 2)) };
        Some(format!("{} {until}", names.join(" = ")))
    });
    spans.collect::<Vec<_>>().join(", then ")
}

/// The tutorial's question: one step of Runge-Kutta 4, or four of semi-implicit Euler?
fn tutorial(study: &Study) -> Option<String> {
    let (fourth, plain) = (Method::RungeKutta4, Method::SemiImplicitEuler);
    let rounds = rounds(study, fourth, plain);
    let of_use = rounds.iter().filter(|round| study.is_usable(round.first) || study.is_usable(round.second));
    let factors: Vec<_> = of_use.filter_map(|round| Some((round, round.factor(study)?))).collect();
    let [(coarse, first), ..] = factors[..] else { return None };
    let (fine, last) = *factors.last()?;
    let better = |factor: f64| if factor > 1.0 { fourth } else { plain };
    let times = |factor: f64| fold(factor.max(factor.recip()));
    let (start, end) = (better(first), better(last));
    if factors.iter().any(|(_, factor)| better(*factor) != start) {
        return Some(format!(
            "At equal evaluations {} is more accurate with coarse steps, {} times at {}, and {} with fine ones, {} times \
             at {}.",
            title(start),
            times(first),
            evaluations(study, coarse.evaluations),
            title(end),
            times(last),
            number(fine.evaluations, 3),
        ));
    }
    let (worse, its) = if start == fourth { (plain, coarse.second) } else { (fourth, coarse.first) };
    if exact(study, start) {
        let error = study.error(its, SEEN).map_or_else(|| "failed".to_owned(), |error| length(error, 2));
        let at = evaluations(study, coarse.evaluations);
        return Some(format!(
            "{} is exact here; {} has an error of {error} at {at}.",
            capital(&title(start)),
            title(worse)
        ));
    }
    let fine = match factors.len() {
        1 => String::new(),
        _ => format!(", {} times at {}", times(last), number(fine.evaluations, 3)),
    };
    Some(format!(
        "At equal evaluations {} is more accurate than {} at every useful step: its error is {} times smaller at {}{fine}.",
        title(start),
        title(worse),
        times(first),
        evaluations(study, coarse.evaluations),
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

/// What the arithmetic alone would choose, and what this program takes on top.
fn alone(study: &Study) -> Option<String> {
    let (answers, over) = (answers(study, Cost::Arithmetic), study.over_arithmetic());
    let over = || over.iter().map(|(_, times)| *times);
    let (least, most) = (over().reduce(f64::min)?, over().reduce(f64::max)?);
    let cheapest = if answers.is_empty() {
        String::new()
    } else {
        format!("Cheapest by the arithmetic alone, a loop over arrays: {}. ", spans(study, &answers))
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
    let here = answers(study, Cost::Time);
    if here.is_empty() {
        return None;
    }
    let methods =
        |answers: &[Answer<'_>]| answers.iter().map(|answer| answer.cheapest.methods()).collect::<Vec<_>>();
    let mut text = format!("Cheapest by time with {}: {}", bodies(study.size()), spans(study, &here));
    let mut last = methods(&here);
    for size in study.sizes().into_iter().filter(|size| *size != study.size()) {
        let study = study.at_size(size);
        let there = answers(&study, Cost::Time);
        if methods(&there) != methods(&here) && methods(&there) != last {
            text += &format!(". With {}: {}", bodies(size), spans(&study, &there));
        }
        last = methods(&there);
    }
    Some(text + ".")
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

/// What errors are measured against.
fn truth(study: &Study) -> String {
    match &study.truth {
        Truth::ClosedForm { source } => format!("Errors are measured against a closed form: {source}."),
        Truth::Reference { method, substeps, position_error_m, exact_damping, .. } => format!(
            "Errors are measured against a run of {} with {substeps} substeps per tick, whose own error is {}{}.",
            title(*method),
            length(*position_error_m, 2),
            if *exact_damping {
                "; damping that multiplies once per tick stands in it as the law that it stands for"
            } else {
                ""
            },
        ),
    }
}

/// The name in the middle of a sentence, where a comma would part it.
pub(crate) fn title(method: Method) -> String {
    method.claims().title.replace(',', "")
}

/// A setting with its steps per second.
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
    let digits = number(count as f64, 9);
    format!("{digits} {}", if count == 1 { "body" } else { "bodies" })
}
