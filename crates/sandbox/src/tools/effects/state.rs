//! Effects of a running session: who switched them, and what its receipt says.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use lab::Row;
use motion::effects::{Effect, EffectState, NeverDeclared};
use motion::{Evaluations, PreviousPosition, Request};

use crate::app::session::Session;
use crate::app::ui::Topic;

/// Who switched an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SwitchedBy {
    /// The key G.
    Key,
    /// A step of a script.
    Script,
    /// A box in the panel of effects.
    Panel,
    /// The settings, where gravity and damping have values.
    Settings,
    /// A flag of the command line.
    Flag,
}

impl SwitchedBy {
    /// The words for it in receipts.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Key => "switched by G",
            Self::Script => "switched by script",
            Self::Panel => "switched in the panel",
            Self::Settings => "changed in the settings",
            Self::Flag => "switched by --without",
        }
    }
}

/// Why a run is recorded.
const RECORDED: &str = "going back: the window, --black-box";

/// The row of the watch for energy out of nowhere.
pub(crate) const ENERGY_WATCH: &str = "energy_watch";

/// Ticks that the panel measures: an answer in a fraction of a second for a scene of some hundred bodies.
const MEASURED_TICKS: u64 = 60;

/// Bodies up to which the panel measures: the window waits for it.
const MEASURED_BODIES: usize = 5_000;

