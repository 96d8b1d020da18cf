//! Supports that move: where they are, what hangs from them, what they cost the energy, and what of files is refused.

use std::f64::consts::PI;

use glam::DVec3;
use history::Simulation;
use motion::{Curve, METHODS, Method, PrescribedMotion, Quarantined, Request, Transform};
use scene::Scene;

use crate::ledger::Kept;
use crate::methods::orders::{claimed_orders, relative_errors};
use crate::rigs::{Environment, Lab, Net, Start, State, elastic, extrapolated, scene_of};

const FOREVER: f64 = f64::INFINITY;

fn sine(amplitude: DVec3, angular_frequency: f64, phase: f64) -> Curve {
    Curve::Sine { amplitude, angular_frequency, phase }
}

/// A ball on a spring of 8 N/m to a support that is shaken along it. The spring damps, too.
struct Shaken {
    damping: f64,
    /// Where the ball starts beyond the rest length, m, and how fast, m/s.
    start: [f64; 2],
    curve: Curve,
    from: f64,
    until: f64,
}

impl Shaken {
    const SPAN: f64 = 4.0;
    const MASS: f64 = 2.0;
    const REST: f64 = 2.0;

    fn lab(&self, method: Method, h: f64) -> Lab {
        let spring = motion::Elastic { damping: self.damping, ..elastic(8.0, Self::REST) };
        let (x, v) = self.ball();
        let ball = Start::of(Self::MASS, x, v);
        let net = Net::pair(Start::held(DVec3::ZERO), ball, spring);
        let mut lab = net.lab(&Environment::default(), method, h);
        lab.insert(0, self.motion());
        lab.recompile();
        lab
    }

    fn ball(&self) -> State {
        let [x, v] = self.start;
        (DVec3::X * (Self::REST + x), DVec3::X * v)
    }

    fn motion(&self) -> PrescribedMotion {
        PrescribedMotion::new(DVec3::ZERO, [(self.curve.clone(), self.from, self.until)])
    }

    /// The states of support and ball at the ends of eight parts of the span, from the equation of motion.
    fn exact(&self, support: impl Fn(f64) -> [f64; 2]) -> Vec<Vec<State>> {
        let acceleration = |t: f64, state: &[State]| {
            let ([x, v], (at, u)) = (support(t), state[0]);
            let pull = 8.0 * (at.x - x - Self::REST) + self.damping * (u.x - v);
            vec![DVec3::X * (-pull / Self::MASS)]
        };
        let found = extrapolated(&[self.ball()], Self::SPAN, 8, 1 << 13, acceleration);
        let with_support = |(part, ball): (usize, Vec<State>)| {
            let [x, v] = support(Self::SPAN * (part + 1) as f64 / 8.0);
            vec![(DVec3::X * x, DVec3::X * v), ball[0]]
        };
        found.into_iter().enumerate().map(with_support).collect()
    }

    fn orders(&self, exact: &[Vec<State>], method: Method, steps: usize) -> [f64; 2] {
        let error = |steps: usize| {
            let mut lab = self.lab(method, Self::SPAN / steps as f64);
            relative_errors(exact.iter().flat_map(|exact| {
                lab.run(steps as u64 / 8).states().into_iter().zip(exact.iter().copied())
            }))
        };
        let [coarse, fine] = [error(steps / 2), error(steps)];
        [0, 1].map(|column| (coarse[column] / fine[column]).log2())
    }

    fn check(&self, support: impl Fn(f64) -> [f64; 2]) {
        let exact = self.exact(support);
        for claims in METHODS {
            let claimed = claimed_orders(claims, self.damping > 0.0);
            let steps = if claimed[0] == 1 { 1 << 13 } else { 1 << 9 };
            let orders = self.orders(&exact, claims.method, steps);
            for (order, claimed) in orders.into_iter().zip(claimed) {
                let off = (order - f64::from(claimed)).abs();
                assert!(off <= 0.06, "{:?}, {}: {orders:.3?}", self.curve, claims.name);
            }
        }
    }
}

