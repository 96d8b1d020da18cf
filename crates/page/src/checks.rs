//! What scripts/test-web asks of a page beside its events.

use cockpit::app::pupil;
use lab::cost::{Bench, Plan, Subject};
use motion::Transform;
use wasm_bindgen::prelude::*;

use crate::Page;

/// The lines of `tests/determinism/methods.txt` for scene number `number`, computed here.
#[wasm_bindgen]
pub fn hashes_of(number: usize) -> Option<String> {
    hashes::scenes().nth(number).map(|scene| hashes::hashes_of(&scene))
}

/// Names of the lessons.
#[wasm_bindgen]
pub fn lessons() -> Vec<String> {
    scene::lesson::shipped().iter().map(|(name, _)| (*name).to_owned()).collect()
}

/// What `sandbox lessons check` prints.
#[wasm_bindgen]
pub fn check_lesson(name: &str) -> Result<String, JsError> {
    let lesson = scene::lesson::load(name).map_err(|error| JsError::new(&error.to_string()))?;
    pupil::check(&lesson).map_err(|error| JsError::new(&error.to_string()))
}

/// The study of the first half second of a scene, as JSON.
#[wasm_bindgen]
pub fn study_of(scene: &str) -> Result<String, JsError> {
    let failed = |error: &dyn ToString| JsError::new(&error.to_string());
    let scene = scene::load(scene).map_err(|error| failed(&error))?;
    let plan = Plan { longer: 0, rates: false, ..Plan::quick(1) };
    let mut bench = Bench::new(Subject::of_scene(scene, Some(0.5)), plan);
    while !bench.work(1.0) {}
    serde_json::to_string(bench.study()).map_err(|error| failed(&error))
}

/// Fails as a fault of the program does.
#[wasm_bindgen]
pub fn panic(why: &str) {
    panic!("{why}");
}

#[wasm_bindgen]
impl Page {
    /// The pixel of the canvas at which the middle of a body is seen.
    pub fn pixel_of(&self, body: &str) -> Option<Vec<f64>> {
        let shell = self.0.borrow();
        let (view, sim) = (&shell.session.view, shell.session.stage.sim());
        let place = sim.world.get::<Transform>(sim.named(body)?)?.position;
        let [corner, size] = view.view_area();
        Some((corner + view.viewpoint().project(place, size)?).to_array().to_vec())
    }
}
