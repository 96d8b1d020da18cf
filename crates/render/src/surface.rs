//! Surfaces of triangles that are new in every frame: cloth, jelly, balloons.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A mesh whose points moved since the last frame. Both of its sides are drawn; it casts and receives shadows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Its points; a point that no triangle uses may have any position, even one that is not a number.
    pub vertices: Vec<SurfaceVertex>,
    /// Its triangles, by indices of `vertices`; connected triangles must be wound in the same sense, or shading
    /// breaks.
    pub triangles: Vec<[u32; 3]>,
    /// Whether it has the outline of a selected body.
    pub outlined: bool,
}

/// A point of a [`Surface`]. The layout is that of the vertex buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SurfaceVertex {
    /// Relative to the camera, m.
    pub position: [f32; 3],
    /// Red, green, blue as displayed (not linear) and an alpha that is ignored, since surfaces are opaque.
    pub color: [u8; 4],
    /// Unit normal, on the side from which the triangles are seen counter-clockwise.
    pub normal: [f32; 3],
}

impl Surface {
    /// A smooth surface through `points`, m relative to the camera, without an outline. Triangles with an invalid index
    /// or a point that is not finite are left out. Color: red, green, blue as displayed, 0 to 1, and alpha.
    #[must_use]
    pub fn smooth(
        points: &[Vec3],
        triangles: impl IntoIterator<Item = [u32; 3]>,
        color: [f32; 4],
    ) -> Self {
        let there =
            |corner: &u32| points.get(*corner as usize).is_some_and(|point| point.is_finite());
        let triangles: Vec<_> =
            triangles.into_iter().filter(|triangle| triangle.iter().all(there)).collect();
        let normals = smooth_normals(points, &triangles);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to a byte"
        )]
        let bytes = color.map(|channel| (channel.clamp(0.0, 1.0) * 255.0).round() as u8);
        let vertex = |(position, normal): (&Vec3, Vec3)| SurfaceVertex {
            position: position.to_array(),
            color: bytes,
            normal: normal.to_array(),
        };
        Self {
            vertices: points.iter().zip(normals).map(vertex).collect(),
            triangles,
            outlined: false,
        }
    }
}

/// The area-weighted mean normal of the triangles at each point and at the points next to it; zero at a point without
/// triangles. Without the neighbors, ripples of one cell would show as patches.
fn smooth_normals(points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let own = mean_normals(points, triangles);
    let mut normals = own.clone();
    for triangle in triangles {
        let sum: Vec3 = triangle.iter().map(|corner| own[*corner as usize]).sum();
        for corner in triangle {
            normals[*corner as usize] += sum;
        }
    }
    normals.into_iter().map(Vec3::normalize_or_zero).collect()
}

/// The area-weighted mean normal of the triangles at each point; zero at a point without triangles.
fn mean_normals(points: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| points[corner as usize]);
        // Its length is twice the area.
        let normal = (b - a).cross(c - a);
        for corner in triangle {
            normals[*corner as usize] += normal;
        }
    }
    for normal in &mut normals {
        *normal = normal.normalize_or_zero();
    }
    normals
}

