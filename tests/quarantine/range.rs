//! A stated range: a body that would leave it is quarantined as one that would turn non-finite is.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{
    Cause, Damping, DampingModel, Drag, Elastic, Fault, Method, Range, Request, StableId,
};

use super::rig::{bits, records, run, scenes, start};
use crate::rigs::{Drive, Environment, H, Lab, Net, Start, elastic, scene_of};

/// Bodies that fall side by side, of which one flies off at 50 m/s.
fn crowd(method: Method, range: Option<Range>, called: bool) -> Lab {
    let around = Environment {
        damping: Some(Damping { model: DampingModel::Exact, rate: 0.1 }),
        drag: called.then_some(Drag::new(0.0, 1e-3)),
        ..Environment::falling()
    };
    let mut lab = around.lab(method, H);
    range.into_iter().for_each(|range| lab.world.insert_resource(range));
    for i in 0..11 {
        lab.body(1.0, if i == 4 { DVec3::X * 50.0 } else { DVec3::Z });
    }
    lab.recompile();
    lab
}

#[test]
fn a_body_that_would_leave_the_range_is_quarantined_within_and_no_other_notices() {
    for method in Method::ALL {
        for called in [false, true] {
            let bound = 20.0;
            let range = Range { position: bound, ..Range::FINITE };
            let what = format!("{method:?}, {called}");
            let (mut lab, mut free) =
                (crowd(method, Some(range), called), crowd(method, None, called));
            let mut last = DVec3::ZERO;
            while lab.records().is_empty() {
                last = lab.x(4);
                lab.run(1);
                free.run(1);
            }
            // The free one is beyond it, and this one is where it was before the tick.
            assert!(free.x(4).x > bound && lab.x(4) == last && last.x <= bound, "{what}");
            let record = lab.records()[0];
            let Cause { component, fault, system } = record.cause;
            assert_eq!(record.body, lab.bodies[4]);
            assert_eq!((component, fault), ("Transform.position", Fault::Range(bound)), "{what}");
            let expected = format!("position would leave the range of 2e1 m in {system}");
            assert_eq!(record.cause.what(), expected, "{what}");
            lab.run(20);
            free.run(20);
            assert_eq!(lab.all_bits(&[4]), free.all_bits(&[4]), "{what}");
        }
    }
}

#[test]
fn a_body_that_would_be_too_fast_is_quarantined_in_every_kernel() {
    for method in Method::ALL {
        for called in [false, true] {
            let range = Range { speed: 5.0, ..Range::FINITE };
            let mut lab = crowd(method, Some(range), called);
            lab.run(1);
            let records = lab.records();
            assert_eq!(records.len(), 1, "{method:?}, {called}");
            assert_eq!(records[0].body, lab.bodies[4]);
            let Cause { component, fault, .. } = records[0].cause;
            let expected = ("PhysicsBody.velocity", Fault::Range(5.0));
            assert_eq!((component, fault), expected, "{method:?}, {called}");
            // The others fall: 9.8 m/s² take half a second to 5 m/s.
            lab.run(60);
            assert_eq!(lab.records().len(), 1, "{method:?}, {called}");
            lab.run(60);
            assert_eq!(lab.records().len(), 11, "{method:?}, {called}");
        }
    }
}

#[test]
fn a_member_of_a_group_that_would_leave_the_range_is_quarantined() {
    for method in Method::ALL {
        let spring = Elastic { damping: 0.1, ..elastic(1.0, 1.0) };
        let net = Net {
            bodies: (0..3)
                .map(|i| Start::of(1.0, DVec3::Y * 10.0, DVec3::X * 60.0 * f64::from(i)))
                .collect(),
            springs: vec![([0, 1], spring), ([1, 2], spring)],
        };
        let mut lab = net.lab(&Environment::default(), method, H);
        lab.world.insert_resource(Range { position: 12.0, ..Range::FINITE });
        lab.recompile().run(14);
        let records = lab.records();
        assert_eq!((records.len(), records[0].body), (1, lab.bodies[2]), "{method:?}: {records:?}");
        let cause = Cause {
            system: "integrate_groups",
            component: "Transform.position",
            fault: Fault::Range(12.0),
        };
        assert_eq!(records[0].cause, cause, "{method:?}");
        assert!(lab.x(2).x <= 12.0 && lab.x(1).x > 3.0, "{method:?}");
    }
}

#[test]
fn an_experiment_may_ask_for_too_much() {
    for (request, component, bound) in [
        (Request::SetPosition as fn(Entity, DVec3) -> Request, "Transform.position", 100.0),
        (Request::SetVelocity, "PhysicsBody.velocity", 30.0),
        (Request::Impulse, "PhysicsBody.velocity", 30.0),
    ] {
        let mut lab = Lab::new(Method::RungeKutta4, H).with(Range { position: 100.0, speed: 30.0 });
        let body = lab.body(1.0, DVec3::ZERO);
        lab.ask(request(body, DVec3::Y * bound)).run(1);
        assert_eq!(lab.records(), []);
        let body = lab.body(1.0, DVec3::ZERO);
        lab.ask(request(body, DVec3::Y * (1.01 * bound))).run(1);
        let record = *lab.records().last().unwrap();
        let cause = Cause { system: "requests", component, fault: Fault::Range(bound) };
        assert_eq!((record.body, record.cause), (body, cause));
        assert_eq!(lab.state(body), (DVec3::Y * 10.0, DVec3::ZERO));
    }
}

