//! The editor: adds, copies, moves, joins and removes what the scene's file has, and changes every value of it.
//!
//! It edits the text of the scene, and the scene restarts with each change: a file says how a scene starts.

mod document;
mod editing;
mod form;
mod free;
mod handles;
mod parts;
pub(crate) mod selected;

use std::path::Path;

use egui::{Align2, CollapsingHeader, Key, Painter, Rect, RichText, TextEdit, Ui};
use glam::DVec3;
use motion::{Substeps, TimeStep};
use render::Frame;
use report::numbers::{capital, rounded};
use scene::{Scene, TextEdit as SceneEdit};

use self::document::Document;
use self::form::{EARTH, Form, LISTS, TITLES};
use self::free::free_move;
use self::handles::Handle;
use self::parts::{PARTS, Place, rounded_to_multiple, triple};
use self::selected::{selected_entry, selected_path};
use crate::actions::Act;
use crate::clock::FrameTime;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::art::wells;
use crate::view::labels::{Label, around};
use crate::view::marks::{self, FAULT, POINTER};
use crate::view::{Mode, View, inks};
use crate::words::{label, plain};

/// Radius of an added sphere, as a fraction of its distance: it is a tenth as high as the view.
const SIZE: f64 = 0.04;

/// Radius of what is in the view around the first body of a scene, as a multiple of its size.
const AROUND: f64 = 6.0;

/// Radius of what marks a well, pixels.
const WELL_PX: f64 = 14.0;

/// Least distance at which an object is added, m.
const NEAREST: f64 = 0.01;

/// Directions in which an added object moves if something is in its way.
const OUTWARD: [DVec3; 5] = [DVec3::Y, DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z];

/// Distance at which an object is added if the middle of the view shows nothing, m.
const AWAY: f64 = 12.0;

/// Button, what it adds, list and first curve, for a body that forces move.
const THRUST: [&str; 4] =
    ["Add thrust", "a force over time", "thrusts", "polynomial([(10.0, 0.0, 0.0)])"];
/// The same for an immovable body.
const MOVE: [&str; 4] = [
    "Add motion",
    "the way of what forces do not move",
    "moves",
    "sine(amplitude_m: (0.5, 0.0, 0.0), angular_frequency_rad_s: 3.0)",
];

/// The editor of a scene.
#[derive(Default)]
pub(crate) struct Editor {
    /// The texts of the scene, from the first change on.
    pub document: Option<Document>,
    /// The error of the change that was tried last.
    pub error: Option<String>,
    /// The ends of a spring that is being added, by name, while their bodies are picked.
    pub spring_ends: Option<Vec<String>>,
    /// Whether the selection has handles.
    pub has_handles: bool,
    /// Whether its panel was laid out since the last ticks: it may be open behind another tab.
    laid_out: bool,
    /// The handle that is dragged.
    pub handle: Option<Handle>,
    form: Form,
    /// The entry whose values were laid out last.
    shown: Option<String>,
    /// The file name that the person typed.
    typed_file: Option<String>,
}

impl Editor {
    /// The texts of `scene`, which begin with the present one.
    pub fn document(&mut self, scene: &Scene) -> &mut Document {
        self.document.get_or_insert_with(|| Document::of(scene))
    }

    /// Whether the scene has changes that no file has.
    pub fn is_unsaved(&self, scene: &Scene) -> bool {
        self.document.as_ref().is_some_and(|document| document.is_unsaved(&scene.text))
    }

    /// Forgets the unfinished edits of the scene before a change.
    pub fn discard_unfinished(&mut self) {
        (self.error, self.spring_ends, self.handle) = (None, None, None);
        self.form.forget();
    }

    /// The file of `scene` that saving replaces, if there is one.
    pub fn file<'a>(&'a self, scene: &'a Scene) -> Option<&'a Path> {
        match &self.document {
            Some(document) => document.file.as_ref().map(|(path, _)| path.as_path()),
            None => scene.source.file(),
        }
    }

    /// The name of the file that saving writes.
    pub fn file_to_save(&self, scene: &Scene) -> String {
        let own = || {
            let file = self.file(scene);
            file.map_or_else(|| format!("{}.ron", scene.name), |path| path.display().to_string())
        };
        self.typed_file.clone().unwrap_or_else(own)
    }

