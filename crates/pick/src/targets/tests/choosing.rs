//! Tests of changes between frames: changed rows, things that move, a camera that flies.

use glam::{DQuat, DVec3};

use super::*;

#[test]
fn rows_that_are_removed_and_added_again_are_noticed() {
    let mut world = World::new();
    let near = world.spawn((Transform::at(DVec3::X * 5.0), ball(1.0))).id();
    let far = world.spawn((Transform::at(DVec3::X * 9.0), cube(1.0))).id();
    let mut query = world.query::<(Entity, &Transform, &Shape)>();
    let mut targets = Targets::default();
    let mut look = |world: &World| {
        let chunks = query.contiguous_iter(world).unwrap().map(|(entities, transforms, shapes)| {
            Chunk { entities, transforms, shapes, previous: None, orientations: None }
        });
        targets.update(DVec3::ZERO, 1.0, chunks);
        (
            targets.len(),
            cast(&targets, &ray(DVec3::ZERO, DVec3::X))
                .map(|h| (h.entity, to_the_micrometer(h.distance))),
        )
    };
    assert_eq!(look(&world), (2, Some((near, 4.0))));
    world.despawn(near);
    assert_eq!(look(&world), (1, Some((far, 8.0))));
    let again = world.spawn((Transform::at(DVec3::X * 5.0), cube(2.0))).id();
    assert_eq!(look(&world), (2, Some((again, 3.0))));
    world.entity_mut(far).insert(PreviousPosition(DVec3::ZERO));
    assert_eq!(look(&world), (2, Some((again, 3.0))), "a second table");
    world.despawn(again);
    world.despawn(far);
    assert_eq!(look(&world), (0, None));
}

#[test]
fn a_component_written_in_place_is_seen_after_invalidating() {
    let mut scene = Scene::default().with(DVec3::X * 5.0, ball(1.0));
    let mut targets = scene.targets(DVec3::ZERO);
    scene.shapes[0] = ball(2.0);
    targets.invalidate();
    targets.update(DVec3::ZERO, 1.0, std::iter::once(scene.chunk()));
    assert_eq!(row_and_distance(&targets, &ray(DVec3::ZERO, DVec3::X)), (0, 3.0));
}

#[test]
fn a_tree_is_built_over_resting_targets_and_follows_the_few_that_move() {
    let mut dice = Dice(21);
    let mut scene = dice.scene(4000, DVec3::ZERO, 40.0);
    let mut targets = scene.targets(DVec3::ZERO);
    for _ in 0..=cost::RAYS_BEFORE_BUILD {
        assert!(targets.tree.get().is_none());
        let _ = targets.cast(&dice.aim(DVec3::ZERO, &scene));
    }
    assert!(targets.tree.get().is_some(), "many rays, nothing moves");
    // The camera flies and two bodies move: the tree stays and its hits are those of a scan.
    for frame in 0..200 {
        let eye = DVec3::new(f64::from(frame), 3.0, 0.5);
        for row in [7, 1500] {
            scene.transforms[row].position += dice.vector();
        }
        targets.update(eye, 1.0, std::iter::once(scene.chunk()));
        assert!(targets.tree.get().is_some(), "frame {frame}");
        for _ in 0..10 {
            let ray = dice.aim(eye, &scene);
            assert_eq!(targets.cast(&ray), targets.cast_by_scan(&ray));
        }
        let at_mover = ray(eye, scene.transforms[7].position - eye);
        assert_eq!(targets.cast(&at_mover), targets.cast_by_scan(&at_mover));
    }
    // All move: with many rays per frame the tree is refitted and rebuilt, with few it is dropped.
    for _ in 0..40 {
        scene.transforms.iter_mut().for_each(|t| t.position += dice.vector() * 0.3);
        for _ in 0..500 {
            let ray = dice.aim(DVec3::ZERO, &scene);
            assert_eq!(targets.cast(&ray), targets.cast_by_scan(&ray));
        }
        targets.update(DVec3::ZERO, 1.0, std::iter::once(scene.chunk()));
        assert!(targets.tree.get().is_some());
    }
    scene.transforms.iter_mut().for_each(|t| t.position += dice.vector());
    targets.update(DVec3::ZERO, 1.0, std::iter::once(scene.chunk()));
    assert!(targets.tree.get().is_none(), "all move and nobody asks");
}

#[test]
fn a_tree_is_left_behind_by_a_camera_that_flies_far_and_rays_from_afar_are_scanned() {
    let mut dice = Dice(33);
    let scene = dice.scene(500, DVec3::ZERO, 30.0);
    let mut targets = scene.targets(DVec3::ZERO);
    for distance in [0.0, 4e3, 9e3, 1e5, 0.0] {
        let eye = DVec3::X * distance;
        let ray = dice.aim(eye, &scene);
        assert_eq!(targets.cast_by_tree(&ray), targets.cast_by_scan(&ray));
        targets.update(eye, 1.0, std::iter::once(scene.chunk()));
        assert_eq!(targets.cast_by_tree(&ray), targets.cast_by_scan(&ray));
    }
}

#[test]
fn a_tree_whose_frame_is_km_away_misses_no_edge() {
    let mut dice = Dice(44);
    let mut scene = Scene::default();
    for _ in 0..500 {
        scene.add(dice.vector() * 30.0, cube(0.2), DQuat::IDENTITY);
    }
    let mut targets = scene.targets(DVec3::new(4000.0, -4000.0, 4000.0));
    let _ = targets.cast_by_tree(&ray(DVec3::ZERO, DVec3::X));
    targets.update(DVec3::ZERO, 1.0, std::iter::once(scene.chunk()));
    assert!(targets.tree.get().is_some_and(|tree| tree.serves(DVec3::ZERO)));
    for row in 0..500 {
        // Just inside of an edge of the face towards -x: in f32, 4 km away, the edge is known to 0.2 mm.
        let edge = scene.transforms[row].position + DVec3::new(-0.2, 0.199_99, 0.1);
        let hit = targets.cast_by_scan(&ray(edge - DVec3::X, DVec3::X));
        assert!(hit.is_some());
        assert_eq!(targets.cast_by_tree(&ray(edge - DVec3::X, DVec3::X)), hit);
    }
}
