//! The order of every method on every problem of coupled bodies, position and velocity apart.

use glam::DVec3;
use motion::internals::Solver;
use motion::{Claims, Damping, DampingModel, METHODS, Method, MutualGravity, OwnLaws};

use super::manufactured::manufactured;
use crate::methods::orders::{claimed_orders, relative_errors};
use crate::rigs::{Environment, Net, Start, State, elastic, extrapolated, pendulum, tetrahedron};

/// Parts of the span at whose ends the error is looked at.
const SAMPLES: usize = 8;

/// A net of which the states at the ends of the parts are known.
pub struct Problem {
    pub name: &'static str,
    pub span: f64,
    pub net: Net,
    pub around: Environment,
    pub own: fn(usize) -> Option<OwnLaws>,
    pub exact: Vec<Vec<State>>,
    pub velocity_laws: bool,
}

impl Problem {
    pub fn new(name: &'static str, span: f64, net: Net, exact: impl Fn(f64) -> Vec<State>) -> Self {
        let exact =
            (1..=SAMPLES).map(|sample| exact(span * sample as f64 / SAMPLES as f64)).collect();
        let around = Environment::default();
        Self { name, span, net, around, own: |_| None, exact, velocity_laws: false }
    }

    /// One without a closed form, from accelerations by plain formulas.
    fn without_form(
        name: &'static str,
        span: f64,
        net: Net,
        around: Environment,
        a: impl Fn(&[State]) -> Vec<DVec3>,
    ) -> Self {
        let exact = extrapolated(&net.start(), span, SAMPLES, 1 << 13, |_, state| a(state));
        Self { name, span, net, around, own: |_| None, exact, velocity_laws: false }
    }

    /// Largest errors over the samples and bodies relative to the largest exact values.
    fn errors(&self, method: Method, solver: Option<Solver>, steps: usize) -> [f64; 2] {
        let around = Environment { solver, ..self.around.clone() };
        let mut rig = self.net.lab(&around, method, self.span / steps as f64);
        for body in 0..rig.bodies.len() {
            if let Some(laws) = (self.own)(body) {
                rig.insert(body, laws);
            }
        }
        relative_errors(self.exact.iter().flat_map(|exact| {
            rig.run((steps / SAMPLES) as u64).states().into_iter().zip(exact.iter().copied())
        }))
    }

    /// `log2(E(h) / E(h / 2))` of position and velocity, of the finest pair of which rounding, if it all
    /// went one way, is at most a tenth; going all ways it is far below a hundredth.
    fn orders(&self, claims: &Claims, solver: Option<Solver>) -> [f64; 2] {
        let mut steps = match (claimed_orders(claims, self.velocity_laws)[0], claims.method) {
            (1, Method::ExplicitEuler) if self.name == "tetrahedron" => 1 << 16,
            (1, Method::ImplicitEuler) if self.name == "tetrahedron" => 1 << 14,
            (1, _) => 1 << 13,
            (2, _) => 1 << 11,
            _ => 1 << 12,
        };
        let mut fine = self.errors(claims.method, solver, steps);
        loop {
            let coarse = self.errors(claims.method, solver, steps / 2);
            let rounding = f64::EPSILON / 2.0 * steps as f64;
            if fine.iter().all(|error| *error >= 10.0 * rounding) {
                return [0, 1].map(|column| (coarse[column] / fine[column]).log2());
            }
            (fine, steps) = (coarse, steps / 2);
            assert!(steps > 64, "{}: nothing but rounding", self.name);
        }
    }

    /// Orders within 0.05 of the claimed ones.
    fn check(&self, claims: &Claims, solver: Option<Solver>) {
        let claimed = claimed_orders(claims, self.velocity_laws);
        let orders = self.orders(claims, solver);
        for (order, claimed) in orders.into_iter().zip(claimed) {
            let off = (order - f64::from(claimed)).abs();
            assert!(off <= 0.05, "{}, {}: {orders:.3?} for {claimed}", self.name, claims.name);
        }
    }

    /// [`Self::check_all`] of the methods of an order above 1.
    pub fn check_high(&self) {
        METHODS
            .iter()
            .filter(|claims| claims.position_order > 1)
            .for_each(|claims| self.check(claims, None));
    }

    pub fn check_all(&self) {
        METHODS.iter().for_each(|claims| self.check(claims, None));
    }
}

