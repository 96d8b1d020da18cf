//! Resolves one written body: mass to inverse mass, degrees to a rotation.

use glam::{DQuat, DVec3, EulerRot};
use motion::{AxisLocks, Method};
use pick::Shape;

use crate::check::{DAMPING_RATE, SPEED, Scope, shown, shown_vector};
use crate::raw;
use crate::scene::BodySpec;
use crate::substepping::Substepping;
use crate::text::faults::Faults;
use crate::text::syntax::Word;

/// Settings of the scene for bodies that do not give their own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Defaults {
    /// `None` if the text is not the name of a method.
    pub method: Option<Method>,
    pub substeps: Substepping,
    pub step_hz: f64,
}

/// Resolves body `index` of the list.
pub(crate) fn body(
    raw: &raw::Body,
    index: usize,
    scenes: Defaults,
    faults: &mut Faults,
) -> BodySpec {
    let scope = Scope::item("bodies", index);
    let scenery = raw.scenery == Some(true);
    let immovable = raw.immovable == Some(true);
    if scenery {
        refuse_physics(raw, scope, faults);
    }
    let velocity = faults.vector(scope, "velocity_m_s", raw.velocity_m_s, DVec3::ZERO);
    if immovable && !scenery && velocity != DVec3::ZERO {
        faults.refuse(
            scope,
            "velocity_m_s",
            "an immovable body has no velocity",
            "remove it, or immovable: true, or give the body a motion in `moves`",
        );
    }
    let cure = match immovable {
        true => "give a positive number of kilograms, or leave it out",
        false => "give a positive number of kilograms, or immovable: true",
    };
    let inverse_mass = faults.inverse_mass(scope, raw.mass_kg, 1.0, 1.0, cure);
    let position = faults.vector(scope, "position_m", raw.position_m, DVec3::ZERO);
    let method = faults.method(scope, raw.method.as_ref());
    let substeps = faults.substeps(scope, raw.substeps);
    let own = Defaults {
        method: if raw.method.is_some() { method } else { scenes.method },
        substeps: substeps.unwrap_or(scenes.substeps),
        ..scenes
    };
    BodySpec {
        shape: raw.shape.as_ref().and_then(|shape| resolve_shape(shape, scope, faults)),
        position,
        orientation: orientation(raw, scope, faults),
        velocity: if scenery || immovable { DVec3::ZERO } else { velocity },
        verlet_previous: if scenery {
            None
        } else {
            verlet_previous(raw, position, own, scope, faults)
        },
        inverse_mass: (!scenery).then_some(if immovable { 0.0 } else { inverse_mass }),
        source_mass: raw.mass_kg.filter(|_| immovable && !scenery),
        color: faults.color(scope, raw.color),
        checker: faults.word(scope, "texture", raw.texture.as_ref(), false, &TEXTURES),
        method,
        substeps,
        damping_rate: faults.optional(scope, "damping_per_s", raw.damping_per_s, DAMPING_RATE),
        max_speed: faults.optional(scope, "max_speed_m_s", raw.max_speed_m_s, SPEED),
        locks: locks(raw.locked_axes.as_deref().unwrap_or_default(), scope, faults),
        gravity_off: raw.gravity_off == Some(true),
    }
}

/// The position of the body one substep before the start; `own` has the settings of the body.
fn verlet_previous(
    raw: &raw::Body,
    position: DVec3,
    own: Defaults,
    scope: Scope,
    faults: &mut Faults,
) -> Option<DVec3> {
    const KEY: &str = "verlet_previous_position_m";
    let previous = faults.vector(scope, KEY, Some(raw.verlet_previous_position_m?), position);
    let mut refuse = |what: &str, cure: &str| faults.refuse(scope, KEY, what, cure);
    if raw.immovable == Some(true) {
        refuse("an immovable body was nowhere else", "remove it, or immovable: true");
    } else if let Some(method) = own.method.filter(|method| *method != Method::PositionVerlet) {
        let what = format!("{} knows no previous position", method.name());
        refuse(&what, "set method: position_verlet, or give velocity_m_s instead");
    } else if !((position - previous) * own.step_hz * f64::from(own.substeps.least())).is_finite() {
        refuse("the way from there is too long for one step", "give a place closer to position_m");
    }
    if raw.velocity_m_s.is_some() {
        refuse("it says how fast the body starts, as velocity_m_s does", "remove one of the two");
    }
    Some(previous)
}

/// Longest label, characters: about a third of a window 1280 pixels wide.
const LABEL_LIMIT: usize = 60;

/// The text that is drawn beside the body.
pub(crate) fn label(raw: &raw::Body, scope: Scope, faults: &mut Faults) -> Option<String> {
    let label = raw.label.clone()?;
    let length = label.chars().count();
    let what = if label.trim().is_empty() {
        "an empty label says nothing".to_owned()
    } else if label.chars().any(char::is_control) {
        "a label is one line of plain characters".to_owned()
    } else if length > LABEL_LIMIT {
        format!("{length} characters are too many beside a body")
    } else {
        return Some(label);
    };
    faults.refuse(
        scope,
        "label",
        what,
        format!("give 1 to {LABEL_LIMIT} characters, or remove it"),
    );
    None
}

/// Names of textures, and whether each is the checkerboard.
const TEXTURES: [(&str, bool); 2] = [("checker", true), ("none", false)];

