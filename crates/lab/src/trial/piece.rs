//! The trial of one part: its truth, its run, and its cures.

use history::{Bond, Holder, Simulation, Snapshot, Twin, bonds};
use motion::MutualGravity;
use motion::margin::{Margin, Margins};
use scene::{OwnLawsSpec, Part, Scene};

use super::judge::{Run, judged, lead};
use super::search::Search;
use super::truth::{Cast, Truth};
use super::{Ahead, Excess, Settled, Tried, Verdict, Waiting};
use crate::run::{decade, movable, size};

/// Turns of the slowest bond that a trial looks ahead.
const TURNS: f64 = 100.0;

/// Least time, s, and ticks that it looks ahead, if the work allows.
const SECONDS: f64 = 10.0;
const TICKS: f64 = 600.0;

/// Fewer ticks are no trial.
const LEAST_TICKS: u64 = 4;

/// `w h` of the steps of the coarser of the finer runs: as the work allows.
const FINE: [f64; 2] = [0.15, 0.7];

/// `w h` of their samples.
const SAMPLED: f64 = 0.5;

/// Most steps of the finer runs per tick.
const MOST_STEPS: f64 = 65_536.0;

/// Most work for cures, over that of the truth.
const CURES: f64 = 2.0;

/// How many times finer the truth becomes where its runs part, and how often.
const FINER: u32 = 4;
const ATTEMPTS: u32 = 3;

/// Error of a tick for which substeps are chosen as a cure: so many decades below the size of the part.
const CHOSEN: i32 = 4;

/// Work of a tick beside that of its evaluations.
const WORK_OF_TICK: f64 = 300.0;

/// Work of making a body of a world.
const WORK_OF_BODY: f64 = 300.0;

/// Factor for frequencies that add up.
const UNCERTAIN: f64 = 1.2;

/// Part of the run, at its end, in which bodies count as settled.
const WINDOW: f64 = 0.25;

/// The trial of a part.
pub(super) struct Piece {
    part: Part,
    carries: bool,
    /// Ticks of the truth.
    horizon: u64,
    /// Ticks of the run.
    end: u64,
    /// The tick after which bodies count as settled.
    from: u64,
    /// Steps of the truth per tick, and samples.
    steps: u32,
    samples: u32,
    /// How often the truth was made finer, and when it parted before.
    attempt: u32,
    parted_before: u64,
    /// Work of a step of all bodies by the reference.
    work_of_step: f64,
    /// Work for the truth: what is left, and what was done.
    left: f64,
    truth_work: f64,
    /// Work for cures so far.
    cure_work: f64,
    verdict_alone: bool,
    cast: Cast,
    phase: Phase,
    tried: Tried,
}

/// The part at its start, which is never simulated.
struct Start {
    base: Simulation,
    snapshot: Snapshot,
}

/// The next work of a trial.
enum Phase {
    /// Choose the steps and the horizon.
    Choose(Start, Ahead),
    /// Make the finer runs, one at a time, then the run.
    Make(Start, Vec<Simulation>),
    Run(Box<Runs>),
    Done,
}

/// The worlds of a trial.
struct Runs {
    start: Start,
    truth: Truth,
    run: Run,
    search: Option<Search>,
}

/// Whether a scene has anything but gravity and engines, for which no step is too long.
pub(super) fn has_laws(part: &Scene) -> bool {
    let has_own = |laws: &OwnLawsSpec| {
        laws.drag.is_some() || !laws.wells.is_empty() || !laws.riding_wells.is_empty()
    };
    part.damping.is_some()
        || part.laws.drag.is_some()
        || part.laws.wells.is_some()
        || part.mutual_gravity.is_some()
        || !part.springs.is_empty()
        || !part.soft_bodies.is_empty()
        || part.own_laws.values().any(has_own)
}

/// Whether the energy of a part stays: nothing damps or drives it.
fn conserves(part: &Scene) -> bool {
    let has_own = |laws: &OwnLawsSpec| {
        laws.drag.is_some() || !laws.riding_wells.is_empty() || !laws.thrusts.is_empty()
    };
    part.damping.is_none()
        && part.laws.drag.is_none()
        && part.emitters.is_empty()
        && part.motions.is_empty()
        && part.all_springs().all(|(_, elastic)| elastic.damping == 0.0)
        && part.bodies.iter().all(|body| body.max_speed.is_none())
        && !part.own_laws.values().any(has_own)
}

/// Work of a step of all bodies of a part by the reference.
fn work_of_step(part: &Scene) -> f64 {
    let bodies = part.bodies.len() as f64;
    let springs = part.all_springs().count() as f64;
    let pairs = if part.mutual_gravity.is_some() { bodies * bodies / 16.0 } else { 0.0 };
    4.0 * (bodies + 0.5 * springs + pairs)
}

