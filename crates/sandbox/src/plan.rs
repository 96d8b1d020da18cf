//! What one step runs, in order, read from the compiled schedule.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use motion::{Damping, Drag, Gravity, Groups, Method, MutualGravity, OwnLaws, Wells, Wind};
use scene::{Scene, StepKind};

use crate::methods::cost;
use crate::session::{Options, Overrides, Session};

/// The plan of `scene`, changed by `overrides`, as text.
#[must_use]
pub fn text(scene: Scene, overrides: Overrides) -> String {
    let options = Options { pictures: false, interpolate: false, overrides, ..Options::default() };
    let mut session = Session::new(scene, options);
    let laws = Laws::of(session.world_mut());
    let scene = session.scene();
    let step = match scene.step {
        StepKind::Fixed => format!("{} Hz", scene.step_hz),
        StepKind::Frame => "the frame's own length".to_owned(),
    };
    let method = session.stepper().method();
    let mut plan = format!(
        "step of `{}`: {}, {step}{}, {} bodies\n",
        scene.name,
        method.name(),
        if scene.substeps == 1 { String::new() } else { format!(" in {} substeps", scene.substeps) },
        scene.bodies.len()
    );
    let systems = session.stepper().systems();
    let integrating = systems.iter().filter(|system| integrated(system).is_some()).count();
    for (i, system) in systems.iter().enumerate() {
        let name = system.split(['<', ':']).next().unwrap_or(system);
        let what = match integrated(system) {
            Some((method, filter)) => {
                let claims = method.claims();
                let whose = if integrating > 1 { whose(filter) } else { "" };
                let coupled = if name == "integrate_groups" { &laws.coupled } else { "" };
                let Laws { accelerating, damping, .. } = &laws;
                format!("{}: {}{whose}{coupled}{accelerating}{damping}", claims.title, cost(claims))
            }
            None => laws.what(name),
        };
        plan += &format!("{:>3}. {name:<24} {what}\n", i + 1);
    }
    if systems.iter().any(|system| system.starts_with("integrate_in_one_pass")) {
        let halves = ["integrate_acceleration", "integrate_velocity"];
        let [first, second] = if method == Method::ExplicitEuler { [halves[1], halves[0]] } else { halves };
        plan += &format!("     ( {first}, then {second}, one pass over memory, equal bits )\n");
    }
    plan
}

/// The method of a system `integrate<RungeKutta4, Without<OwnMethod>>`, and what follows it in the brackets.
fn integrated(system: &str) -> Option<(Method, &str)> {
    let name = system.strip_prefix("integrate_groups").or_else(|| system.strip_prefix("integrate"))?;
    let parameters = name.trim_start_matches("::").strip_prefix('<')?;
    let (name, filter) = parameters.split_once([',', '>'])?;
    // A method's type is called what the method is.
    let method = Method::ALL.into_iter().find(|method| format!("{method:?}") == name)?;
    Some((method, filter.trim()))
}

/// Which bodies a system moves where several share them.
fn whose(filter: &str) -> &'static str {
    if filter.starts_with("Without") {
        ", bodies without a method of their own"
    } else {
        ", bodies that ask for it"
    }
}

/// The laws of a world in words, each behind a semicolon.
struct Laws {
    /// Those between bodies.
    coupled: String,
    accelerating: String,
    damping: String,
}

impl Laws {
    fn of(world: &mut World) -> Self {
        let mut accelerating = String::new();
        if let Some(Gravity { acceleration: g, on }) = world.get_resource::<Gravity>() {
            let on = if *on { "on" } else { "off" };
            accelerating += &format!("; gravity ({}, {}, {}) m/s², {on}", g.x, g.y, g.z);
        }
        if let Some(Drag { linear, quadratic, wind }) = world.get_resource::<Drag>() {
            accelerating += &format!("; drag {linear} 1/s, {quadratic} 1/m");
            if let Some(Wind { velocity: v, gust, gust_hz }) = wind {
                accelerating += &format!("; wind ({}, {}, {}) m/s", v.x, v.y, v.z);
                if !wind.is_some_and(|wind| wind.is_steady()) {
                    accelerating += &format!(", gusts {gust} m/s at {gust_hz} Hz");
                }
            }
        }
        if let Some(Wells(wells)) = world.get_resource::<Wells>() {
            accelerating += &format!("; wells: {}", wells.len());
        }
        let mut own = BTreeMap::new();
        for law in world.query::<&OwnLaws>().iter(world).flat_map(OwnLaws::laws) {
            *own.entry(law.name()).or_insert(0) += 1;
        }
        for (name, count) in own {
            accelerating += &format!("; {name}: {count}");
        }
        let damping = match world.get_resource::<Damping>() {
            Some(Damping { model, rate }) => format!("; damping {} {rate} 1/s", model.name()),
            None => String::new(),
        };
        Self { coupled: coupled(world), accelerating, damping }
    }

