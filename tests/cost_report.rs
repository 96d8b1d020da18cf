//! The report of a study, on studies whose answers are known.

#[path = "cost_report/fixture.rs"]
mod fixture;

use std::collections::BTreeMap;

use fixture::{fall, oscillator, report, rest};
use lab::cost::{
    Accuracy, Cost, Drift, Failure, Host, Outcome, Report, Study, TickTime, TimedTick, Truth,
};
use motion::Method;
use report::{CELLS_HEADER, Table, files, json, table, tables, words};

use crate::rigs::root;

use crate::cost::oscillator::overtakes;

/// All files by their names.
fn texts(report: &Report) -> BTreeMap<String, String> {
    files(report).map(|(name, bytes)| (name, String::from_utf8(bytes).unwrap())).collect()
}

#[track_caller]
fn sentence<'a>(words: &'a [String], beginning: &str) -> &'a str {
    let found = words.iter().find(|sentence| sentence.contains(beginning));
    found.unwrap_or_else(|| panic!("nothing says {beginning:?}: {words:#?}"))
}

/// The table of that title.
#[track_caller]
fn table_of(study: &Study, title: &str) -> Table {
    let found = tables(study).into_iter().find(|table| table.title.starts_with(title));
    found.unwrap_or_else(|| panic!("there is no table {title:?}"))
}

impl Rows for Table {
    #[track_caller]
    fn cell(&self, row: &str, column: &str) -> &str {
        let place = self.header.iter().position(|title| title.starts_with(column)).unwrap();
        let found = self.rows.iter().find(|cells| cells[0] == row);
        &found.unwrap_or_else(|| panic!("{row:?} is no row of {self:#?}"))[place]
    }
}

/// Cells by the first cell of their row and the start of their column's title.
trait Rows {
    fn cell(&self, row: &str, column: &str) -> &str;
}

/// A length as reports have it, m.
#[track_caller]
fn meters(text: &str) -> f64 {
    let (number, unit) = text.trim_end_matches(" *").split_once(' ').unwrap();
    let unit = ["m", "cm", "mm", "µm", "nm", "pm"]
        .into_iter()
        .zip([1.0, 1e-2, 1e-3, 1e-6, 1e-9, 1e-12])
        .find(|(name, _)| *name == unit);
    number.replace(',', "").parse::<f64>().unwrap() * unit.unwrap().1
}

/// A number as reports have it.
#[track_caller]
fn plain(text: &str) -> f64 {
    text.replace(',', "").parse().unwrap()
}

fn failed(study: &Study) -> usize {
    study.cells.iter().filter(|cell| cell.errors().is_none()).count()
}

fn fail_all(study: &mut Study) {
    for cell in &mut study.cells {
        cell.outcome = Outcome::Failed(Failure::BlewUp);
    }
}

#[test]
fn runge_kutta_4_overtakes_verlet_where_the_table_says() {
    let study = oscillator();
    // Phase errors of z²/24 and (4z)⁴/120 a radian are equal at 64 pi / sqrt(20) = 45 evaluations a period of 1 s; rungs
    // are a factor of up to 1.2 apart there.
    let (fourth, verlet) = (Method::RungeKutta4, Method::VelocityVerlet);
    let (at, _) = overtakes(&study, fourth, verlet, Accuracy::Position).unwrap();
    assert!((at - 45.0).abs() < 4.0 + 0.2 * 45.0, "{at}");
    let table = table_of(&study, "Errors at equal evaluations");
    let mut seen = 0;
    for row in &table.rows {
        let [verlet, fourth] = ["VV", "RK4"].map(|name| table.cell(&row[0], name));
        if verlet != "-" && fourth != "-" {
            let (cost, is_better) = (plain(&row[0]), meters(fourth) < meters(verlet));
            assert_eq!(is_better, cost > at, "{row:?}");
            seen += 1;
        }
    }
    assert!(seen > 5, "{table:?}");
}

