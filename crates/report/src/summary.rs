//! The results of a study as text: in Markdown, and for a terminal.

use lab::cost::{Machine, Study};

use super::table::Table;
use super::tables::{every_run, ranking, tables};
use super::words::words;

/// The answers in short: the cheapest methods, the times of methods, and the machine. Every number is the study's.
pub fn brief(study: &Study, machine: &Machine) -> String {
    let mut text: String = words(study).iter().map(|sentence| format!("- {sentence}\n")).collect();
    let ranking = ranking(study);
    if !ranking.rows.is_empty() {
        text += &format!("\n{}", ranking.markdown());
    }
    let Machine { processor, cores, system, compiler, .. } = machine;
    text + &format!(
        "\nMeasured on: {processor}, {cores} cores, {system}, {compiler}. Times are thread CPU time; methods that tie (=) \
         differ by less than the spread of their passes.\n"
    )
}

/// [`brief`], then every table.
pub fn markdown(study: &Study, machine: &Machine) -> String {
    let part = |table: &Table| format!("\n### {}\n\n{}", table.title, table.markdown());
    brief(study, machine) + &tables(study).iter().map(part).collect::<String>()
}

/// A study for a terminal: sentences, what they are taken from, and every run.
pub fn text(study: &Study) -> String {
    let mut text = format!("{}: {}\n\n", study.subject, study.description);
    words(study).iter().for_each(|sentence| text += &format!("  {sentence}\n"));
    for table in tables(study) {
        text += &format!("\n{}:\n{}", table.title, table.aligned());
    }
    text + "\n" + &table(study) + "\n"
}

/// Methods by the time of a step, then every cell that was run, with a star on those of the front, in aligned
/// columns.
pub fn table(study: &Study) -> String {
    let mut text = String::new();
    let ranking = ranking(study);
    if !ranking.rows.is_empty() {
        text += &ranking.aligned();
        text += "= ties with the first of its rank: the times differ by less than the spread of their passes.\n\n";
    }
    text + &every_run(study).aligned()
        + "* on the front: nothing is both cheaper and more accurate.\n"
}
