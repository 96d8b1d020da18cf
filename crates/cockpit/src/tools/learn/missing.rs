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

/// The comparisons of `formula` that do not hold, in words: "the energy is 51 J and has to be below 43 J". Empty if that takes more
/// than one quantity, or one without a unit: a person needs the author's words then.
pub(super) fn missing(
    formula: &Formula,
    measures: Measures<'_>,
    value: impl Fn(&str) -> Option<f64> + Copy,
) -> String {
    let Some(parts) = formula.comparisons() else { return String::new() };
    let failing: Vec<_> = parts.iter().filter(|part| !part.holds(value)).collect();
    let truths: Option<Vec<_>> = failing.iter().map(|part| truth(part, measures)).collect();
    match (truths, &failing[..]) {
        (Some(words), _) => words.join("; "),
        (None, [part]) => short_of(part, measures, value).unwrap_or_default(),
        (None, _) => String::new(),
    }
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

/// What a quantity is and has to be; `None` for a formula of several, or without a unit.
fn short_of(
    part: &Comparison,
    measures: Measures<'_>,
    value: impl Fn(&str) -> Option<f64>,
) -> Option<String> {
    let (quantity, suffix) = quantity_of(measures.quantities, part.left.text().trim())?;
    let (words, unit) = words(&quantity.measure, measures);
    let extreme = match suffix {
        "" => "",
        "_most" => "largest ",
        "_least" => "smallest ",
        _ => return None,
    };
    let bound = match part.sign {
        "<" | "<=" => "below ",
        ">" | ">=" => "above ",
        "!=" => "other than ",
        _ => "",
    };
    let [now, then] = [part.left.value(&value), part.right.value(&value)];
    let with_unit = |number: f64| format!("{} {unit}", in_words(number));
    (!unit.is_empty() && now.is_finite() && then.is_finite()).then(|| {
        let (now, then) = (with_unit(now), with_unit(then));
        format!("the {extreme}{words} is {now} and has to be {bound}{then}")
    })
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
        assert_eq!(said("e < 43 && m == 2"), "the energy is 51 J and has to be below 43 J");
        assert_eq!(
            said("e_most < e_before * 0.85"),
            "the largest energy is 51 J and has to be below 42.5 J"
        );
        assert_eq!(
            said("v >= 1"),
            "the speed of ball is less than 1e-9 m/s and has to be above 1 m/s"
        );
        for of_several in ["abs(e - e_before) > 3", "v / m >= 1", "e < 43 && m > 9", "2 * m > 9"] {
            assert_eq!(said(of_several), "", "{of_several}");
        }
        assert_eq!(
            said("rk4 == 1 && ledger == 1 && paused == 0"),
            "the method is not Runge-Kutta 4; Ledger is not open; it is paused"
        );
        assert_eq!(said("gone > 2"), "");
        assert_eq!(said("e > 60 || v > 2"), "", "no words for it");
    }
}
