//! Small pictures drawn without a window, judged by their pixels.

#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use std::sync::Arc;

use egui::epaint::{Color32, ColorImage, ImageData, ImageDelta};
use glam::{Quat, Vec3, Vec4};
use render::{
    CHECKER, Film, Frame, Gpu, Ground, Image, Instance, Light, Line, OFFSCREEN_FORMAT, OUTLINED,
    Offscreen, Panels, Particle, Quality, RenderError, Renderer, Sprite, wgpu,
};

const SIZE: [u32; 2] = [160, 90];

fn gpu() -> Gpu {
    Gpu::headless().unwrap_or_else(|error| panic!("{error}"))
}

fn frame() -> Frame {
    Frame { size_px: SIZE, ..Frame::default() }
}

fn draw(gpu: &Gpu, frame: &Frame, quality: Quality) -> Image {
    let picture = Offscreen::new(gpu, frame.size_px).unwrap();
    Renderer::new(gpu, OFFSCREEN_FORMAT, quality).draw(gpu, frame, picture.view());
    picture.read(gpu).unwrap()
}

fn body(position: [f32; 3], half: f32, color: [f32; 3]) -> Instance {
    let [red, green, blue] = color;
    Instance {
        position,
        half_extents: [half; 3],
        color: [red, green, blue, 1.0],
        ..Instance::default()
    }
}

fn middle(image: &Image) -> [u8; 4] {
    image.pixel(image.size_px[0] / 2, image.size_px[1] / 2).unwrap()
}

fn differing_pixels(a: &Image, b: &Image) -> usize {
    assert_eq!(a.size_px, b.size_px);
    a.rgba.chunks_exact(4).zip(b.rgba.chunks_exact(4)).filter(|(a, b)| a != b).count()
}

#[test]
fn the_empty_frame_is_sky_over_ground() {
    let image = draw(&gpu(), &frame(), Quality::FIXED);
    let [top, bottom] = [0, SIZE[1] - 1].map(|y| image.pixel(80, y).unwrap());
    assert!(top[2] > top[0] && top[2] > 120, "the sky is not blue: {top:?}");
    assert!(u32::from(top[2]) > u32::from(bottom[2]) + 20, "no ground below: {top:?} {bottom:?}");
    assert!(image.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255));
}

#[test]
fn a_cube_shows_its_color_with_any_light_and_quality() {
    let gpu = gpu();
    let lamp = Light {
        position: Vec3::new(20.0, 30.0, 10.0),
        target: Vec3::ZERO,
        color: Vec3::ONE,
        shadows: true,
    };
    for light in [None, Some(lamp)] {
        for quality in [Quality::FIXED, Quality { shadow_map_px: 64, msaa: 4, ..Quality::FIXED }] {
            for sphere in [false, true] {
                let mut frame = Frame { light, ..frame() };
                let bodies = if sphere { &mut frame.spheres } else { &mut frame.cuboids };
                bodies.push(body([0.0, 0.0, -5.0], 1.0, [1.0, 0.05, 0.05]));
                let [red, green, blue, _] = middle(&draw(&gpu, &frame, quality));
                assert!(
                    red > 60 && red > 2 * green.max(blue),
                    "{light:?} {quality:?} {:?}",
                    [red, green, blue]
                );
            }
        }
    }
}

#[test]
fn the_nearer_body_hides_the_farther_one_in_either_order() {
    let gpu = gpu();
    let near = body([0.0, 0.0, -5.0], 0.5, [0.0, 1.0, 0.0]);
    let far = body([0.0, 0.0, -9.0], 2.0, [1.0, 0.0, 0.0]);
    let pictures = [[near, far], [far, near]]
        .map(|cuboids| draw(&gpu, &Frame { cuboids: cuboids.to_vec(), ..frame() }, Quality::FIXED));
    let [red, green, ..] = middle(&pictures[0]);
    assert!(green > 2 * red, "the farther cube shows: {:?}", middle(&pictures[0]));
    assert_eq!(differing_pixels(&pictures[0], &pictures[1]), 0);
}

