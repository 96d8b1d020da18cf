//! Whole worlds in plain arrays: the bits of the tables.

mod experiments;
mod refused;
mod saved;
mod worlds;

use bevy_ecs::prelude::*;
use glam::DVec3;
use history::Simulation;
use motion::arrays::Bare;
use motion::{Law, Method, Wells};
use scene::{OwnLawsSpec, Scene};

/// Id, position and velocity.
type States = Vec<(u32, DVec3, DVec3)>;

/// A scene in a world, with that method and number of substeps.
fn twin(scene: Scene, method: Method, substeps: u32) -> Simulation {
    Simulation::new(Scene { method, substeps, ..scene })
}

/// The same in plain arrays, as it is now.
fn arrays(twin: &mut Simulation) -> Bare {
    let method = twin.method();
    arrays_by(twin, method)
}

/// The same, continued by `method`.
fn arrays_by(twin: &mut Simulation, method: Method) -> Bare {
    let Simulation { scene, world, bodies, .. } = twin;
    let laws = |body: Entity| {
        let id = bodies.iter().position(|entity| *entity == body).unwrap();
        own_laws(&scene.own_laws[&u32::try_from(id).unwrap()])
    };
    Bare::of_world(world, method, &laws, Vec::new()).unwrap()
}

fn own_laws(spec: &OwnLawsSpec) -> Vec<Box<dyn Law>> {
    let wells =
        (!spec.wells.is_empty()).then(|| Box::new(Wells(spec.wells.clone())) as Box<dyn Law>);
    let thrusts = spec.thrusts.iter().map(|thrust| Box::new(thrust.clone()) as Box<dyn Law>);
    let drag = spec.drag.map(|drag| Box::new(drag) as Box<dyn Law>);
    drag.into_iter().chain(wells).chain(thrusts).collect()
}

fn run(bare: &mut Bare, ticks: u32) {
    (0..ticks).for_each(|_| bare.tick());
}

fn states(bare: &Bare) -> States {
    bare.states().map(|(id, x, v)| (id.0, x, v)).collect()
}
