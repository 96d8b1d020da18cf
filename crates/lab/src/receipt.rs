//! The receipt of a scene: each effect, whether it acts and why, on how many bodies, and what it costs in time and
//! memory.

use bevy_ecs::prelude::*;
use history::Simulation;
use motion::effects::{Effect, EffectState, column_bytes};
use motion::internals::values;
use motion::snapshot::{LastAcceleration, LastStep};
use motion::{Dormant, Method, OwnMethod, PhysicsBody, Quarantined, Static, own_method};
use scene::{Declaration, Scene};

use crate::run::{ByEffect, started, step_times};

/// One line of a receipt.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiptLine {
    /// Its name.
    pub name: &'static str,
    /// The effect; `None` for the state of methods and for pictures.
    pub effect: Option<Effect>,
    /// Whether it acts.
    pub state: EffectState,
    /// Why it acts: the key of the scene file that declares it, with its line if that is known, or what switched it.
    pub because: Option<String>,
    /// Bodies that it acts on.
    pub bodies: usize,
    /// Evaluations per step, counted in the run.
    pub evaluations: f64,
    /// Thread CPU time that a step saves without it, ns; `None` if not measured. A value near 0 or below is within
    /// the noise.
    pub ns: Option<f64>,
    /// `ns` as a part of the whole step.
    pub share: Option<f64>,
    /// Bytes of state in the world.
    pub bytes: usize,
}

impl ReceiptLine {
    /// A line without an effect and without costs.
    pub const fn of(name: &'static str, state: EffectState) -> Self {
        Self {
            name,
            effect: None,
            state,
            because: None,
            bodies: 0,
            evaluations: 0.0,
            ns: None,
            share: None,
            bytes: 0,
        }
    }
}

/// What the effects of a run do and cost: every effect, declared or not, then the state of methods.
pub type Receipt = ByEffect<ReceiptLine>;

/// The receipt of `ticks` ticks of `scene`, at least 1, from its start, with effects switched off before the first tick.
pub fn receipt(scene: &Scene, ticks: u64, without: &[Effect]) -> Receipt {
    let ticks = ticks.max(1);
    let mut simulation = started(scene.clone(), without);
    simulation.run(ticks);
    let evaluations = simulation.evaluations().clone();
    let mut rows = receipt_without_running(&simulation);
    let acting: Vec<_> = rows
        .iter()
        .filter(|row| row.state == EffectState::On)
        .filter_map(|row| row.effect)
        .collect();
    let one_less = |effect: &Effect| without.iter().copied().chain([*effect]).collect();
    let variants: Vec<_> =
        [without.to_vec()].into_iter().chain(acting.iter().map(one_less)).collect();
    let times = step_times(scene, &variants, ticks);
    let ns = times.first().copied().unwrap_or_default();
    for row in &mut rows {
        let count = match row.name {
            IMPLICIT_SOLVER => evaluations.newton_iterations() + evaluations.cg_iterations(),
            name => evaluations
                .laws()
                .iter()
                .find(|(law, _)| *law == name)
                .map_or(0, |(_, count)| *count),
        };
        row.evaluations = count as f64 / ticks as f64;
        if let Some(place) = acting.iter().position(|effect| Some(*effect) == row.effect) {
            let saved = ns - times[place + 1];
            (row.ns, row.share) = (Some(saved), Some(saved / ns));
        } else if row.effect.is_some() {
            (row.ns, row.share) = (Some(0.0), Some(0.0));
        }
    }
    Receipt { scene: scene.name.clone(), method: scene.method, ticks, ns, rows }
}

const IMPLICIT_SOLVER: &str = "implicit_solver";

/// The lines of a simulation in its present state, without running it: evaluations and times are not filled in.
pub fn receipt_without_running(simulation: &Simulation) -> Vec<ReceiptLine> {
    let method = simulation.method();
    let Simulation { scene, world, .. } = simulation;
    let mut rows: Vec<_> = Effect::ALL
        .into_iter()
        .map(|effect| {
            let state = motion::effects::state(world, effect);
            ReceiptLine {
                effect: Some(effect),
                because: (state != EffectState::NotDeclared).then(|| because(scene, effect)),
                bodies: effect.bodies(world),
                bytes: effect.bytes(world),
                ..ReceiptLine::of(effect.name(), state)
            }
        })
        .collect();
    let implicit = bodies_of(world, method, Method::ImplicitEuler);
    let steps = values::<LastStep>(world).count();
    let kept = values::<LastAcceleration>(world).count();
    let methods = [
        (IMPLICIT_SOLVER, implicit, 0, "method: implicit_euler"),
        ("verlet_state", steps, column_bytes::<LastStep>(world), "method: position_verlet"),
        (
            "kept_accelerations",
            kept,
            column_bytes::<LastAcceleration>(world),
            "method: velocity_verlet or yoshida_4",
        ),
    ];
    rows.extend(methods.map(|(name, bodies, bytes, why)| {
        let state = if bodies > 0 { EffectState::On } else { EffectState::NotDeclared };
        let because = (bodies > 0).then(|| why.to_owned());
        ReceiptLine { because, bodies, bytes, ..ReceiptLine::of(name, state) }
    }));
    rows
}

/// The first key of the scene file that declares an effect, with its line if that is known.
fn because(scene: &Scene, effect: Effect) -> String {
    let declared = scene.declared.iter().find(|declared| declared.effect == effect);
    match declared {
        Some(Declaration { path, line: Some(line), .. }) => format!("{path}, line {line}"),
        Some(Declaration { path, line: None, .. }) => path.clone(),
        None => "declared since".to_owned(),
    }
}

/// Bodies that a step integrates.
type Integrated = (Without<Quarantined>, Without<Static>, Without<Dormant>);

/// Number of movable bodies that `sought` integrates.
fn bodies_of(world: &World, scene: Method, sought: Method) -> usize {
    let moves = |body: &PhysicsBody| body.inverse_mass > 0.0;
    let uses = |(body, state, has_own): &(EntityRef, &PhysicsBody, bool)| {
        let own = if *has_own { own_method(*body) } else { None };
        moves(state) && own.unwrap_or(scene) == sought
    };
    let mut bodies = world
        .try_query_filtered::<(EntityRef, &PhysicsBody, Has<OwnMethod>), Integrated>()
        .expect("a stepper registers them");
    bodies.iter(world).filter(uses).count()
}
