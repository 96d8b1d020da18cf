//! Drawing in Bevy: what `InertiaPlugin::with_drawing` moves, when and where, beside closed forms.

use std::time::Duration;

use bevy_app::prelude::*;
use bevy_ecs::prelude::*;
use bevy_reflect::PartialReflect;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy, Virtual};
use bevy_transform::TransformPlugin;
use motion::clock::StepClock;
use motion::{FloatingOrigin, InertiaPlugin, StepSystems, TimeStep};
// Both bring what they have; `Transform` is Bevy's.
use bevy_transform::prelude::*;
use motion::prelude::*;

const FRAME_MS: u64 = 30;

/// An app with frames of 30 ms and a body at `x` that moves at 1 m/s.
fn app(plugin: InertiaPlugin, x: f64) -> (App, Entity) {
    let mut app = App::new();
    app.add_plugins((TimePlugin, TransformPlugin, plugin))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(FRAME_MS)));
    let body = app.world_mut().spawn(moving(x)).id();
    (app, body)
}

fn moving(x: f64) -> impl Bundle {
    let body = PhysicsBody::with_mass(1.0).moving_at(Vector::X);
    (motion::Transform::at(Vector::X * x), body, Transform::default())
}

/// Where the body is drawn, m.
fn drawn(app: &App, body: Entity) -> f32 {
    app.world().get::<GlobalTransform>(body).unwrap().translation().x
}

fn seconds(app: &App) -> f64 {
    app.world().resource::<Time<Virtual>>().elapsed_secs_f64()
}

#[test]
fn a_body_is_drawn_one_tick_behind_the_time_of_the_frame() {
    for method in Method::ALL {
        let plugin = InertiaPlugin::default().with_method(method).with_hz(10.0).with_drawing();
        let (mut app, body) = app(plugin, 0.0);
        for _ in 0..100 {
            app.update();
            let expected = (seconds(&app) - 0.1).max(0.0) as f32;
            assert!((drawn(&app, body) - expected).abs() < 1e-6, "{method:?}");
        }
        // Frames were not ticks: 2.97 s at 10 Hz.
        assert_eq!(app.world().resource::<StepClock>().ticks(), 29);
    }
}

#[test]
fn far_from_the_origin_bodies_are_drawn_around_the_floating_one() {
    let (mut app, body) = app(InertiaPlugin::default().with_hz(100.0).with_drawing(), 1e9 + 0.25);
    app.insert_resource(FloatingOrigin(Vector::X * 1e9));
    (0..11).for_each(|_| app.update());
    // The first frame has no length.
    let expected = (0.25 + seconds(&app) - 0.01) as f32;
    assert!((drawn(&app, body) - expected).abs() < 1e-6);
}

#[test]
fn a_paused_body_stands_still_and_a_moved_one_is_not_drawn_on_its_way() {
    #[derive(Resource)]
    struct Paused(bool);
    let (mut app, body) = app(InertiaPlugin::default().with_hz(10.0).with_drawing(), 0.0);
    app.insert_resource(Paused(false))
        .configure_sets(FixedUpdate, StepSystems::Tick.run_if(|paused: Res<Paused>| !paused.0));
    (0..20).for_each(|_| app.update());
    app.insert_resource(Paused(true));
    (0..4).for_each(|_| app.update());
    let still = drawn(&app, body);
    for _ in 0..10 {
        app.update();
        assert_eq!(drawn(&app, body), still);
    }
    app.insert_resource(Paused(false));
    app.world_mut().get_mut::<motion::Transform>(body).unwrap().position.x = 500.0;
    app.world_mut().entity_mut(body).remove::<motion::PreviousPosition>();
    app.update();
    assert!(drawn(&app, body) >= 500.0);
}