    /// The places of the arrows and rings over the picture, points.
    pub fn places(&self, stage: &Stage, view: &View, painter: &Painter) -> Vec<Rect> {
        if !self.has_handles {
            return Vec::new();
        }
        let arrows = handles::seen(stage, view, painter).into_iter();
        let arrows = arrows.map(|([a, b], _)| Rect::from_two_pos(a, b).expand(4.0));
        let rings = bare_wells(&stage.sim().scene, view);
        arrows.chain(rings.iter().map(|well| marks::ring_place(painter, well))).collect()
    }

    /// Forgets what is being typed, and what is being dragged.
    pub fn cancel_typing(&mut self) {
        self.form.cancel();
        self.handle = None;
    }

    /// Takes a body as an end of the spring that is being added. Returns the spring once it has both ends.
    pub fn join(&mut self, stage: &Stage, name: String) -> Option<Intent> {
        let mut ends = self.spring_ends.take()?;
        if !ends.contains(&name) {
            ends.push(name);
        }
        let [from, to] = &ends[..] else {
            self.spring_ends = Some(ends);
            return None;
        };
        let sim = stage.sim();
        let ids = [from, to].map(|name| sim.id(sim.named(name)?));
        let [one, other] = ids.map(|id| sim.scene.bodies.get(id? as usize));
        let (one, other) = (one?, other?);
        let inverse: f64 = [one, other].iter().filter_map(|body| body.inverse_mass).sum();
        let reduced = if inverse > 0.0 { 1.0 / inverse } else { 1.0 };
        let length = one.position.distance(other.position);
        let spring = parts::spring([from, to], reduced, length, substep(stage));
        let select = sim.scene.entry_of(ids[1]?).map(|entry| entry.path());
        Some(Intent::Rewrite(vec![SceneEdit::add("springs", spring)], select))
    }

    fn file_row(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let scene = &desk.stage.sim().scene;
        let [can_undo, can_redo] = self
            .document
            .as_ref()
            .map_or([false; 2], |document| [document.can_undo(), document.can_redo()]);
        ui.horizontal_wrapped(|ui| {
            for (words, act, can) in [("Undo", Act::Undo, can_undo), ("Redo", Act::Redo, can_redo)]
            {
                let key = act.key().to_string();
                if ui.add_enabled(can, egui::Button::new(words)).on_hover_text(key).clicked() {
                    desk.intents.push(Intent::Act(act));
                }
            }
            let mut file = self.file_to_save(scene);
            let field = ui.add(TextEdit::singleline(&mut file).desired_width(110.0));
            let field = field.on_hover_text("file, in the working directory unless it has folders");
            if field.changed() {
                self.typed_file = Some(file.clone());
            }
            let enter = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let save = ui.button("Save").on_hover_text("the scene into this file (Ctrl+Shift+S)");
            if save.clicked() || enter {
                desk.intents.push(Intent::Act(Act::SaveScene));
            }
        });
    }

