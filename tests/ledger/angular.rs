//! Angular momentum about the origin: torques by cause, and what each method invents.

use glam::DVec3;
use motion::ledger::LedgerLines;
use motion::{DampingModel, Method};

use super::Kept;

const HZ: f64 = 60.0;
const FORCE: DVec3 = DVec3::new(3.0, -1.0, 0.5);

fn angular(kept: &Kept) -> &LedgerLines<DVec3> {
    &kept.ledger.since_opening().angular_momentum
}

/// Methods whose velocity belongs to the time of their position.
fn synchronous() -> impl Iterator<Item = Method> {
    Method::ALL.into_iter().filter(|method| *method != Method::PositionVerlet)
}

#[test]
fn a_push_gives_its_torque_at_the_place_of_each_kick_and_leaves_no_residual() {
    for method in synchronous() {
        for substeps in [1, 3] {
            let scene = "bodies: [(name: \"cart\", position_m: (1.0, 2.0, -3.0), velocity_m_s: (0.5, 0.25, 0.0), mass_kg: 2.0)]";
            let mut kept = Kept::of(scene, method, HZ, substeps);
            for _ in 0..10 {
                kept.push("cart", FORCE).tick();
            }
            let given = kept.x("cart").cross(kept.v("cart") * 2.0)
                - kept.ledger.angular_momentum_at_opening();
            let lines = angular(kept.run(3).check());
            assert!(lines.pushes.length() > 1.0, "{method:?}: {lines:?}");
            assert!(lines.pushes.distance(given) < 1e-13, "{method:?}: {lines:?}, {given}");
            assert!(lines.residual.length() < 1e-13, "{method:?}: {lines:?}");
        }
    }
}

#[test]
fn gravity_turns_a_falling_body_about_the_origin_by_its_weight_times_the_distance() {
    for method in synchronous() {
        let scene =
            "gravity: (), bodies: [(name: \"stone\", position_m: (4.0, 1.0, 0.0), mass_kg: 2.0)]";
        let mut kept = Kept::of(scene, method, HZ, 2);
        let lines = angular(kept.run(120).check());
        assert!(
            lines.law("gravity").distance(DVec3::Z * (-9.8 * 4.0 * 2.0 * 2.0)) < 1e-11,
            "{method:?}: {lines:?}"
        );
        assert!(lines.residual.length() < 1e-11, "{method:?}: {lines:?}");
    }
}

