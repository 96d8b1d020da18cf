//! The results of a study as tables.

use lab::cost::{
    Accuracy, Cell, Cheapest, Choice, Cost, EqualCost, Host, Outcome, OverArithmetic, Phase, Place,
    RateRow, SEEN, ShownOrder, Study,
};
use motion::Method;

use super::numbers::{NONE, duration, length, number, share};
use super::palette::ink;
use super::table::Table;
use super::words::{bodies, fate, setting, title, why};

/// The tables of a summary, those that have any rows.
pub fn tables(study: &Study) -> Vec<Table> {
    let tables = [
        cheapest(study),
        of_methods(study),
        phases(study),
        equal(study),
        failed(study),
        front(study),
    ];
    tables.into_iter().filter(|table| !table.rows.is_empty()).collect()
}

fn or_none<T>(value: Option<T>, text: impl Fn(T) -> String) -> String {
    value.map_or_else(|| NONE.to_owned(), text)
}

/// The cheapest settings for each error, with "=" between those that tie. Only the smallest of several errors with
/// one answer is listed, because it implies the others.
pub(crate) fn cheapest(study: &Study) -> Table {
    let has_alone = !study.answers(Cost::Arithmetic).is_empty();
    let row = |Choice { below_m, by_evaluations, by_time, by_arithmetic }: Choice<'_>| {
        let quickest = by_time.as_ref().map(|quick| quick.cell);
        let real_time = quickest.and_then(|cell| study.cost(cell, Cost::RealTime));
        let words = |cheapest: Option<&Cheapest<'_>>| {
            or_none(cheapest, |cheapest| settings(study, cheapest))
        };
        vec![
            format!("below {}", length(below_m, 2)),
            settings(study, &by_evaluations),
            or_none(study.cost(by_evaluations.cell, Cost::Evaluations), |cost| number(cost, 3)),
            words(by_time.as_ref()),
            or_none(quickest.and_then(|cell| cell.time), |time| duration(time.ns_per_body_step, 2)),
            or_none(real_time, |part| share(part, 2)),
        ]
        .into_iter()
        .chain(has_alone.then(|| words(by_arithmetic.as_ref())))
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
    let header = header.into_iter().chain(has_alone.then_some("cheapest by the arithmetic alone"));
    let title = format!("Cheapest for an error within {} s", number(study.simulated_s, 3));
    Table::words(title, header, study.choices().into_iter().map(row))
}

/// The cheapest setting, and those that tie with it.
fn settings(study: &Study, cheapest: &Cheapest<'_>) -> String {
    cheapest.cells().map(|cell| setting(study, cell)).collect::<Vec<_>>().join(" = ")
}

