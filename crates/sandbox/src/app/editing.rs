//! Changes of the scene's text: each restarts the scene with what the text says then. Undo, redo, saving, and the question
//! before unsaved changes are left.

use std::path::PathBuf;
use std::sync::Arc;

use bevy_ecs::entity::Entity;
use glam::DVec3;
use motion::effects::{self, Effect, EffectState};
use motion::snapshot::OffResource;
use motion::{Damping, Gravity, Method, Substeps, TimeStep};
use scene::{Entry, FileIndex, Scene, SceneError, StepKind, TextEdit};

use crate::app::session::{DEFAULT_FPS, Session};
use crate::app::ui::Question;
use crate::panels::Panel;
use crate::tools::editor::{Editor, Handle, NEAR_POINTS, free_move, selected_entry, triple};
use crate::tools::tool::Answer;
use crate::view::notices::Topic;
use crate::view::stage::{Mode, Order, SceneFile, Stage, View};
use crate::view::things::Thing;

impl Session {
    /// Makes changes in the text of the scene and restarts with it, paused; the entry at the path `select` is selected then.
    /// Changes that make no scene are told in the editor, and nothing happens.
    pub(crate) fn rewrite(&mut self, changes: &[TextEdit], select: Option<&str>) {
        if changes.is_empty() {
            return;
        }
        let before = self.present_text();
        let after = self.rewritten(&before, changes);
        self.take_change(before, after, select);
    }

    /// The scene of another text of the present one.
    fn rewritten(&self, text: &str, changes: &[TextEdit]) -> Result<Scene, SceneError> {
        let scene = &self.sim.scene;
        scene::rewrite(&scene.name, text, changes).and_then(|text| scene.reread(&text))
    }

    fn take_change(&mut self, before: Arc<str>, after: Result<Scene, SceneError>, select: Option<&str>) {
        match after {
            Ok(scene) => {
                self.tools.editor.document(&self.stage.sim.scene).changed(before);
                self.restart_with(scene, select);
            }
            Err(error) => {
                self.tools.editor.finish();
                self.tools.editor.error = Some(error.to_string());
            }
        }
    }

    pub(crate) fn undo(&mut self) {
        self.go_to_text("nothing to undo; , goes back in time", |editor, present| {
            editor.document.as_mut()?.undo(present)
        });
    }

    pub(crate) fn redo(&mut self) {
        self.go_to_text("nothing to redo", |editor, present| editor.document.as_mut()?.redo(present));
    }

    fn go_to_text(&mut self, none: &str, other: fn(&mut Editor, Arc<str>) -> Option<Arc<str>>) {
        let present = self.present_text();
        let Some(text) = other(&mut self.tools.editor, present) else {
            self.notices.say(Topic::Editor, none.to_owned());
            return;
        };
        // Every text of the document was read before. What was set in the run since the present text stays.
        let settings = self.settings();
        if let Ok(scene) = self.with_settings(&text, &settings) {
            let selected = selected_entry(&self.stage).map(|(entry, _)| entry.path());
            self.restart_with(scene, selected.as_deref());
        }
    }

    /// The text of the scene with the method, step, gravity, damping and switched effects that it has now.
    pub(crate) fn present_text(&mut self) -> Arc<str> {
        let text = Arc::clone(&self.sim.scene.text);
        let settings = self.settings();
        if settings.is_empty() {
            return text;
        }
        self.with_settings(&text, &settings).map_or(text, |scene| scene.text)
    }

    /// What of the text is set otherwise in the run, as changes of the text.
    fn settings(&mut self) -> Vec<TextEdit> {
        let scene = &self.sim.scene;
        scene.reread(&scene.text).map_or_else(|_| Vec::new(), |written| settings(&mut self.stage, &written))
    }

    /// The scene of `text` with these settings; without them if they make no scene together with its other keys.
    fn with_settings(&self, text: &str, settings: &[TextEdit]) -> Result<Scene, SceneError> {
        self.rewritten(text, settings).or_else(|_| self.sim.scene.reread(text))
    }

