//! What a study found as Markdown: the answers, then every sentence and the front as a table.

use super::numbers::{duration, length, number};
use super::ranking;
use super::words::{Topic, topics, words};
use lab::cost::{Accuracy, Cost, Machine, Study};

/// The answers in short: who is the cheapest, the times of methods, and the machine. Every number is the study's.
#[must_use]
pub fn brief(study: &Study, machine: &Machine) -> String {
    let short = [Topic::Line, Topic::Tutorial, Topic::Time];
    let said = topics(study).into_iter().filter(|(topic, _)| short.contains(topic));
    let mut text: String =
        said.flat_map(|(_, sentences)| sentences).map(|sentence| format!("- {sentence}\n")).collect();
    let rows = ranking::rows(study);
    if !rows.is_empty() {
        text += &format!("\n{}", table(&ranking::header(study), &rows));
    }
    let Machine { processor, cores, system, compiler, .. } = machine;
    text + &format!(
        "\nMeasured on: {processor}, {cores} cores, {system}, {compiler}. Times are thread CPU time; methods that tie (=) \
         differ by less than the spread of their rounds.\n"
    )
}

/// [`brief`], then every sentence, and the settings that nothing beats in both position error and evaluations.
#[must_use]
pub fn markdown(study: &Study, machine: &Machine) -> String {
    let mut text = brief(study, machine) + "\n### Everything that was found\n\n";
    for sentence in words(study) {
        text += &format!("- {sentence}\n");
    }
    let front = study.front(Accuracy::Position, Cost::Evaluations);
    let row = |cell: &&lab::cost::Cell| {
        let setting = cell.setting;
        [
            format!("`{}` x {}", setting.method.name(), setting.substeps),
            number(1.0 / study.step_s(setting), 3),
            study.error(cell, Accuracy::Position).map_or_else(String::new, |error| length(error, 2)),
            study.cost(cell, Cost::Evaluations).map_or_else(String::new, |cost| number(cost, 3)),
            cell.time.as_ref().map_or_else(String::new, |time| duration(time.ns_per_body_step, 2)),
        ]
    };
    let header =
        ["on the front", "steps per s", "error", "evaluations per body per s", "time per body per step"];
    text += &format!("\n{}", table(&header, &front.iter().map(row).collect::<Vec<_>>()));
    let arrays = ranking::of_arrays(study);
    if !arrays.is_empty() {
        text += &format!("\nOn plain arrays:\n\n{}", table(&ranking::ARRAYS, &arrays));
    }
    text
}

/// A table in Markdown.
fn table<const N: usize>(header: &[impl AsRef<str>; N], rows: &[[String; N]]) -> String {
    let titles: Vec<_> = header.iter().map(AsRef::as_ref).collect();
    let mut text = format!("| {} |\n|{}\n", titles.join(" | "), " --- |".repeat(N));
    for row in rows {
        text += &format!("| {} |\n", row.join(" | "));
    }
    text
}
