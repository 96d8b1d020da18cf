//! How methods look in figures: a color and a shape each.

use motion::Method;

use super::drawing::{Rgb, hex};
use crate::palette::{ink, linear};

/// Light ground of figures, sRGB.
pub(crate) const LIGHT: Rgb = [0xff, 0xff, 0xff];
/// Dark ground of figures, sRGB.
pub(crate) const DARK: Rgb = [0x16, 0x19, 0x1d];

/// Contrast that a graphic needs to be seen (WCAG 2.2, 1.4.11).
const CONTRAST: f64 = 3.0;

/// The color of a method, moved away from the ground until it stands out.
pub(crate) fn color(method: Method, ground: Rgb) -> Rgb {
    let towards = if luminance(ground) > 0.5 { 0.0 } else { 255.0 };
    let own = ink(method).srgb;
    let mixed =
        |part: f64| own.map(|channel| f64::from(channel) + part * (towards - f64::from(channel)));
    let enough = |part: &f64| contrast(mixed(*part), ground.map(f64::from)) >= CONTRAST;
    let part = (0..20).map(|i| 0.05 * f64::from(i)).find(enough).unwrap_or(1.0);
    mixed(part).map(rounded)
}

fn rounded(channel: f64) -> u8 {
    channel.round() as u8
}

/// Contrast ratio of relative luminances (WCAG 2.2), 1 to 21.
fn contrast(a: [f64; 3], b: [f64; 3]) -> f64 {
    let luminance = |srgb: [f64; 3]| luminance(srgb.map(rounded)) + 0.05;
    let (a, b) = (luminance(a), luminance(b));
    a.max(b) / a.min(b)
}

fn luminance(srgb: Rgb) -> f64 {
    srgb.map(linear)
        .iter()
        .zip([0.2126, 0.7152, 0.0722])
        .map(|(channel, weight)| channel * weight)
        .sum()
}

/// The outline of a method's mark around the origin, about 6 pixels in radius. Position Verlet and the midpoint method
/// often have the errors of the methods after them, and are a little larger to be seen behind them.
pub(crate) const fn shape(method: Method) -> &'static str {
    match method {
        Method::ExplicitEuler => "M0,-6.5 L6.2,4.6 L-6.2,4.6 Z",
        Method::SemiImplicitEuler => "M-5.4,0 A5.4,5.4 0 1 1 5.4,0 A5.4,5.4 0 1 1 -5.4,0 Z",
        Method::ImplicitEuler => "M-4.8,-4.8 H4.8 V4.8 H-4.8 Z",
        Method::PositionVerlet => "M0,9 L8.4,-6.4 L-8.4,-6.4 Z",
        Method::VelocityVerlet => "M0,-7 L6,0 L0,7 L-6,0 Z",
        Method::RungeKutta2Midpoint => "M-9,0 L6.4,-8.4 L6.4,8.4 Z",
        Method::RungeKutta2Heun => "M6.5,0 L-4.6,-6.2 L-4.6,6.2 Z",
        Method::RungeKutta4 => {
            "M0,-7.5 L1.8,-2.4 L7.1,-2.3 L2.9,0.9 L4.4,6.1 L0,3 L-4.4,6.1 L-2.9,0.9 L-7.1,-2.3 L-1.8,-2.4 Z"
        }
        Method::Yoshida4 => "M-6,0 L-3,-5.2 L3,-5.2 L6,0 L3,5.2 L-3,5.2 Z",
    }
}

/// Rules that move each method's color away from a dark ground; figures on their own are on a light one.
pub(crate) fn dark_rules() -> String {
    Method::ALL.into_iter().fold(String::new(), |rules, method| {
        let (name, color) = (method.name(), hex(color(method, DARK)));
        rules + &format!(".l-{name}{{stroke:{color}}}.p-{name}{{fill:{color}}}\n")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_stands_out_on_both_grounds_and_has_its_own_shape() {
        for method in Method::ALL {
            for ground in [LIGHT, DARK] {
                let srgb = color(method, ground).map(f64::from);
                assert!(contrast(srgb, ground.map(f64::from)) >= CONTRAST, "{}", method.name());
            }
            assert_eq!(
                Method::ALL.into_iter().filter(|other| shape(*other) == shape(method)).count(),
                1
            );
        }
    }
}
