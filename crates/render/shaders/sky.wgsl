// The sky behind everything: a gradient from the direction of view, no image.

const ZENITH = vec3f(0.27, 0.45, 0.70);
const HORIZON = vec3f(0.79, 0.85, 0.89);
const GROUND = vec3f(0.62, 0.66, 0.69);
const NADIR = vec3f(0.33, 0.36, 0.39);

// Where nothing is up: from below to above, with stars.
const SPACE_LOW = vec3f(0.043, 0.063, 0.125);
const SPACE_HIGH = vec3f(0.078, 0.106, 0.188);
// Cells of the sky along the radius of a ball around the eye, and the share of those on the ball that have a star.
const CELLS = 40.0;
const WITH_STAR = 0.05;

struct Sky {
    @builtin(position) clip: vec4f,
    @location(0) direction: vec3f,
}

// A corner of a triangle that covers the view, on the far plane.
fn sky_corner(index: u32) -> Sky {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0;
    var out: Sky;
    out.clip = vec4f(corner, 1.0, 1.0);
    out.direction = globals.camera_forward.xyz
        + globals.camera_right.xyz * (corner.x * globals.camera_right.w)
        + globals.camera_up.xyz * (corner.y * globals.camera_up.w);
    return out;
}

@vertex
fn vs_sky(@builtin(vertex_index) index: u32) -> Sky {
    return sky_corner(index);
}

// In a direction that goes up by `height` of its length.
fn sky_color(height: f32) -> vec3f {
    if globals.picture.w > 1.0 {
        return vec3f(1.0);
    }
    let above = mix(HORIZON, ZENITH, smoothstep(0.0, 1.0, sqrt(max(height, 0.0))));
    let below = mix(GROUND, NADIR, smoothstep(0.0, 1.0, sqrt(max(-height, 0.0))));
    let with_horizon = mix(below, above, smoothstep(-0.01, 0.004, height));
    let without = mix(SPACE_LOW, SPACE_HIGH, 0.5 + 0.5 * height);
    return mix(with_horizon, without, globals.picture.z);
}

// Three numbers from 0 to 1 that are the same for a cell in every picture (Jarzynski and Olano 2020, PCG3D).
fn chance(cell: vec3f) -> vec3f {
    var v = vec3u(vec3i(cell)) * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> vec3u(16u);
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return vec3f(v >> vec3u(8u)) / 16777216.0;
}

// Light of the star in a direction of length 1: a spot of some pixels, whatever the angle of view.
fn star(toward: vec3f) -> f32 {
    let cell = floor(toward * CELLS);
    let place = chance(cell);
    let at = normalize(cell + 0.2 + 0.6 * place);
    let from_middle = distance(at, toward) / globals.viewport.z;
    let brightness = chance(cell + 7.0);
    return select(0.0, mix(0.08, 0.7, brightness.y * brightness.y * brightness.y) * clamp(1.3 - from_middle, 0.0, 1.0), brightness.x < WITH_STAR);
}

@fragment
fn fs_sky(in: Sky) -> @location(0) vec4f {
    let toward = normalize(in.direction);
    var color = sky_color(toward.y);
    if globals.picture.z > 0.0 && globals.picture.w < 2.0 {
        // So few levels of dark would show as bands: a part of a level goes to some of the pixels (Jimenez 2014).
        let dither = fract(52.9829189 * fract(dot(in.clip.xy, vec2f(0.06711056, 0.00583715)))) - 0.5;
        color += star(toward) + dither / 255.0;
    }
    return vec4f(stored(color), 1.0);
}
