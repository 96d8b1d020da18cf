//! The swap chain of a window: resizing, minimizing, and getting over a lost surface.

use wgpu::{CurrentSurfaceTexture, Surface, SurfaceConfiguration, SurfaceTexture, TextureFormat};

use crate::gpu::caught;
use crate::{Gpu, RenderError};

/// A window's surface, always configured for the window's size.
pub struct WindowTarget {
    surface: Surface<'static>,
    config: SurfaceConfiguration,
    view_format: TextureFormat,
    /// A minimized window has no area, and a surface must not be configured without one.
    visible: bool,
    lost: bool,
}

/// One picture of the window, to be drawn and then presented.
pub struct WindowFrame {
    texture: SurfaceTexture,
    view: wgpu::TextureView,
}

impl WindowFrame {
    /// The view to draw into.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Width and height in pixels, required of [`crate::Frame::size_px`].
    pub fn size_px(&self) -> [u32; 2] {
        let size = self.texture.texture.size();
        [size.width, size.height]
    }

    /// Shows the picture. With winit, call `Window::pre_present_notify` just before.
    pub fn present(self, gpu: &Gpu) {
        gpu.queue.present(self.texture);
    }
}

impl WindowTarget {
    /// Configures the surface for a window of inner size `size_px`, which may be zero.
    pub fn new(
        surface: Surface<'static>,
        gpu: &Gpu,
        size_px: [u32; 2],
    ) -> Result<Self, RenderError> {
        let (config, view_format) = configuration(&surface, gpu, size_px)?;
        let mut target = Self { surface, config, view_format, visible: false, lost: false };
        target.resize(gpu, size_px);
        Ok(target)
    }

    /// The format that the renderer has to be made for. It is an sRGB format only if the system insists on one, so
    /// that a window shows the bytes of a headless picture.
    pub fn format(&self) -> TextureFormat {
        self.view_format
    }

    /// Takes the window's new inner size in pixels; zero, as of a minimized window, stops the pictures until the
    /// next size.
    pub fn resize(&mut self, gpu: &Gpu, size_px: [u32; 2]) {
        self.visible = size_px[0] > 0 && size_px[1] > 0;
        if self.visible {
            let [width, height] = size_px.map(|side| side.min(gpu.max_side_px()));
            self.config.width = width;
            self.config.height = height;
            self.configure(gpu);
        }
    }

    /// The next picture; `None` if this frame has to be skipped: the window is minimized, hidden or busy, or its
    /// surface is [`lost`](Self::lost).
    pub fn acquire(&mut self, gpu: &Gpu) -> Option<WindowFrame> {
        if !self.visible {
            return None;
        }
        for attempt in 0..2 {
            // Requesting a texture from a surface that is not configured panics.
            if self.lost {
                return None;
            }
            match self.surface.get_current_texture() {
                CurrentSurfaceTexture::Success(texture) => return Some(self.frame(texture)),
                CurrentSurfaceTexture::Suboptimal(texture) => {
                    if attempt == 1 {
                        return Some(self.frame(texture));
                    }
                    // Configuring while a texture of the surface is alive panics.
                    drop(texture);
                    self.configure(gpu);
                }
                CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Lost => {
                    self.lost = attempt == 1;
                    self.configure(gpu);
                }
                CurrentSurfaceTexture::Timeout
                | CurrentSurfaceTexture::Occluded
                | CurrentSurfaceTexture::Validation => return None,
            }
        }
        None
    }

    /// Configures the surface. One that cannot be configured is lost, for example because its display has ended.
    fn configure(&mut self, gpu: &Gpu) {
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        self.surface.configure(&gpu.device, &self.config);
        self.lost |= caught(scope).is_some();
    }

    /// Whether configuring did not bring the surface back: make another with [`Gpu::surface`] and pass it to
    /// [`WindowTarget::replace_surface`].
    pub fn lost(&self) -> bool {
        self.lost
    }

    /// Takes a new surface of the same window in place of a lost one.
    pub fn replace_surface(&mut self, gpu: &Gpu, surface: Surface<'static>) {
        self.surface = surface;
        self.lost = false;
        self.resize(gpu, [self.config.width, self.config.height]);
    }

    fn frame(&mut self, texture: SurfaceTexture) -> WindowFrame {
        self.lost = false;
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor {
            format: Some(self.view_format),
            ..Default::default()
        });
        WindowFrame { texture, view }
    }
}

fn configuration(
    surface: &Surface<'_>,
    gpu: &Gpu,
    size_px: [u32; 2],
) -> Result<(SurfaceConfiguration, TextureFormat), RenderError> {
    let unusable = || RenderError::Surface { detail: format!("{} does not support it", gpu.info) };
    let mut config = surface
        .get_default_config(&gpu.adapter, size_px[0].max(1), size_px[1].max(1))
        .ok_or_else(unusable)?;
    let formats = surface.get_capabilities(&gpu.adapter).formats;
    let eight_bit = |format: &TextureFormat| {
        matches!(format.remove_srgb_suffix(), TextureFormat::Rgba8Unorm | TextureFormat::Bgra8Unorm)
    };
    let unorm = formats.iter().find(|format| eight_bit(format) && !format.is_srgb());
    let srgb = formats.iter().find(|format| eight_bit(format));
    let mut view_format = config.format;
    if let Some(&format) = unorm.or(srgb) {
        config.format = format;
        view_format = format;
        let capabilities = gpu.adapter.get_downlevel_capabilities();
        if format.is_srgb()
            && capabilities.flags.contains(wgpu::DownlevelFlags::SURFACE_VIEW_FORMATS)
        {
            view_format = format.remove_srgb_suffix();
            config.view_formats = vec![view_format];
        }
    }
    config.present_mode = wgpu::PresentMode::AutoVsync;
    // Input is to be on the screen two frames later: the frame in which it arrives and the one that draws it.
    config.desired_maximum_frame_latency = 1;
    Ok((config, view_format))
}
