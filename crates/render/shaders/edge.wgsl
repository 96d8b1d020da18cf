// The edges of boxes: lines that smooth them where a pixel has one sample. Follows body.wgsl.

struct Edge {
    @builtin(position) clip: vec4f,
    // w: pixels from the edge.
    @location(0) position_and_across: vec4f,
    // What is painted at either side: the normal of a face, w: its share at the edge, which fades within a pixel.
    @location(1) @interpolate(flat) left: vec4f,
    @location(2) @interpolate(flat) right: vec4f,
    @location(3) @interpolate(flat) albedo: vec3f,
}

fn axis(index: u32) -> vec3f {
    return vec3f(f32(index == 0u), f32(index == 1u), f32(index == 2u));
}

// Six vertices for each of the twelve edges.
@vertex
fn vs_edge(@builtin(vertex_index) index: u32, body: Body) -> Edge {
    let number = index / 6u;
    let corner = index % 6u;
    let along = axis(number / 4u);
    let side = vec2f(f32(number & 1u), f32((number >> 1u) & 1u)) * 2.0 - 1.0;
    let faces = array(axis((number / 4u + 1u) % 3u) * side.x, axis((number / 4u + 2u) % 3u) * side.y);
    let middle = placed(faces[0] + faces[1], body);
    let half = rotated(body.orientation, along * body.half_extents);
    let first = rotated(body.orientation, faces[0]);
    let second = rotated(body.orientation, faces[1]);
    let first_is_seen = dot(first, middle) < 0.0;
    let second_is_seen = dot(second, middle) < 0.0;
    let ends = array(globals.view_projection * vec4f(middle - half, 1.0), globals.view_projection * vec4f(middle + half, 1.0));

    var out: Edge;
    // Beyond the far plane: an edge that is not seen, or comes too near, and a floor with a board on it, are left as they are.
    out.clip = vec4f(0.0, 0.0, 2.0, 1.0);
    let near = globals.camera_forward.w;
    let is_board = (body.surface & CHECKER) != 0u;
    if !(first_is_seen || second_is_seen) || min(ends[0].w, ends[1].w) <= near || is_board {
        return out;
    }
    let start = on_screen(ends[0]);
    let across = leftward(start, on_screen(ends[1]));
    // The first face goes on from the edge against the second normal.
    let inward = globals.view_projection * vec4f(middle - second * dot(body.half_extents, abs(faces[1])), 1.0);
    let first_is_left = (dot(on_screen(inward) - start, across) > 0.0) == (inward.w > 0.0);
    // Between two faces each shades into the other; at a silhouette the face that is seen shades into what is behind.
    let both = first_is_seen && second_is_seen;
    let silhouette = vec4f(select(second, first, first_is_seen), 1.0);
    out.left = select(silhouette, vec4f(select(first, second, first_is_left), 0.5), both);
    out.right = select(silhouette, vec4f(select(second, first, first_is_left), 0.5), both);
    let is_end = corner == 1u || corner == 2u || corner == 4u;
    let aside = select(-REACH, REACH, corner == 2u || corner == 4u || corner == 5u);
    out.clip = beside(select(ends[0], ends[1], is_end), across * aside);
    out.position_and_across = vec4f(middle + half * select(-1.0, 1.0, is_end), aside);
    out.albedo = albedo_of(body.color.rgb);
    return out;
}

@fragment
fn fs_edge(in: Edge) -> @location(0) vec4f {
    let across = in.position_and_across.w;
    let face = select(in.right, in.left, across > 0.0);
    let share = face.w - abs(across);
    if share < 0.02 {
        discard;
    }
    return vec4f(stored(shaded(in.position_and_across.xyz, face.xyz, in.albedo)), share);
}
