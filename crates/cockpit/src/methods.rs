//! Methods of integration in words: lists, panels, plans and docs/methods.md show the claims through this module.

use motion::{Claims, METHODS, Method};
use report::numbers::json_number as number;
use serde_json::{Value, json};

/// A column of the table of methods.
pub struct Column {
    /// Its name in JSON.
    pub name: &'static str,
    /// Its heading for people.
    pub heading: &'static str,
    cell: fn(&Claims) -> Cell,
}

enum Cell {
    Text(&'static str),
    Count(u32),
    Flag(bool),
    Limit(f64),
}

const fn column(name: &'static str, heading: &'static str, cell: fn(&Claims) -> Cell) -> Column {
    Column { name, heading, cell }
}

/// Every column; the longest last, where a narrow terminal cuts least.
pub const COLUMNS: [Column; 13] = [
    column("method", "method", |claims| Cell::Text(claims.name)),
    column("title", "title", |claims| Cell::Text(claims.title)),
    column("position_order", "order x", |claims| Cell::Count(claims.position_order)),
    column("velocity_order", "order v", |claims| Cell::Count(claims.velocity_order)),
    column("order_with_velocity_laws", "order under v", |claims| {
        Cell::Count(claims.order_with_velocity_laws)
    }),
    column("evaluations", "evals", |claims| Cell::Count(claims.evaluations)),
    column("evaluations_with_velocity_laws", "evals under v", |claims| {
        Cell::Count(claims.evaluations_with_velocity_laws)
    }),
    column("start_up_evaluations", "evals at start", |claims| {
        Cell::Count(claims.start_up_evaluations)
    }),
    column("stability_limit", "stable", |claims| Cell::Limit(claims.stability_limit)),
    column("symplectic", "symplectic", |claims| Cell::Flag(claims.symplectic)),
    column("reversible", "reversible", |claims| Cell::Flag(claims.reversible)),
    column("source", "source", |claims| Cell::Text(claims.source)),
    column("damping", "damping", |claims| Cell::Text(claims.damping)),
];

impl Column {
    /// The cell of a method, for programs.
    pub fn value(&self, claims: &Claims) -> Value {
        match (self.cell)(claims) {
            Cell::Text(text) => json!(text),
            Cell::Count(count) => json!(count),
            Cell::Flag(flag) => json!(flag),
            Cell::Limit(limit) => number(limit),
        }
    }

    /// The cell of a method, for people.
    pub fn text(&self, claims: &Claims) -> String {
        match (self.cell)(claims) {
            Cell::Text(text) => text.to_owned(),
            Cell::Count(count) => count.to_string(),
            Cell::Flag(flag) => yes_or_no(flag).to_owned(),
            Cell::Limit(_) => stable(claims),
        }
    }
}

pub(crate) const fn yes_or_no(flag: bool) -> &'static str {
    if flag { "yes" } else { "no" }
}

/// The steps of h seconds for which `x'' = -w² x` stays bounded, in words.
pub(crate) fn stable(claims: &Claims) -> String {
    match claims.stability_limit {
        0.0 => "never".to_owned(),
        f64::INFINITY => "always".to_owned(),
        limit => format!("w h < {}", (limit * 1e3).floor() / 1e3),
    }
}

/// A method in one line.
pub(crate) fn line(method: Method) -> String {
    let claims = method.claims();
    format!(
        "{}: order {} in position, {} in velocity; stable: {}",
        claims.title,
        claims.position_order,
        claims.velocity_order,
        stable(claims)
    )
}

/// Evaluations per step of a method.
pub fn cost(claims: &Claims) -> String {
    let Claims { evaluations, evaluations_with_velocity_laws: under_v, .. } = *claims;
    let plural = if evaluations == 1 { "" } else { "s" };
    let more = if under_v == evaluations {
        String::new()
    } else {
        format!(", {under_v} under laws of the velocity")
    };
    format!("{evaluations} evaluation{plural} per step{more}")
}

/// The table in Markdown, as docs/methods.md has it: all columns but the last, which is a sentence.
#[must_use]
pub fn markdown() -> String {
    let columns = &COLUMNS[..COLUMNS.len() - 1];
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut table = row(columns.iter().map(|column| column.heading.to_owned()).collect());
    table += &row(columns.iter().map(|_| "---".to_owned()).collect());
    for claims in METHODS {
        let cells = columns.iter().map(|column| column.text(claims));
        table += &row(cells
            .enumerate()
            .map(|(i, text)| if i == 0 { format!("`{text}`") } else { text })
            .collect());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_stability_are_words_and_never_promise_more_than_the_claim() {
        let words = Method::ALL.map(|method| stable(method.claims()));
        assert_eq!(words[..3], ["never", "w h < 2", "always"]);
        assert_eq!(stable(Method::RungeKutta4.claims()), "w h < 2.828");
        assert_eq!(stable(Method::Yoshida4.claims()), "w h < 1.573");
    }
}