#[test]
fn the_table_compares_verlet_and_runge_kutta_2_at_equal_evaluations() {
    let table = table_of(&oscillator(), "Errors at equal evaluations");
    let row = table.rows.iter().rev().find(|row| row.iter().all(|cell| cell != "-")).unwrap();
    for name in ["RK2 midpoint", "RK2 Heun"] {
        // z²/6 against (z/2)²/24, and z²/24 at equal steps.
        let factor = meters(table.cell(&row[0], name)) / meters(table.cell(&row[0], "VV"));
        assert!((factor - 16.0).abs() < 3.2, "{name}: {factor} in {row:?}");
    }
}

#[test]
fn words_answer_the_tutorials_question() {
    let said = words(&oscillator());
    let said = sentence(
        &said,
        "At equal evaluations Runge-Kutta 4 is more accurate than semi-implicit Euler",
    );
    assert!(said.contains("at every useful step"), "{said}");
    // The other way round: Runge-Kutta 4 with the errors of the Euler.
    let mut swapped = oscillator();
    for cell in &mut swapped.cells {
        cell.setting.method = match cell.setting.method {
            Method::RungeKutta4 => Method::SemiImplicitEuler,
            Method::SemiImplicitEuler => Method::RungeKutta4,
            other => other,
        };
    }
    swapped.cells.sort_by_key(|cell| (cell.setting.method, cell.setting.substeps));
    let per_step = |method: Method| u64::from(method.claims().evaluations);
    let ticks = swapped.ticks;
    for cell in &mut swapped.cells {
        cell.counts.accelerations =
            ticks * u64::from(cell.setting.substeps.least()) * per_step(cell.setting.method);
    }
    let said = words(&swapped);
    sentence(&said, "At equal evaluations semi-implicit Euler is more accurate than Runge-Kutta 4");
}

#[test]
fn the_cheapest_for_an_error_keeps_it_and_nothing_cheaper_does() {
    let study = oscillator();
    let table = table_of(&study, "Cheapest for an error within 10 s");
    let cost = plain(table.cell("below 1 mm", "evaluations"));
    let cheapest = study
        .cells
        .iter()
        .filter(|cell| cell.errors().is_some_and(|errors| errors.position_m <= 1e-3))
        .filter_map(|cell| study.cost(cell, Cost::Evaluations))
        .fold(f64::INFINITY, f64::min);
    assert!((cost / cheapest - 1.0).abs() < 0.03, "{table:?}, but {cheapest} evaluations do");
    assert!(table.cell("below 1 mm", "per body per step").ends_with(" ns"), "{table:?}");
    assert!(table.cell("below 1 mm", "of real time").ends_with(" %"), "{table:?}");
}

#[test]
fn headlines_are_read_from_the_table_that_they_head() {
    for study in [oscillator(), fall()] {
        let table = table_of(&study, "Cheapest for an error within 10 s");
        for (beginning, column, ends) in [
            ("Cheapest by evaluations: ", "cheapest by evaluations", "."),
            ("Cheapest by time with 1 body: ", "cheapest by time", "."),
        ] {
            let said = words(&study);
            let said = sentence(&said, beginning)
                .strip_prefix(beginning)
                .unwrap()
                .trim_end_matches(ends)
                .to_owned();
            let place = table.header.iter().position(|title| title == column).unwrap();
            // "A at 5 Hz (x 2) = B at 5 Hz (x 2)" names A = B; rows with the same methods are one span.
            let names = |cell: &str| {
                cell.split(" = ")
                    .map(|part| part.split(" at ").next().unwrap().to_owned())
                    .collect::<Vec<_>>()
            };
            let rows: Vec<_> = table
                .rows
                .iter()
                .map(|row| (names(&row[place]), row[0].replace("below ", "down to ")))
                .collect();
            let spans: Vec<_> = rows
                .chunk_by(|a, b| a.0 == b.0)
                .map(|span| format!("{} {}", span[0].0.join(" = "), span.last().unwrap().1))
                .collect();
            let said: Vec<_> =
                said.split(", then ").map(|span| span.replace(" (exact)", "")).collect();
            assert_eq!(said.len(), spans.len(), "{said:#?} {spans:#?}");
            for (said, span) in said.iter().zip(&spans) {
                assert!(span.starts_with(said.as_str()), "{said} is not {span}");
            }
        }
    }
}

