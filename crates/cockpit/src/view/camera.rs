//! The tutorial's camera: flies level by yaw, looks by mouse, follows the selection when locked.

use glam::{DVec2, DVec3};
use pick::Viewpoint;
use scene::CameraSpec;

/// Turn of the camera per count of the mouse, degrees.
const DEGREES_PER_COUNT: f64 = 0.07;

/// Flying speed, m/s, of a camera that is as far from its scene as the tutorial's.
const SPEED: f64 = 100.0;

/// Offset of a locked camera from the body that it looks at, m.
const LOCKED_OFFSET: DVec3 = DVec3::new(0.0, 14.0, 20.0);

/// Nearest distance that is drawn, as a part of that to what is looked at.
const NEAR: f64 = 0.1;

/// The camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    start: CameraSpec,
    /// Flying speed, m/s.
    speed: f64,
    /// Nearest distance that is drawn, m.
    near_m: f64,
    /// Eye, m.
    pub position: DVec3,
    /// Turn about the right axis, degrees in [-90, 90].
    pub pitch: f64,
    /// Turn about the vertical, degrees in [0, 360).
    pub yaw: f64,
}

impl Camera {
    /// The camera of a scene.
    #[must_use]
    pub fn new(start: CameraSpec) -> Self {
        let yaw = start.yaw_deg.rem_euclid(360.0);
        let (near_m, position, pitch) = (start.near, start.position, start.pitch_deg);
        Self { start, speed: SPEED, near_m, position, pitch, yaw }
    }

    /// The same camera, with a speed at which it flies to a scene `distance` meters away in about a second: 1, 2 or 5 m/s times a
    /// power of ten.
    #[must_use]
    pub fn at_distance(self, distance: f64) -> Self {
        let decade = 10_f64.powf(distance.log10().floor());
        let speed = [1.0, 2.0, 5.0, 10.0].map(|step| step * decade);
        let off = |speed: &f64| (speed / distance).ln().abs();
        let nearest = speed.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        Self { speed: nearest.filter(|speed| speed.is_normal()).unwrap_or(SPEED), ..self }
    }

    /// Flying speed, m/s.
    #[must_use]
    pub const fn speed(&self) -> f64 {
        self.speed
    }

    /// Puts the camera back to where the scene put it.
    pub fn reset(&mut self) {
        *self = Self { speed: self.speed, ..Self::new(self.start) };
    }

    /// Draws what is seen from a distance in meters, however small it is.
    pub fn draw_from(&mut self, distance: f64) {
        self.near_m = self.start.near.min(NEAR * distance);
    }

    /// Turns the camera by counts of the mouse, right and down.
    pub fn look(&mut self, right: f64, down: f64) {
        self.yaw = (self.yaw - right * DEGREES_PER_COUNT).rem_euclid(360.0);
        self.pitch = (self.pitch - down * DEGREES_PER_COUNT).clamp(-90.0, 90.0);
    }

    /// Turns around `pivot`, m, which stays where it is seen, by degrees to the right and down.
    pub fn orbit(&mut self, pivot: DVec3, degrees: DVec2) {
        let away = self.viewpoint().orientation.inverse() * (self.position - pivot);
        self.yaw = (self.yaw - degrees.x).rem_euclid(360.0);
        self.pitch = (self.pitch - degrees.y).clamp(-90.0, 90.0);
        self.position = pivot + self.viewpoint().orientation * away;
    }

    /// Flies for `seconds` along held directions: right, up and forward, each -1, 0 or 1. Forward and right are
    /// level, whatever the pitch, and a diagonal is not slowed down.
    pub fn fly(&mut self, held: DVec3, seconds: f64) {
        let (sin, cos) = self.yaw.to_radians().sin_cos();
        let (right, forward) = (DVec3::new(cos, 0.0, -sin), DVec3::new(-sin, 0.0, -cos));
        self.position +=
            (right * held.x + DVec3::Y * held.y + forward * held.z) * self.speed * seconds;
    }

    /// Puts the camera behind and above `body`, m, looking at it.
    pub fn follow(&mut self, body: DVec3) {
        self.position = body + LOCKED_OFFSET;
        self.yaw = 0.0;
        self.pitch = -LOCKED_OFFSET.y.atan2(LOCKED_OFFSET.z).to_degrees();
    }

    /// The camera as rays and pictures need it.
    #[must_use]
    pub fn viewpoint(&self) -> Viewpoint {
        let CameraSpec { fov_y_deg, far, .. } = self.start;
        Viewpoint::from_pitch_yaw(
            self.position,
            self.pitch,
            self.yaw,
            fov_y_deg.to_radians(),
            self.near_m,
            far,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flying_is_level_and_follows_the_yaw() {
        let mut camera = Camera::new(CameraSpec::TUTORIAL);
        camera.fly(DVec3::Z, 0.5);
        let moved = camera.position - CameraSpec::TUTORIAL.position;
        let half = std::f64::consts::FRAC_1_SQRT_2 * 50.0;
        assert!((moved - DVec3::new(half, 0.0, -half)).length() < 1e-12);
        camera.reset();
        camera.fly(DVec3::new(1.0, 1.0, 0.0), 1.0);
        let moved = camera.position - CameraSpec::TUTORIAL.position;
        assert!((moved - DVec3::new(2.0 * half, 100.0, 2.0 * half)).length() < 1e-12);
    }

    #[test]
    fn it_flies_to_its_scene_in_about_a_second_and_at_a_round_speed() {
        let camera = Camera::new(CameraSpec::TUTORIAL);
        for (distance, speed) in
            [(94.0, 100.0), (1.1, 1.0), (1.5, 2.0), (7.2, 10.0), (40.0, 50.0), (3e5, 2e5)]
        {
            let found = camera.at_distance(distance).speed();
            assert!((found / speed - 1.0).abs() < 1e-12, "{distance} m: {found} m/s");
        }
        for distance in [0.0, f64::INFINITY, f64::NAN] {
            assert_eq!(camera.at_distance(distance), camera);
        }
        let mut slow = camera.at_distance(1.0);
        slow.reset();
        assert_eq!(slow, camera.at_distance(1.0));
    }

    #[test]
    fn the_look_is_clamped_in_pitch_and_wrapped_in_yaw() {
        let mut camera = Camera::new(CameraSpec::TUTORIAL);
        camera.look(-1000.0, -10_000.0);
        assert_eq!((camera.pitch, camera.yaw), (90.0, 25.0));
    }

    #[test]
    fn a_locked_camera_looks_at_the_body() {
        let mut camera = Camera::new(CameraSpec::TUTORIAL);
        let body = DVec3::new(3.0, -50.0, 7.0);
        camera.follow(body);
        assert!((camera.pitch + 34.992).abs() < 1e-3);
        let view = camera.viewpoint();
        assert!((view.forward() - (body - view.position).normalize()).length() < 1e-12);
    }
}
