//! The card of the selection: the tutorial's quantities with their units.

use egui::{Align2, Grid, RichText};
use glam::DVec3;
use motion::Method;

use super::Selected;
use crate::session::SoftSum;

/// Points that three components of two digits before the point need.
const WIDTH: f32 = 340.0;

pub(super) fn show(context: &egui::Context, selected: &Selected, scene: Method) {
    // Read-only and not interactive: clicks over it reach the scene.
    egui::Window::new("selection")
        .title_bar(false)
        .resizable(false)
        .interactable(false)
        .anchor(Align2::RIGHT_CENTER, [-8.0, 0.0])
        .show(context, |ui| {
            // Else the card's edge would jump with every digit.
            ui.set_min_width(WIDTH);
            ui.label(RichText::new(&selected.name).strong());
            Grid::new("quantities").num_columns(2).show(ui, |ui| {
                for (quantity, value) in rows(selected, scene) {
                    ui.label(quantity);
                    ui.monospace(value);
                    ui.end_row();
                }
            });
        });
}

fn rows(selected: &Selected, scene: Method) -> Vec<(&'static str, String)> {
    let mut rows = vec![
        ("position", vector(selected.position, "m")),
        ("displacement", vector(selected.displacement, "m")),
    ];
    let Some(body) = selected.body else {
        rows.push(("physics", "none: scenery".to_owned()));
        return rows;
    };
    if let Some(soft) = &selected.soft {
        rows.extend(soft_rows(soft));
        return rows;
    }
    let movable = body.inverse_mass > 0.0;
    let gravity = if movable { selected.gravity } else { DVec3::ZERO };
    let of_laws = if movable { selected.laws * body.mass() } else { DVec3::ZERO };
    let weight = if movable { gravity * body.mass() } else { DVec3::ZERO };
    let applied = selected.applied * body.inverse_mass - body.velocity * selected.damping + selected.laws;
    let acceleration = if movable { applied + gravity } else { DVec3::ZERO };
    rows.extend([
        ("velocity", vector(body.velocity, "m/s")),
        ("speed", format!("{} m/s", number(length(body.velocity)))),
        ("acceleration", vector(acceleration, "m/s²")),
        ("forces", vector(selected.applied + weight + of_laws, "N")),
        ("mass", if movable { format!("{} kg", number(body.mass())) } else { "infinite".to_owned() }),
        ("inverse mass", format!("{} 1/kg", number(body.inverse_mass))),
        ("momentum", vector(body.momentum(), "kg m/s")),
        ("weight", format!("{} N", number(length(weight)))),
    ]);
    if movable {
        let (method, whose) = selected.own_method.map_or((scene, "the scene's"), |own| (own, "its own"));
        rows.push(("method", format!("{}, {whose}", method.claims().title)));
    }
    if let Some(why) = &selected.quarantined {
        rows.push(("quarantined", why.clone()));
    }
    rows
}

/// What the points have together. No acceleration: pins hold a soft body with forces that only its springs know.
fn soft_rows(soft: &SoftSum) -> Vec<(&'static str, String)> {
    let SoftSum { body, points, pinned, quarantined, springs, .. } = soft;
    let mut counted = points.to_string();
    for (count, word) in [(pinned, "pinned"), (quarantined, "quarantined")] {
        if *count > 0 {
            counted += &format!(", {count} {word}");
        }
    }
    let mass =
        if body.inverse_mass > 0.0 { format!("{} kg", number(body.mass())) } else { "infinite".to_owned() };
    vec![
        ("velocity", vector(body.velocity, "m/s")),
        ("speed", format!("{} m/s", number(length(body.velocity)))),
        ("points", counted),
        ("springs", springs.to_string()),
        ("mass", mass),
        ("momentum", vector(body.momentum(), "kg m/s")),
        ("kinetic energy", format!("{} J", number(soft.kinetic_energy))),
        ("energy in springs", format!("{} J", number(soft.spring_energy))),
    ]
}

fn vector(v: DVec3, unit: &str) -> String {
    format!("({}, {}, {}) {unit}", number(v.x), number(v.y), number(v.z))
}

/// Also where its square is beyond every number.
fn length(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (v / largest).length() * largest } else { largest }
}

/// Three decimals, or a power of ten where they would say nothing.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-2..1e6).contains(&size) { format!("{value:.3}") } else { format!("{value:.3e}") }
}
