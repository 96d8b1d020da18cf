//! Problems with known solutions, by name.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};
use motion::units::outer;
use motion::{BodyState, EvaluationTime, Jacobians, Law};

use super::arithmetic::{self, Formula, MakeLoop, Springs};
use super::exact::{eccentric_anomaly, jacobi};

/// Position, m, and velocity, m/s.
pub type State = (DVec3, DVec3);

/// A closed form: the state of every body that can move, in the order of the file, at a time in s, and its source.
pub(crate) type Exact = (fn(f64) -> Vec<State>, &'static str);

/// A problem on which methods are compared.
#[derive(Clone, Copy, Debug)]
pub struct Problem {
    /// Its name on the command line.
    pub name: &'static str,
    /// One line about it.
    pub description: &'static str,
    /// The bodies and laws, as a scene file.
    pub(crate) scene: fn() -> String,
    /// Ticks of the run.
    pub(crate) ticks: u64,
    /// A law that no scene file can declare.
    pub(crate) law: Option<Duffing>,
    /// A closed form.
    pub(crate) exact: Option<Exact>,
    /// Length of a natural period, s.
    pub(crate) period: Option<f64>,
    /// Least and most substeps per tick: from useless errors to round-off.
    pub(crate) ladder: (u32, u32),
    /// The problem in a loop over arrays; `None` if no loop was written for it.
    pub(crate) in_loop: Option<MakeLoop>,
}

impl Problem {
    /// Whether there is a loop over arrays of the same arithmetic.
    pub const fn has_loop(&self) -> bool {
        self.in_loop.is_some()
    }
}

/// Duffing's hardening spring without damping and drive, of unit mass: `x'' = -x - 2 x³` along every axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Duffing;

impl Law for Duffing {
    fn name(&self) -> &'static str {
        "duffing"
    }

    fn acceleration(&self, at: EvaluationTime, body: BodyState) -> DVec3 {
        Formula::acceleration(*self, at.time, body.position, body.velocity)
    }

    fn jacobians(&self, _: EvaluationTime, body: BodyState) -> Jacobians {
        let [position, velocity] = Formula::jacobians(*self, body.position, body.velocity);
        Jacobians { position, velocity }
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }

    fn has_potential(&self) -> bool {
        true
    }

    fn potential_energy(&self, body: BodyState) -> f64 {
        let part = |x: f64| 0.5 * x * x * (1.0 + x * x);
        let energy: f64 = body.position.to_array().into_iter().map(part).sum();
        energy * (1.0 / body.inverse_mass)
    }
}

impl Formula for Duffing {
    #[inline(always)]
    fn acceleration(self, _: f64, x: DVec3, _: DVec3) -> DVec3 {
        x.map(|x| -(x + 2.0 * x * x * x))
    }

    fn jacobians(self, x: DVec3, _: DVec3) -> [DMat3; 2] {
        let slope = |x: f64| -(1.0 + 6.0 * x * x);
        [DMat3::from_diagonal(DVec3::from_array(x.to_array().map(slope))), DMat3::ZERO]
    }
}

/// Uniform gravity g, m/s².
#[derive(Clone, Copy)]
struct Fall(DVec3);

impl Default for Fall {
    fn default() -> Self {
        Self(DVec3::NEG_Y * FALL)
    }
}

impl Formula for Fall {
    const IS_CONSTANT: bool = true;

    #[inline(always)]
    fn acceleration(self, _: f64, _: DVec3, _: DVec3) -> DVec3 {
        self.0
    }

    fn linear_rate(self) -> Option<f64> {
        Some(0.0)
    }
}

/// Uniform gravity g, m/s², and linear drag c, 1/s.
#[derive(Clone, Copy)]
struct TerminalFall(DVec3, f64);

impl Default for TerminalFall {
    fn default() -> Self {
        Self(DVec3::NEG_Y * FALL, DRAG)
    }
}

impl Formula for TerminalFall {
    const DEPENDS_ON_VELOCITY: bool = true;

