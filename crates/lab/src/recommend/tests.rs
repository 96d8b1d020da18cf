//! Choices from made-up studies, against trying every choice.

use motion::Method;

use super::*;
use crate::cost::{Cell, Counts, Errors, Failure, Outcome, Time, Truth};

/// A study of 2 bodies over 2 s with a cell for each (error, m; ms for 1/60 s); an error of NaN is a failed run.
fn study(own_error: f64, points: &[(f64, f64)]) -> Study {
    let cell = |(i, (error, ms)): (usize, &(f64, f64))| {
        let rate = 1e3 / (60.0 * ms);
        let errors = Errors {
            relative: *error,
            position_m: *error,
            velocity_m_s: *error,
            position_rms_m: *error,
            ..Errors::default()
        };
        let failed = Outcome::Failed(Failure::BlewUp);
        let method = Method::ALL[i % Method::ALL.len()];
        let setting = Setting { method, substeps: (1 + i as u32).into() };
        Cell {
            outcome: if error.is_nan() { failed } else { Outcome::Finished(errors) },
            counts: Counts { accelerations: 1000 * (1 + i as u64), solver: 200 },
            time: Some(Time {
                ns_per_body_step: 1e9 / (rate * 2.0 * 100.0 * (1.0 + i as f64)),
                real_time_factor: rate,
                yardsticks: 1.0,
                quartiles: [1.0; 3],
            }),
            ..Cell::not_run(setting)
        }
    };
    let reference = Truth::Reference {
        method: Method::RungeKutta4,
        substeps: 64,
        relative_error: own_error,
        position_error_m: own_error,
        exact_damping: false,
    };
    let cells: Vec<_> = points.iter().enumerate().map(cell).collect();
    Study {
        subject: "made up".to_owned(),
        description: String::new(),
        step_hz: 100.0,
        ticks: 200,
        simulated_s: 2.0,
        bodies: 2,
        period_s: None,
        own: Setting { method: Method::SemiImplicitEuler, substeps: 1.into() },
        truth: reference,
        position_scale_m: 1.0,
        velocity_scale_m_s: 1.0,
        cells,
        timed_bodies: None,
        tick_times: Vec::new(),
        drifts: Vec::new(),
        rates: Vec::new(),
        notes: Vec::new(),
    }
}

fn untimed(mut study: Study) -> Study {
    study.cells.iter_mut().for_each(|cell| cell.time = None);
    study
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * b.abs()
}

/// Pseudorandom numbers that are the same in every run: the generator of Lehmer (1951), multiplier 48271.
fn random(state: &mut u64) -> f64 {
    *state = *state * 48_271 % 0x7fff_ffff;
    *state as f64 / 2_147_483_647.0
}

#[test]
fn each_part_gets_the_cheapest_point_below_the_error_and_the_dear_one_sets_the_price() {
    // The third point is dominated; the fourth run failed.
    let stiff = study(0.0, &[(1e-1, 1.0), (1e-4, 4.0), (2e-3, 5.0), (f64::NAN, 0.1), (1e-6, 16.0)]);
    let free = study(0.0, &[(1e-5, 0.5), (1e-7, 1.0)]);
    let found = recommend(&[("cloth", &stiff), ("free bodies", &free)], Goal::Error(1e-3)).unwrap();
    let rows: Vec<_> =
        found.rows.iter().map(|row| (row.part.as_str(), row.pick.setting.substeps)).collect();
    assert_eq!(rows, [("cloth", 2.into()), ("free bodies", 1.into())]);
    assert!(near(found.total, 4.5) && near(found.rows[0].share, 4.0 / 4.5), "{found:?}");
    assert_eq!((found.unit, found.dearest, found.limiting), (Unit::Milliseconds, 0, 0));
    assert_eq!((found.rows[0].pick.error_m, found.rows[0].bodies), (1e-4, 2));
    // A tenth of that error is reached by the same points.
    let next = found.next.unwrap();
    assert!(near(next.total, 4.5) && next.picks.is_empty(), "{next:?}");

    let found = recommend(&[("cloth", &stiff), ("free bodies", &free)], Goal::Error(1e-4)).unwrap();
    let next = found.next.unwrap();
    assert!(near(next.total, 16.5) && next.error_m == 1e-4 / 10.0, "{next:?}");
    assert_eq!(
        next.picks.iter().map(|(i, point)| (*i, point.setting.substeps)).collect::<Vec<_>>(),
        [(0, 5.into())]
    );
    let found = recommend(&[("cloth", &stiff)], Goal::Error(1e-6)).unwrap();
    assert_eq!(found.next, None, "nothing was measured at 1e-7 m");
}

#[test]
fn without_times_evaluations_are_the_price_and_no_time_is_promised() {
    let part = untimed(study(0.0, &[(1e-2, 9.0), (1e-4, 1.0)]));
    let timed = study(0.0, &[(1e-2, 9.0), (1e-4, 1.0)]);
    // One part without times suffices.
    let parts = [("a", &part), ("b", &timed)];
    let found = recommend(&parts, Goal::Error(1e-3)).unwrap();
    assert_eq!(found.unit, Unit::Evaluations);
    // 2200 evaluations in two seconds for each part.
    assert!(near(found.total, 2.0 * 2200.0 / 2.0 / 60.0), "{found:?}");
    assert_eq!(recommend(&parts, Goal::Budget(1.0)), Err(Refusal::NoTimes));
}

