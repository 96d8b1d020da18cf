//! What it costs to look at every state before it is stored: the same kernels with the look and without, in turns in one process.
//! `--steps checked|unchecked METHOD BODIES STEPS` only steps, for counting instructions.

#[path = "common/mod.rs"]
mod common;

use std::marker::PhantomData;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use common::{Contestant, compare};
use motion::internals::{
    apply_forces, clear_forces, insert_step_resources, integrate_in_one_pass, quarantine_bodies,
};
use motion::methods::{
    Field, Integrator, MethodStateKind, RungeKutta4, SemiImplicitEuler, StepState, VelocityVerlet,
};
use motion::units::Vector;
use motion::{Damping, Gravity, Method, PhysicsBody, TimeStep, Transform};

const SIZES: [usize; 3] = [1_000, 100_000, 1_000_000];

/// `M`, that looks at states or does not: both are compiled here, so that nothing else differs.
#[derive(Clone, Copy, Default)]
struct Looking<M, const LOOKS: bool>(PhantomData<M>);

impl<M: Integrator, const LOOKS: bool> Integrator for Looking<M, LOOKS> {
    const METHOD: Method = M::METHOD;
    const STATE: MethodStateKind = M::STATE;
    const DAMPS_INSIDE: bool = M::DAMPS_INSIDE;
    const SOLVES: bool = M::SOLVES;
    const MOVES: bool = M::MOVES;
    const MOVES_WITH_NEW_VELOCITY: bool = M::MOVES_WITH_NEW_VELOCITY;
    const KICKS: bool = M::KICKS;
    const PASSES_TIME: bool = M::PASSES_TIME;
    const CHECKED: bool = LOOKS;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        step_state: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        M::step(field, x, v, step_state)
    }
}

/// A world of free bodies and the systems of its tick.
struct Ecs {
    world: World,
    schedule: Schedule,
}

impl Ecs {
    fn new<M: Integrator>(n: usize) -> Self {
        let mut world = World::new();
        insert_step_resources(&mut world, TimeStep(1.0 / 120.0));
        world.insert_resource(Gravity::EARTH);
        world.insert_resource(Damping::TUTORIAL);
        #[expect(clippy::cast_precision_loss, reason = "a million")]
        let body = |i: usize| {
            let velocity = Vector::new(1.0, 2.0, 3.0);
            (
                Transform::at(Vector::new(i as f64, 10.0, -1.0)),
                PhysicsBody { velocity, inverse_mass: 10.0 },
            )
        };
        world.spawn_batch((0..n).map(body).collect::<Vec<_>>());
        let mut schedule = Schedule::default();
        schedule.set_executor(SingleThreadedExecutor::new());
        schedule.add_systems(
            (apply_forces, integrate_in_one_pass::<M>, clear_forces, quarantine_bodies).chain(),
        );
        Self { world, schedule }
    }

    fn step(&mut self) {
        self.schedule.run(&mut self.world);
    }

    /// The state of every body, bit for bit.
    fn bits(&mut self) -> Vec<[u64; 6]> {
        let mut bodies = self.world.query::<(&Transform, &PhysicsBody)>();
        let of = |(at, body): (&Transform, &PhysicsBody)| {
            let ([a, b, c], [d, e, f]) = (at.position.to_array(), body.velocity.to_array());
            [a, b, c, d, e, f].map(f64::to_bits)
        };
        bodies.iter(&self.world).map(of).collect()
    }
}

fn pair<M: Integrator>(n: usize) -> [Ecs; 2] {
    [Ecs::new::<Looking<M, false>>(n), Ecs::new::<Looking<M, true>>(n)]
}

fn ratio<M: Integrator>(n: usize) {
    let [mut unchecked, mut checked] = pair::<M>(n);
    (0..10).for_each(|_| [&mut unchecked, &mut checked].into_iter().for_each(Ecs::step));
    assert_eq!(unchecked.bits(), checked.bits(), "both do the same work");
    let contestants: Vec<Contestant<'_>> = vec![
        ("without a look", Box::new(|| unchecked.step())),
        ("as it is", Box::new(|| checked.step())),
    ];
    compare(n, M::METHOD.name(), &[None, (n == 100_000).then_some(1.03)], contestants);
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(place) = arguments.iter().position(|argument| argument == "--steps") {
        let [who, method, bodies, steps] = &arguments[place + 1..place + 5] else {
            panic!("checked|unchecked METHOD BODIES STEPS")
        };
        let bodies = bodies.parse().expect("a number");
        let pair = match method.as_str() {
            "semi_implicit_euler" => pair::<SemiImplicitEuler>(bodies),
            "velocity_verlet" => pair::<VelocityVerlet>(bodies),
            "runge_kutta_4" => pair::<RungeKutta4>(bodies),
            other => panic!("{other} is not measured here"),
        };
        let [unchecked, checked] = pair;
        let mut ecs = if who == "checked" { checked } else { unchecked };
        (0..steps.parse().expect("a number")).for_each(|_: u32| ecs.step());
        return;
    }
    if !arguments.iter().any(|argument| argument == "--test") {
        println!(
            "ns a tick and median ratio to the first of each group (interleaved, thread CPU time)"
        );
        for n in SIZES {
            ratio::<SemiImplicitEuler>(n);
            ratio::<VelocityVerlet>(n);
            ratio::<RungeKutta4>(n);
        }
    }
}
