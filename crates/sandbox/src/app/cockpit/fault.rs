//! The bar that says what went wrong, with buttons for its cures; it stays until it is dismissed.

use egui::{Panel as Side, RichText, Ui};
use lab::cost::Setting;
use motion::{Method, MutualGravity};
use scene::unsolvable;

use crate::tools::forecast;
use crate::tools::tool::Edit;
use crate::view::marks::FAULT;
use crate::view::stage::Stage;

/// What is known of the fault that is shown.
#[derive(Default)]
pub(super) struct FaultBar {
    /// The tick that went wrong.
    tick: u64,
    dismissed: bool,
    /// Settings that the forecast calls stable, in words.
    cures: Vec<(String, Setting)>,
}

impl FaultBar {
    /// Lays out the bar at the bottom of `root`, if something went wrong.
    pub fn show(&mut self, root: &mut Ui, stage: &mut Stage, edits: &mut Vec<Edit>) {
        let Some(fault) = stage.fault().cloned() else {
            *self = Self::default();
            return;
        };
        if self.tick != fault.tick {
            // The forecast is of where the run stands: at the last good tick.
            if !stage.arrived() {
                return;
            }
            *self = Self { tick: fault.tick, dismissed: false, cures: cures(stage) };
        }
        if self.dismissed {
            return;
        }
        let good = fault.tick.saturating_sub(1);
        Side::bottom("fault").show(root, |ui| {
            ui.horizontal_wrapped(|ui| {
                ui.label(RichText::new(format!("Tick {}: {}.", fault.tick, fault.what)).color(FAULT));
                if stage.ticks() != good && ui.button("Last good tick").clicked() {
                    edits.push(Edit::Seek(good));
                }
                for (words, cure) in &self.cures {
                    let button = ui.add_enabled(*cure != stage.setting(), egui::Button::new(words));
                    if button.on_hover_text("stable by the forecast; Play goes on with it").clicked() {
                        edits.push(Edit::ApplySetting(*cure));
                    }
                }
                if ui.button("Save bundle").on_hover_text("one file that repeats the run (Ctrl+S)").clicked()
                {
                    edits.push(Edit::SaveBundle);
                }
                self.dismissed = ui.button("Dismiss").clicked();
            });
        });
    }
}

/// What the forecast proposes for the worst of what is unstable now. What it does not know may still be too fast for the step.
fn cures(stage: &mut Stage) -> Vec<(String, Setting)> {
    let present = stage.setting();
    let rows = forecast::rows(stage);
    let known = rows.iter().find(|row| row.margin.is_unstable).map(|row| row.margin.cure);
    let (substeps, method) = match known {
        Some(cure) => (cure.substeps, cure.method),
        None => (Some(present.substeps.saturating_mul(4)), Some(Method::ImplicitEuler)),
    };
    let attracts = stage.sim.world.contains_resource::<MutualGravity>();
    let method = method.filter(|method| *method != present.method && unsolvable(*method, attracts).is_none());
    let finer = substeps.map(|substeps| (format!("{substeps} substeps"), Setting { substeps, ..present }));
    let other = method.map(|method| (method.claims().title.to_owned(), Setting { method, ..present }));
    finer.into_iter().chain(other).collect()
}
