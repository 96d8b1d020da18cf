//! The keys of a group of the scene's text as rows with a field each.

use std::collections::HashMap;
use std::sync::Arc;

use egui::{Align, ComboBox, Grid, Layout, PopupCloseBehavior, Response, TextEdit, Ui, Vec2};
use motion::{DampingModel, Method};
use report::numbers::{capital, rounded};
use scene::{BodySpec, Field, Kind, Scene, TextEdit as Change, Value};

use crate::tools::number::{count_field, number_field};
use crate::words::{label, plain};

/// Lists whose entries have no body to be selected by.
pub(super) const LISTS: [&str; 5] = ["wells", "thrusts", "moves", "emitters", "springs"];

/// Width of labels and of values, points: of all groups, so that they are below each other.
const LABEL: f32 = 74.0;
const FIELD: f32 = 140.0;

/// Width of the frame of a field for text, points.
const FRAME: f32 = 8.0;

/// Greatest number of entries of a list that are shown.
pub(super) const TITLES: usize = 50;

/// Gravity near the ground.
pub(super) const EARTH: &str = "(acceleration_m_s2: (0.0, -9.8, 0.0))";

/// First values of added keys, where their kind does not determine one.
const BEGINNINGS: [(&str, &str); 19] = [
    ("color", "(1.0, 1.0, 1.0)"),
    ("shape", "sphere(radius_m: 1.0)"),
    ("half_extents_m", "(1.0, 1.0, 1.0)"),
    ("size_m", "(1.0, 1.0, 1.0)"),
    ("spacing_m", "(3.5, 3.5)"),
    ("curve", "polynomial([(0.0, 10.0, 0.0)])"),
    ("locked_axes", "[y]"),
    ("pinned", "[]"),
    ("gravity", EARTH),
    ("damping", "(model: exact, rate_per_s: 0.4)"),
    ("drag", "(linear_per_s: 0.1)"),
    ("wind", "(velocity_m_s: (5.0, 0.0, 0.0))"),
    ("mutual_gravity", "(constant_m3_kg_s2: 1.0)"),
    ("range", "(position_m: 1000.0)"),
    ("push", "(start_n: 10.0, newtons_per_notch: 100.0)"),
    ("light", "(position_m: (-60.0, 80.0, 100.0), color: (1.0, 1.0, 0.9), shadows: true)"),
    ("camera", "(position_m: (-60.0, 40.0, 60.0), pitch_deg: -15.0, yaw_deg: 315.0)"),
    ("expect", "(finite: true)"),
    ("direction", "(0.0, 1.0, 0.0)"),
];

/// The words that a key takes, if they are few.
fn words(key: &str) -> Vec<&'static str> {
    match key {
        "method" => Method::ALL.iter().map(|method| method.name()).collect(),
        "model" => DampingModel::ALL.iter().map(|model| model.name()).collect(),
        "texture" => vec!["checker", "none"],
        "kind" => vec!["mixed", "cubes", "spheres"],
        "step" => vec!["fixed", "frame"],
        _ => Vec::new(),
    }
}

/// The values that were read from the text of a scene, and the edits in progress.
#[derive(Default)]
pub(super) struct Form {
    text: Arc<str>,
    groups: HashMap<String, Vec<Row>>,
    /// The keys of the scene itself.
    root: Vec<Field>,
    /// Number of entries of each list.
    lists: HashMap<&'static str, usize>,
    /// Titles of the entries of lists without bodies, and the bodies that each names.
    titles: HashMap<String, Vec<(String, Vec<String>)>>,
    /// Number of further layouts that drop what was typed, after a cancel.
    canceled: u8,
}

struct Row {
    field: Field,
    /// The value as the person has changed it so far.
    edited: Option<Value>,
}

impl Form {
    /// Forgets changes that were not applied.
    pub fn forget(&mut self) {
        self.groups.clear();
    }