#[test]
fn a_body_is_in_place_in_the_frame_in_which_it_is_spawned() {
    let (mut app, _) = app(InertiaPlugin::default().with_drawing(), 0.0);
    app.add_systems(Update, |mut commands: Commands, bodies: Query<&PhysicsBody>| {
        if bodies.iter().len() == 1 {
            commands.spawn(moving(7.0));
        }
    });
    app.update();
    let mut drawn = app.world_mut().query::<&GlobalTransform>();
    assert!(drawn.iter(app.world()).any(|at| at.translation().x == 7.0));
}

#[test]
fn the_length_of_a_tick_is_one_setting() {
    let rates = |app: &App| {
        let TimeStep(step) = *app.world().resource::<TimeStep>();
        (step, app.world().resource::<Time<Fixed>>().timestep())
    };
    // By the plugin, by Bevy before the plugin, and by neither.
    let (mut first, _) = app(InertiaPlugin::default().with_hz(120.0), 0.0);
    assert_eq!(rates(&first), (1.0 / 120.0, Duration::from_nanos(8_333_333)));
    let mut second = App::new();
    second.insert_resource(Time::<Fixed>::from_hz(50.0));
    second.add_plugins((InertiaPlugin::default(), TimePlugin));
    assert_eq!(rates(&second), (0.02, Duration::from_millis(20)));
    let (third, _) = app(InertiaPlugin::default(), 0.0);
    assert_eq!(rates(&third), (1.0 / 64.0, Duration::from_micros(15_625)));
    // Later, by either.
    first.insert_resource(TimeStep(0.25));
    first.update();
    assert_eq!(rates(&first), (0.25, Duration::from_millis(250)));
    first.world_mut().resource_mut::<Time<Fixed>>().set_timestep_hz(20.0);
    first.update();
    assert_eq!(rates(&first), (0.05, Duration::from_millis(50)));
}

#[test]
fn ticks_of_no_length_and_scenery_that_moves_are_drawn() {
    let (mut app, body) = app(InertiaPlugin::default().with_hz(10.0).with_drawing(), 3.0);
    let at = |x: f64| (motion::Transform::at(Vector::X * x), Transform::default());
    let scenery = app.world_mut().spawn(at(1.0)).id();
    (0..4).for_each(|_| app.update());
    app.world_mut().get_mut::<motion::Transform>(scenery).unwrap().position.x = 2.0;
    let before = drawn(&app, body);
    app.insert_resource(TimeStep(0.0));
    for _ in 0..20 {
        app.update();
        assert_eq!(drawn(&app, scenery), 2.0);
    }
    assert!(drawn(&app, body) >= before && drawn(&app, body) < 3.2);
}

#[test]
fn without_a_fixed_schedule_or_time_bodies_are_drawn_where_they_are() {
    let mut timeless = App::new();
    let plugin = InertiaPlugin::default().in_schedule(Update).with_hz(50.0).with_drawing();
    timeless.add_plugins((TransformPlugin, plugin));
    let body = timeless.world_mut().spawn(moving(0.0)).id();
    timeless.update();
    assert!((drawn(&timeless, body) - 0.02).abs() < 1e-9);

    let plugin = InertiaPlugin::default().in_schedule(PreUpdate).with_hz(50.0).with_drawing();
    let (mut app, body) = app(plugin, 0.0);
    (0..50).for_each(|_| app.update());
    assert!((drawn(&app, body) - 1.0).abs() < 1e-6);
}

#[test]
fn components_and_settings_can_be_inspected() {
    let app = App::new();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    assert!(registry.get(std::any::TypeId::of::<Gravity>()).is_some());
    let component =
        registry.get_type_data::<ReflectComponent>(std::any::TypeId::of::<PhysicsBody>());
    assert!(component.is_some());
    let mut body = PhysicsBody::with_mass(1.0);
    let fields = body.reflect_mut().as_struct().unwrap();
    fields.field_mut("velocity").unwrap().apply(&Vector::Y);
    assert_eq!(body.velocity, Vector::Y);
}
