//! The memory that a scene takes, estimated before any of it is allocated, and what there is.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use motion::Link;
use motion::forecast::Forecast;

use crate::scene::{BodySpec, Scene};

/// Bytes of a body beside its entry in the scene: its components, in columns that may have room for twice as many, and
/// look-ups by entity and by stable id. `tests/bounds.rs` measures what these come to.
const BODY: u64 = 450;

/// What a body takes besides that moves to a table of its own, as members of groups and particles do.
const MOVED: u64 = 250;

/// What a particle takes besides: its emitter's throw, and its life in the pool.
const PARTICLE: u64 = 380;

/// What a member of a group takes besides: its rows in the arrays of a step and of a forecast.
const GROUPED: u64 = 310;

/// Bytes of a spring beside its entry in the scene: its place in the list that forces are computed from.
const SPRING: u64 = 40;

/// What a body takes besides in a ledger: its rows at both ends of a tick, its record, and its path.
const LEDGER: u64 = 900;

/// What a body takes besides in a black box: its rows in the snapshot that is made. And what snapshots take at most together.
const BLACK_BOX: u64 = 300;
const TIMELINE: u64 = 64 << 20;

/// What a body takes besides in pictures: its instance here and on a device in software, and its place between two ticks.
const PICTURE: u64 = 1000;

/// What is not asked about: a scene of less fits everywhere.
const SMALL: u64 = 256 << 20;

/// What the person allows, bytes.
static ALLOWED: OnceLock<u64> = OnceLock::new();

/// Lets no scene from now on take more than so many bytes; the first call decides. Without one it is what the machine has
/// free when a scene is loaded.
pub fn allow_memory(bytes: u64) {
    ALLOWED.get_or_init(|| bytes);
}

/// What there is to find room for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Census {
    pub bodies: u64,
    /// Those of them that are members of groups, or particles.
    pub moved: u64,
    /// Those of them that are members of groups.
    pub grouped: u64,
    pub springs: u64,
}

impl Census {
    /// The sum of two censuses.
    pub const fn and(self, other: Self) -> Self {
        Self {
            bodies: self.bodies.saturating_add(other.bodies),
            moved: self.moved.saturating_add(other.moved),
            grouped: self.grouped.saturating_add(other.grouped),
            springs: self.springs.saturating_add(other.springs),
        }
    }

    /// Bytes that it takes at most until the first tick is over.
    pub fn bytes(self) -> u64 {
        let forecast = if self.springs > 0 { Forecast::most_bytes(self.grouped) } else { 0 };
        [
            self.bodies.saturating_mul(BODY + size_of::<BodySpec>() as u64),
            self.moved.saturating_mul(MOVED),
            self.grouped.saturating_mul(GROUPED),
            self.moved.saturating_sub(self.grouped).saturating_mul(PARTICLE),
            self.springs.saturating_mul(SPRING + size_of::<Link>() as u64),
            forecast,
        ]
        .into_iter()
        .fold(0, u64::saturating_add)
    }
}

/// What a run keeps besides its world. Tables of states are written as they come and keep nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keeps {
    /// A ledger of energy and momentum.
    pub ledger: bool,
    /// The last minute, to go back in.
    pub black_box: bool,
    /// Pictures, with the bytes of the device that draws them.
    pub pictures: Option<u64>,
}

impl Keeps {
    /// Bytes on top for a scene of so many bodies, at most.
    fn bytes(self, bodies: u64) -> u64 {
        let each = |kept: bool, bytes: u64| if kept { bodies.saturating_mul(bytes) } else { 0 };
        let parts = [
            each(self.ledger, LEDGER),
            each(self.black_box, BLACK_BOX),
            if self.black_box { TIMELINE } else { 0 },
            each(self.pictures.is_some(), PICTURE),
            self.pictures.unwrap_or_default(),
        ];
        parts.into_iter().fold(0, u64::saturating_add)
    }
}

/// So many bodies, in words.
pub(crate) fn bodies_words(count: u64) -> String {
    if count == 1 { "1 body".to_owned() } else { format!("{count} bodies") }
}

impl Scene {
    /// Says by how much a run of the scene that keeps all that exceeds what there is, if it does.
    ///
    /// # Errors
    /// Where it takes more bytes than are allowed, or free.
    pub fn check_memory(&self, keeps: Keeps) -> Result<(), String> {
        let bodies = self.bodies.len() as u64;
        let needed = self.estimated_bytes(keeps);
        let Some((least, by_person)) = too_little_for(needed) else { return Ok(()) };
        let have = if by_person { "are allowed" } else { "are free" };
        let (needed, least) = (byte_words(needed), byte_words(least));
        let bodies = bodies_words(bodies);
        Err(format!("{bodies} and what the run keeps of them take some {needed}, and {least} {have}"))
    }

