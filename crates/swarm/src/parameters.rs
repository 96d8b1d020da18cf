//! The uniform data of the shaders that step and draw swarms.

use bytemuck::{Pod, Zeroable};

use crate::swarm_tick::{SwarmLaws, SwarmLook, SwarmStepping, SwarmTick};

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
    substep: u32,
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

impl Parameters {
    /// The parameters of a tick of a swarm of `slots` slots, after the tick `last`.
    pub fn new(
        stepping: SwarmStepping,
        slots: u32,
        tick: &SwarmTick,
        last: Option<&SwarmTick>,
    ) -> Self {
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
        };
        parameters.act(&tick.laws, tick.phase);
        parameters.flags |= match stepping {
            SwarmStepping::PositionVerlet => 0,
            SwarmStepping::SemiImplicitEuler => KEEPS_VELOCITY,
            SwarmStepping::VelocityVerlet => KEEPS_VELOCITY | VELOCITY_VERLET,
        };
        for (is, flag) in
            [(tick.reversed, REVERSED), (tick.other_laws, RESTARTED), (!tick.born, BARREN)]
        {
            parameters.flags |= if is { flag } else { 0 };
        }
        parameters
    }

    /// The same parameters with the laws of another tick; `phase` is the phase of gusts at its start.
    pub fn under(mut self, laws: &SwarmLaws, phase: f32) -> Self {
        self.act(laws, phase);
        self
    }

    /// The same parameters for a substep of the tick.
    pub fn at(mut self, substep: u32) -> Self {
        self.substep = substep;
        self
    }

    fn act(&mut self, laws: &SwarmLaws, phase: f32) {
        let SwarmLaws { constant, rate, drag, air, wave, turns, wells, damping } = laws;
        (self.constant, self.rate, self.phase) = (*constant, *rate, phase);
        [self.mean, self.across, self.up] = *air;
        (self.wave, self.turns) = (*wave, *turns);
        [self.linear, self.quadratic] = drag.unwrap_or_default();
        self.flags = self.flags & !HAS_DRAG | if drag.is_some() { HAS_DRAG } else { 0 };
        (self.damping, self.damping_rate) =
            damping.map_or((0, 0.0), |(model, rate)| (model as u32, rate));
        let wells = &wells[..wells.len().min(SwarmLaws::WELLS)];
        self.wells = wells.len() as u32;
        for (row, [x, y, z, strength, softening]) in self.well.iter_mut().zip(wells) {
            *row = [*x, *y, *z, *strength, *softening, 0.0, 0.0, 0.0];
        }
    }
}

/// Mirrors `Look` in crates/swarm/shaders/draw.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(crate) struct LookParameters {
    anchor: [f32; 3],
    radius: f32,
    color: [f32; 4],
    back: f32,
    exposure: f32,
    life: f32,
    fades_in: f32,
}

impl From<SwarmLook> for LookParameters {
    fn from(look: SwarmLook) -> Self {
        let SwarmLook { anchor, radius_m, color, back, exposure_s, life_s, fades_in } = look;
        Self { anchor, radius: radius_m, color, back, exposure: exposure_s, life: life_s, fades_in }
    }
}
