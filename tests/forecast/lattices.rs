//! Large nets: what is said of them is no more than what is known.

use std::f64::consts::PI;

use glam::DVec3;
use history::Simulation;
use motion::Method;
use motion::margin::{Margin, Margins};

use crate::rigs::{Environment, Net, Start, elastic, scene_of};

fn worst(soft_body: &str) -> Margin {
    let scene = scene_of(&format!("(version: 1, step_hz: 120, soft_bodies: [{soft_body}])"));
    let run = Simulation::new(scene);
    *Margins::of(&run.world, run.stepper.method()).list().first().unwrap()
}

/// Every point swings against its neighbors along one axis: `m w² = 4 k (1 + 2 + 4 / 3)`.
#[test]
fn a_large_lattice_is_not_accused() {
    let lattice =
        "lattice(cells: (60, 60, 60), size_m: (1, 1, 1), mass_kg: 1, stiffness_n_m: 0.01)";
    let margin = worst(lattice);
    let exact = (0.01 * 61.0_f64.powi(3) * 52.0 / 3.0).sqrt() / 120.0;
    assert!(margin.value <= exact && margin.value >= 0.99 * exact, "{margin:?} {exact}");
    assert!(margin.at_most >= margin.value && margin.at_most <= 1.01 * margin.value, "{margin:?}");
    assert!(!margin.is_unstable() && (margin.limit - 2.0).abs() < 1e-3, "{margin:?}");
}

/// The first products leave an interval with the limit in it: the search continues.
#[test]
fn a_large_lattice_near_its_limit_is_decided() {
    for (part, is_unstable) in [(1.007, true), (0.99, false)] {
        let stiffness = (2.0 * part * 120.0_f64).powi(2) / (61.0_f64.powi(3) * 52.0 / 3.0);
        let margin = worst(&format!(
            "lattice(cells: (60, 60, 60), size_m: (1, 1, 1), mass_kg: 1, stiffness_n_m: {stiffness:?})"
        ));
        assert!(margin.is_unstable() == is_unstable && !margin.may_be_unstable(), "{margin:?}");
    }
}

/// The largest of `m w² / k` of a cloth without an end, over all waves.
fn fastest_wave() -> f64 {
    let wave = |i: i32, j: i32| {
        let [a, b] = [i, j].map(|i| f64::from(i) * PI / 300.0);
        let along = |a: f64| 2.0 * (1.0 - a.cos()) + 2.0 * (1.0 - (2.0 * a).cos());
        let [rising, falling] = [a + b, a - b].map(|a| 1.0 - a.cos());
        let (xx, yy, xy) =
            (along(a) + rising + falling, along(b) + rising + falling, rising - falling);
        f64::midpoint(xx, yy) + ((xx - yy) / 2.0).hypot(xy)
    };
    (0..=300).flat_map(|i| (0..=300).map(move |j| wave(i, j))).fold(0.0, f64::max)
}

/// Neighbors and the next but one cannot all swing against each other: no bound of a single point is close.
#[test]
fn the_value_of_a_large_cloth_is_within_a_hundredth() {
    let margin = worst(
        "cloth(rows: 250, columns: 250, along_m: (1, 0, 0), down_m: (0, -1, 0), mass_kg: 1, stiffness_n_m: 0.1,
         shear: true, bend: true)",
    );
    let exact = (0.1 * 250.0_f64.powi(2) * fastest_wave()).sqrt() / 120.0;
    // Waves of a grid of them: the fastest of all is next to nothing faster.
    assert!(
        margin.value <= exact * (1.0 + 1e-4) && margin.value >= 0.99 * exact,
        "{margin:?} {exact}"
    );
    assert!(
        margin.at_most >= 0.999 * exact && margin.at_most <= 1.01 * margin.value,
        "{margin:?} {exact}"
    );
}

/// A chain of `bodies` bodies of 1 kg that turns corners.
fn bent_chain(bodies: usize, stiffness: f64) -> Net {
    let place = |i: usize| DVec3::new(i as f64, 0.6 * (i % 2) as f64, 0.3 * (i % 3) as f64);
    let start =
        |i: usize| if i == 0 { Start::held(place(0)) } else { Start::of(1.0, place(i), DVec3::Y) };
    let spring = |i: usize| ([i - 1, i], elastic(stiffness, place(i).distance(place(i - 1))));
    Net { bodies: (0..bodies).map(start).collect(), springs: (1..bodies).map(spring).collect() }
}

#[test]
fn implicit_euler_is_a_cure_only_where_its_iteration_ends() {
    let mut cured = 0;
    for bodies in [2, 5, 40, 1500] {
        for k in [1e5, 1e7, 1e9, 1e14, 1e20, 1e100, 1e300] {
            let net = bent_chain(bodies, k);
            let rig = net.lab(&Environment::default(), Method::SemiImplicitEuler, 1.0 / 60.0);
            let margin =
                *Margins::of(&rig.world, Method::SemiImplicitEuler).list().first().unwrap();
            assert!(
                margin.is_unstable() && (margin.limit - 2.0).abs() <= 0.01,
                "{bodies} {k:e}: {margin:?}"
            );
            let exact = (k * 4.0).sqrt() / 60.0;
            assert!(
                margin.value <= exact && margin.value >= 0.4 * exact,
                "{bodies} {k:e}: {margin:?}"
            );
            if margin.cure.method == Some(Method::ImplicitEuler) {
                let mut rig = net.lab(&Environment::default(), Method::ImplicitEuler, 1.0 / 60.0);
                rig.run(30);
                let unconverged = rig.evaluations().unconverged_steps();
                assert_eq!(unconverged, 0, "{bodies} {k:e}: {margin:?}");
                cured += 1;
            }
        }
    }
    assert!(cured >= 4, "{cured}");
}

/// The value of a long chain is known within a hundredth: of hundreds of substeps one hundredth is some.
#[test]
fn the_substeps_that_a_cure_names_are_enough() {
    for k in [1e9, 2e9, 3e9, 5e9, 1e10] {
        let net = bent_chain(300, k);
        let margin = |substeps| {
            let around = Environment { substeps, ..Environment::default() };
            let rig = net.lab(&around, Method::SemiImplicitEuler, 1.0 / 60.0);
            *Margins::of(&rig.world, Method::SemiImplicitEuler).list().first().unwrap()
        };
        let unstable = margin(None);
        assert!(unstable.is_unstable() && unstable.at_most > unstable.value, "{k:e}: {unstable:?}");
        let cured = margin(unstable.cure.substeps);
        assert!(
            cured.substeps > 400 && !cured.is_unstable() && !cured.may_be_unstable(),
            "{k:e}: {cured:?}"
        );
    }
}
