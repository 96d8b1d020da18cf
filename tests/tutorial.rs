//! The numbers of the tutorial's own scheme.

use motion::units::Vector;
use motion::{Gravity, Method};

use crate::rigs::{G, H, Lab, close, digits};

/// Closed form of n ticks from rest under constant acceleration: stored velocity and way.
fn closed_form(a: f64, d: f64, n: f64) -> (f64, f64) {
    let k = 1.0 - d * H;
    // 1 - k^n without the cancellation.
    let lost = -(n * (-d * H).ln_1p()).exp_m1();
    (a * k / d * lost, a / d * (n * H - k * lost / d))
}

#[test]
fn a_fall_with_damping_is_the_closed_form_of_the_scheme() {
    let table = [
        (60, "-4.432971", "-1.167573"),
        (120, "-8.061168", "-4.347081"),
        (240, "-13.461121", "-15.347198"),
        (600, "-21.124693", "-69.688268"),
        (1200, "-23.974074", "-185.064814"),
    ];
    let mut lab = Lab::tutorial();
    let body =
        lab.world.spawn((motion::Transform::default(), motion::PhysicsBody::with_mass(0.1))).id();
    let mut done = 0;
    for (n, v, drop) in table {
        lab.run(n - done);
        done = n;
        let (closed_v, closed_x) = closed_form(G, 0.4, n as f64);
        close(lab.v(body).y, closed_v, 1e-11);
        close(lab.x(body).y, closed_x, 1e-11);
        digits(lab.v(body).y, v);
        digits(lab.x(body).y, drop);
    }
}

#[test]
fn undamped_the_two_eulers_lie_on_either_side_of_the_truth() {
    for (method, drop) in
        [(Method::SemiImplicitEuler, "-4.940833"), (Method::ExplicitEuler, "-4.859167")]
    {
        let mut lab = Lab::new(method, H).with_gravity();
        let body = lab.body(10.0, Vector::ZERO);
        lab.run(120);
        digits(lab.x(body).y - 10.0, drop);
        close(lab.v(body).y, G, 1e-13);
    }
}

#[test]
fn ten_seconds_of_free_fall_reach_98_meters_a_second() {
    let mut lab = Lab::new(Method::SemiImplicitEuler, H).with_gravity();
    let body = lab.body(1.0, Vector::ZERO);
    lab.run(1200);
    close(lab.v(body).y, -98.0, 1e-12);
}

#[test]
fn one_push_on_a_grid_body_the_player_and_the_floor() {
    // Newtons, inverse mass, speed in the push's own tick, speed stored after it, whole way.
    let table = [
        (10.0, 10.0, "0.833333", "0.830556", "2.083333"),
        (110.0, 10.0, "9.166667", "9.136111", "22.916667"),
        (10.0, 0.5, "0.041667", "0.041528", "0.104167"),
        (10.0, 0.0, "0.000000", "0.000000", "0.000000"),
    ];
    for (newtons, w, moves, stored, way) in table {
        let mut lab = Lab::tutorial();
        lab.world.resource_mut::<Gravity>().on = false;
        let body = lab.body(w, Vector::ZERO);
        lab.push(body, Vector::Z * newtons).run(1);
        digits(lab.x(body).z / H, moves);
        digits(lab.v(body).z, stored);
        lab.run(12_000);
        digits(lab.x(body).z, way);
    }
}

#[test]
fn the_terminal_speed_is_moved_at_and_stored_short_of() {
    let mut lab = Lab::tutorial();
    let body = lab.body(10.0, Vector::ZERO);
    lab.run(12_000);
    digits(lab.v(body).y, "-24.418333");
    let before = lab.x(body).y;
    lab.run(1);
    digits((lab.x(body).y - before) / H, "-24.500000");
}

#[test]
fn a_grid_body_reaches_the_floor_passes_its_middle_and_leaves_it_below() {
    let mut lab = Lab::tutorial();
    let body = lab.body(10.0, Vector::ZERO);
    let mut tick = 0;
    // Half-height 1: it touches the top of the slab at y = 0 when its center is at 1.
    for (height, first) in [(1.0, 179), (0.0, 189), (-5.0, 237)] {
        while lab.x(body).y > height {
            lab.run(1);
            tick += 1;
        }
        assert_eq!(tick, first, "first tick with the center at {height} m or below");
    }
    let (v, _) = closed_form(G, 0.4, 179.0);
    digits(v, "-10.9859");
}

#[test]
fn after_ten_seconds_of_a_held_key_of_ten_newtons() {
    let mut lab = Lab::tutorial();
    lab.world.resource_mut::<Gravity>().on = false;
    let body = lab.body(10.0, Vector::ZERO);
    lab.world
        .resource_mut::<motion::PushQueue>()
        .sustain([motion::Push { body, newtons: Vector::X * 10.0 }]);
    lab.run(1200);
    let (v, x) = closed_form(100.0, 0.4, 1200.0);
    close(lab.v(body).x, v, 1e-11);
    close(lab.x(body).x, x, 1e-11);
}
