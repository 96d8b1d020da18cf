// Particles: camera-facing quads shaded as round discs.

struct Particle {
    @location(0) position: vec3f,
    @location(1) radius: f32,
    @location(2) color: vec4f,
}

struct Disc {
    @builtin(position) clip: vec4f,
    @location(0) place: vec2f, // on the disc, radius 1
    @location(1) position: vec3f,
    // Linear.
    @location(2) albedo: vec4f,
}

@vertex
fn vs_particle(@builtin(vertex_index) index: u32, particle: Particle) -> Disc {
    let place = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    // Below three quarters of a pixel a particle would flicker in and out of existence.
    let pixel = globals.viewport.z * max(dot(particle.position, globals.camera_forward.xyz), 0.0);
    let radius = max(particle.radius, 0.75 * pixel);
    let offset = globals.camera_right.xyz * place.x + globals.camera_up.xyz * place.y;
    var out: Disc;
    out.position = particle.position + offset * radius;
    out.clip = globals.view_projection * vec4f(out.position, 1.0);
    out.place = place;
    out.albedo = vec4f(albedo_of(particle.color.rgb), particle.color.a);
    return out;
}

@fragment
fn fs_particle(in: Disc) -> @location(0) vec4f {
    let from_center = length(in.place);
    let width = max(fwidth(from_center), 1e-4);
    let coverage = clamp((1.0 - from_center) / width + 0.5, 0.0, 1.0);
    if coverage < 0.02 {
        discard;
    }
    let bulge = sqrt(max(1.0 - from_center * from_center, 0.0));
    let normal = normalize(globals.camera_right.xyz * in.place.x
        + globals.camera_up.xyz * in.place.y
        - globals.camera_forward.xyz * max(bulge, 0.05));
    return vec4f(stored(shaded(in.position, normal, in.albedo.rgb)), in.albedo.a * coverage);
}
