//! Maps of what a step does to an oscillator: one panel a method.

use std::error::Error;

use motion::Method;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::oscillator::{Damped, Eigenvalues, Oscillator, eigenvalues};
use super::theory::oscillator_limit;

/// What becomes of an oscillator in the long run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LongRun {
    /// It swings on for ever.
    Keeps,
    /// It swings less and less.
    Decays,
    /// It comes to rest without a swing.
    Creeps,
    /// It comes to rest and changes sign at every step, which no oscillator does.
    Flips,
    /// It grows.
    Grows,
}

impl LongRun {
    /// Every class.
    pub const ALL: [Self; 5] = [Self::Keeps, Self::Decays, Self::Creeps, Self::Flips, Self::Grows];

    /// From one tick.
    #[must_use]
    pub fn of(tick: [[f64; 2]; 2]) -> Self {
        // Where real eigenvalues meet, rounding moves them by its square root.
        let (size, least, swings, rounding) = match eigenvalues(tick) {
            Eigenvalues::Pair(re, im) => (re.hypot(im), re, true, 1e-12),
            Eigenvalues::Real(low, high) => (low.abs().max(high.abs()), low, false, 1e-7),
        };
        if size.is_nan() || size > 1.0 + rounding {
            Self::Grows
        } else if size >= 1.0 - rounding && swings {
            Self::Keeps
        } else if swings {
            Self::Decays
        } else if least < -rounding {
            Self::Flips
        } else {
            Self::Creeps
        }
    }

    /// What it is called in a legend.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Keeps => "swings on",
            Self::Decays => "swings less and less",
            Self::Creeps => "comes to rest without a swing",
            Self::Flips => "comes to rest, flipping at every step",
            Self::Grows => "grows",
        }
    }

    /// Colors of Okabe and Ito (2008, Color Universal Design), the ones that grow darkest.
    const fn color(self) -> RGBColor {
        match self {
            Self::Keeps => RGBColor(0xd6, 0xea, 0xf8),
            Self::Decays => RGBColor(86, 180, 233),
            Self::Creeps => RGBColor(0, 158, 115),
            Self::Flips => RGBColor(240, 228, 66),
            Self::Grows => RGBColor(176, 58, 0),
        }
    }
}

/// A map: classes by step and by something else, for every method.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// What it shows.
    pub title: String,
    /// What stands along the axes, with units.
    pub axes: [String; 2],
    /// Middles of the cells along the first axis and along the second, in equal ratios.
    pub places: [Vec<f64>; 2],
    /// A panel a method: classes, row by row of the second axis, and the closed form of the limit over it.
    pub panels: Vec<Panel>,
}

/// One method.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// The method.
    pub method: Method,
    /// Classes, the first axis running faster.
    pub classes: Vec<LongRun>,
    /// Points of the line beyond which the closed form says that it grows.
    pub theory: Vec<(f64, f64)>,
}

/// `n` values in equal ratios.
fn ratios(low: f64, high: f64, n: u32) -> Vec<f64> {
    (0..n).map(|i| low * (high / low).powf((f64::from(i) + 0.5) / f64::from(n))).collect()
}

/// Step against stiffness, without damping: `side` cells a side.
#[must_use]
pub fn stiffness_map(side: u32) -> Map {
    let places = [ratios(1e-4, 1.0, side), ratios(1.0, 1e8, side)];
    let panel = |method: Method| {
        let oscillator = Oscillator { method, damped: Damped::by_drag(0.0) };
        let class =
            |k: &f64| places[0].iter().map(|h| LongRun::of(oscillator.tick(*k, *h))).collect::<Vec<_>>();
        let limit = oscillator_limit(method, oscillator.damped);
        let line = ratios(1.0, 1e8, 200).into_iter().map(|k| (limit / k.sqrt(), k));
        Panel {
            method,
            classes: places[1].iter().flat_map(class).collect(),
            theory: line.filter(|(h, _)| (1e-4..=1.0).contains(h)).collect(),
        }
    };
    Map {
        title: "Step against stiffness, no damping".to_owned(),
        axes: ["step h, s".to_owned(), "stiffness over mass k / m, 1/s²".to_owned()],
        panels: Method::ALL.map(panel).to_vec(),
        places,
    }
}

/// Step against damping by linear drag, of an oscillator of frequency w: `side` cells a side.
#[must_use]
pub fn damping_map(side: u32) -> Map {
    let (steps, rates) = ((0.02, 20.0), (0.01, 10.0));
    let places = [ratios(steps.0, steps.1, side), ratios(rates.0, rates.1, side)];
    let panel = |method: Method| {
        let class = |ratio: &f64| {
            let oscillator = Oscillator { method, damped: Damped::by_drag(*ratio) };
            places[0].iter().map(|h| LongRun::of(oscillator.tick(1.0, *h))).collect::<Vec<_>>()
        };
        let line = ratios(rates.0, rates.1, 200);
        let line = line.into_iter().map(|ratio| (oscillator_limit(method, Damped::by_drag(ratio)), ratio));
        Panel {
            method,
            classes: places[1].iter().flat_map(class).collect(),
            theory: line.filter(|(h, _)| (steps.0..=steps.1).contains(h)).collect(),
        }
    };
    Map {
        title: "Step against damping by linear drag".to_owned(),
        axes: ["w h".to_owned(), "damping ratio c / 2w".to_owned()],
        panels: Method::ALL.map(panel).to_vec(),
        places,
    }
}

