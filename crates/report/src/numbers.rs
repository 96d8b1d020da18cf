//! Numbers as people read them: few digits, units that fit, and a dash for what is not finite; and as JSON has them.

use std::ops::Range;

use serde_json::{Value, json};

/// Stands for a number that is not finite.
pub const NONE: &str = "-";

/// Formats a number with at most that number of significant digits, but all digits before the point, without trailing
/// zeros; as a power of ten from ten million up and below a ten-thousandth.
pub fn number(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or_default();
    if !(-4..7).contains(&exponent) {
        return format!("{}e{exponent}", trimmed(mantissa));
    }
    let whole = usize::try_from(exponent).unwrap_or_default() + 1;
    let leading = usize::try_from(-exponent).unwrap_or_default();
    let decimals = if exponent < 0 { leading + digits - 1 } else { digits.saturating_sub(whole) };
    grouped(trimmed(&format!("{value:.decimals$}")))
}

/// Rounds to significant digits.
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

/// Formats a number with significant digits, including trailing zeros; as a power of ten outside of `range`.
pub fn significant(value: f64, digits: u8, range: Range<f64>) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if range.contains(&size) {
        let decimals = (f64::from(digits) - 1.0 - size.log10().floor()).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.*e}", usize::from(digits) - 1)
    }
}

/// Formats a number with at most four significant digits, without trailing zeros.
pub fn digits(value: f64) -> String {
    match significant(value, 4, 1e-3..1e4) {
        _ if value.is_infinite() => "infinite".to_owned(),
        text if text.contains('e') => text,
        text => trimmed(&text).to_owned(),
    }
}

/// Formats a number that changes, with four significant digits (three in a power of ten): trailing zeros keep it in
/// place.
pub fn four_digits(value: f64) -> String {
    let digits = if (1e-3..1e5).contains(&value.abs()) { 4 } else { 3 };
    significant(value, digits, 1e-3..1e5)
}

/// Formats a change as [`four_digits`], with a sign.
pub fn signed(value: f64) -> String {
    if value > 0.0 { format!("+{}", four_digits(value)) } else { four_digits(value) }
}

/// Formats a number with three significant digits.
pub fn three_digits(value: f64) -> String {
    significant(value, 3, 0.01..1e4)
}

/// Formats a number with three decimals, or as a power of ten if decimals would say nothing.
pub fn three_decimals(value: f64) -> String {
    // Adding 0 turns -0 into 0.
    let (value, size) = (value + 0.0, value.abs());
    if value == 0.0 || (1e-2..1e6).contains(&size) {
        format!("{value:.3}")
    } else {
        format!("{value:.3e}")
    }
}

/// Formats a count per step; a whole number without decimals.
pub fn count(count: f64) -> String {
    if count == count.round() { format!("{count:.0}") } else { format!("{count:.2}") }
}

/// Formats seconds in the unit that a person would use.
pub fn long_duration(seconds: f64) -> String {
    let units = [("days", 86_400.0), ("h", 3_600.0), ("min", 60.0), ("s", 1.0)];
    let unit = units.iter().find(|(_, length)| seconds >= 1.5 * length);
    let (name, length) = unit.copied().unwrap_or(("ms", 1e-3));
    format!("{:.1} {name}", seconds / length)
}

/// Seconds per day.
const DAY: f64 = 86_400.0;
/// Seconds per Julian year.
const YEAR: f64 = 365.25 * DAY;

/// The astronomical unit, m (IAU 2012).
const AU: f64 = 149_597_870_700.0;

/// The unit for times up to `seconds`, and its length in seconds: seconds, days or years.
pub fn time_unit(seconds: f64) -> (&'static str, f64) {
    match seconds.abs() {
        size if size >= 2.0 * YEAR => ("years", YEAR),
        size if size >= 2.0 * DAY => ("days", DAY),
        _ => ("s", 1.0),
    }
}

/// The rate of ticks of `step` seconds: per second, or as the length of a tick if that is a minute or more.
pub fn tick_rate(step: f64) -> String {
    match step {
        step if step < 60.0 => format!("{} Hz", digits(1.0 / step)),
        step if (step / DAY - 1.0).abs() < 1e-9 => "1 per day".to_owned(),
        step => format!("1 per {}", long_duration(step)),
    }
}

