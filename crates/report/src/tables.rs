//! What a study found, as tables.

use lab::cost::{
    Accuracy, Answer, Cell, Cheapest, Cost, Host, Outcome, Place, Precision, RateRow, Study, TickTime,
};
use motion::Method;

use super::numbers::{NONE, duration, length, number, share};
use super::palette::ink;
use super::reading::{SEEN, claimed_orders, exact, failures, fate, floor, methods, ranks};
use super::table::Table;
use super::words::{answers, bodies, setting, title};

/// The tables of a summary, those that have any rows.
pub fn tables(study: &Study) -> Vec<Table> {
    let tables = [
        cheapest(study),
        of_methods(study),
        phases(study),
        equal(study),
        failed(study),
        front(study),
        by_precision(study),
    ];
    tables.into_iter().filter(|table| !table.rows.is_empty()).collect()
}

fn or_none<T>(value: Option<T>, text: impl Fn(T) -> String) -> String {
    value.map_or_else(|| NONE.to_owned(), text)
}

/// The cheapest settings for each error, with "=" between those that tie. Of errors with one answer there is the smallest,
/// which says the others.
pub(crate) fn cheapest(study: &Study) -> Table {
    let [by_evaluations, by_time, by_arithmetic] =
        [Cost::Evaluations, Cost::Time, Cost::Arithmetic].map(|cost| answers(study, cost));
    let of_bound = |below_m: f64| move |answer: &&Answer<'_>| answer.below_m.to_bits() == below_m.to_bits();
    let quick = |below_m: f64| by_time.iter().find(of_bound(below_m));
    let alone = |below_m: f64| {
        let found = by_arithmetic.iter().find(of_bound(below_m));
        found.map(|answer| settings(study, &answer.cheapest))
    };
    let rows: Vec<_> = by_evaluations.iter().map(|answer| (answer, quick(answer.below_m))).collect();
    let picks = |(answer, quick): (&Answer<'_>, Option<&Answer<'_>>)| {
        let quick = quick.map(|quick| settings(study, &quick.cheapest));
        (settings(study, &answer.cheapest), quick, alone(answer.below_m))
    };
    let is_last = |i: usize| rows.get(i + 1).is_none_or(|next| picks(*next) != picks(rows[i]));
    let row = |(answer, quick): (&Answer<'_>, Option<&Answer<'_>>)| {
        let quickest = quick.map(|quick| quick.cheapest.cell);
        let real_time = quickest.and_then(|cell| study.cost(cell, Cost::RealTime));
        vec![
            format!("below {}", length(answer.below_m, 2)),
            settings(study, &answer.cheapest),
            or_none(study.cost(answer.cheapest.cell, Cost::Evaluations), |cost| number(cost, 3)),
            or_none(quick, |quick| settings(study, &quick.cheapest)),
            or_none(quickest.and_then(|cell| cell.time), |time| duration(time.ns_per_body_step, 2)),
            or_none(real_time, |part| share(part, 2)),
        ]
        .into_iter()
        .chain((!by_arithmetic.is_empty()).then(|| or_none(alone(answer.below_m), |alone| alone)))
        .collect()
    };
    let header = [
        "error",
        "cheapest by evaluations",
        "evaluations per body per s",
        "cheapest by time",
        "per body per step",
        "of real time",
    ];
    let header =
        header.into_iter().chain((!by_arithmetic.is_empty()).then_some("cheapest by the arithmetic alone"));
    let title = format!("Cheapest for an error within {} s", number(study.simulated_s, 3));
    Table::words(title, header, (0..rows.len()).filter(|i| is_last(*i)).map(|i| row(rows[i])))
}

/// The cheapest setting, and those that tie with it.
fn settings(study: &Study, cheapest: &Cheapest<'_>) -> String {
    let all = [cheapest.cell].into_iter().chain(cheapest.ties.iter().copied());
    all.map(|cell| setting(study, cell)).collect::<Vec<_>>().join(" = ")
}

