//! From input to what it means: modes, flying, selecting, pushing, the clock and the panels.
//!
//! Nothing here writes the state of a body: a click becomes a queued push, an edit a queued request.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use motion::effects::Effect;
use motion::{Dormant, Gravity, Method, Push, PushQueue, Request, SoftBody};
use scene::unsolvable;

use crate::actions::{Act, Lasts, binding, takes_shift};
use crate::app::held::{self, Drag};
use crate::app::session::{Session, SwitchedBy};
use crate::input::{Button, Input, Key};
use crate::methods;
use crate::panels::Panel;
use crate::view::notices::Topic;
use crate::view::stage::{Mode, Order};

/// Slowest and fastest pace that the keys reach.
const PACES: std::ops::RangeInclusive<f64> = 1.0 / 64.0..=16.0;

/// Longest time between the two clicks of a double click, s.
const DOUBLE_CLICK_S: f64 = 0.4;

/// A press is a click as long as the pointer stays within so many points.
const CLICK_POINTS: f64 = 4.0;

impl Session {
    pub(crate) fn handle(&mut self, input: &Input) {
        match input {
            Input::KeyDown(key) => self.key_down(key),
            Input::KeyUp(key) => {
                self.hands.held.release(key);
                self.ui.key(key, false);
            }
            Input::Text(text) => {
                if self.ui.takes_text() {
                    self.ui.text(text);
                }
            }
            Input::Mouse(x, y) => match self.view.mode {
                Mode::Camera => self.view.camera.look(*x, *y),
                Mode::Selection => {
                    let before = std::mem::replace(&mut self.view.pointer, DVec2::new(*x, *y));
                    self.ui.pointer(*x, *y);
                    let click = self.click_px();
                    let pointer = self.view.pointer;
                    if let Some((_, pull)) =
                        self.seen.pressed.take_if(|(from, _)| from.distance(pointer) > click)
                    {
                        self.seen.pull = Some(pull);
                    }
                    if let Some(drag) = self.hands.drag {
                        self.drag(drag, self.view.pointer - before);
                    }
                    if let Some(handle) = &mut self.tools.editor.handle {
                        handle.follow(&self.stage);
                    }
                }
            },
            Input::ButtonDown(button) => self.button(*button, true),
            Input::ButtonUp(button) => self.button(*button, false),
            Input::Wheel(notches) => {
                if self.view.mode == Mode::Selection && self.ui.wants_pointer() {
                    self.ui.wheel(*notches);
                } else if notches.is_finite() {
                    match self.zooms() {
                        true => self.zoom(*notches),
                        false => self.view.click_force += notches * self.view.push.per_notch,
                    }
                }
            }
            Input::FocusLost => {
                self.hands.held.release_all();
                self.let_go();
                self.ui.focus_lost();
            }
            Input::Resized(size) => {
                self.run.options.size_px = *size;
                self.ui.set_size(*size);
            }
            Input::Scaled(scale) => self.ui.set_scale(*scale),
            Input::DockWidth(points) => self.ui.cockpit.set_dock_width(*points),
            Input::Arrange(text) => self.arrange(text),
            Input::Act(action) => self.carry_out(action),
        }
    }

    fn key_down(&mut self, key: &Key) {
        let binding = binding(key);
        let is_one_of = |acts: &[Act]| binding.filter(|row| acts.contains(&row.act));
        let leaves = is_one_of(&[Act::Cancel, Act::Quit, Act::FocusPanels, Act::Screenshot]).is_some();
        let saves = is_one_of(&[Act::SaveBundle, Act::SaveScene, Act::Quit]).filter(|_| self.ui.takes_text());
        if let Some(row) = saves {
            // What is being typed is taken first, when the field is laid out without the keyboard.
            self.ui.release_focus();
            self.ui.postponed.push(row.act);
        } else if (self.ui.question.is_some() || self.ui.takes_key(key)) && !leaves {
            self.ui.key(key, true);
        } else if let Some(binding) = binding {
            if takes_shift(key) {
                let moved_s = self.hands.held.take_shift();
                self.view.camera.fly(DVec3::Y, moved_s);
            }
            match binding.lasts {
                Lasts::While(hold) => self.hands.held.press(key, hold),
                _ => self.act(binding.act),
            }
        }
    }

