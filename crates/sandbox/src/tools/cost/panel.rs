//! The panel of accuracy and cost: one dot per method and step, measured on a copy of the running scene.

use egui::{Color32, Grid, Id, ProgressBar, RichText, Ui};
use egui_plot::{Line, LineStyle, MarkerShape, Plot, PlotPoint, PlotPoints, PlotUi, Points, VLine};
use lab::cost::{Accuracy, Cell, Cost, Setting, Study};
use motion::Method;
use report::ink;

use crate::tools::cost::state::{self, SHARE};
use crate::tools::tool::{Desk, Edit};
use crate::view::hud::{mouse_hint, swatch};
use crate::view::inks;

/// What the axes count.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axes {
    accuracy: Accuracy,
    cost: Cost,
}

impl Default for Axes {
    fn default() -> Self {
        Self { accuracy: Accuracy::Position, cost: Cost::Evaluations }
    }
}

const WIDTH: f32 = 430.0;
const HEIGHT: f32 = 300.0;
/// A click belongs to the nearest dot, if that is no farther, points.
const REACH: f32 = 14.0;
const FRONT: Color32 = Color32::from_gray(150);
const FAILED: Color32 = Color32::from_rgb(255, 90, 80);

/// The panel; whether the study is to start again.
pub(super) fn show(ui: &mut Ui, cost: &state::Cost, desk: &mut Desk<'_>) -> bool {
    let width = desk.width(WIDTH);
    ui.set_width(width);
    let Some(study) = cost.study() else {
        ui.label("the first run begins with the next frame");
        return false;
    };
    mouse_hint(ui, desk.stage);
    let again = head(ui, study, cost.progress(), width);
    // They stay as they are chosen when another scene is opened.
    let id = Id::unique("cost axes");
    let mut axes: Axes = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    choose(ui, &mut axes);
    ui.data_mut(|data| data.insert_temp(id, axes));
    if let Some(setting) = plot(ui, study, axes, desk.stage.setting(), width) {
        desk.edits.push(Edit::ApplySetting(setting));
    }
    legend(ui, study);
    foot(ui, study, axes, width);
    again
}

/// How far the study is; whether it is to start again.
fn head(ui: &mut Ui, study: &Study, progress: f64, width: f32) -> bool {
    ui.horizontal(|ui| {
        if progress < 1.0 {
            #[expect(clippy::cast_possible_truncation, reason = "a part of 1")]
            let done = progress as f32;
            let words = format!("measuring on a copy, {:.0} % of each frame", SHARE * 100.0);
            ui.add(ProgressBar::new(done).desired_width(width - 110.0).text(words));
        } else {
            let Study { simulated_s, bodies, .. } = study;
            let s = if *bodies == 1 { "y" } else { "ies" };
            ui.label(format!("{bodies} bod{s}, {simulated_s:.3} s from the start, measured on a copy"));
        }
        ui.button("again").clicked()
    })
    .inner
}

fn choose(ui: &mut Ui, axes: &mut Axes) {
    ui.horizontal(|ui| {
        ui.weak("error in");
        ui.radio_value(&mut axes.accuracy, Accuracy::Position, "m");
        ui.radio_value(&mut axes.accuracy, Accuracy::Relative, "parts of the motion");
    });
    ui.horizontal(|ui| {
        ui.weak("cost in");
        ui.radio_value(&mut axes.cost, Cost::Evaluations, "evaluations per body per s");
        ui.radio_value(&mut axes.cost, Cost::RealTime, "part of real time");
    });
}

/// A dot: its place, in logarithms, and its cell.
struct Dot<'a> {
    at: [f64; 2],
    cell: &'a Cell,
}

fn dots(study: &Study, axes: Axes, method: Method) -> Vec<Dot<'_>> {
    let dot = |cell: &'_ Cell| {
        let (cost, error) = (study.cost(cell, axes.cost)?, study.error(cell, axes.accuracy)?);
        (cost > 0.0).then(|| [cost.log10(), error.max(LEAST).log10()])
    };
    let curve = study.curve(method, lab::cost::Precision::F64);
    curve.filter_map(|cell| Some(Dot { at: dot(cell)?, cell })).collect()
}

/// Errors below are drawn there: exact is nowhere on a logarithmic axis.
const LEAST: f64 = 1e-16;

/// The plot; the setting whose dot was clicked.
fn plot(ui: &mut Ui, study: &Study, axes: Axes, present: Setting, width: f32) -> Option<Setting> {
    let all: Vec<_> = Method::ALL.into_iter().flat_map(|method| dots(study, axes, method)).collect();
    let power = |mark: egui_plot::GridMark, _: &std::ops::RangeInclusive<f64>| match mark.value.fract() {
        0.0 => format!("1e{:.0}", mark.value),
        _ => String::new(),
    };
    let decades = |input: egui_plot::GridInput| {
        let (from, to) = input.bounds;
        // Those beyond the ends would be written outside of the plot.
        #[expect(clippy::cast_possible_truncation, reason = "decades")]
        let decades = from.ceil() as i32..=to.floor() as i32;
        decades
            .map(|decade| egui_plot::GridMark { value: f64::from(decade), step_size: 3.0 })
            .collect::<Vec<_>>()
    };
    let words = match axes.cost {
        Cost::RealTime | Cost::Time => "CPU seconds per simulated second",
        Cost::Evaluations | Cost::Instructions => "evaluations per body per simulated second",
    };
    let plot = Plot::new(("cost", axes.accuracy as u8, axes.cost as u8))
        .width(width)
        .height(HEIGHT)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_boxed_zoom(false)
        .x_axis_label(words)
        .y_axis_label(match axes.accuracy {
            Accuracy::Position => "largest error, m",
            Accuracy::Relative | Accuracy::Velocity => "largest error, relative",
        })
        .x_axis_formatter(power)
        .y_axis_formatter(power)
        .x_grid_spacer(decades)
        .y_grid_spacer(decades)
        .label_formatter(|_| None);
    plot.show(ui, |ui| {
        draw(ui, study, axes, &all, present);
        let pointer = ui.response().hover_pos()?;
        let distance =
            |dot: &Dot<'_>| ui.screen_from_plot(PlotPoint::new(dot.at[0], dot.at[1])).distance(pointer);
        let near = all.iter().map(|dot| (distance(dot), dot)).filter(|(distance, _)| *distance < REACH);
        let (_, dot) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let words = hint(study, dot.cell, axes);
        let clicked = ui.response().clicked();
        ui.response().clone().on_hover_text_at_pointer(words);
        clicked.then_some(dot.cell.setting)
    })
    .inner
}

