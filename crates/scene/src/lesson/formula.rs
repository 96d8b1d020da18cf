//! Formulas over measured quantities, and sentences with formulas in them.

use std::sync::Arc;

use exmex::{
    BinOp, Express, FlatEx, MakeOperators, MatchLiteral, Operator, literal_matcher_from_pattern,
};

/// The arithmetic of formulas: all values are numbers, true is 1 and false is 0.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Arithmetic;

impl MakeOperators<f64> for Arithmetic {
    fn make<'a>() -> Vec<Operator<'a, f64>> {
        let binary = |name, prio, apply: fn(f64, f64) -> f64| {
            Operator::make_bin(name, BinOp { apply, prio, is_commutative: false })
        };
        vec![
            binary("||", 0, |a, b| truth(a != 0.0 || b != 0.0)),
            binary("&&", 1, |a, b| truth(a != 0.0 && b != 0.0)),
            binary("<=", 2, |a, b| truth(a <= b)),
            binary(">=", 2, |a, b| truth(a >= b)),
            binary("==", 2, |a, b| truth(a == b)),
            binary("!=", 2, |a, b| truth(a != b)),
            binary("<", 2, |a, b| truth(a < b)),
            binary(">", 2, |a, b| truth(a > b)),
            Operator::make_bin_unary(
                "+",
                BinOp { apply: |a, b| a + b, prio: 3, is_commutative: false },
                |a| a,
            ),
            Operator::make_bin_unary(
                "-",
                BinOp { apply: |a, b| a - b, prio: 3, is_commutative: false },
                |a| -a,
            ),
            binary("*", 4, |a, b| a * b),
            binary("/", 4, |a, b| a / b),
            binary("^", 5, libm::pow),
            binary("min", 6, f64::min),
            binary("max", 6, f64::max),
            Operator::make_unary("abs", f64::abs),
            Operator::make_unary("sqrt", f64::sqrt),
        ]
    }
}

literal_matcher_from_pattern!(Numbers, r"^[0-9]+(\.[0-9]*)?([eE][+-]?[0-9]+)?");

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

/// A formula over named quantities: `+ - * / ^`, `abs(x)`, `sqrt(x)`, `min(x, y)`, `max(x, y)`, comparisons, `&&` and `||`.
#[derive(Clone, Debug)]
pub struct Formula {
    text: String,
    /// Shared, because it is large and copied with its lesson.
    tree: Arc<FlatEx<f64, Arithmetic, Numbers>>,
}

impl Formula {
    /// Longest formula that is read, bytes: the parser is recursive.
    const LONGEST: usize = 500;

    /// Reads a formula.
    ///
    /// # Errors
    /// What is wrong with it, as a clause.
    pub fn parse(text: &str) -> Result<Self, String> {
        // The parser would take anything in braces for a name, and accepts other brackets than round ones.
        if text.len() > Self::LONGEST
            || text.contains(['{', '}', '[', ']', '"'])
            || text.trim().is_empty()
        {
            return Err(format!("`{text}` is not a formula"));
        }
        let tree = FlatEx::parse(text).map_err(|_| format!("`{text}` is not a formula"))?;
        Ok(Self { text: text.to_owned(), tree: Arc::new(tree) })
    }

    /// The formula as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The quantities that it names.
    #[must_use]
    pub fn names(&self) -> &[String] {
        self.tree.var_names()
    }

    /// The comparisons that it joins with `&&`; `None` if it is made of anything else.
    #[must_use]
    pub fn comparisons(&self) -> Option<Vec<Comparison>> {
        let (mut parts, mut start) = (Vec::new(), 0);
        for at in outside_brackets(&self.text) {
            if self.text[at..].starts_with("||") {
                return None;
            }
            if self.text[at..].starts_with("&&") {
                parts.push(&self.text[start..at]);
                start = at + 2;
            }
        }
        parts.push(&self.text[start..]);
        parts.into_iter().map(Comparison::parse).collect()
    }

    /// Its value, if `quantity` gives the value of each name; NaN if a name has no value.
    pub fn value(&self, quantity: impl Fn(&str) -> Option<f64>) -> f64 {
        let values: Vec<f64> =
            self.names().iter().map(|name| quantity(name).unwrap_or(f64::NAN)).collect();
        // `max`, `||` and others would hide a NaN.
        if values.iter().any(|value| value.is_nan()) {
            return f64::NAN;
        }
        self.tree.eval(&values).unwrap_or(f64::NAN)
    }

    /// Whether it holds: its value is a number other than 0.
    pub fn holds(&self, quantity: impl Fn(&str) -> Option<f64>) -> bool {
        let value = self.value(quantity);
        !value.is_nan() && value != 0.0
    }
}

/// One of the conditions that a formula joins with `&&`.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The left side.
    pub left: Formula,
    /// One of `< <= > >= == !=`.
    pub sign: &'static str,
    /// The right side.
    pub right: Formula,
}

