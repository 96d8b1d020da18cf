//! The lesson strip, the list of lessons, and the welcome card of the first start.

use std::sync::{Arc, LazyLock};

use egui::{
    Align, Align2, Button, Context, Key, Layout, Pos2, RichText, Role, ScrollArea, TextEdit, Ui,
    WidgetInfo, Window,
};
use scene::lesson::{Goal, Lesson, LessonStep, shipped};

use super::Learn;
use crate::actions::Act;
use crate::intent::Intent;
use crate::panels::Panel;
use crate::tools::tool::Desk;

/// Width of the lesson in its own window, points.
pub(super) const WIDTH: f32 = 560.0;

/// Height of the strip in the cockpit, points. Fixed, so that the view keeps its size from step to step.
pub(crate) const HEIGHT: f32 = 132.0;

/// The lessons shipped with the program.
static LESSONS: LazyLock<Vec<Arc<Lesson>>> = LazyLock::new(|| {
    let lessons = shipped().iter().filter_map(|(name, text)| Lesson::parse(name, text).ok());
    lessons.map(Arc::new).collect()
});

/// Lays out the open lesson, or the list of lessons.
pub(super) fn show(ui: &mut Ui, learn: &mut Learn, desk: &mut Desk<'_>) {
    // A window sizes itself to its content; the strip has a fixed height and scrolls.
    if desk.dock_width.is_none() {
        return show_all(ui, learn, desk);
    }
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        show_all(ui, learn, desk);
    });
}

fn show_all(ui: &mut Ui, learn: &mut Learn, desk: &mut Desk<'_>) {
    match learn.lesson() {
        Some((lesson, step, _)) => {
            let lesson = Arc::clone(lesson);
            running(ui, learn, (&lesson, step, lesson.steps.get(step)), desk);
        }
        None => list(ui, learn, desk),
    }
    if let Some(fault) = &learn.fault {
        ui.colored_label(ui.visuals().error_fg_color, fault);
    }
}

fn list(ui: &mut Ui, learn: &mut Learn, desk: &mut Desk<'_>) {
    ui.label(
        "Lessons: each says what to do, continues when it is done, and measures what it claims.",
    );
    ui.horizontal_wrapped(|ui| {
        for (number, lesson) in LESSONS.iter().enumerate() {
            let done = if learn.done.contains(&lesson.name) { "✔ " } else { "" };
            let words = format!("{done}{} {}", number + 1, lesson.title);
            let about =
                format!("{} {} min. Belongs to: {}", lesson.about, lesson.minutes, lesson.page);
            if ui.button(words).on_hover_text(about).clicked() {
                desk.intents.push(Intent::OpenLesson(lesson.name.clone()));
            }
        }
        for (path, title) in &learn.own {
            if ui.button(title).on_hover_text(path.display().to_string()).clicked() {
                desk.intents.push(Intent::Open(path.to_string_lossy().into_owned()));
            }
        }
        if ui.button("Close").clicked() {
            desk.intents.push(Intent::Act(Act::Panel(Panel::Learn)));
        }
    });
}