#[test]
fn the_camera_orientation_is_from_camera_to_world() {
    // Turned left by 90 degrees, the camera looks along -X.
    let mut frame =
        Frame { cuboids: vec![body([-5.0, 0.0, 0.0], 1.0, [1.0, 0.0, 0.0])], ..frame() };
    frame.camera.orientation = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let [red, green, ..] = middle(&draw(&gpu(), &frame, Quality::FIXED));
    assert!(red > 2 * green);
    let clip =
        frame.camera.view_projection(16.0 / 9.0) * Vec4::new(-frame.camera.near_m, 0.0, 0.0, 1.0);
    assert!((clip.z / clip.w).abs() < 1e-5, "the near plane is not at depth 0: {clip}");
    let clip =
        frame.camera.view_projection(16.0 / 9.0) * Vec4::new(-frame.camera.far_m, 0.0, 0.0, 1.0);
    assert!((clip.z / clip.w - 1.0).abs() < 1e-5, "the far plane is not at depth 1: {clip}");
}

#[test]
fn a_checker_board_has_dark_and_bright_squares() {
    let gpu = gpu();
    let board = Instance { surface: CHECKER, ..body([0.0, 0.0, -4.0], 1.0, [1.0; 3]) };
    let image = draw(&gpu, &Frame { cuboids: vec![board], ..frame() }, Quality::FIXED);
    let row: Vec<bool> =
        (0..SIZE[0]).filter_map(|x| image.pixel(x, 40)).map(|pixel| pixel[0] > 150).collect();
    let changes = row.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!(changes >= 3, "{changes} changes along a row of four squares");
}

#[test]
fn an_outline_surrounds_a_selected_body_and_leaves_its_inside_alone() {
    let gpu = gpu();
    for sphere in [false, true] {
        let pictures = [0, OUTLINED].map(|surface| {
            // A floor right below, and the far wall of it behind: neither may swallow the outline.
            let floor = Instance {
                half_extents: [50.0, 0.5, 50.0],
                ..body([0.0, -1.5, -5.0], 1.0, [0.5; 3])
            };
            let selected = Instance { surface, ..body([0.0, 0.0, -5.0], 1.0, [0.0, 0.6, 0.0]) };
            let mut frame = Frame { cuboids: vec![floor], ..frame() };
            frame.camera.orientation = Quat::from_rotation_x(-0.1);
            if sphere {
                frame.spheres.push(selected);
            } else {
                frame.cuboids.push(selected);
            }
            draw(&gpu, &frame, Quality::FIXED)
        });
        let [plain, outlined] = &pictures;
        assert_eq!(middle(plain), middle(outlined));
        let yellow = |x: u32, y: u32| {
            let [red, green, blue, _] = outlined.pixel(x, y).unwrap();
            red > 200 && green > 170 && blue < 90
        };
        let dark =
            |x: u32, y: u32| outlined.pixel(x, y).unwrap()[..3].iter().all(|&channel| channel < 10);
        for (side, along) in [
            ("left", (0..80).map(|x| (x, 45)).collect::<Vec<_>>()),
            ("right", (80..160).map(|x| (x, 45)).collect()),
            ("top", (0..45).map(|y| (80, y)).collect()),
            ("bottom", (45..90).map(|y| (80, y)).collect()),
        ] {
            let count = along.iter().filter(|(x, y)| yellow(*x, *y)).count();
            assert!((1..=5).contains(&count), "sphere {sphere}, {side}: {count} bright pixels");
            assert!(
                along.iter().any(|(x, y)| dark(*x, *y)),
                "sphere {sphere}, {side}: no dark rim"
            );
        }
        let changed = differing_pixels(plain, outlined);
        assert!((100..2000).contains(&changed), "sphere {sphere}: {changed} pixels changed");
    }
}

