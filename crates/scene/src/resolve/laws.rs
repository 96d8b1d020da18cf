//! Resolves the laws that bodies obey: drag and wind, mutual gravity, wells and thrusts, and the bodies that each of
//! them is for.

use std::collections::BTreeMap;

use glam::DVec3;
use motion::{BodyDrag, Curve, Drag, MutualGravity, Thrust, Well, Wells, Wind, WorldLaws};

use crate::check::{Rule, Scope, not_negative, rule, shown};
use crate::generate::Bodies;
use crate::raw;
use crate::resolve::carriers::physical;
use crate::scene::{OwnLawsSpec, RidingWellSpec};
use crate::text::faults::Faults;
use crate::text::syntax::Triple;

/// The constant of gravity, m³/(kg s²) (CODATA 2018).
const GRAVITATIONAL_CONSTANT: f64 = 6.674_30e-11;

const LINEAR: Rule = rule(not_negative, "a rate of drag", "give a number of 1/s from 0 up");
const QUADRATIC: Rule = rule(not_negative, "a factor of drag", "give a number of 1/m from 0 up");
const BODY_DRAG: Rule = rule(not_negative, "a coefficient of drag", "give a number from 0 up");
const GUST: Rule = rule(not_negative, "a strength of gusts", "give meters per second from 0 up");
const GUST_HZ: Rule = rule(not_negative, "a frequency", "give gusts a second from 0 up");
const CONSTANT: Rule =
    rule(f64::is_finite, "a constant of gravity", "give a finite number, below 0 to repel");
const STRENGTH: Rule = rule(f64::is_finite, "a strength", "give a finite number, below 0 to repel");
/// The softening length of a well or of mutual gravity.
const SOFTENING: Rule = rule(not_negative, "a softening", "give a number of meters from 0 up");
const FREQUENCY: Rule =
    rule(f64::is_finite, "a frequency", "give a finite number of radians a second");
const PHASE: Rule = rule(f64::is_finite, "a phase", "give a finite number of radians");
const START: Rule = rule(|v| v < f64::INFINITY, "a time", "give seconds, or leave it out");
const END: Rule = rule(|v| !v.is_nan(), "a time", "give seconds, or leave it out");

/// The laws of every body. Wells that name bodies and drag of single bodies become own laws.
pub(crate) fn world_laws(raw: &raw::Scene, own: &mut OwnLaws, faults: &mut Faults) -> WorldLaws {
    own.drags(&raw.bodies, raw.wind.is_some(), faults);
    let wells = own.wells(&raw.wells, faults);
    WorldLaws {
        drag: drag(raw.drag.as_ref(), raw.wind.as_ref(), faults),
        wells: (!wells.is_empty()).then_some(Wells(wells)),
    }
}

/// Drag, and the wind that it sees.
fn drag(raw: Option<&raw::Drag>, wind: Option<&raw::Wind>, faults: &mut Faults) -> Option<Drag> {
    let wind = wind.map(|raw| self::wind(raw, faults));
    let Some(raw) = raw else {
        if wind.is_some() {
            let what = "wind moves the air that drag sees, and there is no drag";
            faults.add("wind", what, "declare `drag`, or remove it");
        }
        return None;
    };
    let scope = Scope::section("drag");
    if raw.linear_per_s.is_none() && raw.quadratic_per_m.is_none() {
        let cure = "add `linear_per_s`, `quadratic_per_m` or both";
        faults.add(scope.path(), "drag needs at least one coefficient", cure);
    }
    let linear = faults.number(scope, "linear_per_s", raw.linear_per_s, 0.0, LINEAR);
    let quadratic = faults.number(scope, "quadratic_per_m", raw.quadratic_per_m, 0.0, QUADRATIC);
    Some(Drag { linear, quadratic, wind })
}

fn wind(raw: &raw::Wind, faults: &mut Faults) -> Wind {
    let scope = Scope::section("wind");
    let cure = "add one such as `velocity_m_s: (3.0, 0.0, 0.0)`";
    faults.require(raw.velocity_m_s.is_some(), scope, "velocity_m_s", cure);
    let cure = "gusts need `gust_m_s` and `gust_hz`; add it, or remove the other";
    let (gust, gust_hz) = (raw.gust_m_s.is_some(), raw.gust_hz.is_some());
    faults.require(gust || !gust_hz, scope, "gust_m_s", cure);
    faults.require(gust_hz || !gust, scope, "gust_hz", cure);
    Wind {
        velocity: faults.vector(scope, "velocity_m_s", raw.velocity_m_s, DVec3::ZERO),
        gust: faults.number(scope, "gust_m_s", raw.gust_m_s, 0.0, GUST),
        gust_hz: faults.number(scope, "gust_hz", raw.gust_hz, 0.0, GUST_HZ),
    }
}