    /// Reads the text of `scene`, if it is not the one that was read last.
    pub fn read(&mut self, scene: &Scene) {
        if self.canceled > 0 {
            self.canceled -= 1;
            self.groups.clear();
        }
        if !Arc::ptr_eq(&self.text, &scene.text) {
            *self = Self {
                text: Arc::clone(&scene.text),
                root: scene.fields(""),
                lists: LISTS.into_iter().zip(scene.counts(LISTS)).collect(),
                ..Self::default()
            };
        }
    }

    /// Forgets what is being typed. Lasts for some layouts, because a field applies its text up to two layouts after it lost the
    /// keyboard.
    pub fn cancel(&mut self) {
        self.canceled = 3;
    }

    /// Takes the changes in the group at `path` that were not applied, because its fields were no longer laid out.
    pub fn left(&mut self, path: &str) -> Vec<Change> {
        let mut changes = Vec::new();
        for group in [path.to_owned(), format!("{path}.shape")] {
            for Row { field, edited } in self.groups.remove(&group).into_iter().flatten() {
                if let Some(edited) = edited.filter(|edited| Some(edited) != field.value.as_ref()) {
                    changes.push(Change::set(&*group, field.key, edited.to_string()));
                }
            }
        }
        changes
    }

    /// The sections that the text has.
    pub fn sections(&self) -> Vec<&'static str> {
        let written =
            self.root.iter().filter(|field| field.kind == Kind::Group && field.value.is_some());
        written.map(|field| field.key).collect()
    }

    /// Number of entries of a list.
    pub fn count(&self, list: &str) -> usize {
        self.lists.get(list).copied().unwrap_or(0)
    }

    /// The titles of the first entries of a list without bodies, at most [`TITLES`], and the bodies that each names.
    pub fn titles(&mut self, scene: &Scene, list: &str) -> &[(String, Vec<String>)] {
        let count = self.count(list).min(TITLES);
        self.titles.entry(list.to_owned()).or_insert_with(|| {
            let paths: Vec<_> = (0..count).map(|index| format!("{list}[{index}]")).collect();
            let fields = scene.fields_of(&paths.iter().map(String::as_str).collect::<Vec<_>>());
            let both = paths.iter().zip(&fields);
            both.map(|(path, fields)| (title(path, fields), bodies_in(fields))).collect()
        })
    }

    /// The first entries of a list without bodies that name `body`.
    pub fn naming(&mut self, scene: &Scene, list: &str, body: &str) -> Vec<usize> {
        let titles = self.titles(scene, list).iter().enumerate();
        let naming = titles.filter(|(_, (_, bodies))| bodies.iter().any(|name| name == body));
        naming.map(|(index, _)| index).collect()
    }

    /// Lays out the keys of the group at `path` that `shown` lets through; pushes what the person changed.
    pub fn group(
        &mut self,
        ui: &mut Ui,
        scene: &Scene,
        path: &str,
        shown: fn(&Field) -> bool,
        changes: &mut Vec<Change>,
    ) {
        self.rows(ui, scene, path, shown, changes);
        let rows = self.groups.get(path).into_iter().flatten();
        if rows.into_iter().any(|row| row.field.key == "shape" && row.field.value.is_some()) {
            self.rows(ui, scene, &format!("{path}.shape"), |field| field.value.is_some(), changes);
        }
        let rows = self.groups.get(path).into_iter().flatten();
        let absent: Vec<_> = rows.filter(|row| row.field.value.is_none()).collect();
        if !absent.is_empty() {
            ui.menu_button("Add a value", |ui| {
                for Row { field, .. } in absent {
                    let (words, unit) = label(field.key);
                    let words = if unit.is_empty() { words } else { format!("{words}, {unit}") };
                    if ui.button(words).clicked() {
                        changes.push(Change::set(path, field.key, beginning(field, scene)));
                        // Its place is then one on the body, or that of the body.
                        if field.key == "rides_on" {
                            let value =
                                path.starts_with("emitters").then(|| "(0.0, 0.0, 0.0)".to_owned());
                            let (group, key) = (path.to_owned(), "position_m".to_owned());
                            changes.push(Change::Set { group, key, value });
                        }
                    }
                }
            });
        }
    }

    /// Lays out the keys that the text has.
    fn rows(
        &mut self,
        ui: &mut Ui,
        scene: &Scene,
        path: &str,
        shown: fn(&Field) -> bool,
        changes: &mut Vec<Change>,
    ) {
        let rows = self.groups.entry(path.to_owned()).or_insert_with(|| {
            let row = |field: Field| Row { edited: field.value.clone(), field };
            scene.fields(path).into_iter().filter(shown).map(row).collect()
        });
        Grid::new(("form", path)).num_columns(3).show(ui, |ui| {
            for Row { field, edited } in rows.iter_mut() {
                let (Some(value), Some(edited)) = (&field.value, edited) else { continue };
                let (words, unit) = label(field.key);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    ui.set_min_width(LABEL);
                    ui.weak(words).on_hover_text(field.key);
                });
                let name = format!("{path} {}", field.key);
                let changed = ui.vertical(|ui| {
                    ui.set_min_width(FIELD);
                    widget(ui, scene, [&name, field.key, unit], edited)
                });
                if changed.inner && edited != value && self.canceled == 0 {
                    changes.push(Change::set(path, field.key, edited.to_string()));
                }
                let removes =
                    ui.small_button("\u{1f5d1}").on_hover_text("Remove; the default applies.");
                if removes.clicked() {
                    changes.push(Change::Set {
                        group: path.to_owned(),
                        key: field.key.to_owned(),
                        value: None,
                    });
                }
                ui.end_row();
            }
        });
    }
}

