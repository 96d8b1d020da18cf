//! The unit meshes that every body is an instance of.

use bytemuck::{Pod, Zeroable};
use wgpu::util::DeviceExt as _;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub uv: [f32; 2],
}

pub(crate) struct Mesh {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

impl Mesh {
    pub fn cube(device: &wgpu::Device) -> Self {
        let (vertices, indices) = cube();
        Self::upload(device, "cube", &vertices, &indices)
    }

    /// A sphere with that number of meridians and two thirds as many parallels.
    pub fn sphere(device: &wgpu::Device, meridians: u16) -> Self {
        let (vertices, indices) = sphere(meridians, (meridians * 2 / 3).max(2));
        Self::upload(device, "sphere", &vertices, &indices)
    }

    /// Draws the given rows of `instances`.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        instances: &wgpu::Buffer,
        rows: std::ops::Range<u32>,
    ) {
        if !rows.is_empty() {
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_vertex_buffer(1, instances.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
            pass.draw_indexed(0..self.index_count, 0, rows);
        }
    }

    fn upload(device: &wgpu::Device, label: &str, vertices: &[Vertex], indices: &[u16]) -> Self {
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        Self {
            vertices: buffer(bytemuck::cast_slice(vertices), wgpu::BufferUsages::VERTEX),
            indices: buffer(bytemuck::cast_slice(indices), wgpu::BufferUsages::INDEX),
            index_count: indices.len() as u32,
        }
    }
}

/// A cube of half extent 1, counter-clockwise seen from outside, with the whole texture on each face.
fn cube() -> (Vec<Vertex>, Vec<u16>) {
    // Normal, and the directions of growing u and v: right times up is the normal.
    const FACES: [[[f32; 3]; 3]; 6] = [
        [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
        [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
        [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    ];
    let mut vertices = Vec::with_capacity(24);
    let mut indices = Vec::with_capacity(36);
    for [normal, right, up] in FACES {
        let first = vertices.len() as u16;
        for [u, v] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            let corner = |axis: usize| {
                normal[axis] + right[axis] * (2.0 * u - 1.0) + up[axis] * (2.0 * v - 1.0)
            };
            vertices.push(Vertex {
                position: [corner(0), corner(1), corner(2)],
                normal,
                uv: [u, v],
            });
        }
        indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }
    (vertices, indices)
}

/// A sphere of radius 1, counter-clockwise seen from outside, with longitude and latitude as u and v.
fn sphere(segments: u16, rings: u16) -> (Vec<Vertex>, Vec<u16>) {
    let mut vertices = Vec::new();
    let mut indices = Vec::new();
    for ring in 0..=rings {
        let v = f32::from(ring) / f32::from(rings);
        let (radius, height) = (v * std::f32::consts::PI).sin_cos();
        // The seam has two sets of vertices, with u = 0 and u = 1; otherwise the texture would run backward in its
        // last strip.
        for segment in 0..=segments {
            let u = f32::from(segment) / f32::from(segments);
            let (x, z) = (u * std::f32::consts::TAU).sin_cos();
            let position = [x * radius, height, z * radius];
            vertices.push(Vertex { position, normal: position, uv: [u, v] });
        }
    }
    let stride = segments + 1;
    for ring in 0..rings {
        for segment in 0..segments {
            let upper = ring * stride + segment;
            let lower = upper + stride;
            if ring > 0 {
                indices.extend([upper, lower + 1, upper + 1]);
            }
            if ring + 1 < rings {
                indices.extend([upper, lower, lower + 1]);
            }
        }
    }
    (vertices, indices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn triangles_face_outward() {
        for (name, (vertices, indices)) in [("cube", cube()), ("sphere", sphere(48, 32))] {
            for triangle in indices.chunks_exact(3) {
                let [a, b, c] =
                    [0, 1, 2].map(|i| Vec3::from(vertices[usize::from(triangle[i])].position));
                let facing = (b - a).cross(c - a).dot(a + b + c);
                assert!(facing > 1e-6, "{name}: {triangle:?} faces inward or is empty: {facing}");
            }
        }
    }

    #[test]
    fn meshes_are_closed() {
        for (name, (vertices, indices)) in [("cube", cube()), ("sphere", sphere(48, 32))] {
            let volume: f32 = indices
                .chunks_exact(3)
                .map(|triangle| {
                    let [a, b, c] =
                        [0, 1, 2].map(|i| Vec3::from(vertices[usize::from(triangle[i])].position));
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            let exact = if name == "cube" { 8.0 } else { 4.0 / 3.0 * std::f32::consts::PI };
            assert!((volume / exact - 1.0).abs() < 0.03, "{name} encloses {volume}, exact {exact}");
        }
    }
}
