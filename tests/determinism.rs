//! Equal bits: every shipped scene has one pinned hash, which every way of running it gives.

use std::fmt::Write as _;
use std::fs;
use std::process::Command;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use hashes::{BEFORE_SWITCH, Run, TICKS, fps};
use history::Simulation;
use motion::{StableId, Stepper, Threads, TimeStep, Transform};
use scene::Scene;
use tempfile::TempDir;
use xxhash_rust::xxh3::Xxh3;

use crate::rigs::{assert_stored, json, output, program, root, scene_of, world_bits};

const PINS: &str = "tests/determinism/hashes.txt";

/// Every shipped scene with its frames a second and its pinned hash.
fn pinned() -> Vec<(String, f64, u64)> {
    let text = fs::read_to_string(root().join(PINS)).unwrap();
    let line = |line: &str| {
        let [name, fps, hash] = line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
        (name.to_owned(), fps.parse().unwrap(), u64::from_str_radix(hash, 16).unwrap())
    };
    text.lines().filter(|line| !line.starts_with('#')).map(line).collect()
}

/// The state hash of the contract.
fn hash(world: &mut World) -> u64 {
    let mut hash = Xxh3::new();
    for bits in world_bits(world).into_iter().flat_map(|(_, bits)| bits) {
        hash.update(&bits.to_le_bytes());
    }
    hash.digest()
}

/// The start of a scene; `arrange` changes the world that it was spawned into, before anything is compiled.
fn start(scene: &Scene, mut world: World, arrange: impl FnOnce(&mut World)) -> Run {
    let bodies = scene.spawn(&mut world);
    arrange(&mut world);
    let stepper = Stepper::new(&mut world, scene.method, TimeStep(1.0 / scene.step_hz));
    Run::of(Simulation { scene: Arc::new(scene.clone()), world, stepper, bodies })
}

/// The state hash at the end of a run.
fn end(mut run: Run) -> u64 {
    run.ticks(0, TICKS);
    hash(&mut run.simulation.world)
}

