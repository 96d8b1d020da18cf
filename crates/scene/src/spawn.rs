//! Spawns a resolved scene: each entity has only the components that its body needs.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::snapshot::LastStep;
use motion::{
    AxisLocks, DampingRate, Dormant, Emitter, EvaluationTime, GravityOff, Method, Orientation,
    OwnLaws, OwnSubsteps, PhysicsBody, RidesOn, RidingWell, SoftBody, SourceMass, SpeedLimit,
    Spring, StableId, Substeps, Transform, mark_method,
};

use crate::scene::{BodySpec, RidingWellSpec, Scene};
use crate::substepping::Substepping;

/// The appearance of a thing besides its shape.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Appearance {
    /// Linear red, green and blue, each 0 to 1.
    pub color: [f32; 3],
    /// Whether it has the checker texture.
    pub checker: bool,
}

/// The index of a thing in its list: on a [`Spring`] of [`Scene::springs`], on a [`SoftBody`] of
/// [`Scene::soft_bodies`], on an [`Emitter`] of [`Scene::emitters`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FileIndex(pub u32);

/// Radius with which a body without a shape is drawn, m. Physics treats it as a point.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct PointRadius(pub f32);

impl Default for PointRadius {
    /// Large enough to be seen in a scene of bodies of a meter.
    fn default() -> Self {
        Self(0.15)
    }
}

/// The name of a soft body. One without this component has the name of its first point up to the first dot.
#[derive(Component, Clone, Debug, PartialEq, Eq)]
pub struct SoftBodyName(pub String);

impl Scene {
    /// Spawns every body into `world`, then springs, soft bodies and emitters, and inserts the resources of the
    /// effects that the scene declares. Switches off those of [`Scene::off_at_start`].
    ///
    /// Returns the entities of the bodies in the order of the stable id, which each of them carries; scenery, too.
    /// Springs, soft bodies and emitters are entities with a [`FileIndex`] and an [`Appearance`].
    pub fn spawn(&self, world: &mut World) -> Vec<Entity> {
        world.insert_resource(Substeps(self.substeps.least()));
        declare(world, self.gravity);
        declare(world, self.damping);
        self.laws.clone().insert_into(world);
        declare(world, self.mutual_gravity);
        declare(world, self.range);
        let entities: Vec<_> = (0..)
            .map(StableId)
            .zip(&self.bodies)
            .map(|(id, body)| self.spawn_body(world, id, body))
            .collect();
        self.spawn_own_laws(world, &entities);
        for (id, motion) in &self.motions {
            let [_, velocity] = motion.at(EvaluationTime::at(0.0));
            let body = PhysicsBody::IMMOVABLE.moving_at(velocity);
            world.entity_mut(entities[*id as usize]).insert((body, motion.clone()));
        }
        self.spawn_coupled(world, &entities);
        if self.substeps.choice().is_some() {
            self.substeps.put(world);
        }
        for effect in &self.off_at_start {
            // An effect that was never declared is off anyway.
            let _ = motion::effects::switch(world, *effect, false);
        }
        entities
    }

    /// Gives bodies their own laws. All bodies that one riding well attracts share copies of it.
    fn spawn_own_laws(&self, world: &mut World, entities: &[Entity]) {
        let mut riding: Vec<(RidingWellSpec, RidingWell)> = Vec::new();
        for (id, spec) in &self.own_laws {
            let mut laws = spec.laws();
            for well in &spec.riding_wells {
                let RidingWellSpec { rides_on, strength, softening } = *well;
                let known =
                    riding.iter().find(|(other, _)| other == well).map(|(_, known)| known.clone());
                let known = known.unwrap_or_else(|| {
                    let new = RidingWell::new(entities[rides_on as usize], strength, softening);
                    riding.push((*well, new.clone()));
                    new
                });
                laws.push(Box::new(known));
            }
            world.entity_mut(entities[*id as usize]).insert(OwnLaws::new(laws));
        }
    }

