//! The truth of a trial: two far finer runs, and the largest values that they have had.

use history::{Bond, Simulation};
use motion::units::Vector;
use motion::{PhysicsBody, Quarantined, Transform, totals};

/// A body after a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Body {
    Present(Vector, Vector),
    /// Not born, or removed.
    Away,
    Quarantined,
}

/// The state of a run after a tick.
pub(super) struct Look {
    pub bodies: Vec<Body>,
    /// Position relative to the holder, by bond.
    pub arms: Vec<Option<Vector>>,
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Kinetic and potential energy, J; NaN if it was not computed.
    pub energy: f64,
}

impl Look {
    /// The state of a run with its energy, which takes about as long as an evaluation.
    pub fn at(simulation: &Simulation, cast: &Cast) -> Self {
        let sums = totals(&simulation.world);
        Self {
            energy: sums.kinetic_energy + sums.potential_energy,
            ..Self::within(simulation, cast)
        }
    }

    /// The state of a run without its energy.
    fn within(simulation: &Simulation, cast: &Cast) -> Self {
        let mut kinetic = 0.0;
        let mut body = |id: &u32| {
            let Some(body) = simulation.present(*id) else {
                let there = simulation.body(*id).map(|body| simulation.world.entity(body));
                let is_quarantined = there.is_some_and(|body| body.contains::<Quarantined>());
                return if is_quarantined { Body::Quarantined } else { Body::Away };
            };
            let (Some(at), Some(state)) = (body.get::<Transform>(), body.get::<PhysicsBody>())
            else {
                return Body::Away;
            };
            kinetic += state.kinetic_energy();
            Body::Present(at.position, state.velocity)
        };
        Self {
            bodies: cast.ids.iter().map(&mut body).collect(),
            arms: cast.bonds.iter().map(|bond| bond.arm(simulation)).collect(),
            kinetic,
            energy: f64::NAN,
        }
    }
}

/// The movable bodies of a part, and what is known of them at the start.
pub(super) struct Cast {
    /// Stable ids in the part.
    pub ids: Vec<u32>,
    pub bonds: Vec<Bond>,
    /// Number of the body of each bond.
    pub bound: Vec<usize>,
    /// Whether a bond holds it, by body.
    pub is_bound: Vec<bool>,
    /// Whether they act on each other.
    pub joined: bool,
    /// Whether their energy stays.
    pub conserves: bool,
    /// Whether springs hold each of them, and nothing attracts them.
    pub held: bool,
    /// Length of a tick, s.
    pub tick: f64,
}

/// Part of the largest speed of joined bodies below which a speed is not compared: a wave of a coarse run comes early.
const FAINT: f64 = 0.02;

/// Values of two runs of the same size differ by less than this factor.
const ALIKE: f64 = 2.0;

/// Times the smallest difference of two numbers that counts as rounding.
const ROUNDING: f64 = 1e6 * f64::EPSILON;

/// The largest values of a run so far.
#[derive(Clone, Debug)]
pub(super) struct Most {
    /// Speed by body, m/s.
    pub speeds: Vec<f64>,
    /// The largest of them.
    fastest: f64,
    /// Distance from the origin by body, m.
    sizes: Vec<f64>,
    /// Distance from the holder by bond, m.
    pub arms: Vec<f64>,
    pub kinetic: f64,
    /// Sum of the kinetic energies, J, and their number.
    kinetic_sum: [f64; 2],
    /// Least and largest change of the energy, J.
    pub energy: [f64; 2],
    /// Energy at the start, J.
    start: f64,
    quarantined: Vec<bool>,
}

impl Most {
    pub fn of(look: &Look) -> Self {
        let mut most = Self {
            speeds: vec![0.0; look.bodies.len()],
            fastest: 0.0,
            sizes: vec![0.0; look.bodies.len()],
            arms: vec![0.0; look.arms.len()],
            kinetic: 0.0,
            kinetic_sum: [0.0; 2],
            energy: [0.0; 2],
            start: look.energy,
            quarantined: vec![false; look.bodies.len()],
        };
        most.add(look);
        most
    }

    pub fn add(&mut self, look: &Look) {
        for (i, body) in look.bodies.iter().enumerate() {
            match body {
                Body::Present(x, v) => {
                    self.speeds[i] = self.speeds[i].max(v.length());
                    self.fastest = self.fastest.max(self.speeds[i]);
                    self.sizes[i] = self.sizes[i].max(x.length());
                }
                Body::Quarantined => self.quarantined[i] = true,
                Body::Away => {}
            }
        }
        for (most, arm) in self.arms.iter_mut().zip(&look.arms) {
            *most = most.max(arm.map_or(0.0, Vector::length));
        }
        self.kinetic = self.kinetic.max(look.kinetic);
        self.kinetic_sum = [self.kinetic_sum[0] + look.kinetic, self.kinetic_sum[1] + 1.0];
        let change = look.energy - self.start;
        if change.is_finite() {
            self.energy = [self.energy[0].min(change), self.energy[1].max(change)];
        }
    }