#[test]
fn a_cube_throws_its_shadow_on_the_floor_and_nothing_shadows_itself() {
    let gpu = gpu();
    let floor =
        Instance { half_extents: [20.0, 0.5, 20.0], ..body([0.0, -3.5, -12.0], 1.0, [1.0; 3]) };
    let cube = body([0.0, -1.0, -12.0], 1.0, [1.0; 3]);
    let picture = |cuboids: &[Instance], shadows| {
        let light = Light {
            position: Vec3::new(0.0, 60.0, -12.0),
            target: Vec3::new(0.0, -3.0, -12.0),
            color: Vec3::ONE,
            shadows,
        };
        let mut frame = Frame { cuboids: cuboids.to_vec(), light: Some(light), ..frame() };
        frame.camera.orientation = Quat::from_rotation_x(-0.2);
        draw(&gpu, &frame, Quality::FIXED)
    };
    let darker = |dark: &Image, lit: &Image| {
        dark.rgba
            .chunks_exact(4)
            .zip(lit.rgba.chunks_exact(4))
            .filter(|(d, l)| l[1].saturating_sub(d[1]) > 40)
            .count()
    };
    let [shadowed, lit] = [true, false].map(|shadows| picture(&[floor, cube], shadows));
    let count = darker(&shadowed, &lit);
    assert!((50..3000).contains(&count), "{count} pixels in shadow");
    let [shadowed, lit] = [true, false].map(|shadows| picture(&[floor], shadows));
    assert_eq!(differing_pixels(&shadowed, &lit), 0, "the floor shadows itself");
}

#[test]
fn lights_in_awkward_places_draw_something() {
    let gpu = gpu();
    let cuboids = vec![body([0.0, 0.0, -5.0], 1.0, [1.0; 3])];
    for position in [Vec3::ZERO, Vec3::Y * 1e-9, Vec3::Y * 50.0, Vec3::NEG_Y * 50.0, Vec3::Z * 1e6]
    {
        let light = Light { position, target: Vec3::ZERO, color: Vec3::ONE, shadows: true };
        draw(
            &gpu,
            &Frame { cuboids: cuboids.clone(), light: Some(light), ..frame() },
            Quality::FIXED,
        );
    }
}

#[test]
fn lines_arrows_and_particles_are_drawn() {
    let gpu = gpu();
    let empty = draw(&gpu, &frame(), Quality::FIXED);
    let mut with_arrow = frame();
    Line::arrow(
        &mut with_arrow.lines,
        Vec3::new(-1.0, 0.0, -5.0),
        Vec3::new(1.0, 0.0, -5.0),
        [1.0, 0.0, 0.0, 1.0],
        3.0,
    );
    assert_eq!(with_arrow.lines.len(), 2);
    let image = draw(&gpu, &with_arrow, Quality::FIXED);
    assert_eq!(middle(&image), [255, 0, 0, 255]);
    let count = differing_pixels(&empty, &image);
    assert!((100..600).contains(&count), "{count} pixels of arrow");

    // Through the camera and out of it again: the part behind the camera must not come back mirrored.
    let behind =
        Line::new(Vec3::new(0.0, 0.5, 5.0), Vec3::new(0.0, 0.5, -5.0), [1.0, 0.0, 0.0, 1.0], 3.0);
    let image = draw(&gpu, &Frame { lines: vec![behind], ..frame() }, Quality::FIXED);
    let below = (46..90).filter(|&y| image.pixel(80, y) != empty.pixel(80, y)).count();
    assert_eq!(below, 0);
    assert!(differing_pixels(&empty, &image) > 50);

    let particle =
        Particle { position: [0.0, 0.0, -5.0], radius_m: 0.5, color: [1.0, 0.0, 0.0, 1.0] };
    let image = draw(&gpu, &Frame { particles: vec![particle], ..frame() }, Quality::FIXED);
    let [red, green, ..] = middle(&image);
    assert!(red > 100 && green < 60);
    // A disc of 10.9 pixels radius, not the square around it.
    let count = differing_pixels(&empty, &image);
    assert!((340..430).contains(&count), "{count} pixels of particle");

    let mut none = Vec::new();
    Line::arrow(&mut none, Vec3::ONE, Vec3::ONE, [1.0; 4], 3.0);
    Line::arrow(&mut none, Vec3::ONE, Vec3::splat(f32::NAN), [1.0; 4], 3.0);
    assert!(none.is_empty());
}

