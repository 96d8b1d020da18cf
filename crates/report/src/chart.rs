//! A figure being drawn: a frame with axes, marks in it, and a legend beside it.
//!
//! Written here: plotters would bring 24 crates.

mod axis;
mod drawing;
mod grid;
mod marks;

use motion::Method;

pub(crate) use axis::{Axis, axes};
pub use drawing::Drawing;
pub(crate) use drawing::{Anchor, Box4, INK, Rgb, SOFT, Shape, Stroke, WIDTH};
pub(crate) use grid::{Cell, Grid, Row};
pub(crate) use marks::dark_rules;

/// Width of the legend at the right, pixels.
const LEGEND: f64 = 296.0;
/// Left margin of the frame, pixels.
const LEFT: f64 = 92.0;
/// Top margin of the frame, pixels.
const TOP: f64 = 46.0;
/// Bottom margin of the frame, pixels.
const BOTTOM: f64 = 60.0;
/// Estimated width of a letter of a label, pixels.
const LETTER: f64 = 6.3;
/// Height of a row of the legend, pixels.
const ROW: f64 = 23.0;

/// Step by which the words of a level move to a free place, pixels.
const LEVEL_STEP: f64 = 12.0;

const CROSS: &str = "M-4.5,-4.5L4.5,4.5M-4.5,4.5L4.5,-4.5";
const LINE: &str = "M-18,0H18";
const RED: Rgb = [0xb3, 0x26, 0x1e];
const BUDGET: Stroke = Stroke::new(RED, 1.6).dashed(&[6.0, 4.0]);
const FLOOR: Stroke = Stroke::new(SOFT, 1.2).dashed(&[3.0, 3.0]);
const RING: Stroke = Stroke::new(INK, 2.0);
const FRONT: Stroke = Stroke { opacity: 0.42, ..Stroke::new([0x9a, 0xa3, 0xad], 10.0) };

/// A figure being drawn.
pub(crate) struct Chart {
    title: String,
    x: Axis,
    y: Axis,
    height: u32,
    /// Shapes below the points.
    under: Vec<Shape>,
    over: Vec<Shape>,
    legend: Vec<Shape>,
    legend_rows: f64,
    taken: Vec<Box4>,
    /// Horizontal positions of failures: those at one cost are stacked.
    failures: Vec<f64>,
}

impl Chart {
    pub(crate) const fn new(title: String, x: Axis, y: Axis, height: u32) -> Self {
        Self {
            title,
            x,
            y,
            height,
            under: Vec::new(),
            over: Vec::new(),
            legend: Vec::new(),
            legend_rows: 0.0,
            taken: Vec::new(),
            failures: Vec::new(),
        }
    }

    /// The frame, pixels.
    fn frame(&self) -> Box4 {
        [LEFT, TOP, f64::from(WIDTH) - LEGEND, f64::from(self.height) - BOTTOM]
    }

    fn at(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let [left, top, right, bottom] = self.frame();
        (left + self.x.place(x) * (right - left), bottom - self.y.place(y) * (bottom - top))
    }

    /// The line of a curve, with those lengths of dashes and gaps.
    pub(crate) fn curve(&mut self, method: Method, dash: &'static [f64], points: &[(f64, f64)]) {
        let points: Vec<_> = points.iter().map(|point| self.at(*point)).collect();
        // Keeps names off the curve.
        for pair in points.windows(2) {
            let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
            for i in 0..8 {
                let part = f64::from(i) / 8.0;
                let (x, y) = (x0 + part * (x1 - x0), y0 + part * (y1 - y0));
                self.taken.push([x - 1.0, y - 1.0, x + 1.0, y + 1.0]);
            }
        }
        self.over.push(curve(Shape::line(points), method, dash));
    }

    /// A point of a curve, with words that show under the pointer.
    pub(crate) fn point(&mut self, method: Method, x: f64, y: f64, words: &str) {
        let (x, y) = self.at((x, y));
        self.taken.push([x - 7.0, y - 7.0, x + 7.0, y + 7.0]);
        self.over.push(mark(method, words).at(x, y));
    }

