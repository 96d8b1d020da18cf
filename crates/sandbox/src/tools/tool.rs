//! What a tool is: something that a key opens beside the picture.

use egui::{Align2, Painter, Rect, Ui};
use history::Change;
use render::Frame;

use crate::clock::FrameTime;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::view::View;

/// What a panel is laid out with.
pub(crate) struct Desk<'a> {
    pub stage: &'a mut Stage,
    pub view: &'a mut View,
    /// Points from side to side that the dock has; a window is as wide as its panel.
    pub dock_width: Option<f32>,
    /// Takes what the person wants.
    pub intents: &'a mut Vec<Intent>,
    /// Set by a panel that is done.
    pub closes: bool,
}

impl Desk<'_> {
    /// The width of a panel that is `wanted` points wide in a window.
    pub fn width(&self, wanted: f32) -> f32 {
        self.dock_width.unwrap_or(wanted)
    }
}

/// Where a panel stands on the screen: a side or a corner, and points from there.
pub(crate) type Anchor = (Align2, [f32; 2]);

/// A tool: its state, and what it does at each point of a frame. All but the panel can be left out.
pub(crate) trait Tool {
    /// Where the panel stands while those of these titles are open.
    fn anchor(&self, open: &[&str]) -> Anchor;

    /// Whether the next scene closes the panel.
    fn closes_with_scene(&self) -> bool {
        false
    }

    /// Lays out the open panel.
    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>);

    /// Its key was pressed while the panel was `open` or not; whether the panel is open after that.
    fn toggle(&mut self, _stage: &mut Stage, open: bool) -> bool {
        !open
    }

    /// Carries out an intent that is for this tool, whose panel is `open` or not; the intents that follow from it. `None` if it is
    /// for another one.
    fn take(
        &mut self,
        _intent: &Intent,
        _stage: &mut Stage,
        _view: &View,
        _open: bool,
    ) -> Option<Vec<Intent>> {
        None
    }

    /// The left button went down in the view. A tool may take the press if what it offers is within `near_px` of the pointer.
    /// Returns the intents that follow; `None` if the press is not for this tool.
    fn press(&mut self, _stage: &Stage, _view: &mut View, _near_px: f64) -> Option<Vec<Intent>> {
        None
    }

    /// The pointer moved.
    fn drag(&mut self, _view: &View) {}

    /// The left button came up; the intents that follow.
    fn release(&mut self, _stage: &Stage) -> Vec<Intent> {
        Vec::new()
    }

    /// A drag is given up; nothing is changed.
    fn let_go(&mut self) {}

    /// Escape was pressed.
    fn cancel(&mut self) {}

    /// Another scene comes, or another text of the same one, `rewritten`.
    fn next_scene(&mut self, _rewritten: bool)
    where
        Self: Sized + Default,
    {
        *self = Self::default();
    }

    /// The stage has another world: of the same scene after a reset or a seek, or of another scene.
    fn restart(&mut self, _stage: &mut Stage) {}

    /// The input of a frame was taken, or a scene was opened.
    fn begin_frame(&mut self, _stage: &mut Stage, _open: bool) {}

    /// The stage got a change between two ticks.
    fn after_change(&mut self, _change: &Change) {}

    /// A tick is about to be simulated; it is the `last` one that is drawn in this frame, or not.
    fn before_tick(&mut self, _stage: &mut Stage, _last: bool) {}

    /// The ticks of a frame are over.
    fn after_ticks(&mut self, _stage: &mut Stage, _view: &View, _open: bool, _time: FrameTime) {}

    /// Adds to the picture.
    fn draw(&self, _stage: &Stage, _view: &View, _frame: &mut Frame) {}

    /// Writes into the picture, not over its own `panel` and not over what is `taken`.
    fn write(
        &self,
        _stage: &Stage,
        _view: &View,
        _painter: &Painter,
        _panel: Option<Rect>,
        _taken: Vec<Rect>,
    ) {
    }

    /// Whether it works without ticks while its panel is open.
    fn works(&self) -> bool {
        false
    }
}
