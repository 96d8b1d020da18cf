//! Finds the values of a RON text in one scan beside the parser, which does not keep their places.

use std::collections::{BTreeMap, HashSet};
use std::fmt::Write as _;
use std::ops::Range;

use super::tokens::{Token, Tokens};

/// Groups and lists of a text by their paths, as in `bodies[3]`; the path of the outermost value is that of the root.
pub(crate) type Tree<'a> = BTreeMap<String, Bracket<'a>>;

/// A group `(key: value, ...)` or a list `[value, ...]`. Places are byte offsets of the text.
#[derive(Debug)]
pub(crate) struct Bracket<'a> {
    /// From the end of the opening bracket to the start of the closing one.
    pub inside: Range<usize>,
    pub items: Vec<Item<'a>>,
}

/// A value in brackets, with its key if it has one.
#[derive(Debug)]
pub(crate) struct Item<'a> {
    pub name: Option<&'a str>,
    /// Start of the key, or of a value without a key.
    pub start: usize,
    pub value: Range<usize>,
    /// End of the comma after it.
    pub comma: Option<usize>,
}

/// Depth of brackets up to which paths are followed, more than the parser accepts. Without a limit, the paths of a
/// text of nothing but brackets take quadratic time.
const DEEPEST: usize = 160;

/// Reads a text whose outermost value is called `root` in paths. Calls `asks` with the path and byte offset of every
/// key and value, in the order of the text; the tree has the groups and lists for which `asks` returns true. Text
/// that is not RON gives meaningless paths, but never a panic.
pub(crate) fn scan<'a>(
    text: &'a str,
    root: &str,
    mut asks: impl FnMut(&str, usize) -> bool,
) -> Tree<'a> {
    /// Brackets that are not closed yet, or the whole text.
    struct Frame<'a> {
        path_length: usize,
        /// Index of the next item.
        index: usize,
        /// Its entry in the tree, if it is asked for.
        bracket: Option<Bracket<'a>>,
    }
    let (mut tree, mut path, mut asked) = (Tree::new(), root.to_owned(), false);
    let mut frame = Frame { path_length: root.len(), index: 0, bracket: None };
    let mut outer: Vec<Frame<'_>> = Vec::new();
    // Open brackets beyond the deepest that are followed.
    let mut deeper = 0_usize;
    // Whether the path of the coming value is set, because a key or the name of a variant precedes it.
    let mut announced = false;
    let mut tokens = Tokens::new(text).peekable();
    while let Some((token, range)) = tokens.next() {
        let is_value = matches!(token, Token::Open | Token::Word | Token::Literal);
        if deeper == 0 && (token == Token::Key || is_value && !announced) {
            path.truncate(frame.path_length);
            let (mut name, mut value) = (None, range.clone());
            if token == Token::Key {
                let key = &text[range.clone()];
                let key = key.strip_prefix("r#").unwrap_or(key);
                path.push_str(if path.is_empty() { "" } else { "." });
                path.push_str(key);
                (name, value.start) = (Some(key), range.end);
            } else if !outer.is_empty() {
                // Writing into a string cannot fail.
                let _ = write!(path, "[{}]", frame.index);
            }
            asked = asks(&path, range.start);
            if let Some(bracket) = &mut frame.bracket {
                bracket.items.push(Item { name, start: range.start, value, comma: None });
            }
        } else if is_value {
            reach(&mut frame.bracket, &range);
        }
        if token != Token::Colon {
            announced = token == Token::Key
                || token == Token::Word && matches!(tokens.peek(), Some((Token::Open, _)));
        }
        match token {
            Token::Open if outer.len() < DEEPEST => {
                let bracket =
                    asked.then(|| Bracket { inside: range.end..range.end, items: Vec::new() });
                let inside = Frame { path_length: path.len(), index: 0, bracket };
                outer.push(std::mem::replace(&mut frame, inside));
            }
            Token::Open => deeper += 1,
            Token::Close if deeper > 0 => deeper -= 1,
            Token::Close => {
                let Some(before) = outer.pop() else { continue };
                let closed = std::mem::replace(&mut frame, before);
                if let Some(mut bracket) = closed.bracket {
                    bracket.inside.end = range.start;
                    tree.entry(path[..closed.path_length].to_owned()).or_insert(bracket);
                }
                reach(&mut frame.bracket, &range);
            }
            Token::Comma if deeper == 0 => {
                frame.index += 1;
                if let Some(item) =
                    frame.bracket.as_mut().and_then(|bracket| bracket.items.last_mut())
                {
                    item.comma = Some(range.end);
                }
            }
            Token::Comma | Token::Key | Token::Colon | Token::Word | Token::Literal => {}
        }
    }
    tree
}

/// Reads the groups and lists at `paths`.
pub(crate) fn brackets<'a>(text: &'a str, paths: &[&str]) -> Tree<'a> {
    let paths: HashSet<&str> = paths.iter().copied().collect();
    scan(text, "", |path, _| paths.contains(path))
}

/// Extends the value of the last item to the end of `range`.
fn reach(bracket: &mut Option<Bracket<'_>>, range: &Range<usize>) {
    if let Some(Item { value, .. }) = bracket.as_mut().and_then(|bracket| bracket.items.last_mut())
    {
        let start = if value.start == value.end { range.start } else { value.start };
        *value = start..range.end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_has_what_was_asked_for_with_the_places_of_its_items() {
        let text = "T(a: 1, /* ( */ r#b : kind(c: -2) , list: [(\"]\", x),\n (), 7 ])";
        let tree = brackets(text, &["b", "list", "list[0]", "absent", "a"]);
        let spans = |path: &str| -> Vec<_> {
            let items = tree[path].items.iter();
            items
                .map(|item| (item.name, &text[item.start..item.comma.unwrap_or(item.value.end)]))
                .collect()
        };
        assert_eq!(tree.keys().collect::<Vec<_>>(), ["b", "list", "list[0]"]);
        assert_eq!(spans("b"), [(Some("c"), "c: -2")]);
        assert_eq!(spans("list"), [(None, "(\"]\", x),"), (None, "(),"), (None, "7")]);
        assert_eq!(&text[tree["list[0]"].inside.clone()], "\"]\", x");
        let whole = scan(text, "root", |_, _| true);
        assert_eq!(
            whole.keys().collect::<Vec<_>>(),
            ["root", "root.b", "root.list", "root.list[0]", "root.list[1]"]
        );
        assert_eq!(&text[whole["root"].items[1].value.clone()], "kind(c: -2)");
        assert!(
            scan("(a: [1, (2)", "", |_, _| true).keys().eq(["a[1]"]),
            "brackets that never close are left out"
        );
    }
}
