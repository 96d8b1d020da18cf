//! Times of ticks as tables: methods ranked in double precision, and what arrays take in each precision.

use motion::Method;

use super::numbers::{NONE, duration, number};
use super::words::{bodies, title};
use lab::cost::{Host, Place, Study, TickTime};

/// Titles of [`rows`].
pub(crate) fn header(study: &Study) -> [String; 6] {
    let with = format!("per body per step with {}", bodies(study.size()));
    let ratio = format!("times {}", base(study).map_or_else(String::new, |(method, _)| title(method)));
    ["rank", "method", "fixed per tick", "per body per step", &with, &ratio].map(str::to_owned)
}

/// Methods by the time of a step, the shortest first; "=" is on those that tie.
pub(crate) fn rows(study: &Study) -> Vec<[String; 6]> {
    let places = study.ranking();
    let Some((_, unit)) = base(study) else { return Vec::new() };
    let mut rank = 0;
    let row = |(i, place): (usize, &Place)| {
        let Place { method, ns_per_body_step, tied } = *place;
        if !tied {
            rank = i + 1;
        }
        let shares = tied || places.get(i + 1).is_some_and(|next| next.tied);
        let line = study.world_times().find(|of| of.method == method);
        let of = |ns: fn(&TickTime) -> f64| line.map_or_else(|| NONE.to_owned(), |of| duration(ns(of), 2));
        [
            format!("{rank}{}", if shares { " =" } else { "" }),
            method.claims().title.to_owned(),
            of(|of| of.fixed_ns),
            of(|of| of.ns_per_body_step),
            duration(ns_per_body_step, 2),
            number(ns_per_body_step / unit, 2),
        ]
    };
    places.iter().enumerate().map(row).collect()
}

/// What methods are compared with: semi-implicit Euler, or the first.
fn base(study: &Study) -> Option<(Method, f64)> {
    let places = study.ranking();
    let plain = places.iter().find(|place| place.method == Method::SemiImplicitEuler).or(places.first())?;
    Some((plain.method, plain.ns_per_body_step))
}

/// Titles of [`of_arrays`].
pub(crate) const ARRAYS: [&str; 4] = ["method", "precision", "fixed per tick", "per body per step"];

/// Times on plain arrays, by method and precision.
pub(crate) fn of_arrays(study: &Study) -> Vec<[String; 4]> {
    let row = |of: &TickTime| {
        [
            of.method.claims().title.to_owned(),
            of.precision.name().to_owned(),
            duration(of.fixed_ns, 2),
            duration(of.ns_per_body_step, 2),
        ]
    };
    study.tick_times.iter().filter(|of| of.host == Host::Arrays).map(row).collect()
}
