//! The metric of a row: one number per look at a run.

use motion::ledger::Energies;
use motion::units::{Scalar, Vector};
use scene::{Measure, Scene, SurvivalRow};

use super::record::PREFIX;
use super::row_run::RowRun;
use crate::cost::{Sample, larger, paired};
use crate::run::movable;

/// Approximate number of looks at a run, unless they would be more than [`EVERY`] ticks apart.
const LOOKS: u64 = 256;

/// Most ticks between two looks.
const EVERY: u64 = 64;

/// The states of another run at the same looks, which positions are compared with.
#[derive(Clone, Debug, Default)]
pub(super) struct Target {
    looks: Vec<Vec<Sample>>,
    start: Vec<Sample>,
    /// Why the looks end early, if a state turned non-finite.
    pub failure: Option<String>,
}

impl Target {
    /// The target for a run that begins now.
    pub fn new(run: &mut RowRun) -> Self {
        Self { looks: Vec::new(), start: run.states(), failure: None }
    }

    /// Why look number `look`, from 0, is missing, if a state turned non-finite before it.
    pub fn ends_before(&self, look: usize) -> Option<&str> {
        self.failure.as_deref().filter(|_| look >= self.looks.len())
    }

    pub fn look(&mut self, run: &mut RowRun) {
        self.looks.push(run.states());
    }

    /// The largest distance from the start at any look, m; 1 if no body moves.
    fn way(&self) -> Scalar {
        let ways = self.looks.iter().flat_map(|look| distances(look, &self.start, Vector::ZERO));
        let longest = ways.fold(0.0, Scalar::max);
        if longest > 0.0 && longest.is_finite() { longest } else { 1.0 }
    }
}

/// Distances between the bodies that both lists have, with `offset` subtracted from the first.
fn distances<'a>(
    states: &'a [Sample],
    others: &'a [Sample],
    offset: Vector,
) -> impl Iterator<Item = Scalar> + 'a {
    paired(states, others)
        .filter_map(move |((_, x, _), other)| Some((*x - offset).distance(other?.1)))
}

/// The state of body `id`, if the list has it.
fn of(states: &[Sample], id: u32) -> Option<&Sample> {
    states.binary_search_by_key(&id, |(id, ..)| *id).ok().map(|at| &states[at])
}

/// Computes the numbers of a run of a row.
pub(super) struct Metric {
    measure: Measure,
    every: u64,
    /// Length of a run, ticks.
    pub ticks: u64,
    scale: Option<Scalar>,
    /// Stable id and mass, kg, of each movable body.
    masses: Vec<(u32, Scalar)>,
    /// Ends and rest length, m, of springs that have one.
    springs: Vec<([u32; 2], Scalar)>,
    /// Direction of gravity and terminal speed, m/s.
    terminal: (Vector, Scalar),
    offset: Vector,
    way: Scalar,
}

impl Metric {
    /// The metric of `row` in its `scene`, with a target if the measure needs one.
    pub fn new(scene: &Scene, row: &SurvivalRow, target: Option<&Target>) -> Self {
        let masses = movable(scene).filter_map(|(id, body)| Some((id, 1.0 / body.inverse_mass?)));
        let springs = scene.all_springs().map(|(ends, elastic)| (ends, elastic.rest_length));
        let gravity = scene.gravity.map_or(Vector::ZERO, |gravity| gravity.acceleration);
        let rate = scene.damping.map_or(0.0, |damping| damping.rate);
        Self {
            measure: row.measure,
            every: if row.measure == Measure::Energy {
                1
            } else {
                (row.ticks / LOOKS).clamp(1, EVERY)
            },
            ticks: row.ticks,
            scale: row.scale,
            masses: masses.collect(),
            springs: springs.filter(|(_, rest)| *rest > 0.0).collect(),
            terminal: (gravity.normalize_or_zero(), gravity.length() / rate),
            offset: if row.measure == Measure::Origin { row.offset } else { Vector::ZERO },
            way: target.map_or(1.0, Target::way),
        }
    }

    /// Whether a run is looked at after this number of ticks.
    pub fn is_look(&self, ticks: u64) -> bool {
        match self.measure {
            // Only the end counts.
            Measure::TerminalSpeed => ticks == self.ticks,
            // A run that ends with the prefix has a look there, and a longer one must have the same.
            Measure::Energy
            | Measure::Reference
            | Measure::Origin
            | Measure::Rest
            | Measure::Stretch => {
                ticks.is_multiple_of(self.every) || ticks == PREFIX || ticks == self.ticks
            }
        }
    }

    /// The number of a run at look number `look`, from 0.
    pub fn number(&self, run: &mut RowRun, target: Option<&Target>, look: usize) -> Scalar {
        match self.measure {
            Measure::Energy => self.energy(run),
            Measure::Reference | Measure::Origin => {
                let states = run.states();
                let there = target.and_then(|target| target.looks.get(look));
                let farthest =
                    |there: &Vec<Sample>| distances(&states, there, self.offset).fold(0.0, larger);
                there.map_or(Scalar::NAN, farthest) / self.way
            }
            Measure::Rest => {
                let states = run.states();
                let energy = self.moving(&states).map(|(mass, v)| 0.5 * mass * v.length_squared());
                energy.sum::<Scalar>() / self.scale.unwrap_or(1.0)
            }
            Measure::Stretch => self.stretch(&run.states()),
            Measure::TerminalSpeed => {
                let (down, speed) = self.terminal;
                let states = run.states();
                self.moving(&states).map(|(_, v)| v.dot(down) / speed - 1.0).fold(0.0, larger)
            }
        }
    }

    fn energy(&self, run: &RowRun) -> Scalar {
        let Some(ledger) = run.ledger() else { return Scalar::NAN };
        let start = ledger.energies_at_opening();
        let size = |energies: &Energies| energies.total().abs().max(energies.kinetic);
        // A run that begins without energy is measured relative to its present energy.
        let at_start = Some(size(start)).filter(|scale| *scale > 0.0);
        let scale = self.scale.or(at_start).unwrap_or_else(|| size(ledger.energies()));
        let residual = ledger.since_opening().energy.residual;
        // A run with neither energy nor residual is exact.
        if residual == 0.0 { 0.0 } else { residual / scale }
    }

    /// Mass, kg, and velocity, m/s, of every movable body that still exists.
    fn moving<'a>(&'a self, states: &'a [Sample]) -> impl Iterator<Item = (Scalar, Vector)> + 'a {
        self.masses.iter().filter_map(|(id, mass)| Some((*mass, of(states, *id)?.2)))
    }

    fn stretch(&self, states: &[Sample]) -> Scalar {
        let strains = self.springs.iter().filter_map(|([one, other], rest)| {
            let ((_, a, _), (_, b, _)) = (of(states, *one)?, of(states, *other)?);
            Some((a.distance(*b) / rest - 1.0).abs())
        });
        strains.fold(0.0, larger)
    }
}
