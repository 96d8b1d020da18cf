//! The state file of a run: the states of bodies at some of its ticks, as CSV.

use std::io::{self, Write};

use bevy_ecs::entity::Entity;
use glam::DVec3;
use lab::Value;
use motion::effects::{Effect, EffectState, state};
use motion::{
    Dormant, ForceCause, LAWS, LAWS_WITH_POTENTIAL, PhysicsBody, Quarantined, Transform,
    each_potential_energy,
};
use report::csv_line;
use scene::Scene;
use wildmatch::WildMatch;

use crate::failure::Failure;
use crate::output::files::{Output, OutputPath, output_file};
use cockpit::stage::Stage;

/// A quantity of a body in the state file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Position,
    Velocity,
    Acceleration,
    /// The sum of all forces.
    Force,
    /// Each force by its cause.
    Forces,
    /// The kinetic energy and each potential energy.
    Energies,
    Momentum,
    AngularMomentum,
    /// The distance to the body of that name.
    Distance(String),
}

/// The words for all quantities but distances.
const WORDS: [(&str, Quantity); 8] = [
    ("position", Quantity::Position),
    ("velocity", Quantity::Velocity),
    ("acceleration", Quantity::Acceleration),
    ("force", Quantity::Force),
    ("forces", Quantity::Forces),
    ("energies", Quantity::Energies),
    ("momentum", Quantity::Momentum),
    ("angular_momentum", Quantity::AngularMomentum),
];

/// The word for a distance, before the name of a body.
const DISTANCE: &str = "distance:";

impl Quantity {
    /// The quantity of that word on the command line.
    pub fn parse(word: &str) -> Result<Self, String> {
        if let Some(body) = word.strip_prefix(DISTANCE) {
            return Ok(Self::Distance(body.to_owned()));
        }
        let known = WORDS.into_iter().find(|(name, _)| *name == word);
        known.map(|(_, quantity)| quantity).ok_or_else(|| {
            let near = scene::nearest(word, WORDS.iter().map(|(name, _)| *name));
            let guess = scene::did_you_mean(near);
            let names = WORDS.map(|(name, _)| name).join(", ");
            format!("{guess}the columns are {names} and {DISTANCE}BODY")
        })
    }

    fn columns(&self, causes: &Causes) -> Vec<String> {
        let axes =
            |name: &str, unit: &str| ["x", "y", "z"].map(|axis| format!("{name}_{axis}_{unit}"));
        match self {
            Self::Position => axes("position", "m").to_vec(),
            Self::Velocity => axes("velocity", "m_s").to_vec(),
            Self::Acceleration => axes("acceleration", "m_s2").to_vec(),
            Self::Force => axes("force", "n").to_vec(),
            Self::Forces => causes
                .forces
                .iter()
                .flat_map(|cause| axes(&format!("force_{cause}"), "n"))
                .collect(),
            Self::Energies => {
                let potential =
                    causes.energies.iter().map(|law| format!("potential_energy_{law}_j"));
                std::iter::once("kinetic_energy_j".to_owned()).chain(potential).collect()
            }
            Self::Momentum => axes("momentum", "kg_m_s").to_vec(),
            Self::AngularMomentum => axes("angular_momentum", "kg_m2_s").to_vec(),
            Self::Distance(body) => vec![format!("distance_{body}_m")],
        }
    }
}

/// The causes of forces and the kinds of potential energy that a scene declares, on or off.
#[derive(Clone, Debug, Default)]
struct Causes {
    forces: Vec<&'static str>,
    energies: Vec<&'static str>,
}

impl Causes {
    fn of(stage: &Stage) -> Self {
        let mut is_declared = |law: &&str| {
            let effect = Effect::from_name(law);
            effect
                .is_some_and(|effect| state(&stage.sim().world, effect) != EffectState::NotDeclared)
        };
        let declared: Vec<_> = LAWS.iter().map(|(law, _)| *law).filter(&mut is_declared).collect();
        let energies =
            declared.iter().copied().filter(|law| LAWS_WITH_POTENTIAL.contains(law)).collect();
        Self {
            forces: std::iter::once(ForceCause::Push.name()).chain(declared).collect(),
            energies,
        }
    }
}