    /// A failed run: a cross at the top edge, at its cost.
    pub(crate) fn failure(&mut self, method: Method, x: f64, words: &str) {
        let (x, top) = self.at((x, f64::INFINITY));
        let above = self.failures.iter().filter(|other| (**other - x).abs() < 9.0).count();
        self.failures.push(x);
        let y = top + 9.0 + 12.0 * above as f64;
        self.taken.push([x - 6.0, y - 6.0, x + 6.0, y + 6.0]);
        let stroke = Stroke::new(marks::color(method, marks::LIGHT), 2.4);
        let class = format!("failed l-{}", method.name());
        self.over.push(Shape::path(CROSS).class(class).stroke(stroke).tip(words).at(x, y));
    }

    /// The front: thick and pale, under everything.
    pub(crate) fn front(&mut self, points: &[(f64, f64)]) {
        let points: Vec<_> = points.iter().map(|point| self.at(*point)).collect();
        self.under.push(Shape::line(points).class("front").stroke(FRONT));
    }

    /// A ring around a point.
    pub(crate) fn ring(&mut self, x: f64, y: f64, words: &str) {
        let (x, y) = self.at((x, y));
        self.over.push(circle(12.0).class("ring").stroke(RING).tip(words).at(x, y));
    }

    /// Adds a name beside a point, on a free side, if there is one: first toward the lower left, because no point
    /// lies below a front.
    pub(crate) fn name(&mut self, x: f64, y: f64, text: &str) {
        let (x, y) = self.at((x, y));
        let wide = width_of(text);
        let places = [
            (-wide - 9.0, 14.0),
            (-wide - 11.0, 4.0),
            (-wide - 5.0, 22.0),
            (-wide / 2.0, 24.0),
            (-wide - 11.0, -6.0),
            (10.0, -9.0),
            (11.0, 4.0),
            (10.0, 16.0),
        ];
        let box_at = |(dx, dy): (f64, f64)| [x + dx, y + dy - 10.0, x + dx + wide, y + dy + 3.0];
        let [left, top, right, bottom] = self.frame();
        let fits = |b: &Box4| b[0] > left && b[1] > top && b[2] < right && b[3] < bottom;
        let free = |b: &Box4| self.taken.iter().all(|taken| !overlap(taken, b));
        if let Some(place) = places.map(box_at).into_iter().find(|place| fits(place) && free(place))
        {
            self.over.push(Shape::words(text).class("ink name").at(place[0], place[3] - 3.0));
            self.taken.push(place);
        }
    }

    /// The budget: a vertical line with words along its top, drawn at the edge if it is beyond the axis.
    pub(crate) fn budget(&mut self, x: f64, words: &str) {
        let beyond = !self.x.holds(x);
        let (x, _) = self.at((x, 1.0));
        let words_of = Shape::words(words).class("budget-text").fill(RED);
        self.upright(if beyond { x - 1.5 } else { x }, "budget", BUDGET, words_of, width_of(words));
    }

    /// A vertical line with words along its top, such as the size of a cache; left out beyond the axis.
    pub(crate) fn limit(&mut self, x: f64, words: &str) {
        if self.x.holds(x) {
            let (x, _) = self.at((x, 1.0));
            self.upright(x, "floor", FLOOR, Shape::soft_words(words), width_of(words));
        }
    }

    fn upright(&mut self, x: f64, class: &str, stroke: Stroke, words: Shape, long: f64) {
        let [_, top, _, bottom] = self.frame();
        self.under.push(Shape::line([(x, top), (x, bottom)]).class(class).stroke(stroke));
        self.under.push(words.anchored(Anchor::End).upward().at(x - 6.0, top + 8.0));
        self.taken.push([x - 20.0, top, x + 2.0, top + 8.0 + long]);
    }

    /// A horizontal line with words above its right end, or its left one if `at_left`; if that place is taken, below
    /// the line or farther inside.
    pub(crate) fn level(&mut self, y: f64, words: &str, at_left: bool) {
        let [left, _, right, _] = self.frame();
        let (_, y) = self.at((1.0, y));
        let wide = width_of(words);
        let room = (right - left - 16.0 - wide).max(0.0);
        let steps = (0..=(room / LEVEL_STEP) as u32).map(|step| f64::from(step) * LEVEL_STEP);
        let places = steps.flat_map(|inside| {
            let from = if at_left { left + 8.0 + inside } else { right - 8.0 - wide - inside };
            [y - 18.0, y + 2.0].map(|top| [from, top, from + wide, top + 18.0])
        });
        let mut places = places.peekable();
        let first = places.peek().copied();
        let free = |place: &Box4| self.taken.iter().all(|taken| !overlap(taken, place));
        let Some(place) = places.find(free).or(first) else { return };
        self.under.push(Shape::line([(left, y), (right, y)]).class("floor").stroke(FLOOR));
        let (anchor, x) = if at_left { (Anchor::Start, place[0]) } else { (Anchor::End, place[2]) };
        self.under.push(Shape::soft_words(words).anchored(anchor).at(x, place[1] + 12.0));
        self.taken.push(place);
    }