    /// Spawns the springs, soft bodies and emitters, which name bodies.
    fn spawn_coupled(&self, world: &mut World, entities: &[Entity]) {
        let plain = |color| Appearance { color, checker: false };
        for (i, spring) in (0..).map(FileIndex).zip(&self.springs) {
            let ends = spring.ends.map(|end| entities[end as usize]);
            world.spawn((Spring { ends, elastic: spring.elastic }, plain(spring.color), i));
        }
        for (i, soft) in (0..).map(FileIndex).zip(&self.soft_bodies) {
            let body = SoftBody {
                points: entities[soft.points.start as usize..soft.points.end as usize].to_vec(),
                springs: soft.links.clone(),
                triangles: soft.triangles.clone(),
                sheet: soft.sheet,
            };
            let mut drawn =
                world.spawn((body, SoftBodyName(soft.name.clone()), plain(soft.color), i));
            soft.blades.map(|blades| drawn.insert(blades));
        }
        for (i, emitter) in (0..).map(FileIndex).zip(&self.emitters) {
            let pool = entities[emitter.pool.start as usize..emitter.pool.end as usize].to_vec();
            pool.iter().for_each(|body| {
                world.entity_mut(*body).insert((Dormant, PointRadius(emitter.radius)));
            });
            let component = Emitter {
                rate: emitter.rate,
                life: emitter.life,
                position: emitter.position,
                pool,
                launches: emitter.launches.clone(),
                inverse_mass: emitter.inverse_mass,
            };
            let mut emitter_entity = world.spawn((component, plain(emitter.color), i));
            if let Some(body) = emitter.rides_on {
                emitter_entity.insert(RidesOn(entities[body as usize]));
            }
            let Some(particles) = &emitter.on_device else { continue };
            let start =
                emitter.rides_on.map_or(DVec3::ZERO, |body| self.bodies[body as usize].position);
            let particles = particles.anchored_at(emitter.position + start);
            emitter_entity.insert((PointRadius(emitter.radius), particles));
        }
    }

    /// Velocity of a body that starts with a previous position of position Verlet, m/s, and the length of that step,
    /// s. `None` if another method was chosen in place of the scene's.
    #[must_use]
    pub fn verlet_start(&self, body: &BodySpec) -> Option<(DVec3, LastStep)> {
        let previous = body.verlet_previous?;
        let h = 1.0 / (self.step_hz * f64::from(body.substeps.unwrap_or(self.substeps).least()));
        let uses_it = body.method.unwrap_or(self.method) == Method::PositionVerlet;
        uses_it.then(|| ((body.position - previous) / h, LastStep(h)))
    }

    fn spawn_body(&self, world: &mut World, id: StableId, body: &BodySpec) -> Entity {
        let verlet_start = self.verlet_start(body);
        let velocity = verlet_start.map_or(body.velocity, |(velocity, _)| velocity);
        let mut entity = spawn_plain(world, id, body, velocity);
        if let Some(method) = body.method {
            mark_method(&mut entity, Some(method));
        }
        give(&mut entity, verlet_start.map(|(_, last_step)| last_step));
        give(&mut entity, body.substeps.map(|substeps| OwnSubsteps(substeps.least())));
        give(
            &mut entity,
            body.substeps.filter(|_| body.is_movable()).and_then(Substepping::choice),
        );
        give(&mut entity, body.orientation.map(Orientation));
        give(&mut entity, body.damping_rate.map(DampingRate::new));
        give(&mut entity, body.max_speed.map(SpeedLimit));
        give(&mut entity, (body.locks != AxisLocks::default()).then_some(body.locks));
        give(&mut entity, body.gravity_off.then_some(GravityOff));
        give(
            &mut entity,
            body.source_mass.filter(|_| self.mutual_gravity.is_some()).map(SourceMass),
        );
        entity.id()
    }
}

fn declare<R: Resource>(world: &mut World, effect: Option<R>) {
    if let Some(effect) = effect {
        world.insert_resource(effect);
    }
}

fn give<C: Component>(entity: &mut EntityWorldMut<'_>, component: Option<C>) {
    if let Some(component) = component {
        entity.insert(component);
    }
}

/// The components of most bodies: position, mass and shape.
fn spawn_plain<'w>(
    world: &'w mut World,
    id: StableId,
    body: &BodySpec,
    velocity: DVec3,
) -> EntityWorldMut<'w> {
    let look = Appearance { color: body.color, checker: body.checker };
    let common = (Transform::at(body.position), id, look);
    let physics = body.inverse_mass.map(|inverse_mass| PhysicsBody { velocity, inverse_mass });
    // Common kinds are spawned whole: inserting one component after another would move a million bodies several
    // times.
    match (physics, body.shape) {
        (Some(physics), Some(shape)) => world.spawn((common, physics, shape)),
        (Some(physics), None) => world.spawn((common, physics)),
        (None, Some(shape)) => world.spawn((common, shape)),
        (None, None) => world.spawn(common),
    }
}

#[cfg(test)]
mod tests {
    use motion::methods::RungeKutta4;
    use motion::{Damping, Drag, Gravity, Wells};
    use pick::Shape;

    use super::*;