/// Methods by the time of a step, the shortest first; "=" is on those that tie.
pub(crate) fn ranking(study: &Study) -> Table {
    let (places, alone) = (study.ranking(Host::World), study.ranking(Host::Arithmetic));
    // Compared with semi-implicit Euler, or the first.
    let base_of = |places: &[Place]| {
        places.iter().find(|place| place.method == Method::SemiImplicitEuler).or(places.first()).copied()
    };
    let (base, base_alone, over) = (base_of(&places), base_of(&alone), study.over_arithmetic());
    let mut rank = 0;
    let row = |(i, place): (usize, &Place)| {
        let Place { method, ns_per_body_step, tied } = *place;
        if !tied {
            rank = i + 1;
        }
        let shares = tied || places.get(i + 1).is_some_and(|next| next.tied);
        let line = study.world_times().find(|of| of.method == method);
        vec![
            format!("{rank}{}", if shares { " =" } else { "" }),
            method.claims().title.to_owned(),
            or_none(line, |of| duration(of.fixed_ns, 2)),
            or_none(line, |of| duration(of.ns_per_body_step, 2)),
            duration(ns_per_body_step, 2),
            or_none(base, |base| number(ns_per_body_step / base.ns_per_body_step, 2)),
        ]
        .into_iter()
        .chain(base_alone.into_iter().flat_map(|base| {
            let own = alone.iter().find(|place| place.method == method).map(|place| place.ns_per_body_step);
            let over = over.iter().find(|(of, _)| *of == method);
            [
                or_none(own, |own| duration(own, 2)),
                or_none(own, |own| number(own / base.ns_per_body_step, 2)),
                or_none(over, |(_, times)| number(*times, 2)),
            ]
        }))
        .collect()
    };
    let header = [
        "rank".to_owned(),
        "method".to_owned(),
        "line: fixed per tick".to_owned(),
        "line: per body per step".to_owned(),
        format!("measured: per body per step with {}", bodies(study.size())),
        format!("times {}", base.map_or_else(String::new, |base| title(base.method))),
    ];
    let of_alone = base_alone.into_iter().flat_map(|base| {
        let alone = "the arithmetic alone: per body per step".to_owned();
        [alone, format!("times {}", title(base.method)), "this program over it".to_owned()]
    });
    let header = header.into_iter().chain(of_alone);
    Table::numbers("Time of a step", header, places.iter().enumerate().map(row))
}

/// What a step takes in this program over the arithmetic alone, and what the arithmetic takes, by method and problem; of
/// several sizes, one after another. Empty where no loop was timed.
pub fn prices(studies: &[Study], sizes: &[usize]) -> Vec<Table> {
    let timed: Vec<_> = studies.iter().filter(|study| !study.over_arithmetic().is_empty()).collect();
    if timed.is_empty() {
        return Vec::new();
    }
    let header = || std::iter::once("method").chain(timed.iter().map(|study| &*study.subject));
    let rows = |cell: &dyn Fn(&Study, Method) -> Option<f64>, sizes: &[usize]| -> Vec<Vec<String>> {
        let at = |study: &Study, method| {
            let each =
                sizes.iter().map(|size| or_none(cell(&study.at_size(*size), method), |n| number(n, 2)));
            each.collect::<Vec<_>>().join(", ")
        };
        let row = |method: Method| {
            let cells = timed.iter().map(|study| at(study, method));
            std::iter::once(method.claims().title.to_owned()).chain(cells).collect()
        };
        Method::ALL.into_iter().map(row).collect()
    };
    let over = |study: &Study, method| {
        study.over_arithmetic().into_iter().find(|(of, _)| *of == method).map(|(_, times)| times)
    };
    let alone = |study: &Study, method| {
        let places = study.ranking(Host::Arithmetic);
        places.into_iter().find(|place| place.method == method).map(|place| place.ns_per_body_step)
    };
    let with: Vec<_> = sizes.iter().map(|size| bodies(*size)).collect();
    let with = with.join(" and with ");
    vec![
        Table::numbers(
            format!("This program over the arithmetic alone, with {with}"),
            header(),
            rows(&over, sizes),
        ),
        Table::numbers(
            format!("The arithmetic alone, ns per body per step, with {}", bodies(sizes[0])),
            header(),
            rows(&alone, &sizes[..1]),
        ),
    ]
}

