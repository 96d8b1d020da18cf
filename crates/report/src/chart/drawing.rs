//! A drawing: shapes and words, as SVG.

use std::fmt::Write;

use crate::escape::html;

/// Red, green and blue as displayed (sRGB).
pub(crate) type Rgb = [u8; 3];

/// A box on the picture, pixels: left, top, right, bottom.
pub(crate) type Box4 = [f64; 4];

/// Width of every figure, pixels.
pub(crate) const WIDTH: u32 = 1100;
pub(crate) const INK: Rgb = [0x1c, 0x21, 0x27];
pub(crate) const SOFT: Rgb = [0x5f, 0x68, 0x72];
pub(crate) const PAPER: Rgb = [0xff, 0xff, 0xff];

/// Alignment of words relative to their position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    const fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Middle => "middle",
            Self::End => "end",
        }
    }
}

/// The outline of a shape: a path or words.
#[derive(Clone, Debug)]
pub(crate) enum Outline {
    /// The path, in the language of SVG.
    Path(String),
    /// Words of a size in pixels.
    Words { text: String, size: f64, anchor: Anchor, upward: bool },
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stroke {
    pub color: Rgb,
    pub width: f64,
    /// Lengths of dashes and gaps; empty for a whole line.
    pub dash: &'static [f64],
    /// Opacity, 0 to 1.
    pub opacity: f32,
}

impl Stroke {
    pub(crate) const fn new(color: Rgb, width: f64) -> Self {
        Self { color, width, dash: &[], opacity: 1.0 }
    }

    pub(crate) const fn dashed(self, dash: &'static [f64]) -> Self {
        Self { dash, ..self }
    }
}

/// A shape of a drawing.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub outline: Outline,
    /// Its place, pixels.
    pub at: (f64, f64),
    /// CSS class, by which a page changes its colors.
    pub class: String,
    pub fill: Option<Rgb>,
    pub stroke: Option<Stroke>,
    /// Text that is shown under the pointer.
    pub tip: String,
}

impl Shape {
    const fn new(outline: Outline) -> Self {
        Self {
            outline,
            at: (0.0, 0.0),
            class: String::new(),
            fill: None,
            stroke: None,
            tip: String::new(),
        }
    }

    pub(crate) fn path(path: impl Into<String>) -> Self {
        Self::new(Outline::Path(path.into()))
    }

    /// A line through points.
    pub(crate) fn line(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let mut path = String::new();
        for (x, y) in points {
            // Writing to a string cannot fail.
            let _ = write!(path, "{}{x:.1},{y:.1}", if path.is_empty() { 'M' } else { 'L' });
        }
        Self::path(path)
    }

    /// Rectangles by their left, top, width and height.
    pub(crate) fn rectangles(boxes: impl IntoIterator<Item = [f64; 4]>) -> Self {
        let path = |[x, y, width, height]: [f64; 4]| {
            format!("M{x:.1},{y:.1}h{width:.1}v{height:.1}h{:.1}Z", -width)
        };
        Self::path(boxes.into_iter().map(path).collect::<String>())
    }

    /// Words in ink.
    pub(crate) fn words(text: impl Into<String>) -> Self {
        let text = text.into();
        let words = Outline::Words { text, size: 13.0, anchor: Anchor::Start, upward: false };
        Self::new(words).fill(INK).class("ink")
    }

    /// Less important words.
    pub(crate) fn soft_words(text: impl Into<String>) -> Self {
        Self::words(text).fill(SOFT).class("soft")
    }

    pub(crate) const fn at(mut self, x: f64, y: f64) -> Self {
        self.at = (x, y);
        self
    }

    pub(crate) fn class(mut self, class: impl Into<String>) -> Self {
        self.class = class.into();
        self
    }

    pub(crate) const fn fill(mut self, color: Rgb) -> Self {
        self.fill = Some(color);
        self
    }

    pub(crate) const fn stroke(mut self, stroke: Stroke) -> Self {
        self.stroke = Some(stroke);
        self
    }

    pub(crate) fn tip(mut self, words: &str) -> Self {
        words.clone_into(&mut self.tip);
        self
    }

    pub(crate) const fn anchored(mut self, to: Anchor) -> Self {
        if let Outline::Words { anchor, .. } = &mut self.outline {
            *anchor = to;
        }
        self
    }

    pub(crate) const fn sized(mut self, pixels: f64) -> Self {
        if let Outline::Words { size, .. } = &mut self.outline {
            *size = pixels;
        }
        self
    }

    pub(crate) const fn upward(mut self) -> Self {
        if let Outline::Words { upward, .. } = &mut self.outline {
            *upward = true;
        }
        self
    }

    fn svg(&self) -> String {
        let mut style = String::new();
        if !self.class.is_empty() {
            style += &format!(" class=\"{}\"", self.class);
        }
        style += &format!(" fill=\"{}\"", self.fill.map_or("none".to_owned(), hex));
        if let Some(Stroke { color, width, dash, opacity }) = self.stroke {
            style += &format!(" stroke=\"{}\" stroke-width=\"{width}\"", hex(color));
            if !dash.is_empty() {
                let dash: Vec<_> = dash.iter().map(f64::to_string).collect();
                style += &format!(" stroke-dasharray=\"{}\"", dash.join(" "));
            }
            if opacity < 1.0 {
                style += &format!(" stroke-opacity=\"{opacity}\"");
            }
        }
        let (x, y) = self.at;
        let tip = if self.tip.is_empty() {
            String::new()
        } else {
            format!("<title>{}</title>", html(&self.tip))
        };
        match &self.outline {
            Outline::Path(path) => {
                let place = if self.at == (0.0, 0.0) {
                    String::new()
                } else {
                    format!(" transform=\"translate({x:.1},{y:.1})\"")
                };
                format!("<path{style} d=\"{path}\"{place}>{tip}</path>\n")
            }
            Outline::Words { text, size, anchor, upward } => {
                let place = if *upward {
                    format!("transform=\"translate({x:.1},{y:.1}) rotate(-90)\"")
                } else {
                    format!("x=\"{x:.1}\" y=\"{y:.1}\"")
                };
                format!(
                    "<text{style} {place} font-size=\"{size}\" text-anchor=\"{}\" pointer-events=\"none\">{}</text>\n",
                    anchor.name(),
                    html(text)
                )
            }
        }
    }
}

/// Formats a color for CSS.
pub(crate) fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Shapes with a title; later shapes are above earlier ones.
#[derive(Clone, Debug)]
pub struct Drawing {
    pub(crate) title: String,
    pub(crate) height: u32,
    pub(crate) shapes: Vec<Shape>,
}

impl Drawing {
    /// The drawing as an SVG document.
    pub fn document(&self) -> String {
        self.tag(&format!(
            "xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{}\" ",
            self.height
        ))
    }

    /// The drawing as a part of a page.
    pub(crate) fn inline(&self) -> String {
        self.tag("")
    }

    fn tag(&self, more: &str) -> String {
        let shapes: String = self.shapes.iter().map(Shape::svg).collect();
        format!(
            "<svg {more}viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"{}\" stroke-linejoin=\"round\" \
             font-family=\"Ubuntu, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif\">\n\
             <rect class=\"paper\" width=\"100%\" height=\"100%\" fill=\"{}\"/>\n{shapes}</svg>\n",
            self.height,
            html(&self.title),
            hex(PAPER),
        )
    }
}
