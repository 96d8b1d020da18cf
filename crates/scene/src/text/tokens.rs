//! The tokens of a RON text, with their places.

use std::ops::Range;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Token {
    Open,
    Close,
    Comma,
    /// A word before a colon; the colon belongs to it.
    Key,
    /// A colon behind anything else.
    Colon,
    /// An identifier or a number.
    Word,
    /// A string or a character.
    Literal,
}

/// The tokens of a RON text; comments and document attributes are skipped.
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
                            || matches!(
                                c,
                                '('..=')' | '[' | ']' | '{' | '}' | ',' | ':' | '"' | '\'' | '/'
                            )
                    };
                    let length = rest
                        .char_indices()
                        .skip(1)
                        .find(|(_, c)| end(*c))
                        .map_or(rest.len(), |(i, _)| i);
                    (Token::Word, length)
                }
            },
        };
        self.at += length;
        let range = start..self.at;
        if token == Token::Word {
            self.skip_blank();
            if self.rest().starts_with(':') {
                self.at += 1;
                return Some((Token::Key, range));
            }
        }
        Some((token, range))
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
