//! Where in a RON text a key path is: a scanner beside the parser, which keeps no positions.

use std::collections::{HashMap, HashSet};
use std::iter::Peekable;
use std::ops::Range;

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
        for (i, _) in text.as_bytes()[scanned..offset].iter().enumerate().filter(|(_, byte)| **byte == b'\n')
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
    let start: usize = text.split_inclusive('\n').take(at.line.saturating_sub(1)).map(str::len).sum();
    let rest = &text[start..];
    start + rest.char_indices().nth(at.column.saturating_sub(1)).map_or(rest.len(), |(i, _)| i)
}

/// The byte offset of each path, or of its nearest ancestor that is written in the text.
pub(crate) fn offsets(text: &str, root: &str, paths: &[&str]) -> Vec<Option<usize>> {
    let upwards = |path| std::iter::successors(Some(path), |&path| parent(path));
    let written = written(text, root, paths.iter().copied().flat_map(upwards));
    paths.iter().map(|path| upwards(*path).find_map(|path| written.get(path).copied())).collect()
}

/// The byte offset of each of `paths` that is written in the text.
pub(crate) fn written<'p>(
    text: &str,
    root: &str,
    paths: impl IntoIterator<Item = &'p str>,
) -> HashMap<&'p str, usize> {
    let wanted: HashSet<&'p str> = paths.into_iter().collect();
    let mut found = HashMap::new();
    if wanted.is_empty() {
        return found;
    }
    walk(text, root, |path, offset| {
        if let Some(path) = wanted.get(path) {
            found.entry(*path).or_insert(offset);
        }
    });
    found
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
    walk(text, root, |path, start| {
        if start <= offset {
            path.clone_into(&mut last);
        }
    });
    last
}

/// The text with the bare word `nan` spelled `NaN`, as RON has it; offsets stay as they are.
pub(crate) fn spell_nan(text: &str) -> String {
    let mut spelled = text.to_owned();
    let mut tokens = Tokens::new(text).peekable();
    while let Some((token, range)) = tokens.next() {
        let word = &text[range.clone()];
        if token == Token::Word && matches!(word, "nan" | "-nan" | "+nan") && !is_colon(&mut tokens) {
            spelled.replace_range(range.end - 3..range.end, "NaN");
        }
    }
    spelled
}

/// Whether the outermost value of the text is a group in round brackets, which may have the name of its type before it.
pub(crate) fn is_group(text: &str, type_name: &str) -> bool {
    let mut tokens = Tokens::new(text).skip_while(|(_, range)| text[range.clone()] == *type_name);
    matches!(tokens.next(), Some((Token::Open, range)) if text[range.clone()].starts_with('('))
}

fn parent(path: &str) -> Option<&str> {
    if path.is_empty() { None } else { Some(&path[..path.rfind(['.', '[']).unwrap_or(0)]) }
}

fn is_colon(tokens: &mut Peekable<Tokens<'_>>) -> bool {
    matches!(tokens.peek(), Some((Token::Colon, _)))
}

/// Brackets deep to which paths are followed: more than the parser accepts. Without a bound, the paths of a text
/// of nothing but brackets take quadratic time.
const DEEPEST: usize = 160;