/// The edges at which a surface ends as seen from the camera: those of one triangle, and those where one of two triangles faces
/// the camera and the other does not. Normals are on the side that is seen.
pub(crate) fn silhouette(surface: &Surface) -> Vec<[SurfaceVertex; 2]> {
    let at = |corner: u32| Vec3::from(surface.vertices[corner as usize].position);
    let of = |[a, b, c]: [u32; 3]| {
        let [from, to, apex] = [a, b, c].map(at);
        let normal = (to - from).cross(apex - from);
        ([a.min(b), a.max(b)], normal, -normal.dot(from), apex)
    };
    let sides = |&[a, b, c]: &[u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].map(of);
    let mut sides: Vec<_> = surface.triangles.iter().flat_map(sides).collect();
    sides.sort_unstable_by_key(|(edge, ..)| *edge);
    let ends = |sides: &[([u32; 2], Vec3, f32, Vec3)]| {
        let facing = match *sides {
            [(_, _, facing, _)] => facing,
            [(edge, normal, one, _), (_, _, other, apex)] if (one > 0.0) != (other > 0.0) => {
                // The triangle is seen that hides the other one.
                let hides = normal.dot(apex - at(edge[0])) * one < 0.0;
                if hides { one } else { other }
            }
            _ => return None,
        };
        Some(sides[0].0.map(|end| {
            let vertex = surface.vertices[end as usize];
            let normal = vertex.normal.map(|part| part * facing.signum());
            SurfaceVertex { normal, ..vertex }
        }))
    };
    sides.chunk_by(|one, other| one.0 == other.0).filter_map(ends).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: [f32; 4] = [1.0; 4];

    fn normal(surface: &Surface, vertex: usize) -> Vec3 {
        Vec3::from(surface.vertices[vertex].normal)
    }

    #[test]
    fn a_flat_sheet_has_its_normal_everywhere_on_the_side_that_sees_it_counter_clockwise() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        for (triangles, expected) in
            [([[0, 1, 2], [0, 2, 3]], Vec3::Z), ([[0, 2, 1], [0, 3, 2]], Vec3::NEG_Z)]
        {
            let surface = Surface::smooth(&points, triangles, WHITE);
            assert!((0..4).all(|vertex| normal(&surface, vertex) == expected));
        }
    }

    #[test]
    fn at_a_fold_a_normal_leans_to_the_larger_triangle() {
        // Along x, one triangle lies in the plane y = 0 and one of twice its area stands in z = 0.
        let points = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::Y * 2.0];
        let surface = Surface::smooth(&points, [[0, 2, 1], [0, 1, 3]], WHITE);
        let [x, y, z] = surface.vertices[0].normal;
        assert!(x == 0.0 && y > 0.4 && z > 1.5 * y, "{y} {z}");
        assert_eq!([surface.vertices[2].normal[0], surface.vertices[3].normal[0]], [0.0; 2]);
        // Normals beside the fold lean toward it, but more toward their own triangle.
        let [flat, steep] = [normal(&surface, 2), normal(&surface, 3)];
        assert!(flat.y > 0.7 && flat.z > 0.1 && steep.z > 0.7 && steep.y > 0.1, "{flat} {steep}");
    }

    #[test]
    fn a_small_far_cell_has_a_good_normal() {
        let corner = Vec3::new(60.0, -40.0, 80.0);
        let points = [corner, corner + Vec3::X * 0.01, corner + Vec3::Y * 0.01];
        let surface = Surface::smooth(&points, [[0, 1, 2]], WHITE);
        assert!(normal(&surface, 0).dot(Vec3::Z) > 0.9999);
    }

    #[test]
    fn triangles_with_a_point_that_is_not_there_are_left_out_and_spoil_nothing() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN];
        let surface = Surface::smooth(&points, [[0, 1, 2], [1, 2, 3], [0, 1, 9]], WHITE);
        assert_eq!(surface.triangles, [[0, 1, 2]]);
        assert!((0..3).all(|vertex| normal(&surface, vertex) == Vec3::Z));
        assert_eq!(normal(&surface, 3), Vec3::ZERO);
    }

    #[test]
    fn a_surface_ends_at_its_border_and_where_it_folds_away_from_the_camera() {
        let edges = |points: &[Vec3], triangles: &[[u32; 3]]| {
            silhouette(&Surface::smooth(points, triangles.iter().copied(), WHITE))
        };
        let lies = |edge: &[SurfaceVertex; 2], x: f32| edge.iter().all(|end| end.position[0] == x);
        // Two squares that meet at x = 0: in one plane across the view, then folded onto each other.
        let square = |end: f32, z: f32| [(end, 0.0, z), (end, 1.0, z)].map(Vec3::from);
        let sheet = |left: f32, z: f32| {
            [
                [(0.0, 0.0, -5.0), (0.0, 1.0, -5.0)].map(Vec3::from),
                square(left, z),
                square(1.0, -5.0),
            ]
            .concat()
        };
        let cells = [[0, 1, 3], [0, 3, 2], [0, 4, 5], [0, 5, 1]];
        let flat = edges(&sheet(-1.0, -5.0), &cells);
        assert_eq!((flat.len(), flat.iter().filter(|edge| lies(edge, 0.0)).count()), (6, 0));
        for (behind, seen) in [(-6.0, 1.0), (-4.0, -1.0)] {
            let folded = edges(&sheet(0.9, behind), &cells);
            let fold: Vec<_> = folded.iter().filter(|edge| lies(edge, 0.0)).collect();
            assert_eq!((folded.len(), fold.len()), (7, 1), "{behind}");
            let own = Surface::smooth(&sheet(0.9, behind), cells, WHITE).vertices[0].normal;
            assert_eq!(fold[0][0].normal, own.map(|part| part * seen), "{behind}");
        }
    }

    #[test]
    fn a_triangle_without_area_has_no_normal_and_no_nan() {
        let surface = Surface::smooth(&[Vec3::ONE; 3], [[0, 1, 2]], WHITE);
        assert_eq!(normal(&surface, 0), Vec3::ZERO);
    }
}
