//! The driver of a tick: segment by segment, with damping inside the steps or around them all.

use super::record::{Note, Recorder, vector};
use super::{Row, TickParameters};
use crate::laws::damping::Decay;
use crate::laws::tick_times::{Segment, Segments};
use crate::methods::{Field, Integrator, StepState};

/// A field that is driven through a tick segment by segment. Damping, speed limits and axis locks, and their records, are
/// written here, once for blocks and groups.
pub(crate) trait TickField: Field + Sized {
    /// The rows of all bodies.
    type Rows: AsRef<[Row]>;

    /// Enters the next segment of the tick, in which the damping of all bodies is `decay`.
    fn enter<M: Integrator>(&mut self, segment: Segment, decay: Decay);

    /// Begins a step in the state that the last one left.
    fn begin_step(&mut self) {}

    /// The length of a step that would end in (`x`, `v`) up to its first discontinuity that depends on the state, s; `None` if
    /// there is none. The step is then repeated with this length.
    fn length_to_event(&mut self, x: Self::Space, v: Self::Space) -> Option<f64> {
        let _ = (x, v);
        None
    }

    /// Frees the memory of the last step: all elements of the space except the state and the method state.
    fn recycle(
        &mut self,
        x: &mut Self::Space,
        v: &mut Self::Space,
        step_state: &mut StepState<Self>,
    ) {
        let _ = (x, v, step_state);
    }

    /// Ends a step; returns the state from which the next one starts.
    fn after_step<M: Integrator>(
        &mut self,
        x: Self::Space,
        v: Self::Space,
        step_state: &mut StepState<Self>,
    ) -> (Self::Space, Self::Space);

    /// Stores the state (`x`, `v`) after damping, speed limit and locks around a tick; returns the state to continue from.
    fn settle(&mut self, x: Self::Space, v: Self::Space) -> (Self::Space, Self::Space) {
        (x, v)
    }

    /// `v` times the factors of damping that `factor` picks.
    fn decayed(&mut self, v: Self::Space, factor: impl Fn(&Decay) -> Option<f64>) -> Self::Space;

    /// Applies speed limit and axis locks.
    fn restrain(&mut self, v: Self::Space) -> Self::Space;

    /// The records of the tick, if it has a ledger.
    fn recorder(&mut self) -> &mut Option<Recorder>;

    /// An element of the space as rows.
    fn rows(&self, element: Self::Space) -> Self::Rows;

    /// Rate of exact damping of a row times the length of the step, if the step has exact damping.
    fn exact_damping(&self, row: usize) -> Option<f64>;

    /// Applies and records the factors of damping that `factor` picks.
    #[inline(always)]
    fn damp(&mut self, v: Self::Space, factor: impl Fn(&Decay) -> Option<f64>) -> Self::Space {
        let decayed = self.decayed(v, factor);
        self.record_change(v, decayed, &|record, _, from, to| record.damp(from, to));
        decayed
    }

    /// Applies and records speed limit and axis locks.
    #[inline(always)]
    fn limit(&mut self, v: Self::Space) -> Self::Space {
        let limited = self.restrain(v);
        self.record_change(v, limited, &|record, _, from, to| record.limit(from, to));
        limited
    }

    /// [`Field::before_move`].
    #[inline(always)]
    fn damp_and_limit(&mut self, v: Self::Space) -> Self::Space {
        let decayed = self.damp(v, |decay| decay.before_move);
        let limited = self.limit(decayed);
        let h = self.step();
        self.record_change(limited, limited, &|record, _, v, _| record.travel(h, v));
        limited
    }

    /// Records a change, if the tick has a ledger.
    #[inline(always)]
    fn record_change(&mut self, from: Self::Space, to: Self::Space, note: Note<'_>) {
        if self.recorder().is_some() {
            self.record(from, to, note);
        }
    }

    #[cold]
    fn record(&mut self, from: Self::Space, to: Self::Space, note: Note<'_>) {
        let (from, to) = (self.rows(from), self.rows(to));
        self.recorder().iter_mut().for_each(|record| record.note(from.as_ref(), to.as_ref(), note));
    }

    /// Records a kick by the acceleration `a`.
    #[cold]
    fn record_kick(&mut self, v: Self::Space, a: Self::Space, kicked: Self::Space) {
        let (h, a) = (self.step(), self.rows(a));
        let a = a.as_ref();
        let damping: Vec<_> = (0..a.len()).map(|row| self.exact_damping(row)).collect();
        self.record(v, kicked, &|record, row, from, to| match damping[row] {
            Some(q) => record.damped_kick(h, q, vector(&a[row]), from, to),
            None => record.kick(h, from, to),
        });
    }

    /// Records an implicit step.
    #[inline(always)]
    fn record_solved(&mut self, v: Self::Space, solved: Self::Space) {
        let h = self.step();
        self.record_change(v, solved, &|record, _, from, to| {
            record.kick(h, from, to);
            record.travel(h, to);
        });
    }
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
        v = field.before_move(v);
        field.record_change(x, v, &|record, _, x, v| record.begin(x, v));
        (x, v) = field.settle(x, v);
    }
    for (number, mut segment) in segments.iter().enumerate() {
        if number > 0 {
            field.recycle(&mut x, &mut v, step_state);
        }
        loop {
            field.enter::<M>(segment, parameters.decay_in(segment));
            field.begin_step();
            if segment.jump {
                // The cached acceleration is from before the jump.
                step_state.start = None;
            }
            let StepState { last_step, start } = *step_state;
            let (to_x, to_v) = M::step(field, x, v, step_state);
            let Some(length) = field.length_to_event(to_x, to_v) else {
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
    if M::DAMPS_INSIDE {
        return (x, v);
    }
    field.record_change(x, v, &|record, _, x, v| record.end(x, v));
    v = field.after_move(v);
    v = field.limit(v);
    field.settle(x, v)
}