    /// The next row of the legend: samples around their middle, and words.
    fn row(&mut self, samples: impl IntoIterator<Item = Shape>, words: Shape) {
        let (x, y) = (f64::from(WIDTH) - LEGEND + 44.0, TOP + 8.0 + ROW * self.legend_rows);
        self.legend_rows += 1.0;
        self.legend.extend(samples.into_iter().map(|sample| sample.at(x, y)));
        self.legend.push(words.at(x + 27.0, y + 4.5));
    }

    /// A curve of a method, in the legend.
    pub(crate) fn legend_method(&mut self, method: Method, words: &str) {
        let line = curve(Shape::path(LINE), method, &[]);
        self.row([line, mark(method, words)], Shape::words(words));
    }

    /// Empty row.
    pub(crate) const fn legend_gap(&mut self) {
        self.legend_rows += 1.0;
    }

    /// The front, in the legend.
    pub(crate) fn legend_front(&mut self, words: &str) {
        self.row([Shape::path(LINE).class("front").stroke(FRONT)], Shape::words(words));
    }

    /// The ring, in the legend.
    pub(crate) fn legend_ring(&mut self, words: &str) {
        self.row([circle(10.0).class("ring").stroke(RING)], Shape::words(words));
    }

    /// The budget, in the legend.
    pub(crate) fn legend_budget(&mut self, words: &str) {
        self.row([Shape::path("M0,-9V9").class("budget").stroke(BUDGET)], Shape::words(words));
    }

    /// Failures, in the legend.
    pub(crate) fn legend_failure(&mut self, words: &str) {
        self.row(
            [Shape::path(CROSS).class("dash").stroke(Stroke::new(SOFT, 2.4))],
            Shape::words(words),
        );
    }

    /// More about the row before, in the legend, or a remark.
    pub(crate) fn legend_note(&mut self, words: &str) {
        self.row([], Shape::soft_words(words));
    }

    /// The figure.
    pub(crate) fn finish(self) -> Drawing {
        let frame = self.frame();
        let [left, top, right, bottom] = frame;
        let (across, down) = (0.5 * (left + right), 0.5 * (top + bottom));
        let middle = |words: &str| Shape::words(words).anchored(Anchor::Middle);
        let mut shapes = vec![
            Shape::words(&self.title).sized(17.0).at(left, top - 18.0),
            middle(&self.x.title).at(across, bottom + 46.0),
            middle(&self.y.title).upward().at(20.0, down),
        ];
        shapes.extend(axes(&self.x, &self.y, frame));
        shapes.extend([self.under, self.over, self.legend].into_iter().flatten());
        Drawing { title: self.title, height: self.height, shapes }
    }
}

fn overlap(a: &Box4, b: &Box4) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

fn width_of(text: &str) -> f64 {
    LETTER * text.chars().count() as f64
}

fn circle(radius: f64) -> Shape {
    Shape::path(format!(
        "M{radius},0A{radius},{radius} 0 1 1 -{radius},0A{radius},{radius} 0 1 1 {radius},0Z"
    ))
}

fn curve(line: Shape, method: Method, dash: &'static [f64]) -> Shape {
    let stroke = Stroke::new(marks::color(method, marks::LIGHT), 1.9).dashed(dash);
    line.class(format!("l-{}", method.name())).stroke(stroke)
}

fn mark(method: Method, words: &str) -> Shape {
    let class = format!("mark p-{}", method.name());
    let edge = Stroke::new(marks::LIGHT, 0.8);
    let color = marks::color(method, marks::LIGHT);
    Shape::path(marks::shape(method)).class(class).fill(color).stroke(edge).tip(words)
}