#[test]
fn every_method_keeps_its_order_on_what_hangs_from_a_shaken_support() {
    for damping in [0.0, 0.8] {
        let curve = sine(DVec3::X * 0.3, 3.0, 0.4);
        let shaken = Shaken { damping, start: [0.4, 0.3], curve, from: 0.0, until: FOREVER };
        shaken.check(|t| {
            let (sin, cos) = (3.0 * t + 0.4).sin_cos();
            [0.3 * (sin - 0.4_f64.sin()), 0.9 * cos]
        });
    }
}

#[test]
fn steps_are_split_where_the_motion_of_a_support_bends() {
    // It goes at 0.5 m/s from 0.37 s until 1.71 s: no tick ends there.
    let curve = Curve::Polynomial(vec![DVec3::ZERO, DVec3::X * 0.5]);
    let way = |t: f64| {
        [0.5 * (t.clamp(0.37, 1.71) - 0.37), if (0.37..1.71).contains(&t) { 0.5 } else { 0.0 }]
    };
    let points = vec![(0.37, DVec3::ZERO), (1.71, DVec3::X * 0.67)];
    for (curve, from, until) in [(curve, 0.37, 1.71), (Curve::Table(points), 0.0, FOREVER)] {
        let shaken = Shaken { damping: 0.0, start: [0.0; 2], curve, from, until };
        // The equation of motion, piece by piece, in closed form: w = 2.
        let exact: Vec<_> = (1..=8)
            .map(|part| {
                let t = Shaken::SPAN * f64::from(part) / 8.0;
                let (mut x, mut v) = (0.0_f64, 0.0_f64);
                for (start, end, speed) in
                    [(0.0, 0.37, 0.0), (0.37, 1.71, 0.5), (1.71, FOREVER, 0.0)]
                {
                    let length = t.min(end) - start;
                    if length <= 0.0 {
                        break;
                    }
                    // About the support, which goes uniformly.
                    let [at, _] = way(start);
                    let (sin, cos) = (2.0 * length).sin_cos();
                    let (d, u) = (x - at, v - speed);
                    (x, v) = (
                        at + speed * length + d * cos + u / 2.0 * sin,
                        speed - 2.0 * d * sin + u * cos,
                    );
                }
                let [at, speed] = way(t);
                vec![
                    (DVec3::X * at, DVec3::X * speed),
                    (DVec3::X * (Shaken::REST + x), DVec3::X * v),
                ]
            })
            .collect();
        for method in [Method::VelocityVerlet, Method::RungeKutta4, Method::Yoshida4] {
            let claims = METHODS.iter().find(|claims| claims.method == method).unwrap();
            let orders = shaken.orders(&exact, method, 1 << 9);
            for (order, claimed) in orders.into_iter().zip(claimed_orders(claims, false)) {
                // Where within a step the bend is, and so the error, changes with the step.
                assert!(order > f64::from(claimed) - 0.4, "{method:?}, {from}: {orders:?}");
            }
        }
    }
}

#[test]
fn the_shipped_resonance_swings_as_theory_says() {
    let (w0, rate) = (PI, 0.2 * PI);
    let mut simulation = Simulation::new(scene::load("resonance").unwrap());
    // Twelve times the time in which the first swings decay.
    simulation.run(40 * 120);
    for tick in 0..480 {
        let t = 40.0 + f64::from(tick) / 120.0;
        for (name, w) in [("slow", 0.5 * w0), ("equal", w0), ("fast", 2.0 * w0)] {
            let (a, b) = (w0 * w0 - w * w, rate * w);
            let (amplitude, behind) = (0.5 * w0 * w0 / a.hypot(b), b.atan2(a));
            let off = (position(&simulation, name).x - amplitude * (w * t - behind).sin()).abs();
            assert!(off < 2e-3 * amplitude, "{name} at {t} s: {off} of {amplitude}");
        }
        simulation.run(1);
    }
}

