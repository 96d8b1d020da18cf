//! The panels' side of a session: one egui context fed from the same input as everything else, without a window.

use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, Vec2};
use motion::{FrameClock, FrameTime};

use scene::Happening;

use crate::actions::Key;
use crate::control::Mode;
use crate::input::Button;
use crate::panels::{self, Edit, Finder};
use crate::session::{Order, Session, SwitchedBy};

/// How long a notice stays, s.
const NOTICE_S: f64 = 4.0;

/// Pixels and notches beyond every screen: of larger ones egui's speeds are no numbers.
const FAR: f64 = 1e6;

/// Points that the panels need, the help being the widest. A smaller picture has smaller points, down to half
/// the size: below that nobody could read them.
const ROOM: [f32; 2] = [960.0, 540.0];
const SMALLEST: f32 = 0.5;

/// Which panels are open, and egui.
pub(crate) struct Ui {
    context: egui::Context,
    events: Vec<Event>,
    output: Option<egui::FullOutput>,
    /// Pixels a point, as the display has it.
    scale: f32,
    size_px: [u32; 2],
    pointer: Pos2,
    laid_out: bool,
    pub help: bool,
    pub settings: bool,
    pub effects: bool,
    pub cost: bool,
    /// What its axes count.
    pub axes: panels::Axes,
    /// The list of ghosts, which it leaves alone when it is closed.
    pub ghosts: bool,
    pub ledger: bool,
    pub forecast: bool,
    pub timeline: bool,
    pub finder: Option<Finder>,
    was_open: bool,
    notices: Vec<(String, Option<f64>)>,
}

impl Ui {
    pub fn new(size_px: [u32; 2]) -> Self {
        let context = egui::Context::default();
        // Pictures must not depend on how many frames ago a panel was opened.
        context.all_styles_mut(|style| style.animation_time = 0.0);
        let mut visuals = egui::Visuals::dark();
        // As bright as the tutorial's texts.
        visuals.widgets.noninteractive.fg_stroke.color = egui::Color32::from_gray(191);
        context.set_visuals(visuals);
        Self {
            context,
            events: Vec::new(),
            output: None,
            scale: 1.0,
            size_px,
            pointer: Pos2::ZERO,
            laid_out: false,
            help: false,
            settings: false,
            effects: false,
            cost: false,
            axes: panels::Axes::default(),
            ghosts: false,
            ledger: false,
            forecast: false,
            timeline: false,
            finder: None,
            was_open: false,
            notices: Vec::new(),
        }
    }

    pub fn toggle_help(&mut self) {
        self.help ^= true;
    }

    pub fn toggle_settings(&mut self) {
        self.settings ^= true;
    }

    pub fn toggle_effects(&mut self) {
        self.effects ^= true;
    }

    pub fn toggle_cost(&mut self) {
        self.cost ^= true;
    }

    pub fn toggle_ledger(&mut self) {
        self.ledger ^= true;
    }

    pub fn toggle_forecast(&mut self) {
        self.forecast ^= true;
    }

    pub fn toggle_timeline(&mut self) {
        self.timeline ^= true;
    }

    pub fn toggle_finder(&mut self) {
        self.finder = if self.finder.is_none() { Some(Finder::default()) } else { None };
    }

    /// Drops what waits for a layout that nobody will see.
    pub fn forget(&mut self) {
        self.events.clear();
        self.notices.clear();
    }

    pub fn notice(&mut self, text: String) {
        self.notices.push((text, None));
    }

    /// Takes back a notice that something newer makes untrue.
    pub fn take_back(&mut self, notice: &str) {
        self.notices.retain(|(text, _)| text != notice);
    }

    /// Whether a panel is open.
    pub fn any_open(&self) -> bool {
        let Self { help, settings, effects, cost, ghosts, ledger, forecast, timeline, .. } = self;
        let panels = [help, settings, effects, cost, ghosts, ledger, forecast, timeline].map(|open| *open);
        panels.contains(&true) || self.finder.is_some()
    }

