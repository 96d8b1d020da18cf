//! Orbits and drag: what the forecast says, beside runs of the kernels.

use glam::DVec3;
use motion::arrays::Bare;
use motion::margin::{Deviation, Fate, Forecast, LimitingPart, Margin, Occasion};
use motion::{Drag, Gravity, Law, Method, MutualGravity, Substeps, Well, Wells};

use crate::rigs::{Dice, Environment, Net as Springs, Start};

/// The methods that single bodies in wells are tried with.
const METHODS: [Method; 8] = [
    Method::ExplicitEuler,
    Method::SemiImplicitEuler,
    Method::PositionVerlet,
    Method::VelocityVerlet,
    Method::RungeKutta2Midpoint,
    Method::RungeKutta2Heun,
    Method::RungeKutta4,
    Method::Yoshida4,
];

fn well() -> Wells {
    Wells(vec![Well { position: DVec3::ZERO, strength: 1.0, softening: 0.0 }])
}

/// The worst margin of a body that is at `x` with the velocity `v`.
fn margin(around: &Environment, [x, v]: [DVec3; 2], method: Method, h: f64) -> Margin {
    let mut rig = Springs::free([Start::of(1.0, x, v)]).lab(around, method, h);
    Forecast::of(&mut rig.world, method).margins()[0]
}

/// Whether an orbit about a well of strength 1 stays between half its nearest and twice its farthest distance for
/// `turns` turns of the kernels.
fn stays(apsides: [f64; 2], method: Method, h: f64, substeps: u32, turns: f64) -> bool {
    let [near, far] = apsides;
    let a = near.midpoint(far);
    let mut bare = Bare::new(method, h).with_law(well()).with_substeps(substeps);
    bare.add([far, 0.0, 0.0], [0.0, (2.0 / far - 1.0 / a).sqrt(), 0.0], 1.0);
    let ticks = (turns * std::f64::consts::TAU * a.powf(1.5) / h).ceil() as u64;
    (0..ticks).all(|_| {
        bare.tick();
        let r = DVec3::from(bare.positions[0]).length();
        2.0 * r >= near && r <= 2.0 * far && !bare.has_failed()
    })
}

/// An ellipse that begins at its farthest point.
fn ellipse(e: f64) -> ([f64; 2], [DVec3; 2]) {
    let (near, far) = (1.0 - e, 1.0 + e);
    ([near, far], [DVec3::X * far, DVec3::Y * (2.0 / far - 1.0).sqrt()])
}

#[test]
fn circles_and_ellipses_are_judged_like_their_runs_and_cures_keep_them() {
    let around = Environment { wells: Some(well()), ..Environment::default() };
    let mut dice = Dice(42);
    let (mut alarms, mut cures) = (0, 0);
    let (mut false_alarms, mut missed, mut broken) = (Vec::new(), Vec::new(), Vec::new());
    for case in 0..500 {
        let method = METHODS[case % METHODS.len()];
        let e = if case % 3 == 0 { 0.0 } else { 0.9 * dice.number().abs() };
        // w h at the closest approach.
        let value = 10.0_f64.powf(0.75 * dice.number() - 0.25);
        let (apsides, start) = ellipse(e);
        let h = value * apsides[0].powf(1.5);
        let margin = margin(&around, start, method, h);
        assert!((margin.value / value - 1.0).abs() < 1e-6, "{margin:?} {value}");
        let holds = stays(apsides, method, h, 1, 100.0);
        alarms += usize::from(margin.is_unstable());
        assert_eq!(margin.is_reported(), margin.is_unstable(), "{margin:?}");
        match (margin.is_unstable(), holds) {
            (true, true) => false_alarms.push((method, value, e, margin.fate)),
            (false, false) => missed.push((method, value, e, margin.fate)),
            _ => {}
        }
        let substeps = margin.cure.substeps.map(|substeps| (method, substeps));
        for (method, substeps) in
            substeps.into_iter().chain(margin.cure.method.map(|method| (method, 1)))
        {
            cures += 1;
            if method == Method::ImplicitEuler || !stays(apsides, method, h, substeps, 100.0) {
                broken.push((case, method, substeps, value, e));
            }
        }
    }
    assert!(alarms > 150 && cures > 200, "{alarms} {cures}");
    assert!(false_alarms.is_empty() && missed.is_empty(), "{alarms} {false_alarms:?} {missed:?}");
    assert!(broken.is_empty(), "of {cures}: {broken:?}");
}