impl Comparison {
    /// The longer signs are first, because `<` begins `<=`.
    const SIGNS: [&'static str; 6] = ["<=", ">=", "==", "!=", "<", ">"];

    fn parse(text: &str) -> Option<Self> {
        let (at, sign) = outside_brackets(text).find_map(|at| {
            Some((at, *Self::SIGNS.iter().find(|sign| text[at..].starts_with(**sign))?))
        })?;
        let part = |text: &str| Formula::parse(text.trim()).ok();
        Some(Self { left: part(&text[..at])?, sign, right: part(&text[at + sign.len()..])? })
    }

    /// Whether it holds, if `quantity` gives the value of each name.
    pub fn holds(&self, quantity: impl Fn(&str) -> Option<f64>) -> bool {
        let (left, right) = (self.left.value(&quantity), self.right.value(&quantity));
        // No comparison with NaN holds, not even `!=`.
        let Some(order) = left.partial_cmp(&right) else { return false };
        match self.sign {
            "<=" => order.is_le(),
            ">=" => order.is_ge(),
            "==" => order.is_eq(),
            "!=" => order.is_ne(),
            "<" => order.is_lt(),
            _ => order.is_gt(),
        }
    }
}

/// Byte offsets of the characters of `text` outside of all brackets.
fn outside_brackets(text: &str) -> impl Iterator<Item = usize> {
    let mut depth = 0;
    text.char_indices().filter_map(move |(at, c)| {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        (depth == 0).then_some(at)
    })
}

/// A sentence with formulas in braces.
#[derive(Clone, Debug, Default)]
pub struct Sentence(Vec<Part>);

#[derive(Clone, Debug)]
enum Part {
    Words(String),
    Number(Formula),
}

impl Sentence {
    /// Reads a sentence.
    ///
    /// # Errors
    /// What is wrong with it, as a clause.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = Vec::new();
        let mut rest = text;
        while let Some((words, after)) = rest.split_once('{') {
            let Some((formula, after)) = after.split_once('}') else {
                return Err("a brace is not closed".to_owned());
            };
            parts.extend([Part::Words(words.to_owned()), Part::Number(Formula::parse(formula)?)]);
            rest = after;
        }
        parts.push(Part::Words(rest.to_owned()));
        Ok(Self(parts))
    }

    /// The formulas in it.
    pub fn formulas(&self) -> impl Iterator<Item = &Formula> {
        self.0.iter().filter_map(|part| match part {
            Part::Number(formula) => Some(formula),
            Part::Words(_) => None,
        })
    }

    /// The formulas of each part that ends with a period, a question mark or an exclamation mark.
    #[must_use]
    pub fn claims(&self) -> Vec<Vec<&Formula>> {
        let mut claims = vec![Vec::new()];
        for part in &self.0 {
            match part {
                Part::Number(formula) => claims.last_mut().expect("there is one").push(formula),
                Part::Words(words) if [". ", "? ", "! "].iter().any(|end| words.contains(end)) => {
                    claims.push(Vec::new());
                }
                Part::Words(_) => {}
            }
        }
        claims.retain(|claim| !claim.is_empty());
        claims
    }

    /// The sentence with the values of its formulas, as `written` writes them.
    pub fn filled(
        &self,
        quantity: impl Fn(&str) -> Option<f64>,
        written: impl Fn(f64) -> String,
    ) -> String {
        let part = |part: &Part| match part {
            Part::Words(words) => words.clone(),
            Part::Number(formula) => written(formula.value(&quantity)),
        };
        self.0.iter().map(part).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value of each formula with `v` and `v_most`, whether it holds, and the comparisons that it is made of.
    #[test]
    fn formulas_are_arithmetic_of_numbers_and_truth_is_1() {
        let quantity = |name: &str| match name {
            "v" => Some(1.5),
            "v_most" => Some(3.0),
            _ => None,
        };
        let part = |part: &Comparison| {
            let (left, right) = (part.left.text(), part.right.text());
            format!("{left} {} {right}: {}", part.sign, part.holds(quantity))
        };
        crate::answers("lesson/formulas.txt", |text| {
            let Ok(formula) = Formula::parse(text) else { return "refused".to_owned() };
            let (value, holds) = (formula.value(quantity), formula.holds(quantity));
            let parts =
                formula.comparisons().map(|parts| parts.iter().map(part).collect::<Vec<_>>());
            format!("{value:?} {holds} {parts:?}")
        });
        assert!(Formula::parse("").is_err() && Formula::parse(&"(".repeat(10_000)).is_err());
        assert!(Sentence::parse("fast: {v").is_err());
    }

    #[test]
    fn a_sentence_is_filled_with_its_numbers() {
        let sentence = Sentence::parse("It moves at {v} m/s, {v * 2} later.").unwrap();
        assert_eq!(
            sentence.filled(|_| Some(1.5), |v| v.to_string()),
            "It moves at 1.5 m/s, 3 later."
        );
        assert_eq!(sentence.formulas().count(), 2);
        let claims = |text: &str| {
            Sentence::parse(text).unwrap().claims().iter().map(Vec::len).collect::<Vec<_>>()
        };
        assert_eq!(claims("It moves at {v} m/s, {v * 2} later. Then {v}. Good."), [2, 1]);
        assert_eq!(claims("In 0.5 s: {v}, not {w}"), [2]);
        assert_eq!(claims("Nothing."), [0_usize; 0]);
    }
}
