//! Turns keys and the pointer into intents. Camera, selection, pull, held pushes and click force change at once, without an
//! intent.

use glam::{DVec2, DVec3};
use history::Change;

use crate::actions::{Act, Lasts, binding, shift_is_part_of};
use crate::app::fingers::{Fingers, Gesture};
use crate::app::held::Held;
use crate::app::ui::Ui;
use crate::input::{Button, Input, Key, SwitchedBy, TouchPhase};
use crate::intent::Intent;
use crate::stage::Stage;
use crate::stage::notices::Topic;
use crate::stage::pull::Pull;
use crate::stage::soft::pushes_on;
use crate::stage::things::{Picked, is_movable, pushed};
use crate::tools::Tools;
use crate::view::navigation::Drag;
use crate::view::{Mode, View};

/// Longest time between the two clicks of a double click, s.
const DOUBLE_CLICK_S: f64 = 0.4;

/// Greatest distance that the pointer moves in a click, points.
const CLICK_POINTS: f64 = 4.0;

/// Greatest distance at which a press takes the handle of a tool, points.
const NEAR_POINTS: f64 = 8.0;

/// Held keys and buttons.
#[derive(Default)]
pub(crate) struct Hands {
    pub held: Held,
    /// Time at which the next key goes down or up, s of frame time, if known.
    at: Option<f64>,
    selecting: bool,
    /// Time and place of the last click, s and pixels: a second click soon after it frames the selection.
    clicked: Option<(f64, DVec2)>,
    /// How the pointer moves the camera while a button is down.
    drag: Option<Drag>,
    /// Place of the press of the left button, pixels, and the pull that it may become, until it is a click or a pull.
    pressed: Option<(DVec2, Pull)>,
    /// Place of the press of the right button on what it would push if that were selected, pixels.
    missed: Option<DVec2>,
    fingers: Fingers,
    /// The place about which two fingers move the camera, m.
    pivot: Option<DVec3>,
}

/// The parts of a session that [`Hands`] change.
pub(crate) struct Reach<'a> {
    pub stage: &'a mut Stage,
    pub view: &'a mut View,
    pub ui: &'a mut Ui,
    pub tools: &'a mut Tools,
}

impl Reach<'_> {
    /// The same parts for a shorter time.
    const fn again(&mut self) -> Reach<'_> {
        let Self { stage, view, ui, tools } = self;
        Reach { stage, view, ui, tools }
    }

    /// Whether drags and the wheel move the camera.
    fn moves_camera(&self) -> bool {
        self.ui.cockpit.shown && self.view.mode == Mode::Selection
    }

    /// Converts points to pixels.
    fn pixels(&self, points: f64) -> f64 {
        points * f64::from(self.ui.pixels_per_point())
    }
}

impl Hands {
    /// Handles one input. Returns the intents that it expresses.
    pub fn take(&mut self, input: &Input, mut reach: Reach<'_>) -> Vec<Intent> {
        match input {
            Input::KeyDown(key) => return self.key_down(key, None, reach),
            Input::KeyDownUntil(key, until) => return self.key_down(key, Some(*until), reach),
            Input::KeyUp(key) => {
                self.held.release(key, self.at.take());
                reach.ui.key(key, false);
            }
            Input::At(time) => self.at = Some(*time),
            Input::Text(text) if reach.ui.takes_text() => reach.ui.text(text),
            Input::Compose(text) if reach.ui.takes_text() => reach.ui.compose(text),
            Input::Assist(request) => reach.ui.assist(request),
            Input::Mouse(x, y) => {
                reach.view.by_finger = false;
                match reach.view.mode {
                    Mode::Camera => reach.view.camera.look(*x, *y),
                    Mode::Selection => self.move_pointer(DVec2::new(*x, *y), &mut reach),
                }
            }
            Input::Touch(finger, phase, x, y) => {
                return self.touch(*finger, *phase, DVec2::new(*x, *y), reach);
            }
            Input::ButtonDown(button) => return self.button_down(*button, reach),
            Input::ButtonUp(button) => return self.button_up(*button, reach),
            Input::Wheel(notches) => self.wheel(*notches, &mut reach),
            Input::FocusLost => {
                self.held.release_all();
                self.fingers = Fingers::default();
                self.let_go(&mut reach);
                reach.ui.focus_lost();
            }
            Input::Text(_)
            | Input::Compose(_)
            | Input::Resized(_)
            | Input::Scaled(_)
            | Input::DockWidth(_)
            | Input::Arrange(_)
            | Input::Change(_)
            | Input::Picture(_) => {}
        }
        Vec::new()
    }

