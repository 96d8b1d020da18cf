//! The settings panel: the tutorial's further work 1 and 2, live.

mod method;

use egui::{Align2, ComboBox, DragValue, Ui};
use glam::DVec3;
use history::Change;
use motion::{Damping, DampingModel, Gravity, Method, Request, TimeStep};

use crate::input::SwitchedBy;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::card::Selected;
use crate::view::hud::mouse_hint;

/// Gravity at the surface, m/s² (Earth: the tutorial's value).
const PRESETS: [(&str, f64); 5] =
    [("Earth", -9.8), ("Moon", -1.62), ("Mars", -3.71), ("none", 0.0), ("upward", 9.8)];

/// Range in which `step_hz` can be dragged, Hz.
const STEP_HZ: std::ops::RangeInclusive<f64> = 1.0..=10_000.0;

/// The settings.
#[derive(Default)]
pub(crate) struct Settings;

impl Tool for Settings {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::LEFT_CENTER, [8.0, 0.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let selected = desk.stage.selection().and_then(|thing| Selected::of(desk.stage, thing));
        let (stage, intents) = (&*desk.stage, &mut *desk.intents);
        let method = stage.sim().method();
        mouse_hint(ui, desk.view);
        gravity(ui, stage, intents);
        ui.separator();
        damping(ui, stage, intents);
        ui.separator();
        ui.horizontal(|ui| {
            let mut rate = 1.0 / stage.sim().world.resource::<TimeStep>().0;
            ui.label("step_hz");
            if ui.add(DragValue::new(&mut rate).range(STEP_HZ).speed(1.0).suffix(" Hz")).changed() {
                intents.push(Intent::Change(Change::Step(1.0 / rate), SwitchedBy::Settings));
            }
        });
        ui.separator();
        method::of_scene(ui, method, intents);
        ui.separator();
        match &selected {
            Some(selected) => {
                body(ui, (stage.sim().id(selected.entity), selected), method, intents);
            }
            None => {
                ui.weak("select a body to edit its mass, velocity and method");
            }
        }
    }
}

/// The change of a law or a body that this panel asks for.
fn ask(request: Request<u32>) -> Intent {
    Intent::Change(Change::request(request), SwitchedBy::Settings)
}

fn gravity(ui: &mut Ui, stage: &Stage, intents: &mut Vec<Intent>) {
    ui.label("gravity");
    let declared = stage.sim().world.get_resource::<Gravity>();
    let mut on = declared.is_some_and(|gravity| gravity.on);
    if ui.checkbox(&mut on, "on").changed() {
        intents.push(ask(match declared {
            Some(_) => Request::SwitchGravity(on),
            None => Request::SetGravity(Gravity::EARTH.acceleration),
        }));
    }
    ui.horizontal(|ui| {
        for (name, y) in PRESETS {
            if ui.button(name).clicked() {
                intents.push(ask(Request::SetGravity(DVec3::new(0.0, y, 0.0))));
            }
        }
    });
    let acceleration = declared.map_or(DVec3::ZERO, |gravity| gravity.acceleration);
    if let Some(changed) = vector(ui, acceleration, 0.1, "m/s²") {
        intents.push(ask(Request::SetGravity(changed)));
    }
}

fn damping(ui: &mut Ui, stage: &Stage, intents: &mut Vec<Intent>) {
    ui.label("damping");
    let declared = stage.sim().world.get_resource::<Damping>().copied();
    let declared = declared.unwrap_or(Damping { model: DampingModel::default(), rate: 0.0 });
    let mut changed = declared;
    ui.horizontal(|ui| {
        ComboBox::from_id_salt("damping model").selected_text(changed.model.name()).show_ui(
            ui,
            |ui| {
                for model in DampingModel::ALL {
                    ui.selectable_value(&mut changed.model, model, model.name());
                }
            },
        );
        ui.add(DragValue::new(&mut changed.rate).range(0.0..=1e6).speed(0.01).suffix(" 1/s"));
    });
    if changed != declared && changed.rate.is_finite() {
        intents.push(ask(Request::SetDamping(changed)));
    }
}

fn body(
    ui: &mut Ui,
    (id, selected): (Option<u32>, &Selected),
    scene: Method,
    intents: &mut Vec<Intent>,
) {
    ui.label(&selected.name);
    let Some((id, body)) = id.zip(selected.body) else {
        ui.weak("scenery has no physics");
        return;
    };
    if selected.soft.is_some() {
        ui.weak("a soft body: its scene says what its points and springs are");
        return;
    }
    if body.inverse_mass <= 0.0 {
        ui.weak("mass infinite: nothing moves it");
        return;
    }
    ui.horizontal(|ui| {
        let mut mass = body.mass();
        let speed = mass * 0.01;
        ui.label("mass");
        if ui.add(DragValue::new(&mut mass).range(1e-6..=1e9).speed(speed).suffix(" kg")).changed()
        {
            intents.push(ask(Request::SetInverseMass(id, 1.0 / mass)));
        }
    });
    ui.label("velocity");
    if let Some(velocity) = vector(ui, body.velocity, 0.1, "m/s") {
        intents.push(ask(Request::SetVelocity(id, velocity)));
    }
    method::of_body(ui, (id, selected), scene, intents);
}

/// Lays out three numbers. Returns the new vector if one was changed.
fn vector(ui: &mut Ui, value: DVec3, speed: f64, unit: &str) -> Option<DVec3> {
    let mut edited = value;
    let mut changed = false;
    ui.horizontal(|ui| {
        for axis in 0..3 {
            changed |=
                ui.add(DragValue::new(&mut edited[axis]).speed(speed).max_decimals(3)).changed();
        }
        ui.label(unit);
    });
    changed.then_some(edited)
}
