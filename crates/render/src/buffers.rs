//! Buffers that are kept from frame to frame and grow when a frame needs more.

use std::ops::Range;

use bytemuck::Pod;
use glam::Vec3;

use crate::{Gpu, Instance, OUTLINED};

/// Instances, vertices or indices on the adapter; grows to the next power of two and never shrinks.
pub(crate) struct InstanceBuffer {
    label: &'static str,
    buffer: wgpu::Buffer,
}

impl InstanceBuffer {
    pub fn new(device: &wgpu::Device, label: &'static str) -> Self {
        Self::of(device, label, wgpu::BufferUsages::VERTEX)
    }

    /// An empty buffer for indices.
    pub fn of_indices(device: &wgpu::Device, label: &'static str) -> Self {
        Self::of(device, label, wgpu::BufferUsages::INDEX)
    }

    fn of(device: &wgpu::Device, label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self {
            label,
            buffer: create(device, label, usage | wgpu::BufferUsages::COPY_DST, 16 * 1024),
        }
    }

    /// Copies `rows` to the adapter. Returns the number of rows that can be drawn: all, unless they exceed its
    /// largest buffer.
    pub fn upload<T: Pod>(&mut self, gpu: &Gpu, rows: &[T]) -> u32 {
        let limit = gpu.device.limits().max_buffer_size;
        let most = usize::try_from(limit).unwrap_or(usize::MAX) / size_of::<T>();
        let rows = &rows[..rows.len().min(most)];
        let bytes: &[u8] = bytemuck::cast_slice(rows);
        if bytes.is_empty() {
            return 0;
        }
        let needed = bytes.len() as u64;
        if needed > self.buffer.size() {
            let size = needed.next_power_of_two().min(limit);
            self.buffer = create(&gpu.device, self.label, self.buffer.usage(), size);
        }
        gpu.queue.write_buffer(&self.buffer, 0, bytes);
        rows.len() as u32
    }

    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Draws `rows` as quads: strips of two triangles each.
    pub fn draw_quads(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        rows: Range<u32>,
    ) {
        self.draw_vertices(pass, pipeline, 4, rows);
    }

    /// Draws that number of vertices for each of these rows.
    pub fn draw_vertices(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        vertices: u32,
        rows: Range<u32>,
    ) {
        if !rows.is_empty() {
            pass.set_pipeline(pipeline);
            pass.set_vertex_buffer(0, self.buffer.slice(..));
            pass.draw(0..vertices, rows);
        }
    }
}

/// More bodies than this are drawn in the order in which they come: sorting them would take longer than it saves.
const MOST_SORTED: usize = 10_000;

/// The bodies of one kind. The outlined ones are last, so that each kind is one draw. Nearer ones come before those
/// that they hide, because hidden pixels need not be shaded.
pub(crate) struct Bodies {
    pub instances: InstanceBuffer,
    sorted: Vec<Instance>,
    /// Rows without an outline.
    pub plain: u32,
    /// All rows.
    pub total: u32,
}

impl Bodies {
    pub fn new(device: &wgpu::Device, label: &'static str) -> Self {
        Self {
            instances: InstanceBuffer::new(device, label),
            sorted: Vec::new(),
            plain: 0,
            total: 0,
        }
    }

    pub fn upload<'a>(&mut self, gpu: &Gpu, rows: impl IntoIterator<Item = &'a Instance>) {
        self.sorted.clear();
        self.sorted.extend(rows);
        let is_outlined = |row: &Instance| row.surface & OUTLINED != 0;
        let sorts = self.sorted.len() <= MOST_SORTED;
        self.sorted.sort_by_cached_key(|row| {
            // The key is the distance to the far side, so a floor comes after bodies on it. Floats from 0 up are
            // ordered as their bits.
            let distance =
                || Vec3::from(row.position).length() + Vec3::from(row.half_extents).max_element();
            (is_outlined(row), if sorts { distance().to_bits() } else { 0 })
        });
        self.total = self.instances.upload(gpu, &self.sorted);
        self.plain = self.total.min(self.sorted.partition_point(|row| !is_outlined(row)) as u32);
    }
}

fn create(
    device: &wgpu::Device,
    label: &str,
    usage: wgpu::BufferUsages,
    size: u64,
) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}
