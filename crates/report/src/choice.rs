//! Which method leads for which error, and which setting is the cheapest for one.

use lab::cost::{Accuracy, Cell, Cost, Precision, Study};
use motion::Method;

use super::reading::{SEEN, methods, usable};

/// Counts and errors that differ by less than this part are equal: the single evaluation with which some methods start
/// is not what one chooses by.
const EVEN: f64 = 0.03;

/// Part by which the costs of two methods may differ and are equal: of times, the spread of their rounds.
fn tie(study: &Study, cost: Cost, methods: [Method; 2]) -> f64 {
    match cost {
        Cost::Evaluations | Cost::Instructions => EVEN,
        Cost::Time | Cost::RealTime => {
            methods.map(|method| study.spread(method)).into_iter().fold(0.0, f64::max)
        }
    }
}

/// Errors for which leaders are looked up, a decade.
const LEVELS: i32 = 64;

/// A lead that is shorter than this many fold in error is noise between rungs.
const SHORT: f64 = 1.5;

/// A method that is the cheapest for errors down to some size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lead {
    /// The method.
    pub method: Method,
    /// The least error, m, for which it leads.
    pub down_to_m: f64,
}

/// An error, or the noise floor where it is below that, m.
fn resolved(study: &Study, cell: &Cell) -> Option<f64> {
    Some(study.error(cell, SEEN)?.max(study.trusted(cell, SEEN)))
}

/// Cells of double precision with their costs and errors.
fn priced(study: &Study, cost: Cost) -> impl Iterator<Item = (&Cell, f64, f64)> {
    study.in_double().filter_map(move |cell| Some((cell, study.cost(cell, cost)?, resolved(study, cell)?)))
}

/// The largest error that is of use and the least that was reached, m; `None` if none is of use.
fn errors_of_use(study: &Study, cost: Cost) -> Option<(f64, f64)> {
    let errors = || priced(study, cost).filter(|(cell, ..)| usable(study, cell)).map(|(.., error)| error);
    let (largest, least) = (errors().fold(0.0, f64::max), errors().fold(f64::INFINITY, f64::min));
    (largest > 0.0).then_some((largest, least))
}

/// The cost at which a method first keeps an error, between rungs by straight lines in logarithms.
fn price(study: &Study, method: Method, cost: Cost, error: f64) -> Option<f64> {
    let points: Vec<_> = priced(study, cost).filter(|(cell, ..)| cell.setting.method == method).collect();
    let first = points.iter().position(|(cell, _, reached)| usable(study, cell) && *reached <= error)?;
    let (_, fine_cost, fine) = points[first];
    let Some((_, coarse_cost, coarse)) = first.checked_sub(1).map(|before| points[before]) else {
        return Some(fine_cost);
    };
    let part = if coarse > error { (coarse / error).ln() / (coarse / fine).ln() } else { 1.0 };
    Some(coarse_cost * (fine_cost / coarse_cost).powf(part))
}

/// The leader for one error: of methods with equal prices the one whose velocities are the better ones.
fn leader(study: &Study, cost: Cost, error: f64) -> Option<Method> {
    let prices: Vec<_> = methods(study, Precision::F64)
        .into_iter()
        .filter_map(|method| Some((method, price(study, method, cost, error)?)))
        .collect();
    let (first, least) = *prices.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let ties = |(method, price): &(Method, f64)| *price <= least * (1.0 + tie(study, cost, [first, *method]));
    let tied = prices.into_iter().filter(ties).map(|(method, _)| method);
    tied.min_by_key(|method| std::cmp::Reverse(method.claims().velocity_order))
}

/// The methods that lead, from the largest useful error to the smallest that was reached.
pub(crate) fn leads(study: &Study, cost: Cost) -> Vec<Lead> {
    let Some((largest, least)) = errors_of_use(study, cost) else { return Vec::new() };
    let levels = ((largest / least).log10() * f64::from(LEVELS)).ceil() as i32;
    let mut leads: Vec<Lead> = Vec::new();
    for level in 0..=levels {
        let error = (largest * 10f64.powf(-f64::from(level) / f64::from(LEVELS))).max(least);
        let Some(method) = leader(study, cost, error) else { continue };
        match leads.last_mut() {
            Some(lead) if lead.method == method => lead.down_to_m = error,
            _ => leads.push(Lead { method, down_to_m: error }),
        }
    }
    without_short(leads, largest)
}

/// Short leads go to whoever leads before them, or after the first.
fn without_short(leads: Vec<Lead>, largest: f64) -> Vec<Lead> {
    let mut kept: Vec<Lead> = Vec::new();
    let mut from = largest;
    let last = leads.len().saturating_sub(1);
    for (i, lead) in leads.into_iter().enumerate() {
        let long = from > SHORT * lead.down_to_m;
        from = lead.down_to_m;
        match kept.last_mut() {
            Some(before) if before.method == lead.method || !long => before.down_to_m = lead.down_to_m,
            None if !long && i < last => {}
            _ => kept.push(lead),
        }
    }
    kept
}

