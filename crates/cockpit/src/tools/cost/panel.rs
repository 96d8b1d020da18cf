//! The panel of accuracy and cost: one dot per method and step, measured on a copy of the running scene.

use egui::{
    Button, Color32, EventFilter, Grid, Id, Key, Label, ProgressBar, Response, RichText, Role,
    Sense, Ui, WidgetInfo,
};
use egui_plot::{Line, LineStyle, MarkerShape, Plot, PlotPoint, PlotPoints, PlotUi, Points, VLine};
use lab::IS_THREAD_TIME;
use lab::cost::{Accuracy, Cell, Cost, Outcome, Setting, Study};
use motion::Method;
use report::ink;
use report::numbers::{digits, fold, length, number, power_of_ten, share};

use crate::intent::Intent;
use crate::tools::cost::state::{self, SHARE};
use crate::tools::tool::Desk;
use crate::view::hud::{mouse_hint, swatch};
use crate::view::inks;

/// The quantities of the axes.
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
/// Least height of what is below the legend in the dock, points: the amount of text depends on the machine, and a dock that is
/// scrolled to its end has to be at the same place when a recording is replayed.
const FOOT: f32 = 280.0;
/// Height of the sentences that come first, points: room for six lines, so that what is below them does not move during a study.
const HEAD: f32 = 112.0;
/// Methods per row of the legend.
const COLUMNS: usize = 4;
/// Greatest distance from a click to its dot, points.
const REACH: f32 = 14.0;
const FRONT: Color32 = Color32::from_gray(150);
const FAILED: Color32 = Color32::from_rgb(255, 90, 80);

/// Lays out the panel. Returns whether the study is to start again.
pub(super) fn show(ui: &mut Ui, cost: &state::Cost, desk: &mut Desk<'_>) -> bool {
    let width = desk.width(WIDTH);
    ui.set_width(width);
    let Some(study) = cost.study() else {
        ui.label("the first run begins with the next frame");
        return false;
    };
    mouse_hint(ui, desk.view);
    // The chosen axes stay when another scene is opened.
    let id = Id::unique("cost axes");
    let mut axes: Axes = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let present = desk.stage.setting();
    let (again, uses) = head(ui, study, cost.progress());
    let nearer = first(ui, study, axes, present).filter(|_| uses);
    choose(ui, &mut axes);
    ui.data_mut(|data| data.insert_temp(id, axes));
    let clicked = plot(ui, study, axes, present, width);
    legend(ui, study);
    let pressed = ui.scope(|ui| {
        if desk.dock_width.is_some() {
            ui.set_min_height(FOOT);
        }
        let pressed = front(ui, study, axes, present);
        foot(ui, study, width);
        pressed
    });
    desk.intents.extend(nearer.or(clicked).or(pressed.inner).map(Intent::ApplySetting));
    again
}

/// Lays out the progress of the study. Returns whether the study is to start again, and whether to use the setting with the
/// smaller error at the same cost. The button for that is there even without such a setting, because a recording counts the
/// controls.
fn head(ui: &mut Ui, study: &Study, progress: f64) -> (bool, bool) {
    ui.horizontal(|ui| {
        let again = ui.button("Measure again").clicked();
        let uses = ui
            .button("Use")
            .on_hover_text("uses the method and substeps with the smaller error at the same cost")
            .clicked();
        if progress < 1.0 {
            #[expect(clippy::cast_possible_truncation, reason = "a part of 1")]
            let done = progress as f32;
            let bar = ProgressBar::new(done).desired_width(ui.available_width()).text("measuring");
            ui.add(bar).on_hover_text(format!(
                "takes at most {:.0} % of the time of a frame",
                SHARE * 100.0
            ));
        } else {
            let Study { simulated_s, bodies, .. } = study;
            let s = if *bodies == 1 { "y" } else { "ies" };
            let time = number(*simulated_s, 3);
            let words = format!("{bodies} bod{s}, {time} s from the start, on a copy");
            ui.add(Label::new(words).truncate());
        }
        (again, uses)
    })
    .inner
}

/// Lays out the error and the cost of the current setting, and the setting with a smaller error at the same cost. Returns that
/// setting, if there is one.
fn first(ui: &mut Ui, study: &Study, axes: Axes, present: Setting) -> Option<Setting> {
    let lines = ui.scope(|ui| {
        ui.set_min_height(HEAD);
        if study.is_flat(axes.accuracy) {
            ui.label(
                "More substeps do not reduce the error of most methods here; the details say why.",
            );
        }
        let mine = study.cells.iter().find(|cell| cell.setting == present);
        let Some((mine, error)) =
            mine.and_then(|mine| Some((mine, study.error(mine, axes.accuracy)?)))
        else {
            ui.weak(match mine.map(|mine| (mine.is_run(), &mine.outcome)) {
                Some((false, _)) => "Your setting is measured next.".to_owned(),
                Some((true, Outcome::Failed(why))) => format!("Your setting fails here: {why}."),
                Some((true, Outcome::Finished(_))) => "Your setting has no error.".to_owned(),
                None => "Your setting is not among those that are measured.".to_owned(),
            });
            return None;
        };
        let cost = study.cost(mine, axes.cost).map_or(String::new(), |cost| match axes.cost {
            Cost::RealTime => format!(", {} of real time", share(cost, 2)),
            Cost::Evaluations | Cost::Time | Cost::Arithmetic => {
                format!(", {} evaluations per body per s", digits(cost))
            }
        });
        let off = match axes.accuracy {
            Accuracy::Position => length(error, 2),
            Accuracy::Relative | Accuracy::Velocity => share(error, 2),
        };
        ui.strong(format!("Yours: up to {off} off within {} s{cost}.", digits(study.simulated_s)));
        let Some((cell, times)) = study.better_at_cost_of(mine, axes.accuracy, axes.cost) else {
            ui.weak("No measured setting is much more accurate at this cost.");
            return None;
        };
        ui.label(format!(
            "{}: {} times smaller error at the same cost.",
            title(cell.setting),
            fold(times)
        ));
        Some(cell.setting)
    });
    lines.inner
}

