//! The lesson strip, the list of lessons, and the welcome card of the first start.

use std::sync::{Arc, LazyLock};

use egui::{
    Align, Align2, Button, Context, Frame, Image, Key, LayerId, Layout, Pos2, Rect, RichText, Role,
    ScrollArea, Sense, Shadow, Stroke, TextEdit, Ui, Vec2, WidgetInfo, Window,
};
use scene::lesson::{Goal, Lesson, LessonStep, shipped};

use super::Learn;
use crate::actions::Act;
use crate::intent::Intent;
use crate::panels::Panel;
use crate::tools::thumbnails::PICTURE;
use crate::tools::tool::{Desk, Tool as _};

/// Width of the lesson in its own window, points.
pub(super) const WIDTH: f32 = 560.0;

/// Height of the strip in the cockpit on a screen of that width, points. Fixed, so that the view keeps its size from step to step.
pub(crate) fn height(width: f32) -> f32 {
    if width < NARROW { 250.0 } else { 168.0 }
}

/// Width of a screen on which the words of a step take several lines, points.
const NARROW: f32 = 600.0;

/// Radius of the dot of a step, points.
const DOT: f32 = 4.0;

/// Size of the task, points.
const TASK: f32 = 16.0;

/// Height of the row of answers, points.
const ANSWERS: f32 = 26.0;

/// The lessons shipped with the program.
static LESSONS: LazyLock<Vec<Arc<Lesson>>> = LazyLock::new(|| {
    let lessons = shipped().iter().filter_map(|(name, text)| Lesson::parse(name, text).ok());
    lessons.map(Arc::new).collect()
});