#[test]
fn settings_that_cost_the_same_are_called_ties() {
    let table = table_of(&fall(), "Cheapest for an error");
    let last = &table.rows.last().unwrap()[1];
    assert!(
        last.starts_with("position Verlet at ") && last.contains(" = velocity Verlet at "),
        "{last}"
    );
}

#[test]
fn methods_tie_with_the_first_of_their_rank_and_not_with_each_other_in_a_chain() {
    let methods = [Method::SemiImplicitEuler, Method::VelocityVerlet, Method::PositionVerlet];
    let time = |(ns, method)| TickTime {
        method,
        host: Host::World,
        fixed_ns: 0.0,
        ns_per_body_step: ns,
        substeps: Some(1),
        yardstick_ns: 1.0,
        // A spread of 2 %.
        points: vec![TimedTick { body_steps: 1.0, ns, quartiles: [1.0, 1.02, 1.04] }],
    };
    let tick_times = [100.0, 101.5, 103.0].into_iter().zip(methods).map(time).collect();
    let study = Study { timed_bodies: Some(1), tick_times, ..fall() };
    let tied: Vec<_> =
        study.ranking(Host::World).into_iter().map(|place| (place.method, place.tied)).collect();
    assert_eq!(tied, [(methods[0], false), (methods[1], true), (methods[2], false)]);
}

#[test]
fn what_explicit_euler_is_worth_is_said() {
    let study = oscillator();
    assert_eq!(table_of(&study, "Methods").cell("explicit Euler", "cheapest of these"), "never");
    let failed = table_of(&study, "Runs that failed");
    assert_eq!(failed.cell("explicit Euler", "why"), "blew up");
    assert!(failed.cell("explicit Euler", "substeps").starts_with("x 10, x 12"), "{failed:?}");
}

#[test]
fn a_method_of_the_wrong_order_is_named() {
    let mut study = oscillator();
    let orders = |study: &Study| {
        table_of(study, "Methods").rows.into_iter().map(|row| row[1].clone()).collect::<Vec<_>>()
    };
    assert!(orders(&study).iter().all(|order| !order.contains("claimed")));
    // Runge-Kutta 4 with the errors of semi-implicit Euler: order 1.
    let euler: Vec<_> =
        study.curve(Method::SemiImplicitEuler).map(|cell| cell.outcome.clone()).collect();
    let broken = study.cells.iter_mut().filter(|cell| cell.setting.method == Method::RungeKutta4);
    for (cell, outcome) in broken.zip(euler) {
        cell.outcome = outcome;
    }
    assert_eq!(table_of(&study, "Methods").cell("Runge-Kutta 4", "order"), "1.0, claimed 4");
    assert_eq!(orders(&study).iter().filter(|order| order.contains("claimed")).count(), 1);
}

#[test]
fn an_order_is_not_fitted_below_ten_times_the_references_own_error() {
    let mut study = oscillator();
    let method = Method::VelocityVerlet;
    let order = |study: &Study| study.order(method, Accuracy::Position);
    let sound = order(&study).unwrap();
    assert!((sound - 2.0).abs() < 0.05, "{sound}");
    let errors = |study: &Study| -> Vec<f64> {
        study.curve(method).filter_map(|cell| study.error(cell, Accuracy::Position)).collect()
    };
    // The six finest are within ten times the uncertainty of the reference, which is all that they show.
    let errors = errors(&study);
    let own = errors[errors.len() - 6] / 9.9;
    study.truth = Truth::Reference {
        method: Method::RungeKutta4,
        substeps: 16,
        relative_error: own,
        position_error_m: own,
        exact_damping: false,
    };
    for cell in study.cells.iter_mut().filter(|cell| cell.setting.method == method) {
        if let Outcome::Finished(errors) = &mut cell.outcome {
            errors.position_m =
                if errors.position_m < 10.0 * own { 9.9 * own } else { errors.position_m };
        }
    }
    let told = order(&study).unwrap();
    assert!((told - 2.0).abs() < 0.05, "{told}");
    // One error that can be told has no slope.
    if let Truth::Reference { position_error_m, .. } = &mut study.truth {
        *position_error_m = 1e3;
    }
    assert_eq!(order(&study), None);
}

