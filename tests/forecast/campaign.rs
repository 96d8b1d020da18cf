//! Trials of random scenes in which two things meet, and of scenes that once were missed, each beside its own finer run.

use std::fmt::Write as _;

use bevy_ecs::prelude::*;
use history::{Fault, Overrides, Simulation, Watch};
use lab::trial::{Ahead, Trial, Tried, Verdict};
use motion::margin::Margins;
use motion::units::Vector;
use motion::{Method, PhysicsBody, Quarantined, Transform, totals};
use report::ForecastRow;
use scene::Scene;

use crate::rigs::{Dice, scene_of};

/// What scenes are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Element {
    Well,
    RidingWell,
    MutualGravity,
    Spring,
    Cord,
    LinearDrag,
    QuadraticDrag,
    Engine,
    Gusts,
    Lock,
    Limit,
}

use Element::{
    Cord, Engine, Gusts, Limit, LinearDrag, Lock, MutualGravity, QuadraticDrag, RidingWell, Spring,
    Well,
};

const ELEMENTS: [Element; 11] = [
    Well,
    RidingWell,
    MutualGravity,
    Spring,
    Cord,
    LinearDrag,
    QuadraticDrag,
    Engine,
    Gusts,
    Lock,
    Limit,
];

/// A scene about a body `b`, 1 m from what holds it.
struct Sketch {
    dice: Dice,
    elements: [Element; 2],
    /// Highest rate or frequency at the start, about, 1/s.
    rate: f64,
    mass: f64,
    x: Vector,
    v: Vector,
    bodies: String,
    wells: String,
    springs: String,
    drag: String,
    keys: String,
    /// Keys of `b`.
    own: String,
}

impl Sketch {
    fn of(elements: [Element; 2], seed: u64) -> Self {
        let mut dice = Dice(seed);
        let mass = log(&mut dice, 0.1, 10.0);
        let v = Vector::Y * log(&mut dice, 0.01, 1.0);
        let [bodies, wells, springs, drag, keys, own] = Default::default();
        let (rate, x) = (0.3, Vector::X);
        let mut sketch =
            Self { dice, elements, rate, mass, x, v, bodies, wells, springs, drag, keys, own };
        for element in ELEMENTS.into_iter().filter(|element| elements.contains(element)) {
            sketch.add(element);
        }
        sketch
    }

    fn has(&self, element: Element) -> bool {
        self.elements.contains(&element)
    }

    fn log(&mut self, low: f64, high: f64) -> f64 {
        log(&mut self.dice, low, high)
    }

    fn toss(&mut self) -> bool {
        self.dice.number() > 0.0
    }

    fn add(&mut self, element: Element) {
        match element {
            Well => {
                let strength = self.log(0.3, 3.0);
                let softening = if self.toss() { self.log(0.01, 0.3) } else { 0.0 };
                self.rate = self.rate.max(strength.sqrt());
                self.v = Vector::Y * strength.sqrt() * self.log(0.5, 1.2);
                let _ = write!(
                    self.wells,
                    "(strength_m3_s2: {strength:?}, softening_m: {softening:?}),"
                );
            }
            RidingWell => self.add_riding_well(),
            MutualGravity => self.add_mutual_gravity(),
            Spring | Cord => self.add_spring(element == Cord),
            LinearDrag => {
                let rate = self.log(0.05, 5.0);
                self.rate = self.rate.max(rate);
                let _ = write!(self.drag, "linear_per_s: {rate:?},");
            }
            QuadraticDrag => {
                let drag = self.log(0.02, 3.0);
                self.rate = self.rate.max(2.0 * drag * self.v.length());
                if self.has(Gusts) || self.toss() {
                    let _ = write!(self.drag, "quadratic_per_m: {drag:?},");
                } else {
                    let _ = write!(self.own, "quadratic_drag_kg_m: {:?},", drag * self.mass);
                }
            }
            Engine => {
                let force = self.mass * self.log(0.1, 3.0);
                let from = if self.toss() { 0.0 } else { self.log(1.0, 30.0) };
                let curve = format!("polynomial([({force:?}, 0, 0)])");
                let _ = write!(
                    self.keys,
                    "thrusts: [(body: \"b\", curve: {curve}, from_s: {from:?})],"
                );
            }
            Gusts => {
                if self.drag.is_empty() {
                    let rate = self.log(0.05, 2.0);
                    self.rate = self.rate.max(rate);
                    let _ = write!(self.drag, "linear_per_s: {rate:?},");
                }
                let (wind, gust, hz) =
                    (self.log(0.2, 4.0), self.log(0.1, 5.0), self.log(0.02, 0.3));
                let _ = write!(
                    self.keys,
                    "wind: (velocity_m_s: ({wind:?}, 0, 0), gust_m_s: {gust:?}, gust_hz: {hz:?}),"
                );
            }
            Lock => {
                let axis = ["x", "y", "z"][self.dice.below(3)];
                let _ = write!(self.own, "locked_axes: [{axis}],");
            }
            Limit => {
                let speed = self.log(0.3, 3.0);
                let _ = write!(self.own, "max_speed_m_s: {speed:?},");
            }
        }
    }

