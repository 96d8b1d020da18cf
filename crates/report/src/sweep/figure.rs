//! The figure of a sweep: a line over one axis of numbers, a field of colors over more axes.

use lab::sweep::Plan;
use lab::{Kind, Value};
use motion::Method;

use crate::chart::{Anchor, Axis, Cell, Drawing, Grid, Rgb, Row, Shape, Stroke, WIDTH, axes};
use crate::numbers::{NONE, digits, number};
use crate::palette::ink;

/// Most columns of colors that are drawn; a sweep may have more.
const MOST_COLUMNS: usize = 120;
/// Most rows of colors that are drawn; a sweep may have more.
const MOST_ROWS: usize = 60;

/// A measure whose values span more than this is shown in logarithms.
const WIDE: f64 = 50.0;

/// Colors from dark to light, which also people who do not see colors can read: stops of viridis (van der Walt and
/// Smith 2015).
const SCALE: [Rgb; 6] = [
    [0x44, 0x01, 0x54],
    [0x41, 0x44, 0x87],
    [0x2a, 0x78, 0x8e],
    [0x22, 0xa8, 0x84],
    [0x7a, 0xd1, 0x51],
    [0xfd, 0xe7, 0x25],
];

const YES: Rgb = [0x7c, 0xc4, 0xa0];
const NO: Rgb = [0xe0, 0x89, 0x7b];
const ABSENT: Rgb = [0xc8, 0xcc, 0xd2];

/// The figure of the first measure of a sweep. Runs are added one by one, in memory that does not grow with their
/// number.
pub struct Figure {
    title: String,
    plan: Plan,
    /// Index of the measure among the columns.
    column: usize,
    name: String,
    kind: Kind,
    /// Index of the axis that goes to the right: the longest of numbers or, without numbers, of all.
    across: usize,
    wide: usize,
    high: usize,
    cells: Vec<Value>,
}

impl Figure {
    /// A figure without runs, for a sweep of the scene named `scene`.
    pub fn new(scene: &str, plan: &Plan) -> Self {
        let columns = plan.columns();
        let (name, kind) =
            plan.measures.first().map_or(("", Kind::Text), |measure| measure.columns()[0]);
        let column = columns.iter().position(|column| column.name == name).unwrap_or(columns.len());
        let rank = |at: &usize| (plan.axes[*at].numbers().is_some(), plan.axes[*at].values.len());
        let across = (0..plan.axes.len()).max_by_key(rank).unwrap_or_default();
        let wide = plan.axes.get(across).map_or(1, |axis| axis.values.len());
        let rows = plan.runs().unwrap_or(u64::MAX) / wide.max(1) as u64;
        let (wide, high) = (wide.min(MOST_COLUMNS), rows.min(MOST_ROWS as u64) as usize);
        Self {
            title: format!("{scene}: {name}, runs of {} s", number(plan.seconds, 6)),
            plan: plan.clone(),
            column,
            name: name.to_owned(),
            kind,
            across,
            wide,
            high,
            cells: vec![Value::Absent; wide * high],
        }
    }

    /// Adds run number `run` with its row of the table.
    pub fn add(&mut self, run: u64, row: &[Value]) {
        let indices = self.plan.indices(run);
        let column = indices.get(self.across).copied().unwrap_or_default();
        let below =
            indices.iter().zip(&self.plan.axes).enumerate().filter(|(at, _)| *at != self.across);
        let row_of = below
            .fold(0_usize, |row, (_, (index, axis))| row.saturating_mul(axis.values.len()) + index);
        if column < self.wide
            && row_of < self.high
            && let Some(value) = row.get(self.column)
        {
            self.cells[row_of * self.wide + column] = value.clone();
        }
    }

    /// The figure.
    pub fn drawing(&self) -> Drawing {
        self.line().unwrap_or_else(|| self.field())
    }

    /// Values that can be shown as numbers.
    fn numbers(&self) -> impl Iterator<Item = f64> {
        self.cells.iter().filter_map(shown)
    }