fn choose(ui: &mut Ui, axes: &mut Axes) {
    ui.horizontal(|ui| {
        ui.weak("error in");
        ui.radio_value(&mut axes.accuracy, Accuracy::Position, "m");
        ui.radio_value(&mut axes.accuracy, Accuracy::Relative, "parts of the motion");
    });
    ui.horizontal_wrapped(|ui| {
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
    let cells = study.curve(method).chain(study.chosen(method));
    cells.filter_map(|cell| Some(Dot { at: dot(cell)?, cell })).collect()
}

/// Smaller errors are drawn here: a logarithmic axis has no place for 0.
const LEAST: f64 = 1e-16;

/// Lays out the plot. Returns the setting whose dot was clicked.
fn plot(ui: &mut Ui, study: &Study, axes: Axes, present: Setting, width: f32) -> Option<Setting> {
    let all: Vec<_> =
        Method::ALL.into_iter().flat_map(|method| dots(study, axes, method)).collect();
    let decade =
        |mark: egui_plot::GridMark, _: &std::ops::RangeInclusive<f64>| match mark.value.fract() {
            #[expect(clippy::cast_possible_truncation, reason = "decades")]
            0.0 if !all.is_empty() => power_of_ten(mark.value as i32),
            _ => String::new(),
        };
    let decades = |input: egui_plot::GridInput| {
        let (from, to) = input.bounds;
        // Marks beyond the ends would be written outside of the plot.
        #[expect(clippy::cast_possible_truncation, reason = "decades")]
        let decades = from.ceil() as i32..=to.floor() as i32;
        decades
            .map(|decade| egui_plot::GridMark { value: f64::from(decade), step_size: 3.0 })
            .collect::<Vec<_>>()
    };
    let words = match axes.cost {
        // A page is not told the time of its thread.
        Cost::RealTime | Cost::Time | Cost::Arithmetic if IS_THREAD_TIME => {
            "CPU seconds per simulated second"
        }
        Cost::RealTime | Cost::Time | Cost::Arithmetic => "seconds per simulated second",
        Cost::Evaluations => "evaluations per body per simulated second",
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
        .x_axis_formatter(decade)
        .y_axis_formatter(decade)
        .show_grid(!all.is_empty())
        .x_grid_spacer(decades)
        .y_grid_spacer(decades)
        .label_formatter(|_| None);
    plot.show(ui, |ui| {
        draw(ui, study, axes, &all, present);
        let pointer = ui.response().hover_pos()?;
        let distance = |dot: &Dot<'_>| {
            ui.screen_from_plot(PlotPoint::new(dot.at[0], dot.at[1])).distance(pointer)
        };
        let near =
            all.iter().map(|dot| (distance(dot), dot)).filter(|(distance, _)| *distance < REACH);
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
        // Dashed where substeps are chosen.
        for (is_fixed, style) in [(true, LineStyle::Solid), (false, LineStyle::dashed_dense())] {
            let is_of = |dot: &&Dot<'_>| {
                let Setting { method: of, substeps } = dot.cell.setting;
                of == method && substeps.fixed().is_some() == is_fixed
            };
            let curve: Vec<_> = all.iter().filter(is_of).map(|dot| dot.at).collect();
            ui.line(
                Line::new("", PlotPoints::from(curve.clone()))
                    .color(color.gamma_multiply(0.5))
                    .style(style)
                    .allow_hover(false),
            );
            ui.points(
                Points::new("", PlotPoints::from(curve))
                    .color(color)
                    .radius(4.0)
                    .allow_hover(false),
            );
        }
    }
    if let Some(dot) = all.iter().find(|dot| dot.cell.setting == present) {
        let ring = PlotPoints::from(vec![dot.at]);
        ui.points(
            Points::new("", ring).color(emphasis).radius(8.0).filled(false).allow_hover(false),
        );
    }
    let top = all.iter().map(|dot| dot.at[1]).fold(f64::NEG_INFINITY, f64::max);
    let failed = study.cells.iter().filter(|cell| cell.is_run() && cell.errors().is_none());
    for cell in failed {
        if let (Some(cost), true) =
            (study.cost(cell, axes.cost).filter(|cost| *cost > 0.0), top.is_finite())
        {
            let mark = PlotPoints::from(vec![[cost.log10(), top + 0.7]]);
            let color = color_of(cell.setting.method);
            ui.points(
                Points::new("", mark)
                    .color(color)
                    .radius(5.0)
                    .shape(MarkerShape::Cross)
                    .allow_hover(false),
            );
        }
    }
}

fn hint(study: &Study, cell: &Cell, axes: Axes) -> String {
    let Setting { method, .. } = cell.setting;
    let rate = study.step_hz * study.steps(cell);
    let error = study.error(cell, axes.accuracy).unwrap_or(f64::NAN);
    let error =
        if axes.accuracy == Accuracy::Position { length(error, 3) } else { share(error, 3) };
    let evaluations = study.cost(cell, Cost::Evaluations).unwrap_or(f64::NAN);
    let mut words = format!(
        "{}: {rate:.0} steps per s\nerror {error}, {evaluations:.0} evaluations per s",
        title(cell.setting)
    );
    if let Some(errors) = cell.errors() {
        words += &format!("\nerror of positions: rms {}", length(errors.position_rms_m, 3));
    }
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
    Grid::new("cost legend").num_columns(COLUMNS).spacing([10.0, 1.0]).show(ui, |ui| {
        for (place, method) in Method::ALL.into_iter().enumerate() {
            let failed = study.cells.iter().any(|cell| {
                cell.setting.method == method && cell.is_run() && cell.errors().is_none()
            });
            ui.horizontal(|ui| {
                swatch(ui, inks::of_method(ui.visuals(), method));
                ui.label(ink(method).short);
                if failed {
                    let color = inks::words(ui.visuals(), FAILED);
                    ui.label(RichText::new("×").color(color))
                        .on_hover_text("some of its runs failed");
                }
            });
            if place % COLUMNS == COLUMNS - 1 {
                ui.end_row();
            }
        }
    });
}

/// Lays out the settings on the front as buttons, the cheapest first. Returns the chosen one. The keyboard reaches them as one
/// control, and arrows move through them: a recording counts the controls, and the number of settings depends on the machine.
fn front(ui: &mut Ui, study: &Study, axes: Axes, present: Setting) -> Option<Setting> {
    let front = study.front(axes.accuracy, axes.cost);
    let row = ui.horizontal_wrapped(|ui| {
        ui.label("on the front:");
        if front.is_empty() {
            return vec![ui.weak("nothing yet")];
        }
        front.iter().map(|cell| setting_button(ui, study, cell, axes, present)).collect()
    });
    let (buttons, id) = (row.inner, Id::unique("place on the front"));
    let place = ui.data(|data| data.get_temp(id)).unwrap_or(0).min(buttons.len() - 1);
    let list = ui.interact(buttons[place].rect, id, Sense::focusable_noninteractive());
    let name =
        front.get(place).map_or_else(|| "nothing yet".to_owned(), |cell| title(cell.setting));
    list.widget_info(|| WidgetInfo::labeled(Role::ListBox, true, format!("on the front: {name}")));
    let mut chosen = buttons.iter().position(Response::clicked);
    if list.has_focus() {
        let arrows =
            EventFilter { horizontal_arrows: true, vertical_arrows: true, ..Default::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, arrows));
        let pressed =
            |keys: [Key; 2]| ui.input(|input| keys.into_iter().any(|key| input.key_pressed(key)));
        let (back, on) =
            (pressed([Key::ArrowLeft, Key::ArrowUp]), pressed([Key::ArrowRight, Key::ArrowDown]));
        let next =
            (place + usize::from(on)).saturating_sub(usize::from(back)).min(buttons.len() - 1);
        if next != place {
            ui.data_mut(|data| data.insert_temp(id, next));
            buttons[next].scroll_to_me(None);
        }
        chosen = chosen.or(pressed([Key::Enter, Key::Space]).then_some(place));
    }
    front.get(chosen?).map(|cell| cell.setting)
}

/// The button of a setting, in the words of the legend.
fn setting_button(
    ui: &mut Ui,
    study: &Study,
    cell: &Cell,
    axes: Axes,
    present: Setting,
) -> Response {
    let words = format!("{} x {:#}", ink(cell.setting.method).short, cell.setting.substeps);
    let is_present = cell.setting == present;
    let button = ui.add(Button::selectable(is_present, words).small().sense(Sense::CLICK));
    let name = title(cell.setting);
    button.widget_info(|| WidgetInfo::selected(Role::Button, true, is_present, &name));
    button.on_hover_text(hint(study, cell, axes))
}

fn title(Setting { method, substeps, .. }: Setting) -> String {
    format!("{} x {substeps:#}", method.claims().title)
}

fn foot(ui: &mut Ui, study: &Study, width: f32) {
    egui::CollapsingHeader::new("Details").show(ui, |ui| {
        ui.set_max_width(width);
        for note in &study.notes {
            ui.label(note);
        }
        for sentence in report::time_words(study) {
            ui.weak(sentence);
        }
    });
}
