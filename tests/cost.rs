//! What accuracy costs: the measuring measured.

mod arithmetic;
mod measuring;
pub mod oscillator;
mod panel;
pub(crate) mod references;
mod timing;

use lab::cost::{Bench, Plan, Subject};
use motion::Method;

/// What is measured of accuracy alone.
fn plain(methods: &[Method], rungs: impl Into<Vec<u32>>) -> Plan {
    Plan {
        methods: methods.to_vec(),
        rungs: rungs.into(),
        passes: 0,
        longer: 0,
        rates: false,
        ..Plan::full()
    }
}

/// The whole of a study.
#[track_caller]
fn studied(subject: Subject, plan: Plan) -> Bench {
    finished(Bench::new(subject, plan))
}

#[track_caller]
fn finished(mut bench: Bench) -> Bench {
    assert!(bench.work(f64::INFINITY), "everything is run");
    bench
}
