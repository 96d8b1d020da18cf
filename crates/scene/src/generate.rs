//! Every body of a scene in the order of the stable id: the written ones, then grids, then clouds.

use glam::DVec3;
use pick::Shape;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::check::{Scope, not_negative, positive, shown, shown_vector};
use crate::faults::Faults;
use crate::names::Names;
use crate::raw::{RawBody, RawCloud, RawGrid};
use crate::resolve::is_extent;
use crate::resolve_body::{self, Defaults};
use crate::scene::BodySpec;

/// Most bodies that a scene may have; four times what the documentation promises to be able to watch.
pub const BODY_LIMIT: u64 = 4_000_000;

/// Half an edge of a grid's cubes, and the radius of its spheres, m, as in the tutorial.
const GRID_SIZE: f64 = 1.0;
/// Distance of a grid's bodies where none is given, m, as in the tutorial.
const GRID_SPACING: f64 = 3.5;
/// Mass of a grid's bodies where none is given, kg; its reciprocal is exactly the tutorial's 10.
const GRID_MASS: f64 = 0.1;

#[derive(Clone, Copy, Debug)]
enum GridKind {
    Mixed,
    Cubes,
    Spheres,
}

/// A checked grid.
struct Grid {
    kind: GridKind,
    columns: u32,
    rows: u32,
    spacing: [f64; 2],
    origin: DVec3,
    body: BodySpec,
}

/// A checked cloud.
struct Cloud {
    count: u32,
    center: DVec3,
    half_extents: DVec3,
    speed: f64,
    body: BodySpec,
}

/// Every body of a scene and what belongs to it by stable id.
pub(crate) struct Bodies {
    pub bodies: Vec<BodySpec>,
    /// `None` where there are too many bodies to be named.
    pub names: Option<Names>,
    pub labels: Vec<(u32, String)>,
}

/// Resolves all bodies and draws what the generators draw, from one stream in the order of the file.
pub(crate) fn bodies(
    raw_bodies: &[RawBody],
    raw_grids: &[RawGrid],
    raw_clouds: &[RawCloud],
    scenes: Defaults,
    seed: u64,
    faults: &mut Faults,
) -> Bodies {
    let mut names = Names::default();
    let mut labels = Vec::new();
    let mut bodies: Vec<BodySpec> = Vec::new();
    for (i, raw) in raw_bodies.iter().enumerate() {
        bodies.push(resolve_body::body(raw, i, scenes, faults));
        let scope = Scope::item("bodies", i);
        labels.extend(resolve_body::label(raw, scope, faults).map(|label| (i as u32, label)));
        // The dot keeps names that nobody wrote apart from those that somebody did.
        let name = raw.name.clone().unwrap_or_else(|| format!("body.{i}"));
        if raw.name.is_some() {
            check_name(&name, scope, faults);
        }
        add_name(|name| names.add(name), name, scope, faults);
    }
    let grids: Vec<Grid> = raw_grids.iter().enumerate().map(|(i, raw)| grid(raw, i, faults)).collect();
    let clouds: Vec<Cloud> = raw_clouds.iter().enumerate().map(|(i, raw)| cloud(raw, i, faults)).collect();

    let sizes = grids.iter().map(|grid| u64::from(grid.rows) * u64::from(grid.columns));
    let sizes = sizes.chain(clouds.iter().map(|cloud| u64::from(cloud.count)));
    let total = sizes.fold(bodies.len() as u64, u64::saturating_add);
    if total > BODY_LIMIT {
        let largest = if raw_bodies.len() as u64 > BODY_LIMIT {
            "bodies"
        } else if raw_clouds.is_empty() {
            "grids"
        } else {
            "clouds"
        };
        faults.add(
            largest,
            format!("{total} bodies are too many"),
            format!("give at most {BODY_LIMIT} in all"),
        );
        return Bodies { bodies, names: None, labels };
    }
    for (i, (grid, raw)) in grids.iter().zip(raw_grids).enumerate() {
        let scope = Scope::item("grids", i);
        let prefix = prefix(raw.name.as_deref(), "grid", scope, i, faults);
        add_name(
            |prefix| names.add_run(prefix, grid.rows * grid.columns, Some(grid.rows)),
            prefix,
            scope,
            faults,
        );
    }
    for (i, (cloud, raw)) in clouds.iter().zip(raw_clouds).enumerate() {
        let scope = Scope::item("clouds", i);
        let prefix = prefix(raw.name.as_deref(), "cloud", scope, i, faults);
        add_name(|prefix| names.add_run(prefix, cloud.count, None), prefix, scope, faults);
    }
    // A scene with faults is never spawned.
    if faults.is_empty() {
        let mut random = Pcg64::seed_from_u64(seed);
        bodies.reserve_exact(total as usize - bodies.len());
        grids.iter().for_each(|grid| grid.generate(&mut random, &mut bodies));
        clouds.iter().for_each(|cloud| cloud.generate(&mut random, &mut bodies));
    }
    Bodies { bodies, names: Some(names), labels }
}

