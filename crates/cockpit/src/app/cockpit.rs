//! The cockpit: bars and a dock for the mouse, around the view and never over it.

mod away;
mod browser;
mod dock;
mod fault;
mod hints;
mod toolbar;

use egui::{Align2, Area, Color32, Frame, Id, Panel as Side, Pos2, Rect, Response, RichText, Ui};

use self::browser::Browser;
use self::fault::FaultBar;
use crate::intent::Intent;
use crate::panels::{Panel, Tab};
use crate::stage::Stage;
use crate::stage::notices::Topic;
use crate::tools::tool::{Desk, Tool as _};
use crate::tools::{Tools, learn};
use crate::view::View;
use crate::view::inks;
use crate::view::marks::FAULT;

/// Least width of the screen at which the scene browser is open by default, points.
const ROOM_FOR_BROWSER: f32 = 1200.0;

/// Width of the browser, points.
const BROWSER: f32 = 190.0;

/// Least and greatest width of the dock at the start, points.
const DOCK: [f32; 2] = [340.0, 480.0];
/// Width of the dock at the start, as a fraction of the screen.
const DOCK_SHARE: f32 = 0.28;

/// Height of the dock below the view, as a fraction of what the bars leave.
const DOCK_BELOW: f32 = 0.45;

/// Greatest width that [`Cockpit::set_dock_width`] accepts, points; larger ones are clamped.
const WIDEST_DOCK: f32 = 10_000.0;

/// Lays out a bar at the bottom of what is `free` of the view, and takes its place from that.
fn bar(root: &Ui, name: &str, free: &mut Rect, add: impl FnOnce(&mut Ui)) {
    let area = Area::new(Id::unique(name)).pivot(Align2::LEFT_BOTTOM).fixed_pos(free.left_bottom());
    let frame = Frame::side_top_panel(root.style());
    let width = (free.width() - frame.total_margin().sum().x).max(0.0);
    let shown = area.show(root.ctx(), |ui| {
        frame.show(ui, |ui| {
            ui.set_width(width);
            ui.horizontal_wrapped(add);
        });
    });
    free.max.y = shown.response.rect.top();
}

/// Lays out the bar that says why a file was not written or opened.
fn files_bar(root: &Ui, free: &mut Rect, stage: &mut Stage) {
    let Some(why) = stage.notices.file_error().map(str::to_owned) else { return };
    bar(root, "file", free, |ui| {
        ui.label(RichText::new(why).color(inks::words(ui.visuals(), FAULT)));
        if ui.button("Close").clicked() {
            stage.notices.retract(Topic::FileError);
        }
    });
}

/// A part of the cockpit that can get the keyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Toolbar,
    Scenes,
    Dock,
}

/// Widths of the dock, points.
#[derive(Default)]
struct DockWidth {
    /// The width for the next layout.
    set: Option<f32>,
    /// The width that a person chose.
    chosen: Option<f32>,
    /// The widths of the screen and of the dock in the last layout.
    last: Option<[f32; 2]>,
}

impl DockWidth {
    /// Records the widths of a layout. If the screen is as wide as before, only a person can have changed the width of the dock.
    fn note(&mut self, screen: f32, dock: f32) {
        let dragged = self
            .last
            .is_some_and(|[before, width]| before == screen && (width - dock).abs() >= 0.5);
        if dragged {
            self.chosen = Some(dock);
        }
        self.last = Some([screen, dock]);
    }
}

/// A side of the cockpit: open if the screen has room for it, until a person opens it, or a panel in it, or closes it.
pub(crate) struct Fold {
    chosen: Option<bool>,
    /// Least width of the screen at which it is open by default, points.
    room: f32,
}

impl Fold {
    /// Whether the side is open, on a screen of that width in points.
    pub fn is_open(&self, width: f32) -> bool {
        self.chosen.unwrap_or(width >= self.room)
    }

    /// Opens or closes the side, on a screen of that width in points.
    pub fn toggle(&mut self, width: f32) {
        self.chosen = Some(!self.is_open(width));
    }

    /// Opens the side or closes it, on a screen of any width.
    pub const fn set(&mut self, open: bool) {
        self.chosen = Some(open);
    }

    /// Whether a person opened or closed the side.
    pub const fn is_chosen(&self) -> bool {
        self.chosen.is_some()
    }
}

/// The state of the cockpit: what a person opened and typed.
pub(crate) struct Cockpit {
    pub shown: bool,
    browser: Browser,
    pub scenes: Fold,
    pub dock: Fold,
    /// The chosen tab of the dock.
    pub tab: Tab,
    /// The tab to choose in the next layout.
    pub next_tab: Option<Tab>,
    dock_width: DockWidth,
    /// The part that gets the keyboard in the next layout.
    pub focuses: Option<Part>,
    /// Place of each part in the last layout.
    parts: Vec<(Part, Rect)>,
    fault: FaultBar,
    /// What the bars over the view leave of it.
    pub free: Rect,
    seen: away::Seen,
    /// The panels that were open in the last layout.
    opened: Vec<Panel>,
}

impl Default for Cockpit {
    fn default() -> Self {
        Self {
            shown: false,
            browser: Browser::default(),
            scenes: Fold { chosen: None, room: ROOM_FOR_BROWSER },
            dock: Fold { chosen: None, room: 2.0 * DOCK[0] },
            tab: Tab::default(),
            next_tab: None,
            dock_width: DockWidth::default(),
            focuses: None,
            parts: Vec::new(),
            fault: FaultBar::default(),
            free: Rect::NOTHING,
            seen: None,
            opened: Vec::new(),
        }
    }
}

