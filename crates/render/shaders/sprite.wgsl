// Sprites: soft, unlit discs that face the camera, drawn out along the way that they move.

struct Sprite {
    @location(0) position: vec3f,
    @location(1) radius: f32,
    @location(2) streak: vec3f,
    @location(3) color: vec4f,
}

struct Spot {
    @builtin(position) clip: vec4f,
    // On the sprite in radii, x along the streak, and half the length of the streak.
    @location(0) place_and_half: vec3f,
    @location(1) color: vec4f,
}

// Opacity of what the ground hides.
const HIDDEN = 0.25;

@vertex
fn vs_sprite(@builtin(vertex_index) index: u32, sprite: Sprite) -> Spot {
    return spot(index, sprite);
}

fn spot(index: u32, sprite: Sprite) -> Spot {
    let corner = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    // A soft edge takes half of a small sprite away: none is smaller than a pixel.
    let pixel = globals.viewport.z * max(dot(sprite.position, globals.camera_forward.xyz), 0.0);
    let radius = max(sprite.radius, pixel);
    let seen = vec2f(dot(sprite.streak, globals.camera_right.xyz), dot(sprite.streak, globals.camera_up.xyz));
    let way = length(seen);
    let along = select(vec2f(1.0, 0.0), seen / max(way, 1e-9), way > 1e-9);
    let half = 0.5 * way / radius;
    let place = vec2f(corner.x * (1.0 + half), corner.y);
    let flat = (along * place.x + vec2f(-along.y, along.x) * place.y) * radius;
    // The streak ends where the sprite is.
    let middle = sprite.position - 0.5 * sprite.streak;
    let position = middle + globals.camera_right.xyz * flat.x + globals.camera_up.xyz * flat.y;
    var out: Spot;
    let is_hidden = on_ground(sprite.position).y != sprite.position.y;
    let clip = globals.view_projection * vec4f(select(position, on_ground(position), is_hidden), 1.0);
    out.clip = select(clip, pulled_nearer(clip, 0.001 * clip.w), is_hidden);
    out.place_and_half = vec3f(place, half);
    // As much light as it really sends, so that many small ones stay many, but no less than the 8 bits of a channel keep.
    out.color = vec4f(sprite.color.rgb, sprite.color.a * clamp(sprite.radius / pixel, 0.04, 1.0) * select(1.0, HIDDEN, is_hidden));
    return out;
}

@fragment
fn fs_sprite(in: Spot) -> @location(0) vec4f {
    let beyond = max(abs(in.place_and_half.x) - in.place_and_half.z, 0.0);
    let from_middle = length(vec2f(beyond, in.place_and_half.y));
    let coverage = 1.0 - smoothstep(0.4, 1.0, from_middle);
    let color = in.color.rgb * (1.0 - 0.3 * from_middle * from_middle);
    return vec4f(stored(color), in.color.a * coverage);
}
