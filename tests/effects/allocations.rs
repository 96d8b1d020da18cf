//! A running step allocates nothing.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use bevy_ecs::prelude::*;
use motion::effects::Effect;
use motion::internals::Solver;
use motion::{Method, PushQueue};

use super::{COUPLED, LOCAL, lab_of, world_of};
use crate::rigs::{H, Lab};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
    /// Bytes that this thread has asked for and not given back, and the most that it ever had.
    static HELD: Cell<[i64; 2]> = const { Cell::new([0; 2]) };
}

/// The system's allocator; counts for each thread how often it was asked for memory, and how much.
struct Counting;

impl Counting {
    fn count(gained: usize, lost: usize) {
        let [held, most] = HELD.get();
        let held = held + gained as i64 - lost as i64;
        HELD.set([held, most.max(held)]);
        ALLOCATIONS.set(ALLOCATIONS.get() + u64::from(gained > 0));
    }
}

/// The most bytes that this thread holds at once during `work`, beyond what it holds before.
pub(crate) fn most_held(work: impl FnOnce()) -> u64 {
    let [before, _] = HELD.get();
    HELD.set([before; 2]);
    work();
    u64::try_from(HELD.get()[1] - before).unwrap()
}

#[allow(
    unsafe_code,
    reason = "an allocator is unsafe by nature; this one only counts and hands on"
)]
// SAFETY: every call reaches the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Self::count(layout.size(), 0);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        Self::count(0, layout.size());
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        Self::count(layout.size(), 0);
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        Self::count(size, layout.size());
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How often this thread asks for memory in `ticks` ticks.
fn allocations(lab: &mut Lab, ticks: u64) -> u64 {
    let before = ALLOCATIONS.get();
    for _ in 0..ticks {
        lab.run(1);
        // A world remembers components that were removed, as births do, until then.
        lab.world.clear_trackers();
    }
    ALLOCATIONS.get() - before
}

#[test]
fn the_counter_counts() {
    let before = ALLOCATIONS.get();
    drop(std::hint::black_box(vec![1_u8; 100]));
    assert_eq!(ALLOCATIONS.get() - before, 1);
}

#[test]
fn no_shipped_scene_allocates_in_a_steady_tick() {
    for shipped in scene::shipped() {
        let scene = shipped.load().unwrap();
        let mut world = World::new();
        scene.spawn(&mut world);
        let mut lab = Lab::of(world, scene.method, 1.0 / scene.step_hz);
        // Long enough for every slot of an emitter to have lived.
        allocations(&mut lab, 600);
        assert_eq!(allocations(&mut lab, 50), 0, "{}", shipped.name);
    }
}

/// Pushes every body in every tick.
fn push_all(world: &mut World) {
    let bodies: Vec<_> =
        world.query_filtered::<Entity, With<motion::PhysicsBody>>().iter(world).collect();
    let pushes = bodies.iter().map(|body| motion::Push { body: *body, newtons: glam::DVec3::X });
    world.resource_mut::<PushQueue>().sustain(pushes);
}

#[test]
fn no_effect_and_no_method_allocates_in_a_steady_tick() {
    for method in Method::ALL {
        let mut lab = lab_of(&LOCAL, method);
        push_all(&mut lab.world);
        allocations(&mut lab, 100);
        assert_eq!(allocations(&mut lab, 100), 0, "{}", method.name());
    }
}

#[test]
fn groups_allocate_nothing_in_a_steady_tick() {
    for method in Method::ALL {
        for newton_iterations in [0, 2] {
            let mut world = world_of(&[&LOCAL[..], &COUPLED].concat());
            world.insert_resource(Solver { newton_iterations, ..Solver::default() });
            world.insert_resource(motion::Substeps(3));
            let mut lab = Lab::of(world, method, H);
            push_all(&mut lab.world);
            allocations(&mut lab, 100);
            assert_eq!(allocations(&mut lab, 100), 0, "{}", method.name());
        }
    }
}

/// Masses on springs of different stiffness to posts, of which one moves, all pushed.
fn posts(method: Method) -> Lab {
    let mut world = World::new();
    world.insert_resource(motion::Gravity::EARTH);
    for number in 0..40_u32 {
        let at = glam::DVec3::X * f64::from(number);
        let velocity = if number == 7 { glam::DVec3::Y } else { glam::DVec3::ZERO };
        let post = motion::PhysicsBody { velocity, inverse_mass: 0.0 };
        let post =
            world.spawn((motion::StableId(2 * number), motion::Transform::at(at), post)).id();
        let below = motion::Transform::at(at - glam::DVec3::Y);
        let id = motion::StableId(2 * number + 1);
        let mass = world.spawn((id, below, motion::PhysicsBody::with_mass(1.0))).id();
        let elastic = motion::Elastic::new(40.0 + f64::from(number), 1.0);
        world.spawn(motion::Spring { ends: [post, mass], elastic });
    }
    let mut lab = Lab::of(world, method, H);
    push_all(&mut lab.world);
    lab
}

#[test]
fn groups_side_by_side_allocate_nothing_in_a_steady_tick() {
    for method in Method::ALL {
        let mut lab = posts(method);
        lab.run(20);
        assert_eq!(lab.world.resource::<motion::internals::Groups>().side_by_side(), 40);
        assert_eq!(allocations(&mut lab, 50), 0, "{}", method.name());
    }
}

#[test]
fn substeps_and_a_large_world_allocate_no_more() {
    let mut world = world_of(&[Effect::Gravity, Effect::Wells, Effect::Thrusts]);
    world.insert_resource(motion::Substeps(50));
    let mut lab = Lab::of(world, Method::RungeKutta4, H);
    allocations(&mut lab, 30);
    assert_eq!(allocations(&mut lab, 30), 0);
}

#[test]
fn effects_that_nobody_declares_have_no_resource_no_column_and_no_system() {
    let mut lab = lab_of(&[], Method::SemiImplicitEuler);
    allocations(&mut lab, 20);
    assert_eq!(allocations(&mut lab, 50), 0);
    let names = [
        "apply_forces",
        "integrate_acceleration",
        "integrate_velocity",
        "clear_forces",
        "quarantine_bodies",
    ];
    assert_eq!(lab.stepper.systems(), names);
    let world = &mut lab.world;
    assert!(
        !world.contains_resource::<motion::Gravity>()
            && !world.contains_resource::<motion::Damping>()
    );
    assert!(
        !world.contains_resource::<motion::Drag>() && !world.contains_resource::<motion::Wells>()
    );
    assert!(!world.contains_resource::<motion::internals::Groups>());
    let absent = [
        world.register_component::<motion::OwnLaws>(),
        world.register_component::<motion::SpeedLimit>(),
        world.register_component::<motion::AxisLocks>(),
        world.register_component::<motion::DampingRate>(),
        world.register_component::<motion::Emission>(),
        world.register_component::<motion::snapshot::LastStep>(),
        world.register_component::<motion::snapshot::LastAcceleration>(),
    ];
    for kind in world.archetypes().iter() {
        assert!(absent.iter().all(|component| !kind.contains(*component)));
    }
}
