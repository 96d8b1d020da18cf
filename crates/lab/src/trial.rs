//! Trials: a simulation run ahead by its own method and schedule, beside far finer runs of the same scene.
//!
//! The finer runs are two, one with twice the substeps of the other. Where they agree they are the truth. Each body is compared with
//! the largest speed, and with the largest distance from what [holds it](history::bonds), that the truth has had by a third later,
//! so that a motion may be early or late, but not of another size.

mod judge;
mod piece;
mod search;
mod truth;

use std::collections::BTreeSet;
use std::sync::Arc;

use history::{Simulation, Snapshot};
use motion::Method;
use motion::margin::Cure;
use scene::{Scene, Substepping};

use self::piece::Piece;

/// How many times the truth's largest value a value may be: above that a body is thrown out.
const THROWN: f64 = 3.0;

/// How far a trial looks ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead {
    /// Time, s. `None` for a hundred turns of the slowest bond, and at least 10 s and 600 ticks.
    pub seconds: Option<f64>,
    /// Most work, in [units](Trial::advance).
    pub work: f64,
    /// Whether verdicts alone are wanted: no cures.
    pub verdicts_alone: bool,
}

impl Ahead {
    /// The work of a forecast at the start of a run: some tenths of a second.
    pub const DEFAULT: Self = Self { seconds: None, work: 4e6, verdicts_alone: false };
}

/// The time, s, after which the first body of `simulation` is thrown out within `seconds`, if one is.
pub(crate) fn thrown_after(simulation: &Simulation, seconds: f64) -> Option<f64> {
    let ahead = Ahead { seconds: Some(seconds), verdicts_alone: true, ..Ahead::DEFAULT };
    let mut trial = Trial::new(simulation, ahead);
    trial.finish();
    let thrown = |tried: Tried| match tried.verdict {
        Verdict::Thrown(after, excess) if excess.is_gain() => Some(after),
        Verdict::Holds | Verdict::Thrown(..) | Verdict::Wrong(_) | Verdict::NotTried => None,
    };
    trial.found().into_iter().filter_map(thrown).reduce(f64::min)
}

/// By what a body is thrown out, each as a multiple of the largest value of the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Excess {
    /// Its speed.
    Speed(f64),
    /// Its distance from what holds it.
    Distance(f64),
    /// The energy that the part gained beyond the truth, over the kinetic energy of the truth; below 0 if it lost energy.
    Energy(f64),
    /// The body is quarantined.
    Quarantined,
}

impl Excess {
    /// Whether it is too much, and not a loss of energy.
    #[must_use]
    pub const fn is_gain(self) -> bool {
        !matches!(self, Self::Energy(by) if by < 0.0)
    }

    /// The multiple.
    #[must_use]
    pub const fn times(self) -> f64 {
        match self {
            Self::Speed(times) | Self::Distance(times) => times,
            Self::Energy(times) => 1.0 + times.abs(),
            Self::Quarantined => f64::INFINITY,
        }
    }
}

/// Where a body settles that the truth does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Settled {
    /// At a velocity: its least and largest multiple of the true one.
    Velocity([f64; 2]),
    /// At a distance from what holds it: its least and largest multiple of the true one.
    Distance([f64; 2]),
    /// It swings this many times too far or too fast, without growing any more.
    Swings(f64),
    /// It does not come to rest: its largest speed as a multiple of the largest true speed.
    Moving(f64),
}

/// The result of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// No body deviates in size from the truth.
    Holds,
    /// A body is thrown out after this time, s.
    Thrown(f64, Excess),
    /// A body settles elsewhere.
    Wrong(Settled),
    /// The part was not tried, because no truth for even a few ticks fits into the work.
    NotTried,
}

impl Verdict {
    /// Whether it is a fault.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        matches!(self, Self::Thrown(..) | Self::Wrong(_))
    }
}

/// The trial of a part of a scene whose bodies have the same method and substeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Name of the part.
    pub part: String,
    /// Stable ids of its bodies, ascending.
    pub ids: Arc<[u32]>,
    /// Number of movable bodies that were tried.
    pub bodies: usize,
    /// Number of movable bodies that they stand for.
    pub of: usize,
    /// Their method.
    pub method: Method,
    /// Their substeps.
    pub substeps: Substepping,
    /// The result.
    pub verdict: Verdict,
    /// Stable id of the body of the verdict.
    pub body: Option<u32>,
    /// Stable id of the body that holds it.
    pub holder: Option<u32>,
    /// How far the trial has looked, s. Where it [holds](Verdict::Holds): how long no body was beyond what the truth had by then, as
    /// far as that can be predicted.
    pub seconds: f64,
    /// The time from which on the truth cannot be predicted, s: two runs that are far finer than the scene part there. From then on only
    /// energy and sizes are compared.
    pub predictable_s: Option<f64>,
    /// The changes that would remove the fault, each tried over the same time.
    pub cure: Cure,
    /// Whether the search for cures came to its end, and not to that of its work.
    pub is_searched: bool,
    /// Whether the trial has ended.
    pub is_done: bool,
}

