//! Turns what a person wrote into what the program uses: defaults, units and faults of a whole scene.

mod carriers;
pub(crate) mod declared;
mod laws;
mod moves;
pub(crate) mod springs;
pub(crate) mod survival;

use std::sync::Arc;

use motion::effects::Effect;
use motion::{Damping, DampingModel, Gravity, Range};

use crate::check::{DAMPING_RATE, RADIUS, Rule, STEP_RATE, Scope, positive, rule};
use crate::generate::{self, Bodies, Defaults, NAME_LIMIT, on_device};
use crate::lists::counted_within;
use crate::memory::{room, too_much};
use crate::raw;
use crate::scene::coupled::Declaration;
use crate::scene::{
    CameraSpec, ExpectSpec, LightSpec, PushSpec, Reading, SCENE_VERSION, Scene, Source, StepKind,
};
use crate::text::faults::{Faults, SceneError};
use crate::text::locate;
use crate::text::syntax::{self, Word};
use laws::OwnLaws;

const FORCE: Rule = rule(f64::is_finite, "a force", "give a finite number of newtons");
const LARGEST_DISTANCE: Rule =
    rule(positive, "a largest distance from the origin", "give a positive number of meters");
const LARGEST_SPEED: Rule =
    rule(positive, "a largest speed", "give a positive number of meters per second");
const DISTANCE: Rule = rule(positive, "a distance", "give a positive number of meters");
const PITCH: Rule = rule(|v| (-90.0..=90.0).contains(&v), "a pitch", "give degrees from -90 to 90");
const YAW: Rule = rule(f64::is_finite, "a yaw", "give a finite number of degrees");
const FOV: Rule =
    rule(|v| v > 0.0 && v < 180.0, "a field of view", "give degrees above 0 and below 180");
const DRIFT: Rule = rule(positive, "a bound", "give a positive number such as 1e-3");

impl Scene {
    /// Reads a scene from a text. Messages call it `name`, which is also the name of a scene that has none.
    ///
    /// ```
    /// let scene = scene::Scene::parse("ball.ron", "(version: 1, bodies: [(mass_kg: 0.5)])").expect("it is a scene");
    /// assert_eq!(scene.bodies[0].inverse_mass, Some(2.0));
    ///
    /// let error = scene::Scene::parse("ball.ron", "(version: 1, bodies: [(mass_kg: -1)])").unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "ball.ron:1:24: bodies[0].mass_kg: -1 is not a mass; give a positive number of kilograms, or immovable: true",
    /// );
    /// ```
    ///
    /// # Errors
    ///
    /// If the text is not RON or a value has the wrong type: that one place. Otherwise every fault of the text.
    pub fn parse(name: &str, text: &str) -> Result<Self, SceneError> {
        parse_as(name, text, Source::Text)
    }

    /// Reads another text of this scene. It gets this scene's source, and its name if the text has none.
    ///
    /// # Errors
    ///
    /// As [`Self::parse`].
    pub fn reread(&self, text: &str) -> Result<Self, SceneError> {
        parse_as(&self.name, text, self.source.clone())
    }
}

/// Reads a scene that came from `source`.
pub(crate) fn parse_as(name: &str, text: &str, source: Source) -> Result<Scene, SceneError> {
    let read = Arc::from(text);
    let text = locate::spell_nan(text);
    let text = text.as_str();
    let later = || match syntax::read::<raw::Version>(text, "") {
        Ok((raw::Version { version: Some(version) }, _)) if version > SCENE_VERSION => {
            Some(version)
        }
        _ => None,
    };
    // Checked first: a newer file is full of keys and types that would only be noise here.
    if let Some(version) = later() {
        let mut faults = Faults::default();
        faults.add(
            "version",
            format!("version {version} of the format is newer than this program, which reads version {SCENE_VERSION}"),
            "use a newer program",
        );
        return Err(faults.into_error(name, text, ""));
    }
    let room = room().saturating_sub(text.len());
    let (read_raw, entries) = counted_within(room, || syntax::read::<raw::Scene>(text, ""));
    let Some(entries) = entries else {
        return Err(SceneError::of_file(
            name,
            too_much(),
            "write fewer, or give more with `--memory GIB`",
        ));
    };
    let (raw, unknown) = read_raw.map_err(|error| syntax::error(name, text, "", &error))?;
    let bytes = |name: &Option<String>| name.as_ref().map_or(0, String::len);
    let reading = Reading {
        text: text.len() as u64,
        entries: entries as u64,
        bodies: raw.bodies.len() as u64,
        name_bytes: raw
            .bodies
            .iter()
            .map(|body| (bytes(&body.name) + bytes(&body.label)) as u64)
            .sum(),
    };
    let mut faults = Faults::default();
    for path in &unknown {
        unknown_key(&raw, &mut faults, path);
    }
    let declared = declared::declared(&raw, text);
    let scene = resolve(&raw, declared, read, name, source, reading, &mut faults);
    faults.check(name, text, "")?;
    Ok(scene)
}

