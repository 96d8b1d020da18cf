//! The bar at the top: time, method, what is drawn, and the modes.

use egui::{
    Button, Checkbox, ComboBox, PopupCloseBehavior, Response, RichText, Role, Ui, Vec2, WidgetInfo,
};
use history::Change;
use motion::clock::StepClock;
use motion::{AutoSubsteps, Gravity, Method, MutualGravity, Substeps, TimeStep};
use report::numbers::{pace_words, scene_time, tick_rate};
use scene::{BodySpec, Substepping, unsolvable};

use crate::actions::Act;
use crate::app::focus::frame_if_lesson_names;
use crate::input::SwitchedBy;
use crate::intent::Intent;
use crate::methods;
use crate::panels::Panel;
use crate::stage::Stage;
use crate::tools::number::{count_field, number_field};
use crate::view::{Mode, View};

/// Paces of the list, as multiples of the pace of the scene.
const PACES: [f64; 9] = [1.0 / 64.0, 1.0 / 16.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// Time until a held button acts for the first time, s.
const REPEAT_AFTER_S: f64 = 0.4;
/// Time between two later actions of a held button, s.
const REPEAT_EVERY_S: f64 = 0.05;

/// Least size of the button that pauses, points: with "Play" it is as wide as with "Pause", so that no button moves when it is
/// pressed.
const PAUSE: Vec2 = Vec2::new(72.0, 0.0);

/// Least width of the bar at which the last buttons have words beside their icons, points: in a narrower bar the words would take
/// a second row.
const ROOM_FOR_WORDS: f32 = 1400.0;

/// Least width of the bar at which what is drawn is switched by buttons, and not in a menu, points.
const ROOM_FOR_ALL: f32 = 1100.0;

/// Least width of the bar at which the first buttons have words beside their icons, points: on a phone they have none.
const ROOM_FOR_NAMES: f32 = 560.0;

/// Width of the list of methods, points.
const LIST: f32 = 440.0;

/// Lays out the bar. Returns its first control.
pub(super) fn show(
    ui: &mut Ui,
    stage: &Stage,
    view: &View,
    browses: bool,
    dock: bool,
    learns: bool,
    intents: &mut Vec<Intent>,
) -> Response {
    let width = ui.available_width();
    let shown = ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.spacing_mut().button_padding.x = 3.0;
        let named = width >= ROOM_FOR_NAMES;
        let scenes = act(ui, intents, Act::ToggleBrowser, ("☰", "Scenes"), browses, named);
        act(ui, intents, Act::Panel(Panel::Learn), ("🎓", "Learn"), learns, named);
        ui.separator();
        let words = if stage.playback().paused() { ("⏵", "Play") } else { ("⏸", "Pause") };
        let fill = ui.visuals().selection.bg_fill;
        let pause =
            act_by(ui, intents, Act::Pause, words.1, Button::new(words).fill(fill).min_size(PAUSE));
        frame_if_lesson_names(ui, if stage.playback().paused() { "Pause" } else { "Play" }, &pause);
        act_while_held(ui, intents, Act::StepBack, ("⏮", "Back"), named);
        act_while_held(ui, intents, Act::Step, ("⏭", "Step"), named);
        act(ui, intents, Act::ResetWorld, ("⟲", "Reset"), false, named);
        pace(ui, stage, intents);
        let seconds = stage.sim().world.resource::<StepClock>().scene_seconds();
        let step = stage.sim().world.resource::<TimeStep>().0;
        ui.monospace(format!("{:>9}", scene_time(seconds, step)));
        ui.separator();
        method(ui, stage, intents);
        ui.separator();
        // Grayed in a scene without gravity, so that every button keeps its place.
        let gravity = stage.sim().world.get_resource::<Gravity>();
        ui.add_enabled_ui(gravity.is_some(), |ui| {
            let on = gravity.is_some_and(|gravity| gravity.on);
            let button = act(ui, intents, Act::ToggleGravity, ("⬇", "Gravity"), on, true);
            button.on_disabled_hover_text("This scene has no gravity; Build adds it.");
        });
        let drawn = |ui: &mut Ui, intents: &mut Vec<Intent>| {
            let list = [
                (Act::VelocityArrows, ("➡", "Velocity"), view.velocity_arrows),
                (Act::ForceArrows, ("⬈", "Forces"), view.force_arrows),
                (Act::Springs, ("➿", "Springs"), view.springs),
                (Act::Trails, ("☄", "Trails"), view.trails),
            ];
            for (action, words, on) in list {
                act(ui, intents, action, words, on, true);
            }
        };
        // In a narrower bar these would take another row.
        if width >= ROOM_FOR_ALL {
            drawn(ui, intents);
        } else {
            ui.menu_button("Show", |ui| drawn(ui, intents));
        }
        ui.separator();
        let list = [
            (Act::Frame, ("⛶", "Frame"), false),
            (Act::ToggleMode, ("✈", "Fly"), view.mode == Mode::Camera),
            (Act::ToggleDock, ("🛠", "Tools"), dock),
            (Act::Panel(Panel::Help), ("❓", "Help"), false),
        ];
        // Help is about keys, which a phone does not have.
        for (action, words, on) in list.into_iter().take(if named { 4 } else { 3 }) {
            act(ui, intents, action, words, on, width >= ROOM_FOR_WORDS);
        }
        scenes
    });
    shown.inner
}