    #[inline(always)]
    fn acceleration(self, _: f64, _: DVec3, v: DVec3) -> DVec3 {
        self.0 - v * self.1
    }

    fn linear_rate(self) -> Option<f64> {
        Some(self.1)
    }
}

/// A linear spring to the origin with stiffness per mass w², 1/s².
#[derive(Clone, Copy)]
struct Spring(f64);

impl Default for Spring {
    fn default() -> Self {
        Self(FREQUENCY * FREQUENCY)
    }
}

impl Formula for Spring {
    #[inline(always)]
    fn acceleration(self, _: f64, x: DVec3, _: DVec3) -> DVec3 {
        x * -self.0
    }

    fn jacobians(self, _: DVec3, _: DVec3) -> [DMat3; 2] {
        [DMat3::IDENTITY * -self.0, DMat3::ZERO]
    }
}

/// A [`Spring`] with linear drag c, 1/s.
#[derive(Clone, Copy)]
struct DampedSpring(Spring, f64);

impl Default for DampedSpring {
    fn default() -> Self {
        Self(Spring::default(), DECAY)
    }
}

impl Formula for DampedSpring {
    const DEPENDS_ON_VELOCITY: bool = true;

    #[inline(always)]
    fn acceleration(self, t: f64, x: DVec3, v: DVec3) -> DVec3 {
        self.0.acceleration(t, x, v) - v * self.1
    }

    fn jacobians(self, x: DVec3, v: DVec3) -> [DMat3; 2] {
        let [by_x, _] = self.0.jacobians(x, v);
        [by_x, DMat3::IDENTITY * -self.1]
    }
}

/// Attraction to the origin with mu, m³/s², and the square of the softening length, m².
#[derive(Clone, Copy)]
struct Orbit(f64, f64);

impl Default for Orbit {
    fn default() -> Self {
        Self(1.0, 0.0)
    }
}

impl Orbit {
    #[inline(always)]
    fn inverse(self, x: DVec3) -> f64 {
        (x.dot(x) + self.1).sqrt().recip()
    }
}

impl Formula for Orbit {
    #[inline(always)]
    fn acceleration(self, _: f64, x: DVec3, _: DVec3) -> DVec3 {
        let inverse = self.inverse(x);
        x * -(self.0 * inverse * inverse * inverse)
    }

    fn jacobians(self, x: DVec3, _: DVec3) -> [DMat3; 2] {
        let inverse = self.inverse(x);
        let cubed = self.0 * inverse * inverse * inverse;
        let tidal = outer(x, x) * (3.0 * cubed * inverse * inverse);
        [tidal - DMat3::IDENTITY * cubed, DMat3::ZERO]
    }
}

/// Uniform gravity, m/s², and a spring to the origin with stiffness per mass, 1/s², and rest length, m.
#[derive(Clone, Copy)]
struct Pendulum(DVec3, f64, f64);

impl Default for Pendulum {
    fn default() -> Self {
        Self(DVec3::NEG_Y * 9.81, 100.0, 1.0)
    }
}

impl Formula for Pendulum {
    #[inline(always)]
    fn acceleration(self, _: f64, x: DVec3, _: DVec3) -> DVec3 {
        let stretch = 1.0 - self.2 * x.dot(x).sqrt().recip();
        self.0 - x * (self.1 * stretch)
    }

    fn jacobians(self, x: DVec3, _: DVec3) -> [DMat3; 2] {
        let inverse = 1.0 / x.dot(x).sqrt();
        let n = x * inverse;
        let along = outer(n, n);
        let across = (DMat3::IDENTITY - along) * (1.0 - self.2 * inverse);
        [(along + across) * -self.1, DMat3::ZERO]
    }
}

/// Uniform gravity, m/s², and quadratic drag k, 1/m.
#[derive(Clone, Copy)]
struct QuadraticDrag(DVec3, f64);