pub(crate) fn mutual_gravity(raw: &raw::MutualGravity, faults: &mut Faults) -> MutualGravity {
    let scope = Scope::section("mutual_gravity");
    let key = "constant_m3_kg_s2";
    MutualGravity {
        constant: faults.number(
            scope,
            key,
            raw.constant_m3_kg_s2,
            GRAVITATIONAL_CONSTANT,
            CONSTANT,
        ),
        softening: faults.number(scope, "softening_m", raw.softening_m, 0.0, SOFTENING),
    }
}

/// Gathers the laws of single bodies.
pub(crate) struct OwnLaws<'a> {
    /// All bodies, if there are names.
    bodies: &'a Bodies,
    pub by_id: BTreeMap<u32, OwnLawsSpec>,
}

impl<'a> OwnLaws<'a> {
    pub const fn new(bodies: &'a Bodies) -> Self {
        Self { bodies, by_id: BTreeMap::new() }
    }

    /// Adds the drag of written bodies, whose stable ids are the first.
    fn drags(&mut self, raw: &[raw::Body], in_wind: bool, faults: &mut Faults) {
        for (i, body) in raw.iter().enumerate() {
            let scope = Scope::item("bodies", i);
            let Some(key) = body.drag_key() else { continue };
            if in_wind {
                let what =
                    "wind moves the air of the scene's `drag` alone, and this drag is in still air";
                faults.refuse(scope, key, what, "remove it or `wind`, or use `drag`");
            }
            if body.immovable == Some(true) {
                let what = format!("an immovable body is not slowed, so no `{key}`");
                faults.refuse(scope, key, what, "remove it, or immovable: true");
                continue;
            }
            if body.quadratic_drag_kg_m.is_some() && body.drag_area_m2.is_some() {
                let what = "the quadratic drag of the body is given twice";
                faults.refuse(scope, "drag_area_m2", what, "keep it or `quadratic_drag_kg_m`");
            }
            let [linear, quadratic, area] =
                body.drags().map(|(key, value)| faults.number(scope, key, value, 0.0, BODY_DRAG));
            let drag = BodyDrag::new(linear, quadratic.max(BodyDrag::of_area(area)));
            if body.scenery != Some(true)
                && let Ok(id) = u32::try_from(i)
            {
                self.by_id.entry(id).or_default().drag = Some(drag);
            }
        }
    }

    /// Adds the wells that name bodies to these bodies, and returns the other wells.
    fn wells(&mut self, raw: &[raw::Well], faults: &mut Faults) -> Vec<Well> {
        let mut for_all = Vec::new();
        for (i, raw) in raw.iter().enumerate() {
            let scope = Scope::item("wells", i);
            let well = well(raw, scope, faults);
            let carrier = raw.rides_on.as_ref().map(|name| self.carrier(name, raw, scope, faults));
            let Some(bodies) = &raw.bodies else {
                if carrier.is_some() {
                    let cure = "name them, as in `bodies: [\"moon\"]`";
                    faults.missing(scope.path(), "bodies", cure);
                }
                for_all.push(well);
                continue;
            };
            if bodies.is_empty() {
                let cure = "name a body, or leave `bodies` out for a well that attracts all";
                faults.refuse(scope, "bodies", "a well needs at least one body", cure);
            }
            for (j, name) in bodies.iter().enumerate() {
                let key = format!("bodies[{j}]");
                if bodies[..j].contains(name) {
                    faults.refuse(
                        scope,
                        &key,
                        format!("{name:?} is named twice"),
                        "keep one of them",
                    );
                    continue;
                }
                for own in self.each_of(name, scope, &key, carrier.flatten(), faults) {
                    match carrier {
                        None => own.wells.push(well),
                        Some(None) => {}
                        Some(Some(rides_on)) => {
                            let Well { strength, softening, .. } = well;
                            own.riding_wells.push(RidingWellSpec { rides_on, strength, softening });
                        }
                    }
                }
            }
        }
        for_all
    }

    /// The stable id of the body on which a well rides.
    fn carrier(
        &self,
        name: &str,
        raw: &raw::Well,
        scope: Scope,
        faults: &mut Faults,
    ) -> Option<u32> {
        if raw.position_m.is_some() {
            let what = "a well that rides on a body is where the body is";
            faults.refuse(scope, "position_m", what, "remove it, or `rides_on`");
        }
        physical(name, self.bodies, scope.key("rides_on"), "no well can ride on", faults)
    }

