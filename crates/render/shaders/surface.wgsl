// Surfaces of triangles that move on their own: both sides, their shadows and the outline of the selected ones.

override outline_px: f32 = 0.0;
override outline_bright: f32 = 0.0;

// Light that shines through from the far side, as a share of what the near side would reflect. Without it, a sheet seen
// against the light would be one flat color without folds. Solid ones shade themselves there.
const SHINES_THROUGH = 0.35;

// How far toward the light a surface looks for its shadow in the soft look, texels of the map: otherwise the facets of
// the mesh, which normals smooth, would show as specks in each other's shadow.
const LIFT = 6.0;

struct Vertex {
    @location(0) position: vec3f,
    @location(1) color: vec4f,
    @location(2) normal: vec3f,
}

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) color: vec3f,
    @location(2) normal: vec3f,
}

@vertex
fn vs_surface(vertex: Vertex) -> Point {
    var out: Point;
    out.clip = globals.view_projection * vec4f(vertex.position, 1.0);
    out.position = vertex.position;
    out.color = vertex.color.rgb;
    out.normal = vertex.normal;
    return out;
}

// What is seen of a place on a surface; `normal` is on the side that is seen.
fn seen(position: vec3f, normal: vec3f, color: vec3f) -> vec3f {
    // In a sharp fold normals cancel; such a pixel is lit as if it faced the camera.
    let size = length(normal);
    let outward = select(normalize(-position), normal * (1.0 / max(size, 1e-6)), size > 1e-3);

    let albedo = albedo_of(color);
    let to_light = globals.light_position.xyz - position;
    let from_behind = -dot(outward, normalize(to_light));
    let lift = select(0.0, LIFT, globals.picture.w > 0.0) * globals.shadow_map.y * length(to_light);
    let lifted = position + select(lift, -lift, from_behind > 0.0) * outward;
    var out = sent_back(position, lifted, outward, albedo, true);
    if globals.light_color.w != 0.0 && from_behind > 0.0 {
        let reaching = light_reaching(lifted, -outward, from_behind);
        out += albedo * globals.light_color.rgb * (SHINES_THROUGH * DIFFUSE * from_behind * reaching);
    }
    return stored(displayed(out));
}

@fragment
fn fs_surface(in: Point, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    return vec4f(seen(in.position, in.normal * select(-1.0, 1.0, front), in.color), 1.0);
}

// An edge where the surface ends, as seen from the camera: it fades into what is behind it within a pixel.
struct Edge {
    @location(0) start: vec3f,
    @location(1) start_color: vec4f,
    @location(2) start_normal: vec3f,
    @location(3) end: vec3f,
    @location(4) end_color: vec4f,
    @location(5) end_normal: vec3f,
}

struct EdgePoint {
    @builtin(position) clip: vec4f,
    // w: pixels from the edge.
    @location(0) position_and_across: vec4f,
    @location(1) color: vec3f,
    @location(2) normal: vec3f,
}

@vertex
fn vs_edge(@builtin(vertex_index) index: u32, edge: Edge) -> EdgePoint {
    let ends = array(globals.view_projection * vec4f(edge.start, 1.0), globals.view_projection * vec4f(edge.end, 1.0));
    var out: EdgePoint;
    // Beyond the far plane: what comes too near is left as it is.
    out.clip = vec4f(0.0, 0.0, 2.0, 1.0);
    if min(ends[0].w, ends[1].w) <= globals.camera_forward.w {
        return out;
    }
    let across = leftward(on_screen(ends[0]), on_screen(ends[1]));
    let is_end = (index & 1u) == 1u;
    let aside = select(-REACH, REACH, index >= 2u);
    out.clip = beside(select(ends[0], ends[1], is_end), across * aside);
    out.position_and_across = vec4f(select(edge.start, edge.end, is_end), aside);
    out.color = select(edge.start_color, edge.end_color, is_end).rgb;
    out.normal = select(edge.start_normal, edge.end_normal, is_end);
    return out;
}

@fragment
fn fs_edge(in: EdgePoint) -> @location(0) vec4f {
    let share = 1.0 - abs(in.position_and_across.w);
    if share < 0.02 {
        discard;
    }
    return vec4f(seen(in.position_and_across.xyz, in.normal, in.color), share);
}

@vertex
fn vs_shadow(vertex: Vertex) -> @builtin(position) vec4f {
    return globals.light_projection * vec4f(vertex.position, 1.0);
}

// The surface moved on the screen in one of eight directions; all of them together are its outline, wherever it ends.
@vertex
fn vs_outline(vertex: Vertex, @builtin(instance_index) direction: u32) -> @builtin(position) vec4f {
    let clip = globals.view_projection * vec4f(vertex.position, 1.0);
    let angle = 0.78539816 * f32(direction);
    let aside = vec2f(cos(angle), sin(angle)) * (2.0 * outline_px) / globals.viewport.xy;
    // As far as the outlines of bodies: something the surface rests on must not swallow its edge.
    let distance = max(clip.w, globals.camera_forward.w);
    let nearer = 4.0 * outline_px * globals.viewport.z * distance;
    return pulled_nearer(vec4f(clip.xy + aside * clip.w, clip.zw), nearer);
}

@fragment
fn fs_outline() -> @location(0) vec4f {
    return vec4f(stored(vec3f(1.0, 0.87, 0.1) * outline_bright), 1.0);
}
