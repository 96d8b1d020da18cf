// Lines: quads of a width in pixels, unlit, hidden by bodies in front of them, and not by the ground.

struct Line {
    @location(0) start: vec3f,
    @location(1) start_width_px: f32,
    @location(2) end: vec3f,
    @location(3) end_width_px: f32,
    @location(4) start_color: vec4f,
    @location(5) end_color: vec4f,
}

struct Stroke {
    @builtin(position) clip: vec4f,
    @location(0) across_px: vec2f, // x: distance from the middle, y: half the width
    @location(1) color: vec4f,
}

@vertex
fn vs_line(@builtin(vertex_index) index: u32, line: Line) -> Stroke {
    var start = globals.view_projection * vec4f(on_ground(line.start), 1.0);
    var end = globals.view_projection * vec4f(on_ground(line.end), 1.0);
    let near = globals.camera_forward.w;
    var out: Stroke;
    if start.w < near && end.w < near {
        out.clip = vec4f(2.0, 2.0, 2.0, 1.0);
        return out;
    }
    // The division below is only right in front of the near plane.
    if start.w < near {
        start = mix(start, end, (near - start.w) / (end.w - start.w));
    } else if end.w < near {
        end = mix(end, start, (near - end.w) / (start.w - end.w));
    }
    let half_size = 0.5 * globals.viewport.xy;
    let direction = end.xy / end.w * half_size - start.xy / start.w * half_size;
    let length_px = length(direction);
    let along = select(vec2f(1.0, 0.0), direction / max(length_px, 1e-6), length_px > 1e-6);
    let side = vec2f(-along.y, along.x);

    let at_end = (index & 1u) == 1u;
    let half_width = 0.5 * select(line.start_width_px, line.end_width_px, at_end);
    let reach = (half_width + 1.0) * select(-1.0, 1.0, index >= 2u);
    let point = select(start, end, at_end);
    // On surfaces a line would fight for depth; a thousandth of the distance settles it.
    let clip = pulled_nearer(point, 0.001 * point.w);
    // Divided here, so that the distance across is interpolated in pixels and not in perspective.
    out.clip = vec4f(clip.xy / clip.w + side * reach / half_size, clip.z / clip.w, 1.0);
    out.across_px = vec2f(reach, half_width);
    out.color = select(line.start_color, line.end_color, at_end);
    return out;
}

@fragment
fn fs_line(in: Stroke) -> @location(0) vec4f {
    let coverage = clamp(in.across_px.y + 0.5 - abs(in.across_px.x), 0.0, 1.0);
    if coverage < 0.02 {
        discard;
    }
    return vec4f(stored(in.color.rgb), in.color.a * coverage);
}
