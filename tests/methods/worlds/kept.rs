//! The acceleration that velocity Verlet and Yoshida's composition keep is used only where it is the one that
//! would be evaluated: a run that keeps nothing has the same bits.

use glam::DVec3;
use motion::snapshot::LastAcceleration;
use motion::{
    Damping, DampingModel, Gravity, Laws, Method, OwnLaws, Request, SpeedLimit, Substeps, TimeStep,
    Well, Wells,
};

use super::{Bits, Environment, H, crowd_with_engines, starts, wells};
use crate::rigs::{Lab, engine};

const METHODS: [Method; 2] = [Method::VelocityVerlet, Method::Yoshida4];

type Event = fn(&mut Lab);

/// The bits after every tick and the accelerations that were evaluated.
fn run(scene: &Environment, method: Method, forgets: bool, event: Event) -> (Vec<Vec<Bits>>, u64) {
    let mut lab = crowd_with_engines(scene, method);
    let mut ticks = Vec::new();
    for tick in 0..40 {
        if tick == 20 {
            event(&mut lab);
        }
        if forgets {
            forget(&mut lab);
        }
        ticks.push(lab.run(1).all_bits(&[]));
    }
    (ticks, lab.evaluations().accelerations())
}

fn forget(lab: &mut Lab) {
    for body in &lab.bodies {
        lab.world.entity_mut(*body).remove::<LastAcceleration>();
    }
}

/// What may happen between two ticks, to a world whose laws are called.
const EVENTS: [(&str, Event); 15] = [
    ("nothing", |_| {}),
    ("wells", |lab| {
        lab.world.resource_mut::<Wells>().0[0].strength = -2.0;
    }),
    ("wells replaced", |lab| {
        lab.world.insert_resource(Wells(vec![Well {
            position: DVec3::Y,
            strength: 2.0,
            softening: 1.0,
        }]));
    }),
    ("wells switched for other laws", |lab| {
        lab.world.remove_resource::<Wells>();
        lab.world.insert_resource(Laws(vec![Box::new(wells())]));
        lab.recompile();
    }),
    ("position", |lab| {
        lab.ask(Request::SetPosition(lab.bodies[1], DVec3::new(-3.0, 0.5, 2.0)));
        lab.ask(Request::SetPosition(lab.bodies[3], DVec3::new(-3.0, 0.5, 2.0)));
    }),
    ("velocity", |lab| {
        lab.ask(Request::SetVelocity(lab.bodies[1], DVec3::X));
        lab.ask(Request::SetVelocity(lab.bodies[3], DVec3::X));
    }),
    ("inverse mass", |lab| {
        lab.ask(Request::SetInverseMass(lab.bodies[3], 5.0));
    }),
    ("inverse mass without an engine, and one that becomes movable", |lab| {
        lab.ask(Request::SetInverseMass(lab.bodies[1], 0.0));
        lab.ask(Request::SetInverseMass(lab.bodies[5], 2.0));
    }),
    ("engines", |lab| {
        lab.insert(3, OwnLaws::new(vec![Box::new(engine([DVec3::new(-9.0, 3.0, 1.0)]))]));
    }),
    ("engines gone", |lab| {
        lab.world.entity_mut(lab.bodies[3]).remove::<OwnLaws>();
    }),
    ("engines that another body had", |lab| {
        let laws = lab.world.entity_mut(lab.bodies[3]).take::<OwnLaws>().unwrap();
        lab.insert(4, laws);
    }),
    ("gravity and damping", |lab| {
        lab.ask(Request::SetGravity(DVec3::new(1.0, 2.0, 3.0)));
        lab.ask(Request::SetDamping(Damping { model: DampingModel::Exact, rate: 0.5 }));
    }),
    ("tick and substeps", |lab| {
        lab.world.insert_resource(TimeStep(H / 2.0));
        lab.world.insert_resource(Substeps(2));
    }),
    ("removal", |lab| {
        // The last row takes the place of the one that is gone.
        lab.ask(Request::SetVelocity(lab.bodies[10], DVec3::X * f64::NAN))
            .push(2, DVec3::Y * f64::INFINITY);
    }),
    ("a limit, and damping that is one of the laws", |lab| {
        lab.insert(1, SpeedLimit(0.5));
        lab.ask(Request::SetVelocity(lab.bodies[1], DVec3::X * 3.0));
        lab.ask(Request::SetDamping(Damping { model: DampingModel::Exact, rate: 0.5 }));
    }),
];

#[test]
fn what_is_kept_is_what_would_be_evaluated() {
    for method in METHODS {
        for scene in [
            Environment::orbiting(),
            Environment {
                gravity: Some(Gravity::EARTH),
                substeps: Some(3),
                ..Environment::orbiting()
            },
        ] {
            for (name, event) in EVENTS {
                let (keeps, evaluated) = run(&scene, method, false, event);
                let (forgets, anew) = run(&scene, method, true, event);
                for (tick, (keeps, forgets)) in keeps.iter().zip(&forgets).enumerate() {
                    assert_eq!(keeps, forgets, "{method:?} {name} tick {tick} {scene:?}");
                }
                assert!(evaluated < anew, "{method:?} {name}: {evaluated}, {anew}");
            }
        }
    }
}

/// Wells that go while another called law stays: the schedule is the same, the laws are not.
#[test]
fn a_law_that_goes_leaves_no_acceleration_behind() {
    for method in METHODS {
        let run = |forgets: bool| {
            let mut lab = Environment::orbiting().lab(method, H);
            lab.world.insert_resource(Laws(vec![Box::new(wells())]));
            lab.recompile();
            for start in starts() {
                lab.spawn(start);
            }
            lab.run(10);
            lab.world.remove_resource::<Wells>();
            lab.recompile();
            if forgets {
                forget(&mut lab);
            }
            lab.run(1).all_bits(&[])
        };
        assert_eq!(run(false), run(true), "{method:?}");
    }
}
