//! What is foretold of nets, against runs.

use glam::DVec3;
use motion::margin::{LimitingPart, Margin, Margins};
use motion::{
    Damping, DampingModel, Drag, Elastic, Method, MutualGravity, OwnLaws, Substeps, Well, Wells,
};

use super::limits::Net;
use crate::rigs::{Dice, Environment, Lab, Net as Springs, Start, elastic};

fn margins(rig: &mut Lab) -> Margins {
    Margins::of(&rig.world, rig.stepper.method())
}

fn worst(margins: &Margins) -> Margin {
    *margins.list().first().expect("something is looked at")
}

/// The worst margin of a net.
fn margin_of(net: &Springs, around: &Environment, method: Method, h: f64) -> Margin {
    worst(&margins(&mut net.lab(around, method, h)))
}

/// Two bodies on a spring of that stiffness over mass, one of them held.
fn stiff_spring(k: f64) -> Springs {
    damped_spring(k, 0.0)
}

/// The same with a damper of that rate.
fn damped_spring(stiffness: f64, damping: f64) -> Springs {
    let (post, body) = (Start::held(DVec3::ZERO), Start::of(1.0, DVec3::X, DVec3::ZERO));
    Springs::pair(post, body, Elastic::new(stiffness, 1.0).damped(damping))
}

/// The methods with a stability limit, one after the other and again.
fn limited() -> impl Iterator<Item = Method> {
    let limits = |method: &Method| method.claims().stability_limit;
    Method::ALL
        .into_iter()
        .filter(move |method| limits(method) > 0.0 && limits(method).is_finite())
        .cycle()
}

#[test]
fn a_net_breaks_where_it_was_foretold() {
    for (number, method) in (0..50).zip(limited()) {
        let net = Net::random(100 + number);
        let h = 1e-3;
        let margin = worst(&net.stepped(method, h).margins());
        let bounded = margin.at_most >= margin.value * (1.0 - 1e-9);
        assert!(bounded && margin.is_known(), "{} {margin:?}", net.name);
        let longest = h / margin.ratio();
        assert!(
            net.stepped(method, 0.99 * longest).stays(1500),
            "{} {method:?} breaks below",
            net.name
        );
        assert!(
            !net.stepped(method, 1.01 * longest).stays(1500),
            "{} {method:?} holds above",
            net.name
        );
    }
}

#[test]
fn a_net_in_drag_breaks_where_it_was_foretold() {
    for number in 0..18_u32 {
        let method = Method::ALL[number as usize % Method::ALL.len()];
        let net = Net::random(200 + u64::from(number));
        let w = net.largest_frequency();
        let net = Net { drag: [0.4, 1.2][number as usize / 9] * w, ..net };
        let margin = worst(&net.stepped(method, 0.01 / w).margins());
        if method == Method::ImplicitEuler {
            assert_eq!(margin.limit, f64::INFINITY);
            assert!(net.stepped(method, 100.0 / w).stays(200));
            continue;
        }
        let longest = 0.01 / w / margin.ratio();
        assert!(
            net.stepped(method, 0.99 * longest).stays(20_000),
            "{} {method:?} breaks below",
            net.name
        );
        assert!(
            !net.stepped(method, 1.01 * longest).stays(20_000),
            "{} {method:?} holds above",
            net.name
        );
    }
}

/// A net at rest of springs and dampers, each with its own damping, moved next to nothing.
fn dampers(seed: u64) -> Springs {
    let mut dice = Dice(seed);
    let n = 4 + dice.below(8);
    let mass = |dice: &mut Dice| 10.0_f64.powf(1.5 * dice.number());
    let place = |dice: &mut Dice, i: usize| DVec3::X * i as f64 + dice.vector() * 0.3;
    let mut bodies = vec![Start::held(DVec3::ZERO)];
    for i in 1..=n {
        let (mass, place) = (mass(&mut dice), place(&mut dice, i));
        bodies.push(Start::of(mass, place, DVec3::ZERO));
    }
    let mut ends: Vec<_> = (1..=n).map(|i| [i - 1, i]).collect();
    ends.extend((2..=n).map(|i| [i - 2, i]));
    ends.extend((3..=n).map(|i| [i - 3, i]));
    let spring = |ends: [usize; 2], dice: &mut Dice| {
        let stiffness = 10.0_f64.powf(3.0 + dice.number());
        let length = bodies[ends[0]].x.distance(bodies[ends[1]].x);
        let damping = 0.02 * stiffness.sqrt() * 10.0_f64.powf(dice.number());
        (ends, Elastic::new(stiffness, length).damped(damping))
    };
    let springs = ends.into_iter().map(|ends| spring(ends, &mut dice)).collect();
    for body in &mut bodies[1..] {
        body.x += dice.vector() * 1e-9;
    }
    Springs { bodies, springs }
}

