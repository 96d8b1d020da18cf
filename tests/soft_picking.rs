//! What a click on a soft body selects, and what a push on it moves.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Elastic, Link, PhysicsBody, SoftBody, Transform};
use sandbox::input::Button;

use crate::rigs::{Drive, H, SIZE, at, click, close, down, scene_of, up};
use crate::soft::{POINT_MASS, Soft};

/// Selection mode, at `offset`, looking along -z at these soft bodies and bodies.
fn drive(offset: DVec3, bodies: &str, soft: impl IntoIterator<Item = Soft>) -> Drive {
    let text = format!(
        "(version: 1, push: (), camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0), bodies: [{bodies}])"
    );
    let mut scene = scene_of(&text);
    scene.camera.position += offset;
    scene.bodies.iter_mut().for_each(|body| body.position += offset);
    for mut soft in soft {
        soft.places.iter_mut().for_each(|place| *place += offset);
        soft.add_to(&mut scene);
    }
    let mut drive = Drive::of(scene);
    drive.press("Q");
    drive
}

fn soft_body(drive: &mut Drive) -> (Entity, SoftBody) {
    let world = drive.session.stage.world_mut();
    let (entity, body) = world.query::<(Entity, &SoftBody)>().single(world).unwrap();
    (entity, body.clone())
}

fn velocities(drive: &Drive, body: &SoftBody) -> Vec<DVec3> {
    let world = &drive.session.stage.sim().world;
    body.points.iter().map(|point| world.get::<PhysicsBody>(*point).unwrap().velocity).collect()
}

/// The numbers of the points that move.
fn moving(drive: &Drive, body: &SoftBody) -> Vec<usize> {
    (0..).zip(velocities(drive, body)).filter(|(_, v)| *v != DVec3::ZERO).map(|(i, _)| i).collect()
}

const MIDDLE: DVec3 = DVec3::new(0.0, 0.0, -10.0);

/// 4 m by 3 m in cells of 1 m.
fn sheet() -> Soft {
    Soft::upright(3, 4, MIDDLE)
}

#[test]
fn a_click_on_a_cell_selects_the_soft_body_and_a_push_there_moves_the_nearest_point() {
    for offset in [DVec3::ZERO, DVec3::new(1e5, 1e5, -1e5)] {
        // Row 1, column 2 is the point of number 7, at (0, 0.5); pinned, the next nearest is pushed instead.
        for (pins, place, expected) in [
            (vec![], DVec3::new(0.1, 0.55, 0.0), 7),
            (vec![7], DVec3::new(0.3, 0.55, 0.0), 8),
            (vec![], DVec3::new(-1.9, -1.35, 0.0), 15),
        ] {
            let mut drive = drive(offset, "", [Soft { pinned: pins, ..sheet() }]);
            let (entity, body) = soft_body(&mut drive);
            let pixel = drive.pixel(offset + MIDDLE + place);
            assert_eq!(drive.select(pixel).as_deref(), Some("soft"));
            assert_eq!(drive.session.stage.selection(), Some(entity));
            drive.click(Button::Right, pixel).ticks(1);
            assert_eq!(moving(&drive, &body), [expected]);
            let (v, along) = (velocities(&drive, &body)[expected], (MIDDLE + place).normalize());
            close(v.dot(along), 10.0 / POINT_MASS * H, 1e-9);
            assert!(v.cross(along).length() < 1e-9 * v.length());
        }
    }
}

#[test]
fn from_behind_it_is_hit_as_well() {
    let mut sheet = sheet();
    sheet.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    assert_eq!(drive(DVec3::ZERO, "", [sheet]).select(SIZE / 2.0).as_deref(), Some("soft"));
}

#[test]
fn of_a_soft_body_and_a_cuboid_the_nearer_is_selected() {
    for (z, name) in [(-5, "box"), (-15, "soft")] {
        let bodies = format!(
            "(name: \"box\", shape: cuboid(half_extents_m: (0.5, 0.5, 0.5)), position_m: (0, 0, {z}))"
        );
        let mut drive = drive(DVec3::ZERO, &bodies, [sheet()]);
        assert_eq!(drive.select(SIZE / 2.0).as_deref(), Some(name));
        // A push that the other thing is in the way of pushes nothing.
        let beside = drive.pixel(MIDDLE + DVec3::X * 1.9);
        assert_eq!(drive.select(beside).as_deref(), Some("soft"));
        let (_, body) = soft_body(&mut drive);
        drive.click(Button::Right, SIZE / 2.0).ticks(1);
        assert_eq!(moving(&drive, &body).is_empty(), name == "box");
        drive.click(Button::Right, beside).ticks(1);
        assert!(!moving(&drive, &body).is_empty());
    }
}

#[test]
fn of_the_layers_of_a_fold_the_closest_is_pushed() {
    // Three cells, one behind the other, zigzag; from the front the first of them is met, from behind the last.
    for (toward, pushed) in [(-1.2, 1), (1.2, 3)] {
        let fold = Soft::sheet(1, 3, |u, v| {
            let right = (u * 3.0).round() % 2.0;
            MIDDLE + DVec3::new(3.0 * right - 1.5, 1.5 - 3.0 * v, toward * u)
        });
        let mut drive = drive(DVec3::ZERO, "", [fold]);
        let (_, body) = soft_body(&mut drive);
        // Nearest to this place are: of the first cell the point 1, of the second 5, of the third 3.
        let front = if toward < 0.0 { 0.7 / 3.0 } else { 2.7 / 3.0 };
        let pixel = drive.pixel(MIDDLE + DVec3::new(0.6, 0.3, toward * front));
        assert_eq!(drive.select(pixel).as_deref(), Some("soft"));
        drive.click(Button::Right, pixel).ticks(1);
        assert_eq!(moving(&drive, &body), [pushed]);
    }
}

