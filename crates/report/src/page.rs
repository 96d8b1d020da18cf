//! The report as one page that needs nothing beside it: the answers first, then figures, then every number.

mod parts;

pub(crate) use parts::table;
use parts::{details, duel, failures, machine, notes, precision_table, rates, times, words};

use super::chart::{dark_rules, escaped};
use super::figures::{ACCURACIES, Figure, Kind, accuracy_name, cost_name, costs, figures};
use super::numbers;
use super::slugs;
use super::words::{Topic, headline};
use lab::cost::{Accuracy, Cost, Report, Study};

pub(crate) const STYLE: &str = include_str!("page.css");

/// The page.
pub(crate) fn page(report: &Report) -> String {
    let slugs = slugs(&report.studies);
    let title = match &report.studies[..] {
        [one] => format!("What accuracy costs: {}", one.subject),
        _ => "What accuracy costs".to_owned(),
    };
    let incomplete = if report.complete {
        ""
    } else {
        "<p class=\"warning\">The run was cut short: some planned settings are missing.</p>"
    };
    let sections: String =
        report.studies.iter().zip(&slugs).map(|(study, slug)| section(study, slug)).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{STYLE}@media (prefers-color-scheme: dark) {{\n{}}}\n{}</style>\n</head>\n<body>\n<header>\n\
         <h1>{title}</h1>\n<p class=\"lead\">Every method of integration at a ladder of steps: how far it is from the \
         truth, and what it costs.</p>\n{incomplete}{}</header>\n<main>\n{sections}</main>\n{}</body>\n</html>\n",
        dark_rules(),
        selector_rules(),
        contents(report, &slugs),
        machine(report),
        title = escaped(&title),
    )
}

/// Subjects with their answers in one line, where there are several.
fn contents(report: &Report, slugs: &[String]) -> String {
    if report.studies.len() < 2 {
        return String::new();
    }
    let rows = report.studies.iter().zip(slugs).map(|(study, slug)| {
        format!(
            "<li><a href=\"#{slug}\">{}</a><span>{}</span></li>\n",
            escaped(&study.subject),
            escaped(&headline(study))
        )
    });
    format!("<nav><ol>\n{}</ol></nav>\n", rows.collect::<String>())
}

fn section(study: &Study, slug: &str) -> String {
    let figures = figures(study);
    let of = |kinds: fn(&Kind) -> bool| -> String {
        figures.iter().filter(|figure| kinds(&figure.kind)).map(shown).collect()
    };
    [
        format!(
            "<section id=\"{slug}\">\n<h2>{}</h2>\n<p class=\"about\">{}</p>\n<p class=\"answer\">{}</p>\n",
            escaped(&study.subject),
            escaped(&about(study)),
            escaped(&headline(study))
        ),
        words(study, &[Topic::Tutorial, Topic::Cheapest, Topic::Time, Topic::Verlet]),
        times(study),
        duel(study),
        selected(study, slug, &figures),
        words(study, &[Topic::Never, Topic::Orders, Topic::Truth]),
        of(|kind| *kind == Kind::Precision),
        words(study, &[Topic::Precision]),
        precision_table(study),
        of(|kind| matches!(kind, Kind::Drift(_))),
        words(study, &[Topic::Energy]),
        rates(study),
        failures(study),
        details(study),
        notes(study),
        "</section>\n".to_owned(),
    ]
    .concat()
}

fn about(study: &Study) -> String {
    let bodies = if study.bodies == 1 { "1 body".to_owned() } else { format!("{} bodies", study.bodies) };
    let period = study.period_s.map(|period| format!(", a period of {} s", numbers::number(period, 3)));
    let dot = if study.description.is_empty() || study.description.ends_with('.') { "" } else { "." };
    format!(
        "{}{dot} {bodies}, {} s at {} ticks a second{}.",
        study.description,
        numbers::number(study.simulated_s, 3),
        numbers::number(study.step_hz, 3),
        period.unwrap_or_default(),
    )
}

