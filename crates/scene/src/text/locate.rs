//! Finds the place of a key path in a text, and the path at a place.

use std::collections::{HashMap, HashSet};

use super::tokens::{Token, Tokens};
use super::tree::scan;

/// A place in a text as an editor counts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Position {
    /// From 1.
    pub line: usize,
    /// In characters, from 1.
    pub column: usize,
}

/// The positions of byte offsets that are given in ascending order.
pub(crate) fn positions(text: &str, ascending: &[usize]) -> Vec<Position> {
    let (mut line, mut line_start, mut scanned) = (1, 0, 0);
    let mut found = Vec::with_capacity(ascending.len());
    for &offset in ascending {
        let offset = offset.min(text.len());
        for (i, _) in
            text.as_bytes()[scanned..offset].iter().enumerate().filter(|(_, byte)| **byte == b'\n')
        {
            line += 1;
            line_start = scanned + i + 1;
        }
        scanned = offset;
        let column = 1 + text.get(line_start..offset).map_or(0, |before| before.chars().count());
        found.push(Position { line, column });
    }
    found
}

/// The byte offset of a line and column, both from 1; the end of the text if it is shorter.
pub(crate) fn offset_of(text: &str, at: Position) -> usize {
    let start: usize =
        text.split_inclusive('\n').take(at.line.saturating_sub(1)).map(str::len).sum();
    let rest = &text[start..];
    start + rest.char_indices().nth(at.column.saturating_sub(1)).map_or(rest.len(), |(i, _)| i)
}

/// The byte offset of each path, or of its nearest ancestor that is written in the text.
pub(crate) fn offsets(text: &str, root: &str, paths: &[&str]) -> Vec<Option<usize>> {
    let upwards = |path| std::iter::successors(Some(path), |&path| parent(path));
    let wanted: HashSet<&str> = paths.iter().copied().flat_map(upwards).collect();
    let mut written = HashMap::new();
    if !wanted.is_empty() {
        scan(text, root, |path, offset| {
            if let Some(path) = wanted.get(path) {
                written.entry(*path).or_insert(offset);
            }
            false
        });
    }
    paths.iter().map(|path| upwards(*path).find_map(|path| written.get(path).copied())).collect()
}

/// The line of each path as [`offsets`] finds it, from 1.
pub(crate) fn lines(text: &str, paths: &[&str]) -> Vec<Option<usize>> {
    let offsets = offsets(text, "", paths);
    let mut ascending: Vec<usize> = offsets.iter().copied().flatten().collect();
    ascending.sort_unstable();
    let positions = positions(text, &ascending);
    let line = |offset| ascending.binary_search(&offset).ok().map(|i| positions[i].line);
    offsets.into_iter().map(|offset| offset.and_then(line)).collect()
}

/// The path of the value that contains, or is the last to begin before, a byte offset.
pub(crate) fn path_at(text: &str, root: &str, offset: usize) -> String {
    let mut last = String::new();
    scan(text, root, |path, start| {
        if start <= offset {
            path.clone_into(&mut last);
        }
        false
    });
    last
}

/// The text with the bare word `nan` spelled `NaN`, as RON has it; offsets stay as they are.
pub(crate) fn spell_nan(text: &str) -> String {
    let mut spelled = text.to_owned();
    if !text.contains("nan") {
        return spelled;
    }
    for (token, range) in Tokens::new(text) {
        if token == Token::Word && matches!(&text[range.clone()], "nan" | "-nan" | "+nan") {
            spelled.replace_range(range.end - 3..range.end, "NaN");
        }
    }
    spelled
}

/// Whether the outermost value of the text is a group in round brackets, which may have the name of its type before it.
pub(crate) fn is_group(text: &str, type_name: &str) -> bool {
    let mut tokens = Tokens::new(text)
        .skip_while(|(token, range)| *token == Token::Word && text[range.clone()] == *type_name);
    tokens.next().is_some_and(|(_, range)| text[range].starts_with('('))
}

/// The path of the group or list that has the value at `path`.
fn parent(path: &str) -> Option<&str> {
    if path.is_empty() { None } else { Some(&path[..path.rfind(['.', '[']).unwrap_or(0)]) }
}

#[cfg(test)]
mod tests;