/// Whether it stays within a thousand times what it was moved by.
fn stays_at_rest(net: &Springs, method: Method, h: f64) -> bool {
    let mut rig = net.lab(&Environment::default(), method, h);
    let start = net.start();
    (0..1500).all(|_| {
        rig.run(1);
        (0..start.len()).all(|body| rig.x(body).distance(start[body].0) <= 3e-6)
    })
}

#[test]
fn a_net_of_dampers_breaks_where_it_was_foretold() {
    for (seed, method) in (0..35).zip(limited()) {
        let net = dampers(seed);
        let h = 1e-3;
        let margin = margin_of(&net, &Environment::default(), method, h);
        let longest = h / margin.ratio();
        assert!(
            stays_at_rest(&net, method, 0.99 * longest),
            "{seed} {method:?} breaks below {margin:?}"
        );
        assert!(
            !stays_at_rest(&net, method, 1.01 * longest),
            "{seed} {method:?} holds above {margin:?}"
        );
    }
}

#[test]
fn a_stiff_spring_needs_84_substeps_or_an_implicit_method() {
    let net = stiff_spring(1e8);
    let margin = margin_of(&net, &Environment::default(), Method::SemiImplicitEuler, 1.0 / 60.0);
    assert!((margin.value - 1e4 / 60.0).abs() <= 1e-6 * margin.value, "{margin:?}");
    assert!((margin.limit - 2.0).abs() <= 1e-4, "{margin:?}");
    assert!(margin.is_unstable() && matches!(margin.part, LimitingPart::Spring(_)));
    assert_eq!((margin.cure.substeps, margin.cure.method), (Some(84), Some(Method::ImplicitEuler)));
    for (substeps, unstable) in [(83, true), (84, false)] {
        let around = Environment { substeps: Some(substeps), ..Environment::default() };
        let margin = margin_of(&net, &around, Method::SemiImplicitEuler, 1.0 / 60.0);
        assert_eq!((margin.is_unstable(), margin.substeps), (unstable, substeps));
    }
}

#[test]
fn limits_are_exact_to_a_hundredth_on_both_sides() {
    for method in limited().take(5) {
        let limit = method.claims().stability_limit;
        for (part, unstable) in [(0.99, false), (1.01, true)] {
            let mut rig =
                stiff_spring(100.0).lab(&Environment::default(), method, part * limit / 10.0);
            let margin = worst(&margins(&mut rig));
            assert_eq!(margin.is_unstable(), unstable, "{method:?} {part}");
            assert!((margin.ratio() - part).abs() <= 1e-4, "{method:?} {part}");
        }
    }
}

#[test]
fn methods_that_are_never_stable_are_named_with_their_growth_and_another_method() {
    // |R|² = 1 + z² and 1 + z⁴/4.
    for (method, z, squared, other) in [
        (Method::ExplicitEuler, 0.1, 1.01, Method::SemiImplicitEuler),
        (Method::RungeKutta2Midpoint, 0.5, 1.0 + 0.5_f64.powi(4) / 4.0, Method::VelocityVerlet),
        (Method::RungeKutta2Heun, 0.1, 1.0 + 1e-4 / 4.0, Method::VelocityVerlet),
    ] {
        let margin = margin_of(&stiff_spring(100.0), &Environment::default(), method, z / 10.0);
        assert!(
            margin.is_unstable() && margin.limit == 0.0 && margin.ratio().is_infinite(),
            "{margin:?}"
        );
        let growth = f64::powf(squared, 0.5 * 10.0 / z);
        assert!((margin.growth_per_s / growth - 1.0).abs() <= 1e-6, "{margin:?} {growth}");
        assert_eq!((margin.cure.substeps, margin.cure.method), (None, Some(other)));
    }
    let net = stiff_spring(1e8);
    let margin = margin_of(&net, &Environment::default(), Method::ImplicitEuler, 1.0);
    assert!(
        !margin.is_unstable() && margin.limit.is_infinite() && margin.ratio() == 0.0,
        "{margin:?}"
    );
}

