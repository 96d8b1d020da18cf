//! The keys of one group of a RON text, and how a key is put in or given another value.

use std::ops::Range;

use crate::edit::Change;
use crate::text::locate::{Token, Tokens};

/// A group `(key: value, ...)`; places are byte offsets in the text.
pub(super) struct Group {
    /// Behind its opening bracket.
    start: usize,
    keys: Vec<Key>,
}

struct Key {
    name: String,
    start: usize,
    value: Range<usize>,
}

/// Keys of a scene behind the last of which its method stands, in the order of the format.
const BEFORE_METHOD: [&str; 5] = ["version", "name", "description", "step_hz", "step"];

impl Group {
    /// The group that begins at `offset`, with the name of a struct or variant or without.
    pub fn at(text: &str, offset: usize) -> Option<Self> {
        let tokens = Tokens::new(&text[offset..]);
        let mut tokens =
            tokens.map(|(token, range)| (token, range.start + offset..range.end + offset)).peekable();
        tokens.next_if(|(token, _)| *token == Token::Word);
        let (_, open) = tokens.next_if(|(token, _)| *token == Token::Open)?;
        let (mut keys, mut depth) = (Vec::<Key>::new(), 1_usize);
        while let Some((token, range)) = tokens.next() {
            match token {
                Token::Open => depth += 1,
                Token::Close if depth == 1 => return Some(Self { start: open.end, keys }),
                Token::Close => depth -= 1,
                Token::Comma if depth == 1 => continue,
                Token::Word
                    if depth == 1 && tokens.next_if(|(token, _)| *token == Token::Colon).is_some() =>
                {
                    let name = &text[range.clone()];
                    let name = name.strip_prefix("r#").unwrap_or(name).to_owned();
                    keys.push(Key { name, start: range.start, value: range.end..range.end });
                    continue;
                }
                _ => {}
            }
            if let Some(Key { value, .. }) = keys.last_mut() {
                *value = if value.start == value.end { range } else { value.start..range.end };
            }
        }
        None
    }

    /// Adds the edits that give the group the method and substeps of `change`; `inherited` holds without them.
    pub fn set(
        &self,
        text: &str,
        change: &Change,
        inherited: (motion::Method, u32),
        edits: &mut Vec<(Range<usize>, String)>,
    ) {
        let (method, substeps) = (change.method.name().to_owned(), change.substeps.to_string());
        let values = [
            ("method", method, change.method == inherited.0),
            ("substeps", substeps, change.substeps == inherited.1),
        ];
        let mut absent = Vec::new();
        for (name, value, holds_anyway) in values {
            match self.key(name) {
                Some(key) => edits.push((key.value.clone(), value)),
                None if holds_anyway => {}
                None => absent.push(format!("{name}: {value}")),
            }
        }
        if !absent.is_empty() {
            edits.push(self.insertion(text, &absent, change.path.is_none()));
        }
    }

    fn key(&self, name: &str) -> Option<&Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// Puts entries behind the key that they belong to: on lines of their own where that has one, else on its line.
    fn insertion(&self, text: &str, entries: &[String], is_scene: bool) -> (Range<usize>, String) {
        let pair = self.key("method").or_else(|| self.key("substeps"));
        let of_scene = || BEFORE_METHOD.iter().rev().find_map(|name| self.key(name)).filter(|_| is_scene);
        let Some(anchor) = pair.or_else(of_scene).or(self.keys.last()) else {
            return (self.start..self.start, entries.join(", "));
        };
        let end = anchor.value.end;
        anchor.own_line(text).map_or_else(
            || (end..end, entries.iter().map(|entry| format!(", {entry}")).collect()),
            |(at, line_break, indent)| {
                let lines = entries.iter().map(|entry| format!("{line_break}{indent}{entry},"));
                (at..at, lines.collect())
            },
        )
    }
}

impl Key {
    /// Where the key stands alone on its line: the end of the line, the characters that break it, and its indent.
    fn own_line<'a>(&self, text: &'a str) -> Option<(usize, &'a str, &'a str)> {
        let line = text[..self.start].rfind('\n')? + 1;
        let indent = &text[line..self.start];
        let rest = text[self.value.end..].split_inclusive('\n').next()?;
        let content = rest.trim_end_matches(['\r', '\n']);
        let line_break = &rest[content.len()..];
        let behind = content.trim_start().strip_prefix(',')?.trim_start();
        let alone = indent.trim().is_empty() && (behind.is_empty() || behind.starts_with("//"));
        (alone && !line_break.is_empty()).then_some((self.value.end + content.len(), line_break, indent))
    }
}
