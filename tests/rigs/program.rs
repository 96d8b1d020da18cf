//! A world of bodies that is stepped and looked at: the `check` of these tests.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{
    Damping, Elastic, Evaluations, Gravity, Method, PhysicsBody, PushQueue, Quarantine, QuarantineRecord,
    Quarantined, Request, Requests, Spring, StableId, Stepper, TimeStep, Totals, Transform, totals,
};
use process_control::{ChildExt as _, Control as _};
use scene::Scene;
use tempfile::TempDir;

use crate::rigs::Start;

/// The tutorial's tick, s.
pub const H: f64 = 1.0 / 120.0;

/// Gravity of the tutorial, m/s².
pub const G: f64 = -9.8;

/// Position and velocity of a body, bit for bit.
pub type Bits = [u64; 6];

pub fn bits(x: Vector, v: Vector) -> Bits {
    [x.x, x.y, x.z, v.x, v.y, v.z].map(f64::to_bits)
}

/// The same of every body of `states`, as [`Simulation::states`](history::Simulation::states) gives them.
pub fn all_bits(states: impl IntoIterator<Item = (u32, Vector, Vector)>) -> Vec<(u32, Bits)> {
    states.into_iter().map(|(id, x, v)| (id, bits(x, v))).collect()
}

/// The same of every body with physics in `world`, in stable-id order.
pub fn world_bits(world: &mut World) -> Vec<(u32, Bits)> {
    let mut bodies = world.query::<(&StableId, &Transform, &PhysicsBody)>();
    let mut all = all_bits(bodies.iter(world).map(|(id, at, body)| (id.0, at.position, body.velocity)));
    all.sort_unstable();
    all
}

/// A world that is built by hand and its stepper, its bodies and springs in the order that they came in.
pub struct Lab {
    pub world: World,
    pub stepper: Stepper,
    pub bodies: Vec<Entity>,
    pub springs: Vec<Entity>,
}

/// A body of a [`Lab`]: itself, or its place among the bodies.
pub trait Which {
    fn of(self, lab: &Lab) -> Entity;
}

impl Which for Entity {
    fn of(self, _: &Lab) -> Entity {
        self
    }
}

impl Which for usize {
    fn of(self, lab: &Lab) -> Entity {
        lab.bodies[self]
    }
}

impl Lab {
    pub fn new(method: Method, h: f64) -> Self {
        Self::of(World::new(), method, h)
    }

    /// With what is in `world` already.
    pub fn of(mut world: World, method: Method, h: f64) -> Self {
        let stepper = Stepper::new(&mut world, method, TimeStep(h));
        Self { world, stepper, bodies: Vec::new(), springs: Vec::new() }
    }

    pub fn tutorial() -> Self {
        Self::new(Method::SemiImplicitEuler, H).with_gravity().with(Damping::TUTORIAL)
    }

    pub fn with_gravity(self) -> Self {
        self.with(Gravity::EARTH)
    }

    pub fn with(mut self, resource: impl Resource) -> Self {
        self.world.insert_resource(resource);
        self
    }

    pub fn spawn(&mut self, start: Start) -> Entity {
        let body = self.world.spawn(start.components()).id();
        self.bodies.push(body);
        body
    }

    /// A body of that inverse mass at a height of 10 m.
    pub fn body(&mut self, inverse_mass: f64, velocity: Vector) -> Entity {
        self.spawn(Start { x: Vector::Y * 10.0, v: velocity, w: inverse_mass })
    }

    pub fn spring<T: Which>(&mut self, ends: [T; 2], elastic: Elastic) -> Entity {
        let ends = ends.map(|end| end.of(self));
        let spring = self.world.spawn(Spring { ends, elastic }).id();
        self.springs.push(spring);
        spring
    }

    pub fn insert(&mut self, body: impl Which, components: impl Bundle) {
        let body = body.of(self);
        self.world.entity_mut(body).insert(components);
    }

    pub fn recompile(&mut self) -> &mut Self {
        self.stepper.recompile(&mut self.world);
        self
    }

    pub fn push(&mut self, body: impl Which, newtons: Vector) -> &mut Self {
        let body = body.of(self);
        self.world.resource_mut::<PushQueue>().push_once(body, newtons);
        self
    }