#[test]
fn circles_hold_and_break_on_either_side_of_their_limits() {
    let around = Environment { wells: Some(well()), ..Environment::default() };
    for method in METHODS {
        let (apsides, start) = ellipse(0.0);
        let here = margin(&around, start, method, 0.3);
        let lasts = here.lasts.unwrap();
        assert_eq!(lasts == 0.0, method == Method::ExplicitEuler, "{here:?}");
        for part in [0.9, 0.99, 1.01, 1.05].into_iter().filter(|_| lasts > 0.0) {
            let margin = margin(&around, start, method, part * lasts);
            // Near the limit there are resonances: above it values at which a circle lasts again, and some below at which it
            // does not.
            let holds = stays(apsides, method, part * lasts, 1, 100.0);
            assert_eq!(margin.is_unstable(), !holds, "{part} {margin:?}");
            assert!(holds || part > 0.9, "{method:?} {part}");
        }
        if method.claims().symplectic {
            let margin = margin(&around, start, method, 1.01 * here.limit);
            assert_eq!(margin.fate, Fate::Grows, "{margin:?}");
        }
    }
}

#[test]
fn implicit_euler_keeps_no_orbit_and_cures_none() {
    let around = Environment { wells: Some(well()), ..Environment::default() };
    let (_, start) = ellipse(0.0);
    for value in [0.05, 0.5, 1.43, 2.1] {
        assert!(margin(&around, start, Method::ImplicitEuler, value).is_unstable(), "{value}");
        let cure = margin(&around, start, Method::SemiImplicitEuler, value).cure;
        assert_ne!(cure.method, Some(Method::ImplicitEuler), "{value}");
    }
}

#[test]
fn two_bodies_are_an_orbit_and_more_are_run() {
    // A circle of 1 m about their center of mass.
    let pair = |w: f64| {
        let circle =
            |side: f64| Start::of(2.0, DVec3::X * (0.5 * side), DVec3::Y * (0.5 * side * w));
        (MutualGravity { constant: w * w / 4.0, softening: 0.0 }, [circle(1.0), circle(-1.0)])
    };
    let h = 1.0 / 60.0;
    for (value, fate) in [(1.0, Some(Fate::Holds)), (1.1, None), (1.45, Some(Fate::Grows))] {
        let (law, bodies) = pair(value / h);
        let around = Environment { attraction: Some(law), ..Environment::default() };
        let mut rig = Springs::free(bodies).lab(&around, Method::VelocityVerlet, h);
        let margin = Forecast::of(&mut rig.world, Method::VelocityVerlet).margins()[0];
        assert_eq!(margin.part, LimitingPart::MutualGravity([rig.bodies[0], rig.bodies[1]]));
        assert!((margin.value - value).abs() < 1e-6, "{margin:?}");
        assert!(
            fate.map_or(matches!(margin.fate, Fate::Drifts(_)), |fate| margin.fate == fate),
            "{margin:?}"
        );
    }
    // A comet that passes a sun and its planet: nothing but the run tells how near it comes.
    let sun = Start::of(100.0, DVec3::ZERO, DVec3::ZERO);
    let planet = Start::of(0.1, DVec3::Z * 4.0, DVec3::X * 5.0);
    let comet = Start::of(1e-3, DVec3::X * 8.0, DVec3::Y * 0.5);
    let law = MutualGravity { constant: 1.0, softening: 0.0 };
    let around = Environment { attraction: Some(law), ..Environment::default() };
    for (method, hz, unstable) in [
        (Method::VelocityVerlet, 60.0, true),
        (Method::VelocityVerlet, 20_000.0, false),
        (Method::ExplicitEuler, 60.0, true),
    ] {
        let mut rig = Springs::free([sun, planet, comet]).lab(&around, method, 1.0 / hz);
        let margin = Forecast::of(&mut rig.world, method).margins()[0];
        assert_eq!(margin.occasion, Occasion::Met, "{margin:?}");
        assert!(
            margin.value > 5.0 * margin.now && margin.is_unstable() == unstable,
            "{hz} {margin:?}"
        );
    }
}