/// The quantities and the bodies in the state file of a run.
#[derive(Clone, Debug)]
pub(crate) struct Selection {
    pub quantities: Vec<Quantity>,
    /// Patterns of the names of bodies, with `*` and `?`; without patterns, all bodies.
    pub bodies: Vec<String>,
}

impl Selection {
    /// Position and velocity of all bodies.
    pub fn usual() -> Self {
        Self { quantities: vec![Quantity::Position, Quantity::Velocity], bodies: Vec::new() }
    }

    /// Refuses names and patterns that no body has, or only scenery, which has no rows.
    pub fn check(&self, scene: &Scene) -> Result<(), Failure> {
        let names = &scene.names;
        let refuse = |place: &str, name: &str| {
            let (what, cure) = names.stranger(name);
            Err(Failure::Usage(format!("{place}: {what}; {cure}")))
        };
        for quantity in &self.quantities {
            if let Quantity::Distance(body) = quantity
                && names.find(body).is_none()
            {
                return refuse(&format!("--columns {DISTANCE}{body}"), body);
            }
        }
        for pattern in &self.bodies {
            let pattern_of = WildMatch::new(pattern);
            let named = scene.bodies.iter().zip(names.iter());
            let matched: Vec<_> = named
                .filter(|(_, name)| pattern_of.matches(name))
                .map(|(body, _)| body.inverse_mass)
                .collect();
            if matched.iter().all(Option::is_none) {
                let what = if matched.is_empty() {
                    "no body has such a name; * is any letters of a name, ? is one"
                } else {
                    "only scenery, which never moves, has such a name; name a body with physics"
                };
                return Err(Failure::Usage(format!("--bodies {pattern}: {what}")));
            }
        }
        Ok(())
    }
}

/// The state file, row by row.
pub(crate) struct States<W: Write> {
    quantities: Vec<Quantity>,
    bodies: Vec<WildMatch>,
    causes: Causes,
    out: W,
}

impl States<Output> {
    /// Begins the file at `path`.
    pub fn begin(path: &OutputPath, stage: &Stage, selection: &Selection) -> Result<Self, Failure> {
        let end = path.as_ref().extension();
        if end.is_some_and(|end| end.eq_ignore_ascii_case("parquet")) {
            let what = "states are written as CSV; give a name that ends in .csv";
            return Err(Failure::Usage(format!("{}: {what}", path.as_ref().display())));
        }
        let failed = |error: io::Error| Failure::file("write", path.as_ref(), &error);
        Self::new(output_file(path)?, stage, selection).map_err(failed)
    }

    /// Writes what is left.
    pub fn finish(self) -> io::Result<()> {
        self.out.finish()
    }
}

impl<W: Write> States<W> {
    fn new(mut out: W, stage: &Stage, selection: &Selection) -> io::Result<Self> {
        let causes = Causes::of(stage);
        let names = selection.quantities.iter().flat_map(|quantity| quantity.columns(&causes));
        let columns = ["tick", "time_s", "body"].map(str::to_owned).into_iter().chain(names);
        out.write_all(csv_line(columns).as_bytes())?;
        let bodies = selection.bodies.iter().map(|pattern| WildMatch::new(pattern)).collect();
        Ok(Self { quantities: selection.quantities.clone(), bodies, causes, out })
    }