/// Times of the arithmetic alone, by method and precision.
pub(crate) fn by_precision(study: &Study) -> Table {
    let row = |of: &TickTime| {
        vec![
            of.method.claims().title.to_owned(),
            of.precision.name().to_owned(),
            duration(of.fixed_ns, 2),
            duration(of.ns_per_body_step, 2),
        ]
    };
    let single = |method| methods(study, Precision::F32).contains(&method);
    let alone = study.tick_times.iter().filter(|of| of.host == Host::Arithmetic && single(of.method));
    Table::numbers(
        "By precision: the arithmetic alone",
        ["method", "precision", "line: fixed per tick", "line: per body per step"],
        alone.map(row),
    )
}

/// What each method is worth: its order, whether it is ever the best choice, what single precision leaves of it, and
/// what it does to energy.
pub(crate) fn of_methods(study: &Study) -> Table {
    let ranks = ranks(study);
    let never = [Cost::Evaluations, Cost::Time]
        .map(|cost| (!answers(study, cost).is_empty()).then(|| study.never_best(cost)));
    let best = |method: Method| {
        let by = ["evaluations", "time"].into_iter().zip(&never);
        let by: Vec<_> =
            by.filter(|(_, never)| never.as_ref().is_some_and(|never| !never.contains(&method))).collect();
        match &by[..] {
            _ if never.iter().all(Option::is_none) => NONE.to_owned(),
            [] => "never".to_owned(),
            by => by.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" and "),
        }
    };
    let lengths: Vec<_> = [false, true]
        .into_iter()
        .filter_map(|long| Some((long, study.drifts.iter().find(|drift| drift.long == long)?.simulated_s)))
        .collect();
    let row = |method: Method| {
        let mut row = vec![method.claims().title.to_owned()];
        row.push(if ranks { order(study, method) } else { NONE.to_owned() });
        row.push(best(method));
        row.push(single_precision(study, method).filter(|_| ranks).unwrap_or_else(|| NONE.to_owned()));
        for (long, _) in &lengths {
            let drift =
                study.drifts.iter().find(|drift| drift.long == *long && drift.setting.method == method);
            row.push(or_none(drift, |drift| format!("x {}: {}", drift.setting.substeps, fate(drift))));
        }
        row
    };
    let header = ["method", "order", "best choice by", "in single precision"].map(str::to_owned);
    let energy = lengths.iter().map(|(_, s)| format!("energy invented or lost over {} s", number(*s, 3)));
    let rows = methods(study, Precision::F64).into_iter().map(row);
    Table::words("Methods", header.into_iter().chain(energy), rows)
}

/// The order that errors show, and what the table of methods claims where that is another.
fn order(study: &Study, method: Method) -> String {
    if exact(study, method) {
        return if study.truth.own_error().1 > 0.0 { "as exact as the reference" } else { "exact" }
            .to_owned();
    }
    let finest = study.curve(method, Precision::F64).filter(|cell| cell.errors().is_some()).last();
    let order = study.order(method, SEEN).filter(|_| finest.is_some_and(|cell| study.is_usable(cell)));
    let Some(shows) = order else { return NONE.to_owned() };
    let off = |order: &u32| (shows - f64::from(*order)).abs();
    match claimed_orders(study, method).into_iter().min_by(|a, b| off(a).total_cmp(&off(b))) {
        Some(claimed) if off(&claimed) > 0.25 => format!("{shows:.1}, claimed {claimed}"),
        _ => format!("{shows:.1}"),
    }
}