    /// The smallest number above 0 and the largest, and whether they are shown in logarithms.
    fn span(&self) -> (f64, f64, bool) {
        let low = self.numbers().filter(|number| *number > 0.0).fold(f64::INFINITY, f64::min);
        let high = self.numbers().fold(0.0, f64::max);
        (low, high, high > WIDE * low)
    }

    /// A line over one axis of numbers; `None` for other sweeps.
    fn line(&self) -> Option<Drawing> {
        let [axis] = &self.plan.axes[..] else { return None };
        let xs = axis.numbers()?;
        let is_number = matches!(self.kind, Kind::Number | Kind::Count);
        if !is_number
            || self.numbers().next().is_none()
            || xs.iter().any(|x| *x < 0.0)
            || xs.len() < 3
        {
            return None;
        }
        let chosen = |title: &str, (low, high): (f64, f64), values: Vec<f64>| {
            if low > 0.0 && high > WIDE * low {
                Axis::logarithmic(title, values.into_iter(), |mark| number(mark, 3))
            } else {
                Axis::linear(title, high, |mark| number(mark, 3))
            }
        };
        let [least, most] =
            [f64::min, f64::max].map(|pick| xs.iter().copied().reduce(pick).unwrap_or_default());
        let (low, high, _) = self.span();
        let x = chosen(&axis.place, (least, most), xs.clone());
        let y = chosen(&self.name, (low, high), self.numbers().collect());
        let frame = [110.0, 60.0, f64::from(WIDTH) - 40.0, 520.0];
        let [left, top, right, bottom] = frame;
        let mut points: Vec<(f64, f64, String)> = xs
            .iter()
            .zip(&self.cells)
            .zip(&axis.values)
            .filter_map(|((at, cell), value)| {
                let shown = shown(cell)?;
                let place = (
                    left + x.place(*at) * (right - left),
                    bottom - y.place(shown) * (bottom - top),
                );
                Some((place.0, place.1, format!("{}={value}: {}", axis.place, digits(shown))))
            })
            .collect();
        points.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let color = ink(Method::VelocityVerlet).srgb;
        let middle = |words: &str| Shape::words(words).anchored(Anchor::Middle);
        let mut shapes = vec![
            Shape::words(&self.title).sized(17.0).at(left, top - 22.0),
            middle(&x.title).at(0.5 * (left + right), bottom + 46.0),
            middle(&y.title).upward().at(24.0, 0.5 * (top + bottom)),
        ];
        shapes.extend(axes(&x, &y, frame));
        shapes.push(
            Shape::line(points.iter().map(|(x, y, _)| (*x, *y))).stroke(Stroke::new(color, 1.8)),
        );
        shapes.extend(points.iter().map(|(x, y, words)| {
            Shape::rectangles([[-3.0, -3.0, 6.0, 6.0]]).fill(color).at(*x, *y).tip(words)
        }));
        shapes.extend(self.left_out().map(|note| Shape::soft_words(note).at(left, 584.0)));
        Some(Drawing { title: self.title.clone(), height: 590, shapes })
    }

