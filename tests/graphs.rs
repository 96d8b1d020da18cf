//! Graphs: samples of several bodies and of their ghosts, which are states of plain runs.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use history::{REFERENCE_SUBSTEPS, Simulation};
use motion::Method;
use sandbox::input::Button;
use scene::Scene;

use crate::rigs::{Cockpit, H, bits, close, remove};

/// A row of a saved graph.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    time: f64,
    body: String,
    run: String,
    method: String,
    position: DVec3,
    velocity: DVec3,
    /// Absent of soft bodies.
    acceleration: Option<DVec3>,
    kinetic: f64,
}

/// What `Save CSV` saves; an absent column is an empty text.
fn saved(cockpit: &mut Cockpit) -> Vec<Row> {
    cockpit.drive.give([]);
    // The run stands still meanwhile: the table is of the last tick.
    click(cockpit, "Look");
    click(cockpit, "Save CSV");
    let table = cockpit.saved_table();
    let mut lines = table.lines();
    let header: Vec<_> = lines.next().unwrap().split(',').collect();
    lines.map(|line| row(&header, &line.split(',').collect::<Vec<_>>())).collect()
}

fn row(header: &[&str], cells: &[&str]) -> Row {
    assert_eq!(header.len(), cells.len());
    let cell =
        |name: &str| header.iter().position(|other| *other == name).map_or("", |at| cells[at]);
    let vector = |quantity: &str, unit: &str| {
        let parts = ["x", "y", "z"].map(|axis| cell(&format!("{quantity}_{axis}_{unit}")).parse());
        let [Ok(x), Ok(y), Ok(z)] = parts else { return None };
        Some(DVec3::new(x, y, z))
    };
    Row {
        time: cell("time_s").parse().unwrap(),
        body: cell("body").to_owned(),
        run: cell("run").to_owned(),
        method: cell("method").to_owned(),
        position: vector("position", "m").unwrap(),
        velocity: vector("velocity", "m_s").unwrap(),
        acceleration: vector("acceleration", "m_s2"),
        kinetic: cell("kinetic_energy_j").parse().unwrap(),
    }
}

/// A scene with open graphs.
fn graphs(scene: &str) -> Cockpit {
    let mut cockpit = Cockpit::of(scene, [1600, 1200]);
    cockpit.drive.press("Y").press("F1").give([]);
    cockpit
}

fn select(cockpit: &mut Cockpit, body: &str) {
    let pixel = cockpit.seen(body);
    assert_eq!(cockpit.drive.select(pixel).as_deref(), Some(body));
    cockpit.drive.give([]);
}

/// Clicks the control of that name while the run stands still.
fn click(cockpit: &mut Cockpit, name: &str) {
    let middle = cockpit.middle_of(name);
    cockpit.drive.click(Button::Left, middle).give([]);
}

fn keep(cockpit: &mut Cockpit, bodies: &[&str]) {
    for body in bodies {
        select(cockpit, body);
        click(cockpit, "Keep");
    }
}

/// Fails unless the rows of `body` in `run` by `method` have the states of `simulation` at the ends of the ticks from `first` on.
#[track_caller]
fn assert_states(
    rows: &[Row],
    (body, run, method): (&str, &str, &str),
    mut simulation: Simulation,
    first: u64,
) {
    let of = |row: &&Row| (&*row.body, &*row.run, &*row.method) == (body, run, method);
    let rows: Vec<_> = rows.iter().filter(of).collect();
    assert!(rows.len() > 5, "{body}, {run}, {method}");
    let id = simulation.scene.names.find(body).unwrap();
    simulation.run(first);
    for row in rows {
        let time = simulation.ticks() as f64 / simulation.scene.step_hz;
        close(row.time, time, 1e-12);
        let (_, position, velocity) = simulation.states().find(|(other, ..)| *other == id).unwrap();
        let what = format!("{body}, {run}, {method} at {time} s");
        if method == Method::PositionVerlet.name() {
            assert_eq!(row.position, position, "{what}");
        } else {
            assert_eq!(bits(row.position, row.velocity), bits(position, velocity), "{what}");
        }
        simulation.tick();
    }
}

fn shipped(name: &str) -> Simulation {
    Simulation::new(scene::load(name).unwrap())
}

#[test]
fn kept_bodies_have_the_states_of_a_plain_run_and_stay_until_they_are_removed() {
    let mut cockpit = graphs("bridge");
    keep(&mut cockpit, &["plank2", "plank5"]);
    select(&mut cockpit, "plank8");
    cockpit.drive.ticks(60);
    let rows = saved(&mut cockpit);
    let bodies = |rows: &[Row]| rows.iter().map(|row| row.body.clone()).collect::<BTreeSet<_>>();
    assert_eq!(bodies(&rows), ["plank2", "plank5", "plank8"].map(str::to_owned).into());
    for body in ["plank2", "plank5", "plank8"] {
        assert_states(&rows, (body, "", ""), shipped("bridge"), 0);
    }
    assert_eq!(rows.len(), 3 * 61);

    // Another selection takes the place of one that is not kept.
    select(&mut cockpit, "plank0");
    assert_eq!(
        bodies(&saved(&mut cockpit)),
        ["plank0", "plank2", "plank5"].map(str::to_owned).into()
    );
    let [corner, size] = cockpit.session().view.view_area();
    assert_eq!(cockpit.drive.select(corner + size * DVec2::new(0.5, 0.08)), None);
    click(&mut cockpit, "Remove plank2");
    // One body has the table that one body always had.
    let rows = saved(&mut cockpit);
    assert_eq!((bodies(&rows), rows.len()), ([String::new()].into(), 61));
    click(&mut cockpit, "Remove plank5");
    assert!(cockpit.session().controls().iter().all(|control| control.name != "Remove plank5"));
}

