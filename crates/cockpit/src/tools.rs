//! The tools: everything that a key opens beside the picture, one folder or file each, and the one list of them.

pub(crate) mod cost;
mod curves;
pub(crate) mod editor;
pub mod effects;
pub(crate) mod finder;
pub(crate) mod forecast;
pub(crate) mod ghosts;
mod graphs;
mod help;
pub mod learn;
pub(crate) mod ledger;
pub(crate) mod number;
mod settings;
pub(crate) mod thumbnails;
mod timeline;
pub(crate) mod tool;

use std::path::PathBuf;
use std::sync::Arc;

use bevy_ecs::entity::Entity;
use lab::ReceiptLine;
use lab::cost::Study;
use motion::ledger::Ledger;

use self::ghosts::GhostRow;
use self::learn::{LessonState, Screen};
use self::tool::Tool;
use crate::clock::FrameTime;
use crate::intent::Intent;
use crate::panels::{Panel, with_panels};
use crate::stage::{SceneFile, Stage};
use crate::view::View;
use report::ForecastRow;

/// Makes the struct of all tools from the list of panels.
macro_rules! tools {
    ($($Tool:ident in $tool:ident: $name:literal, $key:tt, $title:literal, $what:literal;)*) => {
        /// The state of all tools of a scene.
        #[derive(Default)]
        pub struct Tools {
            $(pub(crate) $tool: $tool::$Tool,)*
        }

        impl Tools {
            /// All tools, in the order of the rows.
            pub(crate) fn each(&mut self) -> impl Iterator<Item = (Panel, &mut dyn Tool)> {
                [$((Panel::$Tool, &mut self.$tool as &mut dyn Tool),)*].into_iter()
            }

            /// Tells every tool that another scene was opened or, if `rewritten`, another text of the same scene.
            pub(crate) fn next_scene(&mut self, rewritten: bool) {
                $(self.$tool.next_scene(rewritten);)*
            }
        }
    };
}

with_panels!(tools);

impl Tools {
    /// The lessons.
    pub fn lessons(&mut self) -> &mut learn::Learn {
        &mut self.learn
    }

    /// The study behind the panel of costs, while it runs.
    pub fn study(&mut self) -> Option<&mut lab::cost::Bench> {
        self.cost.live.as_mut().map(|live| &mut live.bench)
    }

    /// Whether ghosts are shown.
    #[must_use]
    pub fn shows_ghosts(&self) -> bool {
        self.ghosts.are_shown()
    }

    /// Hands an intent to the tool that handles it. Returns the intents that follow from it; `None` if no tool handles it.
    pub(crate) fn take(
        &mut self,
        intent: &Intent,
        stage: &mut Stage,
        view: &View,
        opened: &[Panel],
    ) -> Option<Vec<Intent>> {
        self.each()
            .find_map(|(panel, tool)| tool.take(intent, stage, view, opened.contains(&panel)))
    }

    /// Hands a press of the left button to the open tool that handles it. Returns the intents that follow from it; `None` if no
    /// tool handles it.
    pub(crate) fn press(
        &mut self,
        stage: &Stage,
        view: &mut View,
        near_px: f64,
        opened: &[Panel],
    ) -> Option<Vec<Intent>> {
        let mut open = self.each().filter(|(panel, _)| opened.contains(panel));
        open.find_map(|(_, tool)| tool.press(stage, view, near_px))
    }

    /// Tells every tool that the ticks of a frame are over.
    pub(crate) fn after_ticks(
        &mut self,
        stage: &mut Stage,
        view: &View,
        opened: &[Panel],
        time: FrameTime,
    ) {
        for (panel, tool) in self.each() {
            tool.after_ticks(stage, view, opened.contains(&panel), time);
        }
        self.graphs.sample(stage, &self.ghosts, opened.contains(&Panel::Graphs));
        let screen = Screen { view, opened, ghosts: &self.ghosts, ledger: &self.ledger };
        self.learn.end_frame(stage, &screen, time.total());
    }

    /// Tells every tool that a tick comes: see [`Tool::before_tick`].
    pub(crate) fn before_tick(&mut self, stage: &Stage, view: &View, opened: &[Panel], last: bool) {
        self.each().for_each(|(_, tool)| tool.before_tick(stage, last));
        let screen = Screen { view, opened, ghosts: &self.ghosts, ledger: &self.ledger };
        self.learn.look(stage, &screen);
    }

    /// How much of its limit a spring between two bodies uses, while the forecast is shown.
    pub(crate) fn spring_ratio(&self) -> Option<impl Fn([Entity; 2]) -> f64> {
        let forecast = &self.forecast;
        forecast.shown().map(|_| |ends| forecast.spring_ratio(ends).unwrap_or(0.0))
    }

    /// Notes that the file has the text of the scene now.
    pub fn saved_scene(&mut self, stage: &mut Stage, file: &SceneFile) {
        self.editor.saved(stage, file);
    }

    /// The file that saving replaces, and its text when it was opened or saved last.
    #[must_use]
    pub fn own_file(&self) -> Option<(PathBuf, Arc<str>)> {
        self.editor.own_file()
    }

    /// Keeps a ledger from now on, whether its panel is open or not.
    pub fn keep_ledger(&mut self, stage: &Stage) {
        self.ledger.always = true;
        self.ledger.keep(stage, true);
    }

    /// The ledger, if one is kept.
    #[must_use]
    pub fn ledger(&self) -> Option<&Ledger> {
        self.ledger.kept()
    }

    /// A row for every method and, last, for the reference; empty while no ghosts are shown.
    #[must_use]
    pub fn ghosts(&self, stage: &Stage) -> Vec<GhostRow> {
        self.ghosts.rows(stage)
    }

    /// How far everything is from instability now, the worst first.
    #[must_use]
    pub fn forecast(stage: &Stage) -> Vec<ForecastRow> {
        forecast::rows(stage)
    }

    /// Computes the forecast at the start of a scene with frames of that length, s. Keeps the rows with a fault and those that grow
    /// slowly for the summary; tells and returns those with a fault.
    pub fn forecast_start(&mut self, stage: &mut Stage, frame: f64) -> Vec<ForecastRow> {
        self.forecast.compute(stage, frame)
    }

    /// Begins the forecast of [`Self::forecast_start`], which goes on from frame to frame and tells the faults that it finds.
    pub fn forecast_begin(&mut self, stage: &mut Stage, frame: f64) {
        self.forecast.begin(stage, frame);
    }

    /// The rows of the forecast at the start of the scene that have a fault, or grow slowly.
    #[must_use]
    pub fn forecast_at_start(&self) -> &[ForecastRow] {
        self.forecast.at_start()
    }

    /// The forecast of the open panel, the worst first.
    #[must_use]
    pub fn shown_forecast(&self) -> Option<&[ForecastRow]> {
        self.forecast.shown()
    }

    /// The study of the running scene so far, while its panel is open.
    #[must_use]
    pub fn cost_study(&self) -> Option<&Study> {
        self.cost.study()
    }

    /// The part of the study that is done, in [0, 1].
    #[must_use]
    pub fn cost_progress(&self) -> f64 {
        self.cost.progress()
    }

    /// Progress in the open lesson.
    #[must_use]
    pub fn lesson(&self) -> Option<LessonState> {
        self.learn.state()
    }

    /// The receipt of the session as it is: its effects, their causes and the number of bodies of each; evaluations per step are
    /// counted since the last look, and times are from the last measurement.
    pub fn receipt(&mut self, stage: &Stage, view: &View) -> Vec<ReceiptLine> {
        self.effects.receipt(stage, view)
    }
}
