//! Times by a clock of the test's own: what ticks cost is known, and what a study says of them follows.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use lab::cost::{
    Bench, Cost, Counts, Failure, Host, Machine as Computer, Make, Plan, Runner, Sample, Setting,
    Study, Subject, make, problem,
};
use motion::Method;
use motion::Method::{
    ExplicitEuler, ImplicitEuler, RungeKutta4, SemiImplicitEuler, VelocityVerlet,
};

/// A machine on which ticks cost what a formula says, and up to a twentieth more in each round.
#[derive(Default)]
struct Machine {
    /// Picoseconds.
    now: AtomicU64,
    random: AtomicU64,
}

impl Machine {
    /// A number in [0, 1) that looks random, by the generator of Lehmer (1951), multiplier 48271.
    fn disturbance(&self) -> f64 {
        let next = |state| Some(state * 48_271 % 0x7fff_ffff);
        let state = self.random.fetch_update(Ordering::Relaxed, Ordering::Relaxed, next).unwrap();
        state as f64 / 2_147_483_647.0
    }
}

/// Fixed cost of a tick, and cost per body per step, ns: Verlet is faster up to 67 bodies, and the Eulers tie.
fn costs(method: Method) -> (f64, f64) {
    match method {
        SemiImplicitEuler => (500.0, 5.0),
        ExplicitEuler => (502.0, 5.02),
        VelocityVerlet => (300.0, 8.0),
        RungeKutta4 => (600.0, 20.0),
        _ => (900.0, 40.0),
    }
}

/// A run that takes as long as it is told to.
struct Priced {
    machine: Arc<Machine>,
    picoseconds: f64,
    /// Of one body, and its ticks to come: simulated where its errors are measured.
    run: Option<Box<dyn Runner>>,
    ticks: u64,
}

impl Priced {
    fn run(&mut self) -> Option<&mut Box<dyn Runner>> {
        let run = self.run.as_mut()?;
        (0..std::mem::take(&mut self.ticks)).for_each(|_| run.tick());
        Some(run)
    }
}

impl Runner for Priced {
    fn tick(&mut self) {
        self.machine.now.fetch_add(self.picoseconds as u64, Ordering::Relaxed);
        self.ticks += 1;
    }
    fn states(&mut self) -> Vec<Sample> {
        self.run().map_or_else(Vec::new, |run| run.states())
    }
    fn counts(&mut self) -> Counts {
        self.run().map_or_else(Counts::default, |run| run.counts())
    }
    fn failure(&mut self) -> Option<Failure> {
        self.run().and_then(|run| run.failure())
    }
}

const METHODS: [Method; 5] =
    [ExplicitEuler, SemiImplicitEuler, ImplicitEuler, VelocityVerlet, RungeKutta4];

/// A study of Kepler's problem on such a machine, disturbed by numbers from `seed` on.
fn study(seed: u64, plan: Plan) -> Study {
    let machine = Arc::new(Machine { random: AtomicU64::new(seed), ..Machine::default() });
    let now = Arc::clone(&machine);
    let clock = move || now.now.load(Ordering::Relaxed) as f64 * 1e-12;
    let make: Box<Make> = Box::new(move |subject: &Subject, setting: Setting, host: Host| {
        let bodies = subject.scene().bodies.len();
        let run = (bodies == 1).then(|| make(subject, setting, host)).transpose()?;
        let (fixed, each) = costs(setting.method);
        let ns = fixed + each * bodies as f64;
        let picoseconds = 1e3 * ns * (1.0 + 0.05 * machine.disturbance());
        Ok(Box::new(Priced { machine: Arc::clone(&machine), picoseconds, run, ticks: 0 })
            as Box<dyn Runner>)
    });
    let subject = Subject::of_problem(problem("kepler").unwrap()).unwrap();
    super::finished(Bench::with(subject, plan, make, Box::new(clock))).study().clone()
}

fn plan() -> Plan {
    Plan { passes: Plan::full().passes, timed: 0.002, ..super::plain(&METHODS, [64, 128]) }
}