    fn key_down(&mut self, key: &Key, until: Option<f64>, reach: Reach<'_>) -> Vec<Intent> {
        let at = self.at.take();
        let Reach { view, ui, .. } = reach;
        let binding = binding(key);
        let is_one_of = |acts: &[Act]| binding.filter(|row| acts.contains(&row.act));
        let leaves =
            is_one_of(&[Act::Cancel, Act::Quit, Act::FocusPanels, Act::Screenshot]).is_some();
        let saves =
            is_one_of(&[Act::SaveBundle, Act::SaveScene, Act::Quit]).filter(|_| ui.takes_text());
        if let Some(row) = saves {
            // The text being typed takes effect first: in the next layout, in which the field has lost the keyboard.
            ui.release_focus();
            ui.postponed.push(row.act);
        } else if (ui.question.is_some() || ui.takes_key(key)) && !leaves {
            ui.key(key, true);
        } else if let Some(binding) = binding {
            if shift_is_part_of(key) {
                let moved_s = self.held.take_shift();
                view.camera.fly(DVec3::Y, moved_s);
            }
            match binding.lasts {
                Lasts::While(hold) => self.held.press(key, hold, at, until),
                Lasts::Once | Lasts::Repeatedly => return vec![Intent::Act(binding.act)],
            }
        }
        Vec::new()
    }

    /// Handles a finger: one is the left button, or looks around in camera mode; two move the camera.
    fn touch(
        &mut self,
        finger: u64,
        phase: TouchPhase,
        at: DVec2,
        mut reach: Reach<'_>,
    ) -> Vec<Intent> {
        reach.ui.touch(finger, phase, at);
        reach.view.by_finger = true;
        let looks = reach.view.mode == Mode::Camera;
        if phase == TouchPhase::Down {
            self.pivot = None;
            if !looks && !self.fingers.any() {
                self.move_pointer(at, &mut reach);
            }
        }
        let on_panel = !looks && reach.ui.wants_pointer();
        let click = reach.pixels(CLICK_POINTS);
        let gestures = self.fingers.take(finger, phase, at, on_panel, click);
        gestures.into_iter().flat_map(|gesture| self.gesture(gesture, reach.again())).collect()
    }

    fn gesture(&mut self, gesture: Gesture, mut reach: Reach<'_>) -> Vec<Intent> {
        let (looks, moves_camera) = (reach.view.mode == Mode::Camera, reach.moves_camera());
        let Reach { stage, view, ui, .. } = reach.again();
        match gesture {
            Gesture::Move { by, .. } if looks => view.camera.look(by.x, by.y),
            Gesture::Move { to, .. } => self.move_pointer(to, &mut reach),
            Gesture::Hold => {
                let mut intents = self.button_down(Button::Right, reach.again());
                intents.extend(self.button_up(Button::Right, reach));
                return intents;
            }
            Gesture::Press => return self.button_down(Button::Left, reach),
            Gesture::Release => {
                let intents = self.button_up(Button::Left, reach.again());
                reach.ui.pointer_gone();
                return intents;
            }
            Gesture::LetGo => {
                self.let_go(&mut reach);
                reach.ui.focus_lost();
            }
            Gesture::Orbit(_) | Gesture::Pinch { .. } if !moves_camera => {}
            Gesture::Orbit(by) => {
                let pivot = self.pivot_of_fingers(view, stage);
                view.drag(Drag::Orbit(pivot), by, ui.pixels_per_point());
            }
            Gesture::Pinch { by, times } => {
                let pivot = self.pivot_of_fingers(view, stage);
                view.drag(Drag::Pan(pivot), by, ui.pixels_per_point());
                view.approach(pivot, times.recip());
            }
        }
        Vec::new()
    }

    /// The place that was between two fingers when they first moved, m.
    fn pivot_of_fingers(&mut self, view: &mut View, stage: &Stage) -> DVec3 {
        *self.pivot.get_or_insert_with(|| {
            view.pointer = self.fingers.span().0;
            view.pivot(stage)
        })
    }

    fn move_pointer(&mut self, to: DVec2, reach: &mut Reach<'_>) {
        let click = reach.pixels(CLICK_POINTS);
        let Reach { stage, view, ui, tools } = reach;
        let before = std::mem::replace(&mut view.pointer, to);
        ui.pointer(to.x, to.y);
        if let Some((_, pull)) = self.pressed.take_if(|(from, _)| from.distance(to) > click) {
            stage.set_pull(Some(pull));
        }
        if let Some(drag) = self.drag {
            view.drag(drag, to - before, ui.pixels_per_point());
        }
        tools.each().for_each(|(_, tool)| tool.drag(view));
    }

