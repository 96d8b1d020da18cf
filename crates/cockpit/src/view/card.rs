//! The card of the selection: the tutorial's quantities with their units.

use bevy_ecs::prelude::*;
use egui::{Align2, Grid, Id, RichText, Sense, Stroke, TextStyle, Ui, Vec2};
use glam::DVec3;
use motion::{ForceCause, Method, PhysicsBody, Transform};
use pick::Viewpoint;
use report::numbers::three_decimals;

use crate::stage::Stage;
use crate::stage::forces::{add_to, synchronized, synchronized_points};
use crate::stage::quarantines::quarantined_because;
use crate::stage::soft::SoftSum;

/// Points between the card and the edge of the picture.
const MARGIN: f32 = 8.0;

/// Width of three components with two digits before the decimal point, points.
const WIDTH: f32 = 340.0;

/// Side of the square for an arrow, points.
const DIRECTION: f32 = 13.0;

/// Lengths, m, and velocities, m/s, below this are rounding errors, and shown as 0.
const NOISE: f64 = 1e-14;

/// Fraction of the largest term below which a sum is a rounding error, and shown as 0.
const ROUNDING: f64 = 1e-12;

/// Greatest number of springs of one body that are listed one by one.
const SPRINGS: usize = 3;

/// The selected thing in the tutorial's terms.
pub(crate) struct Selected {
    pub entity: Entity,
    pub name: String,
    pub position: DVec3,
    pub displacement: DVec3,
    /// Its body, at the time of the position; `None` for scenery.
    pub body: Option<PhysicsBody>,
    /// The forces on it, N, by cause; springs together if there are many. Empty for a soft body.
    pub forces: Vec<(String, DVec3)>,
    /// Its own method, if it has one.
    pub own_method: Option<Method>,
    /// When and by which system it was quarantined, if it was.
    pub quarantined: Option<String>,
    /// Sums over the points of a soft body.
    pub soft: Option<SoftSum>,
}

impl Selected {
    pub(crate) fn of(stage: &Stage, entity: Entity) -> Option<Self> {
        match SoftSum::of(stage.sim(), entity) {
            Some(soft) => Some(Self::of_points(stage, entity, soft)),
            None => Self::of_thing(stage, entity),
        }
    }

    /// A soft body as its center of mass.
    fn of_points(stage: &Stage, entity: Entity, mut soft: SoftSum) -> Self {
        let pushes = stage.here().pushes();
        soft.body = synchronized_points(&stage.sim().world, &pushes, entity, soft.body);
        Self {
            entity,
            name: stage.name(entity),
            position: soft.position,
            displacement: soft.displacement,
            body: Some(soft.body),
            forces: Vec::new(),
            own_method: None,
            quarantined: None,
            soft: Some(soft),
        }
    }

    fn of_thing(stage: &Stage, entity: Entity) -> Option<Self> {
        let position = stage.sim().world.get::<Transform>(entity)?.position;
        let start = stage
            .sim()
            .id(entity)
            .map_or(position, |id| stage.sim().scene.bodies[id as usize].position);
        let forces = stage.forces_on(entity);
        Some(Self {
            entity,
            name: stage.name(entity),
            position,
            displacement: position - start,
            body: synchronized(&stage.sim().world, entity, &forces),
            forces: Self::named(stage, &forces),
            own_method: stage.sim().world.get_entity(entity).ok().and_then(motion::own_method),
            quarantined: quarantined_because(stage.sim(), stage.recorder(), entity),
            soft: None,
        })
    }

    /// The forces under their names: a few springs each by its other end, many as one sum.
    fn named(stage: &Stage, forces: &[(ForceCause, DVec3)]) -> Vec<(String, DVec3)> {
        let springs =
            forces.iter().filter(|(cause, _)| matches!(cause, ForceCause::Spring(_))).count();
        let mut named: Vec<(String, DVec3)> = Vec::new();
        for (cause, newtons) in forces {
            let name = match cause {
                ForceCause::Spring(other) if springs <= SPRINGS => {
                    format!("by spring to {}", stage.name(*other))
                }
                ForceCause::Spring(_) => format!("by {springs} springs"),
                cause @ (ForceCause::Push | ForceCause::Law(_)) => {
                    format!("by {}", cause.name().replace('_', " "))
                }
            };
            add_to(&mut named, name, *newtons);
        }
        named
    }
}

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
            lines(ui, selected, scene);
        });
    // It was placed by the width of the last layout.
    let edge = context.content_rect().right() - MARGIN;
    if card.is_some_and(|card| (card.response.rect.right() - edge).abs() > 0.5) {
        context.request_discard("the card has another width");
    }
}

