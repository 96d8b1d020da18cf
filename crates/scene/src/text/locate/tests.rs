//! The scanner against texts in which a careless one would lose its way.

use super::*;

fn at(text: &str, root: &str, path: &str) -> Option<Position> {
    let offset = offsets(text, root, &[path])[0]?;
    Some(positions(text, &[offset])[0])
}

#[track_caller]
fn check(text: &str, path: &str, line: usize, column: usize) {
    assert_eq!(at(text, "", path), Some(Position { line, column }), "{path} in {text}");
}

#[test]
fn keys_entries_and_variants_are_found() {
    let text =
        "(\n  a: 1,\n  list: [\n    (b: ball(r: 2.0), c: (1, -2e3, 3)),\n    (b: x),\n  ],\n)";
    check(text, "", 1, 1);
    check(text, "a", 2, 3);
    check(text, "list", 3, 3);
    check(text, "list[0]", 4, 5);
    check(text, "list[0].b", 4, 6);
    check(text, "list[0].b.r", 4, 14);
    check(text, "list[0].c[1]", 4, 30);
    check(text, "list[1].b", 5, 6);
}

#[test]
fn a_missing_key_is_looked_for_in_its_group() {
    check("(a: 1,\n list: [(b: 1)])", "list[0].absent", 2, 9);
    check("(a: 1,\n list: [(b: 1)])", "list[7].absent", 2, 2);
    check("\n\n (a: 1)", "absent", 3, 2);
    assert_eq!(at("", "", "a"), None);
}

#[test]
fn strings_comments_and_characters_hide_their_brackets() {
    check(r#"(a: "\"( [ , b: ", b: 1)"#, "b", 1, 20);
    check("(a: r#\"\"( b: \"#, b: 1)", "b", 1, 18);
    check("(a: r\"\\\", b: 1)", "b", 1, 11);
    check("(a: br\"(\", b: '(', c: 1)", "c", 1, 20);
    check("(/* b: ( /* nested ) */ */ // b: (\n b: 1)", "b", 2, 2);
    check("(a: \"über\", b: 1)", "b", 1, 13);
}

#[test]
fn named_groups_raw_names_and_attributes_are_passed_through() {
    check("Scene(a: Some((b: 1)), r#c: 2)", "c", 1, 24);
    check("#![enable(implicit_some)]\n(a: (b: 1))", "a.b", 2, 6);
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
