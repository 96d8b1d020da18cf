//! `sandbox plan`: the systems of one step, in order, read from the compiled schedule.

use clap::Args;
use history::Overrides;
use motion::{LawTexts, Method};
use scene::{Scene, StepKind, Substepping, byte_words, shown};

use crate::args::{SceneName, method};
use crate::failure::Failure;
use crate::output::command_files::CommandFiles;
use crate::output::show;
use cockpit::app::session::Session;
use cockpit::methods::cost;
use cockpit::stage::options::{Options, check};

pub(super) const EXAMPLES: &str = "\
Example:
  sandbox plan tutorial --method runge_kutta_4";

/// Prints the systems of one step.
#[derive(Args, Debug)]
pub(crate) struct PlanArgs {
    /// A shipped scene or a file
    scene: SceneName,
    /// Method of integration; overrides the scene. Bodies with their own method keep it
    #[arg(long, value_name = "M", value_parser = method)]
    method: Option<Method>,
}

/// Does what `sandbox plan` says.
pub(crate) fn run(args: &PlanArgs) -> Result<(), Failure> {
    let overrides = Overrides { method: args.method, ..Overrides::default() };
    let scene = CommandFiles::default().named_scene(&args.scene)?;
    check(overrides, &scene)?;
    show(&text(scene, overrides))
}

/// The plan of `scene`, changed by `overrides`, as text.
#[must_use]
pub fn text(scene: Scene, overrides: Overrides) -> String {
    let options = Options { pictures: false, interpolate: false, overrides, ..Options::default() };
    let session = Session::new(scene, options);
    let LawTexts { between_bodies, on_bodies, damping } = LawTexts::of(&session.stage.sim().world);
    let [between_bodies, accelerating] = [&between_bodies, &on_bodies].map(joined);
    let damping = joined(&damping);
    let scene = &session.stage.sim().scene;
    let step = match scene.step {
        StepKind::Fixed => format!("{} Hz", shown(scene.step_hz)),
        StepKind::Frame => "the frame's own length".to_owned(),
    };
    let (method, scene_substeps) = (session.stage.sim().stepper.method(), scene.substeps);
    let mut plan = format!(
        "step of `{}`: {}, {step}{}, {} bodies\n",
        scene.name,
        method.name(),
        if scene.substeps == Substepping::Fixed(1) {
            String::new()
        } else {
            format!(" in {:#} substeps", scene.substeps)
        },
        scene.bodies.len()
    );
    let systems = session.stage.sim().stepper.systems();
    let integrating = systems.iter().filter(|system| integrated(system).is_some()).count();
    for (i, system) in systems.iter().enumerate() {
        let name = system.split(['<', ':']).next().unwrap_or(system);
        let what = match integrated(system) {
            Some((method, filter)) => {
                let claims = method.claims();
                let whose = if integrating > 1 { whose(filter) } else { "" };
                let coupled = if name == "integrate_groups" { &between_bodies } else { "" };
                format!("{}: {}{whose}{coupled}{accelerating}{damping}", claims.title, cost(claims))
            }
            None => what(name, &accelerating, &damping),
        };
        plan += &format!("{:>3}. {name:<24} {what}\n", i + 1);
    }
    if systems.iter().any(|system| system.starts_with("integrate_in_one_pass")) {
        let halves = ["integrate_acceleration", "integrate_velocity"];
        let [first, second] =
            if method == Method::ExplicitEuler { [halves[1], halves[0]] } else { halves };
        plan += &format!("     ( {first}, then {second}, one pass over memory, equal bits )\n");
    }
    for emitter in &session.stage.sim().scene.emitters {
        let Some(swarm) = &emitter.on_device else { continue };
        let (particles, substeps) =
            (swarm.slots(), swarm.substeps.unwrap_or(scene_substeps.least()));
        plan += &format!(
            "     ( on the graphics device: `{}`, {particles} particles, {}, {substeps} dispatch{} per tick, {} bytes per particle and \
             dispatch, {} )\n",
            emitter.name,
            swarm.method.claims().title,
            if substeps == 1 { "" } else { "es" },
            swarm.bytes_per_step(),
            byte_words(swarm.bytes()),
        );
    }
    plan
}

/// The method of a system `integrate<RungeKutta4, Without<OwnMethod>>`, and what follows it in the brackets.
fn integrated(system: &str) -> Option<(Method, &str)> {
    let name =
        system.strip_prefix("integrate_groups").or_else(|| system.strip_prefix("integrate"))?;
    let parameters = name.trim_start_matches("::").strip_prefix('<')?;
    let (name, filter) = parameters.split_once([',', '>'])?;
    // The type of a method has the name of its variant.
    let method = Method::ALL.into_iter().find(|method| format!("{method:?}") == name)?;
    Some((method, filter.trim()))
}

/// The bodies that a system moves, in words, if several systems share the bodies.
fn whose(filter: &str) -> &'static str {
    if filter.starts_with("Without") {
        ", bodies without their own method"
    } else {
        ", bodies with this method as their own"
    }
}

/// Joins texts, each after a semicolon.
fn joined<'a>(texts: impl IntoIterator<Item = &'a String>) -> String {
    texts.into_iter().map(|text| format!("; {text}")).collect()
}

/// The words for a system that integrates nothing, or one half of a step of Euler.
fn what(system: &str, accelerating: &str, damping: &str) -> String {
    match system {
        "carry_wells" => "wells move with the bodies on which they ride".to_owned(),
        "follow_motion" => "immovable bodies go where their motion has them".to_owned(),
        "emit_particles" => {
            "particles that are due are born, and taken back when their life is over".to_owned()
        }
        "advance_swarms" => {
            "births, deaths and laws of particles on the graphics device are logged for it"
                .to_owned()
        }
        "apply_forces" => "queued pushes become forces".to_owned(),
        "integrate_acceleration" => format!("v += (F w + g) h{accelerating}"),
        "integrate_velocity" => format!("x += v h{damping}"),
        "integrate_in_one_pass" => format!("both middle systems{accelerating}{damping}"),
        "remember_steps" => "bodies new to position Verlet start with the Taylor value".to_owned(),
        "remember_accelerations" => {
            "room for the last acceleration, the next step's first".to_owned()
        }
        "apply_deferred" => "bodies get what was given to them".to_owned(),
        "clear_forces" => "forces last one tick".to_owned(),
        "quarantine_bodies" => "quarantines bodies that would become non-finite".to_owned(),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_system_says_its_method() {
        for (name, method, filter) in [
            (
                "integrate<RungeKutta4, Without<OwnMethod>>",
                Method::RungeKutta4,
                "Without<OwnMethod>>",
            ),
            ("integrate::<Yoshida4, With<Yoshida4>>", Method::Yoshida4, "With<Yoshida4>>"),
            ("integrate<VelocityVerlet>", Method::VelocityVerlet, ""),
        ] {
            assert_eq!(integrated(name), Some((method, filter)));
        }
        for name in [
            "integrate_in_one_pass<ExplicitEuler>",
            "integrate_velocity",
            "integrate<Rk9>",
            "clear_forces",
        ] {
            assert_eq!(integrated(name), None);
        }
    }
}