/// Fails unless `hashed` gives the pinned hash of every shipped scene.
#[track_caller]
fn all_are_pinned(hashed: impl Fn(&Scene) -> u64) {
    let mut wrong = String::new();
    for (name, _, pinned) in pinned() {
        let found = hashed(&scene::load(&name).unwrap());
        if found != pinned {
            writeln!(wrong, "{name}: {found:016x}, pinned is {pinned:016x}").unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn every_shipped_scene_has_its_pinned_hash() {
    let mut text = format!(
        "# Scene, frames a second, state hash after {TICKS} ticks, gravity switched after {BEFORE_SWITCH}. UPDATE_EXPECT=1 writes it.\n"
    );
    for shipped in scene::shipped() {
        let scene = shipped.load().unwrap();
        let (fps, found) = (fps(&scene), end(start(&scene, World::new(), |_| {})));
        writeln!(text, "{} {fps} {found:016x}", shipped.name).unwrap();
    }
    assert_stored(PINS, &text);
}

/// `scripts/hashes` compares the same list on other processors.
#[test]
fn every_scene_has_its_pinned_hash_by_every_method() {
    assert_stored("tests/determinism/methods.txt", &hashes::hashes());
}

#[test]
fn chaos_is_chaotic() {
    let scene = hashes::scenes().find(|scene| scene.name == "chaos").unwrap();
    let mut runs = [0.0, 1e-9].map(|off| {
        start(&scene, World::new(), |world| {
            let (_, mut first) = world
                .query::<(&StableId, &mut Transform)>()
                .iter_mut(world)
                .find(|(id, _)| id.0 == 1)
                .unwrap();
            first.position.x += off;
        })
    });
    let distance = |runs: &mut [Run; 2]| {
        let [a, b] = runs
            .each_ref()
            .map(|run| run.simulation.states().map(|state| state.1).collect::<Vec<_>>());
        a.into_iter().zip(b).map(|(a, b)| (a - b).length()).fold(0.0, f64::max)
    };
    runs.iter_mut().for_each(|run| run.ticks(0, TICKS));
    let off = distance(&mut runs);
    assert!(off > 1e-5, "{off:e}");
}

#[test]
fn the_program_gives_the_pinned_hashes() {
    let folder = TempDir::new().unwrap();
    let summary = folder.path().join("summary.json");
    all_are_pinned(|scene| {
        let script = root().join("tests/determinism/script.ron");
        let line =
            ["run", &scene.name, "--ticks", &TICKS.to_string(), "--fps", &fps(scene).to_string()];
        let mut program = Command::new(program());
        program.args(line).arg("--script").arg(script).arg("--summary").arg(&summary);
        output(&mut program).fine();
        u64::from_str_radix(json(&summary)["state_hash"].as_str().unwrap(), 16).unwrap()
    });
}

/// State hash of the crowd below.
const CROWD: u64 = 0xb36a_ad57_e0de_1c65;

#[test]
fn two_threads_give_the_pinned_hashes() {
    all_are_pinned(|scene| {
        end(start(scene, World::new(), |world| world.insert_resource(Threads::new(2))))
    });
}

/// Of the shipped scenes, only `sparks` has enough bodies for threads to share them.
#[test]
fn any_number_of_threads_hashes_a_crowd_alike() {
    let count = Threads::FROM + 777;
    let scene = scene_of(&format!(
        "(version: 1, gravity: (acceleration_m_s2: (0.0, -9.8, 0.0)), drag: (quadratic_per_m: 0.05), clouds: \
             [(count: {count}, center_m: (0.0, 50.0, 0.0), half_extents_m: (10.0, 10.0, 10.0), speed_m_s: 1.0)])"
    ));
    for threads in [1, 2, 4] {
        let mut run =
            start(&scene, World::new(), |world| world.insert_resource(Threads::new(threads)));
        run.ticks(0, 12);
        let hash = hash(&mut run.simulation.world);
        assert_eq!(hash, CROWD, "{threads} threads: {hash:016x}");
    }
}

#[test]
fn runs_that_are_saved_and_loaded_give_the_pinned_hashes() {
    for at in [1, BEFORE_SWITCH - 1, BEFORE_SWITCH, 177] {
        all_are_pinned(|scene| {
            let mut run = start(scene, World::new(), |_| {});
            run.ticks(0, at);
            let snapshot = run.simulation.snapshot();
            run.simulation = Simulation::restore(scene.clone(), &snapshot).unwrap();
            run.ticks(at, TICKS);
            hash(&mut run.simulation.world)
        });
    }
}

/// Moves rows of tables.
#[derive(Component)]
struct Elsewhere;

/// Numbers without a pattern (Knuth, MMIX).
fn shuffled<T>(mut things: Vec<T>, seed: u64) -> Vec<T> {
    let mut state = seed;
    for last in (1..things.len()).rev() {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        things.swap(last, (state >> 33) as usize % (last + 1));
    }
    things
}

/// A world in which the next entities get numbers in no order.
fn world_of_old_numbers() -> World {
    let mut world = World::new();
    let entities: Vec<_> = (0..3000).map(|_| world.spawn_empty().id()).collect();
    for entity in shuffled(entities, 1) {
        world.despawn(entity);
    }
    world
}

/// Takes everything out of its table and back again in another order: the last rows come first.
fn mix_rows(world: &mut World) {
    let all: Vec<_> = world.query::<Entity>().iter(world).collect();
    for entity in shuffled(all.clone(), 2) {
        world.entity_mut(entity).insert(Elsewhere);
    }
    for entity in shuffled(all, 3) {
        world.entity_mut(entity).remove::<Elsewhere>();
    }
}

#[test]
fn entities_in_any_order_give_the_pinned_hashes() {
    let rows = |world: &mut World| {
        world.query::<&StableId>().iter(world).map(|id| id.0).collect::<Vec<_>>()
    };
    let mut world = world_of_old_numbers();
    let entities = scene::load("rope").unwrap().spawn(&mut world);
    assert!(!entities.is_sorted(), "the numbers are in order: this test tests nothing");
    mix_rows(&mut world);
    assert!(!rows(&mut world).is_sorted(), "the rows are in order: this test tests nothing");
    all_are_pinned(|scene| end(start(scene, world_of_old_numbers(), mix_rows)));
}