#[test]
fn two_wells_and_a_well_with_a_spring_are_summed() {
    let h = 1.0 / 60.0;
    let strength = |value: f64| (value / h) * (value / h);
    for (value, unstable) in [(1.3, false), (1.5, true)] {
        let side =
            |x: f64| Well { position: DVec3::X * x, strength: strength(value), softening: 0.0 };
        let around = Environment {
            wells: Some(Wells(vec![side(1.0), side(-1.0)])),
            ..Environment::default()
        };
        let margin = margin(&around, [DVec3::Y * 0.1, DVec3::ZERO], Method::SemiImplicitEuler, h);
        assert_eq!(margin.is_unstable(), unstable, "{margin:?}");
    }
    for (spring, pull, unstable) in
        [(1.9, 0.0, false), (1.9, 0.6, false), (1.9, 0.64, true), (1.9, 1.2, true)]
    {
        let mut net = crate::rigs::chain(1, strength(spring), 1.0, 1.0);
        let at = net.bodies.iter().find(|body| body.w > 0.0).unwrap().x;
        let axis = (at - net.bodies[0].x).normalize();
        let across = axis.any_orthonormal_vector();
        net.bodies.iter_mut().filter(|body| body.w > 0.0).for_each(|body| body.x += across * 1e-3);
        let wells =
            Wells(vec![Well { position: at + across, strength: strength(pull), softening: 0.0 }]);
        let around = Environment { wells: Some(wells), ..Environment::default() };
        let mut rig = net.lab(&around, Method::SemiImplicitEuler, h);
        let margin = Forecast::of(&mut rig.world, Method::SemiImplicitEuler).margins()[0];
        assert_eq!(margin.is_unstable(), unstable, "{spring} {pull} {margin:?}");
    }
}

#[test]
fn a_well_that_repels_stiffens_the_spring_that_points_at_it() {
    let (stiffness, strength, h) = (10.0, -8.0, 1.0 / 2.3);
    let mut net = crate::rigs::chain(1, stiffness, 1.0, 1.0);
    let at = net.bodies.iter().find(|body| body.w > 0.0).unwrap().x;
    let axis = (at - net.bodies[0].x).normalize();
    let far = Well { position: at + axis * 50.0, strength: 1.0, softening: 0.0 };
    let near = Well { position: at + axis, strength, softening: 0.0 };
    let around = Environment { wells: Some(Wells(vec![far, near])), ..Environment::default() };
    let mut rig = net.lab(&around, Method::SemiImplicitEuler, h);
    let margin = Forecast::of(&mut rig.world, Method::SemiImplicitEuler).margins()[0];
    // The force of the well falls by 2 mu / r³ per meter.
    let expected = h * (stiffness - 2.0 * strength).sqrt();
    assert!((margin.value / expected - 1.0).abs() < 1e-4, "{margin:?} {expected}");
    assert!(margin.is_unstable() && margin.part == LimitingPart::Well(1, rig.bodies[1]));

    // Beside the spring, it does not.
    net.bodies[1].x += axis.any_orthonormal_vector() * 1e-3;
    let beside = Well { position: at + axis.any_orthonormal_vector(), ..near };
    let around = Environment { wells: Some(Wells(vec![beside])), ..Environment::default() };
    let mut rig = net.lab(&around, Method::SemiImplicitEuler, h);
    let margin = Forecast::of(&mut rig.world, Method::SemiImplicitEuler).margins()[0];
    let expected = h * (-2.0 * strength).sqrt();
    assert!((margin.value / expected - 1.0).abs() < 1e-2, "{margin:?} {expected}");
}

#[test]
fn a_free_body_that_a_well_repels_is_thrown_away_and_not_unstable() {
    let wells = Wells(vec![Well { position: DVec3::ZERO, strength: -8.0, softening: 0.0 }]);
    let law = MutualGravity { constant: 1e-9, softening: 0.0 };
    for law in [None, Some(law)] {
        let around =
            Environment { wells: Some(wells.clone()), attraction: law, ..Environment::default() };
        let bodies = [DVec3::X, DVec3::X * 50.0].map(|place| Start::of(1.0, place, DVec3::ZERO));
        let mut rig = Springs::free(bodies).lab(&around, Method::SemiImplicitEuler, 0.6);
        let forecast = Forecast::of(&mut rig.world, Method::SemiImplicitEuler);
        let is_of_well = |margin: &&Margin| matches!(margin.part, LimitingPart::Well(..));
        assert_eq!(forecast.margins().iter().find(is_of_well), None);
    }
}

/// Whether a body that only drag slows down from a speed ever moves by more than four times as much in a tick.
fn grows(drag: Drag, speed: f64, (method, h): (Method, f64), substeps: u32) -> bool {
    let mut bare = Bare::new(method, h).with_law(drag).with_substeps(substeps);
    bare.add([0.0; 3], [speed, 0.0, 0.0], 1.0);
    (0..240).any(|_| {
        let before = DVec3::from(bare.positions[0]);
        bare.tick();
        let holds = DVec3::from(bare.positions[0]).distance(before) <= 4.0 * speed * h;
        !holds || bare.has_failed()
    })
}