/// Units of times and their lengths, s.
const SECONDS: [(&str, f64); 5] =
    [("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9), ("ps", 1e-12)];

/// A time of a scene whose ticks last `step` seconds: in days and years if a tick lasts a minute or more, else in the largest
/// unit of which a tick is at least a hundred-thousandth.
pub fn scene_time(seconds: f64, step: f64) -> String {
    match seconds {
        seconds if step < 60.0 => {
            let (name, unit) =
                SECONDS.into_iter().find(|(_, unit)| step >= 1e-5 * unit).unwrap_or(("fs", 1e-15));
            format!("{:.2} {name}", seconds / unit)
        }
        seconds if seconds < 2.0 * YEAR => format!("{:.1} days", seconds / DAY),
        seconds => format!("{:.2} years", seconds / YEAR),
    }
}

/// A pace, simulated seconds per second, in words.
pub fn pace_words(pace: f64) -> String {
    match pace {
        pace if pace < 1.0 => format!("1/{} x", digits(1.0 / pace)),
        pace if pace < 3_600.0 => format!("{} x", digits(pace)),
        pace if pace < DAY => format!("{} h/s", digits(pace / 3_600.0)),
        pace if pace < YEAR => format!("{} days/s", digits(pace / DAY)),
        pace => format!("{} years/s", digits(pace / YEAR)),
    }
}

/// A number for JSON; the name of a number that is not finite, which JSON does not have.
pub fn json_number(value: f64) -> Value {
    match value {
        value if value.is_finite() => json!(value),
        value if value.is_nan() => json!("nan"),
        value => json!(value.to_string()),
    }
}

fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// Inserts commas between thousands.
fn grouped(text: &str) -> String {
    let (whole, rest) = text.find('.').map_or((text, ""), |point| text.split_at(point));
    let mut grouped = String::new();
    for (i, c) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) && !grouped.ends_with('-') {
            grouped.push(',');
        }
        grouped.push(c);
    }
    grouped + rest
}

/// A unit: the smallest size for which it is used, its own size, and its name.
type Unit = (f64, f64, &'static str);

/// Formats a value in the first of `units` that it fills, which descend, or in the last.
fn in_units(value: f64, digits: usize, units: &[Unit]) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    // 0.99996 mm is 1 mm when it is rounded to two digits.
    let size = rounded(value, digits).abs();
    let fits = units.iter().find(|(from, ..)| size >= *from * (1.0 - 1e-9));
    let Some((_, size, name)) = fits.or(units.last()) else { return number(value, digits) };
    format!("{} {name}", number(value / size, digits))
}

const METER: Unit = (1.0, 1.0, "m");
const LENGTHS: [Unit; 8] = [
    (0.01 * AU, AU, "au"),
    (1e4, 1e3, "km"),
    METER,
    (1e-2, 1e-2, "cm"),
    (1e-5, 1e-3, "mm"),
    (1e-7, 1e-6, "µm"),
    (1e-10, 1e-9, "nm"),
    (1e-12, 1e-12, "pm"),
];

/// A length in m.
pub fn length(meters: f64, digits: usize) -> String {
    // Rounding may lift a value to the unit, so a little less counts.
    let no_name = meters.abs() < 9.9e-13;
    in_units(meters, digits, if no_name { &[METER] } else { &LENGTHS })
}

/// A length in m with all of its digits, also zeros: in a column that changes, it keeps its width.
pub fn steady_length(meters: f64, digits: u8) -> String {
    let text = length(meters, digits.into());
    match text.split_once(' ').map(|(number, unit)| (number.parse(), unit)) {
        Some((Ok(number), unit)) => format!("{} {unit}", significant(number, digits, 1e-3..1e6)),
        _ => text,
    }
}

/// The unit for lengths up to `meters` in a drawing, and its length in meters: meters, kilometers or astronomical
/// units.
pub fn length_unit(meters: f64) -> (&'static str, f64) {
    let (_, size, name) =
        LENGTHS[..2].iter().copied().find(|(from, ..)| meters.abs() >= *from).unwrap_or(METER);
    (name, size)
}

/// A time in ns.
pub fn duration(ns: f64, digits: usize) -> String {
    in_units(ns, digits, &[(1e9, 1e9, "s"), (1e6, 1e6, "ms"), (1e3, 1e3, "µs"), (1.0, 1.0, "ns")])
}

/// A part of a whole in percent, or as a multiple from 10 wholes on.
pub fn share(part: f64, digits: usize) -> String {
    match part {
        _ if !part.is_finite() => NONE.to_owned(),
        10.0.. => format!("{}-fold", fold(part)),
        _ => format!("{} %", number(100.0 * part, digits)),
    }
}

