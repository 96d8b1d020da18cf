//! What varies in a sweep: a place in the scene, and the values that it takes.

use motion::{DampingModel, Method};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

/// Most values of an axis.
const MOST_VALUES: usize = 1_000_000;

/// A place in a scene, and the values that it takes, as a person writes them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Axis {
    /// The place, as messages name it: see [`scene::VariedScene`].
    pub place: String,
    /// Its values: at least one, and none twice.
    pub values: Vec<String>,
}

/// How the values of a range are spaced.
#[derive(Clone, Copy, PartialEq)]
enum Spacing {
    Linear,
    Logarithmic,
}

impl Axis {
    /// Reads `PLACE=VALUES`, where VALUES is
    /// - a list: `30,60,120` or `(1,0,0),(2,0,0)`,
    /// - `all` methods or models of damping,
    /// - a range with both ends: `1e2..1e6 log 20` or `1..2 lin 5`,
    /// - random draws from a range: `1..2 random 20`, uniform, or `1e2..1e6 log random 20`, uniform in the logarithm, with
    ///   `seed 7` at the end instead of 0 (PCG64, O'Neill 2014).
    ///
    /// # Errors
    /// What is wrong with the text, and what would be right.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (place, values) =
            text.split_once('=').ok_or("give a place and its values, as in step_hz=30,60,120")?;
        let (place, values) = (place.trim(), values.trim());
        if place.is_empty() {
            return Err("give the place before the =, as in step_hz=30,60,120".to_owned());
        }
        if values.contains(char::is_control) {
            return Err("a value has no line breaks; write it on one line".to_owned());
        }
        let values = if values == "all" {
            all_of(place)?
        } else if values.contains("..") && !values.contains('"') {
            range(values)?
        } else {
            list(values)?
        };
        if let Some(twice) = twice(&values) {
            return Err(format!("{twice} is given twice; leave one out"));
        }
        Ok(Self { place: place.to_owned(), values })
    }

    /// Its values as numbers, if all of them are.
    #[must_use]
    pub fn numbers(&self) -> Option<Vec<f64>> {
        // A whole number that `f64` may not represent exactly stays a text.
        let exact =
            |value: &str, number: f64| number.abs() < 9e15 || value.contains(['.', 'e', 'E']);
        let number = |value: &String| {
            value.parse::<f64>().ok().filter(|number| number.is_finite() && exact(value, *number))
        };
        self.values.iter().map(number).collect()
    }
}

/// All words that are values of the place.
fn all_of(place: &str) -> Result<Vec<String>, String> {
    let words: Vec<&str> = match place.rsplit('.').next() {
        Some("method") => Method::ALL.map(Method::name).to_vec(),
        Some("model") => DampingModel::ALL.map(DampingModel::name).to_vec(),
        _ => {
            return Err("only method and damping.model have `all` values; give a list or a range"
                .to_owned());
        }
    };
    Ok(words.into_iter().map(str::to_owned).collect())
}

/// Splits a list at the commas outside of brackets and quotes.
fn list(text: &str) -> Result<Vec<String>, String> {
    let (mut values, mut value, mut depth) = (Vec::new(), String::new(), 0_usize);
    let (mut quoted, mut escaped) = (false, false);
    for c in text.chars() {
        let was_escaped = std::mem::take(&mut escaped);
        match c {
            '\\' if quoted => escaped = !was_escaped,
            '"' if !was_escaped => quoted = !quoted,
            '/' | '*' if !quoted && value.ends_with('/') => {
                return Err("a value has no comments; leave it out".to_owned());
            }
            '(' | '[' if !quoted => depth += 1,
            ')' | ']' if !quoted => depth = depth.saturating_sub(1),
            ',' if depth == 0 && !quoted => {
                values.push(std::mem::take(&mut value));
                continue;
            }
            _ => {}
        }
        value.push(c);
    }
    values.push(value);
    let values: Vec<String> = values.iter().map(|value| value.trim().to_owned()).collect();
    if values.iter().any(String::is_empty) {
        return Err("a value is missing; give values with a comma between two".to_owned());
    }
    Ok(values)
}

const RANGE: &str =
    "give a range as 1e2..1e6 log 20, 1..2 lin 5, 1..2 random 20 seed 7 or 1e2..1e6 log random 20";

