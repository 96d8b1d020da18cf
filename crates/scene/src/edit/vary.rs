//! Scenes that differ from one text in the values of some places.

use std::collections::BTreeSet;
use std::ops::Range;

use super::bracket::Piece;
use super::rewrite::{TextEdit, apply, rewrite};
use crate::raw;
use crate::scene::{Scene, Source};
use crate::text::faults::{Faults, SceneError};
use crate::text::nearest::nearest;
use crate::text::tree::{Tree, scan};

/// A scene in which the values of some places vary.
///
/// A place is named as in messages: `bodies[3].mass_kg`, `gravity.acceleration_m_s2[1]`, `springs[*].stiffness_n_m`
/// for all springs. It is a value in the text of the scene, or a key that a group of the text may have. If `[*]`
/// matches groups with and without the key, the groups without it do not get it.
///
/// ```
/// use scene::{Scene, VariedScene};
///
/// let scene = Scene::parse("ball.ron", "(version: 1, bodies: [(mass_kg: 2), (mass_kg: 3)])").expect("it is a scene");
/// let varied = VariedScene::new(&scene, &[("bodies[*].mass_kg", "1"), ("substeps", "1")]).expect("it has these places");
/// let other = varied.scene(&["0.5", "4"]).expect("the values are allowed");
/// assert_eq!((other.bodies[1].inverse_mass, other.substeps), (Some(2.0), 4.into()));
///
/// let wrong = VariedScene::new(&scene, &[("bodies[0].mas_kg", "1")]).unwrap_err();
/// assert_eq!(
///     wrong.to_string(),
///     "ball.ron:1:23: bodies[0].mas_kg: there is no such place in the scene; did you mean bodies[0].mass_kg?",
/// );
/// ```
#[derive(Clone, Debug)]
pub struct VariedScene {
    scene: Scene,
    /// The text with a value at every place.
    text: String,
    /// Byte ranges in the text of the values of each place.
    places: Vec<Vec<Range<usize>>>,
}

impl VariedScene {
    /// Prepares `scene` for other values at `places`, each of which comes with an allowed value.
    ///
    /// # Errors
    /// If the scene does not have a place, or if two places overlap.
    pub fn new(scene: &Scene, places: &[(&str, &str)]) -> Result<Self, SceneError> {
        let values = Values::of(&scene.text);
        let mut edits = Vec::new();
        for (place, value) in places {
            if values.at(place).next().is_none() {
                edits.extend(
                    values.insert(place, value).ok_or_else(|| values.missing(scene, place))?,
                );
            }
        }
        let text = rewrite(&scene.name, &scene.text, &edits)?;
        let values = Values::of(&text);
        let places: Vec<(&str, Vec<Range<usize>>)> =
            places.iter().map(|(place, _)| (*place, values.at(place).cloned().collect())).collect();
        let mut all: Vec<_> = places
            .iter()
            .flat_map(|(place, ranges)| ranges.iter().map(move |range| (range, *place)))
            .collect();
        all.sort_unstable_by_key(|(range, _)| (range.start, range.end));
        if let Some([(_, one), (_, other)]) =
            all.windows(2).find(|pair| pair[1].0.start < pair[0].0.end)
        {
            let what = format!("{one} varies the same value");
            return Err(fault(scene, other, what, "leave one of them out".to_owned()));
        }
        let places = places.into_iter().map(|(_, ranges)| ranges).collect();
        Ok(Self { scene: scene.clone(), text, places })
    }

    /// The text with these values, one for each place, as a person writes them.
    #[must_use]
    pub fn text(&self, values: &[&str]) -> String {
        let pieces = self.places.iter().zip(values).flat_map(|(ranges, value)| {
            ranges.iter().map(move |range| -> Piece { (range.clone(), (*value).to_owned()) })
        });
        apply(&self.text, pieces.collect())
    }

