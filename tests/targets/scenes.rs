//! Small scenes of everything that acts, with numbers of every size.

use std::fmt::Write as _;

use arbitrary::{Result, Unstructured};
use motion::Method;

use super::numbers::{at_least_0, finite, vector, written};

/// Bodies of a scene, at most; they are called b0, b1 and so on.
pub const BODIES: usize = 6;

/// The text of a scene. Most of them can be loaded.
pub fn text(u: &mut Unstructured<'_>) -> Result<String> {
    let mut text = "(version: 1,\n".to_owned();
    let out = &mut text;
    line(out, "step_hz", *u.choose(&[1e-3, 1.0, 30.0, 60.0, 120.0, 1e3, 1e9])?);
    if u.ratio(1, 8)? {
        out.push_str(" step: frame,\n");
    }
    line(out, "method", u.choose(&Method::ALL)?.name());
    line(out, "substeps", u.int_in_range(1..=3)?);
    if u.ratio(1, 2)? {
        let on = u.ratio(3, 4)?;
        line(
            out,
            "gravity",
            format!("(acceleration_m_s2: {}, on_at_start: {on})", written(vector(u)?)),
        );
    }
    if u.ratio(1, 2)? {
        let model = u.choose(&["tutorial", "clamped", "exact"])?;
        line(out, "damping", format!("(model: {model}, rate_per_s: {:?})", at_least_0(u)?));
    }
    if u.ratio(1, 3)? {
        let (linear, quadratic) = (at_least_0(u)?, at_least_0(u)?);
        line(out, "drag", format!("(linear_per_s: {linear:?}, quadratic_per_m: {quadratic:?})"));
        if u.ratio(1, 3)? {
            let velocity = written(vector(u)?);
            line(
                out,
                "wind",
                format!("(velocity_m_s: {velocity}, gust_m_s: {:?}, gust_hz: 0.5)", at_least_0(u)?),
            );
        }
    }
    if u.ratio(1, 4)? {
        let (place, strength, softening) = (written(vector(u)?), finite(u)?, at_least_0(u)?);
        line(
            out,
            "wells",
            format!(
                "[(position_m: {place}, strength_m3_s2: {strength:?}, softening_m: {softening:?})]"
            ),
        );
    }
    if u.ratio(1, 6)? {
        line(
            out,
            "mutual_gravity",
            format!("(constant_m3_kg_s2: {:?}, softening_m: {:?})", finite(u)?, at_least_0(u)?),
        );
    }
    let bodies = u.int_in_range(1..=BODIES)?;
    out.push_str(" bodies: [\n");
    for body in 0..bodies {
        writeln!(out, "  (name: \"b{body}\"{}),", body_keys(u)?)
            .expect("a string takes everything");
    }
    out.push_str(" ],\n");
    if u.ratio(1, 6)? {
        let from = u.int_in_range(0..=3)?;
        let curve = format!("polynomial([{}, {}])", written(vector(u)?), written(vector(u)?));
        line(
            out,
            "thrusts",
            format!("[(body: \"b0\", curve: {curve}, from_s: {from}.0, until_s: {}.5)]", from + 1),
        );
    }
    out.push_str(" springs: [\n");
    for _ in 0..u.int_in_range(0..=5)? {
        let (one, other) = (u.int_in_range(0..=bodies - 1)?, u.int_in_range(0..=bodies - 1)?);
        if one == other {
            continue;
        }
        let (stiffness, damping) =
            (at_least_0(u)?, if u.ratio(1, 3)? { at_least_0(u)? } else { 0.0 });
        write!(
            out,
            "  (between: (\"b{one}\", \"b{other}\"), stiffness_n_m: {stiffness:?}, damping_n_s_m: {damping:?}"
        )
        .expect("a string takes everything");
        if u.ratio(1, 2)? {
            write!(out, ", rest_length_m: {:?}", at_least_0(u)?)
                .expect("a string takes everything");
        }
        out.push_str("),\n");
    }
    out.push_str(" ],\n");
    if u.ratio(1, 8)? {
        let (mass, stiffness, air) = (at_least_0(u)?, at_least_0(u)?, at_least_0(u)?);
        let keys =
            format!("mass_kg: {mass:?}, stiffness_n_m: {stiffness:?}, damping_n_s_m: {air:?}");
        let body = match u.int_in_range(0..=2)? {
            0 => format!("chain(points: 4, to_m: (1.0, 2.0, 3.0), {keys}, pinned: [first])"),
            1 => format!(
                "cloth(rows: 3, columns: 3, along_m: (1.0, 0.0, 0.0), down_m: (0.0, -1.0, 0.0), {keys}, pinned: [top_left])"
            ),
            _ => format!("lattice(cells: (1, 1, 1), size_m: (1.0, 1.0, 1.0), {keys})"),
        };
        line(out, "soft_bodies", format!("[{body}]"));
    }
    if u.ratio(1, 10)? {
        line(
            out,
            "emitters",
            "[(rate_per_s: 60.0, speed_m_s: 5.0, life_s: 0.2, spread_deg: 20.0)]",
        );
    }
    text.push(')');
    Ok(text)
}

fn line(out: &mut String, key: &str, value: impl std::fmt::Display) {
    writeln!(out, " {key}: {value},").expect("a string takes everything");
}

fn body_keys(u: &mut Unstructured<'_>) -> Result<String> {
    let mut keys = format!(", position_m: {}", written(vector(u)?));
    let out = &mut keys;
    let mut key = |key: &str, value: String| {
        write!(out, ", {key}: {value}").expect("a string takes everything");
    };
    if u.ratio(1, 6)? {
        key("immovable", "true".to_owned());
        if u.ratio(1, 2)? {
            key("mass_kg", format!("{:?}", at_least_0(u)?));
        }
        return Ok(keys);
    }
    key("velocity_m_s", written(vector(u)?));
    key("mass_kg", format!("{:?}", at_least_0(u)?));
    if u.ratio(1, 10)? {
        key("method", u.choose(&Method::ALL)?.name().to_owned());
    }
    if u.ratio(1, 10)? {
        key("substeps", u.int_in_range(1..=3)?.to_string());
    }
    if u.ratio(1, 6)? {
        key("damping_per_s", format!("{:?}", at_least_0(u)?));
    }
    if u.ratio(1, 8)? {
        key("max_speed_m_s", format!("{:?}", at_least_0(u)?));
    }
    if u.ratio(1, 8)? {
        key("locked_axes", "[y]".to_owned());
    }
    if u.ratio(1, 8)? {
        key("gravity_off", "true".to_owned());
    }
    Ok(keys)
}
