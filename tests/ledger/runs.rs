//! Books of whole runs: the panel, the summary and the verdict.

use motion::Method;
use sandbox::input::Input;
use scene::ChangeAction;
use serde_json::Value;

use crate::rigs::{Drive, H, Said, summarized};

/// Runs the program on a scene, with a script if it has steps.
fn run(scene: &str, script: &str, flags: &str) -> (Said, Value) {
    let scene = format!("(version: 1, {scene})");
    let with_script = if script.is_empty() { "" } else { "--script books.script" };
    let files = [("books.ron", scene.as_str()), ("books.script", script)];
    summarized(files, &format!("run books.ron {with_script} {flags}"))
}

const WORKING: [(&str, &str); 4] = [
    ("damping: (rate_per_s: 0.4)", ""),
    ("drag: (linear_per_s: 0.4, quadratic_per_m: 0.1)", ""),
    ("thrusts: [(body: \"ball\", curve: polynomial([(1, 0, 0)]), until_s: 0.5)]", ""),
    (
        "seed: 1",
        "[(at_s: 0.2, do: push(\"ball\", (30, 0, 0))), (at_s: 0.4, do: set_velocity(\"ball\", (9, 0, 0))), (at_s: 0.6, do: press(\"G\"))]",
    ),
];

fn falling(key: &str, bound: f64) -> String {
    format!(
        "method: runge_kutta_4, gravity: (), {key}, bodies: [(name: \"ball\", velocity_m_s: (3, 1, 0))],
         expect: (energy_drift_below: {bound:e})"
    )
}

#[test]
fn a_bound_of_the_energy_is_checked_where_something_does_work() {
    for (key, script) in WORKING {
        let (said, summary) = run(&falling(key, 1e-7), script, "--assert --seconds 1");
        said.says(0, "");
        let change = summary["ledger"]["change_j"].as_f64().unwrap();
        let without_books = change.abs() / summary["kinetic_energy_j"].as_f64().unwrap();
        assert!(without_books > 1e-3, "{key}: the energy itself changed by {change} J");
        // The same bound shows a worse method.
        let (said, _) =
            run(&falling(key, 1e-7), script, "--assert --seconds 1 --method explicit_euler");
        assert!(said.ends(1).err.starts_with("sandbox: energy drifted by "), "{key}");
    }
}

#[test]
fn a_bound_of_the_energy_holds_with_clicks() {
    let scene = "bodies: [(name: \"ball\", velocity_m_s: (3, 1, 0), mass_kg: 2)], push: (), expect: (energy_drift_below: 1e-12)";
    let script = "[(at_tick: 12, do: push(\"ball\", (300, 0, 0))), (at_tick: 40, do: push(\"ball\", (-30, 900, 0)))]";
    for method in ["explicit_euler", "semi_implicit_euler", "implicit_euler"] {
        let (said, summary) =
            run(scene, script, &format!("--assert --seconds 1 --method {method}"));
        said.says(0, "");
        assert!(summary["ledger"]["push_work_j"].as_f64().unwrap() > 10.0, "{method}: {summary}");
    }
}