#[test]
fn damping_and_drag_of_single_bodies_have_their_own_limits() {
    let body = |rate: f64, model: DampingModel, method: Method| {
        let around =
            Environment { damping: Some(Damping { model, rate }), ..Environment::default() };
        let mut rig =
            Springs::free([Start::of(1.0, DVec3::ZERO, DVec3::X)]).lab(&around, method, 0.1);
        worst(&margins(&mut rig))
    };
    for (model, method, limit) in [
        (DampingModel::Tutorial, Method::SemiImplicitEuler, 2.0),
        (DampingModel::Tutorial, Method::RungeKutta4, 2.0),
        (DampingModel::Clamped, Method::SemiImplicitEuler, f64::INFINITY),
        (DampingModel::Exact, Method::SemiImplicitEuler, f64::INFINITY),
        (DampingModel::Exact, Method::RungeKutta2Heun, 2.0),
        (DampingModel::Exact, Method::RungeKutta4, 2.785_293_563),
        (DampingModel::Exact, Method::ImplicitEuler, f64::INFINITY),
    ] {
        let margin = body(5.0, model, method);
        assert!(matches!(margin.part, LimitingPart::Damping(_)), "{margin:?}");
        assert!((margin.value - 0.5).abs() < 1e-12, "{margin:?}");
        assert!(
            margin.limit == limit || (margin.limit / limit - 1.0).abs() <= 1e-4,
            "{margin:?} {limit}"
        );
        assert!(!margin.is_unstable());
    }
    assert!(body(20.1, DampingModel::Tutorial, Method::SemiImplicitEuler).is_unstable());

    // The slope of c u + k u² is c + 2 k u; it explains, and names no fault.
    let around = Environment { drag: Some(Drag::new(1.0, 0.5)), ..Environment::default() };
    let fast = Springs::free([Start::of(1.0, DVec3::ZERO, DVec3::Y * 30.0)]);
    let mut rig = fast.lab(&around, Method::ExplicitEuler, 0.1);
    let margin = worst(&margins(&mut rig));
    assert!((margin.value - 3.1).abs() < 1e-12 && margin.grows(), "{margin:?}");
    assert!(!margin.is_linear && !margin.is_unstable(), "{margin:?}");
    assert_eq!(margin.part, LimitingPart::Drag(rig.bodies[0]));
}

#[test]
fn an_over_damped_spring_names_its_damper_and_its_cure() {
    for method in [Method::SemiImplicitEuler, Method::RungeKutta4] {
        let net = damped_spring(400.0, 250.0);
        let margin = margin_of(&net, &Environment::default(), method, 1.0 / 60.0);
        assert!(matches!(margin.part, LimitingPart::Damper(_)), "{margin:?}");
        assert!((margin.value - 250.0 / 60.0).abs() < 1e-6 && margin.is_unstable(), "{margin:?}");
        let around = Environment { substeps: margin.cure.substeps, ..Environment::default() };
        assert!(!margin_of(&net, &around, method, 1.0 / 60.0).is_unstable());
    }
}

#[test]
fn a_well_is_looked_at_from_where_bodies_are() {
    let wells = Wells(vec![Well { position: DVec3::ZERO, strength: 8.0, softening: 0.0 }]);
    let around = Environment { wells: Some(wells), ..Environment::default() };
    let circle = |r: f64| Start::of(1.0, DVec3::Z * r, DVec3::X * (8.0 / r).sqrt());
    let bodies = [4.0, 2.0, 3.0].map(circle);
    let mut rig = Springs::free(bodies).lab(&around, Method::VelocityVerlet, 0.5);
    let margin = worst(&margins(&mut rig));
    // w² = 8 / 2³.
    assert_eq!(margin.part, LimitingPart::Well(0, rig.bodies[1]));
    assert!((margin.value - 0.5).abs() < 1e-6 && (margin.limit - 2.0).abs() < 1e-3, "{margin:?}");
    assert!(!margin.is_linear, "{margin:?}");
}

