//! Switching effects off and on.

use bevy_ecs::prelude::*;
use history::Simulation;
use motion::effects::{Effect, EffectState, NeverDeclared};
use motion::internals::StepPlan;
use motion::units::Vector;
use motion::{
    Damping, DampingModel, DampingRate, Drag, Elastic, Gravity, Method, MutualGravity, OwnLaws,
    PhysicsBody, Request, SpeedLimit, Spring, Stepper, TimeStep, Wells,
};
use scene::Scene;

use super::{COUPLED, LOCAL, lab_of, world_of};
use crate::rigs::{H, Lab, world_bits};

fn ask(lab: &mut Lab, requests: impl IntoIterator<Item = Request>) {
    for request in requests {
        lab.ask(request);
    }
    lab.stepper.carry_out_requests(&mut lab.world);
}

#[test]
fn off_and_on_again_at_once_is_bit_identical_to_never() {
    for method in Method::ALL {
        let mut never = lab_of(&LOCAL, method);
        never.run(40);
        let expected = world_bits(&mut never.world);
        for effect in LOCAL {
            let mut lab = lab_of(&LOCAL, method);
            lab.run(15);
            ask(&mut lab, [false, true].map(|on| Request::Switch(effect, on)));
            lab.run(1);
            if method != Method::PositionVerlet {
                // Position Verlet restarts when a law really goes.
                for on in [false, true] {
                    ask(&mut lab, [Request::Switch(effect, on)]);
                }
            }
            lab.run(24);
            assert_eq!(world_bits(&mut lab.world), expected, "{effect} under {}", method.name());
        }
    }
}

#[test]
fn what_is_off_is_what_was_never_declared_bit_for_bit_and_system_for_system() {
    off_is_never(&LOCAL, &LOCAL);
}

#[test]
fn what_acts_between_bodies_is_off_as_if_it_was_never_declared() {
    let gravity = [Effect::Gravity, Effect::Drag, Effect::Springs, Effect::MutualGravity];
    off_is_never(&gravity, &COUPLED);
    for effect in COUPLED {
        off_is_never(&[Effect::Damping, effect], &[effect]);
    }
}

/// Switches each of `switched` off in a world that declares `all`.
fn off_is_never(all: &[Effect], switched: &[Effect]) {
    for method in Method::ALL {
        for effect in switched.iter().copied() {
            // Air that no drag sees is nothing: wind goes with drag.
            let others: Vec<_> = all
                .iter()
                .copied()
                .filter(|other| {
                    *other != effect && (effect, *other) != (Effect::Drag, Effect::Wind)
                })
                .collect();
            let [mut never, mut off] = [&others[..], all].map(|effects| lab_of(effects, method));
            ask(&mut off, [Request::Switch(effect, false)]);
            for _ in 0..2 {
                never.run(20);
                off.run(20);
                let what = format!("{effect} under {}", method.name());
                assert_eq!(world_bits(&mut off.world), world_bits(&mut never.world), "{what}");
                assert_eq!(off.stepper.systems(), never.stepper.systems(), "{what}");
                assert_eq!(off.stepper.plan(), never.stepper.plan(), "{what}");
            }
            assert_eq!(off.counts(), never.counts(), "{effect} under {}", method.name());
        }
    }
}

#[test]
fn what_acts_between_bodies_comes_back_as_it_was() {
    for method in Method::ALL {
        let all = [Effect::Gravity, Effect::Springs, Effect::MutualGravity];
        let mut never = lab_of(&all, method);
        never.run(40);
        for effect in COUPLED {
            let mut lab = lab_of(&all, method);
            lab.run(15);
            if method != Method::PositionVerlet {
                for on in [false, true] {
                    ask(&mut lab, [Request::Switch(effect, on)]);
                }
            }
            lab.run(25);
            let [bits, of_never] = [&mut lab, &mut never].map(|lab| world_bits(&mut lab.world));
            assert_eq!(bits, of_never, "{effect} under {}", method.name());
        }
    }
}

#[test]
fn off_at_the_start_is_switched_off_before_the_first_tick() {
    let scene = scene::load("everything").unwrap();
    let later = |mut simulation: Simulation| {
        simulation.run(100);
        simulation.hash()
    };
    let whole = later(Simulation::new(scene.clone()));
    assert_eq!(Effect::ALL[0], Effect::Gravity);
    for off in [&Effect::ALL[1..], &[Effect::Drag]] {
        let mut switched = Simulation::new(scene.clone());
        off.iter().for_each(|effect| switched.request(Request::Switch(*effect, false)));
        let started = Simulation::new(Scene { off_at_start: off.to_vec(), ..scene.clone() });
        let hash = later(started);
        assert_eq!(hash, later(switched), "{off:?}");
        assert_ne!(hash, whole, "{off:?}");
    }
}

