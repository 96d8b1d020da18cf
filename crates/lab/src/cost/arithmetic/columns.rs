//! The states of bodies in columns of numbers, and a step of every body over them.

use glam::DVec3;

/// x, y and z of every body.
pub(super) type Columns = [Vec<f64>; 3];

pub(super) fn push(columns: &mut Columns, vector: DVec3) {
    columns.iter_mut().zip(vector.to_array()).for_each(|(column, number)| column.push(number));
}

pub(super) fn get([x, y, z]: &Columns, i: usize) -> DVec3 {
    DVec3::new(x[i], y[i], z[i])
}

/// Replaces position and velocity of every body by those that `step` returns, which also gets `field`. Returns the field.
pub(super) fn each<F>(
    [[x, y, z], [vx, vy, vz]]: [&mut Columns; 2],
    field: F,
    step: impl Fn(&mut F, [DVec3; 2]) -> [DVec3; 2],
) -> F {
    let step = |field: &mut F, body: [[f64; 3]; 2]| {
        step(field, body.map(DVec3::from_array)).map(|vector| vector.to_array())
    };
    step_six(x, y, z, vx, vy, vz, field, step)
}

/// Replaces position, velocity and acceleration of every body, as [`each`] does.
pub(super) fn each_with<F>(
    [[x, y, z], [vx, vy, vz], [ax, ay, az]]: [&mut Columns; 3],
    field: F,
    step: impl Fn(&mut F, [DVec3; 3]) -> [DVec3; 3],
) -> F {
    let step = |field: &mut F, body: [[f64; 3]; 3]| {
        step(field, body.map(DVec3::from_array)).map(|vector| vector.to_array())
    };
    step_nine(x, y, z, vx, vy, vz, ax, ay, az, field, step)
}

/// A step of every body, whose position and velocity are three numbers each.
///
/// The six arrays are six arguments of a function that is not inlined, so the compiler knows that they do not
/// overlap; the field is moved in and out, so that it stays in registers. Otherwise vectorization would depend on
/// luck.
#[expect(
    clippy::too_many_arguments,
    reason = "an argument is known not to overlap with another one"
)]
#[inline(never)]
fn step_six<F>(
    x: &mut [f64],
    y: &mut [f64],
    z: &mut [f64],
    vx: &mut [f64],
    vy: &mut [f64],
    vz: &mut [f64],
    mut field: F,
    step: impl Fn(&mut F, [[f64; 3]; 2]) -> [[f64; 3]; 2],
) -> F {
    let n = x.len();
    let (y, z, vx, vy, vz) = (&mut y[..n], &mut z[..n], &mut vx[..n], &mut vy[..n], &mut vz[..n]);
    for i in 0..n {
        [[x[i], y[i], z[i]], [vx[i], vy[i], vz[i]]] =
            step(&mut field, [[x[i], y[i], z[i]], [vx[i], vy[i], vz[i]]]);
    }
    field
}

/// [`step_six`] for nine arrays: the last three are accelerations.
#[expect(
    clippy::too_many_arguments,
    reason = "an argument is known not to overlap with another one"
)]
#[inline(never)]
fn step_nine<F>(
    x: &mut [f64],
    y: &mut [f64],
    z: &mut [f64],
    vx: &mut [f64],
    vy: &mut [f64],
    vz: &mut [f64],
    ax: &mut [f64],
    ay: &mut [f64],
    az: &mut [f64],
    mut field: F,
    step: impl Fn(&mut F, [[f64; 3]; 3]) -> [[f64; 3]; 3],
) -> F {
    let n = x.len();
    let (y, z, vx, vy, vz) = (&mut y[..n], &mut z[..n], &mut vx[..n], &mut vy[..n], &mut vz[..n]);
    let (ax, ay, az) = (&mut ax[..n], &mut ay[..n], &mut az[..n]);
    for i in 0..n {
        [[x[i], y[i], z[i]], [vx[i], vy[i], vz[i]], [ax[i], ay[i], az[i]]] =
            step(&mut field, [[x[i], y[i], z[i]], [vx[i], vy[i], vz[i]], [ax[i], ay[i], az[i]]]);
    }
    field
}
