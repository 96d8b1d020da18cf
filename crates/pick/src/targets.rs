//! The drawn poses of one frame: what rays are tested against and instances are read from.

use std::cell::Cell;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

use bevy_ecs::entity::Entity;
use bevy_ecs::resource::Resource;
use glam::{DVec3, Quat, Vec3};
use motion::{Orientation, PreviousPosition, Transform};

use crate::bvh::{Tree, cost};
use crate::columns::{Columns, Rows, Writing, same, write};
use crate::exact::{Volume, within_reach};
use crate::scan::{Beam, INFLATION};
use crate::{Ray, Shape};

/// A run of rows of one table, all slices of one length.
#[derive(Clone, Copy, Debug)]
pub struct Chunk<'a> {
    /// The entity of each row.
    pub entities: &'a [Entity],
    /// Position of each row.
    pub transforms: &'a [Transform],
    /// Position of each row at the start of the last tick; without it the rows are drawn at their positions.
    pub previous: Option<&'a [PreviousPosition]>,
    /// Shape of each row.
    pub shapes: &'a [Shape],
    /// Orientation of each row; without it no row is rotated.
    pub orientations: Option<&'a [Orientation]>,
}

/// The closest thing on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The entity that was hit.
    pub entity: Entity,
    /// Its row in [`Targets`], valid until the next update.
    pub index: usize,
    /// Distance from the ray's origin, m, above 0.
    pub distance: f64,
    /// Point of its surface that was hit, world space, m.
    pub point: DVec3,
}

/// The drawn poses of one frame, relative to an anchor: structure of arrays in f32, filled once per frame, read by
/// ray casts and by the extraction of instances.
///
/// The closest hit wins (the lower row among equals); floor, immovable bodies and scenery are hit like all else. A
/// shape that contains the ray's origin is not hit, since a body cannot be seen from inside. The tutorial's box behaves
/// the same; its sphere is hit at a negative distance instead, an error that is not repeated here. Shapes behind the
/// origin, at a position that is not finite, or farther than 1e18 m are never hit.
///
/// A cast scans all targets or walks a tree, whichever recent frames make cheaper; the hit is the same.
#[derive(Resource, Default)]
pub struct Targets {
    anchor: DVec3,
    columns: Columns,
    entities: Vec<Entity>,
    shapes: Vec<Shape>,
    volumes: Vec<Volume>,
    orientations: Vec<Quat>,
    /// Length of each chunk and whether it has orientations.
    layout: Vec<(usize, bool)>,
    tree: OnceLock<Tree>,
    /// Rays since the last update.
    rays: AtomicU32,
    /// Rays scanned since too many targets moved for a tree.
    scanned: AtomicU32,
}

impl std::fmt::Debug for Targets {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let tree = self.tree.get().is_some();
        f.debug_struct("Targets")
            .field("anchor", &self.anchor)
            .field("len", &self.len())
            .field("tree", &tree)
            .finish()
    }
}