    fn add_riding_well(&mut self) {
        let strength = self.log(0.3, 3.0);
        self.rate = self.rate.max(strength.sqrt());
        let (at, speed) = if self.has(Well) { (5.0, 0.35) } else { (0.0, self.dice.number()) };
        self.x.x += at;
        self.v = Vector::Y * (speed + strength.sqrt() * self.log(0.6, 1.2));
        let _ = write!(
            self.bodies,
            "(name: \"carrier\", mass_kg: 50.0, position_m: ({at:?}, 0, 0), velocity_m_s: (0, {speed:?}, 0)),"
        );
        let _ = write!(
            self.wells,
            "(strength_m3_s2: {strength:?}, rides_on: \"carrier\", bodies: [\"b\"]),"
        );
    }

    fn add_mutual_gravity(&mut self) {
        let (mass, constant) = (self.log(1.0, 30.0), self.log(0.1, 1.0));
        let _ = write!(self.keys, "mutual_gravity: (constant_m3_kg_s2: {constant:?}),");
        let frequency = (constant * (mass + self.mass)).sqrt();
        self.rate = self.rate.max(frequency);
        let (place, speed) = if self.has(RidingWell) {
            (-3.0, (constant * 50.0 / 3.0).sqrt())
        } else if self.has(Well) {
            (4.0, self.v.y)
        } else {
            let place = self.x.x - 1.0;
            let around = frequency * self.log(0.6, 1.1);
            let share = self.mass / (mass + self.mass);
            let speed = self.v.y - around * share;
            self.v.y += around * (1.0 - share);
            (place, speed)
        };
        let _ = write!(
            self.bodies,
            "(name: \"m\", mass_kg: {mass:?}, position_m: ({place:?}, 0, 0), velocity_m_s: (0, {speed:?}, 0)),"
        );
    }

