// A substep of a swarm, one particle per invocation.
//
// Position Verlet reads two positions and writes one: where the last position was, the next one is written, and the two buffers
// change roles. Its velocity is (x - last) / (length of a substep), half a step old. A short step would lose the velocity in the
// digits of the positions: after one, of a particle that is born within the tick or of all, the last position is placed as if the
// step had been a standard one.

@group(0) @binding(0) var<uniform> tick: Tick;
@group(0) @binding(1) var<storage, read_write> positions: array<vec4u>;
// Last positions, or velocities.
@group(0) @binding(2) var<storage, read_write> others: array<vec4u>;
@group(0) @binding(3) var<storage, read> launches: array<f32>;

struct State {
    x: vec3f,
    v: vec3f,
}

const PI = 3.14159265358979;

// WGSL allows its own sine an error of 2^-11; this one is exact to some 2e-7.
fn sine(angle: f32) -> f32 {
    let turns = round(angle * 0.15915494);
    // 2 pi in two parts, so that the angle keeps its digits.
    let a = (angle - turns * 6.28125) - turns * 1.9353072e-3;
    let b = select(a, PI - a, a > 0.5 * PI);
    let c = select(b, -PI - b, b < -0.5 * PI);
    let s = c * c;
    return c * (1.0 + s * (-0.16666667 + s * (8.3333310e-3 + s * (-1.9840874e-4 + s * (2.7525562e-6 - s * 2.3889859e-8)))));
}

fn acceleration(x: vec3f, v: vec3f, time: f32) -> vec3f {
    var a = tick.constant - v * tick.rate;
    if (tick.flags & HAS_DRAG) != 0u {
        let phase = (tick.phase + tick.turns * time) - dot(x, tick.wave);
        let air = tick.mean + tick.across * sine(phase) + tick.up * (0.5 * sine(phase + phase));
        let u = v - air;
        a -= u * (tick.linear + tick.quadratic * sqrt(dot(u, u)));
    }
    for (var i = 0u; i < tick.wells; i++) {
        let well = tick.well[i];
        let r = x - well.position;
        let squared = dot(r, r) + well.softening * well.softening;
        // In the middle of a well without softening there is no force.
        let inverse = select(inverseSqrt(max(squared, 1e-30)), 0.0, squared == 0.0);
        a -= r * (well.strength * inverse * inverse * inverse);
    }
    return a;
}

// What damping multiplies the velocity by in `h` seconds, if the model does so before (false) or after (true) the move.
fn damped(h: f32, after_move: bool) -> f32 {
    let q = tick.damping_rate * h;
    if tick.damping == 1u && after_move {
        return 1.0 - q;
    }
    if tick.damping == 2u && !after_move {
        return max(1.0 - q, 0.0);
    }
    if tick.damping == 3u && !after_move {
        return 1.0 / (1.0 + q);
    }
    return 1.0;
}

fn is_finite(vector: vec3f) -> bool {
    // By bits: a shader may assume that no number is infinite.
    let exponents = bitcast<vec3u>(vector) & vec3u(0x7f800000u);
    return all(exponents != vec3u(0x7f800000u));
}

// The particle in a slot during this tick, with what is stored of it.
struct Particle {
    generation: u32,
    // When it is born, if in this tick.
    birth: f32,
    is_new: bool,
    x: vec3f,
    other: vec3f,
}

fn particle_in(slot: u32) -> Particle {
    let stored = positions[slot];
    var p: Particle;
    p.generation = stored.w;
    p.x = bitcast<vec3f>(stored.xyz);
    p.other = bitcast<vec3f>(others[slot].xyz);
    // The last particle of this slot that is born before the end of the tick.
    let newest = tick.births.z - select(1u, 0u, slot < tick.births.w);
    let some = tick.births.z > 0u || slot < tick.births.w;
    p.is_new = some && before(tick.births.xy, tick.births.zw) && !before(vec2u(newest, slot), tick.births.xy);
    if p.is_new {
        let generation = newest + 1u;
        // One that failed in this tick stays away.
        if tick.substep == 0u || p.generation == generation {
            p.generation = generation;
        } else {
            p.generation = 0u;
        }
        p.birth = birth_in(tick.births, tick.first_birth, tick.between, tick.slots, generation, slot);
        p.birth = min(p.birth, tick.length);
    } else if p.generation == 0u || before(vec2u(p.generation - 1u, slot), tick.dead) {
        p.generation = 0u;
    }
    return p;
}