    fn what(&self, system: &str) -> String {
        let Self { accelerating, damping, .. } = self;
        match system {
            "emit_particles" => {
                "particles that are due are born, and taken back when their life is over".to_owned()
            }
            "apply_forces" => "queued pushes become forces".to_owned(),
            "integrate_acceleration" => format!("v += (F w + g) h{accelerating}"),
            "integrate_velocity" => format!("x += v h{damping}"),
            "integrate_in_one_pass" => format!("both middle systems{accelerating}{damping}"),
            "remember_steps" => "bodies new to position Verlet start with the Taylor value".to_owned(),
            "remember_accelerations" => "room for the last acceleration, the next step's first".to_owned(),
            "apply_deferred" => "bodies get what was given to them".to_owned(),
            "clear_forces" => "forces last one tick".to_owned(),
            "quarantine_bodies" => "freezes what would turn non-finite".to_owned(),
            _ => String::new(),
        }
    }
}

/// What acts between bodies, in words, each behind a semicolon.
fn coupled(world: &World) -> String {
    let Some(groups) = world.get_resource::<Groups>() else { return String::new() };
    let count = |count: usize, one: &str| format!("; {count} {one}{}", if count == 1 { "" } else { "s" });
    let bodies = if groups.bodies() == 1 { "body" } else { "bodies" };
    let mut words = count(groups.len(), "group") + &format!(" of {} {bodies}", groups.bodies());
    if groups.springs() > 0 {
        words += &count(groups.springs(), "spring");
    }
    if let Some(MutualGravity { constant, softening }) = world.get_resource::<MutualGravity>() {
        words += &format!("; mutual gravity {constant} m³/(kg s²), softened over {softening} m");
    }
    words
}

#[cfg(test)]
mod tests {
    use motion::units::Vector;
    use motion::{Curve, Thrust, Well};

    use super::*;

    #[test]
    fn laws_are_named_with_their_numbers() {
        let mut world = World::new();
        assert_eq!(Laws::of(&mut world).accelerating, "");
        world.insert_resource(Gravity::EARTH);
        world.insert_resource(Drag::new(0.1, 0.02));
        let well = Well { position: Vector::ZERO, strength: 1.0, softening: 0.0 };
        world.insert_resource(Wells(vec![well; 2]));
        let thrust = Thrust::new(Curve::Polynomial(vec![Vector::X]), 0.0, 1.0);
        world.spawn(OwnLaws::new(vec![Box::new(thrust)]));
        let expected = "; gravity (0, -9.8, 0) m/s², on; drag 0.1 1/s, 0.02 1/m; wells: 2; thrusts: 1";
        assert_eq!(Laws::of(&mut world).accelerating, expected);
    }

    #[test]
    fn the_name_of_a_system_says_its_method() {
        for (name, method, filter) in [
            ("integrate<RungeKutta4, Without<OwnMethod>>", Method::RungeKutta4, "Without<OwnMethod>>"),
            ("integrate::<Yoshida4, With<Yoshida4>>", Method::Yoshida4, "With<Yoshida4>>"),
            ("integrate<VelocityVerlet>", Method::VelocityVerlet, ""),
        ] {
            assert_eq!(integrated(name), Some((method, filter)));
        }
        for name in
            ["integrate_in_one_pass<ExplicitEuler>", "integrate_velocity", "integrate<Rk9>", "clear_forces"]
        {
            assert_eq!(integrated(name), None);
        }
    }
}