    pub fn ask(&mut self, request: Request) -> &mut Self {
        self.world.resource_mut::<Requests>().ask(request);
        self
    }

    /// Asks and has it carried out, without a tick.
    pub fn have(&mut self, request: Request) {
        self.ask(request);
        self.stepper.carry_out_requests(&mut self.world);
    }

    pub fn set_method(&mut self, method: Method) {
        self.stepper.set_method(&mut self.world, method);
    }

    pub fn run(&mut self, ticks: u64) -> &mut Self {
        (0..ticks).for_each(|_| self.stepper.tick(&mut self.world));
        self
    }

    pub fn x(&self, body: impl Which) -> Vector {
        self.world.get::<Transform>(body.of(self)).unwrap().position
    }

    pub fn v(&self, body: impl Which) -> Vector {
        self.world.get::<PhysicsBody>(body.of(self)).unwrap().velocity
    }

    /// Position and velocity.
    pub fn state(&self, body: impl Which + Copy) -> (Vector, Vector) {
        (self.x(body), self.v(body))
    }

    pub fn states(&self) -> Vec<(Vector, Vector)> {
        self.bodies.iter().map(|body| self.state(*body)).collect()
    }

    pub fn bits(&self, body: impl Which + Copy) -> Bits {
        bits(self.x(body), self.v(body))
    }

    /// Bits of all bodies but some.
    pub fn all_bits(&self, but: &[usize]) -> Vec<Bits> {
        (0..self.bodies.len()).filter(|body| !but.contains(body)).map(|body| self.bits(body)).collect()
    }

    pub fn is_quarantined(&self, body: impl Which) -> bool {
        self.world.get::<Quarantined>(body.of(self)).is_some()
    }

    /// Records of the bodies that were quarantined, in the order of events.
    pub fn records(&self) -> &[QuarantineRecord] {
        self.world.resource::<Quarantine>().records()
    }

    pub fn evaluations(&self) -> &Evaluations {
        self.world.resource()
    }

    /// Evaluations of accelerations, in all and by law.
    pub fn counts(&self) -> (u64, Vec<(&'static str, u64)>) {
        let mut laws = self.evaluations().laws().to_vec();
        laws.sort_unstable();
        (self.evaluations().accelerations(), laws)
    }

    pub fn totals(&mut self) -> Totals {
        totals(&mut self.world)
    }

    /// Kinetic and potential energy, J.
    pub fn energy(&mut self) -> f64 {
        let sum = self.totals();
        sum.kinetic_energy + sum.potential_energy
    }
}

/// Fails unless `actual` is within `relative` of `expected`.
#[track_caller]
pub fn close(actual: f64, expected: f64, relative: f64) {
    let error = (actual - expected).abs();
    assert!(
        error <= relative * expected.abs(),
        "{actual} is not {expected} (error {error:e}, allowed {relative:e})"
    );
}

/// Fails unless `actual` rounds to the digits of `expected`.
#[track_caller]
pub fn digits(actual: f64, expected: &str) {
    let decimals = expected.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    assert_eq!(format!("{actual:.decimals$}"), expected);
}

/// The program, built beside these tests.
///
/// # Panics
/// When it is not there: say how to build it.
pub fn program() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    let program =
        tests.parent().unwrap().parent().unwrap().join(format!("sandbox{}", std::env::consts::EXE_SUFFIX));
    assert!(program.exists(), "{} is missing; build it with `cargo build -p sandbox`", program.display());
    program
}

/// Longest that a test waits for a program, many times what any of them takes.
const DEADLINE: Duration = Duration::from_secs(600);

/// What a program said: exit code, or -1 if a signal ended it, standard output and standard error.
#[derive(Debug)]
pub struct Said {
    pub command: String,
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// Runs `command`, which reads nothing, to its end.
///
/// # Panics
/// When it does not end by itself: it is killed.
#[track_caller]
pub fn output(command: &mut Command) -> Said {
    output_within(DEADLINE, command)
}

/// Runs `command` for at most `deadline`: see [`output`].
#[track_caller]
fn output_within(deadline: Duration, command: &mut Command) -> Said {
    let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let child = child.unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let ended = child.controlled_with_output().time_limit(deadline).terminate_for_timeout().wait().unwrap();
    let ended =
        ended.unwrap_or_else(|| panic!("{command:?} did not end within {deadline:?}")).into_std_lossy();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let code = ended.status.code().unwrap_or(-1);
    Said { command: format!("{command:?}"), code, out: text(ended.stdout), err: text(ended.stderr) }
}

/// Looks again and again until there is something.
///
/// # Panics
/// When it does not come.
#[track_caller]
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < DEADLINE, "gave up waiting for {what}");
        sleep(Duration::from_millis(20));
    }
}