#[test]
fn the_limiting_spring_is_named_and_its_margin_is_that_of_the_group() {
    let mut net = crate::rigs::chain(6, 100.0, 1.0, 1.0);
    net.springs[3].1.stiffness = 5e4;
    let rig = net.lab(&Environment::default(), Method::VelocityVerlet, 1.0 / 60.0);
    let all = Margins::with_springs(&rig.world, Method::VelocityVerlet);
    let margin = worst(&all);
    assert_eq!(margin.part, LimitingPart::Spring([rig.bodies[3], rig.bodies[4]]));
    let ratios: Vec<_> = all.springs().iter().map(|spring| spring.ratio).collect();
    assert_eq!(ratios.len(), 6);
    let worst = all.springs().iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio)).unwrap();
    assert_eq!((worst.ends, worst.ratio), ([rig.bodies[3], rig.bodies[4]], margin.ratio()));
}

#[test]
fn a_large_cloth_of_dampers_is_judged_like_its_run() {
    let (columns, rows) = (12, 9);
    let at = |i: usize, j: usize| i * columns + j;
    let mut net = Springs::default();
    for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        let place = DVec3::new(j as f64, -(i as f64), 0.0);
        net.bodies.push(if i == 0 {
            Start::held(place)
        } else {
            Start::of(0.05, place, DVec3::ZERO)
        });
    }
    for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
        let mut join = |other: usize, length: f64| {
            let elastic = Elastic::new(200.0, length).damped(0.3 + 0.02 * j as f64);
            net.springs.push(([at(i, j), other], elastic));
        };
        if j + 1 < columns {
            join(at(i, j + 1), 1.0);
        }
        if i + 1 < rows {
            join(at(i + 1, j), 1.0);
        }
        if i + 1 < rows && j + 1 < columns {
            join(at(i + 1, j + 1), 2.0_f64.sqrt());
        }
    }
    let mut dice = Dice(5);
    for body in net.bodies.iter_mut().filter(|body| body.w > 0.0) {
        body.x += DVec3::new(dice.number(), dice.number(), 0.0) * 1e-9;
    }
    for method in [Method::SemiImplicitEuler, Method::VelocityVerlet, Method::RungeKutta4] {
        let margin = margin_of(&net, &Environment::default(), method, 1e-3);
        let longest = 1e-3 / margin.ratio();
        assert!(stays_at_rest(&net, method, 0.99 * longest), "{method:?} breaks below {margin:?}");
        assert!(!stays_at_rest(&net, method, 1.01 * longest), "{method:?} holds above {margin:?}");
    }
}

#[test]
fn a_scene_of_nothing_that_could_be_unstable_is_not_looked_at() {
    let falling = Springs::free([Start::of(1.0, DVec3::ZERO, DVec3::X)]);
    let mut rig = falling.lab(&Environment::falling(), Method::ExplicitEuler, 0.1);
    assert!(margins(&mut rig).list().is_empty());
    rig.world.insert_resource(Substeps(5));
    assert!(margins(&mut rig).list().is_empty());
}

#[test]
fn laws_of_single_bodies_are_looked_at_by_their_derivatives() {
    let wells = Wells(vec![Well { position: DVec3::ZERO, strength: 8.0, softening: 0.0 }]);
    // A circle of w = 1.
    let body = Springs::free([Start::of(1.0, DVec3::Y * 2.0, DVec3::X * 2.0)]);
    let mut rig = body.lab(&Environment::default(), Method::VelocityVerlet, 0.5);
    rig.insert(0, OwnLaws::new(vec![Box::new(wells)]));
    let margin = worst(&margins(&mut rig));
    assert_eq!(margin.part, LimitingPart::Law("wells", rig.bodies[0]));
    assert!((margin.value - 0.5).abs() < 1e-6 && !margin.is_linear, "{margin:?}");
}

#[test]
fn a_limit_is_the_same_seen_from_afar() {
    for k in [1e-30, 1e-11, 1e-4, 1e8, 1e18, 1e30, 1e60] {
        for damped in [false, true] {
            let net = damped_spring(k, if damped { 1e-12 * k.sqrt() } else { 0.0 });
            let margin = margin_of(&net, &Environment::default(), Method::SemiImplicitEuler, 1e-2);
            assert!((margin.limit - 2.0).abs() <= 0.02, "{k:e} {damped}: {margin:?}");
            assert_eq!(margin.is_unstable(), 1e-2 * k.sqrt() > 2.0, "{k:e} {damped}: {margin:?}");
            assert_eq!(margin.cure.substeps.is_some(), k == 1e8, "{k:e}");
        }
    }
}