    fn add_row(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        ui.horizontal_wrapped(|ui| {
            ui.label("Add");
            for (words, list, text) in PARTS {
                if ui.button(words).clicked() {
                    let mut place = place(desk.stage, desk.view);
                    let scene = &desk.stage.sim().scene;
                    let name = scene.fresh_name(&words.to_lowercase());
                    let index = scene.count(list);
                    let (path, color) =
                        (format!("{list}[{index}]"), parts::color(index + scene.count("bodies")));
                    let added =
                        |place: &Place| vec![SceneEdit::add(list, text(&name, place, color))];
                    let by = free_move(scene, &added(&place), &path, &OUTWARD, false);
                    place.at = scene::moved_place(place.at, by);
                    let is_first = scene.bodies.is_empty();
                    let mut changes = added(&place);
                    // Those of the shipped scene say that it is empty.
                    let stale = is_first && scene.source.file().is_none();
                    changes.extend(["name", "description"].into_iter().filter(|_| stale).map(
                        |key| SceneEdit::Set {
                            group: String::new(),
                            key: key.to_owned(),
                            value: None,
                        },
                    ));
                    desk.intents.push(Intent::Rewrite(changes, Some(path)));
                    if is_first {
                        desk.view.frame_ball(Some((place.at, AROUND * place.size)));
                    }
                }
            }
            let is_joining = self.spring_ends.is_some();
            let spring = ui.add(egui::Button::new("Spring").selected(is_joining));
            let what = "between two bodies, or points of soft bodies, that are clicked next";
            if spring.on_hover_text(what).clicked() {
                self.spring_ends = (!is_joining).then(Vec::new);
            }
            if ui.button("Well").on_hover_text("attracts every body, as 1/r²").clicked() {
                let Place { at, size, .. } = place(desk.stage, desk.view);
                let strength = rounded_1_2_5(WELL * size.powi(3));
                let text = format!(
                    "(position_m: {}, strength_m3_s2: {strength:?}, softening_m: {size:?})",
                    triple(at)
                );
                desk.intents.push(Intent::Rewrite(
                    vec![SceneEdit::add("wells", text)],
                    selected_path(desk.stage),
                ));
            }
            // Last: it is gone once it was pressed.
            let scene = &desk.stage.sim().scene;
            let gravity = scene.gravity.is_none().then(|| ui.button("Gravity"));
            if gravity.is_some_and(|gravity| gravity.on_hover_text("downward, 9.8 m/s²").clicked())
            {
                let gravity = SceneEdit::set("", "gravity", EARTH);
                desk.intents.push(Intent::Rewrite(vec![gravity], selected_path(desk.stage)));
            }
        });
        if let Some(ends) = &self.spring_ends {
            ui.strong(match ends.first() {
                None => "Click the first end of the spring.".to_owned(),
                Some(first) => format!("From {first}: click the other end."),
            });
        }
    }

    /// Applies what was typed for the entry that was selected in the last layout, if another one is selected now.
    fn leave_entry(&mut self, desk: &mut Desk<'_>) {
        let path = selected_path(desk.stage);
        if path == self.shown {
            return;
        }
        let left = std::mem::replace(&mut self.shown, path.clone());
        let changes = left.map_or_else(Vec::new, |left| self.form.left(&left));
        change(desk, changes, path);
    }

    /// Lays out the entry of the selection.
    fn selection(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let Some((entry, name)) = selected_entry(desk.stage) else {
            ui.weak("Click a body to change it; Ctrl+click selects also what cannot be moved.");
            return;
        };
        let (path, scene) = (entry.path(), &desk.stage.sim().scene);
        ui.horizontal_wrapped(|ui| {
            ui.strong(if entry.bodies.len() > 1 && entry.list != "soft_bodies" {
                format!("{name}: one of {} of {}", entry.bodies.len(), plain(&path))
            } else {
                name
            });
        });
        ui.horizontal_wrapped(|ui| {
            if ui.button("Duplicate").on_hover_text("Ctrl+D").clicked() {
                desk.intents.push(Intent::Act(Act::Duplicate));
            }
            if ui
                .button("Delete")
                .on_hover_text("with the springs and thrusts that hold it (Delete)")
                .clicked()
            {
                desk.intents.push(Intent::Act(Act::Delete));
            }
            let separate = "makes single bodies of it, each with its own values; at most 1000";
            if entry.may_be_taken_apart()
                && ui.button("Take apart").on_hover_text(separate).clicked()
            {
                let apart = scene.apart(&path);
                match apart.is_empty() {
                    true => {
                        self.error = Some(format!("{} has more than 1000 bodies", plain(&path)));
                    }
                    false => desk.intents.push(Intent::Rewrite(apart, None)),
                }
            }
            if entry.list != "bodies" {
                return;
            }
            let body = scene.names.get(entry.bodies.start).unwrap_or_default().into_owned();
            let mut added = None;
            let is_immovable = scene.bodies[entry.bodies.start as usize].inverse_mass == Some(0.0);
            let [button, tip, list, curve] = if is_immovable { MOVE } else { THRUST };
            if ui.button(button).on_hover_text(tip).clicked() {
                let drive = format!("(body: {body:?}, curve: {curve})");
                added = Some(SceneEdit::add(list, drive));
            }
            let emitter = ui.button("Add emitter");
            if emitter.on_hover_text("particles that come from it as it moves").clicked() {
                let name = scene.fresh_name("emitter");
                let color = parts::color(scene.count("emitters"));
                let on_body = Place { at: DVec3::ZERO, ..place(desk.stage, desk.view) };
                let more = format!(", rides_on: {body:?}");
                let emitter = parts::emitter(&name, &on_body, color, &more);
                added = Some(SceneEdit::add("emitters", emitter));
            }
            let added = added.map(|added| Intent::Rewrite(vec![added], Some(path.clone())));
            desk.intents.extend(added);
        });
        let mut changes = Vec::new();
        self.form.group(ui, scene, &path, |_| true, &mut changes);
        if entry.list == "bodies" {
            let body = scene.names.get(entry.bodies.start).unwrap_or_default();
            for list in LISTS {
                for index in self.form.naming(scene, list, &body) {
                    self.list_entry(ui, scene, list, index, true, &mut changes);
                }
            }
        }
        change(desk, changes, Some(path));
    }

