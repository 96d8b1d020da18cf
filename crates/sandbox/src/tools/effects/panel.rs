//! The panel of effects: what acts, because of what, on how many bodies, at what cost; and switching it.

use egui::{Align2, Grid};
use motion::effects::EffectState;

use crate::app::control::Mode;
use crate::app::panels::{Edit, Model};
use crate::commands::effects::tidy;

pub(crate) fn show(context: &egui::Context, model: &Model, edits: &mut Vec<Edit>) {
    egui::Window::new("Effects")
        .resizable(false)
        .collapsible(false)
        .anchor(Align2::RIGHT_CENTER, [-8.0, 0.0])
        .show(context, |ui| {
            if model.mode == Mode::Camera {
                ui.weak("the pointer turns the camera: Q lets it click here");
            }
            Grid::new("effects").num_columns(7).striped(true).spacing([10.0, 2.0]).show(ui, |ui| {
                for heading in ["", "bodies", "evaluations", "ns a step", "share", "bytes", "because"] {
                    ui.weak(heading);
                }
                ui.end_row();
                for row in &model.effects {
                    let mut on = row.state == EffectState::On;
                    match row.effect {
                        Some(effect) => {
                            let declared = row.state != EffectState::NotDeclared;
                            let box_ = ui.add_enabled(declared, egui::Checkbox::new(&mut on, row.name));
                            if box_.changed() {
                                edits.push(Edit::Switch(effect, on));
                            }
                        }
                        None => {
                            ui.add_enabled(on, egui::Label::new(row.name));
                        }
                    }
                    let number = |on: bool, text: String| if on { text } else { String::new() };
                    ui.label(number(on, row.bodies.to_string()));
                    ui.label(number(on, tidy(row.evaluations)));
                    ui.label(row.ns.map_or(String::new(), |ns| number(on, format!("{ns:.0}"))));
                    ui.label(
                        row.share
                            .map_or(String::new(), |share| number(on, format!("{:.0} %", share * 100.0))),
                    );
                    ui.label(number(row.bytes > 0, row.bytes.to_string()));
                    match (&row.because, row.state) {
                        (Some(because), _) => ui.label(because),
                        (None, state) => ui.weak(state.words()),
                    };
                    ui.end_row();
                }
            });
            if ui
                .button("measure")
                .on_hover_text("runs a copy of the scene with and without each effect")
                .clicked()
            {
                edits.push(Edit::MeasureEffects);
            }
        });
}