#[test]
fn a_tick_has_a_fixed_cost_and_one_per_body_and_step() {
    // Implicit steps converge on these rungs.
    let study = study(1, Plan { rungs: vec![2048, 4096, 8192], ..plan() });
    assert_eq!((study.size(), study.sizes()), (1000, vec![1, 10, 100, 1000, 10_000, 100_000]));
    assert_eq!(study.world_times().count(), METHODS.len());
    for of in study.world_times() {
        let (fixed, each) = costs(of.method);
        assert!((of.fixed_ns / fixed - 1.0).abs() < 0.06, "{of:?}");
        assert!((of.ns_per_body_step / each - 1.0).abs() < 0.06, "{of:?}");
    }
    for cell in &study.cells {
        let (fixed, each) = costs(cell.setting.method);
        let Some(time) = cell.time.filter(|_| cell.setting.method != ImplicitEuler) else {
            continue;
        };
        let expected = fixed / 1000.0 + each;
        assert!(
            (time.ns_per_body_step / expected - 1.0).abs() < 0.06,
            "{}: {time:?}",
            cell.setting
        );
        let busy = 1e-9 * 1000.0 * time.ns_per_body_step / study.step_s(cell.setting);
        assert!((busy * time.real_time_factor - 1.0).abs() < 1e-9, "{}: {time:?}", cell.setting);
    }
    // The iterations of a solver depend on the step, and with them its time.
    let implicit: Vec<_> = study
        .curve(ImplicitEuler)
        .filter_map(|cell| {
            let counts = (cell.counts.accelerations + cell.counts.solver) as f64;
            Some(cell.time?.ns_per_body_step / counts * f64::from(cell.setting.substeps.least()))
        })
        .collect();
    assert!(
        implicit.len() > 1 && implicit.iter().all(|of| (of / implicit[0] - 1.0).abs() < 1e-9),
        "{implicit:?}"
    );
}

#[test]
fn runs_on_one_machine_rank_alike_at_every_size_and_call_a_tie_a_tie() {
    for seed in 1..=12 {
        let study = study(seed * 7919, plan());
        let ranking = |study: &Study| {
            let places = study.ranking(Host::World);
            let of = |method| places.iter().position(|place| place.method == method).unwrap();
            // The tied ones in the order of the table.
            let tied = of(ExplicitEuler).abs_diff(of(SemiImplicitEuler)) == 1;
            assert!(
                tied && places[of(ExplicitEuler).max(of(SemiImplicitEuler))].tied,
                "{seed}: {places:?}"
            );
            assert_eq!(places.iter().filter(|place| place.tied).count(), 1, "{seed}: {places:?}");
            [of(VelocityVerlet), of(RungeKutta4), of(ImplicitEuler)]
        };
        assert_eq!(ranking(&study), [2, 3, 4], "{seed}");
        assert_eq!(ranking(&study.at_size(10)), [0, 3, 4], "{seed}");
        let crossings = study.crossings();
        assert_eq!(crossings.len(), 2, "{seed}: {crossings:?}");
        for crossing in crossings {
            // Lines cross where the differences of both costs balance.
            let ((f, c), (g, d)) = (costs(crossing.above), costs(crossing.below));
            let at = (f - g) / (d - c);
            assert!((crossing.body_steps / at - 1.0).abs() < 0.2, "{seed}: {crossing:?}, not {at}");
        }
    }
}

#[test]
fn what_is_cheapest_by_time_is_told_at_the_size_that_was_named() {
    let at = |bodies| study(1, Plan { bodies, ..plan() });
    let (few, many) = (at(10), at(100_000));
    let price = |study: &Study, method| {
        study.cost(study.curve(method).next().unwrap(), Cost::Time).unwrap()
    };
    for (study, euler_is_faster) in [(&few, false), (&many, true)] {
        assert_eq!(price(study, SemiImplicitEuler) < price(study, VelocityVerlet), euler_is_faster);
    }
    // Four evaluations at a price of four.
    let ratio = price(&many, RungeKutta4) / price(&many, SemiImplicitEuler);
    assert!((ratio / 4.0 - 1.0).abs() < 0.06, "{ratio}");
    let words = report::words(&many).join(" ");
    assert!(words.contains("Cheapest by time with 100,000 bodies"), "{words}");
    assert!(words.contains("semi-implicit Euler is faster than velocity Verlet from "), "{words}");
    let table = report::brief(&many, &Computer::here());
    for row in
        ["| 1 = | explicit Euler |", "| 1 = | semi-implicit Euler |", "| 4 | Runge-Kutta 4 |"]
    {
        assert!(table.contains(row), "{row} is not in {table}");
    }
}

#[test]
fn sizes_that_would_take_too_long_are_left_out_but_never_the_one_that_was_named() {
    let study = study(1, Plan { bodies: 10_000, patience: 0.2, ..plan() });
    assert_eq!(study.sizes(), [1, 10, 100, 1000, 10_000]);
    assert!(study.notes.iter().any(|note| note.contains("100000 bodies")), "{:?}", study.notes);
    assert!(
        study.cells.iter().filter(|cell| cell.errors().is_some()).all(|cell| cell.time.is_some())
    );
}
