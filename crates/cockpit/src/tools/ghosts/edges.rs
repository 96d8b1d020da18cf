//! The edges of a ghost, drawn as thin lines.

use std::collections::BTreeSet;

use scene::{Scene, SoftBodySpec};

/// The edges of springs and soft bodies, as pairs of stable ids.
pub(crate) fn of(scene: &Scene) -> Vec<[u32; 2]> {
    let springs = scene.springs.iter().map(|spring| spring.ends);
    springs.chain(scene.soft_bodies.iter().flat_map(|soft| of_soft_body(scene, soft))).collect()
}

/// The edges of a soft body: the springs of a rope, or the sides of the cells of a surface. A cell is two triangles that share
/// their longest side, the diagonal, which is left out. All springs of a surface would look like felt.
fn of_soft_body(scene: &Scene, soft: &SoftBodySpec) -> Vec<[u32; 2]> {
    let ids = |ends: [u32; 2]| ends.map(|end| soft.points.start + end);
    if soft.triangles.is_empty() {
        return soft.links.iter().map(|link| ids(link.ends)).collect();
    }
    let mut edges = BTreeSet::new();
    for [a, b, c] in &soft.triangles {
        let mut sides = [[a, b], [b, c], [c, a]].map(|[a, b]| ids([*a.min(b), *a.max(b)]));
        let length = |side: [u32; 2]| {
            let [from, to] = side.map(|id| scene.bodies[id as usize].position);
            from.distance(to)
        };
        sides.sort_by(|a, b| length(*a).total_cmp(&length(*b)));
        edges.extend(&sides[..2]);
    }
    edges.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ghosts_of_soft_bodies_are_ropes_and_the_sides_of_cells() {
        let scene = |soft: &str| {
            let text = format!(
                "(version: 1, bodies: [(name: \"a\"), (name: \"b\")], springs: [(between: (\"a\", \"b\"), stiffness_n_m: 1)], soft_bodies: [{soft}])"
            );
            Scene::parse("edges", &text).unwrap_or_else(|error| panic!("{error}"))
        };
        let count = |soft: &str| of(&scene(soft)).len() - 1;
        assert_eq!(of(&scene(""))[0], [0, 1]);
        assert_eq!(count("chain(points: 5, to_m: (4, 0, 0), stiffness_n_m: 1)"), 4);
        // Rows of five points and columns of four, without shear and bend.
        let cloth = "cloth(rows: 4, columns: 5, along_m: (4, 0, 0), down_m: (0, -2, 0), stiffness_n_m: 1, shear: true, bend: true)";
        assert_eq!(count(cloth), 4 * 4 + 3 * 5);
        // A block of one cell has twelve edges.
        assert_eq!(count("lattice(cells: (1, 1, 1), size_m: (1, 2, 3), stiffness_n_m: 1)"), 12);
    }
}