/// A post at the origin and 2 kg beyond a spring of rest length 2 m; along a line, as the deviation `x(t)`.
fn on_a_post(
    damping: f64,
    deviation: impl Fn(f64) -> (f64, f64),
) -> (Net, impl Fn(f64) -> Vec<State>) {
    let axis = DVec3::new(0.48, 0.6, 0.64);
    let at = move |t: f64| {
        let (x, v) = deviation(t);
        vec![(DVec3::ZERO, DVec3::ZERO), (axis * (2.0 + x), axis * v)]
    };
    let (x, v) = at(0.0)[1];
    // w = 2, c = 2 zeta w m.
    let spring = motion::Elastic { damping: 8.0 * damping, ..elastic(8.0, 2.0) };
    (Net::pair(Start::held(DVec3::ZERO), Start::of(2.0, x, v), spring), at)
}

#[test]
fn a_mass_on_a_spring() {
    let (net, exact) = on_a_post(0.0, |t| {
        let (sin, cos) = (2.0 * t).sin_cos();
        (0.5 * cos + 0.25 * sin, 0.5 * cos - sin)
    });
    Problem::new("oscillator", 4.0, net, exact).check_all();
}

#[test]
fn a_mass_on_a_spring_with_damping() {
    for zeta in [0.2, 1.0, 3.0] {
        let (net, exact) = on_a_post(zeta, move |t| {
            let (s, x, v) = (2.0 * zeta, 0.5, 0.5);
            let left = 4.0 - s * s;
            let r = left.abs().sqrt();
            let (cos, sin) = if left > 0.0 {
                ((r * t).cos(), (r * t).sin() / r)
            } else if left < 0.0 {
                ((r * t).cosh(), (r * t).sinh() / r)
            } else {
                (1.0, t)
            };
            let (decay, b) = ((-s * t).exp(), v + s * x);
            let at = x * cos + b * sin;
            (at * decay, (b * cos - left * x * sin - s * at) * decay)
        });
        Problem { velocity_laws: true, ..Problem::new("damped", 2.0, net, exact) }.check_all();
    }
}

#[test]
fn two_masses_and_a_spring() {
    let (axis, across) = (DVec3::new(0.48, 0.6, 0.64), DVec3::new(0.3, -0.2, 0.5));
    let w = (50.0 / 0.75_f64).sqrt();
    let exact = move |t: f64| {
        // Separation of m 1 and m 3 about their centre of mass, which moves on.
        let (sin, cos) = (w * t).sin_cos();
        let (x, v) = (1.0 + 0.2 * cos + 0.5 / w * sin, 0.5 * cos - 0.2 * w * sin);
        let state = |part: f64| (across * t + axis * (part * x), across + axis * (part * v));
        vec![state(-0.75), state(0.25)]
    };
    let starts = exact(0.0);
    let of = |mass: f64, (x, v): (DVec3, DVec3)| Start::of(mass, x, v);
    let net = Net::pair(of(1.0, starts[0]), of(3.0, starts[1]), elastic(50.0, 1.0));
    Problem::new("two masses", 1.0, net, exact).check_all();
}

/// Distance from known digits, at most what extrapolation leaves.
#[track_caller]
fn digits(got: DVec3, known: [f64; 3]) {
    let error = got.distance(DVec3::from_array(known));
    assert!(error <= 2e-12, "{got} for {known:?}: {error:e}");
}

/// S13, its mass moving at `v`.
fn on_a_string(v: DVec3) -> Problem {
    let mut net = pendulum(100.0);
    net.bodies[1].v = v;
    let around = Environment::pull(DVec3::Y * -9.81);
    let springs = net.clone();
    Problem::without_form("elastic pendulum", 2.0, net, around, move |state| {
        vec![DVec3::ZERO, springs.forces(state)[1] - DVec3::Y * 9.81]
    })
}

#[test]
fn an_elastic_pendulum() {
    let (x, v) = on_a_string(DVec3::ZERO).exact[SAMPLES - 1][1];
    digits(x, [0.466_536_552_151_127_3, -0.976_482_006_657_847_7, 0.0]);
    digits(v, [0.251_092_300_866_732_8, 1.249_657_376_757_730_3, 0.0]);
    // Not from rest: there the half step that semi-implicit Euler's velocity is late makes up for the half step
    // that it starts early, and it looks like order 2.
    on_a_string(DVec3::new(0.4, 0.3, -0.5)).check_all();
}

/// Three bodies that chase each other on an eight.
pub fn figure_eight() -> (Net, Environment) {
    let (x, v) = (
        DVec3::new(0.970_004_36, -0.243_087_53, 0.0),
        DVec3::new(-0.932_407_37, -0.864_731_46, 0.0),
    );
    let bodies =
        [(x, v * -0.5), (-x, v * -0.5), (DVec3::ZERO, v)].map(|(x, v)| Start::of(1.0, x, v));
    let attraction = Some(MutualGravity { constant: 1.0, softening: 0.0 });
    (Net::free(bodies), Environment { attraction, ..Environment::default() })
}

