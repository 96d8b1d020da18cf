//! How a person arranged the panels: as text, and as the input that brings it back.

use crate::app::actions::key_of_word;
use crate::app::session::Session;
use crate::app::ui::Ui;
use crate::input::Input;
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

    /// The input that arranges the panels as `text` says, in a window of that size on a display of that scale. Unknown lines
    /// change nothing; without one about them, the bars and the dock are shown.
    #[must_use]
    pub fn input_to_arrange(&self, text: &str, size_px: [u32; 2], scale: f64) -> Vec<Input> {
        let states: Vec<_> = text.lines().filter_map(|line| line.split_once(' ')).collect();
        let state = |name: &str| states.iter().find(|(other, _)| *other == name).map(|(_, state)| *state);
        let presses =
            |name: &str| state(name).and_then(|count| count.parse().ok()).unwrap_or(0).clamp(0, MOST_SIZES);
        let sizes: isize = presses("larger") - presses("smaller");
        let resized = (0..sizes.abs()).map(|_| if sizes > 0 { "larger" } else { "smaller" });
        let width = Ui::width_of(size_px, scale, sizes);
        let switched = self.switches(width).into_iter().flat_map(|(name, on)| {
            let wanted = match state(name) {
                Some("on") => Some(true),
                Some("off") => Some(false),
                _ => (name == COCKPIT).then_some(true),
            };
            // Twice leaves the scenes as they are, and as a person's choice: else they follow the width of the window.
            let presses = match wanted {
                Some(wanted) if wanted != on => 1,
                Some(_) if name == BROWSER => 2,
                _ => 0,
            };
            std::iter::repeat_n(name, presses)
        });
        let keys = resized.chain(switched).filter_map(|name| key_of_word(name).ok());
        let dock_width = state(DOCK_WIDTH).and_then(|points| points.parse().ok());
        let dock_width = dock_width.filter(|points: &f64| points.is_finite() && *points > 0.0);
        let taps = keys.flat_map(|key| [Input::KeyDown(key.clone()), Input::KeyUp(key)]);
        taps.chain(dock_width.map(Input::DockWidth)).collect()
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
