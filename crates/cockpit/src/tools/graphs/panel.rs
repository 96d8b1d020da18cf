//! The panel of graphs: the choice of bodies and quantities, and the plot.

use egui::{Button, Color32, ComboBox, Grid, Role, Ui, Visuals, WidgetInfo};
use egui_plot::Legend;
use report::{REFERENCE_INK, ink};

use crate::intent::Intent;
use crate::stage::things::Thing;
use crate::tools::curves::{self, Curve};
use crate::tools::graphs::state::{Graphed, Graphs, MOST_KEPT, Part, Quantity, Run, Sample, Track};
use crate::tools::tool::Desk;
use crate::view::hud::swatch;
use crate::view::inks;

const HEIGHT: f32 = 160.0;
const WIDTH: f32 = 420.0;

/// Width of curves, points.
const THIN: f32 = 1.5;
/// Width of the curve of a body among those of ghosts, points.
const THICK: f32 = 2.5;

/// Colors of the parts of one vector, and of several bodies: the kept ones and the selection.
const COLORS: [Color32; MOST_KEPT + 1] = [
    Color32::from_rgb(255, 120, 110),
    Color32::from_rgb(130, 210, 130),
    Color32::from_rgb(120, 180, 255),
    Color32::from_rgb(255, 200, 90),
    Color32::from_rgb(200, 150, 255),
    Color32::from_rgb(90, 220, 215),
    Color32::from_rgb(255, 150, 210),
    Color32::from_rgb(190, 190, 120),
    Color32::from_rgb(200, 200, 200),
];

pub(super) fn show(ui: &mut Ui, graphs: &mut Graphs, desk: &mut Desk<'_>) {
    ui.set_width(desk.width(WIDTH));
    ui.horizontal(|ui| {
        let list = ComboBox::from_id_salt("quantity").selected_text(graphs.quantity.name());
        list.show_ui(ui, |ui| {
            for quantity in Quantity::ALL {
                ui.selectable_value(&mut graphs.quantity, quantity, quantity.name());
            }
        });
        let sampled = graphs
            .bodies
            .iter()
            .flat_map(|body| &body.tracks)
            .any(|track| !track.samples.is_empty());
        let save = ui.add_enabled(sampled, Button::new("Save CSV"));
        if save.on_hover_text("every quantity of the graph's seconds as a table").clicked() {
            desk.intents.push(Intent::SaveTable(graphs.csv()));
        }
    });
    if graphs.bodies.is_empty() {
        ui.weak("Select a body to see how it moves.");
        return;
    }
    if !graphs.quantity.is_scalar() {
        parts(ui, graphs);
    }
    bodies(ui, graphs);
    let curves = match graphs.has_several() {
        true => several(ui.visuals(), graphs),
        false => graphs.bodies.iter().flat_map(|body| single(graphs, body)).collect(),
    };
    if curves.iter().any(|curve| !curve.points.is_empty()) {
        let legend = (!graphs.has_several()).then(Legend::default);
        curves::show(ui, "graph", HEIGHT, legend, &curves);
    }
    methods(ui, graphs);
    unknown(ui, graphs);
}

/// Lays out the choice of the parts of a vector that are drawn: any of them for a single body without ghosts, else one.
fn parts(ui: &mut Ui, graphs: &mut Graphs) {
    let several = graphs.has_several();
    ui.horizontal(|ui| {
        for (place, part) in Part::ALL.into_iter().enumerate() {
            let shown = graphs.parts.0[place];
            let on = if several { graphs.part == part } else { shown };
            if !ui.add(Button::selectable(on, part.name())).clicked() {
                continue;
            }
            if several {
                (graphs.part, graphs.has_chosen) = (part, true);
            } else if !shown || graphs.parts.0.iter().filter(|shown| **shown).count() > 1 {
                graphs.parts.0[place] ^= true;
            }
        }
    });
}

/// Lists the bodies, each with the button that keeps or removes it.
fn bodies(ui: &mut Ui, graphs: &mut Graphs) {
    let has_room = graphs.bodies.iter().filter(|body| body.kept).count() < MOST_KEPT;
    let several = graphs.bodies.len() > 1;
    for body in &mut graphs.bodies {
        ui.horizontal(|ui| {
            // Invisible, but with its place, so that the keyboard stays on the button.
            ui.scope(|ui| {
                if !body.kept && !several {
                    ui.set_invisible();
                }
                swatch(ui, color(ui.visuals(), body));
            });
            ui.label(&body.name);
            if body.kept {
                let remove = ui.small_button("×").on_hover_text("remove it from the graph");
                let words = format!("Remove {}", body.name);
                remove.widget_info(|| WidgetInfo::labeled(Role::Button, true, &words));
                body.kept = !remove.clicked();
            } else {
                let keep = ui.add_enabled(has_room, Button::new("Keep").small());
                let keep = keep
                    .on_hover_text("keeps the body in the graph when something else is selected");
                let full = format!("{MOST_KEPT} bodies are kept; remove one first");
                body.kept = keep.on_disabled_hover_text(full).clicked();
            }
        });
    }
}