impl Default for QuadraticDrag {
    fn default() -> Self {
        Self(DVec3::NEG_Y * FALL, QUADRATIC_DRAG)
    }
}

impl Formula for QuadraticDrag {
    const DEPENDS_ON_VELOCITY: bool = true;

    #[inline(always)]
    fn acceleration(self, _: f64, _: DVec3, v: DVec3) -> DVec3 {
        self.0 + v * -(self.1 * v.dot(v).sqrt())
    }

    fn jacobians(self, _: DVec3, v: DVec3) -> [DMat3; 2] {
        let speed = v.length();
        let along = outer(v, v) * (1.0 / speed.max(f64::MIN_POSITIVE));
        [DMat3::ZERO, (DMat3::IDENTITY * speed + along) * -self.1]
    }
}

/// Attraction to several wells: their positions, m, mu of each, m³/s², and the square of the softening length, m².
#[derive(Clone, Copy)]
struct Cluster([DVec3; 5], f64, f64);

impl Default for Cluster {
    fn default() -> Self {
        Self(WELLS, 1.0, 0.01)
    }
}

impl Formula for Cluster {
    #[inline(always)]
    fn acceleration(self, t: f64, x: DVec3, v: DVec3) -> DVec3 {
        let orbit = Orbit(self.1, self.2);
        let mut sum = DVec3::ZERO;
        for well in self.0 {
            sum += orbit.acceleration(t, x - well, v);
        }
        sum
    }

    fn jacobians(self, x: DVec3, _: DVec3) -> [DMat3; 2] {
        let of_well = |well: DVec3| Orbit(self.1, self.2).jacobians(x - well, DVec3::ZERO)[0];
        [self.0.map(of_well).into_iter().fold(DMat3::ZERO, |sum, by_x| sum + by_x), DMat3::ZERO]
    }
}

/// A force that grows linearly: force per mass at the start, m/s², and its rate, m/s³.
#[derive(Clone, Copy)]
struct Engine(DVec3, DVec3);

impl Default for Engine {
    fn default() -> Self {
        Self(DVec3::new(0.0, ENGINE, 0.0), DVec3::new(ENGINE_GROWTH, 0.0, 0.0))
    }
}

impl Formula for Engine {
    #[inline(always)]
    fn acceleration(self, t: f64, _: DVec3, _: DVec3) -> DVec3 {
        self.0 + self.1 * t
    }
}

/// A soft body of four masses.
#[derive(Clone, Copy)]
struct Tetrahedron;

impl Springs<4> for Tetrahedron {
    const MASSES: [f64; 4] = [1.0, 2.0, 3.0, 4.0];
    const SPRINGS: &'static [([usize; 2], f64, f64)] = &[
        ([0, 1], 50.0, 1.0),
        ([0, 2], 50.0, 1.0),
        ([0, 3], 50.0, 1.0),
        ([1, 2], 50.0, 1.0),
        ([1, 3], 50.0, 1.0),
        ([2, 3], 50.0, 1.0),
    ];
}

/// Eccentricity of the orbit.
const ECCENTRICITY: f64 = 0.6;
/// Angular frequency of the oscillators, rad/s.
const FREQUENCY: f64 = 2.0;
/// Decay rate of the damped oscillator, 1/s: a fifth of critical.
const DECAY: f64 = 2.0 * 0.2 * FREQUENCY;
/// Gravity of the falls, m/s².
const FALL: f64 = 9.8;
/// Linear drag of the falls, 1/s.
const DRAG: f64 = 0.4;
/// Quadratic drag of the falls, 1/m.
const QUADRATIC_DRAG: f64 = 0.05;
/// Force of the engine on 1 kg, N.
const ENGINE: f64 = 10.0;
/// Growth of that force, N/s.
const ENGINE_GROWTH: f64 = 1.5;
/// Five wells around the origin, m.
const WELLS: [DVec3; 5] = [
    DVec3::new(0.0, 0.0, 0.0),
    DVec3::new(1.0, 0.5, 0.0),
    DVec3::new(-1.0, 0.0, 0.5),
    DVec3::new(0.0, -1.0, -0.5),
    DVec3::new(0.5, 1.0, 0.0),
];

