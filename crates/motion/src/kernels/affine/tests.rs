//! Tests that every way in which a table can be integrated gives the same bits.

use super::*;
use crate::kernels::blocks;
use crate::kernels::{BodyOptions, Kernel, StepStatistics};
use crate::laws::Affine;
use crate::laws::damping::{Damping, DampingModel};
use crate::laws::tick_times::TickTimes;
use crate::methods::table::Method;
use crate::methods::{Traits, with_method};

const ROWS: usize = 11;

/// Positions and rows of a small table.
#[derive(Clone, Debug, PartialEq)]
struct State {
    x: Vec<[f64; 3]>,
    bodies: Vec<Row>,
    steps: Vec<f64>,
}

impl State {
    fn new(h: f64) -> Self {
        let number = |i: usize, k: f64| 0.1 * i as f64 + k / (i + 1) as f64;
        Self {
            x: (0..ROWS).map(|i| [number(i, 1.0), number(i, 2.0), number(i, -3.7)]).collect(),
            bodies: (0..ROWS)
                .map(|i| [number(i, 0.3), number(i, 5.0), number(i, -0.7), (i as f64 / 3.0)])
                .collect(),
            // One body is new; the velocity of another one was reversed.
            steps: (0..ROWS).map(|i| [h, h, 0.0, h, h, h, h, h, h, -h, h][i]).collect(),
        }
    }

    fn batch<'a, M: Integrator>(&'a mut self, applied: AppliedForces<'a>) -> Batch<'a> {
        let method_state = match M::STATE {
            MethodStateKind::LastStep => MethodStateRows::LastStep(&mut self.steps),
            _ => MethodStateRows::None,
        };
        Batch {
            positions: &mut self.x,
            bodies: &mut self.bodies,
            applied: Some(applied),
            method_state,
        }
    }
}

fn parameters<M: Integrator>(
    damping: Option<Damping>,
    drag: f64,
    substeps: u32,
) -> TickParameters<'static> {
    let h = 1.0 / 120.0;
    let times = TickTimes { start: 0.0, end: h, tick: h, substeps };
    let gravity = glam::DVec3::new(0.1, -9.8, 1e-3);
    let affine = Affine { constant: gravity, rate: drag };
    TickParameters::new(Traits::of::<M>(), affine, damping, &[], 0, times)
}

/// The state after 50 ticks by each of the ways in which a table can be integrated.
fn every_way<M: Integrator>(damping: Option<Damping>, drag: f64, substeps: u32) -> Vec<State> {
    let parameters = parameters::<M>(damping, drag, substeps);
    let forces: Vec<[f64; 3]> = (0..ROWS)
        .map(|i| if [1, 2, 7, 10].contains(&i) { [i as f64, 1.0, -1.0] } else { [0.0; 3] })
        .collect();
    let pushed = [1, 2, 7, 10].map(|row| (0, row));
    let applied = AppliedForces { forces: &forces, rows: &pushed, offset: 0 };
    let start = State::new(parameters.times.tick);
    let mut states = Vec::new();
    let mut run = |tick: &mut dyn FnMut(&mut State)| {
        let mut state = start.clone();
        (0..50).for_each(|_| tick(&mut state));
        assert!(state.bodies.iter().flatten().all(|number| number.is_finite()));
        states.push(state);
    };
    let refuse = &mut |row, breach| panic!("row {row} refused: {breach:?}");
    let statistics = &mut StepStatistics::default();
    run(&mut |state| {
        let batch = &mut state.batch::<M>(applied);
        (Kernel::of::<M>().integrate)(&parameters, batch, 0..ROWS, None, statistics, refuse);
    });
    run(&mut |state| {
        let batch = &mut state.batch::<M>(applied);
        blocks::run::<M>(&parameters, &BodyOptions::NONE, None, batch, 0..ROWS, statistics, refuse);
    });
    run(&mut |state| {
        let batch = &mut state.batch::<M>(applied);
        for row in 0..ROWS {
            let done = Kernel::of::<M>().integrate_row(
                &parameters,
                BodyOptions::NONE,
                batch,
                row,
                statistics,
            );
            assert_eq!(done, Ok(()));
        }
    });
    states
}

#[test]
fn every_kernel_and_instruction_set_gives_the_same_bits() {
    let models = DampingModel::ALL.map(|model| Some(Damping { model, rate: 0.4 }));
    for method in Method::ALL {
        for (damping, drag) in
            [None, models[0], models[1], models[2]].into_iter().zip([0.3, 0.0, 0.0, 0.3])
        {
            for substeps in [1, 3] {
                let all = with_method!(method, M => every_way::<M>(damping, drag, substeps));
                assert!(
                    all.iter().all(|state| *state == all[0]),
                    "{method:?} {damping:?} {drag} {substeps}"
                );
            }
        }
    }
}
