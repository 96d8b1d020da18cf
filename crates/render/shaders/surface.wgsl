// Surfaces of triangles that move on their own: both sides, their shadows and the outline of the selected ones.

override outline_px: f32 = 0.0;
override outline_bright: f32 = 0.0;

// Light that shines through from the far side, as a share of what the near side would reflect. Without it, a sheet seen
// against the light would be one flat color without folds. Solid ones shade themselves there.
const SHINES_THROUGH = 0.35;

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

@fragment
fn fs_surface(in: Point, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    // In a sharp fold normals cancel; such a pixel is lit as if it faced the camera.
    let size = length(in.normal);
    let faces_camera = normalize(-in.position);
    let outward = in.normal * (select(-1.0, 1.0, front) / max(size, 1e-6));
    let normal = select(faces_camera, outward, size > 1e-3);

    let albedo = albedo_of(in.color);
    var out = sent_back(in.position, normal, albedo, true);
    let to_light = normalize(globals.light_position.xyz - in.position);
    let from_behind = -dot(normal, to_light);
    if globals.light_color.w != 0.0 && from_behind > 0.0 {
        let reaching = light_reaching(in.position, -normal, from_behind);
        out += albedo * globals.light_color.rgb * (SHINES_THROUGH * DIFFUSE * from_behind * reaching);
    }
    return vec4f(stored(displayed(out)), 1.0);
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
