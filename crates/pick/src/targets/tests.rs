//! Scenes to cast rays at, and a second, independent test in f64.

use bevy_ecs::prelude::*;
use glam::{DQuat, DVec3};

use super::*;

mod choosing;
mod hits;

/// One table of things, as the world would hold it.
#[derive(Clone, Default)]
struct Scene {
    entities: Vec<Entity>,
    transforms: Vec<Transform>,
    previous: Option<Vec<PreviousPosition>>,
    shapes: Vec<Shape>,
    orientations: Vec<Orientation>,
}

impl Scene {
    fn with(mut self, position: DVec3, shape: Shape) -> Self {
        self.add(position, shape, DQuat::IDENTITY);
        self
    }

    fn add(&mut self, position: DVec3, shape: Shape, turned: DQuat) {
        self.entities.push(Entity::from_raw_u32(self.entities.len() as u32).unwrap());
        self.transforms.push(Transform::at(position));
        self.shapes.push(shape);
        self.orientations.push(Orientation(turned));
    }

    fn chunk(&self) -> Chunk<'_> {
        Chunk {
            entities: &self.entities,
            transforms: &self.transforms,
            previous: self.previous.as_deref(),
            shapes: &self.shapes,
            orientations: Some(&self.orientations),
        }
    }

    fn targets(&self, anchor: DVec3) -> Targets {
        let mut targets = Targets::default();
        targets.update(anchor, 1.0, std::iter::once(self.chunk()));
        targets
    }

    /// Distance to the closest shape when all are larger by `off` times the error that f32 allows: a rounding or
    /// two of the distance (2^-24 = 6e-8 of it, the position's), and some of the size (parry's).
    fn brute_force(&self, ray: &Ray, off: f64) -> f64 {
        (0..self.shapes.len())
            .map(|i| self.brute_force_one(i, ray, off))
            .fold(f64::INFINITY, f64::min)
    }

    fn brute_force_one(&self, i: usize, ray: &Ray, off: f64) -> f64 {
        let start = ray.origin() - self.transforms[i].position;
        let grow = off * (1.2e-7 * start.length() + 5e-7 * self.shapes[i].bounding_radius());
        let turn = self.orientations[i].0.inverse();
        let (start, direction) = (turn * start, turn * ray.direction());
        match self.shapes[i] {
            Shape::Sphere { radius } => {
                let (along, radius) = (-start.dot(direction), radius + grow);
                let square = radius * radius - (start + direction * along).length_squared();
                let entry = along - square.max(0.0).sqrt();
                if radius > 0.0 && square >= 0.0 && entry > 0.0 { entry } else { f64::INFINITY }
            }
            Shape::Cuboid { half_extents } => {
                let half = half_extents + grow;
                let (a, b) = ((-half - start) / direction, (half - start) / direction);
                let (entry, exit) = (a.min(b).max_element(), a.max(b).min_element());
                if half.min_element() > 0.0 && entry <= exit && entry > 0.0 {
                    entry
                } else {
                    f64::INFINITY
                }
            }
        }
    }
}

/// Marsaglia's xorshift64: enough for scenes, and no dependency.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    fn turn(&mut self) -> DQuat {
        let (v, w) = (self.vector(), self.unit());
        DQuat::from_xyzw(v.x, v.y, v.z, w).normalize()
    }

    fn scene(&mut self, count: usize, center: DVec3, spread: f64) -> Scene {
        let mut scene = Scene::default();
        for i in 0..count {
            let position = center + self.vector() * spread;
            let turned = self.turn();
            let shape = if i % 2 == 0 { ball(0.2 + self.unit()) } else { cube(0.2 + self.unit()) };
            scene.add(position, shape, turned);
        }
        scene
    }

    /// A ray from near `eye` that passes within a few m of a random thing.
    fn aim(&mut self, eye: DVec3, scene: &Scene) -> Ray {
        let at = (self.unit() * scene.transforms.len() as f64) as usize;
        let origin = eye + self.vector();
        Ray::new(origin, scene.transforms[at].position + self.vector() * 1.5 - origin).unwrap()
    }
}

fn ball(radius: f64) -> Shape {
    Shape::sphere(radius).unwrap()
}

fn cube(half: f64) -> Shape {
    Shape::cuboid(DVec3::splat(half)).unwrap()
}

fn ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray::new(origin, direction).unwrap()
}

/// Both paths must agree to the bit, so each test tests both.
#[track_caller]
fn cast(targets: &Targets, ray: &Ray) -> Option<Hit> {
    let hit = targets.cast_by_scan(ray);
    assert_eq!(hit, targets.cast_by_tree(ray), "scan and tree, {ray:?}");
    hit
}

#[track_caller]
fn row_and_distance(targets: &Targets, ray: &Ray) -> (usize, f64) {
    let hit = cast(targets, ray).expect("a hit");
    (hit.index, to_the_micrometer(hit.distance))
}

fn to_the_micrometer(distance: f64) -> f64 {
    (distance * 1e6).round() / 1e6
}