/// `grid` for the first of its list, `grid2` for the second, unless it has a name of its own.
fn prefix(name: Option<&str>, kind: &str, scope: Scope, index: usize, faults: &mut Faults) -> String {
    match name {
        Some(name) => {
            check_name(name, scope, faults);
            name.to_owned()
        }
        None if index == 0 => kind.to_owned(),
        None => format!("{kind}{}", index + 1),
    }
}

/// Names stand in scripts, tables and generated names, so they are plain words.
fn check_name(name: &str, scope: Scope, faults: &mut Faults) {
    if name.is_empty() || !name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-')) {
        let cure = "use letters, digits, `_` and `-`";
        faults.add(scope.key("name"), format!("{name:?} cannot be a name"), cure);
    }
}

fn add_name(add: impl FnOnce(String) -> bool, name: String, scope: Scope, faults: &mut Faults) {
    let shown = name.clone();
    if !add(name) {
        faults.add(
            scope.key("name"),
            format!("the name `{shown}` is taken"),
            "give every body a name of its own",
        );
    }
}

fn grid(raw: &RawGrid, index: usize, faults: &mut Faults) -> Grid {
    let scope = Scope::item("grids", index);
    let kinds = [("mixed", GridKind::Mixed), ("cubes", GridKind::Cubes), ("spheres", GridKind::Spheres)];
    let kind = faults.word((scope, "kind"), raw.kind.as_ref(), GridKind::Mixed, &kinds);
    let rows = count(raw.rows, (scope, "rows"), faults);
    let columns = count(raw.columns, (scope, "columns"), faults);
    let spacing = raw.spacing_m.unwrap_or([GRID_SPACING; 2]);
    if !spacing.into_iter().all(positive) {
        let [x, z] = spacing;
        faults.add(
            scope.key("spacing_m"),
            format!("({}, {}) is not a spacing", shown(x), shown(z)),
            "give two positive numbers of meters",
        );
    }
    let origin = faults.vector((scope, "origin_m"), raw.origin_m, DVec3::ZERO);
    let [x, z] = spacing;
    let span = DVec3::new(f64::from(columns) * x, 0.0, f64::from(rows) * z);
    if spacing.into_iter().all(positive) && !(origin + span).is_finite() {
        faults.add(scope.key("spacing_m"), "the grid reaches beyond all numbers", "give a smaller spacing");
    }
    let body = BodySpec {
        inverse_mass: Some(faults.inverse_mass(
            scope,
            raw.mass_kg,
            GRID_MASS,
            "give a positive number of kilograms",
        )),
        color: faults.color((scope, "color"), raw.color, BodySpec::DEFAULT.color, 1.0),
        checker: true,
        method: faults.method(scope, raw.method.as_ref()),
        substeps: faults.substeps(scope, raw.substeps),
        ..BodySpec::DEFAULT
    };
    Grid { kind, columns, rows, spacing, origin, body }
}