    /// Scrolls a panel, zooms, or changes the force of a click. The wheel changes the force if it cannot move the camera, if
    /// there is something to push, or if Ctrl is held.
    fn wheel(&mut self, notches: f64, reach: &mut Reach<'_>) {
        let moves_camera = reach.moves_camera();
        let Reach { stage, view, ui, .. } = reach;
        let pushes = stage.sim().scene.push.is_some() && moves_selection(stage);
        if view.mode == Mode::Selection && ui.wants_pointer() {
            ui.wheel(notches);
        } else if notches.is_finite() {
            match moves_camera && !pushes && !self.held.changes_force() {
                true => view.zoom(stage, notches),
                false => view.turn_force(stage, notches),
            }
        }
    }

    fn button_down(&mut self, button: Button, mut reach: Reach<'_>) -> Vec<Intent> {
        let selects = reach.view.mode == Mode::Selection;
        let over_panel = selects && reach.ui.wants_pointer();
        if selects {
            reach.ui.button(button, true);
        }
        if over_panel {
            return Vec::new();
        }
        let (moves_camera, near_px) = (reach.moves_camera(), reach.pixels(NEAR_POINTS));
        match button {
            Button::Left if selects => {
                let Reach { stage, view, ui, tools } = &mut reach;
                if let Some(intents) = tools.press(stage, view, near_px, ui.opened()) {
                    return intents;
                }
                // As in the tutorial, a drag selects whatever it passes over; in the cockpit, it pulls what was pressed.
                self.selecting = !moves_camera;
                self.select(&mut reach);
                if moves_camera {
                    let Reach { stage, view, .. } = reach;
                    self.pressed = view.take(stage).map(|pull| (view.pointer, pull));
                }
            }
            Button::Right => return self.push_or_orbit(reach),
            Button::Middle if moves_camera => {
                self.drag = Some(Drag::Pan(reach.view.pivot(reach.stage)));
            }
            Button::Left | Button::Middle => {}
        }
        Vec::new()
    }

    fn button_up(&mut self, button: Button, reach: Reach<'_>) -> Vec<Intent> {
        let moves_camera = reach.moves_camera();
        let click = reach.pixels(CLICK_POINTS);
        let Reach { stage, view, ui, tools } = reach;
        let over_panel = view.mode == Mode::Selection && ui.wants_pointer();
        // A button that went down in one mode may come up in the other.
        ui.button(button, false);
        if button != Button::Left {
            self.drag = None;
            // A drag that began there turned the camera.
            let is_click = |at: DVec2| at.distance(view.pointer) <= click;
            if self.missed.take().is_some_and(is_click) && button == Button::Right {
                let what = "click a body first: a right click pushes what is selected";
                stage.notices.say(Topic::Other, what);
            }
            return Vec::new();
        }
        let mut intents = Vec::new();
        if moves_camera && stage.here().pull.is_none() && !over_panel {
            let (now, at) = (stage.playback().now(), view.pointer);
            let double = self.clicked.take().is_some_and(|(then, place)| {
                now - then <= DOUBLE_CLICK_S && place.distance(at) <= click
            });
            if !double {
                self.clicked = Some((now, at));
            } else if stage.selection().is_some() {
                intents.push(Intent::Act(Act::Frame));
            }
        }
        self.selecting = false;
        self.pressed = None;
        stage.set_pull(None);
        intents.extend(tools.each().flat_map(|(_, tool)| tool.release(stage)));
        intents
    }

    /// Flies the camera by held keys, selects by a held button, and aims the pull at the pointer. Call it once per frame.
    pub fn steer(&mut self, seconds: f64, mut reach: Reach<'_>) -> Vec<Intent> {
        self.at = None;
        let held = self.fingers.rest(seconds);
        let intents = held.map(|held| self.gesture(held, reach.again())).unwrap_or_default();
        let flight = self.held.flight(seconds);
        let Reach { view, .. } = &mut reach;
        if view.mode == Mode::Camera && view.locked.is_none() {
            view.camera.fly(flight, seconds);
        }
        if self.selecting {
            self.select(&mut reach);
        }
        let Reach { stage, view, .. } = reach;
        if let Some(pull) = stage.pull_mut() {
            pull.toward = view.pulled_toward(pull.depth);
        }
        intents
    }