    /// A field of colors: the longest axis to the right, every combination of the others below one another.
    fn field(&self) -> Drawing {
        let (low, high, logarithmic) = self.span();
        let across = self.plan.axes.get(self.across);
        let cell = |row: &str, column: usize, value: &Value| {
            let color = match value {
                Value::Flag(true) => YES,
                Value::Flag(false) => NO,
                other @ (Value::Number(_) | Value::Count(_) | Value::Text(_) | Value::Absent) => {
                    shown(other)
                        .map_or(ABSENT, |number| scale(part(number, low, high, logarithmic)))
                }
            };
            let shown = match value {
                Value::Number(number) => digits(*number),
                Value::Absent => NONE.to_owned(),
                other @ (Value::Count(_) | Value::Flag(_) | Value::Text(_)) => other.to_string(),
            };
            let at = across.map(|axis| format!("{}={}, ", axis.place, axis.values[column]));
            let tip = format!("{}{row}: {shown}", at.unwrap_or_default());
            Some(Cell { color, tip, words: None })
        };
        let rows = self.cells.chunks(self.wide.max(1)).enumerate().map(|(row, cells)| {
            let name = self.row_name(row);
            let cells = cells.iter().enumerate().map(|(column, value)| cell(&name, column, value));
            Row { cells: cells.collect(), name, is_apart: false }
        });
        let value = |value: &String| value.parse().map_or_else(|_| value.clone(), digits);
        let columns = across.map_or_else(Default::default, |axis| {
            (axis.place.clone(), axis.values.iter().take(self.wide).map(value).collect())
        });
        Grid {
            title: self.title.clone(),
            legend: self.legend(low, high, logarithmic),
            columns,
            rows: rows.collect(),
            note: self.left_out(),
        }
        .drawing()
    }

    fn legend(&self, low: f64, high: f64, logarithmic: bool) -> Vec<Shape> {
        let absent = if self.kind == Kind::Text { "not a number" } else { "nothing measured" };
        let mut shapes = Vec::from(Grid::legend_entry(16.0, ABSENT, absent));
        match self.kind {
            Kind::Flag => {
                shapes.extend(Grid::legend_entry(186.0, YES, "true"));
                shapes.extend(Grid::legend_entry(276.0, NO, "false"));
            }
            Kind::Number | Kind::Count if low.is_finite() => {
                let (x, least) = (400.0, if logarithmic { low } else { 0.0 });
                shapes.push(Grid::legend_words(x - 8.0, &digits(least)).anchored(Anchor::End));
                shapes.extend(Grid::legend_scale(x, scale));
                let note = if logarithmic { " (logarithmic)" } else { "" };
                shapes.push(Grid::legend_words(x + 264.0, &format!("{}{note}", digits(high))));
            }
            Kind::Number | Kind::Count | Kind::Text => {}
        }
        shapes
    }

    /// The values of the vertical axes in row `row`.
    fn row_name(&self, mut row: usize) -> String {
        let mut words = Vec::new();
        for (at, axis) in self.plan.axes.iter().enumerate().rev() {
            if at != self.across {
                words.push(format!("{}={}", axis.place, axis.values[row % axis.values.len()]));
                row /= axis.values.len();
            }
        }
        words.reverse();
        words.join(", ")
    }

    /// A note on what is not drawn, if anything is not.
    fn left_out(&self) -> Option<String> {
        let columns = self.plan.axes.get(self.across).map_or(1, |axis| axis.values.len());
        let rows = self.plan.runs().unwrap_or(u64::MAX) / columns as u64;
        let more = columns > self.wide || rows > self.high as u64;
        more.then(|| {
            format!(
                "the first {} of {columns} columns and {} of {rows} rows; the table has all",
                self.wide, self.high
            )
        })
    }
}

/// The number that a cell shows; `None` if it shows none.
fn shown(cell: &Value) -> Option<f64> {
    match cell {
        Value::Number(number) => Some(*number).filter(|number| number.is_finite()),
        Value::Count(count) => Some(*count as f64),
        Value::Flag(_) | Value::Text(_) | Value::Absent => None,
    }
}

/// The position of a number on the scale, 0 to 1.
fn part(number: f64, low: f64, high: f64, logarithmic: bool) -> f64 {
    let part = if logarithmic { (number / low).ln() / (high / low).ln() } else { number / high };
    if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) }
}

