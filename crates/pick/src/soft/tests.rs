//! Rays against soft bodies.

use bevy_ecs::world::World;
use motion::Elastic;

use super::*;

/// A soft body and the positions of its points.
struct Sample {
    entity: Entity,
    body: SoftBody,
    blades: Option<Blades>,
    places: Vec<(Entity, SoftPoint)>,
}

fn link(a: u32, b: u32, rest_length: f64) -> Link {
    Link { ends: [a, b], elastic: Elastic::new(1.0, rest_length) }
}

impl Sample {
    fn new(
        world: &mut World,
        places: &[DVec3],
        springs: Vec<Link>,
        triangles: Vec<[u32; 3]>,
    ) -> Self {
        let points: Vec<_> = places.iter().map(|_| world.spawn_empty().id()).collect();
        let place = |(entity, position): (&Entity, &DVec3)| {
            (*entity, SoftPoint { position: *position, movable: true })
        };
        let places = points.iter().zip(places).map(place).collect();
        let entity = world.spawn_empty().id();
        Self {
            entity,
            body: SoftBody { points, springs: springs.into(), triangles, sheet: false },
            blades: None,
            places,
        }
    }

    /// A sheet in the plane z = 0 of `cells` by `cells` squares of 1 m, moved by `offset`.
    fn sheet(world: &mut World, cells: u32, offset: DVec3) -> Self {
        let side = cells + 1;
        let places: Vec<_> = (0..side * side)
            .map(|i| DVec3::new(f64::from(i % side), f64::from(i / side), 0.0) + offset)
            .collect();
        let squares = (0..cells * cells).map(|i| i / cells * side + i % cells);
        let triangles =
            squares.flat_map(|i| [[i, i + 1, i + side + 1], [i, i + side + 1, i + side]]);
        Self::new(world, &places, vec![link(0, 1, 1.0)], triangles.collect())
    }

    fn rope(world: &mut World, places: &[DVec3]) -> Self {
        let links = (1..places.len() as u32).map(|i| link(i - 1, i, 1.0)).collect();
        Self::new(world, places, links, Vec::new())
    }

    fn edit(&mut self, number: usize) -> &mut SoftPoint {
        &mut self.places[number].1
    }
}

fn cast(samples: &[&Sample], anchor: DVec3, ray: &Ray, thinnest: f64) -> Option<SoftHit> {
    let mut targets = SoftTargets::default();
    let all: Vec<_> = samples.iter().flat_map(|sample| &sample.places).copied().collect();
    let point = |entity| all.iter().find(|(point, _)| *point == entity).map(|(_, point)| *point);
    targets.update(
        anchor,
        samples.iter().map(|sample| (sample.entity, &sample.body, sample.blades.as_ref())),
        point,
    );
    let body =
        |entity| samples.iter().find(|sample| sample.entity == entity).map(|sample| &sample.body);
    targets.cast(ray, thinnest, body)
}

fn ray(origin: DVec3, direction: DVec3) -> Ray {
    Ray::new(origin, direction).unwrap()
}

#[test]
fn a_sheet_is_hit_from_both_sides_in_the_cell_that_the_ray_goes_through() {
    let mut world = World::new();
    for offset in [DVec3::ZERO, DVec3::new(1e5, -1e5, 1e5)] {
        let sheet = Sample::sheet(&mut world, 4, offset);
        for (x, y) in [(0.7, 0.2), (3.1, 2.6), (1.9, 3.95)] {
            let target = DVec3::new(x, y, 0.0) + offset;
            for eye in [
                DVec3::new(9.0, 5.0, 12.0),
                DVec3::new(-3.0, 1.0, -7.0),
                DVec3::new(2.0, 2.0, 300.0),
            ] {
                let eye = eye + offset;
                let hit = cast(&[&sheet], eye, &ray(eye, target - eye), 0.0).unwrap();
                assert_eq!(hit.entity, sheet.entity);
                assert!(hit.point.distance(target) < 1e-4, "{} is not {target}", hit.point);
                assert!((hit.distance - eye.distance(target)).abs() < 1e-4);
                let lower = x.fract() > y.fract();
                let square = y as usize * 4 + x as usize;
                assert_eq!(hit.triangle, Some(2 * square + usize::from(!lower)), "{target}");
                let nearest = y.round() as usize * 5 + x.round() as usize;
                assert_eq!(hit.pushed, Some(sheet.body.points[nearest]));
            }
        }
        let past = DVec3::new(4.2, 2.0, 5.0) + offset;
        assert_eq!(cast(&[&sheet], past, &ray(past, DVec3::NEG_Z), 0.0), None);
        let behind = DVec3::new(1.0, 2.0, -5.0) + offset;
        assert_eq!(cast(&[&sheet], behind, &ray(behind, DVec3::NEG_Z), 0.0), None);
    }
}

