//! The panel of effects: which are on, why, on how many bodies and at what cost; and switches for them.

use egui::{Button, CollapsingHeader, Grid, RichText, Ui};
use history::Change;
use lab::ReceiptLine;
use motion::Request;
use motion::effects::EffectState;
use report::numbers::count;

use crate::input::SwitchedBy;
use crate::intent::Intent;
use crate::tools::tool::Desk;
use crate::view::hud::mouse_hint;
use crate::words::plain;

/// Number of columns in the dock.
const NARROW: usize = 5;
/// Width of the first column in the dock, points.
const NAME: f32 = 110.0;

/// Size of the causes in the dock, points: a scene with everything in it has 19 of them.
const CAUSE: f32 = 11.0;

/// Lays out the panel: what the scene has, and the rest folded. Returns whether the effects are to be measured.
pub(super) fn show(ui: &mut Ui, desk: &mut Desk<'_>, rows: &[ReceiptLine], measures: bool) -> bool {
    mouse_hint(ui, desk.view);
    let (here, more): (Vec<_>, Vec<_>) =
        rows.iter().partition(|row| row.state != EffectState::NotDeclared);
    table(ui, desk, "effects", &here);
    CollapsingHeader::new(format!("{} more", more.len()))
        .id_salt("more")
        .show(ui, |ui| table(ui, desk, "more effects", &more));
    let button = ui.add_enabled(!measures, Button::new("Measure costs"));
    button.on_hover_text("runs a copy of the scene with and without each effect").clicked()
}

fn table(ui: &mut Ui, desk: &mut Desk<'_>, name: &str, rows: &[&ReceiptLine]) {
    // The dock is not wide enough for a column of causes: there, the causes are below the names.
    let narrow = desk.dock_width.is_some();
    let headings = ["", "bodies", "calls", "ns", "share", "bytes", "because"];
    let columns = if narrow { NARROW } else { headings.len() };
    let gap = if narrow { 8.0 } else { 10.0 };
    Grid::new(name).num_columns(columns).striped(true).spacing([gap, 2.0]).show(ui, |ui| {
        for (i, heading) in headings[..columns].iter().enumerate() {
            let heading = ui.weak(*heading);
            if matches!(i, 2 | 3) {
                heading.on_hover_text("of the law, per step");
            }
        }
        ui.end_row();
        for row in rows {
            let mut on = row.state == EffectState::On;
            let because = row.because.as_deref().unwrap_or(row.state.words());
            let hint = if row.bytes > 0 {
                format!("{because}; {} bytes", row.bytes)
            } else {
                because.to_owned()
            };
            ui.vertical(|ui| {
                match row.effect {
                    Some(effect) => {
                        let declared = row.state != EffectState::NotDeclared;
                        let box_ =
                            ui.add_enabled(declared, egui::Checkbox::new(&mut on, plain(row.name)));
                        if box_.on_hover_text(hint).changed() {
                            let switch = Change::request(Request::Switch(effect, on));
                            desk.intents.push(Intent::Change(switch, SwitchedBy::Panel));
                        }
                    }
                    None => {
                        ui.add_enabled(on, egui::Label::new(plain(row.name)).extend())
                            .on_hover_text(hint);
                    }
                }
                if let Some(because) = row
                    .because
                    .as_deref()
                    .filter(|because| narrow && plain(because) != plain(row.name))
                {
                    ui.set_max_width(NAME);
                    ui.add(
                        egui::Label::new(RichText::new(plain(because)).size(CAUSE).weak()).wrap(),
                    );
                }
            });
            let number = |on: bool, text: String| if on { text } else { String::new() };
            let measured = |value: Option<f64>, text: fn(f64) -> String| {
                value.map_or(String::new(), |value| number(on, text(value)))
            };
            ui.label(number(on, row.bodies.to_string()));
            ui.label(number(on, count(row.evaluations)));
            ui.label(measured(row.ns, |ns| format!("{ns:.0}")));
            ui.label(measured(row.share, |share| format!("{:.0} %", share * 100.0)));
            if !narrow {
                ui.label(number(row.bytes > 0, row.bytes.to_string()));
                match row.because {
                    Some(_) => ui.label(plain(because)),
                    None => ui.weak(because),
                };
            }
            ui.end_row();
        }
    });
}
