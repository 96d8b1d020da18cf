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
        ui.set_width(desk.width(panel::WIDTH));
        match self.shown() {
            Some(rows) => panel::show(ui, rows, self.progress()),
            None => drop(ui.weak("Computing margins of stability")),
        }
    }

    /// Makes this frame compute the forecast again, if the change may affect it.
    fn after_change(&mut self, change: &Change) {
        let is_felt = match change {
            Change::Requests(_) | Change::Method(_) | Change::Substeps(_) => true,
            Change::Step(_) | Change::Push(..) => false,
        };
        if is_felt {
            self.coming = None;
            self.shown.iter_mut().for_each(|shown| shown.age = f64::INFINITY);
        }
    }

    /// Keeps the forecast of an open panel fresh.
    fn after_ticks(&mut self, stage: &mut Stage, _: &View, open: bool, time: FrameTime) {
        if !open {
            (self.shown, self.coming) = (None, None);
            self.advance_frame(stage, false);
            return;
        }
        let of = circumstances(stage);
        let is_known =
            self.shown.as_ref().is_some_and(|shown| shown.of == of && shown.age.is_finite());
        if !is_known && self.coming.as_ref().is_none_or(|(coming, _)| *coming != of) {
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
        if self.shown.is_some() || self.coming.is_some() {
            let of = circumstances(stage);
            self.coming = None;
            self.restart_trial(stage);
            self.refresh(stage, of);
        }
    }
}
