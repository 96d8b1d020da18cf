//! Pictures of soft bodies and springs: relations between pixels, and what a frame holds.

use glam::DVec3;
use motion::{Dormant, Elastic, PhysicsBody, Quarantined, SoftBody, Spring, Transform};
use render::Image;
use sandbox::input::Button;
use scene::{PointRadius, Scene};

use crate::rigs::{FILM_SIZE, Film, Studio, green, places, scene_of, yellow};
use crate::soft::Soft;

/// A floor with its top at y = 0, seen from `eye` at 3 m height along -z, or from behind along +z.
fn stage(eye: f64, shadows: bool) -> Scene {
    let yaw = if eye > 0.0 { 0 } else { 180 };
    let text = format!(
        "(version: 1, push: (),
          camera: (position_m: (0, 3, {eye}), pitch_deg: -10, yaw_deg: {yaw}, fov_y_deg: 45, near_m: 0.1, far_m: 300),
          light: (position_m: (15, 40, 30), color: (0.8, 0.8, 0.5), shadows: {shadows}),
          bodies: [(name: \"floor\", shape: cuboid(half_extents_m: (40, 1, 40)), position_m: (0, -1, 0),
                    immovable: true)])"
    );
    scene_of(&text)
}

/// The stage with these soft bodies, paused, so that nothing moves that is drawn.
fn film(scene: Scene, bodies: impl IntoIterator<Item = Soft>) -> Film {
    let mut film = Film::of(scene);
    film.press("P");
    for body in bodies {
        body.spawn(film.session.stage.world_mut());
    }
    film.frame([]);
    film
}

/// Waves of 0.35 m across a sheet in front of the camera.
fn waves(rows: u32, columns: u32) -> Soft {
    let mut soft = Soft::sheet(rows, columns, |u, v| {
        DVec3::new(4.0 * u - 2.0, 3.6 - 3.0 * v, 0.35 * (12.0 * u + 3.0 * v).sin())
    });
    soft.pinned = (0..=columns as usize).step_by(5).collect();
    soft
}

/// What is drawn of `film` without words, kept beside other evidence to be looked at.
fn draw(studio: &mut Studio, film: &mut Film, name: &str) -> Image {
    let picture = studio.draw_bodies(&mut film.session);
    let folder = crate::rigs::root().join("target/pictures");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(format!("soft_{name}.png")), picture.png(&[]).unwrap()).unwrap();
    picture
}

fn draw_once(film: &mut Film, name: &str) -> Image {
    draw(&mut Studio::new(FILM_SIZE), film, name)
}

fn light([r, g, b, _]: [u8; 4]) -> f64 {
    (f64::from(r) + f64::from(g) + f64::from(b)) / 3.0
}

/// Pixels of `image` that `other` has otherwise.
fn changed(image: &Image, other: &Image) -> Vec<[u8; 4]> {
    let pixels = image.rgba.as_chunks::<4>().0.iter().zip(other.rgba.as_chunks::<4>().0);
    pixels.filter(|(a, b)| a != b).map(|(a, _)| *a).collect()
}

fn mean(pixels: &[[u8; 4]]) -> f64 {
    assert!(pixels.len() > 2000, "only {} pixels", pixels.len());
    pixels.iter().copied().map(light).sum::<f64>() / pixels.len() as f64
}

#[test]
fn a_cloth_is_lit_from_both_sides_and_never_black() {
    let seen = [12.0, -12.0].map(|eye| {
        let empty = draw_once(&mut film(stage(eye, false), []), "empty");
        let name = if eye > 0.0 { "front" } else { "back" };
        let picture = draw_once(&mut film(stage(eye, false), [waves(20, 30)]), name);
        let cloth = changed(&picture, &empty);
        // The pins are dark; they are few.
        let dark = cloth.iter().filter(|pixel| light(**pixel) < 40.0).count();
        assert!(dark < 60, "{name}: {dark} black pixels of {}", cloth.len());
        let shades: std::collections::BTreeSet<_> =
            cloth.iter().map(|pixel| pixel[0] / 8).collect();
        assert!(shades.len() > 5, "{name}: the waves do not show: {shades:?}");
        (cloth.len() as f64, mean(&cloth))
    });
    let [(front_size, front), (back_size, back)] = seen;
    assert!(front > 120.0 && back > 60.0 && front > back + 20.0, "{front} in front, {back} behind");
    assert!((front_size / back_size - 1.0).abs() < 0.15, "{front_size} and {back_size} pixels");
}

