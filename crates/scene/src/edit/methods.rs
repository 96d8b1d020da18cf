//! Methods and substeps written into the text of a scene.

use std::fmt;
use std::sync::Arc;

use motion::Method;
use serde::{Deserialize, Serialize};

use super::rewrite::{TextEdit, rewrite};
use crate::entries::Entry;
use crate::parts::Part;
use crate::resolve::springs::unsolvable;
use crate::scene::Scene;
use crate::substepping::Substepping;
use crate::text::faults::SceneError;

/// A setting of a run: a method, and its substeps per tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Setting {
    /// Method of every body.
    pub method: Method,
    /// Substeps of every body.
    pub substeps: Substepping,
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {:#}", self.method.name(), self.substeps)
    }
}

impl Scene {
    /// The method and substeps for the scene and for each entry that differs from it, so that the bodies of each part
    /// have those given with the part.
    ///
    /// The scene gets those of the free bodies, or of another part if a scene with mutual gravity cannot have them.
    #[must_use]
    pub fn methods_of_parts<'p>(
        &self,
        parts: &[(&'p Part, Setting)],
    ) -> (Setting, Vec<(&'p Entry, Setting)>) {
        let settings = parts.iter().rev().map(|(_, setting)| *setting);
        let own = Setting { method: self.method, substeps: self.substeps };
        let solvable =
            |setting: &Setting| unsolvable(setting.method, self.mutual_gravity.is_some()).is_none();
        let common = settings.chain([own]).find(solvable).unwrap_or(own);
        let entries = parts
            .iter()
            .flat_map(|(part, setting)| part.entries.iter().map(|entry| (entry, *setting)));
        let differs = |(entry, setting): &(&Entry, _)| {
            *setting != common || self.written_methods(entry) != [false; 2]
        };
        (common, entries.filter(differs).collect())
    }

    /// The text of the scene with `common` as the method and substeps of the scene, and those of `entries` as their
    /// own; `name` is what messages call it. A key is not written if its value is already the default.
    ///
    /// ```
    /// use motion::Method;
    /// use scene::{Scene, Setting, Substepping};
    ///
    /// let text = "(version: 1, // the first\n bodies: [(mass_kg: 2)])";
    /// let scene = Scene::parse("ball.ron", text).expect("it is a scene");
    /// let ball = &scene.entries()[0];
    /// let entries = [(ball, Setting { method: Method::RungeKutta4, substeps: Substepping::Fixed(3) })];
    /// let common = Setting { method: Method::default(), substeps: Substepping::Fixed(1) };
    /// assert_eq!(
    ///     scene.with_methods("ball.ron", common, &entries).expect("it can have that method"),
    ///     "(version: 1, // the first\n bodies: [(mass_kg: 2, method: runge_kutta_4, substeps: 3)])",
    /// );
    /// ```
    ///
    /// # Errors
    ///
    /// If the new text would not be a valid scene, or would change anything but these methods and substeps.
    pub fn with_methods(
        &self,
        name: &str,
        common: Setting,
        entries: &[(&Entry, Setting)],
    ) -> Result<String, SceneError> {
        let written = ["method", "substeps"].map(|key| self.written(key).is_some());
        let own = entries.iter().flat_map(|(entry, setting)| {
            edits(&entry.path(), *setting, common, self.written_methods(entry))
        });
        let default = Setting { method: Method::default(), substeps: Substepping::Fixed(1) };
        let edits: Vec<_> = edits("", common, default, written).chain(own).collect();
        let text = rewrite(name, &self.text, &edits)?;
        // Parsed by the same name, because a scene without a name has that of its file.
        let before = Self::parse(name, &self.text)?;
        if before.differs_only_in(&Self::parse(name, &text)?, common, entries) {
            return Ok(text);
        }
        let what =
            "methods and substeps cannot be written into this text without changing more than them";
        Err(SceneError::of_file(name, what, "write them by hand"))
    }

    /// Whether the entry has a method and substeps of its own.
    fn written_methods(&self, entry: &Entry) -> [bool; 2] {
        let body = &self.bodies[entry.bodies.start as usize];
        [body.method.is_some(), body.substeps.is_some()]
    }

    /// Whether `after` is this scene with these methods and substeps.
    pub(super) fn differs_only_in(
        &self,
        after: &Self,
        common: Setting,
        entries: &[(&Entry, Setting)],
    ) -> bool {
        let mut expected = self.clone();
        (expected.method, expected.substeps) = (common.method, common.substeps);
        for (entry, Setting { method, substeps }) in entries {
            for body in &mut expected.bodies[entry.bodies.start as usize..entry.bodies.end as usize]
            {
                (body.method, body.substeps) = (Some(*method), Some(*substeps));
            }
        }
        let [expected, after] = [expected, after.clone()].map(|mut scene| {
            for body in &mut scene.bodies {
                body.method.get_or_insert(scene.method);
                body.substeps.get_or_insert(scene.substeps);
            }
            // Ignores the text and the line numbers, which the edits change.
            scene.text = Arc::default();
            scene.declared.iter_mut().for_each(|declaration| declaration.line = None);
            scene
        });
        expected == after
    }
}

/// The edits that give a group a method and substeps. `written` says which of the two keys it has; `inherited` holds
/// without them.
fn edits(
    group: &str,
    Setting { method, substeps }: Setting,
    inherited: Setting,
    written: [bool; 2],
) -> impl Iterator<Item = TextEdit> + use<> {
    let method = (written[0] || method != inherited.method)
        .then(|| TextEdit::set(group, "method", method.name()));
    let substeps = (written[1] || substeps != inherited.substeps)
        .then(|| TextEdit::set(group, "substeps", substeps.to_string()));
    method.into_iter().chain(substeps)
}