/// What a session remembers for its receipt.
#[derive(Default)]
pub(crate) struct Effects {
    switched: BTreeMap<Effect, SwitchedBy>,
    /// Tick and counts of the last look, and evaluations a step between the two before.
    seen: (u64, Vec<(&'static str, u64)>),
    rates: Vec<(&'static str, f64)>,
    /// Nanoseconds a step and share by name, as measured on a copy of the scene.
    measured: Vec<(&'static str, Option<f64>, Option<f64>)>,
}

impl Session {
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

    /// Asks for a change, and remembers who did if it is one of an effect. The settings may declare one, which is told; for all
    /// others one that is not declared is refused.
    pub(crate) fn ask_by(&mut self, request: Request, by: SwitchedBy) {
        let effect = match request {
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
        self.ask(request);
    }

    /// Remembers who switched an effect last.
    pub(crate) fn note_switched(&mut self, effect: Effect, by: SwitchedBy) {
        self.effects.switched.insert(effect, by);
        self.ui.retract(Topic::Forecast);
        if effect == Effect::Gravity {
            self.ui.retract(Topic::Gravity);
        }
    }

    /// The receipt of the session as it is: what acts, because of what, on how many bodies; evaluations a step are
    /// those since the last look, times those of the last measurement.
    pub fn receipt(&mut self) -> Vec<Row> {
        self.look_at_rates();
        let mut rows = lab::look(&self.sim.scene, &mut self.sim.world, self.sim.stepper.method());
        rows.extend(self.picture_rows());
        for row in &mut rows {
            if let Some(by) = row.effect.and_then(|effect| self.effects.switched.get(&effect)) {
                row.because = Some(by.words().to_owned());
            }
            if let Some((_, rate)) = self.effects.rates.iter().find(|(law, _)| *law == row.name) {
                row.evaluations = *rate;
            }
            if let Some((_, ns, share)) = self.effects.measured.iter().find(|(name, ..)| *name == row.name) {
                (row.ns, row.share) = (*ns, *share);
            }
        }
        rows
    }

    /// What a session with pictures has beside the step.
    pub fn picture_rows(&mut self) -> [Row; 6] {
        let row = |name, on: bool, bodies, bytes, why: &str| Row {
            because: on.then(|| why.to_owned()),
            bodies: if on { bodies } else { 0 },
            bytes: if on { bytes } else { 0 },
            ..Row::of(name, if on { EffectState::On } else { EffectState::Off })
        };
        let drawn_between = self.sim.world.query::<&PreviousPosition>().iter(&self.sim.world).count();
        let targets = self.targets();
        let (shapes, (xs, ys, zs)) = (targets.entities().len(), targets.positions());
        let picked = size_of_val(targets.entities()) + size_of_val(xs) + size_of_val(ys) + size_of_val(zs);
        let movable = self.methods().into_iter().map(|(_, bodies)| bodies).sum();
        let arrows = self.control.velocity_arrows || self.control.force_arrows;
        let timeline = self.timeline_bytes();
        let shadows = self.sim.scene.light.is_some_and(|light| light.shadows);
        [
            row(
                "interpolation",
                self.options.interpolate,
                drawn_between,
                drawn_between * size_of::<PreviousPosition>(),
                "pictures between two ticks",
            ),
            row("picking", shapes > 0, shapes, picked, "pictures and the pointer"),
            match shadows {
                true => row("shadows", self.options.pictures, shapes, 0, "light.shadows"),
                false => Row::of("shadows", EffectState::NotDeclared),
            },
            row("arrows", arrows, movable, 0, "keys 1 and 2"),
            row("timeline", self.records(), 0, timeline, RECORDED),
            row(ENERGY_WATCH, self.records(), movable, history::Watch::bytes(), RECORDED),
        ]
    }

    /// Measures on a copy of the scene, from its start, what each effect costs a step.
    pub(crate) fn measure_effects(&mut self) {
        if self.sim.scene.bodies.len() > MEASURED_BODIES {
            self.notice(format!(
                "too many bodies to wait for: run `sandbox effects {}`",
                self.sim.scene.name
            ));
            return;
        }
        let off = |effect: &Effect| motion::effects::state(&mut self.sim.world, *effect) == EffectState::Off;
        let without: Vec<_> = Effect::ALL.into_iter().filter(off).collect();
        let receipt = lab::receipt_without(&self.sim.scene, MEASURED_TICKS, &without);
        let watch = lab::watch_time(&self.sim.scene);
        let rows = receipt.rows.iter().map(|row| (row.name, row.ns, row.share));
        self.effects.measured = rows.chain([(ENERGY_WATCH, Some(watch), Some(watch / receipt.ns))]).collect();
    }

    #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
    fn look_at_rates(&mut self) {
        let now = self.ticks();
        let (then, before) = &self.effects.seen;
        if now <= *then {
            return;
        }
        let counts = self.sim.world.resource::<Evaluations>().laws().to_vec();
        let ticks = (now - then) as f64;
        let was = |law| before.iter().find(|(name, _)| *name == law).map_or(0, |(_, count)| *count);
        self.effects.rates = counts
            .iter()
            .map(|(law, count)| (*law, count.saturating_sub(was(*law)) as f64 / ticks))
            .collect();
        self.effects.seen = (now, counts);
    }

    /// Counts evaluations a step from here on: what was counted before was another scene.
    pub(crate) fn count_effects_from_now(&mut self) {
        self.effects.seen = (self.ticks(), self.sim.world.resource::<Evaluations>().laws().to_vec());
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use motion::Gravity;
    use scene::Scene;

    use super::*;
    use crate::app::session::Options;

    #[test]
    fn the_settings_declare_an_effect_and_say_so_and_a_script_is_refused() {
        let scene = Scene::parse("bare", "(version: 1)").expect("it is a scene");
        let mut session = Session::new(scene, Options::default());
        let mut declared_by = |by| {
            session.ask_by(Request::SetGravity(DVec3::Y), by);
            session.carry_out_requests();
            let said = session.notices().last().expect("either is told").to_owned();
            (session.world().contains_resource::<Gravity>(), said)
        };
        assert_eq!(declared_by(SwitchedBy::Script), (false, "this scene never declared gravity".to_owned()));
        let said = "gravity is declared by the settings now, not by the scene".to_owned();
        assert_eq!(declared_by(SwitchedBy::Settings), (true, said));
    }
}