fn beginning(field: &Field, scene: &Scene) -> String {
    let known = BEGINNINGS.iter().find(|(key, _)| *key == field.key);
    match field.kind {
        _ if field.key == "name" => Value::Text(scene.fresh_name("body")).to_string(),
        _ if matches!(field.key, "body" | "rides_on") => Value::Text(mover(scene)).to_string(),
        _ if field.key == "bodies" => format!("{:?}", bodies(scene).take(1).collect::<Vec<_>>()),
        _ if field.key == "method" => scene.method.name().to_owned(),
        _ if known.is_some() => known.map_or_else(String::new, |(_, text)| (*text).to_owned()),
        Kind::Flag => "true".to_owned(),
        Kind::Count => "1".to_owned(),
        Kind::Number => "1.0".to_owned(),
        Kind::Numbers(count) => Value::Numbers(vec![0.0; count]).to_string(),
        Kind::Text => Value::Text(field.key.to_owned()).to_string(),
        Kind::Word => words(field.key).first().map_or_else(String::new, |word| (*word).to_owned()),
        Kind::Group => "()".to_owned(),
        Kind::Other => "[]".to_owned(),
    }
}

/// The largest count that a field takes: above it, not every whole number is a floating-point one.
const MOST_COUNT: f64 = 9_007_199_254_740_992.0;

