//! What a study found as Markdown: its sentences, and the front as a table.

use super::numbers::{duration, length, number};
use super::words::words;
use crate::cost::{Accuracy, Cost, Machine, Study};

/// Sentences as a list, the settings that nothing beats in both position error and evaluations, and the machine.
/// Every number is the study's.
#[must_use]
pub fn markdown(study: &Study, machine: &Machine) -> String {
    let mut text = String::new();
    for sentence in words(study) {
        text += &format!("- {sentence}\n");
    }
    text += "\n| on the front | steps a second | error | evaluations a body-second | a body-step |\n";
    text += "| --- | --- | --- | --- | --- |\n";
    for cell in study.front(Accuracy::Position, Cost::Evaluations) {
        let error = study.error(cell, Accuracy::Position).map_or_else(String::new, |error| length(error, 2));
        let evaluations =
            study.cost(cell, Cost::Evaluations).map_or_else(String::new, |cost| number(cost, 3));
        let time = cell.time.as_ref().map_or_else(String::new, |time| duration(time.ns_per_body_step, 2));
        let setting = cell.setting;
        let rate = number(1.0 / study.step_s(setting), 3);
        text += &format!(
            "| `{}` x {} | {rate} | {error} | {evaluations} | {time} |\n",
            setting.method.name(),
            setting.substeps
        );
    }
    let Machine { processor, cores, system, compiler, .. } = machine;
    text + &format!(
        "\nMeasured on: {processor}, {cores} cores, {system}, {compiler}. Times are thread CPU time.\n"
    )
}