#[test]
fn a_sprite_is_drawn_out_behind_and_hides_nothing_with_its_edge() {
    let gpu = gpu();
    let empty = draw(&gpu, &frame(), Quality::FIXED);
    let sprite = |streak| Sprite {
        position: [0.0, 0.0, -5.0],
        radius_m: 0.5,
        streak,
        _pad: 0.0,
        color: [1.0, 0.0, 0.0, 1.0],
    };
    let seen = |streak, x: u32| {
        let image = draw(&gpu, &Frame { sprites: vec![sprite(streak)], ..frame() }, Quality::FIXED);
        image.pixel(x, 45) != empty.pixel(x, 45)
    };
    // 10.9 pixels are its radius, and a meter is twice that.
    let (still, right) = ([0.0; 3], [1.0, 0.0, 0.0]);
    assert_eq!([60, 75, 80, 85, 100].map(|x| seen(still, x)), [false, true, true, true, false]);
    assert_eq!([45, 60, 80, 85, 100].map(|x| seen(right, x)), [false, true, true, true, false]);
    // A nearer one, drawn first.
    let near =
        Sprite { position: [-0.35, 0.0, -4.0], color: [0.0, 0.0, 1.0, 1.0], ..sprite(still) };
    let image =
        draw(&gpu, &Frame { sprites: vec![near, sprite(still)], ..frame() }, Quality::FIXED);
    assert!(middle(&image)[0] > 100, "{:?}", middle(&image));
}

#[test]
fn a_ground_has_lines_below_the_horizon_and_space_has_no_horizon() {
    let gpu = gpu();
    let empty = draw(&gpu, &frame(), Quality::FIXED);
    let ground = Ground { height_m: -2.0, spacing_m: 1.0, offset_m: [0.0; 2] };
    let grounded = draw(&gpu, &Frame { ground: Some(ground), ..frame() }, Quality::FIXED);
    let row =
        |image: &Image, y| (0..SIZE[0]).map(|x| image.pixel(x, y).unwrap()).collect::<Vec<_>>();
    assert_eq!(row(&empty, 20), row(&grounded, 20));
    let red = |pixel: &[u8; 4]| pixel[0];
    let below = row(&grounded, 80);
    let (dark, bright) =
        (below.iter().map(red).min().unwrap(), below.iter().map(red).max().unwrap());
    assert!(bright > dark + 10, "no lines: {dark} to {bright}");

    let space = draw(&gpu, &Frame { space: true, ..frame() }, Quality::FIXED);
    let step = |image: &Image| {
        // The darkest pixel of a row is no star.
        let gray = |y| row(image, y).iter().map(|pixel| u32::from(pixel[1])).min().unwrap();
        (1..SIZE[1]).map(|y| gray(y).abs_diff(gray(y - 1))).max().unwrap()
    };
    assert!(step(&empty) > 20 && step(&space) < 4, "{} {}", step(&empty), step(&space));
}

#[test]
fn space_has_the_same_stars_in_every_picture_and_paper_has_none() {
    let gpu = gpu();
    let space = Frame { space: true, soft: true, ..frame() };
    let stars = |image: &Image| {
        let all = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
        all.filter(|(x, y)| image.pixel(*x, *y).unwrap()[0] > 60).collect::<Vec<_>>()
    };
    let seen = stars(&draw(&gpu, &space, Quality::FIXED));
    assert!((50..1000).contains(&seen.len()), "{}", seen.len());
    assert_eq!(stars(&draw(&gpu, &space, Quality::FIXED)), seen);
    let paper = draw(&gpu, &Frame { paper: true, ..space }, Quality::FIXED);
    assert_eq!(stars(&paper).len() as u32, SIZE[0] * SIZE[1], "it is white");
}

#[test]
fn a_ball_is_round_at_every_size() {
    let gpu = gpu();
    for (radius_m, x_m) in [(0.05_f32, 0.0), (0.3, 0.0), (0.3, 1.0), (1.2, 0.0)] {
        let away = 4.0;
        let spheres = vec![body([x_m, 0.0, -away], radius_m, [0.0; 3])];
        // Black on white, so that each pixel says how much of it is covered.
        let frame = Frame { paper: true, spheres, ..frame() };
        let image = draw(&gpu, &frame, Quality::FIXED);
        let covered: f32 =
            image.rgba.chunks_exact(4).map(|pixel| 1.0 - f32::from(pixel[2]) / 255.0).sum();
        // The cone of rays that touch it meets the picture in an ellipse.
        let squared = away * away - radius_m * radius_m;
        let wider = (1.0 + x_m * x_m / squared).sqrt();
        let radius_px = 0.5 * SIZE[1] as f32 * radius_m
            / (squared.sqrt() * (0.5 * frame.camera.fov_y_rad).tan());
        let exact = std::f32::consts::PI * radius_px * radius_px * wider;
        let off = (covered - exact).abs();
        assert!(off < 0.5 + 0.005 * exact, "{radius_m} at {x_m}: {covered} of {exact}");
    }
}

