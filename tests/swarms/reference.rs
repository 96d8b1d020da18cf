//! The same steps on plain arrays in single precision: each step of the device within the errors that WGSL allows, and a thousand
//! steps within what these come to.
//!
//! WGSL lets a device fuse or reorder nothing but a multiplication and the addition after it, and allows errors of 2.5 units in the
//! last place (ulp) for a division, 2 for an inverse square root and those of `1 / inverseSqrt` for a root. [`U`] is half a ulp of
//! a number of size 1: the error of one rounding. Of two evaluations of an expression, each rounding of either counts.

use cockpit::view::on_device::swarms;
use glam::Vec3;
use motion::Method;
use swarm::{SwarmLaws, SwarmParticle, SwarmTick};

use super::{Device, scene_text, ticks};
use crate::rigs::Drive;

const U: f32 = f32::EPSILON / 2.0;

/// Roundings of a division, of an inverse square root and of a root on a device, and here.
const DIVISION: f32 = 5.0 + 1.0;
const INVERSE_ROOT: f32 = 4.0 + 2.0;
const ROOT: f32 = 4.0 + 5.0 + 1.0;

/// An acceleration, how far that of a device may be from it at the same state, and how it changes with the state.
#[derive(Clone, Copy)]
struct Near {
    value: Vec3,
    error: f32,
    /// Most change per change of position, 1/s².
    by_x: f32,
    /// Least and most change against a change of velocity, 1/s.
    by_v: [f32; 2],
}

impl Near {
    /// How far it may be off at a state that is off by `of` in position, m, and velocity, m/s.
    fn off(&self, of: [f32; 2]) -> f32 {
        self.error + self.by_x * of[0] + self.by_v[1] * of[1]
    }

    /// How far a velocity may be off that was off by `of` and is accelerated for `h` seconds: drag takes a part of it away.
    fn kicked(&self, of: [f32; 2], h: f32) -> f32 {
        let kept = self.by_v.map(|rate| (1.0 - rate * h).abs());
        of[1] * kept[0].max(kept[1]) + h * (self.error + self.by_x * of[0])
    }
}

/// The sine of crates/swarm/shaders/step.wgsl.
fn sine(angle: f32) -> f32 {
    let turns = (angle * 0.159_154_94).round_ties_even();
    let a = (angle - turns * 6.281_25) - turns * 1.935_307_2e-3;
    let pi = std::f32::consts::PI;
    let b = if a > 0.5 * pi { pi - a } else { a };
    let c = if b < -0.5 * pi { -pi - b } else { b };
    let s = c * c;
    c * (1.0
        + s * (-0.166_666_67
            + s * (8.333_331e-3
                + s * (-1.984_087_4e-4 + s * (2.752_556_2e-6 - s * 2.388_985_9e-8)))))
}

#[test]
fn the_sine_of_the_shader_is_one() {
    for i in -30_000..30_000_i16 {
        let angle = f32::from(i) * 1e-3;
        let off = (f64::from(sine(angle)) - f64::from(angle).sin()).abs();
        assert!(off < 3e-7, "{off:e} at {angle}");
    }
}