    fn spawn(text: &str) -> (Scene, World, Vec<Entity>) {
        let scene = Scene::parse("t", text).unwrap_or_else(|error| panic!("{error}"));
        let mut world = World::new();
        let bodies = scene.spawn(&mut world);
        (scene, world, bodies)
    }

    #[test]
    fn a_world_holds_what_the_scene_declares_and_nothing_else() {
        let text = "(version: 1, bodies: [
            (name: \"plain\", mass_kg: 0.5, velocity_m_s: (1, 2, 3)),
            (name: \"wall\", shape: sphere(radius_m: 1), scenery: true),
            (name: \"all\", shape: sphere(radius_m: 1), rotation_deg: (0, 90, 0), damping_per_s: 2,
             max_speed_m_s: 3, locked_axes: [z], gravity_off: true),
        ])";
        let (_, world, entities) = spawn(text);
        let [plain, wall, all] = entities[..] else { panic!("{entities:?}") };

        assert_eq!(world.get::<PhysicsBody>(plain).unwrap().inverse_mass, 2.0);
        assert_eq!(world.get::<StableId>(all), Some(&StableId(2)));
        assert!(world.get::<PhysicsBody>(wall).is_none() && world.get::<Shape>(wall).is_some());
        assert!(world.get::<Shape>(plain).is_none() && world.get::<Orientation>(plain).is_none());
        assert!(
            world.get::<SpeedLimit>(plain).is_none() && world.get::<AxisLocks>(plain).is_none()
        );
        assert_eq!(world.get::<SpeedLimit>(all), Some(&SpeedLimit(3.0)));
        assert_eq!(
            world.get::<AxisLocks>(all),
            Some(&AxisLocks { z: true, ..AxisLocks::default() })
        );
        assert!(world.get::<GravityOff>(all).is_some() && world.get::<Orientation>(all).is_some());
        assert_eq!(world.get::<DampingRate>(all).unwrap().rate(), 2.0);
        assert!(world.get_resource::<Gravity>().is_none());
        // Declared by the body's own rate alone.
        assert_eq!(world.get_resource::<Damping>().unwrap().rate, 0.0);
        assert!(world.get_resource::<Drag>().is_none() && world.get_resource::<Wells>().is_none());
        assert_eq!(world.get_resource::<Substeps>(), Some(&Substeps(1)));
        assert!(world.get::<OwnLaws>(plain).is_none() && world.get::<OwnSubsteps>(plain).is_none());
    }