/// The answer to "which setting, for an error below this".
pub(crate) struct Answer<'a> {
    /// The bound, m.
    pub below_m: f64,
    /// Cheapest by evaluations.
    pub by_evaluations: &'a Cell,
    /// Cheapest by thread CPU time, where it was measured; if it ties with the cheapest by evaluations, that one.
    pub by_time: Option<&'a Cell>,
    /// The method that becomes cheaper by evaluations, and the error, m, below which it does.
    pub next: Option<(Method, f64)>,
}

/// The cheapest setting that keeps an error; of equal ones that with the best velocities.
fn cheapest(study: &Study, cost: Cost, below_m: f64) -> Option<&Cell> {
    let keeps = || {
        let kept = study
            .in_double()
            .filter(move |cell| study.error(cell, SEEN).is_some_and(|error| error <= below_m));
        kept.filter_map(move |cell| Some((cell, study.cost(cell, cost)?)))
    };
    let method = |cell: &Cell| cell.setting.method;
    let (first, least) = keeps().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let tied = keeps()
        .filter(|(cell, price)| *price <= least * (1.0 + tie(study, cost, [method(first), method(cell)])))
        .map(|(cell, _)| cell);
    let relative = |cell: &Cell| {
        let errors = cell.errors().map_or(f64::INFINITY, |errors| errors.relative);
        errors.max(study.trusted(cell, Accuracy::Relative))
    };
    let better = |cell: &Cell| std::cmp::Reverse(cell.setting.method.claims().velocity_order);
    tied.min_by(|a, b| relative(a).total_cmp(&relative(b)).then(better(a).cmp(&better(b))))
}

/// Answers for powers of ten within what was measured, the loosest first, six bounds at most. Of bounds with one answer
/// there is the tightest, which says the others.
pub(crate) fn answers(study: &Study) -> Vec<Answer<'_>> {
    let Some((loosest, least)) = errors_of_use(study, Cost::Evaluations) else { return Vec::new() };
    let leads = leads(study, Cost::Evaluations);
    let start = loosest.log10().ceil() as i32;
    let mut answers: Vec<Answer<'_>> = Vec::new();
    // Not by powi: 10^-3 is to be the number that is written 0.001.
    let bounds = (0..6).filter_map(|down| format!("1e{}", start - down).parse::<f64>().ok());
    for below_m in bounds.filter(|below_m| *below_m >= least) {
        let Some(by_evaluations) = cheapest(study, Cost::Evaluations, below_m) else { continue };
        if answers.last().is_some_and(|last| last.by_evaluations.setting == by_evaluations.setting) {
            answers.pop();
        }
        let by_time = cheapest(study, Cost::Time, below_m).map(|quick| {
            let tie = tie(study, Cost::Time, [quick, by_evaluations].map(|cell| cell.setting.method));
            let price = |cell| study.cost(cell, Cost::Time).unwrap_or(f64::INFINITY);
            if price(quick) * (1.0 + tie) < price(by_evaluations) { quick } else { by_evaluations }
        });
        let next = next(&leads, by_evaluations.setting.method, below_m);
        answers.push(Answer { below_m, by_evaluations, by_time, next });
    }
    answers
}

/// The method that takes the lead below an error.
fn next(leads: &[Lead], method: Method, below_m: f64) -> Option<(Method, f64)> {
    leads
        .windows(2)
        .map(|pair| (pair[1].method, pair[0].down_to_m))
        .find(|(next, from_m)| *next != method && *from_m < below_m)
}

/// Methods whose every setting another one beats clearly in error or cost, and does not lose to in the other.
pub(crate) fn never_best(study: &Study, cost: Cost) -> Vec<Method> {
    let beats = |(cell, price, error): &(&Cell, f64, f64),
                 (other, other_price, other_error): &(&Cell, f64, f64)| {
        let more = 1.0 + tie(study, cost, [cell.setting.method, other.setting.method]);
        (price * more < *other_price && *error <= other_error * (1.0 + EVEN))
            || (error * (1.0 + EVEN) < *other_error && *price <= other_price * more)
    };
    let all: Vec<_> = priced(study, cost).collect();
    let stands =
        |point: &(&Cell, f64, f64)| usable(study, point.0) && !all.iter().any(|other| beats(other, point));
    methods(study, Precision::F64)
        .into_iter()
        .filter(|method| {
            let mut own = all.iter().filter(|point| point.0.setting.method == *method).peekable();
            own.peek().is_some() && !own.any(stands)
        })
        .collect()
}