fn color(visuals: &Visuals, body: &Graphed) -> Color32 {
    inks::marks(visuals, COLORS[body.ink % COLORS.len()])
}

/// The color and the short name of a ghost.
fn of_ghost(visuals: &Visuals, run: Run) -> Option<(Color32, &'static str)> {
    let Run::Ghost(method) = run else { return None };
    let [r, g, b] = REFERENCE_INK.srgb;
    Some(method.map_or_else(
        || (inks::marks(visuals, Color32::from_rgb(r, g, b)), REFERENCE_INK.short),
        |method| (inks::of_method(visuals, method), ink(method).short),
    ))
}

fn points(track: &Track, quantity: Quantity, part: Part) -> Vec<[f64; 2]> {
    let point = |sample: &Sample| Some([sample.time, quantity.value(&sample.motion, part)?]);
    track.samples.iter().filter_map(point).collect()
}

/// The parts of one body's vector, each in its color.
fn single(graphs: &Graphs, body: &Graphed) -> Vec<Curve> {
    let Some(track) = body.tracks.first() else { return Vec::new() };
    let curve = |(name, color, part)| Curve {
        name,
        color,
        width: THIN,
        points: points(track, graphs.quantity, part),
    };
    if graphs.quantity.is_scalar() {
        let name = graphs.quantity.name().split([' ', ',']).next().unwrap_or_default();
        return vec![curve((name.to_owned(), COLORS[1], Part::default()))];
    }
    let parts = Part::ALL.into_iter().zip(COLORS).zip(graphs.parts.0).filter(|(_, shown)| *shown);
    parts.map(|((part, color), _)| curve((part.name().to_owned(), color, part))).collect()
}

/// The curves of one part of every body, in its color, over those of its ghosts, in the colors of their methods. Ghosts are left
/// out where they fly off: beside them the other curves would be flat.
fn several(visuals: &Visuals, graphs: &Graphs) -> Vec<Curve> {
    let tracks =
        graphs.bodies.iter().flat_map(|body| body.tracks.iter().map(move |track| (body, track)));
    let mut shown: Vec<_> = tracks
        .filter(|(_, track)| track.shown)
        .map(|(body, track)| (body, track.run, points(track, graphs.quantity, graphs.part)))
        .collect();
    shown.sort_by_key(|(_, run, _)| *run == Run::Solid);
    let stays = |run: Run| !matches!(run, Run::Ghost(Some(_)));
    let values = shown.iter().filter(|(_, run, _)| stays(*run)).flat_map(|(.., points)| points);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [_, value]| {
        (low.min(*value), high.max(*value))
    });
    let span = high - low;
    let is_near = |[_, value]: &[f64; 2]| span <= 0.0 || (low - span..=high + span).contains(value);
    let curves = |(body, run, points): (&Graphed, Run, Vec<[f64; 2]>)| {
        let (name, color, width) = match of_ghost(visuals, run) {
            Some((color, method)) => (format!("{}, {method}", body.name), color, THIN),
            None if graphs.has_ghosts() => (body.name.clone(), color(visuals, body), THICK),
            None => (body.name.clone(), color(visuals, body), THIN),
        };
        let pieces =
            points.chunk_by(|a, b| is_near(a) == is_near(b)).filter(|piece| is_near(&piece[0]));
        let curve =
            |piece: &[[f64; 2]]| Curve { name: name.clone(), color, width, points: piece.to_vec() };
        pieces.map(curve).collect::<Vec<_>>()
    };
    shown.into_iter().flat_map(curves).collect()
}

/// Names the ghosts beside their colors.
fn methods(ui: &mut Ui, graphs: &Graphs) {
    let Some(body) = graphs.bodies.first().filter(|_| graphs.has_ghosts()) else { return };
    let ghosts: Vec<_> = body
        .tracks
        .iter()
        .filter(|track| track.shown)
        .filter_map(|track| of_ghost(ui.visuals(), track.run))
        .collect();
    Grid::new("ghosts in graphs").spacing([10.0, 1.0]).show(ui, |ui| {
        for row in ghosts.chunks(4) {
            for (color, name) in row {
                ui.horizontal(|ui| {
                    swatch(ui, *color);
                    ui.weak(*name);
                });
            }
            ui.end_row();
        }
    });
    ui.weak("Ghosts are left out where they fly off.");
}

/// Says why there is no curve of a body.
fn unknown(ui: &mut Ui, graphs: &Graphs) {
    for body in &graphs.bodies {
        let known = |track: &Track| !points(track, graphs.quantity, Part::default()).is_empty();
        if body.tracks.iter().any(known) {
            continue;
        }
        let why = match body.thing {
            Thing::Soft(_) => {
                "not computed for a soft body: pins hold it with forces that only its springs know"
            }
            Thing::Body(_) => "scenery, which does not move",
        };
        ui.weak(format!("{}: {why}.", body.name));
    }
}