    /// Adds a row for every body with physics that is wanted, immovable ones too, in stable-id order.
    pub fn add(&mut self, stage: &Stage) -> io::Result<()> {
        let is_wanted = |name: &str| {
            self.bodies.is_empty() || self.bodies.iter().any(|pattern| pattern.matches(name))
        };
        let bodies: Vec<_> = stage
            .sim()
            .remaining_bodies()
            .filter_map(|thing| {
                let body = *stage.sim().world.get::<PhysicsBody>(thing)?;
                let position = stage.sim().world.get::<Transform>(thing)?.position;
                let name = stage.name(thing);
                is_wanted(&name).then_some((thing, name, position, body))
            })
            .collect();
        let entities: Vec<_> = bodies.iter().map(|(thing, ..)| *thing).collect();
        let caused = Caused::of(stage, &entities, &self.quantities);
        let others: Vec<_> =
            self.quantities.iter().map(|quantity| other(stage, quantity)).collect();
        for (at, (thing, name, position, body)) in bodies.into_iter().enumerate() {
            let moves = moves(stage, thing, &body);
            let mut row = vec![
                Value::Count(stage.sim().ticks()),
                Value::Number(stage.sim().seconds()),
                Value::Text(name),
            ];
            for (quantity, other) in self.quantities.iter().zip(&others) {
                let vector = |v: DVec3| v.to_array().map(Value::Number).to_vec();
                let of_forces = |v: DVec3| if moves { vector(v) } else { vec![Value::Absent; 3] };
                row.extend(match quantity {
                    Quantity::Position => vector(position),
                    Quantity::Velocity => vector(body.velocity),
                    Quantity::Acceleration => of_forces(caused.force(at) * body.inverse_mass),
                    Quantity::Force => of_forces(caused.force(at)),
                    Quantity::Forces => {
                        let causes = self.causes.forces.iter();
                        causes.flat_map(|cause| of_forces(caused.force_by(at, cause))).collect()
                    }
                    Quantity::Energies => {
                        let potential =
                            self.causes.energies.iter().map(|law| caused.energy_by(at, law));
                        let energies = std::iter::once(body.kinetic_energy()).chain(potential);
                        energies.map(Value::Number).collect()
                    }
                    Quantity::Momentum => vector(body.momentum()),
                    Quantity::AngularMomentum => vector(position.cross(body.momentum())),
                    Quantity::Distance(_) => {
                        vec![
                            other.map_or(Value::Absent, |other| {
                                Value::Number(position.distance(other))
                            }),
                        ]
                    }
                });
            }
            let field = |value: &Value| match value {
                Value::Number(number) => format!("{number:.16e}"),
                other @ (Value::Count(_) | Value::Flag(_) | Value::Text(_) | Value::Absent) => {
                    other.to_string()
                }
            };
            self.out.write_all(csv_line(row.iter().map(field)).as_bytes())?;
        }
        Ok(())
    }
}

/// The state of `stage` as CSV, with the usual columns.
pub(crate) fn csv_of(stage: &Stage) -> io::Result<Vec<u8>> {
    let mut states = States::new(Vec::new(), stage, &Selection::usual())?;
    states.add(stage)?;
    Ok(states.out)
}

/// The position of the other body of a distance.
fn other(stage: &Stage, quantity: &Quantity) -> Option<DVec3> {
    let Quantity::Distance(name) = quantity else { return None };
    let body = stage.sim().named(name)?;
    stage.sim().world.get::<Transform>(body).map(|transform| transform.position)
}

/// Whether forces move the body.
fn moves(stage: &Stage, thing: Entity, body: &PhysicsBody) -> bool {
    let thing = stage.sim().world.entity(thing);
    body.inverse_mass > 0.0 && !thing.contains::<Quarantined>() && !thing.contains::<Dormant>()
}

/// Forces and potential energies of bodies, by index; only those that the quantities need.
struct Caused {
    forces: Vec<Vec<(&'static str, DVec3)>>,
    energies: Vec<Vec<(&'static str, f64)>>,
}

impl Caused {
    fn of(stage: &Stage, bodies: &[Entity], quantities: &[Quantity]) -> Self {
        let mut caused = Self {
            forces: vec![Vec::new(); bodies.len()],
            energies: vec![Vec::new(); bodies.len()],
        };
        let asks = |of: &[Quantity]| quantities.iter().any(|quantity| of.contains(quantity));
        if asks(&[Quantity::Acceleration, Quantity::Force, Quantity::Forces]) {
            motion::each_force(
                &stage.sim().world,
                &stage.here().pushes(),
                bodies,
                |at, cause, newtons| {
                    caused.forces[at].push((cause.name(), newtons));
                },
            );
        }
        if asks(&[Quantity::Energies]) {
            each_potential_energy(&stage.sim().world, bodies, |at, law, joules| {
                caused.energies[at].push((law, joules));
            });
        }
        caused
    }

    /// The sum of all forces.
    fn force(&self, at: usize) -> DVec3 {
        self.forces[at].iter().map(|(_, newtons)| newtons).sum()
    }

    fn force_by(&self, at: usize, cause: &str) -> DVec3 {
        self.forces[at].iter().filter(|(by, _)| *by == cause).map(|(_, newtons)| newtons).sum()
    }

    fn energy_by(&self, at: usize, law: &str) -> f64 {
        self.energies[at]
            .iter()
            .filter(|(by, _)| *by == law)
            .fold(0.0, |sum, (_, joules)| sum + joules)
    }
}
