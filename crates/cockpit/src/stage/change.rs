//! Changes of the running simulation that a person, a script or a panel asks for.

use bevy_ecs::prelude::*;
use history::Change;
use motion::effects::{Effect, EffectState, NeverDeclared};
use motion::{Method, MutualGravity, OwnMethod, Particle, Request};
use scene::{ChangeAction, PictureAction, unsolvable};

use crate::input::SwitchedBy;
use crate::stage::notices::Topic;
use crate::stage::{Order, Stage};

impl Stage {
    /// Makes a change of a script.
    pub(crate) fn carry_out(&mut self, action: &ChangeAction) {
        match Change::of(action, &self.sim) {
            Ok(change) => self.change(change, SwitchedBy::Script),
            Err(gone) => self.notices.refuse(Topic::Other, gone.to_string()),
        }
    }

    /// Does something about the picture for a script.
    pub(crate) fn show(&mut self, action: &PictureAction) {
        match action {
            PictureAction::Screenshot(name) => {
                self.orders.push(Order::Screenshot(Some(name.clone())));
            }
            PictureAction::Caption(words) => self.caption = Some(words.clone()),
        }
    }

    /// Makes a change of the simulation. Refuses a change that its methods cannot solve.
    pub fn change(&mut self, change: Change, by: SwitchedBy) {
        self.here.interventions += 1;
        match change {
            Change::Requests(requests) => {
                requests.into_iter().for_each(|request| self.ask_by(request, by));
            }
            Change::Method(method) => {
                let gravity = self.sim.world.contains_resource::<MutualGravity>();
                if !self.refuses([method], gravity) && method != self.sim.method() {
                    self.notices.retract(Topic::Method);
                    self.notices.retract(Topic::Forecast);
                    self.give(change);
                }
            }
            Change::Substeps(_) => {
                self.notices.retract(Topic::Forecast);
                self.give(change);
            }
            Change::Step(step) => {
                if self.playback.set_step(step) {
                    self.notices.retract(Topic::Forecast);
                    self.give(change);
                }
            }
            Change::Push(..) => self.give(change),
        }
    }

    /// Makes a change between two ticks and records it. Cancels a seek, drops the quarantines that are ahead, because the run
    /// differs from now on, and clears the selection if the change removed the thing.
    pub(crate) fn give(&mut self, change: Change) {
        self.recorder.watch_again();
        self.quarantines.forget_ahead();
        self.give_up_seek();
        self.recorder.note(&self.sim, &change);
        self.give_again(change);
    }

    /// Makes a change that is already recorded.
    pub(crate) fn give_again(&mut self, change: Change) {
        self.sim.give(&change);
        self.keep_substeps();
        // A push moves no body before the tick.
        self.here.version += u64::from(!matches!(change, Change::Push(..)));
        self.here.untold.push(change);
        let Self { sim, here, .. } = self;
        here.selection.take_if(|thing| sim.world.get_entity(*thing).is_err());
    }

    /// Refuses the first of `methods` that cannot be used with `mutual_gravity`. Returns whether there was one.
    fn refuses(&mut self, methods: impl IntoIterator<Item = Method>, mutual_gravity: bool) -> bool {
        let why = methods.into_iter().find_map(|method| unsolvable(method, mutual_gravity));
        if let Some(why) = why {
            self.notices.refuse(Topic::Method, format!("{why}; take another method"));
        }
        why.is_some()
    }

    /// Switches an effect off or on again, at once. Tells the person if the scene never declared the effect.
    ///
    /// # Errors
    /// An effect that the scene never declared.
    pub fn switch_effect(
        &mut self,
        effect: Effect,
        on: bool,
        by: SwitchedBy,
    ) -> Result<(), NeverDeclared> {
        self.refuse_undeclared(effect)?;
        if effect == Effect::MutualGravity && on {
            // Includes bodies that do not move now; particles are not attracted.
            let world = &mut self.sim.world;
            let mut bodies =
                world.query_filtered::<EntityRef, (With<OwnMethod>, Without<Particle>)>();
            let own: Vec<_> = bodies.iter(world).filter_map(motion::own_method).collect();
            if self.refuses(own.into_iter().chain([self.sim.method()]), true) {
                // The effect is declared and stays off: the person was told why.
                return Ok(());
            }
        }
        self.give(Change::request(Request::Switch(effect, on)));
        self.note_switched(effect, by);
        Ok(())
    }

    fn refuse_undeclared(&mut self, effect: Effect) -> Result<(), NeverDeclared> {
        if motion::effects::state(&self.sim.world, effect) != EffectState::NotDeclared {
            return Ok(());
        }
        let error = NeverDeclared(effect);
        self.notices.refuse(Topic::Other, error.to_string());
        Err(error)
    }

    /// Makes a request and remembers the source of a change of an effect. Refuses an effect that the scene never declared,
    /// unless the settings made the request: they declare it and tell the person.
    fn ask_by(&mut self, request: Request<u32>, by: SwitchedBy) {
        let effect = match request {
            Request::Switch(effect, on) => {
                // The person was told if the scene never declared the effect.
                let _ = self.switch_effect(effect, on, by);
                return;
            }
            Request::SetBodyMethod(_, method) => {
                let gravity = self.sim.world.contains_resource::<MutualGravity>();
                if self.refuses([method.unwrap_or(self.sim.method())], gravity) {
                    return;
                }
                None
            }
            Request::SetGravity(_) | Request::SwitchGravity(_) => Some(Effect::Gravity),
            Request::SetDamping(_) => Some(Effect::Damping),
            Request::Impulse(..)
            | Request::SetVelocity(..)
            | Request::SetPosition(..)
            | Request::SetInverseMass(..)
            | Request::ReverseVelocities
            | Request::Remove(_) => None,
        };
        if let Some(effect) = effect {
            if by != SwitchedBy::Settings {
                if self.refuse_undeclared(effect).is_err() {
                    return;
                }
            } else if motion::effects::state(&self.sim.world, effect) == EffectState::NotDeclared {
                self.notices.say(
                    Topic::Other,
                    format!("{effect} is set by the settings now; saving the scene writes it into the file"),
                );
            }
            self.note_switched(effect, by);
        }
        self.give(Change::request(request));
    }

    /// Remembers the source of the last change of an effect.
    fn note_switched(&mut self, effect: Effect, by: SwitchedBy) {
        self.switched.insert(effect, by);
        self.notices.retract(Topic::Forecast);
        if effect == Effect::Gravity {
            self.notices.retract(Topic::Gravity);
        }
    }
}
