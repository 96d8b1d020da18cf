//! Tests of hits.

use glam::{DQuat, DVec2, DVec3};

use super::*;
use crate::Viewpoint;

#[test]
fn no_targets_no_hit() {
    let targets = Targets::default();
    assert!(targets.is_empty());
    assert_eq!(cast(&targets, &ray(DVec3::ZERO, DVec3::X)), None);
}

#[test]
fn the_nearest_of_two_in_a_line_is_hit_and_the_occluded_one_is_not() {
    for (near, far) in [(5.0, 9.0), (9.0, 5.0)] {
        let scene =
            Scene::default().with(DVec3::X * near, ball(1.0)).with(DVec3::X * far, cube(1.0));
        let targets = scene.targets(DVec3::ZERO);
        let hit = cast(&targets, &ray(DVec3::ZERO, DVec3::X)).unwrap();
        assert_eq!(hit.index, usize::from(far < near));
        assert_eq!(hit.entity, scene.entities[hit.index]);
        assert!((hit.distance - 4.0).abs() < 1e-6 && hit.point.abs_diff_eq(DVec3::X * 4.0, 1e-6));
        let back = cast(&targets, &ray(DVec3::X * 20.0, DVec3::NEG_X)).unwrap();
        assert_ne!(back.index, hit.index, "from the other side the other one is in front");
        assert_eq!(cast(&targets, &ray(DVec3::ZERO, DVec3::NEG_X)), None, "both are behind");
        assert_eq!(cast(&targets, &ray(DVec3::Y * 1.5, DVec3::X)), None, "past both");
    }
}

#[test]
fn of_two_at_the_same_distance_the_lower_row_is_hit() {
    let mut scene = Dice(9).scene(300, DVec3::X * 100.0, 20.0);
    for _ in 0..3 {
        scene.add(DVec3::X * 10.0, cube(1.0), DQuat::IDENTITY);
    }
    let targets = scene.targets(DVec3::ZERO);
    assert_eq!(row_and_distance(&targets, &ray(DVec3::ZERO, DVec3::X)), (300, 9.0));
}

#[test]
fn a_turned_cube_is_hit_where_the_unturned_is_not_and_the_other_way_round() {
    let turned = DQuat::from_rotation_y(45.0_f64.to_radians());
    let cases =
        [(DVec3::new(0.0, 0.0, 1.3), false, true), (DVec3::new(0.95, 0.0, 0.95), true, false)];
    for (passes, straight_hit, turned_hit) in cases {
        let down = ray(passes + DVec3::Y * 10.0, DVec3::NEG_Y);
        for (turn, expected) in [(DQuat::IDENTITY, straight_hit), (turned, turned_hit)] {
            let mut scene = Scene::default();
            scene.add(DVec3::ZERO, cube(1.0), turn);
            assert_eq!(
                cast(&scene.targets(DVec3::ZERO), &down).is_some(),
                expected,
                "{passes} {turn}"
            );
        }
    }
}

#[test]
fn a_ray_that_starts_inside_passes_through_to_what_is_behind() {
    for around in [ball(3.0), cube(3.0)] {
        let scene = Scene::default().with(DVec3::ZERO, around).with(DVec3::Z * -10.0, ball(1.0));
        let targets = scene.targets(DVec3::ZERO);
        for start in [DVec3::ZERO, DVec3::Z * -1.5, DVec3::Z * 2.9] {
            let (row, distance) = row_and_distance(&targets, &ray(start, DVec3::NEG_Z));
            assert_eq!(row, 1, "{start}");
            assert!((distance - 9.0 - start.z).abs() < 1e-5);
        }
        assert_eq!(row_and_distance(&targets, &ray(DVec3::Z * 5.0, DVec3::NEG_Z)).0, 0);
    }
}

#[test]
fn the_ray_through_the_screen_center_hits_the_tutorials_floor() {
    let floor = Shape::cuboid(DVec3::new(100.0, 2.0, 100.0)).unwrap();
    let offsets = [DVec3::ZERO, DVec3::new(1e5, 0.0, 0.0), DVec3::new(-1e5, 1e5, 1e5)];
    for offset in offsets {
        let scene = Scene::default().with(offset - DVec3::Y * 2.0, floor).with(offset, ball(1.0));
        let eye = offset + DVec3::new(-60.0, 40.0, 60.0);
        let view = Viewpoint::from_pitch_yaw(eye, -15.0, 315.0, 45.0_f64.to_radians(), 0.1, 500.0);
        let size = DVec2::new(1280.0, 720.0);
        let targets = scene.targets(eye);
        let hit = cast(&targets, &view.ray_through(size / 2.0, size)).unwrap();
        assert_eq!(hit.index, 0);
        assert!((hit.distance - 154.548).abs() < 1e-3, "{}", hit.distance);
        assert!(
            (hit.point - offset).abs_diff_eq(DVec3::new(45.558, 0.0, -45.558), 1e-3),
            "{}",
            hit.point - offset
        );
        let ball = view.ray_through(view.project(offset, size).unwrap(), size);
        assert_eq!(cast(&targets, &ball).unwrap().index, 1);
    }
}

