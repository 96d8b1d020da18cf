//! How a person arranged the panels: as text, and brought back from it.

use crate::app::actions::named;
use crate::app::session::Session;
use crate::tools::{Panel, TOOLS};

/// The action that hides what a person never hid.
const COCKPIT: &str = "toggle_cockpit";
const BROWSER: &str = "toggle_browser";
const DOCK_WIDTH: &str = "dock_width";

/// Most steps between two sizes of panels that are believed.
const MOST_SIZES: isize = 10;

impl Session {
    /// How the panels are arranged, an action and its state in each line: `on`, `off`, or how many times it was done.
    #[must_use]
    pub fn arrangement(&self) -> String {
        let chosen = |(name, _): &(&str, bool)| *name != BROWSER || self.ui.cockpit.has_chosen_browser();
        let switches = self.switches(self.ui.width()).into_iter().filter(chosen);
        let mut text: String =
            switches.map(|(name, on)| format!("{name} {}\n", if on { "on" } else { "off" })).collect();
        match self.ui.sizes_above_usual() {
            0 => {}
            up @ 1.. => text += &format!("larger {up}\n"),
            down => text += &format!("smaller {}\n", -down),
        }
        if let Some(points) = self.ui.cockpit.chosen_dock_width() {
            text += &format!("{DOCK_WIDTH} {points}\n");
        }
        text
    }

    /// Arranges the panels as `text` says, whatever is open or asked. Unknown lines change nothing; without one about them, the bars
    /// and the dock are shown.
    pub(crate) fn arrange(&mut self, text: &str) {
        let states: Vec<_> = text.lines().filter_map(|line| line.split_once(' ')).collect();
        let state = |name: &str| states.iter().find(|(other, _)| *other == name).map(|(_, state)| *state);
        let count =
            |name: &str| state(name).and_then(|count| count.parse().ok()).unwrap_or(0).clamp(0, MOST_SIZES);
        let sizes: isize = count("larger") - count("smaller");
        for _ in 0..sizes.abs() {
            self.ui.zoom_by(sizes.signum());
        }
        for (name, on) in self.switches(self.ui.width()) {
            let wanted = match state(name) {
                Some("on") => true,
                Some("off") => false,
                _ if name == COCKPIT => true,
                _ => continue,
            };
            if name == BROWSER {
                self.ui.cockpit.set_browser(wanted);
            } else if let Some(binding) = named(name).filter(|_| wanted != on) {
                self.act(binding.does);
            }
        }
        let dock_width = state(DOCK_WIDTH).and_then(|points| points.parse().ok());
        if let Some(points) = dock_width.filter(|points: &f64| points.is_finite() && *points > 0.0) {
            self.ui.cockpit.set_dock_width(points);
        }
    }

    /// Actions that switch something on and off, and whether it is on, on a screen of that width in points.
    fn switches(&self, width: f32) -> Vec<(&'static str, bool)> {
        let cockpit = &self.ui.cockpit;
        let parts = [
            (COCKPIT, cockpit.shown),
            ("toggle_theme", self.ui.is_light()),
            (BROWSER, cockpit.browses(width)),
            ("toggle_dock", cockpit.dock),
        ];
        // Ghosts end with their scene; the others stand over it and are soon closed again.
        let passing = [Panel::Ghosts, Panel::Help, Panel::Finder];
        let panels = TOOLS.iter().filter(|(panel, _)| !passing.contains(panel));
        parts.into_iter().chain(panels.map(|(panel, row)| (row.name, self.ui.shows(*panel)))).collect()
    }
}
