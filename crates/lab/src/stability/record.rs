//! The matrix as plain data, written as JSON and read again.

use motion::Method;
use serde::{Deserialize, Serialize};

use super::class::Class;

/// [`Matrix::format`] of this program.
pub const FORMAT: u32 = 2;

/// Longer runs also keep their state after this many ticks, so that tests can repeat the first part alone.
pub const PREFIX: u64 = 20_000;

/// The survival matrix: every method on every case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Matrix {
    /// Version of this format.
    pub format: u32,
    /// The rows, in the order of cases and of their rows.
    pub rows: Vec<CaseRow>,
}

/// One row of a case, with a cell per method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseRow {
    /// Name of the scene.
    pub case: String,
    /// One line about it.
    pub description: String,
    /// The label that tells the row from others of the scene; empty for a single row.
    pub label: String,
    /// What the numbers measure: the name of a [`scene::Measure`].
    pub measure: String,
    /// Length of a run, ticks.
    pub ticks: u64,
    /// The cells, one per method, in the order of the methods.
    pub cells: Vec<Cell>,
}

impl CaseRow {
    /// The case and the label as one title.
    pub fn title(&self) -> String {
        if self.label.is_empty() {
            self.case.clone()
        } else {
            format!("{}: {}", self.case, self.label)
        }
    }

    /// The cell of `method`.
    pub fn cell(&self, method: Method) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.method == method)
    }
}

/// The result of one method on one row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// The method.
    pub method: Method,
    /// The class of the run.
    pub class: Class,
    /// The number that decided, with its sign; NaN if the method was refused.
    #[serde(with = "number")]
    pub number: f64,
    /// The bound on its magnitude; NaN if the method was refused.
    #[serde(with = "number")]
    pub bound: f64,
    /// Why it ended early or was refused, or another note; may be empty.
    pub why: String,
    /// Its class after [`PREFIX`] ticks, for longer runs.
    pub prefix: Option<Prefix>,
}

/// The class of the first part of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prefix {
    /// Its class.
    pub class: Class,
    /// The number that decided.
    #[serde(with = "number")]
    pub number: f64,
}

impl Matrix {
    /// As JSON; numbers that are not finite are the strings `"nan"`, `"inf"` and `"-inf"`.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a matrix is plain data") + "\n"
    }
}

mod number {
    use serde::{Deserialize, Deserializer, Serializer, de};

    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Written {
        Number(f64),
        Word(String),
    }

    pub fn serialize<S: Serializer>(number: &f64, to: S) -> Result<S::Ok, S::Error> {
        match number {
            number if number.is_finite() => to.serialize_f64(*number),
            number if number.is_nan() => to.serialize_str("nan"),
            number => to.serialize_str(&number.to_string()),
        }
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        match Written::deserialize(from)? {
            Written::Number(number) => Ok(number),
            Written::Word(word) => {
                word.parse().map_err(|_| de::Error::custom(format!("`{word}` is not a number")))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_read_as_it_was_written() {
        let cell = |number, prefix| Cell {
            method: Method::Yoshida4,
            class: Class::Explodes,
            number,
            bound: 1e3,
            why: "because".to_owned(),
            prefix,
        };
        let prefix = Some(Prefix { class: Class::Exact, number: 1.5e-30 });
        let row = CaseRow {
            case: "case".to_owned(),
            description: String::new(),
            label: "label".to_owned(),
            measure: "rest".to_owned(),
            ticks: 7,
            cells: vec![
                cell(f64::INFINITY, prefix),
                cell(f64::NEG_INFINITY, None),
                cell(-0.25, None),
            ],
        };
        assert_eq!(row.title(), "case: label");
        let matrix = Matrix { format: FORMAT, rows: vec![row] };
        assert_eq!(serde_json::from_str::<Matrix>(&matrix.json()).unwrap(), matrix);
        let nan = matrix.json().replace("-0.25", "\"nan\"");
        assert!(serde_json::from_str::<Matrix>(&nan).unwrap().rows[0].cells[2].number.is_nan());
    }
}