    /// Begins `scene`, another text of the present one, paused; camera, click force and what is drawn stay.
    fn restart_with(&mut self, scene: Scene, select: Option<&str>) {
        let same_camera = scene.camera == self.sim.scene.camera;
        let offset = self.offset_in_entry(select);
        let mut editor = std::mem::take(&mut self.tools.editor);
        editor.finish();
        let mut graphs = std::mem::take(&mut self.tools.graphs);
        let same_push = scene.push == self.sim.scene.push;
        let same_trails = scene.trails == self.sim.scene.trails;
        let pace = self.clock.pace();
        // The text says them; scenes that are opened later have them again.
        let overrides = std::mem::take(&mut self.run.options.overrides);
        self.go_on_with(scene, editor, |view, before| {
            let camera = if same_camera { before.camera } else { view.camera };
            let click_force = if same_push { before.click_force } else { view.click_force };
            let trails = if same_trails { before.trails } else { view.trails };
            let (labels, push) = (std::mem::take(&mut view.labels), view.push);
            *view = View { camera, click_force, trails, labels, push, paused: true, ..before };
        });
        self.run.options.overrides = overrides;
        graphs.go_on_with_names(&mut self.stage);
        self.tools.graphs = graphs;
        self.clock.set_pace(pace).expect("it was a pace before");
        self.forecast_start(1.0 / DEFAULT_FPS);
        self.seen.selection = select.and_then(|path| self.entity_at(path, offset));
    }

    /// Which body of the entry at `path` is selected, from 0.
    fn offset_in_entry(&self, path: Option<&str>) -> u32 {
        let offset = || {
            let (entry, _) = selected_entry(&self.stage).filter(|(entry, _)| Some(&*entry.path()) == path)?;
            Some(self.seen.ids.get(&self.seen.selection?)? - entry.bodies.start)
        };
        offset().unwrap_or(0)
    }

    /// A body of the entry at `path`, or the soft body that it makes.
    fn entity_at(&mut self, path: &str, offset: u32) -> Option<Entity> {
        let entry = self.sim.scene.entry_at(path)?;
        let thing = match entry.list {
            "soft_bodies" => Thing::Soft(FileIndex(u32::try_from(entry.index).ok()?)),
            _ => Thing::Body((entry.bodies.start + offset).min(entry.bodies.end.saturating_sub(1))),
        };
        thing.entity(&mut self.sim)
    }