fn position(simulation: &Simulation, name: &str) -> DVec3 {
    let body = simulation.named(name).unwrap();
    simulation.world.get::<Transform>(body).unwrap().position
}

/// A stiff rod of 1 m that stands on a support, 0.02 rad from upright; the support goes up and down as
/// `amplitude sin(w t)`. The largest angle from upright within ten seconds, rad.
fn largest_angle(amplitude: f64, w: f64) -> f64 {
    let scene = scene_of(&format!(
        "(version: 1, step_hz: 1000, substeps: 4, method: velocity_verlet, gravity: (),
        bodies: [(name: \"support\", immovable: true),
            (name: \"bob\", position_m: ({:?}, {:?}, 0))],
        springs: [(between: (\"support\", \"bob\"), stiffness_n_m: 1e6, damping_n_s_m: 100, rest_length_m: 1)],
        moves: [(body: \"support\", curve: sine(amplitude_m: (0, {amplitude:?}, 0), angular_frequency_rad_s: {w:?}))])",
        0.02_f64.sin(),
        0.02_f64.cos(),
    ));
    let mut simulation = Simulation::new(scene);
    let mut largest = 0.0_f64;
    for _ in 0..10_000 {
        simulation.run(1);
        let d = position(&simulation, "bob") - position(&simulation, "support");
        largest = largest.max(d.x.atan2(d.y).abs());
    }
    largest
}

#[test]
fn a_pendulum_stands_on_a_support_that_is_shaken_fast_enough() {
    // It stands if A² w² > 2 g l (Kapitza 1951), here for A w above 4.43 m/s.
    let limit = (2.0 * 9.8_f64).sqrt();
    assert!(largest_angle(0.02, 1.3 * limit / 0.02) < 0.1);
    assert!(largest_angle(0.02, 0.7 * limit / 0.02) > 1.0);
}

#[test]
fn on_a_support_that_moves_uniformly_all_is_as_on_one_at_rest() {
    let v = DVec3::new(3.0, -2.0, 1.0);
    for claims in METHODS {
        let labs = [DVec3::ZERO, v].map(|v| {
            let x = DVec3::new(2.3, 0.4, 0.0);
            let spring = motion::Elastic { damping: 0.3, ..elastic(20.0, 2.0) };
            let ball = Start::of(0.5, x, DVec3::Y + v);
            let net = Net::pair(Start::held(DVec3::ZERO), ball, spring);
            let mut lab = net.lab(&Environment::default(), claims.method, 0.01);
            let curve = Curve::Polynomial(vec![DVec3::ZERO, v]);
            lab.insert(0, PrescribedMotion::new(DVec3::ZERO, [(curve, 0.0, FOREVER)]));
            lab.recompile().run(500);
            lab.states()
        });
        let [rest, moved] = labs;
        for ((x, u), (moved_x, moved_u)) in rest.into_iter().zip(moved) {
            let (off, by) = ((moved_x - v * 5.0 - x).length(), (moved_u - v - u).length());
            assert!(off < 1e-11 && by < 1e-11, "{}: {off:e} m, {by:e} m/s", claims.name);
        }
    }
}

#[test]
fn the_ledger_has_the_work_of_a_support() {
    let sections = "bodies: [(name: \"support\", immovable: true),
            (name: \"ball\", position_m: (1.2, 0, 0), velocity_m_s: (0, 0.5, 0), mass_kg: 2)],
        springs: [(between: (\"support\", \"ball\"), stiffness_n_m: 8, damping_n_s_m: 0.5, rest_length_m: 1)],
        moves: [(body: \"support\", curve: sine(amplitude_m: (0.3, 0, 0.1), angular_frequency_rad_s: 2))]";
    let mut kept = Kept::of(sections, Method::RungeKutta4, 2000.0, 1);
    let start = kept.ledger.energies_at_opening().total();
    kept.run(6000);
    let lines = &kept.ledger.since_opening().energy;
    let change = kept.ledger.energies().total() - start;
    assert!(lines.anchors.abs() > 0.1, "the support works: {lines:?}");
    assert!(kept.residual().abs() < 1e-12, "{lines:?}, {change}");
    let accounted = lines.anchors + lines.laws.iter().map(|(_, work)| work).sum::<f64>();
    assert!((change - accounted).abs() < 1e-12, "{change} {accounted}");
}

#[test]
fn what_rides_on_a_support_is_where_its_motion_has_it() {
    let scene = scene_of(
        "(version: 1, step_hz: 10, method: runge_kutta_4,
        bodies: [(name: \"sun\", immovable: true), (name: \"planet\", position_m: (5, 0, 0), velocity_m_s: (0, 1, 0))],
        wells: [(strength_m3_s2: 5, rides_on: \"sun\", bodies: [\"planet\"])],
        emitters: [(name: \"dust\", rides_on: \"sun\", rate_per_s: 40, speed_m_s: 0, life_s: 2, capacity: 80)],
        moves: [(body: \"sun\", curve: sine(amplitude_m: (0, 0, 1), angular_frequency_rad_s: 2))])",
    );
    let planet = |hz: f64| {
        let mut simulation = Simulation::new(Scene { step_hz: hz, ..scene.clone() });
        simulation.run((4.0 * hz) as u64);
        position(&simulation, "planet")
    };
    // Order 4: to the exact motion of the well, not to one that goes uniformly within a tick.
    let [coarse, middle, fine] = [20.0, 40.0, 80.0].map(planet);
    let order = ((coarse - middle).length() / (middle - fine).length()).log2();
    assert!((order - 4.0).abs() < 0.2, "{order}");

    let mut simulation = Simulation::new(scene);
    simulation.run(1);
    // Born at 0, 25, 50 and 75 ms, with the velocity of the sun.
    for slot in 0..4 {
        let born = 0.025 * f64::from(slot);
        let z = position(&simulation, &format!("dust.{slot}")).z;
        let expected = (2.0 * born).sin() + 2.0 * (2.0 * born).cos() * (0.1 - born);
        assert!((z - expected).abs() < 1e-15, "{slot}: {z} {expected}");
    }
}

#[test]
fn what_is_asked_of_a_support_leaves_it_on_its_curve() {
    let curve = sine(DVec3::Z * 0.3, 3.0, 0.0);
    let shaken = Shaken { damping: 0.0, start: [0.0; 2], curve, from: 0.0, until: FOREVER };
    let mut lab = shaken.lab(Method::VelocityVerlet, 0.01);
    let support = lab.bodies[0];
    for request in [
        Request::SetPosition(support, DVec3::X),
        Request::SetVelocity(support, DVec3::X),
        Request::Impulse(support, DVec3::X),
        Request::ReverseVelocities,
    ] {
        lab.ask(request);
    }
    lab.push(0, DVec3::X * 1e9).run(1);
    let (x, v) = lab.states()[0];
    let (sin, cos) = 0.03_f64.sin_cos();
    assert!((x - DVec3::Z * (0.3 * sin)).length() < 1e-15, "{x}");
    assert!((v - DVec3::Z * (0.9 * cos)).length() < 1e-15, "{v}");
}

#[test]
fn a_support_that_leaves_the_range_is_quarantined_where_it_was() {
    let scene = scene_of(
        "(version: 1, step_hz: 10, range: (position_m: 2), bodies: [(name: \"a\", immovable: true)],
        moves: [(body: \"a\", curve: polynomial([(0, 0, 0), (1, 0, 0)]))])",
    );
    let mut simulation = Simulation::new(scene);
    simulation.run(40);
    let body = simulation.named("a").unwrap();
    assert!(simulation.world.entity(body).contains::<Quarantined>());
    let x = position(&simulation, "a").x;
    assert!((x - 2.0).abs() < 1e-12, "{x}");
}
