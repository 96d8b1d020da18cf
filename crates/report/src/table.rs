//! Tables: on a page, in Markdown, on a terminal, and as comma-separated values.

use crate::escape::{csv_field, html, markdown};

/// Rows of text under a row of headings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// Headings of the columns.
    pub header: Vec<String>,
    /// Cells, one per column.
    pub rows: Vec<Vec<String>>,
    /// Whether all but the first column are numbers, which are aligned to the right.
    pub numbers: bool,
}

impl Table {
    /// A table of numbers.
    pub(crate) fn numbers<H: Into<String>>(
        title: impl Into<String>,
        header: impl IntoIterator<Item = H>,
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Self {
        let header = header.into_iter().map(Into::into).collect();
        Self { title: title.into(), header, rows: rows.into_iter().collect(), numbers: true }
    }

    /// A table of words.
    pub(crate) fn words<H: Into<String>>(
        title: impl Into<String>,
        header: impl IntoIterator<Item = H>,
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Self {
        Self { numbers: false, ..Self::numbers(title, header, rows) }
    }

    /// The table as HTML, without its title.
    pub(crate) fn html(&self) -> String {
        let cells = |tag: &str, row: &[String]| -> String {
            row.iter().map(|value| format!("<{tag}>{}</{tag}>", joined(&html(value)))).collect()
        };
        let rows: String =
            self.rows.iter().map(|row| format!("<tr>{}</tr>\n", cells("td", row))).collect();
        format!(
            "<div class=\"wide\"><table class=\"{}\">\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
            if self.numbers { "numbers" } else { "plain" },
            cells("th", &self.header)
        )
    }

    /// The table in Markdown, without its title.
    pub fn markdown(&self) -> String {
        let line = |row: &[String]| {
            let cells: Vec<_> = row.iter().map(|cell| markdown(cell)).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        format!("{}|{}\n{rows}", line(&self.header), " --- |".repeat(self.header.len()))
    }

    /// The table for a terminal, without its title, in aligned columns: words to the left and numbers to the right.
    pub fn aligned(&self) -> String {
        let rows: Vec<_> = std::iter::once(&self.header).chain(&self.rows).cloned().collect();
        aligned(&rows, self.numbers)
    }
}

/// A cell whose lines end neither before a percent sign nor inside `(x 4)`.
fn joined(html: &str) -> String {
    html.replace(" %", "&nbsp;%").replace("(x ", "(x&nbsp;")
}

/// Rows in aligned columns: all to the left, or all but the first one to the right.
pub fn aligned(rows: &[Vec<String>], to_the_right: bool) -> String {
    let width =
        |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<_> = (0..rows.first().map_or(0, Vec::len)).map(width).collect();
    let padded = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (value, width))| {
            if column > 0 && to_the_right {
                format!("{value:>width$}")
            } else {
                format!("{value:<width$}")
            }
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(padded).collect()
}

/// Rows under a header as CSV (RFC 4180).
pub fn csv(header: &str, rows: impl Iterator<Item = Vec<String>>) -> String {
    header.to_owned() + "\n" + &rows.map(csv_line).collect::<String>()
}

/// A row as CSV (RFC 4180).
pub fn csv_line(fields: impl IntoIterator<Item = String>) -> String {
    fields.into_iter().map(|field| csv_field(&field)).collect::<Vec<_>>().join(",") + "\n"
}
