//! The panels' side of a session: one egui context fed from the same input as everything else, without a window.

mod focus;
mod style;

use egui::accesskit::Node;
use egui::{
    Event, ImeEvent, Modifiers, PointerButton, Pos2, RawInput, Rect, TouchDeviceId, TouchId, Vec2,
};
use glam::DVec2;

use crate::actions::Act;
use crate::app::cockpit::Cockpit;
use crate::clock::FrameTime;
use crate::input::{Button, Key, TouchPhase};
use crate::intent::Question;
use crate::panels::Panel;
use crate::tools::number;

/// Limit of pixels and notches, beyond every screen: with larger ones, egui's speeds are not finite.
const FAR: f64 = 1e6;

/// A button, a field or words on the screen, as assistive technology names it.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Kind of the control, by AccessKit's name.
    pub role: String,
    /// Words of the control.
    pub name: String,
    /// Left, top, right and bottom, pixels.
    pub rect_px: [f64; 4],
    /// Whether it has the keyboard.
    pub focused: bool,
}

/// Which panels are open, and egui.
pub(crate) struct Ui {
    context: egui::Context,
    events: Vec<Event>,
    output: Option<egui::FullOutput>,
    /// Whether `output` has requests to the system that were not taken.
    asks: bool,
    /// Pixels per point of the display.
    scale: f32,
    /// The size of everything in the panels: an index into the list of sizes.
    zoom: usize,
    size_px: [u32; 2],
    pointer: Pos2,
    laid_out: bool,
    /// Open panels in the order in which they were opened.
    opened: Vec<Panel>,
    /// Open panels that were hidden with the dock.
    hidden: Vec<Panel>,
    was_open: bool,
    /// The bars and the dock around the view.
    pub(crate) cockpit: Cockpit,
    /// The area that the bars and the dock left for the view in the last layout.
    pub view: Rect,
    /// Actions that are carried out after the next layout.
    pub postponed: Vec<Act>,
    /// The question that is open.
    pub(crate) question: Option<Question>,
    /// When egui wants its next layout, s; infinite if nothing moves by itself.
    lays_out_at: f64,
    focus: focus::Focus,
}

impl Ui {
    pub fn new(size_px: [u32; 2]) -> Self {
        let context = egui::Context::default();
        style::install(&context);
        Self {
            context,
            events: Vec::new(),
            output: None,
            asks: false,
            scale: 1.0,
            zoom: style::USUAL,
            size_px,
            pointer: Pos2::ZERO,
            laid_out: false,
            opened: Vec::new(),
            hidden: Vec::new(),
            was_open: false,
            cockpit: Cockpit::default(),
            view: Rect::EVERYTHING,
            postponed: Vec::new(),
            question: None,
            lays_out_at: f64::INFINITY,
            focus: focus::Focus::default(),
        }
    }

    /// Whether `panel` is open.
    pub fn shows(&self, panel: Panel) -> bool {
        self.opened.contains(&panel)
    }

    /// Whether `panel` is open and not hidden with the dock.
    pub fn lays_out(&self, panel: Panel) -> bool {
        self.shows(panel) && !self.hidden.contains(&panel)
    }

    /// Opens `panel` on top of the others, if it is closed or hidden.
    pub fn open(&mut self, panel: Panel) {
        self.hidden.retain(|other| *other != panel);
        if !self.shows(panel) {
            self.opened.push(panel);
        }
    }

    pub fn close(&mut self, panel: Panel) {
        self.opened.retain(|other| *other != panel);
        self.hidden.retain(|other| *other != panel);
    }

    /// When egui wants its next layout, s; infinite if nothing moves by itself.
    pub const fn lays_out_at(&self) -> f64 {
        self.lays_out_at
    }

    /// Drops what waits for a layout that no person will see.
    pub fn forget(&mut self) {
        self.events.clear();
    }

    pub fn opened(&self) -> &[Panel] {
        &self.opened
    }

    /// Whether there is anything to click: an open panel, the cockpit or a question.
    pub const fn any_open(&self) -> bool {
        !self.opened.is_empty() || self.cockpit.shown || self.question.is_some()
    }

    /// Whether a panel was open in the last layout: one more layout forgets it.
    pub const fn closing(&self) -> bool {
        self.was_open
    }

    /// Closes an open list, else takes the keyboard from a control, else closes the panel that was opened last. Returns `false`
    /// if there is nothing of these.
    pub fn close_top(&mut self) -> bool {
        // The finder's field has the keyboard as long as it is open.
        if self.opened.last() != Some(&Panel::Finder) {
            if egui::Popup::is_any_open(&self.context) {
                egui::Popup::close_all(&self.context);
                return true;
            }
            if self.release_focus() {
                return true;
            }
        }
        let top = self.opened.iter().rposition(|panel| !self.hidden.contains(panel));
        top.map(|top| self.opened.remove(top)).is_some()
    }