/// The least error in single precision, and where; `None` where no run of it went through.
fn single_precision(study: &Study, method: Method) -> Option<String> {
    let (best, least, worse) = floor(study, method, Precision::F32)?;
    let double = floor(study, method, Precision::F64).map(|(_, least, _)| least);
    if !worse && double.is_some_and(|double| least <= 1.5 * double) {
        return Some("as good".to_owned());
    }
    let finer = if worse { ", finer steps are worse" } else { "" };
    let compensated = floor(study, method, Precision::CompensatedF32)
        .map(|(_, least, _)| format!("; compensated {}", length(least, 2)));
    Some(format!(
        "{} at x {}{finer}{}",
        length(least, 2),
        best.setting.substeps,
        compensated.unwrap_or_default()
    ))
}

/// Phase and amplitude at the end of the run apart, of every method at the same step: the middle one of those that were run.
pub(crate) fn phases(study: &Study) -> Table {
    let has_phase = |cell: &&Cell| cell.errors().is_some_and(|errors| errors.phase.is_some());
    let methods = methods(study, Precision::F64);
    let mut rungs: Vec<u32> = methods
        .iter()
        .flat_map(|method| study.curve(*method, Precision::F64))
        .filter(has_phase)
        .map(|cell| cell.setting.substeps)
        .collect();
    rungs.sort_unstable();
    rungs.dedup();
    let middle = rungs.get(rungs.len() / 2).copied();
    let row = |method: &Method| {
        let cell = study.curve(*method, Precision::F64).find(|cell| Some(cell.setting.substeps) == middle)?;
        let (phase, period_s) = (cell.errors()?.phase?, study.period_s?);
        let late = if phase.late_s < 0.0 { "early" } else { "late" };
        // Farther off than the motion is large, a run has no phase.
        let has_phase = (phase.off_path < 1.0).then_some(phase.late_s.abs());
        Some(vec![
            method.claims().title.to_owned(),
            number(1.0 / study.step_s(cell.setting), 3),
            or_none(has_phase, |off| format!("{} {late}", duration(1e9 * off, 2))),
            or_none(has_phase, |off| share(off / period_s, 2)),
            share(phase.off_path, 2),
        ])
    };
    let title = format!("Phase and amplitude apart, after {} s", number(study.simulated_s, 3));
    let header = ["method", "steps per s", "phase", "of a period", "amplitude and shape: off the path"];
    Table::numbers(title, header, methods.iter().filter_map(row))
}

/// Errors of positions at equal evaluations, the least of a row with a star.
pub(crate) fn equal(study: &Study) -> Table {
    let methods = if ranks(study) { methods(study, Precision::F64) } else { Vec::new() };
    let base = methods.iter().find(|method| **method == Method::SemiImplicitEuler).or(methods.first());
    let mut costs: Vec<f64> = Vec::new();
    for cell in base.into_iter().flat_map(|base| study.curve(*base, Precision::F64)) {
        let cost = study.cost(cell, Cost::Evaluations).filter(|cost| *cost > 0.0);
        costs.extend(cost.filter(|cost| costs.last().is_none_or(|last| *cost > 1.9 * last)));
    }
    let row = |cost: &f64| {
        let errors: Vec<_> =
            methods.iter().map(|method| study.error_at(*method, SEEN, Cost::Evaluations, *cost)).collect();
        let least = errors.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let star = |error: f64| if error <= least { " *" } else { "" };
        let cells = errors.iter().map(|error| or_none(*error, |error| length(error, 2) + star(error)));
        std::iter::once(number(*cost, 3)).chain(cells).collect()
    };
    let header =
        std::iter::once("evaluations per body per s").chain(methods.iter().map(|method| ink(*method).short));
    Table::numbers("Errors at equal evaluations, the least with a star", header, costs.iter().map(row))
}

