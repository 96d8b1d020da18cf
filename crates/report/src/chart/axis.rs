//! An axis of a figure: its range, and the positions and labels of its marks.

use super::drawing::{Anchor, Box4, Rgb, Shape, Stroke};

const GRID: Rgb = [0xdd, 0xe1, 0xe6];
const FAINT: Rgb = [0xf1, 0xf3, 0xf5];
const EDGE: Rgb = [0x8c, 0x95, 0x9f];

/// A range with marks.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    logarithmic: bool,
    /// Marks with labels.
    labelled: Vec<(f64, String)>,
    /// Grid lines without labels.
    light: Vec<f64>,
    /// What it shows, with its unit.
    pub title: String,
}

impl Axis {
    /// A logarithmic axis, a little wider than the positive ones of `values`, with a decade around a single value and
    /// a default range if there is none. `label` formats a mark.
    pub(crate) fn logarithmic(
        title: impl Into<String>,
        values: impl Iterator<Item = f64>,
        label: impl Fn(f64) -> String,
    ) -> Self {
        let (low, high) = values
            .filter(|value| value.is_finite() && *value > 0.0)
            .fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), value| {
                (low.min(value), high.max(value))
            });
        let (low, high) = if high > 0.0 { (low.log10(), high.log10()) } else { (-16.0, 0.0) };
        let room = (0.04 * (high - low)).max(if high - low < 0.5 { 0.3 } else { 0.08 });
        Self::between(title, (10f64.powf(low - room), 10f64.powf(high + room)), label)
    }

    /// A logarithmic axis between two positive ends.
    pub(crate) fn between(
        title: impl Into<String>,
        (low, high): (f64, f64),
        label: impl Fn(f64) -> String,
    ) -> Self {
        let (labelled, light) = (Vec::new(), Vec::new());
        let mut axis = Self { low, high, logarithmic: true, labelled, light, title: title.into() };
        axis.mark(low.log10(), high.log10(), label);
        axis
    }

    /// Adds marks at powers of ten, and between them if there are few.
    fn mark(&mut self, low: f64, high: f64, label: impl Fn(f64) -> String) {
        let (first, last) = (low.floor() as i32, high.ceil() as i32);
        let every = ((last - first) / 9 + 1).max(1);
        let between: &[f64] = if high - low < 1.2 {
            &[2.0, 3.0, 5.0]
        } else if high - low < 2.5 {
            &[3.0]
        } else {
            &[]
        };
        for exponent in first..=last {
            // Parsed, not computed by `powi`: 10^-5 has to be the number that is written 1e-5.
            let decade: f64 = format!("1e{exponent}").parse().unwrap_or(f64::NAN);
            if exponent.rem_euclid(every) == 0 {
                self.labelled.push((decade, label(decade)));
                self.labelled
                    .extend(between.iter().map(|times| (times * decade, label(times * decade))));
            } else {
                self.light.push(decade);
            }
            if last - first < 8 {
                self.light.extend((2..10).map(|times| f64::from(times) * decade));
            }
        }
        let (low, high) = (self.low * (1.0 - 1e-9), self.high * (1.0 + 1e-9));
        self.labelled.retain(|(value, _)| (low..=high).contains(value));
        self.light.retain(|value| (low..=high).contains(value));
    }

    /// A linear axis from 0 to `high`.
    pub(crate) fn linear(
        title: impl Into<String>,
        high: f64,
        label: impl Fn(f64) -> String,
    ) -> Self {
        let high = if high.is_finite() && high > 0.0 { high } else { 1.0 };
        let decade = 10f64.powf((high / 4.0).log10().floor());
        let step = [1.0, 2.0, 2.5, 5.0, 10.0]
            .map(|times| times * decade)
            .into_iter()
            .find(|step| high / step <= 8.0);
        let step = step.unwrap_or(high);
        let marks =
            (0..=8).map(|i| f64::from(i) * step).filter(|mark| *mark <= high * (1.0 + 1e-9));
        Self {
            low: 0.0,
            high,
            logarithmic: false,
            labelled: marks.map(|mark| (mark, label(mark))).collect(),
            light: Vec::new(),
            title: title.into(),
        }
    }

    /// The same axis with a part of its length added at the high end.
    pub(crate) fn with_room(mut self, part: f64) -> Self {
        self.high *= (self.high / self.low).powf(part);
        self
    }

    /// The position of a value, 0 at the low end and 1 at the high one; values outside are moved to the end.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let at = if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        if at.is_nan() { 0.0 } else { at.clamp(0.0, 1.0) }
    }

    /// Whether a value is within the range.
    pub(crate) fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// Grid, edges and marks of two axes at the left and the foot of a frame.
pub(crate) fn axes(x: &Axis, y: &Axis, [left, top, right, bottom]: Box4) -> Vec<Shape> {
    let across = |value: f64| left + x.place(value) * (right - left);
    let up = |value: f64| bottom - y.place(value) * (bottom - top);
    let upright = |value: f64| Shape::line([(across(value), top), (across(value), bottom)]);
    let level = |value: f64| Shape::line([(left, up(value)), (right, up(value))]);
    let faint = |line: Shape| line.class("faint").stroke(Stroke::new(FAINT, 1.0));
    let grid = |line: Shape| line.class("grid").stroke(Stroke::new(GRID, 1.0));
    let mut shapes: Vec<_> = x.light.iter().map(|value| faint(upright(*value))).collect();
    shapes.extend(y.light.iter().map(|value| faint(level(*value))));
    shapes.extend(x.labelled.iter().map(|(value, _)| grid(upright(*value))));
    shapes.extend(y.labelled.iter().map(|(value, _)| grid(level(*value))));
    let corner = Shape::line([(left, top), (left, bottom), (right, bottom)]);
    shapes.push(corner.class("edge").stroke(Stroke::new(EDGE, 1.0)));
    for (value, label) in &x.labelled {
        shapes.push(
            Shape::soft_words(label).anchored(Anchor::Middle).at(across(*value), bottom + 19.0),
        );
    }
    for (value, label) in &y.labelled {
        shapes
            .push(Shape::soft_words(label).anchored(Anchor::End).at(left - 8.0, up(*value) + 4.5));
    }
    shapes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::number;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.labelled.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn marks_stand_at_powers_of_ten() {
        let axis = Axis::logarithmic("error", [1e-3, 1.0].into_iter(), |value| number(value, 1));
        assert_eq!(labels(&axis), ["0.001", "0.01", "0.1", "1"]);
        assert!(axis.place(1e-3) > 0.0 && axis.place(1.0) < 1.0);
        let middle = axis.place(10f64.powf(-1.5));
        assert!((middle - 0.5).abs() < 1e-12, "{middle}");
        assert_eq!((axis.place(0.0), axis.place(1e9), axis.place(f64::NAN)), (0.0, 1.0, 0.0));
    }

    #[test]
    fn there_is_an_axis_for_one_value_and_for_none() {
        let one = Axis::logarithmic("error", [4.0].into_iter(), |value| number(value, 1));
        assert_eq!(labels(&one), ["3", "5"]);
        let none =
            Axis::logarithmic("error", [0.0, f64::NAN].into_iter(), |value| number(value, 1));
        assert!(none.holds(1e-8) && !labels(&none).is_empty());
        assert_eq!(
            labels(&Axis::linear("t", 10.0, |value| number(value, 2))),
            ["0", "2", "4", "6", "8", "10"]
        );
        assert_eq!(labels(&Axis::linear("t", 0.0, |value| number(value, 2))).len(), 6);
    }
}