    /// Whether the pointer is over a panel or drags something of it.
    pub fn wants_pointer(&self) -> bool {
        // By the current pointer, not by that of the last layout: it may have moved in this very frame.
        let layer = self.context.layer_id_at(self.pointer);
        let over = layer.is_some_and(|layer| layer.order != egui::Order::Background);
        self.any_open()
            && (over
                || !self.scene_area().contains(self.pointer)
                || self.context.egui_is_using_pointer())
    }

    pub fn key(&mut self, key: &Key, pressed: bool) {
        if let Some(moves) = self.move_dock_edge(key) {
            self.events.extend(pressed.then_some(moves));
            return;
        }
        let name = match key.name() {
            "Up" | "Down" | "Left" | "Right" => format!("Arrow{}", key.name()),
            name => name.to_owned(),
        };
        let modifiers = Modifiers {
            ctrl: key.ctrl(),
            command: key.ctrl(),
            shift: key.shift(),
            ..Modifiers::NONE
        };
        match (pressed && key.ctrl(), key.name()) {
            (true, "C") => self.events.push(Event::Copy),
            (true, "X") => self.events.push(Event::Cut),
            _ => {}
        }
        if let Some(key) = egui::Key::from_name(&name) {
            self.events.push(Event::Key {
                key,
                physical_key: None,
                pressed,
                repeat: false,
                modifiers,
            });
        }
    }

    pub fn text(&mut self, text: &str) {
        let typed: String = text.chars().filter(|character| !character.is_control()).collect();
        if !typed.is_empty() {
            self.events.push(Event::Text(typed));
        }
    }

    /// Shows what an input method composes.
    pub fn compose(&mut self, text: &str) {
        let text = text.to_owned();
        self.events.push(Event::Ime(ImeEvent::Preedit { text, active_range_chars: None }));
    }

    /// Hands on what assistive technology asks for. Scripts were checked when they were read.
    pub fn assist(&mut self, request: &str) {
        self.events.extend(serde_json::from_str(request).map(Event::AccessKitActionRequest));
    }

    #[expect(clippy::cast_possible_truncation, reason = "pixels")]
    fn points(&self, x: f64, y: f64) -> Pos2 {
        let pixel = |number: f64| number.clamp(-FAR, FAR) as f32;
        Pos2::new(pixel(x), pixel(y)) / self.pixels_per_point()
    }

    pub fn pointer(&mut self, x: f64, y: f64) {
        self.pointer = self.points(x, y);
        self.events.push(Event::PointerMoved(self.pointer));
    }

    /// Tells egui of a finger, for which it scrolls what is dragged; the pointer follows by itself.
    pub fn touch(&mut self, finger: u64, phase: TouchPhase, at: DVec2) {
        let phase = match phase {
            TouchPhase::Down => egui::TouchPhase::Start,
            TouchPhase::Move => egui::TouchPhase::Move,
            TouchPhase::Up => egui::TouchPhase::End,
            TouchPhase::Cancel => egui::TouchPhase::Cancel,
        };
        self.events.push(Event::Touch {
            device_id: TouchDeviceId(0),
            id: TouchId(finger),
            phase,
            pos: self.points(at.x, at.y),
            force: None,
        });
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
        for button in [Button::Left, Button::Right, Button::Middle] {
            self.button(button, false);
        }
        self.events.push(Event::PointerGone);
    }

    /// Shows or hides the bars and the dock with its panels. Returns whether they are shown now.
    pub fn toggle_cockpit(&mut self) -> bool {
        self.cockpit.shown ^= true;
        self.hidden.clear();
        if !self.cockpit.shown {
            self.hidden.extend(self.opened.iter().filter(|panel| panel.tab().is_some()));
        }
        // Bars and dock have to be measured, as at the first layout.
        self.laid_out = false;
        self.cockpit.shown
    }

    /// The area in which a click goes into the scene: the view without the edge by which the dock is dragged.
    fn scene_area(&self) -> Rect {
        let mut area = self.view;
        if self.cockpit.shown {
            area.max.x -= self.context.global_style().interaction.resize_grab_radius_side;
        }
        area
    }

    #[expect(clippy::cast_possible_truncation, reason = "a scale between 1 and 4")]
    pub fn set_scale(&mut self, scale: f64) {
        self.scale = scale.clamp(0.5, 8.0) as f32;
    }