/// The icon and the name of a button.
type Words = (&'static str, &'static str);

/// A button with its icon and, if it is `named`, its name.
fn button_of(on: bool, (icon, name): Words, named: bool) -> Button<'static> {
    if named { Button::selectable(on, (icon, name)) } else { Button::selectable(on, icon) }
}

/// Adds a button for an action of the table; its tooltip says what it does and names its key.
fn act(
    ui: &mut Ui,
    intents: &mut Vec<Intent>,
    action: Act,
    words: Words,
    on: bool,
    named: bool,
) -> Response {
    act_by(ui, intents, action, words.1, button_of(on, words, named))
}

/// Adds a button that repeats its action while it is held, as a key does.
fn act_while_held(ui: &mut Ui, intents: &mut Vec<Intent>, action: Act, words: Words, named: bool) {
    let button = add(ui, action, words.1, button_of(false, words, named));
    let (held, now) = (button.is_pointer_button_down_on(), ui.input(|input| input.time));
    // The time of its next action, and whether it has acted while it was held.
    let (due, acted) =
        ui.data(|data| data.get_temp(button.id)).unwrap_or((now + REPEAT_AFTER_S, false));
    let repeats = held && now >= due;
    if repeats || (button.clicked() && !acted) {
        intents.push(Intent::Act(action));
    }
    ui.data_mut(|data| {
        if held {
            let due = if repeats { now + REPEAT_EVERY_S } else { due };
            data.insert_temp(button.id, (due, acted || repeats));
        } else {
            data.remove_temp::<(f64, bool)>(button.id);
        }
    });
    if held {
        ui.request_repaint();
    }
}

fn act_by(
    ui: &mut Ui,
    intents: &mut Vec<Intent>,
    action: Act,
    name: &str,
    button: Button<'_>,
) -> Response {
    let button = add(ui, action, name, button);
    if button.clicked() {
        intents.push(Intent::Act(action));
    }
    button
}

/// Adds a button, which screen readers call by its `name` without the icon.
fn add(ui: &mut Ui, action: Act, name: &str, button: Button<'_>) -> Response {
    let button = ui.add(button).on_hover_text(action.binding().tooltip());
    button.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
    frame_if_lesson_names(ui, name, &button);
    button
}

/// The paces in the list, simulated seconds per second, for a scene whose own pace is `usual`: multiples of `usual` or, from an
/// hour per second on, round numbers of the unit in which they are shown.
fn paces(usual: f64) -> Vec<f64> {
    const HOUR: f64 = 3_600.0;
    const ROUND: [f64; 12] = [
        1.0, 6.0, 24.0, 72.0, 240.0, 720.0, 1_440.0, 2_880.0, 8_766.0, 26_298.0, 87_660.0,
        876_600.0,
    ];
    if usual < HOUR {
        return PACES.map(|times| times * usual).to_vec();
    }
    let reach = PACES[0] * usual..=PACES[PACES.len() - 1] * usual;
    ROUND.map(|hours| hours * HOUR).into_iter().filter(|pace| reach.contains(pace)).collect()
}

