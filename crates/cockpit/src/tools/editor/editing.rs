//! Changes of the scene's text, each of which restarts the scene with the new text. Undo, redo and saving.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use history::RunSettings;
use motion::Method;
use motion::effects::{self, Effect, EffectState};
use scene::{Entry, Scene, SceneError, StepKind, TextEdit};

use crate::intent::{Intent, Question};
use crate::stage::notices::Topic;
use crate::stage::{Order, SceneFile, Stage};
use crate::tools::editor::Editor;
use crate::tools::editor::document::Document;
use crate::tools::editor::free::free_move;
use crate::tools::editor::parts::triple;
use crate::tools::editor::selected::selected_entry;
use crate::view::View;

/// The intents that follow from a change of the text: a restart, or none if the new text is not a valid scene.
type Next = Vec<Intent>;

impl Editor {
    /// Makes changes in the text of the scene and restarts it, paused, with the entry at the path `select` selected. If the new
    /// text is not a valid scene, the editor shows the error, and nothing else happens.
    pub(super) fn rewrite(
        &mut self,
        stage: &Stage,
        changes: &[TextEdit],
        select: Option<&str>,
    ) -> Next {
        if changes.is_empty() {
            return Vec::new();
        }
        let before = present_text(stage);
        let after = rewritten(stage, &before, changes);
        self.take_change(stage, before, after, select)
    }

    fn take_change(
        &mut self,
        stage: &Stage,
        before: Arc<str>,
        after: Result<Scene, SceneError>,
        select: Option<&str>,
    ) -> Next {
        match after {
            Ok(scene) => {
                self.document(&stage.sim().scene).changed(before);
                restart(scene, select)
            }
            Err(error) => {
                self.discard_unfinished();
                self.error = Some(error.to_string());
                Vec::new()
            }
        }
    }

    pub(super) fn undo(&mut self, stage: &mut Stage) -> Next {
        self.go_to_text(stage, "nothing to undo; , goes back in time", Document::undo)
    }

    pub(super) fn redo(&mut self, stage: &mut Stage) -> Next {
        self.go_to_text(stage, "nothing to redo", Document::redo)
    }

    fn go_to_text(
        &mut self,
        stage: &mut Stage,
        none: &str,
        other: fn(&mut Document, Arc<str>) -> Option<Arc<str>>,
    ) -> Next {
        let present = present_text(stage);
        let Some(text) = self.document.as_mut().and_then(|document| other(document, present))
        else {
            stage.notices.say(Topic::Editor, none.to_owned());
            return Vec::new();
        };
        // Every text of the document was read before. Settings that were changed in the run stay.
        let settings = settings_of(stage);
        let selected = selected_entry(stage).map(|(entry, _)| entry.path());
        with_settings(stage, &text, &settings)
            .map_or_else(|_| Vec::new(), |scene| restart(scene, selected.as_deref()))
    }