#[test]
fn balls_that_overlap_meet_where_their_surfaces_do() {
    let gpu = gpu();
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    for [first, second] in [[-0.5, 0.5], [0.5, -0.5]] {
        let spheres = [(first, red), (second, blue)]
            .map(|(x, color)| body([x, 0.0, -6.0], 1.0, color))
            .to_vec();
        let frame = Frame { soft: true, spheres, ..frame() };
        let image = draw(&gpu, &frame, Quality::FIXED);
        // The plane between them is seen from its edge.
        for x in 65..95 {
            let [r, _, b, _] = image.pixel(x, 45).unwrap();
            let is_red = (x < 80) == (first < 0.0);
            assert!(if is_red { r > b } else { b > r }, "{first} {x}: {r} {b}");
        }
    }
}

fn panels(context: &egui::Context) -> Panels {
    let input = egui::RawInput {
        screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(160.0, 90.0))),
        ..Default::default()
    };
    let output = context.run_ui(input, |ui| {
        ui.painter().rect_filled(
            egui::Rect::from_min_size(egui::pos2(10.0, 10.0), egui::vec2(20.0, 20.0)),
            0.0,
            Color32::from_rgb(10, 200, 30),
        );
    });
    Panels {
        primitives: context.tessellate(output.shapes, output.pixels_per_point),
        textures_delta: output.textures_delta,
        pixels_per_point: output.pixels_per_point,
    }
}

#[test]
fn panels_are_painted_last_even_if_their_textures_came_with_a_frame_without_area() {
    let gpu = gpu();
    let context = egui::Context::default();
    let picture = Offscreen::new(&gpu, SIZE).unwrap();
    for quality in [Quality::FIXED, Quality { shadow_map_px: 64, msaa: 4, ..Quality::FIXED }] {
        let context = if quality.msaa == 1 { context.clone() } else { egui::Context::default() };
        let mut renderer = Renderer::new(&gpu, OFFSCREEN_FORMAT, quality);
        let minimized =
            Frame { size_px: [0, 90], panels: Some(panels(&context)), ..Frame::default() };
        renderer.draw(&gpu, &minimized, picture.view());
        let near = body([0.0, 0.0, -1.0], 5.0, [1.0; 3]);
        let shown = Frame { cuboids: vec![near], panels: Some(panels(&context)), ..frame() };
        renderer.draw(&gpu, &shown, picture.view());
        assert_eq!(picture.read(&gpu).unwrap().pixel(20, 20), Some([10, 200, 30, 255]));
    }
}

fn busy() -> Frame {
    let mut frame = Frame {
        light: Some(Light {
            position: Vec3::new(-30.0, 20.0, 10.0),
            target: Vec3::new(0.0, 0.0, -10.0),
            color: Vec3::new(0.8, 0.8, 0.5),
            shadows: true,
        }),
        ..frame()
    };
    let floor =
        Instance { half_extents: [30.0, 1.0, 30.0], ..body([0.0, -4.0, -10.0], 1.0, [1.0; 3]) };
    frame.cuboids.push(Instance { surface: CHECKER, ..floor });
    for i in 0..400_u16 {
        let (row, column) = (f32::from(i / 20), f32::from(i % 20));
        let surface = if i % 7 == 0 { CHECKER | OUTLINED } else { CHECKER };
        let one =
            Instance { surface, ..body([column - 10.0, -1.0, -4.0 - row], 0.3, [1.0, 0.8, 0.6]) };
        if i % 2 == 0 {
            frame.cuboids.push(one);
        } else {
            frame.spheres.push(one);
        }
        frame.particles.push(Particle {
            position: [column - 10.0, 1.0, -4.0 - row],
            radius_m: 0.1,
            color: [1.0, 0.5, 0.0, 0.7],
        });
    }
    frame
}