#[test]
fn three_bodies_on_an_eight() {
    let (net, around) = figure_eight();
    let problem = Problem::without_form("figure eight", 1.0, net, around, |state| {
        let pull = |a: usize, b: usize| {
            let r = state[b].0 - state[a].0;
            r / r.length().powi(3)
        };
        (0..3).map(|a| pull(a, (a + 1) % 3) + pull(a, (a + 2) % 3)).collect()
    });
    let known = [
        [0.993_582_919_940_977_9, 0.219_204_947_114_695_56, 0.0],
        [-0.050_734_285_274_952_34, 0.046_861_246_685_958_62, 0.0],
        [-0.942_848_634_666_025_5, -0.266_066_193_800_654_2, 0.0],
    ];
    problem.exact[SAMPLES - 1].iter().zip(known).for_each(|((x, _), known)| digits(*x, known));
    problem.check_all();
}

#[test]
fn four_masses_joined_two_by_two() {
    let net = tetrahedron();
    let springs = net.clone();
    let problem =
        Problem::without_form("tetrahedron", 2.0, net, Environment::default(), move |state| {
            let forces = springs.forces(state);
            forces.iter().zip(&springs.bodies).map(|(force, body)| *force * body.w).collect()
        });
    let end = &problem.exact[SAMPLES - 1];
    digits(
        end[0].0,
        [-0.111_348_234_798_915_44, -0.235_906_323_850_404_84, 1.324_832_881_425_341_2],
    );
    digits(end[3].0, [0.204_630_780_280_977_23, 0.077_219_582_263_536_79, 0.135_364_983_350_661_3]);
    problem.check_all();
}

/// A moving post under damping. The two Eulers damp it as well; for the others damping is a law, which acts on no
/// immovable body.
#[test]
fn a_post_that_moves_holds_what_is_damped() {
    let mut net = pendulum(60.0);
    (net.bodies[0].v, net.bodies[1].v) = (DVec3::new(1.0, 0.5, -0.3), DVec3::new(0.4, 0.3, -0.5));
    let damping = Some(Damping { model: DampingModel::Exact, rate: 0.8 });
    let around = Environment { damping, ..Environment::pull(DVec3::Y * -9.81) };
    let problem = |rate: f64| {
        let springs = net.clone();
        let problem =
            Problem::without_form("moving post", 2.0, net.clone(), around.clone(), move |state| {
                let force = springs.forces(state)[1];
                vec![state[0].1 * -rate, force - DVec3::Y * 9.81 - state[1].1 * 0.8]
            });
        Problem { velocity_laws: true, ..problem }
    };
    let (slowed, steady) = (problem(0.8), problem(0.0));
    for claims in METHODS {
        let inside = [Method::ExplicitEuler, Method::SemiImplicitEuler].contains(&claims.method);
        if inside { &slowed } else { &steady }.check(claims, None);
    }
}

/// The linearized and the converged step are both of order 1; Newton iterations lead from one to the other quadratically.
#[test]
fn newton_iterations_lead_to_the_implicit_step_that_is_not_linearised() {
    let newton =
        |newton_iterations| Solver { newton_iterations, tolerance: 1e-12, ..Solver::default() };
    let problem = on_a_string(DVec3::ZERO);
    problem.check(Method::ImplicitEuler.claims(), Some(newton(5)));
    manufactured(true).check(Method::ImplicitEuler.claims(), Some(newton(5)));
    let end = |iterations| {
        let around = Environment { solver: Some(newton(iterations)), ..problem.around.clone() };
        let mut rig = problem.net.lab(&around, Method::ImplicitEuler, 1.0 / 60.0);
        rig.run(1);
        rig.state(1)
    };
    // v1 = v + h a(x1, v1), x1 = x + h v1: what is left of it.
    let left = |iterations| {
        let (x, v) = end(iterations);
        let state = [(DVec3::ZERO, DVec3::ZERO), (x, v)];
        let a = problem.net.forces(&state)[1] - DVec3::Y * 9.81;
        (v - a / 60.0).length()
    };
    let residuals = [0, 1, 2, 3, 6].map(left);
    assert!(residuals[0] > 1e-6 && residuals[2] < 1e-4 * residuals[0], "{residuals:?}");
    assert!(residuals[4] <= 1e-14, "{residuals:?}");
}
