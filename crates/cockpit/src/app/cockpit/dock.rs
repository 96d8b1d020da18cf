//! The dock at the right: a tab per role, with the selection or a section for every tool.

use egui::style::ScrollAnimation;
use egui::{Align, Button, CollapsingHeader, Response, Role, ScrollArea, Ui, WidgetInfo};

use crate::actions::Act;
use crate::app::focus::{frame_if_lesson_names, reveal_focus};
use crate::intent::Intent;
use crate::panels::{PANELS, Panel, Tab};
use crate::stage::Stage;
use crate::tools::Tools;
use crate::tools::tool::Desk;
use crate::view::View;
use crate::view::card::{self, Selected};

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
    let first = tabs(ui, tab);
    ui.separator();
    ScrollArea::vertical().id_salt(*tab as usize).auto_shrink(false).show(ui, |ui| {
        if *tab == Tab::Look {
            selection(ui, stage, view);
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

/// Lays out the row of tabs. Returns the first one.
fn tabs(ui: &mut Ui, chosen: &mut Tab) -> Response {
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
        ui.weak("Click a body to select it.");
    }
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