#[test]
fn ghosts_have_the_states_of_runs_by_their_methods_and_the_distances_of_their_list() {
    let mut cockpit = graphs("oscillator");
    keep(&mut cockpit, &["ball"]);
    select(&mut cockpit, "ball");
    cockpit.drive.press("T").press("F1").give([]);
    select(&mut cockpit, "ball");
    cockpit.drive.ticks(40);
    let rows = saved(&mut cockpit);
    let alone = |method, substeps: Option<u32>| {
        let mut scene = scene::load("oscillator").unwrap();
        scene.bodies.iter_mut().for_each(|body| body.method = None);
        scene.method = method;
        scene.substeps = substeps.map_or(scene.substeps, Into::into);
        Simulation::new(scene)
    };
    let solid = cockpit.session().stage.sim().stepper.method();
    for method in Method::ALL {
        let run = if method == solid { "solid" } else { "ghost" };
        assert_states(&rows, ("ball", run, method.name()), alone(method, None), 0);
    }
    let fine = || alone(Method::RungeKutta4, Some(REFERENCE_SUBSTEPS));
    assert_states(&rows, ("ball", "reference", Method::RungeKutta4.name()), fine(), 0);
    assert_eq!(rows.iter().map(|row| (&row.run, &row.method)).collect::<BTreeSet<_>>().len(), 10);

    let last = |run: &str, method: Method| {
        rows.iter().rfind(|row| row.run == run && row.method == method.name()).unwrap()
    };
    let there = last("reference", Method::RungeKutta4).position;
    let session = cockpit.session();
    for row in session.tools.ghosts(&session.stage).into_iter().filter(|row| row.distance.is_some())
    {
        let method = row.method.unwrap();
        let run = if method == solid { "solid" } else { "ghost" };
        assert_eq!(Some(last(run, method).position.distance(there)), row.distance, "{method:?}");
    }
    // The velocity that position Verlet keeps is one of half a step before.
    let ghost = last("ghost", Method::PositionVerlet);
    let mut synchronized = alone(Method::PositionVerlet, None);
    synchronized.run(40);
    let ball = synchronized.scene.names.find("ball").unwrap();
    let velocity = |run: &Simulation| run.states().find(|(id, ..)| *id == ball).unwrap().2;
    let lagging = velocity(&synchronized);
    synchronized.set_method(Method::VelocityVerlet);
    close(ghost.velocity.x, velocity(&synchronized).x, 1e-12);
    assert!((lagging.x - velocity(&synchronized).x).abs() > 1e-3);
    close(ghost.kinetic, 0.5 * ghost.velocity.length_squared(), 1e-12);

    // A hidden ghost is in no graph, and without ghosts there is one run.
    click(&mut cockpit, "Measure");
    click(&mut cockpit, Method::Yoshida4.claims().title);
    cockpit.drive.give([]);
    assert!(saved(&mut cockpit).iter().all(|row| row.method != Method::Yoshida4.name()));
    cockpit.drive.press("T").give([]);
    assert!(saved(&mut cockpit).iter().all(|row| row.run.is_empty()));
}

#[test]
fn a_soft_body_has_a_center_of_mass_in_every_run_and_no_acceleration() {
    let mut cockpit = graphs("jelly");
    for _ in 0..100 {
        cockpit.drive.press("K").give([]);
        if cockpit.drive.selected().as_deref() == Some("jelly") {
            break;
        }
    }
    click(&mut cockpit, "Keep");
    cockpit.drive.press("T").ticks(20);
    let rows = saved(&mut cockpit);
    let of = |run: &str| rows.iter().filter(|row| row.run == run).cloned().collect::<Vec<_>>();
    let (solid, reference) = (of("solid"), of("reference"));
    assert_eq!((solid.len(), reference.len()), (21, 21));
    assert!(rows.iter().all(|row| row.body == "jelly" && row.acceleration.is_none()));
    for (a, b) in solid.iter().zip(&reference) {
        assert!((a.position - b.position).length() < 0.05, "{a:?} {b:?}");
    }
    assert!(
        solid[20].position != reference[20].position && solid[20].position != solid[0].position
    );
}

