//! `sandbox stability` itself, and cases as scenes.

use std::path::Path;

use lab::stability::{Matrix, StabilityRun};
use motion::Method;
use tempfile::TempDir;

use super::committed;
use crate::rigs::{command_lines, sandbox};

fn said(folder: impl AsRef<Path>, line: &str) -> String {
    let said = sandbox(folder, line);
    assert!(said.err.lines().all(|line| line.starts_with("made the folder ")), "{}", said.err);
    said.fine()
}

#[test]
fn a_row_and_two_columns_alone_are_those_of_the_whole() {
    let folder = TempDir::new().unwrap();
    let asked = "stability hitch hitch --method runge_kutta_4 --method explicit_euler";
    let json = said(folder.path(), &format!("{asked} --format json --out new/report"));
    let out = folder.path().join("new/report");
    let found: Matrix = serde_json::from_str(&json).unwrap();
    let mut expected = committed();
    expected.rows.retain(|row| row.case == "hitch");
    let asked_for = [Method::ExplicitEuler, Method::RungeKutta4];
    expected
        .rows
        .iter_mut()
        .for_each(|row| row.cells.retain(|cell| asked_for.contains(&cell.method)));
    assert_eq!(found, expected);

    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    assert_eq!(read("matrix.json"), json);
    let csv = read("matrix.csv");
    assert_eq!(csv.lines().count(), 1 + 4);
    assert_eq!(csv.lines().next(), Some("case,row,measure,ticks,method,class,number,bound,why"));
    assert!(
        csv.lines()
            .nth(1)
            .unwrap()
            .starts_with("hitch,as one step,energy,300,explicit_euler,explodes,")
    );
    let (svg, page) = (read("matrix.svg"), read("stability.html"));
    assert!(svg.starts_with("<svg xmlns=") && svg.trim_end().ends_with("</svg>"));
    for text in [&svg, &page] {
        assert!(text.contains(">explodes</text>") && text.contains("hitch: in fixed ticks"));
    }
    assert_eq!(read("matrix.md"), report::stability::markdown(&found));
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 5);
}

#[test]
fn the_table_has_a_line_a_row() {
    command_lines("stability");
}

#[test]
fn cases_are_scenes() {
    let list = said(".", "list cases");
    assert_eq!(list.lines().count(), scene::cases().len());
    let summary = said(".", "run over_damping --ticks 60 --damping exact");
    assert!(summary.contains("over_damping"), "{summary}");
}

#[test]
fn a_scene_of_ones_own_is_a_case_too() {
    let text = "(version: 1, bodies: [(name: \"a\", velocity_m_s: (1, 0, 0))],
        expect: (survival: (measure: reference, ticks: 120, exact_below: 1e-9, bounded_below: 0.1, script: [
            (at_s: 0.5, do: reverse_velocities), (at_s: 0.75, do: set_velocity(\"a\", (nan, 0, 0)))])))";
    let row = |ticks| {
        let scene = scene::Scene::parse("own", text).unwrap();
        let mut run = StabilityRun::new(vec![scene], &[Method::VelocityVerlet], ticks);
        while !run.work(0.01) {}
        run.matrix().rows[0].clone()
    };
    let prefix = row(Some(80));
    assert_eq!((prefix.cells[0].class.name(), prefix.ticks), ("exact", 80));
    let cell = &row(None).cells[0];
    assert_eq!(cell.class.name(), "explodes");
    assert!(cell.why.starts_with("a: ") && cell.why.ends_with(" in tick 91"), "{}", cell.why);
}
