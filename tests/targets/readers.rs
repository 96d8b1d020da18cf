//! Whatever a file holds: it is read, or refused with words that help.

use arbitrary::{Result, Unstructured};
use history::Simulation;
use scene::{Scene, SceneError, Script};

/// A whole number of more digits is too large for a test: of bodies, it would be millions.
const LONG: usize = 4;

/// Bodies that a test has time for.
const MOST_BODIES: usize = 2000;

/// A text of any bytes as a scene.
pub fn scene(bytes: &[u8]) {
    read_scene(&String::from_utf8_lossy(bytes));
}

/// A shipped scene in which some tokens were changed, dropped or doubled.
pub fn mutated_scene(bytes: &[u8]) {
    if let Ok(text) = mutated(&mut Unstructured::new(bytes)) {
        read_scene(&text);
    }
}

/// A text of any bytes as a script.
pub fn script(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    match Script::parse("any", &text) {
        Ok(script) => {
            let tutorial = scene::load("tutorial").unwrap();
            let known = |word: &str| sandbox::actions::key_of_word(word).is_ok();
            if let Err(error) = script.check("any", &text, &tutorial, known, |_| true, |_| false) {
                helps(&error);
            }
        }
        Err(error) => helps(&error),
    }
}

fn read_scene(text: &str) {
    let part_of_number = |c: char| c.is_ascii_alphanumeric() || "+-._".contains(c);
    let is_large = |word: &str| word.len() > LONG && word.chars().all(|c| c.is_ascii_digit());
    if text.split(|c| !part_of_number(c)).any(is_large) {
        return;
    }
    match Scene::parse("any", text) {
        Ok(scene) if scene.bodies.len() <= MOST_BODIES => runs(&scene),
        Ok(_) => {}
        Err(error) => helps(&error),
    }
}

/// What was accepted can be simulated.
fn runs(scene: &Scene) {
    let mut run = Simulation::new(scene.clone());
    assert_eq!(run.bodies.len(), scene.bodies.len());
    if scene.substeps > 8.into()
        || scene.bodies.iter().any(|body| body.substeps.is_some_and(|parts| parts > 8.into()))
    {
        return;
    }
    run.run(3);
    super::step::assert_finite(&mut run.world);
}

fn helps(error: &SceneError) {
    let text = error.to_string();
    assert!(!text.trim().is_empty() && text.contains("any"), "{text:?} does not name the file");
}

/// Words and numbers that belong to some key or other.
const TOKENS: &[&str] = &[
    "0",
    "-0.0",
    "-1",
    "1e308",
    "1e999",
    "-1e-320",
    "nan",
    "inf",
    "-inf",
    "true",
    "None",
    "\"\"",
    "\"b0\"",
    "fixed",
    "frame",
    "exact",
    "implicit_euler",
    "()",
    "(0, 0, 0)",
    "[]",
    "{}",
    "(",
    ")",
    ",",
    ":",
    "version",
    "gravity",
    "mass_kg",
    "between",
    "first",
    "'x'",
    "/*",
    "//",
    "\\",
    "\u{0}",
    "\u{feff}",
];

fn mutated(u: &mut Unstructured<'_>) -> Result<String> {
    let text = u.choose(scene::shipped())?.text;
    let mut tokens = tokens(text);
    for _ in 0..u.int_in_range(1..=6)? {
        let at = u.choose_index(tokens.len())?;
        match u.int_in_range(0..=4)? {
            0 => tokens[at] = u.choose(TOKENS)?,
            1 => tokens[at] = "",
            2 => tokens.insert(at, tokens[at]),
            3 => {
                let other = u.choose_index(tokens.len())?;
                tokens.swap(at, other);
            }
            _ => tokens.truncate(at.max(1)),
        }
    }
    Ok(tokens.concat())
}

/// Words, numbers, and whatever stands between.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut start = 0;
    let kind = |c: char| (c.is_alphanumeric() || "_.-\"".contains(c), c.is_whitespace());
    let mut chars = text.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        let ends = chars
            .peek()
            .is_none_or(|(_, next)| kind(*next) != kind(c) || kind(c) == (false, false));
        if ends {
            let end = at + c.len_utf8();
            tokens.push(&text[start..end]);
            start = end;
        }
    }
    tokens
}
