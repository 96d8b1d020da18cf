//! Estimates the memory that a scene takes, before any of it is allocated, and the memory that is available.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use motion::Link;
use motion::margin::Margins;

use crate::scene::coupled::EmitterSpec;
use crate::scene::{BodySpec, Reading, Scene};

/// Bytes of a body in addition to its entry in the scene: its components, in columns that may have room for twice as
/// many, and look-ups by entity and by stable id. `tests/bounds.rs` measures these bytes.
const BODY: u64 = 560;

/// Bytes of a scene and a world without bodies.
const EMPTY: u64 = 256 << 10;

/// Additional bytes of a body that moves to a table of its own, as members of groups and particles do.
const MOVED: u64 = 370;

/// Additional bytes of a particle: its launch velocity, and its life in the pool.
const PARTICLE: u64 = 700;

/// Additional bytes of a member of a group: its rows in the arrays of a step and of a forecast.
const GROUPED: u64 = 240;

/// Bytes of a spring of a soft body in addition to its entry in the scene: its place in the list that forces are
/// computed from.
const LINK: u64 = 40;

/// Bytes of a triangle of a sheet in the air.
const TRIANGLE: u64 = 220;

/// Additional bytes of a body that is written as an entry of its own, compared with a generated one.
const WRITTEN_BODY: u64 = 190;
/// Bytes of a spring in the scene and in its world.
const SPRING: [u64; 2] = [70, 350];
/// Bytes of a well in the scene and in its world.
const WELL: [u64; 2] = [80, 400];
/// Bytes of a thrust, or of the drag of a body, in the scene and in its world.
const THRUST: [u64; 2] = [130, 160];
/// Bytes of a point of the curve of a thrust in the scene and in its world.
const POINT: [u64; 2] = [50, 50];

/// Copies of each name and label.
const COPIES_OF_NAMES: u64 = 2;

/// Copies of a text while it is read: the original, one with its numbers spelled as RON has them, and that of the
/// scene.
const COPIES_OF_TEXT: u64 = 3;

/// Additional bytes of a body in a ledger: its rows at both ends of a tick, its record, and its path.
const LEDGER: u64 = 1_200;

/// Additional bytes of a body whose run is compared: its start, and its states in lists.
const COMPARED: u64 = 240;

/// Additional bytes of a body in a black box: its rows in the snapshot that is being made.
const BLACK_BOX: u64 = 300;
/// Memory limit of a timeline: the bytes of all its snapshots together.
pub const TIMELINE_BYTES: usize = 64 << 20;

/// Additional bytes of a body in pictures: its instance here and on a device in software, and its place between two
/// ticks.
const PICTURE: u64 = 1000;

/// A scene of at most that many bytes is read without a check: it fits everywhere.
const SMALL: u64 = 256 << 20;

/// The memory that the person allows, bytes.
static ALLOWED: OnceLock<u64> = OnceLock::new();

/// Limits the memory of scenes from now on; the first call decides. Without a call, the limit is the memory that is
/// free when a scene is loaded.
pub fn allow_memory(bytes: u64) {
    ALLOWED.get_or_init(|| bytes);
}

/// Counts of everything that a scene needs memory for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Census {
    pub bodies: u64,
    /// Particles on a graphics device.
    pub on_device: u64,
    /// Bodies that are members of groups, or particles.
    pub moved: u64,
    /// Bodies that are members of groups.
    pub grouped: u64,
    /// Springs of soft bodies.
    pub links: u64,
    /// Triangles of sheets that air acts on.
    pub blown: u64,
    pub springs: u64,
    pub wells: u64,
    pub drags: u64,
    pub thrusts: u64,
    /// Points of the curves of thrusts.
    pub points: u64,
}

impl Reading {
    /// Bytes that are taken only during reading, at most: a list has room for up to twice its entries.
    const fn passing(self) -> u64 {
        let text = self.text.saturating_mul(COPIES_OF_TEXT - 1);
        text.saturating_add(self.entries.saturating_mul(2)).saturating_add(self.name_bytes)
    }