    /// Takes in the values of another run of the same motion, as far as they are of the same size.
    fn join(&mut self, other: &Self) {
        let larger = |own: &mut f64, other: f64| {
            if other <= ALIKE * *own {
                *own = own.max(other);
            }
        };
        let all = |own: &mut [f64], others: &[f64]| {
            own.iter_mut().zip(others).for_each(|(own, other)| larger(own, *other));
        };
        all(&mut self.speeds, &other.speeds);
        self.fastest = self.speeds.iter().copied().fold(0.0, f64::max);
        all(&mut self.sizes, &other.sizes);
        all(&mut self.arms, &other.arms);
        larger(&mut self.kinetic, other.kinetic);
    }

    /// The energy with which changes of the energy are compared, J.
    pub fn energy_scale(&self) -> f64 {
        self.kinetic.max(self.energy[1] - self.energy[0]).max(self.faint_energy())
    }

    pub fn is_quarantined(&self, body: usize) -> bool {
        self.quarantined[body]
    }

    /// The speed of a body below which it is not compared, m/s.
    pub fn faint(&self, body: usize, cast: &Cast) -> f64 {
        let waves = if cast.joined { FAINT * self.fastest } else { 0.0 };
        waves.max(ROUNDING * self.sizes[body] / cast.tick)
    }

    /// The energy that counts as rounding, J.
    fn faint_energy(&self) -> f64 {
        if self.start.is_finite() { 1e-9 * self.start.abs() } else { 0.0 }
    }
}

/// Velocities and distances over the last part of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Window {
    count: f64,
    sums: Vec<Vector>,
    squares: Vec<f64>,
    /// Largest speed, m/s, by body.
    pub speeds: Vec<f64>,
    /// Least and largest distance from the holder, m, by bond.
    pub arms: Vec<[f64; 2]>,
}

impl Window {
    pub fn add(&mut self, look: &Look) {
        self.sums.resize(look.bodies.len(), Vector::ZERO);
        self.squares.resize(look.bodies.len(), 0.0);
        self.speeds.resize(look.bodies.len(), 0.0);
        self.arms.resize(look.arms.len(), [f64::INFINITY, 0.0]);
        self.count += 1.0;
        for (i, body) in look.bodies.iter().enumerate() {
            let v = if let Body::Present(_, v) = body { *v } else { Vector::NAN };
            self.sums[i] += v;
            self.squares[i] += v.length_squared();
            self.speeds[i] = self.speeds[i].max(v.length());
        }
        for ([least, most], arm) in self.arms.iter_mut().zip(&look.arms) {
            let length = arm.map_or(f64::NAN, Vector::length);
            (*least, *most) = (least.min(length), most.max(length));
        }
    }

    /// The mean velocity of a body, if it was there all the time.
    pub fn mean(&self, body: usize) -> Option<Vector> {
        let mean = *self.sums.get(body)? / self.count;
        mean.is_finite().then_some(mean)
    }

    /// The mean velocity of a body, if it is settled at it.
    pub fn settled(&self, body: usize) -> Option<Vector> {
        let mean = self.mean(body)?;
        let variance = self.squares[body] / self.count - mean.length_squared();
        let is_steady = variance <= STEADY * STEADY * mean.length_squared();
        (is_steady && mean != Vector::ZERO).then_some(mean)
    }
}

/// Root of the mean square of the deviation from a velocity at which a body is settled, over the velocity.
const STEADY: f64 = 0.03;

/// Distance of the two finer runs, over the size of the motion, from which on they do not agree.
const PARTED: f64 = 0.1;

/// Part of an energy that counts as kinetic energy where a motion begins at rest.
const BOUND: f64 = 0.1;

/// Difference of their energies, over the mean kinetic energy, from which on neither is the truth.
const UNRESOLVED: f64 = 0.5;

/// Ticks between two records of the largest values, as part of the ticks so far.
const APART: f64 = 0.06;

/// Two far finer runs of a part, and what they have in common.
pub(super) struct Truth {
    coarse: Simulation,
    fine: Simulation,
    /// Ticks of the finer runs per tick of the scene.
    ticks_per_tick: [u32; 2],
    most: [Most; 2],
    /// The largest values after some of the ticks.
    records: Vec<(u64, Most)>,
    pub window: Window,
    window_from: u64,
    pub ticks: u64,
    /// The tick from which on they do not agree, by body, and the first of these.
    parted: Vec<Option<u64>>,
    pub parted_from: Option<u64>,
    /// The first tick at which their energies or, where energy does not stay, their sizes did not agree: an encounter was too close for
    /// them.
    pub unresolved_from: Option<u64>,
    starts: Vec<Body>,
    /// Largest distance from the start, m, by body.
    ways: Vec<f64>,
}

