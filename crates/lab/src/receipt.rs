//! The receipt of a scene: each effect, whether it acts and why, on how many bodies, and what it costs in time and
//! memory.

use bevy_ecs::prelude::*;
use history::Simulation;
use motion::effects::{Effect, EffectState, column_bytes};
use motion::internals::values;
use motion::snapshot::{LastAcceleration, LastStep};
use motion::{Dormant, Method, OwnMethod, PhysicsBody, Quarantined, Static, own_method};
use scene::{Declaration, Scene};

use crate::clock::thread_time;
use crate::run::{ByEffect, StepTimes, started};

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
    let mut run = ReceiptRun::new(scene, ticks, without);
    run.work(f64::INFINITY);
    run.receipt()
}

/// A receipt that is being measured, in slices.
pub struct ReceiptRun {
    scene: Scene,
    without: Vec<Effect>,
    ticks: u64,
    /// Counts evaluations, for that many more ticks.
    counted: Simulation,
    left: u64,
    /// What is timed once that is done.
    timed: Option<Timed>,
}

struct Timed {
    rows: Vec<ReceiptLine>,
    /// The effects that act, in the order of the times after the first one.
    acting: Vec<Effect>,
    times: StepTimes,
}

impl ReceiptRun {
    /// Begins a receipt: see [`receipt`].
    pub fn new(scene: &Scene, ticks: u64, without: &[Effect]) -> Self {
        let (scene, without, ticks) = (scene.clone(), without.to_vec(), ticks.max(1));
        let counted = started(scene.clone(), &without);
        Self { scene, without, ticks, counted, left: ticks, timed: None }
    }

    /// Measures until `seconds` of the thread's time have passed, and at least a tick or a block. Returns whether all is measured.
    pub fn work(&mut self, seconds: f64) -> bool {
        let start = thread_time();
        loop {
            if self.left > 0 {
                self.counted.tick();
                self.left -= 1;
            } else if self.timed().times.time_block() {
                return true;
            }
            if thread_time() - start > seconds {
                return false;
            }
        }
    }

    fn timed(&mut self) -> &mut Timed {
        let Self { scene, without, ticks, counted, timed, .. } = self;
        timed.get_or_insert_with(|| {
            let rows = receipt_without_running(counted);
            let acting = rows.iter().filter(|row| row.state == EffectState::On);
            let acting: Vec<_> = acting.filter_map(|row| row.effect).collect();
            let one_less = |effect: &Effect| without.iter().copied().chain([*effect]).collect();
            let all = [without.clone()].into_iter().chain(acting.iter().map(one_less)).collect();
            Timed { rows, acting, times: StepTimes::new(scene, all, *ticks) }
        })
    }

    /// What was measured.
    pub fn receipt(mut self) -> Receipt {
        self.timed();
        let Self { counted, ticks, timed, .. } = self;
        let (mut rows, acting, times) =
            timed.map(|timed| (timed.rows, timed.acting, timed.times.ns())).unwrap_or_default();
        let evaluations = counted.evaluations();
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
        let scene = &counted.scene;
        Receipt { scene: scene.name.clone(), method: scene.method, ticks, ns, rows }
    }
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
