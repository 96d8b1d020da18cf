//! Every cell is run again. Of runs longer than `PREFIX` ticks that is their beginning, for which the matrix has a number of
//! its own: a million ticks at rest take minutes.

use lab::stability::{Cell, Class, Matrix, PREFIX, Prefix, StabilityRun};
use motion::Method;
use scene::Scene;

use super::committed;

/// How far numbers may be apart, relative: they are the same to the bit where arithmetic is, and short decimals in
/// the file.
const TOLERANCE: f64 = 1e-6;

/// What a run of at most [`PREFIX`] ticks gives.
fn beginning(cell: &Cell) -> Prefix {
    cell.prefix.unwrap_or(Prefix { class: cell.class, number: cell.number })
}

/// Cells of `found` that are not what `of` gives of those in `committed`, each in a sentence.
fn differences(committed: &Matrix, found: &Matrix, of: fn(&Cell) -> Prefix) -> Vec<String> {
    let mut different = Vec::new();
    let titles = |matrix: &Matrix| {
        matrix.rows.iter().map(lab::stability::CaseRow::title).collect::<Vec<_>>()
    };
    if titles(committed) != titles(found) {
        different.push(format!("rows were {:?} and are {:?}", titles(committed), titles(found)));
    }
    for (before, now) in committed.rows.iter().zip(&found.rows) {
        for cell in &now.cells {
            let name = format!("{} by {}", now.title(), cell.method.name());
            let Some(was) = before.cell(cell.method).map(of) else {
                different.push(format!("{name} is new"));
                continue;
            };
            let near = (was.number - cell.number).abs() <= TOLERANCE * was.number.abs();
            let same = near
                || was.number.to_bits() == cell.number.to_bits()
                || cell.class == Class::Refused;
            if was.class != cell.class || !same {
                let (before, after) = (was.class.name(), cell.class.name());
                different.push(format!(
                    "{name} was {before} {:e} and is {after} {:e}",
                    was.number, cell.number
                ));
            }
        }
    }
    different
}

fn found(cases: Vec<Scene>, methods: &[Method], ticks: Option<u64>) -> Matrix {
    let mut run = StabilityRun::new(cases, methods, ticks);
    while !run.work(1.0) {}
    run.matrix().clone()
}

#[track_caller]
fn assert_same(different: &[String]) {
    assert!(
        different.is_empty(),
        "run scripts/studies stability if that is meant:\n{}",
        different.join("\n")
    );
}

#[test]
fn every_cell_is_what_the_committed_matrix_has() {
    let cases = scene::cases().iter().map(|case| case.load().unwrap()).collect();
    let (before, now) = (committed(), found(cases, &Method::ALL, Some(PREFIX)));
    for row in before.rows.iter().chain(&now.rows) {
        assert!(row.cells.iter().map(|cell| cell.method).eq(Method::ALL), "{}", row.title());
    }
    assert_same(&differences(&before, &now, beginning));
}

/// All other runs of more than [`PREFIX`] ticks.
#[test]
fn a_close_passage_is_what_the_committed_matrix_has_to_its_end() {
    let mut before = committed();
    let long = before.rows.iter().filter(|row| row.ticks > PREFIX && row.case != "at_rest");
    assert!(long.map(|row| row.case.as_str()).eq(["close_passage"]));
    before.rows.retain(|row| row.case == "close_passage");
    let case = scene::load_case("close_passage").unwrap();
    let now = found(vec![case], &Method::ALL, None);
    assert_same(&differences(&before, &now, |cell| Prefix {
        class: cell.class,
        number: cell.number,
    }));
}

/// The whole run of one method.
#[test]
fn a_million_ticks_at_rest_are_what_the_committed_matrix_has() {
    let case = scene::load_case("at_rest").unwrap();
    let found = found(vec![case], &[Method::SemiImplicitEuler], None);
    let mut before = committed();
    before.rows.retain(|row| row.case == "at_rest");
    assert_eq!(before.rows.iter().map(|row| row.ticks).min(), Some(1_000_000));
    assert_same(&differences(&before, &found, |cell| Prefix {
        class: cell.class,
        number: cell.number,
    }));
}

#[test]
fn a_cell_that_changes_its_class_or_number_is_named_with_both() {
    let before = committed();
    let mut now = before.clone();
    let row = now.rows.iter_mut().find(|row| row.title() == "huge_steps").unwrap();
    let changed = &mut row.cells[2];
    assert_eq!((changed.method, changed.class), (Method::ImplicitEuler, Class::Decays));
    (changed.class, changed.number) = (Class::Bounded, -0.5);
    let exploded = row.cells.iter_mut().find(|cell| cell.class == Class::Explodes).unwrap();
    exploded.number *= 1.0 + 1e-5;
    for row in &mut now.rows {
        row.cells.iter_mut().for_each(|cell| {
            (cell.class, cell.number) = (beginning(cell).class, beginning(cell).number);
        });
    }
    let different = differences(&before, &now, beginning);
    assert_eq!(different.len(), 2, "{different:?}");
    assert!(different.iter().all(|line| line.starts_with("huge_steps by ")), "{different:?}");
    let lost = different.iter().find(|line| line.contains("implicit_euler was decays -")).unwrap();
    assert!(lost.ends_with(" and is bounded -5e-1"), "{lost}");
}