#[test]
fn exact_methods_are_called_exact() {
    let table = table_of(&fall(), "Methods");
    for exact in ["position Verlet", "velocity Verlet", "Runge-Kutta 4"] {
        assert_eq!(table.cell(exact, "order"), "exact");
    }
    for euler in ["explicit Euler", "semi-implicit Euler", "implicit Euler"] {
        assert_eq!(table.cell(euler, "order"), "1.0");
    }
    let words = words(&fall());
    assert!(words[0].ends_with(" then position Verlet = velocity Verlet (exact)."), "{}", words[0]);
    sentence(&words, "Runge-Kutta 4 is exact here; semi-implicit Euler has an error of");
}

#[test]
fn energy_is_bounded_or_grows_or_is_lost() {
    let table = table_of(&oscillator(), "Methods");
    let fate = |method| table.cell(method, "energy invented or lost over 400 s");
    for symplectic in ["semi-implicit Euler", "velocity Verlet", "Yoshida 4"] {
        assert!(fate(symplectic).contains(": within "), "{}", fate(symplectic));
    }
    let heun = fate("Runge-Kutta 2, Heun");
    assert!(heun.starts_with("x 240: grows as t^1.0 "), "{heun}");
    let lost = fate("implicit Euler");
    assert!(lost.ends_with(": loses 100 % of the energy at the start"), "{lost}");
    let grown = fate("explicit Euler");
    assert!(grown == "x 480: failed" || grown.contains("grows exponentially to "), "{grown}");
}

#[test]
fn a_doubtful_reference_ranks_nothing() {
    let mut study = oscillator();
    study.truth = Truth::Reference {
        method: Method::RungeKutta4,
        substeps: 16,
        relative_error: 0.7,
        position_error_m: 0.7,
        exact_damping: false,
    };
    let words = words(&study);
    assert!(words[0].starts_with("The reference is itself uncertain by 70 cm"), "{}", words[0]);
    assert!(!words.iter().any(|said| said.contains("cheapest")), "{words:#?}");
    assert!(!tables(&study).iter().any(|table| table.title.starts_with("Cheapest")));
}

#[test]
fn tables_have_a_row_a_cell() {
    let report = report(vec![oscillator(), fall()]);
    let files = texts(&report);
    let cells: usize = report.studies.iter().map(|study| study.cells.len()).sum();
    let mut lines = files["cells.csv"].lines();
    assert_eq!(lines.next(), Some(CELLS_HEADER));
    let page = std::fs::read_to_string(root().join("docs/contract/outputs.md")).unwrap();
    assert!(
        page.contains(&format!("`{CELLS_HEADER}`")),
        "outputs.md has other columns of cells.csv"
    );
    let columns = CELLS_HEADER.split(',').count();
    assert_eq!(columns, 15);
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), cells);
    assert!(rows.iter().all(|row| row.len() == columns));
    let cell = &report.studies[0].cells[3];
    let row = &rows[3];
    assert_eq!(row[..3], ["oscillator", "explicit_euler", "16"]);
    assert_eq!(row[3].parse::<f64>().unwrap(), report.studies[0].step_s(cell.setting));
    assert_eq!((row[4], row[7]), ("", "blew up"));
    let good = rows.iter().position(|row| row[7] == "finished").unwrap();
    let errors = report.studies[0].cells[good].errors().unwrap();
    assert_eq!(rows[good][5].parse::<f64>().unwrap(), errors.position_m);

    let samples: usize = report.studies[0].drifts.iter().map(|drift| drift.series.len()).sum();
    assert_eq!(files["drift.csv"].lines().count(), 1 + samples);
    assert_eq!(files["rates.csv"].lines().count(), 1 + report.studies[0].rates.len());
    // A header, a row a cell, and the meaning of the star.
    assert_eq!(table(&report.studies[0]).lines().count(), report.studies[0].cells.len() + 2);
}

