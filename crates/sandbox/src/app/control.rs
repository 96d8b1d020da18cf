//! From input to what it means: modes, flying, selecting, pushing, the clock and the panels.
//!
//! Nothing here writes the state of a body: a click becomes a queued push, an edit a queued request.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use motion::effects::Effect;
use motion::{Damping, Gravity, Method, PhysicsBody, Push, PushQueue, Quarantined, Request, SoftBody};
use scene::{PushSpec, unsolvable};

use crate::actions::{Action, Key, When, binding};
use crate::app::held::{self, Held};
use crate::app::session::{Order, Session, SwitchedBy};
use crate::app::ui::{Panel, Topic};
use crate::input::{Button, Experiment, Input};
use crate::methods;
use crate::view::trails::Trails;

/// What the pointer is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// The mouse turns the camera, keys fly it, the pointer is grabbed.
    #[default]
    Camera,
    /// The pointer is free and selects.
    Selection,
}

/// Slowest and fastest pace that the keys reach.
const PACES: std::ops::RangeInclusive<f64> = 1.0 / 64.0..=16.0;

/// What input has brought about so far.
#[derive(Clone, Debug)]
pub(crate) struct Control {
    pub mode: Mode,
    pub selection: Option<Entity>,
    pub locked: Option<Entity>,
    pub click_force: f64,
    pub push: PushSpec,
    /// In selection mode, pixels from the top left.
    pub pointer: DVec2,
    pub selecting: bool,
    pub held: Held,
    pub paused: bool,
    pub steps_asked: u64,
    pub velocity_arrows: bool,
    pub force_arrows: bool,
    /// Every spring is drawn, and not the surfaces that springs hold.
    pub springs: bool,
    pub trails: bool,
}

impl Control {
    pub fn new(push: PushSpec, paused: bool) -> Self {
        Self {
            mode: Mode::default(),
            selection: None,
            locked: None,
            click_force: push.start,
            push,
            pointer: DVec2::ZERO,
            selecting: false,
            held: Held::default(),
            paused,
            steps_asked: 0,
            velocity_arrows: false,
            force_arrows: false,
            springs: false,
            trails: false,
        }
    }
}

impl Session {
    pub(crate) fn handle(&mut self, input: &Input) {
        match input {
            Input::KeyDown(key) => self.key_down(key),
            Input::KeyUp(key) => {
                self.control.held.release(key);
                self.ui.key(key, false);
            }
            Input::Text(text) => {
                if self.ui.takes_keys() {
                    self.ui.text(text);
                }
            }
            Input::Mouse(x, y) => match self.control.mode {
                Mode::Camera => self.camera.look(*x, *y),
                Mode::Selection => {
                    self.control.pointer = DVec2::new(*x, *y);
                    self.ui.pointer(*x, *y);
                }
            },
            Input::ButtonDown(button) => self.button(*button, true),
            Input::ButtonUp(button) => self.button(*button, false),
            Input::Wheel(notches) => {
                if self.control.mode == Mode::Selection && self.ui.wants_pointer() {
                    self.ui.wheel(*notches);
                } else if notches.is_finite() {
                    self.control.click_force += notches * self.control.push.per_notch;
                }
            }
            Input::FocusLost => {
                self.control.held.release_all();
                self.control.selecting = false;
                self.ui.focus_lost();
            }
            Input::Resized(size) => {
                self.options.size_px = *size;
                self.ui.set_size(*size);
            }
            Input::Scaled(scale) => self.ui.set_scale(*scale),
            Input::Experiment(experiment) => self.experiment(experiment),
        }
    }

    fn key_down(&mut self, key: &Key) {
        let binding = binding(key);
        let leaves = binding.is_some_and(|row| matches!(row.action, Action::Cancel | Action::Quit));
        if self.ui.takes_keys() && !leaves {
            self.ui.key(key, true);
        } else if let Some(binding) = binding {
            if key.takes_shift() {
                self.camera.fly(DVec3::Y, self.control.held.take_shift());
            }
            if binding.held {
                self.control.held.press(key);
            } else {
                self.act(binding.action);
            }
        }
    }

