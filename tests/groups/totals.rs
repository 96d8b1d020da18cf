//! Energies of what acts between bodies.

use glam::DVec3;
use motion::{Method, MutualGravity, Request, SourceMass};

use crate::rigs::{Environment, Net, Start, elastic, net::H, ring, tetrahedron};

#[test]
fn springs_store_half_of_stiffness_times_stretch_squared() {
    let bodies = vec![
        Start::held(DVec3::ZERO),
        Start::of(2.0, DVec3::new(3.0, 4.0, 0.0), DVec3::X),
        Start::of(1.0, DVec3::new(3.0, 4.0, 2.0), DVec3::ZERO),
    ];
    let net =
        Net { bodies, springs: vec![([0, 1], elastic(10.0, 3.0)), ([2, 1], elastic(6.0, 2.5))] };
    let mut rig = net.lab(&Environment::default(), Method::default(), H);
    // 10 / 2 (5 - 3)^2 + 6 / 2 (2 - 2.5)^2, and 2 / 2 of motion.
    let sum = rig.totals();
    assert_eq!((sum.potential_energy, sum.kinetic_energy), (20.75, 1.0));
    rig.have(Request::Remove(rig.bodies[2]));
    assert_eq!(rig.totals().potential_energy, 20.0);
    rig.have(Request::SetPosition(rig.bodies[1], DVec3::Y * 2.0));
    assert_eq!(rig.totals().potential_energy, 5.0);
}

#[test]
fn mutual_gravity_has_the_energy_of_every_pair() {
    let bodies = [
        Start::of(2.0, DVec3::ZERO, DVec3::ZERO),
        Start::of(3.0, DVec3::X * 3.0, DVec3::ZERO),
        Start::held(DVec3::Y * 8.0),
        Start::held(DVec3::Z),
    ];
    let attraction = Some(MutualGravity { constant: 0.5, softening: 4.0 });
    let around = Environment { attraction, ..Environment::default() };
    let mut rig = Net::free(bodies).lab(&around, Method::default(), H);
    rig.insert(2, SourceMass(7.0));
    let pair = |mass: f64, r: f64| -0.5 * mass / r.hypot(4.0);
    // The one that cannot move attracts with its mass as a source; the other one has none.
    let exact = pair(6.0, 3.0) + pair(14.0, 8.0) + pair(21.0, 73.0_f64.sqrt());
    let sum = rig.totals().potential_energy;
    assert!((sum / exact - 1.0).abs() <= 4.0 * f64::EPSILON, "{sum} for {exact}");
    // What is attracted falls towards it: the force is minus the slope of the energy.
    rig.run(1);
    let pull = |to: DVec3, mass: f64| to * (0.5 * mass / to.length().hypot(4.0).powi(3));
    let a = pull(DVec3::X * 3.0, 3.0) + pull(DVec3::Y * 8.0, 7.0);
    assert!(
        (rig.v(0) - a * H).length() <= 1e-16 && rig.v(2) == DVec3::ZERO && rig.v(3) == DVec3::ZERO
    );
}

/// The error of the energy is of second order, and does not grow.
#[test]
fn velocity_verlet_keeps_the_energy_in_bounds() {
    for (name, net) in [("tetrahedron", tetrahedron()), ("ring", ring())] {
        let worst = |h: f64| {
            let mut rig = net.lab(&Environment::default(), Method::VelocityVerlet, h);
            let start = rig.energy();
            [0, 1].map(|_| {
                let mut worst = 0.0_f64;
                for _ in 0..500 {
                    rig.run(10);
                    worst = worst.max(((rig.energy() - start) / start).abs());
                }
                worst
            })
        };
        let (coarse, fine) = (worst(1.0 / 100.0), worst(1.0 / 200.0));
        // Looked at every ten steps, of a motion that does not repeat itself.
        assert!(
            coarse[1] <= 1.5 * coarse[0] && fine[1] <= 1.5 * fine[0],
            "{name}: {coarse:?} {fine:?}"
        );
        let ratio = coarse[0].max(coarse[1]) / fine[0].max(fine[1]);
        assert!((3.2..4.8).contains(&ratio), "{name}: {ratio}");
    }
}