/// A factor with two significant digits.
pub fn fold(factor: f64) -> String {
    number(rounded(factor, 2), 2)
}

const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// A power of ten with its exponent in superscript.
pub fn power_of_ten(exponent: i32) -> String {
    if exponent == 0 {
        return "1".to_owned();
    }
    let raised = |c: char| c.to_digit(10).map_or('⁻', |digit| RAISED[digit as usize]);
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// Formats a number as a power of ten, or a digit times one, if a plain number would be long.
pub fn power(value: f64) -> String {
    let exponent = value.log10().floor() as i32;
    let digit = (value / 10f64.powi(exponent)).round();
    if (-2..=3).contains(&exponent) {
        number(value, 1)
    } else if digit > 1.0 {
        format!("{digit}·{}", power_of_ten(exponent))
    } else {
        power_of_ten(exponent)
    }
}

/// The text with a capital first letter.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_matter() {
        let table = [
            (0.0, "0"),
            (1.0, "1"),
            (16.04, "16"),
            (9.96, "10"),
            (123.4, "123"),
            (12288.0, "12,288"),
            (-1234.5, "-1,234"),
            (0.020_4, "0.02"),
            (0.000_16, "0.00016"),
            (3.12e-9, "3.1e-9"),
            (9.4e6, "9,400,000"),
            (9.99e6, "1e7"),
            (2.5e7, "2.5e7"),
            (f64::NAN, "-"),
            (f64::INFINITY, "-"),
        ];
        for (value, text) in table {
            assert_eq!(number(value, 2), text);
        }
    }

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
    fn steady_lengths_keep_their_digits() {
        let of = |meters: f64| steady_length(meters, 3);
        assert_eq!(
            [of(0.012), of(1.0), of(7.2e-3), of(0.0)],
            ["1.20 cm", "1.00 m", "7.20 mm", "0 m"]
        );
        assert_eq!([of(3.036e-4), of(f64::NAN)], ["0.304 mm", "-"]);
    }

    #[test]
    fn times_and_paces_of_the_solar_system_are_read_in_days_and_years() {
        let times = [
            (1.23e-11, 1e-15),
            (1.5, 0.01),
            (86_400.0, 59.0),
            (86_400.0, 3_600.0),
            (1e8, 86_400.0),
        ];
        assert_eq!(
            times.map(|(seconds, step)| scene_time(seconds, step)),
            ["12.30 ps", "1.50 s", "86400.00 s", "1.0 days", "3.17 years"]
        );
        let paces = [1.0 / 64.0, 1.0, 16.0, 3_600.0, 2_592_000.0, 6.3e7].map(pace_words);
        assert_eq!(
            [1.0 / 120.0, 86_400.0, 3_600.0].map(tick_rate),
            ["120 Hz", "1 per day", "1 per 60.0 min"]
        );
        assert_eq!(paces, ["1/64 x", "1 x", "16 x", "1 h/s", "30 days/s", "1.996 years/s"]);
    }

    #[test]
    fn units_fit() {
        assert_eq!(length(1e-3, 2), "1 mm");
        assert_eq!(length(2.04e-5, 2), "0.02 mm");
        assert_eq!(length(0.0999, 2), "10 cm");
        assert_eq!(length(12.0, 2), "12 m");
        assert_eq!(length(1234.4, 3), "1,234 m");
        assert_eq!(length(938_242e3, 3), "938,242 km");
        assert_eq!(length(1.496e11, 3), "1 au");
        assert_eq!([9_000.0, 2e4, 1e11].map(|most| length_unit(most).0), ["m", "km", "au"]);
        assert_eq!(length(5e-6, 2), "5 µm");
        assert_eq!(length(3e-12, 2), "3 pm");
        assert_eq!(length(3e-13, 2), "3e-13 m");
        assert_eq!(length(0.0, 2), "0 m");
        assert_eq!(length(f64::NAN, 2), "-");
        assert_eq!(duration(3.12, 2), "3.1 ns");
        assert_eq!(duration(2.5e6, 2), "2.5 ms");
        assert_eq!(share(0.000_007, 2), "0.0007 %");
        assert_eq!(fold(149_713.0), "150,000");
        assert_eq!(power_of_ten(-12), "10⁻¹²");
        assert_eq!(power_of_ten(4), "10⁴");
    }
}
