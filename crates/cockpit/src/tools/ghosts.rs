//! Ghosts: the same run with every method, beside a fine reference.

mod edges;
mod panel;
mod picture;
mod state;

use std::collections::BTreeSet;

use egui::{Align2, Painter, Rect, Ui};
use history::Change;
use render::Frame;

use self::state::{MOST_BODIES, Twins};
use crate::actions::Act;
use crate::clock::FrameTime;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::stage::notices::Topic;
use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::View;

pub use state::{GhostRow, GhostState};
pub(crate) use state::{GhostRun, Ghosts};

impl Tool for Ghosts {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::LEFT_CENTER, [8.0, 0.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        panel::show(ui, self, desk);
    }

    /// Makes the ghosts and opens their panel, or removes both. Escape closes only the panel; the next toggle reopens it.
    fn toggle(&mut self, stage: &mut Stage, open: bool) -> bool {
        stage.notices.retract(Topic::Ghosts);
        if open {
            self.twins = None;
            return false;
        }
        if self.twins.is_some() {
            return true;
        }
        if stage.sim().bodies.len() > MOST_BODIES {
            stage
                .notices
                .say(Topic::Other, format!("more than {MOST_BODIES} bodies: too many for ghosts"));
            return false;
        }
        self.begin(stage.sim(), BTreeSet::new());
        true
    }

    /// Handles the action that gives the solid bodies the next method.
    fn take(
        &mut self,
        intent: &Intent,
        stage: &mut Stage,
        _: &View,
        _: bool,
    ) -> Option<Vec<Intent>> {
        let Intent::Act(Act::NextSolid) = intent else { return None };
        if self.twins.is_some() {
            return Some(vec![Intent::Act(Act::NextMethod)]);
        }
        let what = "there are no ghosts to choose from; T shows them";
        stage.notices.say(Topic::Ghosts, what.to_owned());
        Some(Vec::new())
    }

    fn closes_with_scene(&self) -> bool {
        true
    }

    fn after_change(&mut self, change: &Change) {
        if let Some(twins) = &mut self.twins {
            twins.all().for_each(|twin| twin.give(change));
        }
    }

    /// Simulates a tick of the ghosts.
    fn before_tick(&mut self, stage: &Stage, last: bool) {
        self.keep_substeps(stage);
        let Some(twins) = &mut self.twins else { return };
        twins.add_distances(stage);
        for twin in twins.all() {
            if last {
                twin.remember_positions();
            }
            twin.tick();
        }
    }

    fn after_ticks(&mut self, stage: &mut Stage, _: &View, _: bool, _: FrameTime) {
        self.keep_substeps(stage);
        if let Some(twins) = &mut self.twins {
            twins.add_distances(stage);
        }
    }

    fn restart(&mut self, stage: &Stage) {
        if let Some(Twins { hidden, .. }) = self.twins.take() {
            self.begin(stage.sim(), hidden);
        }
    }

    fn draw(&self, stage: &Stage, view: &View, frame: &mut Frame) {
        if let Some(twins) = &self.twins {
            picture::add_ghosts(twins, stage, view, frame);
        }
    }

    fn write(
        &self,
        stage: &Stage,
        view: &View,
        painter: &Painter,
        panel: Option<Rect>,
        taken: Vec<Rect>,
    ) {
        panel::show_labels(painter, &self.labels(stage, view), taken, panel);
    }
}
