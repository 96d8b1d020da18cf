//! Studies whose answers are known: methods on the oscillator and in free fall, reckoned here step by step.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use lab::cost::{
    BLOWN_UP, Cell, Counts, Drift, EnergyScale, Errors, FORMAT, Failure, Machine, Outcome, RateRow,
    Report, Setting, Study, Time, Truth,
};
use motion::Method;

/// Eight ticks in 10 s.
const STEP_HZ: f64 = 0.8;
const SIMULATED_S: f64 = 10.0;
/// Steps a tick: factors of two, and between them.
const RUNGS: [u32; 19] =
    [10, 12, 14, 16, 20, 28, 40, 48, 56, 80, 112, 160, 224, 320, 448, 640, 1280, 2560, 5120];

/// One step of h seconds of `x'' = a(x)`, from position and velocity.
fn step(method: Method, a: &dyn Fn(f64) -> f64, w2: f64, (x, v): (f64, f64), h: f64) -> (f64, f64) {
    let verlet = |(x, v): (f64, f64), h: f64| {
        let half = v + 0.5 * h * a(x);
        let x = x + h * half;
        (x, half + 0.5 * h * a(x))
    };
    match method {
        Method::ExplicitEuler => (x + h * v, v + h * a(x)),
        Method::SemiImplicitEuler => {
            let v = v + h * a(x);
            (x + h * v, v)
        }
        Method::ImplicitEuler => {
            let v = (v + h * a(x)) / (1.0 + h * h * w2);
            (x + h * v, v)
        }
        Method::PositionVerlet | Method::VelocityVerlet => verlet((x, v), h),
        Method::RungeKutta2Midpoint => {
            let middle = (x + 0.5 * h * v, v + 0.5 * h * a(x));
            (x + h * middle.1, v + h * a(middle.0))
        }
        Method::RungeKutta2Heun => {
            let end = (x + h * v, v + h * a(x));
            (x + 0.5 * h * (v + end.1), v + 0.5 * h * (a(x) + a(end.0)))
        }
        Method::RungeKutta4 => {
            let at = |part: f64, (dx, dv): (f64, f64)| (v + part * h * dv, a(x + part * h * dx));
            let k1 = (v, a(x));
            let k2 = at(0.5, k1);
            let k3 = at(0.5, k2);
            let k4 = at(1.0, k3);
            let sum = |of: fn((f64, f64)) -> f64| of(k1) + 2.0 * of(k2) + 2.0 * of(k3) + of(k4);
            (x + h / 6.0 * sum(|k| k.0), v + h / 6.0 * sum(|k| k.1))
        }
        Method::Yoshida4 => {
            let w = 1.0 / (2.0 - 2f64.cbrt());
            let state = verlet((x, v), w * h);
            verlet(verlet(state, (1.0 - 2.0 * w) * h), w * h)
        }
    }
}

/// A motion of one body along a line, from (x, v) at the start.
struct Motion {
    start: (f64, f64),
    w2: f64,
    pull: f64,
    truth: fn(f64) -> (f64, f64),
}

const OSCILLATOR: Motion = Motion {
    start: (1.0, 0.0),
    w2: TAU * TAU,
    pull: 0.0,
    truth: |t| ((TAU * t).cos(), -TAU * (TAU * t).sin()),
};

const FALL: Motion =
    Motion { start: (0.0, 0.0), w2: 0.0, pull: 9.8, truth: |t| (-4.9 * t * t, -9.8 * t) };

impl Motion {
    /// The states after each of `steps` steps.
    fn run(&self, method: Method, h: f64, steps: u64) -> impl Iterator<Item = (f64, f64)> {
        let a = |x: f64| -self.w2 * x - self.pull;
        let mut state = self.start;
        (0..steps).map(move |_| {
            state = step(method, &a, self.w2, state, h);
            state
        })
    }

    /// Largest distances from the truth after any step, and the root of their mean square.
    fn errors(&self, method: Method, substeps: u32, (x_scale, v_scale): (f64, f64)) -> Errors {
        let h = 1.0 / (STEP_HZ * f64::from(substeps));
        let steps = (SIMULATED_S * STEP_HZ) as u64 * u64::from(substeps);
        let (mut largest, mut squares) = (Errors::default(), 0.0);
        for (i, (x, v)) in (1..).zip(self.run(method, h, steps)) {
            let truth = (self.truth)(i as f64 * h);
            let (dx, dv) = ((x - truth.0).abs(), (v - truth.1).abs());
            largest.relative = largest.relative.max((dx / x_scale).hypot(dv / v_scale));
            largest.position_m = largest.position_m.max(dx);
            largest.velocity_m_s = largest.velocity_m_s.max(dv);
            squares += dx * dx;
        }
        Errors { position_rms_m: (squares / steps as f64).sqrt(), ..largest }
    }
}

fn time(method: Method, substeps: u32) -> Time {
    let ns = 2.0 + 1.1 * f64::from(method.claims().evaluations);
    let of_a_second = ns * STEP_HZ * f64::from(substeps);
    Time {
        ns_per_body_step: ns,
        real_time_factor: 1e9 / of_a_second,
        yardsticks: ns / 2.5,
        quartiles: [1.01, 1.02, 1.05],
    }
}