/// Lays out the rows of the card.
fn lines(ui: &mut Ui, selected: &Selected, scene: Method) {
    ui.label(RichText::new(&selected.name).strong());
    Grid::new("quantities").num_columns(2).show(ui, |ui| {
        for (quantity, value) in rows(selected, scene) {
            ui.label(quantity);
            ui.label(RichText::new(value).text_style(TextStyle::Monospace));
            ui.end_row();
        }
    });
}

/// Lays out the rows of the card in the dock: vectors as their length and an arrow that points as in the picture of `camera`, or
/// as their components if a person asks for them.
pub(crate) fn dock_lines(ui: &mut Ui, selected: &Selected, scene: Method, camera: &Viewpoint) {
    let id = Id::unique("components of vectors");
    let mut components = ui.data(|data| data.get_temp(id)).unwrap_or(false);
    ui.horizontal(|ui| {
        ui.label(RichText::new(&selected.name).strong());
        ui.toggle_value(&mut components, "x y z")
            .on_hover_text("components of vectors instead of their lengths");
    });
    ui.data_mut(|data| data.insert_temp(id, components));
    Grid::new("quantities").num_columns(2).show(ui, |ui| {
        for (quantity, value) in quantities(selected, scene) {
            match value {
                // The row of the velocity shows it.
                Quantity::Text(_) if quantity == "speed" && !components => continue,
                Quantity::Vector(v, noise, unit) if quantity != "position" && !components => {
                    ui.label(quantity);
                    ui.horizontal(|ui| {
                        let length = scalar(length(v), noise);
                        direction(ui, v, noise, camera);
                        ui.label(format!("{length} {unit}")).on_hover_text(value.text());
                    });
                }
                value @ (Quantity::Vector(..) | Quantity::Text(_)) => {
                    ui.label(quantity);
                    ui.label(value.text());
                }
            }
            ui.end_row();
        }
    });
}

/// Paints an arrow that points as `v` does in the picture of `camera`, a dot if `v` points along the line of sight, nothing if it
/// is 0.
fn direction(ui: &mut Ui, v: DVec3, noise: f64, camera: &Viewpoint) {
    let (place, _) = ui.allocate_exact_size(Vec2::splat(DIRECTION), Sense::hover());
    let Some(along) = v.try_normalize().filter(|_| length(v) > noise) else { return };
    #[expect(clippy::cast_possible_truncation, reason = "points")]
    let arrow =
        Vec2::new(along.dot(camera.right()) as f32, -along.dot(camera.up()) as f32) * DIRECTION;
    let color = ui.visuals().text_color();
    if arrow.length() < 0.3 * DIRECTION {
        ui.painter().circle_filled(place.center(), 2.0, color);
    } else {
        ui.painter().arrow(place.center() - arrow / 2.0, arrow, Stroke::new(1.5, color));
    }
}

/// Greatest number of causes of forces that are listed.
const CAUSES: usize = 6;