    /// The scene with these values.
    ///
    /// # Errors
    /// As [`Scene::parse`], where a value is not allowed.
    pub fn scene(&self, values: &[&str]) -> Result<Scene, SceneError> {
        let named = |error| SceneError { name: called(&self.scene), ..error };
        self.scene.reread(&self.text(values)).map_err(named)
    }
}

/// Every value of a text with its path, in the order of the text.
struct Values<'a> {
    text: &'a str,
    tree: Tree<'a>,
    all: Vec<(String, Range<usize>)>,
}

impl<'a> Values<'a> {
    fn of(text: &'a str) -> Self {
        let tree = scan(text, "", |_, _| true);
        let mut all = vec![(String::new(), 0..text.len())];
        for (path, bracket) in &tree {
            all.extend(bracket.items.iter().enumerate().map(|(index, item)| {
                let path = match item.name {
                    Some(name) if path.is_empty() => name.to_owned(),
                    Some(name) => format!("{path}.{name}"),
                    None => format!("{path}[{index}]"),
                };
                (path, item.value.clone())
            }));
        }
        all.sort_by_key(|(_, range)| range.start);
        Self { text, tree, all }
    }

    /// The values at `place`.
    fn at(&self, place: &str) -> impl Iterator<Item = &Range<usize>> {
        self.all.iter().filter(move |(path, _)| is_at(path, place)).map(|(_, range)| range)
    }

    /// The keys that a group at `path` may have.
    fn keys(&self, path: &str) -> impl Iterator<Item = &'static str> {
        let word = self.tree.get(path).map(|group| group.word(self.text));
        word.map_or_else(Vec::new, |word| raw::kinds_at(path, word)).into_iter().map(|(key, _)| key)
    }

    /// Writes a key that groups may have and do not have; `None` if there is no such key or group.
    fn insert(&self, place: &str, value: &str) -> Option<Vec<TextEdit>> {
        let (group, key) = place.rsplit_once('.').unwrap_or(("", place));
        let groups = self
            .tree
            .keys()
            .filter(|path| is_at(path, group) && self.keys(path).any(|known| known == key));
        let edits: Vec<_> = groups.map(|path| TextEdit::set(path, key, value)).collect();
        (!edits.is_empty()).then_some(edits)
    }

    /// The error for a place that the scene does not have, with the nearest place that it has.
    fn missing(&self, scene: &Scene, place: &str) -> SceneError {
        let all = place.contains("[*]");
        let mut known = BTreeSet::new();
        for (path, _) in &self.all {
            let keys = self.keys(path).map(|key| match &path[..] {
                "" => key.to_owned(),
                path => format!("{path}.{key}"),
            });
            known.extend(
                keys.chain([path.clone()]).map(|path| if all { every(&path) } else { path }),
            );
        }
        let near = nearest(place, known.iter().map(String::as_str));
        let cure = match near {
            Some(near) => format!("did you mean {near}?"),
            None => "give a place as messages name it, such as bodies[0].mass_kg".to_owned(),
        };
        fault(scene, place, "there is no such place in the scene".to_owned(), cure)
    }
}

fn fault(scene: &Scene, place: &str, what: String, cure: String) -> SceneError {
    let mut faults = Faults::default();
    faults.add(place, what, cure);
    faults.into_error(&called(scene), &scene.text, "")
}

/// The name of the scene in messages.
fn called(scene: &Scene) -> String {
    match &scene.source {
        Source::File(path) => path.display().to_string(),
        Source::Shipped(_) | Source::Text => scene.name.clone(),
    }
}

/// Whether `place` names `path`.
fn is_at(path: &str, place: &str) -> bool {
    let Some((before, after)) = place.split_once("[*]") else { return path == place };
    let index = path.strip_prefix(before).and_then(|rest| rest.strip_prefix('[')?.split_once(']'));
    index.is_some_and(|(_, rest)| is_at(rest, after))
}

/// The path with `[*]` for each index.
fn every(path: &str) -> String {
    let mut parts = path.split('[');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |path, part| path + "[*]" + part.split_once(']').map_or("", |(_, rest)| rest))
}
