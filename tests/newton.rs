//! Newton's laws, inverse mass, pushes.

use bevy_ecs::prelude::*;
use motion::internals::{Passes, StepPlan, step_schedule};
use motion::units::Vector;
use motion::{
    AxisLocks, Damping, DampingModel, DampingRate, Elastic, Force, Gravity, GravityOff, Method,
    MutualGravity, Push, PushQueue, Request, SpeedLimit, Transform,
};
use scene::unsolvable;

use crate::rigs::{Drive, H, Lab, Start, close};

#[test]
fn first_law_a_body_left_alone_keeps_its_velocity_and_one_at_rest_its_place() {
    for method in Method::ALL {
        let mut lab = Lab::new(method, H);
        let moving = lab.body(10.0, Vector::new(1.0, -2.0, 0.5));
        let resting = lab.body(10.0, Vector::ZERO);
        let start = lab.x(moving);
        lab.run(1200);
        assert_eq!(lab.v(moving), Vector::new(1.0, -2.0, 0.5));
        let way = lab.x(moving) - start;
        // 1,200 additions round by at most half an ulp of the end point each.
        assert!((way - lab.v(moving) * 10.0).abs().max_element() <= 1200.0 * f64::EPSILON * 20.0);
        assert_eq!(lab.x(resting), Vector::Y * 10.0);
    }
}

#[test]
fn the_scene_of_the_first_law_passes_a_mark_each_second() {
    let mut drive = Drive::shipped("first_law");
    for second in 1..=4 {
        drive.ticks(120);
        let at = |name: &str| drive.x(name);
        let (mark, seconds) = (at(&format!("mark_{second}")), f64::from(second));
        for name in ["free", "thrown"] {
            assert!((at(name).x - mark.x).abs() < 1e-12, "{name} at {second} s");
        }
        assert_eq!(at("free").y, 15.0);
        // Semi-implicit Euler falls h/2 v too far.
        let fallen = 0.5 * 1.62 * seconds * (seconds + 1.0 / 120.0);
        assert!((at("thrown").y - (13.0 - fallen)).abs() < 1e-10, "{second} s");
    }
}

#[test]
fn second_law_a_force_accelerates_by_force_times_inverse_mass() {
    for (w, n) in [(10.0, 100.0), (0.5, -3.0), (1e-3, 1e6)] {
        for h in [H, H / 2.0, H / 4.0] {
            let mut lab = Lab::new(Method::SemiImplicitEuler, h);
            let body = lab.body(w, Vector::ZERO);
            lab.push(body, Vector::new(0.0, n, 0.0)).run(1);
            assert_eq!(lab.v(body).y, n * w * h);
        }
    }
}

#[test]
fn third_law_a_body_pulls_as_hard_as_it_is_pulled() {
    // What acts between two bodies: one force, found twice.
    let spring = |lab: &mut Lab, ends| {
        lab.spring(ends, Elastic::new(50.0, 1.0).damped(0.3));
    };
    let attraction = |lab: &mut Lab, _| {
        lab.world.insert_resource(MutualGravity { constant: 20.0, softening: 0.1 });
    };
    for between in [&spring as &dyn Fn(&mut Lab, [Entity; 2]), &attraction] {
        for method in Method::ALL {
            let mut lab = Lab::new(method, H);
            let bodies = [lab.body(10.0, Vector::ZERO), lab.body(0.25, Vector::ZERO)];
            lab.world.get_mut::<Transform>(bodies[0]).unwrap().position +=
                Vector::new(2.0, -1.0, 0.5);
            between(&mut lab, bodies);
            if unsolvable(method, lab.world.contains_resource::<MutualGravity>()).is_some() {
                continue;
            }
            lab.recompile();
            let mut largest: f64 = 0.0;
            for tick in 0..60 {
                lab.run(1);
                let [light, heavy] = [lab.v(bodies[0]) / 10.0, lab.v(bodies[1]) / 0.25];
                largest = largest.max(light.length());
                let off = (light + heavy).length();
                assert!(off <= 1e-12 * largest, "{method:?}, tick {tick}: {light} and {heavy}");
            }
            assert!(largest > 0.1, "{method:?}: {largest}");
        }
    }
}

#[test]
fn an_infinite_mass_is_moved_by_nothing() {
    for passes in [1, 300] {
        let mut lab = Lab::tutorial();
        let floor = lab.body(0.0, Vector::ZERO);
        for _ in 0..passes {
            lab.body(10.0, Vector::ZERO);
        }
        lab.set_method(Method::SemiImplicitEuler);
        for force in [1e30, f64::MAX, f64::INFINITY, f64::NAN] {
            lab.push(floor, Vector::new(force, -force, force)).run(3);
        }
        assert_eq!(lab.state(floor), (Vector::Y * 10.0, Vector::ZERO));
    }
}

#[test]
fn two_pushes_in_one_tick_add_and_a_push_is_gone_in_the_next() {
    let mut lab = Lab::new(Method::SemiImplicitEuler, H);
    let body = lab.body(10.0, Vector::ZERO);
    lab.push(body, Vector::new(3.0, 0.0, 0.0)).push(body, Vector::new(4.0, 5.0, 0.0)).run(1);
    let after_one = lab.v(body);
    assert_eq!(after_one, Vector::new(7.0 * 10.0 * H, 5.0 * 10.0 * H, 0.0));
    assert_eq!(lab.world.get::<Force>(body).unwrap().newtons(), Vector::ZERO);
    lab.run(5);
    assert_eq!(lab.v(body), after_one);
}

