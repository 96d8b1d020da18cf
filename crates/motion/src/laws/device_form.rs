//! The formulas by which a graphics device evaluates laws, with their numbers.

use super::{Affine, Drag, Well};

/// The formula of a law among those of `shaders/swarm_step.wgsl`, for particles that a graphics device integrates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeviceForm<'a> {
    /// `a = constant - rate v`.
    Affine(Affine),
    /// Drag that is not affine.
    Drag(&'a Drag),
    /// Points that attract or repel.
    Wells(&'a [Well]),
}
