//! Momentum: kept between bodies that can move, booked to anchors where something is held.

use glam::DVec3;
use motion::{Method, Request};

use super::Kept;

const PAIR: &str = "bodies: [
        (name: \"a\", velocity_m_s: (0.3, 0.0, 0.1), mass_kg: 2.0),
        (name: \"b\", position_m: (1.5, 0.0, 0.0), velocity_m_s: (0.0, 0.4, 0.0))],
    springs: [(between: (\"a\", \"b\"), stiffness_n_m: 8.0, damping_n_s_m: 0.3, rest_length_m: 1.0)]";

#[test]
fn two_masses_on_a_spring_invent_no_momentum() {
    for method in Method::ALL {
        let mut kept = Kept::of(PAIR, method, 60.0, 2);
        let books = &kept.run(240).check().ledger.since_opening().momentum;
        assert!(books.residual.length() < 1e-13, "{method:?}: {books:?}");
        assert_eq!((books.anchors, books.laws.len()), (DVec3::ZERO, 0), "{method:?}");
        assert!(kept.ledger.since_opening().energy.law("spring_damping") < -0.01, "{method:?}");
    }
}

#[test]
fn what_a_post_takes_is_booked_to_anchors() {
    let scene = "bodies: [(name: \"post\", immovable: true),
            (name: \"a\", position_m: (1.4, 0.0, 0.0), velocity_m_s: (0.0, 0.4, 0.0), mass_kg: 2.0)],
        springs: [(between: (\"post\", \"a\"), stiffness_n_m: 8.0, damping_n_s_m: 0.3, rest_length_m: 1.0)]";
    for (method, bound) in [
        (Method::RungeKutta4, 1e-8),
        (Method::VelocityVerlet, 1e-4),
        (Method::SemiImplicitEuler, 2e-2),
    ] {
        let mut kept = Kept::of(scene, method, 120.0, 1);
        let books = &kept.run(100).check().ledger.since_opening().momentum;
        assert!(books.anchors.length() > 0.5, "{method:?}: {books:?}");
        assert!(books.residual.length() < bound, "{method:?}: {books:?}");
        let energy = &kept.ledger.since_opening().energy;
        assert_eq!(energy.anchors, 0.0, "a post at rest does no work");
    }
}

#[test]
fn the_work_of_a_moving_post_is_booked_to_anchors() {
    let scene = "bodies: [(name: \"post\", immovable: true), (name: \"a\", position_m: (1.0, 0.0, 0.0), mass_kg: 2.0)],
        springs: [(between: (\"post\", \"a\"), stiffness_n_m: 8.0, damping_n_s_m: 0.3, rest_length_m: 1.0)]";
    let residual = |hz: u32| {
        let mut kept = Kept::of(scene, Method::RungeKutta4, f64::from(hz), 1);
        let post = kept.body("post");
        kept.ask(Request::SetVelocity(post, DVec3::X * -0.5));
        kept.run(hz).check();
        let books = kept.ledger.since_opening();
        assert!((kept.x("post").x + 0.5).abs() < 1e-12 && books.energy.anchors > 0.1, "{books:?}");
        assert!(books.momentum.residual.length() < 1e-7, "{books:?}");
        books.energy.residual.abs()
    };
    let [coarse, fine] = [residual(60), residual(120)];
    assert!(coarse < 1e-6 && coarse / fine > 11.0, "{coarse:e} {fine:e}");
}

#[test]
fn a_lock_holds_its_end_of_a_spring() {
    let scene = PAIR
        .replace("mass_kg: 2.0", "mass_kg: 2.0, locked_axes: [x]")
        .replace("(0.3, 0.0, 0.1)", "(0.0, 0.0, 0.1)");
    let mut kept = Kept::of(&scene, Method::RungeKutta4, 120.0, 4);
    kept.run(240).check();
    let books = kept.ledger.since_opening();
    let anchors = books.momentum.anchors;
    assert!(anchors.x.abs() > 0.1 && anchors.y.abs() + anchors.z.abs() < 1e-15, "{books:?}");
    assert!(books.momentum.residual.length() < 1e-8, "{books:?}");
    assert!(kept.ledger.relative_residual() < 1e-8, "{books:?}");
}