fn running(
    ui: &mut Ui,
    learn: &mut Learn,
    (lesson, number, step): (&Lesson, usize, Option<&LessonStep>),
    desk: &mut Desk<'_>,
) {
    let home = learn.is_at_home(desk.stage);
    ui.horizontal(|ui| {
        let of = lesson.steps.len();
        let place =
            if step.is_some() { format!("{} of {of}", number + 1) } else { "done".to_owned() };
        ui.label(RichText::new(format!("{}: {place}", lesson.title)).strong());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui
                .button("Leave")
                .on_hover_text("close this lesson; the list of lessons comes back")
                .clicked()
            {
                learn.leave();
            }
            let skip = ui.add_enabled(step.is_some(), Button::new("Skip"));
            if skip.on_hover_text("continue without doing it").clicked() {
                learn.skip();
            }
            if ui
                .add_enabled(number > 0, Button::new("Previous"))
                .on_hover_text("the step before")
                .clicked()
            {
                learn.go_back();
            }
        });
    });
    let rejection = learn.rejection().map(str::to_owned);
    if let Some(verdict) = learn.verdict() {
        match learn.claim_held() {
            true => {
                ui.label(RichText::new(format!("✔ {verdict}")).color(ui.visuals().hyperlink_color))
            }
            false => ui.colored_label(ui.visuals().warn_fg_color, verdict),
        };
    }
    let Some(step) = step else { return at_end(ui, learn, lesson, desk.intents) };
    if !home {
        ui.label("This lesson plays in another scene.");
        if let Some(scene) = learn.home().filter(|_| ui.button("Open its scene").clicked()) {
            desk.intents.push(Intent::Open(scene));
        }
        return;
    }
    ui.label(RichText::new(&step.task).strong());
    if !step.watch.is_empty() {
        ui.label(&step.watch);
    }
    if let Some((missing, hint)) = learn.missing(desk.stage.playback().now()) {
        let words = hint.map(|hint| format!("Hint: {hint}"));
        let missing = Some(missing).filter(|missing| !missing.is_empty());
        let missing = missing.map(|missing| format!("Not yet: {missing}."));
        ui.weak(missing.into_iter().chain(words).collect::<Vec<_>>().join(" "));
    }
    match &step.goal {
        Goal::Done { .. } => {}
        Goal::Number { unit, .. } => {
            ui.horizontal(|ui| {
                let field = ui.add(
                    TextEdit::singleline(&mut learn.typed)
                        .desired_width(90.0)
                        .hint_text("a number"),
                );
                ui.label(unit);
                field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "answer"));
                let enter = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
                let typed = learn.typed.clone();
                if (ui.button("Answer").clicked() || enter) && !typed.trim().is_empty() {
                    learn.answer(&typed);
                }
                show_rejection(ui, rejection.as_deref());
            });
        }
        Goal::Choice { choices, .. } => {
            ui.horizontal_wrapped(|ui| {
                for (say, _) in choices {
                    if ui.button(say).clicked() {
                        learn.answer(say);
                    }
                }
                show_rejection(ui, rejection.as_deref());
            });
        }
    }
}

fn show_rejection(ui: &mut Ui, rejection: Option<&str>) {
    if let Some(rejection) = rejection {
        ui.colored_label(ui.visuals().warn_fg_color, rejection);
    }
}

fn at_end(ui: &mut Ui, learn: &mut Learn, lesson: &Lesson, intents: &mut Vec<Intent>) {
    if learn.skipped() {
        ui.label("A step was skipped: the lesson is marked ✔ when all steps are done in one go.");
    }
    let here = LESSONS.iter().position(|other| other.name == lesson.name);
    ui.horizontal(|ui| {
        let next = here.and_then(|here| LESSONS.get(here + 1));
        if let Some(next) = next.filter(|next| ui.button(format!("Next: {}", next.title)).clicked())
        {
            intents.push(Intent::OpenLesson(next.name.clone()));
        }
        if ui.button("All lessons").clicked() {
            learn.leave();
        }
    });
}

/// Lays out the welcome card, with the middle of its lower edge at `place`.
pub(crate) fn welcome(
    context: &Context,
    place: Pos2,
    learn: &mut Learn,
    intents: &mut Vec<Intent>,
) {
    let mut stays = true;
    let card = Window::new("Welcome").collapsible(false).resizable(false).open(&mut stays);
    card.pivot(Align2::CENTER_BOTTOM).fixed_pos(place).show(context, |ui| {
        let things = ["Drag a ball.", "Press G: everything falls, through the floor."];
        for (words, done) in things.into_iter().zip(learn.tried) {
            ui.label(if done { format!("✔ {words}") } else { words.to_owned() });
        }
        let Some(first) = LESSONS.first() else { return };
        if ui.button(format!("Start the first lesson ({} min)", first.minutes)).clicked() {
            intents.push(Intent::OpenLesson(first.name.clone()));
        }
    });
    learn.welcome &= stays;
}
