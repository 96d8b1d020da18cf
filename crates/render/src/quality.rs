//! How much work a picture may cost.

use crate::AdapterSummary;

/// Trade-offs between speed and looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Side of the square shadow map, pixels; limited to what the adapter supports.
    pub shadow_map_px: u32,
    /// Meridians of a sphere, at least 3: with n of them its outline deviates from a circle by 5 / n² of the radius.
    /// If there are many spheres, the small ones have fewer.
    pub sphere_meridians: u16,
    /// Samples per pixel: 1, or 4 for smooth edges; 1 if the adapter does not support 4.
    pub msaa: u32,
}

/// Largest deviation of the outline of a small sphere from a circle, pixels.
const STRAYS_PX: f32 = 0.5;

/// Memory of a device in software, bytes: mostly its compiled shaders.
const DEVICE: u64 = 124 << 20;

impl Quality {
    /// The same on every machine, for stored reference pictures.
    pub const FIXED: Self = Self { shadow_map_px: 1024, sphere_meridians: 15, msaa: 1 };

    /// Smooth edges, round balls and fine shadows: for hardware, and for software if a picture may take its time.
    pub const HIGH: Self = Self { shadow_map_px: 4096, sphere_meridians: 48, msaa: 4 };

    /// The quality for an adapter: four samples quadruple the time of a frame in software and cost little in
    /// hardware.
    pub fn for_adapter(adapter: &AdapterSummary) -> Self {
        if adapter.software { Self::FIXED } else { Self::HIGH }
    }

    /// Most memory for drawing pictures of this size on a device in software, bytes, measured with llvmpipe (Mesa
    /// 22): the device itself, the shadow map, and for every pixel its color, its depth, two copies to read it, and
    /// its samples.
    #[must_use]
    pub fn device_bytes(&self, [width, height]: [u32; 2]) -> u64 {
        let of_pixel = 16 + if self.msaa > 1 { 12 * u64::from(self.msaa) } else { 0 };
        let shadow_map = 4 * u64::from(self.shadow_map_px).pow(2);
        DEVICE + shadow_map + of_pixel * u64::from(width) * u64::from(height)
    }

    /// Meridians of a small sphere.
    pub(crate) fn small_sphere_meridians(&self) -> u16 {
        (self.sphere_meridians * 2 / 3).max(3)
    }

    /// Radius below which a sphere is small, pixels.
    pub(crate) fn small_sphere_px(&self) -> f32 {
        STRAYS_PX * f32::from(self.small_sphere_meridians()).powi(2) / 5.0
    }
}
