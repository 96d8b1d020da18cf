//! The report as one self-contained page: the answers first, then figures, then every number.

use lab::cost::{Cost, Machine, Report, Study};

use super::chart::{Drawing, dark_rules};
use super::escape::html;
use super::figures::{ACCURACIES, Kind, accuracy_name, cost_name, costs, figures};
use super::numbers::number;
use super::table::Table;
use super::tables::{
    cheapest, equal, every_run, failed, of_methods, phases, prices, ranking, rates,
};
use super::words::{bodies, evaluations, headline, setting, words};

const STYLE: &str = include_str!("page.css");

/// A page of sections, with a line below its title and more rules of style.
pub(crate) fn document(
    title: &str,
    lead: &str,
    rules: &str,
    header: &str,
    main: &str,
    footer: &str,
) -> String {
    let title = html(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{STYLE}{rules}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n<p class=\"lead\">{lead}</p>\n\
         {header}</header>\n<main>\n{main}</main>\n{footer}</body>\n</html>\n"
    )
}

/// A table under its title; empty if the table has no rows.
pub(crate) fn titled(table: &Table) -> String {
    if table.rows.is_empty() {
        return String::new();
    }
    format!("<h3>{}</h3>\n{}", html(&table.title), table.html())
}

/// A table that the reader can unfold; empty if it has no rows.
pub(crate) fn folded(table: &Table) -> String {
    if table.rows.is_empty() {
        return String::new();
    }
    format!("<details><summary>{}</summary>\n{}</details>\n", html(&table.title), table.html())
}

/// The page of a report.
pub(crate) fn page(report: &Report) -> String {
    let slugs = slugs(&report.studies);
    let title = match &report.studies[..] {
        [one] => format!("What accuracy costs: {}", one.subject),
        _ => "What accuracy costs".to_owned(),
    };
    let lead = "Every method of integration at a ladder of steps: how far it is from the truth, and what it costs.";
    let rules =
        format!("@media (prefers-color-scheme: dark) {{\n{}}}\n{}", dark_rules(), selector_rules());
    let incomplete = if report.complete {
        ""
    } else {
        "<p class=\"warning\">The run was cut short: some planned settings are missing.</p>"
    };
    let header = incomplete.to_owned() + &contents(report, &slugs);
    let sections: String = report
        .studies
        .iter()
        .zip(&slugs)
        .map(|(study, slug)| section(study, slug, &report.machine))
        .collect();
    document(&title, lead, &rules, &header, &sections, &machine(report))
}

/// Subjects with their answers in one line, if there are several subjects.
fn contents(report: &Report, slugs: &[String]) -> String {
    if report.studies.len() < 2 {
        return String::new();
    }
    let rows = report.studies.iter().zip(slugs).map(|(study, slug)| {
        format!(
            "<li><a href=\"#{slug}\">{}</a><span>{}</span></li>\n",
            html(&study.subject),
            html(&headline(study))
        )
    });
    let size = report.studies.iter().find_map(|study| study.timed_bodies);
    let prices: Vec<_> = size.map_or_else(Vec::new, |size| prices(&report.studies, &[size]));
    let prices: String = prices.iter().map(folded).collect();
    format!("<nav><ol>\n{}</ol></nav>\n{prices}", rows.collect::<String>())
}

fn section(study: &Study, slug: &str, machine: &Machine) -> String {
    let figures = figures(study, machine);
    let words = words(study);
    let sentences = words.iter().skip(1).map(|sentence| format!("<p>{}</p>\n", html(sentence)));
    [
        format!(
            "<section id=\"{slug}\">\n<h2>{}</h2>\n<p class=\"about\">{}</p>\n<p class=\"answer\">{}</p>\n",
            html(&study.subject),
            html(&about(study)),
            html(&words[0])
        ),
        sentences.collect(),
        titled(&cheapest(study)),
        titled(&ranking(study)),
        shown_of(&figures, |kind| *kind == Kind::Growth),
        selected(study, slug, &figures),
        titled(&of_methods(study)),
        titled(&phases(study)),
        folded(&equal(study)),
        shown_of(&figures, |kind| matches!(kind, Kind::Drift(_))),
        titled(&rates(study)),
        titled(&failed(study)),
        folded(&every_run(study)),
        notes(study),
        "</section>\n".to_owned(),
    ]
    .concat()
}

fn about(study: &Study) -> String {
    let period = study.period_s.map(|period| format!(", a period of {} s", number(period, 3)));
    let dot =
        if study.description.is_empty() || study.description.ends_with('.') { "" } else { "." };
    format!(
        "{}{dot} {}, {} s at {} ticks per second{}.",
        study.description,
        bodies(study.bodies),
        number(study.simulated_s, 3),
        number(study.step_hz, 3),
        period.unwrap_or_default(),
    )
}

fn shown((kind, drawing): &(Kind, Drawing)) -> String {
    let (classes, caption) = match *kind {
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
        Kind::Growth => (
            "growth".to_owned(),
            "The time of a step per body, of independent copies of the problem. A few bodies share the fixed cost of a tick; many \
             no longer fit into a cache, whose sizes are marked in bodies of 56 bytes.",
        ),
        Kind::Drift(_) => (
            "drift".to_owned(),
            "The most energy that a method invented or lost until then, as a part of the larger of its energy at the start and its \
             peak kinetic energy. Symplectic methods swing within bounds; the others drift.",
        ),
    };
    format!(
        "<figure class=\"{classes}\">\n{}<figcaption>{caption}</figcaption>\n</figure>\n",
        drawing.inline()
    )
}

