//! The card of the selection: the tutorial's quantities with their units.

use egui::{Align2, Grid, RichText};
use glam::DVec3;
use motion::Method;

use crate::app::panels::Selected;
use crate::app::session::SoftSum;

/// Points between the card and the edge of the picture.
const MARGIN: f32 = 8.0;

/// Points that three components of two digits before the point need.
const WIDTH: f32 = 340.0;

pub(crate) fn show(context: &egui::Context, selected: &Selected, scene: Method) {
    // Read-only and not interactive: clicks over it reach the scene.
    let card = egui::Window::new("selection")
        .title_bar(false)
        .resizable(false)
        .interactable(false)
        .anchor(Align2::RIGHT_CENTER, [-MARGIN, 0.0])
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
    // It stood where it fits as wide as it was last.
    let edge = context.content_rect().right() - MARGIN;
    if card.is_some_and(|card| (card.response.rect.right() - edge).abs() > 0.5) {
        context.request_discard("the card has another width");
    }
}

/// Causes of forces that are listed.
const CAUSES: usize = 6;

/// The forces that there are, where they are more than one.
fn causes(forces: &[(String, DVec3)]) -> Vec<(&str, String)> {
    let acting: Vec<_> = forces.iter().filter(|(_, newtons)| *newtons != DVec3::ZERO).collect();
    if acting.len() < 2 {
        return Vec::new();
    }
    let listed = acting.iter().take(CAUSES);
    let mut rows: Vec<_> = listed.map(|(cause, newtons)| (&**cause, vector(*newtons, "N"))).collect();
    if let Some(others) = acting.get(CAUSES..).filter(|others| !others.is_empty()) {
        rows.push(("by others", vector(others.iter().map(|(_, newtons)| *newtons).sum(), "N")));
    }
    rows
}

fn rows(selected: &Selected, scene: Method) -> Vec<(&str, String)> {
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
    let force: DVec3 = selected.forces.iter().map(|(_, newtons)| *newtons).sum();
    let weight = selected.forces.iter().find(|(cause, _)| cause == "by gravity");
    let weight = weight.map_or(DVec3::ZERO, |(_, newtons)| *newtons);
    rows.extend([
        ("velocity", vector(body.velocity, "m/s")),
        ("speed", format!("{} m/s", number(length(body.velocity)))),
        ("acceleration", vector(force * body.inverse_mass, "m/s²")),
        ("force", vector(force, "N")),
    ]);
    rows.extend(causes(&selected.forces));
    rows.extend([
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
    // -0 is 0.
    let (value, size) = (value + 0.0, value.abs());
    if value == 0.0 || (1e-2..1e6).contains(&size) { format!("{value:.3}") } else { format!("{value:.3e}") }
}

#[cfg(test)]
mod tests {
    use motion::clock::FrameClock;
    use scene::Scene;

    use super::*;
    use crate::app::session::{Options, Session};
    use crate::input::InputFrame;

    /// The card of that body after some ticks.
    fn card(scene: Scene, body: &str, ticks: u32) -> Vec<(String, String)> {
        let tick = 1.0 / scene.step_hz;
        let (mut session, mut clock) = (Session::new(scene, Options::default()), FrameClock::default());
        for _ in 0..ticks {
            session.advance(&InputFrame::NOTHING, clock.advance_by(tick).expect("time goes on"));
        }
        let body = session.body(body).expect("a body of the scene");
        let selected = Selected::of(&mut session, body).expect("a thing");
        rows(&selected, Method::default()).into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    fn value<'a>(rows: &'a [(String, String)], name: &str) -> Option<&'a str> {
        rows.iter().find(|(known, _)| known == name).map(|(_, value)| &**value)
    }

    #[test]
    fn the_card_has_the_force_and_the_acceleration_that_act() {
        let shipped = |name| scene::load(name).expect("it is shipped");
        let rows = card(shipped("oscillator"), "ball", 0);
        // k (L - L0) = pi² 3 N on 1 kg.
        assert_eq!(value(&rows, "force"), Some("(-29.609, 0.000, 0.000) N"));
        assert_eq!(value(&rows, "acceleration"), Some("(-29.609, 0.000, 0.000) m/s²"));
        assert_eq!(value(&rows, "by spring to anchor"), None, "it is all there is");
        let rows = card(shipped("third_law"), "heavy", 0);
        assert_eq!(value(&rows, "force"), Some("(60.000, 0.000, 0.000) N"));
        assert_eq!(value(&rows, "acceleration"), Some("(6.000, 0.000, 0.000) m/s²"));
        let text = "(version: 1, step_hz: 10, gravity: (), damping: (model: tutorial, rate_per_s: 1),
            bodies: [(name: \"ball\", mass_kg: 2, velocity_m_s: (3, 0, 0))])";
        let rows = card(Scene::parse("t", text).expect("a good scene"), "ball", 0);
        let shown = ["force", "by gravity", "by damping", "weight"].map(|name| value(&rows, name));
        let expected = [
            "(-6.000, -19.600, 0.000) N",
            "(0.000, -19.600, 0.000) N",
            "(-6.000, 0.000, 0.000) N",
            "19.600 N",
        ];
        assert_eq!(shown, expected.map(Some));
    }

    #[test]
    fn the_causes_of_a_force_are_few() {
        let rows = card(scene::load("flag").expect("it is shipped"), "flag.r8.c12", 30);
        let causes: Vec<_> =
            rows.iter().map(|(name, _)| &**name).filter(|name| name.starts_with("by ")).collect();
        assert_eq!(causes, ["by gravity", "by 12 springs", "by drag"]);
    }
}