/// Every problem.
pub const PROBLEMS: [Problem; 11] = [
    Problem {
        name: "free_fall",
        description: "A throw in uniform gravity, 2 s: what a constant force costs each method",
        scene: || {
            one_body(
                4.0,
                "gravity: (acceleration_m_s2: (0, -9.8, 0)),",
                "velocity_m_s: (3, 10, 0)",
                "",
            )
        },
        ticks: 8,
        law: None,
        exact: Some((free_fall, "Galilei 1638: x = x0 + v0 t + g t² / 2")),
        period: None,
        ladder: (1, 256),
        in_loop: Some(arithmetic::run::<Fall>),
    },
    Problem {
        name: "terminal_fall",
        description: "A fall against linear drag towards its terminal speed, 8 s",
        scene: || {
            let laws = "gravity: (acceleration_m_s2: (0, -9.8, 0)), drag: (linear_per_s: 0.4),";
            one_body(1.0, laws, "velocity_m_s: (3, 10, 0)", "")
        },
        ticks: 8,
        law: None,
        exact: Some((terminal_fall, "v = v_t + (v0 - v_t) e^(-c t)")),
        period: None,
        ladder: (1, 1024),
        in_loop: Some(arithmetic::run::<TerminalFall>),
    },
    Problem {
        name: "quadratic_drag",
        description: "A fall against quadratic drag towards its terminal speed, 8 s",
        scene: || {
            let laws = "gravity: (acceleration_m_s2: (0, -9.8, 0)), drag: (quadratic_per_m: 0.05),";
            one_body(1.0, laws, "position_m: (0, 0, 0)", "")
        },
        ticks: 8,
        law: None,
        exact: Some((quadratic_drag, "v = v_t tanh(t / tau), tau = v_t / g")),
        period: None,
        ladder: (1, 1024),
        in_loop: Some(arithmetic::run::<QuadraticDrag>),
    },
    Problem {
        name: "engine",
        description: "An engine whose force grows, 8 s",
        scene: || {
            let thrusts = format!(
                "thrusts: [(body: \"body\", curve: polynomial([(0, {ENGINE:?}, 0), ({ENGINE_GROWTH:?}, 0, 0)]))],"
            );
            one_body(1.0, &thrusts, "velocity_m_s: (3, 0, 0)", "")
        },
        ticks: 8,
        law: None,
        exact: Some((engine, "x = x0 + v0 t + a t² / 2 + b t³ / 6")),
        period: None,
        ladder: (1, 256),
        in_loop: Some(arithmetic::run::<Engine>),
    },
    Problem {
        name: "harmonic_oscillator",
        description: "A mass on an ideal spring, 5 periods",
        scene: || oscillator_scene(5),
        ticks: 8,
        law: None,
        exact: Some((oscillator, "x = x0 cos w t + v0 / w sin w t")),
        period: Some(TAU / FREQUENCY),
        ladder: (4, 4096),
        in_loop: Some(arithmetic::run::<Spring>),
    },
    Problem {
        name: "damped_oscillator",
        description: "A mass on an ideal spring with a fifth of the critical damping, 2 periods",
        scene: || {
            let start = "position_m: (1, 0, 0), velocity_m_s: (0.5, 0, 0)";
            one_body(
                4.0 * FREQUENCY / TAU,
                &format!("drag: (linear_per_s: {DECAY:?}),"),
                start,
                SPRING,
            )
        },
        ticks: 8,
        law: None,
        exact: Some((damped_oscillator, "x'' = -w² x - c x', underdamped")),
        period: Some(TAU / FREQUENCY),
        ladder: (1, 1024),
        in_loop: Some(arithmetic::run::<DampedSpring>),
    },
    Problem {
        name: "kepler",
        description: "An orbit of eccentricity 0.6, 5 times around",
        scene: || {
            let start = format!(
                "position_m: ({:?}, 0, 0), velocity_m_s: (0, {:?}, 0)",
                1.0 - ECCENTRICITY,
                ((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY)).sqrt()
            );
            one_body(8.0 / (5.0 * TAU), "wells: [(strength_m3_s2: 1)],", &start, "")
        },
        ticks: 8,
        law: None,
        exact: Some((kepler, "Kepler 1609: t = E - e sin E")),
        period: Some(TAU),
        ladder: (16, 8192),
        in_loop: Some(arithmetic::run::<Orbit>),
    },
    Problem {
        name: "five_wells",
        description: "An orbit around five wells, 20 s",
        scene: || {
            let well = |DVec3 { x, y, z }: &DVec3| {
                format!("(position_m: ({x:?}, {y:?}, {z:?}), strength_m3_s2: 1, softening_m: 0.1)")
            };
            let wells = WELLS.iter().map(well).collect::<Vec<_>>().join(", ");
            one_body(
                3.2,
                &format!("wells: [{wells}],"),
                "position_m: (4, 0, 0), velocity_m_s: (0, 1.1, 0)",
                "",
            )
        },
        ticks: 64,
        law: None,
        exact: None,
        period: None,
        ladder: (1, 256),
        in_loop: Some(arithmetic::run::<Cluster>),
    },
    Problem {
        name: "duffing",
        description: "A spring that hardens, x'' = -x - 2 x³, 8 s",
        scene: || one_body(1.0, "", "position_m: (1, 0, 0)", ""),
        ticks: 8,
        law: Some(Duffing),
        exact: Some((duffing, "Duffing 1918: x = cn(sqrt(3) t | 1/3)")),
        period: None,
        ladder: (4, 4096),
        in_loop: Some(arithmetic::run::<Duffing>),
    },
    Problem {
        name: "elastic_pendulum",
        description: "A mass that swings on a spring, chaotic in the long run, 5 s",
        scene: || {
            let start = "position_m: (0.6, -1, 0)";
            let spring = "springs: [(between: (\"anchor\", \"body\"), stiffness_n_m: 100, rest_length_m: 1)],";
            one_body(12.8, "gravity: (acceleration_m_s2: (0, -9.81, 0)),", start, spring)
        },
        ticks: 64,
        law: None,
        exact: None,
        period: None,
        ladder: (1, 256),
        in_loop: Some(arithmetic::run::<Pendulum>),
    },
    Problem {
        name: "tetrahedron",
        description: "A soft body of four masses and six springs, thrown, 2 s",
        scene: || TETRAHEDRON.to_owned(),
        ticks: 32,
        law: None,
        exact: None,
        period: None,
        ladder: (1, 256),
        in_loop: Some(arithmetic::run_groups::<Tetrahedron, 4>),
    },
];

