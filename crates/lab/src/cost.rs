//! Measures what accuracy costs: the error and the cost of every method at every step on a problem or a scene.
//!
//! A [`Plan`] says what is run of a [`Subject`]. A [`Bench`] runs it a little at a time, each run in a world or in plain
//! arrays ([`Runner`]), and writes a [`Study`]: the errors and evaluations of every [`Cell`], the times of ticks
//! ([`TickTime`]), energy over time ([`Drift`]), a second at several frame rates ([`RateRow`]). A [`Report`] is the studies
//! of one command and the [`Machine`] that they were made on.
//!
//! An error is the largest over all ticks: each run advances beside the truth, and no states are stored. Errors and
//! times come from separate runs (Rein, Liu 2012; Rackauckas, Nie 2017).

mod arithmetic;
mod bench;
mod blocks;
mod choice;
mod comparison;
mod drift;
mod exact;
mod fate;
mod front;
mod hosts;
mod machine;
mod plan;
mod problem;
mod ranking;
mod rates;
mod record;
mod runner;
mod subject;
mod timing;
mod truth;

pub(crate) use drift::invented;
pub(crate) use truth::{Deviation, Scales, larger, paired};

pub use crate::clock::{Clock, take_real_time_priority};
pub use bench::Bench;
pub use choice::{Answer, Cheapest, Choice, Lead};
pub use comparison::{Contest, EqualCost, FailedRuns, Round, SEEN, ShownOrder};
pub use fate::Fate;
pub use front::{Accuracy, Cost};
pub use hosts::{Make, make};
pub use plan::Plan;
pub use problem::{PROBLEMS, Problem, State, problem};
pub use ranking::{Crossing, OverArithmetic, Place};
pub use record::{
    BLOWN_UP, Cell, Counts, Drift, EnergyScale, Errors, FORMAT, Failure, Host, Machine, Outcome,
    Phase, RateRow, Report, Setting, Study, TickTime, Time, TimedTick, Truth,
};
pub use runner::{Runner, Sample};
pub use subject::Subject;
