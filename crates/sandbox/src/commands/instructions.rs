//! Instructions of a tick, counted by callgrind on this very program: exact where times are not.

use std::collections::HashMap;
use std::process::Command;

use lab::cost::{Host, Precision, Setting, Study, Subject, make};
use motion::Method;

use crate::failure::Failure;

/// Ticks of the shorter of two runs, whose start cancels out.
const TICKS: u64 = 4;

/// The program that counts, and its package.
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

/// Counts the instructions of a tick of every setting of f64 that went through; what `earlier` has of as many bodies is
/// taken from there. Of a problem, a step of copies is counted once for each method. `name` is what the subject is
/// called on the command line.
///
/// # Errors
/// A counter that fails.
pub(crate) fn count(study: &mut Study, name: &str, earlier: Option<&Study>) -> Result<(), Failure> {
    let earlier = earlier.filter(|earlier| earlier.timed_bodies == study.timed_bodies);
    let steps: HashMap<_, _> = study.world_times().filter_map(|of| Some((of.method, of.substeps?))).collect();
    let mut counted = HashMap::new();
    for cell in &mut study.cells {
        let known = earlier.and_then(|study| study.cells.iter().find(|other| other.setting == cell.setting));
        cell.instructions_per_tick = known.and_then(|known| known.instructions_per_tick);
        let counts = cell.setting.precision == Precision::F64 && cell.errors().is_some();
        if !counts || cell.instructions_per_tick.is_some() {
            continue;
        }
        let setting = cell.setting;
        let (setting, copies) = match steps.get(&setting.method) {
            Some(&substeps) => (Setting { substeps, ..setting }, study.timed_bodies),
            None => (setting, None),
        };
        let of = |ticks| collected(name, setting, copies, ticks);
        let per_tick = match counted.get(&setting) {
            Some(count) => *count,
            #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
            None => of(2 * TICKS)?.saturating_sub(of(TICKS)?) as f64 / TICKS as f64,
        };
        counted.insert(setting, per_tick);
        let ticks = if copies.is_some() { f64::from(cell.setting.substeps) } else { 1.0 };
        cell.instructions_per_tick = Some(ticks * per_tick);
    }
    Ok(())
}

fn collected(subject: &str, setting: Setting, bodies: Option<usize>, ticks: u64) -> Result<u64, Failure> {
    let failed = |what: &str| Failure::Usage(format!("{TOOL} did not count {setting} of {subject}: {what}"));
    let program = std::env::current_exe().map_err(|error| failed(&error.to_string()))?;
    let output = Command::new(TOOL)
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(["cost", subject, "--ticks-of"])
        .arg(format!("{}:{}:{ticks}", setting.method.name(), setting.substeps))
        .args(bodies.map(|bodies| format!("--bodies={bodies}")))
        .output()
        .map_err(|error| failed(&error.to_string()))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let count = text.lines().find_map(|line| line.split_once("Collected : ")?.1.trim().parse().ok());
    count.ok_or_else(|| failed(text.lines().last().unwrap_or("it said nothing")))
}

/// The run that is counted: so many ticks of a setting.
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

    /// Runs them; of so many `bodies`, as copies of a problem, steps of that setting.
    pub fn run(self, subject: &Subject, bodies: Option<u32>) -> Result<(), Failure> {
        let Setting { substeps, .. } = self.setting;
        let run = match bodies {
            Some(bodies) => {
                let setting = Setting { substeps: 1, ..self.setting };
                make(&subject.of_bodies(bodies, substeps), setting, Host::World)
            }
            None => make(subject, self.setting, Host::World),
        };
        let mut run = run.map_err(|failure| Failure::Usage(failure.to_string()))?;
        (0..self.ticks).for_each(|_| run.tick());
        Ok(())
    }
}