#[test]
fn through_a_hole_and_past_an_edge_nothing_is_selected() {
    let mut sheet = sheet();
    // The two triangles of row 1, column 1.
    sheet.triangles.drain(10..12);
    let mut drive = drive(DVec3::ZERO, "", [sheet]);
    for (place, hit) in [
        (DVec3::new(-0.4, 0.1, 0.0), false),
        (DVec3::new(-1.4, 0.1, 0.0), true),
        (DVec3::new(1.95, -1.45, 0.0), true),
        (DVec3::new(2.05, 0.0, 0.0), false),
    ] {
        let pixel = drive.pixel(MIDDLE + place);
        assert_eq!(drive.select(pixel).is_some(), hit, "{place}");
    }
}

#[test]
fn a_rope_is_selected_at_points_and_springs_and_named_after_its_first_point() {
    let text = "(version: 1, push: (), camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0),
        clouds: [(name: \"line\", count: 3, center_m: (0, 0, 0), half_extents_m: (0, 0, 0))])";
    let mut scene = scene_of(text);
    for (body, x) in scene.bodies.iter_mut().zip([-1.0, 0.0, 1.0]) {
        body.position = DVec3::new(x, x, -10.0);
    }
    let mut drive = Drive::of(scene);
    drive.press("Q");
    let points: Vec<_> = drive.session.stage.sim().remaining_bodies().collect();
    let link = |a, b| Link { ends: [a, b], elastic: Elastic::new(9.0, std::f64::consts::SQRT_2) };
    let body = SoftBody { points, springs: [link(0, 1), link(1, 2)].into(), ..SoftBody::default() };
    drive.session.stage.world_mut().spawn(body);
    for x in [0.0, 0.5, -0.7, 1.0] {
        let pixel = drive.pixel(DVec3::new(x, x, -10.0));
        assert_eq!(drive.select(pixel).as_deref(), Some("line"), "{x}");
    }
    for (x, y) in [(0.0, 0.5), (-1.3, -1.3)] {
        let pixel = drive.pixel(DVec3::new(x, y, -10.0));
        assert_eq!(drive.select(pixel), None, "({x}, {y})");
    }
}

#[test]
fn a_held_push_accelerates_a_soft_body_as_one_of_its_mass_and_pins_not_at_all() {
    // A quarter of the points, so that springs between pinned and pushed ones do not pull within the first tick.
    let pinned = vec![0, 1, 2, 3, 4];
    let mut drive = drive(DVec3::ZERO, "", [Soft { pinned: pinned.clone(), ..sheet() }]);
    let (_, body) = soft_body(&mut drive);
    // Points of unlike mass.
    let heavy = PhysicsBody::with_mass(2.0);
    drive.session.stage.world_mut().entity_mut(body.points[12]).insert(heavy);
    assert_eq!(drive.select(SIZE / 2.0).as_deref(), Some("soft"));
    drive.give([down("Right")]).ticks(1).give([up("Right")]);
    let mass = 14.0 * POINT_MASS + 2.0;
    for (number, v) in velocities(&drive, &body).into_iter().enumerate() {
        if pinned.contains(&number) {
            assert_eq!(v, DVec3::ZERO);
        } else {
            close(v.x, 10.0 / mass * H, 1e-12);
            assert_eq!((v.y, v.z), (0.0, 0.0));
        }
    }
}

#[test]
fn a_locked_camera_follows_the_center_of_mass() {
    let mut drive = drive(DVec3::ZERO, "", [sheet()]);
    let (_, body) = soft_body(&mut drive);
    drive.session.stage.world_mut().entity_mut(body.points[0]).insert(PhysicsBody::with_mass(20.0));
    drive.select(SIZE / 2.0);
    drive.press("L");
    let world = &drive.session.stage.sim().world;
    let placed = |point: &Entity| {
        let mass = world.get::<PhysicsBody>(*point).unwrap().mass();
        (world.get::<Transform>(*point).unwrap().position * mass, mass)
    };
    let (moment, mass) =
        body.points.iter().map(placed).fold((DVec3::ZERO, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let camera = drive.session.view.camera();
    let expected = moment / mass + DVec3::new(0.0, 14.0, 20.0);
    assert!(camera.position.distance(expected) < 1e-9, "{} is not {expected}", camera.position);
}

#[test]
fn a_click_beside_it_clears_the_selection_and_removed_points_cannot_be_hit() {
    let mut drive = drive(DVec3::ZERO, "", [sheet()]);
    let (_, body) = soft_body(&mut drive);
    let pixel = drive.pixel(MIDDLE + DVec3::new(0.1, 0.55, 0.0));
    assert!(drive.select(pixel).is_some());
    drive.give([at(SIZE)]).give(click(Button::Left));
    assert_eq!(drive.selected(), None);
    drive.session.stage.world_mut().despawn(body.points[7]);
    drive.ticks(1);
    assert_eq!(drive.select(pixel), None);
}
