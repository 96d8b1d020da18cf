//! Instructions of a tick, counted by callgrind on this very program: exact where times are not.

use std::process::Command;

use lab::cost::{Host, Precision, Setting, Study, Subject, make};
use motion::Method;

use crate::failure::Failure;

/// Ticks of the shorter of two runs, whose start cancels out.
const TICKS: u64 = 4;

/// What is looked for, and the package that has it.
const TOOL: &str = "valgrind";

/// Whether there is a counter.
///
/// # Errors
/// There is none: the package that has it.
pub(crate) fn check() -> Result<(), Failure> {
    match Command::new(TOOL).arg("--version").output() {
        Ok(output) if output.status.success() => Ok(()),
        _ => Err(Failure::Usage(format!("--instructions needs {TOOL}; install the package {TOOL}"))),
    }
}

/// Counts the instructions of a tick of every setting of f64 that went through; what `earlier` has is taken from
/// there. `name` is what the subject is called on the command line.
///
/// # Errors
/// A counter that fails.
pub(crate) fn count(study: &mut Study, name: &str, earlier: Option<&Study>) -> Result<(), Failure> {
    for cell in &mut study.cells {
        let known = earlier.and_then(|study| study.cells.iter().find(|other| other.setting == cell.setting));
        cell.instructions_per_tick = known.and_then(|known| known.instructions_per_tick);
        let counts = cell.setting.precision == Precision::F64 && cell.errors().is_some();
        if counts && cell.instructions_per_tick.is_none() {
            let of = |ticks| collected(name, cell.setting, ticks);
            #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
            let a_tick = of(2 * TICKS)?.saturating_sub(of(TICKS)?) as f64 / TICKS as f64;
            cell.instructions_per_tick = Some(a_tick);
        }
    }
    Ok(())
}

fn collected(subject: &str, setting: Setting, ticks: u64) -> Result<u64, Failure> {
    let failed = |what: &str| Failure::Usage(format!("{TOOL} did not count {setting} of {subject}: {what}"));
    let program = std::env::current_exe().map_err(|error| failed(&error.to_string()))?;
    let output = Command::new(TOOL)
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(["cost", subject, "--ticks-of"])
        .arg(format!("{}:{}:{ticks}", setting.method.name(), setting.substeps))
        .output()
        .map_err(|error| failed(&error.to_string()))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let count = text.lines().find_map(|line| line.split_once("Collected : ")?.1.trim().parse().ok());
    count.ok_or_else(|| failed(text.lines().last().unwrap_or("it said nothing")))
}

/// What is counted: so many ticks of a setting and nothing else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TicksOf {
    setting: Setting,
    ticks: u64,
}

impl TicksOf {
    /// From `method:substeps:ticks`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = text.split(':');
        let mut next = || parts.next().unwrap_or_default();
        let method = Method::from_name(next());
        let (substeps, ticks) = (next().parse().ok(), next().parse().ok());
        match (method, substeps, ticks) {
            (Some(method), Some(substeps), Some(ticks)) if substeps > 0 => {
                Ok(Self { setting: Setting { method, substeps, precision: Precision::F64 }, ticks })
            }
            _ => Err("give method:substeps:ticks".to_owned()),
        }
    }

    /// Runs them.
    pub fn run(self, subject: &Subject) -> Result<(), Failure> {
        let run = make(subject, self.setting, Host::World);
        let mut run = run.map_err(|failure| Failure::Usage(failure.to_string()))?;
        (0..self.ticks).for_each(|_| run.tick());
        Ok(())
    }
}
