//! Every law and effect in the books: under Runge-Kutta 4 next to nothing is left over, and each line is so large that
//! leaving it out would be seen.

use motion::Method;
use motion::ledger::{Ledger, LedgerTotals};

use super::Kept;

/// A scene, what is looked at, J, and the largest residual, relative to start energy and largest kinetic energy.
struct Case {
    name: &'static str,
    scene: &'static str,
    line: fn(&Ledger) -> f64,
    bound: f64,
    /// Whether it falls with the fourth order of the tick, or is rounding at once.
    falls: bool,
}

fn books(ledger: &Ledger) -> &LedgerTotals {
    ledger.since_opening()
}

/// How much the potential of that law changed.
fn potential(ledger: &Ledger, law: &str) -> f64 {
    let [then, now] = [ledger.energies_at_opening(), ledger.energies()].map(|energies| {
        energies
            .potential
            .iter()
            .find(|(name, _)| *name == law)
            .map_or(f64::NAN, |(_, energy)| *energy)
    });
    now - then
}

const CASES: [Case; 15] = [
    Case {
        name: "quadratic drag in gusts of wind",
        scene: "drag: (linear_per_s: 0.3, quadratic_per_m: 0.2),
            wind: (velocity_m_s: (3.0, 0.0, 1.0), gust_m_s: 1.0, gust_hz: 0.8),
            bodies: [(name: \"a\", velocity_m_s: (-2.0, 4.0, 0.0), mass_kg: 2.0), (name: \"b\", position_m: (4.0, 1.0, 0.0))]",
        line: |ledger| books(ledger).energy.law("drag"),
        bound: 1e-9,
        falls: true,
    },
    Case {
        name: "linear drag in steady wind, with gravity",
        scene: "gravity: (), drag: (linear_per_s: 0.7), wind: (velocity_m_s: (3.0, 0.0, 1.0)),
            bodies: [(name: \"a\", velocity_m_s: (-2.0, 4.0, 0.0), mass_kg: 2.0)]",
        line: |ledger| books(ledger).energy.law("drag"),
        bound: 1e-9,
        falls: true,
    },
    Case {
        name: "a flag in gusts of wind",
        scene: "gravity: (), drag: (quadratic_per_m: 0.4), wind: (velocity_m_s: (4.0, 0.0, 1.0), gust_m_s: 1.0, gust_hz: 0.8),
            soft_bodies: [cloth(name: \"flag\", rows: 4, columns: 5, corner_m: (0.0, 5.0, 0.0), along_m: (1.5, 0.0, 0.5),
                down_m: (0.0, -1.0, 0.0), mass_kg: 0.5, stiffness_n_m: 20.0, damping_n_s_m: 0.02, shear: true, pinned: [left_edge])]",
        line: |ledger| books(ledger).energy.law("drag"),
        bound: 1e-7,
        falls: true,
    },
    Case {
        name: "a damped jelly on its bottom",
        scene: "gravity: (),
            soft_bodies: [lattice(name: \"jelly\", cells: (1, 2, 1), center_m: (0.0, 1.0, 0.0), size_m: (1.0, 2.0, 1.0), mass_kg: 2.0,
                stiffness_n_m: 60.0, damping_n_s_m: 0.8, pinned: [bottom])]",
        line: |ledger| books(ledger).energy.law("spring_damping"),
        bound: 1e-7,
        falls: true,
    },
    Case {
        name: "an engine of a polynomial that starts and stops within ticks",
        scene: "thrusts: [(body: \"a\", curve: polynomial([(10.0, 0.0, 0.0), (15.0, 2.0, 0.0)]), from_s: 0.1013, until_s: 0.7077)],
            bodies: [(name: \"a\", velocity_m_s: (-0.2, 0.4, 0.0), mass_kg: 2.0)]",
        line: |ledger| books(ledger).energy.law("thrusts"),
        bound: 1e-8,
        falls: false,
    },
    Case {
        name: "an engine that is a sine",
        scene: "thrusts: [(body: \"a\", curve: sine(amplitude_n: (0.0, 3.0, 0.0), angular_frequency_rad_s: 6.0, phase_rad: 0.3))],
            bodies: [(name: \"a\", velocity_m_s: (-0.2, 0.4, 0.0), mass_kg: 2.0)]",
        line: |ledger| books(ledger).energy.law("thrusts"),
        bound: 1e-8,
        falls: true,
    },
    Case {
        name: "an engine that is a table",
        scene: "thrusts: [(body: \"a\", curve: table([(0.1003, (0.0, 0.0, 0.0)), (0.4017, (0.0, 2.0, 4.0)), (0.8, (1.0, 0.0, 0.0))]))],
            bodies: [(name: \"a\", velocity_m_s: (-0.2, 0.4, 0.0), mass_kg: 2.0)]",
        line: |ledger| books(ledger).energy.law("thrusts"),
        bound: 1e-9,
        falls: false,
    },
    Case {
        name: "a damped spring to a post",
        scene: "bodies: [(name: \"post\", immovable: true), (name: \"a\", position_m: (1.4, 0.0, 0.0), velocity_m_s: (0.0, 0.4, 0.0), mass_kg: 2.0)],
            springs: [(between: (\"post\", \"a\"), stiffness_n_m: 8.0, damping_n_s_m: 1.5, rest_length_m: 1.0)]",
        line: |ledger| books(ledger).energy.law("spring_damping"),
        bound: 1e-8,
        falls: true,
    },
    Case {
        name: "exact damping of all bodies and of one",
        scene: "gravity: (), damping: (rate_per_s: 0.8),
            bodies: [(name: \"a\", velocity_m_s: (-2.0, 4.0, 0.0), mass_kg: 2.0, damping_per_s: 1.7), (name: \"b\", velocity_m_s: (1.0, 0.0, 0.0))]",
        line: |ledger| books(ledger).energy.damping,
        bound: 1e-9,
        falls: true,
    },
    Case {
        name: "a well",
        scene: "wells: [(position_m: (0.0, 0.0, 0.0), strength_m3_s2: 4.0, softening_m: 0.2)],
            bodies: [(name: \"a\", position_m: (2.0, 0.0, 0.0), velocity_m_s: (0.0, 0.6, 0.0), mass_kg: 2.0)]",
        line: |ledger| potential(ledger, "wells"),
        bound: 1e-10,
        falls: false,
    },
    Case {
        name: "mutual gravity with an immovable sun",
        scene: "mutual_gravity: (constant_m3_kg_s2: 1.0, softening_m: 0.1),
            bodies: [(name: \"sun\", immovable: true, mass_kg: 5.0), (name: \"a\", position_m: (2.0, 0.0, 0.0), velocity_m_s: (0.0, 0.6, 0.0)),
                (name: \"b\", position_m: (-1.0, 2.0, 0.0), velocity_m_s: (0.8, 0.0, 0.3), mass_kg: 0.5)]",
        line: |ledger| potential(ledger, "mutual_gravity"),
        bound: 1e-10,
        falls: false,
    },
    Case {
        name: "a speed limit",
        scene: "gravity: (), bodies: [(name: \"a\", velocity_m_s: (3.0, 0.0, 0.0), mass_kg: 2.0, max_speed_m_s: 4.0)]",
        line: |ledger| books(ledger).energy.limits,
        bound: 1e-11,
        falls: false,
    },
    Case {
        name: "a locked axis",
        scene: "gravity: (), bodies: [(name: \"a\", velocity_m_s: (3.0, 1.0, 0.0), mass_kg: 2.0, locked_axes: [x])]",
        line: |ledger| books(ledger).energy.limits,
        bound: 1e-12,
        falls: false,
    },
    Case {
        name: "a speed limit under drag, on a spring",
        scene: "gravity: (), drag: (linear_per_s: 0.4), bodies: [(name: \"post\", immovable: true),
                (name: \"a\", position_m: (0.0, -1.0, 0.0), mass_kg: 2.0, max_speed_m_s: 1.5)],
            springs: [(between: (\"post\", \"a\"), stiffness_n_m: 8.0, rest_length_m: 1.0)]",
        line: |ledger| books(ledger).energy.limits,
        bound: 1e-5,
        falls: false,
    },
    Case {
        name: "a fountain",
        scene: "gravity: (), emitters: [(name: \"fountain\", rate_per_s: 50.0, direction: (0.0, 1.0, 0.0), spread_deg: 10.0,
                speed_m_s: 6.0, life_s: 0.4, mass_kg: 0.01)]",
        line: |ledger| books(ledger).energy.interventions,
        bound: 1e-12,
        falls: false,
    },
];

#[test]
fn under_runge_kutta_4_next_to_nothing_is_left_over_and_no_line_could_be_left_out() {
    for Case { name, scene, line, bound, falls } in CASES {
        let mut kept = Kept::of(scene, Method::RungeKutta4, 240.0, 8);
        kept.run(240).check();
        let relative = kept.ledger.relative_residual();
        let line = line(&kept.ledger);
        let without = (kept.residual() + line).abs() * relative / kept.residual().abs().max(1e-300);
        assert!(relative <= bound, "{name}: {relative:e}, at most {bound:e}");
        assert!(without > 100.0 * bound, "{name}: {line} J could be left out");
        if falls {
            let mut coarse = Kept::of(scene, Method::RungeKutta4, 120.0, 8);
            let ratio = coarse.run(120).ledger.relative_residual() / relative;
            assert!(ratio > 11.0, "{name}: {ratio}");
        }
    }
}

/// What each method invents falls with its order, which is the evidence that no line is missing.
#[test]
fn under_every_method_the_residual_falls_with_the_tick() {
    for Case { name, scene, .. } in CASES {
        for method in Method::ALL {
            if name.contains("mutual") && method == Method::ImplicitEuler {
                continue;
            }
            let residual = |hz: u32| {
                let mut kept = Kept::of(scene, method, f64::from(hz), 1);
                kept.run(hz).check().ledger.relative_residual()
            };
            let [coarse, fine] = [residual(240), residual(960)];
            assert!(fine < 0.5 * coarse || fine < 1e-9, "{name}, {method:?}: {coarse:e} {fine:e}");
        }
    }
}