/// Lays out the open lesson, or the list of lessons.
pub(super) fn show(ui: &mut Ui, learn: &mut Learn, desk: &mut Desk<'_>) {
    // A window sizes itself to its content; the strip and the page have a fixed height and scroll.
    if desk.dock_width.is_none() && learn.lesson().is_some() {
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

/// Lays out the page of lessons over `view`.
pub(crate) fn page(context: &Context, view: Rect, learn: &mut Learn, desk: &mut Desk<'_>) {
    let inside = Frame::window(&context.global_style()).shadow(Shadow::NONE).corner_radius(0.0);
    let margin = inside.total_margin().sum();
    desk.dock_width = Some(view.width() - margin.x);
    let behind = context.layer_painter(LayerId::background()).with_clip_rect(view);
    behind.rect_filled(view, 0.0, inside.fill);
    let page = Window::new("Lessons").title_bar(false).resizable(false).collapsible(false);
    page.frame(inside).fixed_pos(view.min).fixed_size(view.size() - margin).show(context, |ui| {
        learn.show(ui, desk);
    });
}

/// Lays out the lessons as cards, in groups.
fn list(ui: &mut Ui, learn: &mut Learn, desk: &mut Desk<'_>) {
    ui.horizontal(|ui| {
        ui.label("Each lesson says what to do, and measures what it claims.");
        if ui.button("Close").clicked() {
            desk.intents.push(Intent::Act(Act::Panel(Panel::Learn)));
        }
    });
    for (title, names) in GROUPS {
        ui.add_space(6.0);
        ui.label(RichText::new(title).strong());
        ui.horizontal_wrapped(|ui| {
            for name in names {
                let of_name = |lesson: &&Arc<Lesson>| lesson.name == *name;
                if let Some(lesson) = LESSONS.iter().find(of_name) {
                    card(ui, learn, lesson, desk.intents);
                }
            }
        });
    }
    if learn.own.is_empty() {
        return;
    }
    ui.add_space(6.0);
    ui.label(RichText::new("Your files").strong());
    ui.horizontal_wrapped(|ui| {
        for (path, title) in &learn.own {
            if ui.button(title).on_hover_text(path.display().to_string()).clicked() {
                desk.intents.push(Intent::Open(path.to_string_lossy().into_owned()));
            }
        }
    });
}

/// The shipped lessons by what they are about.
const GROUPS: [(&str, &[&str]); 3] = [
    ("Forces", &["force", "mass", "gravity", "feather", "momentum", "resonance", "further_work"]),
    ("Methods", &["eulers", "verlet", "runge_kutta", "energy"]),
    ("Stability", &["frame_time", "springs"]),
];

/// Size of a card, points.
const CARD: Vec2 = Vec2::new(190.0, 148.0);

fn card(ui: &mut Ui, learn: &mut Learn, lesson: &Arc<Lesson>, intents: &mut Vec<Intent>) {
    let done = if learn.done.contains(&lesson.name) { "✔ " } else { "" };
    let words = format!("{done}{}", lesson.title);
    let left = learn.left.get(&lesson.name).copied();
    ui.allocate_ui_with_layout(CARD, Layout::top_down(Align::Min), |ui| {
        ui.set_min_size(CARD);
        let card = ui.vertical(|ui| {
            let picture = learn.pictures.of(ui.ctx(), &lesson.scene).map(|texture| {
                // Without focus: the keyboard goes from title to title.
                let image = Image::from_texture((texture.id(), PICTURE));
                ui.add(Button::image(image).sense(Sense::CLICK))
            });
            let title = ui.add(Button::new(words).wrap().min_size(Vec2::new(PICTURE.x + 8.0, 0.0)));
            picture.map_or(title.clone(), |picture| picture.union(title))
        });
        let about = format!("{} Belongs to: {}", lesson.about, lesson.page);
        let mut opens = card.inner.on_hover_text(about).clicked();
        ui.horizontal(|ui| {
            ui.weak(format!("{} min", lesson.minutes));
            if let Some(left) = left {
                opens |= ui.link(format!("Continue at step {}", left + 1)).clicked();
                if ui.link("Start again").clicked() {
                    learn.left.remove(&lesson.name);
                    opens = true;
                }
            }
        });
        if opens {
            intents.push(Intent::OpenLesson(lesson.name.clone()));
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
    ui.spacing_mut().item_spacing.y = 2.0;
    ui.horizontal(|ui| {
        ui.label(RichText::new(&lesson.title).strong());
        progress(ui, number, lesson.steps.len());
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
            // Last, so that the others keep their places.
            let shows = home && learn.offers_solution(desk.stage.playback().now());
            if shows && ui.button("Show me").on_hover_text("the solution of this step").clicked() {
                learn.show_solution();
            }
        });
    });
    let verdict = learn.verdict().unwrap_or_default();
    match learn.claim_held() {
        true if verdict.is_empty() => ui.label(""),
        true => ui.label(RichText::new(format!("✔ {verdict}")).color(ui.visuals().hyperlink_color)),
        false => ui.colored_label(ui.visuals().warn_fg_color, verdict),
    };
    let Some(step) = step else { return at_end(ui, learn, lesson, desk.intents) };
    if !home {
        ui.label("This lesson plays in another scene.");
        if let Some(scene) = learn.home().filter(|_| ui.button("Open its scene").clicked()) {
            desk.intents.push(Intent::Open(scene));
        }
        return;
    }
    ui.label(RichText::new(&step.task).strong().size(TASK));
    ui.label(&step.watch);
    let now = desk.stage.playback().now();
    ui.horizontal_wrapped(|ui| {
        ui.set_min_height(ANSWERS);
        goal(ui, learn, &step.goal, now);
    });
    if let Some(hint) = learn.hint(now) {
        ui.weak(format!("Hint: {hint}"));
    }
}

/// A dot for each step, filled up to the present one.
fn progress(ui: &mut Ui, number: usize, of: usize) {
    let color = ui.visuals().weak_text_color();
    for step in 0..of {
        let (place, _) = ui.allocate_exact_size(Vec2::splat(2.0 * DOT + 2.0), Sense::hover());
        if step < number {
            ui.painter().circle_filled(place.center(), DOT, color);
        } else {
            ui.painter().circle_stroke(place.center(), DOT, Stroke::new(1.5, color));
        }
    }
    ui.weak(if number < of { format!("step {} of {of}", number + 1) } else { "done".to_owned() });
}

/// What the step asks for, and what is said about what the person gave.
fn goal(ui: &mut Ui, learn: &mut Learn, goal: &Goal, now: f64) {
    match goal {
        Goal::Done { .. } => {
            if let Some(missing) = learn.missing(now) {
                ui.weak(format!("Not yet: {}.", missing.trim_end_matches('.')));
            }
            return;
        }
        Goal::Number { unit, .. } => {
            let field = ui.add(
                TextEdit::singleline(&mut learn.typed).desired_width(90.0).hint_text("a number"),
            );
            ui.label(unit);
            field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "answer"));
            let enter = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let typed = learn.typed.clone();
            if (ui.button("Answer").clicked() || enter) && !typed.trim().is_empty() {
                learn.answer(&typed);
            }
        }
        Goal::Choice { choices, .. } => {
            for choice in choices {
                // A second click on the last answer does not answer this question.
                let button = ui.add_enabled(learn.is_ready(now), Button::new(&choice.say));
                if button.clicked() {
                    learn.answer(&choice.say);
                }
            }
        }
    }
    if let Some(rejection) = learn.rejection() {
        ui.colored_label(ui.visuals().warn_fg_color, rejection);
    }
}

fn at_end(ui: &mut Ui, learn: &mut Learn, lesson: &Lesson, intents: &mut Vec<Intent>) {
    let helped: Vec<_> = learn.helped().map(|step| (step + 1).to_string()).collect();
    if !helped.is_empty() {
        ui.label(format!(
            "The lesson is marked ✔ once you do this yourself (Previous): step {}.",
            helped.join(", ")
        ));
    }
    let mut names = GROUPS.iter().flat_map(|(_, names)| *names);
    let next = names.find(|name| **name == lesson.name).and_then(|_| names.next());
    let next = next.and_then(|next| LESSONS.iter().find(|other| other.name == *next));
    ui.horizontal(|ui| {
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
        let things =
            ["Drag a ball.", "Press Gravity, or the key G: everything falls, through the floor."];
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