fn cloud(raw: &RawCloud, index: usize, faults: &mut Faults) -> Cloud {
    let scope = Scope::item("clouds", index);
    let half_extents = raw.half_extents_m.map_or(DVec3::ZERO, DVec3::from_array);
    let center = faults.vector((scope, "center_m"), raw.center_m, DVec3::ZERO);
    let in_range =
        is_extent(half_extents) && (center + half_extents).is_finite() && (center - half_extents).is_finite();
    if !in_range {
        let what = format!("{} is not half a size", shown_vector(half_extents));
        faults.add(scope.key("half_extents_m"), what, "give three numbers of meters from 0 up");
    }
    let words = ("a speed", "give meters per second from 0 up");
    Cloud {
        count: count(raw.count, (scope, "count"), faults),
        center,
        half_extents,
        speed: faults.number((scope, "speed_m_s"), raw.speed_m_s, 0.0, not_negative, words),
        body: BodySpec {
            inverse_mass: Some(faults.inverse_mass(
                scope,
                raw.mass_kg,
                1.0,
                "give a positive number of kilograms",
            )),
            color: faults.color((scope, "color"), raw.color, BodySpec::DEFAULT.color, 1.0),
            method: faults.method(scope, raw.method.as_ref()),
            substeps: faults.substeps(scope, raw.substeps),
            ..BodySpec::DEFAULT
        },
    }
}

fn count(value: Option<u32>, (scope, key): (Scope, &str), faults: &mut Faults) -> u32 {
    match value {
        Some(0) => {
            faults.add(
                scope.key(key),
                format!("{key} is 0, which makes no body"),
                "give a whole number from 1 up",
            );
        }
        None => faults.missing(scope.path(), key, "give a whole number from 1 up"),
        Some(_) => {}
    }
    value.unwrap_or(0)
}

impl Grid {
    fn generate(&self, random: &mut Pcg64, bodies: &mut Vec<BodySpec>) {
        let cube = Shape::Cuboid { half_extents: DVec3::splat(GRID_SIZE) };
        let sphere = Shape::Sphere { radius: GRID_SIZE };
        for x in 0..self.columns {
            for z in 0..self.rows {
                let shape = match self.kind {
                    GridKind::Cubes => cube,
                    GridKind::Spheres => sphere,
                    GridKind::Mixed => {
                        if random.random::<bool>() {
                            cube
                        } else {
                            sphere
                        }
                    }
                };
                let offset = DVec3::new(f64::from(x) * self.spacing[0], 0.0, f64::from(z) * self.spacing[1]);
                bodies.push(BodySpec { shape: Some(shape), position: self.origin + offset, ..self.body });
            }
        }
    }
}

impl Cloud {
    fn generate(&self, random: &mut Pcg64, bodies: &mut Vec<BodySpec>) {
        for _ in 0..self.count {
            let place = DVec3::new(symmetric(random), symmetric(random), symmetric(random));
            let position = self.center + self.half_extents * place;
            let velocity = if self.speed > 0.0 { self.speed * direction(random) } else { DVec3::ZERO };
            bodies.push(BodySpec { position, velocity, ..self.body });
        }
    }
}

/// A number from -1 up to 1.
fn symmetric(random: &mut Pcg64) -> f64 {
    2.0 * random.random::<f64>() - 1.0
}

/// A uniformly drawn unit vector (Marsaglia 1972), without a sine that could differ between platforms.
fn direction(random: &mut Pcg64) -> DVec3 {
    loop {
        let (a, b) = (symmetric(random), symmetric(random));
        let s = a * a + b * b;
        if s < 1.0 {
            let scale = 2.0 * (1.0 - s).sqrt();
            return DVec3::new(a * scale, b * scale, 1.0 - 2.0 * s);
        }
    }
}

#[cfg(test)]
mod tests;
