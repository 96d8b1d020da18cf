//! Whole worlds in plain arrays: the bits of the tables in f64, and what single precision makes of them.

mod experiments;
mod precision;
mod refused;
mod worlds;

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::arrays::Bare;
use motion::real::Real;
use motion::{Law, Method, Wells};
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

/// A scene in a world, with that method and number of substeps.
fn twin(scene: Scene, method: Method, substeps: u32) -> Simulation {
    Simulation::new(Scene { method, substeps, ..scene })
}

/// The same in plain arrays, as it is now.
fn arrays<T: Precision>(twin: &mut Simulation) -> Bare<T> {
    let method = twin.method();
    arrays_by(twin, method)
}

/// The same, going on by `method`.
fn arrays_by<T: Precision>(twin: &mut Simulation, method: Method) -> Bare<T> {
    let Simulation { scene, world, bodies, .. } = twin;
    let laws = |body: Entity| {
        let id = bodies.iter().position(|entity| *entity == body).unwrap();
        own_laws::<T>(&scene.own_laws[&u32::try_from(id).unwrap()])
    };
    T::of_world(world, method, &laws).unwrap()
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
