//! Numbers as people read them, and as JSON has them.

use glam::DVec3;
use serde_json::{Value, json};

/// A number, or its name where JSON has none.
pub(crate) fn json_number(value: f64) -> Value {
    if value.is_nan() {
        json!("nan")
    } else if value.is_infinite() {
        json!(if value > 0.0 { "inf" } else { "-inf" })
    } else {
        json!(value)
    }
}

/// At most four digits, zeros at the end left out.
pub(crate) fn digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e4).contains(&size) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a power of ten from -3 to 3"
        )]
        let decimals = (3.0 - size.log10().floor()) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else if size.is_infinite() {
        "infinite".to_owned()
    } else {
        format!("{value:.3e}")
    }
}

/// Four digits.
pub(crate) fn four_digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a power of ten from -3 to 4"
        )]
        let decimals = (3.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.2e}")
    }
}

/// Four digits with a sign, of a change.
pub(crate) fn signed(value: f64) -> String {
    if value > 0.0 { format!("+{}", four_digits(value)) } else { four_digits(value) }
}

/// Three decimals, or a power of ten where they would say nothing.
pub(crate) fn three_decimals(value: f64) -> String {
    // -0 is 0.
    let (value, size) = (value + 0.0, value.abs());
    if value == 0.0 || (1e-2..1e6).contains(&size) { format!("{value:.3}") } else { format!("{value:.3e}") }
}

/// A distance with three digits at most: what is read while it changes.
pub(crate) fn meters(distance: f64) -> String {
    match distance {
        0.0 => "0 m".to_owned(),
        d if d < 1e-3 => format!("{d:.1e} m"),
        d if d < 1.0 => format!("{d:.3} m"),
        d if d < 10.0 => format!("{d:.2} m"),
        d if d < 100.0 => format!("{d:.1} m"),
        d if d < 1e5 => format!("{d:.0} m"),
        d => format!("{d:.1e} m"),
    }
}

/// Three digits.
pub(crate) fn three_digits(price: f64) -> String {
    if (0.01..1e4).contains(&price) {
        let digits = (2.0 - price.log10().floor()).max(0.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 4")]
        let digits = digits as usize;
        format!("{price:.digits$}")
    } else {
        format!("{price:.2e}")
    }
}

/// A count per step; a whole number without decimals.
pub(crate) fn tidy(count: f64) -> String {
    if count == count.round() { format!("{count:.0}") } else { format!("{count:.2}") }
}

/// Seconds as a person would say them.
pub(crate) fn duration(seconds: f64) -> String {
    let units = [("days", 86_400.0), ("h", 3_600.0), ("min", 60.0), ("s", 1.0)];
    let unit = units.iter().find(|(_, length)| seconds >= 1.5 * length);
    let (name, length) = unit.copied().unwrap_or(("ms", 1e-3));
    format!("{:.1} {name}", seconds / length)
}

/// Three components with a unit.
pub(crate) fn vector(v: DVec3, unit: &str) -> String {
    format!("({}, {}, {}) {unit}", three_decimals(v.x), three_decimals(v.y), three_decimals(v.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_at_most_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (2.0, "2"),
            (166.666, "166.7"),
            (0.012_345_6, "0.01235"),
            (9_999.6, "10000"),
            (12_345.6, "1.235e4"),
            (1e-5, "1.000e-5"),
        ] {
            assert_eq!(digits(value), text);
        }
    }

    #[test]
    fn numbers_have_four_digits_and_a_sign_where_they_are_changes() {
        let cases = [
            (0.0, "0"),
            (1.0, "1.000"),
            (-12.345_67, "-12.35"),
            (0.012_345, "0.01235"),
            (99_999.0, "99999"),
            (1e-7, "1.00e-7"),
        ];
        for (value, expected) in cases {
            assert_eq!(four_digits(value), expected);
        }
        assert_eq!([signed(2.5), signed(-2.5), signed(0.0)], ["+2.500", "-2.500", "0"]);
    }

    #[test]
    fn distances_have_three_digits_at_every_size() {
        let seen = [0.0, 1.26e-7, 0.0132, 0.999_4, 1.234, 56.78, 1234.4, 3e7].map(meters);
        let expected = ["0 m", "1.3e-7 m", "0.013 m", "0.999 m", "1.23 m", "56.8 m", "1234 m", "3.0e7 m"];
        assert_eq!(seen, expected);
    }
}