    /// Lays out everything of the scene but its bodies.
    fn of_scene(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let mut changes = Vec::new();
        let scene = &desk.stage.sim().scene;
        self.scene_keys(ui, scene, &mut changes);
        self.sections(ui, scene, desk.view, &mut changes);
        self.lists(ui, scene, &mut changes);
        change(desk, changes, selected_path(desk.stage));
    }

    /// Lays out the keys of the scene that are in no section.
    fn scene_keys(&mut self, ui: &mut Ui, scene: &Scene, changes: &mut Vec<SceneEdit>) {
        CollapsingHeader::new("The scene").show(ui, |ui| {
            let own = |field: &scene::Field| {
                field.key != "version"
                    && field.kind != scene::Kind::Other
                    && !(field.kind == scene::Kind::Group && field.value.is_some())
            };
            self.form.group(ui, scene, "", own, changes);
        });
    }

    /// Lays out the sections of the scene.
    fn sections(&mut self, ui: &mut Ui, scene: &Scene, view: &View, changes: &mut Vec<SceneEdit>) {
        for key in self.form.sections() {
            CollapsingHeader::new(capital(&label(key).0)).id_salt(("group", key)).show(ui, |ui| {
                ui.horizontal(|ui| {
                    if ui.button("Remove").clicked() {
                        changes.push(SceneEdit::Set {
                            group: String::new(),
                            key: key.to_owned(),
                            value: None,
                        });
                    }
                    if key == "camera" && ui.button("Use the present view").clicked() {
                        let camera = &view.camera;
                        changes.extend([
                            SceneEdit::set(
                                "camera",
                                "position_m",
                                triple(parts::five_digits(camera.position)),
                            ),
                            SceneEdit::set(
                                "camera",
                                "pitch_deg",
                                format!("{:?}", rounded_to_multiple(camera.pitch, 0.01)),
                            ),
                            SceneEdit::set(
                                "camera",
                                "yaw_deg",
                                format!("{:?}", rounded_to_multiple(camera.yaw, 0.01)),
                            ),
                        ]);
                    }
                });
                self.form.group(ui, scene, key, |_| true, changes);
            });
        }
    }

    /// Lays out the lists of the scene, with their first entries.
    fn lists(&mut self, ui: &mut Ui, scene: &Scene, changes: &mut Vec<SceneEdit>) {
        for list in LISTS {
            let count = self.form.count(list);
            if count == 0 {
                continue;
            }
            let title = capital(&format!("{list}: {count}"));
            CollapsingHeader::new(title).id_salt(("list", list)).show(ui, |ui| {
                for index in 0..count.min(TITLES) {
                    self.list_entry(ui, scene, list, index, false, changes);
                }
                if count > TITLES {
                    ui.weak(format!("and {} more, in the file", count - TITLES));
                }
            });
        }
    }

    /// Lays out an entry of a list, folded unless it `is_open` at first.
    fn list_entry(
        &mut self,
        ui: &mut Ui,
        scene: &Scene,
        list: &str,
        index: usize,
        is_open: bool,
        changes: &mut Vec<SceneEdit>,
    ) {
        let path = format!("{list}[{index}]");
        let titles = self.form.titles(scene, list);
        let title = titles.get(index).map(|(title, _)| title.clone()).unwrap_or_default();
        CollapsingHeader::new(title).id_salt(&path).default_open(is_open).show(ui, |ui| {
            if ui.button("Remove").clicked() {
                changes.extend(scene.without(&path));
            }
            self.form.group(ui, scene, &path, |_| true, changes);
        });
    }
}

