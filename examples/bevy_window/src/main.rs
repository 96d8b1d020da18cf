//! A thousand balls on springs in a gusty wind, in a window of Bevy. The space bar throws them up.
//!
//! Run with `cargo run` in this folder, whose compiler is the one that Bevy wants.

use bevy::prelude::*;
use motion::Wind;
use motion::prelude::*;

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mesh = Mesh3d(meshes.add(Sphere::new(0.3).mesh().uv(16, 8)));
    let color = MeshMaterial3d(materials.add(Color::srgb(0.9, 0.5, 0.2)));
    for number in 0..1000_u32 {
        let place = [number % 10, number / 10 % 10, number / 100].map(|i| f64::from(i) - 4.5);
        let place = motion::Transform::at(Vector::from_array(place));
        let home = commands.spawn((place, PhysicsBody::IMMOVABLE)).id();
        let ball = (place, PhysicsBody::with_mass(1.0), mesh.clone(), color.clone());
        let ball = commands.spawn(ball).id();
        commands.spawn(Spring { ends: [home, ball], elastic: Elastic::new(20.0, 0.0).damped(1.0) });
    }
    let camera = Transform::from_xyz(11.0, 7.0, 20.0).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((Camera3d::default(), camera));
    let sun = Transform::default().looking_to(Vec3::new(-1.0, -2.0, -1.5), Vec3::Y);
    commands.spawn((DirectionalLight::default(), sun));
}

fn throw(keys: Res<ButtonInput<KeyCode>>, mut forces: Forces, balls: Query<Entity, With<Mesh3d>>) {
    if keys.pressed(KeyCode::Space) {
        balls.iter().for_each(|ball| forces.add(ball, Vector::Y * 40.0));
    }
}

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, InertiaPlugin::default().with_drawing()))
        .insert_resource(Drag::new(0.5, 0.0).in_wind(Wind::new(Vector::X * 8.0).gusting(15.0, 0.5)))
        .add_systems(Startup, spawn)
        .add_systems(FixedUpdate, throw.before(StepSystems::Integrate))
        .run();
}
