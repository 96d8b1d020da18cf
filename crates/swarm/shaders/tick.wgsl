// What a tick does to a swarm; prepended to the shaders that step and draw it. Mirrors `Parameters` in parameters.rs.
// Positions are in meters from the swarm's anchor, times in seconds from the start of the tick.
//
// Particle number k is in slot k mod n of n. Where a tick names a particle, it gives the quotient and the slot, so that numbers
// may exceed 32 bits. A slot stores the quotient plus 1; 0 is a slot without a particle.

struct Tick {
    constant: vec3f,
    rate: f32,              // a = constant - rate v
    source: vec3f,
    first_birth: f32,       // when particle `births.xy` is born
    carried: vec3f,
    between: f32,           // from birth to birth
    mean: vec3f,
    linear: f32,            // drag: a = -(linear + quadratic |u|) u with u = v - air
    across: vec3f,
    quadratic: f32,
    up: vec3f,
    phase: f32,             // of gusts, at the anchor and the start of the tick
    wave: vec3f,
    turns: f32,             // rad/s
    births: vec4u,          // the first particle that is due in the tick, and the first after it that is not
    last_births: vec4u,     // those of the tick before
    dead: vec2u,            // particles below this one are dead
    length: f32,            // of the tick
    substeps: f32,
    last_first_birth: f32,  // of the tick before
    last_between: f32,
    last_length: f32,
    last_substeps: f32,
    damping_rate: f32,
    damping: u32,           // 0 none, 1 tutorial, 2 clamped, 3 implicit
    flags: u32,
    wells: u32,
    substep: u32,
    slots: u32,
    pad_a: u32,
    pad_b: u32,
    well: array<Well, 64>,
}

struct Well {
    position: vec3f,
    strength: f32,
    softening: f32,
    pad_x: f32,
    pad_y: f32,
    pad_z: f32,
}

const HAS_DRAG = 1u;
// Velocities are reversed before the tick.
const REVERSED = 2u;
// The velocity of position Verlet is that at the time of the position.
const RESTARTED = 4u;
// Keeps a position and a velocity, not two positions.
const KEEPS_VELOCITY = 8u;
const VELOCITY_VERLET = 16u;
// The slots of those that are due are free: none of them is born.
const BARREN = 32u;

// The least time between two positions that are stored, s: of two that are nearer, their digits would say no velocity.
const SHORTEST = 1e-3;

// By how much time the last position of a particle lies back, after a substep of `h` seconds.
fn standard(h: f32) -> f32 {
    return max(h, SHORTEST);
}

// Whether particle a comes before particle b.
fn before(a: vec2u, b: vec2u) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// When the particle with that quotient in `slot` is born, if it is one of `births`; else 0. Counted from the tick that has them.
fn birth_in(births: vec4u, first: f32, between: f32, slots: u32, generation: u32, slot: u32) -> f32 {
    let particle = vec2u(generation - 1u, slot);
    if generation == 0u || before(particle, births.xy) || !before(particle, births.zw) {
        return 0.0;
    }
    let number = (particle.x - births.x) * slots + particle.y - births.y;
    return max(first + f32(number) * between, 0.0);
}