    /// Adds a copy of the selection beside it, where nothing is.
    pub(crate) fn duplicate(&mut self) {
        let Some((entry, _)) = self.edited_entry() else { return };
        let right = self.viewpoint().right();
        // Along one axis, as a person would put it there.
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * axis.dot(right).signum());
        let axis = axes.into_iter().max_by(|a, b| a.dot(right).total_cmp(&b.dot(right))).unwrap_or(DVec3::X);
        let scene = &self.sim.scene;
        let (original, path) = (entry.path(), format!("{}[{}]", entry.list, scene.count(entry.list)));
        let by = free_move(scene, &scene.copied(&original, DVec3::ZERO), &path, &[axis], true);
        let copy = scene.copied(&original, by);
        self.rewrite(&copy, Some(&path));
    }

    /// Removes the selection from the scene. One of several bodies that an entry makes: asks whether alone.
    pub(crate) fn delete(&mut self) {
        let Some((entry, name)) = self.edited_entry() else { return };
        if matches!(entry.list, "grids" | "clouds") && entry.bodies.len() > 1 {
            let body = self.seen.selection.and_then(|thing| self.seen.ids.get(&thing).copied());
            let alone = body.filter(|_| !self.sim.scene.apart(&entry.path()).is_empty());
            self.ask_person(Question::Deleting { name, entry, alone });
        } else {
            self.delete_entry(&entry);
        }
    }

    fn delete_entry(&mut self, entry: &Entry) {
        let without = self.sim.scene.without(&entry.path());
        self.rewrite(&without, None);
    }

    /// Takes a grid or a cloud apart and removes the body with that stable id from it.
    fn delete_alone(&mut self, entry: &Entry, body: u32) {
        let scene = &self.sim.scene;
        let place = scene.count("bodies") + (body - entry.bodies.start) as usize;
        let before = self.present_text();
        let apart = self.rewritten(&before, &self.sim.scene.apart(&entry.path()));
        let after = apart.and_then(|apart| {
            let without = apart.without(&format!("bodies[{place}]"));
            self.rewritten(&apart.text, &without)
        });
        self.take_change(before, after, None);
    }

    /// The entry of the selection, while the editor is open.
    fn edited_entry(&mut self) -> Option<(Entry, String)> {
        if !self.ui.shows(Panel::Editor) {
            self.notices.say(Topic::Editor, "M opens the editor, which can do that".to_owned());
            return None;
        }
        let entry = selected_entry(&self.stage);
        if entry.is_none() {
            self.notices.say(Topic::Editor, "nothing is selected".to_owned());
        }
        entry
    }

    /// Takes a press of the left button for the editor: an end of a spring, or a handle. Whether it was one.
    pub(crate) fn picks_for_editor(&mut self) -> bool {
        if self.view.mode != Mode::Selection || !self.ui.shows(Panel::Editor) {
            return false;
        }
        if self.tools.editor.joins.is_some() {
            let ray = self.picking_ray();
            let hit = self.cast(&ray).and_then(|hit| hit.pushed);
            if let Some(name) = hit.map(|body| self.stage.name(body))
                && let Some(edit) = self.tools.editor.join(&self.stage, name)
            {
                self.edit(edit);
            }
            return true;
        }
        let near_px = NEAR_POINTS * f64::from(self.ui.pixels_per_point());
        if self.tools.editor.has_handles {
            self.tools.editor.handle = Handle::under_pointer(&self.stage, near_px);
        }
        self.tools.editor.handle.is_some()
    }

    /// Moves the selection as far as its handle was dragged.
    pub(crate) fn drop_handle(&mut self) {
        let Some(handle) = self.tools.editor.handle.take() else { return };
        let Some((entry, _)) = selected_entry(&self.stage).filter(|_| handle.by != DVec3::ZERO) else {
            return;
        };
        let path = entry.path();
        let shifted = self.sim.scene.shifted(&path, handle.by);
        self.rewrite(&shifted, Some(&path));
    }

    /// Saves the scene if it has unsaved changes, else the last minute.
    pub(crate) fn save(&mut self) {
        match self.has_unsaved_changes() {
            true => self.save_scene(),
            false => self.order_bundle(),
        }
    }

    /// Orders the scene to be written into the file that the editor names.
    pub(crate) fn save_scene(&mut self) {
        let text = self.present_text();
        let (editor, scene) = (&mut self.tools.editor, &self.stage.sim.scene);
        let mut path = PathBuf::from(editor.file(scene));
        if path.extension().is_none() {
            path.set_extension("ron");
        }
        let file = editor.document(scene).file.clone();
        let replaces = file.filter(|(file, _)| *file == path).map(|(_, text)| text);
        let of = Arc::clone(&scene.text);
        self.orders.push(Order::Scene(SceneFile { path, text, replaces, of }));
    }

    /// Notes that the file has the text of the scene now.
    pub fn saved_scene(&mut self, SceneFile { path, text, of, .. }: &SceneFile) {
        let document = self.tools.editor.document(&self.stage.sim.scene);
        document.file = Some((path.clone(), Arc::clone(text)));
        document.saved = Some(Arc::clone(of));
        self.run.note_file(path);
    }

    /// Scene files that were opened or saved, the newest last.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.run.files
    }

    /// Remembers scene files of earlier windows, the newest last.
    pub fn remember_files(&mut self, mut files: Vec<PathBuf>) {
        files.append(&mut self.run.files);
        files.iter().for_each(|file| self.run.note_file(file));
    }

    /// Whether the scene has changes that no file has.
    #[must_use]
    pub fn has_unsaved_changes(&self) -> bool {
        self.tools.editor.is_unsaved(&self.sim.scene)
    }

    /// Does what leaves the scene; unsaved changes are asked about before.
    pub fn leave(&mut self, order: Order) {
        if !self.has_unsaved_changes() {
            self.orders.push(order);
            return;
        }
        self.ask_person(Question::Leaving(order));
    }

    /// Asks a question, with a free pointer.
    fn ask_person(&mut self, question: Question) {
        if self.view.mode == Mode::Camera {
            self.toggle_mode();
        }
        self.let_go();
        self.ui.question = Some(question);
    }

    /// Whether something is asked.
    #[must_use]
    pub const fn asks(&self) -> bool {
        self.ui.question.is_some()
    }

    /// Asks whether to go on with the unsaved changes in the file `draft`.
    pub fn offer(&mut self, draft: PathBuf) {
        self.ask_person(Question::LeftBehind(draft));
    }

    /// The file that saving replaces, and what it had when it was opened or saved last.
    #[must_use]
    pub fn own_file(&self) -> Option<(PathBuf, Arc<str>)> {
        self.tools.editor.document.as_ref()?.file.clone()
    }

    /// Goes on, paused, with the unsaved changes of a scene, and with the [file](Self::own_file) that they were made in.
    pub fn open_unsaved(&mut self, scene: Scene, file: Option<(PathBuf, Arc<str>)>) {
        self.open(scene);
        self.view.paused = true;
        let document = self.tools.editor.document(&self.stage.sim.scene);
        (document.saved, document.file) = (None, file);
    }

    /// Does what a question was answered with.
    pub(crate) fn answer(&mut self, answer: Answer) {
        match (self.ui.question.take(), answer) {
            (None, _) | (_, Answer::Cancel) => {}
            (Some(Question::Leaving(order)), Answer::Discard) => {
                // Another scene brings another editor, once it is there.
                if order == Order::Quit {
                    self.tools.editor = Editor::default();
                }
                self.orders.push(order);
            }
            (Some(Question::Leaving(order)), _) => {
                self.save_scene();
                self.orders.push(order);
            }
            (Some(Question::Deleting { entry, .. }), Answer::All) => self.delete_entry(&entry),
            (Some(Question::Deleting { entry, alone, .. }), _) => {
                if let Some(body) = alone {
                    self.delete_alone(&entry, body);
                }
            }
            (Some(Question::LeftBehind(draft)), Answer::Discard) => self.orders.push(Order::Forget(draft)),
            (Some(Question::LeftBehind(draft)), _) => self.orders.push(Order::Restore(draft)),
        }
    }
}

