//! Says in words what a step of a lesson still waits for.

use report::numbers::{digits, number};
use scene::lesson::{
    Axis, Comparison, Formula, Measure, Quantity, RunMeasure, ScreenMeasure, quantity_of,
};

use crate::tools::learn::panel_of;

/// Smallest number that is written; smaller ones are nothing that a person can see.
const LEAST: f64 = 1e-9;

/// A measured number in a sentence.
pub(super) fn in_words(value: f64) -> String {
    match value.abs() {
        size if size > 0.0 && size < LEAST => format!("less than {LEAST:e}"),
        // With commas between thousands, where there are some.
        1e4..1e7 => number(value, 4),
        _ => digits(value),
    }
}

/// The quantities that the names in formulas measure.
#[derive(Clone, Copy)]
pub(super) struct Measures<'a> {
    pub quantities: &'a [Quantity],
    /// The body at which the step points: a person sees it marked, whatever its name is.
    pub pointed_at: Option<&'a str>,
}

impl Measures<'_> {
    /// The name of a body in a sentence.
    fn called<'b>(&self, body: &'b str) -> &'b str {
        if self.pointed_at == Some(body) { "the body with the ring" } else { body }
    }
}

/// The comparisons of `formula` that do not hold, in words: "energy 51 J, to be below 43 J".
pub(super) fn missing(
    formula: &Formula,
    measures: Measures<'_>,
    value: impl Fn(&str) -> Option<f64> + Copy,
) -> String {
    let Some(parts) = formula.comparisons() else { return String::new() };
    let words = |part: &Comparison| {
        truth(part, measures).unwrap_or_else(|| short_of(part, measures, value))
    };
    parts.iter().filter(|part| !part.holds(value)).map(words).collect::<Vec<_>>().join("; ")
}

/// The words of a comparison of a quantity that is true or false; `None` for other quantities.
fn truth(part: &Comparison, measures: Measures<'_>) -> Option<String> {
    let Quantity { measure, .. } =
        measures.quantities.iter().find(|quantity| quantity.name == part.left.text().trim())?;
    let wanted = part.right.value(|_| None) != 0.0;
    let not = if wanted { "not " } else { "" };
    let words = match measure {
        Measure::Run(RunMeasure::Method(method)) => {
            format!("the method is {not}{}", method.claims().title)
        }
        Measure::Run(_) => return None,
        Measure::Screen(measure) => match measure {
            ScreenMeasure::Selected(body) => {
                format!("{} is {not}selected", measures.called(body))
            }
            ScreenMeasure::Shows(panel) => {
                let title = panel_of(panel)?.row().title;
                format!("{title} is {}", if wanted { "not open" } else { "open" })
            }
            ScreenMeasure::Paused => {
                (if wanted { "it is not paused" } else { "it is paused" }).to_owned()
            }
            ScreenMeasure::Follows => {
                format!("the camera follows {}", if wanted { "no body" } else { "a body" })
            }
            ScreenMeasure::Fault => {
                (if wanted { "nothing went wrong yet" } else { "something went wrong" }).to_owned()
            }
            ScreenMeasure::GhostError(_) | ScreenMeasure::PushWork | ScreenMeasure::ClickForce => {
                return None;
            }
        },
    };
    Some(words)
}

fn short_of(
    part: &Comparison,
    measures: Measures<'_>,
    value: impl Fn(&str) -> Option<f64> + Copy,
) -> String {
    let bound = match part.sign {
        "<" | "<=" => "below ",
        ">" | ">=" => "above ",
        "!=" => "other than ",
        _ => "",
    };
    if part.left.names().len() > 2 || part.left.text().contains(['/', '^']) {
        let names: Vec<_> = part
            .left
            .names()
            .iter()
            .map(|name| described(name, std::slice::from_ref(name), measures).0)
            .collect();
        return format!("{} do not meet the condition yet", one_of(&names));
    }
    let (words, unit) = described(part.left.text(), part.left.names(), measures);
    let with_unit = |number: f64| match number.is_nan() {
        true => "not known".to_owned(),
        false => format!("{} {unit}", in_words(number)).trim_end().to_owned(),
    };
    let [now, then] = [&part.left, &part.right].map(|formula| with_unit(formula.value(value)));
    format!("{words} {now}, to be {bound}{then}")
}

