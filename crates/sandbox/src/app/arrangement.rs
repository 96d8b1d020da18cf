//! How a person arranged the panels: as text, and brought back from it.

use crate::actions::Act;
use crate::app::session::Session;
use crate::panels::{PANELS, Panel};

const DOCK_WIDTH: &str = "dock_width";

/// Most steps between two sizes of panels that are believed.
const MOST_SIZES: isize = 10;

impl Session {
    /// How the panels are arranged, an action and its state in each line: `on`, `off`, or how many times it was done.
    #[must_use]
    pub fn arrangement(&self) -> String {
        let chosen =
            |(act, _): &(Act, bool)| *act != Act::ToggleBrowser || self.ui.cockpit.has_chosen_browser();
        let switches = self.switches(self.ui.width()).into_iter().filter(chosen);
        let mut text: String =
            switches.map(|(act, on)| format!("{} {}\n", act.name(), if on { "on" } else { "off" })).collect();
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
        for (act, on) in self.switches(self.ui.width()) {
            let wanted = match state(act.name()) {
                Some("on") => true,
                Some("off") => false,
                // It hides what a person never hid.
                _ if act == Act::ToggleCockpit => true,
                _ => continue,
            };
            if act == Act::ToggleBrowser {
                self.ui.cockpit.set_browser(wanted);
            } else if wanted != on {
                self.act(act);
            }
        }
        let dock_width = state(DOCK_WIDTH).and_then(|points| points.parse().ok());
        if let Some(points) = dock_width.filter(|points: &f64| points.is_finite() && *points > 0.0) {
            self.ui.cockpit.set_dock_width(points);
        }
    }

    /// Actions that switch something on and off, and whether it is on, on a screen of that width in points.
    fn switches(&self, width: f32) -> Vec<(Act, bool)> {
        let cockpit = &self.ui.cockpit;
        let parts = [
            (Act::ToggleCockpit, cockpit.shown),
            (Act::ToggleTheme, self.ui.is_light()),
            (Act::ToggleBrowser, cockpit.browses(width)),
            (Act::ToggleDock, cockpit.dock),
        ];
        // Ghosts end with their scene; the others stand over it and are soon closed again.
        let passing = [Panel::Ghosts, Panel::Help, Panel::Finder];
        let panels = PANELS.iter().map(|(panel, _)| *panel).filter(|panel| !passing.contains(panel));
        parts.into_iter().chain(panels.map(|panel| (Act::Panel(panel), self.ui.shows(panel)))).collect()
    }
}
