//! Nets of bodies and springs: built, run, looked at, and integrated once more by plain formulas.

use glam::DVec3;
use motion::{Elastic, Link, Method, QuarantineRecord, SoftBody, StableId};

use crate::rigs::{Dice, Environment, Lab, Start};

/// The tick of most of these tests, s.
pub const H: f64 = 1.0 / 60.0;

/// Position and velocity.
pub type State = (DVec3, DVec3);

pub const fn elastic(stiffness: f64, rest_length: f64) -> Elastic {
    Elastic::new(stiffness, rest_length)
}

/// Bodies and the springs between them.
#[derive(Clone, Debug, Default)]
pub struct Net {
    pub bodies: Vec<Start>,
    pub springs: Vec<([usize; 2], Elastic)>,
}

impl Net {
    /// Bodies that nothing joins.
    pub fn free(bodies: impl Into<Vec<Start>>) -> Self {
        Self { bodies: bodies.into(), springs: Vec::new() }
    }

    /// Two bodies on a spring.
    pub fn pair(a: Start, b: Start, spring: Elastic) -> Self {
        Self { bodies: vec![a, b], springs: vec![([0, 1], spring)] }
    }

    /// In a world of its own.
    pub fn lab(&self, around: &Environment, method: Method, h: f64) -> Lab {
        let mut lab = around.lab(method, h);
        for (id, start) in (0..).map(StableId).zip(&self.bodies) {
            lab.bodies.push(lab.world.spawn((id, start.components())).id());
        }
        for (ends, elastic) in &self.springs {
            lab.spring(*ends, *elastic);
        }
        lab.recompile();
        lab
    }

    /// The same as one soft body.
    pub fn soft(
        &self,
        triangles: &[[u32; 3]],
        around: &Environment,
        method: Method,
        h: f64,
    ) -> Lab {
        let mut lab = Self::free(&self.bodies[..]).lab(around, method, h);
        let link = |(ends, elastic): &([usize; 2], Elastic)| Link {
            ends: ends.map(|end| u32::try_from(end).unwrap()),
            elastic: *elastic,
        };
        let (points, springs) = (lab.bodies.clone(), self.springs.iter().map(link).collect());
        lab.soft(SoftBody {
            points,
            springs,
            triangles: triangles.to_vec(),
            sheet: !triangles.is_empty(),
        });
        lab
    }

    /// Adds another net; gives the number of its first body.
    pub fn and(&mut self, other: &Self) -> usize {
        let first = self.bodies.len();
        self.bodies.extend(&other.bodies);
        self.springs.extend(
            other.springs.iter().map(|(ends, elastic)| (ends.map(|end| end + first), *elastic)),
        );
        first
    }

    pub fn moved(mut self, by: DVec3) -> Self {
        self.bodies.iter_mut().for_each(|body| body.x += by);
        self
    }

    /// Forces of the springs by the formula, N.
    pub fn forces(&self, state: &[State]) -> Vec<DVec3> {
        let mut forces = vec![DVec3::ZERO; self.bodies.len()];
        for ([a, b], Elastic { stiffness, damping, rest_length, .. }) in &self.springs {
            let ((xa, va), (xb, vb)) = (state[*a], state[*b]);
            let length = xa.distance(xb);
            let n = (xb - xa) / length;
            let force = n * (stiffness * (length - rest_length) + damping * n.dot(vb - va));
            forces[*a] += force;
            forces[*b] -= force;
        }
        forces
    }

    /// The states at the start.
    pub fn start(&self) -> Vec<State> {
        self.bodies.iter().map(|body| (body.x, body.v)).collect()
    }
}

impl Lab {
    pub fn soft(&mut self, soft: SoftBody) {
        self.world.spawn(soft);
        self.recompile();
    }

    /// Fails unless all bodies but some continue tick by tick with the bits of those of `twin`.
    #[track_caller]
    pub fn agrees(&mut self, twin: &mut Self, ticks: u64, but: &[usize], what: &str) {
        for tick in 0..ticks {
            assert_eq!(self.run(1).all_bits(but), twin.run(1).all_bits(but), "{what}, tick {tick}");
        }
    }

    /// Numbers of the bodies that were quarantined, in the order of events.
    pub fn quarantined(&self) -> Vec<usize> {
        let number =
            |record: &QuarantineRecord| self.bodies.iter().position(|body| *body == record.body);
        self.records().iter().map(|record| number(record).unwrap()).collect()
    }
}

