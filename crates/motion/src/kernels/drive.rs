//! The driver of a tick: segment by segment, with damping inside the steps or around them all.

use super::TickParameters;
use crate::laws::damping::Decay;
use crate::laws::tick_times::{Segment, Segments};
use crate::methods::{Field, Integrator, StepState};

/// A field that is driven through a tick segment by segment.
pub(crate) trait TickField: Field + Sized {
    /// Enters the next segment of the tick, in which the damping of all bodies is `decay`.
    fn enter<M: Integrator>(&mut self, segment: Segment, decay: Decay);

    /// Begins a step in the state that the last one left.
    fn begin_step(&mut self) {}

    /// The length of the step, s, up to the first discontinuity that depends on the state, on the way to (`x`, `v`); `None` if
    /// there is none. The step is then taken again up to there.
    fn ends_early(&mut self, x: Self::Space, v: Self::Space) -> Option<f64> {
        let _ = (x, v);
        None
    }

    /// Frees memory of the last step: of all elements of the space but the state and what the method keeps.
    fn recycle(&mut self, x: &mut Self::Space, v: &mut Self::Space, step_state: &mut StepState<Self>) {
        let _ = (x, v, step_state);
    }

    /// Applies damping, speed limit and locks before the tick of a method with damping around its ticks.
    fn before_tick(&mut self, x: Self::Space, v: Self::Space) -> (Self::Space, Self::Space);

    /// Ends a step; returns the state from which the next one starts.
    fn after_step<M: Integrator>(
        &mut self,
        x: Self::Space,
        v: Self::Space,
        step_state: &mut StepState<Self>,
    ) -> (Self::Space, Self::Space);

    /// Applies damping, speed limit and locks after the tick of a method with damping around its ticks.
    fn after_tick(&mut self, x: Self::Space, v: Self::Space) -> (Self::Space, Self::Space);
}

/// Integrates a tick of `M` from the state (`x`, `v`).
#[inline(always)]
pub(crate) fn drive<M: Integrator, F: TickField>(
    field: &mut F,
    parameters: &TickParameters<'_>,
    segments: &Segments,
    mut x: F::Space,
    mut v: F::Space,
    step_state: &mut StepState<F>,
) -> (F::Space, F::Space) {
    if !M::DAMPS_INSIDE {
        (x, v) = field.before_tick(x, v);
    }
    for (number, mut segment) in segments.iter().enumerate() {
        if number > 0 {
            field.recycle(&mut x, &mut v, step_state);
        }
        loop {
            field.enter::<M>(segment, parameters.decay_in(segment));
            field.begin_step();
            if segment.jump {
                // It was evaluated before the jump.
                step_state.start = None;
            }
            let StepState { last_step, start } = *step_state;
            let (to_x, to_v) = M::step(field, x, v, step_state);
            let Some(length) = field.ends_early(to_x, to_v) else {
                (x, v) = field.after_step::<M>(to_x, to_v, step_state);
                break;
            };
            (step_state.last_step, step_state.start) = (last_step, start);
            let (first, rest) = segment.split(length);
            if length > 0.0 {
                field.enter::<M>(first, parameters.decay_in(first));
                (x, v) = M::step(field, x, v, step_state);
                (x, v) = field.after_step::<M>(x, v, step_state);
            }
            segment = rest;
        }
    }
    if M::DAMPS_INSIDE { (x, v) } else { field.after_tick(x, v) }
}
