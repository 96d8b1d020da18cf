//! The arithmetic alone: loops over arrays do what the program does.

use lab::cost::{Host, Plan, Sample, Setting, Subject, make, problem};
use motion::Method;

use super::{plain, studied};

/// The largest difference of a coordinate between the program and the loop, over 200 steps of three copies.
fn difference(name: &str, method: Method) -> f64 {
    // Coarser implicit steps of the orbit do not converge.
    let substeps = if method == Method::ImplicitEuler { 4096 } else { 64 };
    let subject = Subject::of_problem(problem(name).unwrap()).unwrap().of_bodies(3, substeps);
    let setting = Setting { method, substeps: 1.into() };
    let run = |host| {
        let mut run = make(&subject, setting, host).unwrap();
        (0..200).for_each(|_| run.tick());
        run.states()
    };
    let (world, alone) = (run(Host::World), run(Host::Arithmetic));
    assert!(alone.len() >= 3, "{name}");
    let of = |id: u32| world.iter().find(|state| state.0 == id).unwrap();
    let off = |(id, x, v): &Sample| {
        let (_, y, w) = of(*id);
        (x - y).abs().max_element().max((v - w).abs().max_element())
    };
    alone.iter().map(off).fold(0.0, f64::max)
}

#[test]
fn loops_over_laws_of_single_bodies_give_the_bits_of_the_program() {
    for name in ["free_fall", "terminal_fall", "quadratic_drag", "kepler", "five_wells", "duffing"]
    {
        for method in Method::ALL {
            let off = difference(name, method);
            // An implicit step is solved to the same tolerance, by another inverse.
            let allowed = if method == Method::ImplicitEuler { 1e-9 } else { 0.0 };
            assert!(off <= allowed, "{name} by {method:?}: {off}");
        }
    }
}

#[test]
fn a_loop_over_an_engine_does_what_the_program_does() {
    for method in Method::ALL {
        let off = difference("engine", method);
        // Times of evaluations are summed up otherwise.
        assert!(off <= 1e-12, "{method:?}: {off}");
    }
}

#[test]
fn loops_over_springs_do_what_groups_do() {
    for name in ["harmonic_oscillator", "damped_oscillator", "elastic_pendulum", "tetrahedron"] {
        for method in Method::ALL.into_iter().filter(|method| *method != Method::ImplicitEuler) {
            let off = difference(name, method);
            assert!(off <= 1e-11, "{name} by {method:?}: {off}");
        }
    }
}

#[test]
fn a_study_of_a_problem_times_the_arithmetic_alone() {
    let methods = [Method::SemiImplicitEuler, Method::RungeKutta4];
    let study = |name: &str| {
        let plan =
            Plan { passes: 1, timed: 1e-4, bodies: 10, patience: 0.1, ..plain(&methods, [16]) };
        studied(Subject::of_problem(problem(name).unwrap()).unwrap(), plan).study().clone()
    };
    for name in ["kepler", "tetrahedron"] {
        let study = study(name);
        assert_eq!(study.ranking(Host::Arithmetic).len(), 2, "{name}");
        assert!(
            study.cells.iter().all(|cell| cell.arithmetic_time.is_some() && cell.time.is_some())
        );
    }
}
