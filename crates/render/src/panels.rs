//! Paints egui's triangles over a finished picture.

use crate::{Gpu, Panels};

/// egui's own renderer, set so that equal panels give equal bytes.
pub(crate) struct PanelPainter {
    egui: egui_wgpu::Renderer,
}

impl PanelPainter {
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let egui = egui_wgpu::Renderer::new(device, format, egui_wgpu::RendererOptions::PREDICTABLE);
        Self { egui }
    }

    /// Must run for every frame, drawn or not: egui sends each change of a texture once.
    pub fn update_textures(&mut self, gpu: &Gpu, panels: &Panels) {
        for (id, deltas) in &panels.textures_delta.set {
            for delta in deltas {
                self.egui.update_texture(&gpu.device, &gpu.queue, *id, delta);
            }
        }
    }

    /// Drops textures that this frame was the last to use.
    pub fn free_textures(&mut self, panels: &Panels) {
        for id in &panels.textures_delta.free {
            self.egui.free_texture(id);
        }
    }

    /// Records the panels over what `view` holds; the returned commands go to the queue first.
    pub fn paint(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        size_px: [u32; 2],
        panels: &Panels,
    ) -> Vec<wgpu::CommandBuffer> {
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: size_px,
            pixels_per_point: if panels.pixels_per_point > 0.0 { panels.pixels_per_point } else { 1.0 },
        };
        let first = self.egui.update_buffers(&gpu.device, &gpu.queue, encoder, &panels.primitives, &screen);
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("panels"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        self.egui.render(&mut pass.forget_lifetime(), &panels.primitives, &screen);
        first
    }
}
