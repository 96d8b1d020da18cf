//! The forecast: how near everything is to instability.

mod panel;
mod state;

use egui::{Align2, Ui};
use history::Change;

use self::state::{FRESH_LARGE_S, FRESH_S, LARGE_NET, circumstances};
use crate::clock::FrameTime;
use crate::stage::Stage;
use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::View;

pub(crate) use state::{Forecast, rows};

impl Tool for Forecast {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::LEFT_BOTTOM, [8.0, -8.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        if let Some(rows) = self.shown() {
            ui.set_width(desk.width(panel::WIDTH));
            panel::show(ui, rows, self.progress());
        }
    }

    /// Makes this frame compute the forecast again, if the change may affect it.
    fn after_change(&mut self, change: &Change) {
        let is_felt = match change {
            Change::Requests(_) | Change::Method(_) | Change::Substeps(_) => true,
            Change::Step(_) | Change::Push(..) => false,
        };
        if let Some(shown) = self.shown.as_mut().filter(|_| is_felt) {
            shown.age = f64::INFINITY;
        }
    }

    /// Keeps the forecast of an open panel fresh.
    fn after_ticks(&mut self, stage: &mut Stage, _: &View, open: bool, time: FrameTime) {
        if !open {
            self.shown = None;
            self.advance_frame(stage, false);
            return;
        }
        let of = circumstances(stage);
        let is_new =
            self.shown.as_ref().is_none_or(|shown| shown.of != of || shown.age.is_infinite());
        if is_new {
            self.restart_trial(stage);
        }
        self.advance_frame(stage, true);
        let fresh = if of.structure[1] > LARGE_NET { FRESH_LARGE_S } else { FRESH_S };
        if let Some(shown) = &mut self.shown {
            shown.age += time.length();
            if shown.of == of && shown.age < fresh {
                return;
            }
        }
        self.refresh(stage, of);
    }

    fn restart(&mut self, stage: &Stage) {
        if self.shown.is_some() {
            let of = circumstances(stage);
            self.restart_trial(stage);
            self.refresh(stage, of);
        }
    }
}