    /// Whether a panel was open in the last layout: one more layout forgets it.
    pub const fn closing(&self) -> bool {
        self.was_open
    }

    /// Closes the panel that was opened last in this order; `false` if none is open.
    pub fn close_top(&mut self) -> bool {
        if self.finder.take().is_some() {
            return true;
        }
        let Self { help, settings, effects, cost, ghosts, ledger, forecast, timeline, .. } = self;
        for open in [help, settings, effects, cost, ghosts, ledger, forecast, timeline] {
            if std::mem::take(open) {
                return true;
            }
        }
        false
    }

    /// Whether a text field has the keyboard.
    pub fn takes_keys(&self) -> bool {
        self.finder.is_some() || (self.any_open() && self.context.egui_wants_keyboard_input())
    }

    /// Whether the pointer is over a panel or drags something of it.
    pub fn wants_pointer(&self) -> bool {
        // Where the pointer is now, not where the last layout saw it: it may have moved in this very frame.
        let layer = self.context.layer_id_at(self.pointer);
        let over = layer.is_some_and(|layer| layer.order != egui::Order::Background);
        self.any_open() && (over || self.context.egui_is_using_pointer())
    }

    pub fn key(&mut self, key: &Key, pressed: bool) {
        let name = match key.name() {
            "Up" | "Down" | "Left" | "Right" => format!("Arrow{}", key.name()),
            name => name.to_owned(),
        };
        if let Some(key) = egui::Key::from_name(&name) {
            let modifiers = Modifiers::NONE;
            self.events.push(Event::Key { key, physical_key: None, pressed, repeat: false, modifiers });
        }
    }

    pub fn text(&mut self, text: &str) {
        let typed: String = text.chars().filter(|character| !character.is_control()).collect();
        if !typed.is_empty() {
            self.events.push(Event::Text(typed));
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "pixels")]
    pub fn pointer(&mut self, x: f64, y: f64) {
        let pixel = |number: f64| number.clamp(-FAR, FAR) as f32;
        self.pointer = Pos2::new(pixel(x), pixel(y)) / self.pixels_per_point();
        self.events.push(Event::PointerMoved(self.pointer));
    }

    pub fn pointer_gone(&mut self) {
        self.events.push(Event::PointerGone);
    }