#[test]
fn a_sustained_push_acts_in_every_tick_while_it_stands() {
    let mut lab = Lab::new(Method::SemiImplicitEuler, H);
    let body = lab.body(1.0, Vector::ZERO);
    let push = Push { body, newtons: Vector::X * 10.0 };
    lab.world.resource_mut::<PushQueue>().sustain([push]);
    lab.run(120);
    close(lab.v(body).x, 10.0, 1e-13);
    lab.world.resource_mut::<PushQueue>().sustain([]);
    let v = lab.v(body);
    lab.run(10);
    assert_eq!(lab.v(body), v);
}

#[test]
fn pushing_what_has_no_physics_or_is_gone_does_nothing() {
    let mut lab = Lab::tutorial();
    let scenery = lab.world.spawn(Transform::at(Vector::ONE)).id();
    let gone = lab.body(1.0, Vector::ZERO);
    lab.world.despawn(gone);
    lab.push(scenery, Vector::X * 1e9).push(gone, Vector::X * 1e9).run(2);
    assert_eq!(lab.world.get::<Transform>(scenery).unwrap().position, Vector::ONE);
}

#[test]
fn gravity_accelerates_every_mass_alike_and_any_vector_will_do() {
    let mut lab = Lab::tutorial();
    let g = Vector::new(1.0, 2.0, -3.0);
    lab.ask(Request::SetGravity(g));
    let (light, heavy) = (lab.body(1e6, Vector::ZERO), lab.body(1e-6, Vector::ZERO));
    lab.run(240);
    assert_eq!(lab.state(light), lab.state(heavy));
    close(lab.v(light).z / lab.v(light).x, -3.0, 1e-12);
}

#[test]
fn gravity_that_is_switched_off_keeps_its_value_and_never_acts() {
    let mut lab = Lab::tutorial();
    let body = lab.body(10.0, Vector::ZERO);
    lab.ask(Request::SwitchGravity(false)).run(120);
    assert_eq!(lab.x(body), Vector::Y * 10.0);
    assert_eq!(lab.world.resource::<Gravity>().acceleration, Gravity::EARTH.acceleration);
    lab.ask(Request::SwitchGravity(true)).run(1);
    assert_eq!(lab.v(body).y, -9.8 * H * (1.0 - 0.4 * H));
}

/// A world of `plain` bodies, and one of each kind that asks for something of its own.
fn asking(plain: usize, method: Method, model: DampingModel) -> Lab {
    let mut lab = Lab::new(method, H).with_gravity().with(Damping { model, rate: 0.4 });
    for i in 0..plain + 5 {
        let x = if i < plain { Vector::splat(i as f64) } else { Vector::Y };
        lab.spawn(Start { x, v: Vector::new(8.0, 3.0, -5.0), w: 2.0 });
    }
    let locks = |x, y, z| AxisLocks { x, y, z };
    lab.insert(plain, GravityOff);
    lab.insert(plain + 1, SpeedLimit(4.0));
    lab.insert(plain + 2, locks(false, false, true));
    lab.insert(plain + 3, DampingRate::new(3.0));
    lab.insert(plain + 4, (DampingRate::new(3.0), SpeedLimit(4.0), locks(true, true, false)));
    lab.set_method(method);
    lab
}

#[test]
fn one_pass_and_two_passes_give_the_same_bits() {
    for method in [Method::ExplicitEuler, Method::SemiImplicitEuler] {
        for model in DampingModel::ALL {
            for plain in [0, 1, 3, 4, 5, 9, 64] {
                let [two, one] = [Passes::Two, Passes::One].map(|passes| {
                    let mut lab = asking(plain, method, model);
                    let plan = StepPlan { method, passes, ..Default::default() };
                    let mut schedule = step_schedule(&mut lab.world, &plan);
                    let last = plain + 4;
                    for tick in 0..100 {
                        lab.push(tick % (plain + 5), Vector::new(tick as f64, 10.0, -3.0));
                        if tick == 50 {
                            lab.push(0, Vector::X * 1e308).push(last, Vector::X * f64::NAN);
                        }
                        schedule.run(&mut lab.world);
                    }
                    lab
                });
                assert_eq!(two.all_bits(&[]), one.all_bits(&[]), "{method:?} {model:?} {plain}");
                let records = |lab: &Lab| lab.records().to_vec();
                assert_eq!(records(&two), records(&one));
                assert_eq!(records(&one).len(), 2);
            }
        }
    }
}

#[test]
fn what_a_body_asks_for_is_its_own() {
    for plain in [0, 300] {
        let mut lab = asking(plain, Method::SemiImplicitEuler, DampingModel::Clamped);
        let [floating, slow, planar, damped] = [plain, plain + 1, plain + 2, plain + 3];
        lab.run(1);
        close(lab.v(floating).y, 3.0 * (1.0 - 0.4 * H), 1e-15);
        close(lab.v(slow).length(), 4.0, 1e-15);
        let direction = Vector::new(8.0, 3.0 - 9.8 * H, -5.0).normalize();
        assert!((lab.v(slow) / 4.0 - direction).length() < 1e-15);
        assert_eq!((lab.v(planar).z, lab.x(planar).z), (0.0, 0.0));
        close(lab.v(damped).x, 8.0 * (1.0 - 3.0 * H), 1e-15);
        lab.run(600);
        assert_eq!((lab.v(planar).z, lab.x(planar).z), (0.0, 0.0));
        assert!(lab.v(slow).length() <= 4.0 * (1.0 + 1e-15));
    }
}
