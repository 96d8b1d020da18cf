//! Scenes by name or path: those embedded in the program first, then files.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::resolve::parse_as;
use crate::scene::{Scene, Source};
use crate::text::faults::SceneError;
use crate::text::nearest::{did_you_mean, nearest};

/// Largest file that is read, bytes: enough for a scene of the most bodies, each written out.
pub const FILE_LIMIT: u64 = 64 << 20;

/// A scene that is embedded in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShippedScene {
    /// Its name on the command line.
    pub name: &'static str,
    /// The text of its file.
    pub text: &'static str,
}

impl ShippedScene {
    /// Reads the scene.
    ///
    /// # Errors
    ///
    /// Never in practice: a test loads every shipped scene.
    pub fn load(&self) -> Result<Scene, SceneError> {
        parse_as(self.name, self.text, Source::Shipped(self.name))
    }
}

macro_rules! files_of {
    ($folder:literal: $($name:literal),+ $(,)?) => {
        &[$(ShippedScene {
            name: $name,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/", $folder, "/", $name, ".ron")),
        }),+]
    };
}

/// Every shipped scene, the default one first.
#[must_use]
pub const fn shipped() -> &'static [ShippedScene] {
    files_of![
        "scenes":
        "tutorial", "tutorial_large", "empty", "thousand", "projectile", "coast", "frame_step",
        "ship", "ship_between", "verlet_start", "orbit", "orbits_race", "terminal_speed",
        "oscillator", "third_law", "figure_eight", "rope", "bridge", "flag", "cape", "jelly",
        "meadow", "fountain", "sparks", "wall", "everything", "feather", "solar",
        "bungee", "dust_trail", "storm", "shower", "first_law", "galaxies", "resonance", "shaken_cloth",
        "comets",
    ]
}

/// The hard cases of the survival matrix, which are scenes with bounds.
#[must_use]
pub const fn cases() -> &'static [ShippedScene] {
    files_of![
        "cases":
        "stiff_spring", "heavy_light_chain", "compressed_spring", "over_damping", "dashpot",
        "close_passage", "comet", "passage", "terminal_fall", "coincident_points", "zero_length_spring", "far_from_origin", "tiny_steps",
        "huge_steps", "jittered_fall", "jittered_spring", "hitch", "at_rest", "subnormals",
        "enormous_forces", "gravity_toggled", "come_and_go",
    ]
}

/// The scene or hard case of that name that is embedded in the program.
#[must_use]
pub fn embedded(name: &str) -> Option<&'static ShippedScene> {
    shipped().iter().chain(cases()).find(|scene| scene.name == name)
}

/// The shipped scenes whose name contains the letters of `query` in order, best match first: an unbroken run
/// and an early start count most. An empty query finds all, in their order.
#[must_use]
pub fn find(query: &str) -> Vec<&'static ShippedScene> {
    let mut found: Vec<_> =
        shipped().iter().filter_map(|scene| Some((spread(scene.name, query)?, scene))).collect();
    if !query.trim().is_empty() {
        found.sort_by_key(|(spread, scene)| (*spread, scene.name.len()));
    }
    found.into_iter().map(|(_, scene)| scene).collect()
}

/// How far apart the letters of `query` are in `name`, and how late they begin; `None` if one is missing.
fn spread(name: &str, query: &str) -> Option<(usize, usize)> {
    let letters = |text: &str| {
        text.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_lowercase).collect::<Vec<_>>()
    };
    let (name, query) = (letters(name), letters(query));
    let from = |start: usize| {
        let mut at = start;
        for letter in &query {
            at += 1 + name[at..].iter().position(|c| c == letter)?;
        }
        Some((at - start - query.len(), start))
    };
    (0..=name.len()).filter_map(from).min()
}

/// Loads a shipped scene or a hard case by its name, or a scene file by its path.
///
/// # Errors
///
/// If there is neither, naming what there is; if the file cannot be read; if it has faults, all of them.
pub fn load(name_or_path: &str) -> Result<Scene, SceneError> {
    match embedded(name_or_path) {
        Some(scene) => scene.load(),
        None => load_file(name_or_path, shipped(), "there is no such scene", "shipped scenes are"),
    }
}

