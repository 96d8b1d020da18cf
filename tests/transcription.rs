//! The tutorial's two loops, written down once more and independently, against the program's schedule: equal bits.

use glam::DVec3;
use motion::{Damping, PhysicsBody, Transform};
use sandbox::Stage;
use sandbox::input::Button;

use crate::rigs::{Drive, G, H, at, click, down, push, tap, up};

/// A body in plain numbers.
struct Body {
    x: [f64; 3],
    v: [f64; 3],
    w: f64,
    force: [f64; 3],
}

/// One update of the tutorial: all accelerations, then all velocities, then the forces are forgotten.
fn update(bodies: &mut [Body], gravity: bool, dt: f64) {
    for body in bodies.iter_mut() {
        for axis in 0..3 {
            let mut acceleration = body.force[axis] * body.w;
            if gravity && body.w > 0.0 && axis == 1 {
                acceleration += G;
            }
            body.v[axis] += acceleration * dt;
        }
    }
    for body in bodies.iter_mut() {
        for axis in 0..3 {
            body.x[axis] += body.v[axis] * dt;
            body.v[axis] *= 1.0 - 0.4 * dt;
        }
    }
    bodies.iter_mut().for_each(|body| body.force = [0.0; 3]);
}

/// Every body with physics of a session, in stable-id order.
fn bodies(stage: &Stage) -> Vec<Body> {
    let world = &stage.sim().world;
    let things = stage
        .sim()
        .remaining_bodies()
        .filter_map(|thing| world.get::<PhysicsBody>(thing).map(|body| (thing, body)));
    things
        .map(|(thing, body)| Body {
            x: world.get::<Transform>(thing).unwrap().position.to_array(),
            v: body.velocity.to_array(),
            w: body.inverse_mass,
            force: [0.0; 3],
        })
        .collect()
}

fn bits(bodies: &[Body]) -> Vec<[u64; 6]> {
    let row = |body: &Body| {
        [0, 1, 2, 3, 4, 5].map(|i| if i < 3 { body.x[i] } else { body.v[i - 3] }.to_bits())
    };
    bodies.iter().map(row).collect()
}

/// Pushes `bodies[i]` in the transcription.
fn force(bodies: &mut [Body], i: usize, newtons: DVec3) {
    for axis in 0..3 {
        bodies[i].force[axis] += newtons[axis];
    }
}

#[test]
fn the_tutorials_two_loops_and_the_schedule_visit_the_same_bits_for_ten_seconds() {
    let mut drive = Drive::tutorial();
    let mut copy = bodies(&drive.session.stage);
    assert_eq!(copy.len(), 29);
    let mut gravity = false;
    drive.press("Q");
    let player = drive.pixel(drive.x("player"));
    assert_eq!(drive.select(player).as_deref(), Some("player"));
    let along =
        drive.session.view.camera().viewpoint().ray_through(player, crate::rigs::SIZE).direction();
    for tick in 0..1200_u32 {
        let mut events = Vec::new();
        if [200, 420, 500, 900].contains(&tick) {
            gravity = !gravity;
            events.extend(tap("G"));
        }
        if tick % 37 == 5 {
            let newtons = DVec3::new(f64::from(tick), -3.3, 0.7);
            let i = 1 + (tick as usize / 37) % 28;
            events.push(push(
                &drive
                    .session
                    .stage
                    .name(drive.session.stage.sim().remaining_bodies().nth(i).unwrap()),
                newtons,
            ));
            force(&mut copy, i, newtons);
        }
        if tick == 90 {
            // The floor, and a second push in the same tick.
            events.extend([push("floor", DVec3::ONE), push("enemy", DVec3::Y * 0.1)]);
            events.push(push("enemy", DVec3::splat(1.0 / 3.0)));
            force(&mut copy, 0, DVec3::ONE);
            force(&mut copy, 2, DVec3::Y * 0.1);
            force(&mut copy, 2, DVec3::splat(1.0 / 3.0));
        }
        if tick == 3 {
            events.push(at(player));
            events.extend(click(Button::Right));
            force(&mut copy, 1, along * 10.0);
        }
        if tick == 600 {
            events.push(down("Right"));
        }
        if tick == 720 {
            events.push(up("Right"));
        }
        if (600..720).contains(&tick) {
            force(&mut copy, 1, DVec3::X * 10.0);
        }
        update(&mut copy, gravity, H);
        drive.frame(H, events);
        assert_eq!(drive.session.stage.sim().ticks(), u64::from(tick) + 1);
        assert_eq!(bits(&bodies(&drive.session.stage)), bits(&copy), "after tick {tick}");
    }
}

#[test]
fn several_ticks_a_frame_visit_the_same_bits_and_a_push_acts_in_the_first_of_them() {
    let mut drive = Drive::tutorial();
    let mut copy = bodies(&drive.session.stage);
    let time = drive.clock.advance_by(0.0).unwrap();
    drive.session.advance(&tap("G").into_iter().collect(), time);
    for frame in 0..30_u32 {
        let newtons = DVec3::new(0.1, f64::from(frame), -7.0);
        force(&mut copy, 5, newtons);
        let name =
            drive.session.stage.name(drive.session.stage.sim().remaining_bodies().nth(5).unwrap());
        let time = drive.clock.advance_by(4.0 * H).unwrap();
        let mut ticks = 0;
        drive.session.advance_watched(
            &[push(&name, newtons)].into_iter().collect(),
            time,
            &mut |now, _| {
                update(&mut copy, true, H);
                assert_eq!(bits(&bodies(now)), bits(&copy), "in frame {frame}");
                ticks += 1;
                std::ops::ControlFlow::Continue(())
            },
        );
        assert_eq!(ticks, 4);
    }
}

#[test]
fn the_plan_of_one_pass_visits_the_same_bits_as_the_two_loops() {
    let mut scene = scene::load("thousand").unwrap();
    scene.damping = Some(Damping::TUTORIAL);
    let mut drive = Drive::of(scene);
    assert_eq!(drive.session.stage.sim().stepper.plan().passes, motion::internals::Passes::One);
    let mut copy = bodies(&drive.session.stage);
    assert_eq!(copy.len(), 1001);
    for tick in 0..300_u32 {
        let mut events = Vec::new();
        if tick % 20 < 3 {
            let newtons = DVec3::new(-0.3, f64::from(tick), 11.0);
            let i = 7 * tick as usize % 1001;
            force(&mut copy, i, newtons);
            events.push(push(
                &drive
                    .session
                    .stage
                    .name(drive.session.stage.sim().remaining_bodies().nth(i).unwrap()),
                newtons,
            ));
        }
        update(&mut copy, true, H);
        drive.frame(H, events);
        assert_eq!(bits(&bodies(&drive.session.stage)), bits(&copy), "after tick {tick}");
    }
}
