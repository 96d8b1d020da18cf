// A sky with a ground below: a plane with lines that fades into the horizon. It takes shadows, and hides what is below it.

const PLAIN = vec3f(0.56, 0.59, 0.61);
const LINE_ON_GROUND = vec3f(0.40, 0.43, 0.46);
const SOFT_PLAIN = vec3f(0.80, 0.82, 0.83);
const SOFT_LINE = vec3f(0.66, 0.69, 0.72);
const SOFT_FAR = vec3f(0.80, 0.85, 0.88);
// What is left of the light in shadow.
const IN_SHADOW = 0.72;
// The distance at which half of the ground has faded, in spacings of its lines.
const HALF_FADED = 25.0;

// How much farther away the ground counts as: what is drawn on it, or in its place, is in front of it.
const GIVES_WAY = 1.0008;

// The plane as far as the far plane. Its depth is linear on the screen.
@vertex
fn vs_plain(@builtin(vertex_index) index: u32) -> Sky {
    var out = sky_corner(index);
    let constant = globals.viewport.w;
    let depth = constant * out.direction.y / (GIVES_WAY * globals.ground.x) - constant / globals.camera_forward.w;
    out.clip = vec4f(out.clip.xy, depth, 1.0);
    return out;
}

@fragment
fn fs_ground(in: Sky) -> @location(0) vec4f {
    let toward = normalize(in.direction);
    let sky = sky_color(toward.y);
    let away = globals.ground.x / min(toward.y, -1e-4);
    let place = (toward.xz * away + globals.ground.zw) / globals.ground.y;
    let width = max(fwidth(place), vec2f(1e-5));
    let from_line = abs(fract(place - 0.5) - 0.5) / width;
    // Lines closer together than pixels are left out.
    let lines = clamp(1.5 - from_line, vec2f(0.0), vec2f(1.0)) * clamp(1.0 - 4.0 * width, vec2f(0.0), vec2f(1.0));
    let soft = globals.picture.w > 0.0;
    let paper = globals.picture.w > 1.0;
    let plain = select(select(PLAIN, SOFT_PLAIN, soft), vec3f(1.0), paper);
    var color = mix(plain, select(LINE_ON_GROUND, SOFT_LINE, soft), max(lines.x, lines.y));

    let point = toward * away;
    let facing_light = normalize(globals.light_position.xyz - point).y;
    let lit = light_reaching(point, vec3f(0.0, 1.0, 0.0), facing_light) / LIT;
    color *= select(1.0, mix(IN_SHADOW, 1.0, lit), facing_light > 0.0);

    let faded = away / (away + HALF_FADED * globals.ground.y);
    return vec4f(stored(select(sky, mix(color, select(select(GROUND, SOFT_FAR, soft), vec3f(1.0), paper), faded), toward.y < 0.0)), 1.0);
}