    fn add_spring(&mut self, pull_only: bool) {
        let stiffness = self.mass * self.log(0.5, 20.0);
        let damping = if self.toss() { 0.0 } else { self.mass * self.log(0.01, 1.0) };
        let rest = self.log(0.3, 1.1);
        self.rate = self.rate.max((stiffness / self.mass).sqrt());
        let is_held = self.has(MutualGravity) || self.toss();
        let kind = if is_held {
            "immovable: true".to_owned()
        } else {
            format!("mass_kg: {:?}", self.log(0.1, 100.0))
        };
        let (name, y) = if pull_only { ("cord", -1.2) } else { ("spring", 1.0) };
        let x = self.x.x;
        let _ = write!(self.bodies, "(name: \"{name}\", position_m: ({x:?}, {y:?}, 0.3), {kind}),");
        let _ = write!(
            self.springs,
            "(between: (\"{name}\", \"b\"), stiffness_n_m: {stiffness:?}, damping_n_s_m: {damping:?},
              rest_length_m: {rest:?}, pull_only: {pull_only}),"
        );
    }

    /// The scene, with a method and a step for which `w h` is between 0.03 and 3.
    fn scene(mut self) -> Scene {
        let product = self.log(0.03, 3.0);
        let method = loop {
            let method = Method::ALL[self.dice.below(Method::ALL.len())];
            if !(self.has(MutualGravity) && method == Method::ImplicitEuler) {
                break method.name();
            }
        };
        let gravity = if self.dice.number() > 0.4 && !self.has(RidingWell) {
            format!("gravity: (acceleration_m_s2: (0, {:?}, 0)),", -self.log(0.2, 3.0))
        } else {
            String::new()
        };
        let Self { rate, mass, x, v, bodies, wells, springs, drag, keys, own, .. } = self;
        let list = |key: &str, [open, close]: [char; 2], items: &str| {
            if items.is_empty() { String::new() } else { format!("{key}: {open}{items}{close},") }
        };
        let [wells, springs] =
            [("wells", wells), ("springs", springs)].map(|(key, all)| list(key, ['[', ']'], &all));
        let drag = list("drag", ['(', ')'], &drag);
        let tuple = |v: Vector| format!("({:?}, {:?}, {:?})", v.x, v.y, v.z);
        let b = format!(
            "(name: \"b\", mass_kg: {mass:?}, position_m: {}, velocity_m_s: {}, {own})",
            tuple(x),
            tuple(v)
        );
        scene_of(&format!(
            "(version: 1, step_hz: {:?}, method: {method}, {gravity} {keys} {drag} {wells} {springs} bodies: [{bodies} {b}])",
            rate / product
        ))
    }
}

fn log(dice: &mut Dice, low: f64, high: f64) -> f64 {
    low * (high / low).powf(0.5 * (dice.number() + 1.0))
}

/// The largest speed of each body and the largest distance of each pair over a run, and its end.
struct Seen {
    speeds: Vec<f64>,
    pairs: Vec<f64>,
    is_quarantined: bool,
    /// Change of the energy of largest magnitude, largest kinetic energy, and energy at the end, J.
    energies: [f64; 3],
    end: Vec<(Vector, Vector)>,
    /// What the watch found.
    fault: Option<Fault>,
}

