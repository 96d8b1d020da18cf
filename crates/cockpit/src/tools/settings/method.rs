//! The choice of a method of integration, with the claims of the chosen one.

use egui::{ComboBox, Grid, Ui};
use history::Change;
use motion::{Claims, Method, Request};

use super::ask;
use crate::input::SwitchedBy;
use crate::intent::Intent;
use crate::methods::{stable, yes_or_no};
use crate::view::card::Selected;

/// Width at which a long source is broken into lines, points.
const WIDTH: f32 = 280.0;

/// Lays out the choice of the scene's method.
pub(super) fn of_scene(ui: &mut Ui, method: Method, intents: &mut Vec<Intent>) {
    let mut chosen = method;
    ui.horizontal(|ui| {
        ui.label("method");
        ComboBox::from_id_salt("method")
            .selected_text(chosen.claims().title)
            .height(400.0)
            .show_ui(ui, |ui| {
                for method in Method::ALL {
                    ui.selectable_value(&mut chosen, method, method.claims().title);
                }
            });
    });
    if chosen != method {
        intents.push(Intent::Change(Change::Method(chosen), SwitchedBy::Settings));
    }
    promises(ui, method.claims());
}

fn promises(ui: &mut Ui, claims: &Claims) {
    Grid::new("claims").num_columns(3).spacing([16.0, 2.0]).show(ui, |ui| {
        let mut row = |what: &str, under_x: &str, under_v: &str| {
            ui.weak(what);
            ui.label(under_x);
            ui.label(under_v);
            ui.end_row();
        };
        row("laws that depend on", "position", "velocity");
        let orders = format!("{}, {}", claims.position_order, claims.velocity_order);
        row("order of x, v", &orders, &claims.order_with_velocity_laws.to_string());
        let evaluations =
            [claims.evaluations, claims.evaluations_with_velocity_laws].map(|n| n.to_string());
        row("evaluations", &evaluations[0], &evaluations[1]);
        row("stable", &stable(claims).replace("w h", "ω h"), "");
        let conserves = [claims.symplectic, claims.reversible].map(yes_or_no).join(", ");
        row("symplectic, reversible", &conserves, "");
    });
    ui.scope(|ui| {
        ui.set_max_width(WIDTH);
        ui.weak(format!("source: {}", claims.source));
    });
}

/// Lays out the choice of the selected body's method: the scene's, or its own.
pub(super) fn of_body(
    ui: &mut Ui,
    id: u32,
    selected: &Selected,
    scene: Method,
    intents: &mut Vec<Intent>,
) {
    let mut chosen = selected.own_method;
    let like_the_scene = format!("the scene's: {}", scene.claims().title);
    ui.horizontal(|ui| {
        ui.label("method");
        let shown = chosen.map_or(like_the_scene.as_str(), |method| method.claims().title);
        ComboBox::from_id_salt("method of the body").selected_text(shown).height(400.0).show_ui(
            ui,
            |ui| {
                ui.selectable_value(&mut chosen, None, &like_the_scene);
                for method in Method::ALL {
                    ui.selectable_value(&mut chosen, Some(method), method.claims().title);
                }
            },
        );
    });
    if chosen != selected.own_method {
        intents.push(ask(Request::SetBodyMethod(id, chosen)));
    }
}
