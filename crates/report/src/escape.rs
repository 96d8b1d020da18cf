//! Escapes text of files for terminals, pages, Markdown and tables of other programs, so that no part of it is
//! interpreted.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Escapes text for a terminal: line breaks stay, and characters that would control the terminal or change the
/// direction of writing are spelled out, as `\u{1b}`.
pub fn terminal(text: &str) -> Cow<'_, str> {
    let steers = |c: char| {
        c != '\n' && c.is_control()
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        if steers(c) {
            let _ = write!(escaped, "{}", c.escape_unicode());
        } else {
            escaped.push(c);
        }
    }
    Cow::Owned(escaped)
}

/// Escapes text within a line of Markdown: it adds no tags, links or cells. Emphasis and code stay, because our own
/// cells have them.
pub(crate) fn markdown(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => escaped.push_str("&lt;"),
            '&' => escaped.push_str("&amp;"),
            '\\' | '|' | '[' | ']' => escaped.extend(['\\', c]),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Escapes text between tags and in attributes of HTML and SVG.
pub(crate) fn html(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // No XML document may hold these.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Escapes a field of comma-separated values (RFC 4180). Text that is not a number but that a spreadsheet would
/// compute gets an apostrophe in front, so that spreadsheets take it as text.
pub(crate) fn csv_field(text: &str) -> String {
    let computed =
        text.starts_with(['=', '+', '-', '@', '\t', '\r']) && text.parse::<f64>().is_err();
    let text = if computed { format!("'{text}") } else { text.to_owned() };
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_terminal_gets_lines_and_no_commands() {
        assert_eq!(
            terminal("a\u{1b}]0;title\u{7}b\r\nc\u{9b}2J"),
            "a\\u{1b}]0;title\\u{7}b\\u{d}\nc\\u{9b}2J"
        );
        assert_eq!(terminal("\u{202e}fdp.exe"), "\\u{202e}fdp.exe");
        let plain = "Größe 3 µm, x\u{308}, 質量\n";
        assert!(matches!(terminal(plain), Cow::Borrowed(text) if text == plain));
    }

    #[test]
    fn markdown_has_no_tags_links_or_cells_of_the_text() {
        assert_eq!(markdown("<b>|[x](y)\n"), "&lt;b>\\|\\[x\\](y) ");
        assert_eq!(markdown("**bounded**, `yoshida_4` x 32"), "**bounded**, `yoshida_4` x 32");
    }

    #[test]
    fn a_spreadsheet_computes_nothing() {
        assert_eq!(csv_field("=HYPERLINK(\"x\",\"y\")"), "\"'=HYPERLINK(\"\"x\"\",\"\"y\"\")\"");
        assert_eq!(csv_field("-2+3"), "'-2+3");
        assert_eq!(
            ["-1.5e-3", "+inf", "3", "a b", ""].map(csv_field),
            ["-1.5e-3", "+inf", "3", "a b", ""]
        );
    }
}