impl Seen {
    /// A run of `ticks` ticks in each of which `times` ticks of `scene` pass.
    fn of(scene: &Scene, ticks: u64, times: u64) -> Self {
        let mut run = Simulation::new(scene.clone());
        let count = run.bodies.len();
        let mut seen = Self {
            speeds: vec![0.0; count],
            pairs: vec![0.0; count * count],
            is_quarantined: false,
            energies: [0.0; 3],
            end: Vec::new(),
            fault: None,
        };
        let mut watch = Watch::new(&run);
        let energy = |run: &mut Simulation| {
            let sums = totals(&run.world);
            [sums.kinetic_energy + sums.potential_energy, sums.kinetic_energy]
        };
        let [start, _] = energy(&mut run);
        for tick in 0..=ticks * times {
            if tick > 0 {
                let fault = watch.tick(&mut run, None);
                seen.fault = seen.fault.or(fault);
            }
            let bodies = run.bodies.iter().map(|body| run.world.entity(*body));
            seen.is_quarantined |= bodies.clone().any(|body| body.contains::<Quarantined>());
            let state = |body: EntityRef<'_>| {
                let (at, state) = body.components::<(&Transform, &PhysicsBody)>();
                (at.position, state.velocity)
            };
            seen.end = bodies.map(state).collect();
            for (i, (x, v)) in seen.end.iter().enumerate() {
                seen.speeds[i] = seen.speeds[i].max(v.length());
                for (j, (other, _)) in seen.end[..i].iter().enumerate() {
                    let pair = &mut seen.pairs[i * count + j];
                    *pair = pair.max(x.distance(*other));
                }
            }
            if tick.is_multiple_of(times) {
                let [total, kinetic] = energy(&mut run);
                if (total - start).abs() > seen.energies[0].abs() {
                    seen.energies[0] = total - start;
                }
                seen.energies[1] = seen.energies[1].max(kinetic);
                seen.energies[2] = total;
            }
        }
        seen.fault = seen.fault.or_else(|| watch.finish(&run));
        seen
    }

    /// The truth: a run by Runge-Kutta 4 in ticks so short that four times shorter ones change nothing; `None` if that takes too
    /// long.
    fn truth(scene: &Scene, ticks: u64) -> Option<Self> {
        let finer = |times: u64| {
            let mut scene = scene.clone().damped_by_law();
            (scene.method, scene.substeps) = (Method::RungeKutta4, 1.into());
            scene.step_hz *= times as f64;
            Self::of(&scene, ticks, times)
        };
        let mut last = finer(32);
        for times in [128, 512, 2048].into_iter().take_while(|times| ticks * times < 600_000) {
            let now = finer(times);
            let fastest = now.speeds.iter().copied().fold(0.0, f64::max);
            let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 0.05 * a.max(*b) + 1e-9;
            let ends = now.end.iter().zip(&last.end);
            let agrees = !now.is_quarantined
                && now.speeds.iter().zip(&last.speeds).all(near)
                && now.pairs.iter().zip(&last.pairs).all(near)
                && { ends }.all(|((_, a), (_, b))| a.distance(*b) <= 0.1 * fastest);
            if agrees {
                return Some(now);
            }
            last = now;
        }
        None
    }

    /// How it exceeds `factor` times the truth: by a speed, or by the distance of a pair that stays together in truth.
    fn exceeds(&self, truth: &Self, start: &Self, factor: f64) -> Option<String> {
        if self.is_quarantined {
            return Some("quarantined".to_owned());
        }
        let speeds = self.speeds.iter().zip(&truth.speeds);
        let speed = { speeds }.find(|(own, all)| **own > factor * **all + 1e-6);
        let pairs = self.pairs.iter().zip(truth.pairs.iter().zip(&start.pairs));
        let pair = { pairs }
            .find(|(own, (all, start))| **all < 2.0 * **start && **own > factor * **all + 1e-6);
        speed
            .map(|(own, all)| format!("speed {own} for {all}"))
            .or_else(|| pair.map(|(own, (all, _))| format!("distance {own} for {all}")))
    }

    /// Whether it goes like the truth, and ends like it.
    fn is_like(&self, truth: &Self, start: &Self) -> bool {
        let ends = self.end.iter().zip(&truth.end);
        let apart = |end: &[(Vector, Vector)], i: usize, j: usize| end[i].0.distance(end[j].0);
        let pairs = (0..self.end.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        self.exceeds(truth, start, 1.5).is_none()
            && [0, 2]
                .iter()
                .all(|at| (self.energies[*at] - truth.energies[*at]).abs() < truth.energies[1])
            && { ends }.all(|((_, own), (_, v))| own.distance(*v) <= 0.05 * v.length())
            && { pairs }.all(|(i, j)| {
                let (own, all) = (apart(&self.end, i, j), apart(&truth.end, i, j));
                (own - all).abs() < 0.3 * all
            })
    }
}

/// A tenth of the work of a forecast: the finer runs here take far longer.
const AHEAD: Ahead = Ahead { work: 1e6, ..Ahead::DEFAULT };

/// What a forecast says of a scene: its trials, and its margins that name a fault.
fn forecast(scene: &Scene) -> (Vec<Tried>, Vec<ForecastRow>) {
    let run = Simulation::new(scene.clone());
    let method = run.method();
    let margins = Margins::of(&run.world, method);
    let mut trial = Trial::new(&run, AHEAD);
    trial.finish();
    let mut rows = ForecastRow::of(&run, &margins, &trial);
    rows.retain(|row| row.margin().is_some() && row.is_fault());
    (trial.found(), rows)
}

