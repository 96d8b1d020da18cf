// The sky behind everything: a gradient from the direction of view, no image.

const ZENITH = vec3f(0.27, 0.45, 0.70);
const HORIZON = vec3f(0.79, 0.85, 0.89);
const GROUND = vec3f(0.62, 0.66, 0.69);
const NADIR = vec3f(0.33, 0.36, 0.39);

// Where nothing is up: from below to above.
const SPACE_LOW = vec3f(0.30, 0.34, 0.41);
const SPACE_HIGH = vec3f(0.36, 0.47, 0.62);

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

@fragment
fn fs_sky(in: Sky) -> @location(0) vec4f {
    return vec4f(stored(sky_color(normalize(in.direction).y)), 1.0);
}