/// Runs `sandbox line` in `folder`: see [`output`].
#[track_caller]
pub fn sandbox(folder: impl AsRef<Path>, line: &str) -> Said {
    output(Command::new(program()).args(line.split_whitespace()).current_dir(folder.as_ref()))
}

/// Runs `sandbox line` in a folder with these files: what it said, and the summary that it wrote, or null.
#[track_caller]
pub fn summarized<'a>(
    files: impl IntoIterator<Item = (&'a str, impl AsRef<[u8]>)>,
    line: &str,
) -> (Said, serde_json::Value) {
    let folder = folder(files);
    let said = sandbox(&folder, &format!("{line} --summary summary.json"));
    let summary = std::fs::read(folder.path().join("summary.json")).unwrap_or_default();
    (said, serde_json::from_slice(&summary).unwrap_or_default())
}

impl Said {
    /// For messages of tests.
    pub fn all(&self) -> String {
        let Self { command, code, out, err } = self;
        format!("{command} ended with {code}\n{out}{err}")
    }

    /// The same, of a program that must have ended with that exit code.
    #[track_caller]
    pub fn ends(self, code: i32) -> Self {
        assert_eq!(self.code, code, "{}", self.all());
        self
    }

    /// Fails unless the program ended with that exit code and said exactly `err` on standard error.
    #[track_caller]
    pub fn says(&self, code: i32, err: &str) {
        assert_eq!((self.code, self.err.as_str()), (code, err), "{}", self.all());
    }

    /// What was printed, by a program that must have succeeded.
    #[track_caller]
    pub fn fine(self) -> String {
        self.ends(0).out
    }

    /// Fails unless the program ended with that exit code and said `words`, among others, on standard error.
    #[track_caller]
    pub fn warns(&self, code: i32, words: &str) {
        let said = self.code == code && self.err.contains(words);
        assert!(said, "not {code} with {words:?}: {}", self.all());
    }

    /// The same, and fails if it printed results.
    #[track_caller]
    pub fn fails(&self, code: i32, words: &str) {
        self.warns(code, words);
        assert_eq!(self.out, "", "{}", self.command);
    }
}

/// A folder with these files.
pub fn folder<'a>(files: impl IntoIterator<Item = (&'a str, impl AsRef<[u8]>)>) -> TempDir {
    let folder = TempDir::new().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

/// The scene that `text` describes.
///
/// # Panics
/// When it describes none.
#[track_caller]
pub fn scene_of(text: &str) -> Scene {
    Scene::parse("test", text).unwrap_or_else(|error| panic!("{error}"))
}

/// The JSON in a file.
#[track_caller]
pub fn json(path: impl AsRef<Path>) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
#[cfg(unix)]
#[should_panic = "did not end within"]
fn a_program_that_waits_for_ever_is_ended() {
    output_within(Duration::from_millis(50), Command::new("tail").args(["-f", "/dev/null"]));
}

/// Whether this run writes what other runs compare with.
pub fn blesses() -> bool {
    std::env::var("BLESS").is_ok_and(|value| value == "1")
}

/// Why `text` is not what is stored at `path`. To `bless` stores it, which is no success: what a run wrote itself proves
/// nothing.
pub fn stored(path: &Path, text: &str, bless: bool) -> Result<(), String> {
    let path_shown = path.display();
    if bless {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
        return Err(format!(
            "{path_shown} is written: look at the difference, and run again without BLESS\n"
        ));
    }
    let golden = std::fs::read_to_string(path).unwrap_or_default();
    if golden == text {
        return Ok(());
    }
    Err(format!("{path_shown}: BLESS=1 writes it anew\nwas\n{golden}\nis\n{text}\n"))
}

/// Root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}