    /// Bytes that a run of the scene that keeps all that takes at most until its first tick is over: as estimated before any
    /// body was made.
    #[must_use]
    pub fn estimated_bytes(&self, keeps: Keeps) -> u64 {
        let bodies = self.bodies.len() as u64;
        let soft = self.soft_bodies.iter();
        let points: u64 = soft.clone().map(|soft| soft.points.len() as u64).sum();
        let links: u64 = soft.map(|soft| soft.links.len() as u64).sum();
        let particles: u64 = self.emitters.iter().map(|emitter| emitter.pool.len() as u64).sum();
        let grouped = if self.mutual_gravity.is_some() { bodies - particles } else { points };
        let springs = links + self.springs.len() as u64;
        let census = Census { bodies, moved: grouped + particles, grouped, springs };
        census.bytes().saturating_add(keeps.bytes(bodies))
    }
}

/// Bytes of memory for scenes: those that the person allows, or those that the machine has free; `None` if it does
/// not report them.
#[must_use]
pub fn memory() -> Option<u64> {
    ALLOWED.get().copied().or_else(free)
}

/// The allowed bytes, if they are less than `needed`, and whether the person set them.
pub(crate) fn too_little_for(needed: u64) -> Option<(u64, bool)> {
    let (least, by_person) = match ALLOWED.get() {
        Some(allowed) => (*allowed, true),
        None if needed <= SMALL => return None,
        None => (free()?, false),
    };
    (needed > least).then_some((least, by_person))
}

/// Bytes in the largest unit of which there is one.
#[must_use]
pub fn byte_words(bytes: u64) -> String {
    let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    match units.into_iter().find(|(power, _)| bytes >> power > 0) {
        Some((power, unit)) => format!("{:.1} {unit}", bytes as f64 / (1_u64 << power) as f64),
        None => format!("{bytes} B"),
    }
}

/// Bytes that this process can still have: the least of what the machine has, what its control groups leave it and
/// what its address space has room for. `None` where the system does not say.
fn free() -> Option<u64> {
    let number = |line: &str| line.split_whitespace().find_map(|word| word.parse::<u64>().ok());
    let of_file = |path: &str, key: &str| {
        let text = fs::read_to_string(path).ok()?;
        text.lines().find(|line| line.starts_with(key)).and_then(number)
    };
    let kib = |path: &str, key: &str| of_file(path, key).map(|kib| kib.saturating_mul(1024));
    let machine = kib("/proc/meminfo", "MemAvailable:");
    let limit = of_file("/proc/self/limits", "Max address space");
    let space = limit.zip(kib("/proc/self/status", "VmSize:")).map(|(most, now)| most.saturating_sub(now));
    [machine, space, free_in_control_groups()].into_iter().flatten().min()
}

/// The least that the control groups of this process leave it, from its own up to the root; those of version 1 have one
/// file for all of memory. The kernel takes the cache of files back before it refuses anything.
fn free_in_control_groups() -> Option<u64> {
    let number = |path: &Path| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let cached = |folder: &Path, kinds: [&str; 2]| -> u64 {
        let text = fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
        let lines = text.lines().filter_map(|line| line.split_once(' '));
        lines
            .filter(|(kind, _)| kinds.contains(kind))
            .filter_map(|(_, bytes)| bytes.parse::<u64>().ok())
            .sum()
    };
    let left = |folder: &Path, most: &str, now: &str, kinds| {
        let used = number(&folder.join(now))?.saturating_sub(cached(folder, kinds));
        Some(number(&folder.join(most))?.saturating_sub(used))
    };
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/")).unwrap_or_default();
    let root = Path::new("/sys/fs/cgroup");
    let own = root.join(own);
    let second = own.ancestors().take_while(|folder| folder.starts_with(root));
    let second = second
        .filter_map(|folder| left(folder, "memory.max", "memory.current", ["inactive_file", "active_file"]));
    let kinds = ["total_inactive_file", "total_active_file"];
    let first = left(&root.join("memory"), "memory.limit_in_bytes", "memory.usage_in_bytes", kinds);
    second.chain(first).min()
}
