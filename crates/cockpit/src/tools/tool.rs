//! The trait of tools, each of which a key opens beside the picture.

use egui::{Align2, Painter, Rect, Ui};
use history::Change;
use render::Frame;

use crate::clock::FrameTime;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::view::View;

/// The surroundings of a panel while it is laid out.
pub(crate) struct Desk<'a> {
    pub stage: &'a mut Stage,
    pub view: &'a mut View,
    /// Width of the dock, points; `None` in a window, which is as wide as its panel.
    pub dock_width: Option<f32>,
    /// Collects the intents of the person.
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

/// Place of a panel on the screen: a side or a corner, and the offset from there, points.
pub(crate) type Anchor = (Align2, [f32; 2]);

/// A tool: its state, and what it does at each point of a frame. Only [`Tool::anchor`] and [`Tool::show`] are required.
pub(crate) trait Tool {
    /// Place of the panel while the panels with the titles `open` are open.
    fn anchor(&self, open: &[&str]) -> Anchor;

    /// Whether the next scene closes the panel.
    fn closes_with_scene(&self) -> bool {
        false
    }

    /// Lays out the open panel.
    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>);

    /// Called when the key of the panel is pressed. Returns whether the panel is open after that.
    fn toggle(&mut self, _stage: &mut Stage, open: bool) -> bool {
        !open
    }

    /// Carries out an intent for this tool. Returns the intents that follow from it; `None` if the intent is not for this tool.
    fn take(
        &mut self,
        _intent: &Intent,
        _stage: &mut Stage,
        _view: &View,
        _open: bool,
    ) -> Option<Vec<Intent>> {
        None
    }

    /// Called when the left button goes down in the view. A tool may take the press if what it offers is within `near_px` of the
    /// pointer. Returns the intents that follow; `None` if the press is not for this tool.
    fn press(&mut self, _stage: &Stage, _view: &mut View, _near_px: f64) -> Option<Vec<Intent>> {
        None
    }

    /// Called when the pointer moves.
    fn drag(&mut self, _view: &View) {}

    /// Called when the left button comes up. Returns the intents that follow.
    fn release(&mut self, _stage: &Stage) -> Vec<Intent> {
        Vec::new()
    }

    /// Gives up a drag without a change.
    fn abandon_drag(&mut self) {}

    /// Called when Escape is pressed.
    fn cancel(&mut self) {}

    /// Called when another scene opens or, if `rewritten`, another text of the same scene.
    fn next_scene(&mut self, _rewritten: bool)
    where
        Self: Sized + Default,
    {
        *self = Self::default();
    }

    /// Called when the stage has another world: of the same scene after a reset or a seek, or of another scene.
    fn restart(&mut self, _stage: &Stage) {}

    /// Called after the input of a frame, and after a scene was opened.
    fn begin_frame(&mut self, _stage: &Stage, _open: bool) {}

    /// Called after a change of the stage between two ticks.
    fn after_change(&mut self, _change: &Change) {}

    /// Called before a tick. `last`: it is the last tick of its frame, and pictures are interpolated.
    fn before_tick(&mut self, _stage: &Stage, _last: bool) {}

    /// Called after the ticks of a frame.
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
