//! A method of another crate in a world.

use motion::methods::{
    ExplicitEuler, Field, ImplicitEuler, Integrator, MethodStateKind, PositionVerlet, RungeKutta4,
    SemiImplicitEuler, StepState, VelocityVerlet,
};
use motion::{Damping, DampingModel, Drag, Elastic, Gravity, Method, Request, Stepper, TimeStep};

use super::{Environment, H, crowd_with_engines, pushes, wells};
use crate::rigs::Lab;

/// The method `M`, made again outside of the library.
#[derive(Clone, Copy, Default)]
struct Outside<M>(M);

impl<M: Integrator> Integrator for Outside<M> {
    const METHOD: Method = M::METHOD;
    const STATE: MethodStateKind = M::STATE;
    const DAMPS_INSIDE: bool = M::DAMPS_INSIDE;
    const SOLVES: bool = M::SOLVES;
    const MOVES_WITH_NEW_VELOCITY: bool = M::MOVES_WITH_NEW_VELOCITY;
    const LIMITS_AFTER_KICK: bool = M::LIMITS_AFTER_KICK;

    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        step_state: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        M::step(field, x, v, step_state)
    }
}

const TICKS: usize = 60;

fn scenes() -> [Environment; 3] {
    let gravity = Some(Gravity::EARTH);
    let damping = Some(Damping { model: DampingModel::Tutorial, rate: 0.4 });
    [
        Environment { damping, ..Environment::falling() },
        Environment { gravity, wells: Some(wells()), substeps: Some(3), ..Environment::default() },
        Environment {
            drag: Some(Drag::new(0.1, 0.1)),
            wells: Some(wells()),
            ..Environment::default()
        },
    ]
}

/// A crowd with engines and a spring.
fn lab(scene: &Environment, method: Method) -> Lab {
    let mut lab = crowd_with_engines(scene, method);
    lab.spring([0, 1], Elastic::new(40.0, 1.0).damped(0.5));
    lab
}

/// Runs `lab`, in which a law is added and the laws of one body are changed on the way.
fn run(lab: &mut Lab) {
    for (tick, pushed) in pushes(11, TICKS, 11).into_iter().enumerate() {
        if tick == TICKS / 3 {
            lab.world.insert_resource(Drag::new(0.2, 0.0));
        }
        if tick == TICKS / 2 {
            lab.ask(Request::SwitchGravity(false));
        }
        for (body, newtons) in pushed {
            lab.push(body, newtons);
        }
        lab.run(1);
    }
}

fn is_as_of_the_table<M: Integrator>() {
    for scene in scenes() {
        let (mut table, mut outside) = (lab(&scene, M::METHOD), lab(&scene, M::METHOD));
        outside.stepper = Stepper::of::<Outside<M>>(&mut outside.world, TimeStep(H));
        run(&mut table);
        run(&mut outside);
        let systems = outside.stepper.systems();
        assert!(systems.iter().any(|system| system.contains("Outside<")), "{systems:?}");
        assert_eq!(outside.all_bits(&[]), table.all_bits(&[]), "{:?} {scene:?}", M::METHOD);
        assert_eq!(outside.counts(), table.counts(), "{:?} {scene:?}", M::METHOD);
    }
}

#[test]
fn a_method_of_another_crate_has_the_bits_and_counts_that_the_table_gives_it() {
    is_as_of_the_table::<ExplicitEuler>();
    is_as_of_the_table::<SemiImplicitEuler>();
    is_as_of_the_table::<ImplicitEuler>();
    is_as_of_the_table::<PositionVerlet>();
    is_as_of_the_table::<VelocityVerlet>();
    is_as_of_the_table::<RungeKutta4>();
}

#[test]
fn a_world_goes_from_a_method_of_another_crate_to_one_of_the_table() {
    let scene = &scenes()[1];
    let mut outside = lab(scene, Method::RungeKutta4);
    outside.stepper = Stepper::of::<Outside<RungeKutta4>>(&mut outside.world, TimeStep(H));
    run(&mut outside);
    outside.set_method(Method::RungeKutta4);
    let systems = outside.stepper.systems();
    assert!(!systems.iter().any(|system| system.contains("Outside<")), "{systems:?}");
    run(&mut outside);
    let mut table = lab(scene, Method::RungeKutta4);
    run(&mut table);
    run(&mut table);
    assert_eq!(outside.all_bits(&[]), table.all_bits(&[]));
}