#[test]
fn quadratic_drag_grows_from_the_limit_of_its_own_law_on() {
    for (method, known) in [
        (Method::ExplicitEuler, 2.0),
        (Method::SemiImplicitEuler, 2.0),
        (Method::PositionVerlet, 3.24),
        (Method::RungeKutta4, 2.455),
        (Method::Yoshida4, 1.12),
    ] {
        let h = 0.01;
        let of = |value: f64| {
            let around =
                Environment { drag: Some(Drag::new(0.0, value / h)), ..Environment::default() };
            margin(&around, [DVec3::ZERO, DVec3::X], method, h)
        };
        let limit = of(0.9 * known).limit;
        assert!((limit / known - 1.0).abs() < 0.01, "{method:?} {limit}");
        for (part, unstable) in [(0.99, false), (1.01, true)] {
            let margin = of(part * limit);
            assert_eq!(margin.is_unstable(), unstable, "{margin:?}");
            assert_eq!(
                grows(Drag::new(0.0, part * limit / h), 1.0, (method, h), 1),
                unstable,
                "{method:?} {part}"
            );
        }
        let cure = of(1.5 * known).cure;
        let substeps = cure.substeps.map(|substeps| (method, substeps));
        for (method, substeps) in substeps.into_iter().chain(cure.method.map(|method| (method, 1)))
        {
            assert!(
                !grows(Drag::new(0.0, 1.5 * known / h), 1.0, (method, h), substeps),
                "{method:?} x {substeps}"
            );
        }
        assert!(cure.substeps.is_some() && cure.method.is_some(), "{cure:?}");
    }
}

#[test]
fn a_fall_that_settles_at_a_wrong_speed_is_told_with_that_speed() {
    let h = 1.0 / 60.0;
    let fall = |k: f64, method: Method, h: f64| {
        let around = Environment { drag: Some(Drag::new(0.0, k)), ..Environment::falling() };
        (around.clone(), margin(&around, [DVec3::ZERO; 2], method, h))
    };
    // From rest, by Runge-Kutta 4 (computed outside: shared design, limits beyond springs).
    for (k, multiple) in [(700.0, 0.82), (800.0, 0.56), (1000.0, 0.32)] {
        let (_, margin) = fall(k, Method::RungeKutta4, h);
        assert!(
            matches!(margin.fate, Fate::Wrong(Deviation::Settles(m)) if (m - multiple).abs() < 0.02),
            "{margin:?}"
        );
        assert_eq!(margin.occasion, Occasion::TerminalSpeed);
        let mut bare =
            Bare::new(Method::RungeKutta4, h).with_law(Drag::new(0.0, k)).with_law(Gravity::EARTH);
        bare.add([0.0; 3], [0.0; 3], 1.0);
        (0..1000).for_each(|_| bare.tick());
        let terminal = (-Gravity::EARTH.affine().unwrap().constant.y / k).sqrt();
        assert!((-bare.bodies[0][1] / terminal - multiple).abs() < 0.02, "{:?}", bare.bodies[0]);
    }
    for method in [Method::ExplicitEuler, Method::SemiImplicitEuler] {
        assert!(matches!(fall(13.0, method, 0.1).1.fate, Fate::Wrong(Deviation::Alternates(_))));
        let (_, calm) = fall(9.0, method, 0.1);
        assert_eq!(calm.fate, Fate::Holds, "{calm:?}");
    }
    assert_eq!(fall(1.0, Method::ImplicitEuler, 0.1).1.fate, Fate::Holds);
}

#[test]
fn an_over_damped_spring_names_its_damper_and_its_cure() {
    for method in [Method::ExplicitEuler, Method::RungeKutta2Midpoint, Method::RungeKutta2Heun] {
        let mut net = crate::rigs::chain(1, 400.0, 1.0, 1.0);
        net.springs[0].1.damping = 150.0;
        let mut rig = net.lab(&Environment::default(), method, 1.0 / 60.0);
        let margin = Forecast::of(&mut rig.world, method).margins()[0];
        assert!(matches!(margin.part, LimitingPart::Damper(_)), "{margin:?}");
        assert!((margin.value - 2.5).abs() < 1e-6 && margin.is_unstable(), "{margin:?}");
        assert_eq!(margin.cure.substeps, Some(2), "{margin:?}");
        rig.world.insert_resource(Substeps(2));
        assert!(!Forecast::of(&mut rig.world, method).margins()[0].is_unstable());
    }
}

