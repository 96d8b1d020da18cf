//! Maps of what a step does to an oscillator: one panel per method.

use lab::limits::{LongRun, Map, Panel};

use crate::chart::{Anchor, Axis, Drawing, INK, Rgb, Shape, Stroke, WIDTH, axes};
use crate::numbers::power;

/// Height of the picture, and room above and below its panels, pixels.
const HEIGHT: u32 = 1080;
const TITLE: f64 = 44.0;
const LEGEND: f64 = 40.0;

/// Colors of Okabe and Ito (2008, Color Universal Design), the ones that grow darkest.
const fn color(class: LongRun) -> Rgb {
    match class {
        LongRun::Keeps => [0xd6, 0xea, 0xf8],
        LongRun::Decays => [86, 180, 233],
        LongRun::Creeps => [0, 158, 115],
        LongRun::Flips => [240, 228, 66],
        LongRun::Grows => [176, 58, 0],
    }
}

/// The picture of `map`.
pub fn picture(map: &Map) -> Drawing {
    let (width, height) = (f64::from(WIDTH) / 3.0, (f64::from(HEIGHT) - TITLE - LEGEND) / 3.0);
    let mut shapes = vec![Shape::words(&map.title).sized(20.0).at(16.0, 30.0)];
    for (panel, place) in map.panels.iter().zip(0_u8..) {
        let (left, top) = (f64::from(place % 3) * width, TITLE + f64::from(place / 3) * height);
        shapes.extend(draw(map, panel, [left + 66.0, top + 26.0, left + width - 14.0, top + height - 46.0]));
    }
    let foot = f64::from(HEIGHT) - LEGEND + 10.0;
    for (x, class) in [16.0, 130.0, 310.0, 560.0, 860.0].into_iter().zip(LongRun::ALL) {
        shapes.push(Shape::rectangles([[x, foot, 16.0, 16.0]]).fill(color(class)));
        shapes.push(Shape::soft_words(class.name()).at(x + 22.0, foot + 13.0));
    }
    Drawing { title: map.title.clone(), height: HEIGHT, shapes }
}

fn draw(map: &Map, panel: &Panel, frame: [f64; 4]) -> Vec<Shape> {
    let [left, top, right, bottom] = frame;
    let ends = map.places.each_ref().map(|places| ends(places));
    let [x, y] = [0, 1].map(|i| Axis::between(&map.axes[i], ends[i], power));
    let across = |part: f64| (left + part * (right - left)).round();
    let up = |part: f64| (bottom - part * (bottom - top)).round();
    let (wide, high) = (map.places[0].len(), map.places[1].len());
    let part = |i: usize, of: usize| i as f64 / of as f64;
    let cells = |class: LongRun| {
        let rows = panel.classes.chunks(wide).enumerate();
        let boxes = rows.flat_map(move |(j, row)| {
            let (top, bottom) = (up(part(j + 1, high)), up(part(j, high)));
            let mut start = 0;
            row.chunk_by(|a, b| a == b).filter_map(move |run| {
                let (from, to) = (across(part(start, wide)), across(part(start + run.len(), wide)));
                start += run.len();
                (run[0] == class).then_some([from, top, to - from, bottom - top])
            })
        });
        Shape::rectangles(boxes).fill(color(class))
    };
    let middle = |words: &str| Shape::soft_words(words).anchored(Anchor::Middle);
    let theory = panel
        .theory
        .iter()
        .map(|(h, at)| (left + x.place(*h) * (right - left), bottom - y.place(*at) * (bottom - top)));
    let mut shapes = axes(&x, &y, frame);
    shapes.extend(LongRun::ALL.map(cells));
    shapes.push(Shape::line(theory).stroke(Stroke::new(INK, 2.0)));
    shapes.push(middle(panel.method.claims().title).sized(15.0).at(0.5 * (left + right), top - 8.0));
    shapes.push(middle(&x.title).at(0.5 * (left + right), bottom + 38.0));
    shapes.push(middle(&y.title).upward().at(left - 48.0, 0.5 * (top + bottom)));
    shapes
}

/// Ends of an axis whose cells have these middles, in equal ratios.
fn ends(places: &[f64]) -> (f64, f64) {
    match places {
        [first, second, .., last] => {
            let half = (second / first).sqrt();
            (first / half, last * half)
        }
        _ => (0.1, 1.0),
    }
}
