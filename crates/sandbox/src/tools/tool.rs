//! What a tool is: something that a key opens beside the picture.

use egui::{Align2, Painter, Rect, Ui};
use history::Change;
use lab::cost::Setting;
use motion::clock::FrameTime;
use render::Frame;
use scene::TextEdit;

use crate::actions::Act;
use crate::input::SwitchedBy;
use crate::view::stage::Stage;

/// What a person answers to a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    Save,
    Open,
    Discard,
    /// One body alone, or all of its entry.
    Alone,
    All,
    Cancel,
}

/// A change that a panel asks for.
#[derive(Clone, Debug)]
pub(crate) enum Edit {
    /// Changes the simulation.
    Change(Change, SwitchedBy),
    ApplySetting(Setting),
    StepHz(f64),
    /// Goes to the end of that tick.
    Seek(u64),
    SaveBundle,
    /// Saves that text as a CSV file.
    SaveTable(String),
    Open(String),
    /// Changes the scene's text, and restarts it with the entry of that path selected.
    Rewrite(Vec<TextEdit>, Option<String>),
    /// Answers the question that is asked.
    Answer(Answer),
    /// Does an action, as its key does.
    Act(Act),
    /// Simulated seconds per second.
    Pace(f64),
}

/// What a panel is laid out with.
pub(crate) struct Desk<'a> {
    pub stage: &'a mut Stage,
    /// Points from side to side that the dock has; a window is as wide as its panel.
    pub dock_width: Option<f32>,
    /// Gives input, what it does and when, for every key and for the mouse.
    pub keys: fn() -> Vec<(String, &'static str, &'static str)>,
    /// Takes the changes that the person asks for.
    pub edits: &'a mut Vec<Edit>,
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

    /// Whether the cockpit has a place for the panel in its dock; another one stands over the picture.
    fn docks(&self) -> bool {
        true
    }

    /// Lays out the open panel.
    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>);

    /// Its key was pressed while the panel was `open` or not; whether the panel is open after that. No request is pending.
    fn toggle(&mut self, _stage: &mut Stage, open: bool) -> bool {
        !open
    }

    /// Requests of the stage are about to be carried out.
    fn before_requests(&mut self, _stage: &mut Stage) {}

    /// A tick is about to be simulated; it is the `last` one that is drawn in this frame, or not.
    fn before_tick(&mut self, _stage: &Stage, _last: bool) {}

    /// The ticks of a frame are over.
    fn after_ticks(&mut self, _stage: &mut Stage, _open: bool, _time: FrameTime) {}

    /// The stage has another world of the same scene.
    fn restart(&mut self, _stage: &mut Stage) {}

    /// Adds to the picture.
    fn draw(&self, _stage: &Stage, _frame: &mut Frame) {}

    /// Writes into the picture, not over its own `panel` and not over what is `taken`.
    fn write(&self, _stage: &Stage, _painter: &Painter, _panel: Option<Rect>, _taken: Vec<Rect>) {}

    /// Whether it goes on without ticks while its panel is open.
    fn works(&self) -> bool {
        false
    }
}