#[test]
fn the_summary_has_books_where_they_were_asked_for_and_the_run_is_the_same() {
    let scene = "gravity: (), drag: (linear_per_s: 0.4), bodies: [(name: \"ball\", velocity_m_s: (3, 1, 0), mass_kg: 2)]";
    let script = "[(at_tick: 12, do: push(\"ball\", (30, 0, 0)))]";
    let (said, kept) = run(scene, script, "--seconds 1 --ledger");
    said.says(0, "");
    let (_, plain) = run(scene, script, "--seconds 1");
    assert_eq!(plain["state_hash"], kept["state_hash"]);
    assert_eq!((plain.get("ledger"), plain["laws"].clone()), (None, kept["laws"].clone()));
    let ledger = kept["ledger"].as_object().unwrap();
    let keys = "kept_s change_j push_work_j laws damping_j limits_j anchors_j interventions_j residual_j \
        residual_j_per_s relative_residual momentum angular_momentum";
    let keys: Vec<_> = keys.split(' ').collect();
    assert_eq!(ledger.keys().collect::<Vec<_>>(), keys);
    let number = |value: &Value| value.as_f64().unwrap();
    let energy = |summary: &Value| {
        number(&summary["kinetic_energy_j"]) + number(&summary["potential_energy_j"])
    };
    let change = energy(&kept) - number(&kept["energy_at_start_j"]);
    assert!((number(&ledger["change_j"]) - change).abs() < 1e-10);
    let lines = number(&ledger["push_work_j"])
        + number(&ledger["laws"]["drag"])
        + number(&ledger["residual_j"]);
    assert!((lines - change).abs() < 1e-10, "{ledger:?}");
    assert!(number(&ledger["push_work_j"]) > 0.5 && number(&ledger["laws"]["drag"]) < -1.0);
    assert!((number(&ledger["kept_s"]) - 1.0).abs() < 1e-12);
    let momentum = &ledger["momentum"];
    assert!((number(&momentum["pushes_n_s"][0]) - 30.0 * H).abs() < 1e-12);
    assert!((number(&momentum["laws"]["gravity"][1]) + 9.8 * 2.0).abs() < 1e-11);
    let angular = &ledger["angular_momentum"];
    let now = number(&kept["angular_momentum_kg_m2_s"][2]);
    // At the start it flies through the origin.
    assert!((number(&angular["change_n_m_s"][2]) - now).abs() < 1e-10 && now < -10.0, "{angular}");
    let sum =
        ["pushes_n_m_s", "damping_n_m_s", "residual_n_m_s"].map(|line| number(&angular[line][2]));
    let laws = ["gravity", "drag"].map(|law| number(&angular["laws"][law][2]));
    assert!((sum.iter().chain(&laws).sum::<f64>() - now).abs() < 1e-10, "{angular}");
}

#[test]
fn the_panel_keeps_books_while_it_is_open_and_no_longer() {
    let mut drive = Drive::tutorial();
    assert!(drive.ticks(3).session.tools.ledger().is_none());
    drive.press("G").press("B").ticks(60);
    let ledger = drive.session.tools.ledger().unwrap();
    assert!((ledger.seconds() - 60.0 * H).abs() < 1e-12);
    // Semi-implicit Euler loses `m g² h² / 2` a tick and body; damping makes it a little less.
    let bodies = motion::totals(&drive.session.stage.sim().world).momentum.y / drive.v("player").y;
    let lost = -bodies * 9.8 * 9.8 * H * H / 2.0 * 60.0;
    let ledger = drive.session.tools.ledger().unwrap();
    let residual = ledger.since_opening().energy.residual;
    assert!((residual / lost - 1.0).abs() < 0.25, "{residual} J, about {lost} J");
    assert!(ledger.since_opening().energy.damping < 0.0);
    // It begins again with the scene.
    drive.press("F1").ticks(1);
    let ledger = drive.session.tools.ledger().unwrap();
    assert!((ledger.seconds() - H).abs() < 1e-12, "{} s", ledger.seconds());
    assert_eq!(ledger.since_opening().energy.interventions, 0.0);
    drive.press("Escape").ticks(1);
    assert!(drive.session.tools.ledger().is_none());
}

#[test]
fn a_change_of_the_method_begins_a_ledger_and_what_was_before_stays_with_the_method_before() {
    let method = |method| Input::Change(ChangeAction::SetMethod(method));
    let mut drive = Drive::shipped("orbit");
    drive.press("B").give([method(Method::ExplicitEuler)]).ticks(60);
    let invented =
        |drive: &Drive| drive.session.tools.ledger().unwrap().since_opening().energy.residual;
    let by_euler = invented(&drive);
    assert!(by_euler > 1e-6, "{by_euler} J");
    drive.give([method(Method::RungeKutta4)]).ticks(30);
    let (by_runge_kutta, ledger) = (invented(&drive), drive.session.tools.ledger().unwrap());
    assert!(by_runge_kutta.abs() < 1e-3 * by_euler, "{by_runge_kutta} J of {by_euler} J");
    assert!(
        ledger.seconds() < 31.0 / drive.session.stage.sim().scene.step_hz,
        "{} s",
        ledger.seconds()
    );
}

#[test]
fn books_go_on_with_the_scene_that_is_opened() {
    let mut drive = Drive::tutorial();
    drive.press("B").ticks(10);
    drive.session.open(scene::load("oscillator").unwrap());
    drive.ticks(12);
    let ledger = drive.session.tools.ledger().unwrap();
    assert!((ledger.seconds() - 12.0 * H).abs() < 1e-9, "{}", ledger.seconds());
    assert!(ledger.energies().potential.iter().any(|(law, _)| *law == "springs"));
}