/// Methods by the time of a step, the shortest first; "=" marks ties.
pub(crate) fn ranking(study: &Study) -> Table {
    let (places, alone) = (study.ranking(Host::World), study.ranking(Host::Arithmetic));
    let (base, base_alone, over) =
        (Place::base(&places), Place::base(&alone), study.over_arithmetic());
    let row = |(i, place): (usize, &Place)| {
        let Place { method, ns_per_body_step, tied, rank, .. } = *place;
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
            let own = alone
                .iter()
                .find(|place| place.method == method)
                .map(|place| place.ns_per_body_step);
            let over = over.iter().find(|over| over.method == method);
            [
                or_none(own, |own| duration(own, 2)),
                or_none(own, |own| number(own / base.ns_per_body_step, 2)),
                or_none(over, with_spread),
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

/// The time of a step in this program relative to the arithmetic alone, for each of `sizes`, and the time of the
/// arithmetic alone for the first one, by method and problem. Empty if no loop was timed.
pub fn prices(studies: &[Study], sizes: &[usize]) -> Vec<Table> {
    let timed: Vec<_> =
        studies.iter().filter(|study| !study.over_arithmetic().is_empty()).collect();
    if timed.is_empty() {
        return Vec::new();
    }
    let header = || std::iter::once("method").chain(timed.iter().map(|study| &*study.subject));
    let rows = |cell: &dyn Fn(&Study, Method) -> String, sizes: &[usize]| -> Vec<Vec<String>> {
        let at = |study: &Study, method| {
            let each = sizes.iter().map(|size| cell(&study.at_size(*size), method));
            each.collect::<Vec<_>>().join(", ")
        };
        let row = |method: Method| {
            let cells = timed.iter().map(|study| at(study, method));
            std::iter::once(method.claims().title.to_owned()).chain(cells).collect()
        };
        Method::ALL.into_iter().map(row).collect()
    };
    let over = |study: &Study, method| {
        or_none(study.over_arithmetic().iter().find(|over| over.method == method), with_spread)
    };
    let alone = |study: &Study, method| {
        let places = study.ranking(Host::Arithmetic);
        or_none(places.iter().find(|place| place.method == method), |place| {
            number(place.ns_per_body_step, 2)
        })
    };
    let with: Vec<_> = sizes.iter().map(|size| bodies(*size)).collect();
    let with = with.join(" and with ");
    vec![
        Table::numbers(
            format!(
                "This program over the arithmetic alone, with {with}; in brackets the spread of the passes"
            ),
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

/// A ratio of times; in brackets, how far the median of the passes lies above the least.
fn with_spread(OverArithmetic { times, spread, .. }: &OverArithmetic) -> String {
    format!("{} ({:.0} %)", number(*times, 2), 100.0 * spread)
}

/// Properties of each method: its order, whether it is ever the cheapest, and what it does to energy.
pub(crate) fn of_methods(study: &Study) -> Table {
    let ranks = study.ranks();
    let best = [("evaluations", Cost::Evaluations), ("time", Cost::Time)]
        .map(|(name, cost)| (name, study.ever_cheapest(cost)));
    let best = |method: Method| {
        let by = best
            .iter()
            .filter(|(_, best)| best.as_ref().is_some_and(|best| best.contains(&method)));
        match &by.map(|(name, _)| *name).collect::<Vec<_>>()[..] {
            _ if best.iter().all(|(_, best)| best.is_none()) => NONE.to_owned(),
            [] => "never".to_owned(),
            by => by.join(" and "),
        }
    };
    let lengths: Vec<_> = [false, true]
        .into_iter()
        .filter_map(|long| {
            Some((long, study.drifts.iter().find(|drift| drift.long == long)?.simulated_s))
        })
        .collect();
    let row = |method: Method| {
        let mut row = vec![method.claims().title.to_owned()];
        row.push(if ranks { order(study, method) } else { NONE.to_owned() });
        row.push(best(method));
        for (long, _) in &lengths {
            let drift = study
                .drifts
                .iter()
                .find(|drift| drift.long == *long && drift.setting.method == method);
            row.push(or_none(drift, |drift| {
                format!("x {:#}: {}", drift.setting.substeps, fate(drift))
            }));
        }
        row
    };
    let header = ["method", "order", "cheapest of these by"].map(str::to_owned);
    let energy =
        lengths.iter().map(|(_, s)| format!("energy invented or lost over {} s", number(*s, 3)));
    let rows = study.methods().into_iter().map(row);
    Table::words("Methods", header.into_iter().chain(energy), rows)
}

/// The order that errors show, and the order that the table of methods claims if it differs.
fn order(study: &Study, method: Method) -> String {
    if study.is_exact(method) {
        return if study.truth.own_error().1 > 0.0 { "as exact as the reference" } else { "exact" }
            .to_owned();
    }
    or_none(study.shown_order(method), |ShownOrder { shows, claimed }| match claimed {
        Some(claimed) => format!("{shows:.1}, claimed {claimed}"),
        None => format!("{shows:.1}"),
    })
}

/// Errors of phase and amplitude at the end of the run, of every method at one step: the middle one of those that
/// were run.
pub(crate) fn phases(study: &Study) -> Table {
    let row = |(cell, phase): (&Cell, Phase)| {
        let period_s = study.period_s?;
        let late = if phase.late_s < 0.0 { "early" } else { "late" };
        let off = phase.known_late_s().map(f64::abs);
        Some(vec![
            cell.setting.method.claims().title.to_owned(),
            number(1.0 / study.step_s(cell.setting), 3),
            or_none(off, |off| format!("{} {late}", duration(1e9 * off, 2))),
            or_none(off, |off| share(off / period_s, 2)),
            share(phase.off_path, 2),
        ])
    };
    let title = format!("Phase and amplitude apart, after {} s", number(study.simulated_s, 3));
    let header =
        ["method", "steps per s", "phase", "of a period", "amplitude and shape: off the path"];
    Table::numbers(title, header, study.phases().into_iter().filter_map(row))
}

/// Errors of positions at equal evaluations; a star marks the smallest of a row.
pub(crate) fn equal(study: &Study) -> Table {
    let row = |EqualCost { evaluations, errors_m, least_m }: EqualCost| {
        let star = |error: f64| if error <= least_m { " *" } else { "" };
        let cells =
            errors_m.iter().map(|error| or_none(*error, |error| length(error, 2) + star(error)));
        std::iter::once(number(evaluations, 3)).chain(cells).collect()
    };
    let methods = study.methods();
    let header = std::iter::once("evaluations per body per s")
        .chain(methods.iter().map(|method| ink(*method).short));
    let rows = study.at_equal_costs().into_iter().map(row);
    Table::numbers("Errors at equal evaluations, the least with a star", header, rows)
}

/// Failed runs, which figures show as crosses.
pub(crate) fn failed(study: &Study) -> Table {
    let rows = study.failed_runs().into_iter().map(|group| {
        let substeps: Vec<_> =
            group.runs.iter().map(|(substeps, _)| format!("x {substeps:#}")).collect();
        let title = group.method.claims().title.to_owned();
        vec![title, substeps.join(", "), why(&group)]
    });
    Table::words("Runs that failed", ["method", "substeps", "why"], rows)
}

/// The settings that nothing beats in both position error and evaluations.
pub(crate) fn front(study: &Study) -> Table {
    let row = |cell: &Cell| {
        let setting = cell.setting;
        vec![
            format!("`{}` x {:#}", setting.method.name(), setting.substeps),
            number(1.0 / study.mean_step_s(cell), 3),
            or_none(study.error(cell, SEEN), |error| length(error, 2)),
            or_none(study.cost(cell, Cost::Evaluations), |cost| number(cost, 3)),
            or_none(cell.time, |time| duration(time.ns_per_body_step, 2)),
        ]
    };
    let header =
        ["setting", "steps per s", "error", "evaluations per body per s", "per body per step"];
    Table::numbers(
        "On the front",
        header,
        study.front(SEEN, Cost::Evaluations).into_iter().map(row),
    )
}

/// Every cell that was run, by method and substeps, with a star on those of the front. For a failed one, the reason
/// is in place of the error.
pub(crate) fn every_run(study: &Study) -> Table {
    let mut cells: Vec<_> = study.cells.iter().filter(|cell| cell.is_run()).collect();
    cells.sort_by_key(|cell| (cell.setting.method, cell.setting.substeps));
    let fronts = [Cost::Evaluations, Cost::Time].map(|cost| study.front(SEEN, cost));
    let row = |cell: &Cell| {
        let setting = cell.setting;
        let on_front = fronts.iter().flatten().any(|other| other.setting == setting);
        let nanoseconds =
            |host| or_none(cell.time_in(host), |time| duration(time.ns_per_body_step, 2));
        vec![
            format!("{} {}", if on_front { "*" } else { " " }, setting.method.claims().title),
            format!("{:#}", setting.substeps),
            duration(1e9 * study.mean_step_s(cell), 3),
            study
                .error(cell, Accuracy::Relative)
                .map_or_else(|| outcome(cell), |error| number(error, 2)),
            or_none(study.error(cell, SEEN), |error| length(error, 2)),
            or_none(cell.errors(), |errors| length(errors.position_rms_m, 2)),
            or_none(study.cost(cell, Cost::Evaluations), |cost| number(cost, 3)),
            nanoseconds(Host::World),
            nanoseconds(Host::Arithmetic),
            or_none(cell.time, |time| number(time.real_time_factor, 2)),
        ]
    };
    let header = [
        "  method",
        "substeps",
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

/// One second at several frame rates.
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