#[test]
fn a_cloth_casts_a_shadow_on_the_floor_and_a_ball_on_the_cloth() {
    let flat = || Soft::sheet(8, 8, |u, v| DVec3::new(4.0 * u - 2.0, 2.0, 4.0 * v - 2.0));
    let pictures = [true, false].map(|shadows| {
        let name = if shadows { "shadow" } else { "no_shadow" };
        draw_once(&mut film(stage(12.0, shadows), [flat()]), name)
    });
    let shadow = changed(&pictures[0], &pictures[1]);
    assert!(shadow.len() > 1500, "{} pixels in shadow", shadow.len());
    // A sheet that shaded itself would be as dark as its shadow on the floor.
    let empty = draw_once(&mut film(stage(12.0, true), []), "empty_shadow");
    let cloth_and_shadow = changed(&pictures[0], &empty).len();
    let cloth =
        changed(&pictures[1], &draw_once(&mut film(stage(12.0, false), []), "empty_no_shadow"))
            .len();
    assert!(
        cloth_and_shadow > cloth + 1000,
        "{cloth} pixels of cloth, {cloth_and_shadow} with its shadow"
    );

    let with_ball = [true, false].map(|shadows| {
        let mut film = film(stage(12.0, shadows), [flat()]);
        let ball = pick::Shape::sphere(0.5).unwrap();
        film.session.stage.world_mut().spawn((Transform::at(DVec3::new(0.3, 3.5, 0.0)), ball));
        film.frame([]);
        draw_once(&mut film, if shadows { "ball_shadow" } else { "ball_no_shadow" })
    });
    let more = changed(&with_ball[0], &with_ball[1]).len();
    assert!(more > shadow.len() + 60, "the ball adds no shadow: {} and {more}", shadow.len());
}

#[test]
fn the_view_of_springs_shows_stretched_ones_red_and_compressed_ones_blue() {
    let red = |[r, g, b, _]: [u8; 4]| r > 150 && g < 60 && b < 60;
    let blue = |[r, g, b, _]: [u8; 4]| r < 60 && g < 110 && b > 150;
    for (stretch, name) in [(1.0, "rest"), (1.2, "stretched"), (0.8, "compressed")] {
        let sheet = Soft { stretch, ..Soft::upright(9, 12, DVec3::new(0.0, 2.1, 0.0)) };
        let mut film = film(stage(12.0, true), [sheet]);
        let mut studio = Studio::new(FILM_SIZE);
        let before = draw(&mut studio, &mut film, &format!("surface_{name}"));
        assert_eq!(places(&before, red).len() + places(&before, blue).len(), 0, "{name}");
        film.press("3");
        let springs = draw(&mut studio, &mut film, &format!("springs_{name}"));
        let (reds, blues) = (places(&springs, red).len(), places(&springs, blue).len());
        assert_eq!(
            [reds > 1000, blues > 1000],
            [stretch > 1.0, stretch < 1.0],
            "{name}: {reds}, {blues}"
        );
        assert_eq!(reds.min(blues), 0, "{name}");
        film.press("3");
        assert!(draw(&mut studio, &mut film, "surface_again") == before, "{name}");
    }
}

#[test]
fn a_selected_soft_body_is_green_and_outlined_where_it_is() {
    let at = DVec3::new(0.0, 2.1, 0.0);
    let rope = || Soft::rope(8, DVec3::new(-1.8, 3.6, 0.0), DVec3::new(1.8, 0.6, 0.0));
    for (soft, name) in [(Soft::upright(9, 12, at), "sheet"), (rope(), "rope")] {
        let mut film = film(stage(6.0, true), [soft]);
        let mut studio = Studio::new(FILM_SIZE);
        let before = draw(&mut studio, &mut film, &format!("plain_{name}"));
        assert_eq!(places(&before, |pixel| green(pixel) || yellow(pixel)), []);
        let pixel = film.press("Q").pixel_of(at);
        film.frame([crate::rigs::at(pixel)]).click(Button::Left);
        let selected =
            film.session.stage.selection().unwrap_or_else(|| panic!("{name} is not selected"));
        assert_eq!(film.session.stage.name(selected), "soft");
        let after = draw(&mut studio, &mut film, &format!("selected_{name}"));
        for color in [green, yellow] {
            let places = places(&after, color);
            assert!(places.len() > 200, "{name}: {} pixels", places.len());
            // The middle of their extent: edges of a pixel more or less shift their mean.
            let low = places.iter().copied().reduce(glam::DVec2::min).unwrap();
            let high = places.iter().copied().reduce(glam::DVec2::max).unwrap();
            let off = (0.5 * (low + high)).distance(pixel);
            assert!(off < 12.0, "{name} is seen {off} pixels from where it is");
        }
    }
}

