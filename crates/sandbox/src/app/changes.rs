//! Changes of the running simulation that a person, a script or a panel asks for.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use history::Change;
use lab::cost::Setting;
use motion::effects::{Effect, EffectState, NeverDeclared};
use motion::{Method, MutualGravity, OwnMethod, Particle, Request, Substeps, TimeStep};
use scene::{Action, unsolvable};

use crate::app::session::{Session, SwitchedBy};
use crate::input::Input;
use crate::tools::tool::{Edit, Tool as _};
use crate::view::notices::Topic;
use crate::view::stage::Order;

impl Session {
    /// Does what a script's action says.
    pub(crate) fn carry_out(&mut self, action: &Action) {
        if let Action::Screenshot(name) = action {
            self.orders.push(Order::Screenshot(Some(name.clone())));
            return;
        }
        match Change::of(action, &self.sim) {
            Ok(Some(change)) => self.change(change, SwitchedBy::Script),
            Ok(None) => {}
            Err(gone) => self.refuse(gone.to_string()),
        }
    }

    /// Makes a change of the simulation; one that its methods cannot solve is refused.
    pub fn change(&mut self, change: Change, by: SwitchedBy) {
        match change {
            Change::Requests(requests) => {
                requests.into_iter().for_each(|request| self.ask_by(request, by));
            }
            Change::Method(method) => self.set_method(method),
            Change::Substeps(substeps) => self.set_substeps(substeps),
            Change::Step(step) => self.set_rate(1.0 / step),
            Change::Push(..) => self.sim.give(&change),
        }
    }

    /// Does what a panel asks for.
    pub(crate) fn edit(&mut self, edit: Edit) {
        match edit {
            Edit::Change(change, by) => self.change(change, by),
            Edit::ApplySetting(setting) => self.choose(setting),
            Edit::StepHz(rate) => self.set_rate(rate),
            Edit::Seek(tick) => self.begin_seek(tick),
            Edit::SaveBundle => self.order_bundle(),
            Edit::SaveTable(text) => self.orders.push(Order::Table(text)),
            Edit::Open(scene) => self.leave(Order::Open(scene)),
            Edit::Rewrite(changes, select) => self.rewrite(&changes, select.as_deref()),
            Edit::Answer(answer) => self.answer(answer),
            Edit::Act(act) => self.act(act),
            Edit::Pace(pace) => self.set_pace(pace / self.clock.pace()),
        }
    }

    /// Goes on with ticks of another rate, Hz.
    fn set_rate(&mut self, rate: f64) {
        if self.clock.set_rate(rate).is_ok() {
            self.record(Change::Step(1.0 / rate));
            self.notices.retract(Topic::Forecast);
            self.sim.world.insert_resource(TimeStep(1.0 / rate));
        }
    }

    /// Goes on with another method of the scene.
    pub(crate) fn set_method(&mut self, method: Method) {
        let gravity = self.sim.world.contains_resource::<MutualGravity>();
        if self.refuses([method], gravity) {
            return;
        }
        if method != self.sim.method() {
            self.record(Change::Method(method));
            self.notices.retract(Topic::Method);
            self.notices.retract(Topic::Forecast);
        }
        self.sim.set_method(method);
    }

    /// Goes on with another number of substeps of the scene.
    fn set_substeps(&mut self, substeps: u32) {
        Arc::make_mut(&mut self.sim.scene).substeps = substeps;
        self.record(Change::Substeps(substeps));
        self.notices.retract(Topic::Forecast);
        self.sim.world.insert_resource(Substeps(substeps));
        self.tools.ghosts.restart(&mut self.stage);
    }

    /// Goes on with a setting that a panel offers. In a recording steps name it, and this does nothing: what a panel offers
    /// depends on what its machine measured.
    fn choose(&mut self, setting: Setting) {
        if self.player.as_ref().is_some_and(|player| player.names_settings(self.run.frames)) {
            return;
        }
        for chosen in [Action::SetMethod(setting.method), Action::SetSubsteps(setting.substeps)] {
            self.carry_out(&chosen);
            self.chosen.push(Input::Act(chosen));
        }
    }

