// egui's triangles: colors times an image, both as displayed and premultiplied by their alpha.

@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;

struct Corner {
    @location(0) position: vec2f, // points from the top left of the picture
    @location(1) uv: vec2f,
    @location(2) color: vec4f,
}

struct Panel {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
    @location(1) color: vec4f,
}

@vertex
fn vs_panel(corner: Corner) -> Panel {
    var out: Panel;
    let place = corner.position / globals.picture.xy;
    out.clip = vec4f(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y, 0.0, 1.0);
    out.uv = corner.uv;
    out.color = corner.color;
    return out;
}

@fragment
fn fs_panel(in: Panel) -> @location(0) vec4f {
    let color = in.color * textureSampleLevel(image, image_sampler, in.uv, 0.0);
    return vec4f(stored(color.rgb), color.a);
}