/// Size of the picture, and of what stands above and below the panels.
const SIZE: (u32, u32) = (1100, 1080);
const TITLE: u32 = 44;
const LEGEND: u32 = 40;

const GRAY: RGBColor = RGBColor(0x5f, 0x68, 0x72);

impl Map {
    /// As an SVG document; empty if it could not be drawn, which drawing into a string always can.
    #[must_use]
    pub fn svg(&self) -> String {
        let mut svg = String::new();
        match self.draw(&mut svg) {
            Ok(()) => svg,
            Err(_) => String::new(),
        }
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn Error>> {
        let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let (title, rest) = area.split_vertically(TITLE);
        title.draw(&Text::new(self.title.clone(), (16, 14), ("sans-serif", 22).into_font()))?;
        let (panels, legend) = rest.split_vertically(SIZE.1 - TITLE - LEGEND);
        for (panel, area) in self.panels.iter().zip(panels.split_evenly((3, 3))) {
            self.draw_panel(panel, &area)?;
        }
        for (left, class) in [16, 130, 310, 560, 860].into_iter().zip(LongRun::ALL) {
            legend.draw(&Rectangle::new([(left, 10), (left + 16, 26)], class.color().filled()))?;
            legend.draw(&Text::new(
                class.name(),
                (left + 22, 13),
                ("sans-serif", 13).into_font().color(&GRAY),
            ))?;
        }
        area.present()?;
        Ok(())
    }

    fn draw_panel(
        &self,
        panel: &Panel,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
    ) -> Result<(), Box<dyn Error>> {
        let [(x, wide), (y, high)] = self.places.each_ref().map(|places| edges(places));
        let font = |size: i32| ("sans-serif", size).into_font().color(&GRAY);
        let mut chart = ChartBuilder::on(area)
            .margin(8)
            .caption(panel.method.claims().title, ("sans-serif", 15))
            .x_label_area_size(36)
            .y_label_area_size(54)
            .build_cartesian_2d((x.0..x.1).log_scale(), (y.0..y.1).log_scale())?;
        let cells = panel.classes.chunks(self.places[0].len()).zip(&self.places[1]);
        for (row, middle) in cells {
            let mut start = 0;
            for run in row.chunk_by(|a, b| a == b) {
                let end = start + run.len();
                let from = self.places[0][start] / wide;
                let to = self.places[0][end - 1] * wide;
                let cell = [(from, middle / high), (to, middle * high)];
                chart.draw_series([Rectangle::new(cell, run[0].color().filled())])?;
                start = end;
            }
        }
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(5)
            .y_labels(5)
            .x_desc(self.axes[0].clone())
            .y_desc(self.axes[1].clone())
            .label_style(font(12))
            .axis_desc_style(font(12))
            .x_label_formatter(&|value| power(*value))
            .y_label_formatter(&|value| power(*value))
            .draw()?;
        chart.draw_series([PathElement::new(panel.theory.clone(), BLACK.stroke_width(2))])?;
        Ok(())
    }
}

/// Ends of an axis, and the ratio of a cell's edge to its middle.
fn edges(places: &[f64]) -> ((f64, f64), f64) {
    match places {
        [first, second, .., last] => {
            let half = (second / first).sqrt();
            ((first / half, last * half), half)
        }
        _ => ((0.1, 1.0), 1.0),
    }
}

/// A mark of a logarithmic axis.
fn power(value: f64) -> String {
    let exponent = value.log10().round();
    if (0.01..=100.0).contains(&value) { format!("{value}") } else { format!("1e{exponent}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_those_of_the_eigenvalues() {
        let (sin, cos) = 0.3_f64.sin_cos();
        let turn = |by: f64| [[by * cos, by * sin], [-by * sin, by * cos]];
        for (tick, class) in [
            (turn(1.0), LongRun::Keeps),
            (turn(0.9), LongRun::Decays),
            (turn(1.1), LongRun::Grows),
            ([[0.5, 0.0], [0.0, 0.2]], LongRun::Creeps),
            ([[0.5, 0.0], [0.0, -0.2]], LongRun::Flips),
            ([[0.5, 0.0], [0.0, -1.2]], LongRun::Grows),
            ([[f64::NAN, 0.0], [0.0, 0.0]], LongRun::Grows),
        ] {
            assert_eq!(LongRun::of(tick), class, "{tick:?}");
        }
    }
}
