//! The settings panel: the tutorial's further work 1 and 2, live.

mod method;

use egui::{Align2, ComboBox, Ui};
use glam::DVec3;
use history::Change;
use motion::{Damping, DampingModel, Gravity, Method, Request, TimeStep};
use scene::{BODY_MASS, COMPONENT, DAMPING_RATE, STEP_RATE};

use crate::input::SwitchedBy;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::tools::number::value_field;
use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::card::Selected;
use crate::view::hud::mouse_hint;

/// Gravity at the surface, m/s² (Earth: the tutorial's value).
const PRESETS: [(&str, f64); 5] =
    [("Earth", -9.8), ("Moon", -1.62), ("Mars", -3.71), ("none", 0.0), ("upward", 9.8)];

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
            let rate = 1.0 / stage.sim().world.resource::<TimeStep>().0;
            ui.label("ticks per second");
            let asked = value_field(ui, "step_hz", STEP_RATE, rate, 0.01 * rate, " Hz");
            let change = |rate| Intent::Change(Change::Step(1.0 / rate), SwitchedBy::Settings);
            push(intents, asked, change);
        });
        ui.separator();
        method::of_scene(ui, method, intents);
        ui.separator();
        match &selected {
            Some(selected) => {
                body(ui, stage.sim().id(selected.entity), selected, method, intents);
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
    let asked = vector(ui, "gravity.acceleration_m_s2", acceleration, "m/s²");
    push(intents, asked, |changed| ask(Request::SetGravity(changed)));
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
        let (key, rule) = ("damping.rate_per_s", DAMPING_RATE);
        let asked = value_field(ui, key, rule, declared.rate, 0.01, " 1/s");
        push(intents, asked, |rate| ask(Request::SetDamping(Damping { rate, ..changed })));
    });
    if changed.model != declared.model {
        intents.push(ask(Request::SetDamping(changed)));
    }
}

fn body(
    ui: &mut Ui,
    id: Option<u32>,
    selected: &Selected,
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
    // What is being typed is for this body, also if another one is selected meanwhile.
    ui.push_id(id, |ui| {
        ui.horizontal(|ui| {
            ui.label("mass");
            let mass = body.mass();
            let asked = value_field(ui, "mass_kg", BODY_MASS, mass, 0.01 * mass, " kg");
            push(intents, asked, |mass| ask(Request::SetInverseMass(id, 1.0 / mass)));
        });
        ui.label("velocity");
        let asked = vector(ui, "velocity_m_s", body.velocity, "m/s");
        push(intents, asked, |velocity| ask(Request::SetVelocity(id, velocity)));
        method::of_body(ui, id, selected, scene, intents);
    });
}

/// Lays out the three numbers of the vector `key`. Returns the new vector if one was changed, or what is wrong with it.
fn vector(ui: &mut Ui, key: &str, value: DVec3, unit: &str) -> Option<Result<DVec3, String>> {
    let mut asked = None;
    ui.horizontal(|ui| {
        for axis in 0..3 {
            let number = value_field(ui, key, COMPONENT, value[axis], 0.1, "");
            let with = |number| {
                let mut edited = value;
                edited[axis] = number;
                edited
            };
            asked = number.map(|number| number.map(with)).or(asked.take());
        }
        ui.label(unit);
    });
    asked
}

/// Adds the intent of a value that the person asks for, or of its refusal.
fn push<T>(
    intents: &mut Vec<Intent>,
    asked: Option<Result<T, String>>,
    intent: impl FnOnce(T) -> Intent,
) {
    intents.extend(asked.map(|asked| asked.map_or_else(Intent::Refuse, intent)));
}