#[test]
fn a_push_goes_to_the_nearest_corner_that_moves_and_to_none_if_none_does() {
    let mut world = World::new();
    let mut sheet = Sample::sheet(&mut world, 1, DVec3::ZERO);
    let at_first = ray(DVec3::new(0.2, 0.05, 3.0), DVec3::NEG_Z);
    let pushed = |sheet: &Sample| cast(&[sheet], DVec3::ZERO, &at_first, 0.0).unwrap().pushed;
    assert_eq!(pushed(&sheet), Some(sheet.body.points[0]));
    sheet.edit(0).movable = false;
    assert_eq!(pushed(&sheet), Some(sheet.body.points[1]));
    (0..4).for_each(|number| sheet.edit(number).movable = false);
    assert_eq!(pushed(&sheet), None);
}

#[test]
fn a_ray_through_a_hole_misses() {
    let mut world = World::new();
    let mut sheet = Sample::sheet(&mut world, 3, DVec3::ZERO);
    let through = ray(DVec3::new(1.5, 1.6, 3.0), DVec3::NEG_Z);
    let whole = cast(&[&sheet], DVec3::ZERO, &through, 0.0).unwrap().triangle.unwrap();
    sheet.body.triangles.remove(whole);
    assert_eq!(cast(&[&sheet], DVec3::ZERO, &through, 0.0), None);
    // The triangles of a point that is missing, or at NaN, are not hit.
    for hole in [None, Some(DVec3::NAN)] {
        let mut sheet = Sample::sheet(&mut world, 3, DVec3::ZERO);
        match hole {
            None => drop(sheet.places.remove(5)),
            Some(nowhere) => sheet.edit(5).position = nowhere,
        }
        assert_eq!(
            cast(&[&sheet], DVec3::ZERO, &ray(DVec3::new(1.2, 1.1, 3.0), DVec3::NEG_Z), 0.0),
            None
        );
        let beside = ray(DVec3::new(2.6, 2.5, 3.0), DVec3::NEG_Z);
        assert!(cast(&[&sheet], DVec3::ZERO, &beside, 0.0).is_some());
    }
}

#[test]
fn the_nearer_of_two_sheets_is_hit_in_either_order() {
    let mut world = World::new();
    let near = Sample::sheet(&mut world, 2, DVec3::ZERO);
    let far = Sample::sheet(&mut world, 2, DVec3::Z * -0.01);
    let down = ray(DVec3::new(0.7, 0.2, 4.0), DVec3::NEG_Z);
    for samples in [[&near, &far], [&far, &near]] {
        assert_eq!(cast(&samples, DVec3::ZERO, &down, 0.0).unwrap().entity, near.entity);
    }
}

#[test]
fn a_rope_is_hit_at_its_points_and_springs_with_the_radii_that_are_drawn() {
    let mut world = World::new();
    let offset = DVec3::new(1e5, 0.0, -1e5);
    let places = [DVec3::ZERO, DVec3::X, DVec3::new(2.0, 1.0, 0.0)].map(|place| place + offset);
    let rope = Sample::rope(&mut world, &places);
    let eye = offset + DVec3::Z * 8.0;
    let at =
        |x: f64, y: f64| cast(&[&rope], eye, &ray(eye, offset + DVec3::new(x, y, 0.0) - eye), 0.0);
    let (point, link) = (0.12, 0.06);
    for (x, y, number) in
        [(1.0, 0.9 * point, 1), (0.3, 0.9 * link, 0), (0.7, -0.9 * link, 1), (1.7, 0.7, 2)]
    {
        let hit = at(x, y).unwrap_or_else(|| panic!("({x}, {y}) is a miss"));
        assert_eq!(hit.pushed, Some(rope.body.points[number]), "({x}, {y})");
        assert!((hit.distance - 8.0).abs() < 0.15 && hit.triangle.is_none());
    }
    for (x, y) in [(1.0, -1.2 * point), (0.5, 1.2 * link), (-0.2, 0.0), (2.2, 1.2)] {
        assert_eq!(at(x, y), None, "({x}, {y})");
    }
}