fn unknown_key(raw: &raw::Scene, faults: &mut Faults, path: &str) {
    let group = path.rsplit_once('.').map_or("", |(group, _)| group);
    let soft = group
        .strip_prefix("soft_bodies[")
        .and_then(|rest| rest.strip_suffix(']')?.parse::<usize>().ok());
    let kind = soft.and_then(|index| raw.soft_bodies.get(index)).map_or("", |soft| &soft.word);
    let known: Vec<_> = raw::kinds_at(group, kind).into_iter().map(|(key, _)| key).collect();
    faults.unknown_key(path, &known);
}

/// The name that the file gives.
fn scene_name(raw: &raw::Scene, faults: &mut Faults) -> Option<String> {
    let name = raw.name.clone()?;
    let length = name.chars().count();
    if length > NAME_LIMIT || name.chars().any(char::is_control) {
        let what = if length > NAME_LIMIT {
            format!("{length} characters are too many for a name")
        } else {
            "a name is one line of plain characters".to_owned()
        };
        faults.add("name", what, format!("give at most {NAME_LIMIT} characters, or remove it"));
    }
    Some(name)
}

/// The words of a text in one line.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The one place where defaults are filled in. Returns a scene even if there are faults; it is then not used.
fn resolve(
    raw: &raw::Scene,
    declared: Vec<Declaration>,
    text: Arc<str>,
    name: &str,
    source: Source,
    reading: Reading,
    faults: &mut Faults,
) -> Scene {
    const ROOT: Scope = Scope::ROOT;
    match raw.version {
        None => faults.add(
            "version",
            "the version is missing",
            format!("add `version: {SCENE_VERSION}`"),
        ),
        Some(SCENE_VERSION) => {}
        Some(other) => {
            faults.add(
                "version",
                format!("there is no version {other}"),
                format!("give version: {SCENE_VERSION}"),
            );
        }
    }
    let step_hz = faults.number(ROOT, "step_hz", raw.step_hz, 120.0, STEP_RATE);
    // If a tick lasts longer than a person waits, sixty ticks are shown per second by default.
    let usual = if step_hz < SHORTEST_WAIT_HZ { 60.0 / step_hz } else { 1.0 };
    let pace = faults.number(ROOT, "pace", raw.pace, usual, PACE);
    let kinds = [("fixed", StepKind::Fixed), ("frame", StepKind::Frame)];
    let step = faults.word(ROOT, "step", raw.step.as_ref(), StepKind::Fixed, &kinds);
    let own = faults.method(ROOT, raw.method.as_ref());
    let method = own.unwrap_or_default();
    let substeps = faults.substeps(ROOT, raw.substeps).unwrap_or_default();
    let defaults = Defaults {
        method: if raw.method.is_some() { own } else { Some(method) },
        substeps,
        step_hz,
    };
    let seed = raw.seed.unwrap_or(0);

    let gravity = raw.gravity.as_ref().map(|raw| {
        let (scope, earth) = (Scope::section("gravity"), Gravity::EARTH.acceleration);
        let acceleration = faults.vector(scope, "acceleration_m_s2", raw.acceleration_m_s2, earth);
        Gravity { acceleration, on: raw.on_at_start.unwrap_or(true) }
    });
    let damping = raw.damping.as_ref().map(|raw| damping(raw, faults));
    let mutual_gravity = raw.mutual_gravity.as_ref().map(|raw| laws::mutual_gravity(raw, faults));
    let range = raw.range.as_ref().map(|raw| range(raw, faults));
    let push = raw.push.as_ref().map(|raw| {
        let scope = Scope::section("push");
        let PushSpec { start, per_notch, .. } = PushSpec::TUTORIAL;
        PushSpec {
            start: faults.number(scope, "start_n", raw.start_n, start, FORCE),
            per_notch: faults.number(
                scope,
                "newtons_per_notch",
                raw.newtons_per_notch,
                per_notch,
                FORCE,
            ),
            radius: faults.optional(scope, "radius_m", raw.radius_m, RADIUS),
        }
    });
    let camera = raw.camera.as_ref().map_or(CameraSpec::TUTORIAL, |raw| camera(raw, faults));
    let light = raw.light.as_ref().map(|raw| light(raw, faults));
    let off_at_start = off_at_start(raw.off_at_start.as_deref().unwrap_or_default(), faults);
    let expect = raw.expect.as_ref().map(|raw| expect(raw, faults));
    let mut bodies = generate::bodies(raw, reading, defaults, seed, faults);
    carriers::carry_emitters(&raw.emitters, &mut bodies, faults);
    let mut own_laws = OwnLaws::new(&bodies);
    let laws = laws::world_laws(raw, &mut own_laws, faults);
    own_laws.thrusts(&raw.thrusts, faults);
    on_device::check(raw, step_hz, &laws, &bodies, faults);
    let own_laws = own_laws.by_id;
    let motions = moves::moves(&raw.moves, &bodies, faults);
    let springs = springs::springs(&raw.springs, &bodies, faults);
    springs::check_groups(&bodies, &springs, mutual_gravity.is_some(), faults);
    if mutual_gravity.is_some() && !off_at_start.contains(&Effect::MutualGravity) {
        springs::check_methods(defaults.method, &bodies.sections, faults);
    }
    let Bodies { bodies, names, labels, emitters, soft_bodies, .. } = bodies;
    let named = names.is_some();
    let mut scene = Scene {
        text,
        reading,
        name: scene_name(raw, faults).unwrap_or_else(|| name.to_owned()),
        description: one_line(raw.description.as_deref().unwrap_or_default()),
        source,
        step_hz,
        step,
        pace,
        method,
        substeps,
        seed,
        gravity,
        damping,
        laws,
        mutual_gravity,
        range,
        own_laws,
        motions,
        push,
        camera,
        light,
        trails: raw.trails.unwrap_or(false),
        select_immovable: raw.select_immovable.unwrap_or(false),
        bodies,
        names: names.unwrap_or_default(),
        labels,
        emitters,
        springs,
        soft_bodies,
        off_at_start,
        declared,
        expect,
        survival: None,
    };
    scene.survival = survival::survival(raw, &scene, named.then_some(&scene.names), faults);
    // A body's own rate has to act even if the scene declares no damping: with the default model, on that body alone.
    if scene.bodies.iter().any(|body| body.damping_rate.is_some()) {
        scene.damping.get_or_insert(Damping { model: DampingModel::Exact, rate: 0.0 });
    }
    scene
}

