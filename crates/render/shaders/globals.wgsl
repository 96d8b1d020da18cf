// What every shader knows about the frame; prepended to each of the others. Mirrors `Globals` in renderer.rs.
// All positions are in meters relative to the camera, which is the origin.

struct Globals {
    view_projection: mat4x4f,
    light_projection: mat4x4f,
    camera_right: vec4f,    // w: tangent of half the horizontal field of view
    camera_up: vec4f,       // w: tangent of half the vertical field of view
    camera_forward: vec4f,  // w: near plane, m
    viewport: vec4f,        // xy: size in pixels, z: meters a pixel spans at 1 m, w: constant term of clip z
    light_position: vec4f,  // w: 1 = casts shadows
    light_color: vec4f,     // w: 1 = a point light, 0 = the head light
    shadow_map: vec4f,      // x: size of a texel in uv, y: meters a texel spans at 1 m from the light
    picture: vec4f,         // xy: size of the whole picture with its panels, points; z: 1 = a sky without a horizon; w: 1 = soft light, matte bodies, 2 = and for paper
    ground: vec4f,          // x: height, m; y: meters from line to line; zw: where the camera is between the lines, m
}

@group(0) @binding(0) var<uniform> globals: Globals;

// A target with an sRGB format encodes once more on store, so what it is given has to be decoded first.
override target_is_srgb: bool = false;

fn stored(display: vec3f) -> vec3f {
    if !target_is_srgb {
        return display;
    }
    let low = display / 12.92;
    let high = pow((display + 0.055) / 1.055, vec3f(2.4));
    return select(high, low, display <= vec3f(0.04045));
}

// A point below the ground at the place on it that hides the point, which is seen at the same place.
fn on_ground(point: vec3f) -> vec3f {
    let height = globals.ground.x;
    return point * select(1.0, height / point.y, height < 0.0 && point.y < height);
}

// Depth as if the point were `meters` nearer to the camera, its place on the screen unchanged.
fn pulled_nearer(clip: vec4f, meters: f32) -> vec4f {
    let distance = max(clip.w - meters, globals.camera_forward.w);
    let z = clip.z + globals.viewport.w * (clip.w / distance - 1.0);
    return vec4f(clip.xy, z, clip.w);
}

// Pixels of a soft edge at either side of it.
const REACH = 1.5;

// Pixels from the middle of the view.
fn on_screen(clip: vec4f) -> vec2f {
    return 0.5 * globals.viewport.xy * clip.xy / clip.w;
}

// The direction to the left of the way between two places on the screen, a unit vector.
fn leftward(start: vec2f, end: vec2f) -> vec2f {
    let toward = normalize(end - start + vec2f(1e-6, 0.0));
    return vec2f(-toward.y, toward.x);
}

// A point moved on the screen by `pixels`, and in front of the surface on which it lies.
fn beside(clip: vec4f, pixels: vec2f) -> vec4f {
    let moved = clip + vec4f(pixels * 2.0 / globals.viewport.xy * clip.w, 0.0, 0.0);
    return pulled_nearer(moved, 2.0 * globals.viewport.z * clip.w);
}