    /// Bytes of the reading that the scene keeps.
    const fn kept(self) -> u64 {
        let bodies = self.bodies.saturating_mul(WRITTEN_BODY);
        self.text
            .saturating_add(bodies)
            .saturating_add(self.name_bytes.saturating_mul(COPIES_OF_NAMES))
    }
}

impl Census {
    /// The sum of two censuses.
    pub const fn and(self, other: Self) -> Self {
        Self {
            bodies: self.bodies.saturating_add(other.bodies),
            on_device: self.on_device.saturating_add(other.on_device),
            moved: self.moved.saturating_add(other.moved),
            grouped: self.grouped.saturating_add(other.grouped),
            links: self.links.saturating_add(other.links),
            blown: self.blown.saturating_add(other.blown),
            springs: self.springs.saturating_add(other.springs),
            wells: self.wells.saturating_add(other.wells),
            drags: self.drags.saturating_add(other.drags),
            thrusts: self.thrusts.saturating_add(other.thrusts),
            points: self.points.saturating_add(other.points),
        }
    }

    /// The counts of entries that are written out, with their bytes in the scene and in its world.
    const fn written(self) -> [(u64, [u64; 2]); 5] {
        let Self { springs, wells, drags, thrusts, points, .. } = self;
        [(springs, SPRING), (wells, WELL), (drags, THRUST), (thrusts, THRUST), (points, POINT)]
    }

    /// Bytes in the scene.
    fn in_scene(self) -> u64 {
        let bodies = self.bodies.saturating_mul(size_of::<BodySpec>() as u64);
        let links = self.links.saturating_mul(size_of::<Link>() as u64);
        let written =
            self.written().into_iter().map(|(count, [bytes, _])| count.saturating_mul(bytes));
        written.fold(bodies.saturating_add(links), u64::saturating_add)
    }

    /// Bytes in its world until the first tick is over, at most.
    fn in_world(self) -> u64 {
        let forecast =
            if self.springs + self.links > 0 { Margins::most_bytes(self.grouped) } else { 0 };
        let of_each = [
            self.bodies.saturating_mul(BODY),
            self.moved.saturating_mul(MOVED),
            self.grouped.saturating_mul(GROUPED),
            self.moved.saturating_sub(self.grouped).saturating_mul(PARTICLE),
            self.links.saturating_mul(LINK),
            self.blown.saturating_mul(TRIANGLE),
            self.on_device.saturating_mul(EmitterSpec::PARTICLE_ON_DEVICE),
            forecast,
        ];
        let written =
            self.written().into_iter().map(|(count, [_, bytes])| count.saturating_mul(bytes));
        of_each.into_iter().chain(written).fold(0, u64::saturating_add)
    }

    /// Most bytes of a scene with these counts, from its reading until the first tick of a run that keeps `more`
    /// bytes is over.
    pub fn bytes(self, reading: Reading, more: u64) -> u64 {
        let run = self.in_world().saturating_add(more);
        let kept = EMPTY.saturating_add(self.in_scene()).saturating_add(reading.kept());
        kept.saturating_add(reading.passing().max(run))
    }

    /// The counts in words.
    pub fn words(self) -> String {
        let counts = [
            (self.links.saturating_add(self.springs), "spring"),
            (self.wells, "well"),
            (self.thrusts, "thrust"),
            (self.points, "point of curves"),
        ];
        let mut words = vec![bodies_words(self.bodies)];
        if self.on_device > 0 {
            words.push(format!("{} particles on a graphics device", self.on_device));
        }
        for (count, what) in counts.into_iter().filter(|(count, _)| *count > 0) {
            let (first, rest) =
                what.split_once(' ').map_or((what, String::new()), |(a, b)| (a, format!(" {b}")));
            words.push(format!("{count} {first}{}{rest}", if count == 1 { "" } else { "s" }));
        }
        let last = words.pop().unwrap_or_default();
        if words.is_empty() { last } else { format!("{} and {last}", words.join(", ")) }
    }
}