/// A value of the card.
enum Quantity {
    /// A vector, the length below which it is 0, and its unit.
    Vector(DVec3, f64, &'static str),
    Text(String),
}

impl Quantity {
    /// The value as text, a vector by its components.
    fn text(&self) -> String {
        match self {
            Self::Vector(v, noise, unit) => vector(*v, *noise, unit),
            Self::Text(text) => text.clone(),
        }
    }
}

/// The forces that are not 0, if there is more than one.
fn causes(forces: &[(String, DVec3)]) -> Vec<(&str, Quantity)> {
    let acting: Vec<_> = forces.iter().filter(|(_, newtons)| *newtons != DVec3::ZERO).collect();
    if acting.len() < 2 {
        return Vec::new();
    }
    let listed = acting.iter().take(CAUSES);
    let mut rows: Vec<_> =
        listed.map(|(cause, newtons)| (&**cause, Quantity::Vector(*newtons, 0.0, "N"))).collect();
    if let Some(others) = acting.get(CAUSES..).filter(|others| !others.is_empty()) {
        let sum = others.iter().map(|(_, newtons)| *newtons).sum();
        rows.push(("by others", Quantity::Vector(sum, 0.0, "N")));
    }
    rows
}

/// The rows of the card, as text.
pub(crate) fn rows(selected: &Selected, scene: Method) -> Vec<(&str, String)> {
    quantities(selected, scene)
        .into_iter()
        .map(|(quantity, value)| (quantity, value.text()))
        .collect()
}

fn quantities(selected: &Selected, scene: Method) -> Vec<(&str, Quantity)> {
    use Quantity::{Text, Vector};
    let mut rows = vec![
        ("position", Vector(selected.position, NOISE, "m")),
        ("displacement", Vector(selected.displacement, NOISE, "m")),
    ];
    let Some(body) = selected.body else {
        rows.push(("physics", Text("none: scenery".to_owned())));
        return rows;
    };
    if let Some(soft) = &selected.soft {
        rows.extend(soft_rows(soft));
        return rows;
    }
    let movable = body.inverse_mass > 0.0;
    let force: DVec3 = selected.forces.iter().map(|(_, newtons)| *newtons).sum();
    let largest = selected.forces.iter().map(|(_, newtons)| length(*newtons)).fold(0.0, f64::max);
    let noise = ROUNDING * largest;
    let weight = selected.forces.iter().find(|(cause, _)| cause == "by gravity");
    let weight = weight.map_or(DVec3::ZERO, |(_, newtons)| *newtons);
    rows.extend([
        ("velocity", Vector(body.velocity, NOISE, "m/s")),
        ("speed", Text(format!("{} m/s", scalar(length(body.velocity), NOISE)))),
        ("acceleration", Vector(force * body.inverse_mass, noise * body.inverse_mass, "m/s²")),
        ("force", Vector(force, noise, "N")),
    ]);
    rows.extend(causes(&selected.forces));
    rows.extend([
        (
            "mass",
            Text(if movable {
                format!("{} kg", three_decimals(body.mass()))
            } else {
                "infinite".to_owned()
            }),
        ),
        ("inverse mass", Text(format!("{} 1/kg", three_decimals(body.inverse_mass)))),
        ("momentum", Vector(body.momentum(), NOISE * body.mass(), "kg m/s")),
        ("weight", Text(format!("{} N", three_decimals(length(weight))))),
    ]);
    if movable {
        let (method, whose) =
            selected.own_method.map_or((scene, "the scene's"), |own| (own, "its own"));
        rows.push(("method", Text(format!("{}, {whose}", method.claims().title))));
    }
    if let Some(why) = &selected.quarantined {
        rows.push(("quarantined", Text(why.clone())));
    }
    rows
}

/// Three components with a unit. Components below `noise`, or below rounding of the largest one, are 0; a small one has the
/// decimals of the largest.
fn vector(v: DVec3, noise: f64, unit: &str) -> String {
    let largest = v.abs().max_element();
    let noise = noise.max(ROUNDING * largest);
    let [x, y, z] = v.to_array().map(|part| match part.abs() {
        size if largest >= 1e-2 && size < 5e-4 => scalar(0.0, noise),
        size if largest >= 1e-2 && size < 1e-2 => format!("{part:.3}"),
        _ => scalar(part, noise),
    });
    format!("({x}, {y}, {z}) {unit}")
}

fn scalar(value: f64, noise: f64) -> String {
    three_decimals(if value.abs() < noise { 0.0 } else { value })
}

/// The rows of a soft body: sums over its points. No acceleration: pins hold a soft body with forces that only its springs know.
fn soft_rows(soft: &SoftSum) -> Vec<(&'static str, Quantity)> {
    use Quantity::{Text, Vector};
    let SoftSum { body, points, pinned, quarantined, springs, .. } = soft;
    let mut counted = points.to_string();
    for (count, word) in [(pinned, "pinned"), (quarantined, "quarantined")] {
        if *count > 0 {
            counted += &format!(", {count} {word}");
        }
    }
    let mass = if body.inverse_mass > 0.0 {
        format!("{} kg", three_decimals(body.mass()))
    } else {
        "infinite".to_owned()
    };
    vec![
        ("velocity", Vector(body.velocity, NOISE, "m/s")),
        ("speed", Text(format!("{} m/s", scalar(length(body.velocity), NOISE)))),
        ("points", Text(counted)),
        ("springs", Text(springs.to_string())),
        ("mass", Text(mass)),
        ("momentum", Vector(body.momentum(), NOISE * body.mass(), "kg m/s")),
        ("kinetic energy", Text(format!("{} J", three_decimals(soft.kinetic_energy)))),
        ("spring energy", Text(format!("{} J", three_decimals(soft.spring_energy)))),
    ]
}

/// The length of `v`, even if its square overflows.
fn length(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (v / largest).length() * largest } else { largest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounding_leaves_is_0_and_what_is_small_is_not() {
        let of = |x, y| vector(DVec3::new(x, y, 0.0), NOISE, "m/s");
        assert_eq!(of(0.0, 2.142e-31), "(0.000, 0.000, 0.000) m/s");
        assert_eq!(of(3.0, -4.4e-13), "(3.000, 0.000, 0.000) m/s");
        assert_eq!(of(3e-9, 4e-9), "(3.000e-9, 4.000e-9, 0.000) m/s");
        assert_eq!(vector(DVec3::X * 6e-24, 0.0, "N"), "(6.000e-24, 0.000, 0.000) N");
        assert_eq!(scalar(f64::NAN, NOISE), "NaN");
    }
}
