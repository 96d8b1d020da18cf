//! Samples for graphs: of the selection and of kept bodies, in the run and in its ghosts.

use std::collections::VecDeque;

use glam::DVec3;
use history::Simulation;
use motion::clock::StepClock;
use motion::{Method, Push};

use crate::stage::Stage;
use crate::stage::playback::CATCH_UP;
use crate::stage::things::{Motion, Thing};
use crate::tools::ghosts::{GhostRun, Ghosts};

/// How long a sample is kept, s.
const KEPT_S: f64 = 10.0;

/// Greatest number of samples of one body in one run.
const MOST_SAMPLES: usize = 4096;

/// Fraction of the largest span of values below which a curve is flat.
const FLAT: f64 = 0.01;

/// Greatest number of bodies that a person keeps.
pub(super) const MOST_KEPT: usize = 8;

/// The quantity that is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Quantity {
    #[default]
    Position,
    Velocity,
    Acceleration,
    Force,
    KineticEnergy,
    Substeps,
}

impl Quantity {
    pub const ALL: [Self; 6] = [
        Self::Position,
        Self::Velocity,
        Self::Acceleration,
        Self::Force,
        Self::KineticEnergy,
        Self::Substeps,
    ];

    /// Whether it has no parts.
    pub const fn is_scalar(self) -> bool {
        matches!(self, Self::KineticEnergy | Self::Substeps)
    }

    pub const fn name(self) -> &'static str {
        match self {
            Self::Position => "position, m",
            Self::Velocity => "velocity, m/s",
            Self::Acceleration => "acceleration, m/s²",
            Self::Force => "force, N",
            Self::KineticEnergy => "kinetic energy, J",
            Self::Substeps => "substeps per tick",
        }
    }

    /// The value that is drawn of a motion, if it is known.
    pub fn value(self, motion: &Motion, part: Part) -> Option<f64> {
        let vector = match self {
            Self::Position => motion.position,
            Self::Velocity => motion.velocity,
            Self::Acceleration => motion.forced?[0],
            Self::Force => motion.forced?[1],
            Self::KineticEnergy => return Some(motion.kinetic_energy),
            Self::Substeps => return Some(f64::from(motion.substeps)),
        };
        Some(match part {
            Part::X => vector.x,
            Part::Y => vector.y,
            Part::Z => vector.z,
            Part::Magnitude => vector.length(),
        })
    }
}

/// The part of a vector that is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Part {
    X,
    #[default]
    Y,
    Z,
    Magnitude,
}

impl Part {
    pub const ALL: [Self; 4] = [Self::X, Self::Y, Self::Z, Self::Magnitude];

    pub const fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::Magnitude => "magnitude",
        }
    }
}

/// The run of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Run {
    Solid,
    /// The ghosts of that method; `None` is the reference.
    Ghost(Option<Method>),
}

/// A motion at one time, s.
pub(super) struct Sample {
    pub time: f64,
    pub motion: Motion,
}

/// How one body moved in one run.
pub(super) struct Track {
    pub run: Run,
    pub shown: bool,
    pub samples: VecDeque<Sample>,
}

impl Track {
    /// Forgets what was sampled at `time` or later.
    fn forget_from(&mut self, time: f64) {
        while self.samples.pop_back_if(|sample| sample.time >= time).is_some() {}
    }

    /// Forgets what is too old at `time`.
    fn forget_before(&mut self, time: f64) {
        while self.samples.len() > MOST_SAMPLES
            || self.samples.front().is_some_and(|sample| sample.time < time - KEPT_S)
        {
            self.samples.pop_front();
        }
    }
}

/// A body in the graph.
pub(super) struct Graphed {
    pub thing: Thing,
    pub name: String,
    /// Its place in the list of colors.
    pub ink: usize,
    /// Whether it stays when something else is selected.
    pub kept: bool,
    pub tracks: Vec<Track>,
}

impl Graphed {
    fn sample(
        &mut self,
        simulation: &Simulation,
        pushes: &[Push],
        time: f64,
        (run, shown): (Run, bool),
    ) {
        let at = self.tracks.iter().position(|track| track.run == run).unwrap_or_else(|| {
            self.tracks.push(Track { run, shown, samples: VecDeque::new() });
            self.tracks.len() - 1
        });
        let track = &mut self.tracks[at];
        track.shown = shown;
        if track.samples.back().is_some_and(|last| last.time == time) {
            return;
        }
        track.forget_from(time);
        let entity = self.thing.entity(simulation);
        let motion = entity.and_then(|entity| Motion::of(simulation, pushes, entity));
        track.samples.extend(motion.map(|motion| Sample { time, motion }));
    }
}

/// The graphs; samples are taken while their panel is open.
#[derive(Default)]
pub(crate) struct Graphs {
    /// The kept bodies, and the selection.
    pub(super) bodies: Vec<Graphed>,
    /// Generation of the ghosts that were sampled.
    ghosts: Option<u64>,
    pub(super) quantity: Quantity,
    /// The parts of a vector that are drawn of one body.
    pub(super) parts: Parts,
    /// The part that is drawn if there are several curves of each.
    pub(super) part: Part,
    /// Whether a person chose `part`; otherwise it is an axis along which something moves.
    pub(super) has_chosen: bool,
    /// Whether the bodies have to be found by name in another text of the scene.
    pub(super) renamed: bool,
}

