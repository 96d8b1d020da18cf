//! How long a frame takes from input to pixels, without a window: `cargo bench -p inertia-sandbox --bench frames [-- SCENE...]`.

#![allow(clippy::unwrap_used, reason = "a benchmark that fails should panic")]

use std::time::Instant;

use cpu_time::ProcessTime;
use render::{Gpu, OFFSCREEN_FORMAT, Offscreen, Quality, Renderer, wgpu};
use sandbox::clock::FrameClock;
use sandbox::input::{Input, InputFrame};
use sandbox::{Options, Session};

const SIZE_PX: [u32; 2] = [1280, 720];
const FRAMES_PER_SECOND: f64 = 60.0;
const WARM_UP: u32 = 30;
const FRAMES: u32 = 150;

fn main() {
    // Cargo adds `--bench`.
    let named: Vec<String> =
        std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let scenes =
        if named.is_empty() { vec!["tutorial".to_owned(), "thousand".to_owned()] } else { named };
    let gpu = Gpu::headless().unwrap();
    let quality = Quality::for_adapter(&gpu.info);
    let mut renderer = Renderer::new(&gpu, OFFSCREEN_FORMAT, quality);
    let picture = Offscreen::new(&gpu, SIZE_PX).unwrap();
    println!(
        "{}; median ms of a frame of {SIZE_PX:?} and processor time of all threads per frame",
        gpu.info
    );
    for scene in &scenes {
        for with_cockpit in [false, true] {
            let (ms, processor_ms) = measure(&gpu, &mut renderer, &picture, scene, with_cockpit);
            let view = if with_cockpit { "with the cockpit" } else { "bare" };
            println!("{scene:20} {view:16} {ms:6.1} {processor_ms:6.1}");
        }
    }
}

fn measure(
    gpu: &Gpu,
    renderer: &mut Renderer,
    picture: &Offscreen,
    scene: &str,
    with_cockpit: bool,
) -> (f64, f64) {
    let options = Options { size_px: SIZE_PX, ..Options::default() };
    let mut session = Session::new(scene::load(scene).unwrap(), options);
    let mut clock = FrameClock::default();
    let mut first = InputFrame::NOTHING;
    if with_cockpit {
        first.events.push(Input::KeyDown("F10".parse().unwrap()));
    }
    let mut times = Vec::new();
    let mut began = ProcessTime::now();
    for frame in 0..WARM_UP + FRAMES {
        if frame == WARM_UP {
            began = ProcessTime::now();
        }
        let start = Instant::now();
        let time = clock.advance_to(f64::from(frame) / FRAMES_PER_SECOND).unwrap();
        let input = std::mem::take(&mut first);
        renderer.draw(gpu, &session.frame(&input, time), picture.view());
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        if frame >= WARM_UP {
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    let processor_ms = began.elapsed().as_secs_f64() * 1e3 / f64::from(FRAMES);
    times.sort_by(f64::total_cmp);
    (times[times.len() / 2], processor_ms)
}