impl Cockpit {
    /// The part at that place.
    pub fn part_at(&self, place: Pos2) -> Option<Part> {
        self.parts.iter().find(|(_, rect)| rect.contains(place)).map(|(part, _)| *part)
    }

    /// The part that follows `part`, or the first one.
    pub fn part_after(&self, part: Option<Part>) -> Option<Part> {
        let mut parts = self.parts.iter().map(|(part, _)| *part);
        if part.is_some() {
            parts.find(|other| Some(*other) == part);
        }
        parts.next()
    }

    /// Left edge of the dock, points, if it is open.
    pub fn dock_left(&self) -> Option<f32> {
        self.parts.iter().find(|(part, _)| *part == Part::Dock).map(|(_, rect)| rect.left())
    }

    /// Gives the dock a width, points.
    #[expect(clippy::cast_possible_truncation, reason = "points")]
    pub fn set_dock_width(&mut self, points: f64) {
        let points = (points as f32).clamp(DOCK[0], WIDEST_DOCK);
        self.dock_width = DockWidth { set: Some(points), chosen: Some(points), last: None };
    }

    /// The width of the dock, points, if a person gave it one.
    pub fn chosen_dock_width(&self) -> Option<f32> {
        self.dock_width.chosen.map(f32::round)
    }

    /// Remembers where `part` is, and gives its `first` control the keyboard if `focuses` says so.
    fn lay_out_part(&mut self, part: Part, rect: Rect, first: &Response) {
        self.parts.push((part, rect));
        if self.focuses.take_if(|focuses| *focuses == part).is_some() {
            first.request_focus();
        }
    }

    /// Lays out the bars and the dock with the `opened` panels, in `root`; what is left of it is the view.
    pub fn show(
        &mut self,
        root: &mut Ui,
        opened: &[Panel],
        stage: &mut Stage,
        view: &mut View,
        tools: &mut Tools,
        intents: &mut Vec<Intent>,
    ) {
        let width = root.available_width();
        // The area around the view already has the color of the panels: painting it again would take half the time of a frame in
        // software.
        let bare = Frame::side_top_panel(root.style()).fill(Color32::TRANSPARENT);
        let newest = opened.last().copied().filter(|panel| !self.opened.contains(panel));
        let opens = newest.and_then(Panel::tab);
        if opens.is_some() && !self.dock.is_chosen() && !self.dock.is_open(width) {
            self.dock.set(true);
        }
        let browses = self.scenes.is_open(width);
        let docks = self.dock.is_open(width);
        let learns = opened.contains(&Panel::Learn);
        self.parts.clear();
        let bar = Side::top("toolbar").frame(bare);
        let bar =
            bar.show(root, |ui| toolbar::show(ui, stage, view, browses, docks, learns, intents));
        self.lay_out_part(Part::Toolbar, bar.response.rect, &bar.inner);
        Side::bottom("hints")
            .frame(bare)
            .show(root, |ui| hints::show(ui, stage, view, &tools.editor, intents));
        if browses {
            let side = Side::left("scenes").frame(bare).resizable(false).exact_size(BROWSER);
            let scene = &stage.sim().scene;
            let file = tools.editor.file(scene).map(|path| path.to_string_lossy());
            let here = (file.as_deref().unwrap_or(&scene.name), stage.files.all());
            let side = side.show(root, |ui| self.browser.show(ui, here, intents));
            self.lay_out_part(Part::Scenes, side.response.rect, &side.inner);
        }
        if docks {
            self.tab = self.next_tab.take().or(opens).unwrap_or(self.tab);
            // On a screen as narrow as a phone, the dock is below the view.
            let is_beside = width >= self.dock.room;
            let range = DOCK[0]..=0.6 * width;
            let side = if is_beside {
                let usual = (width * DOCK_SHARE).clamp(DOCK[0], DOCK[1]);
                let side = Side::right("dock").default_size(usual).size_range(range.clone());
                match self.dock_width.set.take() {
                    Some(set) => side.exact_size(set.clamp(*range.start(), *range.end())),
                    None => side,
                }
            } else {
                Side::bottom("dock below").exact_size(DOCK_BELOW * root.available_height())
            };
            let side = side.frame(bare).show(root, |ui| {
                let panels = dock::OpenPanels { opened, newest };
                dock::show(ui, &mut self.tab, panels, stage, view, tools, intents)
            });
            if is_beside {
                self.dock_width.note(width, side.response.rect.width());
            }
            self.lay_out_part(Part::Dock, side.response.rect, &side.inner);
        }
        if opened.contains(&Panel::Learn) && tools.learn.lesson().is_some() {
            let strip = Side::bottom("lesson").resizable(false).exact_size(learn::height(width));
            strip.show(root, |ui| {
                let dock_width = Some(ui.available_width());
                let mut desk = Desk { stage, view, dock_width, intents, closes: false };
                tools.learn.show(ui, &mut desk);
            });
        }
        // These bars come and go: they lie over the view, and nothing moves.
        self.free = root.available_rect_before_wrap();
        self.fault.show(root, &mut self.free, stage, intents);
        files_bar(root, &mut self.free, stage);
        away::show(root, &mut self.free, stage, view, &mut self.seen, intents);
        self.opened = opened.to_owned();
    }
}
