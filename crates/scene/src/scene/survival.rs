//! Hard cases: how a scene is run in the survival matrix, and the bounds on its numbers.

use glam::DVec3;
use motion::Damping;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::action::Step;
use crate::random::symmetric;
use crate::substepping::Substepping;

/// One row of the survival matrix: a run of the scene that every method makes.
#[derive(Clone, Debug, PartialEq)]
pub struct SurvivalRow {
    /// Distinguishes the row from the others of the scene; empty for a single row.
    pub label: String,
    /// The quantity that is measured.
    pub measure: Measure,
    /// Length of the run, ticks, at least 1.
    pub ticks: u64,
    /// Bounds on the number.
    pub bounds: Bounds,
    /// Energy that [`Measure::Energy`] and [`Measure::Rest`] are relative to, J, above 0, if the scene gives it.
    pub scale: Option<f64>,
    /// Substeps of the fine run that [`Measure::Reference`] compares with.
    pub reference_substeps: u32,
    /// Lengths of the ticks.
    pub steps: TickLengths,
    /// Ticks per second; overrides the scene.
    pub step_hz: f64,
    /// Substeps; override those of the scene.
    pub substeps: Substepping,
    /// Damping; overrides the scene.
    pub damping: Option<Damping>,
    /// Vector by which everything is moved away from the origin, m.
    pub offset: DVec3,
    /// Changes of the run, at seconds or ticks.
    pub script: Vec<Step>,
}

/// The quantity that a row measures. All of them are relative, without a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Measure {
    /// Energy that the method invented (positive) or lost (negative) since the start, by the ledger, relative to the
    /// larger of energy and kinetic energy at the start, or to a stated one.
    Energy,
    /// Largest distance of a body from its position in a fine run, relative to the largest distance of a body from
    /// its start there.
    Reference,
    /// Largest distance of a body from its position in a run of the same method at the origin, relative as above.
    Origin,
    /// Kinetic energy of what should be at rest, relative to a stated energy.
    Rest,
    /// Largest strain of a spring, `|L / L0 - 1|`; springs without a rest length do not count.
    Stretch,
    /// Velocity along gravity at the end of the run, relative to the terminal one g / c, minus 1: -1 for a body at
    /// rest, below -1 for a body that rises. The number of the largest magnitude, if there are several bodies.
    TerminalSpeed,
}

impl Measure {
    /// All measures.
    pub const ALL: [Self; 6] = [
        Self::Energy,
        Self::Reference,
        Self::Origin,
        Self::Rest,
        Self::Stretch,
        Self::TerminalSpeed,
    ];

    /// Its name in scene files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Energy => "energy",
            Self::Reference => "reference",
            Self::Origin => "origin",
            Self::Rest => "rest",
            Self::Stretch => "stretch",
            Self::TerminalSpeed => "terminal_speed",
        }
    }
}

/// Bounds on the magnitude of a number: `exact <= bounded < explodes`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Up to this magnitude a run is as exact as rounding allows.
    pub exact: f64,
    /// Up to this magnitude a run is useful.
    pub bounded: f64,
    /// Above this magnitude a run has exploded.
    pub explodes: f64,
}

/// The lengths of the ticks of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum TickLengths {
    /// `1 / step_hz` seconds each.
    #[default]
    Constant,
    /// Each of its own length, drawn evenly from `1 - spread` to `1 + spread` times the constant one.
    Jittered {
        /// Above 0, below 1.
        spread: f64,
        /// Seed of the draws.
        seed: u64,
    },
    /// One tick, the first that begins at that time or later, lasts longer.
    Hitch {
        /// Time of the tick, s.
        at: f64,
        /// Its length, s, above 0.
        length: f64,
    },
}

/// The lengths of the ticks of a row, one after the other.
#[derive(Clone, Debug)]
pub struct Lengths {
    steps: TickLengths,
    step: f64,
    random: Pcg64,
    ticks: u32,
    done: bool,
}

impl Iterator for Lengths {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        let begins = f64::from(self.ticks) * self.step;
        self.ticks = self.ticks.saturating_add(1);
        Some(match self.steps {
            TickLengths::Constant => self.step,
            TickLengths::Jittered { spread, .. } => {
                self.step * (1.0 + spread * symmetric(&mut self.random))
            }
            // The ticks before it are constant, so rounding must not move it by one.
            TickLengths::Hitch { at, length } if !self.done && begins >= at - 1e-9 * self.step => {
                self.done = true;
                length
            }
            TickLengths::Hitch { .. } => self.step,
        })
    }
}

impl SurvivalRow {
    /// Lengths of its ticks, s; the iterator never ends.
    #[must_use]
    pub fn lengths(&self) -> Lengths {
        let seed = if let TickLengths::Jittered { seed, .. } = self.steps { seed } else { 0 };
        let random = Pcg64::seed_from_u64(seed);
        Lengths { steps: self.steps, step: 1.0 / self.step_hz, random, ticks: 0, done: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn row(steps: TickLengths) -> SurvivalRow {
        let text = "(version: 1, step_hz: 10, bodies: [(mass_kg: 1)], wells: [(strength_m3_s2: 1)],
            expect: (survival: (measure: reference, ticks: 5, bounded_below: 1, offset_m: (0, 7, 0))))";
        SurvivalRow { steps, ..Scene::parse("t", text).unwrap().survival.unwrap().remove(0) }
    }

    #[test]
    fn ticks_have_the_lengths_that_are_asked_for() {
        let lengths = |steps| row(steps).lengths().take(1000).collect::<Vec<_>>();
        assert!(lengths(TickLengths::Constant).iter().all(|length| *length == 0.1));
        let hitch = lengths(TickLengths::Hitch { at: 0.3, length: 1.0 });
        assert_eq!(hitch[..5], [0.1, 0.1, 0.1, 1.0, 0.1]);
        let jittered = |seed| lengths(TickLengths::Jittered { spread: 0.5, seed });
        assert!(jittered(1).iter().all(|length| (0.05..0.15).contains(length)));
        assert!(
            jittered(1).iter().any(|length| *length < 0.06)
                && jittered(1).iter().any(|l| *l > 0.14)
        );
        assert_eq!(jittered(1), jittered(1));
        assert_ne!(jittered(1), jittered(2));
    }

    #[test]
    fn an_offset_moves_everything() {
        let row = row(TickLengths::Constant);
        let text = "(version: 1, bodies: [(position_m: (1, 0, 0), method: runge_kutta_4)], wells: [(strength_m3_s2: 1)],
            emitters: [(rate_per_s: 1, life_s: 1, speed_m_s: 1)])";
        let moved = row.scene(&Scene::parse("t", text).unwrap());
        assert_eq!(moved.bodies[0].position, DVec3::new(1.0, 7.0, 0.0));
        assert_eq!(moved.laws.wells.unwrap().0[0].position, DVec3::new(0.0, 7.0, 0.0));
        assert_eq!(moved.emitters[0].position, DVec3::new(0.0, 7.0, 0.0));
        assert_eq!((moved.step_hz, moved.bodies[0].method), (10.0, None));
    }
}