/// Refuses physics on scenery, which is only a collision volume.
fn refuse_physics(raw: &raw::Body, scope: Scope, faults: &mut Faults) {
    if raw.shape.is_none() {
        let cure = "add a shape, or remove scenery: true";
        faults.refuse(scope, "scenery", "scenery needs a shape", cure);
    }
    let physics = [
        ("velocity_m_s", raw.velocity_m_s.is_some()),
        ("verlet_previous_position_m", raw.verlet_previous_position_m.is_some()),
        ("mass_kg", raw.mass_kg.is_some()),
        ("immovable", raw.immovable.is_some()),
        ("method", raw.method.is_some()),
        ("substeps", raw.substeps.is_some()),
        ("damping_per_s", raw.damping_per_s.is_some()),
        ("max_speed_m_s", raw.max_speed_m_s.is_some()),
        ("locked_axes", raw.locked_axes.is_some()),
        ("gravity_off", raw.gravity_off.is_some()),
    ];
    let drags = raw.drags().map(|(key, value)| (key, value.is_some()));
    for (key, _) in physics.into_iter().chain(drags).filter(|(_, given)| *given) {
        faults.refuse(
            scope,
            key,
            format!("scenery has no physics, so no `{key}`"),
            "remove it, or scenery: true",
        );
    }
}

fn resolve_shape(raw: &raw::Shape, scope: Scope, faults: &mut Faults) -> Option<Shape> {
    let raw::Shape { word, keys } = raw;
    let half_extents = keys.half_extents_m.map(DVec3::from_array);
    let cuboid =
        ("half_extents_m", half_extents.map(|half_extents| Shape::Cuboid { half_extents }));
    let sphere = ("radius_m", keys.radius_m.map(|radius| Shape::Sphere { radius }));
    let ((key, shape), (other, strange)) = match word.as_str() {
        "cuboid" => (cuboid, sphere),
        "sphere" => (sphere, cuboid),
        _ => {
            let known = "give cuboid(half_extents_m: (x, y, z)) or sphere(radius_m: r)";
            faults.refuse(scope, "shape", format!("unknown shape `{word}`"), known);
            return None;
        }
    };
    if strange.is_some() {
        faults.refuse(
            scope,
            &format!("shape.{other}"),
            format!("a {word} has no `{other}`"),
            "remove it",
        );
    }
    let Some(shape) = shape else {
        faults.refuse(
            scope,
            "shape",
            format!("a {word} without `{key}` has no size"),
            format!("add `{key}`"),
        );
        return None;
    };
    if shape.validated().is_err() {
        let what = match shape {
            Shape::Cuboid { half_extents } => {
                format!("{} is not half a size", shown_vector(half_extents))
            }
            Shape::Sphere { radius } => format!("{} is not a radius", shown(radius)),
        };
        let cure = format!("give {:e} to {:e} m", Shape::SMALLEST, Shape::LARGEST);
        faults.refuse(scope, &format!("shape.{key}"), what, cure);
        return None;
    }
    Some(shape)
}

/// The rotation about the world's x axis, then y, then z. `None` without a rotation: the component is left out.
fn orientation(raw: &raw::Body, scope: Scope, faults: &mut Faults) -> Option<DQuat> {
    let degrees = faults.vector(scope, "rotation_deg", raw.rotation_deg, DVec3::ZERO);
    let [x, y, z] = degrees.to_array().map(f64::to_radians);
    (degrees != DVec3::ZERO).then(|| DQuat::from_euler(EulerRot::ZYX, z, y, x))
}

fn locks(words: &[Word], scope: Scope, faults: &mut Faults) -> AxisLocks {
    let mut locks = AxisLocks::default();
    for (i, word) in words.iter().enumerate() {
        let key = format!("locked_axes[{i}]");
        let axis =
            faults.word(scope, &key, Some(word), "", &["x", "y", "z"].map(|axis| (axis, axis)));
        locks.x |= axis == "x";
        locks.y |= axis == "y";
        locks.z |= axis == "z";
    }
    locks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_goes_about_x_then_y_then_z_of_the_world() {
        let scene = crate::scene::Scene::parse(
            "t",
            "(version: 1, bodies: [(rotation_deg: (90.0, 90.0, 0.0))])",
        )
        .unwrap();
        let turned = scene.bodies[0].orientation.unwrap() * DVec3::Y;
        // y goes to z about x, and on to x about y.
        assert!((turned - DVec3::X).length() < 1e-15, "{turned}");
    }

    #[test]
    fn bodies_grids_and_clouds_may_have_methods_and_substeps_of_their_own() {
        let scene = crate::scene::Scene::parse(
            "t",
            r#"(version: 1, method: yoshida_4, substeps: 3, bodies: [(), (method: yoshida_4, substeps: 100000)],
                grids: [(rows: 1, columns: 1, method: implicit_euler)], clouds: [(count: 1, substeps: 2)])"#,
        )
        .unwrap();
        assert_eq!((scene.method, scene.substeps), (Method::Yoshida4, 3.into()));
        let own: Vec<_> = scene.bodies.iter().map(|body| (body.method, body.substeps)).collect();
        let expected = [
            (None, None),
            (Some(Method::Yoshida4), Some(100_000.into())),
            (Some(Method::ImplicitEuler), None),
            (None, Some(2.into())),
        ];
        assert_eq!(own, expected);
    }

    #[test]
    fn labels_and_trails_are_there_where_they_are_given() {
        let text = format!(
            r#"(version: 1, trails: true, bodies: [(), (label: "größe {}"), (shape: sphere(radius_m: 1), scenery: true, label: "3 s")])"#,
            "x".repeat(LABEL_LIMIT - 6)
        );
        let scene = crate::scene::Scene::parse("t", &text).unwrap();
        let labels: Vec<_> =
            scene.labels.iter().map(|(id, label)| (*id, label.chars().count())).collect();
        assert_eq!((labels, scene.trails), (vec![(1, LABEL_LIMIT), (2, 3)], true));
        assert!(!crate::scene::Scene::parse("t", "(version: 1)").unwrap().trails);
    }
}
