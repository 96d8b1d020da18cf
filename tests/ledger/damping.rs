//! Damping: every model as its multiplier or its law has it, with a residual of the order of the method.

use glam::DVec3;
use motion::ledger::Ledger;
use motion::{DampingModel, Method};

use super::Kept;

const MASS: f64 = 2.0;
const RATE: f64 = 0.8;
const G: f64 = -9.8;

fn falling(model: DampingModel, method: Method, hz: f64, substeps: u32) -> Kept {
    let scene = format!(
        "gravity: (acceleration_m_s2: (0.0, {G}, 0.0)), damping: (model: {}, rate_per_s: {RATE}),
         bodies: [(name: \"stone\", velocity_m_s: (3.0, 1.0, 0.0), mass_kg: {MASS})]",
        model.name()
    );
    Kept::of(&scene, method, hz, substeps)
}

/// Energy that a factor takes of a velocity, J.
fn taken(v: DVec3, factor: f64) -> f64 {
    MASS * v.dot(v) * (1.0 - factor * factor) / 2.0
}

#[test]
fn the_multipliers_take_what_they_take() {
    let (hz, g) = (50.0, DVec3::Y * G);
    let h = 1.0 / hz;
    let k = 1.0 - RATE * h;
    for model in [DampingModel::Tutorial, DampingModel::Clamped] {
        for method in Method::ALL {
            let mut kept = falling(model, method, hz, 1);
            let mut lost = 0.0;
            for _ in 0..100 {
                let before = kept.v("stone");
                kept.tick();
                let after = kept.v("stone");
                lost += match (method, model) {
                    (Method::ExplicitEuler, _) => taken(before, k),
                    (Method::SemiImplicitEuler, _) => taken(before + g * h, k),
                    (_, DampingModel::Clamped) => taken(before, k),
                    _ => taken(after / k, k),
                };
            }
            let booked = kept.check().ledger.since_opening().energy.damping;
            assert!((booked + lost).abs() < 1e-11 * lost, "{model:?} {method:?}: {booked} {lost}");
        }
    }
}

#[test]
fn the_exact_model_takes_the_integral_along_its_exponential() {
    // The exponential of the Eulers is the exact solution here: its integral is the closed form over all the time.
    let (hz, ticks) = (20.0, 60_u32);
    let t = f64::from(ticks) / hz;
    let (v0, a) = (DVec3::new(3.0, 1.0, 0.0), DVec3::Y * G);
    let last = a / RATE;
    let (first, decay) = (v0 - last, -(-RATE * t).exp_m1());
    let squared = last.dot(last) * t
        + 2.0 * last.dot(first) * decay / RATE
        + first.dot(first) * -(-2.0 * RATE * t).exp_m1() / (2.0 * RATE);
    let lost = MASS * RATE * squared;
    for method in [Method::ExplicitEuler, Method::SemiImplicitEuler] {
        let mut kept = falling(DampingModel::Exact, method, hz, 1);
        let books = kept.run(ticks).check().ledger.since_opening();
        assert!(
            (books.energy.damping + lost).abs() < 1e-11 * lost,
            "{method:?}: {books:?}, {lost}"
        );
        assert!(books.momentum.residual.length() < 1e-11, "{method:?}: {books:?}");
    }
}

/// Orders that the residual falls with as ticks grow shorter; `None` is rounding at once.
fn order(model: DampingModel, method: Method) -> Option<f64> {
    match (method, model) {
        (Method::ExplicitEuler | Method::SemiImplicitEuler, _) => Some(1.0),
        (_, DampingModel::Exact) => Some(4.0),
        // Between two multipliers it solves a constant acceleration exactly.
        _ => None,
    }
}

#[test]
fn the_residual_vanishes_with_the_order_of_the_method() {
    for model in DampingModel::ALL {
        for method in [Method::ExplicitEuler, Method::SemiImplicitEuler, Method::RungeKutta4] {
            let residual = |hz: u32, substeps: u32| {
                let mut kept = falling(model, method, f64::from(hz), substeps);
                kept.run(2 * hz).check().residual()
            };
            let Some(order) = order(model, method) else {
                assert!(residual(40, 1).abs() < 1e-11, "{model:?} {method:?}");
                continue;
            };
            // Fine enough for its first term, and coarse enough to be above rounding.
            let hz = if order == 1.0 { 320 } else { 40 };
            let [coarse, fine] = [residual(hz, 1), residual(2 * hz, 1)];
            let measured = (coarse / fine).log2();
            assert!((measured - order).abs() < 0.06, "{model:?} {method:?}: {coarse:e} {fine:e}");
            assert!(coarse.abs() > 1e-8, "{model:?} {method:?} invents enough to be seen");
            if order == 1.0 {
                // Substeps of the same length invent as much.
                let parts = residual(hz / 2, 2);
                let same = (parts - coarse).abs() < 1e-9 * coarse.abs();
                assert!(same, "{model:?} {method:?}: {parts:e} {coarse:e}");
            }
        }
    }
}

#[test]
fn a_factor_that_turns_or_stops_a_body_is_booked_too() {
    // q = 1.5 turns, q = 1 stops, q = 40 clamps.
    for rate in [60.0, 40.0, 1600.0] {
        for model in DampingModel::ALL {
            for method in [Method::ExplicitEuler, Method::SemiImplicitEuler, Method::RungeKutta4] {
                let scene = format!(
                    "damping: (model: {}, rate_per_s: {rate}),
                     bodies: [(name: \"stone\", velocity_m_s: (3.0, 1.0, 0.0), mass_kg: 2.0)]",
                    model.name()
                );
                let exact = model == DampingModel::Exact && method == Method::RungeKutta4;
                let diverges = model == DampingModel::Tutorial && rate > 100.0;
                if exact || diverges {
                    continue;
                }
                let mut kept = Kept::of(&scene, method, 40.0, 1);
                kept.run(5).check();
                let books = kept.ledger.since_opening();
                let wrong = books.energy.residual.abs() / kept.ledger.energies_at_opening().total();
                assert!(wrong < 1e-12, "{rate} {model:?} {method:?}: {books:?}");
                assert!(
                    books.energy.damping < 0.0 && books.momentum.residual.length() < 1e-12,
                    "{books:?}"
                );
            }
        }
    }
}

/// Bodies of every kind under one damping: free, with a limit, with a locked axis, with both, with a rate of its own, and a
/// pair of such on a spring of no stiffness to speak of.
fn kinds(model: Option<DampingModel>, rate: f64, gravity: &str) -> String {
    let damping = model.map_or(String::new(), |model| {
        format!("damping: (model: {}, rate_per_s: {rate}),", model.name())
    });
    let own =
        if model.is_some() { format!(", damping_per_s: {}", 0.3 * rate) } else { String::new() };
    let kinds = [
        "",
        ", max_speed_m_s: 2",
        ", locked_axes: [y]",
        ", max_speed_m_s: 2, locked_axes: [y]",
        &own,
    ];
    let mut bodies = String::new();
    for pair in [false, true] {
        for (number, kind) in kinds.iter().enumerate() {
            let name = if pair { format!("p{number}") } else { format!("s{number}") };
            bodies += &format!(
                "(name: \"{name}\", position_m: ({number}, 0, 9), velocity_m_s: (3, 1, -2), mass_kg: 2{kind}),"
            );
        }
    }
    let springs: String = (1..5)
        .map(|end| format!("(between: (\"p{}\", \"p{end}\"), stiffness_n_m: 1e-13),", end - 1))
        .collect();
    format!("{gravity} {damping} bodies: [{bodies}], springs: [{springs}]")
}

#[test]
fn the_books_close_whatever_stands_between_the_substeps() {
    let push = DVec3::new(300.0, -200.0, 90.0);
    for (rate, gravity) in [(0.8, ""), (60.0, ""), (60.0, "gravity: (),")] {
        for model in [None].into_iter().chain(DampingModel::ALL.map(Some)) {
            for method in Method::ALL {
                // There it is a law, whose impulse and work are of the order of the ledger.
                let is_law = !matches!(method, Method::ExplicitEuler | Method::SemiImplicitEuler);
                if is_law && model == Some(DampingModel::Exact) {
                    continue;
                }
                for substeps in [1, 2, 5, 8] {
                    let mut kept = Kept::of(&kinds(model, rate, gravity), method, 60.0, substeps);
                    // The first step of position Verlet has half a kick.
                    kept.run(1);
                    kept.ledger = Ledger::open(&kept.simulation.world);
                    for tick in 0..6 {
                        for number in 0..5 {
                            if tick % 2 == 0 {
                                kept.push(&format!("s{number}"), push)
                                    .push(&format!("p{number}"), push);
                            }
                        }
                        kept.tick();
                    }
                    let books = kept.check().ledger.since_opening();
                    let what =
                        format!("{model:?} {rate}/s {method:?} {substeps} {gravity}: {books:?}");
                    assert!(books.momentum.residual.length() < 1e-9, "{what}");
                    // Gravity has a potential, which the Eulers miss by their order.
                    assert!(!gravity.is_empty() || books.energy.residual.abs() < 1e-9, "{what}");
                    let lost = books.energy.damping + books.energy.limits;
                    assert!(lost < -10.0 && books.energy.pushes > 10.0, "{what}");
                    for number in 0..5 {
                        let [single, member] =
                            ["s", "p"].map(|kind| kept.v(&format!("{kind}{number}")));
                        assert!(single.distance(member) < 1e-9, "{number} {what}");
                    }
                }
            }
        }
    }
}