impl Piece {
    /// The trial of a part of `scene` from `snapshot`; `None` if nothing in it limits a step.
    pub fn new(
        scene: &Scene,
        snapshot: &Snapshot,
        mut waiting: Waiting,
        ahead: Ahead,
    ) -> Option<Self> {
        let part = scene.part_of(std::mem::take(&mut waiting.ids));
        if !has_laws(&part.scene) {
            return None;
        }
        let ids: Vec<u32> = movable(&part.scene).map(|(id, _)| id).collect();
        let tried = Tried::new(part.name.clone(), &part.bodies, ids.len(), &waiting);
        let cast = Cast {
            is_bound: vec![false; ids.len()],
            ids,
            bonds: Vec::new(),
            bound: Vec::new(),
            joined: part.name != scene::FREE_BODIES,
            conserves: conserves(&part.scene),
            held: false,
            tick: snapshot.tick_seconds(),
        };
        let mut piece = Self {
            carries: part.scene.own_laws.values().any(|laws| !laws.riding_wells.is_empty()),
            horizon: 0,
            end: 0,
            from: 0,
            steps: 1,
            samples: 1,
            attempt: 0,
            parted_before: 0,
            left: if ahead.seconds.is_some() { f64::INFINITY } else { ahead.work },
            work_of_step: work_of_step(&part.scene),
            truth_work: 0.0,
            cure_work: 0.0,
            verdict_alone: ahead.verdicts_alone,
            phase: Phase::Done,
            tried,
            cast,
            part,
        };
        // Not even the worlds are made where a few ticks are too much.
        if piece.left >= piece.work_of_tick() * LEAST_TICKS as f64 {
            let snapshot = snapshot.of_part(scene, &piece.part);
            let base = Simulation::restore(piece.part.scene.clone(), &snapshot).ok()?;
            piece.phase = Phase::Choose(Start { base, snapshot }, ahead);
            (piece.tried.verdict, piece.tried.is_done) = (Verdict::Holds, false);
        }
        Some(piece)
    }

    /// Chooses steps and horizon.
    fn choose(&mut self, base: &Simulation, ahead: Ahead) {
        let cast = &mut self.cast;
        cast.bonds = bonds(base);
        let number = |bond: &Bond| cast.ids.binary_search(&bond.body).unwrap_or_default();
        cast.bound = cast.bonds.iter().map(number).collect();
        cast.bound.iter().for_each(|body| cast.is_bound[*body] = true);
        cast.held = cast.bonds.iter().all(|bond| bond.is_spring)
            && cast.is_bound.iter().all(|bound| *bound);
        let method = base.method();
        let margins = Margins::of(&base.world, method);
        let largest = |rates: &mut dyn Iterator<Item = f64>| {
            rates.filter(|rate| rate.is_finite()).fold(0.0, f64::max)
        };
        let tick = cast.tick;
        let rates = margins.list().iter().map(|margin| margin.rate(tick));
        let stiffness = UNCERTAIN * tick * largest(&mut { rates });
        let closest = UNCERTAIN * tick * largest(&mut cast.bonds.iter().map(|bond| bond.fastest));
        let slowest = largest(&mut cast.bonds.iter().map(|bond| bond.turn_s));
        let steps = |number: f64| number.ceil().clamp(1.0, MOST_STEPS) as u32;
        let [fine, coarse] = FINE;
        let (most, least) = (steps(stiffness.max(closest) / fine), steps(stiffness / coarse));
        let seconds = ahead.seconds.unwrap_or((TURNS * slowest).max(SECONDS).max(TICKS * tick));
        // A time that was computed from a number of ticks is that number.
        let ticks = (seconds / tick - 1e-6).ceil().clamp(1.0, 1e12);
        self.horizon = lead(ticks as u64);
        let wanted = self.horizon as f64;
        self.samples = steps(stiffness / SAMPLED).min(least);
        self.steps = most;
        let affordable = ahead.work * f64::from(most) / (self.work_of_tick() * wanted);
        self.steps = (affordable.min(f64::from(most)) as u32).max(least);
        self.limit();
    }

    /// The work of the truth so far.
    pub const fn truth_work(&self) -> f64 {
        self.truth_work
    }

    /// Work of a tick of the truth.
    fn work_of_tick(&self) -> f64 {
        let steps = f64::from(self.steps);
        let ticks = if self.carries { 3.0 * steps } else { 2.0 * f64::from(self.samples) };
        3.0 * steps * self.work_of_step + ticks * (WORK_OF_TICK + 2.0 * self.cast.ids.len() as f64)
    }