/// The figures of some kinds.
fn shown_of(figures: &[(Kind, Drawing)], kinds: fn(&Kind) -> bool) -> String {
    figures.iter().filter(|(kind, _)| kinds(kind)).map(shown).collect()
}

/// The two panels, below controls that choose what they show.
fn selected(study: &Study, slug: &str, figures: &[(Kind, Drawing)]) -> String {
    let panels = shown_of(figures, |kind| matches!(kind, Kind::Cost(..)))
        + &shown_of(figures, |kind| matches!(kind, Kind::Step(_)));
    if panels.is_empty() {
        return String::new();
    }
    let choices = |group: &str, choices: Vec<(&str, &str)>| -> String {
        let choice = |(i, (class, words)): (usize, &(&str, &str))| {
            let checked = if i == 0 { " checked" } else { "" };
            format!(
                "<label><input type=\"radio\" name=\"{slug}-{group}\" class=\"by-{class}\"{checked}>{words}</label>\n"
            )
        };
        choices.iter().enumerate().map(choice).collect()
    };
    let of_errors = ACCURACIES.map(accuracy_name).into_iter().zip(["of positions, m", "relative"]);
    let of_costs = costs(study).into_iter().map(|cost| (cost_name(cost), cost_words(cost)));
    format!(
        "<div class=\"panels\">\n<div class=\"choices\">\n<fieldset><legend>Error</legend>\n{}</fieldset>\n\
         <fieldset><legend>Cost</legend>\n{}</fieldset>\n</div>\n{panels}</div>\n",
        choices("error", of_errors.collect()),
        choices("cost", of_costs.collect()),
    )
}

const fn cost_words(cost: Cost) -> &'static str {
    match cost {
        Cost::Evaluations => "evaluations",
        Cost::Time => "CPU time per body",
        Cost::Arithmetic => "CPU time of the arithmetic alone",
        Cost::RealTime => "part of real time",
    }
}

/// Rules that show what is chosen, without any script.
fn selector_rules() -> String {
    let shows = |classes: &[&str]| {
        let chosen: String =
            classes.iter().map(|class| format!(":has(.by-{class}:checked)")).collect();
        let panel = if let [_, _] = classes { "cost" } else { "step" };
        format!(".panels{chosen} figure.{panel}.{}{{display:block}}\n", classes.join("."))
    };
    let mut rules = String::new();
    for accuracy in ACCURACIES.map(accuracy_name) {
        rules += &shows(&[accuracy]);
        for cost in Cost::ALL.map(cost_name) {
            rules += &shows(&[accuracy, cost]);
        }
    }
    rules
}

/// Notes for the reader.
fn notes(study: &Study) -> String {
    let own = study.cells.iter().find(|cell| cell.setting == study.own);
    let own = own.map(|cell| {
        let cost = study.cost(cell, Cost::Evaluations).unwrap_or(f64::NAN);
        format!("As the scene is set: {}, {}.", setting(study, cell), evaluations(study, cost))
    });
    let ties = "Times that tie (=) differ by less than the spread of their passes. A star is on what no other setting beats \
        in both error and cost."
        .to_owned();
    let items = own
        .iter()
        .chain(&study.notes)
        .chain([&ties])
        .map(|note| format!("<li>{}</li>\n", html(note)));
    format!("<ul class=\"notes\">\n{}</ul>\n", items.collect::<String>())
}

/// The machine of the measurements, and how they were made.
fn machine(report: &Report) -> String {
    let Report { machine, command, .. } = report;
    let rows = [
        ("Processor", format!("{} ({} cores)", machine.processor, machine.cores)),
        ("System", machine.system.clone()),
        ("Vector instructions", machine.instructions.clone()),
        ("Version", machine.version.clone()),
        ("Compiler", machine.compiler.clone()),
        ("Command", command.clone()),
    ];
    let rows: String = rows
        .iter()
        .map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>\n", html(value)))
        .collect();
    format!(
        "<footer>\n<h2>Measured on</h2>\n<dl>\n{rows}</dl>\n<p>Error and time are measured in runs of their own: the one \
         is compared with the truth after every tick and looks at no clock, the other is timed in thread CPU time, block by \
         block, the least of several, in turns with a fixed yardstick. Relative errors are the largest over bodies and \
         times of the distances in position and velocity together, each in units of the motion's own scale; a run that \
         blew up, was quarantined or did not converge is a cross and never a point.</p>\n</footer>\n"
    )
}

/// Names of files and anchors for subjects, which may be paths: letters, digits and dashes, no two alike.
pub(crate) fn slugs(studies: &[Study]) -> Vec<String> {
    let mut slugs: Vec<String> = Vec::new();
    for study in studies {
        let stem = study.subject.rsplit(['/', '\\']).next().unwrap_or_default();
        let stem = stem.strip_suffix(".ron").unwrap_or(stem);
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
        let mut slug: String = stem.chars().map(plain).collect();
        if slug.is_empty() {
            slug.push_str("study");
        }
        if slugs.contains(&slug) {
            slug = format!("{slug}-{}", slugs.len() + 1);
        }
        slugs.push(slug);
    }
    slugs
}