/// Counts of a campaign.
#[derive(Debug, Default)]
struct Counts {
    scenes: usize,
    faults: usize,
    cures: usize,
    /// Scenes that were not tried, and scenes without a truth.
    skipped: [usize; 2],
    missed: Vec<String>,
    accused: Vec<String>,
    broken: Vec<String>,
    /// Right motions that the watch calls a fault.
    alarms: Vec<String>,
    /// Scenes in which bodies are thrown out, and those of them in which the watch finds no fault.
    thrown: usize,
    silent: Vec<String>,
}

impl Counts {
    fn judge(&mut self, scene: &Scene) {
        self.scenes += 1;
        let (trials, margins) = forecast(scene);
        let is_tried = |tried: &&Tried| tried.verdict != Verdict::NotTried;
        let seconds = trials.iter().filter(is_tried).map(|tried| tried.seconds);
        let seconds = seconds.fold(f64::INFINITY, f64::min);
        let ticks = if seconds.is_finite() { scene.ticks_in(seconds) } else { 200 };
        if margins.is_empty() && !trials.iter().any(|tried| is_tried(&tried)) {
            self.skipped[0] += 1;
            return;
        }
        let Some(truth) = Seen::truth(scene, ticks) else {
            self.skipped[1] += 1;
            return;
        };
        let (start, own) = (Seen::of(scene, 0, 1), Seen::of(scene, ticks, 1));
        let name = |what: &str| format!("{what}: {trials:?} {margins:?}\n{}", scene.text);
        let has_fault = !margins.is_empty() || trials.iter().any(|tried| tried.verdict.is_fault());
        // A cure is tried as far as the motion can be predicted.
        let until = trials.iter().filter_map(|tried| tried.predictable_s).fold(seconds, f64::min);
        let known = scene.ticks_in(until).saturating_sub(1).min(ticks);
        let shorter = if has_fault && known < ticks { Seen::truth(scene, known) } else { None };
        let known_truth = if known < ticks { shorter.as_ref() } else { Some(&truth) };
        self.faults += usize::from(has_fault);
        let of_own = own.fault.as_ref().filter(|_| own.is_like(&truth, &start));
        if let Some(fault) = truth.fault.as_ref().or(of_own) {
            self.alarms.push(name(&fault.what));
        }
        let exceeds = own.exceeds(&truth, &start, 4.5);
        if let Some(why) = &exceeds {
            self.thrown += 1;
            if own.fault.is_none() {
                self.silent.push(name(why));
            }
        }
        match (has_fault, exceeds) {
            (false, Some(why)) => self.missed.push(name(&why)),
            (true, _) if own.is_like(&truth, &start) => self.accused.push(name("like the truth")),
            _ => {}
        }
        let of_trials = trials.iter().filter(|tried| tried.verdict.is_fault());
        let mut cures: Vec<_> =
            of_trials.map(|tried| tried.cure).chain(margins.iter().map(|row| row.cure)).collect();
        cures.dedup();
        // With several faults a cure is of one of them.
        let is_alone = trials.len().max(margins.len()) == 1;
        for cure in cures.into_iter().filter(|_| is_alone) {
            let substeps = cure.substeps.map(|substeps| (None, Some(substeps.into())));
            let method = cure.method.map(|method| (Some(method), None));
            for (method, substeps) in substeps.into_iter().chain(method) {
                self.cures += 1;
                let mut cured = scene.clone();
                Overrides { method, substeps, ..Overrides::default() }.apply(&mut cured);
                let (again, margins) = forecast(&cured);
                let exceeds = known_truth
                    .and_then(|truth| Seen::of(&cured, known, 1).exceeds(truth, &start, 4.5));
                let has_fault =
                    !margins.is_empty() || again.iter().any(|tried| tried.verdict.is_fault());
                if has_fault || exceeds.is_some() {
                    self.broken
                        .push(name(&format!("{method:?} {substeps:?} {exceeds:?} {again:?}")));
                }
            }
        }
    }