    pub const fn set_size(&mut self, size_px: [u32; 2]) {
        self.size_px = size_px;
    }

    /// Lays out a frame by `lay_out`, which egui calls once more if something has another size than expected.
    pub fn run(&mut self, time: FrameTime, mut lay_out: impl FnMut(&mut Self, &mut egui::Ui)) {
        let (now, context) = (time.total(), self.context.clone());
        // The first layout only measures; a second one of the same frame is right.
        let passes = if self.laid_out { 1 } else { 2 };
        let pixels_per_point = self.pixels_per_point();
        for _ in 0..passes {
            let [width, height] = self.size_px;
            #[expect(clippy::cast_precision_loss, reason = "pixels")]
            let size = Vec2::new(width as f32, height as f32) / pixels_per_point;
            let mut input = RawInput {
                screen_rect: Some(Rect::from_min_size(Pos2::ZERO, size)),
                time: Some(now),
                #[expect(clippy::cast_possible_truncation, reason = "a frame time")]
                predicted_dt: time.length() as f32,
                events: std::mem::take(&mut self.events),
                ..Default::default()
            };
            if let Some(viewport) = input.viewports.get_mut(&egui::ViewportId::ROOT) {
                viewport.native_pixels_per_point = Some(pixels_per_point);
            }
            let mut output = context.run_ui(input, |root| lay_out(self, root));
            if let Some(mut earlier) = self.output.take() {
                // Keep textures and copied texts that nothing has taken yet.
                earlier.textures_delta.append(std::mem::take(&mut output.textures_delta));
                output.textures_delta = std::mem::take(&mut earlier.textures_delta);
                let copied = &mut output.platform_output.commands;
                copied.splice(0..0, earlier.platform_output.commands);
            }
            let delay =
                output.viewport_output.get(&egui::ViewportId::ROOT).map(|root| root.repaint_delay);
            // The longest delay means never.
            let delay = delay.filter(|delay| *delay < std::time::Duration::MAX);
            self.lays_out_at = now + delay.map_or(f64::INFINITY, |delay| delay.as_secs_f64());
            (self.output, self.asks) = (Some(output), true);
            self.follow_focus();
        }
        self.laid_out = true;
        self.was_open = self.any_open();
    }

    pub fn take_requests(&mut self) -> Option<egui::PlatformOutput> {
        let output = self.output.as_mut().filter(|_| std::mem::take(&mut self.asks))?;
        Some(std::mem::take(&mut output.platform_output))
    }

    pub const fn context(&self) -> &egui::Context {
        &self.context
    }

    /// The refusal of what was typed into a number of the last layout.
    pub fn refusal(&self) -> Option<String> {
        number::refusal(&self.context)
    }

    /// The controls of the last layout; the first call only begins to name them.
    pub fn controls(&self) -> Vec<Control> {
        self.context.enable_accesskit();
        let update = self
            .output
            .as_ref()
            .and_then(|output| output.platform_output.accesskit_update.as_ref());
        let scale = f64::from(self.pixels_per_point());
        let control = |(id, node): &(_, Node)| {
            let name = node.label().or_else(|| node.value())?.to_owned();
            let rect = node.bounds()?;
            let rect_px = [rect.x0, rect.y0, rect.x1, rect.y1].map(|edge| edge * scale);
            Some(Control {
                role: format!("{:?}", node.role()),
                name,
                rect_px,
                focused: update?.focus == *id,
            })
        };
        update.map_or_else(Vec::new, |update| update.nodes.iter().filter_map(control).collect())
    }

    /// Width of the screen, points.
    #[expect(clippy::cast_precision_loss, reason = "pixels")]
    pub fn width(&self) -> f32 {
        self.size_px[0] as f32 / self.pixels_per_point()
    }

    /// The panels of the last layout as triangles; their textures are handed out once.
    pub fn panels(&mut self) -> Option<render::Panels> {
        let output = self.output.as_mut()?;
        let shapes = output.shapes.clone();
        let pixels_per_point = output.pixels_per_point;
        let textures_delta = std::mem::take(&mut output.textures_delta);
        let primitives = self.context.tessellate(shapes, pixels_per_point);
        Some(render::Panels { primitives, textures_delta, pixels_per_point })
    }

    pub fn pixels_per_point(&self) -> f32 {
        style::pixels_per_point(self.size_px, self.scale, self.zoom)
    }
}

impl Drop for Ui {
    fn drop(&mut self) {
        // No picture will draw them any more; debug builds of egui panic unless they are cleared.
        if let Some(output) = &mut self.output {
            output.textures_delta.clear();
        }
    }
}
