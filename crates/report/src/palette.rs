//! The color and the short name of each method, in pictures, panels and figures alike.

use motion::{METHODS, Method};

/// How a method is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ink {
    /// A name that fits beside a line.
    pub short: &'static str,
    /// Red, green and blue as displayed (sRGB), 0 to 255.
    pub srgb: [u8; 3],
}

/// The color and the name of references.
pub const REFERENCE_INK: Ink = Ink { short: "reference", srgb: [255, 255, 255] };

/// The colors and names of methods, in the order of [`motion::METHODS`]: seven colors of Okabe and Ito (2008, Color
/// Universal Design), then wine and indigo of Tol (2021, "muted"). Any two of them, and white, differ by 16 or more
/// in CIELAB, where 2.3 is just noticed, also for people who do not see red, green or blue (Machado, Oliveira,
/// Fernandes 2009).
pub const INKS: [Ink; METHODS.len()] = [
    Ink { short: "EE", srgb: [213, 94, 0] },
    Ink { short: "SIE", srgb: [230, 159, 0] },
    Ink { short: "IE", srgb: [240, 228, 66] },
    Ink { short: "PV", srgb: [0, 158, 115] },
    Ink { short: "VV", srgb: [86, 180, 233] },
    Ink { short: "RK2 midpoint", srgb: [0, 114, 178] },
    Ink { short: "RK2 Heun", srgb: [204, 121, 167] },
    Ink { short: "RK4", srgb: [136, 34, 85] },
    Ink { short: "Y4", srgb: [51, 34, 136] },
];

/// The color and the short name of `method`.
pub const fn ink(method: Method) -> Ink {
    INKS[method as usize]
}

/// Linear light, 0 to 1, of a channel as displayed (sRGB).
pub(crate) fn linear(channel: u8) -> f64 {
    let value = f64::from(channel) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What people see of linear red, green and blue: with all cones, then without those for red, green or blue.
    const EYES: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152_286, 1.052_583, -0.204_868],
            [0.114_503, 0.786_281, 0.099_216],
            [-0.003_882, -0.048_116, 1.051_998],
        ],
        [
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ],
        [
            [1.255_528, -0.076_749, -0.178_779],
            [-0.078_411, 0.930_809, 0.147_602],
            [0.004_733, 0.691_367, 0.303_900],
        ],
    ];

    fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
    }

    /// CIELAB under daylight (D65).
    fn cielab(eye: &[[f64; 3]; 3], srgb: [u8; 3]) -> [f64; 3] {
        let seen = times(eye, srgb.map(linear)).map(|channel| channel.clamp(0.0, 1.0));
        let to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
        let [x, y, z] = times(&to_xyz, seen);
        let root = |t: f64| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
        let (x, y, z) = (root(x / 0.95047), root(y), root(z / 1.08883));
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    #[test]
    fn methods_are_in_the_order_of_the_table() {
        assert_eq!(Method::ALL.map(|method| method as usize), [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(ink(Method::RungeKutta4).short, "RK4");
        assert_eq!(ink(Method::Yoshida4).short, "Y4");
    }

    #[test]
    fn no_two_colors_look_alike_to_anybody() {
        let inks: Vec<_> = INKS.into_iter().chain([REFERENCE_INK]).collect();
        for (i, a) in inks.iter().enumerate() {
            for b in &inks[..i] {
                assert_ne!(a.short, b.short);
                for eye in &EYES {
                    let (p, q) = (cielab(eye, a.srgb), cielab(eye, b.srgb));
                    let distance =
                        p.iter().zip(q).map(|(p, q)| (p - q).powi(2)).sum::<f64>().sqrt();
                    assert!(distance > 16.0, "{} and {} are {distance:.1} apart", a.short, b.short);
                }
            }
        }
    }
}