#[test]
fn commas_and_quotes_stay_in_their_fields() {
    let mut study = fall();
    study.subject = "a, \"b\"".to_owned();
    let files = texts(&report(vec![study]));
    assert!(
        files["cells.csv"].lines().nth(1).unwrap().starts_with("\"a, \"\"b\"\"\",explicit_euler,")
    );
}

#[test]
fn the_json_is_the_report() {
    let report = report(vec![oscillator(), fall(), rest()]);
    let text = json(&report);
    assert_eq!(texts(&report)["report.json"], text);
    let again: Report = serde_json::from_str(&text).unwrap();
    assert!(again == report, "the report is not read as it was written");
}

#[test]
fn the_page_needs_nothing_beside_it() {
    let report = report(vec![oscillator(), fall()]);
    let page = &texts(&report)["report.html"];
    for outside in ["http:", "https:", "src=", "@import", "url(", "<script", "<link"] {
        assert!(!page.contains(outside), "the page has {outside}");
    }
    for number in ["NaN", "inf ", ">inf<", "-inf"] {
        assert!(!page.contains(number), "the page has {number}");
    }
    assert!(page.contains("A &lt;processor&gt; &amp; more") && !page.contains("<processor>"));
    for study in &report.studies {
        for said in words(study) {
            assert!(page.contains(&said), "the page lacks {said}");
        }
        for table in tables(study).iter().filter(|table| !table.title.starts_with("On the front")) {
            assert!(page.contains(&table.title), "the page lacks {}", table.title);
        }
    }
    assert_eq!(page.matches("<section").count(), 2);
    assert_eq!(page.matches("<nav>").count(), 1);
}

#[test]
fn every_choice_of_error_and_cost_has_its_figure_and_its_rule() {
    let page = &texts(&report(vec![oscillator()]))["report.html"];
    for error in ["position", "relative"] {
        assert_eq!(page.matches(&format!("figure class=\"step {error}\"")).count(), 1);
        for cost in ["evaluations", "time", "real-time"] {
            assert_eq!(page.matches(&format!("figure class=\"cost {error} {cost}\"")).count(), 1);
            assert_eq!(page.matches(&format!("class=\"by-{cost}\"")).count(), 1);
            assert!(
                page.contains(&format!(".panels:has(.by-{error}:checked):has(.by-{cost}:checked)"))
            );
        }
    }
}

#[test]
fn every_failed_run_is_a_cross_and_every_other_one_a_point() {
    let study = oscillator();
    let crosses = failed(&study);
    assert!(crosses > 0);
    let cells = study.cells.len();
    let files = texts(&report(vec![study]));
    let figures: Vec<_> = files.iter().filter(|(name, _)| name.contains("error-")).collect();
    assert_eq!(figures.len(), 8);
    for (name, svg) in figures {
        assert_eq!(svg.matches("class=\"failed").count(), crosses, "{name}");
        // Nine more are in the legend.
        assert_eq!(svg.matches("class=\"mark").count(), cells - crosses + 9, "{name}");
        assert!(!svg.contains("NaN") && !svg.contains("inf,") && !svg.contains("inf "), "{name}");
    }
}

#[test]
fn failed_runs_without_a_time_are_counted_where_they_cannot_be_placed() {
    let mut study = oscillator();
    let crosses = failed(&study);
    for cell in study.cells.iter_mut().filter(|cell| cell.errors().is_none()) {
        cell.time = None;
    }
    let files = texts(&report(vec![study]));
    let svg = &files["oscillator-error-cost-time-position.svg"];
    assert!(svg.contains(&format!("{crosses} runs without this cost")));
    assert!(!svg.contains("class=\"failed"));
}

