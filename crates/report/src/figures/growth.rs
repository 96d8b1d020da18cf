//! Time of a step per body against the number of bodies.

use lab::cost::{Machine, Study, TickTime, TimedTick};

use crate::chart::{Axis, Chart, Drawing};
use crate::numbers::{duration, number};
use crate::words::bodies;

/// Bytes of a body that a step in a world reads and writes: position, velocity and inverse mass.
const BODY: f64 = 56.0;

pub(super) fn figure(study: &Study, machine: &Machine) -> Option<Drawing> {
    let grows = |of: &&TickTime| of.substeps.is_some() && of.points.len() > 1;
    let curves: Vec<_> = study.world_times().filter(grows).collect();
    curves.first()?;
    let per_body = |point: &TimedTick| point.ns / point.body_steps;
    let points = || curves.iter().flat_map(|of| &of.points);
    let x = Axis::logarithmic("bodies", points().map(|point| point.body_steps), |count| {
        number(count, 2)
    });
    let y = Axis::logarithmic("CPU time of a step per body", points().map(per_body), |ns| {
        duration(ns, 1)
    });
    let mut chart = Chart::new(format!("{}: time of a step per body", study.subject), x, y, 620);
    for of in &curves {
        let title = of.method.claims().title;
        let line: Vec<_> =
            of.points.iter().map(|point| (point.body_steps, per_body(point))).collect();
        chart.curve(of.method, &[], &line);
        for (point, (count, ns)) in of.points.iter().zip(&line) {
            let words = format!(
                "{title}, {}: {} per body",
                bodies(point.body_steps as usize),
                duration(*ns, 2)
            );
            chart.point(of.method, *count, *ns, &words);
        }
        chart.legend_method(of.method, title);
    }
    for (size, level) in machine.caches.iter().zip(1..) {
        chart.limit(*size as f64 / BODY, &format!("cache {level}: {} KiB", size >> 10));
    }
    Some(chart.finish())
}
