//! The scan: which blocks of targets have a bounding ball that a ray meets, in f32 and many lanes at once.

use glam::{DVec3, Vec3};

use crate::Ray;
use crate::dispatch::dispatched;

/// Number of targets in a block. 32 lanes are a few vectors; more would only re-test more targets one by one after a match.
pub(crate) const BLOCK: usize = 32;

/// Margin by which the test favors a match, per square meter of squared distance (c² and b² below).
///
/// c² comes with 3 roundings of 2^-24, b² with some 8; this is 4 times their sum of 7e-7, since a miss here would be
/// a wrong answer. Its cost: everything within 1.7 mrad of the ray, about a pixel, is tested exactly, 20 ns each.
const SLACK: f32 = 3e-6;

/// Factor by which stored bounding balls are enlarged, for the comparisons along the ray.
pub(crate) const INFLATION: f32 = 1.0 + 2e-6;

/// Bounding balls as structure of arrays, each array a whole number of blocks long.
#[derive(Clone, Copy)]
pub(crate) struct Balls<'a> {
    pub(crate) x: &'a [[f32; BLOCK]],
    pub(crate) y: &'a [[f32; BLOCK]],
    pub(crate) z: &'a [[f32; BLOCK]],
    pub(crate) radius: &'a [[f32; BLOCK]],
}

/// A ray in f32, relative to the anchor of the balls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    origin: Vec3,
    direction: Vec3,
    slack: f32,
}

dispatched!(
    next_block(beam: &Beam, balls: Balls<'_>, from: usize, limit: f32) -> Option<usize>,
    Beam::next_block
);

impl Beam {
    pub(crate) fn new(ray: &Ray, anchor: DVec3) -> Self {
        let origin = (ray.origin() - anchor).as_vec3();
        // Subtracting the origin adds a rounding error of its size, which the slack per distance from it does not cover.
        Self {
            origin,
            direction: ray.direction().as_vec3(),
            slack: SLACK * origin.length_squared(),
        }
    }

    /// Whether the ball may be met at less than `limit` m. May be true wrongly, never false.
    ///
    /// For a center c, at b along the ray, it compares c² - b² with r²; in f32 the difference is noise for far centers,
    /// which the slack covers.
    #[inline(always)]
    fn may_meet(&self, x: f32, y: f32, z: f32, radius: f32, limit: f32) -> bool {
        let (x, y, z) = (x - self.origin.x, y - self.origin.y, z - self.origin.z);
        let along = x * self.direction.x + y * self.direction.y + z * self.direction.z;
        let off = (x * x + y * y + z * z) * (1.0 - SLACK) - along * along;
        // `&`, not `&&`: a branch would end the vectorization.
        (off <= radius * radius + self.slack)
            & (along + radius >= 0.0)
            & (along - radius <= limit * INFLATION)
    }

    /// The first block at or after `from` in which a ball may be met at less than `limit` m.
    #[inline(always)]
    fn next_block(&self, balls: Balls<'_>, from: usize, limit: f32) -> Option<usize> {
        let blocks =
            balls.x.iter().zip(balls.y).zip(balls.z).zip(balls.radius).enumerate().skip(from);
        for (block, (((x, y), z), radius)) in blocks {
            // An integer count: LLVM vectorizes its sum, but not a float maximum.
            let mut matches = 0_u32;
            for lane in 0..BLOCK {
                matches += u32::from(self.may_meet(x[lane], y[lane], z[lane], radius[lane], limit));
            }
            if matches != 0 {
                return Some(block);
            }
        }
        None
    }

    /// Calls `visit(index, limit)` for every target whose ball may be met; what it returns is the new limit.
    #[inline]
    pub(crate) fn scan(
        &self,
        balls: Balls<'_>,
        mut limit: f32,
        mut visit: impl FnMut(usize, f32) -> f32,
    ) {
        let mut next = 0;
        while let Some(block) = next_block(self, balls, next, limit) {
            let (x, y, z, radius) =
                (&balls.x[block], &balls.y[block], &balls.z[block], &balls.radius[block]);
            for lane in 0..BLOCK {
                if self.may_meet(x[lane], y[lane], z[lane], radius[lane], limit) {
                    limit = visit(block * BLOCK + lane, limit);
                }
            }
            next = block + 1;
        }
    }
}
