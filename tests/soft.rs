//! Soft bodies put into a world by hand, for the tests of how they are drawn and picked.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Elastic, Link, PhysicsBody, SoftBody, Transform};
use scene::{Appearance, BodySpec, Scene, SoftBodyName, SoftBodySpec};

/// Mass of a point, kg.
pub const POINT_MASS: f64 = 0.25;

/// What a soft body is made of, before it is in a world.
pub struct Soft {
    pub places: Vec<DVec3>,
    pub pinned: Vec<usize>,
    pub springs: Vec<[u32; 2]>,
    pub triangles: Vec<[u32; 3]>,
    pub color: [f32; 3],
    /// Length of every spring where it is put, as a multiple of that at rest.
    pub stretch: f64,
}

impl Soft {
    /// A sheet of `rows` by `columns` cells through `place(u, v)`, both in [0, 1]: u along a row, v down.
    pub fn sheet(rows: u32, columns: u32, place: impl Fn(f64, f64) -> DVec3) -> Self {
        let across = columns + 1;
        let number = |row: u32, column: u32| row * across + column;
        let at = |row: u32, column: u32| {
            place(f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows))
        };
        let all = |rows, columns| {
            (0..rows).flat_map(move |row| (0..columns).map(move |column| (row, column)))
        };
        let along = all(rows + 1, columns)
            .map(|(row, column)| [number(row, column), number(row, column + 1)]);
        let down =
            all(rows, across).map(|(row, column)| [number(row, column), number(row + 1, column)]);
        let triangles = all(rows, columns).flat_map(|(row, column)| {
            let [a, b] = [number(row, column), number(row, column + 1)];
            [[a, a + across, b], [b, a + across, b + across]]
        });
        Self {
            places: all(rows + 1, across).map(|(row, column)| at(row, column)).collect(),
            pinned: Vec::new(),
            springs: along.chain(down).collect(),
            triangles: triangles.collect(),
            color: [1.0, 1.0, 1.0],
            stretch: 1.0,
        }
    }

    /// A flat sheet that is 4 m wide and 3 m high, in the plane z = 0 around `middle`.
    pub fn upright(rows: u32, columns: u32, middle: DVec3) -> Self {
        Self::sheet(rows, columns, |u, v| middle + DVec3::new(4.0 * u - 2.0, 1.5 - 3.0 * v, 0.0))
    }

    /// A rope of `springs` springs from `from` to `to`.
    pub fn rope(springs: u32, from: DVec3, to: DVec3) -> Self {
        let place = |i: u32| from.lerp(to, f64::from(i) / f64::from(springs));
        Self {
            places: (0..=springs).map(place).collect(),
            pinned: vec![0],
            springs: (0..springs).map(|i| [i, i + 1]).collect(),
            triangles: Vec::new(),
            color: [1.0, 0.8, 0.4],
            stretch: 1.0,
        }
    }

    fn links(&self) -> Arc<[Link]> {
        let link = |ends: &[u32; 2]| {
            let [a, b] = ends.map(|end| self.places[end as usize]);
            let rest_length = a.distance(b) / self.stretch;
            Link { ends: *ends, elastic: Elastic::new(100.0, rest_length) }
        };
        self.springs.iter().map(link).collect()
    }

    /// Adds it to a scene, with the name `soft`.
    pub fn add_to(self, scene: &mut Scene) {
        let id = |count: usize| u32::try_from(count).unwrap();
        let points = id(scene.bodies.len())..id(scene.bodies.len() + self.places.len());
        let point = |(number, place): (usize, &DVec3)| BodySpec {
            position: *place,
            inverse_mass: Some(if self.pinned.contains(&number) { 0.0 } else { 1.0 / POINT_MASS }),
            ..BodySpec::DEFAULT
        };
        scene.bodies.extend(self.places.iter().enumerate().map(point));
        scene.soft_bodies.push(SoftBodySpec {
            name: "soft".to_owned(),
            sheet: true,
            points,
            links: self.links(),
            triangles: self.triangles,
            blades: None,
            color: self.color,
        });
    }

    /// Puts it there, with the name `soft`.
    pub fn spawn(self, world: &mut World) -> Entity {
        let points: Vec<_> = self
            .places
            .iter()
            .enumerate()
            .map(|(number, place)| {
                let pinned = self.pinned.contains(&number);
                let body = if pinned {
                    PhysicsBody::IMMOVABLE
                } else {
                    PhysicsBody::with_mass(POINT_MASS)
                };
                world.spawn((Transform::at(*place), body)).id()
            })
            .collect();
        let springs = self.links();
        let body = SoftBody { points, springs, triangles: self.triangles, sheet: true };
        let look = Appearance { color: self.color, checker: false };
        world.spawn((body, look, SoftBodyName("soft".to_owned()))).id()
    }
}
