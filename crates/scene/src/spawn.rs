//! From a resolved scene to entities: each carries the components that it asks for and no others.

use bevy_ecs::prelude::*;
use motion::{AxisLocks, DampingRate, GravityOff, Orientation, PhysicsBody, SpeedLimit, StableId, Transform};

use crate::scene::{BodySpec, Scene};

/// What a thing looks like beside its shape.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Appearance {
    /// Linear red, green and blue, each 0 to 1.
    pub color: [f32; 3],
    /// Whether it wears the checker texture.
    pub checker: bool,
}

impl Scene {
    /// Spawns every body into `world` and inserts the resources of the effects that the scene declares.
    ///
    /// The entities come in the order of the stable id, which each of them carries; scenery too.
    pub fn spawn(&self, world: &mut World) -> Vec<Entity> {
        if let Some(gravity) = self.gravity {
            world.insert_resource(gravity);
        }
        if let Some(damping) = self.damping {
            world.insert_resource(damping);
        }
        (0..).map(StableId).zip(&self.bodies).map(|(id, body)| spawn_body(world, id, body)).collect()
    }
}

fn spawn_body(world: &mut World, id: StableId, body: &BodySpec) -> Entity {
    let look = Appearance { color: body.color, checker: body.checker };
    let common = (Transform::at(body.position), id, look);
    let physics = body.inverse_mass.map(|inverse_mass| PhysicsBody { velocity: body.velocity, inverse_mass });
    // The common kinds in one go each: inserting piece by piece would move a million bodies several times.
    let mut entity = match (physics, body.shape) {
        (Some(physics), Some(shape)) => world.spawn((common, physics, shape)),
        (Some(physics), None) => world.spawn((common, physics)),
        (None, Some(shape)) => world.spawn((common, shape)),
        (None, None) => world.spawn(common),
    };
    if let Some(orientation) = body.orientation {
        entity.insert(Orientation(orientation));
    }
    if let Some(rate) = body.damping_rate {
        entity.insert(DampingRate::new(rate));
    }
    if let Some(limit) = body.max_speed {
        entity.insert(SpeedLimit(limit));
    }
    if body.locks != AxisLocks::default() {
        entity.insert(body.locks);
    }
    if body.gravity_off {
        entity.insert(GravityOff);
    }
    entity.id()
}

#[cfg(test)]
mod tests {
    use motion::{Damping, Gravity};
    use pick::Shape;

    use super::*;

    #[test]
    fn a_world_holds_what_the_scene_declares_and_nothing_else() {
        let text = "(version: 1, bodies: [
            (name: \"plain\", mass_kg: 0.5, velocity_m_s: (1, 2, 3)),
            (name: \"wall\", shape: sphere(radius_m: 1), scenery: true),
            (name: \"all\", shape: sphere(radius_m: 1), rotation_deg: (0, 90, 0), damping_per_s: 2,
             max_speed_m_s: 3, locked_axes: [z], gravity_off: true),
        ])";
        let scene = Scene::parse("t", text).unwrap();
        let mut world = World::new();
        let entities = scene.spawn(&mut world);
        let [plain, wall, all] = entities[..] else { panic!("{entities:?}") };

        assert_eq!(world.get::<PhysicsBody>(plain).unwrap().inverse_mass, 2.0);
        assert_eq!(world.get::<StableId>(all), Some(&StableId(2)));
        assert!(world.get::<PhysicsBody>(wall).is_none() && world.get::<Shape>(wall).is_some());
        assert!(world.get::<Shape>(plain).is_none() && world.get::<Orientation>(plain).is_none());
        assert!(world.get::<SpeedLimit>(plain).is_none() && world.get::<AxisLocks>(plain).is_none());
        assert_eq!(world.get::<SpeedLimit>(all), Some(&SpeedLimit(3.0)));
        assert_eq!(world.get::<AxisLocks>(all), Some(&AxisLocks { z: true, ..AxisLocks::default() }));
        assert!(world.get::<GravityOff>(all).is_some() && world.get::<Orientation>(all).is_some());
        assert_eq!(world.get::<DampingRate>(all).unwrap().rate(), 2.0);
        assert!(world.get_resource::<Gravity>().is_none());
        // Declared by the body's own rate alone.
        assert_eq!(world.get_resource::<Damping>().unwrap().rate, 0.0);
    }
}