    #[track_caller]
    fn are_good(&self) {
        let Self { scenes, missed, accused, broken, alarms, thrown, silent, .. } = self;
        assert!(missed.is_empty() && broken.is_empty(), "{self:#?}");
        assert!(accused.len().max(alarms.len()) * 100 <= *scenes, "{self:#?}");
        assert!(2 * silent.len() <= *thrown, "{self:#?}");
        println!("thrown out: {thrown}, silent: {}", silent.len());
    }
}

/// Scenes for each pair of elements: `INERTIA_CAMPAIGN` has another number.
fn each() -> u64 {
    std::env::var("INERTIA_CAMPAIGN").map_or(1, |each| each.parse().expect("a whole number"))
}

#[test]
fn scenes_in_which_two_things_meet_are_judged_like_their_finer_runs() {
    let mut counts = Counts::default();
    let pairs = (0..ELEMENTS.len()).flat_map(|i| (0..=i).map(move |j| (j, i)));
    for (j, i) in pairs {
        for seed in 0..each() {
            let seed = 1000 * seed + 20 * i as u64 + j as u64;
            counts.judge(&Sketch::of([ELEMENTS[j], ELEMENTS[i]], seed).scene());
        }
    }
    counts.are_good();
    let Counts { scenes, faults, cures, skipped, .. } = counts;
    assert!(10 * faults > scenes && cures > faults, "{faults} {cures} of {scenes}");
    assert!(10 * (skipped[0] + skipped[1]) < 3 * scenes, "{skipped:?} of {scenes}");
    println!("{scenes} scenes, {faults} faults, {cures} cures, {skipped:?} skipped");
}

