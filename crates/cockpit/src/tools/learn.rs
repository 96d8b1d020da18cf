//! Lessons: what to do next, what to watch, and questions whose answers are measured.

mod missing;
mod panel;
mod state;

use egui::{Align2, Context, Id, Ui};
use motion::Gravity;

use crate::clock::FrameTime;
use crate::panels::{PANELS, Panel};
use crate::stage::Stage;
use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::View;
use crate::view::labels::{Label, around};

pub(crate) use panel::{height, page, welcome};
pub use state::Learn;
pub use state::LessonState;
pub(crate) use state::Screen;

impl Tool for Learn {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::LEFT_BOTTOM, [8.0, -8.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        ui.set_width(desk.width(panel::WIDTH));
        let pointed_at =
            self.points_at().filter(|_| self.is_at_home(desk.stage)).map(str::to_owned);
        ui.ctx().data_mut(|data| data.insert_temp(points_at(), pointed_at));
        panel::show(ui, self, desk);
    }

    /// The cards would lie over the scene.
    fn closes_with_scene(&self) -> bool {
        self.lesson().is_none()
    }

    fn toggle(&mut self, _: &mut Stage, open: bool) -> bool {
        self.welcome = false;
        !open
    }

    /// Keeps the lesson, because lessons go from scene to scene.
    fn next_scene(&mut self, _: bool) {
        self.forget_world();
    }

    fn restart(&mut self, stage: &Stage) {
        self.forget_world();
        self.begin_world(stage);
    }

    fn begin_frame(&mut self, stage: &Stage, open: bool) {
        self.shown = open;
        self.measures = open && self.is_at_home(stage);
    }

    fn after_ticks(&mut self, stage: &mut Stage, _: &View, _: bool, _: FrameTime) {
        let falls = stage.sim().world.get_resource::<Gravity>().is_some_and(|gravity| gravity.on);
        self.tried = [self.tried[0] || stage.here().pull.is_some(), self.tried[1] || falls];
    }
}

impl Learn {
    /// The body at which the present step points, to be marked by a ring.
    pub(crate) fn marked(&self, stage: &Stage, view: &View) -> Option<Label> {
        let name = self.points_at().filter(|_| self.shown && self.is_at_home(stage))?;
        let (_, label) = view.label(stage, stage.sim().named(name)?, "", around)?;
        Some(label)
    }
}

/// Key in egui's memory of the name of the control at which the open lesson points.
fn points_at() -> Id {
    Id::unique("what a lesson points at")
}

/// The name of the control at which the open lesson points.
pub(crate) fn pointed_at(context: &Context) -> Option<String> {
    context.data(|data| data.get_temp::<Option<String>>(points_at())).flatten()
}

/// Makes no lesson point at a control, because the panel of lessons is closed.
pub(crate) fn point_at_nothing(context: &Context) {
    context.data_mut(|data| data.remove_temp::<Option<String>>(points_at()));
}

/// The panel with that name in scripts, if there is one.
pub fn panel_of(name: &str) -> Option<Panel> {
    PANELS.iter().find(|(_, row)| row.name == name).map(|(panel, _)| *panel)
}