fn shown(figure: &Figure) -> String {
    let (classes, caption) = match figure.kind {
        Kind::Step(accuracy) => (
            format!("step {}", accuracy_name(accuracy)),
            "Error against step. A method of order p falls as a line of slope p; where it bends level, round-off or the \
             reference's own error is all that is left.",
        ),
        Kind::Cost(accuracy, cost) => (
            format!("cost {} {}", accuracy_name(accuracy), cost_name(cost)),
            "Error against cost. The lower left wins; settings on the thick line, the front, are named, and none of the \
             others beats them in both.",
        ),
        Kind::Precision => (
            "precision".to_owned(),
            "The same steps in double and in single precision. Where a dashed line turns up, smaller steps make it worse: \
             each adds a rounding.",
        ),
        Kind::Drift(_) => (
            "drift".to_owned(),
            "The largest share of energy that a method invented or lost until then. Symplectic methods swing within bounds; the others drift.",
        ),
    };
    format!(
        "<figure class=\"{classes}\">\n{}<figcaption>{caption}</figcaption>\n</figure>\n",
        figure.drawing.inline()
    )
}

/// The two panels, with what they show chosen above them.
fn selected(study: &Study, slug: &str, figures: &[Figure]) -> String {
    let costs = costs(study);
    let of = |kinds: fn(&Kind) -> bool| -> String {
        figures.iter().filter(|figure| kinds(&figure.kind)).map(shown).collect()
    };
    let panels = of(|kind| matches!(kind, Kind::Cost(..))) + &of(|kind| matches!(kind, Kind::Step(_)));
    if panels.is_empty() {
        return String::new();
    }
    let choice = |group: &str, class: String, words: &str, first: bool| {
        let checked = if first { " checked" } else { "" };
        format!(
            "<label><input type=\"radio\" name=\"{slug}-{group}\" class=\"by-{class}\"{checked}>{words}</label>\n"
        )
    };
    let of_costs: String = costs
        .iter()
        .enumerate()
        .map(|(i, cost)| choice("cost", cost_name(*cost).to_owned(), cost_words(*cost), i == 0))
        .collect();
    let of_errors: String = ACCURACIES
        .iter()
        .enumerate()
        .map(|(i, accuracy)| {
            choice("error", accuracy_name(*accuracy).to_owned(), accuracy_words(*accuracy), i == 0)
        })
        .collect();
    format!(
        "<div class=\"panels\">\n<div class=\"choices\">\n<fieldset><legend>Error</legend>\n{of_errors}</fieldset>\n\
         <fieldset><legend>Cost</legend>\n{of_costs}</fieldset>\n</div>\n{panels}</div>\n"
    )
}

const fn cost_words(cost: Cost) -> &'static str {
    match cost {
        Cost::Evaluations => "evaluations",
        Cost::Time => "CPU time per body",
        Cost::RealTime => "part of real time",
        Cost::Instructions => "instructions",
    }
}

const fn accuracy_words(accuracy: Accuracy) -> &'static str {
    match accuracy {
        Accuracy::Relative => "relative",
        Accuracy::Position => "of positions, m",
        Accuracy::Velocity => "of velocities, m/s",
    }
}

/// What is chosen is what is seen; without any script.
fn selector_rules() -> String {
    let shows = |classes: &[&str]| {
        let chosen: String = classes.iter().map(|class| format!(":has(.by-{class}:checked)")).collect();
        let panel = if let [_, _] = classes { "cost" } else { "step" };
        format!(".panels{chosen} figure.{panel}.{}{{display:block}}\n", classes.join("."))
    };
    let mut rules = String::new();
    for accuracy in ACCURACIES.map(accuracy_name) {
        rules += &shows(&[accuracy]);
        for cost in [Cost::Evaluations, Cost::Time, Cost::RealTime, Cost::Instructions].map(cost_name) {
            rules += &shows(&[accuracy, cost]);
        }
    }
    rules
}
