//! What energy does, which runs failed, and what errors are measured against.

use std::collections::BTreeMap;

use super::title;
use crate::numbers::{capital, length, list, number, share};
use crate::reading::{self, Growth, growth};
use lab::cost::{Drift, Precision, Study, Truth};

/// Methods that fare alike, in one sentence for each length of run.
pub(super) fn energy(study: &Study) -> Vec<String> {
    [false, true].into_iter().filter_map(|long| of_length(study, long)).collect()
}

fn of_length(study: &Study, long: bool) -> Option<String> {
    let drifts: Vec<_> = study.drifts.iter().filter(|drift| drift.long == long).collect();
    let simulated_s = drifts.iter().map(|drift| drift.simulated_s).fold(f64::NAN, f64::max);
    let mut fates: BTreeMap<u8, (&str, Vec<String>)> = BTreeMap::new();
    for drift in &drifts {
        let (rank, what, whom) = fate(drift);
        fates.entry(rank).or_insert((what, Vec::new())).1.push(whom);
    }
    let said: Vec<_> = fates.into_values().map(|(what, whom)| format!("{what} {}", list(&whom))).collect();
    (!said.is_empty()).then(|| {
        format!("Energy that methods invent or lose over {} s: {}.", number(simulated_s, 3), said.join("; "))
    })
}

fn fate(drift: &Drift) -> (u8, &'static str, String) {
    let whom = format!("{} x {}", title(drift.setting.method), drift.setting.substeps);
    let largest = share(drift.largest.unwrap_or(f64::NAN), 2);
    match growth(drift) {
        Some(Growth::RoundOff) => (0, "round-off with", whom),
        Some(Growth::Bounded) => (1, "within bounds with", format!("{whom} ({largest})")),
        Some(Growth::Grows(power)) => (2, "growing with", format!("{whom} (as t^{power:.1}, to {largest})")),
        Some(Growth::Lost) => (3, "most of it lost with", whom),
        Some(Growth::Invented) => (4, "most of it invented with", whom),
        None => (5, "a run that failed with", whom),
    }
}

pub(super) fn failures(study: &Study) -> Vec<String> {
    let of_group = |group: &reading::FailedRuns<'_>| {
        let who = capital(&title(group.method));
        format!("{who}{} at {}: {}.", in_precision(group.precision), list(&group.substeps()), group.why())
    };
    reading::failures(study).iter().map(of_group).collect()
}

fn in_precision(precision: Precision) -> String {
    match precision {
        Precision::F64 => String::new(),
        other => format!(" in {}", other.name()),
    }
}

pub(super) fn truth(study: &Study) -> String {
    match &study.truth {
        Truth::ClosedForm { source } => format!("Errors are measured against a closed form: {source}."),
        Truth::Reference { method, substeps, position_error_m, exact_damping, .. } => format!(
            "Errors are measured against a run of {} with {substeps} steps a tick, whose own error is {}{}.",
            title(*method),
            length(*position_error_m, 2),
            if *exact_damping {
                "; damping that multiplies once a tick stands in it as the law it stands for"
            } else {
                ""
            },
        ),
    }
}
