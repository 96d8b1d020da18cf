//! A group in the driver of a tick: cords, and damping, limits and locks by class.

use super::classes::Class;
use super::{GroupField, GroupRows, Layout, Scratch, start};
use crate::groups::combination::{Combination, FIRST, VELOCITY};
use crate::groups::rows::{Array, Row};
use crate::kernels::record::Recorder;
use crate::kernels::{TickField, restrain};
use crate::laws::damping::Decay;
use crate::laws::tick_times::Segment;
use crate::methods::{Field as _, Integrator, StepState};

impl<E: Layout> TickField for GroupField<'_, E> {
    type Rows = Vec<Row>;

    /// By class, because bodies may have their own damping.
    fn enter<M: Integrator>(&mut self, segment: Segment, _: Decay) {
        self.segment = segment;
        if M::DAMPS_INSIDE {
            for class in &mut self.scratch.classes.list {
                let none = Decay::none(segment.length);
                class.decay = class.damping.map_or(none, |damping| damping.factors(segment.length));
            }
        }
    }

    fn begin_step(&mut self) {
        self.begin_step_of_cords();
    }

    fn length_to_event(&mut self, x: Combination, v: Combination) -> Option<f64> {
        self.change_of_cords(x, v)
    }

    fn after_step<M: Integrator>(
        &mut self,
        x: Combination,
        v: Combination,
        step_state: &mut StepState<Self>,
    ) -> (Combination, Combination) {
        let movable = self.movable();
        let Segment { length, jump, .. } = self.segment;
        let measures = self.scratch.defect.on;
        if measures {
            let GroupRows { x, v, .. } = &self.rows;
            self.scratch.defect.before(&x[..movable], &v[..movable], jump);
        }
        self.finish(x, v);
        if measures {
            let GroupRows { x, v, .. } = &self.rows;
            self.scratch.defect.after(&x[..movable], &v[..movable], length);
        }
        self.follow_motions_to(self.end());
        step_state.start = step_state.start.and_then(|start| self.keep(start));
        start()
    }

    fn settle(&mut self, x: Combination, v: Combination) -> (Combination, Combination) {
        if v != Combination::of(VELOCITY) {
            self.finish(x, v);
        }
        self.next = FIRST;
        start()
    }

    fn decayed(&mut self, v: Combination, factor: impl Fn(&Decay) -> Option<f64>) -> Combination {
        if self.scratch.classes.list.iter().all(|class| factor(&class.decay).is_none()) {
            return v;
        }
        match self.scratch.classes.uniform() {
            Some(class) if self.rows.anchors_rest => {
                factor(&class.decay).map_or(v, |factor| v * factor)
            }
            _ => self.each_row(v, |class| factor(&class.decay)),
        }
    }

    fn restrain(&mut self, v: Combination) -> Combination {
        if self
            .scratch
            .classes
            .list
            .iter()
            .all(|class| class.limit.is_none() && class.locks.is_none())
        {
            return v;
        }
        let slot = self.own_array(&v);
        let Scratch { slots, classes, .. } = &mut *self.scratch;
        for row in self.rows.with_options {
            let row = *row as usize;
            let Class { limit, locks, .. } = *classes.of(row);
            for element in &mut slots[slot][row * self.width..][..self.width] {
                for lane in 0..E::LANES {
                    let mut of_lane = element.row(lane);
                    restrain(&mut of_lane, limit, locks);
                    element.set_row(lane, of_lane);
                }
            }
        }
        Combination::of(slot)
    }

    fn recorder(&mut self) -> &mut Option<Recorder> {
        &mut self.statistics.record
    }

    /// All rows, group by group.
    fn rows(&self, sum: Combination) -> Vec<Row> {
        let mut elements = Array::default();
        self.compute(&sum, &mut elements);
        let row = |group: usize, row: usize| {
            let (element, lane): (usize, usize) = self.place(row, group);
            elements[element].row(lane)
        };
        let of_group = |group: usize| (0..self.coupling.rows).map(move |number| (group, number));
        (0..self.rows.groups).flat_map(of_group).map(|(group, number)| row(group, number)).collect()
    }

    fn exact_damping(&self, row: usize) -> Option<f64> {
        let Class { damping, decay, .. } = self.class(row % self.coupling.rows);
        damping.filter(|_| decay.keep.is_some()).map(|damping| damping.rate * self.step())
    }
}
