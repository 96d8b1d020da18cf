//! The objects that can be added to a scene, as text, with values that keep them stable and visible.

use glam::DVec3;
use motion::Gravity;
use report::numbers::rounded;
use scene::Value;

/// Colors of added objects, in turn.
const COLORS: [&str; 5] = [
    "(0.9, 0.35, 0.2)",
    "(0.3, 0.5, 0.9)",
    "(0.95, 0.75, 0.2)",
    "(0.3, 0.7, 0.4)",
    "(0.7, 0.4, 0.8)",
];

/// The phase that the fastest spring goes through in a substep, radians; semi-implicit Euler is stable below 2.
const PHASE: f64 = 0.5;

/// How far standard gravity stretches an added spring, as a fraction of its length.
const SAG: f64 = 0.1;

/// Free fall near the ground, m/s².
const GRAVITY: f64 = -Gravity::EARTH.acceleration.y;

/// Place and size of an added object.
pub(super) struct Place {
    /// Position, m.
    pub at: DVec3,
    /// Radius of a sphere, m.
    pub size: f64,
    /// Length of a substep, s.
    pub substep: f64,
}

/// Something to add: its name, its list, and its text by name, place and color.
pub(super) type Part = (&'static str, &'static str, fn(&str, &Place, &str) -> String);

/// Everything that can be added by a click.
pub(super) const PARTS: [Part; 8] = [
    ("Sphere", "bodies", |name, place, color| {
        let Place { at, size, .. } = place;
        format!(
            "(name: {name:?}, shape: sphere(radius_m: {size:?}), position_m: {}, mass_kg: 1.0, color: {color})",
            triple(*at)
        )
    }),
    ("Box", "bodies", |name, place, color| {
        let half = triple(DVec3::splat(place.size));
        format!(
            "(name: {name:?}, shape: cuboid(half_extents_m: {half}), position_m: {}, mass_kg: 1.0, color: {color})",
            triple(place.at)
        )
    }),
    ("Post", "bodies", |name, place, _| {
        let half = triple(DVec3::splat(0.5 * place.size));
        format!(
            "(name: {name:?}, shape: cuboid(half_extents_m: {half}), position_m: {}, immovable: true)",
            triple(place.at)
        )
    }),
    ("Particle", "bodies", |name, place, color| {
        format!("(name: {name:?}, position_m: {}, mass_kg: 1.0, color: {color})", triple(place.at))
    }),
    ("Rope", "soft_bodies", |name, place, color| {
        let to = triple(place.at + 10.0 * place.size * DVec3::X);
        let springs = springs(place, 1.0 / 11.0, 4.0);
        let from = triple(place.at);
        format!(
            "chain(name: {name:?}, points: 11, from_m: {from}, to_m: {to}, mass_kg: 1.0, {springs}, pinned: [first], color: {color})"
        )
    }),
    ("Cloth", "soft_bodies", |name, place, color| {
        let (along, down) =
            (triple(8.0 * place.size * DVec3::X), triple(-6.0 * place.size * DVec3::Y));
        let springs = springs(place, 1.0 / 63.0, 24.0);
        let corner = triple(place.at);
        format!(
            "cloth(name: {name:?}, rows: 7, columns: 9, corner_m: {corner}, along_m: {along}, down_m: {down}, shear: true, mass_kg: 1.0, {springs}, pinned: [top_left, top_right], color: {color})"
        )
    }),
    ("Jelly", "soft_bodies", |name, place, color| {
        let size = triple(DVec3::splat(3.0 * place.size));
        let springs = springs(place, 1.0 / 64.0, 52.0);
        format!(
            "lattice(name: {name:?}, cells: (3, 3, 3), center_m: {}, size_m: {size}, mass_kg: 1.0, {springs}, color: {color})",
            triple(place.at)
        )
    }),
    ("Emitter", "emitters", |name, place, color| emitter(name, place, color, "")),
];

/// The text of an emitter, which ends with the values `more`.
pub(super) fn emitter(name: &str, place: &Place, color: &str, more: &str) -> String {
    // So fast that particles rise ten sizes against gravity.
    let speed = rounded((2.0 * GRAVITY * 10.0 * place.size).sqrt(), 2);
    let radius = rounded(0.08 * place.size, 2);
    format!(
        "(name: {name:?}, rate_per_s: 60.0, position_m: {}, direction: (0.0, 1.0, 0.0), spread_deg: 15.0, speed_m_s: {speed:?}, life_s: 3.0, radius_m: {radius:?}, mass_kg: 0.01, color: {color}{more})",
        triple(place.at)
    )
}

/// The color of the next added object, if there are `entries` entries.
pub(super) const fn color(entries: usize) -> &'static str {
    COLORS[entries % COLORS.len()]
}

/// The text of a spring between two bodies with those names and that reduced mass, kg, at rest at their distance, m: standard
/// gravity stretches it by [`SAG`] of that.
pub(super) fn spring(between: [&str; 2], reduced_mass: f64, length: f64, substep: f64) -> String {
    let sags = reduced_mass * GRAVITY / (SAG * length);
    let elastic = elastic(sags.min(stiffest(reduced_mass, substep)), reduced_mass);
    let ([one, other], length) = (between, rounded(length, 3));
    format!(
        "(between: ({one:?}, {other:?}), {elastic}, rest_length_m: {length:?}, pull_only: false)"
    )
}

/// Stiffness and damping for points of `mass` kilograms: as stiff as [`PHASE`] allows if the squared frequency of the fastest
/// mode is `factor` times k / m.
fn springs(place: &Place, mass: f64, factor: f64) -> String {
    elastic(stiffest(mass, place.substep) / factor, mass)
}

/// The greatest stiffness that [`PHASE`] allows, N/m.
fn stiffest(mass: f64, substep: f64) -> f64 {
    mass * (PHASE / substep).powi(2)
}

/// A stiffness, N/m, with a tenth of critical damping for `mass`, kg.
fn elastic(stiffness: f64, mass: f64) -> String {
    let stiffness = rounded(stiffness, 2);
    let damping = rounded(0.2 * (stiffness * mass).sqrt(), 2);
    format!("stiffness_n_m: {stiffness:?}, damping_n_s_m: {damping:?}")
}

pub(crate) fn triple(v: DVec3) -> String {
    // Turns -0 into 0.
    Value::from(v + DVec3::ZERO).to_string()
}

/// The multiple of `step` nearest to `number`, with the decimals that the step has.
pub(crate) fn rounded_to_multiple(number: f64, step: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "decimals")]
    let decimals = (-step.log10()).ceil().max(0.0) as usize;
    let multiple = (number / step).round() * step;
    format!("{multiple:.decimals$}").parse().unwrap_or(multiple)
}

/// Rounds a position to five digits of its distance from the origin.
pub(super) fn five_digits(place: DVec3) -> DVec3 {
    let step = 10_f64.powf(place.length().log10().floor() - 4.0);
    if step.is_normal() {
        place.to_array().map(|part| rounded_to_multiple(part, step)).into()
    } else {
        place
    }
}