#[test]
fn a_net_without_end_is_unstable() {
    let post = Start::held(DVec3::ZERO);
    let light = Springs::pair(post, Start::of(1e-300, DVec3::X, DVec3::ZERO), elastic(1e10, 1.0));
    let fast =
        Springs::pair(post, Start::of(1.0, DVec3::X, DVec3::splat(1e160)), elastic(1.0, 1.0));
    for (net, drag) in [(light, None), (fast, Some(Drag::new(0.0, 0.1)))] {
        for method in Method::ALL {
            let mut rig = net.lab(&Environment::default(), method, 1e-2);
            drag.into_iter().for_each(|drag| rig.world.insert_resource(drag));
            let margin = worst(&margins(&mut rig));
            assert!(margin.grows() && margin.ratio() == f64::INFINITY, "{method:?}: {margin:?}");
            assert_eq!(margin.cure, motion::margin::Cure::default(), "{method:?}");
        }
    }
}

/// More rates of damping than the forecast tells apart: it stays on the safe side, and close.
#[test]
fn many_rates_of_damping_are_taken_together() {
    let mut net = dampers(3);
    net.bodies
        .extend((0..40).map(|i| Start::of(1.0, DVec3::X * (20.0 + f64::from(i)), DVec3::ZERO)));
    let last = net.bodies.len() - 1;
    let spring = |i: usize| {
        let rest_length = net.bodies[i].x.distance(net.bodies[i - 1].x);
        ([i - 1, i], Elastic::new(100.0, rest_length).damped(0.5))
    };
    let springs: Vec<_> = (last - 39..=last).map(spring).collect();
    net.springs.extend(springs);
    let around = |rates: usize| {
        let mut rig = net.lab(&Environment::default(), Method::SemiImplicitEuler, 1e-3);
        rig.world.insert_resource(Damping { model: DampingModel::Exact, rate: 0.4 });
        for body in 0..rates {
            rig.insert(body, motion::DampingRate::new(0.1 + 0.01 * body as f64));
        }
        rig.recompile();
        worst(&margins(&mut rig))
    };
    let (few, many) = (around(4), around(last));
    assert!((few.limit / many.limit - 1.0).abs() < 0.02, "{few:?} {many:?}");
}

/// Two bodies on a circle have `w² = G (m + m') / r³`.
#[test]
fn mutual_gravity_has_the_frequency_of_the_fastest_pair() {
    for part in [0.7, 1.45] {
        let h = 1.0 / 60.0;
        let w = part / h;
        let far = Start::of(5.0, DVec3::X * 400.0, DVec3::ZERO);
        // A circle of 2 m about their center.
        let orbiting = |mass: f64, r: f64| Start::of(mass, DVec3::Y * r, DVec3::X * (w * r));
        let attraction = Some(MutualGravity { constant: w * w * 8.0 / 4.0, softening: 0.0 });
        let around = Environment { attraction, ..Environment::default() };
        let bodies = [far, orbiting(1.0, 1.5), orbiting(3.0, -0.5)];
        let mut rig = Springs::free(bodies).lab(&around, Method::SemiImplicitEuler, h);
        let margin = worst(&margins(&mut rig));
        assert_eq!(margin.part, LimitingPart::MutualGravity([rig.bodies[1], rig.bodies[2]]));
        assert!((margin.value - part).abs() < 1e-9 && !margin.is_linear, "{margin:?}");
    }
}

#[test]
fn of_many_wells_the_fastest_is_listed() {
    let well = |number: u32| Well {
        position: DVec3::X * f64::from(number + 1),
        strength: if number == 700 { 1e12 } else { 1.0 },
        softening: 0.0,
    };
    let around =
        Environment { wells: Some(Wells((0..1000).map(well).collect())), ..Environment::default() };
    let net = Springs::free([Start::of(1.0, DVec3::ZERO, DVec3::ZERO)]);
    let mut rig = net.lab(&around, Method::SemiImplicitEuler, 1.0 / 60.0);
    let all = margins(&mut rig);
    assert_eq!(all.list().len(), 1);
    assert_eq!(worst(&all).part, LimitingPart::Well(700, rig.bodies[0]));
}