/// What of `written` is set otherwise in the run of `stage`, as changes of its text.
fn settings(stage: &mut Stage, written: &Scene) -> Vec<TextEdit> {
    let off = switched_off(stage, written);
    let world = &stage.sim.world;
    let mut changes = Vec::new();
    let mut set = |group: &str, key: &str, value: String| changes.push(TextEdit::set(group, key, value));
    let (method, substeps) = (stage.sim.method(), world.resource::<Substeps>().0);
    if method != written.method {
        set("", "method", Method::name(method).to_owned());
    }
    if substeps != written.substeps {
        set("", "substeps", substeps.to_string());
    }
    let rate = stage.clock.rate();
    if written.step == StepKind::Fixed && rate != written.step_hz && world.contains_resource::<TimeStep>() {
        set("", "step_hz", format!("{rate:?}"));
    }
    if let Some(now) = world.get_resource::<Gravity>().filter(|now| Some(**now) != written.gravity) {
        let (acceleration, on) = (triple(now.acceleration), now.on.to_string());
        match written.gravity {
            None => set("", "gravity", format!("(acceleration_m_s2: {acceleration}, on_at_start: {on})")),
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
    let off_damping = || world.get_resource::<OffResource<Damping>>().map(|off| &off.0);
    let damping = world.get_resource::<Damping>().or_else(off_damping);
    if let Some(now) = damping.filter(|now| Some(**now) != written.damping) {
        let (model, rate) = (now.model.name(), now.rate);
        match written.written("damping") {
            None => set("", "damping", format!("(model: {model}, rate_per_s: {rate:?})")),
            Some(_) => {
                set("damping", "model", model.to_owned());
                set("damping", "rate_per_s", format!("{rate:?}"));
            }
        }
    }
    changes.extend(off);
    changes
}

/// Which effects are switched off, if that is not what is written. Gravity has its own key.
fn switched_off(stage: &mut Stage, written: &Scene) -> Option<TextEdit> {
    let mut now = stage.effects_off();
    now.retain(|effect| *effect != Effect::Gravity);
    let mut before = written.off_at_start.clone();
    before.retain(|effect| effects::state(&mut stage.sim.world, *effect) != EffectState::NotDeclared);
    before.sort();
    before.dedup();
    let names: Vec<_> = now.iter().map(|effect| effect.name()).collect();
    let value = (!names.is_empty()).then(|| format!("[{}]", names.join(", ")));
    (now != before).then(|| TextEdit::Set { group: String::new(), key: "off_at_start".to_owned(), value })
}
