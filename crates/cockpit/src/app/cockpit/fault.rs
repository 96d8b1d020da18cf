//! The bar that says what went wrong, with buttons for its cures; it stays until it is dismissed.

use egui::{Rect, RichText, Ui};
use lab::cost::Setting;
use motion::{Method, MutualGravity};
use report::numbers::number;
use scene::{Substepping, unsolvable};

use crate::actions::Act;
use crate::app::cockpit::bar;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::tools::forecast;
use crate::view::inks;
use crate::view::marks::FAULT;

/// The fault that the bar shows.
#[derive(Default)]
pub(super) struct FaultBar {
    /// The tick that went wrong, and what happened.
    of: Option<(u64, String)>,
    dismissed: bool,
    cures: Vec<Cure>,
}

/// A setting that may help.
struct Cure {
    setting: Setting,
    words: String,
    why: &'static str,
}

impl FaultBar {
    /// Lays out the bar at the bottom of what is `free` of the view, if something went wrong.
    pub fn show(
        &mut self,
        root: &Ui,
        free: &mut Rect,
        stage: &mut Stage,
        intents: &mut Vec<Intent>,
    ) {
        let Some(fault) = stage.recorder().fault().cloned() else {
            *self = Self::default();
            return;
        };
        let of = Some((fault.tick, fault.what.clone()));
        if self.of != of {
            // The forecast is of the current state, so wait until the run is back at the last good tick.
            if stage.recorder().is_seeking() {
                return;
            }
            // In a state after the fault, the forecast would propose settings that no longer help.
            let is_good = stage.recorder().is_good(stage.sim().ticks());
            let cures = if is_good { cures(stage) } else { std::mem::take(&mut self.cures) };
            *self = Self { of, dismissed: false, cures };
        }
        if self.dismissed {
            return;
        }
        let (good, at) = (stage.recorder().last_good(), stage.times().words(fault.tick));
        bar(root, "fault", free, |ui| {
            let color = inks::words(ui.visuals(), FAULT);
            let words = format!("At {at}: {}.", plainly(&fault.what));
            ui.label(RichText::new(words).color(color)).on_hover_text(&fault.what);
            if let Some(good) = good.filter(|good| *good != stage.sim().ticks())
                && ui.button("Last good tick").clicked()
            {
                intents.push(Intent::Seek(good));
            }
            for Cure { setting, words, why } in &self.cures {
                let button = ui.add_enabled(*setting != stage.setting(), egui::Button::new(words));
                if button.on_hover_text(*why).clicked() {
                    intents.push(Intent::ApplySetting(*setting));
                }
            }
            if ui
                .button("Save bundle")
                .on_hover_text("one file that repeats the run (Ctrl+S)")
                .clicked()
            {
                intents.push(Intent::SaveBundle);
            }
            if ui.button("Reset to start").on_hover_text("the scene from its start (F1)").clicked()
            {
                intents.push(Intent::Act(Act::ResetWorld));
            }
            self.dismissed = ui.button("Dismiss").clicked();
        });
    }
}

/// An energy above which its number says nothing, J.
const EXPLODED_J: f64 = 1e9;

/// What happened, with numbers as people read them.
fn plainly(what: &str) -> String {
    let plain =
        |word: &str| word.parse().map_or_else(|_| word.to_owned(), |value| number(value, 3));
    match what.split(' ').filter_map(|word| word.parse().ok()).fold(0.0, f64::max) {
        EXPLODED_J.. => "the energy exploded".to_owned(),
        _ => what.split(' ').map(plain).collect::<Vec<_>>().join(" "),
    }
}

/// The settings that the forecast proposes instead of the scene's or, if it finds nothing unstable, settings that may help
/// anyway.
fn cures(stage: &mut Stage) -> Vec<Cure> {
    let present = stage.setting();
    let rows = forecast::rows(stage);
    let worst = rows.iter().find(|row| row.is_fault());
    let (substeps, method, why) = match worst {
        Some(row) if row.setting() == (present.method, present.substeps) => {
            let why = if row.is_cure_tried {
                "Tried ahead: it holds. Play continues with it."
            } else {
                "By its margin it is stable. Play continues with it."
            };
            let chosen = row.cure.error.map(Substepping::auto);
            (chosen.or(row.cure.substeps.map(Substepping::Fixed)), row.cure.method, why)
        }
        // A body with its own method: no setting of the scene helps it.
        Some(_) => return Vec::new(),
        None => {
            let finer = present.substeps.finer(4).clamped();
            (
                Some(finer),
                Some(Method::ImplicitEuler),
                "Worth a try: the forecast does not know what went wrong.",
            )
        }
    };
    let attracts = stage.sim().world.contains_resource::<MutualGravity>();
    let method = method
        .filter(|method| *method != present.method && unsolvable(*method, attracts).is_none());
    let substeps = substeps.filter(|substeps| *substeps != present.substeps);
    let finer = substeps
        .map(|substeps| (format!("{substeps:#} substeps"), Setting { substeps, ..present }));
    let other =
        method.map(|method| (method.claims().title.to_owned(), Setting { method, ..present }));
    finer.into_iter().chain(other).map(|(words, setting)| Cure { setting, words, why }).collect()
}

#[cfg(test)]
mod tests {
    use super::plainly;

    #[test]
    fn energies_are_told_as_people_read_them() {
        let created = |joules: &str| {
            format!("the method created {joules} J of energy from here on; the run had 4.870e1 J")
        };
        assert_eq!(plainly(&created("1.235e2")), created("124").replace("4.870e1", "48.7"));
        assert_eq!(plainly(&created("7.401e224")), "the energy exploded");
    }
}