/// Lays out a widget for a value. Returns whether the person has finished changing it.
fn widget(ui: &mut Ui, scene: &Scene, [name, key, unit]: [&str; 3], value: &mut Value) -> bool {
    let done = |response: Response| response.drag_stopped() || response.lost_focus();
    // A longer list is no help: there, names are typed.
    let has_few = scene.bodies.len() - scene.particles_in_pools() <= MOST_PICKED;
    match value {
        Value::Flag(flag) => ui.checkbox(flag, "").changed(),
        Value::Count(count) => done(count_field(ui, count, 0.0..=MOST_COUNT, "")),
        Value::Number(number) => done(drag(ui, number, &format!(" {unit}"))),
        Value::Numbers(numbers) if key == "color" => color(ui, numbers),
        Value::Numbers(numbers) => {
            ui.horizontal(|ui| {
                // Three long numbers fit into the dock at its usual width.
                ui.spacing_mut().item_spacing.x = 2.0;
                ui.spacing_mut().button_padding.x = 2.0;
                // All of them are laid out, whichever is done.
                let done =
                    numbers.iter_mut().fold(false, |any, number| done(drag(ui, number, "")) | any);
                ui.label(unit);
                done
            })
            .inner
        }
        Value::Text(text) if matches!(key, "body" | "rides_on") && has_few => {
            body(ui, name, scene, text)
        }
        Value::Text(text) => done(ui.add(field(TextEdit::singleline(text)))),
        Value::Written(written) if key == "shape" => shape(ui, name, written),
        Value::Written(written) if key == "between" && has_few && quoted(written).len() == 2 => {
            let mut ends = quoted(written);
            let mut one =
                |i: usize, ui: &mut Ui| body(ui, &format!("{name} {i}"), scene, &mut ends[i]);
            let picked = ui.vertical(|ui| one(0, ui) | one(1, ui)).inner;
            if picked {
                *written = format!("({:?}, {:?})", ends[0], ends[1]);
            }
            picked
        }
        Value::Written(written) if key == "bodies" && has_few => {
            let mut chosen = quoted(written);
            let before = chosen.len();
            let list = ComboBox::from_id_salt(name).selected_text(format!("{before} picked"));
            let list = list.height(400.0).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
            list.show_ui(ui, |ui| {
                for other in bodies(scene) {
                    let mut is_chosen = chosen.contains(&other);
                    if ui.checkbox(&mut is_chosen, &other).changed() {
                        chosen.retain(|name| *name != other);
                        chosen.extend(is_chosen.then_some(other));
                    }
                }
            });
            let is_other = chosen.len() != before;
            if is_other {
                *written = format!("{chosen:?}");
            }
            is_other
        }
        Value::Written(written) => {
            let words = words(key);
            if words.is_empty() {
                return done(ui.add(field(TextEdit::singleline(written).code_editor())));
            }
            let before = written.clone();
            let list = ComboBox::from_id_salt(name).selected_text(plain(written)).height(400.0);
            list.show_ui(ui, |ui| {
                for word in words {
                    ui.selectable_value(written, word.to_owned(), plain(word));
                }
            });
            before != *written
        }
    }
}

