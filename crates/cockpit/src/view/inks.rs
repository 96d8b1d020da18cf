//! Colors of words and marks in panels, so that they can be seen in both themes.

use egui::{Color32, Rgba, Visuals};
use motion::Method;
use report::ink;

/// Least contrast of words with what is behind them (WCAG 2.2, criterion 1.4.3).
pub(crate) const WORDS: f32 = 4.5;
/// Least contrast of marks and lines with what is behind them (WCAG 2.2, criterion 1.4.11).
const MARKS: f32 = 3.0;

/// `color` for words: moved toward white or black as far as words need it on panels, plots and striped rows.
pub(crate) fn words(visuals: &Visuals, color: Color32) -> Color32 {
    apart(visuals, color, WORDS)
}

/// `color` for marks, lines and areas.
pub(crate) fn marks(visuals: &Visuals, color: Color32) -> Color32 {
    apart(visuals, color, MARKS)
}

/// The color of a method. It is changed only in a theme in which it could not be seen.
pub(crate) fn of_method(visuals: &Visuals, method: Method) -> Color32 {
    let [r, g, b] = ink(method).srgb;
    marks(visuals, Color32::from_rgb(r, g, b))
}

/// `color` for words on `plate`, a dark translucent ground over any picture.
pub(crate) fn on_plate(plate: Color32, color: Color32) -> Color32 {
    let behind = [Color32::WHITE, Color32::BLACK].map(|picture| picture.blend(plate));
    apart_from(&behind, color, Color32::WHITE, WORDS)
}

fn apart(visuals: &Visuals, color: Color32, least: f32) -> Color32 {
    let behind = [visuals.panel_fill, visuals.extreme_bg_color, striped(visuals)];
    let end = if visuals.dark_mode { Color32::WHITE } else { Color32::BLACK };
    apart_from(&behind, color, end, least)
}

/// `color` moved toward `end` until its contrast with each of `behind` is at least `least`.
fn apart_from(behind: &[Color32], color: Color32, end: Color32, least: f32) -> Color32 {
    let steps = (0..=32_u8).map(|step| color.lerp_to_gamma(end, f32::from(step) / 32.0));
    let seen = |color: &Color32| behind.iter().all(|behind| contrast(*color, *behind) >= least);
    steps.into_iter().find(seen).unwrap_or(end)
}

/// The color behind every second row of a table.
fn striped(visuals: &Visuals) -> Color32 {
    visuals.panel_fill.blend(visuals.faint_bg_color)
}

/// The contrast of two colors (WCAG 2.2), from 1 to 21.
pub(crate) fn contrast(a: Color32, b: Color32) -> f32 {
    let [a, b] = [a, b].map(|color| {
        let color = Rgba::from(color);
        0.2126 * color.r() + 0.7152 * color.g() + 0.0722 * color.b()
    });
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::hud::PLATE;

    #[test]
    fn methods_and_words_are_seen_in_both_themes_and_change_only_where_they_must() {
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-3);
        // The standard gives this contrast for 0x767676 on white.
        assert!((contrast(Color32::from_gray(0x76), Color32::WHITE) - 4.54).abs() < 0.01);
        for visuals in [Visuals::dark(), Visuals::light()] {
            let behind = [visuals.panel_fill, visuals.extreme_bg_color, striped(&visuals)];
            let worst = |color| {
                behind.map(|behind| contrast(color, behind)).into_iter().fold(21.0, f32::min)
            };
            for method in Method::ALL {
                let [r, g, b] = ink(method).srgb;
                let (here, everywhere) = (of_method(&visuals, method), Color32::from_rgb(r, g, b));
                assert!(worst(here) >= MARKS, "{method:?} {here:?}");
                assert_eq!(here == everywhere, worst(everywhere) >= MARKS, "{method:?}");
                assert!(worst(words(&visuals, everywhere)) >= WORDS);
            }
        }
    }

    #[test]
    fn words_in_the_picture_are_seen_on_every_sky() {
        // From the darkest to colors that a cause or a warning has.
        let colors = [0x00_0000, 0xff_5933, 0x8c_a6f2, 0xff_c85a, 0xff_ffff];
        for color in colors.map(|rgb: u32| {
            let [_, r, g, b] = rgb.to_be_bytes();
            Color32::from_rgb(r, g, b)
        }) {
            for sky in [Color32::WHITE, Color32::BLACK, Color32::from_rgb(120, 160, 220)] {
                let behind = sky.blend(PLATE);
                assert!(contrast(on_plate(PLATE, color), behind) >= WORDS, "{color:?} on {sky:?}");
            }
        }
    }
}
