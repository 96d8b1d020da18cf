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
    /// Settings that the forecast calls stable.
    cures: Vec<Setting>,
}

impl FaultBar {
    /// Lays out the bar at the bottom of `root`, if something went wrong.
    pub fn show(&mut self, root: &mut Ui, stage: &mut Stage, edits: &mut Vec<Edit>) {
        let Some(fault) = stage.fault().cloned() else {
            *self = Self::default();
            return;
        };
        if self.tick != fault.tick {
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
                for cure in &self.cures {
                    let present = stage.setting();
                    let words = match (cure.method == present.method, cure.substeps) {
                        (true, substeps) => format!("{substeps} substeps"),
                        (false, _) => cure.method.claims().title.to_owned(),
                    };
                    let button = ui.add_enabled(*cure != present, egui::Button::new(words));
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

/// What the forecast proposes for the worst of what is unstable now.
fn cures(stage: &mut Stage) -> Vec<Setting> {
    let present = stage.setting();
    let attracts = stage.sim.world.contains_resource::<MutualGravity>();
    let solves = |method: &Method| unsolvable(*method, attracts).is_none();
    let rows = forecast::rows(stage);
    let Some(worst) = rows.iter().find(|row| row.margin.is_unstable) else {
        // What the forecast does not know may still be too fast for the step.
        let finer = Setting { substeps: present.substeps.saturating_mul(4), ..present };
        let implicit = Some(Method::ImplicitEuler).filter(solves);
        return [finer].into_iter().chain(implicit.map(|method| Setting { method, ..present })).collect();
    };
    let cure = &worst.margin.cure;
    let substeps = cure.substeps.map(|substeps| Setting { substeps, ..present });
    let method = cure.method.filter(solves).map(|method| Setting { method, ..present });
    substeps.into_iter().chain(method).collect()
}
