//! The panels and words of a frame, laid out from the session.

use std::sync::Arc;

use egui::{Id, LayerId, Rect, Window};
use motion::clock::{FrameClock, FrameTime};

use crate::actions;
use crate::app::session::Session;
use crate::app::ui::Question;
use crate::app::ui::{Ui, show_focus};
use crate::tools::Tools;
use crate::tools::tool::{Answer, Desk, Edit};
use crate::view::card::{self, Selected};
use crate::view::stage::Stage;
use crate::view::{hud, marks};

/// Lays out all that is written over the picture; the changes that the person asks for.
fn lay_out(ui: &mut Ui, root: &mut egui::Ui, stage: &mut Stage, tools: &mut Tools) -> Vec<Edit> {
    let (mut edits, mut windows) = (Vec::new(), Vec::new());
    let titles: Vec<_> = ui.opened().iter().map(|panel| panel.row().title).collect();
    let opened = ui.opened().to_owned();
    let (context, docks) = (root.ctx().clone(), ui.cockpit.shown);
    if docks {
        ui.cockpit.show(root, &opened, stage, tools, &mut edits);
    }
    ui.view = root.available_rect_before_wrap();
    let [r, g, b, _] = root.visuals().panel_fill.to_array();
    stage.run.surround = [r, g, b];
    stage.run.view_px = docks.then(|| pixels(ui.view, context.pixels_per_point()));
    for (panel, tool) in tools.each().filter(|(panel, _)| ui.shows(*panel)) {
        if docks && tool.docks() {
            continue;
        }
        let (place, inward) = tool.anchor(&titles);
        let window = Window::new(panel.row().title).resizable(false).collapsible(false).anchor(place, inward);
        let mut desk =
            Desk { stage, dock_width: None, keys: actions::rows, edits: &mut edits, closes: false };
        let shown = window.show(&context, |ui| tool.show(ui, &mut desk));
        windows.push((panel, shown.map(|shown| shown.response.rect), desk.closes));
    }
    if let Some(question) = &ui.question {
        let scene = &stage.sim.scene;
        edits.extend(ask(&context, question, &scene.name, &tools.editor.file(scene)));
    }
    windows.iter().filter(|(.., closes)| *closes).for_each(|(panel, ..)| ui.close(*panel));
    show_focus(&context);
    if !stage.run.options.hud {
        return edits;
    }
    let painter = context.layer_painter(LayerId::new(egui::Order::Background, Id::unique("hud")));
    let painter = painter.with_clip_rect(ui.view);
    let mut taken = hud::places(&painter, stage);
    marks::show(&painter, &stage.visible_labels(), &mut taken);
    taken.extend(stage.fault_mark().map(|mark| marks::show_mark(&painter, &mark)));
    for (panel, tool) in tools.each() {
        let window = windows.iter().find(|(other, ..)| *other == panel).and_then(|(_, rect, _)| *rect);
        tool.write(stage, &painter, window, taken.clone());
    }
    hud::show(&painter, stage);
    stage.write_pull(&painter);
    let selected = stage.seen.selection.filter(|_| !docks).and_then(|thing| Selected::of(stage, thing));
    if let Some(selected) = selected {
        card::show(&context, &selected, stage.sim.method());
    }
    edits
}

/// Asks a question.
fn ask(context: &egui::Context, question: &Question, scene: &str, file: &str) -> Option<Edit> {
    let (words, answers) = match question {
        Question::Leaving(_) => (
            format!("The changes of {scene} are not saved."),
            vec![
                (format!("Save as {file}"), Answer::Save),
                ("Discard them".to_owned(), Answer::Discard),
                ("Stay".to_owned(), Answer::Cancel),
            ],
        ),
        Question::LeftBehind(_) => (
            "A window was closed before its changes were saved.".to_owned(),
            vec![
                ("Open them".to_owned(), Answer::Open),
                ("Delete them".to_owned(), Answer::Discard),
                ("Ask again next time".to_owned(), Answer::Cancel),
            ],
        ),
        Question::Deleting { name, entry, alone } => {
            let (count, alone) =
                (entry.bodies.len(), alone.map(|_| ("Delete it alone".to_owned(), Answer::Alone)));
            let others =
                [(format!("Delete all {count}"), Answer::All), ("Keep it".to_owned(), Answer::Cancel)];
            let words = format!("{name} is one of the {count} bodies that {} makes.", entry.path());
            (words, alone.into_iter().chain(others).collect())
        }
    };
    let asked = egui::Modal::new(Id::unique("question")).show(context, |ui| {
        ui.label(words);
        ui.add_space(8.0);
        let row = ui.horizontal(|ui| {
            answers.into_iter().fold(None, |answered, (words, answer)| {
                let button = ui.button(words);
                // The keyboard answers, too.
                if ui.memory(|memory| memory.focused().is_none()) {
                    button.request_focus();
                }
                if button.clicked() { Some(answer) } else { answered }
            })
        });
        row.inner
    });
    asked.inner.map(Edit::Answer)
}

/// Left, top, width and height of `rect`, of which a point has `scale` pixels.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "pixels of a picture")]
fn pixels(rect: Rect, scale: f32) -> [u32; 4] {
    let [left, top, right, bottom] = [rect.left(), rect.top(), rect.right(), rect.bottom()]
        .map(|edge| (edge * scale).round().max(0.0) as u32);
    [left, top, right.saturating_sub(left).max(1), bottom.saturating_sub(top).max(1)]
}

impl Session {
    /// Lays the panels out for this frame and does what the person changed in them.
    pub(crate) fn lay_out_panels(&mut self, time: FrameTime) {
        self.notices.expire(time.total());
        let Self { stage, tools, ui, .. } = self;
        let (mut edits, text) = (Vec::new(), Arc::clone(&stage.sim.scene.text));
        ui.run(time, |ui, root| edits.extend(lay_out(ui, root, stage, tools)));
        for edit in edits {
            // Places in one text are others in the text that a change before made of it.
            let stale = matches!(edit, Edit::Rewrite(..)) && !Arc::ptr_eq(&text, &self.sim.scene.text);
            if !stale {
                self.edit(edit);
            }
        }
        for action in std::mem::take(&mut self.ui.postponed) {
            self.edit(Edit::Act(action));
        }
    }

    /// Lays the panels out for a picture of the present state, between two frames.
    pub(crate) fn lay_out_still(&mut self) {
        if let Ok(now) = FrameClock::default().advance_to(self.clock.now()) {
            // A card that is new stands at its place in the layout after those that measure it.
            (0..2).for_each(|_| self.lay_out_panels(now));
        }
    }
}