    /// What is held acts once a frame: flying, selecting, pushing.
    pub(crate) fn steer(&mut self, seconds: f64) {
        let tapped = self.control.held.end_input();
        if self.control.mode == Mode::Camera && self.control.locked.is_none() {
            self.camera.fly(self.control.held.flight(&tapped.in_frame, seconds), seconds);
        }
        let (held, tapped) = (self.control.held.push(), held::push(&tapped.between_ticks));
        let selected = self.control.selection.filter(|_| self.control.mode == Mode::Selection);
        let pushes = |newtons: DVec3| match selected {
            Some(thing) if newtons != DVec3::ZERO => self.pushes_on(thing, newtons),
            _ => Vec::new(),
        };
        let (held, tapped) = (pushes(held), pushes(tapped));
        let mut queue = self.sim.world.resource_mut::<PushQueue>();
        queue.sustain(held);
        tapped.into_iter().for_each(|Push { body, newtons }| queue.push_once(body, newtons));
        if self.control.selecting {
            self.select();
        }
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::ToggleMode => self.toggle_mode(),
            Action::ToggleGravity => self.toggle_gravity(),
            Action::ResetWorld => self.reset_world(),
            Action::ResetCamera => {
                self.camera.reset();
                self.control.locked = None;
            }
            Action::LockCamera => {
                self.control.locked = match self.control.locked {
                    Some(_) => None,
                    None => self.control.selection,
                };
            }
            Action::Pause => self.control.paused = !self.control.paused,
            Action::StepOnce => {
                self.control.paused = true;
                self.control.steps_asked += 1;
            }
            Action::StepBack => self.step_back(),
            Action::Slower => self.set_pace(0.5),
            Action::Faster => self.set_pace(2.0),
            Action::PreviousScene => self.open_neighbor(-1),
            Action::NextScene => self.open_neighbor(1),
            Action::FindScene => self.ui.toggle(Panel::Finder),
            Action::NextMethod => self.change_method(Method::next),
            Action::PreviousMethod => self.change_method(Method::previous),
            Action::Settings => self.ui.toggle(Panel::Settings),
            Action::Effects => self.ui.toggle(Panel::Effects),
            Action::Cost => self.ui.toggle(Panel::Cost),
            Action::Ghosts => self.toggle_ghosts(),
            Action::NextSolid => self.next_solid(),
            Action::Ledger => self.ui.toggle(Panel::Ledger),
            Action::Forecast => self.ui.toggle(Panel::Forecast),
            Action::Timeline => self.ui.toggle(Panel::Timeline),
            Action::SaveBundle => self.ask_for_bundle(),
            Action::Help => self.ui.toggle(Panel::Help),
            Action::VelocityArrows => self.control.velocity_arrows ^= true,
            Action::ForceArrows => self.control.force_arrows ^= true,
            Action::Springs => self.control.springs ^= true,
            Action::Trails => {
                self.control.trails ^= true;
                self.trails = Trails::default();
            }
            Action::Screenshot => self.orders.push(Order::Screenshot(None)),
            Action::Cancel => {
                if !self.ui.close_top() && self.control.selection.take().is_none() {
                    self.notice("Ctrl+Q quits");
                }
            }
            Action::Quit => self.orders.push(Order::Quit),
            // What is held is read once a frame.
            Action::FlyForward
            | Action::FlyBack
            | Action::FlyLeft
            | Action::FlyRight
            | Action::FlyUp
            | Action::FlyDown
            | Action::PushMinusZ
            | Action::PushPlusZ
            | Action::PushMinusX
            | Action::PushPlusX
            | Action::PushPlusY
            | Action::PushMinusY
            | Action::SelectImmovable => {}
        }
    }

    fn toggle_mode(&mut self) {
        self.control.mode = match self.control.mode {
            Mode::Camera => Mode::Selection,
            Mode::Selection => Mode::Camera,
        };
        self.control.selecting = false;
        // The pointer appears where the cross-hair was, and leaves the panels when it is grabbed.
        let [width, height] = self.options.size_px.map(f64::from);
        self.control.pointer = DVec2::new(width, height) / 2.0;
        match self.control.mode {
            Mode::Camera => self.ui.pointer_gone(),
            Mode::Selection => self.ui.pointer(self.control.pointer.x, self.control.pointer.y),
        }
    }

    fn toggle_gravity(&mut self) {
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
        self.ui.notice(Topic::Method, methods::line(method));
    }

    fn set_pace(&mut self, factor: f64) {
        let pace = (self.clock.pace() * factor).clamp(*PACES.start(), *PACES.end());
        self.clock.set_pace(pace).expect("a clamped pace is positive and finite");
        self.ui.notice(Topic::Speed, format!("{pace} x speed"));
    }

    fn open_neighbor(&mut self, step: isize) {
        let shipped = scene::shipped();
        let here = shipped.iter().position(|shipped| shipped.name == self.sim.scene.name);
        let next = match here {
            Some(here) => {
                here.checked_add_signed(step).map_or(shipped.len() - 1, |next| next % shipped.len())
            }
            None => 0,
        };
        self.orders.push(Order::Open(shipped[next].name.to_owned()));
    }

    fn button(&mut self, button: Button, down: bool) {
        let over_panel = self.control.mode == Mode::Selection && self.ui.wants_pointer();
        if self.control.mode == Mode::Selection {
            self.ui.button(button, down);
        }
        if down && over_panel {
            return;
        }
        match (button, down) {
            (Button::Left, true) if self.control.mode == Mode::Selection => {
                self.control.selecting = true;
                self.select();
            }
            (Button::Left, false) => self.control.selecting = false,
            (Button::Right, true) => self.push_selected(),
            _ => {}
        }
    }

    /// Selects what is under the pointer; nothing there clears the selection, and so does what cannot be moved, unless it is
    /// wanted.
    fn select(&mut self) {
        let ray = self.picking_ray();
        let wanted = self.control.held.holds(Action::SelectImmovable) || self.sim.scene.select_immovable;
        let hit = self.cast(&ray).map(|hit| hit.entity);
        self.control.selection = hit.filter(|hit| wanted || self.is_movable(*hit));
    }

    /// Whether forces move a thing, or did until it was quarantined; of a soft body, any of its points.
    fn is_movable(&self, thing: Entity) -> bool {
        let moves = |body: Entity| {
            let state = self.sim.world.get::<PhysicsBody>(body);
            state.is_some_and(|state| state.inverse_mass > 0.0)
                || self.sim.world.get::<Quarantined>(body).is_some()
        };
        match self.sim.world.get::<SoftBody>(thing) {
            Some(soft) => soft.points.iter().any(|point| moves(*point)),
            None => moves(thing),
        }
    }

    /// Pushes the selection along the ray, if the ray meets it first.
    fn push_selected(&mut self) {
        let (Some(selected), Some(_)) = (self.control.selection, self.sim.scene.push) else { return };
        let ray = self.picking_ray();
        let hit = self.cast(&ray).filter(|hit| hit.entity == selected);
        if let Some(pushed) = hit.and_then(|hit| hit.pushed) {
            let newtons = ray.direction() * self.control.click_force;
            self.sim.world.resource_mut::<PushQueue>().push_once(pushed, newtons);
        }
    }

    pub(crate) fn experiment(&mut self, experiment: &Experiment) {
        match experiment {
            Experiment::Push(name, newtons) => {
                if let Some(body) = self.body_or_refuse(name) {
                    self.sim.world.resource_mut::<PushQueue>().push_once(body, DVec3::from_array(*newtons));
                }
            }
            Experiment::OfBody(name, request, value) => {
                if let Some(body) = self.body_or_refuse(name) {
                    self.ask(request(body, DVec3::from_array(*value)));
                }
            }
            Experiment::OfWorld(request) => self.ask_by(*request, SwitchedBy::Script),
            Experiment::Remove(name) => {
                if let Some(body) = self.body_or_refuse(name) {
                    self.ask(Request::Remove(body));
                }
            }
            Experiment::DampingRate(rate) => {
                let damping = self.sim.world.get_resource::<Damping>().copied();
                let model = damping.map_or_else(Default::default, |damping| damping.model);
                self.ask_by(Request::SetDamping(Damping { model, rate: *rate }), SwitchedBy::Script);
            }
            Experiment::Method(method) => self.set_method(*method),
            Experiment::BodyMethod(name, method) => {
                if let Some(body) = self.body_or_refuse(name) {
                    self.set_body_method(body, *method);
                }
            }
            Experiment::SwitchEffect(effect, on) => {
                // The person was told if there is no such effect in the scene.
                let _ = self.switch_effect(*effect, *on, SwitchedBy::Script);
            }
            Experiment::Screenshot(name) => self.orders.push(Order::Screenshot(Some(name.clone()))),
        }
    }
}

impl When {
    /// Whether it covers `mode`.
    #[must_use]
    pub fn covers(self, mode: Mode) -> bool {
        match self {
            Self::Always => true,
            Self::CameraMode => mode == Mode::Camera,
            Self::SelectionMode => mode == Mode::Selection,
        }
    }
}