impl Tried {
    /// Nothing was found of a part yet, of which that many bodies are tried.
    fn new(
        part: String,
        ids: &[u32],
        bodies: usize,
        Waiting { setting: (method, substeps), of, .. }: &Waiting,
    ) -> Self {
        Self {
            part,
            ids: Arc::from(ids),
            bodies,
            of: *of,
            method: *method,
            substeps: *substeps,
            verdict: Verdict::NotTried,
            body: None,
            holder: None,
            seconds: 0.0,
            predictable_s: None,
            cure: Cure::default(),
            is_searched: false,
            is_done: true,
        }
    }
}

/// Most bodies of a part that is tried without being asked to.
const MOST_BODIES: usize = 5_000;

/// Most single bodies of a class that are tried.
const MOST_SINGLE: usize = 256;

/// The trial of a simulation, which continues from call to call.
pub struct Trial {
    scene: Arc<Scene>,
    start: Snapshot,
    /// The parts that are left, in reverse.
    waiting: Vec<Waiting>,
    pieces: Vec<Piece>,
    /// The parts that are too large to be tried.
    untried: Vec<Tried>,
    ahead: Ahead,
    /// The work that is left for the truth.
    left: f64,
    count: usize,
}

impl Trial {
    /// A trial of `simulation` from its present state, without the inputs that wait for the next tick.
    #[must_use]
    pub fn new(simulation: &Simulation, ahead: Ahead) -> Self {
        let scene = Arc::clone(&simulation.scene);
        let has_laws = piece::has_laws(&scene);
        let start = if has_laws { simulation.snapshot() } else { Snapshot::default() };
        let mut waiting = if has_laws { parts(&scene, &start) } else { Vec::new() };
        waiting.reverse();
        let count = waiting.len();
        let is_large = |part: &mut Waiting| part.ids.len() > MOST_BODIES && ahead.seconds.is_none();
        let large: Vec<_> = waiting.extract_if(.., is_large).collect();
        let name = |ids: &[u32]| ids.first().and_then(|id| scene.names.get(*id));
        let tried = |part: &Waiting| {
            let first = name(&part.ids).unwrap_or_default();
            let name = format!("{first} and {} more", part.ids.len() - 1);
            Tried::new(name, &part.ids, part.of, part)
        };
        let untried = large.iter().map(tried).collect();
        let pieces = Vec::new();
        Self { scene, start, waiting, pieces, untried, ahead, left: ahead.work, count }
    }

    /// Continues for about `work` units, each about the time that one body takes for one evaluation. Returns whether the
    /// trial has ended.
    pub fn advance(&mut self, mut work: f64) -> bool {
        loop {
            if let Some(piece) = self.pieces.last_mut().filter(|piece| !piece.is_done()) {
                if work <= 0.0 {
                    return false;
                }
                let before = piece.truth_work();
                work -= piece.advance(work);
                self.left -= piece.truth_work() - before;
                continue;
            }
            let share = self.left / self.waiting.len().max(1) as f64;
            let Some(waiting) = self.waiting.pop() else { return true };
            let ahead = Ahead { work: share, ..self.ahead };
            if let Some(piece) = Piece::new(&self.scene, &self.start, waiting, ahead) {
                work -= if piece.is_done() { 0.0 } else { piece.work_of_world() };
                self.pieces.push(piece);
            }
        }
    }

    /// Runs the trial to its end.
    pub fn finish(&mut self) {
        while !self.advance(f64::INFINITY) {}
    }

    /// Share of the trial that is done, 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f64 {
        let here = self.pieces.last().map_or(0.0, |piece| 1.0 - piece.progress());
        1.0 - (self.waiting.len() as f64 + here) / self.count.max(1) as f64
    }

    /// What was found so far, the worst first.
    #[must_use]
    pub fn found(&self) -> Vec<Tried> {
        let pieces = self.pieces.iter().map(Piece::tried);
        let mut found: Vec<_> = pieces.chain(&self.untried).cloned().collect();
        let rank = |tried: &Tried| match tried.verdict {
            Verdict::Thrown(after, _) => (0, after),
            Verdict::Wrong(_) => (1, 0.0),
            Verdict::NotTried => (2, 0.0),
            Verdict::Holds => (3, 0.0),
        };
        found.sort_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal));
        found
    }
}

