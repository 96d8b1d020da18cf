//! Particles fly from their birth: what is left of the tick in which one is born is a tick of its method.

use bevy_ecs::prelude::*;
use motion::clock::{ClockState, StepClock};
use motion::ledger::Ledger;
use motion::units::Vector;
use motion::{
    AxisLocks, Curve, Damping, DampingModel, DampingRate, Drag, Emitter, Gravity, Method, OwnLaws,
    OwnSubsteps, Range, SpeedLimit, StableId, Substeps, Thrust, TimeStep, Well, Wells, Wind,
};

use super::emitters::{AT, expected, fountain, launch, living, now};
use crate::rigs::{Lab, Start};

fn gravity(world: &mut World) {
    world.insert_resource(Gravity::EARTH);
}

#[test]
fn particles_are_on_the_exact_parabola_at_any_tick_rate() {
    let g = Gravity::EARTH.acceleration;
    let constant = |hz: f64| vec![1.0 / hz];
    let frames = vec![0.02, 0.031, 0.0047, 0.09];
    let steps = [constant(30.0), constant(60.0), constant(240.0), constant(7.0), frames];
    for (lengths, (rate, life, count)) in steps
        .iter()
        .flat_map(|lengths| [(31.0, 1.7, 53), (457.0, 0.6, 11)].map(|pool| (lengths, pool)))
    {
        // Those whose positions are exact under a constant acceleration.
        let exact = Method::ALL.into_iter().filter(|method| method.claims().position_order > 1);
        for (method, substeps) in exact.flat_map(|method| [(method, 1), (method, 3)]) {
            let what =
                format!("{method:?} in {substeps} substeps of {lengths:?} s, {rate} a second");
            let prepare = |world: &mut World| {
                gravity(world);
                world.insert_resource(Substeps(substeps));
            };
            let (mut lab, _) = fountain(count, rate, life, method, lengths[0], prepare);
            let mut seen = 0;
            for length in lengths.iter().cycle().take(100) {
                lab.world.insert_resource(TimeStep(*length));
                let now = now(lab.run(1));
                let numbers = expected(count as u64, rate, life, now);
                assert_eq!(living(&lab).len(), numbers.len(), "{what}");
                for number in numbers {
                    let slot = (number % count as u64) as usize;
                    let (x, v) = lab.state(slot);
                    let age = now - number as f64 / rate;
                    let exact = AT + launch(slot) * age + g * (age * age / 2.0);
                    assert!((x - exact).length() < 1e-11, "{what}, {number}: {x} is not {exact}");
                    if method != Method::PositionVerlet {
                        assert!(
                            (v - launch(slot) - g * age).length() < 1e-11,
                            "{what}, {number}: {v}"
                        );
                    }
                    seen += 1;
                }
            }
            assert!(seen >= 100, "{what}: {seen} particles");
        }
    }
}

#[test]
fn under_drag_particles_have_the_order_of_their_method() {
    let (g, c, until) = (Gravity::EARTH.acceleration, 3.0, 2);
    let (rate, life, count) = (31.0, 0.9, 28);
    for method in Method::ALL {
        let order = f64::from(method.claims().order_with_velocity_laws);
        let error = |hz: u32| {
            let prepare = |world: &mut World| {
                gravity(world);
                world.insert_resource(Drag::new(c, 0.0));
            };
            let (mut lab, _) = fountain(count, rate, life, method, 1.0 / f64::from(hz), prepare);
            let states = lab.run(u64::from(until * hz)).states();
            let numbers = expected(count as u64, rate, life, f64::from(until));
            let squares = numbers.iter().map(|number| {
                let slot = (number % count as u64) as usize;
                let age = f64::from(until) - *number as f64 / rate;
                let exact = AT + g * (age / c) - (launch(slot) - g / c) * ((-c * age).exp_m1() / c);
                (states[slot].0 - exact).length_squared()
            });
            (squares.sum::<f64>() / numbers.len() as f64).sqrt()
        };
        let [coarse, fine] = [32, 256].map(error);
        let found = (coarse / fine).log2() / 3.0;
        assert!((found - order).abs() < 0.1, "{method:?}: {coarse:e} {fine:e}, {found}");
    }
}