/// Loads a hard case by its name, or any scene file with `expect: (survival: (...))` by its path.
///
/// # Errors
///
/// As [`load`]; if the scene says nothing of survival.
pub fn load_case(name_or_path: &str) -> Result<Scene, SceneError> {
    let scene = match embedded(name_or_path) {
        Some(scene) => scene.load()?,
        None => load_file(name_or_path, cases(), "there is no such case", "the cases are")?,
    };
    if scene.survival.is_some() {
        return Ok(scene);
    }
    let cure = "add `expect: (survival: (measure: energy, seconds: 10, bounded_below: 0.1))`, or name a case of \
                `sandbox list cases`";
    Err(SceneError::of_file(name_or_path, "the scene is no hard case", cure))
}

/// Loads a file; `known` are the names to suggest for a word that is not a path.
fn load_file(
    name_or_path: &str,
    known: &[ShippedScene],
    what: &str,
    names_are: &str,
) -> Result<Scene, SceneError> {
    let path = Path::new(name_or_path);
    let looks_like_path = path.extension().is_some() || path.components().count() > 1;
    if !looks_like_path && !path.exists() {
        let names: Vec<&str> = known.iter().map(|scene| scene.name).collect();
        let all = shipped().iter().chain(cases()).map(|scene| scene.name);
        let near =
            nearest(name_or_path, names.iter().copied()).or_else(|| nearest(name_or_path, all));
        let guess = did_you_mean(near);
        let cure = format!("{guess}{names_are} {}; a file needs its path", names.join(", "));
        return Err(SceneError::of_file(name_or_path, what, cure));
    }
    load_path(path)
}

/// Loads a scene file by its path, which need not be UTF-8.
///
/// # Errors
///
/// If the file cannot be read; if it has faults, all of them.
pub fn load_path(path: &Path) -> Result<Scene, SceneError> {
    let text = read_text(path)?;
    let called = path.to_string_lossy();
    let mut scene = parse_as(&called, &text, Source::File(path.to_owned()))?;
    if scene.name == called {
        // A scene without a name has that of its file, without folders.
        scene.name = path
            .file_stem()
            .map_or_else(|| scene.name.clone(), |stem| stem.to_string_lossy().into_owned());
    }
    Ok(scene)
}

/// Reads a scene, script or table of frame times as text, without a byte order mark.
///
/// # Errors
///
/// If there is no such file, it is a folder, cannot be read, is not UTF-8 or larger than [`FILE_LIMIT`].
#[expect(clippy::wildcard_enum_match_arm, reason = "kinds of errors of the system")]
pub fn read_text(path: &Path) -> Result<String, SceneError> {
    let name = path.to_string_lossy();
    let fail = |what: &str, cure: &str| SceneError::of_file(&name, what, cure);
    let unreadable = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => fail("there is no such file", "check the path"),
        _ => fail(
            &format!("the file cannot be read: {}", io_words(&error)),
            "check the path and its permissions",
        ),
    };
    if path.is_dir() {
        return Err(fail("this is a folder", "give the path of a file in it"));
    }
    let file = File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    // Read one byte past the limit to detect a file that is too large, even one that never ends.
    file.take(FILE_LIMIT + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > FILE_LIMIT {
        let cure = format!(
            "give one of at most {} MiB; clouds and grids are short to write",
            FILE_LIMIT >> 20
        );
        return Err(fail("the file is too large", &cure));
    }
    // The signature of a ZIP archive.
    if bytes.starts_with(b"PK\x03\x04") {
        let cure = format!(
            "`sandbox {name}` opens a bundle in the window, `sandbox replay {name}` runs it"
        );
        return Err(fail("this is an archive, not a text", &cure));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count();
        fail(&format!("line {line} is not UTF-8 text"), "save the file as UTF-8")
    })?;
    Ok(match text.strip_prefix('\u{feff}') {
        Some(text) => text.to_owned(),
        None => text,
    })
}

/// What the system says of an error, without its number.
#[must_use]
pub fn io_words(error: &std::io::Error) -> String {
    let text = error.to_string();
    let words = text.split(" (os error").next().unwrap_or_default();
    let mut characters = words.chars();
    characters
        .next()
        .map_or_else(String::new, |first| first.to_lowercase().chain(characters).collect())
}

#[cfg(test)]
mod tests;
