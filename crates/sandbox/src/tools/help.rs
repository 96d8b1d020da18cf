//! The help panel: the table of named actions.

use egui::{Align2, Grid, RichText, ScrollArea, Vec2};

use crate::actions::{BINDINGS, MOUSE};

/// Points of the window's frame and title, and some around it.
const MARGINS: Vec2 = Vec2::new(32.0, 64.0);

pub(crate) fn show(context: &egui::Context) {
    let keys = BINDINGS.iter().map(|row| (row.keys.join("  "), row.what, row.when.words()));
    let mouse = MOUSE.iter().map(|(input, when, what)| ((*input).to_owned(), *what, when.words()));
    let rows: Vec<_> = keys.chain(mouse).collect();
    let most = context.content_rect().size() - MARGINS;
    egui::Window::new("Keys and mouse")
        .resizable(false)
        .collapsible(false)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .default_size(most)
        .show(context, |ui| {
            ScrollArea::both().max_width(most.x).max_height(most.y).show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    ui.spacing_mut().item_spacing.x = 24.0;
                    // Two columns: one would be higher than a small window.
                    for (half, rows) in rows.chunks(rows.len().div_ceil(2)).enumerate() {
                        Grid::new(half).num_columns(2).striped(true).spacing([12.0, 2.0]).show(ui, |ui| {
                            for (input, what, when) in rows {
                                ui.label(RichText::new(input).monospace().strong());
                                ui.label(*what).on_hover_text(*when);
                                ui.end_row();
                            }
                        });
                    }
                })
            });
        });
}
