//! Whole worlds in plain arrays: the bits of the tables in f64, and what single precision makes of them.

mod experiments;
mod precision;
mod refused;
mod worlds;

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::arrays::Bare;
use motion::real::Real;
use motion::{Evaluations, Law, Method, PhysicsBody, StableId, Stepper, TimeStep, Transform, Wells};
use scene::{OwnLawsSpec, Scene};

/// Id, position and velocity.
type States = Vec<(u32, DVec3, DVec3)>;

/// `f64` or `f32`, as the arrays have entry points for.
trait Precision: Real {
    fn of_world(
        world: &mut World,
        method: Method,
        laws: motion::arrays::LawsOf<'_, Self>,
    ) -> Result<Bare<Self>, motion::arrays::NotForArrays>;
    fn tick(bare: &mut Bare<Self>);
}

macro_rules! precisions {
    ($($t:ty)*) => {$(
        impl Precision for $t {
            fn of_world(
                world: &mut World,
                method: Method,
                laws: motion::arrays::LawsOf<'_, Self>,
            ) -> Result<Bare<Self>, motion::arrays::NotForArrays> {
                Bare::<$t>::of_world(world, method, laws, Vec::new())
            }

            fn tick(bare: &mut Bare<Self>) {
                bare.tick();
            }
        }
    )*};
}

precisions!(f64 f32);

/// A scene in a world, with its schedule.
struct Twin {
    world: World,
    stepper: Stepper,
    scene: Scene,
    entities: Vec<Entity>,
}

impl Twin {
    fn new(mut scene: Scene, method: Method, substeps: u32) -> Self {
        scene.method = method;
        scene.substeps = substeps;
        let mut world = World::new();
        let entities = scene.spawn(&mut world);
        let stepper = Stepper::new(&mut world, method, TimeStep(1.0 / scene.step_hz));
        Self { world, stepper, scene, entities }
    }

    /// The same in plain arrays, as it is now.
    fn bare<T: Precision>(&mut self) -> Bare<T> {
        let Self { world, scene, entities, .. } = self;
        let laws = |body: Entity| {
            let id = entities.iter().position(|entity| *entity == body).unwrap();
            own_laws::<T>(&scene.own_laws[&u32::try_from(id).unwrap()])
        };
        T::of_world(world, scene.method, &laws).unwrap()
    }

    fn run(&mut self, ticks: u32) {
        (0..ticks).for_each(|_| self.stepper.tick(&mut self.world));
    }

    fn states(&mut self) -> States {
        let mut bodies = self.world.query::<(&StableId, &Transform, &PhysicsBody)>();
        let mut states: States =
            bodies.iter(&self.world).map(|(id, at, body)| (id.0, at.position, body.velocity)).collect();
        states.sort_by_key(|(id, ..)| *id);
        states
    }

    fn evaluations(&self) -> &Evaluations {
        self.world.resource()
    }
}

fn own_laws<T: Real>(spec: &OwnLawsSpec) -> Vec<Box<dyn Law<T>>> {
    let wells = (!spec.wells.is_empty()).then(|| Box::new(Wells(spec.wells.clone())) as Box<dyn Law<T>>);
    let thrusts = spec.thrusts.iter().map(|thrust| Box::new(thrust.clone()) as Box<dyn Law<T>>);
    wells.into_iter().chain(thrusts).collect()
}

fn run<T: Precision>(bare: &mut Bare<T>, ticks: u32) {
    (0..ticks).for_each(|_| T::tick(bare));
}

fn states<T: Precision>(bare: &Bare<T>) -> States {
    bare.states().map(|(id, x, v)| (id.0, x, v)).collect()
}

fn bits(states: &States) -> Vec<(u32, [u64; 3], [u64; 3])> {
    let bits = |vector: DVec3| vector.to_array().map(f64::to_bits);
    states.iter().map(|(id, x, v)| (*id, bits(*x), bits(*v))).collect()
}
