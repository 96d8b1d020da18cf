//! A script that a session plays.
//!
//! Its keys and pointer act at the start of a frame, as a person's do. Its other steps act between two ticks, so that they
//! act in the same tick whatever the frames are.

use bevy_ecs::prelude::*;
use motion::TimeStep;
use motion::clock::{FrameTime, StepClock};
use scene::When;

use super::Session;
use crate::player::Player;

impl Session {
    /// Plays a script from the next frame on, beside the input of frames.
    pub fn play(&mut self, player: Player) {
        self.player = Some(player);
    }

    /// The script that is played, if one is.
    #[must_use]
    pub const fn player(&self) -> Option<&Player> {
        self.player.as_ref()
    }

    /// What the script waits for in vain while the session is paused, at `rate` frames a second.
    pub(crate) fn waits_in_vain(&self, rate: f64) -> Option<When> {
        self.player.as_ref()?.waits_in_vain(self, rate)
    }

    /// Does what the script does at the start of a frame.
    pub(super) fn play_frame(&mut self, time: FrameTime) {
        let (frame, ticks) = (self.frames, self.ticks());
        let Some(player) = &mut self.player else { return };
        for input in player.of_frame(frame, ticks, time.total()) {
            self.handle(&input);
        }
    }

    /// Does what the script does before the next tick; whether that is something.
    pub(super) fn play_tick(&mut self) -> bool {
        let Some(player) = &mut self.player else { return false };
        let (clock, step) = (self.world.resource::<StepClock>(), self.world.resource::<TimeStep>());
        let inputs = player.of_tick(clock.ticks(), clock.seconds(), step.0);
        for input in &inputs {
            self.handle(input);
        }
        !inputs.is_empty()
    }

    /// [`Self::play_tick`] between two ticks of a frame.
    pub(super) fn play_between_ticks(&mut self) {
        if self.play_tick() {
            self.carry_out_requests();
            self.note_pushes();
        }
    }

    /// A body of the scene; where it is gone, that is told.
    pub(crate) fn body_or_refuse(&mut self, name: &str) -> Option<Entity> {
        let body = self.body(name);
        if body.is_none() {
            self.refuse(format!("there is no body {name} any more"));
        }
        body
    }
}