#[test]
fn a_range_that_nothing_leaves_changes_nothing() {
    for (name, scene) in scenes() {
        let (mut with, mut without) = (start(&scene), start(&scene));
        // The solar system is larger.
        with.world.insert_resource(Range { position: 1e13, speed: 1e6 });
        run(&mut with, 20);
        run(&mut without, 20);
        assert!(bits(&with, StableId(u32::MAX)) == bits(&without, StableId(u32::MAX)), "{name}");
        assert_eq!(records(&with), [], "{name}");
    }
}

#[test]
fn the_range_of_a_scene_is_kept_through_the_program() {
    let text = "(version: 1, step_hz: 100, range: (position_m: 5), bodies: [
        (name: \"runaway\", velocity_m_s: (10, 0, 0)), (name: \"calm\"),
    ])";
    let scene = scene_of(text);
    assert_eq!(scene.range, Some(Range { position: 5.0, ..Range::FINITE }));
    let mut drive = Drive::of(scene);
    drive.run(200, 0.01);
    let [quarantined] = drive.session.stage.quarantines().so_far() else {
        panic!("{:?}", drive.session.stage.quarantines().so_far())
    };
    assert_eq!(
        (quarantined.body.as_str(), quarantined.cause.as_str(), quarantined.component),
        ("runaway", "range", "Transform.position")
    );
    assert_eq!(
        quarantined.what,
        format!("position would leave the range of 5e0 m in {}", quarantined.system)
    );
    assert!(drive.x("runaway").x <= 5.0 && drive.x("runaway").x > 4.9);
    assert_eq!((drive.x("calm"), drive.v("calm")), (DVec3::ZERO, DVec3::ZERO));
}

/// A body that leaves and comes back within a tick never left, in every kernel.
#[test]
fn a_range_is_asked_at_the_end_of_a_tick() {
    let thrown = |method, law: bool, joined: bool| {
        let around = Environment {
            drag: law.then_some(Drag::new(0.0, 1e-9)),
            substeps: Some(10),
            ..Environment::pull(DVec3::Y * -10.0)
        };
        let mut lab = around.lab(method, 1.0).with(Range { position: 1.0, ..Range::FINITE });
        for _ in 0..6 {
            lab.spawn(Start::of(1.0, DVec3::ZERO, DVec3::Y * 5.0));
        }
        if joined {
            lab.spring([0, 1], elastic(1.0, 0.0));
        }
        lab.recompile();
        let heights: Vec<_> = lab.run(1).states().into_iter().map(|(x, _)| x.y).collect();
        (lab.records().len(), heights)
    };
    for method in Method::ALL {
        for (law, joined) in [(false, false), (true, false), (false, true)] {
            let (records, heights) = thrown(method, law, joined);
            let back = heights.iter().all(|y| y.abs() <= 1.0);
            assert!(records == 0 && back, "{method:?} {law} {joined}: {records} {heights:?}");
        }
    }
}

/// A kick beyond the range that damping takes back within the tick is allowed.
#[test]
fn two_passes_and_one_ask_for_the_range_alike() {
    for method in [Method::SemiImplicitEuler, Method::ExplicitEuler] {
        for count in [3, 300] {
            let damping = Some(Damping { model: DampingModel::Tutorial, rate: 0.4 });
            let around = Environment { damping, ..Environment::pull(DVec3::Y * -10.0) };
            let mut lab = around.lab(method, 0.25).with(Range { speed: 10.0, ..Range::FINITE });
            for _ in 0..count {
                lab.body(1.0, DVec3::Y * -8.0);
            }
            lab.recompile().run(1);
            let quarantined = lab.records().len();
            let speed = lab.v(0).y;
            // Explicit Euler damps before it kicks.
            assert_eq!(quarantined, 0, "{method:?} {count}: {speed}");
            assert!((-10.0..-8.0).contains(&speed), "{method:?} {count}: {speed}");
            lab.run(3);
            // The next one leaves it.
            assert_eq!(lab.records().len(), count, "{method:?} {count}");
        }
    }
}

#[test]
fn a_body_at_the_border_is_quarantined_as_it_was_before_the_tick() {
    for method in Method::ALL {
        for substeps in [1, 8] {
            let around =
                Environment { substeps: Some(substeps), ..Environment::pull(DVec3::Y * -10.0) };
            let mut lab = around.lab(method, H).with(Range { speed: 1.0, ..Range::FINITE });
            for _ in 0..5 {
                lab.body(1.0, DVec3::ZERO);
            }
            lab.recompile();
            let mut last = (DVec3::ZERO, DVec3::ZERO);
            while lab.records().is_empty() {
                last = lab.state(2);
                lab.run(1);
            }
            assert_eq!(lab.state(2), last, "{method:?} {substeps}");
        }
    }
}