/// Everything that a run keeps besides its world. Tables of states are written as they come and keep nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keeps {
    /// A ledger of energy, momentum and angular momentum.
    pub ledger: bool,
    /// States that are compared: with those of how many further runs beside it.
    pub compared: Option<u64>,
    /// The last minute, to go back in.
    pub black_box: bool,
    /// Pictures, with the bytes of the device that draws them.
    pub pictures: Option<u64>,
}

impl Keeps {
    /// Most additional bytes of a run of a scene with these bodies and particles on a device.
    fn bytes(self, census: Census) -> u64 {
        let Census { bodies, on_device, .. } = census;
        let each = |kept: bool, bytes: u64| if kept { bodies.saturating_mul(bytes) } else { 0 };
        let parts = [
            each(self.ledger, LEDGER),
            each(self.compared.is_some(), COMPARED),
            // Each has a scene of its own.
            self.compared
                .unwrap_or(0)
                .saturating_mul(census.in_world().saturating_add(census.in_scene())),
            each(self.black_box, BLACK_BOX),
            if self.black_box { TIMELINE_BYTES as u64 } else { 0 },
            if self.black_box && on_device > 0 { EmitterSpec::KEPT_ON_DEVICE } else { 0 },
            each(self.pictures.is_some(), PICTURE),
            self.pictures.unwrap_or_default(),
        ];
        parts.into_iter().fold(0, u64::saturating_add)
    }
}

/// A number of bodies, in words.
pub(crate) fn bodies_words(count: u64) -> String {
    if count == 1 { "1 body".to_owned() } else { format!("{count} bodies") }
}

impl Scene {
    /// Checks that there is enough memory for a run of the scene that keeps `keeps`.
    ///
    /// # Errors
    /// If the run takes more bytes than are allowed, or free: by how much, in words.
    pub fn check_memory(&self, keeps: Keeps) -> Result<(), String> {
        let needed = self.estimated_bytes(keeps);
        let Some((least, by_person)) = shortage(needed) else { return Ok(()) };
        let (words, needed) = (self.census().words(), byte_words(needed));
        let there = there_are(least, by_person);
        Err(format!("{words} and what the run keeps of them take about {needed}, and {there}"))
    }

    /// Most bytes of the scene and of a run that keeps `keeps`, from reading it until its first tick is over, as
    /// estimated before any body was made.
    #[must_use]
    pub fn estimated_bytes(&self, keeps: Keeps) -> u64 {
        let census = self.census();
        census.bytes(self.reading, keeps.bytes(census))
    }

    fn census(&self) -> Census {
        let bodies = self.bodies.len() as u64;
        let soft = self.soft_bodies.iter();
        let points: u64 = soft.clone().map(|soft| soft.points.len() as u64).sum();
        let links: u64 = soft.clone().map(|soft| soft.links.len() as u64).sum();
        let in_air = self.laws.drag.is_some();
        let blown =
            soft.filter(|soft| in_air && soft.sheet).map(|soft| soft.triangles.len() as u64).sum();
        let particles = self.particles_in_pools() as u64;
        let grouped = if self.mutual_gravity.is_some() { bodies - particles } else { points };
        let own = self.own_laws.values();
        let own_wells: u64 =
            own.clone().map(|laws| (laws.wells.len() + laws.riding_wells.len()) as u64).sum();
        let drags = own.clone().filter(|laws| laws.drag.is_some()).count() as u64;
        let thrusts = own.flat_map(|laws| &laws.thrusts);
        Census {
            bodies,
            on_device: self.particles_on_device() as u64,
            moved: grouped + particles,
            grouped,
            links,
            blown,
            springs: self.springs.len() as u64,
            wells: own_wells + self.laws.wells.as_ref().map_or(0, |wells| wells.0.len() as u64),
            drags,
            thrusts: (thrusts.clone().count() + self.motions.len()) as u64,
            points: thrusts.map(|thrust| thrust.curve().points() as u64).sum(),
        }
    }
}

/// Bytes that reading may take: those that are allowed, or free; a scene of less than [`SMALL`] is always read.
pub(crate) fn room() -> usize {
    let bytes = match ALLOWED.get() {
        Some(allowed) => *allowed,
        None => free().map_or(u64::MAX, |free| free.max(SMALL)),
    };
    usize::try_from(bytes).unwrap_or(usize::MAX)
}