    /// The laws of the body of that name, or of the movable bodies of the entry of that name, which a well attracts.
    fn each_of(
        &mut self,
        name: &str,
        scope: Scope,
        key: &str,
        carrier: Option<u32>,
        faults: &mut Faults,
    ) -> Vec<&mut OwnLawsSpec> {
        let emitter = self.bodies.emitters.iter().find(|emitter| emitter.name == name);
        if emitter.is_some_and(|emitter| emitter.on_device.is_some()) {
            let what = format!(
                "{name:?} is on the graphics device, where every well attracts all particles"
            );
            faults.refuse(scope, key, what, "give the emitter on: cpu, or leave `bodies` out");
        }
        let group =
            || self.bodies.names.as_ref().filter(|names| names.find(name).is_none())?.group(name);
        if let Some(group) = emitter.map(|emitter| emitter.pool.clone()).or_else(group) {
            let bodies = &self.bodies.bodies;
            let is_attracted =
                |id: &u32| bodies[*id as usize].inverse_mass != Some(0.0) && Some(*id) != carrier;
            for id in group.clone().filter(is_attracted) {
                self.by_id.entry(id).or_default();
            }
            let own = self.by_id.range_mut(group).filter(|(id, _)| is_attracted(id));
            return own.map(|(_, own)| own).collect();
        }
        if carrier.is_some()
            && self.bodies.names.as_ref().and_then(|names| names.find(name)) == carrier
        {
            faults.refuse(
                scope,
                key,
                "a well does not attract the body on which it rides",
                "remove it",
            );
            return Vec::new();
        }
        self.of(name, scope, key, "well attracts", faults).into_iter().collect()
    }

    /// Adds the engines of bodies.
    pub fn thrusts(&mut self, raw: &[raw::Drive], faults: &mut Faults) {
        for (i, raw) in raw.iter().enumerate() {
            let scope = Scope::item("thrusts", i);
            let thrust = drive(raw, "amplitude_n", scope, faults);
            let Some(body) = driven(raw, scope, faults) else { continue };
            let own = self.of(body, scope, "body", "engine moves", faults);
            if let (Some(own), Some((curve, from, until))) = (own, thrust) {
                own.thrusts.push(Thrust::new(curve, from, until));
            }
        }
    }

    /// The laws of the body `name`, if laws can act on it.
    fn of(
        &mut self,
        name: &str,
        scope: Scope,
        key: &str,
        acts: &str,
        faults: &mut Faults,
    ) -> Option<&mut OwnLawsSpec> {
        let names = self.bodies.names.as_ref()?;
        let Some(id) = names.find(name) else {
            let (what, cure) = names.stranger(name);
            faults.refuse(scope, key, what, cure);
            return None;
        };
        let inverse_mass = self.bodies.bodies.get(id as usize).map(|body| body.inverse_mass);
        let kind = match inverse_mass {
            Some(None) => "scenery",
            Some(Some(0.0)) => "immovable",
            _ => return Some(self.by_id.entry(id).or_default()),
        };
        let what = format!("{name:?} is {kind}, so no {acts} it");
        faults.refuse(scope, key, what, "name a body that can move");
        None
    }
}

fn well(raw: &raw::Well, scope: Scope, faults: &mut Faults) -> Well {
    let cure = "add one such as `strength_m3_s2: 1000.0`";
    faults.require(raw.strength_m3_s2.is_some(), scope, "strength_m3_s2", cure);
    Well {
        position: faults.vector(scope, "position_m", raw.position_m, DVec3::ZERO),
        strength: faults.number(scope, "strength_m3_s2", raw.strength_m3_s2, 0.0, STRENGTH),
        softening: faults.number(scope, "softening_m", raw.softening_m, 0.0, SOFTENING),
    }
}

/// The name of the body that a curve drives.
pub(super) fn driven<'r>(
    raw: &'r raw::Drive,
    scope: Scope,
    faults: &mut Faults,
) -> Option<&'r String> {
    if raw.body.is_none() {
        faults.missing(scope.path(), "body", "name the body that it drives");
    }
    raw.body.as_ref()
}