#[test]
fn switching_keeps_the_value() {
    let mut lab = lab_of(&LOCAL, Method::RungeKutta4);
    let drag = *lab.world.resource::<Drag>();
    let names = |world: &mut World| {
        let laws =
            |laws: &OwnLaws| laws.laws().iter().map(|law| format!("{law:?}")).collect::<Vec<_>>();
        let mut all: Vec<_> = world
            .query::<(Entity, &OwnLaws)>()
            .iter(world)
            .map(|(body, own)| (body, laws(own)))
            .collect();
        all.sort_unstable_by_key(|(body, _)| body.to_bits());
        all
    };
    let own = names(&mut lab.world);
    let all = |on| LOCAL.map(|effect| Request::Switch(effect, on));
    ask(&mut lab, all(false));
    let world = &mut lab.world;
    assert!(LOCAL.iter().all(|effect| motion::effects::state(world, *effect) == EffectState::Off));
    assert!(!world.contains_resource::<Drag>() && !world.contains_resource::<Wells>());
    assert!(!world.contains_resource::<Damping>() && !world.resource::<Gravity>().on);
    assert_eq!(world.query::<&OwnLaws>().iter(world).count(), 0);
    assert_eq!(world.query::<&SpeedLimit>().iter(world).count(), 0);
    assert_eq!(world.query::<&DampingRate>().iter(world).count(), 0);
    lab.run(3);
    // In another order than they went.
    ask(&mut lab, [Effect::Thrusts, Effect::Drag].map(|effect| Request::Switch(effect, true)));
    ask(&mut lab, all(true));
    let world = &mut lab.world;
    assert!(LOCAL.iter().all(|effect| motion::effects::state(world, *effect) == EffectState::On));
    assert_eq!((*world.resource::<Drag>(), names(world)), (drag, own));
    assert_eq!(world.query::<&SpeedLimit>().single(world).unwrap(), &SpeedLimit(1.1));
    assert_eq!(world.query::<&DampingRate>().single(world).unwrap().rate(), 1.5);
    let damping = world.resource::<Damping>();
    assert_eq!((damping.model, damping.rate), (DampingModel::Exact, 0.3));
}

#[test]
fn an_effect_that_nobody_declared_says_so_and_a_second_switch_does_nothing() {
    let mut world = world_of(&[]);
    for effect in Effect::ALL {
        assert_eq!(motion::effects::state(&world, effect), EffectState::NotDeclared);
        for on in [false, true] {
            let error = motion::effects::switch(&mut world, effect, on).unwrap_err();
            assert_eq!(error, NeverDeclared(effect));
            assert_eq!(error.to_string(), format!("this scene never declared {}", effect.name()));
        }
        assert_eq!(Effect::from_name(effect.name()), Some(effect));
    }
    world.insert_resource(Drag::new(1.0, 0.0));
    for on in [false, false, true, true] {
        motion::effects::switch(&mut world, Effect::Drag, on).unwrap();
    }
    assert_eq!(world.resource::<Drag>().linear, 1.0);
}

#[test]
fn wind_is_switched_also_while_drag_is_off() {
    let mut world = world_of(&[Effect::Drag, Effect::Wind]);
    let before = *world.resource::<Drag>();
    motion::effects::switch(&mut world, Effect::Drag, false).unwrap();
    motion::effects::switch(&mut world, Effect::Wind, false).unwrap();
    motion::effects::switch(&mut world, Effect::Drag, true).unwrap();
    assert_eq!(world.resource::<Drag>().wind, None);
    assert_eq!(motion::effects::state(&world, Effect::Wind), EffectState::Off);
    motion::effects::switch(&mut world, Effect::Wind, true).unwrap();
    assert_eq!(*world.resource::<Drag>(), before);
}