/// The acceleration at a state.
fn acceleration(tick: &SwarmTick, x: Vec3, v: Vec3, time: f32) -> Near {
    let SwarmLaws { constant, rate, drag, wind: [mean, across, up, wave], wells, .. } = &*tick.laws;
    let [mean, across, up, wave, constant] =
        [*mean, *across, *up, *wave, *constant].map(Vec3::from);
    let mut value = constant - v * *rate;
    let mut error = 4.0 * U * (constant.length() + v.length() * rate);
    let (mut by_x, mut by_v) = (0.0, [*rate; 2]);
    if let Some([linear, quadratic, turns]) = *drag {
        let phase = (tick.phase + turns * time) - x.dot(wave);
        let in_phase =
            6.0 * U * (tick.phase.abs() + (turns * time).abs() + x.length() * wave.length());
        let air = mean + across * sine(phase) + up * (0.5 * sine(phase + phase));
        // The polynomial has seven multiplications and additions of numbers up to pi / 2.
        let in_sine = 2.0 * 14.0 * U * std::f32::consts::FRAC_PI_2;
        let in_air = (across.length() + up.length()) * (in_phase + in_sine)
            + 6.0 * U * (mean.length() + across.length() + up.length());
        let u = v - air;
        let in_u = in_air + 2.0 * U * u.length();
        let a = u * (linear + quadratic * u.dot(u).sqrt());
        value -= a;
        let most = linear + 2.0 * quadratic * u.length();
        error += most * in_u + (ROOT + 12.0) * U * a.length() + 2.0 * U * value.length();
        by_x += most * wave.length() * (across.length() + up.length());
        by_v = [by_v[0] + linear, by_v[1] + most];
    }
    for [px, py, pz, strength, softening] in wells.iter() {
        let r = x - Vec3::new(*px, *py, *pz);
        let squared = r.dot(r) + softening * softening;
        let inverse = if squared == 0.0 { 0.0 } else { 1.0 / squared.max(1e-30).sqrt() };
        let a = r * (strength * inverse * inverse * inverse);
        value -= a;
        // Half of what the square is off by, three times; and what r is off by.
        let slope = 4.0 * strength.abs() * inverse * inverse * inverse;
        error += (3.0 * (INVERSE_ROOT + 4.0) + 8.0) * U * a.length()
            + slope * 2.0 * U * x.length()
            + 2.0 * U * value.length();
        by_x += slope;
    }
    Near { value, error, by_x, by_v }
}

/// A particle of the reference, and how far a device may be from its two rows, m and m or m/s.
#[derive(Clone, Copy)]
struct Reference {
    particle: SwarmParticle,
    errors: [f32; 2],
}

/// The particles after `tick`, each from what `before` has in its slot; `last` is the tick before.
fn step(
    method: Method,
    launches: &[[f32; 3]],
    [last, tick]: [Option<&SwarmTick>; 2],
    before: &[Option<Reference>],
) -> Vec<Option<Reference>> {
    let tick = tick.unwrap();
    assert_eq!((tick.substeps, tick.other_laws, tick.reversed, tick.born), (1, false, false, true));
    let slots = launches.len() as u64;
    let numbers = |[first, after]: [u64; 2], slot: u64| {
        (first..after).find(|number| number % slots == slot).map(|number| (number, number - first))
    };
    let birth =
        |tick: &SwarmTick, after: u64| (tick.first_birth + after as f32 * tick.between).max(0.0);
    (0_u64..)
        .zip(before)
        .map(|(slot, before)| {
            let standard = last.map_or(tick.step, |last| last.step);
            let (generation, x, v, h, prior, of) = match numbers(tick.births, slot) {
                Some((number, after)) => {
                    let birth = birth(tick, after).min(tick.step);
                    let in_birth = 3.0 * U * (tick.first_birth.abs() + after as f32 * tick.between);
                    let (source, carried) = (Vec3::from(tick.source), Vec3::from(tick.carried));
                    let launch = Vec3::from(launches[slot as usize]) + carried;
                    let h = tick.step - birth;
                    let of = [
                        carried.length() * in_birth + 2.0 * U * source.length(),
                        2.0 * U * launch.length(),
                    ];
                    // What the time of birth is off by moves the particle along.
                    let of = [of[0] + in_birth * launch.length(), of[1] + in_birth * 50.0];
                    (number / slots, source + carried * birth, launch, h, 0.0, of)
                }
                None => {
                    let Reference { particle, errors } = (*before)?;
                    if particle.generation * slots + slot < tick.dead {
                        return None;
                    }
                    let (x, other) = (Vec3::from(particle.position), Vec3::from(particle.other));
                    let born = last.and_then(|last| {
                        let (number, after) = numbers(last.births, slot)?;
                        (number / slots == particle.generation)
                            .then(|| birth(last, after).min(last.step))
                    });
                    let prior = standard - born.unwrap_or(0.0);
                    let (v, of) = match method {
                        Method::PositionVerlet => {
                            let v = (x - other) * (1.0 / standard);
                            // How far the difference of the rows is off was kept as their velocity.
                            (v, [errors[0], errors[1] + (2.0 * DIVISION + 4.0) * U * v.length()])
                        }
                        _ => (other, errors),
                    };
                    (particle.generation, x, v, tick.step, prior, of)
                }
            };
            let time = tick.step - h;
            let a = acceleration(tick, x, v, time);
            let h_off = (DIVISION + 4.0) * U * h;
            let (next_x, next_v, errors, other) = match method {
                Method::SemiImplicitEuler => {
                    let next_v = v + a.value * h;
                    let v_off = a.kicked(of, h)
                        + a.value.length() * (h_off + 4.0 * U * h)
                        + 2.0 * U * next_v.length();
                    let next_x = x + next_v * h;
                    (
                        next_x,
                        next_v,
                        [
                            of[0] + h * v_off + next_v.length() * h_off + 4.0 * U * next_x.length(),
                            v_off,
                        ],
                        next_v,
                    )
                }
                Method::VelocityVerlet => {
                    let next_x = x + (v + a.value * (0.5 * h)) * h;
                    let middle = (v + a.value * (0.5 * h)).length();
                    let x_off = of[0]
                        + h * (of[1] + 0.5 * h * a.off(of))
                        + middle * (h_off + 6.0 * U * h)
                        + 4.0 * U * next_x.length();
                    let predicted = v + a.value * h;
                    let predicted_off = of[1] + h * a.off(of) + 6.0 * U * predicted.length();
                    let b = acceleration(tick, next_x, predicted, time + h);
                    let next_v = v + (a.value + b.value) * (0.5 * h);
                    // The mean of both rates takes a part of it away.
                    let v_off = 0.5 * (a.kicked(of, h) + b.kicked([x_off, of[1]], h))
                        + 0.5 * h * b.by_v[1] * (predicted_off - of[1])
                        + (a.value + b.value).length() * (h_off + 6.0 * U * h)
                        + 2.0 * U * next_v.length();
                    (next_x, next_v, [x_off, v_off], next_v)
                }
                Method::PositionVerlet => {
                    let kick = 0.5 * (h + prior);
                    let next_v = v + a.value * kick;
                    let v_off = a.kicked(of, kick)
                        + a.value.length() * (h_off + 8.0 * U * kick)
                        + 2.0 * U * next_v.length();
                    let next_x = x + next_v * h;
                    let rounded = 4.0 * U * (next_x.length() + x.length());
                    let x_off = of[0] + h * v_off + next_v.length() * h_off + rounded;
                    let is_new = prior == 0.0;
                    let other = if is_new { next_x - next_v * tick.step } else { x };
                    // The next step takes its velocity from the two rows, with what they lose of it.
                    (next_x, next_v, [x_off, v_off + rounded / tick.step], other)
                }
                _ => unreachable!("no method of swarms"),
            };
            let _ = next_v;
            let particle =
                SwarmParticle { generation, position: next_x.to_array(), other: other.to_array() };
            Some(Reference { particle, errors })
        })
        .collect()
}