/// Runs that are crosses and no points.
pub(crate) fn failed(study: &Study) -> Table {
    let rows = failures(study).into_iter().map(|group| {
        let title = group.method.claims().title.to_owned();
        vec![title, group.precision.name().to_owned(), group.substeps().join(", "), group.why()]
    });
    Table::words("Runs that failed", ["method", "precision", "substeps", "why"], rows)
}

/// The settings that nothing beats in both position error and evaluations.
pub(crate) fn front(study: &Study) -> Table {
    let row = |cell: &Cell| {
        let setting = cell.setting;
        vec![
            format!("`{}` x {}", setting.method.name(), setting.substeps),
            number(1.0 / study.step_s(setting), 3),
            or_none(study.error(cell, SEEN), |error| length(error, 2)),
            or_none(study.cost(cell, Cost::Evaluations), |cost| number(cost, 3)),
            or_none(cell.time, |time| duration(time.ns_per_body_step, 2)),
        ]
    };
    let header = ["setting", "steps per s", "error", "evaluations per body per s", "per body per step"];
    Table::numbers("On the front", header, study.front(SEEN, Cost::Evaluations).into_iter().map(row))
}

/// Every cell that was run, by method, precision and substeps, with a star on those of the front; a failed one has its
/// reason for an error.
pub(crate) fn every_run(study: &Study) -> Table {
    let mut cells: Vec<_> = study.cells.iter().filter(|cell| cell.is_run()).collect();
    cells.sort_by_key(|cell| (cell.setting.method, cell.setting.precision, cell.setting.substeps));
    let fronts = [Cost::Evaluations, Cost::Time].map(|cost| study.front(SEEN, cost));
    let row = |cell: &Cell| {
        let setting = cell.setting;
        let on_front = fronts.iter().flatten().any(|other| other.setting == setting);
        let nanoseconds = |host| or_none(cell.time_in(host), |time| duration(time.ns_per_body_step, 2));
        vec![
            format!("{} {}", if on_front { "*" } else { " " }, setting.method.claims().title),
            setting.substeps.to_string(),
            setting.precision.name().to_owned(),
            duration(1e9 * study.step_s(setting), 3),
            study.error(cell, Accuracy::Relative).map_or_else(|| outcome(cell), |error| number(error, 2)),
            or_none(study.error(cell, SEEN), |error| length(error, 2)),
            or_none(cell.errors(), |errors| length(errors.position_rms_m, 2)),
            or_none(study.cost(cell, Cost::Evaluations), |cost| number(cost, 3)),
            nanoseconds(Host::World),
            nanoseconds(Host::Arithmetic),
            or_none(cell.time_in(setting.precision.host()), |time| number(time.real_time_factor, 2)),
        ]
    };
    let header = [
        "  method",
        "substeps",
        "precision",
        "step",
        "error, relative",
        "error",
        "rms",
        "evaluations per body per s",
        "per body per step",
        "the arithmetic alone",
        "times real time",
    ];
    Table::numbers("Every run in numbers", header, cells.into_iter().map(row))
}

/// `finished`, or why not.
pub(crate) fn outcome(cell: &Cell) -> String {
    match &cell.outcome {
        Outcome::Finished(_) => "finished".to_owned(),
        Outcome::Failed(failure) => failure.to_string(),
    }
}

/// The same second at several frame rates.
pub(crate) fn rates(study: &Study) -> Table {
    let row = |rate: &RateRow| {
        vec![
            number(rate.frame_hz, 3),
            rate.step.clone(),
            rate.damping.clone(),
            rate.push.clone(),
            rate.ticks.to_string(),
            rate.moved_m.map_or_else(|| "lost".to_owned(), |moved| length(moved, 3)),
            or_none(rate.off_m, |off| length(off, 2)),
        ]
    };
    let header = ["frames per s", "step", "damping", "push", "ticks", "moved", "off"];
    Table::numbers("The same second at several frame rates", header, study.rates.iter().map(row))
}