    /// Does an action at once; one that lasts while its key is held does nothing.
    pub(crate) fn act(&mut self, act: Act) {
        match act {
            Act::Panel(panel) => self.toggle(panel),
            Act::ToggleMode => self.toggle_mode(),
            Act::ToggleGravity => self.toggle_gravity(),
            Act::ResetWorld => self.reset_world(),
            Act::ResetCamera => self.reset_camera(),
            Act::LockCamera => {
                self.seen.locked = self.seen.selection.filter(|_| self.seen.locked.is_none());
            }
            Act::NextBody => self.select_neighbor(1),
            Act::PreviousBody => self.select_neighbor(-1),
            Act::Frame => self.frame_view(),
            Act::Pause => self.view.paused ^= true,
            Act::Step => {
                self.view.paused = true;
                self.hands.steps_asked += 1;
            }
            Act::StepBack => self.step_back(),
            Act::Slower => self.set_pace(0.5),
            Act::Faster => self.set_pace(2.0),
            Act::PreviousScene => self.open_neighbor(-1),
            Act::NextScene => self.open_neighbor(1),
            Act::NextMethod => self.change_method(Method::next),
            Act::PreviousMethod => self.change_method(Method::previous),
            Act::NextSolid => self.next_solid(),
            Act::SaveBundle => self.save(),
            Act::SaveScene => self.save_scene(),
            Act::Undo => self.undo(),
            Act::Redo => self.redo(),
            Act::Duplicate => self.duplicate(),
            Act::Delete => self.delete(),
            Act::VelocityArrows => self.view.velocity_arrows ^= true,
            Act::ForceArrows => self.view.force_arrows ^= true,
            Act::Springs => self.view.springs ^= true,
            Act::Trails => {
                self.view.trails ^= true;
                self.seen.trails = Default::default();
            }
            Act::FocusPanels => self.focus_panels(),
            Act::Larger => self.zoom_panels(1),
            Act::Smaller => self.zoom_panels(-1),
            Act::ToggleTheme => self.toggle_theme(),
            Act::ToggleBrowser => self.toggle_browser(),
            Act::ToggleDock => self.ui.cockpit.dock ^= true,
            Act::ToggleCockpit => self.toggle_cockpit(),
            Act::Screenshot => self.orders.push(Order::Screenshot(None)),
            Act::Cancel => self.cancel(),
            Act::Quit => self.leave(Order::Quit),
            Act::FlyForward
            | Act::FlyBack
            | Act::FlyLeft
            | Act::FlyRight
            | Act::FlyUp
            | Act::FlyDown
            | Act::PushMinusZ
            | Act::PushPlusZ
            | Act::PushMinusX
            | Act::PushPlusX
            | Act::PushPlusY
            | Act::PushMinusY
            | Act::SelectImmovable
            | Act::ChangeForce => {}
        }
    }

    /// How far the pointer moves in a click at most, pixels.
    fn click_px(&self) -> f64 {
        CLICK_POINTS * f64::from(self.ui.pixels_per_point())
    }

    /// Lets go of what the buttons of the mouse hold.
    pub(crate) fn let_go(&mut self) {
        self.hands.selecting = false;
        self.hands.drag = None;
        (self.seen.pressed, self.seen.pull) = (None, None);
        self.tools.editor.handle = None;
    }

    /// Opens or closes a panel.
    fn toggle(&mut self, panel: Panel) {
        // A tool that follows the world begins where nothing waits to be done.
        self.carry_out_requests();
        let open = self.ui.shows(panel);
        let Some((_, tool)) = self.tools.each().find(|(other, _)| *other == panel) else { return };
        if tool.toggle(&mut self.stage, open) {
            self.ui.open(panel);
            if self.ui.cockpit.shown && self.view.mode == Mode::Camera {
                self.toggle_mode();
            }
        } else {
            self.ui.close(panel);
        }
    }