impl Targets {
    /// Takes over the poses of all `chunks`, as drawn `alpha` (0 to 1) of the way from the previous to the
    /// current tick, relative to `anchor` (world space, m; the camera's position).
    ///
    /// Shapes and orientations are read again only where rows have changed; after writing to one in place,
    /// call [`Self::invalidate`].
    ///
    /// # Panics
    ///
    /// If the slices of a chunk differ in length.
    pub fn update<'a>(
        &mut self,
        anchor: DVec3,
        alpha: f64,
        chunks: impl Iterator<Item = Chunk<'a>>,
    ) {
        let old_anchor = std::mem::replace(&mut self.anchor, anchor);
        let rays = std::mem::take(self.rays.get_mut());
        let enough = cost::most_moved_for_tree(self.len(), rays);
        if self.tree.get().is_some_and(|tree| !tree.serves(anchor)) {
            self.tree.take();
        }
        let (mut from, mut moved, mut number) = (0, 0, 0);
        for chunk in chunks {
            let count = chunk.entities.len();
            assert_eq!(chunk.transforms.len(), count, "a chunk has one transform for each entity");
            assert!(
                chunk.previous.is_none_or(|p| p.len() == count),
                "a chunk has one previous position for each entity"
            );
            if !self.has(number, from, &chunk) {
                self.replace(number, from, &chunk);
            }
            let positions = self.columns.rows_mut(from, from + count);
            let rows = Rows { transforms: chunk.transforms, previous: chunk.previous };
            // A tree itself finds the bodies that moved.
            let enough = self.tree.get().is_none().then_some(enough);
            moved += write(positions, rows, Writing { alpha, old_anchor, anchor, enough });
            if let Some(tree) = self.tree.get_mut() {
                tree.note(from, rows, alpha);
            }
            from += count;
            number += 1;
        }
        if number != self.layout.len() {
            self.truncate(number, from);
        }
        let kept = match self.tree.get_mut() {
            Some(tree) => tree.follow(rays),
            None => moved <= enough,
        };
        if !kept {
            self.tree.take();
            *self.scanned.get_mut() = 0;
        }
    }

    /// Makes the next update read shapes and orientations again.
    pub fn invalidate(&mut self) {
        self.truncate(0, 0);
    }

    fn has(&self, number: usize, from: usize, chunk: &Chunk<'_>) -> bool {
        let layout = (chunk.entities.len(), chunk.orientations.is_some());
        self.layout.get(number) == Some(&layout) && same(&self.entities[from..], chunk.entities)
    }

    /// Forgets the rows of this chunk and of all after it.
    fn truncate(&mut self, number: usize, from: usize) {
        self.layout.truncate(number);
        self.entities.truncate(from);
        self.shapes.truncate(from);
        self.volumes.truncate(from);
        self.orientations.truncate(from);
        self.columns.resize(from);
        self.tree.take();
        *self.scanned.get_mut() = 0;
    }

    fn replace(&mut self, number: usize, from: usize, chunk: &Chunk<'_>) {
        self.truncate(number, from);
        let rows = chunk.entities.len();
        assert_eq!(chunk.shapes.len(), rows, "a chunk has one shape for each entity");
        self.layout.push((rows, chunk.orientations.is_some()));
        self.entities.extend_from_slice(chunk.entities);
        self.shapes.extend_from_slice(chunk.shapes);
        match chunk.orientations {
            None => self.orientations.resize(from + rows, Quat::IDENTITY),
            Some(orientations) => {
                assert_eq!(orientations.len(), rows, "a chunk has one orientation for each entity");
                self.orientations.extend(orientations.iter().map(|o| o.0.as_quat().normalize()));
            }
        }
        self.columns.resize(from + rows);
        for (row, shape) in chunk.shapes.iter().enumerate() {
            let volume = Volume::of(shape);
            self.columns.set_radius(from + row, volume.bounding_radius() * INFLATION);
            self.volumes.push(volume);
        }
    }

    /// The closest thing that `ray` hits.
    ///
    /// The ray may start anywhere, but positions are known to 6e-8 of their distance from the anchor.
    #[must_use]
    pub fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.rays.fetch_add(1, Ordering::Relaxed);
        if let Some(tree) = self.tree.get() {
            return self.walk(tree, ray);
        }
        if self.len() < cost::FEWEST
            || self.scanned.fetch_add(1, Ordering::Relaxed) < cost::RAYS_BEFORE_BUILD
        {
            return self.cast_by_scan(ray);
        }
        self.cast_by_tree(ray)
    }

    /// [`Self::cast`] by scanning all targets; the hit is the same. For measurements and tests.
    #[must_use]
    pub fn cast_by_scan(&self, ray: &Ray) -> Option<Hit> {
        let closest = Closest::default();
        let shift = ray.origin() - self.anchor;
        let beam = Beam::new(ray, self.anchor);
        beam.scan(self.columns.balls(), f32::MAX, |row, _| self.visit(row, shift, ray, &closest));
        self.hit(ray, &closest)
    }

    /// [`Self::cast`] by walking the tree, which is built if there is none; the hit is the same. For measurements
    /// and tests.
    #[must_use]
    pub fn cast_by_tree(&self, ray: &Ray) -> Option<Hit> {
        self.walk(self.tree.get_or_init(|| self.build()), ray)
    }

    fn build(&self) -> Tree {
        let reach = self
            .volumes
            .iter()
            .zip(&self.orientations)
            .map(|(volume, &turned)| volume.reach(turned));
        Tree::build(self.anchor, self.positions(), reach.collect())
    }

    fn walk(&self, tree: &Tree, ray: &Ray) -> Option<Hit> {
        let closest = Closest::default();
        let shift = ray.origin() - self.anchor;
        match tree.walk(ray, |row, _| self.visit(row, shift, ray, &closest)) {
            Some(()) => self.hit(ray, &closest),
            None => self.cast_by_scan(ray),
        }
    }

    /// Tests one row exactly and returns the distance beyond which no further row is of interest, m.
    #[inline]
    fn visit(&self, row: usize, shift: DVec3, ray: &Ray, closest: &Closest) -> f32 {
        let (best, index) = closest.0.get();
        let center = self.columns.center(row);
        if within_reach(center)
            && let Some(distance) = self.volumes[row].distance(
                self.orientations[row],
                center.as_dvec3() - shift,
                ray,
                best,
            )
            && (distance < best || row < index)
        {
            closest.0.set((distance, row));
        }
        // One up, so that rounding does not lose an equally close row of lower number.
        (closest.0.get().0 as f32).next_up()
    }

    fn hit(&self, ray: &Ray, closest: &Closest) -> Option<Hit> {
        let (distance, index) = closest.0.get();
        let entity = *self.entities.get(index)?;
        Some(Hit { entity, index, distance, point: ray.at(distance) })
    }

    /// Number of targets.
    #[must_use]
    pub fn len(&self) -> usize {
        self.entities.len()
    }

    /// Whether there are no targets.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entities.is_empty()
    }

    /// The anchor, to which the positions are relative, world space, m.
    #[must_use]
    pub fn anchor(&self) -> DVec3 {
        self.anchor
    }

    /// Drawn positions minus the anchor, m: x, y and z of all rows.
    #[must_use]
    pub fn positions(&self) -> (&[f32], &[f32], &[f32]) {
        self.columns.positions()
    }

    /// The entity of each row, in order.
    #[must_use]
    pub fn entities(&self) -> &[Entity] {
        &self.entities
    }

    /// The entity of row `index`.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    #[must_use]
    pub fn entity(&self, index: usize) -> Entity {
        self.entities[index]
    }

    /// The shape of row `index`.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    #[must_use]
    pub fn shape(&self, index: usize) -> &Shape {
        &self.shapes[index]
    }

    /// The orientation of row `index`, a unit quaternion.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    #[must_use]
    pub fn orientation(&self, index: usize) -> Quat {
        self.orientations[index]
    }

    /// Half extents of the axis-aligned box around the rotated shape of row `index`, m.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    #[must_use]
    pub fn reach(&self, index: usize) -> Vec3 {
        self.volumes[index].reach(self.orientations[index])
    }
}

/// Distance and row of the closest hit so far.
struct Closest(Cell<(f64, usize)>);

impl Default for Closest {
    fn default() -> Self {
        Self(Cell::new((f64::INFINITY, usize::MAX)))
    }
}

#[cfg(test)]
mod tests;