fn cell(motion: &Motion, setting: Setting, scales: (f64, f64)) -> Cell {
    let (method, substeps) = (setting.method, setting.substeps.least());
    let steps = SIMULATED_S * STEP_HZ * f64::from(substeps);
    let errors = motion.errors(method, substeps, scales);
    let blown_up = errors.relative.is_nan() || errors.relative >= BLOWN_UP;
    Cell {
        setting,
        outcome: if blown_up {
            Outcome::Failed(Failure::BlewUp)
        } else {
            Outcome::Finished(errors)
        },
        counts: Counts {
            accelerations: steps as u64 * u64::from(method.claims().evaluations),
            solver: 0,
        },
        time: Some(time(method, substeps)),
        arithmetic_time: None,
    }
}

fn cells(motion: &Motion, scales: (f64, f64)) -> Vec<Cell> {
    let rungs = |method| {
        RUNGS.into_iter().map(move |substeps| {
            cell(motion, Setting { method, substeps: substeps.into() }, scales)
        })
    };
    Method::ALL.into_iter().flat_map(rungs).collect()
}

/// The ledger of the oscillator's energy at a hundred times of a run.
fn drift(method: Method, long: bool) -> Drift {
    let (substeps, simulated_s) =
        (480 / method.claims().evaluations, if long { 400.0 } else { 10.0 });
    let h = 1.0 / (STEP_HZ * f64::from(substeps));
    let steps = (simulated_s / h).round() as u64;
    let energy = |(x, v): (f64, f64)| 0.5 * (v * v + OSCILLATOR.w2 * x * x);
    let start = energy(OSCILLATOR.start);
    let residuals: Vec<_> = (1..)
        .zip(OSCILLATOR.run(method, h, steps))
        .map(|(i, state)| (i as f64 * h, energy(state) / start - 1.0))
        .take_while(|(_, residual)| residual.abs() < 1e6)
        .collect();
    let every = (residuals.len() / 100).max(1);
    let failed = (residuals.len() as u64) < steps;
    let largest = residuals.iter().map(|(_, residual)| residual.abs()).fold(0.0, f64::max);
    Drift {
        setting: Setting { method, substeps: substeps.into() },
        long,
        simulated_s,
        scale: EnergyScale::Start,
        start: 1.0,
        largest: (!failed).then_some(largest),
        series: residuals.chunks(every).enumerate().map(jittered).collect(),
    }
}

/// One of a piece of the run, never at the same place: even samples keep step with the oscillation.
fn jittered((i, piece): (usize, &[(f64, f64)])) -> (f64, f64) {
    piece[(i * 7919) % piece.len()]
}

fn study(subject: &str, description: &str, scales: (f64, f64), cells: Vec<Cell>) -> Study {
    Study {
        subject: subject.to_owned(),
        description: description.to_owned(),
        step_hz: STEP_HZ,
        ticks: (SIMULATED_S * STEP_HZ) as u64,
        simulated_s: SIMULATED_S,
        bodies: 1,
        period_s: None,
        own: Setting { method: Method::SemiImplicitEuler, substeps: 80.into() },
        truth: Truth::ClosedForm { source: "x = cos 2 pi t".to_owned() },
        position_scale_m: scales.0,
        velocity_scale_m_s: scales.1,
        cells,
        timed_bodies: None,
        tick_times: Vec::new(),
        drifts: Vec::new(),
        rates: Vec::new(),
        notes: Vec::new(),
    }
}

/// A mass on a spring with a period of 1 s.
pub fn oscillator() -> Study {
    static MADE: LazyLock<Study> = LazyLock::new(make_oscillator);
    MADE.clone()
}

fn make_oscillator() -> Study {
    let scales = (1.0, TAU);
    let cells = cells(&OSCILLATOR, scales);
    let rate = |frame_hz, step: &str| RateRow {
        frame_hz,
        step: step.to_owned(),
        damping: "tutorial".to_owned(),
        push: "force".to_owned(),
        ticks: frame_hz as u64,
        moved_m: Some(0.8 + 1.0 / frame_hz),
        off_m: Some(1.0 / frame_hz),
    };
    Study {
        period_s: Some(1.0),
        drifts: [false, true]
            .into_iter()
            .flat_map(|long| Method::ALL.into_iter().map(move |method| drift(method, long)))
            .collect(),
        rates: vec![rate(30.0, "frame"), rate(60.0, "fixed")],
        ..study("oscillator", "A mass on a spring", scales, cells)
    }
}

/// Free fall for 10 s.
pub fn fall() -> Study {
    let scales = (490.0, 98.0);
    Study {
        truth: Truth::ClosedForm { source: "x = -g t^2 / 2".to_owned() },
        ..study("fall", "A body in free fall", scales, cells(&FALL, scales))
    }
}

/// Nothing moves.
pub fn rest() -> Study {
    let mut rest = oscillator();
    rest.subject = "rest".to_owned();
    (rest.position_scale_m, rest.velocity_scale_m_s) = (0.0, 0.0);
    for cell in &mut rest.cells {
        cell.outcome = Outcome::Finished(Errors::default());
    }
    for drift in &mut rest.drifts {
        drift.largest = Some(0.0);
        drift.series.iter_mut().for_each(|(_, residual)| *residual = 0.0);
    }
    rest
}

pub fn report(studies: Vec<Study>) -> Report {
    let word = |text: &str| text.to_owned();
    Report {
        format: FORMAT,
        command: word("sandbox cost oscillator --out report"),
        machine: Machine {
            processor: word("A <processor> & more"),
            cores: 2,
            caches: vec![32 << 10, 512 << 10],
            system: word("Linux, x86_64"),
            instructions: word("AVX2"),
            version: word("0.1.0"),
            compiler: word("rustc 1.95.0, release"),
        },
        complete: true,
        studies,
    }
}
