//! The damping models, and drag of single bodies, against their formulas.

use history::Simulation;
use motion::effects::{Effect, EffectState};
use motion::margin::Margins;
use motion::units::Vector;
use motion::{
    AxisLocks, Damping, DampingModel, DampingRate, Method, PhysicsBody, Request, SpeedLimit,
};

use crate::rigs::{G, H, Lab, close, digits, scene_of};

fn fall(model: DampingModel, hz: f64, seconds: f64) -> (f64, f64) {
    let mut lab = Lab::new(Method::SemiImplicitEuler, 1.0 / hz).with_gravity();
    lab = lab.with(Damping { model, rate: 0.4 });
    let body = lab.body(10.0, Vector::ZERO);
    lab.run((hz * seconds).round() as u64);
    (lab.v(body).y, lab.x(body).y - 10.0)
}

#[test]
fn clamped_damping_gives_the_numbers_of_physx() {
    let (v, drop) = fall(DampingModel::Clamped, 120.0, 1.0);
    digits(v, "-8.061168");
    digits(drop, "-4.332590");
    let (v, drop) = fall(DampingModel::Clamped, 120.0, 10.0);
    digits(v, "-23.974074");
    digits(drop, "-184.447932");
    // The ways differ from the tutorial's by exactly the factor that is applied before the move, not after.
    let (_, tutorial) = fall(DampingModel::Tutorial, 120.0, 10.0);
    close(drop, tutorial * (1.0 - 0.4 * H), 1e-12);
}

#[test]
fn the_same_second_at_four_rates() {
    let tutorial = [(30.0, "-8.013003", "-4.467492"), (60.0, "-8.045145", "-4.387138")];
    let tutorial = tutorial
        .into_iter()
        .chain([(120.0, "-8.061168", "-4.347081"), (240.0, "-8.069167", "-4.327082")]);
    for (hz, v, drop) in tutorial {
        let (moved_v, moved) = fall(DampingModel::Tutorial, hz, 1.0);
        digits(moved_v, v);
        digits(moved, drop);
        // The exact model has one velocity at every rate, that of the differential equation.
        let (exact_v, _) = fall(DampingModel::Exact, hz, 1.0);
        close(exact_v, G / 0.4 * (1.0 - (-0.4_f64).exp()), 1e-13);
    }
}

#[test]
fn terminal_speed_of_each_model() {
    // q = c h = 0.5: the models differ by half.
    let rate = 60.0;
    let terminal = |model| {
        let mut lab =
            Lab::new(Method::SemiImplicitEuler, H).with_gravity().with(Damping { model, rate });
        let body = lab.body(1.0, Vector::ZERO);
        lab.run(400);
        let before = lab.x(body).y;
        lab.run(1);
        (lab.v(body).y, (lab.x(body).y - before) / H)
    };
    let right = G / rate;
    // Rounding of a position near 10 m, seen as a speed.
    let noise = 10.0 * f64::EPSILON / H / right.abs();
    let (stored, moves) = terminal(DampingModel::Tutorial);
    close(stored, right * 0.5, 1e-14);
    close(moves, right, noise);
    let (stored, moves) = terminal(DampingModel::Clamped);
    close(stored, right * 0.5, 1e-14);
    close(moves, right * 0.5, 2.0 * noise);
    let (stored, moves) = terminal(DampingModel::Exact);
    close(stored, right, 1e-14);
    close(moves, right, noise);
}

#[test]
fn strong_damping_flips_the_tutorial_stops_clamped_and_decays_exactly() {
    let after = |model, q: f64| {
        let mut lab = Lab::new(Method::SemiImplicitEuler, H).with(Damping { model, rate: q / H });
        let body = lab.body(1.0, Vector::X);
        lab.run(1);
        lab.v(body).x
    };
    close(after(DampingModel::Tutorial, 1.5), -0.5, 1e-14);
    close(after(DampingModel::Tutorial, 3.0), -2.0, 1e-14);
    assert_eq!(after(DampingModel::Clamped, 1.5), 0.0);
    close(after(DampingModel::Exact, 3.0), (-3.0_f64).exp(), 1e-14);
}

#[test]
fn two_thousand_seconds_of_damping_end_at_zero_not_in_subnormals() {
    for model in DampingModel::ALL {
        let mut lab = Lab::new(Method::SemiImplicitEuler, H).with(Damping { model, rate: 0.4 });
        let v = Vector::new(1.0, -1.0, 1e-300);
        let plain = lab.body(10.0, v);
        let asking = [
            (DampingRate::new(0.4), SpeedLimit(f64::MAX), AxisLocks::default()),
            (DampingRate::new(0.5), SpeedLimit(2.0), AxisLocks { z: true, ..Default::default() }),
        ];
        let asking = asking
            .map(|asked| lab.world.spawn((PhysicsBody::with_mass(1.0).moving_at(v), asked)).id());
        lab.run(240_000);
        for body in asking.into_iter().chain([plain]) {
            assert_eq!(lab.v(body), Vector::ZERO, "{model:?}");
        }
    }
}