/// A curve, and the times from and until which it is followed, s. A sine has its amplitude in the key `amplitude`.
pub(super) fn drive(
    raw: &raw::Drive,
    amplitude: &str,
    scope: Scope,
    faults: &mut Faults,
) -> Option<(Curve, f64, f64)> {
    let curve = match &raw.curve {
        Some(raw::Curve::Polynomial(coefficients)) => polynomial(coefficients, scope, faults),
        Some(raw::Curve::Sine { amplitude_n, amplitude_m, angular_frequency_rad_s, phase_rad }) => {
            let given = [("amplitude_n", *amplitude_n), ("amplitude_m", *amplitude_m)];
            for (key, _) in given.iter().filter(|(key, value)| *key != amplitude && value.is_some())
            {
                let key = format!("curve.{key}");
                faults.refuse(scope, &key, "it has the wrong unit", format!("give {amplitude}"));
            }
            let given = given.into_iter().find(|(key, _)| *key == amplitude);
            let given = (amplitude, given.and_then(|(_, value)| value));
            Some(sine(given, *angular_frequency_rad_s, *phase_rad, scope, faults))
        }
        Some(raw::Curve::Table(points)) => table(points, scope, faults),
        None => {
            faults.missing(
                scope.path(),
                "curve",
                "add one such as `curve: polynomial([(10.0, 0.0, 0.0)])`",
            );
            None
        }
    };
    let from = faults.number(scope, "from_s", raw.from_s, f64::NEG_INFINITY, START);
    let until = faults.number(scope, "until_s", raw.until_s, f64::INFINITY, END);
    // The time of a scene begins at 0.
    let start = from.max(0.0);
    if until <= start {
        let what = format!("{} s is not after the start at {} s", shown(until), shown(start));
        faults.refuse(scope, "until_s", what, "give a later time, or leave it out");
    }
    curve.map(|curve| (curve, from, until))
}

/// The path of entry `i` of the list in the brackets of a curve.
fn entry(i: usize) -> String {
    format!("curve[0][{i}]")
}

fn polynomial(coefficients: &[Triple], scope: Scope, faults: &mut Faults) -> Option<Curve> {
    if coefficients.is_empty() {
        let cure = "give at least the constant one, as in `polynomial([(10.0, 0.0, 0.0)])`";
        faults.refuse(scope, "curve", "a polynomial needs at least one coefficient", cure);
        return None;
    }
    let finite =
        |(i, triple): (usize, &Triple)| faults.vector(scope, &entry(i), Some(*triple), DVec3::ZERO);
    Some(Curve::Polynomial(coefficients.iter().enumerate().map(finite).collect()))
}

fn sine(
    (key_of_amplitude, amplitude): (&str, Option<Triple>),
    frequency: Option<f64>,
    phase: Option<f64>,
    scope: Scope,
    faults: &mut Faults,
) -> Curve {
    for (key, given) in
        [(key_of_amplitude, amplitude.is_some()), ("angular_frequency_rad_s", frequency.is_some())]
    {
        if !given {
            let cure = format!(
                "give a sine as `sine({key_of_amplitude}: (x, y, z), angular_frequency_rad_s: w)`"
            );
            faults.missing(scope.key("curve"), key, &cure);
        }
    }
    let key = "curve.angular_frequency_rad_s";
    Curve::Sine {
        amplitude: faults.vector(
            scope,
            &format!("curve.{key_of_amplitude}"),
            amplitude,
            DVec3::ZERO,
        ),
        angular_frequency: faults.number(scope, key, frequency, 0.0, FREQUENCY),
        phase: faults.number(scope, "curve.phase_rad", phase, 0.0, PHASE),
    }
}

fn table(points: &[(f64, Triple)], scope: Scope, faults: &mut Faults) -> Option<Curve> {
    if points.is_empty() {
        let cure = "give at least one point, as in `table([(0.0, (10.0, 0.0, 0.0))])`";
        faults.refuse(scope, "curve", "a table needs at least one point", cure);
        return None;
    }
    let mut latest = f64::NEG_INFINITY;
    let mut point = |(i, (time, value)): (usize, &(f64, Triple))| {
        let key = entry(i);
        let cure = "give finite times, each later than the one before; for a jump give two, such as 1 and 1.001";
        if !time.is_finite() {
            faults.refuse(scope, &key, format!("{} is not a time", shown(*time)), cure);
        } else if *time <= latest {
            let what = format!("{} s comes after {} s", shown(*time), shown(latest));
            faults.refuse(scope, &key, what, cure);
        } else {
            latest = *time;
        }
        (*time, faults.vector(scope, &format!("{key}[1]"), Some(*value), DVec3::ZERO))
    };
    Some(Curve::Table(points.iter().enumerate().map(&mut point).collect()))
}
