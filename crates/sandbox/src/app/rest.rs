//! Whether a session changes by itself, and how fast it is to go.

use crate::app::session::Session;
use crate::app::ui::Panel;

/// What a person sets that changes how long a frame or a tick takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedSetting {
    pub pace: f64,
    pub paused: bool,
    pub ghosts: bool,
}

impl Session {
    /// Seconds after the last frame until something changes without input; infinite where nothing does.
    #[must_use]
    pub fn changes_in_s(&self) -> f64 {
        let measures = self.ui.shows(Panel::Cost) && self.cost_progress() < 1.0;
        let plays = self.player.as_ref().is_some_and(|player| !player.finished());
        let does = plays || measures || !self.control.held.is_empty() || !self.orders.is_empty();
        if does || !self.control.paused || !self.arrived() {
            return 0.0;
        }
        self.ui.changes_in_s(self.clock.now())
    }

    /// The open panels in the order in which they were opened.
    #[must_use]
    pub fn open_panels(&self) -> &[Panel] {
        self.ui.opened()
    }

    /// Simulated time with the part of the next tick that has passed, s.
    pub(crate) fn progress(&self) -> f64 {
        self.simulated() + self.clock.fraction() / self.clock.rate()
    }

    pub(crate) fn speed_setting(&self) -> SpeedSetting {
        SpeedSetting { pace: self.clock.pace(), paused: self.control.paused, ghosts: self.ghosts.is_some() }
    }
}
