//! Draws a picture without a window and copies it to memory.

use crate::{Gpu, Image, Reading, RenderError};

/// Format of pictures without a window. Neither this nor that of a window is an sRGB format: the shaders encode gamma
/// themselves and panels are blended as egui expects, so both give the same bytes.
pub const OFFSCREEN_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A texture to draw into and the buffer that it is read back through.
pub struct Offscreen {
    size_px: [u32; 2],
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    buffer: wgpu::Buffer,
    bytes_per_row: u32,
}

impl Offscreen {
    /// Creates a texture of `size_px`, width and height, each 1 to [`Gpu::max_side_px`].
    pub fn new(gpu: &Gpu, size_px: [u32; 2]) -> Result<Self, RenderError> {
        Self::with_format(gpu, size_px, OFFSCREEN_FORMAT)
    }

    /// As [`Offscreen::new`], with another format of four bytes: that of a window, to take a picture of it.
    pub fn with_format(
        gpu: &Gpu,
        size_px: [u32; 2],
        format: wgpu::TextureFormat,
    ) -> Result<Self, RenderError> {
        let [width, height] = size_px;
        let max = gpu.max_side_px();
        let max_bytes = gpu.device.limits().max_buffer_size;
        let refused = RenderError::Size { width, height, max, max_area: max_bytes / 4 };
        if !(1..=max).contains(&width) || !(1..=max).contains(&height) {
            return Err(refused);
        }
        let bytes_per_row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(bytes_per_row) * u64::from(height);
        if bytes > max_bytes {
            return Err(refused);
        }
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("offscreen"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: bytes,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Ok(Self { size_px, texture, view, buffer, bytes_per_row })
    }

    /// The view to draw into.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Waits for all submitted work and copies the picture out.
    pub fn read(&self, gpu: &Gpu) -> Result<Image, RenderError> {
        self.copy(gpu);
        let bytes = gpu.read_buffer(&self.buffer);
        Ok(self.image(&bytes.map_err(|detail| RenderError::ReadBack { detail })?))
    }

    /// Begins to copy the picture out, for [`Offscreen::finish_reading`].
    pub fn begin_reading(&self, gpu: &Gpu) -> Result<Reading, RenderError> {
        self.copy(gpu);
        gpu.begin_reading(&self.buffer).map_err(|detail| RenderError::ReadBack { detail })
    }

    /// The picture, if it is there.
    pub fn finish_reading(&self, reading: &Reading) -> Option<Result<Image, RenderError>> {
        let bytes = reading.bytes()?.map_err(|detail| RenderError::ReadBack { detail });
        Some(bytes.map(|bytes| self.image(&bytes)))
    }

    fn copy(&self, gpu: &Gpu) {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read back") });
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &self.buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.bytes_per_row),
                    rows_per_image: None,
                },
            },
            self.texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
    }

    /// The picture of those bytes of the buffer.
    fn image(&self, bytes: &[u8]) -> Image {
        let row_bytes = self.size_px[0] as usize * 4;
        let mut rgba = Vec::with_capacity(row_bytes * self.size_px[1] as usize);
        for row in bytes.chunks_exact(self.bytes_per_row as usize) {
            rgba.extend_from_slice(&row[..row_bytes]);
        }
        use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb};
        let blue_first = matches!(self.texture.format(), Bgra8Unorm | Bgra8UnormSrgb);
        for pixel in rgba.chunks_exact_mut(4) {
            if blue_first {
                pixel.swap(0, 2);
            }
            pixel[3] = 255;
        }
        Image { size_px: self.size_px, rgba }
    }
}
