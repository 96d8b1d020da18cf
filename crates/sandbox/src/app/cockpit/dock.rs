//! The dock at the right: the selection, and a section for every tool.

use egui::style::ScrollAnimation;
use egui::{Align, CollapsingHeader, Response, ScrollArea, TextStyle, Ui};

use crate::actions::{self, Act};
use crate::app::focus::reveal_focus;
use crate::intent::Intent;
use crate::panels::Panel;
use crate::stage::Stage;
use crate::tools::Tools;
use crate::tools::tool::Desk;
use crate::view::View;
use crate::view::card::{self, Selected};

/// Lays out the sections; those of `opened` panels are open, and the `newest` one is scrolled to. Returns the first header.
pub(super) fn show(
    ui: &mut Ui,
    (opened, newest): (&[Panel], Option<Panel>),
    (stage, view): (&mut Stage, &mut View),
    tools: &mut Tools,
    intents: &mut Vec<Intent>,
) -> Response {
    let area = ScrollArea::vertical().auto_shrink(false);
    let shown = area.show(ui, |ui| {
        let selection = CollapsingHeader::new("Selection").default_open(true).show(ui, |ui| {
            let selected = stage.here.selection.and_then(|thing| Selected::of(stage, thing));
            if let Some(selected) = selected {
                sideways(ui, "selection", |ui| {
                    card::lines(ui, &selected, stage.sim.method(), TextStyle::Body);
                });
            } else {
                ui.weak("Click a body to select it.");
            }
        });
        let mut sections: Vec<_> = tools.each().filter(|(_, tool)| tool.docks()).collect();
        // How high it is depends on the time that measuring took: below it nothing would stand where a recording clicked.
        sections.sort_by_key(|(panel, _)| *panel == Panel::Cost);
        for (panel, tool) in sections {
            let row = panel.row();
            let header = CollapsingHeader::new(row.title).open(Some(opened.contains(&panel)));
            let shown = header.show(ui, |ui| {
                sideways(ui, row.name, |ui| {
                    let dock_width = Some(ui.max_rect().width());
                    let mut desk =
                        Desk { stage, view, dock_width, keys: actions::rows, intents, closes: false };
                    tool.show(ui, &mut desk);
                });
            });
            let header = shown.header_response.on_hover_text(format!("{} ({})", row.what, row.keys[0]));
            if newest == Some(panel) {
                header.scroll_to_me_animation(Some(Align::TOP), ScrollAnimation::none());
            }
            if header.clicked() {
                intents.push(Intent::Act(Act::Panel(panel)));
            }
        }
        reveal_focus(ui);
        selection.header_response
    });
    shown.inner
}

/// Lets what is wider than the dock be scrolled; text is wrapped at its width.
fn sideways(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) {
    let width = ui.available_width();
    ScrollArea::horizontal().id_salt(name).show(ui, |ui| {
        ui.set_max_width(width);
        add(ui);
        reveal_focus(ui);
    });
}