#[test]
fn travel_after_one_push_is_force_times_inverse_mass_times_step_over_rate() {
    for rate in [0.1, 0.4, 2.0] {
        for model in DampingModel::ALL {
            let mut lab = Lab::new(Method::SemiImplicitEuler, H).with(Damping { model, rate });
            let body = lab.body(10.0, Vector::ZERO);
            lab.push(body, Vector::X * 10.0).run((60.0 / rate / H) as u64);
            let q = rate * H;
            let discrete = match model {
                DampingModel::Tutorial => 1.0,
                DampingModel::Clamped => 1.0 - q,
                DampingModel::Implicit => 1.0,
                // The kick is smoothed over its own step and the body moves with the velocity after it.
                DampingModel::Exact => 1.0,
            };
            close(lab.x(body).x, H * 10.0 * 10.0 / rate * discrete, 1e-12);
        }
    }
}

/// Two bodies that fall through air, each with a drag of its own.
fn falling(method: Method, keys: &str) -> Simulation {
    Simulation::new(scene_of(&format!(
        "(version: 1, step_hz: 240, method: {}, gravity: (acceleration_m_s2: (0, -9.8, 0)), bodies: [
            (name: \"heavy\", mass_kg: 2, {keys}), (name: \"light\", mass_kg: 0.05, {keys})])",
        method.name()
    )))
}

fn speed(run: &Simulation, name: &str) -> f64 {
    run.world.get::<PhysicsBody>(run.named(name).unwrap()).unwrap().velocity.length()
}

#[test]
fn drag_of_single_bodies_is_a_force_so_the_lighter_one_falls_slower_by_every_method() {
    let seconds = 1.5_f64;
    for method in Method::ALL {
        let tolerance = if method.claims().velocity_order == 1 { 5e-3 } else { 1e-4 };
        for (keys, q, b) in [
            ("drag_area_m2: 0.08", 0.049_f64, 0.0_f64),
            ("quadratic_drag_kg_m: 0.049", 0.049, 0.0),
            ("linear_drag_kg_s: 0.1", 0.0, 0.1),
        ] {
            let mut run = falling(method, keys);
            run.run(360);
            for (name, m) in [("heavy", 2.0_f64), ("light", 0.05)] {
                // v = V tanh(g t / V) with V = sqrt(m g / q), and v = (m g / b)(1 - e^(-b t / m)).
                let terminal = (m * 9.8 / q).sqrt();
                let exact = match b {
                    0.0 => terminal * (9.8 * seconds / terminal).tanh(),
                    b => -(m * 9.8 / b) * (-b * seconds / m).exp_m1(),
                };
                let error = speed(&run, name) / exact - 1.0;
                // Position Verlet's velocity is half a tick behind.
                let lag = if method == Method::PositionVerlet { 2e-3 } else { 0.0 };
                assert!(error.abs() < tolerance + lag, "{method:?}, {keys}, {name}: {error}");
            }
        }
    }
}

#[test]
fn drag_of_single_bodies_follows_the_mass_and_goes_with_the_effect() {
    let mut run = falling(Method::RungeKutta4, "linear_drag_kg_s: 0.1");
    run.request(Request::SetInverseMass(run.named("heavy").unwrap(), 20.0));
    run.run(360);
    assert_eq!(speed(&run, "heavy"), speed(&run, "light"), "now they have one mass");
    let mut run = falling(Method::SemiImplicitEuler, "drag_area_m2: 1");
    let mut free = falling(Method::SemiImplicitEuler, "");
    assert_eq!(motion::effects::state(&free.world, Effect::Drag), EffectState::NotDeclared);
    run.request(Request::Switch(Effect::Drag, false));
    run.run(100);
    free.run(100);
    assert!(run.states().eq(free.states()), "the bits of a fall without air");
}

#[test]
fn the_forecast_judges_drag_of_single_bodies_with_that_of_all() {
    // 1 / h = 10 per second: by 25 kg/s the body of 1 kg turns round in each tick, and faster.
    for (keys, scenes, unstable) in [
        ("linear_drag_kg_s: 25", "", true),
        ("linear_drag_kg_s: 15", "", false),
        ("linear_drag_kg_s: 15", "drag: (linear_per_s: 10),", true),
        ("quadratic_drag_kg_m: 40, velocity_m_s: (1, 0, 0)", "", true),
    ] {
        let scene = format!(
            "(version: 1, step_hz: 10, method: semi_implicit_euler, {scenes} bodies: [(name: \"b\", mass_kg: 1, {keys})])"
        );
        let run = Simulation::new(scene_of(&scene));
        let forecast = Margins::of(&run.world, Method::SemiImplicitEuler);
        let told = forecast.list().iter().any(|margin| margin.grows());
        assert_eq!(told, unstable, "{keys} {scenes}: {:?}", forecast.list());
    }
}