impl Tool for Editor {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::LEFT_CENTER, [8.0, 0.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        self.laid_out = true;
        self.form.read(&desk.stage.sim().scene);
        self.leave_entry(desk);
        self.file_row(ui, desk);
        self.add_row(ui, desk);
        if let Some(error) = &self.error {
            ui.label(RichText::new(error).color(inks::words(ui.visuals(), FAULT)));
        }
        ui.separator();
        self.selection(ui, desk);
        ui.separator();
        self.of_scene(ui, desk);
        ui.weak("A change restarts the scene, paused: the file says how it starts.");
    }

    fn toggle(&mut self, _: &mut Stage, open: bool) -> bool {
        (self.spring_ends, self.handle) = (None, None);
        !open
    }

    fn take(
        &mut self,
        intent: &Intent,
        stage: &mut Stage,
        view: &View,
        open: bool,
    ) -> Option<Vec<Intent>> {
        Some(match intent {
            Intent::Rewrite(changes, select) => self.rewrite(stage, changes, select.as_deref()),
            Intent::Delete(entry, alone) => self.delete(stage, entry, *alone),
            Intent::Act(Act::Undo) => self.undo(stage),
            Intent::Act(Act::Redo) => self.redo(stage),
            Intent::Act(Act::Duplicate) => self.duplicate(stage, view, open),
            Intent::Act(Act::Delete) => self.delete_selection(stage, open),
            Intent::Act(Act::SaveScene) => {
                self.save_scene(stage);
                Vec::new()
            }
            Intent::Act(Act::SaveBundle) if self.is_unsaved(&stage.sim().scene) => {
                vec![Intent::Act(Act::SaveScene)]
            }
            Intent::Act(_)
            | Intent::Change(..)
            | Intent::Refuse(_)
            | Intent::ApplySetting(_)
            | Intent::Pace(_)
            | Intent::TurnForce(_)
            | Intent::Seek(_)
            | Intent::SaveBundle
            | Intent::SaveTable(_)
            | Intent::Open(_)
            | Intent::OpenLesson(_)
            | Intent::Restart(..)
            | Intent::Ask(_)
            | Intent::Answer(_) => return None,
        })
    }

    /// Takes an end of the spring that is being added, or a handle.
    fn press(&mut self, stage: &Stage, view: &mut View, near_px: f64) -> Option<Vec<Intent>> {
        if self.spring_ends.is_some() {
            let ray = view.picking_ray();
            let body = view.cast(stage, &ray).and_then(|hit| hit.pushed);
            let spring = body.and_then(|body| self.join(stage, stage.name(body)));
            return Some(spring.into_iter().collect());
        }
        if self.has_handles {
            self.handle = Handle::under_pointer(stage, view, near_px);
        }
        self.handle.as_ref().map(|_| Vec::new())
    }

    fn drag(&mut self, view: &View) {
        if let Some(handle) = &mut self.handle {
            handle.follow(view);
        }
    }

    /// Moves the selection as far as its handle was dragged.
    fn release(&mut self, stage: &Stage) -> Vec<Intent> {
        let mut moved = || {
            let handle = self.handle.take().filter(|handle| handle.by != DVec3::ZERO)?;
            let path = selected_entry(stage)?.0.path();
            Some(Intent::Rewrite(stage.sim().scene.shifted(&path, handle.by), Some(path)))
        };
        moved().into_iter().collect()
    }

    fn abandon_drag(&mut self) {
        self.handle = None;
    }

    fn cancel(&mut self) {
        self.cancel_typing();
    }

    fn next_scene(&mut self, rewritten: bool) {
        match rewritten {
            true => self.discard_unfinished(),
            false => *self = Self::default(),
        }
    }

    fn after_ticks(&mut self, _: &mut Stage, view: &View, open: bool, _: FrameTime) {
        let is_seen = open && std::mem::take(&mut self.laid_out);
        self.has_handles = is_seen && view.mode == Mode::Selection && view.view_px.is_some();
    }

    fn draw(&self, stage: &Stage, view: &View, frame: &mut Frame) {
        if let Some(handle) = &self.handle {
            handle.draw(stage, view, frame);
        }
    }