#[test]
fn hits_100_km_from_the_origin_are_those_at_the_origin() {
    // Multiples of 2^-20 m, so that moving the scene rounds nothing and the hits must be equal to the bit.
    let snap = |v: DVec3| (v * 1_048_576.0).round() / 1_048_576.0;
    let (mut dice, away, eye) = (Dice(3), DVec3::new(1e5, -1e5, 1e5), DVec3::new(-30.0, 5.0, 12.0));
    let mut here = dice.scene(1000, DVec3::ZERO, 20.0);
    here.transforms.iter_mut().for_each(|t| t.position = snap(t.position));
    let mut there = here.clone();
    there.transforms.iter_mut().for_each(|t| t.position += away);
    let (near, far) = (here.targets(eye), there.targets(eye + away));
    let mut hits = 0;
    for _ in 0..500 {
        let direction = dice.aim(eye, &here).direction();
        let hit = cast(&near, &ray(eye, direction));
        let same = cast(&far, &ray(eye + away, direction));
        assert_eq!(hit.map(|h| (h.entity, h.distance)), same.map(|h| (h.entity, h.distance)));
        hits += u32::from(hit.is_some());
    }
    assert!(hits > 250, "only {hits} of 500 rays hit");
}

#[test]
fn scan_and_tree_find_what_brute_force_in_f64_finds() {
    let floor = Shape::cuboid(DVec3::new(100.0, 2.0, 100.0)).unwrap();
    let mut dice = Dice(0x5EED);
    for (distance, spread) in
        [(0.0, 15.0), (40.0, 15.0), (1e3, 15.0), (1e4, 100.0), (1e5, 60.0), (1e6, 30.0)]
    {
        let center = dice.vector().normalize() * distance;
        let mut scene = dice.scene(700, center, spread);
        scene.add(center - DVec3::Y * 20.0, floor, DQuat::IDENTITY);
        let eye = dice.vector() * 10.0;
        let targets = scene.targets(eye);
        let mut hits = 0;
        for _ in 0..400 {
            let ray = dice.aim(eye, &scene);
            let hit = cast(&targets, &ray);
            let (most, least) = (scene.brute_force(&ray, 1.0), scene.brute_force(&ray, -1.0));
            let found = hit.map_or(f64::INFINITY, |h| h.distance);
            assert!(
                most <= found && found <= least,
                "{distance} m: {most} <= {found} <= {least}, {ray:?}"
            );
            if let Some(hit) = hit {
                assert!(
                    scene.brute_force_one(hit.index, &ray, 1.0) <= found,
                    "another one was hit"
                );
                hits += 1;
            }
        }
        assert!(hits > 100, "only {hits} of 400 rays hit at {distance} m");
    }
}

#[test]
fn positions_that_are_not_numbers_are_never_hit() {
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e30, 1e19];
    let mut scene = Dice(4).scene(300, DVec3::X * 50.0, 10.0);
    for value in bad {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            scene.add(
                DVec3::select(axis.cmpeq(DVec3::ONE), DVec3::splat(value), DVec3::ZERO),
                ball(2.0),
                DQuat::IDENTITY,
            );
            scene.add(axis * value, cube(2.0), DQuat::IDENTITY);
        }
    }
    let mut targets = scene.targets(DVec3::ZERO);
    let mut dice = Dice(5);
    for _ in 0..3 {
        for direction in
            (0..100).map(|_| dice.vector()).chain([DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Z])
        {
            let hit = cast(&targets, &ray(DVec3::Y * 5.0, direction));
            assert!(hit.is_none_or(|h| h.index < 300), "{hit:?}");
        }
        targets.update(DVec3::ONE, 1.0, std::iter::once(scene.chunk()));
    }
    let literal = Shape::Sphere { radius: f64::NAN };
    let scene = Scene::default()
        .with(DVec3::X * 5.0, literal)
        .with(DVec3::X * 9.0, Shape::Sphere { radius: -2.0 });
    assert_eq!(
        cast(&scene.targets(DVec3::ZERO), &ray(DVec3::ZERO, DVec3::X)),
        None,
        "sizes past the constructors"
    );
}

#[test]
fn the_interpolated_pose_is_what_is_hit() {
    let mut scene = Scene::default().with(DVec3::X * 20.0, ball(1.0));
    scene.previous = Some(vec![PreviousPosition(DVec3::X * 10.0)]);
    let mut targets = Targets::default();
    for (alpha, distance) in [(0.0, 9.0), (0.5, 14.0), (1.0, 19.0)] {
        targets.update(DVec3::ZERO, alpha, std::iter::once(scene.chunk()));
        assert_eq!(row_and_distance(&targets, &ray(DVec3::ZERO, DVec3::X)), (0, distance));
        assert_eq!(targets.positions().0, [distance as f32 + 1.0]);
    }
    scene.previous = None;
    targets.update(DVec3::ZERO, 0.0, std::iter::once(scene.chunk()));
    assert_eq!(row_and_distance(&targets, &ray(DVec3::ZERO, DVec3::X)), (0, 19.0));
}

#[test]
fn a_ray_may_start_away_from_the_anchor() {
    let mut dice = Dice(11);
    let scene = dice.scene(400, DVec3::ZERO, 15.0);
    let at_eye = scene.targets(DVec3::Z * 40.0);
    for anchor in [DVec3::ZERO, DVec3::splat(300.0), DVec3::new(-2000.0, 0.0, 0.0)] {
        let targets = scene.targets(anchor);
        let mut hits = 0;
        for _ in 0..200 {
            let ray = dice.aim(DVec3::Z * 40.0, &scene);
            let (a, b) = (cast(&at_eye, &ray), cast(&targets, &ray));
            // Only for grazing rays may the two roundings give different hits.
            if let (Some(a), Some(b)) = (a, b)
                && a.entity == b.entity
            {
                assert!((a.distance - b.distance).abs() < 1e-2);
                hits += 1;
            }
        }
        assert!(hits > 80, "only {hits} of 200 rays hit alike from {anchor}");
    }
}
