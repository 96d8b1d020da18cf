//! What one step runs, in order, read from the compiled schedule.

use motion::{Damping, Gravity, Passes};
use scene::{Scene, StepKind};

use crate::session::{Options, Overrides, Session};

/// The plan of `scene`, changed by `overrides`, as text.
#[must_use]
pub fn text(scene: Scene, overrides: Overrides) -> String {
    let options = Options { pictures: false, interpolate: false, overrides, ..Options::default() };
    let session = Session::new(scene, options);
    let scene = session.scene();
    let step = match scene.step {
        StepKind::Fixed => format!("{} Hz", scene.step_hz),
        StepKind::Frame => "the frame's own length".to_owned(),
    };
    let method = session.stepper().method().name();
    let mut plan = format!("step of `{}`: {method}, {step}, {} bodies\n", scene.name, scene.bodies.len());
    for (i, system) in session.stepper().systems().iter().enumerate() {
        // Generic parameters say nothing to a person.
        let system = system.split('<').next().unwrap_or(system);
        plan += &format!("  {}. {system:<24} {}\n", i + 1, what(system, &session));
    }
    if session.stepper().passes() == Passes::One {
        plan += "     ( integrate_acceleration and integrate_velocity, one pass over memory, equal bits )\n";
    }
    plan
}

fn what(system: &str, session: &Session) -> String {
    let gravity = match session.world().get_resource::<Gravity>() {
        Some(Gravity { acceleration: g, on }) => {
            format!("; gravity ({}, {}, {}) m/s², {}", g.x, g.y, g.z, if *on { "on" } else { "off" })
        }
        None => String::new(),
    };
    let damping = match session.world().get_resource::<Damping>() {
        Some(Damping { model, rate }) => format!("; damping {} {rate} 1/s", model.name()),
        None => String::new(),
    };
    match system {
        "apply_forces" => "queued pushes become forces".to_owned(),
        "integrate_acceleration" => format!("v += (F w + g) h{gravity}"),
        "integrate_velocity" => format!("x += v h{damping}"),
        "integrate_in_one_pass" => format!("both middle systems{gravity}{damping}"),
        "clear_forces" => "forces last one tick".to_owned(),
        "quarantine_bodies" => "freezes what would turn non-finite".to_owned(),
        _ => String::new(),
    }
}
