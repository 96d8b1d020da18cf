//! Far from the origin: the same relative motion, to what positions are rounded to there.

use glam::DVec3;
use motion::{Damping, DampingModel, Elastic, Method};

use crate::rigs::{Environment, Net, Start};

const H: f64 = 1.0 / 128.0;

/// A net that swings on a post, and two bodies that fly by.
fn net() -> Net {
    let body = |i: usize| {
        let v = if i > 3 { DVec3::new(3.0, 7.5, -1.25) } else { DVec3::ZERO };
        let x = DVec3::new(i as f64, 0.25 * (i % 2) as f64, -0.5);
        if i == 0 { Start::held(x) } else { Start::of(1.0, x, v) }
    };
    let elastic = Elastic::new(20.0, 1.0).damped(2.0);
    Net {
        bodies: (0..6).map(body).collect(),
        springs: (0..3).map(|i| ([i, i + 1], elastic)).collect(),
    }
}

#[test]
fn ten_thousand_kilometers_from_the_origin_the_motion_is_the_same() {
    // Numbers of f64 whose sums with the start are exact, and the distance between two positions there.
    let (shift, ulp) = (DVec3::new(1e7, -1e7, 1e7), 1.9e-9);
    let ticks = 1280;
    for method in Method::ALL {
        let damping = Some(Damping { model: DampingModel::Exact, rate: 0.5 });
        let around = Environment { damping, ..Environment::falling() };
        let [mut near, mut far] =
            [DVec3::ZERO, shift].map(|by| net().moved(by).lab(&around, method, H));
        let (near, far) = (near.run(ticks).states(), far.run(ticks).states());
        for ((x, v), (y, u)) in near.iter().zip(&far) {
            let y = *y - shift;
            // Each tick rounds each coordinate by half of that at most; damped motion does not enlarge it, and adds up
            // what ten seconds of it leave.
            let bound = 2.0 * ticks as f64 * ulp;
            assert!(x.distance(y) <= bound, "{method:?}: {x} {y} {:e}", x.distance(y));
            assert!(v.distance(*u) <= 10.0 * bound, "{method:?}: {v} {u}");
        }
        // What nothing pulls at has the very same velocity.
        for free in [4, 5] {
            assert_eq!(near[free].1, far[free].1, "{method:?}");
        }
    }
}