#[test]
fn figures_have_names_of_letters_and_digits() {
    let files = texts(&report(vec![Study { subject: "<\"&'>.ron".to_owned(), ..rest() }]));
    let figures: Vec<_> = files.iter().filter(|(name, _)| name.ends_with(".svg")).collect();
    assert!(figures.len() > 2, "{}", figures.len());
    for (name, svg) in figures {
        assert!(svg.starts_with("<svg xmlns"), "{name}");
        assert!(name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c)), "{name}");
    }
}

#[test]
fn studies_without_anything_to_say_make_a_report() {
    let one_rung = |mut study: Study| {
        study.cells.retain(|cell| cell.setting.substeps == 80.into());
        study
    };
    let untimed = |mut study: Study| {
        for cell in &mut study.cells {
            (cell.time, cell.arithmetic_time) = (None, None);
        }
        study
    };
    let mut broken = oscillator();
    fail_all(&mut broken);
    let mut hopeless = oscillator();
    for cell in &mut hopeless.cells {
        if let Outcome::Finished(errors) = &mut cell.outcome {
            (errors.relative, errors.position_m, errors.velocity_m_s) =
                (f64::NAN, f64::INFINITY, f64::NAN);
        }
    }
    for drift in &mut hopeless.drifts {
        *drift = Drift { largest: None, series: vec![(1.0, f64::NAN)], ..drift.clone() };
    }
    let mut cut_short = oscillator();
    for cell in &mut cut_short.cells {
        cell.outcome = Outcome::Failed(Failure::NotRun);
    }
    let mut empty = fall();
    empty.cells.clear();
    let studies =
        [rest(), one_rung(oscillator()), untimed(oscillator()), broken, hopeless, cut_short, empty];
    for study in studies {
        let said = words(&study);
        assert!(!said.is_empty());
        let cells = tables(&study).into_iter().flat_map(|table| table.rows.into_iter().flatten());
        let said: Vec<_> = said.into_iter().chain(cells).collect();
        assert!(
            said.iter().all(|said| !said.contains("NaN") && !said.contains("inf")),
            "{said:#?}"
        );
        let subject = study.subject.clone();
        for (name, text) in texts(&report(vec![study])) {
            let is_data = name == "report.json";
            assert!(
                is_data || (!text.contains("NaN") && !text.contains(">inf")),
                "{subject}: {name}"
            );
        }
    }
}

#[test]
fn a_study_at_rest_says_so() {
    let said = words(&rest());
    assert_eq!(said[0], "Nothing moves here: every method is exact, and the cheapest will do.");
    assert!(said.iter().all(|said| !said.contains("below")), "{said:#?}");
    assert!(!tables(&rest()).iter().any(|table| table.title.starts_with("Cheapest")));
}

#[test]
fn subjects_of_one_name_keep_their_own_files() {
    let scene = |folder: &str| Study { subject: format!("{folder}/my scene.ron"), ..fall() };
    let files = texts(&report(vec![scene("a"), scene("b")]));
    for name in ["my-scene-error-step-position.svg", "my-scene-2-error-step-position.svg"] {
        assert!(files.contains_key(name), "{name} is not among {:?}", files.keys());
    }
}

#[test]
fn text_of_scene_files_does_nothing_on_pages_in_markdown_or_in_spreadsheets() {
    let mut study = oscillator();
    study.subject =
        "=HYPERLINK(\"http://a\",\"b\")<script>alert(1)</script>|[c](http://d)".to_owned();
    study.description = "<img src=x onerror=alert(1)>".to_owned();
    let files = texts(&report(vec![study]));
    for page in ["report.html", "summary.md"] {
        assert!(!files[page].contains("<script>alert") && !files[page].contains("<img"), "{page}");
    }
    assert!(!files["summary.md"].contains("|[c](http"), "a link or a cell");
    let rows = files["cells.csv"].lines().skip(1);
    assert!(rows.clone().count() > 0);
    for row in rows {
        assert!(row.starts_with("\"'=HYPERLINK(\"\"http"), "{row}");
    }
}