#[test]
fn damping_that_is_set_while_it_is_off_is_on() {
    let mut lab = lab_of(&[Effect::Damping], Method::SemiImplicitEuler);
    let set = Damping { model: DampingModel::Clamped, rate: 2.0 };
    ask(&mut lab, [Request::Switch(Effect::Damping, false), Request::SetDamping(set)]);
    let world = &mut lab.world;
    assert_eq!(motion::effects::state(world, Effect::Damping), EffectState::On);
    assert_eq!(*world.resource::<Damping>(), set);
    assert_eq!(world.query::<&DampingRate>().iter(world).count(), 1);
}

#[test]
fn springs_and_mutual_gravity_are_switched_and_their_values_kept() {
    let mut world = world_of(&[]);
    let ends: Vec<_> =
        world.query_filtered::<Entity, With<PhysicsBody>>().iter(&world).take(2).collect();
    let elastic = Elastic::new(10.0, 1.0).damped(0.1);
    let spring = Spring { ends: [ends[0], ends[1]], elastic };
    let entity = world.spawn(spring).id();
    let pull = MutualGravity { constant: 0.5, softening: 0.1 };
    world.insert_resource(pull);
    for effect in [Effect::Springs, Effect::MutualGravity] {
        for (on, state) in [(false, EffectState::Off), (true, EffectState::On)] {
            motion::effects::switch(&mut world, effect, on).unwrap();
            assert_eq!(motion::effects::state(&world, effect), state);
        }
    }
    assert_eq!((world.get::<Spring>(entity), world.get_resource()), (Some(&spring), Some(&pull)));
}

#[test]
fn every_effect_can_be_toggled_in_the_middle_of_a_run_under_every_method() {
    for method in Method::ALL {
        let mut lab = lab_of(&LOCAL, method);
        for round in 0..4 {
            for effect in LOCAL {
                ask(&mut lab, [Request::Switch(effect, round % 2 == 1)]);
                lab.run(3);
                // That the last particle is gone is noticed a tick later.
                let emits = lab.stepper.plan().emits;
                let plan = StepPlan { emits, ..StepPlan::of(&mut lab.world, method) };
                assert_eq!(*lab.stepper.plan(), plan, "{effect}");
            }
        }
        let finite = |(_, numbers): &(u32, [u64; 6])| {
            numbers.iter().all(|bits| f64::from_bits(*bits).is_finite())
        };
        assert!(world_bits(&mut lab.world).iter().all(finite), "{}", method.name());
        assert!(lab.records().is_empty());
    }
}

/// What an embedder does to the resources of a world between two ticks, without a request.
const CHANGES: [fn(&mut World); 4] = [
    |world| world.insert_resource(Drag { quadratic: 0.5, ..Drag::default() }),
    |world| world.insert_resource(Drag { linear: 0.2, ..Drag::default() }),
    |world| world.insert_resource(Damping { model: DampingModel::Exact, rate: 0.3 }),
    |world| {
        world.remove_resource::<Drag>();
    },
];

#[test]
fn a_law_that_is_exchanged_between_two_ticks_is_counted_as_if_it_had_always_been_there() {
    for method in Method::ALL {
        // Of the same states: an implicit step iterates as often as its state needs.
        let [mut lab, mut other] =
            [(); 2].map(|()| lab_of(&[Effect::Gravity, Effect::Drag], method));
        lab.run(2);
        other.run(2);
        for (number, change) in CHANGES.iter().enumerate() {
            change(&mut lab.world);
            change(&mut other.world);
            other.stepper = Stepper::new(&mut other.world, method, TimeStep(H));
            // The first tick of a method may evaluate once more.
            let [changed, expected] = [&mut lab, &mut other].map(|lab| {
                let (accelerations, before) = lab.run(1).counts();
                let (after, laws) = lab.run(3).counts();
                let old =
                    |law| before.iter().find(|(old, _)| *old == law).map_or(0, |(_, count)| *count);
                let laws = laws.into_iter().map(|(law, count)| (law, count - old(law)));
                (after - accelerations, laws.filter(|(_, count)| *count > 0).collect::<Vec<_>>())
            });
            assert_eq!(changed, expected, "change {number} under {}", method.name());
        }
    }
}

#[test]
fn gravity_that_is_off_is_no_term() {
    let mut lab = lab_of(&[Effect::Gravity], Method::RungeKutta4);
    ask(&mut lab, [Request::Switch(Effect::Gravity, false)]);
    assert!(lab.run(5).evaluations().laws().is_empty());
    assert_eq!(lab.world.resource::<Gravity>().acceleration, Vector::new(0.0, -9.8, 0.0));
}
