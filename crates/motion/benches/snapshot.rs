//! What a snapshot costs beside a tick: to take it, and to put it back after a tick.

#[path = "common/mod.rs"]
mod common;

use bevy_ecs::prelude::*;
use common::compare;
use motion::snapshot::{self, Snapshot};
use motion::units::Vector;
use motion::{Gravity, Method, PhysicsBody, Stepper, TimeStep, Transform};

fn world(n: usize, method: Method) -> (World, Stepper) {
    let mut world = World::new();
    world.insert_resource(Gravity::EARTH);
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let at = |i: usize| Transform::at(Vector::new(i as f64, 10.0, 0.0));
    world.spawn_batch((0..n).map(|i| (at(i), PhysicsBody::with_mass(1.0))).collect::<Vec<_>>());
    let mut stepper = Stepper::new(&mut world, method, TimeStep(1.0 / 120.0));
    stepper.tick(&mut world);
    (world, stepper)
}

/// Bytes of the lists that are as long as there are bodies.
fn bytes(saved: &Snapshot) -> usize {
    size_of_val(&*saved.bodies)
        + size_of_val(&*saved.transforms)
        + size_of_val(&*saved.states)
        + size_of_val(&*saved.last_steps)
}

fn main() {
    for (method, title) in [
        (Method::SemiImplicitEuler, "semi-implicit Euler"),
        (Method::PositionVerlet, "position Verlet"),
    ] {
        for n in [1_000, 10_000, 100_000] {
            let mut worlds = [(); 3].map(|()| world(n, method));
            let [ticked, taken, restored] = &mut worlds;
            let saved = snapshot::take(&restored.0, &restored.1);
            println!("{title:>22} {n:>9}  {} bytes", bytes(&saved));
            compare(
                n,
                title,
                &[None; 3],
                vec![
                    ("tick", Box::new(|| ticked.1.tick(&mut ticked.0))),
                    (
                        "take",
                        Box::new(|| {
                            drop(std::hint::black_box(snapshot::take(&taken.0, &taken.1)));
                        }),
                    ),
                    (
                        "tick and restore",
                        Box::new(|| {
                            restored.1.tick(&mut restored.0);
                            snapshot::restore(&mut restored.0, &mut restored.1, &saved)
                                .expect("the same bodies");
                        }),
                    ),
                ],
            );
        }
    }
}
