//! State hashes of every scene by every method: the same bits on any processor.

use std::fmt::Write as _;

use history::Simulation;
use motion::{Gravity, Method, Request, TimeStep};
use scene::{Scene, StepKind};

/// Ticks of a run.
pub const TICKS: u64 = 240;

/// Ticks before gravity is switched on, or off; `tests/determinism/script.ron` presses the key then.
pub const BEFORE_SWITCH: u64 = 100;

/// Every shipped scene, every hard case, and a chaotic one: bodies on springs swing among three wells, in gusts. A
/// difference between two runs grows more than ten thousand times.
pub fn scenes() -> impl Iterator<Item = Scene> {
    let embedded = scene::shipped().iter().chain(scene::cases());
    let chaos = Scene::parse("chaos", include_str!("chaos.ron")).expect("a scene of the tests");
    embedded.map(|embedded| embedded.load().expect("tests load every scene")).chain([chaos])
}

/// `scene` by each method that can simulate it.
pub fn by_methods(scene: &Scene) -> impl Iterator<Item = Scene> {
    let solved =
        |method: &Method| scene.mutual_gravity.is_none() || *method != Method::ImplicitEuler;
    Method::ALL.into_iter().filter(solved).map(|method| Scene { method, ..scene.clone() })
}

/// Frames a second at which every frame has one tick.
pub fn fps(scene: &Scene) -> f64 {
    if scene.step == StepKind::Frame { 60.0 } else { scene.step_hz }
}

/// A scene that runs in frames of one tick each.
pub struct Run {
    /// The scene as it is now.
    pub simulation: Simulation,
}

impl Run {
    /// Takes a simulation that was just made.
    pub fn of(simulation: Simulation) -> Self {
        Self { simulation }
    }

    /// Simulates the ticks from number `from` on to number `to`.
    pub fn ticks(&mut self, from: u64, to: u64) {
        let Self { simulation } = self;
        let fps = fps(&simulation.scene);
        for tick in from..to {
            if tick == BEFORE_SWITCH
                && let Some(gravity) = simulation.world.get_resource::<Gravity>()
            {
                simulation.request(Request::SwitchGravity(!gravity.on));
            }
            if simulation.scene.step == StepKind::Frame {
                let length = (tick + 1) as f64 / fps - tick as f64 / fps;
                simulation.world.insert_resource(TimeStep(length));
            }
            simulation.tick();
        }
    }
}

/// A line for each scene and method: their names and the state hash after [`TICKS`] ticks.
pub fn hashes() -> String {
    scenes().map(|scene| hashes_of(&scene)).collect()
}

/// The lines of a scene.
pub fn hashes_of(scene: &Scene) -> String {
    let mut lines = String::new();
    for scene in by_methods(scene) {
        let (name, method) = (scene.name.clone(), scene.method.name());
        let mut run = Run::of(Simulation::new(scene));
        run.ticks(0, TICKS);
        let _ = writeln!(lines, "{name} {method} {:016x}", run.simulation.hash());
    }
    lines
}

/// The same for a page or another host of WebAssembly: the number of bytes, which begin at [`hashes_start`].
#[cfg(target_arch = "wasm32")]
#[expect(unsafe_code, reason = "a name that a host finds")]
#[unsafe(no_mangle)]
pub extern "C" fn hashes_length() -> usize {
    TEXT.len()
}

/// Address of the first of [`hashes_length`] bytes.
#[cfg(target_arch = "wasm32")]
#[expect(unsafe_code, reason = "a name that a host finds")]
#[unsafe(no_mangle)]
pub extern "C" fn hashes_start() -> *const u8 {
    TEXT.as_ptr()
}

#[cfg(target_arch = "wasm32")]
static TEXT: std::sync::LazyLock<String> = std::sync::LazyLock::new(hashes);