#[test]
fn another_device_draws_the_images_that_egui_sent_to_a_lost_one() {
    let context = egui::Context::default();
    let (mut first, second) = (panels(&context), panels(&context));
    assert!(!first.textures_delta.set.is_empty() && second.textures_delta.set.is_empty());
    // A part of the image is sent again, as when a letter is new: the corner, from which areas have their white.
    let (id, deltas) = first.textures_delta.set.iter().next().unwrap();
    let (id, whole) = (*id, deltas.first().unwrap());
    let part = ImageDelta {
        image: ImageData::Color(Arc::new(ColorImage::filled([8, 4], Color32::RED))),
        pos: Some([0, 0]),
        ..whole.clone()
    };
    first.textures_delta.set.entry(id).or_default().push(part);
    let drawn = |panels: Panels| Frame { panels: Some(panels), ..frame() };
    let (first, second) = (drawn(first), drawn(second));
    let (gpu, other_gpu) = (gpu(), gpu());
    let look = |renderer: &mut Renderer, gpu: &Gpu, frame: &Frame| {
        let picture = Offscreen::new(gpu, SIZE).unwrap();
        renderer.draw(gpu, frame, picture.view());
        picture.read(gpu).unwrap()
    };
    let mut lost = Renderer::new(&gpu, OFFSCREEN_FORMAT, Quality::FIXED);
    look(&mut lost, &gpu, &first);
    let before = look(&mut lost, &gpu, &second);
    let mut other = Renderer::new(&other_gpu, OFFSCREEN_FORMAT, Quality::FIXED);
    assert_eq!(before.pixel(20, 20), Some([10, 0, 0, 255]));
    assert_ne!(look(&mut other, &other_gpu, &second), before, "without the images");
    other.replace(&other_gpu, lost);
    assert_eq!(look(&mut other, &other_gpu, &second), before);
}

#[test]
fn equal_frames_give_equal_bytes() {
    let gpu = gpu();
    let frame = busy();
    let picture = Offscreen::new(&gpu, SIZE).unwrap();
    let mut renderer = Renderer::new(&gpu, OFFSCREEN_FORMAT, Quality::FIXED);
    let mut images = Vec::new();
    for _ in 0..3 {
        renderer.draw(&gpu, &frame, picture.view());
        images.push(picture.read(&gpu).unwrap());
    }
    images.push(draw(&gpu, &frame, Quality::FIXED));
    assert!(images.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn an_srgb_target_stores_the_same_bytes_within_rounding() {
    let gpu = gpu();
    let frame = Frame { particles: Vec::new(), ..busy() };
    let picture = Offscreen::with_format(&gpu, SIZE, wgpu::TextureFormat::Rgba8UnormSrgb).unwrap();
    Renderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, Quality::FIXED).draw(
        &gpu,
        &frame,
        picture.view(),
    );
    let encoded_twice = picture.read(&gpu).unwrap();
    let plain = draw(&gpu, &frame, Quality::FIXED);
    let worst = plain.rgba.iter().zip(&encoded_twice.rgba).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(1), "{worst:?}");
}

#[test]
fn one_renderer_draws_frames_of_any_size_and_any_number_of_bodies() {
    let gpu = gpu();
    let mut renderer = Renderer::new(
        &gpu,
        OFFSCREEN_FORMAT,
        Quality { shadow_map_px: 256, msaa: 4, ..Quality::FIXED },
    );
    for (size_px, count) in [([160, 90], 1), ([1, 1], 5_000), ([333, 77], 0), ([160, 90], 3)] {
        let picture = Offscreen::new(&gpu, size_px).unwrap();
        let cuboids = vec![body([0.0, 0.0, -5.0], 3.0, [1.0, 0.0, 0.0]); count];
        renderer.draw(&gpu, &Frame { size_px, cuboids, ..Frame::default() }, picture.view());
        let image = picture.read(&gpu).unwrap();
        assert_eq!(image.size_px, size_px);
        let [red, green, ..] = middle(&image);
        assert_eq!(red / 2 > green, count > 0, "{size_px:?}: {count} cubes, {red} {green}");
    }
}