/// The color at a position on the scale.
fn scale(part: f64) -> Rgb {
    let at = part * (SCALE.len() - 1) as f64;
    let stop = (at as usize).min(SCALE.len() - 2);
    let between = at - stop as f64;
    std::array::from_fn(|channel| {
        let [from, to] = [stop, stop + 1].map(|stop| f64::from(SCALE[stop][channel]));
        (from + (to - from) * between).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::plan;
    use super::*;

    fn drawn(plan: &Plan, value: impl Fn(u64) -> Value) -> String {
        let mut figure = Figure::new("oscillator", plan);
        for run in 0..plan.runs().unwrap() {
            let mut row = vec![Value::Absent; plan.axes.len() + 4];
            row.push(value(run));
            figure.add(run, &row);
        }
        figure.drawing().document()
    }

    #[test]
    fn two_axes_are_a_field_with_every_run_in_its_place() {
        let svg = drawn(&plan(), |run| Value::Flag(run == 3));
        assert!(svg.contains("springs[0].stiffness_n_m=10, method=runge_kutta_4: true"), "{svg}");
        assert_eq!(svg.matches(": false</title>").count(), 5);
        assert_eq!(svg.matches("fill=\"#7cc4a0\"").count(), 2);
    }

    #[test]
    fn one_axis_of_numbers_is_a_line() {
        let plan = Plan {
            axes: plan().axes[..1].to_vec(),
            measures: vec![lab::sweep::Measure::Drift],
            ..plan()
        };
        let svg = drawn(&plan, |run| Value::Number(run as f64));
        assert!(svg.contains("springs[0].stiffness_n_m=100: 2<"), "{svg}");
        let svg = drawn(&plan, |_| Value::Absent);
        assert!(svg.contains("nothing measured"));
    }

    #[test]
    fn every_figure_of_every_measure_has_a_mark_for_each_value_that_can_be_shown() {
        let numbers = "springs[0].stiffness_n_m=1,10,100,1000";
        let [offsets, methods] = ["a=-1,0,1,2", "method=explicit_euler,runge_kutta_4"];
        let all: [&[&str]; 5] = [&[numbers], &[offsets], &[methods], &[numbers, methods], &[]];
        for (measure, axes) in
            lab::sweep::Measure::ALL.iter().flat_map(|m| all.map(|axes| (*m, axes)))
        {
            let axes = axes.iter().map(|text| lab::sweep::Axis::parse(text).unwrap()).collect();
            let plan = Plan { axes, measures: vec![measure], ..plan() };
            let kind = measure.columns()[0].1;
            for scale in [0, 1, 1000] {
                let value = |run: u64| match kind {
                    _ if run == 2 => Value::Absent,
                    Kind::Number if run == 3 => Value::Number(f64::NAN),
                    Kind::Number => Value::Number((run * scale) as f64),
                    Kind::Count => Value::Count(run * scale),
                    Kind::Flag => Value::Flag(run == 0),
                    Kind::Text => Value::Text(run.to_string()),
                };
                let svg = drawn(&plan, value);
                let cells = svg.matches("</title>").count();
                // One of a field is in its legend.
                let grey = svg.matches("fill=\"#c8ccd2\"").count().saturating_sub(1);
                let runs = (0..plan.runs().unwrap()).map(value);
                let shown =
                    runs.filter(|value| shown(value).is_some() || matches!(value, Value::Flag(_)));
                assert_eq!(cells - grey, shown.count(), "{} {:?}", measure.name(), plan.axes);
            }
        }
        let plan = Plan {
            axes: vec![lab::sweep::Axis::parse("a=0..199 lin 200").unwrap()],
            measures: vec![lab::sweep::Measure::Drift],
            ..plan()
        };
        assert!(drawn(&plan, |_| Value::Number(1.0)).contains("the first 120 of 200 columns"));
    }

    #[test]
    fn the_scale_ends_where_its_stops_do() {
        assert_eq!([0.0, 1.0].map(scale), [SCALE[0], SCALE[5]]);
        assert_eq!(part(10.0, 1.0, 100.0, true), 0.5);
        assert_eq!(part(25.0, 1.0, 100.0, false), 0.25);
        assert_eq!(part(0.0, 1.0, 100.0, true), 0.0);
    }
}