#[test]
fn what_has_not_happened_is_in_no_graph() {
    let mut cockpit = graphs("bridge");
    cockpit.drive.session.stage.keep_timeline();
    keep(&mut cockpit, &["plank3", "plank6"]);
    let start = cockpit.session().stage.sim().ticks();
    cockpit.drive.press("T").ticks(120);
    let times = |rows: &[Row], run: &str| {
        let of = rows.iter().filter(|row| row.body == "plank6" && row.run == run);
        of.map(|row| (row.time / H).round()).collect::<Vec<_>>()
    };
    let all = |first: i32, last: i32| (first..=last).map(f64::from).collect::<Vec<_>>();
    assert_eq!(times(&saved(&mut cockpit), "ghost").len(), 8 * 121);

    // Back: the past stays, and ghosts, which start again, have none.
    cockpit.drive.session.seek(start + 100);
    let rows = saved(&mut cockpit);
    assert_eq!((times(&rows, "solid"), times(&rows, "reference")), (all(0, 100), vec![100.0]));
    cockpit.drive.press("P").give([remove("plank9")]).ticks(20);
    let rows = saved(&mut cockpit);
    assert_eq!((times(&rows, "solid"), times(&rows, "reference")), (all(0, 120), all(100, 120)));
    // The plank is gone 20 ticks ago: another run than the one before.
    let mut plain = shipped("bridge");
    plain.run(100);
    plain.request(motion::Request::Remove(plain.named("plank9").unwrap()));
    plain.run(20);
    let id = plain.scene.names.find("plank6").unwrap();
    let there = plain.states().find(|(other, ..)| *other == id).unwrap().1;
    let last = rows.iter().rfind(|row| row.body == "plank6" && row.run == "solid").unwrap();
    assert_eq!(last.position, there);

    // Forward over more than a frame: what lies between is not known.
    cockpit.drive.session.seek(start + 20);
    cockpit.drive.give([]);
    cockpit.drive.session.seek(start + 120);
    assert_eq!(times(&saved(&mut cockpit), "solid"), [120.0]);

    // From the start: the same bodies, nothing of the run before.
    cockpit.drive.press("P").press("F1").ticks(10);
    let rows = saved(&mut cockpit);
    assert_eq!((times(&rows, "solid"), times(&rows, "reference")), (all(0, 10), all(0, 10)));
    assert_states(&rows, ("plank3", "solid", "semi_implicit_euler"), shipped("bridge"), 0);
}

#[test]
fn bodies_that_are_gone_leave_the_graph_and_those_of_an_edited_scene_stay_in_it() {
    let mut cockpit = graphs("bridge");
    keep(&mut cockpit, &["plank3", "plank6"]);
    cockpit.drive.ticks(10).give([remove("plank3")]).ticks(10);
    let names = |cockpit: &Cockpit| {
        let controls = cockpit.session().controls().into_iter().map(|control| control.name);
        controls
            .filter_map(|name| name.strip_prefix("Remove ").map(str::to_owned))
            .collect::<Vec<_>>()
    };
    assert_eq!((names(&cockpit), saved(&mut cockpit).len()), (vec!["plank6".to_owned()], 21));

    cockpit.drive.press("F1").give([]);
    keep(&mut cockpit, &["plank1"]);
    cockpit.drive.press("M").ticks(10);
    select(&mut cockpit, "plank0");
    cockpit.drive.press("Delete").give([]);
    let text: Scene = Scene::clone(&cockpit.session().stage.sim().scene);
    assert!(text.names.find("plank0").is_none());
    let rows = saved(&mut cockpit);
    let at = |body: &str| text.bodies[text.names.find(body).unwrap() as usize].position;
    let starts: Vec<_> = rows.iter().map(|row| (&*row.body, row.time, row.position)).collect();
    assert_eq!(starts, [("plank6", 0.0, at("plank6")), ("plank1", 0.0, at("plank1"))]);
    select(&mut cockpit, "plank1");
    cockpit.drive.press("Delete").give([]);
    assert_eq!(names(&cockpit), ["plank6"]);
}

#[test]
fn a_body_is_kept_and_removed_by_keys_alone_and_no_more_than_eight_are() {
    let mut cockpit = graphs("bridge");
    let kept = |cockpit: &Cockpit| {
        let controls = cockpit.session().controls().into_iter();
        controls.filter(|control| control.name.starts_with("Remove ")).count()
    };
    select(&mut cockpit, "plank4");
    cockpit.press("F6").press("F6").press("F6").go_to("Keep", "Tab").press("Enter");
    assert_eq!(kept(&cockpit), 1);
    // The keyboard is where it was.
    cockpit.press("Space");
    assert_eq!(kept(&cockpit), 0);
    cockpit.press("Enter").press("Tab").go_to("Remove plank4", "Shift+Tab").press("Space");
    assert_eq!(kept(&cockpit), 0);
    cockpit.press("Escape");
    for _ in 0..9 {
        click(&mut cockpit, "Keep");
        cockpit.press("K");
    }
    assert_eq!(kept(&cockpit), 8);
    let bodies: BTreeSet<_> = saved(&mut cockpit).into_iter().map(|row| row.body).collect();
    assert_eq!(bodies.len(), 9, "the selection, too");
}