fn pace(ui: &mut Ui, stage: &Stage, intents: &mut Vec<Intent>) {
    let (pace, usual) = (stage.playback().pace(), stage.playback().usual_pace());
    let mut chosen = pace;
    ComboBox::from_id_salt("speed")
        .width(52.0)
        .selected_text(pace_words(pace))
        .show_ui(ui, |ui| {
            for pace in paces(usual) {
                ui.selectable_value(&mut chosen, pace, pace_words(pace));
            }
        })
        .response
        .on_hover_text("simulated seconds per second; the tick stays the same (- and =)");
    if chosen != pace {
        intents.push(Intent::Pace(chosen));
    }
}

/// The tick rate, in words.
pub(super) fn rate(stage: &Stage) -> String {
    tick_rate(stage.sim().world.resource::<TimeStep>().0)
}

/// Lays out the substeps: a number, or the error that they are chosen for.
fn substeps(ui: &mut Ui, stage: &Stage, substeps: &mut Substepping) {
    let mut chooses = substeps.fixed().is_none();
    let takes = |body: &BodySpec| body.is_movable() && body.substeps.is_none();
    let is_taken = stage.sim().scene.bodies.iter().any(takes);
    let choose = Checkbox::new(&mut chooses, "Choose substeps by error");
    ui.add_enabled(is_taken, choose)
        .on_hover_text("as many in every tick as keep its error below this one")
        .on_disabled_hover_text("every body has substeps of its own");
    match substeps.choice() {
        Some(_) if !chooses => *substeps = Substepping::Fixed(1),
        None if chooses => *substeps = Substepping::auto(1e-3),
        Some(choice) => {
            let mut error = choice.error;
            let speed = 0.1 * error;
            number_field(ui, &mut error, speed, " m per tick");
            let other = Substepping::from(AutoSubsteps { error, ..choice });
            if other.fault().is_none() {
                *substeps = other;
            }
        }
        None => {
            let mut number = substeps.least();
            let range = 1.0..=f64::from(Substeps::MOST);
            let unit = if number == 1 { " substep per tick" } else { " substeps per tick" };
            count_field(ui, &mut number, range, unit)
                .on_hover_text("more are more accurate and cost more time");
            *substeps = number.into();
        }
    }
}

/// Lays out method and step as one control: its list has the order and the cost of each method and, at the end, the substeps.
fn method(ui: &mut Ui, stage: &Stage, intents: &mut Vec<Intent>) {
    let setting = stage.setting();
    let mut chosen = setting;
    let attracts = stage.sim().world.contains_resource::<MutualGravity>();
    let present =
        format!("{}, {} x {:#}", setting.method.claims().title, rate(stage), setting.substeps);
    let list = ComboBox::from_id_salt("method of the scene")
        .width(216.0)
        .height(400.0)
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
        .selected_text(present)
        .show_ui(ui, |ui| {
            ui.set_min_width(LIST);
            for method in Method::ALL {
                let why = unsolvable(method, attracts);
                let claims = method.claims();
                ui.add_enabled_ui(why.is_none(), |ui| {
                    let words =
                        format!("order {}, {}", claims.position_order, methods::cost(claims));
                    let is_chosen = chosen.method == method;
                    let row = Button::selectable(is_chosen, claims.title);
                    let row = ui.add(row.right_text(RichText::new(words).weak()));
                    row.widget_info(|| {
                        WidgetInfo::selected(Role::Button, true, is_chosen, claims.title)
                    });
                    if row.on_disabled_hover_text(why.unwrap_or_default()).clicked() {
                        chosen.method = method;
                        ui.close();
                    }
                });
            }
            ui.separator();
            substeps(ui, stage, &mut chosen.substeps);
        })
        .response
        .on_hover_text("method of integration (I and Shift+I)");
    frame_if_lesson_names(ui, "method", &list);
    if chosen.substeps != setting.substeps {
        intents.push(Intent::ApplySetting(chosen));
    } else if chosen.method != setting.method {
        intents.push(Intent::Change(Change::Method(chosen.method), SwitchedBy::Settings));
    }
}
