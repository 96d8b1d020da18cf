//! The references that studies make themselves, against a solver of another make: DOP853 of Hairer, Nørsett and
//! Wanner as the crate `differential-equations` has it, with forces by plain formulas.

use differential_equations::prelude::*;
use glam::DVec3;
use lab::cost::{Bench, Sample, Subject, Truth, problem};
use motion::effects::Effect;
use motion::{Elastic, Method};
use scene::Scene;

use super::{plain, studied};
use crate::rigs::scene_of;

/// A scene of springs, uniform and mutual gravity, and damping, as a system of first order: positions, then
/// velocities, of all bodies.
pub(crate) struct System {
    masses: Vec<Option<f64>>,
    sources: Vec<f64>,
    springs: Vec<([usize; 2], Elastic)>,
    gravity: DVec3,
    attraction: f64,
    damping: f64,
}

impl System {
    pub fn of(scene: &Scene) -> Self {
        let has = |effect| !scene.off_at_start.contains(&effect);
        assert!(scene.laws.wells.is_none() && scene.own_laws.is_empty(), "this system has none");
        assert!(scene.laws.drag.is_none() || !has(Effect::Drag), "this system has none");
        let single = scene
            .springs
            .iter()
            .map(|spring| (spring.ends.map(|end| end as usize), spring.elastic));
        let links = scene.soft_bodies.iter().flat_map(|soft| {
            soft.links
                .iter()
                .map(|link| (link.ends.map(|end| (soft.points.start + end) as usize), link.elastic))
        });
        let mass = |body: &scene::BodySpec| body.inverse_mass.filter(|w| *w > 0.0).map(|w| 1.0 / w);
        Self {
            masses: scene.bodies.iter().map(mass).collect(),
            sources: scene
                .bodies
                .iter()
                .map(|body| mass(body).or(body.source_mass).unwrap_or(0.0))
                .collect(),
            springs: single.chain(links).collect(),
            gravity: scene.gravity.map_or(DVec3::ZERO, |gravity| gravity.acceleration),
            attraction: scene.mutual_gravity.map_or(0.0, |law| law.constant),
            damping: scene.damping.map_or(0.0, |damping| damping.rate),
        }
    }

    fn accelerations(&self, x: &[DVec3], v: &[DVec3]) -> Vec<DVec3> {
        let mut forces = vec![DVec3::ZERO; x.len()];
        for ([a, b], Elastic { stiffness, damping, rest_length, pull_only, .. }) in &self.springs {
            let (along, length) = ((x[*b] - x[*a]).normalize_or_zero(), x[*a].distance(x[*b]));
            let pull = stiffness * (length - rest_length) + damping * (v[*b] - v[*a]).dot(along);
            let is_slack = *pull_only && (length <= *rest_length || pull <= 0.0);
            let pull = if is_slack { DVec3::ZERO } else { along * pull };
            forces[*a] += pull;
            forces[*b] -= pull;
        }
        if self.attraction != 0.0 {
            for a in 0..x.len() {
                for b in (0..x.len()).filter(|b| *b != a) {
                    let r = x[b] - x[a];
                    forces[a] += r
                        * (self.attraction * self.sources[a] * self.sources[b]
                            / r.length().powi(3));
                }
            }
        }
        let each = forces.iter().zip(&self.masses).zip(v);
        each.map(|((force, mass), v)| match mass {
            Some(mass) => *force / *mass + self.gravity - *v * self.damping,
            None => DVec3::ZERO,
        })
        .collect()
    }
}