#[cfg(test)]
mod tests {
    use motion::Method;

    use super::*;
    use crate::stage::Stage;
    use crate::stage::options::Options;
    use crate::tools::ghosts::Ghosts;
    use crate::tools::tool::Tool as _;

    /// Graphs of a plank that is kept and of one that is selected, after some ticks with ghosts.
    fn graphs() -> (Graphs, Stage) {
        let mut stage =
            Stage::new(scene::load("bridge").expect("it is shipped"), Options::default());
        let (mut graphs, mut ghosts) = (Graphs::default(), Ghosts::default());
        assert!(ghosts.toggle(&mut stage, false));
        for body in ["plank3", "plank6"] {
            stage.select(stage.sim().named(body));
            graphs.sample(&stage, &ghosts, true);
            graphs.bodies[0].kept = true;
        }
        for _ in 0..30 {
            ghosts.before_tick(&stage, true);
            stage.sim_mut().tick();
            graphs.sample(&stage, &ghosts, true);
        }
        (graphs, stage)
    }

    #[test]
    fn bodies_have_colors_of_their_own_and_ghosts_those_of_their_methods() {
        let ((mut graphs, stage), visuals) = (graphs(), Visuals::light());
        let curves = several(&visuals, &graphs);
        // Eight other methods and the reference of each body, then the bodies.
        assert_eq!(curves.len(), 2 * 10);
        let names: Vec<_> = curves[18..].iter().map(|curve| &*curve.name).collect();
        assert_eq!(names, ["plank3", "plank6"]);
        assert_ne!(curves[18].color, curves[19].color);
        for (body, curve) in ["plank3", "plank6"].into_iter().zip(&curves[18..]) {
            let place = stage
                .sim()
                .named(body)
                .and_then(|body| stage.drawn_position(body))
                .expect("a place");
            assert_eq!((curve.points.len(), curve.points[30][1]), (31, place.y));
        }
        let yoshida = curves.iter().find(|curve| curve.name == "plank6, Y4").expect("a curve");
        assert_eq!(yoshida.color, inks::of_method(&visuals, Method::Yoshida4));

        // A ghost that flies off is left out from there on.
        let ghost = &mut graphs.bodies[1].tracks[1];
        assert!(matches!(ghost.run, Run::Ghost(Some(Method::ExplicitEuler))));
        ghost.samples.range_mut(20..).for_each(|sample| sample.motion.position.y = 1e9);
        let curves = several(&visuals, &graphs);
        let longest = |name| {
            curves.iter().filter(|curve| curve.name == name).map(|curve| curve.points.len()).max()
        };
        assert_eq!((longest("plank6, EE"), longest("plank6, Y4")), (Some(20), Some(31)));

        // A falling plank: the magnitude of its velocity is the size of its y.
        graphs.quantity = Quantity::Velocity;
        let y = several(&visuals, &graphs).pop().expect("a curve").points;
        graphs.part = Part::Magnitude;
        let magnitude = several(&visuals, &graphs).pop().expect("a curve").points;
        assert!(y[30][1] < -0.5 && magnitude.iter().zip(&y).all(|(m, y)| m[1] >= y[1].abs()));
        graphs.quantity = Quantity::Force;
        let force = several(&visuals, &graphs).pop().expect("a curve").points;
        assert!((force[0][1] - 9.8).abs() < 1e-9, "it weighs 1 kg, and its springs are at rest");
    }

    #[test]
    fn several_curves_begin_with_an_axis_along_which_something_moves() {
        let mut stage =
            Stage::new(scene::load("oscillator").expect("it is shipped"), Options::default());
        let (mut graphs, mut ghosts) = (Graphs::default(), Ghosts::default());
        assert!(ghosts.toggle(&mut stage, false));
        stage.select(stage.sim().named("ball"));
        for _ in 0..30 {
            ghosts.before_tick(&stage, true);
            stage.sim_mut().tick();
            graphs.sample(&stage, &ghosts, true);
        }
        let curve = several(&Visuals::light(), &graphs).pop().expect("a curve").points;
        let [first, last] = [curve[0][1], curve[curve.len() - 1][1]];
        assert!((first - last).abs() > 0.01, "it oscillates along x: {first} to {last}");
    }

    #[test]
    fn one_body_has_a_curve_for_each_part_that_is_chosen() {
        let (mut graphs, _) = graphs();
        let names = |graphs: &Graphs| {
            single(graphs, &graphs.bodies[1])
                .into_iter()
                .map(|curve| curve.name)
                .collect::<Vec<_>>()
        };
        assert_eq!(names(&graphs), ["x", "y", "z"]);
        graphs.parts.0 = [true, false, false, true];
        assert_eq!(names(&graphs), ["x", "magnitude"]);
        graphs.quantity = Quantity::KineticEnergy;
        assert_eq!(names(&graphs), ["kinetic"]);
    }
}
