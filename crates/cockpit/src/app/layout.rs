//! The panels and words of a frame, laid out from the session.

use egui::{Color32, Id, LayerId, Rect, Window};

use crate::app::focus::show_focus;
use crate::app::ui::Ui;
use crate::intent::{Answer, Intent, Question};
use crate::panels::Panel;
use crate::stage::Stage;
use crate::stage::options::Words;
use crate::tools::tool::Desk;
use crate::tools::{Tools, learn};
use crate::view::card::{self, Selected};
use crate::view::{View, hud, marks};
use crate::words::plain;

/// Distance from the bottom of the view to the welcome card, points: below what the scene shows.
const WELCOME_ABOVE: f32 = 56.0;

/// Lays out everything that is written over the picture. Returns the intents of the person.
pub(super) fn lay_out(
    ui: &mut Ui,
    root: &mut egui::Ui,
    stage: &mut Stage,
    view: &mut View,
    tools: &mut Tools,
) -> Vec<Intent> {
    let (mut intents, mut windows) = (Vec::new(), Vec::new());
    let titles: Vec<_> = ui
        .opened()
        .iter()
        .filter(|panel| ui.lays_out(**panel))
        .map(|panel| panel.row().title)
        .collect();
    let opened = ui.opened().to_owned();
    let (context, docks) = (root.ctx().clone(), ui.cockpit.shown);
    if docks {
        ui.cockpit.show(root, &opened, stage, view, tools, &mut intents);
    }
    ui.view = root.available_rect_before_wrap();
    let [r, g, b, _] = root.visuals().panel_fill.to_array();
    view.surround = [r, g, b];
    view.view_px = docks.then(|| pixels(ui.view, context.pixels_per_point()));
    if !ui.shows(Panel::Learn) {
        learn::point_at_nothing(&context);
    }
    if docks && ui.shows(Panel::Learn) && tools.learn.lesson().is_none() {
        let mut desk = Desk { stage, view, dock_width: None, intents: &mut intents, closes: false };
        learn::page(&context, ui.view, &mut tools.learn, &mut desk);
    }
    if docks && tools.learn.welcome {
        let place = ui.cockpit.free.center_bottom() - egui::Vec2::Y * WELCOME_ABOVE;
        learn::welcome(&context, place, &mut tools.learn, &mut intents);
    }
    let has_windows = stage.options().words != Words::Paper;
    hud::write_on_paper(&context, !has_windows);
    for (panel, tool) in tools.each().filter(|(panel, _)| has_windows && ui.lays_out(*panel)) {
        // In the cockpit a lesson has its strip, and pictures without the tutorial's words show no panel of it.
        let has_place = docks || stage.options().words != Words::All;
        if (docks && panel.tab().is_some()) || (has_place && panel == Panel::Learn) {
            continue;
        }
        let (place, inward) = tool.anchor(&titles);
        let window = Window::new(panel.row().title)
            .resizable(false)
            .collapsible(false)
            .anchor(place, inward);
        let mut desk = Desk { stage, view, dock_width: None, intents: &mut intents, closes: false };
        let shown = window.show(&context, |ui| tool.show(ui, &mut desk));
        windows.push((panel, shown.map(|shown| shown.response.rect), desk.closes));
    }
    if let Some(question) = &ui.question {
        let file = tools.editor.file_to_save(&stage.sim().scene);
        intents.extend(ask(&context, question, &file));
    }
    windows.iter().filter(|(.., closes)| *closes).for_each(|(panel, ..)| ui.close(*panel));
    show_focus(&context);
    let words = stage.options().words;
    if words == Words::None {
        return intents;
    }
    let painter = context.layer_painter(LayerId::new(egui::Order::Background, Id::unique("hud")));
    let painter = painter.with_clip_rect(if docks { ui.cockpit.free } else { ui.view });
    let has_all = words == Words::All;
    let scene = &stage.sim().scene;
    let has_springs = !scene.springs.is_empty() || !scene.soft_bodies.is_empty();
    view.margins = has_springs && tools.spring_ratio().is_some();
    let mut taken = if has_all { hud::places(&painter, stage, view) } else { Vec::new() };
    // In the cockpit an open lesson says what there is to see.
    if (docks && !ui.shows(Panel::Learn)) || words == Words::Captions {
        let lesson = tools.learn.caption().filter(|_| ui.shows(Panel::Learn));
        let words = lesson.or_else(|| stage.caption.clone());
        let words = words.unwrap_or_else(|| stage.sim().scene.description.clone());
        taken.extend(hud::caption(&painter, stage, view, &words));
    }
    if let Some(marked) = tools.learn.marked(stage, view) {
        let lines = [(5.0, Color32::from_black_alpha(140)), (2.5, marks::POINTER)];
        marks::ring(&painter, &marked, &lines);
        taken.push(marks::ring_place(&painter, &marked));
    }
    taken.extend(tools.editor.places(stage, view, &painter));
    taken.extend(view.write_pull(stage, &painter));
    if view.is_own_look(stage) {
        taken.extend(view.write_flash(stage, &painter));
    }
    marks::show(&painter, &view.visible_labels(stage), &mut taken);
    taken.extend(view.fault_mark(stage).map(|mark| marks::show_mark(&painter, &mark)));
    for (panel, tool) in tools.each() {
        let window =
            windows.iter().find(|(other, ..)| *other == panel).and_then(|(_, rect, _)| *rect);
        tool.write(stage, view, &painter, window, taken.clone());
    }
    if has_all {
        hud::show(&painter, stage, view);
    }
    let selected = stage
        .selection()
        .filter(|_| !docks && has_all)
        .and_then(|thing| Selected::of(stage, thing));
    if let Some(selected) = selected {
        card::show(&context, &selected, stage.sim().method());
    }
    intents
}

/// Asks a question.
fn ask(context: &egui::Context, question: &Question, file: &str) -> Option<Intent> {
    let (words, answers) = match question {
        Question::Leaving(_) => (
            "The changes of this scene are not saved.".to_owned(),
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
            let others = [
                (format!("Delete all {count}"), Answer::All),
                ("Keep it".to_owned(), Answer::Cancel),
            ];
            let words =
                format!("{name} is one of the {count} bodies that {} makes.", plain(&entry.path()));
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
    asked.inner.map(Intent::Answer)
}

/// Left, top, width and height of `rect`, pixels; a point has `scale` pixels.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "pixels of a picture")]
fn pixels(rect: Rect, scale: f32) -> [u32; 4] {
    let [left, top, right, bottom] = [rect.left(), rect.top(), rect.right(), rect.bottom()]
        .map(|edge| (edge * scale).round().max(0.0) as u32);
    [left, top, right.saturating_sub(left).max(1), bottom.saturating_sub(top).max(1)]
}
