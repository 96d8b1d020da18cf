//! The help panel: the table of named actions.

use egui::{Align2, Grid, Label, RichText, ScrollArea, Ui, Vec2};

use crate::actions::{Act, input_rows};
use crate::intent::Intent;
use crate::tools::tool::{Anchor, Desk, Tool};

/// Room for the frame and the title of the window, and some around it, points.
const MARGINS: Vec2 = Vec2::new(32.0, 64.0);

/// Width of the longest keys in a column, and of the room beside the words, points.
const KEYS: f32 = 200.0;

/// The keys and the mouse.
#[derive(Default)]
pub(crate) struct Help;

impl Tool for Help {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::CENTER_CENTER, [0.0, 0.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let keys: Vec<_> = input_rows().collect();
        let most = ui.ctx().content_rect().size() - MARGINS;
        ui.set_max_size(most);
        ui.horizontal(|ui| {
            for (words, act) in [
                ("Larger", Act::Larger),
                ("Smaller", Act::Smaller),
                ("Light or dark", Act::ToggleTheme),
            ] {
                if ui.button(words).clicked() {
                    desk.intents.push(Intent::Act(act));
                }
            }
        });
        ScrollArea::both().max_width(most.x).max_height(ui.available_height()).show(ui, |ui| {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = 24.0;
                // Two columns: one would be higher than a small window.
                for (half, rows) in keys.chunks(keys.len().div_ceil(2)).enumerate() {
                    let grid = Grid::new(half).num_columns(2).striped(true).spacing([12.0, 2.0]);
                    grid.max_col_width(0.5 * most.x - KEYS).show(ui, |ui| {
                        for row in rows {
                            ui.label(RichText::new(row.inputs.join("  ")).monospace().strong());
                            // Backticks are for the document.
                            ui.add(Label::new(row.what.replace('`', "")).wrap())
                                .on_hover_text(row.when.words());
                            ui.end_row();
                        }
                    });
                }
            })
        });
    }
}