pub(crate) fn vectors(numbers: &[f64]) -> Vec<DVec3> {
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

impl ODE<f64, Vec<f64>> for System {
    fn diff(&self, _: f64, y: &Vec<f64>, dydt: &mut Vec<f64>) {
        let (x, v) = y.split_at(y.len() / 2);
        let a = self.accelerations(&vectors(x), &vectors(v));
        dydt[..v.len()].copy_from_slice(v);
        let numbers = a.iter().flat_map(DVec3::to_array);
        dydt[v.len()..].iter_mut().zip(numbers).for_each(|(to, from)| *to = from);
    }
}

/// The state of `system` at the time `to`, from the state `y` at the time `from`, s: its positions, then its velocities.
pub(crate) fn advance(system: &System, from: f64, to: f64, y: Vec<f64>) -> Vec<f64> {
    let solver = ExplicitRungeKutta::dop853().rtol(1e-13).atol(1e-14).max_steps(10_000_000);
    let solution = IVP::ode(system, from, to, y).method(solver).solve().unwrap();
    solution.y.last().unwrap().clone()
}

/// Positions and velocities, one after the other.
pub(crate) fn flat(states: &[(DVec3, DVec3)]) -> Vec<f64> {
    let part = |of: fn(&(DVec3, DVec3)) -> DVec3| {
        states.iter().flat_map(move |state| of(state).to_array())
    };
    part(|state| state.0).chain(part(|state| state.1)).collect()
}

/// Parts of a run at whose ends its reference is compared.
const PARTS: u64 = 8;

/// Times, and the states of the reference of a study of the bodies that can move.
fn truth(bench: &Bench) -> Vec<(f64, Vec<Sample>)> {
    let (study, scene) = (bench.study(), bench.subject().scene());
    let mut run = bench.reference().unwrap();
    let movable = |id: &u32| scene.bodies[*id as usize].is_movable();
    let mut after = |tick| {
        run.tick();
        let states = run.states().into_iter().filter(|(id, ..)| movable(id)).collect();
        (tick as f64 / study.step_hz, states)
    };
    // The last of each part.
    let looked = |tick: u64| tick * PARTS / study.ticks > (tick - 1) * PARTS / study.ticks;
    (1..=study.ticks)
        .map(|tick| (looked(tick), after(tick)))
        .filter(|(looked, _)| *looked)
        .map(|(_, at)| at)
        .collect()
}

/// Compares the reference of a study with DOP853 at times evenly spread over the run, relative to the scales of the study.
fn check(subject: Subject, scene: &Scene, bound: f64) {
    let plan = plain(&[Method::VelocityVerlet], [16, 64]);
    let bench = studied(subject, plan);
    let study = bench.study();
    let Truth::Reference { relative_error: own, .. } = study.truth else {
        panic!("it has a closed form")
    };
    let start: Vec<_> = scene.bodies.iter().map(|body| (body.position, body.velocity)).collect();
    let system = System::of(scene);
    let truth = truth(&bench);
    assert!(truth.len() as u64 >= PARTS.min(study.ticks), "{}", truth.len());
    let (mut from, mut y) = (0.0, flat(&start));
    for (time, sample) in &truth {
        // From one to the next: between its steps it only interpolates.
        (from, y) = (*time, advance(&system, from, *time, y));
        let (x, v) = y.split_at(y.len() / 2);
        let (x, v) = (vectors(x), vectors(v));
        for (id, ours, speed) in sample {
            let dx = ours.distance(x[*id as usize]) / study.position_scale_m;
            let dv = speed.distance(v[*id as usize]) / study.velocity_scale_m_s;
            // What the study says of itself holds, beside what the other solver leaves open.
            assert!(
                dx.hypot(dv) < bound + 2.0 * own,
                "{} at {time} s: {dx:e} {dv:e}, own {own:e}",
                study.subject
            );
        }
    }
    assert!(own < bound, "{}: {own:e}", study.subject);
}

#[test]
fn references_of_problems_agree_with_dop853() {
    for name in ["elastic_pendulum", "tetrahedron"] {
        let subject = Subject::of_problem(problem(name).unwrap()).unwrap();
        let scene = subject.scene().clone();
        check(subject, &scene, 1e-8);
    }
}

#[test]
fn references_of_scenes_agree_with_dop853() {
    let rows: [(&str, f64, &[Effect]); 4] = [
        ("figure_eight", 4.0, &[]),
        ("tutorial", 2.0, &[]),
        ("rope", 0.5, &[]),
        ("flag", 0.2, &[Effect::Drag, Effect::Wind]),
    ];
    for (name, seconds, without) in rows {
        let mut scene = scene::load(name).unwrap();
        scene.off_at_start = without.to_vec();
        check(Subject::of_scene(scene.clone(), Some(seconds)), &scene, 1e-8);
    }
}

/// What `recommend` promises of particles holds.
#[test]
fn references_of_particles_agree_with_the_closed_form() {
    let text = "(version: 1, step_hz: 30, gravity: (), drag: (linear_per_s: 1.5), emitters: [(rate_per_s: 31, life_s: 0.8,
        speed_m_s: 15, spread_deg: 20, position_m: (1, 2, 3))])";
    let scene = scene_of(text);
    let (fountain, g, c) = (scene.emitters[0].clone(), scene.gravity.unwrap().acceleration, 1.5);
    let bench =
        studied(Subject::of_scene(scene, Some(2.0)), plain(&[Method::RungeKutta4], [1, 4, 16]));
    let study = bench.study();
    let Truth::Reference { position_error_m: own, .. } = study.truth else {
        panic!("it has a closed form")
    };
    assert!(own < 1e-9, "{own:e}");
    let mut seen = 0;
    for (now, sample) in truth(&bench) {
        for (slot, (_, x, _)) in sample.iter().enumerate() {
            // The last of the numbers of this slot that was born before now.
            let numbers = (slot..).step_by(fountain.pool.len()).map(|number| number as f64 / 31.0);
            let born = numbers.take_while(|born| *born < now - 1e-9).last();
            let age = born.map_or(f64::INFINITY, |born| now - born);
            let flies = age < 0.8 - 1e-9;
            let moved =
                g * (age / c) - (fountain.launches[slot] - g / c) * ((-c * age).exp_m1() / c);
            let exact = fountain.position + if flies { moved } else { DVec3::ZERO };
            assert!(x.distance(exact) < 1e-8, "{slot} at {now} s: {x}, not {exact}");
            seen += usize::from(flies);
        }
    }
    assert!(seen > 100, "{seen}");
}
