//! The help panel: the table of named actions.

use egui::{Align2, Grid, RichText};

use crate::actions::{BINDINGS, MOUSE};

pub(super) fn show(context: &egui::Context) {
    egui::Window::new("Keys and mouse").resizable(false).anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(
        context,
        |ui| {
            Grid::new("keys").num_columns(3).striped(true).spacing([16.0, 2.0]).show(ui, |ui| {
                for binding in BINDINGS {
                    ui.label(RichText::new(binding.keys.join("  ")).monospace().strong());
                    ui.label(binding.what);
                    ui.weak(binding.when.words());
                    ui.end_row();
                }
                for (input, when, what) in MOUSE {
                    ui.label(RichText::new(*input).strong());
                    ui.label(*what);
                    ui.weak(when.words());
                    ui.end_row();
                }
            });
        },
    );
}
