//! The measuring itself: what is slow shows as slow by as much, and what is broken as broken.

use lab::cost::{
    Accuracy, Bench, Cost, Counts, Failure, Host, Make, Outcome, Plan, Runner, Sample, Setting,
    Study, Subject, make, problem,
};
use motion::Method;

use super::{finished, plain, studied};
use crate::effects::allocations::most_held;

/// Runs something else under the name of a method.
struct Instead {
    run: Box<dyn Runner>,
    broken: bool,
}

impl Runner for Instead {
    fn tick(&mut self) {
        self.run.tick();
    }

    fn states(&mut self) -> Vec<Sample> {
        let mut states = self.run.states();
        if self.broken {
            states.iter_mut().for_each(|(_, x, _)| x.x = f64::NAN);
        }
        states
    }

    fn counts(&mut self) -> Counts {
        self.run.counts()
    }

    fn failure(&mut self) -> Option<Failure> {
        self.run.failure()
    }
}

/// The runs of the program; RK4 by `fourth`, with states that are not finite for `broken`.
fn instead(fourth: Method, broken: Option<Method>) -> Box<Make> {
    Box::new(move |subject: &Subject, setting: Setting, host: Host| {
        let method = if setting.method == Method::RungeKutta4 { fourth } else { setting.method };
        let run = make(subject, Setting { method, ..setting }, host)?;
        Ok(Box::new(Instead { run, broken: broken == Some(setting.method) }) as Box<dyn Runner>)
    })
}

fn study(subject: Subject, plan: Plan, make: Box<Make>) -> Study {
    finished(Bench::with(subject, plan, make, Box::new(|| 0.0))).study().clone()
}

#[test]
fn a_method_of_another_order_than_its_name_shows_as_that() {
    let subject = Subject::of_problem(problem("duffing").unwrap()).unwrap();
    let plan = plain(&[Method::VelocityVerlet, Method::RungeKutta4], [64, 128, 256, 512]);
    let study = study(subject, plan, instead(Method::SemiImplicitEuler, None));
    let order = |method| study.order(method, Accuracy::Position).unwrap();
    assert!((order(Method::RungeKutta4) - 1.0).abs() < 0.1, "{}", order(Method::RungeKutta4));
    assert!((order(Method::VelocityVerlet) - 2.0).abs() < 0.05);
    let text = report::text(&study);
    assert!(text.contains(", claimed 4"), "{text}");
}

#[test]
fn phase_and_amplitude_of_an_oscillator_are_those_of_the_theory() {
    let subject = Subject::of_problem(problem("harmonic_oscillator").unwrap()).unwrap();
    let rung = 256;
    let bench = studied(subject, plain(&[Method::ExplicitEuler, Method::VelocityVerlet], [rung]));
    let study = bench.study();
    let phase = |method| study.curve(method).next().unwrap().errors().unwrap().phase.unwrap();
    let (steps, w_h) =
        (8.0 * f64::from(rung), 5.0 * std::f64::consts::TAU / (8.0 * f64::from(rung)));
    // A step of explicit Euler turns by atan(w h) and stretches by sqrt(1 + (w h)²).
    let euler = phase(Method::ExplicitEuler);
    let late = study.simulated_s * (1.0 - w_h.atan() / w_h);
    assert!((euler.late_s / late - 1.0).abs() < 1e-4, "{euler:?}, {late} s");
    let stretched = (0.5 * steps * (w_h * w_h).ln_1p()).exp() - 1.0;
    assert!((euler.off_path / stretched - 1.0).abs() < 1e-4, "{euler:?}, {stretched}");
    // Velocity Verlet turns by 2 asin(w h / 2), on an ellipse that is flatter by (w h)² / 8.
    let verlet = phase(Method::VelocityVerlet);
    let early = study.simulated_s * ((0.5 * w_h).asin() / (0.5 * w_h) - 1.0);
    assert!((verlet.late_s / -early - 1.0).abs() < 0.02, "{verlet:?}, {early} s");
    assert!(verlet.off_path < w_h * w_h / 8.0 && verlet.off_path > 0.0, "{verlet:?}");
}