/// A part that is to be tried.
struct Waiting {
    /// Stable ids of its bodies, ascending.
    ids: Vec<u32>,
    /// Method and substeps of its movable bodies.
    setting: (Method, Substepping),
    /// Number of movable bodies that it stands for.
    of: usize,
}

/// The parts of `scene`; single bodies by their method and substeps.
fn parts(scene: &Scene, snapshot: &Snapshot) -> Vec<Waiting> {
    let (joined, free) = scene.joined();
    let is_movable = |id: &u32| scene.bodies[*id as usize].is_movable();
    let mut settings: Vec<Option<(Method, Substepping)>> = vec![None; scene.bodies.len()];
    for (id, method, substeps) in snapshot.settings().filter(|(id, ..)| is_movable(id)) {
        settings[id as usize] = Some((method, substeps));
    }
    let setting = |id: &u32| settings[*id as usize];
    let mut found = Vec::new();
    for ids in joined {
        let Some(setting) = ids.iter().find_map(setting) else { continue };
        let of = ids.iter().filter(|id| is_movable(id)).count();
        found.push(Waiting { ids: sampled(scene, snapshot, ids), setting, of });
    }
    let mut classes: Vec<((Method, Substepping), Vec<u32>)> = Vec::new();
    for id in free {
        let Some(setting) = setting(&id) else { continue };
        match classes.iter_mut().find(|(known, _)| *known == setting) {
            Some((_, bodies)) => bodies.push(id),
            None => classes.push((setting, vec![id])),
        }
    }
    found.extend(classes.into_iter().map(|(setting, ids)| {
        let of = ids.len();
        Waiting { ids: extremes(scene, snapshot, ids), setting, of }
    }));
    found
}

/// The bodies of a part that carry wells or emitters, and up to [`MOST_SINGLE`] others, if these do not act on each other; else all.
fn sampled(scene: &Scene, snapshot: &Snapshot, ids: Vec<u32>) -> Vec<u32> {
    let has = |id: u32| ids.binary_search(&id).is_ok();
    let acts = scene.mutual_gravity.is_some()
        || scene.springs.iter().any(|spring| has(spring.ends[0]))
        || scene.soft_bodies.iter().any(|soft| has(soft.points.start));
    if acts || ids.len() <= MOST_SINGLE {
        return ids;
    }
    let emitters = scene.emitters.iter().filter_map(|emitter| emitter.rides_on);
    let wells = scene.own_laws.values().flat_map(|laws| &laws.riding_wells);
    let all: BTreeSet<_> = emitters.chain(wells.map(|well| well.rides_on)).collect();
    let (mut carriers, others): (Vec<_>, Vec<_>) = ids.into_iter().partition(|id| all.contains(id));
    carriers.extend(extremes(scene, snapshot, others));
    carriers.sort_unstable();
    carriers
}

/// Up to [`MOST_SINGLE`] of `bodies`, ascending: the fastest, the lightest, the heaviest, the most damped, the nearest to wells, and the
/// first.
fn extremes(scene: &Scene, snapshot: &Snapshot, bodies: Vec<u32>) -> Vec<u32> {
    if bodies.len() <= MOST_SINGLE {
        return bodies;
    }
    let wells = scene.laws.wells.iter().flat_map(|wells| &wells.0).take(MOST_SINGLE / 16);
    let wells: Vec<_> = wells.map(|well| well.position).collect();
    let each = MOST_SINGLE / (5 + wells.len());
    let mut least: Vec<Vec<(f64, u32)>> = vec![Vec::new(); 5 + wells.len()];
    for (id, x, v, w) in snapshot.states().filter(|(id, ..)| bodies.binary_search(id).is_ok()) {
        let damping = scene.bodies[id as usize].damping_rate.unwrap_or(0.0);
        let own = [-v.length_squared(), w, -w, -damping, f64::from(id)];
        let keys = own.into_iter().chain(wells.iter().map(|well| well.distance_squared(x)));
        for (list, key) in least.iter_mut().zip(keys) {
            let place = list.partition_point(|known| *known <= (key, id));
            if place < each {
                list.insert(place, (key, id));
                list.truncate(each);
            }
        }
    }
    let kept: BTreeSet<_> = least.into_iter().flatten().map(|(_, id)| id).collect();
    kept.into_iter().collect()
}
