//! Random draws that are the same on every machine: they use no function that differs between platforms.

use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64;

/// A number from -1 up to 1.
pub(crate) fn symmetric(random: &mut Pcg64) -> f64 {
    2.0 * random.random::<f64>() - 1.0
}

/// A uniformly drawn unit vector (Marsaglia 1972).
pub(super) fn direction(random: &mut Pcg64) -> DVec3 {
    in_cone(random, 1.0)
}

/// A uniformly drawn unit vector in a cone about z. `sine_of_half` is the sine of half the cone's half angle, 0 to 1:
/// Marsaglia's map takes the disc of that radius to the cone, and equal areas to equal areas.
pub(super) fn in_cone(random: &mut Pcg64, sine_of_half: f64) -> DVec3 {
    let (a, b) = in_disc(random);
    let (a, b) = (a * sine_of_half, b * sine_of_half);
    let s = a * a + b * b;
    let scale = 2.0 * (1.0 - s).sqrt();
    DVec3::new(a * scale, b * scale, 1.0 - 2.0 * s)
}

/// A uniformly drawn point inside the sphere of radius 1.
pub(super) fn in_ball(random: &mut Pcg64) -> DVec3 {
    loop {
        let place = DVec3::new(symmetric(random), symmetric(random), symmetric(random));
        if place.length_squared() < 1.0 {
            return place;
        }
    }
}

/// A point inside the circle of radius 1.
fn in_disc(random: &mut Pcg64) -> (f64, f64) {
    loop {
        let (a, b) = (symmetric(random), symmetric(random));
        if a * a + b * b < 1.0 {
            return (a, b);
        }
    }
}
