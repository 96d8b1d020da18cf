//! Pushes: booked with F dx and F h, whatever the method, and nothing of them is residual where a method is exact.

use glam::DVec3;
use motion::Method;

use super::{FALLING, Kept};

const HZ: f64 = 60.0;
const FORCE: DVec3 = DVec3::new(3.0, -1.0, 0.5);

#[test]
fn work_is_force_times_displacement_and_the_residual_that_of_the_method() {
    for (method, factor) in FALLING {
        for substeps in [1, 3] {
            let scene = "bodies: [(name: \"cart\", velocity_m_s: (0.5, 0.25, 0.0), mass_kg: 2.0)]";
            let mut kept = Kept::of(scene, method, HZ, substeps);
            // The first step of position Verlet is another one.
            kept.run(3);
            let start = kept.x("cart");
            for _ in 0..10 {
                // Two pushes of a tick add up.
                kept.push("cart", FORCE * 0.25);
                kept.push("cart", FORCE * 0.75);
                kept.tick();
            }
            let work = FORCE.dot(kept.x("cart") - start);
            kept.run(3).check();
            let books = kept.ledger.since_opening();
            assert!((books.energy.pushes - work).abs() < 1e-14, "{method:?}: {} {work}", books.energy.pushes);
            assert!(books.momentum.pushes.distance(FORCE * (10.0 / HZ)) < 1e-14, "{method:?}");
            assert!(books.momentum.residual.length() < 1e-14, "{method:?}: {:?}", books.momentum);
            // A push is constant over the tick, which position Verlet solves exactly.
            let factor = if method == Method::PositionVerlet { 0.0 } else { factor };
            let h = 1.0 / (HZ * f64::from(substeps));
            let theory = factor * 10.0 * f64::from(substeps) * FORCE.dot(FORCE) * h * h / (2.0 * 2.0);
            assert!((kept.residual() - theory).abs() < 1e-14, "{method:?}: {} {theory}", kept.residual());
        }
    }
}

#[test]
fn a_push_along_a_locked_axis_or_of_what_cannot_move_gives_nothing() {
    let scene = "bodies: [
        (name: \"rail\", mass_kg: 2.0, locked_axes: [x]),
        (name: \"wall\", position_m: (5.0, 0.0, 0.0), immovable: true)]";
    for method in Method::ALL {
        let mut kept = Kept::of(scene, method, HZ, 1);
        for _ in 0..5 {
            kept.push("rail", FORCE);
            kept.push("wall", FORCE);
            kept.tick();
        }
        let books = &kept.check().ledger.since_opening().momentum;
        let open = DVec3::new(0.0, FORCE.y, FORCE.z) * (5.0 / HZ);
        assert!(books.pushes.distance(open) < 1e-15, "{method:?}: {books:?}");
        assert!(books.residual.length() < 1e-15, "{method:?}: {books:?}");
    }
}