/// Which parts of a vector are drawn, in the order of [`Part::ALL`].
pub(super) struct Parts(pub [bool; 4]);

impl Default for Parts {
    fn default() -> Self {
        Self([true, true, true, false])
    }
}

impl Graphs {
    /// Samples the bodies and their ghosts after the ticks of a frame.
    pub fn sample(&mut self, stage: &Stage, ghosts: &Ghosts, open: bool) {
        let selection =
            stage.selection().filter(|_| open).and_then(|entity| Thing::of(stage.sim(), entity));
        self.bodies.retain(|body| body.kept || Some(body.thing) == selection);
        if !open {
            self.bodies.iter_mut().for_each(|body| body.tracks.clear());
            return;
        }
        if self.ghosts != ghosts.generation() {
            self.ghosts = ghosts.generation();
            self.bodies
                .iter_mut()
                .for_each(|body| body.tracks.retain(|track| track.run == Run::Solid));
        }
        self.bodies.retain(|body| body.thing.entity(stage.sim()).is_some());
        self.add(stage, selection);
        let time = stage.sim().world.resource::<StepClock>().scene_seconds();
        let pushes = stage.here().pushes();
        for body in &mut self.bodies {
            body.sample(stage.sim(), &pushes, time, (Run::Solid, true));
        }
        let pushes: Vec<(u32, DVec3)> = pushes
            .iter()
            .filter_map(|push| Some((stage.sim().id(push.body)?, push.newtons)))
            .collect();
        for GhostRun { method, shown, simulation } in ghosts.runs(stage.sim().method()) {
            let push = |(id, newtons): &(u32, DVec3)| {
                Some(Push { body: simulation.body(*id)?, newtons: *newtons })
            };
            let pushes: Vec<_> = pushes.iter().filter_map(push).collect();
            for body in &mut self.bodies {
                body.sample(simulation, &pushes, time, (Run::Ghost(method), shown));
            }
        }
        self.tracks().for_each(|track| track.forget_before(time));
        if !self.has_chosen {
            self.choose_part();
        }
    }

    /// Chooses the axis along which values change most, if the current part hardly changes in comparison.
    fn choose_part(&mut self) {
        let span = |part: Part| {
            let solid = self.bodies.iter().filter_map(|body| body.tracks.first());
            let spans = solid.map(|track| {
                let values = track
                    .samples
                    .iter()
                    .filter_map(|sample| self.quantity.value(&sample.motion, part));
                let ends = (f64::INFINITY, f64::NEG_INFINITY);
                let (low, high) =
                    values.fold(ends, |(low, high), value| (low.min(value), high.max(value)));
                high - low
            });
            spans.fold(0.0, f64::max)
        };
        let axes = [Part::X, Part::Y, Part::Z].map(|part| (span(part), part));
        let most = axes.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((most, part)) = most
            && span(self.part) < FLAT * most
        {
            self.part = part;
        }
    }

    /// Adds the selection, if it is not there.
    fn add(&mut self, stage: &Stage, selection: Option<Thing>) {
        let Some((thing, entity)) = selection.zip(stage.selection()) else { return };
        if self.bodies.iter().any(|body| body.thing == thing) {
            return;
        }
        let used: Vec<_> = self.bodies.iter().map(|body| body.ink).collect();
        let ink = (0..).find(|ink| !used.contains(ink)).unwrap_or_default();
        self.bodies.push(Graphed {
            thing,
            name: stage.name(entity),
            ink,
            kept: false,
            tracks: Vec::new(),
        });
    }

    fn tracks(&mut self) -> impl Iterator<Item = &mut Track> {
        self.bodies.iter_mut().flat_map(|body| &mut body.tracks)
    }

    /// Forgets the samples at `time` or later, s, because the run has gone to another state. After a jump forward, forgets all
    /// samples: those in between are missing.
    pub(super) fn go_to(&mut self, time: f64) {
        for track in self.tracks() {
            track.forget_from(time);
            if track.samples.back().is_some_and(|sample| time - sample.time > CATCH_UP) {
                track.samples.clear();
            }
        }
    }

    /// Keeps the kept bodies, found by name in another text of the scene, without their samples.
    pub(crate) fn rebind_by_name(&mut self, stage: &Stage) {
        self.bodies.retain_mut(|body| {
            body.tracks.clear();
            let thing = Thing::named(stage.sim(), &body.name).filter(|_| body.kept);
            thing.inspect(|thing| body.thing = *thing).is_some()
        });
    }

    /// Whether there are several curves of each part.
    pub(super) fn has_several(&self) -> bool {
        self.bodies.len() > 1 || self.ghosts.is_some()
    }

    /// Whether there are ghosts in the graph.
    pub(super) const fn has_ghosts(&self) -> bool {
        self.ghosts.is_some()
    }
}