    pub fn button(&mut self, button: Button, pressed: bool) {
        let button = match button {
            Button::Left => PointerButton::Primary,
            Button::Right => PointerButton::Secondary,
            Button::Middle => PointerButton::Middle,
        };
        self.events.push(Event::PointerButton {
            pos: self.pointer,
            button,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }

    #[expect(clippy::cast_possible_truncation, reason = "notches")]
    pub fn wheel(&mut self, notches: f64) {
        self.events.push(Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: Vec2::new(0.0, notches.clamp(-FAR, FAR) as f32),
            phase: egui::TouchPhase::Move,
            modifiers: Modifiers::NONE,
            source: egui::MouseWheelSource::Unknown,
        });
    }

    pub fn focus_lost(&mut self) {
        self.events.push(Event::PointerGone);
    }

    #[expect(clippy::cast_possible_truncation, reason = "a scale between 1 and 4")]
    pub fn set_scale(&mut self, scale: f64) {
        self.scale = scale.clamp(0.5, 8.0) as f32;
    }

    pub const fn set_size(&mut self, size_px: [u32; 2]) {
        self.size_px = size_px;
    }

    #[expect(clippy::cast_precision_loss, reason = "pixels")]
    fn pixels_per_point(&self) -> f32 {
        let fits = |axis: usize| self.size_px[axis] as f32 / (ROOM[axis] * self.scale);
        self.scale * fits(0).min(fits(1)).clamp(SMALLEST, 1.0)
    }
}

impl Drop for Ui {
    fn drop(&mut self) {
        // Nobody will draw them any more; a debug build of egui asks to be told so.
        if let Some(output) = &mut self.output {
            output.textures_delta.clear();
        }
    }
}

impl Session {
    /// Lays the panels out for this frame and queues what the person changed in them.
    pub(crate) fn lay_out_panels(&mut self, time: FrameTime) {
        let now = time.total();
        self.ui.notices.retain_mut(|(_, until)| now <= *until.get_or_insert(now + NOTICE_S));
        let notices: Vec<_> = self.ui.notices.iter().map(|(text, _)| text.clone()).collect();
        let model = panels::Model::of(self, notices);
        let context = self.ui.context.clone();
        // The first layout only measures; a second one of the same frame stands right.
        let passes = if self.ui.laid_out { 1 } else { 2 };
        let pixels_per_point = self.ui.pixels_per_point();
        let mut edits = Vec::new();
        for _ in 0..passes {
            let [width, height] = self.options.size_px;
            #[expect(clippy::cast_precision_loss, reason = "pixels")]
            let size = Vec2::new(width as f32, height as f32) / pixels_per_point;
            let mut input = RawInput {
                screen_rect: Some(Rect::from_min_size(Pos2::ZERO, size)),
                time: Some(now),
                #[expect(clippy::cast_possible_truncation, reason = "a frame time")]
                predicted_dt: time.length() as f32,
                events: std::mem::take(&mut self.ui.events),
                ..Default::default()
            };
            if let Some(viewport) = input.viewports.get_mut(&egui::ViewportId::ROOT) {
                viewport.native_pixels_per_point = Some(pixels_per_point);
            }
            let ui_state = &mut self.ui;
            let mut output =
                context.run_ui(input, |ui| edits.extend(panels::show(ui.ctx(), ui_state, &model)));
            if let Some(mut earlier) = self.ui.output.take() {
                // Textures that no picture has taken yet.
                earlier.textures_delta.append(std::mem::take(&mut output.textures_delta));
                output.textures_delta = std::mem::take(&mut earlier.textures_delta);
            }
            self.ui.output = Some(output);
        }
        self.ui.laid_out = true;
        self.ui.was_open = self.ui.any_open();
        for edit in edits {
            match edit {
                Edit::Ask(request) => self.ask_by(request, SwitchedBy::Settings),
                Edit::Try(experiment) => self.experiment(&experiment),
                Edit::Switch(effect, on) => {
                    // Only declared ones can be clicked.
                    let _ = self.switch_effect(effect, on, SwitchedBy::Panel);
                }
                Edit::MeasureCost => self.measure_cost(),
                Edit::ApplySetting(setting) => self.apply_setting(setting),
                Edit::MeasureEffects => self.measure_effects(),
                Edit::ShowGhost(method, shown) => self.show_ghost(method, shown),
                Edit::StepHz(rate) => {
                    if self.clock.set_rate(rate).is_ok() {
                        self.record(Happening::Step(1.0 / rate));
                        self.world.insert_resource(motion::TimeStep(1.0 / rate));
                    }
                }
                Edit::Seek(tick) => self.set_out(tick),
                Edit::SaveBundle => self.ask_for_bundle(),
                Edit::Open(scene) => self.orders.push(Order::Open(scene)),
            }
        }
    }

    /// Lays the panels out for a picture of the present state, between two frames.
    pub(crate) fn lay_out_still(&mut self) {
        if let Ok(now) = FrameClock::default().advance_to(self.clock.now()) {
            // A card that is new stands at its place in the layout after those that measure it.
            (0..2).for_each(|_| self.lay_out_panels(now));
        }
    }

    /// The panels of the last layout as triangles; their textures are handed out once.
    pub(crate) fn panels(&mut self) -> Option<render::Panels> {
        let output = self.ui.output.as_mut()?;
        let shapes = output.shapes.clone();
        let pixels_per_point = output.pixels_per_point;
        let textures_delta = std::mem::take(&mut output.textures_delta);
        let primitives = self.ui.context.tessellate(shapes, pixels_per_point);
        Some(render::Panels { primitives, textures_delta, pixels_per_point })
    }

    /// Whether the pointer is to be hidden and held by the window.
    #[must_use]
    pub fn grabs_pointer(&self) -> bool {
        self.control.mode == Mode::Camera
    }
}