const SPRING: &str =
    "springs: [(between: (\"anchor\", \"body\"), stiffness_n_m: 4, rest_length_m: 0)],";

const TETRAHEDRON: &str = "(version: 1, step_hz: 16, bodies: [
        (name: \"a\", mass_kg: 1, velocity_m_s: (0.5, 0, 0)), (name: \"b\", mass_kg: 2, position_m: (1.25, 0, 0)),
        (name: \"c\", mass_kg: 3, position_m: (0, 1.25, 0)), (name: \"d\", mass_kg: 4, position_m: (0, 0, 1.25))],
      springs: [
        (between: (\"a\", \"b\"), stiffness_n_m: 50, rest_length_m: 1), (between: (\"a\", \"c\"), stiffness_n_m: 50, rest_length_m: 1),
        (between: (\"a\", \"d\"), stiffness_n_m: 50, rest_length_m: 1), (between: (\"b\", \"c\"), stiffness_n_m: 50, rest_length_m: 1),
        (between: (\"b\", \"d\"), stiffness_n_m: 50, rest_length_m: 1), (between: (\"c\", \"d\"), stiffness_n_m: 50, rest_length_m: 1)])";

/// The problem of that name.
pub fn problem(name: &str) -> Option<&'static Problem> {
    PROBLEMS.iter().find(|problem| problem.name == name)
}

/// A scene with one body of 1 kg and, if it has springs, an anchor at the origin.
fn one_body(step_hz: f64, laws: &str, start: &str, springs: &str) -> String {
    let anchor = if springs.is_empty() { "" } else { "(name: \"anchor\", immovable: true)," };
    format!(
        "(version: 1, step_hz: {step_hz:?}, {laws} bodies: [{anchor} (name: \"body\", {start})], {springs})"
    )
}

fn free_fall(t: f64) -> Vec<State> {
    let (v0, g) = (DVec3::new(3.0, 10.0, 0.0), DVec3::NEG_Y * FALL);
    vec![(v0 * t + g * (t * t / 2.0), v0 + g * t)]
}

fn terminal_fall(t: f64) -> Vec<State> {
    let (v0, end) = (DVec3::new(3.0, 10.0, 0.0), DVec3::NEG_Y * (FALL / DRAG));
    let left = v0 - end;
    vec![(end * t - left * ((-DRAG * t).exp_m1() / DRAG), end + left * (-DRAG * t).exp())]
}

fn quadratic_drag(t: f64) -> Vec<State> {
    let terminal = (FALL / QUADRATIC_DRAG).sqrt();
    let tau = terminal / FALL;
    let (x, v) = (-terminal * tau * (t / tau).cosh().ln(), -terminal * (t / tau).tanh());
    vec![(DVec3::Y * x, DVec3::Y * v)]
}

fn engine(t: f64) -> Vec<State> {
    let (v0, a, b) = (DVec3::X * 3.0, DVec3::Y * ENGINE, DVec3::X * ENGINE_GROWTH);
    vec![(v0 * t + a * (t * t / 2.0) + b * (t * t * t / 6.0), v0 + a * t + b * (t * t / 2.0))]
}

fn oscillator(t: f64) -> Vec<State> {
    let (sin, cos) = (FREQUENCY * t).sin_cos();
    vec![(DVec3::X * (cos + 0.5 / FREQUENCY * sin), DVec3::X * (0.5 * cos - FREQUENCY * sin))]
}

fn damped_oscillator(t: f64) -> Vec<State> {
    let half = DECAY / 2.0;
    let w = (FREQUENCY * FREQUENCY - half * half).sqrt();
    let (a, b) = (1.0, (0.5 + half) / w);
    let ((sin, cos), decay) = ((w * t).sin_cos(), (-half * t).exp());
    let x = decay * (a * cos + b * sin);
    vec![(DVec3::X * x, DVec3::X * (decay * w * (b * cos - a * sin) - half * x))]
}

fn kepler(t: f64) -> Vec<State> {
    let e = ECCENTRICITY;
    let (sin, cos) = eccentric_anomaly(t, e).sin_cos();
    let (minor, rate) = ((1.0 - e * e).sqrt(), 1.0 / (1.0 - e * cos));
    vec![(DVec3::new(cos - e, minor * sin, 0.0), DVec3::new(-sin * rate, minor * cos * rate, 0.0))]
}

fn duffing(t: f64) -> Vec<State> {
    let w = 3.0_f64.sqrt();
    let (sn, cn, dn) = jacobi(w * t, 1.0 / 3.0);
    vec![(DVec3::X * cn, DVec3::X * (-w * sn * dn))]
}

/// The oscillator over `periods` whole periods, at least 1.
pub(crate) fn oscillator_scene(periods: u32) -> String {
    let step_hz = 8.0 / f64::from(periods) * FREQUENCY / TAU;
    one_body(step_hz, "", "position_m: (1, 0, 0), velocity_m_s: (0.5, 0, 0)", SPRING)
}
