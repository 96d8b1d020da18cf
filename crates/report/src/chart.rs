//! A figure being drawn: a frame with axes, marks in it, and a legend beside it.
//!
//! The frame is drawn by plotters. Marks are written here: they have fractions of a pixel, dashes, and words that
//! show under the pointer, and carry classes by which a page changes their colors.

mod drawing;
mod legend;

use std::fmt::Write;

use motion::Method;

pub(crate) use drawing::Drawing;
use drawing::axes;

use super::axis::Axis;
use super::marks;
use lab::cost::Precision;

/// Width of every figure, pixels.
pub(crate) const WIDTH: u32 = 1100;
/// Room of the legend at the right.
const LEGEND: u32 = 296;
const LEFT: u32 = 92;
const TOP: u32 = 46;
const BOTTOM: u32 = 60;
/// Estimated width of a letter of a label, pixels.
const LETTER: f64 = 6.3;

/// Text as it may stand between tags and in attributes.
pub(crate) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // No XML document may hold these.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// A box on the picture, pixels: left, top, right, bottom.
type Box4 = [f64; 4];

/// A figure being drawn.
pub(crate) struct Chart {
    title: String,
    x: Axis,
    y: Axis,
    height: u32,
    /// Under the points.
    under: String,
    over: String,
    legend: String,
    legend_rows: u32,
    taken: Vec<Box4>,
    /// Horizontal places of failures, to pile up those of one cost.
    failures: Vec<f64>,
}

impl Chart {
    pub(crate) const fn new(title: String, x: Axis, y: Axis, height: u32) -> Self {
        Self {
            title,
            x,
            y,
            height,
            under: String::new(),
            over: String::new(),
            legend: String::new(),
            legend_rows: 0,
            taken: Vec::new(),
            failures: Vec::new(),
        }
    }

    /// The frame, pixels.
    fn frame(&self) -> Box4 {
        [LEFT, TOP, WIDTH - LEGEND, self.height - BOTTOM].map(f64::from)
    }

    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let [left, top, right, bottom] = self.frame();
        (left + self.x.place(x) * (right - left), bottom - self.y.place(y) * (bottom - top))
    }

    fn points(&self, points: &[(f64, f64)]) -> String {
        let mut text = String::new();
        for (x, y) in points {
            let (x, y) = self.at(*x, *y);
            // Writing to a string cannot fail.
            let _ = write!(text, "{x:.1},{y:.1} ");
        }
        text.trim_end().to_owned()
    }

    /// The line of a curve.
    pub(crate) fn curve(&mut self, method: Method, precision: Precision, points: &[(f64, f64)]) {
        self.take(points);
        let (points, style) = (self.points(points), stroke(method, precision));
        self.over += &format!("<polyline fill=\"none\" {style} points=\"{points}\"/>\n");
    }

    /// Keeps names off a line.
    fn take(&mut self, points: &[(f64, f64)]) {
        for pair in points.windows(2) {
            let [(x0, y0), (x1, y1)] = [self.at(pair[0].0, pair[0].1), self.at(pair[1].0, pair[1].1)];
            for i in 0..8 {
                let part = f64::from(i) / 8.0;
                let (x, y) = (x0 + part * (x1 - x0), y0 + part * (y1 - y0));
                self.taken.push([x - 1.0, y - 1.0, x + 1.0, y + 1.0]);
            }
        }
    }

    /// A point of a curve, with words that show under the pointer.
    pub(crate) fn point(&mut self, method: Method, x: f64, y: f64, words: &str) {
        let (x, y) = self.at(x, y);
        self.taken.push([x - 7.0, y - 7.0, x + 7.0, y + 7.0]);
        self.over += &format!("{}\n", mark(method, x, y, words));
    }

    /// A failed run: a cross at the top edge, at its cost.
    pub(crate) fn failure(&mut self, method: Method, x: f64, words: &str) {
        let (x, top) = self.at(x, f64::INFINITY);
        let above = self.failures.iter().filter(|other| (**other - x).abs() < 9.0).count();
        self.failures.push(x);
        #[expect(clippy::cast_precision_loss, reason = "a few runs")]
        let y = top + 9.0 + 12.0 * above as f64;
        self.taken.push([x - 6.0, y - 6.0, x + 6.0, y + 6.0]);
        self.over += &format!("{}\n", cross(method, x, y, words));
    }

    /// The front: thick and pale, under everything.
    pub(crate) fn front(&mut self, points: &[(f64, f64)]) {
        self.under += &format!("<polyline class=\"front\" {FRONT} points=\"{}\"/>\n", self.points(points));
    }

    /// A ring around a point.
    pub(crate) fn ring(&mut self, x: f64, y: f64, words: &str) {
        let (x, y) = self.at(x, y);
        self.over += &format!(
            "<circle class=\"ring\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"12\" {RING}><title>{}</title></circle>\n",
            escaped(words)
        );
    }

    /// A name beside a point, on the side where nothing is: first towards the lower left, where under a front nothing
    /// can be.
    pub(crate) fn name(&mut self, x: f64, y: f64, text: &str) {
        let (x, y) = self.at(x, y);
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
        if let Some(place) = places.map(box_at).into_iter().find(|place| fits(place) && free(place)) {
            self.over += &format!(
                "<text class=\"ink name\" fill=\"{INK}\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n",
                place[0],
                place[3] - 3.0,
                escaped(text)
            );
            self.taken.push(place);
        }
    }

    /// A vertical line with words along its top; one that lies beyond the axis stands at the edge.
    pub(crate) fn upright(&mut self, x: f64, words: &str) {
        let [_, top, _, bottom] = self.frame();
        let beyond = !self.x.holds(x);
        let (x, _) = self.at(x, 1.0);
        let x = if beyond { x - 1.5 } else { x };
        self.under += &format!(
            "<path class=\"budget\" d=\"M{x:.1},{top:.1} V{bottom:.1}\" {BUDGET}/>\n\
             <text class=\"budget-text\" fill=\"{BUDGET_INK}\" text-anchor=\"end\" \
             transform=\"translate({:.1},{:.1}) rotate(-90)\">{}</text>\n",
            x - 6.0,
            top + 8.0,
            escaped(words)
        );
        let long = width_of(words);
        self.taken.push([x - 20.0, top, x + 2.0, top + 8.0 + long]);
    }

    /// A horizontal line with words above its right end, or its left one.
    pub(crate) fn level(&mut self, y: f64, words: &str, at_left: bool) {
        let [left, _, right, _] = self.frame();
        let (_, y) = self.at(1.0, y);
        let (anchor, x) = if at_left { ("start", left + 8.0) } else { ("end", right - 8.0) };
        self.under += &format!(
            "<path class=\"floor\" d=\"M{left:.1},{y:.1} H{right:.1}\" {FLOOR}/>\n\
             <text class=\"soft\" fill=\"{SOFT}\" text-anchor=\"{anchor}\" x=\"{x:.1}\" y=\"{:.1}\">{}</text>\n",
            y - 6.0,
            escaped(words)
        );
        let from = if at_left { x } else { x - width_of(words) };
        self.taken.push([from, y - 18.0, from + width_of(words), y]);
    }

    /// What is between the tags of an SVG of [`WIDTH`] by `height`.
    pub(crate) fn finish(self) -> Drawing {
        let [left, top, right, bottom] = self.frame();
        let text = format!(
            "<rect class=\"paper\" width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
             <text class=\"ink title\" fill=\"{INK}\" font-size=\"17\" x=\"{left:.1}\" y=\"{:.1}\">{}</text>\n\
             <g class=\"axes\">\n{}</g>\n\
             <text class=\"ink\" fill=\"{INK}\" text-anchor=\"middle\" x=\"{:.1}\" y=\"{:.1}\">{}</text>\n\
             <text class=\"ink\" fill=\"{INK}\" text-anchor=\"middle\" transform=\"translate(20,{:.1}) rotate(-90)\">{}\
             </text>\n{}{}{}",
            top - 18.0,
            escaped(&self.title),
            axes(&self.x, &self.y, self.height),
            0.5 * (left + right),
            bottom + 46.0,
            escaped(&self.x.title),
            0.5 * (top + bottom),
            escaped(&self.y.title),
            self.under,
            self.over,
            self.legend,
        );
        Drawing { inner: text, height: self.height, title: self.title }
    }
}

