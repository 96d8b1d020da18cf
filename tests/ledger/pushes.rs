//! Pushes: booked with the kinetic energy and the momentum that they give, whatever the method.

use glam::DVec3;
use motion::Method;

use super::Kept;

const HZ: f64 = 60.0;
const FORCE: DVec3 = DVec3::new(3.0, -1.0, 0.5);

#[test]
fn the_work_of_a_push_is_the_kinetic_energy_that_it_gives() {
    for method in Method::ALL {
        for substeps in [1, 3] {
            let scene = "bodies: [(name: \"cart\", velocity_m_s: (0.5, 0.25, 0.0), mass_kg: 2.0)]";
            let mut kept = Kept::of(scene, method, HZ, substeps);
            // The first step of position Verlet is another one.
            kept.run(3);
            let start = kept.v("cart");
            for _ in 0..10 {
                // Two pushes of a tick add up.
                kept.push("cart", FORCE * 0.25).push("cart", FORCE * 0.75).tick();
            }
            let end = kept.v("cart");
            let work = end.dot(end) - start.dot(start);
            kept.run(3).check();
            let books = kept.ledger.since_opening();
            assert!(
                (books.energy.pushes - work).abs() < 1e-13,
                "{method:?}: {} {work}",
                books.energy.pushes
            );
            assert!(books.momentum.pushes.distance(FORCE * (10.0 / HZ)) < 1e-14, "{method:?}");
            assert!(books.momentum.residual.length() < 1e-14, "{method:?}: {:?}", books.momentum);
            assert!(kept.residual().abs() < 1e-13, "{method:?}: {}", kept.residual());
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
            kept.push("rail", FORCE).push("wall", FORCE).tick();
        }
        let books = &kept.check().ledger.since_opening().momentum;
        let open = DVec3::new(0.0, FORCE.y, FORCE.z) * (5.0 / HZ);
        assert!(books.pushes.distance(open) < 1e-15, "{method:?}: {books:?}");
        assert!(books.residual.length() < 1e-15, "{method:?}: {books:?}");
    }
}