const KEYS: &str = "gravity: (acceleration_m_s2: (0, -3, 0)), drag: (linear_per_s: 0.5, quadratic_per_m: 0.03), \
                    wind: (velocity_m_s: (2, 0, -1), gust_m_s: 2, gust_hz: 0.7), \
                    wells: [(position_m: (4, 6, 0), strength_m3_s2: 30, softening_m: 2), (position_m: (-3, 2, 2), strength_m3_s2: -9, softening_m: 1)],";
const LAYOUTS: [&str; 3] = [
    "layout: positions,",
    "layout: velocity, method: semi_implicit_euler,",
    "layout: velocity, method: velocity_verlet,",
];

/// The largest share of what is allowed by which a row of a particle is off.
#[track_caller]
fn compare(device: &[Option<SwarmParticle>], reference: &[Option<Reference>], dead: u64) -> f32 {
    let slots = device.len() as u64;
    let mut largest = 0.0_f32;
    for (slot, (device, reference)) in (0_u64..).zip(device.iter().zip(reference)) {
        let living = device.filter(|particle| particle.generation * slots + slot >= dead);
        let (device, reference) = match (living, reference) {
            (None, None) => continue,
            (Some(device), Some(reference)) => (device, reference),
            (device, _) => panic!("slot {slot}: {device:?}"),
        };
        assert_eq!(device.generation, reference.particle.generation);
        let off = Vec3::from(device.position).distance(Vec3::from(reference.particle.position));
        assert!(
            off <= reference.errors[0],
            "slot {slot}: {off:e} m, {:e} m are allowed",
            reference.errors[0]
        );
        largest = largest.max(off / reference.errors[0]);
    }
    largest
}

