// Cuboids and spheres: their surfaces, their shadows, the outline of the selected ones, and those that are seen through.

// Mirrors the bits of `Instance::surface`.
const CHECKER = 1u;

override outline_px: f32 = 0.0;
override outline_bright: f32 = 0.0;

struct Vertex {
    @location(0) position: vec3f, // on the unit cube (half extent 1) or the unit sphere
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
}

struct Body {
    @location(3) position: vec3f,
    @location(4) surface: u32,
    @location(5) half_extents: vec3f,
    @location(6) orientation: vec4f,
    @location(7) color: vec4f,
}

// Few and full: in software every location of every triangle takes time and memory, used or not.
struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) position_and_u: vec4f,
    @location(1) normal_and_v: vec4f,
    @location(2) @interpolate(flat) albedo_and_checker: vec4f,
}

fn rotated(q: vec4f, v: vec3f) -> vec3f {
    return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}

fn placed(place: vec3f, body: Body) -> vec3f {
    return body.position + rotated(body.orientation, place * body.half_extents);
}

fn turned_normal(vertex: Vertex, body: Body) -> vec3f {
    // Normals scale by the inverse, or a squashed sphere would be lit as a round one.
    let normal = vertex.normal / max(body.half_extents, vec3f(1e-6));
    return rotated(body.orientation, normalize(normal));
}

@vertex
fn vs_surface(vertex: Vertex, body: Body) -> Surface {
    let position = placed(vertex.position, body);
    var out: Surface;
    out.clip = globals.view_projection * vec4f(position, 1.0);
    out.position_and_u = vec4f(position, vertex.uv.x);
    out.normal_and_v = vec4f(turned_normal(vertex, body), vertex.uv.y);
    out.albedo_and_checker = vec4f(albedo_of(body.color.rgb), f32(body.surface & CHECKER));
    return out;
}

// A 4 by 4 board of grey 128 and white 255, averaged over the pixel's footprint so that the far floor does not shimmer; linear.
fn checker(uv: vec2f) -> f32 {
    let board = uv * 4.0;
    let width = max(fwidth(board), vec2f(1e-4));
    let high = abs(fract((board - 0.5 * width) * 0.5) - 0.5);
    let low = abs(fract((board + 0.5 * width) * 0.5) - 0.5);
    let wave = clamp(2.0 * (high - low) / width, vec2f(-1.0), vec2f(1.0));
    let white = 0.5 - 0.5 * wave.x * wave.y;
    // mix(128 / 255, 1, white) to the power 2.2, off by less than 0.001.
    return 0.2195 + white * (0.4719 + 0.3086 * white);
}

@fragment
fn fs_surface(in: Surface) -> @location(0) vec4f {
    // Derivatives need uniform control flow, so the board is computed before it is known to be wanted.
    let board = checker(vec2f(in.position_and_u.w, in.normal_and_v.w));
    let albedo = in.albedo_and_checker.rgb * mix(1.0, board, in.albedo_and_checker.a);
    return vec4f(stored(shaded(in.position_and_u.xyz, normalize(in.normal_and_v.xyz), albedo)), 1.0);
}

@vertex
fn vs_shadow(vertex: Vertex, body: Body) -> @builtin(position) vec4f {
    return globals.light_projection * vec4f(placed(vertex.position, body), 1.0);
}

// The body grown by a constant number of pixels. Growing the half extents, not each face along its normal, keeps
// the corners of a cube closed.
@vertex
fn vs_outline(vertex: Vertex, body: Body) -> @builtin(position) vec4f {
    let own = placed(vertex.position, body);
    let distance = max(dot(own, globals.camera_forward.xyz), globals.camera_forward.w);
    let grown_by = outline_px * globals.viewport.z * distance;
    let position = body.position + rotated(body.orientation, vertex.position * (body.half_extents + grown_by));
    let clip = globals.view_projection * vec4f(position, 1.0);
    // Without the pull the floor under a resting body would swallow the lower edge.
    return pulled_nearer(clip, 4.0 * grown_by);
}

fn outline_color() -> vec3f {
    return stored(vec3f(1.0, 0.87, 0.1) * outline_bright);
}

@fragment
fn fs_outline() -> @location(0) vec4f {
    return vec4f(outline_color(), 1.0);
}

// How much farther away translucent bodies count as, as a share of their distance: at the same place as an opaque one they are
// hidden, where they would else fight for depth.
const GIVES_WAY = 0.0005;
// Brightness of a face seen from the side, relative to one seen straight on.
const SIDE_LIGHT = 0.6;
// Share of what is behind that the edge of a ball hides beyond its alpha.
const EDGE = 0.6;

struct Translucent {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) color: vec4f,
}

@vertex
fn vs_translucent(vertex: Vertex, body: Body) -> Translucent {
    var out: Translucent;
    out.position = on_ground(placed(vertex.position, body));
    let clip = globals.view_projection * vec4f(out.position, 1.0);
    out.clip = pulled_nearer(clip, -GIVES_WAY * clip.w);
    out.normal = turned_normal(vertex, body);
    out.color = body.color;
    return out;
}

fn seen_through(position: vec3f, normal: vec3f, color: vec4f) -> vec4f {
    let facing = clamp(dot(normal, normalize(-position)), 0.0, 1.0);
    let aside = 1.0 - facing;
    let alpha = mix(color.a, 1.0, EDGE * aside * aside * aside);
    return vec4f(stored(color.rgb * mix(SIDE_LIGHT, 1.0, facing)), alpha);
}

@fragment
fn fs_translucent(in: Translucent) -> @location(0) vec4f {
    return seen_through(in.position, normalize(in.normal), in.color);
}
