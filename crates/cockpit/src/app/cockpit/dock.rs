//! The dock at the right: a tab per role, with the selection or a section for every tool.

use egui::style::ScrollAnimation;
use egui::text::{LayoutJob, TextFormat};
use egui::{
    Align, Button, CollapsingHeader, Color32, Response, Role, ScrollArea, TextStyle, Ui, Vec2,
    WidgetInfo,
};
use motion::effects::{self, Effect, EffectState};
use report::numbers::capital;

use crate::actions::Act;
use crate::app::focus::{frame_if_lesson_names, reveal_focus};
use crate::intent::Intent;
use crate::panels::{PANELS, Panel, Tab};
use crate::stage::Stage;
use crate::tools::Tools;
use crate::tools::tool::Desk;
use crate::view::View;
use crate::view::card::{self, Selected};
use crate::view::hud::bodies;

/// Height of a tile, points: four lines.
const TILE: f32 = 76.0;

/// The panels whose sections are open.
pub(super) struct OpenPanels<'a> {
    pub opened: &'a [Panel],
    /// The one that is scrolled to.
    pub newest: Option<Panel>,
}

/// Lays out the tabs and the sections of the chosen one. Returns the first control.
pub(super) fn show(
    ui: &mut Ui,
    tab: &mut Tab,
    OpenPanels { opened, newest }: OpenPanels<'_>,
    stage: &mut Stage,
    view: &mut View,
    tools: &mut Tools,
    intents: &mut Vec<Intent>,
) -> Response {
    let first = tabs(ui, tab, opened, intents);
    ui.separator();
    ScrollArea::vertical().id_salt(*tab as usize).auto_shrink(false).show(ui, |ui| {
        match *tab {
            Tab::Look => selection(ui, stage, view),
            Tab::Measure => questions(ui, opened, intents),
            Tab::Build | Tab::Past => {}
        }
        let mut sections: Vec<_> =
            tools.each().filter(|(panel, _)| panel.tab() == Some(*tab)).collect();
        // Last, because its height depends on how long measuring took: sections below it would not be where a recording clicked.
        sections.sort_by_key(|(panel, _)| *panel == Panel::Cost);
        for (panel, tool) in sections {
            let row = panel.row();
            let header = CollapsingHeader::new(row.title).open(Some(opened.contains(&panel)));
            let shown = header.show(ui, |ui| {
                sideways(ui, row.name, |ui| {
                    let dock_width = Some(ui.max_rect().width());
                    let mut desk = Desk { stage, view, dock_width, intents, closes: false };
                    tool.show(ui, &mut desk);
                });
            });
            let header =
                shown.header_response.on_hover_text(format!("{} ({})", row.what, row.keys[0]));
            frame_if_lesson_names(ui, row.title, &header);
            if newest == Some(panel) {
                header.scroll_to_me_animation(Some(Align::TOP), ScrollAnimation::none());
            }
            if header.clicked() {
                intents.push(Intent::Act(Act::Panel(panel)));
            }
        }
        reveal_focus(ui);
    });
    first
}

/// Lays out the row of tabs. Returns the first one. A tab that would be empty opens its first panel.
fn tabs(ui: &mut Ui, chosen: &mut Tab, opened: &[Panel], intents: &mut Vec<Intent>) -> Response {
    let row = ui.horizontal_wrapped(|ui| {
        let buttons = Tab::ALL.map(|tab| {
            let [icon, name, what] = tab.words();
            let button =
                ui.add(Button::selectable(*chosen == tab, (icon, name))).on_hover_text(what);
            button.widget_info(|| WidgetInfo::selected(Role::Button, true, *chosen == tab, name));
            if *chosen != tab {
                frame_if_lesson_names(ui, name, &button);
                let titles = PANELS.iter().filter(|(panel, _)| panel.tab() == Some(tab));
                titles.for_each(|(_, row)| frame_if_lesson_names(ui, row.title, &button));
            }
            if button.clicked() {
                *chosen = tab;
                let own =
                    || PANELS.iter().map(|(panel, _)| *panel).filter(|it| it.tab() == Some(tab));
                if matches!(tab, Tab::Build | Tab::Past) && !own().any(|it| opened.contains(&it)) {
                    intents.extend(own().next().map(|panel| Intent::Act(Act::Panel(panel))));
                }
            }
            button
        });
        let [first, ..] = buttons;
        first
    });
    row.inner
}

/// Lays out the state of the selection.
fn selection(ui: &mut Ui, stage: &Stage, view: &View) {
    let selected = stage.selection().and_then(|thing| Selected::of(stage, thing));
    if let Some(selected) = selected {
        sideways(ui, "selection", |ui| {
            card::dock_lines(ui, &selected, stage.sim().method(), &view.viewpoint());
        });
    } else {
        scene(ui, stage);
    }
}

/// Lays out the description of the scene, its effects and the number of its bodies.
fn scene(ui: &mut Ui, stage: &Stage) {
    ui.strong(capital(&stage.sim().scene.name.replace('_', " ")));
    ui.label(&stage.sim().scene.description);
    let world = &stage.sim().world;
    let on = |effect: &Effect| effects::state(world, *effect) == EffectState::On;
    let names: Vec<_> =
        Effect::ALL.into_iter().filter(on).map(|effect| effect.name().replace('_', " ")).collect();
    let acting = match &names[..] {
        [] => "No force acts".to_owned(),
        [one] => format!("{} at work", capital(one)),
        [rest @ .., last] => format!("{} and {last} at work", capital(&rest.join(", "))),
    };
    ui.label(format!("{acting}; {}.", bodies(stage)));
    ui.weak("Click a body to see its numbers.");
}

/// What is asked most, and the panel that answers.
const QUESTIONS: [(Panel, &str, &str); 3] = [
    (Panel::Ghosts, "How accurate?", "all methods beside a fine run"),
    (Panel::Cost, "What does it cost?", "error against time"),
    (Panel::Forecast, "Does it hold?", "how near to breaking"),
];

/// Lays out a tile per question, which opens its panel.
fn questions(ui: &mut Ui, opened: &[Panel], intents: &mut Vec<Intent>) {
    ui.columns(QUESTIONS.len(), |columns| {
        for ((panel, question, answer), ui) in QUESTIONS.into_iter().zip(columns) {
            let mut words = LayoutJob::default();
            let strong = ui.visuals().strong_text_color();
            let font = TextStyle::Body.resolve(ui.style());
            words.append(question, 0.0, TextFormat::simple(font.clone(), strong));
            // The button gives it a color that is read on its own.
            let usual = TextFormat::simple(font, Color32::PLACEHOLDER);
            words.append(&format!("\n{answer}"), 0.0, usual);
            let size = Vec2::new(ui.available_width(), TILE);
            let tile = Button::selectable(opened.contains(&panel), words).wrap().min_size(size);
            let tile = ui.add(tile.corner_radius(4.0).stroke(ui.visuals().window_stroke));
            tile.widget_info(|| WidgetInfo::labeled(Role::Button, true, question));
            if tile.on_hover_text(panel.row().what).clicked() {
                intents.push(Intent::Act(Act::Panel(panel)));
            }
        }
    });
    ui.add_space(4.0);
}

/// Lets contents that are wider than the dock scroll; wraps text at its width.
fn sideways(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) {
    let width = ui.available_width();
    ScrollArea::horizontal().id_salt(name).show(ui, |ui| {
        ui.set_max_width(width);
        add(ui);
        reveal_focus(ui);
    });
}
