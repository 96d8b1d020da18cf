//! Plots of quantities over the last seconds.

use egui::{Color32, Rangef, Ui};
use egui_plot::{AxisHints, GridInput, GridMark, Legend, Line, Plot};
use report::numbers::{digits, four_digits, time_unit};

use crate::view::inks;

/// Largest value in a plot: larger ones and ones that are not finite would make its margins infinite.
const LARGEST_DRAWN: f64 = 1e200;

/// A quantity over time.
pub(crate) struct Curve {
    /// Its name, with the unit.
    pub name: String,
    pub color: Color32,
    /// Width of its line, points.
    pub width: f32,
    /// Times, s, and values.
    pub points: Vec<[f64; 2]>,
}

/// Lays out a plot, and the names if it has a legend. The pointer reads values; it does not drag or zoom, because the
/// plot scrolls by itself.
pub(crate) fn show(
    ui: &mut Ui,
    id: &'static str,
    height: f32,
    legend: Option<Legend>,
    curves: &[Curve],
) {
    let can_be_drawn = |point: &[f64; 2]| point.iter().all(|value| value.abs() <= LARGEST_DRAWN);
    let drawn =
        |curve: &Curve| curve.points.iter().copied().filter(can_be_drawn).collect::<Vec<_>>();
    let curves: Vec<_> = curves.iter().map(|curve| (curve, drawn(curve))).collect();
    // egui_plot fades numbers that are close to each other until they cannot be read.
    let plot = Plot::new(id)
        .custom_x_axes(vec![AxisHints::new_x().label_spacing(Rangef::new(50.0, 51.0))])
        .custom_y_axes(vec![AxisHints::new_y().label_spacing(Rangef::new(12.0, 13.0))])
        .height(height)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .y_axis_min_width(56.0)
        .x_grid_spacer(|input: GridInput| time_marks(input.bounds))
        .x_axis_formatter(|mark, shown| time_mark(mark.value, *shown.end()))
        .y_grid_spacer(|input: GridInput| marks(input.bounds))
        .y_axis_formatter(|mark, _| four_digits(mark.value));
    let plot = legend.into_iter().fold(plot, Plot::legend);
    // Bounds for each curve by itself, because a click on its name hides a curve.
    let plot = curves.iter().fold(plot, |plot, (_, points)| {
        let [times, values] = [0, 1].map(|axis| widened(points.iter().map(|point| point[axis])));
        let plot = times.into_iter().flatten().fold(plot, Plot::include_x);
        values.into_iter().flatten().fold(plot, Plot::include_y)
    });
    // Without these, a plot before the first tick is days wide.
    let all = || curves.iter().flat_map(|(_, points)| points);
    let plot =
        if all().all(|[time, _]| *time <= 0.0) { plot.include_x(0.0).include_x(1.0) } else { plot };
    let is_zero = all().all(|[_, value]| *value == 0.0);
    let plot = if is_zero { plot.include_y(-1.0).include_y(1.0) } else { plot };
    let visuals = ui.visuals().clone();
    plot.show(ui, |plot| {
        for (curve, points) in curves {
            let line = Line::new(&curve.name, points).width(curve.width);
            plot.line(line.color(inks::marks(&visuals, curve.color)));
        }
    });
}

/// Two ends a little beyond all values, if these are nearly equal: the margin of a plot around a single large number
/// is lost to rounding.
fn widened(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let margin = 1e-6 * low.abs().max(high.abs());
    (high - low < margin).then_some([low - margin, high + margin])
}

/// Round times between two bounds, in the unit in which the later one is read.
fn time_marks((low, high): (f64, f64)) -> Vec<GridMark> {
    let (_, seconds) = time_unit(high);
    let scaled = |mark: GridMark| GridMark {
        value: mark.value * seconds,
        step_size: mark.step_size * seconds,
    };
    marks((low / seconds, high / seconds)).into_iter().map(scaled).collect()
}

/// A time at an axis that is shown up to `latest`, s; in seconds it needs no unit.
fn time_mark(time: f64, latest: f64) -> String {
    match time_unit(latest) {
        ("s", _) => digits(time),
        (unit, seconds) => format!("{} {unit}", digits(time / seconds)),
    }
}

/// Two to five round values between two bounds: a low plot has no room for more. None if the bounds are equal or not finite.
fn marks((low, high): (f64, f64)) -> Vec<GridMark> {
    let least = (high - low) / 4.0;
    if !(least > 0.0 && least.is_finite()) {
        return Vec::new();
    }
    let ten = 10.0_f64.powf(least.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].map(|factor| factor * ten).into_iter().find(|step| *step >= least);
    let step_size = step.unwrap_or(10.0 * ten);
    let first = (low / step_size).ceil() * step_size;
    let mark = |number: u8| GridMark { value: first + f64::from(number) * step_size, step_size };
    (0..5).map(mark).filter(|mark| mark.value <= high).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_and_few() {
        let values =
            |low, high| marks((low, high)).into_iter().map(|mark| mark.value).collect::<Vec<_>>();
        assert_eq!(values(-2.0, 48.0), [0.0, 20.0, 40.0]);
        assert_eq!(values(-11.0, 0.5), [-10.0, -5.0, 0.0]);
        assert!(values(3.0, 3.0).is_empty());
        for exponent in -9..9 {
            for size in [1.0, 1.7, 3.0, 4.4, 7.0, 9.9] {
                let high = size * 10.0_f64.powi(exponent);
                assert!((2..=5).contains(&values(-0.3 * high, high).len()), "{high}");
            }
        }
    }
}