/// A canopy that drag holds, and who hangs on it.
fn parachute(hz: f64, method: &str) -> Scene {
    scene_of(&format!(
        "(version: 1, step_hz: {hz:?}, method: {method}, gravity: (acceleration_m_s2: (0, -9.8, 0)), bodies: [
            (name: \"canopy\", mass_kg: 0.5, position_m: (0, 1000, 0), drag_area_m2: 40),
            (name: \"jumper\", mass_kg: 80, position_m: (0, 993, 0))],
          springs: [(between: (\"canopy\", \"jumper\"), stiffness_n_m: 200, damping_n_s_m: 10)])"
    ))
}

/// A moon around a planet around a sun.
fn moon(sun: f64, [planet, moon]: [f64; 2], hz: f64, method: &str) -> Scene {
    scene_of(&format!(
        "(version: 1, step_hz: {hz:?}, method: {method}, mutual_gravity: (constant_m3_kg_s2: 1), bodies: [
            (name: \"sun\", mass_kg: {sun:?}),
            (name: \"planet\", mass_kg: 1, position_m: (100, 0, 0), velocity_m_s: (0, {planet:?}, 0)),
            (name: \"moon\", mass_kg: 0.001, position_m: (100.5, 0, 0), velocity_m_s: (0, {moon:?}, 0))])"
    ))
}

fn riding(hz: f64) -> Scene {
    scene_of(&format!(
        "(version: 1, step_hz: {hz:?}, method: velocity_verlet, bodies: [
            (name: \"planet\", position_m: (20, 0, 0), velocity_m_s: (0, 12.2474487, 0)),
            (name: \"moon\", position_m: (20.2, 0, 0), velocity_m_s: (0, 34.6081, 0))],
          wells: [(strength_m3_s2: 3000),
            (strength_m3_s2: 100, rides_on: \"planet\", bodies: [\"moon\"])])"
    ))
}

/// A moon of a planet of the Sun, at their distances and speeds from each other, in ticks of `tick_s` seconds.
fn of_the_sun([planet, moon]: [[f64; 3]; 2], tick_s: f64, method: &str) -> Scene {
    let [mass, at, speed] = planet;
    let [moon_mass, beside, faster] = moon;
    scene_of(&format!(
        "(version: 1, step_hz: {:?}, method: {method}, mutual_gravity: (constant_m3_kg_s2: 6.6743e-11), bodies: [
            (name: \"sun\", mass_kg: 1.989e30),
            (name: \"planet\", mass_kg: {mass:?}, position_m: ({at:?}, 0, 0), velocity_m_s: (0, {speed:?}, 0)),
            (name: \"moon\", mass_kg: {moon_mass:?}, position_m: ({:?}, 0, 0), velocity_m_s: (0, {:?}, 0))])",
        1.0 / tick_s,
        at + beside,
        speed + faster
    ))
}

/// Jupiter and Io: mass, kg, distance, m, and speed, m/s, of each about what holds it.
const IO: [[f64; 3]; 2] = [[1.898e27, 7.785e11, 13_060.0], [8.93e22, 4.217e8, 17_334.0]];

/// Earth and Moon.
const MOON: [[f64; 3]; 2] = [[5.972e24, 1.496e11, 29_780.0], [7.342e22, 3.844e8, 1_022.0]];

/// A nearly free orbit about a well, on a spring to an anchor.
fn sprung_orbit(hz: f64, method: &str, stiffness: f64, speed: f64) -> Scene {
    scene_of(&format!(
        "(version: 1, step_hz: {hz:?}, method: {method}, wells: [(strength_m3_s2: 1.0)], bodies: [
            (name: \"anchor\", immovable: true, position_m: (2, 1, 0)),
            (name: \"b\", position_m: (2, 0, 0), velocity_m_s: (0, {speed:?}, 0))],
          springs: [(between: (\"anchor\", \"b\"), stiffness_n_m: {stiffness:?}, rest_length_m: 1)])"
    ))
}

/// Implicit Euler at `w h` 10 about a well, with drag.
const STIFF_WELL: &str =
    "(version: 1, step_hz: 0.1, method: implicit_euler, wells: [(strength_m3_s2: 1.0)], drag: (linear_per_s: 0.01),
      bodies: [(name: \"b\", position_m: (1, 0, 0), velocity_m_s: (0, 1, 0))])";

const LATER_ENGINE: &str =
    "(version: 1, step_hz: 0.28, method: semi_implicit_euler, bodies: [(name: \"b\", quadratic_drag_kg_m: 0.12)],
      thrusts: [(body: \"b\", curve: polynomial([(1.66, 0, 0)]), from_s: 35.3)])";

const CORD: &str =
    "(version: 1, step_hz: 2.37, method: explicit_euler, gravity: (acceleration_m_s2: (0, -9.8, 0)), bodies: [
        (name: \"a\", immovable: true), (name: \"b\", mass_kg: 4.3, position_m: (0, -1, 0))],
      springs: [(between: (\"a\", \"b\"), stiffness_n_m: 19.5, damping_n_s_m: 1.65, pull_only: true)])";

/// Scenes that the forecast once called stable while their bodies were thrown out.
#[test]
fn scenes_that_were_missed_are_judged_like_their_finer_runs() {
    let methods = ["velocity_verlet", "semi_implicit_euler", "yoshida_4", "runge_kutta_4"];
    let mut counts = Counts::default();
    for hz in [60.0, 240.0, 2000.0] {
        methods.iter().for_each(|method| counts.judge(&parachute(hz, method)));
    }
    for (sun, speeds) in [
        (10_000.0, [10.0, 11.414_213_6]),
        (100.0, [1.0, 2.414_213_6]),
        (1_000.0, [3.162_277_7, 4.576_491_3]),
    ] {
        for (hz, method) in [1.0, 1.5, 2.0, 2.5].into_iter().zip(methods) {
            counts.judge(&moon(sun, speeds, hz, method));
        }
    }
    [10.0, 30.0, 60.0, 120.0].into_iter().for_each(|hz| counts.judge(&riding(hz)));
    for method in methods {
        for tick_s in [86_400.0, 21_600.0] {
            counts.judge(&of_the_sun(IO, tick_s, method));
        }
        counts.judge(&of_the_sun(MOON, 604_800.0, method));
    }
    counts.judge(&sprung_orbit(8.0, "position_verlet", 0.018, 0.1));
    counts.judge(&sprung_orbit(183.0, "yoshida_4", 0.69, 0.01));
    [LATER_ENGINE, CORD, STIFF_WELL].into_iter().for_each(|text| counts.judge(&scene_of(text)));
    counts.are_good();
    assert!(counts.faults >= 15, "{counts:#?}");
}

/// A cold cloud of bodies that attract each other, without a truth: it is judged by its energy, whatever their number.
#[test]
fn clouds_of_any_number_of_bodies_are_judged_alike() {
    for count in [16, 17, 24, 200] {
        let mut dice = Dice(count);
        let mut bodies = String::new();
        for _ in 0..count {
            let Vector { x, y, z } = (0..4).map(|_| dice.vector()).sum::<Vector>();
            let _ = write!(bodies, "(position_m: ({x:?}, {y:?}, {z:?})),");
        }
        let scene = scene_of(&format!(
            "(version: 1, step_hz: 60, method: velocity_verlet,
              mutual_gravity: (constant_m3_kg_s2: 1, softening_m: 0.01), bodies: [{bodies}])"
        ));
        let run = Simulation::new(scene);
        let mut trial = Trial::new(&run, Ahead::DEFAULT);
        trial.finish();
        let found = trial.found();
        assert!(found[0].verdict.is_fault(), "{count}: {found:?}");
    }
}

/// A rod that hangs from a post and has no tension yet, at 60 degrees from the vertical.
const PENDULUM: &str =
    "(version: 1, step_hz: 60, method: METHOD, gravity: (acceleration_m_s2: (0, -9.81, 0)), bodies: [
    (name: \"post\", immovable: true), (name: \"bob\", position_m: (0.5, -0.8660254, 0), mass_kg: 1.0)],
    springs: [(between: (\"post\", \"bob\"), stiffness_n_m: 200, rest_length_m: 1, damping_n_s_m: 28)])";

/// A critically damped spring that begins stretched, so that it has some stiffness across, where nothing damps, until it rests.
const SETTLING: &str = "(version: 1, step_hz: 60, method: METHOD, bodies: [
    (name: \"post\", immovable: true), (name: \"bob\", position_m: (1.3, 0, 0), mass_kg: 1.0)],
    springs: [(between: (\"post\", \"bob\"), stiffness_n_m: 100, rest_length_m: 1, damping_n_s_m: 20)])";

#[test]
fn methods_that_need_damping_are_judged_over_the_motion() {
    for (scene, method, has_fault) in [
        (PENDULUM, "explicit_euler", true),
        (PENDULUM, "semi_implicit_euler", false),
        (SETTLING, "explicit_euler", false),
        (SETTLING, "runge_kutta_2_heun", false),
    ] {
        let (trials, margins) = forecast(&scene_of(&scene.replace("METHOD", method)));
        let found = trials.iter().any(|tried| tried.verdict.is_fault()) || !margins.is_empty();
        assert_eq!(found, has_fault, "{method}: {trials:?} {margins:?}");
    }
}

/// Of many single bodies, the extreme ones are tried.
#[test]
fn a_fast_body_is_found_among_thousands() {
    let scene = scene_of(
        "(version: 1, step_hz: 60, method: explicit_euler, drag: (quadratic_per_m: 0.5),
          clouds: [(count: 5000, center_m: (0, 0, 0), half_extents_m: (1, 1, 1), speed_m_s: 0.1)],
          bodies: [(name: \"fast\", velocity_m_s: (300, 0, 0))])",
    );
    let (trials, _) = forecast(&scene);
    let [tried] = &trials[..] else { panic!("{trials:?}") };
    assert!(tried.bodies <= 256 && tried.of == 5001, "{tried:?}");
    assert!(matches!(tried.verdict, Verdict::Thrown(..)) && tried.body == Some(0), "{tried:?}");
}