/// A formula with words for its names, and the unit of its value if that is simple.
fn described(text: &str, names: &[String], measures: Measures<'_>) -> (String, &'static str) {
    let described = |name: &String| {
        let (quantity, suffix) = quantity_of(measures.quantities, name)?;
        let (words, unit) = words(&quantity.measure, measures);
        let words = match suffix {
            "_before" => format!("{words} before"),
            "_most" => format!("largest {words}"),
            "_least" => format!("smallest {words}"),
            _ => words,
        };
        Some((words, unit))
    };
    let known: Vec<_> = names.iter().map(described).collect();
    let mut units = known.iter().map(|known| known.as_ref().map_or("", |(_, unit)| unit));
    let unit = units.next().unwrap_or_default();
    // A product or quotient of two quantities has another unit.
    let is_plain = !text.contains(['/', '^']) && (names.len() == 1 || !text.contains('*'));
    let unit = if is_plain && units.all(|other| other == unit) { unit } else { "" };
    // The distance of two numbers, whichever is larger.
    if let (Some(inside), [Some((one, _)), Some((other, _))]) =
        (text.trim().strip_prefix("abs("), &known[..])
        && inside.matches(['(', '+', '*']).count() == 0
    {
        return (format!("difference of {one} and {other}"), unit);
    }
    if let (Some(_), [Some((one, _))]) = (text.trim().strip_prefix("abs("), &known[..])
        && !text.contains(['+', '-', '*'])
    {
        return (format!("magnitude of {one}"), unit);
    }
    let mut written = String::new();
    let mut rest = text.trim();
    while let Some(c) = rest.chars().next() {
        let word: String =
            rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        let place = names.iter().position(|name| *name == word);
        match place.and_then(|place| known[place].as_ref()) {
            Some((words, _)) => written += words,
            None if word.is_empty() => written.push(c),
            None => written += &word,
        }
        rest = &rest[word.len().max(c.len_utf8())..];
    }
    (written, unit)
}

/// Joins words: "a, b and c".
fn one_of(words: &[String]) -> String {
    match words {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        words => words.concat(),
    }
}

/// The measured quantity in words, and its unit.
fn words(measure: &Measure, measures: Measures<'_>) -> (String, &'static str) {
    let called = |body| measures.called(body);
    let axis = |axis: &Axis| match axis {
        Axis::X => "x",
        Axis::Y => "y",
        Axis::Z => "z",
    };
    let measure = match measure {
        Measure::Run(measure) => measure,
        Measure::Screen(measure) => return words_of_screen(measure, measures),
    };
    match measure {
        RunMeasure::Time => ("time".to_owned(), "s"),
        RunMeasure::Position(body, along) => (format!("{} of {}", axis(along), called(body)), "m"),
        RunMeasure::Velocity(body, along) => {
            (format!("velocity of {} along {}", called(body), axis(along)), "m/s")
        }
        RunMeasure::Speed(body) => (format!("speed of {}", called(body)), "m/s"),
        RunMeasure::Mass(body) => (format!("mass of {}", called(body)), "kg"),
        RunMeasure::Distance(one, other) => {
            (format!("distance of {} and {}", called(one), called(other)), "m")
        }
        RunMeasure::Energy => ("energy".to_owned(), "J"),
        RunMeasure::KineticEnergy => ("kinetic energy".to_owned(), "J"),
        RunMeasure::Momentum(along) => (format!("momentum along {}", axis(along)), "kg m/s"),
        RunMeasure::Gravity => ("gravity".to_owned(), "m/s²"),
        RunMeasure::Damping => ("damping".to_owned(), "1/s"),
        RunMeasure::StepHz => ("ticks per second".to_owned(), ""),
        RunMeasure::Substeps => ("substeps".to_owned(), ""),
        RunMeasure::Method(method) => (method.claims().title.to_owned(), ""),
        RunMeasure::Evaluations => ("evaluations".to_owned(), ""),
        RunMeasure::Quarantined => ("quarantined bodies".to_owned(), ""),
        RunMeasure::Error => ("error".to_owned(), "m"),
    }
}

