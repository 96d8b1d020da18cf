//! The list of mutants is true: its words, its edits and its tests are there.

use std::collections::BTreeSet;
use std::fs;

use acceptance::mutants::{MUTANTS, Made};

use crate::harness::root;

#[test]
fn every_mutant_of_the_list_can_be_made_and_has_its_test() {
    assert_eq!(MUTANTS.len(), 27);
    let mistakes: BTreeSet<_> = MUTANTS.iter().map(|mutant| mutant.mistake).collect();
    assert_eq!(mistakes.len(), 27, "one is there twice");
    let read =
        |file: &str| fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    for mutant in MUTANTS {
        match mutant.made {
            Made::BesideTheTests(file, words) => {
                let text = read(file);
                words.iter().for_each(|words| assert!(text.contains(words), "{file} has no {words}"));
            }
            Made::ByEdits(edits) => {
                for edit in edits {
                    let places = read(edit.file).matches(edit.from).count();
                    assert_eq!(places, 1, "{} has {} times {:?}", edit.file, places, edit.from);
                    assert_ne!(edit.from, edit.to);
                }
            }
        }
        let (modules, test) = mutant.killed_by.rsplit_once("::").unwrap();
        let text = read(&format!("tests/{}.rs", modules.replace("::", "/")));
        assert!(text.contains(&format!("#[test]\nfn {test}()")), "there is no test {}", mutant.killed_by);
    }
}