fn overlap(a: &Box4, b: &Box4) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[expect(clippy::cast_precision_loss, reason = "a few letters")]
fn width_of(text: &str) -> f64 {
    LETTER * text.chars().count() as f64
}

const INK: &str = "#1c2127";
const SOFT: &str = "#5f6872";
const BUDGET_INK: &str = "#b3261e";
const FRONT: &str = "fill=\"none\" stroke=\"#9aa3ad\" stroke-opacity=\"0.42\" stroke-width=\"10\" \
    stroke-linecap=\"round\" stroke-linejoin=\"round\"";
const RING: &str = "fill=\"none\" stroke=\"#1c2127\" stroke-width=\"2\"";
const BUDGET: &str = "fill=\"none\" stroke=\"#b3261e\" stroke-width=\"1.6\" stroke-dasharray=\"6 4\"";
const FLOOR: &str = "fill=\"none\" stroke=\"#5f6872\" stroke-width=\"1.2\" stroke-dasharray=\"3 3\"";
const CROSS: &str = "M-4.5,-4.5 L4.5,4.5 M-4.5,4.5 L4.5,-4.5";

fn dashes(precision: Precision) -> String {
    match marks::dash(precision) {
        "" => String::new(),
        dash => format!("stroke-dasharray=\"{dash}\""),
    }
}

fn stroke(method: Method, precision: Precision) -> String {
    let (color, dash) = (marks::color(method, marks::LIGHT), dashes(precision));
    format!(
        "class=\"l-{}\" stroke=\"{color}\" stroke-width=\"1.9\" stroke-linejoin=\"round\" {dash}",
        method.name()
    )
}

fn mark(method: Method, x: f64, y: f64, words: &str) -> String {
    format!(
        "<path class=\"mark p-{}\" fill=\"{}\" stroke=\"#ffffff\" stroke-width=\"0.8\" d=\"{}\" \
         transform=\"translate({x:.1},{y:.1})\"><title>{}</title></path>",
        method.name(),
        marks::color(method, marks::LIGHT),
        marks::shape(method),
        escaped(words),
    )
}

fn cross(method: Method, x: f64, y: f64, words: &str) -> String {
    format!(
        "<path class=\"failed l-{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2.4\" d=\"{CROSS}\" \
         transform=\"translate({x:.1},{y:.1})\"><title>{}</title></path>",
        method.name(),
        marks::color(method, marks::LIGHT),
        escaped(words),
    )
}
