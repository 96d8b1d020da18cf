//! Axes, and the finished figure as a document or a part of a page.

use plotters::prelude::*;

use super::{BOTTOM, LEFT, LEGEND, TOP, WIDTH, escaped};
use crate::axis::Axis;

/// Grid, axes and marks of both. Drawing into a string does not fail; if it did, the figure would have no frame.
pub(super) fn axes(x: &Axis, y: &Axis, height: u32) -> String {
    let mut svg = String::new();
    let drawn = draw_axes(&mut svg, x, y, height);
    let inner = svg.split_once('>').and_then(|(_, rest)| rest.rsplit_once("</svg>")).map(|(inner, _)| inner);
    match (drawn, inner) {
        (Ok(()), Some(inner)) => inner.to_owned(),
        _ => String::new(),
    }
}

fn draw_axes(svg: &mut String, x: &Axis, y: &Axis, height: u32) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(svg, (WIDTH, height)).into_drawing_area();
    let mut chart = ChartBuilder::on(&area)
        .margin_top(TOP)
        .margin_right(LEGEND)
        .x_label_area_size(BOTTOM)
        .y_label_area_size(LEFT)
        .build_cartesian_2d(x.clone(), y.clone())
        .map_err(|error| error.to_string())?;
    let text = |size: i32| ("sans-serif", size).into_font().color(&RGBColor(0x5f, 0x68, 0x72));
    chart
        .configure_mesh()
        .light_line_style(RGBColor(0xf1, 0xf3, 0xf5))
        .bold_line_style(RGBColor(0xdd, 0xe1, 0xe6))
        .axis_style(RGBColor(0x8c, 0x95, 0x9f))
        .label_style(text(16))
        .draw()
        .map_err(|error| error.to_string())?;
    area.present().map_err(|error| error.to_string())?;
    Ok(())
}

/// A figure that was drawn.
pub(crate) struct Drawing {
    pub(super) inner: String,
    pub(super) height: u32,
    pub(super) title: String,
}

impl Drawing {
    /// Elements of SVG, in a picture of the width of all figures and so many pixels high.
    pub(crate) const fn new(inner: String, height: u32, title: String) -> Self {
        Self { inner, height, title }
    }

    fn tag(&self, more: &str) -> String {
        format!(
            "<svg {more}viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"{}\" \
             font-family=\"Ubuntu, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif\" font-size=\"13\">\n{}</svg>\n",
            self.height,
            escaped(&self.title),
            self.inner
        )
    }

    /// A document of its own.
    pub(crate) fn document(&self) -> String {
        self.tag(&format!(
            "xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{}\" ",
            self.height
        ))
    }

    /// A part of a page.
    pub(crate) fn inline(&self) -> String {
        self.tag("")
    }
}