    fn write(
        &self,
        stage: &Stage,
        view: &View,
        painter: &Painter,
        _panel: Option<Rect>,
        mut taken: Vec<Rect>,
    ) {
        let first = self.spring_ends.iter().flatten().next();
        let first = first.and_then(|name| view.label(stage, stage.sim().named(name)?, "", around));
        if let Some((_, end)) = first {
            marks::ring(painter, &end, &[(2.0, POINTER)]);
        }
        if self.has_handles {
            handles::paint_handles(stage, view, painter);
            let wells = bare_wells(&stage.sim().scene, view);
            for well in &wells {
                marks::ring(painter, well, &[(2.0, POINTER)]);
                // Its own words are beside it.
                taken.retain(|place| *place != marks::ring_place(painter, well));
            }
            marks::show(painter, &wells, &mut taken);
        }
    }
}

/// The labels of the wells in the view that no body marks.
fn bare_wells(scene: &Scene, view: &View) -> Vec<Label> {
    let is_bare = |well: &DVec3| !scene.bodies.iter().any(|body| body.position == *well);
    let label = |well| {
        let (at, _) = view.seen_at(well).filter(|(_, inside)| *inside)?;
        Some(Label { at, reach: WELL_PX, text: "well".to_owned() })
    };
    wells(scene).into_iter().filter(is_bare).filter_map(label).collect()
}

/// Requests changes of the scene's text, if there are any. If an entry is renamed, the references to its bodies follow.
fn change(desk: &mut Desk<'_>, changes: Vec<SceneEdit>, select: Option<String>) {
    let scene = &desk.stage.sim().scene;
    let follow = |change: SceneEdit| match name_of(&change) {
        Some((path, name)) => scene.named(path, &name),
        None => vec![change],
    };
    let changes: Vec<_> = changes.into_iter().flat_map(follow).collect();
    if !changes.is_empty() {
        desk.intents.push(Intent::Rewrite(changes, select));
    }
}

/// The path and the new name of the entry that a change renames, if it does.
fn name_of(change: &SceneEdit) -> Option<(&str, String)> {
    let SceneEdit::Set { group, key, value: Some(value) } = change else { return None };
    match scene::Value::read(scene::Kind::Text, value) {
        scene::Value::Text(name) if key == "name" && !group.is_empty() => Some((group, name)),
        scene::Value::Flag(_)
        | scene::Value::Count(_)
        | scene::Value::Number(_)
        | scene::Value::Numbers(_)
        | scene::Value::Text(_)
        | scene::Value::Written(_) => None,
    }
}

/// Length of a substep, s.
fn substep(stage: &Stage) -> f64 {
    let substeps = stage.sim().world.resource::<Substeps>().0;
    stage.sim().world.resource::<TimeStep>().0 / f64::from(substeps)
}

/// The place for an added object: in the middle of the view, on what is seen there.
fn place(stage: &Stage, view: &mut View) -> Place {
    let [_, size_px] = view.view_area();
    let ray = view.viewpoint().ray_through(size_px / 2.0, size_px);
    let hit = view.cast(stage, &ray).map(|hit| hit.distance);
    // Beside the others, as far away as their middle, wherever they are.
    let depth = || Some(View::middle(stage)?.distance(ray.origin()));
    let distance = hit.or_else(depth).filter(|far| *far > 0.0).unwrap_or(AWAY).max(NEAREST);
    let size = rounded_1_2_5(SIZE * distance);
    let at = match hit {
        Some(_) => ray.at(distance) + DVec3::Y * size,
        // The first body of a scene is where everybody looks for it.
        None if stage.sim().scene.bodies.is_empty() => DVec3::ZERO,
        None => ray.at(distance),
    };
    let step = 0.1 * size;
    Place {
        at: at.to_array().map(|part| rounded_to_multiple(part, step)).into(),
        size,
        substep: substep(stage),
    }
}

/// Strength of an added well whose softening is 1 m, m³/s²: a body at ten times that circles it in 20 s.
const WELL: f64 = 100.0;

/// Rounds to 1, 2 or 5 times a power of ten.
fn rounded_1_2_5(number: f64) -> f64 {
    let power = 10.0_f64.powf(number.log10().floor());
    let mantissa =
        [1.0, 2.0, 5.0, 10.0].into_iter().find(|mantissa| number < mantissa * 1.4 * power);
    rounded(mantissa.unwrap_or(10.0) * power, 2)
}
