//! The keys of a scene that declare its effects.

use motion::effects::Effect;

use crate::raw;
use crate::scene::coupled::Declaration;
use crate::text::locate;

/// Each effect that the scene declares, with the first key that does so, in the order of the receipt.
pub(crate) fn declared(raw: &raw::Scene, text: &str) -> Vec<Declaration> {
    let own = |key: &str, has: fn(&raw::Body) -> bool| {
        raw.bodies.iter().position(has).map(|i| format!("bodies[{i}].{key}"))
    };
    let path = |effect: Effect| match effect {
        Effect::Damping => raw
            .path("damping")
            .or_else(|| own("damping_per_s", |body| body.damping_per_s.is_some()))
            .or_else(|| {
                let soft =
                    raw.soft_bodies.iter().position(|soft| soft.keys.damping_per_s.is_some());
                soft.map(|i| format!("soft_bodies[{i}].damping_per_s"))
            }),
        Effect::Drag => raw.path("drag").or_else(|| {
            let mut keys = raw.bodies.iter().map(raw::Body::drag_key).enumerate();
            keys.find_map(|(i, key)| key.map(|key| format!("bodies[{i}].{key}")))
        }),
        Effect::Springs => raw.path("springs").or_else(|| raw.path("soft_bodies")),
        Effect::SpeedLimits => own("max_speed_m_s", |body| body.max_speed_m_s.is_some()),
        Effect::AxisLocks => own("locked_axes", |body| {
            body.locked_axes.as_ref().is_some_and(|axes| !axes.is_empty())
        }),
        Effect::Gravity
        | Effect::Wind
        | Effect::Wells
        | Effect::MutualGravity
        | Effect::Thrusts
        | Effect::Emitters => raw.path(effect.name()),
    };
    let mut declared: Vec<_> = Effect::ALL
        .into_iter()
        .filter_map(|effect| Some(Declaration { effect, path: path(effect)?, line: None }))
        .collect();
    let paths: Vec<&str> = declared.iter().map(|found| found.path.as_str()).collect();
    let lines = locate::lines(text, &paths);
    declared.iter_mut().zip(lines).for_each(|(found, line)| found.line = line);
    declared
}

/// The keys of a scene that call for a law of [`motion::LAWS`], in words.
#[must_use]
pub fn key_of_law(law: &str) -> &str {
    match law {
        "damping" => "damping: (model: exact)",
        "springs" => "springs, soft_bodies",
        key => key,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn each_effect_has_the_line_of_the_first_key_that_calls_for_it() {
        let text = r#"(
version: 1, // gravity: here only in words
bodies: [
  (name: "a", max_speed_m_s: 3, locked_axes: []),
  (name: "b", damping_per_s: 1,
   max_speed_m_s: 2, locked_axes: [z]),
],
wells: [
  (strength_m3_s2: 1),
],
springs: [
],
soft_bodies: [
  chain(points: 2, to_m: (1, 0, 0), stiffness_n_m: 1, damping_per_s: 1),
],
emitters: [
  (rate_per_s: 1, speed_m_s: 1, life_s: 1)],
wind: (velocity_m_s: (1, 0, 0)),
thrusts: [(body: "a", curve: polynomial([(1, 0, 0)]))],
mutual_gravity: (),
gravity: (), drag: (linear_per_s: 1),
)"#;
        let scene = Scene::parse("t", text).unwrap_or_else(|error| panic!("{error}"));
        let declared: Vec<_> = scene
            .declared
            .iter()
            .map(|found| (found.effect, found.path.as_str(), found.line))
            .collect();
        let expected = [
            (Effect::Gravity, "gravity", Some(21)),
            (Effect::Damping, "bodies[1].damping_per_s", Some(5)),
            (Effect::Drag, "drag", Some(21)),
            (Effect::Wind, "wind", Some(18)),
            (Effect::Wells, "wells[0]", Some(9)),
            (Effect::MutualGravity, "mutual_gravity", Some(20)),
            (Effect::Thrusts, "thrusts[0]", Some(19)),
            (Effect::Springs, "soft_bodies[0]", Some(14)),
            (Effect::SpeedLimits, "bodies[0].max_speed_m_s", Some(4)),
            (Effect::AxisLocks, "bodies[1].locked_axes", Some(6)),
            (Effect::Emitters, "emitters[0]", Some(17)),
        ];
        assert_eq!(declared, expected);
        assert!(
            Scene::parse("t", "(version: 1, wells: [], bodies: [()])").unwrap().declared.is_empty()
        );
    }

    #[test]
    fn a_rate_of_soft_bodies_alone_declares_damping_too() {
        let text = "(version: 1, soft_bodies: [chain(points: 2, to_m: (1, 0, 0), stiffness_n_m: 1),
            chain(points: 2, to_m: (1, 0, 0), stiffness_n_m: 1, damping_per_s: 2)])";
        let scene = Scene::parse("t", text).unwrap();
        assert_eq!(scene.declared[0].path, "soft_bodies[1].damping_per_s");
        assert_eq!(scene.declared[0].line, Some(2));
        assert!(scene.damping.is_some_and(|damping| damping.rate == 0.0));
    }
}
