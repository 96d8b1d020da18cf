//! S16: paths that are chosen beforehand, under every mix of what acts on coupled bodies.

use glam::DVec3;
use motion::{BodyState, Drag, Law, OwnLaws, Thrust};

use super::orders::Problem;
use crate::rigs::{self, Environment, Formula, Net, Start, State, elastic};

/// Where the fourth body is held.
const POST: DVec3 = DVec3::new(6.0, 1.0, 1.0);

const DRAG: Drag = Drag::new(0.4, 0.05);

fn engine(body: usize) -> Thrust {
    rigs::engine([DVec3::new(1.0, -0.5, 0.2) * (1.0 + body as f64), DVec3::new(0.3, 0.8, -1.0)])
}

/// Position, velocity and acceleration of a body.
fn path(body: usize, t: f64) -> [DVec3; 3] {
    let shift = body as f64;
    let (sin, cos) = (t + shift).sin_cos();
    let (sin2, cos2) = (2.0 * t + shift).sin_cos();
    let decay = (-t).exp();
    let place = DVec3::new(2.0 * shift, 0.5 * shift * shift, -shift);
    [
        place + DVec3::new(sin, cos2, decay) * 0.5,
        DVec3::new(cos, -2.0 * sin2, -decay) * 0.5,
        DVec3::new(-sin, -4.0 * cos2, decay) * 0.5,
    ]
}

/// Three bodies and a post, every two of them joined.
fn net(everything: bool) -> Net {
    let damping = if everything { 1.5 } else { 0.0 };
    let start = |body: usize| {
        let [x, v, _] = path(body, 0.0);
        if body == 3 { Start::held(POST) } else { Start::of(1.0 + body as f64, x, v) }
    };
    let spring = |ends: [usize; 2]| {
        let (k, l) = (10.0 + 7.0 * ends[1] as f64, 0.8 + 0.3 * ends[0] as f64);
        (ends, motion::Elastic { damping, ..elastic(k, l) })
    };
    let pairs = (0..4).flat_map(|a| (a + 1..4).map(move |b| [a, b]));
    Net { bodies: (0..4).map(start).collect(), springs: pairs.map(spring).collect() }
}

fn states(t: f64) -> Vec<State> {
    let of = |body: usize| match path(body, t) {
        _ if body == 3 => (POST, DVec3::ZERO),
        [x, v, _] => (x, v),
    };
    (0..4).map(of).collect()
}

/// Drives a body along its path, against everything else that acts.
fn driven(number: usize, everything: bool) -> Box<Formula> {
    let net = net(everything);
    Box::new(Formula::new("driven", move |at, body| {
        let [position, velocity, a] = path(number, at.time);
        let on_path = BodyState { position, velocity, inverse_mass: body.inverse_mass };
        let springs = net.forces(&states(at.time))[number];
        let more = if everything {
            DRAG.acceleration(at, on_path) + engine(number).acceleration(at, on_path)
        } else {
            DVec3::ZERO
        };
        a - springs * body.inverse_mass - more - motion::Gravity::EARTH.acceleration
    }))
}

pub fn manufactured(everything: bool) -> Problem {
    let name = if everything { "made, everything" } else { "made, springs" };
    let problem = Problem::new(name, 2.0, net(everything), states);
    let drag = everything.then_some(DRAG);
    let own: fn(usize) -> Option<OwnLaws> = if everything {
        |body| {
            let laws: [Box<dyn Law>; 2] = [Box::new(engine(body)), driven(body, true)];
            (body < 3).then(|| OwnLaws::new(laws.into()))
        }
    } else {
        |body| (body < 3).then(|| OwnLaws::new(vec![driven(body, false)]))
    };
    Problem {
        around: Environment { drag, ..Environment::falling() },
        own,
        velocity_laws: everything,
        ..problem
    }
}

#[test]
fn paths_that_are_chosen_under_springs_and_gravity() {
    manufactured(false).check_all();
}

#[test]
fn paths_that_are_chosen_under_springs_with_damping_drag_gravity_and_engines() {
    manufactured(true).check_all();
}
