//! Going on in a past that is repeated: what came from outside then comes again.

use history::{Event, Input, Intervention};

use crate::app::session::Session;

impl Session {
    /// Whether the coming tick is one that was recorded and is repeated.
    pub(crate) fn repeats(&self) -> bool {
        self.recorded.as_ref().is_some_and(|recorded| {
            recorded.repeats
                && self.ticks() < *recorded.timeline.range().end()
                && self.sim.pending().is_empty()
        })
    }

    /// Does again what came from outside before the coming tick, if that is repeated; whether it is.
    pub(crate) fn repeat_before_tick(&mut self) -> bool {
        let repeats = self.repeats();
        if repeats {
            self.repeat_events();
        }
        repeats
    }

    /// Does what was recorded at the end of the last tick.
    pub(crate) fn repeat_events(&mut self) {
        let now = self.ticks();
        let Some(recorded) = &self.recorded else { return };
        let events: Vec<Event> = recorded.timeline.events_after(now).cloned().collect();
        for Event { what, .. } in events {
            if let Intervention::Requests(requests) = &what {
                self.sim.give(requests.iter().copied().map(Input::Request));
                self.carry_out_unrecorded();
            } else {
                self.sim.apply(&what);
            }
        }
    }
}