#[test]
fn what_cannot_be_reached_or_told_is_refused_in_words() {
    let part = study(1e-6, &[(1e-2, 1.0), (1e-4, 2.0)]);
    let words = |goal| recommend(&[("rope", &part)], goal).unwrap_err().to_string();
    assert_eq!(
        words(Goal::Error(1e-5)),
        "rope: nothing reaches an error of 1e-5 m: the best is semi_implicit_euler x 2 at 1.0e-4 m; \
         give a larger error"
    );
    assert!(words(Goal::Error(1e-7)).contains("the reference itself may be off by 1.0e-6 m"));
    assert!(words(Goal::Budget(0.5)).contains("the cheapest takes 1.00e0 ms"));
    let lost = study(f64::NAN, &[(1e-2, 1.0)]);
    let refused = recommend(&[("rope", &lost)], Goal::Error(1.0));
    assert!(matches!(refused, Err(Refusal::Uncertain { .. })), "{refused:?}");
    let failed = study(0.0, &[(f64::NAN, 1.0)]);
    for goal in [Goal::Error(1.0), Goal::Budget(1.0)] {
        let refused = recommend(&[("rope", &part), ("jelly", &failed)], goal);
        assert_eq!(refused, Err(Refusal::NothingFinished { part: "jelly".to_owned() }));
        assert_eq!(recommend(&[], goal), Err(Refusal::NothingMoves));
    }
}

#[test]
fn errors_below_the_references_own_buy_nothing() {
    // The second and the third error differ by less than the reference's own error.
    let part = study(1e-5, &[(1e-2, 1.0), (1e-6, 2.0), (1e-8, 3.0)]);
    let found = recommend(&[("rope", &part)], Goal::Budget(10.0)).unwrap();
    assert_eq!(found.rows[0].pick.setting.substeps, 2.into());
    assert_eq!((found.next, found.rows[0].reference_error_m), (None, 1e-5));
}

/// Every combination of one finished cell per part, as (largest error, price).
fn every_choice(parts: &[Study]) -> Vec<(f64, f64)> {
    parts.iter().fold(vec![(0.0, 0.0)], |choices, part| {
        let (_, own) = part.truth.own_error();
        let points = part.cells.iter().filter_map(|cell| {
            let price = 1e3 / 60.0 / cell.time.as_ref()?.real_time_factor;
            Some((cell.errors()?.position_m.max(own) + own, price))
        });
        let points: Vec<_> = points.collect();
        let longer = |(error, price): (f64, f64)| {
            points.iter().map(move |(e, p)| (error.max(*e), price + p)).collect::<Vec<_>>()
        };
        choices.into_iter().flat_map(longer).collect()
    })
}

#[test]
fn no_other_choice_is_better() {
    let mut state = 20_261_121;
    let (mut within_budget, mut refused) = (0, 0);
    for _ in 0..200 {
        let mut point = |_| {
            let failed = random(&mut state) < 0.2;
            let error = 10.0_f64.powf(-6.0 * random(&mut state));
            (if failed { f64::NAN } else { error }, 0.01 + 5.0 * random(&mut state))
        };
        let parts: Vec<_> = (0..3)
            .map(|_| study(1e-5, &(0..6).map(&mut point).chain([(0.9, 8.0)]).collect::<Vec<_>>()))
            .collect();
        let named: Vec<_> = parts.iter().map(|part| ("part", part)).collect();
        let choices = every_choice(&parts);
        let budget = 0.2 + 10.0 * random(&mut state);
        let affordable = choices.iter().filter(|(_, price)| *price <= budget * (1.0 + 1e-12));
        let best = affordable.map(|(error, _)| *error).fold(f64::INFINITY, f64::min);
        let cheapest = |error: f64| {
            let good = choices.iter().filter(|(of, _)| *of <= error);
            good.map(|(_, price)| *price).fold(f64::INFINITY, f64::min)
        };
        match recommend(&named, Goal::Budget(budget)) {
            Ok(found) => {
                within_budget += 1;
                let error = found
                    .rows
                    .iter()
                    .map(|row| row.pick.error_m.max(1e-5) + 1e-5)
                    .fold(0.0, f64::max);
                assert_eq!(error, best);
                assert!(
                    near(found.total, cheapest(best)),
                    "{} and {}",
                    found.total,
                    cheapest(best)
                );
                assert!(near(found.rows.iter().map(|row| row.share).sum(), 1.0));
                let better = choices.iter().map(|(error, _)| *error).filter(|error| *error < best);
                let next = better.fold(0.0, f64::max);
                assert_eq!(found.next.is_some(), next > 0.0);
                if let Some(rung) = found.next {
                    assert!(rung.error_m <= next && rung.total > budget && !rung.picks.is_empty());
                    assert!(near(rung.total, cheapest(next)));
                }
            }
            Err(refusal) => {
                refused += 1;
                let Refusal::BudgetTooSmall { least_ms, .. } = refusal else { panic!("{refusal}") };
                assert!(best.is_infinite() && near(least_ms, cheapest(f64::INFINITY)));
            }
        }
        let error = 10.0_f64.powf(-3.0 * random(&mut state));
        match recommend(&named, Goal::Error(error)) {
            Ok(found) => assert!(near(found.total, cheapest(error))),
            Err(_) => assert!(cheapest(error).is_infinite()),
        }
        for (row, part) in recommend(&named, Goal::Error(1.0)).unwrap().rows.iter().zip(&parts) {
            let front = part.front(Accuracy::Position, Cost::Time);
            assert!(
                front.iter().any(|cell| cell.setting == row.pick.setting),
                "it lies on the measured front"
            );
        }
    }
    assert!(within_budget > 50 && refused > 5, "{within_budget} and {refused}");
}
