//! The README's section on what survives what says what the committed matrix says.

use super::committed;
use crate::harness::root;

#[test]
fn the_readme_has_the_committed_matrix() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let between =
        readme.split_once("<!-- stability: begin").unwrap().1.split_once("<!-- stability: end").unwrap().0;
    let text = between.split_once("-->\n").unwrap().1;
    assert_eq!(text, report::stability::markdown(&committed()), "run scripts/readme-stability");
}

#[test]
fn the_readme_names_every_case() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    for case in scene::cases() {
        assert!(readme.contains(case.name), "README.md should name {}", case.name);
    }
}
