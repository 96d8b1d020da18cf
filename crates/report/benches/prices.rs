//! What a step takes in a world over the arithmetic alone: every method, every problem that has a loop.
//!
//! Prints the tables of docs/performance.md, into which `scripts/studies prices` puts them; `-- PROBLEM ...` measures these
//! problems alone. Both sides have the same bits (`tests/cost/arithmetic.rs`).

use lab::cost::{Bench, PROBLEMS, Plan, Problem, Study, Subject, take_real_time_priority};

fn study(problem: &Problem, is_test: bool) -> Study {
    let plan = Plan {
        rungs: vec![256],
        passes: if is_test { 1 } else { 5 },
        timed: if is_test { 0.0 } else { 0.01 },
        longer: 0,
        rates: false,
        patience: if is_test { 0.0 } else { 1e6 },
        ..Plan::full()
    };
    let mut bench = Bench::new(Subject::of_problem(problem).expect("a problem of the list"), plan);
    while !bench.work(1.0) {}
    bench.study().clone()
}

fn main() {
    let (flags, names): (Vec<_>, Vec<_>) =
        std::env::args().skip(1).partition(|word| word.starts_with('-'));
    let is_test = flags.iter().any(|flag| flag == "--test");
    if take_real_time_priority() != Some(true) {
        eprintln!(
            "without real-time priority: as root, or with `sudo chrt -f 1`, times agree better"
        );
    }
    let named =
        |problem: &Problem| names.is_empty() || names.iter().any(|name| name == problem.name);
    let wanted = |problem: &&Problem| problem.has_loop() && named(problem);
    let studies: Vec<_> =
        PROBLEMS.iter().filter(wanted).map(|problem| study(problem, is_test)).collect();
    let sizes = if is_test { vec![1_000] } else { vec![1_000, 100_000] };
    for table in report::prices(&studies, &sizes) {
        println!("{}:\n\n{}", table.title, table.markdown());
    }
}
