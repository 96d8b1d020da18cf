//! Rays through pixels and the closest thing that they hit, tested against the poses that are drawn.
//!
//! - [`Viewpoint`]: a camera; pixels to rays and points to pixels.
//! - [`Ray`] and [`Shape`]: a half-line, and what it can hit.
//! - [`Targets`]: the drawn poses of one frame; [`Targets::cast`] finds the closest [`Hit`]. `scan` goes through all of them in
//!   blocks, `bvh` is the tree for many, `columns` holds the positions, and `exact` is parry3d's test of one shape.
//! - [`SoftTargets`]: the same for the surfaces, points and springs of soft bodies.
//! - `dispatch`: compiles hot loops with and without AVX2.
//!
//! Does not include: contacts, sweeps, several hits along a ray, layers, or shapes other than boxes, spheres and soft bodies.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test"))]

mod bvh;
mod columns;
mod dispatch;
mod exact;
mod ray;
mod scan;
mod shape;
mod soft;
mod targets;
mod view;

pub use ray::{Drawn, Ray, RayError};
pub use shape::{Shape, ShapeError};
pub use soft::{BladeSurface, Blades, SoftHit, SoftPoint, SoftPose, SoftTargets};
pub use targets::{Chunk, Hit, Targets};
pub use view::Viewpoint;
