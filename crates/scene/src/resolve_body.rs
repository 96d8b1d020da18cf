//! From one written body to one that can be spawned: mass to inverse mass, degrees to a rotation.

use glam::{DQuat, DVec3, EulerRot};
use motion::{AxisLocks, Method};
use pick::Shape;

use crate::check::{Scope, not_negative, shown, shown_vector};
use crate::faults::Faults;
use crate::nearest::one_of;
use crate::raw::{RawBody, RawShape};
use crate::resolve::DAMPING_RATE;
use crate::scene::BodySpec;
use crate::syntax::Word;

/// Resolves body `index` of the list, in a scene of the given method.
pub(crate) fn body(raw: &RawBody, index: usize, scenes: Method, faults: &mut Faults) -> BodySpec {
    let scope = Scope::item("bodies", index);
    let scenery = raw.scenery == Some(true);
    let immovable = raw.immovable == Some(true);
    if scenery {
        refuse_physics(raw, scope, faults);
    }
    let velocity = faults.vector((scope, "velocity_m_s"), raw.velocity_m_s, DVec3::ZERO);
    if immovable && !scenery && velocity != DVec3::ZERO {
        faults.add(
            scope.key("velocity_m_s"),
            "an immovable body has no velocity",
            "remove it, or immovable: true",
        );
    }
    let cure = "give a positive number of kilograms, or immovable: true";
    let inverse_mass = faults.inverse_mass(scope, raw.mass_kg, 1.0, cure);
    let speed = ("a speed", "give meters per second from 0 up");
    faults.own_method(scope, raw.method.as_ref(), raw.substeps, scenes);
    BodySpec {
        shape: raw.shape.as_ref().and_then(|shape| resolve_shape(shape, scope, faults)),
        position: faults.vector((scope, "position_m"), raw.position_m, DVec3::ZERO),
        orientation: orientation(raw, scope, faults),
        velocity: if scenery || immovable { DVec3::ZERO } else { velocity },
        inverse_mass: (!scenery).then_some(if immovable { 0.0 } else { inverse_mass }),
        color: faults.color((scope, "color"), raw.color, BodySpec::DEFAULT.color, 1.0),
        checker: faults.word((scope, "texture"), raw.texture.as_ref(), false, &TEXTURES),
        damping_rate: raw
            .damping_per_s
            .map(|rate| faults.number((scope, "damping_per_s"), Some(rate), 0.0, not_negative, DAMPING_RATE)),
        max_speed: raw
            .max_speed_m_s
            .map(|limit| faults.number((scope, "max_speed_m_s"), Some(limit), 0.0, not_negative, speed)),
        locks: locks(raw.locked_axes.as_deref().unwrap_or_default(), scope, faults),
        gravity_off: raw.gravity_off == Some(true),
    }
}

/// Textures and whether they are the checker.
const TEXTURES: [(&str, bool); 2] = [("checker", true), ("none", false)];

/// Scenery is a collision volume and nothing else.
fn refuse_physics(raw: &RawBody, scope: Scope, faults: &mut Faults) {
    if raw.shape.is_none() {
        let cure = "add a shape, or remove scenery: true";
        faults.add(scope.key("scenery"), "scenery without a shape is nothing", cure);
    }
    let physics = [
        ("velocity_m_s", raw.velocity_m_s.is_some()),
        ("mass_kg", raw.mass_kg.is_some()),
        ("immovable", raw.immovable.is_some()),
        ("method", raw.method.is_some()),
        ("substeps", raw.substeps.is_some()),
        ("damping_per_s", raw.damping_per_s.is_some()),
        ("max_speed_m_s", raw.max_speed_m_s.is_some()),
        ("locked_axes", raw.locked_axes.is_some()),
        ("gravity_off", raw.gravity_off.is_some()),
    ];
    for (key, _) in physics.into_iter().filter(|(_, given)| *given) {
        faults.add(
            scope.key(key),
            format!("scenery has no physics, so no `{key}`"),
            "remove it, or scenery: true",
        );
    }
}

fn resolve_shape(raw: &RawShape, scope: Scope, faults: &mut Faults) -> Option<Shape> {
    let RawShape { word, sizes } = raw;
    let (key, other, shape) = match word.as_str() {
        "cuboid" => {
            let other = sizes.radius_m.map(|_| "radius_m");
            let half_extents = sizes.half_extents_m.map(DVec3::from_array);
            ("half_extents_m", other, half_extents.map(|half_extents| Shape::Cuboid { half_extents }))
        }
        "sphere" => {
            let other = sizes.half_extents_m.map(|_| "half_extents_m");
            ("radius_m", other, sizes.radius_m.map(|radius| Shape::Sphere { radius }))
        }
        _ => {
            let known = "give cuboid(half_extents_m: (x, y, z)) or sphere(radius_m: r)";
            faults.add(scope.key("shape"), format!("unknown shape `{word}`"), known);
            return None;
        }
    };
    if let Some(other) = other {
        faults.add(scope.key(&format!("shape.{other}")), format!("a {word} has no `{other}`"), "remove it");
    }
    let Some(shape) = shape else {
        faults.add(
            scope.key("shape"),
            format!("a {word} without `{key}` has no size"),
            format!("add `{key}`"),
        );
        return None;
    };
    if shape.validated().is_err() {
        let what = match shape {
            Shape::Cuboid { half_extents } => format!("{} is not half a size", shown_vector(half_extents)),
            Shape::Sphere { radius } => format!("{} is not a radius", shown(radius)),
        };
        let cure = format!("give {:e} to {:e} m", Shape::SMALLEST, Shape::LARGEST);
        faults.add(scope.key(&format!("shape.{key}")), what, cure);
        return None;
    }
    Some(shape)
}

/// Turned about the world's x axis, then y, then z. `None` where nothing is turned: the component is left out.
fn orientation(raw: &RawBody, scope: Scope, faults: &mut Faults) -> Option<DQuat> {
    let degrees = faults.vector((scope, "rotation_deg"), raw.rotation_deg, DVec3::ZERO);
    let [x, y, z] = degrees.to_array().map(f64::to_radians);
    (degrees != DVec3::ZERO).then(|| DQuat::from_euler(EulerRot::ZYX, z, y, x))
}

fn locks(words: &[Word], scope: Scope, faults: &mut Faults) -> AxisLocks {
    let mut locks = AxisLocks::default();
    for (i, Word(word)) in words.iter().enumerate() {
        match word.as_str() {
            "x" => locks.x = true,
            "y" => locks.y = true,
            "z" => locks.z = true,
            _ => faults.add(
                scope.key(&format!("locked_axes[{i}]")),
                format!("unknown word `{word}`"),
                format!("give {}", one_of(&["x", "y", "z"])),
            ),
        }
    }
    locks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_goes_about_x_then_y_then_z_of_the_world() {
        let scene =
            crate::Scene::parse("t", "(version: 1, bodies: [(rotation_deg: (90.0, 90.0, 0.0))])").unwrap();
        let turned = scene.bodies[0].orientation.unwrap() * DVec3::Y;
        // y goes to z about x, and on to x about y.
        assert!((turned - DVec3::X).length() < 1e-15, "{turned}");
    }
}
