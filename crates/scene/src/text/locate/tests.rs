//! The scanner against texts in which a careless one would lose its way.

use super::*;
use crate::answers;

fn at(text: &str, root: &str, path: &str) -> Option<Position> {
    let offset = offsets(text, root, &[path])[0]?;
    Some(positions(text, &[offset])[0])
}

/// The first line has paths, one of them empty, and the rest is the text.
#[test]
fn keys_entries_and_variants_are_found_and_a_missing_key_is_looked_for_in_its_group() {
    answers("text/locate/places.txt", |case| {
        let (paths, text) = case.split_once('\n').unwrap();
        let place = |path| format!("{path}: {:?}\n", at(text, "", path).unwrap());
        paths.split(' ').map(place).collect()
    });
    assert_eq!(at("", "", "a"), None);
}

#[test]
fn a_bare_list_has_the_name_of_its_root() {
    let text = "[(at_s: 1, do: press(\"G\")),\n (at_s: 2, do: x)]";
    assert_eq!(at(text, "steps", "steps[1].do"), Some(Position { line: 2, column: 12 }));
    let is_group = |text| is_group(text, "Named");
    assert!(!is_group(text) && !is_group("[(a: 1)]") && !is_group("Other(1)") && !is_group(""));
    assert!(is_group(" // x\n(") && is_group("Named (a: 1)"));
    assert_eq!(path_at(text, "steps", 22), "steps[0].do[0]");
}

#[test]
fn only_the_bare_word_nan_is_respelled() {
    let text = "(nan: nan, a: [-nan, nano, \"nan\", 'n'], /* nan */ b: +nan) // nan";
    let spelled = "(nan: NaN, a: [-NaN, nano, \"nan\", 'n'], /* nan */ b: +NaN) // nan";
    assert_eq!(spell_nan(text), spelled);
}

#[test]
fn offsets_and_positions_undo_each_other() {
    let text = "ab\nüü(c\r\n\n d";
    for (offset, _) in text.char_indices() {
        let position = positions(text, &[offset])[0];
        assert_eq!(offset_of(text, position), offset, "{position:?}");
    }
    assert_eq!(offset_of(text, Position { line: 99, column: 99 }), text.len());
}

#[test]
fn text_that_is_not_ron_makes_no_trouble() {
    for text in [
        ")",
        "]]]((",
        "\"",
        "r#\"",
        "'",
        "/*",
        "/",
        ",,,",
        ":::",
        "(a: (b: ]",
        "#!",
        "é(",
        "\u{2028}x",
    ] {
        let _ = (at(text, "", "a.b[3]"), path_at(text, "", 1), spell_nan(text));
    }
}
