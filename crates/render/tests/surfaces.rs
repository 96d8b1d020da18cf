//! Surfaces that move on their own, judged by their pixels.

#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use glam::Vec3;
use render::{
    Frame, Gpu, Image, Instance, Light, OFFSCREEN_FORMAT, Offscreen, Quality, Renderer, Surface,
};

const SIZE: [u32; 2] = [160, 90];

const RED: [f32; 4] = [1.0, 0.05, 0.05, 1.0];

fn gpu() -> Gpu {
    Gpu::headless().unwrap_or_else(|error| panic!("{error}"))
}

fn frame() -> Frame {
    Frame { size_px: SIZE, ..Frame::default() }
}

fn draw(gpu: &Gpu, renderer: &mut Renderer, frame: &Frame) -> Image {
    let picture = Offscreen::new(gpu, frame.size_px).unwrap();
    renderer.draw(gpu, frame, picture.view());
    picture.read(gpu).unwrap()
}

fn middle(image: &Image) -> [u8; 4] {
    image.pixel(SIZE[0] / 2, SIZE[1] / 2).unwrap()
}

/// A square of 2 m around the line of sight, `far` away, of `cells` by `cells`.
fn square(far: f32, cells: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let side = cells + 1;
    let at = |i: u32| i as f32 / cells as f32 * 2.0 - 1.0;
    let points = (0..side * side).map(|i| Vec3::new(at(i % side), at(i / side), -far)).collect();
    let corner = (0..cells * cells).map(move |i| i / cells * side + i % cells);
    let triangles =
        corner.flat_map(|i| [[i, i + 1, i + side + 1], [i, i + side + 1, i + side]]).collect();
    (points, triangles)
}

fn red([r, g, b, _]: [u8; 4]) -> bool {
    r > 50 && r / 2 > g.max(b)
}

#[test]
fn both_sides_show_the_color_with_any_light_and_quality() {
    let gpu = gpu();
    let lamp = |z| Light {
        position: Vec3::new(6.0, 9.0, z),
        target: Vec3::new(0.0, 0.0, -5.0),
        color: Vec3::ONE,
        shadows: true,
    };
    for quality in [Quality::FIXED, Quality { shadow_map_px: 64, msaa: 4, ..Quality::FIXED }] {
        let mut renderer = Renderer::new(&gpu, OFFSCREEN_FORMAT, quality);
        // A lamp in front of the surface and one behind, which shines through it.
        for light in [None, Some(lamp(10.0)), Some(lamp(-20.0))] {
            for seen_from_behind in [false, true] {
                let (points, mut triangles) = square(5.0, 4);
                if seen_from_behind {
                    triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
                }
                let surfaces = vec![Surface::smooth(&points, triangles, RED)];
                let image = draw(&gpu, &mut renderer, &Frame { light, surfaces, ..frame() });
                assert!(red(middle(&image)), "{light:?} {quality:?} {:?}", middle(&image));
            }
        }
    }
}

#[test]
fn a_body_in_front_of_a_surface_hides_it_and_one_behind_does_not() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu, OFFSCREEN_FORMAT, Quality::FIXED);
    for (z, hidden) in [(-3.0, true), (-7.0, false)] {
        let (points, triangles) = square(5.0, 4);
        let green = Instance {
            position: [0.0, 0.0, z],
            color: [0.0, 1.0, 0.0, 1.0],
            ..Instance::default()
        };
        let surfaces = vec![Surface::smooth(&points, triangles, RED)];
        let image = draw(&gpu, &mut renderer, &Frame { surfaces, cuboids: vec![green], ..frame() });
        assert_eq!(red(middle(&image)), !hidden, "{:?}", middle(&image));
    }
}

#[test]
fn surfaces_may_grow_multiply_and_vanish() {
    let gpu = gpu();
    let mut renderer = Renderer::new(&gpu, OFFSCREEN_FORMAT, Quality::FIXED);
    let empty = draw(&gpu, &mut renderer, &frame());
    let mut reds = Vec::new();
    // The second is larger than the buffers are at the start.
    for cells in [1, 100, 2] {
        let (points, triangles) = square(5.0, cells);
        let far: Vec<_> = points.iter().map(|point| *point + Vec3::new(2.5, 0.0, 0.0)).collect();
        let surfaces = vec![
            Surface { outlined: true, ..Surface::smooth(&points, triangles.clone(), RED) },
            Surface::smooth(&far, triangles, RED),
        ];
        let image = draw(&gpu, &mut renderer, &Frame { surfaces, ..frame() });
        let yellow = |pixel: &&[u8; 4]| pixel[0] > 200 && pixel[1] > 200 && pixel[2] < 100;
        let pixels = image.rgba.as_chunks::<4>().0;
        assert!(pixels.iter().filter(yellow).count() > 200, "the first has an outline");
        reds.push(pixels.iter().filter(|pixel| red(**pixel)).count());
    }
    assert!(reds[0] > 1000 && reds.iter().all(|count| *count == reds[0]), "{reds:?}");
    assert!(draw(&gpu, &mut renderer, &frame()) == empty, "something is left of the surfaces");
}