/// The same of a quantity that only the screen has.
fn words_of_screen(measure: &ScreenMeasure, measures: Measures<'_>) -> (String, &'static str) {
    match measure {
        ScreenMeasure::GhostError(method) => (format!("error of {}", method.claims().title), "m"),
        ScreenMeasure::PushWork => ("work of pushes".to_owned(), "J"),
        ScreenMeasure::ClickForce => ("force of a click".to_owned(), "N"),
        ScreenMeasure::Selected(body) => (format!("{} selected", measures.called(body)), ""),
        ScreenMeasure::Shows(panel) => (panel.clone(), ""),
        ScreenMeasure::Paused => ("paused".to_owned(), ""),
        ScreenMeasure::Follows => ("following".to_owned(), ""),
        ScreenMeasure::Fault => ("faults".to_owned(), ""),
    }
}

#[cfg(test)]
mod tests {
    use motion::Method;

    use super::*;

    #[test]
    fn what_is_missing_is_said_with_its_numbers() {
        let quantity = |name: &str, measure| Quantity { name: name.to_owned(), measure };
        let measure = [
            quantity("e", Measure::Run(RunMeasure::Energy)),
            quantity("v", Measure::Run(RunMeasure::Speed("ball".to_owned()))),
            quantity("m", Measure::Run(RunMeasure::Mass("ball".to_owned()))),
            quantity("rk4", Measure::Run(RunMeasure::Method(Method::RungeKutta4))),
            quantity(
                "ledger",
                Measure::Screen(ScreenMeasure::Shows("toggle_ledger_panel".to_owned())),
            ),
            quantity("paused", Measure::Screen(ScreenMeasure::Paused)),
        ];
        let value = |name: &str| match name {
            "e" | "e_most" => Some(51.0),
            "e_before" | "e_least" => Some(50.0),
            "v" => Some(1e-20),
            "m" => Some(2.0),
            "rk4" | "ledger" => Some(0.0),
            "paused" => Some(1.0),
            _ => None,
        };
        let measures = Measures { quantities: &measure, pointed_at: None };
        let said = |text: &str| missing(&Formula::parse(text).expect("a formula"), measures, value);
        assert_eq!(said("e < 43 && m == 2"), "energy 51 J, to be below 43 J");
        assert_eq!(said("e < e_before * 0.85"), "energy 51 J, to be below 42.5 J");
        assert_eq!(
            said("abs(e - e_before) > 3"),
            "difference of energy and energy before 1 J, to be above 3 J"
        );
        assert_eq!(
            said("e_most - e_least == 0 && 2 * m > 9"),
            "largest energy - smallest energy 1 J, to be 0 J; 2 * mass of ball 4 kg, to be above 9 kg"
        );
        assert_eq!(
            said("v / m >= 1"),
            "mass of ball and speed of ball do not meet the condition yet"
        );
        assert_eq!(
            said("abs(v) > 1"),
            "magnitude of speed of ball less than 1e-9 m/s, to be above 1 m/s"
        );
        assert_eq!(
            said("rk4 == 1 && ledger == 1 && paused == 0"),
            "the method is not Runge-Kutta 4; Ledger is not open; it is paused"
        );
        assert_eq!(said("gone > 2"), "gone not known, to be above 2");
        assert_eq!(said("e > 60 || v > 2"), "", "no words for it");
    }
}