    /// Held keys act once per frame: flying, selecting, pushing.
    pub(crate) fn steer(&mut self, seconds: f64) {
        let tapped = self.hands.held.end_input();
        if self.view.mode == Mode::Camera && self.seen.locked.is_none() {
            let direction = self.hands.held.flight(&tapped.in_frame, seconds);
            self.view.camera.fly(direction, seconds);
        }
        let (held, tapped) = (self.hands.held.push(), held::push(&tapped.between_ticks));
        let selected = self.seen.selection.filter(|_| self.view.mode == Mode::Selection);
        let pushes = |newtons: DVec3| match selected {
            Some(thing) if newtons != DVec3::ZERO => self.pushes_on(thing, newtons),
            _ => Vec::new(),
        };
        let (held, tapped) = (pushes(held), pushes(tapped));
        let mut queue = self.sim.world.resource_mut::<PushQueue>();
        queue.sustain(held);
        tapped.into_iter().for_each(|Push { body, newtons }| queue.push_once(body, newtons));
        if self.hands.selecting {
            self.select();
        }
    }

    pub(crate) fn reset_camera(&mut self) {
        self.view.camera.reset();
        self.seen.locked = None;
    }

    pub(crate) fn cancel(&mut self) {
        self.tools.editor.cancel_typing();
        if self.ui.question.take().is_none() && !self.ui.close_top() && self.seen.selection.take().is_none() {
            self.notice("Ctrl+Q quits");
        }
    }

    /// Lets the next method be the solid one.
    pub(crate) fn next_solid(&mut self) {
        if self.tools.ghosts.are_shown() {
            self.change_method(Method::next);
        } else {
            let what = "there are no ghosts to choose from; T shows them";
            self.notices.say(Topic::Ghosts, what.to_owned());
        }
    }

    pub(crate) fn toggle_mode(&mut self) {
        self.view.mode = match self.view.mode {
            Mode::Camera => Mode::Selection,
            Mode::Selection => Mode::Camera,
        };
        self.let_go();
        // The pointer appears where the cross-hair was, and leaves the panels when it is grabbed.
        let [corner, size] = self.view_area();
        self.view.pointer = corner + size / 2.0;
        match self.view.mode {
            Mode::Camera => self.ui.pointer_gone(),
            Mode::Selection => {
                let DVec2 { x, y } = self.view.pointer;
                self.ui.pointer(x, y);
            }
        }
    }

    pub(crate) fn toggle_gravity(&mut self) {
        // Carried out at once: a second toggle in the same frame has to see the first.
        self.carry_out_requests();
        match self.sim.world.get_resource::<Gravity>() {
            Some(gravity) => {
                let request = Request::SwitchGravity(!gravity.on);
                self.ask(request);
                self.carry_out_requests();
                self.note_switched(Effect::Gravity, SwitchedBy::Key);
            }
            None => {
                let what = "this scene declares no gravity; the settings (Tab) can add it";
                self.refuse_about(Topic::Gravity, what);
            }
        }
    }

    pub(crate) fn change_method(&mut self, other: fn(Method) -> Method) {
        let gravity = self.sim.world.contains_resource::<motion::MutualGravity>();
        let mut method = other(self.sim.method());
        while unsolvable(method, gravity).is_some() {
            method = other(method);
        }
        self.set_method(method);
        self.notices.say(Topic::Method, methods::line(method));
    }

    pub(crate) fn set_pace(&mut self, factor: f64) {
        let pace = (self.clock.pace() * factor).clamp(*PACES.start(), *PACES.end());
        self.clock.set_pace(pace).expect("a clamped pace is positive and finite");
        self.notices.say(Topic::Speed, format!("{pace} x speed"));
    }

    pub(crate) fn open_neighbor(&mut self, step: isize) {
        let shipped = scene::shipped();
        let here = shipped.iter().position(|shipped| shipped.name == self.sim.scene.name);
        let next = match here {
            Some(here) => {
                here.checked_add_signed(step).map_or(shipped.len() - 1, |next| next % shipped.len())
            }
            None => 0,
        };
        self.leave(Order::Open(shipped[next].name.to_owned()));
    }

