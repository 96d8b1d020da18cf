// Balls: every pixel of a quad meets the ball along its own ray, so a ball is round at every size. Follows body.wgsl.

// Mirrors a bit of `Instance::surface`.
const SHINES = 4u;

// A corner of the quad that just covers a ball.
struct Corner {
    @builtin(position) clip: vec4f,
    // From the eye through the corner.
    @location(0) ray: vec3f,
    @location(1) @interpolate(flat) center_and_radius: vec4f,
    // Of translucent balls as displayed; of opaque ones linear, w: not 0 = it shines.
    @location(2) @interpolate(flat) color: vec4f,
}

// What a ray meets.
struct Met {
    position: vec3f,
    normal: vec3f,
    // Share of the pixel that the ball covers.
    coverage: f32,
}

struct Seen {
    @builtin(frag_depth) depth: f32,
    @location(0) color: vec4f,
}

// The corner `index` of a quad around a ball that is seen from the origin.
fn corner_of(index: u32, center: vec3f, radius: f32) -> vec3f {
    let place = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    let away = length(center);
    let toward = center / max(away, 1e-20);
    let aside = select(globals.camera_up.xyz, globals.camera_forward.xyz, abs(dot(toward, globals.camera_up.xyz)) > 0.8);
    let right = normalize(cross(toward, aside));
    // Where it passes the center, the cone of rays that touch the ball is wider than the ball.
    let wide = radius * away / sqrt(max(away * away - radius * radius, 1e-4 * away * away));
    return center + (right * place.x + cross(right, toward) * place.y) * wide;
}

fn corner(index: u32, body: Body, grown_by: f32, color: vec4f) -> Corner {
    let radius = body.half_extents.x + grown_by;
    var out: Corner;
    // A pixel at the edge that is covered by less than half is beyond the ball.
    out.ray = corner_of(index, body.position, radius + globals.viewport.z * length(body.position));
    let clip = globals.view_projection * vec4f(out.ray, 1.0);
    // The fragments give the depth: the quad itself is never too near or too far.
    out.clip = vec4f(clip.xy, 0.5 * clip.w, clip.w);
    out.center_and_radius = vec4f(body.position, radius);
    out.color = color;
    return out;
}

// Where a ray passes the center of a ball nearest.
struct Pass {
    toward: vec3f,
    // How far along the ray.
    middle: f32,
    // From there to the center.
    off: vec3f,
}

fn pass_of(ray: vec3f, center: vec3f) -> Pass {
    let toward = normalize(ray);
    let middle = dot(center, toward);
    return Pass(toward, middle, center - toward * middle);
}

fn met(in: Corner) -> Met {
    let radius = in.center_and_radius.w;
    let passed = pass_of(in.ray, in.center_and_radius.xyz);
    let toward = passed.toward;
    let middle = passed.middle;
    let beside = length(passed.off);
    let half = sqrt(max(radius * radius - beside * beside, 0.0));
    let pixel = globals.viewport.z * middle * dot(toward, globals.camera_forward.xyz);
    var out: Met;
    out.position = toward * (middle - half);
    out.normal = normalize(-passed.off - toward * half);
    out.coverage = select(0.0, clamp((radius - beside) / pixel + 0.5, 0.0, 1.0), middle > half);
    return out;
}

// Depth of a point at that distance along the direction of view.
fn depth_at(distance: f32) -> f32 {
    return globals.viewport.w * (1.0 / distance - 1.0 / globals.camera_forward.w);
}

// Coverage of a pixel that is as good as none.
const UNSEEN = 0.02;

// Whether the pixels at the edge are drawn, which let through what is behind, or all others, which hide it.
override edges: bool = false;

@vertex
fn vs_ball(@builtin(vertex_index) index: u32, body: Body) -> Corner {
    return corner(index, body, 0.0, vec4f(albedo_of(body.color.rgb), f32(body.surface & SHINES)));
}

@fragment
fn fs_ball(in: Corner) -> Seen {
    let ball = met(in);
    let distance = dot(ball.position, globals.camera_forward.xyz);
    if ball.coverage < UNSEEN || (ball.coverage < 1.0) != edges || distance < globals.camera_forward.w {
        discard;
    }
    var color: vec3f;
    if in.color.w > 0.0 {
        let facing = max(dot(ball.normal, normalize(-ball.position)), 0.0);
        color = displayed(mix(in.color.rgb, vec3f(1.0), 0.6 * facing));
    } else {
        color = shaded(ball.position, ball.normal, in.color.rgb);
    }
    return Seen(depth_at(distance), vec4f(stored(color), ball.coverage));
}

@vertex
fn vs_ball_outline(@builtin(vertex_index) index: u32, body: Body) -> Corner {
    let distance = max(dot(body.position, globals.camera_forward.xyz), globals.camera_forward.w);
    return corner(index, body, outline_px * globals.viewport.z * distance, vec4f(1.0));
}

@fragment
fn fs_ball_outline(in: Corner) -> Seen {
    let coverage = met(in).coverage;
    if coverage < UNSEEN {
        discard;
    }
    let distance = max(dot(in.center_and_radius.xyz, globals.camera_forward.xyz), globals.camera_forward.w);
    // As far as the outlines of boxes: what the ball rests on must not swallow its edge.
    let nearer = 4.0 * outline_px * globals.viewport.z * distance;
    return Seen(depth_at(max(distance - nearer, globals.camera_forward.w)), vec4f(outline_color(), coverage));
}

@vertex
fn vs_translucent_ball(@builtin(vertex_index) index: u32, body: Body) -> Corner {
    return corner(index, body, 0.0, body.color);
}

@fragment
fn fs_translucent_ball(in: Corner) -> Seen {
    let ball = met(in);
    let position = on_ground(ball.position);
    let distance = dot(position, globals.camera_forward.xyz);
    if ball.coverage < UNSEEN || distance < globals.camera_forward.w {
        discard;
    }
    let color = seen_through(ball.position, ball.normal, in.color);
    return Seen(depth_at(distance * (1.0 + GIVES_WAY)), vec4f(color.rgb, color.a * ball.coverage));
}

struct FromLight {
    @builtin(position) clip: vec4f,
    @location(0) ray: vec3f,
    @location(1) @interpolate(flat) center_and_radius: vec4f,
}

@vertex
fn vs_ball_shadow(@builtin(vertex_index) index: u32, body: Body) -> FromLight {
    let center = body.position - globals.light_position.xyz;
    var out: FromLight;
    out.ray = corner_of(index, center, body.half_extents.x);
    let clip = globals.light_projection * vec4f(out.ray + globals.light_position.xyz, 1.0);
    out.clip = vec4f(clip.xy, 0.5 * clip.w, clip.w);
    out.center_and_radius = vec4f(center, body.half_extents.x);
    return out;
}

// The far side of the ball, as the map has the back faces of boxes.
@fragment
fn fs_ball_shadow(in: FromLight) -> @builtin(frag_depth) f32 {
    let passed = pass_of(in.ray, in.center_and_radius.xyz);
    let under = in.center_and_radius.w * in.center_and_radius.w - dot(passed.off, passed.off);
    if under < 0.0 {
        discard;
    }
    let far = globals.light_position.xyz + passed.toward * (passed.middle + sqrt(under));
    let clip = globals.light_projection * vec4f(far, 1.0);
    return clip.z / clip.w;
}
