//! The pull by the pointer, in the picture.

use egui::{Align2, FontId, Painter, Rect, Vec2};
use glam::DVec3;
use render::{Frame, Line};

use crate::stage::Stage;
use crate::stage::pull::Pull;
use crate::view::View;
use crate::view::hud::{SIZE, THIN, point, text};

const COLOR: [f32; 4] = [1.0, 0.8, 0.2, 1.0];

impl View {
    /// Takes the movable thing under the pointer; `None` if there is none.
    pub(crate) fn take(&mut self, stage: &Stage) -> Option<Pull> {
        let ray = self.picking_ray();
        let hit = self.cast(stage, &ray)?;
        let place = ray.at(hit.distance);
        let depth = (place - self.camera.position).dot(self.viewpoint().forward());
        Pull::of(stage, &hit, place, depth)
    }

    /// The target of a pull, m: the point under the pointer, `depth` meters in front of the camera.
    pub(crate) fn pulled_toward(&self, depth: f64) -> DVec3 {
        let ray = self.picking_ray();
        ray.at(depth / ray.direction().dot(self.viewpoint().forward()))
    }

    /// Draws a line from the place that was grabbed to where the pointer wants it. It is no arrow: its damping may push the body
    /// the other way.
    pub(super) fn add_pull(&self, stage: &Stage, frame: &mut Frame) {
        let Some(pull) = &stage.here().pull else { return };
        let Some(middle) = stage.drawn_position(pull.body) else { return };
        let ends = [middle + pull.offset, self.pulled_toward(pull.depth)];
        let [taken, wanted] = ends.map(|place| (place - self.camera.position).as_vec3());
        frame.lines.push(Line::new(taken, wanted, COLOR, 3.0));
    }

    /// Writes the force beside the pointer, or that the run is paused.
    pub(crate) fn write_pull(&self, stage: &Stage, painter: &Painter) -> Option<Rect> {
        let pull = stage.here().pull.as_ref()?;
        let limit = if pull.limited { ", the most" } else { "" };
        let words = match stage.playback().paused() {
            true => "Paused: Play pulls it".to_owned(),
            false => format!("{} N{limit}", report::numbers::digits(pull.newtons)),
        };
        let at = point(painter, self.pointer);
        let font = FontId::proportional(SIZE);
        let at = at + Vec2::new(14.0, -10.0);
        Some(text(painter, at, Align2::LEFT_BOTTOM, &words, font, THIN))
    }
}