    fn button(&mut self, button: Button, down: bool) {
        let over_panel = self.view.mode == Mode::Selection && self.ui.wants_pointer();
        // What went down in one mode may come up in the other.
        if self.view.mode == Mode::Selection || !down {
            self.ui.button(button, down);
        }
        if down && over_panel {
            return;
        }
        match (button, down) {
            (Button::Left, true) if self.picks_for_editor() => {}
            (Button::Left, true) if self.view.mode == Mode::Selection => {
                // The tutorial selects what the pointer is drawn over; the cockpit pulls what it was pressed on.
                self.hands.selecting = !self.moves_camera();
                self.select();
                if self.moves_camera() {
                    self.seen.pressed = self.take().map(|pull| (self.view.pointer, pull));
                }
            }
            (Button::Left, false) => {
                if self.moves_camera() && self.seen.pull.is_none() && !over_panel {
                    self.frame_at_double_click();
                }
                self.hands.selecting = false;
                (self.seen.pressed, self.seen.pull) = (None, None);
                self.drop_handle();
            }
            (Button::Right, true) => self.push_or_orbit(),
            (Button::Middle, true) if self.moves_camera() => {
                self.hands.drag = Some(Drag::Pan(self.pivot()));
            }
            (Button::Right | Button::Middle, false) => self.hands.drag = None,
            _ => {}
        }
    }

    /// Frames the selection at the second of two clicks at one place.
    fn frame_at_double_click(&mut self) {
        let (now, at) = (self.clock.now(), self.view.pointer);
        let clicked = self.hands.clicked.take();
        let double = clicked.is_some_and(|(then, place)| {
            now - then <= DOUBLE_CLICK_S && place.distance(at) <= self.click_px()
        });
        if !double {
            self.hands.clicked = Some((now, at));
        } else if self.seen.selection.is_some() {
            self.frame_view();
        }
    }

    /// Selects the next movable thing of the scene, or the one before; after the last one comes the first.
    pub(crate) fn select_neighbor(&mut self, step: isize) {
        let points = self.stage.points_of_soft_bodies();
        let world = &mut self.stage.sim.world;
        let softs: Vec<_> = world.query_filtered::<Entity, With<SoftBody>>().iter(world).collect();
        let awake = |thing: &Entity| self.sim.world.get::<Dormant>(*thing).is_none();
        let bodies = self.things().filter(|thing| !points.contains(*thing)).chain(softs);
        let movable: Vec<_> = bodies.filter(|thing| awake(thing) && self.is_movable(*thing)).collect();
        let here = movable.iter().position(|thing| Some(*thing) == self.seen.selection);
        let next = here.and_then(|here| movable.get(here.checked_add_signed(step)?));
        let end = if step > 0 { movable.first() } else { movable.last() };
        self.seen.selection = next.or(end).copied();
        self.tools.editor.handle = None;
    }

    /// Whether a click selects what cannot be moved. Within the cockpit a scene does not say so: there a click beside a body
    /// deselects.
    pub(crate) fn selects_immovable(&self) -> bool {
        let by_scene = self.sim.scene.select_immovable && !self.ui.cockpit.shown;
        by_scene || self.hands.held.selects_immovable()
    }

    /// Selects what is under the pointer; nothing there clears the selection, and so does what cannot be moved, unless it is
    /// wanted.
    fn select(&mut self) {
        let ray = self.picking_ray();
        let wanted = self.selects_immovable();
        let hit = self.cast(&ray).map(|hit| hit.entity);
        self.seen.selection = hit.filter(|hit| wanted || self.is_movable(*hit));
    }

    /// Pushes the selection if it is under the pointer; beside it, or where it cannot be moved, a drag orbits.
    fn push_or_orbit(&mut self) {
        let pushes = self.push_selected() && self.moves_selection();
        if !pushes && self.moves_camera() {
            self.hands.drag = Some(Drag::Orbit(self.pivot()));
        }
    }

    /// Whether something is selected that forces move.
    pub(crate) fn moves_selection(&self) -> bool {
        self.seen.selection.is_some_and(|thing| self.is_movable(thing))
    }

    /// Pushes the selection along the ray, if the ray meets it first; whether it does.
    fn push_selected(&mut self) -> bool {
        let (Some(selected), Some(_)) = (self.seen.selection, self.sim.scene.push) else { return false };
        let ray = self.picking_ray();
        let hit = self.cast(&ray).filter(|hit| hit.entity == selected);
        if let Some(pushed) = hit.and_then(|hit| hit.pushed) {
            let newtons = ray.direction() * self.view.click_force;
            self.sim.world.resource_mut::<PushQueue>().push_once(pushed, newtons);
        }
        hit.is_some()
    }
}