/// A field for text as wide as [`FIELD`]: a cell of a grid would leave it the width that the cell had before.
fn field(text: TextEdit<'_>) -> TextEdit<'_> {
    text.desired_width(FIELD - FRAME).min_size(Vec2::X * FIELD)
}

/// Greatest number of bodies in a list to pick from.
const MOST_PICKED: usize = 200;

/// The bodies of a scene and their names, but for the particles of emitters.
fn named(scene: &Scene) -> impl Iterator<Item = (&BodySpec, String)> {
    let all = (0..).zip(&scene.bodies).filter(|(id, _)| !scene.is_particle(*id));
    all.filter_map(|(id, body)| Some((body, scene.names.get(id)?.into_owned())))
}

fn bodies(scene: &Scene) -> impl Iterator<Item = String> {
    named(scene).map(|(_, name)| name)
}

/// The name of a body to begin with: the first that moves.
fn mover(scene: &Scene) -> String {
    let mover = named(scene).find(|(body, _)| body.is_movable()).map(|(_, name)| name);
    mover.or_else(|| bodies(scene).next()).unwrap_or_default()
}

/// The texts in quotes.
fn quoted(written: &str) -> Vec<String> {
    written.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Lays out a list of bodies to pick one from.
fn body(ui: &mut Ui, name: &str, scene: &Scene, picked: &mut String) -> bool {
    let before = picked.clone();
    ComboBox::from_id_salt(name).selected_text(&*before).height(400.0).show_ui(ui, |ui| {
        for other in bodies(scene) {
            ui.selectable_value(picked, other.clone(), other);
        }
    });
    before != *picked
}

/// Lays out a color to pick. It is finished once nothing is dragged or typed.
fn color(ui: &mut Ui, numbers: &mut [f64]) -> bool {
    let before = [0, 1, 2].map(|channel| (255.0 * numbers[channel]).round() as u8);
    let mut picked = before;
    ui.color_edit_button_srgb(&mut picked);
    for (i, number) in numbers.iter_mut().enumerate().take(3) {
        if picked[i] != before[i] {
            *number = rounded(f64::from(picked[i]) / 255.0, 3);
        }
    }
    !ui.ctx().text_edit_focused() && !ui.input(|input| input.pointer.any_down())
}

/// Lays out the kind of a shape. Another kind keeps the size, which has its own row.
fn shape(ui: &mut Ui, name: &str, written: &mut String) -> bool {
    let size = written
        .split(|c: char| !matches!(c, '0'..='9' | '.' | 'e' | '-'))
        .find_map(|word| word.parse().ok());
    let size: f64 = size.unwrap_or(1.0);
    let shapes = [
        ("sphere", format!("sphere(radius_m: {size:?})")),
        ("cuboid", format!("cuboid(half_extents_m: ({size:?}, {size:?}, {size:?}))")),
    ];
    let is = |kind: &str| written.starts_with(kind);
    let present = shapes.iter().map(|(kind, _)| *kind).find(|kind| is(kind)).unwrap_or_default();
    let mut chosen = present;
    ComboBox::from_id_salt(name).selected_text(present).show_ui(ui, |ui| {
        for (kind, _) in &shapes {
            ui.selectable_value(&mut chosen, *kind, *kind);
        }
    });
    let other = shapes.iter().find(|(kind, _)| *kind == chosen && chosen != present);
    other.inspect(|(_, text)| text.clone_into(written)).is_some()
}

/// Lays out a field for a number that changes, when dragged, in proportion to its size.
fn drag(ui: &mut Ui, number: &mut f64, suffix: &str) -> Response {
    let speed = 0.01 * number.abs().max(0.1);
    number_field(ui, number, speed, suffix)
}

/// The names of bodies in the values of an entry.
fn bodies_in(fields: &[Field]) -> Vec<String> {
    let names = |field: &&Field| matches!(field.key, "between" | "body" | "bodies" | "rides_on");
    let values = fields.iter().filter(names).filter_map(|field| field.value.as_ref());
    values.flat_map(|value| quoted(&value.to_string())).collect()
}

/// The title of the entry at `path`: its path, and what names it.
fn title(path: &str, fields: &[Field]) -> String {
    let of = |key: &str| {
        fields.iter().find(|field| field.key == key)?.value.as_ref().map(ToString::to_string)
    };
    let what = ["name", "between", "body", "position_m"].into_iter().find_map(of);
    let path = capital(&plain(path));
    what.map_or_else(|| path.clone(), |what| format!("{path}: {}", what.replace('"', "")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_words_with_units() {
        for (key, words, unit) in [
            ("position_m", "position", "m"),
            ("velocity_m_s", "velocity", "m/s"),
            ("constant_m3_kg_s2", "constant", "m³/(kg s²)"),
            ("damping_n_s_m", "damping", "N s/m"),
            ("verlet_previous_position_m", "verlet previous position", "m"),
            ("substeps", "substeps", ""),
        ] {
            assert_eq!(label(key), (words.to_owned(), unit));
        }
    }

    #[test]
    fn every_value_that_can_be_added_to_a_body_or_the_scene_makes_a_scene_or_an_error_that_names_it()
     {
        let text = "(version: 1, bodies: [(position_m: (1.0, 2.0, 3.0))])";
        let scene = Scene::parse("t", text).expect("a scene");
        let mut taken = 0;
        for path in ["", "bodies[0]"] {
            for field in scene.fields(path).iter().filter(|field| field.value.is_none()) {
                let change = Change::set(path, field.key, beginning(field, &scene));
                let after = scene::rewrite("t", text, &[change]).expect("the key is known");
                match Scene::parse("t", &after) {
                    Ok(_) => taken += 1,
                    Err(error) => {
                        assert!(error.to_string().contains(field.key), "{}: {error}", field.key);
                    }
                }
            }
        }
        // The others need more than themselves: position Verlet, a shape, an entry.
        assert!(taken > 30, "{taken}");
    }
}
