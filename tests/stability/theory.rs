//! What the cells have to be: closed forms and limits, not what a run gave once.

use lab::stability::Class;
use motion::Method;

use super::cell;
use crate::rigs::close;

/// The methods that keep an oscillator of w h = 1.05, which is what a chain of 63 rad/s has at 60 Hz.
const STABLE: [Method; 6] = [
    Method::SemiImplicitEuler,
    Method::ImplicitEuler,
    Method::PositionVerlet,
    Method::VelocityVerlet,
    Method::RungeKutta4,
    Method::Yoshida4,
];

#[test]
fn only_implicit_euler_survives_a_spring_that_is_too_stiff() {
    // The energy grows by 1 + (w h)² = 1 + 1e8 / 3600 in the first tick, or falls by as much.
    close(cell("stiff_spring: whole ticks", Method::ExplicitEuler).number, 1e8 / 3600.0, 1e-9);
    for method in Method::ALL {
        let class = cell("stiff_spring: whole ticks", method).class;
        let expected =
            if method == Method::ImplicitEuler { Class::Decays } else { Class::Explodes };
        assert_eq!(class, expected, "{}", method.name());
        // 340 substeps are within every limit that there is, w h = 0.49.
        let limit = method.claims().stability_limit;
        let survives = cell("stiff_spring: 340 substeps", method).class != Class::Explodes;
        assert_eq!(survives, limit > 0.49, "{}", method.name());
    }
    // The invariant of semi-implicit Euler, v² + w² x² - z w x v, lets the energy rise by 1 / (1 - z / 2).
    let z = 1e4 / (60.0 * 340.0);
    close(
        cell("stiff_spring: 340 substeps", Method::SemiImplicitEuler).number,
        z / (2.0 - z),
        0.01,
    );
}

#[test]
fn a_load_on_light_links_stretches_them_as_theory_says() {
    // Let go, it goes beyond m g / k = 0.0196 of the link, but a method that damps stays below twice that.
    let cell = cell("heavy_light_chain", Method::ImplicitEuler);
    assert!(
        cell.class == Class::Bounded && (0.0196..0.0392).contains(&cell.number),
        "{}",
        cell.number
    );
}

#[test]
fn damping_by_the_tick_flips_and_diverges_where_its_factor_does() {
    let of = |model: &str, rate: &str, method| {
        cell(&format!("over_damping: {model}, c h = {rate}"), method)
    };
    let semi = Method::SemiImplicitEuler;
    // v = (v + g h)(1 - q) comes to rest at (1 - q) g / c.
    for (rate, q) in [("0.99", 0.99), ("1.5", 1.5)] {
        let cell = of("tutorial", rate, semi);
        close(cell.number, -q, 1e-9);
        assert_eq!(cell.class, Class::Decays);
    }
    for method in Method::ALL {
        for rate in ["2.5", "100"] {
            assert_eq!(of("tutorial", rate, method).class, Class::Explodes, "{}", method.name());
            assert_ne!(of("clamped", rate, method).class, Class::Explodes, "{}", method.name());
        }
    }
    close(of("clamped", "100", semi).number, -1.0, 1e-9);
    // Exact: right in the Eulers at every rate, in the others up to the limit of their stages.
    for rate in ["0.99", "1.5", "2.5", "100"] {
        for method in [Method::ExplicitEuler, semi, Method::ImplicitEuler] {
            assert_eq!(of("exact", rate, method).class, Class::Exact, "{} {rate}", method.name());
        }
    }
    // 2 for Runge-Kutta 2, 2.785 for Runge-Kutta 4.
    for (method, limit) in [
        (Method::RungeKutta2Midpoint, 2.0),
        (Method::RungeKutta2Heun, 2.0),
        (Method::RungeKutta4, 2.785),
    ] {
        for (rate, q) in [("0.99", 0.99), ("1.5", 1.5), ("2.5", 2.5), ("100", 100.0)] {
            let expected = if q < limit { Class::Exact } else { Class::Explodes };
            assert_eq!(of("exact", rate, method).class, expected, "{} {rate}", method.name());
        }
    }
}

#[test]
fn a_million_ticks_at_rest_stay_at_rest() {
    // Rounding walks at random: without damping its energy grows by no more than the ticks do, which are 50 times those of
    // the prefix, give and take a factor of 3; with damping not at all.
    for (row, growth) in [
        ("at_rest: undamped", 150.0),
        ("at_rest: damped", 2.0),
        ("at_rest: damped, 100 km away", 2.0),
    ] {
        for method in STABLE {
            let cell = cell(row, method);
            assert!(cell.number.abs() <= 1e-9, "{row} {}: {}", method.name(), cell.number);
            let before = cell.prefix.unwrap().number;
            assert!(
                cell.number <= growth * before,
                "{row} {}: {before} {}",
                method.name(),
                cell.number
            );
        }
        // Rounding is enough to start what a method lets grow.
        assert_eq!(cell(row, Method::ExplicitEuler).class, Class::Explodes);
    }
}

#[test]
fn tiny_steps_and_large_distances_lose_no_digits() {
    for method in Method::ALL {
        assert_eq!(cell("tiny_steps", method).class, Class::Exact);
        assert_eq!(cell("far_from_origin: 10,000 km", method).class, Class::Exact);
    }
}

#[test]
fn steps_that_differ_are_known_to_every_method() {
    for (row, bound) in [("jittered_fall", 1e-10), ("gravity_toggled", 1e-10)] {
        for method in Method::ALL {
            let exact = method.claims().position_order > 1;
            let cell = cell(row, method);
            let expected = if exact { Class::Exact } else { Class::Bounded };
            assert_eq!(cell.class, expected, "{row} {}", method.name());
            assert!(!exact || cell.number <= bound, "{row} {}: {}", method.name(), cell.number);
        }
    }
    for method in Method::ALL {
        let explodes = cell("hitch: as one step", method).class == Class::Explodes;
        assert_eq!(explodes, method != Method::ImplicitEuler, "{}", method.name());
        assert_ne!(
            cell("hitch: in fixed ticks", method).class,
            Class::Explodes,
            "{}",
            method.name()
        );
    }
}

#[test]
fn what_is_refused_or_quarantined_says_why() {
    let refused = cell("coincident_points", Method::ImplicitEuler);
    assert!(
        refused.class == Class::Refused && refused.why.contains("mutual gravity"),
        "{}",
        refused.why
    );
    assert!(refused.number.is_nan());
    for method in Method::ALL {
        let cell = cell("enormous_forces: beyond range", method);
        assert_eq!(
            (cell.class, cell.number),
            (Class::Explodes, f64::INFINITY),
            "{}",
            method.name()
        );
        assert!(
            cell.why.starts_with("speck: ") && cell.why.ends_with(" in tick 31"),
            "{}",
            cell.why
        );
    }
}
