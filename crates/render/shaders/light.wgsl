// Blinn-Phong with one point light and a shadow map: the constants are those of the tutorial (CSC8503). In the soft look, the sky
// lights what the lamp does not reach, and bodies are matte.

@group(1) @binding(0) var shadow_map: texture_depth_2d;
@group(1) @binding(1) var shadow_sampler: sampler_comparison;

const AMBIENT = 0.05;
const DIFFUSE = 0.9;
const LIT = 0.5;

// What reaches a surface that faces up and one that faces down in the soft look, and how much is left of highlights.
const SKY_LIGHT = 0.62;
const FLOOR_LIGHT = 0.34;
const MATTE = 0.06;

// 0 in shadow to `LIT`; outside the map everything is lit.
fn light_reaching(position: vec3f, normal: vec3f, facing_light: f32) -> f32 {
    if globals.light_position.w == 0.0 {
        return LIT;
    }
    // The map holds back faces; the lift along the normal keeps edges clean where front and back meet.
    let light_distance = distance(globals.light_position.xyz, position);
    let grazing = sqrt(max(1.0 - facing_light * facing_light, 0.0));
    let lift = normal * (1.5 * globals.shadow_map.y * light_distance * grazing);
    let clip = globals.light_projection * vec4f(position + lift, 1.0);
    if clip.w <= 0.0 {
        return LIT;
    }
    let ndc = clip.xyz / clip.w;
    if any(abs(ndc.xy) > vec2f(1.0)) || ndc.z > 1.0 {
        return LIT;
    }
    let uv = ndc.xy * vec2f(0.5, -0.5) + 0.5;
    let depth = ndc.z - 0.0001;
    // Wider where light is soft.
    let step = select(0.5, 1.25, globals.picture.w > 0.0) * globals.shadow_map.x;
    var lit = textureSampleCompareLevel(shadow_map, shadow_sampler, uv + vec2f(-step, -step), depth);
    lit += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + vec2f(step, -step), depth);
    lit += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + vec2f(-step, step), depth);
    lit += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + vec2f(step, step), depth);
    return lit * 0.25 * LIT;
}

// A color as displayed (gamma 2.2) to what surfaces send back of linear light, and back.
fn albedo_of(color: vec3f) -> vec3f {
    return pow(max(color, vec3f(0.0)), vec3f(2.2));
}

fn displayed(linear: vec3f) -> vec3f {
    return pow(linear, vec3f(1.0 / 2.2));
}

// How sharp highlights are. By multiplying: `pow` is slow without a graphics card.
fn to_the_16th(x: f32) -> f32 {
    let x4 = x * x * x * x;
    return x4 * x4 * x4 * x4;
}

fn to_the_80th(x: f32) -> f32 {
    let x16 = to_the_16th(x);
    return x16 * x16 * x16 * x16 * x16;
}

// Strength of the highlight on cloth, relative to a body's. It is wide: a narrow one would show every cell of the mesh.
const SHEEN = 0.12;

// The light that a surface sends to the camera, linear; its shadow is that of the point `lifted`.
fn sent_back(position: vec3f, lifted: vec3f, normal: vec3f, albedo: vec3f, is_matt: bool) -> vec3f {
    let to_camera = normalize(-position);
    var out: vec3f;
    if globals.light_color.w == 0.0 {
        let above = normalize(to_camera + 0.35 * globals.camera_up.xyz);
        out = albedo * (0.12 + 0.6 * max(dot(normal, above), 0.0));
    } else {
        let to_light = normalize(globals.light_position.xyz - position);
        let facing_light = dot(normal, to_light);
        let soft = globals.picture.w > 0.0;
        out = albedo * select(AMBIENT, mix(FLOOR_LIGHT, SKY_LIGHT, 0.5 + 0.5 * normal.y), soft);
        if facing_light > 0.0 {
            let reaching = light_reaching(lifted, normal, facing_light);
            let halfway = normalize(to_light + to_camera);
            let mirrored = max(dot(normal, halfway), 0.0);
            var specular: f32;
            if is_matt {
                specular = SHEEN * to_the_16th(mirrored);
            } else {
                specular = to_the_80th(mirrored);
            }
            specular *= select(1.0, MATTE, soft);
            out += (albedo * (DIFFUSE * facing_light) + specular) * globals.light_color.rgb * reaching;
        }
    }
    return out;
}

// The display color (gamma 2.2) of a surface.
fn shaded(position: vec3f, normal: vec3f, albedo: vec3f) -> vec3f {
    return displayed(sent_back(position, position, normal, albedo, false));
}