fn range(text: &str) -> Result<Vec<String>, String> {
    let mut parts = text.split_whitespace();
    let ends = parts.next().and_then(|ends| ends.split_once(".."));
    let number = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
    let (from, to) = ends.and_then(|(from, to)| Some((number(from)?, number(to)?))).ok_or(RANGE)?;
    let parts: Vec<&str> = parts.collect();
    let (spacing, random, count, seed) = match parts[..] {
        ["lin", count] => (Spacing::Linear, false, count, "0"),
        ["log", count] => (Spacing::Logarithmic, false, count, "0"),
        ["random", count] | ["lin", "random", count] => (Spacing::Linear, true, count, "0"),
        ["random", count, "seed", seed] | ["lin", "random", count, "seed", seed] => {
            (Spacing::Linear, true, count, seed)
        }
        ["log", "random", count] => (Spacing::Logarithmic, true, count, "0"),
        ["log", "random", count, "seed", seed] => (Spacing::Logarithmic, true, count, seed),
        _ => return Err(RANGE.to_owned()),
    };
    let seed: u64 = seed.parse().map_err(|_| "a seed is a whole number; give one such as 7")?;
    let least = if random { 1 } else { 2 };
    let count = count.parse().ok().filter(|count| (least..=MOST_VALUES).contains(count));
    let count =
        count.ok_or_else(|| format!("give from {least} to {MOST_VALUES} values of a range"))?;
    if from >= to {
        return Err(format!(
            "the range {}..{} is empty; give its lower end first",
            written(from),
            written(to)
        ));
    }
    if spacing == Spacing::Logarithmic && from <= 0.0 {
        return Err("a logarithmic range begins above 0; give another lower end, or lin".to_owned());
    }
    let all = if random { 1.0 } else { (count - 1) as f64 };
    let at = |part: f64| match spacing {
        Spacing::Linear => from + (to - from) * part / all,
        Spacing::Logarithmic => from * libm::pow(to / from, part / all),
    };
    let values = if random {
        let mut random = Pcg64::seed_from_u64(seed);
        (0..count).map(|_| at(random.random::<f64>())).collect::<Vec<_>>()
    } else {
        // Both ends stay as they were given.
        let inner = (1..count - 1).map(|i| short(at(i as f64)));
        std::iter::once(from).chain(inner).chain([to]).collect()
    };
    Ok(values.into_iter().map(written).collect())
}

/// Rounds to 14 digits, so that whole values of a range are whole.
fn short(number: f64) -> f64 {
    format!("{number:.13e}").parse().unwrap_or(number)
}

/// A number as a person writes it: whole ones without a point, so that keys for whole numbers take them.
fn written(number: f64) -> String {
    let text = format!("{number:?}");
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

/// A value that occurs twice, as a number or as a text.
fn twice(values: &[String]) -> Option<&String> {
    let meant = |value: &String| match value.parse::<f64>() {
        Ok(number) if number.abs() < 9e15 => written(number),
        _ => value.clone(),
    };
    let mut sorted: Vec<(String, &String)> =
        values.iter().map(|value| (meant(value), value)).collect();
    sorted.sort_unstable();
    sorted.windows(2).find(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        Axis::parse(text).unwrap().values
    }

    #[test]
    fn lists_ranges_and_draws_are_read() {
        assert_eq!(values("step_hz=30, 60,120"), ["30", "60", "120"]);
        assert_eq!(values("bodies[0].velocity_m_s=(1,0,0),(2,0,0)"), ["(1,0,0)", "(2,0,0)"]);
        assert_eq!(values("substeps=1..5 lin 5"), ["1", "2", "3", "4", "5"]);
        assert_eq!(values("method=all").len(), Method::ALL.len());
        assert_eq!(
            values("springs[0].stiffness_n_m=1e2..1e6 log 5"),
            ["100", "1000", "10000", "100000", "1000000"]
        );
        let all: Vec<String> = (1..=5000).map(|whole| whole.to_string()).collect();
        assert_eq!(values("substeps=1..5000 lin 5000"), all);
        assert_eq!(values(r##"bodies[0].label="a, \"b..\"","c""##).len(), 2);
        let seeds = Axis::parse("seed=9007199254740993,9007199254740992").unwrap();
        assert_eq!((seeds.values.len(), seeds.numbers()), (2, None));
        let draws = values("pace=1..2 random 1000 seed 7");
        assert_eq!(draws, values("pace=1..2 lin random 1000 seed 7"));
        assert_ne!(draws, values("pace=1..2 random 1000"));
        let numbers: Vec<f64> = draws.iter().map(|draw| draw.parse().unwrap()).collect();
        let mean = numbers.iter().sum::<f64>() / 1000.0;
        // Six standard deviations of the mean of 1000 uniform draws.
        assert!(
            numbers.iter().all(|draw| (1.0..2.0).contains(draw)) && (mean - 1.5).abs() < 0.055,
            "{mean}"
        );
    }

    #[test]
    fn what_cannot_be_read_says_what_would_be_right() {
        for (text, said) in [
            ("step_hz", "give a place and its values, as in step_hz=30,60,120"),
            ("step_hz=30,,60", "a value is missing; give values with a comma between two"),
            ("step_hz=30,60,30", "30 is given twice; leave one out"),
            ("step_hz=30,60,3e1", "3e1 is given twice; leave one out"),
            ("=30,60", "give the place before the =, as in step_hz=30,60,120"),
            ("step_hz=30,\n60", "a value has no line breaks; write it on one line"),
            ("step_hz=30 /* x */,60", "a value has no comments; leave it out"),
            ("step_hz=60..30 lin 3", "the range 60..30 is empty; give its lower end first"),
            ("step_hz=30..30 lin 3", "the range 30..30 is empty; give its lower end first"),
            ("x=1e300..1e-300 lin 3", "the range 1e300..1e-300 is empty; give its lower end first"),
            (
                "step_hz=0..30 log 3",
                "a logarithmic range begins above 0; give another lower end, or lin",
            ),
            ("step_hz=30..60", RANGE),
            ("step_hz=30..60 lin 1", "give from 2 to 1000000 values of a range"),
            ("step_hz=30..60 random 3 seed x", "a seed is a whole number; give one such as 7"),
            (
                "step_hz=all",
                "only method and damping.model have `all` values; give a list or a range",
            ),
        ] {
            assert_eq!(Axis::parse(text).unwrap_err(), said, "{text}");
        }
    }
}