#[test]
fn a_ray_along_a_rope_enters_at_its_end() {
    let mut world = World::new();
    let rope = Sample::rope(&mut world, &[DVec3::ZERO, DVec3::X]);
    let hit = cast(&[&rope], DVec3::ZERO, &ray(DVec3::X * 5.0, DVec3::NEG_X), 0.0).unwrap();
    assert!((hit.distance - 3.88).abs() < 1e-9 && hit.pushed == Some(rope.body.points[1]));
    let inside = ray(DVec3::X * 0.5, DVec3::X);
    let hit = cast(&[&rope], DVec3::ZERO, &inside, 0.0).unwrap();
    assert!((hit.distance - 0.38).abs() < 1e-9, "a spring that contains the origin is not hit");
}

#[test]
fn what_is_drawn_at_least_so_wide_is_hit_at_least_so_wide() {
    let mut world = World::new();
    let rope = Sample::rope(&mut world, &[DVec3::ZERO, DVec3::X]);
    let beside = ray(DVec3::new(0.5, 0.5, 100.0), DVec3::NEG_Z);
    assert_eq!(cast(&[&rope], DVec3::ZERO, &beside, 0.004), None);
    assert!(cast(&[&rope], DVec3::ZERO, &beside, 0.006).is_some());
}

#[test]
fn radii_follow_the_mean_spring_between_bounds() {
    let radius =
        |rest: &[f64]| point_radius(&rest.iter().map(|rest| link(0, 1, *rest)).collect::<Vec<_>>());
    assert!((radius(&[0.1, 0.3]) - 0.024).abs() < 1e-12);
    assert_eq!((radius(&[]), radius(&[1e-9]), radius(&[50.0])), (0.002, 0.002, 0.15));
}

#[test]
fn poses_follow_the_bodies_that_there_are() {
    let mut world = World::new();
    let samples = [2, 1].map(|cells| Sample::sheet(&mut world, cells, DVec3::X * 1e5));
    let point = |_| Some(SoftPoint { position: DVec3::new(1e5, 2.0, 0.0), movable: false });
    let mut targets = SoftTargets::default();
    targets.update(DVec3::X * 1e5, samples.iter().map(|s| (s.entity, &s.body, None)), point);
    assert_eq!(targets.poses().iter().map(|pose| pose.points().len()).collect::<Vec<_>>(), [9, 4]);
    targets.update(DVec3::X * 1e5, samples[1..].iter().map(|s| (s.entity, &s.body, None)), point);
    let [pose] = targets.poses() else { panic!("one body") };
    assert_eq!((pose.entity(), pose.points()), (samples[1].entity, &[Vec3::Y * 2.0; 4][..]));
    assert!(!pose.is_movable(0) && !pose.is_movable(9) && pose.corners([0, 9]).is_none());
}

#[test]
fn a_blade_is_hit_where_it_is_drawn_and_pushed_at_the_nearest_point_that_moves() {
    let mut world = World::new();
    let places = [0.0, 1.0, 2.0, 3.0].map(|y| DVec3::new(0.0, y, -5.0));
    let mut blade = Sample::rope(&mut world, &places);
    blade.blades = Some(Blades { points: 4, width: 0.2 });
    for held in [0, 1] {
        blade.edit(held).movable = false;
    }
    let pushed = |x: f64, y: f64| {
        let hit = cast(&[&blade], DVec3::ZERO, &ray(DVec3::new(x, y, 0.0), DVec3::NEG_Z), 0.0)?;
        assert!((hit.distance - 5.0).abs() < 1e-6);
        hit.pushed.map(|point| blade.body.points.iter().position(|other| *other == point).unwrap())
    };
    // Its half width is 0.1 (1 - (y / 3)²), and between the points that are held it is in the ground.
    assert_eq!([pushed(0.0, 0.5), pushed(0.08, 1.1), pushed(0.095, 1.1)], [None, Some(2), None]);
    assert_eq!([pushed(0.0, 2.9), pushed(0.04, 2.1), pushed(-0.04, 2.6)], [Some(3), Some(2), None]);
}
