//! The camera of a picture: pixels to rays and points to pixels.

use glam::dcamera::rh::proj::opengl::perspective;
use glam::{DMat4, DQuat, DVec2, DVec3};

use crate::Ray;

/// A perspective camera. It looks along its own -Z with +Y up and +X right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// Position of the eye, world space, m.
    pub position: DVec3,
    /// Camera space to world space.
    pub orientation: DQuat,
    /// Vertical opening angle, rad, above 0 and below pi.
    pub fov_y_rad: f64,
    /// Distance of the near plane, m, above 0.
    pub near_m: f64,
    /// Distance of the far plane, m, above the near plane's.
    pub far_m: f64,
}

impl Viewpoint {
    /// A camera that is turned by `yaw_deg` about +Y and, before that, by `pitch_deg` about +X; an upright
    /// camera with both at 0 looks along -Z.
    ///
    /// The order is that of the tutorial's camera: its view is inverse(translate * yaw * pitch).
    #[must_use]
    pub fn from_pitch_yaw(
        position: DVec3,
        pitch_deg: f64,
        yaw_deg: f64,
        fov_y_rad: f64,
        near_m: f64,
        far_m: f64,
    ) -> Self {
        let yaw = DQuat::from_rotation_y(yaw_deg.to_radians());
        let pitch = DQuat::from_rotation_x(pitch_deg.to_radians());
        Self { position, orientation: yaw * pitch, fov_y_rad, near_m, far_m }
    }

    /// Direction in which the camera looks, of unit length.
    #[must_use]
    pub fn forward(&self) -> DVec3 {
        self.orientation * DVec3::NEG_Z
    }

    /// Direction to the right in the picture, of unit length.
    #[must_use]
    pub fn right(&self) -> DVec3 {
        self.orientation * DVec3::X
    }

    /// Direction up in the picture, of unit length.
    #[must_use]
    pub fn up(&self) -> DVec3 {
        self.orientation * DVec3::Y
    }

    /// The ray from the eye through `pixel` (from the top left corner, physical pixels; whole numbers are the
    /// pixels' corners) of a picture of `size_px`.
    ///
    /// It starts at the eye, not at the near plane, and the far plane does not end it. If there is no such ray, as for a
    /// minimized window of 0 by 0 pixels, it is the ray straight ahead.
    #[must_use]
    pub fn ray_through(&self, pixel: DVec2, size_px: DVec2) -> Ray {
        // Two points on the ray, as the tutorial does it: exactly on the planes is where a hardware matrix
        // could divide by zero.
        let ndc = DVec2::new(2.0, -2.0) * pixel / size_px + DVec2::new(-1.0, 1.0);
        let unproject = self.projection(size_px).inverse();
        let near = unproject.project_point3(ndc.extend(-0.99999));
        let far = unproject.project_point3(ndc.extend(0.99999));
        self.ray_along(far - near).unwrap_or_else(|| self.ray_ahead())
    }

    /// The position of the world point `point` (m) in a picture of `size_px`, in pixels from the top left corner; `None` if
    /// the point is not in front of the camera.
    #[must_use]
    pub fn project(&self, point: DVec3, size_px: DVec2) -> Option<DVec2> {
        let seen = self.orientation.inverse() * (point - self.position);
        if seen.z >= 0.0 {
            return None;
        }
        let ndc = self.projection(size_px).project_point3(seen).truncate();
        let pixel = (ndc * DVec2::new(0.5, -0.5) + 0.5) * size_px;
        pixel.is_finite().then_some(pixel)
    }

    fn projection(&self, size_px: DVec2) -> DMat4 {
        perspective(self.fov_y_rad, size_px.x / size_px.y, self.near_m, self.far_m)
    }

    fn ray_along(&self, in_camera_space: DVec3) -> Option<Ray> {
        // The position stays out of the matrices, so that a camera 100 km away aims as well as one at 0.
        Ray::new(self.position, self.orientation * in_camera_space).ok()
    }

    fn ray_ahead(&self) -> Ray {
        Ray::new(self.position, self.forward())
            .or_else(|_| Ray::new(DVec3::ZERO, DVec3::NEG_Z))
            .expect("the second ray is made of constants")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: DVec2 = DVec2::new(1280.0, 720.0);

    fn tutorial_start() -> Viewpoint {
        let eye = DVec3::new(-60.0, 40.0, 60.0);
        Viewpoint::from_pitch_yaw(eye, -15.0, 315.0, 45.0_f64.to_radians(), 0.1, 500.0)
    }

    const CHECK_PIXELS: [(DVec3, DVec2); 6] = [
        (DVec3::new(0.0, 10.0, 0.0), DVec2::new(640.00, 427.96)),
        (DVec3::new(14.0, 10.0, 14.0), DVec2::new(831.78, 427.96)),
        (DVec3::new(0.0, 10.0, 14.0), DVec2::new(747.33, 463.85)),
        (DVec3::new(14.0, 10.0, 0.0), DVec2::new(726.65, 398.99)),
        (DVec3::new(0.0, 5.0, 0.0), DVec2::new(640.00, 473.11)),
        (DVec3::new(10.0, 5.0, 0.0), DVec2::new(702.81, 448.96)),
    ];

    #[test]
    fn the_start_camera_looks_where_the_tutorials_looks() {
        let view = tutorial_start();
        assert!(
            view.forward().abs_diff_eq(DVec3::new(0.6830, -0.2588, -0.6830), 5e-5),
            "{}",
            view.forward()
        );
        assert!(
            view.right().abs_diff_eq(DVec3::new(0.5, 0.0, 0.5).normalize(), 5e-5),
            "{}",
            view.right()
        );
        assert!(view.up().dot(DVec3::Y) > 0.9);
    }

    #[test]
    fn points_of_the_tutorial_scene_land_on_its_check_pixels() {
        for (point, pixel) in CHECK_PIXELS {
            let seen = tutorial_start().project(point, SIZE).unwrap();
            assert!(seen.abs_diff_eq(pixel, 0.01), "{point} is seen at {seen}, not at {pixel}");
        }
    }

    #[test]
    fn the_ray_through_a_points_pixel_passes_the_point_also_100_km_away() {
        for offset in [DVec3::ZERO, DVec3::new(1e5, -1e5, 1e5)] {
            for (point, _) in CHECK_PIXELS {
                let mut view = tutorial_start();
                view.position += offset;
                let target = point + offset;
                let ray = view.ray_through(view.project(target, SIZE).unwrap(), SIZE);
                assert_eq!(ray.origin(), view.position);
                assert!((ray.direction().length() - 1.0).abs() < 1e-12);
                let miss = (target - ray.origin()).cross(ray.direction()).length();
                assert!(miss < 1e-6, "{target} missed by {miss} m");
            }
        }
    }

    #[test]
    fn a_point_behind_the_camera_has_no_pixel() {
        let view = tutorial_start();
        assert_eq!(view.project(view.position - view.forward(), SIZE), None);
        assert_eq!(view.project(view.position, SIZE), None);
        assert!(view.project(view.position + view.forward(), SIZE).is_some());
    }

    #[test]
    fn a_picture_without_pixels_has_the_ray_straight_ahead() {
        let view = tutorial_start();
        for size in [DVec2::ZERO, DVec2::new(0.0, 720.0), DVec2::NAN] {
            let ray = view.ray_through(DVec2::ZERO, size);
            assert!(ray.direction().abs_diff_eq(view.forward(), 1e-12), "{size}");
        }
    }
}
