//! The scalar and vector of the simulation, decided once.

/// Number type of all simulated state: SI units, 53 bits of precision.
pub type Scalar = f64;
/// Vector of [`Scalar`]s, right-handed, y up.
pub type Vector = glam::DVec3;
/// Rotation of a body, for drawing and picking only: the physics never reads it.
pub type Rotation = glam::DQuat;

/// The matrix `a b^T`.
#[must_use]
pub fn outer(a: Vector, b: Vector) -> glam::DMat3 {
    glam::DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Checks that `value` of the quantity `what`, in `unit`, is at least 0. NaN passes: bodies that it reaches are quarantined
/// with a record that names it.
///
/// # Panics
/// If it is below 0.
pub(crate) fn at_least_0(value: Scalar, what: &str, unit: &str) {
    assert!(
        value >= 0.0 || value.is_nan(),
        "{what} cannot be {value} {unit}; give one of at least 0 {unit}"
    );
}