/// Ticks per second below which a person would wait for each.
const SHORTEST_WAIT_HZ: f64 = 0.1;

const SHARE: Rule = rule(
    |share| share > 0.0 && share <= 1.0,
    "a share of the velocity",
    "give a number above 0, at most 1",
);
const PACE: Rule =
    rule(positive, "a pace", "give a positive number of simulated seconds per second");

fn off_at_start(words: &[Word], faults: &mut Faults) -> Vec<Effect> {
    // Gravity has its own key for this.
    let switched = Effect::ALL.into_iter().filter(|effect| *effect != Effect::Gravity);
    let known: Vec<_> = switched.map(|effect| (effect.name(), Some(effect))).collect();
    let effect = |(i, word): (usize, &Word)| {
        let key = format!("off_at_start[{i}]");
        if word.0 == Effect::Gravity.name() {
            faults.add(
                &key,
                "gravity is not switched off here",
                "give gravity: (on_at_start: false)",
            );
            return None;
        }
        faults.word(Scope::ROOT, &key, Some(word), None, &known)
    };
    words.iter().enumerate().filter_map(effect).collect()
}

fn damping(raw: &raw::Damping, faults: &mut Faults) -> Damping {
    let scope = Scope::section("damping");
    let models = DampingModel::ALL.map(|model| (model.name(), model));
    let model = faults.word(scope, "model", raw.model.as_ref(), DampingModel::Exact, &models);
    if raw.rate_per_s.is_none() && raw.share_kept_per_s.is_none() {
        faults.refuse(
            scope,
            "rate_per_s",
            "the rate is missing",
            "add one such as `rate_per_s: 0.4`",
        );
    }
    if raw.rate_per_s.is_some() && raw.share_kept_per_s.is_some() {
        let what = "the rate is given twice";
        faults.refuse(scope, "share_kept_per_s", what, "keep it or `rate_per_s`");
    }
    let rate = faults.number(scope, "rate_per_s", raw.rate_per_s, 0.0, DAMPING_RATE);
    // What is kept after t seconds is e^(-c t).
    let kept = faults.number(scope, "share_kept_per_s", raw.share_kept_per_s, 1.0, SHARE);
    Damping { model, rate: rate.max(-libm::log(kept)) }
}