#[test]
fn a_method_whose_states_are_not_finite_is_a_mark_and_no_point() {
    let subject = Subject::of_problem(problem("harmonic_oscillator").unwrap()).unwrap();
    let plan = plain(&[Method::VelocityVerlet, Method::RungeKutta4], [16, 32]);
    let broken = instead(Method::RungeKutta4, Some(Method::VelocityVerlet));
    let study = study(subject, plan, broken);
    for cell in study.curve(Method::VelocityVerlet) {
        assert_eq!(cell.outcome, Outcome::Failed(Failure::BlewUp));
        assert!(study.error(cell, Accuracy::Relative).is_none());
        assert!(study.cost(cell, Cost::Evaluations).unwrap() > 0.0, "a mark has a place");
    }
    let front = study.front(Accuracy::Relative, Cost::Evaluations);
    assert!(
        front.iter().all(|cell| cell.setting.method == Method::RungeKutta4) && !front.is_empty()
    );
}

#[test]
fn hopeless_runs_are_marks_with_reasons() {
    // Twice the largest stable step and more: w h = 2 pi / 2.
    let subject = Subject::of_problem(problem("harmonic_oscillator").unwrap()).unwrap();
    let bench = studied(subject, plain(&Method::ALL, [4]));
    let study = bench.study();
    let failed = |method| study.curve(method).next().unwrap().errors().is_none();
    assert!(failed(Method::ExplicitEuler) && !failed(Method::ImplicitEuler));

    let scene = scene::load("figure_eight").unwrap();
    let bench = studied(Subject::of_scene(scene, Some(0.5)), plain(&[Method::ImplicitEuler], [1]));
    let cell = &bench.study().cells[0];
    let Outcome::Failed(Failure::Unsolvable { why }) = &cell.outcome else { panic!("{cell:?}") };
    assert!(why.contains("implicit"), "{why}");
}

#[test]
fn a_study_in_small_pieces_is_the_study_in_one() {
    let subject = || Subject::of_problem(problem("tetrahedron").unwrap()).unwrap();
    let plan = || plain(&Method::ALL, [8, 16]);
    let whole = studied(subject(), plan());
    let mut bench = Bench::new(subject(), plan());
    let (mut pieces, mut last) = (0, 0.0);
    while !bench.work(1e-4) {
        pieces += 1;
        let progress = bench.progress();
        assert!((last..=1.0).contains(&progress), "{last} {progress}");
        last = progress;
    }
    assert_eq!(bench.study(), whole.study());
    assert!(pieces > 3, "{pieces}");
}

#[test]
fn a_resumed_study_runs_only_what_is_missing_and_comes_out_the_same() {
    let subject = || Subject::of_problem(problem("elastic_pendulum").unwrap()).unwrap();
    let plan = || plain(&[Method::VelocityVerlet, Method::RungeKutta4], [16, 32, 64]);
    let whole = studied(subject(), plan()).study().clone();
    let mut broken_off = whole.clone();
    for cell in &mut broken_off.cells[3..] {
        cell.outcome = Outcome::Failed(Failure::NotRun);
    }
    let text = serde_json::to_string(&broken_off).unwrap();
    let read: Study = serde_json::from_str(&text).unwrap();
    assert_eq!(read, broken_off);
    let mut bench = Bench::new(subject(), plan());
    bench.resume(&read);
    assert_eq!(finished(bench).study(), &whole);

    // Nothing is left: not even a reference is run.
    let mut bench = Bench::new(subject(), plan());
    bench.resume(&whole);
    assert!(bench.is_done());
    assert_eq!(bench.study(), &whole);
}

#[test]
fn a_long_run_is_measured_in_the_memory_of_a_short_one() {
    let held = |seconds| {
        let scene = scene::load("thousand").unwrap();
        let plan = plain(&[Method::SemiImplicitEuler, Method::RungeKutta4], [1]);
        most_held(|| drop(studied(Subject::of_scene(scene, Some(seconds)), plan)))
    };
    let (short, long) = (held(0.1), held(3.0));
    assert!(long < short + short / 20, "{short} bytes, and {long}");
}