    /// Adds a copy of the selection beside it, where nothing is.
    pub(super) fn duplicate(&mut self, stage: &mut Stage, view: &View, open: bool) -> Next {
        let Some((entry, _)) = edited_entry(stage, open) else { return Vec::new() };
        let right = view.viewpoint().right();
        // Along one axis, as a person would put it there.
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * axis.dot(right).signum());
        let axis = axes
            .into_iter()
            .max_by(|a, b| a.dot(right).total_cmp(&b.dot(right)))
            .unwrap_or(DVec3::X);
        let scene = &stage.sim().scene;
        let (original, path) =
            (entry.path(), format!("{}[{}]", entry.list, scene.count(entry.list)));
        let by = free_move(scene, &scene.copied(&original, DVec3::ZERO), &path, &[axis], true);
        let copy = scene.copied(&original, by);
        self.rewrite(stage, &copy, Some(&path))
    }

    /// Removes the selection from the scene. Asks first if it is one of several bodies that an entry makes.
    pub(super) fn delete_selection(&mut self, stage: &mut Stage, open: bool) -> Next {
        let Some((entry, name)) = edited_entry(stage, open) else { return Vec::new() };
        if entry.may_be_taken_apart() && entry.bodies.len() > 1 {
            let body = stage.selection().and_then(|thing| stage.sim().id(thing));
            let alone = body.filter(|_| !stage.sim().scene.apart(&entry.path()).is_empty());
            vec![Intent::Ask(Question::Deleting { name, entry, alone })]
        } else {
            self.delete(stage, &entry, None)
        }
    }

    /// Removes an entry. With `alone`, takes a grid or a cloud apart and removes only the body with that stable id.
    pub(super) fn delete(&mut self, stage: &Stage, entry: &Entry, alone: Option<u32>) -> Next {
        let Some(body) = alone else {
            let without = stage.sim().scene.without(&entry.path());
            return self.rewrite(stage, &without, None);
        };
        let place = stage.sim().scene.count("bodies") + (body - entry.bodies.start) as usize;
        let before = present_text(stage);
        let apart = rewritten(stage, &before, &stage.sim().scene.apart(&entry.path()));
        let after = apart.and_then(|apart| {
            let without = apart.without(&format!("bodies[{place}]"));
            rewritten(stage, &apart.text, &without)
        });
        self.take_change(stage, before, after, None)
    }

    /// Orders the scene to be written into the file that the editor names.
    pub(super) fn save_scene(&mut self, stage: &mut Stage) {
        let text = present_text(stage);
        let scene = &stage.sim().scene;
        let mut path = PathBuf::from(self.file_to_save(scene));
        let file = self.document(scene).file.clone();
        let is_own = file.as_ref().is_some_and(|(own, _)| *own == path);
        if !is_own && path.extension().is_none_or(|ending| ending != "ron") {
            path.as_mut_os_string().push(".ron");
        }
        let replaces = file.filter(|(file, _)| *file == path).map(|(_, text)| text);
        let scene_text = Arc::clone(&scene.text);
        stage.orders.push(Order::Scene(SceneFile { path, text, replaces, scene_text }));
    }

    /// Notes that the file has the text of the scene now.
    pub(crate) fn saved(
        &mut self,
        stage: &mut Stage,
        SceneFile { path, text, scene_text, .. }: &SceneFile,
    ) {
        let document = self.document(&stage.sim().scene);
        document.file = Some((path.clone(), Arc::clone(text)));
        document.saved = Some(Arc::clone(scene_text));
        stage.files.note(path);
    }

    /// The file that saving replaces, and its text when it was opened or saved last.
    pub(crate) fn own_file(&self) -> Option<(PathBuf, Arc<str>)> {
        self.document.as_ref()?.file.clone()
    }

    /// Restores unsaved changes, and the [file](Self::own_file) that they were made in.
    pub(crate) fn open_unsaved(&mut self, stage: &Stage, file: Option<(PathBuf, Arc<str>)>) {
        let document = self.document(&stage.sim().scene);
        (document.saved, document.file) = (None, file);
    }
}

fn restart(scene: Scene, select: Option<&str>) -> Next {
    vec![Intent::Restart(Box::new(scene), select.map(str::to_owned))]
}

/// The current scene with another text: `text` after `changes`.
fn rewritten(stage: &Stage, text: &str, changes: &[TextEdit]) -> Result<Scene, SceneError> {
    let scene = &stage.sim().scene;
    scene::rewrite(&scene.name, text, changes).and_then(|text| scene.reread(&text))
}

/// The text of the scene with the method, step, gravity, damping and switched effects that it has now.
fn present_text(stage: &Stage) -> Arc<str> {
    let text = Arc::clone(&stage.sim().scene.text);
    let settings = settings_of(stage);
    if settings.is_empty() {
        return text;
    }
    with_settings(stage, &text, &settings).map_or(text, |scene| scene.text)
}

/// Settings of the run that differ from the text of the scene, as changes of the text.
fn settings_of(stage: &Stage) -> Vec<TextEdit> {
    let scene = &stage.sim().scene;
    scene.reread(&scene.text).map_or_else(|_| Vec::new(), |written| settings(stage, &written))
}

/// The scene of `text` with these settings; without them if they and its other keys are not a valid scene.
fn with_settings(stage: &Stage, text: &str, settings: &[TextEdit]) -> Result<Scene, SceneError> {
    rewritten(stage, text, settings).or_else(|_| stage.sim().scene.reread(text))
}