fn range(raw: &raw::Range, faults: &mut Faults) -> Range {
    let scope = Scope::section("range");
    if raw.position_m.is_none() && raw.speed_m_s.is_none() {
        let cure = "add `position_m`, `speed_m_s` or both";
        faults.add(scope.path(), "a range needs at least one bound", cure);
    }
    let Range { position: any_position, speed: any_speed } = Range::FINITE;
    Range {
        position: faults.number(
            scope,
            "position_m",
            raw.position_m,
            any_position,
            LARGEST_DISTANCE,
        ),
        speed: faults.number(scope, "speed_m_s", raw.speed_m_s, any_speed, LARGEST_SPEED),
    }
}

fn camera(raw: &raw::Camera, faults: &mut Faults) -> CameraSpec {
    let scope = Scope::section("camera");
    let default = CameraSpec::TUTORIAL;
    let camera = CameraSpec {
        position: faults.vector(scope, "position_m", raw.position_m, default.position),
        pitch_deg: faults.number(scope, "pitch_deg", raw.pitch_deg, default.pitch_deg, PITCH),
        yaw_deg: faults.number(scope, "yaw_deg", raw.yaw_deg, default.yaw_deg, YAW),
        fov_y_deg: faults.number(scope, "fov_y_deg", raw.fov_y_deg, default.fov_y_deg, FOV),
        near: faults.number(scope, "near_m", raw.near_m, default.near, DISTANCE),
        far: faults.number(scope, "far_m", raw.far_m, default.far, DISTANCE),
    };
    if camera.near >= camera.far {
        let key = if raw.far_m.is_some() { "far_m" } else { "near_m" };
        let what = format!("far_m {} is not above near_m {}", camera.far, camera.near);
        faults.refuse(scope, key, what, "make far_m the larger one");
    }
    camera
}

fn light(raw: &raw::Light, faults: &mut Faults) -> LightSpec {
    let scope = Scope::section("light");
    let default = LightSpec::TUTORIAL;
    LightSpec {
        position: faults.vector(scope, "position_m", raw.position_m, default.position),
        // A bright light may be more than white.
        color: faults.color_to(scope, raw.color, default.color, f32::MAX.into(), "from 0 up"),
        shadows: raw.shadows.unwrap_or(default.shadows),
    }
}

fn expect(raw: &raw::Expect, faults: &mut Faults) -> ExpectSpec {
    let scope = Scope::section("expect");
    let energy_drift_below =
        faults.optional(scope, "energy_drift_below", raw.energy_drift_below, DRIFT);
    ExpectSpec { energy_drift_below, finite: raw.finite }
}

#[cfg(test)]
mod tests;
