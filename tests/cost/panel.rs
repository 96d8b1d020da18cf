//! The panel of accuracy and cost: the numbers of the command line, in the running session.

use glam::DVec2;
use lab::cost::{Cell, Outcome, Plan, Report, Study, Subject, Truth};
use sandbox::input::Button;

use crate::rigs::{Drive, sandbox};

/// A session of `scene` with the panel open and its study done.
fn studied(scene: &str) -> Drive {
    let mut drive = Drive::shipped(scene);
    drive.press("Q").press("C");
    for _ in 0..100_000 {
        drive.frame(0.05, []);
        if drive.session.tools.cost_progress() == 1.0 {
            return drive;
        }
    }
    panic!("the study does not end");
}

/// What was found, without what was timed.
fn found(study: &Study) -> Study {
    let timeless = |cell: &Cell| Cell { time: None, arithmetic_time: None, ..cell.clone() };
    Study { cells: study.cells.iter().map(timeless).collect(), ..study.clone() }
}

#[test]
fn the_panel_finds_what_a_study_of_the_scene_finds() {
    let drive = studied("orbit");
    let panel = drive.session.tools.cost_study().unwrap();
    let bench =
        super::studied(Subject::of_scene(scene::load("orbit").unwrap(), None), Plan::live());
    // Rungs are what there was time for.
    let same = |cells: &[Cell]| {
        cells
            .iter()
            .map(|cell| (cell.setting, cell.outcome.clone(), cell.counts))
            .collect::<Vec<_>>()
    };
    let (panel, alone) = (found(panel), found(bench.study()));
    assert_eq!(same(&panel.cells), same(&alone.cells));
    assert_eq!((panel.truth, panel.simulated_s), (alone.truth, alone.simulated_s));
    assert!(drive.session.tools.cost_study().unwrap().cells.iter().any(|cell| cell.time.is_some()));
}

#[test]
fn the_panel_and_the_command_line_agree() {
    let drive = studied("orbit");
    let panel = drive.session.tools.cost_study().unwrap();
    let line = format!("cost orbit --quick --format json --seconds {}", panel.simulated_s);
    let report: Report = serde_json::from_str(&sandbox(".", &line).fine()).unwrap();
    let line = &report.studies[0];
    let own = |truth: &Truth| truth.own_error().0;
    let allowed = own(&panel.truth) + own(&line.truth);
    let mut seen = 0;
    for cell in &panel.cells {
        let Some(other) = line.cells.iter().find(|other| other.setting == cell.setting) else {
            continue;
        };
        assert_eq!(cell.counts, other.counts, "{}", cell.setting);
        match (&cell.outcome, &other.outcome) {
            (Outcome::Finished(a), Outcome::Finished(b)) => {
                let apart = (a.relative - b.relative).abs();
                assert!(apart <= allowed + 1e-12 * a.relative, "{}: {a:?} {b:?}", cell.setting);
            }
            (a, b) => assert_eq!(a, b, "{}", cell.setting),
        }
        seen += 1;
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn a_click_on_a_dot_takes_its_setting() {
    let mut drive = studied("orbit");
    let before = drive.session.stage.setting();
    for y in (300..700).step_by(10) {
        for x in (850..1270).step_by(10) {
            drive.click(Button::Left, DVec2::new(f64::from(x), f64::from(y))).frame(0.0, []);
            let now = drive.session.stage.setting();
            if now != before {
                let study = drive.session.tools.cost_study().unwrap();
                assert!(study.cells.iter().any(|cell| cell.setting == now), "{now}");
                assert_eq!(drive.session.stage.sim().stepper.method(), now.method);
                // It stays over a reset, and the study over both: it has settings of its own.
                drive.press("F1").ticks(2);
                assert_eq!(drive.session.stage.setting(), now);
                assert_eq!(drive.session.tools.cost_progress(), 1.0);
                return;
            }
        }
    }
    panic!("no dot was hit");
}

#[test]
fn a_closed_panel_measures_nothing() {
    let mut drive = Drive::shipped("orbit");
    drive.run(10, 0.05);
    assert!(drive.session.tools.cost_study().is_none());
    drive.press("C").run(3, 0.05).press("C");
    let (progress, hash) = (drive.session.tools.cost_progress(), drive.hash());
    drive.run(10, 0.0);
    assert_eq!((drive.session.tools.cost_progress(), drive.hash()), (progress, hash));

    // Studying changes no bit of the run.
    let mut plain = Drive::shipped("orbit");
    let mut watched = Drive::shipped("orbit");
    watched.press("C");
    plain.press("7");
    for drive in [&mut plain, &mut watched] {
        drive.frames(60);
    }
    assert_eq!(plain.hash(), watched.hash());
}
