//! Speeds, masses and distances near the ends of the numbers.

use crate::rigs::Bare;
use glam::DVec3;
use motion::{Drag, Gravity, Method};

use crate::rigs::{Environment, H, Lab, Net, Start, close, elastic};

#[test]
fn a_body_at_1e20_m_s_flies_on_and_no_other_notices() {
    for method in Method::ALL {
        let make = |fourth: DVec3| {
            let mut lab = Lab::new(method, H).with_gravity();
            for i in 0..7 {
                lab.body(1.0, if i == 3 { fourth } else { DVec3::X * f64::from(i) });
            }
            lab.run(120);
            lab
        };
        let (fast, slow) = (make(DVec3::new(1e20, -1e20, 0.0)), make(DVec3::X * 3.0));
        assert!(fast.records().is_empty(), "{method:?}");
        // 120 steps, each rounded a few times.
        let x = fast.x(3).x;
        assert!((x / 1e20 - 1.0).abs() <= 500.0 * f64::EPSILON, "{method:?}: {x:e}");
        assert_eq!(fast.all_bits(&[3]), slow.all_bits(&[3]), "{method:?}");
    }
}

#[test]
fn drag_at_1e20_m_s_quarantines_under_explicit_methods_and_slows_down_under_the_implicit_one() {
    for method in Method::ALL {
        let mut lab = Environment { drag: Some(Drag::new(0.0, 0.05)), ..Environment::default() }
            .lab(method, H);
        let body = lab.body(1.0, DVec3::splat(1e20));
        lab.run(240);
        assert!(lab.x(body).is_finite() && lab.v(body).is_finite(), "{method:?}");
        let quarantined = lab.is_quarantined(body);
        assert_eq!(quarantined, method != Method::ImplicitEuler, "{method:?}");
        if !quarantined {
            // 1 / (k t), and more for the first steps, each of which takes a root of the speed at most.
            close(lab.v(body).length(), 1.0 / (0.05 * 240.0 * H), 0.2);
        }
    }
}

/// By `F w h`, also where the reciprocal of the mass is subnormal.
#[test]
fn masses_over_seventy_six_powers_of_ten_are_pushed_alike() {
    for method in Method::ALL {
        for w in [1e-38, 1e38, 1e-310, f64::MIN_POSITIVE, 1e300] {
            let mut bare = Bare::new(method, H).with_law(Gravity::EARTH);
            bare.add([0.0; 3], [0.0; 3], w);
            bare.push(0, [1e-3 / w.max(1e-300), 0.0, 0.0]);
            bare.tick();
            let force = 1e-3 / w.max(1e-300);
            let expected = force * w * H;
            let v = bare.bodies[0];
            assert!((v[0] - expected).abs() <= 1e-13 * expected, "{method:?} {w:e}: {v:?}");
            assert!(v[1] < 0.0 && !bare.has_failed(), "{method:?} {w:e}");
        }
    }
}

/// Distances whose squares vanish or overflow.
#[test]
fn springs_over_any_distance_leave_numbers_and_momentum() {
    for method in Method::ALL {
        for distance in [1e-23, 2e19, 1e-170, 2e160] {
            let [a, b] =
                [-0.5, 0.5].map(|side| Start::of(1.0, DVec3::X * (side * distance), DVec3::ZERO));
            let mut lab =
                Net::pair(a, b, elastic(10.0, 1.0)).lab(&Environment::default(), method, H);
            let what = format!("{method:?}, {distance:e}");
            assert!(lab.run(60).records().is_empty(), "{what}");
            let (sum, speed) = (lab.totals(), lab.v(0).length());
            assert!(sum.momentum.length() <= 1e-13 * speed, "{what}: {}", sum.momentum);
        }
    }
}
