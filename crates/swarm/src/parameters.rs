//! The uniform data of the shaders that step and draw swarms.

use bytemuck::{Pod, Zeroable};

use motion::{DampingModel, Method};

use crate::laws::SwarmLaws;
use crate::log::SwarmTick;

const HAS_DRAG: u32 = 1;
const REVERSED: u32 = 2;
const RESTARTED: u32 = 4;
const KEEPS_VELOCITY: u32 = 8;
const VELOCITY_VERLET: u32 = 16;
const BARREN: u32 = 32;

/// Mirrors `Tick` in crates/swarm/shaders/tick.wgsl, where the fields are explained.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct Parameters {
    constant: [f32; 3],
    rate: f32,
    source: [f32; 3],
    first_birth: f32,
    carried: [f32; 3],
    between: f32,
    mean: [f32; 3],
    linear: f32,
    across: [f32; 3],
    quadratic: f32,
    up: [f32; 3],
    phase: f32,
    wave: [f32; 3],
    turns: f32,
    births: [u32; 4],
    last_births: [u32; 4],
    dead: [u32; 2],
    length: f32,
    substeps: f32,
    last_first_birth: f32,
    last_between: f32,
    last_length: f32,
    last_substeps: f32,
    damping_rate: f32,
    damping: u32,
    flags: u32,
    wells: u32,
    pub substep: u32,
    slots: u32,
    _pad: [u32; 2],
    well: [[f32; 8]; SwarmLaws::WELLS],
}

/// The generation and the slot of particle number `number`: quotient and remainder by `slots`.
fn particle(number: u64, slots: u32) -> [u32; 2] {
    let slots = u64::from(slots.max(1));
    [(number / slots) as u32, (number % slots) as u32]
}

fn births([first, after]: [u64; 2], slots: u32) -> [u32; 4] {
    let ([a, b], [c, d]) = (particle(first, slots), particle(after, slots));
    [a, b, c, d]
}

/// The number of a model of damping in the shaders; 0 stands for no damping.
const fn number(model: DampingModel) -> u32 {
    match model {
        // Part of the rate of linear drag.
        DampingModel::Exact => 0,
        DampingModel::Tutorial => 1,
        DampingModel::Clamped => 2,
        DampingModel::Implicit => 3,
    }
}

impl Parameters {
    /// The parameters of a tick of a swarm of `slots` slots, after the tick `last`.
    pub fn new(method: Method, slots: u32, tick: &SwarmTick, last: Option<&SwarmTick>) -> Self {
        let last_births = last.map_or([0; 4], |last| births(last.births, slots));
        let last = last.unwrap_or(tick);
        let mut parameters = Self {
            source: tick.source,
            first_birth: tick.first_birth,
            carried: tick.carried,
            between: tick.between,
            births: births(tick.births, slots),
            last_births,
            dead: particle(tick.dead, slots),
            length: tick.step,
            substeps: tick.substeps as f32,
            last_first_birth: last.first_birth,
            last_between: last.between,
            last_length: last.step,
            last_substeps: last.substeps as f32,
            slots,
            ..Self::zeroed()
        }
        .under(&tick.laws, tick.phase);
        for (is, flag) in [
            (tick.reversed, REVERSED),
            (tick.other_laws, RESTARTED),
            (!tick.born, BARREN),
            (method != Method::PositionVerlet, KEEPS_VELOCITY),
            (method == Method::VelocityVerlet, VELOCITY_VERLET),
        ] {
            parameters.flags |= if is { flag } else { 0 };
        }
        parameters
    }

    /// The same parameters under these laws; `phase` is the phase of gusts at the start of the tick.
    pub fn under(mut self, laws: &SwarmLaws, phase: f32) -> Self {
        let SwarmLaws { constant, rate, drag, wind, wells, damping } = laws;
        (self.constant, self.rate, self.phase) = (*constant, *rate, phase);
        [self.linear, self.quadratic, self.turns] = drag.unwrap_or_default();
        [self.mean, self.across, self.up, self.wave] = *wind;
        self.flags = self.flags & !HAS_DRAG | if drag.is_some() { HAS_DRAG } else { 0 };
        (self.damping, self.damping_rate) =
            damping.map_or((0, 0.0), |(model, rate)| (number(model), rate));
        let wells = &wells[..wells.len().min(SwarmLaws::WELLS)];
        self.wells = wells.len() as u32;
        for (row, [x, y, z, strength, softening]) in self.well.iter_mut().zip(wells) {
            *row = [*x, *y, *z, *strength, *softening, 0.0, 0.0, 0.0];
        }
        self
    }
}