#[test]
fn damping_a_speed_limit_and_a_lock_are_their_own_lines() {
    let scene = |model: DampingModel, key: &str| {
        format!(
            "damping: (model: {}, rate_per_s: 0.8), bodies: [
             (name: \"a\", position_m: (2.0, 0.0, 1.0), velocity_m_s: (1.0, 3.0, 0.5), mass_kg: 2.0{key})]",
            model.name()
        )
    };
    for model in DampingModel::ALL {
        for method in synchronous() {
            for (key, limits) in
                [("", false), (", max_speed_m_s: 2.0", true), (", locked_axes: [y]", true)]
            {
                let mut kept = Kept::of(&scene(model, key), method, HZ, 2);
                kept.push("a", FORCE).run(60).check();
                let lines = angular(&kept);
                assert!(lines.damping.length() > 0.01, "{model:?} {method:?}{key}: {lines:?}");
                assert_eq!(
                    lines.limits.length() > 0.1,
                    limits,
                    "{model:?} {method:?}{key}: {lines:?}"
                );
                // Factors are recorded; damping as a law has the error of the method in the tick that is pushed.
                let bound = if model == DampingModel::Exact { 2e-6 } else { 1e-13 };
                assert!(lines.residual.length() < bound, "{model:?} {method:?}{key}: {lines:?}");
            }
        }
    }
}

#[test]
fn a_central_force_has_no_torque_and_only_some_methods_invent_one() {
    // A circle of radius 1 and angular velocity 1.
    let scene = "wells: [(strength_m3_s2: 1.0)],
        bodies: [(name: \"planet\", position_m: (1.0, 0.0, 0.0), velocity_m_s: (0.0, 1.0, 0.0), mass_kg: 2.0)]";
    let residual = |method| {
        let mut kept = Kept::of(scene, method, 1000.0, 1);
        let lines = angular(kept.run(1000).check());
        assert!(lines.law("wells").length() < 1e-12, "{method:?}: {lines:?}");
        lines.residual.z
    };
    // Explicit Euler kicks one step too late and implicit Euler one too early: `h w² L` per second of L = 2.
    for (method, expected) in [(Method::ExplicitEuler, 2e-3), (Method::ImplicitEuler, -2e-3)] {
        let residual = residual(method);
        assert!((residual / expected - 1.0).abs() < 0.01, "{method:?}: {residual:e}");
    }
    for method in [Method::SemiImplicitEuler, Method::VelocityVerlet, Method::Yoshida4] {
        assert!(residual(method).abs() < 1e-12, "{method:?}: {:e}", residual(method));
    }
    assert!(residual(Method::RungeKutta4).abs() < 1e-11, "{:e}", residual(Method::RungeKutta4));
}

#[test]
fn springs_between_movable_bodies_give_none_and_a_post_gives_what_it_holds() {
    let scene = |post: &str| {
        format!(
            "bodies: [(name: \"post\", position_m: (3.0, 0.0, 0.0), mass_kg: 1.0{post}),
            (name: \"a\", position_m: (4.4, 0.0, 0.0), velocity_m_s: (0.0, 0.4, 0.0), mass_kg: 2.0)],
        springs: [(between: (\"post\", \"a\"), stiffness_n_m: 8.0, damping_n_s_m: 0.3, rest_length_m: 1.0)]"
        )
    };
    for method in [Method::SemiImplicitEuler, Method::VelocityVerlet, Method::RungeKutta4] {
        let mut free = Kept::of(&scene(""), method, 120.0, 1);
        let lines = angular(free.run(100).check());
        assert!(
            lines.residual.length() < 1e-2 && lines.anchors == DVec3::ZERO,
            "{method:?}: {lines:?}"
        );
    }
    let mut held = Kept::of(&scene(", immovable: true"), Method::RungeKutta4, 120.0, 1);
    let lines = angular(held.run(100).check());
    assert!(lines.anchors.length() > 0.1 && lines.residual.length() < 1e-8, "{lines:?}");
}

#[test]
fn drag_and_attraction_to_what_is_held_are_accounted_for() {
    let scene = "drag: (linear_per_s: 0.4), wind: (velocity_m_s: (3.0, 0.0, 1.0)), mutual_gravity: (constant_m3_kg_s2: 1.0),
        bodies: [(name: \"sun\", position_m: (1.0, 1.0, 0.0), mass_kg: 5.0, immovable: true),
        (name: \"a\", position_m: (3.0, 0.0, 0.0), velocity_m_s: (0.0, 1.4, 0.0), mass_kg: 2.0),
        (name: \"b\", position_m: (-2.0, 0.0, 1.0), velocity_m_s: (0.0, -1.1, 0.0))]";
    let residual = |hz: u32| {
        let mut kept = Kept::of(scene, Method::RungeKutta4, f64::from(hz), 1);
        let lines = angular(kept.run(hz).check());
        assert!(lines.anchors.length() > 0.1 && lines.law("drag").length() > 0.1, "{lines:?}");
        lines.residual.length()
    };
    let [coarse, fine] = [residual(30), residual(60)];
    assert!(coarse < 1e-5 && coarse / fine > 11.0, "{coarse:e} {fine:e}");
}

#[test]
fn wind_on_a_sheet_turns_it_by_the_torque_on_its_triangles() {
    let scene = "drag: (quadratic_per_m: 2.0), wind: (velocity_m_s: (3.0, 0.0, 1.0)), soft_bodies: [
        cloth(name: \"flag\", rows: 3, columns: 4, corner_m: (1.0, 2.0, 0.0), along_m: (1.0, 0.0, 0.3), down_m: (0.0, -1.0, 0.0),
              mass_kg: 1.0, stiffness_n_m: 20.0, damping_n_s_m: 0.1)]";
    let residual = |hz: u32| {
        let mut kept = Kept::of(scene, Method::RungeKutta4, f64::from(hz), 1);
        let lines = angular(kept.run(hz).check());
        assert!(lines.law("drag").length() > 0.3 && lines.anchors == DVec3::ZERO, "{lines:?}");
        lines.residual.length()
    };
    let [coarse, fine] = [residual(60), residual(120)];
    assert!(coarse < 1e-5 && coarse / fine > 11.0, "{coarse:e} {fine:e}");
}
