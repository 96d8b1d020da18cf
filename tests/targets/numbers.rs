//! Numbers that a person might write, and those that no one should.

use arbitrary::{Result, Unstructured};
use glam::DVec3;

/// The edges of double precision, and of what a square of it is.
const EDGES: &[f64] = &[
    0.0,
    -0.0,
    5e-324,
    1e-310,
    2.3e-308,
    1e-160,
    1e-30,
    1e-9,
    1e9,
    1e20,
    1e30,
    1e100,
    1.3e154,
    1e155,
    1e200,
    1e300,
    f64::MAX,
];

/// Numbers that are none.
const NONE: &[f64] = &[f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

/// A finite number, of everyday size as a rule.
pub fn finite(u: &mut Unstructured<'_>) -> Result<f64> {
    if u.ratio(1, 8)? {
        let edge = *u.choose(EDGES)?;
        return Ok(if u.ratio(1, 2)? { -edge } else { edge });
    }
    Ok(f64::from(u.int_in_range(-800..=800)?) / 8.0)
}

/// A finite number that is not below 0.
pub fn at_least_0(u: &mut Unstructured<'_>) -> Result<f64> {
    Ok(finite(u)?.abs())
}

/// Any number.
pub fn any(u: &mut Unstructured<'_>) -> Result<f64> {
    if u.ratio(1, 6)? { Ok(*u.choose(NONE)?) } else { finite(u) }
}

/// A finite vector.
pub fn vector(u: &mut Unstructured<'_>) -> Result<DVec3> {
    Ok(DVec3::new(finite(u)?, finite(u)?, finite(u)?))
}

/// A vector of any numbers, which are finite more often than not.
pub fn any_vector(u: &mut Unstructured<'_>) -> Result<DVec3> {
    if u.ratio(2, 3)? { vector(u) } else { Ok(DVec3::new(any(u)?, any(u)?, any(u)?)) }
}

/// A vector as scene files and scripts have it.
pub fn written(v: DVec3) -> String {
    format!("({:?}, {:?}, {:?})", v.x, v.y, v.z)
}