#[test]
fn points_of_soft_bodies_are_no_particles_and_dormant_ones_are_nothing() {
    let mut film = film(stage(12.0, true), [waves(4, 5)]);
    let world = film.session.stage.world_mut();
    let at = Transform::at(DVec3::Y);
    world.spawn((at, PhysicsBody::with_mass(1.0)));
    world.spawn((at, PhysicsBody::with_mass(1.0), PointRadius(0.04)));
    world.spawn((at, PhysicsBody::with_mass(1.0), Dormant));
    world.spawn((at, PhysicsBody::with_mass(1.0), Dormant, pick::Shape::sphere(1.0).unwrap()));
    film.frame([]);
    let frame = film.session.picture();
    let radii: Vec<_> = frame.particles.iter().map(|particle| particle.radius_m).collect();
    let mut free: Vec<_> = radii.iter().copied().filter(|radius| *radius >= 0.04).collect();
    free.sort_unstable_by(f32::total_cmp);
    assert_eq!(free, [0.04, 0.15], "the rest are pins: {radii:?}");
    let [surface] = &frame.surfaces[..] else { panic!("one surface") };
    assert_eq!((surface.vertices.len(), surface.triangles.len()), (30, 40));
    // A pin is a ball close by and a disc far away.
    assert_eq!((frame.cuboids.len(), frame.spheres.len() + frame.particles.len() - 2), (1, 2));
}

#[test]
fn triangles_with_a_quarantined_or_vanished_point_are_left_out() {
    let mut film = film(stage(12.0, true), [Soft::upright(4, 4, DVec3::Y * 2.0)]);
    let world = film.session.stage.world_mut();
    let points = world.query::<&SoftBody>().single(world).unwrap().points.clone();
    let mut count = |change: &dyn Fn(&mut bevy_ecs::world::World)| {
        change(film.session.stage.world_mut());
        film.frame([]);
        film.session.picture().surfaces[0].triangles.len()
    };
    assert_eq!(count(&|_| {}), 32);
    // A point inside has six triangles, and of the corners on this diagonal one has one and one two.
    assert_eq!(
        count(&|world| {
            world.entity_mut(points[12]).insert(Quarantined);
        }),
        26
    );
    assert_eq!(count(&|world| assert!(world.despawn(points[0]))), 25);
}

#[test]
fn a_rope_close_by_has_a_thickness_and_far_away_it_is_a_line() {
    let rope = |z: f64| Soft::rope(10, DVec3::new(-1.0, 4.0, z), DVec3::new(1.0, 2.0, z));
    let mut film = film(stage(12.0, true), [rope(8.0), rope(-60.0)]);
    let frame = film.session.picture();
    assert_eq!((frame.cuboids.len(), frame.lines.len()), (1 + 10, 10));
    // The points close by, and of the far one the pin.
    assert_eq!((frame.spheres.len(), frame.particles.len()), (11, 1));
    assert!(frame.surfaces.is_empty());
    draw_once(&mut film, "ropes");
}

#[test]
fn a_spring_between_bodies_is_a_line_unless_an_end_makes_it_inert() {
    let mut film = film(stage(12.0, true), []);
    let world = film.session.stage.world_mut();
    let ends = [-2.0, 2.0].map(|x| {
        let ball = pick::Shape::sphere(0.4).unwrap();
        world
            .spawn((Transform::at(DVec3::new(x, 2.0, 0.0)), PhysicsBody::with_mass(1.0), ball))
            .id()
    });
    world.spawn(Spring { ends, elastic: Elastic::new(1.0, 5.0) });
    film.frame([]);
    let plain = film.session.picture().lines;
    assert_eq!(plain.len(), 1);
    draw_once(&mut film, "spring");
    film.press("3");
    let [line] = film.session.picture().lines[..] else { panic!("one line") };
    assert!(line.start_color[2] > 0.9 && line.start_color[0] < 0.1, "compressed: {line:?}");
    assert_eq!((line.start, line.end), (plain[0].start, plain[0].end));
    film.session.stage.world_mut().entity_mut(ends[0]).insert(Quarantined);
    film.frame([]);
    assert!(film.session.picture().lines.is_empty());
}

#[test]
fn a_cloth_100_km_from_the_origin_draws_the_same_picture() {
    // Without shadows: the shadow map looks at the world's origin, as the tutorial's does.
    let pictures = [0.0, 1e5].map(|offset| {
        let mut scene = stage(12.0, false);
        let offset = DVec3::new(offset, 0.0, offset);
        scene.camera.position += offset;
        scene.bodies[0].position += offset;
        scene.light.as_mut().unwrap().position += offset;
        let mut cloth = waves(10, 15);
        cloth.places.iter_mut().for_each(|place| *place += offset);
        draw_once(&mut film(scene, [cloth]), "far")
    });
    let difference = crate::rigs::Difference::between(&pictures[0], &pictures[1]);
    assert!(difference.accepted(), "{difference}");
}

#[test]
fn a_scene_without_soft_bodies_has_no_surfaces_and_no_lines() {
    let frame = Film::of(scene::load("tutorial").unwrap()).session.picture();
    assert!(frame.surfaces.is_empty() && frame.lines.is_empty() && frame.particles.is_empty());
}