/// A rod that hangs from a post and has no tension yet, at 60 degrees from the vertical.
const PENDULUM: &str =
    "(version: 1, step_hz: 60, method: METHOD, gravity: (acceleration_m_s2: (0, -9.81, 0)), bodies: [
    (name: \"post\", immovable: true), (name: \"bob\", position_m: (0.5, -0.8660254, 0), mass_kg: 1.0)],
    springs: [(between: (\"post\", \"bob\"), stiffness_n_m: 200, rest_length_m: 1, damping_n_s_m: 28)])";

/// A critically damped spring that begins stretched, so that it has some stiffness across, where nothing damps, until it rests.
const SETTLING: &str = "(version: 1, step_hz: 60, method: METHOD, bodies: [
    (name: \"post\", immovable: true), (name: \"bob\", position_m: (1.3, 0, 0), mass_kg: 1.0)],
    springs: [(between: (\"post\", \"bob\"), stiffness_n_m: 100, rest_length_m: 1, damping_n_s_m: 20)])";

#[test]
fn methods_that_need_damping_are_judged_over_the_motion() {
    for (scene, method, unstable) in [
        (PENDULUM, "explicit_euler", true),
        (PENDULUM, "semi_implicit_euler", false),
        (SETTLING, "explicit_euler", false),
        (SETTLING, "runge_kutta_2_heun", false),
    ] {
        let scene = scene.replace("METHOD", method);
        let mut run = history::Simulation::new(crate::rigs::scene_of(&scene));
        let method = run.method();
        let margin = Forecast::of(&mut run.world, method).margins()[0];
        assert_eq!(margin.is_unstable(), unstable, "{margin:?}");
        // Over the top, or at rest.
        let highest = (0..6000).map(|_| {
            run.tick();
            let bob = run.body(1).unwrap();
            run.world.get::<motion::Transform>(bob).unwrap().position.y
        });
        assert_eq!(highest.fold(f64::NEG_INFINITY, f64::max) > 0.5, unstable, "{method:?}");
    }
}

#[test]
fn random_drag_is_judged_like_its_runs_and_cures_hold() {
    let h = 1.0 / 60.0;
    let mut dice = Dice(7);
    let mut between = |low: f64, high: f64| low * (high / low).powf(0.5 * (dice.number() + 1.0));
    let (mut alarms, mut false_alarms, mut missed, mut broken) =
        (0, Vec::new(), Vec::new(), Vec::new());
    for case in 0..500 {
        let method = Method::ALL[case % Method::ALL.len()];
        let speed = between(0.1, 100.0);
        let (linear, quadratic) = (between(0.01, 200.0), between(0.3, 6.0) / h / speed);
        let drag = Drag::new(if case % 3 == 0 { linear } else { 0.0 }, quadratic);
        let around = Environment { drag: Some(drag), ..Environment::default() };
        let margin = margin(&around, [DVec3::ZERO, DVec3::X * speed], method, h);
        let grows = |method: Method, substeps: u32| grows(drag, speed, (method, h), substeps);
        alarms += usize::from(margin.is_unstable());
        assert_eq!(margin.is_reported(), margin.is_unstable(), "{margin:?}");
        match (margin.is_unstable(), grows(method, 1)) {
            (true, false) => false_alarms.push((method, drag, speed)),
            (false, true) => missed.push((method, drag, speed)),
            _ => {}
        }
        let substeps = margin.cure.substeps.map(|substeps| (method, substeps));
        for (method, substeps) in
            substeps.into_iter().chain(margin.cure.method.map(|method| (method, 1)))
        {
            if grows(method, substeps) {
                broken.push((case, method, substeps));
            }
        }
    }
    assert!(alarms > 100, "{alarms}");
    assert!(
        false_alarms.is_empty() && missed.is_empty() && broken.is_empty(),
        "{false_alarms:?} {missed:?} {broken:?}"
    );
}

/// A world of bodies of 1 kg about a well of strength 1.
fn about_a_well(bodies: &[[DVec3; 2]], method: Method, h: f64) -> crate::rigs::Lab {
    let around = Environment { wells: Some(well()), ..Environment::default() };
    let starts: Vec<_> = bodies.iter().map(|[x, v]| Start::of(1.0, *x, *v)).collect();
    Springs::free(starts).lab(&around, method, h)
}

fn worst(rig: &mut crate::rigs::Lab) -> Margin {
    let method = rig.stepper.method();
    Forecast::of(&mut rig.world, method).margins()[0]
}

#[test]
fn a_body_that_only_passes_hides_no_orbit() {
    let passing = [DVec3::X, DVec3::X * 10.0];
    let circling = [DVec3::Y * 1.05, DVec3::Z / 1.05_f64.sqrt()];
    let margin = worst(&mut about_a_well(&[passing, circling], Method::VelocityVerlet, 1.3));
    assert!(
        matches!(margin.fate, Fate::Drifts(_)) && (margin.value - 1.208).abs() < 1e-3,
        "{margin:?}"
    );
}

#[test]
fn an_orbit_too_slow_to_be_tried_is_judged_at_its_closest_approach() {
    // A turn of 1000 s, 60,000 ticks, half of which pass before w h is 3.3.
    let a = (1000.0 / std::f64::consts::TAU).powf(2.0 / 3.0);
    let far = a * 1.999;
    let start = [DVec3::X * far, DVec3::Y * (2.0 / far - 1.0 / a).sqrt()];
    let margin = worst(&mut about_a_well(&[start], Method::VelocityVerlet, 1.0 / 60.0));
    assert!(margin.fate == Fate::Grows && (margin.value - 3.31).abs() < 0.01, "{margin:?}");
}

#[test]
fn position_verlet_is_judged_with_the_velocity_of_its_position() {
    let mut rig = about_a_well(&[[DVec3::X, DVec3::Y]], Method::PositionVerlet, 0.5);
    for _ in 0..40 {
        let margin = worst(&mut rig);
        // The method's own circle is not the true one. With the velocity of half a step before it would be up to 0.8.
        assert!(margin.fate == Fate::Holds && margin.value < 0.6, "{margin:?}");
        rig.stepper.tick(&mut rig.world);
    }
}

#[test]
fn a_bead_on_a_line_comes_no_nearer_to_a_well_than_its_line() {
    let wells = Wells(vec![Well { position: DVec3::Y, strength: 1.0, softening: 0.0 }]);
    let around = Environment { wells: Some(wells), ..Environment::default() };
    let net = Springs::free([Start::of(1.0, DVec3::X * 2.0, DVec3::ZERO)]);
    let mut rig = net.lab(&around, Method::VelocityVerlet, 0.1);
    rig.insert(0, motion::AxisLocks { x: false, y: true, z: true });
    let margin = worst(&mut rig);
    assert!(margin.fate == Fate::Holds && margin.value < 0.11, "{margin:?}");
}

#[test]
fn a_lesser_well_accuses_nothing_and_a_small_quadratic_term_hides_nothing() {
    let far = Well { position: DVec3::X * 1e6, strength: 1e-12, softening: 0.0 };
    let wells = Wells(vec![well().0[0], far]);
    let around = Environment { wells: Some(wells), ..Environment::default() };
    let mut rig = Springs::free([Start::of(1.0, DVec3::X, DVec3::Y)]).lab(
        &around,
        Method::ExplicitEuler,
        1e-3,
    );
    let method = rig.stepper.method();
    let forecast = Forecast::of(&mut rig.world, method);
    assert!(
        forecast
            .margins()
            .iter()
            .all(|margin| margin.part == LimitingPart::Well(0, rig.bodies[0])
                || !margin.is_unstable())
    );
    let around = Environment { drag: Some(Drag::new(200.0, 1e-3)), ..Environment::default() };
    let margin = margin(&around, [DVec3::ZERO; 2], Method::RungeKutta4, 1.0 / 60.0);
    assert_eq!(margin.fate, Fate::Grows, "{margin:?}");
}

#[test]
fn a_light_body_that_is_thrown_out_is_seen_beside_heavy_ones() {
    let circling = |mass: f64, r: f64| Start::of(mass, DVec3::X * r, DVec3::Y / r.sqrt());
    let law = MutualGravity { constant: 1.0, softening: 0.0 };
    let around = Environment { attraction: Some(law), ..Environment::default() };
    let sun = Start::of(1.0, DVec3::ZERO, DVec3::ZERO);
    for (h, unstable) in [(0.4, true), (0.2, false)] {
        let net = Springs::free([sun, circling(0.01, 10.0), circling(1e-9, 1.0)]);
        let margin = worst(&mut net.lab(&around, Method::RungeKutta4, h));
        assert_eq!(margin.is_unstable(), unstable, "{margin:?}");
    }
}