    /// Limits the trial to as many ticks as the work allows.
    fn limit(&mut self) {
        let affordable = (self.left / self.work_of_tick()).min(1e12) as u64;
        self.horizon = self.horizon.min(affordable);
        self.end = judged(self.horizon);
        self.from = ((1.0 - WINDOW) * self.end as f64) as u64;
        self.tried.verdict = if self.end == 0 { Verdict::NotTried } else { Verdict::Holds };
        (self.tried.body, self.tried.holder) = (None, None);
    }

    /// Makes the next world of the trial.
    fn make(&self, start: Start, mut finer: Vec<Simulation>) -> Phase {
        if self.end == 0 {
            return Phase::Done;
        }
        let ticks = |times| if self.carries { self.steps * times } else { self.samples };
        let times = [1, 2];
        if let Some(times) = times.get(finer.len()) {
            let substeps = (self.steps * times).div_ceil(ticks(*times));
            let twin = Twin::finer(&start.base, ticks(*times), substeps.into());
            finer.push(twin.into_simulation());
            return Phase::Make(start, finer);
        }
        let Ok(finer) = finer.try_into() else { return Phase::Done };
        let run = Simulation::restore(self.part.scene.clone(), &start.snapshot)
            .expect("it was restored from there before");
        let truth = Truth::new(finer, &self.cast, times.map(ticks), self.from);
        Phase::Run(Box::new(Runs { start, truth, run: Run::new(run, &self.cast), search: None }))
    }

    pub const fn is_done(&self) -> bool {
        self.tried.is_done
    }

    pub const fn tried(&self) -> &Tried {
        &self.tried
    }

    pub fn progress(&self) -> f64 {
        let ticks = match &self.phase {
            Phase::Choose(..) | Phase::Make(..) => 0,
            Phase::Run(runs) => runs.truth.ticks,
            Phase::Done => self.horizon,
        };
        ticks as f64 / self.horizon.max(1) as f64
    }

    /// Work of making a world.
    pub fn work_of_world(&self) -> f64 {
        WORK_OF_BODY * self.part.bodies.len() as f64
    }

    /// Continues for about `work`. Returns the work done.
    pub fn advance(&mut self, work: f64) -> f64 {
        let mut done = 0.0;
        while done < work && !self.tried.is_done {
            let (next, did) = match std::mem::replace(&mut self.phase, Phase::Done) {
                Phase::Choose(start, ahead) => {
                    self.choose(&start.base, ahead);
                    (Phase::Make(start, Vec::new()), self.work_of_world())
                }
                Phase::Make(start, finer) => (self.make(start, finer), self.work_of_world()),
                Phase::Run(runs) => self.run(runs),
                Phase::Done => (Phase::Done, 0.0),
            };
            done += did;
            self.tried.is_done = matches!(next, Phase::Done);
            self.phase = next;
        }
        done
    }

    /// Continues the runs by a tick. Returns what is next, and the work done.
    fn run(&mut self, mut runs: Box<Runs>) -> (Phase, f64) {
        let is_cure = runs.search.is_some();
        let work = if is_cure { self.try_cure(&mut runs) } else { self.tick(&mut runs) };
        let next = if self.is_to_be_finer(&runs.truth) {
            self.attempt += 1;
            self.parted_before = runs.truth.ticks;
            self.steps *= FINER;
            self.limit();
            Phase::Make(runs.start, Vec::new())
        } else if self.tried.is_done {
            Phase::Done
        } else {
            Phase::Run(runs)
        };
        (next, work)
    }

