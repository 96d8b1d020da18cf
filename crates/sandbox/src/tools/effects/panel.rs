//! The panel of effects: what acts, because of what, on how many bodies, at what cost; and switching it.

use egui::{Grid, Ui};
use lab::Row;
use motion::effects::EffectState;
use report::numbers::count;

use crate::tools::tool::{Desk, Edit};
use crate::view::hud::mouse_hint;

/// The panel; whether the effects are to be measured.
pub(super) fn show(ui: &mut Ui, desk: &mut Desk<'_>, rows: &[Row]) -> bool {
    mouse_hint(ui, desk.stage);
    Grid::new("effects").num_columns(7).striped(true).spacing([10.0, 2.0]).show(ui, |ui| {
        for heading in ["", "bodies", "evals", "ns/step", "share", "bytes", "because"] {
            ui.weak(heading);
        }
        ui.end_row();
        for row in rows {
            let mut on = row.state == EffectState::On;
            let because = row.because.as_deref().unwrap_or(row.state.words());
            match row.effect {
                Some(effect) => {
                    let declared = row.state != EffectState::NotDeclared;
                    let box_ = ui.add_enabled(declared, egui::Checkbox::new(&mut on, row.name));
                    if box_.on_hover_text(because).changed() {
                        desk.edits.push(Edit::Switch(effect, on));
                    }
                }
                None => {
                    ui.add_enabled(on, egui::Label::new(row.name)).on_hover_text(because);
                }
            }
            let number = |on: bool, text: String| if on { text } else { String::new() };
            let measured = |value: Option<f64>, text: fn(f64) -> String| {
                value.map_or(String::new(), |value| number(on, text(value)))
            };
            ui.label(number(on, row.bodies.to_string()));
            ui.label(number(on, count(row.evaluations)));
            ui.label(measured(row.ns, |ns| format!("{ns:.0}")));
            ui.label(measured(row.share, |share| format!("{:.0} %", share * 100.0)));
            ui.label(number(row.bytes > 0, row.bytes.to_string()));
            match row.because {
                Some(_) => ui.label(because),
                None => ui.weak(because),
            };
            ui.end_row();
        }
    });
    let button = ui.button("measure");
    button.on_hover_text("runs a copy of the scene with and without each effect").clicked()
}