    /// Says so where one of `methods` cannot solve what is declared.
    fn refuses(&mut self, methods: impl IntoIterator<Item = Method>, mutual_gravity: bool) -> bool {
        let why = methods.into_iter().find_map(|method| unsolvable(method, mutual_gravity));
        if let Some(why) = why {
            self.refuse(format!("{why}; take another method"));
        }
        why.is_some()
    }

    /// Whether mutual gravity cannot come back, because a method was chosen meanwhile that cannot solve it.
    fn refuses_mutual_gravity(&mut self) -> bool {
        let sim = &mut self.stage.sim;
        // Also of bodies that nothing moves now, and where every body has one of its own; particles are not attracted.
        let mut bodies = sim.world.query_filtered::<EntityRef, (With<OwnMethod>, Without<Particle>)>();
        let own = bodies.iter(&sim.world).filter_map(motion::own_method);
        let methods: Vec<_> = own.chain([sim.method()]).collect();
        self.refuses(methods, true)
    }

    /// Switches an effect off or on again, at once. One that the scene never declared is told to the person.
    ///
    /// # Errors
    /// An effect that the scene never declared.
    pub fn switch_effect(&mut self, effect: Effect, on: bool, by: SwitchedBy) -> Result<(), NeverDeclared> {
        // What was asked for before comes first.
        self.carry_out_requests();
        self.refuse_undeclared(effect)?;
        if effect == Effect::MutualGravity && on && self.refuses_mutual_gravity() {
            // It is there and stays off: the person was told why.
            return Ok(());
        }
        self.ask(Request::Switch(effect, on));
        self.carry_out_requests();
        self.note_switched(effect, by);
        Ok(())
    }

    fn refuse_undeclared(&mut self, effect: Effect) -> Result<(), NeverDeclared> {
        if motion::effects::state(&mut self.sim.world, effect) != EffectState::NotDeclared {
            return Ok(());
        }
        let error = NeverDeclared(effect);
        self.refuse(error.to_string());
        Err(error)
    }

    /// Requests a change, and remembers the source of a change of an effect. An effect that the scene never declared is
    /// refused, except from the settings, which declare it and say so.
    fn ask_by(&mut self, request: Request<u32>, by: SwitchedBy) {
        let effect = match request {
            Request::Switch(effect, on) => {
                // The person was told if there is no such effect in the scene.
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
            _ => None,
        };
        if let Some(effect) = effect {
            if by != SwitchedBy::Settings {
                if self.refuse_undeclared(effect).is_err() {
                    return;
                }
            } else if motion::effects::state(&mut self.sim.world, effect) == EffectState::NotDeclared {
                self.notice(format!("{effect} is declared by the settings now, not by the scene"));
            }
            self.note_switched(effect, by);
        }
        self.sim.give(&Change::request(request));
    }

    /// Remembers what switched an effect last.
    pub(crate) fn note_switched(&mut self, effect: Effect, by: SwitchedBy) {
        self.tools.effects.switched.insert(effect, by);
        self.notices.retract(Topic::Forecast);
        if effect == Effect::Gravity {
            self.notices.retract(Topic::Gravity);
        }
    }

    /// Carries out at once what was asked for; what is gone after that is not selected, followed or hit.
    pub(crate) fn carry_out_requests(&mut self) {
        self.record_requests();
        self.carry_out_unrecorded();
    }

    pub(crate) fn carry_out_unrecorded(&mut self) {
        for (_, tool) in self.tools.each() {
            tool.before_requests(&mut self.stage);
        }
        let (sim, seen) = (&mut self.stage.sim, &mut self.stage.seen);
        sim.carry_out_requests();
        seen.targets_current = false;
        for thing in [&mut seen.selection, &mut seen.locked] {
            thing.take_if(|thing| sim.world.get_entity(*thing).is_err());
        }
    }
}