#[test]
fn each_step_is_within_what_wgsl_allows() {
    let mut device = Device::new();
    for layout in LAYOUTS {
        let emitter = format!(
            "on: gpu, {layout} rate_per_s: 370, life_s: 1.5, direction: (0, 1, 0), spread_deg: 25, speed_m_s: 7"
        );
        let mut drive = Drive::text(&scene_text(KEYS, &emitter));
        let mut before = device.slots(&mut drive.session);
        let mut shares = Vec::new();
        for _ in 0..150 {
            ticks(&mut drive, 1);
            let swarm = swarms(&drive.session.stage).remove(0);
            let [last, tick] = [swarm.ticks.len().checked_sub(2), swarm.ticks.len().checked_sub(1)]
                .map(|place| place.map(|place| &swarm.ticks[place]));
            let exact = |particle: &Option<SwarmParticle>| {
                particle.map(|particle| Reference { particle, errors: [0.0; 2] })
            };
            let before_it: Vec<_> = before.iter().map(exact).collect();
            let reference =
                step(swarm.swarm.method, &swarm.swarm.launches, [last, tick], &before_it);
            // A step is short: what it may be off by is some digits of the position.
            assert!(reference.iter().flatten().all(|row| row.errors[0] < 4e-5));
            before = device.slots(&mut drive.session);
            // The allowance tells a twentieth of a g from none.
            let laws = SwarmLaws { constant: [0.0, -3.5, 0.0], ..(*tick.unwrap().laws).clone() };
            let heavier = SwarmTick { laws: laws.into(), ..tick.unwrap().clone() };
            let heavier =
                step(swarm.swarm.method, &swarm.swarm.launches, [last, Some(&heavier)], &before_it);
            assert!(heavier.iter().zip(&before).any(|(heavier, device)| {
                let (Some(Reference { particle, errors }), Some(device)) = (heavier, device) else {
                    return false;
                };
                Vec3::from(particle.position).distance(Vec3::from(device.position)) > errors[0]
            }));
            shares.push(compare(&before, &reference, tick.unwrap().dead));
        }
        assert!(shares.iter().all(|share| *share <= 1.0), "{layout}: {shares:?}");
    }
}

/// Without laws of the position: those let errors grow exponentially, and a bound of them says nothing after a thousand steps.
const STILL_AIR: &str = "gravity: (acceleration_m_s2: (0, -0.5, 0)), drag: (linear_per_s: 0.8, quadratic_per_m: 0.03), \
                         wind: (velocity_m_s: (0, 0, 0), gust_m_s: 2, gust_hz: 0.7),";

#[test]
fn a_thousand_steps_are_within_what_follows() {
    let mut device = Device::new();
    for layout in LAYOUTS {
        let emitter = format!(
            "on: gpu, {layout} rate_per_s: 370, life_s: 17, capacity: 300, direction: (0, 1, 0), spread_deg: 25, speed_m_s: 7"
        );
        // All are born within a second, and then there is no other: each takes a thousand steps.
        let mut drive = Drive::text(&scene_text(STILL_AIR, &emitter));
        let mut reference = vec![None; 300];
        for tick in 0..1_000 {
            ticks(&mut drive, 1);
            if tick == 48 {
                let off =
                    scene::ChangeAction::SwitchEffect(motion::effects::Effect::Emitters, false);
                drive.give([sandbox::input::Input::Change(off)]);
            }
            let swarm = swarms(&drive.session.stage).remove(0);
            let [last, now] = [swarm.ticks.len().checked_sub(2), swarm.ticks.len().checked_sub(1)]
                .map(|place| place.map(|place| &swarm.ticks[place]));
            reference = step(swarm.swarm.method, &swarm.swarm.launches, [last, now], &reference);
            if tick % 100 == 99 {
                let slots = device.slots(&mut drive.session);
                assert!(compare(&slots, &reference, now.unwrap().dead) <= 1.0);
            }
        }
        let allowed = reference.iter().flatten().map(|row| row.errors[0]).fold(0.0, f32::max);
        // Two positions lose a digit of the velocity in every step, some of which drag takes away again.
        assert!(
            allowed < if layout.contains("positions") { 0.2 } else { 2e-3 },
            "{layout} {allowed} m"
        );
    }
}
