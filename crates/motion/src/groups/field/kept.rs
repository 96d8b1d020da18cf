//! What groups keep from tick to tick.

use super::*;
use crate::blocks::add_compensated;
use crate::units::Scalar;

/// The acceleration at the end of a tick, which is the next one's first if nothing has changed.
#[derive(Debug, Default)]
pub(crate) struct Kept<T: Real> {
    x: RowArray<T>,
    w: Vec<T>,
    a: RowArray<T>,
    time: Option<Scalar>,
    epoch: u64,
    own: u64,
    attraction: Option<MutualGravity>,
    classes: Vec<Class<T>>,
    class_of: Vec<u32>,
}

impl<T: Real> GroupField<'_, T> {
    /// The length of the last step of all rows. Rows that differ, because a velocity was set or a body is new,
    /// are brought to the velocities of their positions' own time, as if they all started there.
    pub(super) fn common_last_step(&mut self, last: &mut [T]) -> T {
        let Some(first) = last.first().copied() else { return T::ZERO };
        if last.iter().all(|step| *step == first) {
            return first;
        }
        let (x, v) = (Combination::of(POSITION), Combination::of(VELOCITY));
        let a = self.laws(T::ZERO, x, v);
        let a = a.slot().unwrap_or(FIRST);
        for (row, (step, v)) in last.iter().zip(self.rows.v.iter_mut()).enumerate() {
            for (axis, part) in v[..3].iter_mut().enumerate() {
                let more = self.scratch.slots[a][row][axis] * *step * T::of(0.5);
                match &mut self.rows.residues {
                    None => *part += more,
                    Some([_, residues]) => {
                        let residue = &mut residues[row][axis];
                        (*part, *residue) = add_compensated((*part, *residue), (more, T::ZERO));
                    }
                }
            }
        }
        self.next = FIRST;
        T::ZERO
    }

    /// A number that is another one whenever laws of single rows are.
    pub(super) fn versions(&self) -> u64 {
        self.rows.lawful.iter().fold(0, |sum, row| {
            u64::wrapping_add(sum, self.askers.laws(*row as usize).1).wrapping_mul(0x100_0000_01b3)
        })
    }

    pub(super) fn recall(&mut self, kept: &Kept<T>, own: u64) -> Option<Combination<T>> {
        let terms = &self.around.terms;
        let fits = kept.time == Some(terms.course.start)
            && (kept.epoch, kept.own) == (terms.epoch, own)
            && kept.attraction.as_ref() == self.around.attraction
            && kept.classes == self.scratch.classes
            && kept.class_of == self.scratch.class_of
            && kept.w == self.rows.w
            && *kept.x == *self.rows.x;
        fits.then(|| {
            self.scratch.slots[KEPT].copy(&kept.a);
            Combination::of(KEPT)
        })
    }

    pub(super) fn note(&self, kept: &mut Kept<T>, own: u64, is_kept: bool) {
        let terms = &self.around.terms;
        kept.time = is_kept.then_some(terms.course.end);
        if is_kept {
            (kept.epoch, kept.own) = (terms.epoch, own);
            kept.attraction = self.around.attraction.copied();
            kept.classes.clone_from(&self.scratch.classes);
            kept.class_of.clone_from(&self.scratch.class_of);
            kept.x.copy(self.rows.x);
            kept.w.clear();
            kept.w.extend_from_slice(self.rows.w);
            kept.a.copy(&self.scratch.slots[KEPT]);
        }
    }
}