impl Truth {
    /// The truth by two finer runs, the coarser first, with that many ticks per tick of the scene. `window_from` is the first tick of the
    /// window.
    pub fn new(
        [coarse, fine]: [Simulation; 2],
        cast: &Cast,
        ticks_per_tick: [u32; 2],
        window_from: u64,
    ) -> Self {
        let looks = [Look::at(&coarse, cast), Look::at(&fine, cast)];
        let most = [Most::of(&looks[0]), Most::of(&looks[1])];
        let [_, look] = looks;
        Self {
            coarse,
            fine,
            ticks_per_tick,
            records: vec![(0, most[1].clone())],
            most,
            window: Window::default(),
            window_from,
            ticks: 0,
            parted: vec![None; cast.ids.len()],
            parted_from: None,
            unresolved_from: None,
            ways: vec![0.0; look.bodies.len()],
            starts: look.bodies,
        }
    }

    /// Simulates a tick of the scene.
    pub fn tick(&mut self, cast: &Cast) {
        self.ticks += 1;
        let [coarse, fine] = [0, 1].map(|i| self.sampled(i, cast));
        self.compare(&coarse, &fine, cast);
        let due = self.recorded() as f64 * (1.0 + APART);
        if self.ticks as f64 >= due {
            self.records.push((self.ticks, self.now()));
        }
    }

    /// Simulates a tick of the scene by one of the two runs.
    fn sampled(&mut self, which: usize, cast: &Cast) -> Look {
        let run = if which == 0 { &mut self.coarse } else { &mut self.fine };
        let samples = self.ticks_per_tick[which];
        let in_window = which == 1 && self.ticks > self.window_from;
        let mut note = |look: Look| {
            self.most[which].add(&look);
            if in_window {
                self.window.add(&look);
            }
            look
        };
        for _ in 1..samples {
            run.tick();
            note(Look::within(run, cast));
        }
        run.tick();
        note(Look::at(run, cast))
    }

    /// The largest values so far, of both runs.
    fn now(&self) -> Most {
        let [coarse, fine] = &self.most;
        let mut most = fine.clone();
        most.join(coarse);
        most
    }

    /// Whether the runs did not agree on a body by the end of this tick.
    pub fn is_parted(&self, body: usize, tick: u64) -> bool {
        self.parted[body].is_some_and(|parted| parted <= tick)
    }

    /// Whether the runs agreed on energies or sizes by the end of this tick.
    pub fn is_resolved(&self, tick: u64) -> bool {
        self.unresolved_from.is_none_or(|unresolved| tick < unresolved)
    }

    /// The last tick of which there is a record.
    pub fn recorded(&self) -> u64 {
        self.records.last().map_or(0, |(tick, _)| *tick)
    }

    /// The largest values by the end of this tick, or a little later.
    pub fn by(&self, tick: u64) -> &Most {
        let at = self.records.partition_point(|(recorded, _)| *recorded < tick);
        &self.records[at.min(self.records.len() - 1)].1
    }

    /// Ends the records at the present tick.
    pub fn close(&mut self) {
        let now = self.now();
        self.records.push((self.ticks, now));
    }

    fn compare(&mut self, coarse: &Look, fine: &Look, cast: &Cast) {
        let most = &self.most[1];
        let apart = (coarse.energy - fine.energy).abs();
        let mean = (most.kinetic_sum[0] / most.kinetic_sum[1]).max(BOUND * fine.energy.abs());
        let agree = if cast.conserves {
            apart <= UNRESOLVED * mean + most.faint_energy() || !fine.energy.is_finite()
        } else {
            let sizes = self.most[0].arms.iter().zip(&most.arms);
            { sizes }.all(|(a, b)| *a <= ALIKE * b && *b <= ALIKE * a)
        };
        if self.unresolved_from.is_none() && !agree {
            self.unresolved_from = Some(self.ticks);
        }
        let mut part = vec![false; cast.ids.len()];
        for (arm, body) in cast.bound.iter().copied().enumerate() {
            let apart = coarse.arms[arm].zip(fine.arms[arm]).map(|(a, b)| a.distance(b));
            part[body] |= apart.is_none_or(|apart| apart > PARTED * self.most[1].arms[arm]);
        }
        for (i, part) in part.iter_mut().enumerate() {
            let (start, a, b) = (self.starts[i], coarse.bodies[i], fine.bodies[i]);
            if let (Body::Present(x0, _), Body::Present(x, _)) = (start, b) {
                self.ways[i] = self.ways[i].max(x0.distance(x));
            }
            *part |= match (a, b) {
                (Body::Present(xa, va), Body::Present(xb, vb)) if !cast.is_bound[i] => {
                    let rounding = ROUNDING * self.most[1].sizes[i];
                    // A particle that is born again begins another way.
                    let way = if start == Body::Away { f64::INFINITY } else { self.ways[i] };
                    let faint = self.most[1].faint(i, cast);
                    xa.distance(xb) > PARTED * way + rounding
                        || va.distance(vb) > PARTED * self.most[1].speeds[i] + faint
                }
                (a, b) => (a == Body::Quarantined) != (b == Body::Quarantined),
            };
        }
        for (parted, _) in self.parted.iter_mut().zip(part).filter(|(_, now)| *now) {
            parted.get_or_insert(self.ticks);
            self.parted_from.get_or_insert(self.ticks);
        }
    }
}