/// The entry of the selection, while the editor is open.
fn edited_entry(stage: &mut Stage, open: bool) -> Option<(Entry, String)> {
    if !open {
        stage.notices.say(Topic::Editor, "M opens the editor, which can do that".to_owned());
        return None;
    }
    let entry = selected_entry(stage);
    if entry.is_none() {
        stage.notices.say(Topic::Editor, "nothing is selected".to_owned());
    }
    entry
}

/// Settings of the run of `stage` that differ from `written`, as changes of its text.
fn settings(stage: &Stage, written: &Scene) -> Vec<TextEdit> {
    let now = RunSettings::of(stage.sim());
    let mut changes = Vec::new();
    let mut set =
        |group: &str, key: &str, value: String| changes.push(TextEdit::set(group, key, value));
    if now.method != written.method {
        set("", "method", Method::name(now.method).to_owned());
    }
    if now.substeps != written.substeps {
        set("", "substeps", now.substeps.to_string());
    }
    if written.step == StepKind::Fixed && now.step != 1.0 / written.step_hz {
        set("", "step_hz", format!("{:?}", now.step_hz()));
    }
    if let Some(now) = now.effects.gravity.filter(|now| Some(*now) != written.gravity) {
        let (acceleration, on) = (triple(now.acceleration), now.on.to_string());
        match written.gravity {
            None => set(
                "",
                "gravity",
                format!("(acceleration_m_s2: {acceleration}, on_at_start: {on})"),
            ),
            Some(before) => {
                if before.acceleration != now.acceleration {
                    set("gravity", "acceleration_m_s2", acceleration);
                }
                if before.on != now.on {
                    set("gravity", "on_at_start", on);
                }
            }
        }
    }
    if let Some(now) = now.effects.damping.filter(|now| Some(*now) != written.damping) {
        let (model, rate) = (now.model.name(), now.rate);
        match written.written("damping") {
            None => set("", "damping", format!("(model: {model}, rate_per_s: {rate:?})")),
            Some(_) => {
                set("damping", "model", model.to_owned());
                set("damping", "rate_per_s", format!("{rate:?}"));
            }
        }
    }
    changes.extend(switched_off(stage, now.effects.off, written));
    changes
}

/// The change that writes the effects `now` as off, if the text has others. Gravity has its own key.
fn switched_off(stage: &Stage, mut now: Vec<Effect>, written: &Scene) -> Option<TextEdit> {
    now.retain(|effect| *effect != Effect::Gravity);
    let mut before = written.off_at_start.clone();
    before.retain(|effect| effects::state(&stage.sim().world, *effect) != EffectState::NotDeclared);
    before.sort();
    before.dedup();
    let names: Vec<_> = now.iter().map(|effect| effect.name()).collect();
    let value = (!names.is_empty()).then(|| format!("[{}]", names.join(", ")));
    (now != before).then(|| TextEdit::Set {
        group: String::new(),
        key: "off_at_start".to_owned(),
        value,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::options::Options;

    #[test]
    fn a_typed_name_gets_the_ending_of_scenes_and_the_file_of_the_scene_keeps_its_own() {
        let mut stage =
            Stage::new(scene::load("empty").expect("it is shipped"), Options::default());
        let mut saves = |mut editor: Editor| {
            editor.save_scene(&mut stage);
            let order = stage.orders.pop();
            let Some(Order::Scene(SceneFile { path, .. })) = order else { panic!("{order:?}") };
            path.display().to_string()
        };
        for (typed, file) in
            [("mine", "mine.ron"), ("mine.2", "mine.2.ron"), ("mine.ron", "mine.ron")]
        {
            let typed_file = Some(typed.to_owned());
            assert_eq!(saves(Editor { typed_file, ..Editor::default() }), file);
        }
        let mut document = Document::of(&scene::load("empty").expect("it is shipped"));
        document.file = Some((PathBuf::from("mine.scene"), Arc::from("")));
        let own = Editor { document: Some(document), ..Editor::default() };
        assert_eq!(saves(own), "mine.scene");
    }
}
