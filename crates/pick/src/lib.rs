//! Rays through pixels and the closest thing they hit, tested against the poses that are drawn.
//!
//! [`Viewpoint`] turns a pixel into a [`Ray`], [`Targets`] holds the drawn poses of one frame and answers
//! [`Targets::cast`]; [`SoftTargets`] does the same for soft bodies. The shapes and the exact tests are parry3d's.
//!
//! # Does not include
//!
//! Contacts, sweeps, several hits along a ray, layers, or shapes other than boxes, spheres and soft bodies.

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

pub use ray::{Ray, RayError};
pub use shape::{Shape, ShapeError};
pub use soft::{SoftHit, SoftPoint, SoftPose, SoftTargets};
pub use targets::{Chunk, Hit, Targets};
pub use view::Viewpoint;