    /// Whether something changes while the hands rest.
    pub fn act_by_themselves(&self) -> bool {
        !self.held.is_empty() || self.fingers.waits()
    }

    /// Sets the pushes of keys for the tick that ends at `due`, s of frame time, known to within `nearly` s.
    pub fn push(&mut self, due: f64, nearly: f64, reach: Reach<'_>) {
        let newtons = self.held.push(due, nearly);
        let Reach { stage, view, .. } = reach;
        let selected = stage.selection().filter(|_| view.mode == Mode::Selection);
        let held = match selected {
            Some(thing) if newtons != DVec3::ZERO => pushes_on(&stage.sim().world, thing, newtons),
            _ => Vec::new(),
        };
        stage.hold(held);
    }

    /// Selects what is under the pointer. Clears the selection if nothing is there, or if it cannot be moved and
    /// [`Self::selects_immovable`] does not allow it.
    fn select(&mut self, reach: &mut Reach<'_>) {
        let wanted = self.selects_immovable(reach.stage, reach.ui);
        let Reach { stage, view, .. } = reach;
        let ray = view.picking_ray();
        let hit = view.cast(stage, &ray).map(|hit| hit.entity);
        stage.select(hit.filter(|hit| wanted || is_movable(&stage.sim().world, *hit)));
    }

    /// Whether a click selects bodies that cannot be moved: if a key says so or, outside the cockpit, the scene. In the cockpit a
    /// click beside a body deselects.
    pub fn selects_immovable(&self, stage: &Stage, ui: &Ui) -> bool {
        let by_scene = stage.sim().scene.select_immovable && !ui.cockpit.shown;
        by_scene || self.held.selects_immovable()
    }

    /// Pushes the selection along the ray if the ray hits it first. Beside it, or if it cannot be moved, begins a drag that
    /// orbits.
    fn push_or_orbit(&mut self, reach: Reach<'_>) -> Vec<Intent> {
        let moves_camera = reach.moves_camera();
        let Reach { stage, view, .. } = reach;
        let ray = view.picking_ray();
        let selected = stage.selection().filter(|_| stage.sim().scene.push.is_some());
        let hit = selected
            .and_then(|selected| view.cast(stage, &ray).filter(|hit| hit.entity == selected));
        if !(hit.is_some() && moves_selection(stage)) && moves_camera {
            self.drag = Some(Drag::Orbit(view.pivot(stage)));
        }
        let Some((hit, body)) = hit.and_then(|hit| Some((hit, hit.pushed?))) else {
            let movable = |hit: Picked| is_movable(&stage.sim().world, hit.entity);
            let pushes = moves_camera && !view.by_finger && stage.sim().scene.push.is_some();
            let missed = pushes && view.cast(stage, &ray).is_some_and(movable);
            self.missed = missed.then_some(view.pointer);
            return Vec::new();
        };
        let (at, newtons) = (ray.at(hit.distance), ray.direction() * view.click_force);
        view.flash(stage, body, at, newtons);
        let push = |(id, share)| Intent::Change(Change::Push(id, newtons * share), SwitchedBy::Key);
        pushed(stage.sim(), body, at).into_iter().map(push).collect()
    }

    /// Ends everything that held mouse buttons do.
    pub fn let_go(&mut self, reach: &mut Reach<'_>) {
        self.selecting = false;
        (self.drag, self.pressed, self.missed) = (None, None, None);
        reach.stage.set_pull(None);
        reach.tools.each().for_each(|(_, tool)| tool.abandon_drag());
    }

    /// Forgets the press, which was in another world.
    pub const fn forget_world(&mut self) {
        (self.pressed, self.missed) = (None, None);
    }

    /// Changes between the two modes.
    pub fn toggle_mode(&mut self, mut reach: Reach<'_>) {
        self.let_go(&mut reach);
        let Reach { view, ui, .. } = reach;
        view.mode = match view.mode {
            Mode::Camera => Mode::Selection,
            Mode::Selection => Mode::Camera,
        };
        // The pointer appears where the cross-hair was, and leaves the panels when it is grabbed.
        let [corner, size] = view.view_area();
        view.pointer = corner + size / 2.0;
        match view.mode {
            Mode::Camera => ui.pointer_gone(),
            Mode::Selection => ui.pointer(view.pointer.x, view.pointer.y),
        }
    }
}

/// Whether something is selected that forces move.
fn moves_selection(stage: &Stage) -> bool {
    stage.selection().is_some_and(|thing| is_movable(&stage.sim().world, thing))
}