#[test]
fn sizes_that_cannot_be_drawn_are_refused_in_words() {
    let gpu = gpu();
    for size_px in [[0, 90], [160, 0], [u32::MAX, 1], [gpu.max_side_px() + 1, 10]] {
        let Err(error) = Offscreen::new(&gpu, size_px) else { panic!("{size_px:?} was accepted") };
        assert!(matches!(error, RenderError::Size { .. }));
        assert!(error.to_string().contains(&size_px[0].to_string()), "{error}");
    }
}

#[test]
fn png_files_keep_every_byte_and_their_text() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("picture.png");
    let image = Image { size_px: [7, 5], rgba: (0..7 * 5 * 4).collect() };
    let text = [("Software", "inertia"), ("Comment", "40 \u{b0}")];
    std::fs::write(&path, image.png(&text).unwrap()).unwrap();
    assert_eq!(Image::read_png(&path).unwrap(), image);
    let read = Image::read_png_text(&path).unwrap();
    assert_eq!(read, text.map(|(keyword, value)| (keyword.to_owned(), value.to_owned())));
    assert!(image.png(&[("", "no keyword")]).is_err());
}

#[test]
fn a_film_shows_every_picture_for_its_time() {
    let shades: [[u8; 6]; 5] =
        [[9, 9, 9, 9, 9, 9], [9, 9, 9, 9, 50, 9], [9, 9, 9, 9, 50, 9], [9, 80, 9, 9, 9, 9], [7; 6]];
    let picture = |shades: [u8; 6]| Image {
        size_px: [3, 2],
        rgba: shades.iter().flat_map(|shade| [*shade, 1, 2, 255]).collect(),
    };
    let spool = || std::io::Cursor::new(Vec::new());
    assert!(Film::new(spool()).finish(std::io::sink(), &[]).is_err(), "no picture is no film");
    let mut film = Film::new(spool());
    for (shades, at_s) in shades.into_iter().zip([0.0, 0.1, 0.2, 0.3, 0.35]) {
        film.add(picture(shades), at_s).unwrap();
    }
    assert!(film.add(Image { size_px: [2, 3], rgba: vec![255; 24] }, 0.4).is_err());

    let mut bytes = Vec::new();
    film.finish(&mut bytes, &[("Scene", "orbit")]).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    assert_eq!(reader.info().animation_control().unwrap().num_plays, 0);
    let mut shown = picture([0; 6]);
    // The third picture is the second one, which stays for both.
    for (expected, milliseconds) in
        [(shades[0], 100), (shades[1], 200), (shades[3], 50), (shades[4], 50)]
    {
        let mut drawn = [0; 24];
        let used = reader.next_frame(&mut drawn).unwrap().buffer_size();
        let control = *reader.info().frame_control().unwrap();
        assert_eq!((control.delay_num, control.delay_den), (milliseconds, 1000));
        for (i, pixel) in drawn[..used].chunks_exact(4).enumerate() {
            let i = u32::try_from(i).unwrap();
            let (x, y) =
                (control.x_offset + i % control.width, control.y_offset + i / control.width);
            let at = 4 * (y * 3 + x) as usize;
            if pixel[3] == 255 {
                shown.rgba[at..at + 4].copy_from_slice(pixel);
            }
        }
        assert_eq!(shown, picture(expected));
    }
    assert!(reader.next_frame(&mut [0; 24]).is_err());
}

#[test]
fn a_crop_is_the_part_asked_for_or_nothing() {
    let image = Image { size_px: [4, 3], rgba: (0..48).collect() };
    let part = image.crop([1, 1], [2, 2]).unwrap();
    assert_eq!(part.pixel(0, 0), image.pixel(1, 1));
    assert_eq!(part.pixel(1, 1), image.pixel(2, 2));
    assert_eq!(image.crop([0, 0], [4, 3]).as_ref(), Some(&image));
    assert_eq!(image.crop([3, 0], [2, 1]), None);
    assert_eq!(image.crop([u32::MAX, 0], [2, 1]), None);
}
