// The particles of a swarm as sprites, drawn from the buffers in which they are stepped.

struct Look {
    anchor: vec3f,  // relative to the camera
    radius: f32,
    color: vec4f,
    back: f32,      // how much of the last tick lies between the picture and its end, 0 to 1
    exposure: f32,  // the streak is the path of this many seconds
    life: f32,
    fades_in: f32,  // the last share of a life in which a particle fades away
}

@group(2) @binding(0) var<uniform> tick: Tick;
@group(2) @binding(1) var<uniform> look: Look;

struct Stored {
    @location(0) position: vec4u,
    @location(1) other: vec4u,
}

@vertex
fn vs_swarm(@builtin(vertex_index) index: u32, @builtin(instance_index) slot: u32, stored: Stored) -> Spot {
    var nowhere: Spot;
    nowhere.clip = vec4f(0.0, 0.0, 2.0, 1.0);
    let generation = stored.position.w;
    if generation == 0u || before(vec2u(generation - 1u, slot), tick.dead) {
        return nowhere;
    }
    let particle = vec2u(generation - 1u, slot);
    let birth = birth_in(tick.births, tick.first_birth, tick.between, tick.slots, generation, slot);
    let lived = tick.length - birth;
    let x = bitcast<vec3f>(stored.position.xyz);
    let other = bitcast<vec3f>(stored.other.xyz);
    let v = select((x - other) / standard(tick.length / tick.substeps), other, (tick.flags & KEEPS_VELOCITY) != 0u);
    let position = look.anchor + (x - v * (lived * look.back));
    // By how many births it is older than the first of the tick.
    let later = f32(i32(tick.births.x - particle.x)) * f32(tick.slots) + (f32(tick.births.y) - f32(particle.y));
    let age = tick.length * (1.0 - look.back) - tick.first_birth + later * tick.between;
    let fade = clamp((1.0 - age / look.life) / look.fades_in, 0.0, 1.0);
    var sprite: Sprite;
    sprite.position = position;
    sprite.radius = look.radius;
    sprite.streak = v * look.exposure;
    sprite.color = vec4f(look.color.rgb, look.color.a * fade);
    return spot(index, sprite);
}
