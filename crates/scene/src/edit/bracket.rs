//! The places in the brackets of a RON text where entries can be added or removed.

use std::ops::Range;

use crate::text::tree::{Bracket, Item};

/// A piece of a text, by byte offsets, and what replaces it.
pub(super) type Piece = (Range<usize>, String);

impl Bracket<'_> {
    /// The name of the struct or variant before the bracket; empty without one.
    pub fn word<'a>(&self, text: &'a str) -> &'a str {
        let before = text[..self.inside.start - 1].trim_end();
        &before[before.trim_end_matches(|c: char| c.is_alphanumeric() || c == '_').len()..]
    }

    /// The index of a key among the items.
    pub fn index(&self, key: &str) -> Option<usize> {
        self.items.iter().position(|item| item.name == Some(key))
    }

    pub fn key(&self, key: &str) -> Option<&Item<'_>> {
        self.index(key).map(|index| &self.items[index])
    }

    /// Inserts `entries` after the last existing one of the keys `after`, or after the last item. Items that are
    /// `gone` do not count.
    pub fn insert(
        &self,
        text: &str,
        entries: &[String],
        after: &[&str],
        gone: &[usize],
    ) -> Vec<Piece> {
        let staying = (0..self.items.len()).rev().find(|index| !gone.contains(index));
        let last = staying.map(|index| &self.items[index]);
        let after = after
            .iter()
            .rev()
            .filter_map(|name| self.index(name))
            .find(|index| !gone.contains(index));
        let Some(anchor) = after.map(|index| &self.items[index]).or(last) else {
            if self.items.is_empty() {
                return vec![self.insert_first(text, entries)];
            }
            return vec![(self.inside.start..self.inside.start, entries.join(", "))];
        };
        let end = anchor.value.end;
        let Some((at, line_break, indent)) = anchor.own_line(text) else {
            return vec![(end..end, entries.iter().map(|entry| format!(", {entry}")).collect())];
        };
        let lines = entries.iter().map(|entry| format!("{line_break}{indent}{entry},")).collect();
        let comma = anchor.comma.is_none().then(|| (end..end, ",".to_owned()));
        comma.into_iter().chain([(at..at, lines)]).collect()
    }

    /// Inserts `entries` into a bracket without items: side by side in an empty group, otherwise each on a line of
    /// its own.
    fn insert_first(&self, text: &str, entries: &[String]) -> Piece {
        let inside = &text[self.inside.clone()];
        let filled = self.inside.start + inside.trim_end().len();
        if text[..self.inside.start].ends_with('(') && inside.trim().is_empty() {
            return (self.inside.clone(), entries.join(", "));
        }
        let line_break = line_break(text);
        let indent = indent_at(text, self.inside.start);
        let lines: String =
            entries.iter().map(|entry| format!("{line_break}{indent}    {entry},")).collect();
        (filled..self.inside.end, format!("{lines}{line_break}{indent}"))
    }

    /// The range of item `index` for its removal, with its comma and, if it is alone on its lines, these lines.
    pub fn remove(&self, text: &str, index: usize) -> Range<usize> {
        let item = &self.items[index];
        if let Some((end, line_break, indent)) = item.own_line(text) {
            return item.start - indent.len()..end + line_break.len();
        }
        if let Some(comma) = item.comma {
            let behind = &text[comma..self.inside.end];
            return item.start..comma + (behind.len() - behind.trim_start_matches(' ').len());
        }
        // Removes the comma before the item, unless a comment is between.
        let before = index.checked_sub(1).map(|before| self.items[before].value.end);
        let start = before.filter(|end| text[*end..item.start].trim_matches([' ', ',']).is_empty());
        start.unwrap_or(item.start)..item.value.end
    }
}

impl Item<'_> {
    /// If the item is alone on its lines: the end of the last line, its line break, and the indent.
    pub fn own_line<'a>(&self, text: &'a str) -> Option<(usize, &'a str, &'a str)> {
        let line = text[..self.start].rfind('\n')? + 1;
        let indent = &text[line..self.start];
        let end = self.comma.unwrap_or(self.value.end);
        let rest = text[end..].split_inclusive('\n').next()?;
        let content = rest.trim_end_matches(['\r', '\n']);
        let line_break = &rest[content.len()..];
        let behind = content.trim_start();
        let alone = indent.trim().is_empty() && (behind.is_empty() || behind.starts_with("//"));
        (alone && !line_break.is_empty()).then_some((end + content.len(), line_break, indent))
    }
}

/// The line break of a text.
pub(super) fn line_break(text: &str) -> &'static str {
    if text.contains("\r\n") { "\r\n" } else { "\n" }
}

/// The white space at the start of the line that contains offset `at`.
pub(super) fn indent_at(text: &str, at: usize) -> &str {
    let line = &text[text[..at].rfind('\n').map_or(0, |end| end + 1)..at];
    &line[..line.len() - line.trim_start().len()]
}
