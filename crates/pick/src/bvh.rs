//! The tree: parry's bounding volume hierarchy over the targets, kept in a frame of its own, and its costs.

use std::cell::Cell;

use glam::{DVec3, Vec3};
use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::Ray as LocalRay;

use crate::Ray;
use crate::columns::{Known, Rows, SPAN, differs, next_moved};
use crate::exact::within_reach;

/// Costs that decide between scan and tree, ns per target, from the crossover part of `cargo bench -p inertia-pick`
/// (2 cores of an AMD EPYC with AVX2). Only their ratios matter, and a wrong one costs time, never a hit.
pub(crate) mod cost {
    /// Scanning one target for one ray.
    pub(crate) const SCAN: f64 = 0.6;
    /// Building the tree, per target.
    pub(crate) const BUILD: f64 = 450.0;
    /// Taking one moved target out of the tree and putting it back.
    pub(crate) const REINSERT: f64 = 800.0;
    /// Rewriting all leaves and refitting their parents, per target of the tree.
    pub(crate) const REFIT: f64 = 40.0;
    /// Below this many targets a scan is about as fast as the tree, and simpler.
    pub(crate) const FEWEST: usize = 1500;

    /// How many of `all` targets may have moved for a tree, updates included, to be cheaper than scanning
    /// `rays` rays.
    pub(crate) fn most_moved_for_tree(all: usize, rays: u32) -> usize {
        // At least one ray: a pointer that hovers asks again in the next frame.
        let scans = f64::from(rays.max(1)) * SCAN;
        if scans >= REFIT { all } else { (all as f64 * scans / REINSERT) as usize }
    }

    /// Rays that are scanned over targets at rest before a tree is built: as many as a build costs, so that the
    /// two together never cost more than twice the cheaper one.
    pub(crate) const RAYS_BEFORE_BUILD: u32 = (BUILD / SCAN) as u32;
}

/// How far the camera may be from the origin of the tree's frame, m: the boxes are loosened for f32 errors up to
/// there (by 1e-6 of it and of their own distance), and beyond it the tree is rebuilt.
const ROAM: f64 = 4096.0;

/// A tree whose leaf numbers are row numbers.
pub(crate) struct Tree {
    bvh: Bvh,
    frame: DVec3,
    /// Coordinates of the centers relative to the frame, by which a thing at rest is recognized.
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    reach: Vec<Vec3>,
    moved: Vec<u32>,
    refitted: u32,
}

/// Refits after which the tree is rebuilt: bodies have then drifted away from those that they were grouped with. At
/// 16, the build adds half a refit's cost to each.
const REFITS_BEFORE_REBUILD: u32 = 16;

impl Tree {
    /// A tree over targets whose positions are relative to `frame`.
    pub(crate) fn build(
        frame: DVec3,
        positions: (&[f32], &[f32], &[f32]),
        reach: Vec<Vec3>,
    ) -> Self {
        let (x, y, z) = (positions.0.to_vec(), positions.1.to_vec(), positions.2.to_vec());
        let mut tree =
            Self { bvh: Bvh::new(), frame, x, y, z, reach, moved: Vec::new(), refitted: 0 };
        tree.rebuild();
        tree
    }

    fn rebuild(&mut self) {
        // Leaf numbers must be gapless: from 0.31.1's `from_iter`, a tree of one or two leaves takes 0 and 1.
        let leaves = (0..self.x.len()).map(|row| (row, self.leaf(row)));
        self.bvh = Bvh::from_iter(BvhBuildStrategy::Binned, leaves);
        self.refitted = 0;
    }

    fn leaf(&self, row: usize) -> Aabb {
        let center = Vec3::new(self.x[row], self.y[row], self.z[row]);
        // The exact test refuses a center that is NaN or out of reach, so any box that builds well will do.
        let (center, reach) =
            if within_reach(center) { (center, self.reach[row]) } else { (Vec3::ZERO, Vec3::ZERO) };
        let size = center.abs().max_element() + reach.max_element() + 2.0 * ROAM as f32;
        Aabb::from_half_extents(center, reach + Vec3::splat(1e-6 * size))
    }

    /// Whether a camera at `anchor` is close enough to the frame's origin.
    pub(crate) fn serves(&self, anchor: DVec3) -> bool {
        (anchor - self.frame).abs().max_element() <= ROAM
    }

    /// Notes the rows that are not where the tree has them; the first of `rows` has the number `from`.
    pub(crate) fn note(&mut self, from: usize, rows: Rows<'_>, alpha: f64) {
        let all = from..from + rows.transforms.len();
        let mut next = 0;
        loop {
            let (x, y, z) = (&self.x[all.clone()], &self.y[all.clone()], &self.z[all.clone()]);
            let known = Known { frame: self.frame, x, y, z };
            let Some(span) = next_moved(known, rows, alpha, next) else { break };
            for row in span * SPAN..rows.transforms.len().min((span + 1) * SPAN) {
                let at = from + row;
                let is = (rows.drawn(row, alpha) - self.frame).as_vec3();
                if differs(is, (&self.x[at], &self.y[at], &self.z[at])) {
                    (self.x[at], self.y[at], self.z[at]) = (is.x, is.y, is.z);
                    self.moved.push(at as u32);
                }
            }
            next = span + 1;
        }
    }

    /// Brings the tree up to date with the noted rows if that is cheaper than scanning `rays` rays. Returns false if it
    /// is not: the tree must then be dropped.
    pub(crate) fn follow(&mut self, rays: u32) -> bool {
        if self.moved.len() > cost::most_moved_for_tree(self.x.len(), rays) {
            return false;
        }
        let mut moved = std::mem::take(&mut self.moved);
        if moved.len() as f64 * cost::REINSERT <= self.x.len() as f64 * cost::REFIT {
            for &row in &moved {
                let leaf = self.leaf(row as usize);
                let _ = self.bvh.reinsert_or_update_with_change_detection(leaf, row, 0.0);
            }
        } else if self.refitted == REFITS_BEFORE_REBUILD {
            self.rebuild();
        } else {
            for &row in &moved {
                let leaf = self.leaf(row as usize);
                let _ = self.bvh.insert_or_update_partially(leaf, row, 0.0);
            }
            self.bvh.refit_without_opt();
            self.refitted += 1;
        }
        moved.clear();
        self.moved = moved;
        true
    }

    /// Calls `visit(row, limit)` for the rows whose boxes the ray meets, nearer boxes first; what it returns is
    /// the new limit. `None` if the ray starts too far from the frame for the boxes to be reliable.
    pub(crate) fn walk(&self, ray: &Ray, visit: impl Fn(usize, f32) -> f32) -> Option<()> {
        let origin = ray.origin() - self.frame;
        if origin.abs().max_element() > 2.0 * ROAM {
            return None;
        }
        let ray = LocalRay::new(origin.as_vec3(), ray.direction().as_vec3());
        let limit = Cell::new(f32::MAX);
        self.bvh.cast_ray(&ray, f32::MAX, |row, _| {
            let closer = visit(row as usize, limit.get());
            (closer < limit.replace(closer)).then_some(closer)
        });
        Some(())
    }
}