/// Everything that acts on single bodies, and what the bodies ask for.
fn everything(lab: &mut Lab, damping: DampingModel) {
    let world = &mut lab.world;
    world.insert_resource(Gravity::EARTH);
    world.insert_resource(Damping { model: damping, rate: 2.0 });
    let wind = Wind { velocity: Vector::new(5.0, 0.0, 1.0), gust: 2.0, gust_hz: 3.0 };
    world.insert_resource(Drag { wind: Some(wind), ..Drag::new(0.3, 0.1) });
    world.insert_resource(Wells(vec![Well {
        position: Vector::Y * 9.0,
        strength: 7.0,
        softening: 0.1,
    }]));
    // It starts within what is left of the tick.
    let thrust = Thrust::new(Curve::Polynomial(vec![Vector::Z * 40.0]), 0.475, f64::INFINITY);
    for (number, body) in lab.bodies.iter().enumerate() {
        let mut body = world.entity_mut(*body);
        match number % 5 {
            0 => body.insert(DampingRate::new(5.0)),
            1 => body.insert(SpeedLimit(4.0)),
            2 => body.insert(AxisLocks { x: true, ..AxisLocks::default() }),
            3 => body.insert(OwnSubsteps(3)),
            _ => body.insert(OwnLaws::new(vec![Box::new(thrust.clone())])),
        };
    }
    lab.recompile();
}

#[test]
fn the_rest_of_a_tick_is_a_tick_with_everything_that_acts() {
    // Particles 10 to 19 are born in the tick from 0.4 s to 0.5 s, at 0.42 s and every 5 ms after it.
    let (h, ticks) = (0.1, 5);
    let time = |number: u64| number as f64 / 200.0;
    for (method, damping) in
        Method::ALL.into_iter().flat_map(|method| DampingModel::ALL.map(|model| (method, model)))
    {
        let (mut lab, _) = fountain(20, 200.0, 10.0, method, h, |_| ());
        everything(&mut lab, damping);
        let end = now(lab.run(ticks));
        for number in 80..100_u64 {
            // The same body in a world of its own, one tick of which is what is left.
            let slot = (number % 20) as usize;
            let mut alone = Lab::new(method, end - time(number));
            for slot in 0..20 {
                alone.spawn(Start { x: AT, v: launch(slot), w: 2.0 });
            }
            everything(&mut alone, damping);
            let state_then = ClockState { since_time: time(number), ..ClockState::default() };
            alone.world.insert_resource(StepClock::from_state(state_then).unwrap());
            let ((x, v), (y, w)) = (lab.state(slot), alone.run(1).state(slot));
            let near = (x - y).length() < 1e-12 && (v - w).length() < 1e-12;
            assert!(near, "{method:?}, {damping:?}, slot {slot}: {x} {v}, not {y} {w}");
            assert!((x - AT).length() > 1e-3, "{slot} has not moved");
        }
    }
}

#[test]
fn a_particle_that_would_leave_the_range_at_its_birth_stays_where_it_was_born() {
    for method in [Method::SemiImplicitEuler, Method::PositionVerlet, Method::RungeKutta4] {
        let prepare = |world: &mut World| {
            gravity(world);
            world.insert_resource(Range { position: 1e9, speed: 50.0 });
        };
        let (mut lab, emitter) = fountain(8, 25.0, 1.0, method, 0.1, prepare);
        let mut faster = lab.world.get::<Emitter>(emitter).unwrap().clone();
        faster.launches[3] = Vector::Y * 100.0;
        lab.world.entity_mut(emitter).insert(faster);
        assert_eq!(lab.run(2).state(3), (AT, Vector::Y * 100.0), "{method:?}");
        assert!(lab.is_quarantined(3));
        let records = lab.run(9).records();
        assert_eq!((records.len(), records[0].id, records[0].tick), (1, Some(StableId(3)), 2));
        assert!(lab.x(4) != AT);
    }
}

#[test]
fn a_scene_that_begins_again_after_one_tick_throws_its_first_particles_again() {
    let (mut lab, _) = fountain(8, 25.0, 1.0, Method::RungeKutta4, 0.1, |_| ());
    let first = lab.run(1).states();
    assert_eq!(living(&lab).len(), 3);
    lab.world.resource_mut::<StepClock>().begin_scene();
    lab.run(1);
    assert_eq!(living(&lab).len(), 3);
    assert_eq!(lab.states(), first);
}

#[test]
fn the_books_of_a_birth_within_a_tick_close() {
    for (method, damping) in [Method::VelocityVerlet, Method::RungeKutta4]
        .into_iter()
        .flat_map(|method| [(method, None), (method, Some(DampingModel::Tutorial))])
    {
        let prepare = |world: &mut World| {
            gravity(world);
            damping
                .into_iter()
                .for_each(|model| world.insert_resource(Damping { model, rate: 0.4 }));
        };
        let (mut lab, _) = fountain(31, 31.0, 0.9, method, 1.0 / 30.0, prepare);
        let mut ledger = Ledger::open(&lab.world);
        (0..60).for_each(|_| ledger.tick(&mut lab.stepper, &mut lab.world));
        let books = ledger.since_opening();
        let residual = (books.energy.residual.abs(), books.momentum.residual.length());
        assert!(residual.0 < 1e-9 && residual.1 < 1e-9, "{method:?}, {damping:?}: {residual:?}");
        assert!(books.momentum.law("gravity").y < -1.0);
    }
}