fn draw(ui: &mut PlotUi<'_>, study: &Study, axes: Axes, all: &[Dot<'_>], present: Setting) {
    let front: Vec<_> = study
        .front(axes.accuracy, axes.cost)
        .into_iter()
        .filter_map(|cell| all.iter().find(|dot| dot.cell.setting == cell.setting))
        .map(|dot| dot.at)
        .collect();
    let visuals = ui.ctx().global_style().visuals.clone();
    let color_of = |method| inks::of_method(&visuals, method);
    let emphasis = visuals.strong_text_color();
    let gray = inks::marks(&visuals, FRONT);
    ui.line(Line::new("front", PlotPoints::from(front)).color(gray).width(4.0).allow_hover(false));
    if axes.cost == Cost::RealTime {
        ui.vline(VLine::new("real time", 0.0).color(emphasis).style(LineStyle::dashed_dense()));
    }
    for method in Method::ALL {
        let color = color_of(method);
        let curve: Vec<_> =
            all.iter().filter(|dot| dot.cell.setting.method == method).map(|dot| dot.at).collect();
        ui.line(
            Line::new("", PlotPoints::from(curve.clone()))
                .color(color.gamma_multiply(0.5))
                .allow_hover(false),
        );
        ui.points(Points::new("", PlotPoints::from(curve)).color(color).radius(4.0).allow_hover(false));
    }
    if let Some(dot) = all.iter().find(|dot| dot.cell.setting == present) {
        let ring = PlotPoints::from(vec![dot.at]);
        ui.points(Points::new("", ring).color(emphasis).radius(8.0).filled(false).allow_hover(false));
    }
    let top = all.iter().map(|dot| dot.at[1]).fold(f64::NEG_INFINITY, f64::max);
    let failed = study.cells.iter().filter(|cell| cell.is_run() && cell.errors().is_none());
    for cell in failed {
        if let (Some(cost), true) = (study.cost(cell, axes.cost).filter(|cost| *cost > 0.0), top.is_finite())
        {
            let mark = PlotPoints::from(vec![[cost.log10(), top + 0.7]]);
            let color = color_of(cell.setting.method);
            ui.points(
                Points::new("", mark).color(color).radius(5.0).shape(MarkerShape::Cross).allow_hover(false),
            );
        }
    }
}

fn hint(study: &Study, cell: &Cell, axes: Axes) -> String {
    let Setting { method, substeps, .. } = cell.setting;
    let rate = study.step_hz * f64::from(substeps);
    let error = study.error(cell, axes.accuracy).unwrap_or(f64::NAN);
    let unit = if axes.accuracy == Accuracy::Position { " m" } else { "" };
    let evaluations = study.cost(cell, Cost::Evaluations).unwrap_or(f64::NAN);
    let mut words = format!(
        "{} x {substeps}: {rate:.0} steps per s\nerror {error:.2e}{unit}, {evaluations:.0} evaluations per s",
        method.claims().title
    );
    if let Some(time) = &cell.time {
        words += &format!(
            "\n{:.1} ns per body per step, {:.0} times real time",
            time.ns_per_body_step, time.real_time_factor
        );
    }
    if let Some(of) = study.world_times().find(|of| of.method == method) {
        words += &format!(
            "\na tick: {:.0} ns fixed + {:.1} ns per body per step",
            of.fixed_ns, of.ns_per_body_step
        );
    }
    words + "\nClick to use it."
}

fn legend(ui: &mut Ui, study: &Study) {
    Grid::new("cost legend").num_columns(5).spacing([10.0, 1.0]).show(ui, |ui| {
        for (place, method) in Method::ALL.into_iter().enumerate() {
            let failed = study
                .cells
                .iter()
                .any(|cell| cell.setting.method == method && cell.is_run() && cell.errors().is_none());
            ui.horizontal(|ui| {
                swatch(ui, inks::of_method(ui.visuals(), method));
                ui.label(ink(method).short);
                if failed {
                    let color = inks::words(ui.visuals(), FAILED);
                    ui.label(RichText::new("×").color(color)).on_hover_text("some of its runs failed");
                }
            });
            if place % 5 == 4 {
                ui.end_row();
            }
        }
    });
}

fn foot(ui: &mut Ui, study: &Study, axes: Axes, width: f32) {
    let front = study.front(axes.accuracy, axes.cost);
    if let (Some(cheap), Some(best)) = (front.first(), front.last()) {
        let words = format!("on the front: from {} to {}", cheap.setting, best.setting);
        ui.label(words);
    }
    ui.scope(|ui| {
        ui.set_max_width(width);
        for sentence in report::time_words(study) {
            ui.label(sentence);
        }
        for note in &study.notes {
            ui.weak(note);
        }
    });
}
