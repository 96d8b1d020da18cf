//! Limits that were measured by running methods, and maps of them.

use std::f64::consts::PI;

use lab::limits::{
    Criterion, Limit, LongRun, Net, Oscillator, damping_map, nets, oscillators, stiffness_map,
};
use motion::{DampingModel, Method};

/// All that are farther from theory than `bound`.
fn far(limits: &[Limit], bound: f64) -> Vec<String> {
    // Not "above": a difference that is no number is far as well.
    let near = |limit: &Limit| limit.relative_difference().abs() <= bound;
    let far = limits.iter().filter(|limit| !near(limit));
    far.map(|limit| format!("{} {}: {} {}", limit.system, limit.method, limit.measured, limit.theory))
        .collect()
}

#[test]
fn limits_of_oscillators_are_their_closed_forms() {
    let limits: Vec<_> = oscillators().iter().map(Oscillator::limit).collect();
    assert_eq!(limits.len(), 6 * Method::ALL.len() + 2 * DampingModel::ALL.len() * 5);
    let far = far(&limits, 0.002);
    assert!(far.is_empty(), "{far:#?}");
    let judged = |criterion| limits.iter().filter(|limit| limit.criterion == criterion).count();
    assert!(judged(Criterion::Amplitude) > 30 && judged(Criterion::SpectralRadius) > 10);
    let heun = ["oscillator", "runge_kutta_2_heun", "never", "never", "+0.000 %", "spectral radius"];
    assert!(limits.iter().any(|limit| limit.cells() == heun), "{limits:#?}");
}

#[test]
fn limits_of_nets_are_those_of_their_fastest_mode() {
    let nets = nets(20);
    let limits: Vec<_> = nets.iter().flat_map(|net| Method::ALL.map(|method| net.limit(method))).collect();
    assert_eq!(limits.len(), 24 * Method::ALL.len());
    let judged = |criterion| limits.iter().filter(|limit| limit.criterion == criterion).count();
    assert_eq!((judged(Criterion::Amplitude), judged(Criterion::Energy)), (24 * 6, 24 * 3));
    let far = far(&limits, 0.002);
    assert!(far.is_empty(), "{far:#?}");
}

#[test]
fn the_fastest_mode_of_a_chain_has_a_closed_form() {
    // 2 sqrt(k / m) cos(pi / (2 n + 1)) of n bodies that hang on one end.
    let (found, closed) = (Net::chain(1.0).largest_frequency(), 20.0 * (PI / 21.0).cos());
    assert!((found / closed - 1.0).abs() <= 1e-9, "{found} for {closed}");
}

#[test]
fn maps_show_where_the_closed_forms_say_that_it_grows() {
    for map in [stiffness_map(24), damping_map(24)] {
        let [steps, others] = &map.places;
        let cell = steps[1] / steps[0] * (1.0 + 1e-9);
        for panel in &map.panels {
            for (other, row) in others.iter().zip(panel.classes.chunks(steps.len())) {
                let near = |(_, at): &&(f64, f64)| (at / other - 1.0).abs() <= 0.06;
                let Some((limit, _)) = panel.theory.iter().find(near) else {
                    let never = panel.theory.is_empty() && panel.method != Method::ImplicitEuler;
                    // What grows too slowly for a number does so at the shortest steps.
                    let is_long = |h: f64| h > 0.05 * steps[steps.len() - 1];
                    let mut long = steps.iter().zip(row).filter(|(h, _)| is_long(**h));
                    let grows = long.all(|(_, class)| *class == LongRun::Grows);
                    assert!(grows || !never, "{:?} {other}", panel.method);
                    continue;
                };
                for (h, class) in steps.iter().zip(row) {
                    let grows = *class == LongRun::Grows;
                    if *h < limit / cell {
                        assert!(!grows, "{:?} {h} {other}", panel.method);
                    } else if *h > limit * cell && panel.method != Method::Yoshida4 {
                        // Yoshida's middle step goes back in time; damped, it has stable windows beyond its limit.
                        assert!(grows, "{:?} {h} {other}", panel.method);
                    }
                }
            }
        }
        let seen = |method: Method, class| {
            map.panels.iter().any(|panel| panel.method == method && panel.classes.contains(&class))
        };
        for method in Method::ALL {
            assert_eq!(seen(method, LongRun::Grows), method != Method::ImplicitEuler, "{method:?}");
        }
        let svg = report::stability::picture(&map).document();
        assert!(svg.starts_with("<svg") && svg.contains("Runge-Kutta 4"), "{}", svg.len());
    }
}