/// S13: 1 kg on an elastic string from the origin.
pub fn pendulum(stiffness: f64) -> Net {
    let weight = Start::of(1.0, DVec3::new(0.6, -1.0, 0.0), DVec3::ZERO);
    Net::pair(Start::held(DVec3::ZERO), weight, elastic(stiffness, 1.0))
}

/// S15: 1 to 4 kg, joined two by two, the first one moving.
pub fn tetrahedron() -> Net {
    let corners = [DVec3::ZERO, DVec3::X * 1.25, DVec3::Y * 1.25, DVec3::Z * 1.25];
    let speed = |i: usize| if i == 0 { DVec3::X * 0.5 } else { DVec3::ZERO };
    let body = |i: usize| Start::of((i + 1) as f64, corners[i], speed(i));
    let pairs = (0..4).flat_map(|a| (a + 1..4).map(move |b| [a, b]));
    Net {
        bodies: (0..4).map(body).collect(),
        springs: pairs.map(|ends| (ends, elastic(50.0, 1.0))).collect(),
    }
}

/// A ring of 8 bodies of random masses, moving at random.
pub fn ring() -> Net {
    let mut dice = Dice(8);
    let body = |i: usize| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / 8.0).sin_cos();
        Start::of(
            1.0 + 0.9 * dice.number(),
            DVec3::new(cos, sin, 0.1 * dice.number()),
            dice.vector() * 0.3,
        )
    };
    let bodies = (0..8).map(body).collect();
    Net { bodies, springs: (0..8).map(|i| ([i, (i + 1) % 8], elastic(40.0, 0.7))).collect() }
}

/// A chain that hangs from the origin in `links` of `length`, of bodies of `mass`.
pub fn chain(links: usize, stiffness: f64, length: f64, mass: f64) -> Net {
    let body = |i: usize| Start::of(mass, DVec3::Y * -(length * i as f64), DVec3::ZERO);
    Net {
        bodies: std::iter::once(Start::held(DVec3::ZERO)).chain((1..=links).map(body)).collect(),
        springs: (0..links).map(|i| ([i, i + 1], elastic(stiffness, length))).collect(),
    }
}

/// The states at the ends of the `samples` parts of `span`, by the classic method of four stages and
/// Richardson's extrapolation; `accelerations` are of the bodies of `start`.
pub fn extrapolated(
    start: &[State],
    span: f64,
    samples: usize,
    steps: usize,
    accelerations: impl Fn(f64, &[State]) -> Vec<DVec3>,
) -> Vec<Vec<State>> {
    let run = |steps: usize| {
        let h = span / steps as f64;
        let mut state = start.to_vec();
        let mut taken = Vec::new();
        for step in 0..steps {
            let t = h * step as f64;
            let slopes = |part: f64, state: &[State]| -> Vec<State> {
                let a = accelerations(t + part * h, state);
                state.iter().zip(a).map(|((_, v), a)| (*v, a)).collect()
            };
            let after = |slopes: &[State], part: f64| -> Vec<State> {
                let rows = state.iter().zip(slopes);
                rows.map(|((x, v), (dx, dv))| (*x + *dx * (part * h), *v + *dv * (part * h)))
                    .collect()
            };
            let a = slopes(0.0, &state);
            let b = slopes(0.5, &after(&a, 0.5));
            let c = slopes(0.5, &after(&b, 0.5));
            let d = slopes(1.0, &after(&c, 1.0));
            for (i, (x, v)) in state.iter_mut().enumerate() {
                *x += (a[i].0 + (b[i].0 + c[i].0) * 2.0 + d[i].0) * (h / 6.0);
                *v += (a[i].1 + (b[i].1 + c[i].1) * 2.0 + d[i].1) * (h / 6.0);
            }
            if (step + 1) % (steps / samples) == 0 {
                taken.push(state.clone());
            }
        }
        taken
    };
    let (coarse, mut fine) = (run(steps / 2), run(steps));
    for (fine, coarse) in fine.iter_mut().flatten().zip(coarse.iter().flatten()) {
        fine.0 += (fine.0 - coarse.0) / 15.0;
        fine.1 += (fine.1 - coarse.1) / 15.0;
    }
    fine
}