    /// A tick of the truth, and the ticks of the run that it can judge. Returns the work done.
    fn tick(&mut self, runs: &mut Runs) -> f64 {
        let Runs { truth, run, search, .. } = runs;
        truth.tick(&self.cast);
        let work = self.work_of_tick();
        self.left -= work;
        self.truth_work += work;
        if self.is_to_be_finer(truth) {
            return work;
        }
        if let Some(unresolved) = truth.unresolved_from {
            self.horizon = unresolved;
            // Energy that stays can be judged without a truth.
            if !self.cast.conserves || self.cast.held {
                self.end = self.end.min(judged(unresolved.saturating_sub(1)));
            }
        }
        let settling = truth.ticks >= self.horizon;
        if settling {
            truth.close();
        }
        let tick = self.cast.tick;
        let seconds = |ticks: u64| ticks as f64 * tick;
        // The last part of the run is compared with that of the truth, which is complete at the end.
        let end = if settling { self.end } else { self.end.min(self.from) };
        while run.ticks < end
            && (settling || lead(run.ticks + 1) <= truth.recorded())
            && !run.is_over()
        {
            let is_late = 2 * run.ticks >= self.end;
            let thrown = run.tick(&self.cast, truth, run.ticks >= self.from, is_late);
            self.tried.seconds = seconds(run.ticks);
            if let Some((body, bond, excess)) = thrown
                && self.is_worse(excess)
            {
                self.note(body, bond, Verdict::Thrown(seconds(run.ticks), excess));
            }
        }
        let parted = truth.parted_from.filter(|parted| *parted <= self.end);
        self.tried.predictable_s = parted.map(seconds);
        if settling {
            match self.tried.verdict {
                Verdict::Thrown(_, excess) if excess.is_gain() => {
                    if let Some(times) = run.swing(&self.cast) {
                        self.tried.verdict = Verdict::Wrong(Settled::Swings(times));
                    }
                }
                Verdict::Thrown(..) => {}
                Verdict::Holds | Verdict::Wrong(_) | Verdict::NotTried => {
                    if let Some((body, bond, settled)) = run.settled(&self.cast, truth) {
                        self.note(body, bond, Verdict::Wrong(settled));
                    }
                }
            }
            let is_fault = self.tried.verdict.is_fault();
            let end = if is_fault { self.end } else { run.held };
            self.tried.seconds = seconds(end);
            if is_fault && !self.verdict_alone {
                *search = Some(Search::new(
                    self.tried.method,
                    self.tried.substeps,
                    decade(size(&self.part.scene, self.tried.seconds) - CHOSEN),
                ));
            } else {
                self.tried.is_done = true;
                if (self.end < LEAST_TICKS || end == 0) && !is_fault {
                    self.tried.verdict = Verdict::NotTried;
                }
            }
        }
        work
    }

    /// Whether an excess is the first fault or, where verdicts alone are wanted, a gain after a loss.
    const fn is_worse(&self, excess: Excess) -> bool {
        match self.tried.verdict {
            Verdict::Thrown(_, before) => {
                self.verdict_alone && excess.is_gain() && !before.is_gain()
            }
            verdict @ (Verdict::Holds | Verdict::Wrong(_) | Verdict::NotTried) => {
                !verdict.is_fault()
            }
        }
    }

    fn note(&mut self, body: Option<usize>, bond: Option<usize>, verdict: Verdict) {
        let name = |own: u32| self.part.bodies.get(own as usize).copied();
        self.tried.verdict = verdict;
        self.tried.body = body.and_then(|body| name(self.cast.ids[body]));
        self.tried.holder = bond.and_then(|bond| match self.cast.bonds[bond].holder {
            Holder::Body(id) => name(id),
            Holder::Well(_) => None,
        });
    }

    /// Whether the finer runs part in the present tick, and still finer ones may agree for longer.
    fn is_to_be_finer(&self, truth: &Truth) -> bool {
        let parted = truth.parted_from.unwrap_or(0);
        let is_better = self.attempt == 0 || parted as f64 > 1.5 * self.parted_before as f64;
        let finer = self.work_of_tick() * f64::from(FINER);
        truth.ticks == parted
            && self.attempt < ATTEMPTS
            && is_better
            && self.left / finer >= 1.5 * parted as f64
    }

    /// Continues the search for cures by a tick of the setting that is tried. Returns the work done.
    fn try_cure(&mut self, runs: &mut Runs) -> f64 {
        let Runs { start: Start { base, .. }, truth, search, .. } = runs;
        let Some(search) = search else { return 0.0 };
        self.cure_work += WORK_OF_TICK;
        if self.cure_work > CURES * self.truth_work {
            search.give_up();
        }
        let steps = search.steps();
        let Some(run) = &mut search.run else {
            let attracts = base.world.contains_resource::<MutualGravity>();
            let mut made = 0;
            match search.next(self.steps.saturating_mul(8), attracts) {
                None => {
                    (self.tried.cure, self.tried.is_searched) = search.result();
                    self.tried.is_done = true;
                }
                Some((method, substeps)) => {
                    made = self.part.bodies.len();
                    let run = Twin::new(base, method, Some(substeps)).into_simulation();
                    let margins = Margins::of(&run.world, method);
                    if margins.list().iter().any(Margin::is_reported) {
                        search.answer(false);
                    } else {
                        search.run = Some(Run::new(run, &self.cast));
                    }
                }
            }
            return WORK_OF_TICK + WORK_OF_BODY * made as f64;
        };
        let work = steps * self.work_of_step;
        let is_thrown = run.tick(&self.cast, truth, run.ticks >= self.from, false).is_some();
        if is_thrown || run.ticks >= self.end {
            let ends = [truth.parted_from, truth.unresolved_from].into_iter().flatten();
            let known = ends.map(|tick| tick.saturating_sub(1)).fold(self.end, u64::min);
            let holds = !is_thrown && run.settled(&self.cast, truth).is_none() && run.held >= known;
            search.answer(holds);
        }
        self.cure_work += work;
        WORK_OF_TICK + work
    }
}