/// How many runs of `each` bytes, at most `most`, fit into the memory beside `shared` bytes.
///
/// # Errors
/// If not one does: by how much, in words.
pub fn runs_that_fit(shared: u64, each: u64, most: usize) -> Result<usize, String> {
    let needed = |runs: u64| each.saturating_mul(runs).saturating_add(shared);
    let Some((least, by_person)) = shortage(needed(most as u64)) else { return Ok(most) };
    let fit = least.saturating_sub(shared) / each.max(1);
    let there = there_are(least, by_person);
    match usize::try_from(fit) {
        Ok(0) => Err(format!("a run takes about {}, and {there}", byte_words(needed(1)))),
        fit => Ok(most.min(fit.unwrap_or(most))),
    }
}

/// Bytes of memory for scenes: those that the person allows, or those that the machine has free; `None` if it does
/// not report them.
#[must_use]
pub fn memory() -> Option<u64> {
    ALLOWED.get().copied().or_else(free)
}

/// The allowed bytes, if they are less than `needed`, and whether the person set them.
pub(crate) fn shortage(needed: u64) -> Option<(u64, bool)> {
    let (least, by_person) = match ALLOWED.get() {
        Some(allowed) => (*allowed, true),
        None if needed <= SMALL => return None,
        None => (free()?, false),
    };
    (needed > least).then_some((least, by_person))
}

/// The available bytes, and whether the person set them, in words.
pub(crate) fn there_are(least: u64, by_person: bool) -> String {
    format!("{} are {}", byte_words(least), if by_person { "allowed" } else { "free" })
}

/// Says that the text of a scene and its entries take more memory than is available.
pub(crate) fn too_much() -> String {
    let least = shortage(u64::MAX);
    let there = least
        .map_or("no more is free".to_owned(), |(least, by_person)| there_are(least, by_person));
    format!("its text and its entries take more memory than there is, and {there}")
}

/// Bytes in words, in the largest unit that is not larger than they are.
#[must_use]
pub fn byte_words(bytes: u64) -> String {
    let units = [(30, "GiB"), (20, "MiB"), (10, "KiB")];
    match units.into_iter().find(|(power, _)| bytes >> power > 0) {
        Some((power, unit)) => format!("{:.1} {unit}", bytes as f64 / (1_u64 << power) as f64),
        None => format!("{bytes} B"),
    }
}

/// Bytes that this process can still get: the least of what the machine has, what its control groups allow and what
/// its address space has room for. `None` if the system does not say.
fn free() -> Option<u64> {
    let machine = in_file("/proc/meminfo", "MemAvailable:").map(|kib| kib.saturating_mul(1024));
    [machine, address_space(), free_in_control_groups()].into_iter().flatten().min()
}

/// Bytes for which the address space of this process has room, as `ulimit -v` sets it; `None` without a limit.
#[must_use]
pub fn address_space() -> Option<u64> {
    let most = in_file("/proc/self/limits", "Max address space")?;
    let now = in_file("/proc/self/status", "VmSize:")?.saturating_mul(1024);
    Some(most.saturating_sub(now))
}

/// The first number in the line of a file that begins with `key`.
fn in_file(path: &str, key: &str) -> Option<u64> {
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with(key))?;
    line.split_whitespace().find_map(|word| word.parse().ok())
}

/// The fewest bytes that the control groups of this process leave it, from its own up to the root; version 1 has one
/// file for all memory. Cached files count as free, because the kernel drops them before it refuses memory.
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
    let v2 = own.ancestors().take_while(|folder| folder.starts_with(root));
    let v2 = v2.filter_map(|folder| {
        left(folder, "memory.max", "memory.current", ["inactive_file", "active_file"])
    });
    let kinds = ["total_inactive_file", "total_active_file"];
    let v1 = left(&root.join("memory"), "memory.limit_in_bytes", "memory.usage_in_bytes", kinds);
    v2.chain(v1).min()
}