    #[test]
    fn laws_methods_and_substeps_go_where_they_were_asked_for() {
        let text = r#"(version: 1, substeps: 5, drag: (linear_per_s: 1), wells: [(strength_m3_s2: 1), (strength_m3_s2: 2, bodies: ["b"])],
            method: runge_kutta_4, bodies: [(), (name: "b", method: runge_kutta_4, substeps: 7)],
            thrusts: [(body: "b", curve: polynomial([(1, 0, 0)])), (body: "b", curve: polynomial([(0, 1, 0)]))])"#;
        let (_, world, bodies) = spawn(text);
        let [plain, own] = bodies[..] else { panic!("two bodies") };
        assert_eq!(world.resource::<Substeps>(), &Substeps(5));
        assert_eq!(world.resource::<Drag>().linear, 1.0);
        assert_eq!(world.resource::<Wells>().0.len(), 1);
        assert_eq!(world.get::<OwnSubsteps>(own), Some(&OwnSubsteps(7)));
        let names = |body| {
            let laws = world.get::<OwnLaws>(body)?;
            Some(laws.laws().iter().map(|law| law.name()).collect::<Vec<_>>())
        };
        assert_eq!((names(plain), names(own)), (None, Some(vec!["wells", "thrusts", "thrusts"])));
        // A body keeps the method that its entry names, even if it is the scene's.
        assert!(
            world.get::<RungeKutta4>(own).is_some() && world.get::<RungeKutta4>(plain).is_none()
        );
    }

    #[test]
    fn a_previous_position_sets_the_velocity_and_the_last_step_of_position_verlet() {
        let text = "(version: 1, step_hz: 10, method: position_verlet, substeps: 2, bodies: [
            (position_m: (1, 2, 0), verlet_previous_position_m: (0, 2, 0)),
            (position_m: (1, 2, 0), verlet_previous_position_m: (0, 2, 0), substeps: 1),
            (position_m: (1, 2, 0))])";
        let (mut scene, world, bodies) = spawn(text);
        let [two, one, right] = bodies[..] else { panic!("three bodies") };
        for (body, speed) in [(two, 20.0), (one, 10.0)] {
            assert_eq!(world.get::<PhysicsBody>(body).unwrap().velocity, DVec3::X * speed);
            assert_eq!(world.get::<LastStep>(body), Some(&LastStep(1.0 / speed)));
        }
        assert_eq!(world.get::<PhysicsBody>(right).unwrap().velocity, DVec3::ZERO);

        scene.method = Method::RungeKutta4;
        let mut world = World::new();
        let bodies = scene.spawn(&mut world);
        assert_eq!(world.get::<PhysicsBody>(bodies[0]).unwrap().velocity, DVec3::ZERO);
        assert!(world.get::<LastStep>(bodies[0]).is_none());
    }

    #[test]
    fn springs_soft_bodies_and_emitters_stand_beside_bodies_and_name_them() {
        let text = r#"(version: 1, mutual_gravity: (constant_m3_kg_s2: 3), bodies: [(name: "a"), (name: "b", immovable: true, mass_kg: 5)],
            springs: [(between: ("a", "b"), stiffness_n_m: 2, color: (1, 0, 0)), (between: ("cloth.r0.c1", "a"), stiffness_n_m: 3)],
            soft_bodies: [chain(points: 3, to_m: (2, 0, 0), stiffness_n_m: 1, damping_per_s: 0.5), cloth(rows: 2, columns: 2, along_m: (1, 0, 0), down_m: (0, -1, 0), stiffness_n_m: 1, pinned: [top_left])],
            emitters: [(rate_per_s: 2, life_s: 1, speed_m_s: 1, position_m: (0, 9, 0), color: (0, 1, 0))])"#;
        let (scene, mut world, bodies) = spawn(text);
        assert_eq!(bodies.len(), 2 + 2 + 3 + 4);
        assert_eq!(world.resource::<motion::MutualGravity>().constant, 3.0);
        assert_eq!(world.get::<SourceMass>(bodies[1]), Some(&SourceMass(5.0)));
        assert!(world.get::<SourceMass>(bodies[0]).is_none());

        let mut springs: Vec<_> = world
            .query::<(&FileIndex, &Spring, &Appearance)>()
            .iter(&world)
            .map(|(i, spring, look)| (i.0, spring.ends, spring.elastic.stiffness, look.color))
            .collect();
        springs.sort_by_key(|spring| spring.0);
        let red = [1.0, 0.0, 0.0];
        let expected =
            [(0, [bodies[0], bodies[1]], 2.0, red), (1, [bodies[8], bodies[0]], 3.0, [1.0; 3])];
        assert_eq!(springs, expected);

        let mut softs = world.query::<(&FileIndex, &SoftBody, &Appearance)>();
        assert_eq!(softs.iter(&world).count(), 2);
        for (index, soft, _) in softs.iter(&world) {
            let spec = &scene.soft_bodies[index.0 as usize];
            assert_eq!(soft.points, bodies[spec.points.start as usize..spec.points.end as usize]);
            assert_eq!((&soft.springs, &soft.triangles), (&spec.links, &spec.triangles));
            assert_eq!(soft.sheet, spec.name == "cloth");
        }
        let pinned: Vec<_> = (4..11)
            .filter(|i| world.get::<PhysicsBody>(bodies[*i]).unwrap().inverse_mass == 0.0)
            .collect();
        assert_eq!(pinned, [7]);
        assert_eq!(world.get::<DampingRate>(bodies[4]).unwrap().rate(), 0.5);

        let (emitter, look) = world.query::<(&Emitter, &Appearance)>().single(&world).unwrap();
        assert_eq!((&emitter.pool[..], emitter.rate, emitter.life), (&bodies[2..4], 2.0, 1.0));
        assert_eq!((&emitter.launches, look.color), (&scene.emitters[0].launches, [0.0, 1.0, 0.0]));
        assert_eq!((emitter.position, emitter.inverse_mass), (DVec3::Y * 9.0, 1.0));
        let dormant: Vec<_> =
            bodies.iter().map(|body| world.get::<Dormant>(*body).is_some()).collect();
        assert!(
            dormant[2] && dormant[3] && dormant.iter().filter(|dormant| **dormant).count() == 2
        );
    }

    #[test]
    fn a_mass_beside_immovable_is_nothing_without_mutual_gravity() {
        let (_, world, bodies) = spawn("(version: 1, bodies: [(immovable: true, mass_kg: 5)])");
        assert!(world.get::<SourceMass>(bodies[0]).is_none());
        assert_eq!(world.get::<PhysicsBody>(bodies[0]), Some(&PhysicsBody::IMMOVABLE));
        assert!(world.get_resource::<motion::MutualGravity>().is_none());
    }
}