/// Calls `visit` with the path and byte offset of every key and value, in the order of the text. Text that is
/// not RON gives paths of no meaning, never a panic.
fn walk(text: &str, root: &str, mut visit: impl FnMut(&str, usize)) {
    struct Frame {
        path_length: usize,
        index: usize,
    }
    let mut path = root.to_owned();
    let mut frames: Vec<Frame> = Vec::new();
    // Whether the path of the coming value is set, because a key or the name of a variant precedes it.
    let mut announced = false;
    let mut tokens = Tokens::new(text).peekable();
    while let Some((token, range)) = tokens.next() {
        let is_key = token == Token::Word && is_colon(&mut tokens);
        let is_value = matches!(token, Token::Open | Token::Word | Token::Literal) && !announced;
        if (is_key || is_value) && frames.len() <= DEEPEST {
            path.truncate(frames.last().map_or(root.len(), |frame| frame.path_length));
            if is_key {
                if !path.is_empty() {
                    path.push('.');
                }
                let word = &text[range.clone()];
                path.push_str(word.strip_prefix("r#").unwrap_or(word));
            } else if let Some(frame) = frames.last() {
                path.push_str(&format!("[{}]", frame.index));
            }
            visit(&path, range.start);
        }
        match token {
            Token::Open => {
                frames.push(Frame { path_length: path.len(), index: 0 });
                announced = false;
            }
            Token::Close => {
                frames.pop();
                announced = false;
            }
            Token::Comma => {
                if let Some(frame) = frames.last_mut() {
                    frame.index += 1;
                }
                announced = false;
            }
            Token::Colon => {}
            Token::Word => announced = is_key || matches!(tokens.peek(), Some((Token::Open, _))),
            Token::Literal => announced = false,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Token {
    Open,
    Close,
    Comma,
    Colon,
    /// An identifier or a number.
    Word,
    /// A string or a character.
    Literal,
}

/// The tokens of a RON text; comments and document attributes are passed over.
pub(crate) struct Tokens<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Tokens<'a> {
    pub fn new(text: &'a str) -> Self {
        let mut tokens = Self { text, at: 0 };
        tokens.skip_blank();
        while tokens.rest().starts_with("#!") {
            tokens.at += tokens.rest().find(']').map_or(tokens.rest().len(), |end| end + 1);
            tokens.skip_blank();
        }
        tokens
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn skip_blank(&mut self) {
        loop {
            let rest = self.rest();
            let word = rest.trim_start_matches(is_blank);
            self.at += rest.len() - word.len();
            if word.starts_with("//") {
                self.at += word.find('\n').unwrap_or(word.len());
            } else if word.starts_with("/*") {
                self.at += block_comment_length(word);
            } else {
                return;
            }
        }
    }
}

impl Iterator for Tokens<'_> {
    type Item = (Token, Range<usize>);

    fn next(&mut self) -> Option<Self::Item> {
        self.skip_blank();
        let (rest, start) = (self.rest(), self.at);
        let first = rest.chars().next()?;
        let (token, length) = match first {
            '(' | '[' | '{' => (Token::Open, 1),
            ')' | ']' | '}' => (Token::Close, 1),
            ',' => (Token::Comma, 1),
            ':' => (Token::Colon, 1),
            '"' | '\'' => (Token::Literal, quoted_length(rest, first)),
            _ => match raw_string_length(rest) {
                Some(length) => (Token::Literal, length),
                None => {
                    let end = |c: char| {
                        is_blank(c)
                            || matches!(c, '('..=')' | '[' | ']' | '{' | '}' | ',' | ':' | '"' | '\'' | '/')
                    };
                    let length =
                        rest.char_indices().skip(1).find(|(_, c)| end(*c)).map_or(rest.len(), |(i, _)| i);
                    (Token::Word, length)
                }
            },
        };
        self.at += length;
        Some((token, start..self.at))
    }
}

/// White space as RON has it: Unicode's, and the two direction marks.
fn is_blank(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\u{200E}' | '\u{200F}')
}

/// Length of the quoted text at the start of `rest`, to the end of the text if it is not closed.
fn quoted_length(rest: &str, quote: char) -> usize {
    let mut escaped = false;
    for (i, c) in rest.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == quote => return i + 1,
            _ => {}
        }
    }
    rest.len()
}

/// Length of the raw string at the start of `rest`, if there is one.
fn raw_string_length(rest: &str) -> Option<usize> {
    let after = rest.strip_prefix("br").or_else(|| rest.strip_prefix('r'))?;
    let hashes = after.len() - after.trim_start_matches('#').len();
    let body = after[hashes..].strip_prefix('"')?;
    let close = format!("\"{}", "#".repeat(hashes));
    let open = rest.len() - body.len();
    Some(body.find(&close).map_or(rest.len(), |end| open + end + close.len()))
}

/// Length of the block comment at the start of `rest`; they nest.
fn block_comment_length(rest: &str) -> usize {
    let (mut depth, mut at) = (0_usize, 0);
    while at < rest.len() {
        if rest.as_bytes()[at..].starts_with(b"/*") {
            depth += 1;
            at += 2;
        } else if rest.as_bytes()[at..].starts_with(b"*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    rest.len()
}

#[cfg(test)]
mod tests;