// By how much time the last position lies back.
fn stored_back() -> f32 {
    if tick.substep > 0u {
        return standard(tick.length / tick.substeps);
    }
    return standard(tick.last_length / tick.last_substeps);
}

// The length of the last step that the particle took, which is not its first.
fn last_step(p: Particle, slot: u32, h: f32) -> f32 {
    if tick.substep > 0u {
        return h;
    }
    let birth = birth_in(tick.last_births, tick.last_first_birth, tick.last_between, tick.slots, p.generation, slot);
    return (tick.last_length - min(birth, tick.last_length)) / tick.last_substeps;
}

@compute @workgroup_size(64)
fn step(@builtin(global_invocation_id) id: vec3u) {
    let slot = id.x;
    if slot >= tick.slots {
        return;
    }
    let p = particle_in(slot);
    if p.generation == 0u {
        return;
    }
    if p.is_new && (tick.flags & BARREN) != 0u {
        positions[slot] = vec4u(0u);
        others[slot] = vec4u(0u);
        return;
    }
    let keeps_velocity = (tick.flags & KEEPS_VELOCITY) != 0u;
    let is_born = p.is_new && tick.substep == 0u;
    let h = (tick.length - p.birth) / tick.substeps;
    let time = p.birth + f32(tick.substep) * h;
    let sign = select(1.0, -1.0, (tick.flags & REVERSED) != 0u && tick.substep == 0u);
    var last = 0.0;
    var at: State;
    if is_born {
        let launch = vec3f(launches[3u * slot], launches[3u * slot + 1u], launches[3u * slot + 2u]);
        at = State(tick.source + tick.carried * p.birth, launch + tick.carried);
    } else if keeps_velocity {
        at = State(p.x, p.other * sign);
    } else {
        at = State(p.x, (p.x - p.other) * (sign / stored_back()));
        let restarted = (tick.flags & RESTARTED) != 0u && tick.substep == 0u;
        last = select(sign * last_step(p, slot, h), 0.0, restarted);
    }
    let is_first = tick.substep == 0u;
    let is_last = f32(tick.substep + 1u) == tick.substeps;
    let inside = keeps_velocity && (tick.flags & VELOCITY_VERLET) == 0u;
    if !inside && is_first {
        at.v *= damped(h * tick.substeps, false);
    }
    let a = acceleration(at.x, at.v, time);
    var next: State;
    if inside {
        // Semi-implicit Euler.
        let v = (at.v + a * h) * damped(h, false);
        next = State(at.x + v * h, v * damped(h, true));
    } else if keeps_velocity {
        // Velocity Verlet.
        let x = at.x + (at.v + a * (0.5 * h)) * h;
        let b = acceleration(x, at.v + a * h, time + h);
        next = State(x, at.v + (a + b) * (0.5 * h));
    } else {
        // Position Verlet.
        let v = at.v + a * (0.5 * (h + last));
        next = State(at.x + v * h, v);
    }
    var after = 1.0;
    if !inside && is_last {
        after = damped(h * tick.substeps, true);
        next.v *= after;
    }
    if !is_finite(next.x) || !is_finite(next.v) {
        positions[slot] = vec4u(0u);
        others[slot] = vec4u(0u);
        return;
    }
    if keeps_velocity {
        positions[slot] = vec4u(bitcast<vec3u>(next.x), p.generation);
        others[slot] = vec4u(bitcast<vec3u>(next.v), p.generation);
        return;
    }
    // The buffers change roles after the step.
    others[slot] = vec4u(bitcast<vec3u>(next.x), p.generation);
    let usual = tick.length / tick.substeps;
    if p.is_new || after != 1.0 || usual < SHORTEST {
        let placed = next.x - next.v * standard(usual);
        positions[slot] = vec4u(bitcast<vec3u>(placed), p.generation);
    }
}

// Brings the velocities of position Verlet to the time of the positions, under the laws of the tick before.
@compute @workgroup_size(64)
fn synchronize(@builtin(global_invocation_id) id: vec3u) {
    let slot = id.x;
    if slot >= tick.slots {
        return;
    }
    let p = particle_in(slot);
    if p.generation == 0u || p.is_new {
        return;
    }
    let length = stored_back();
    let v = (p.x - p.other) / length;
    let a = acceleration(p.x, v, tick.last_length);
    let synchronized = v + a * (0.5 * last_step(p, slot, 0.0));
    others[slot] = vec4u(bitcast<vec3u>(p.x - synchronized * length), p.generation);
}
