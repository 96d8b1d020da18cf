//! What acts on bodies in plain arrays.

use smallvec::SmallVec;

use crate::groups::Solver;
use crate::kernels::Terms;
use crate::laws::course::Course;
use crate::laws::damping::Damping;
use crate::laws::{Affine, Declared, Drag, Gravity, Law, MutualGravity, Wells};
use crate::methods::Integrator;
use crate::real::{Real, RealVector as _};
use crate::state::range::{Bounds, Range};

/// Laws that are called for every body, in a list that allocates nothing.
pub(super) type Called<'a, T> = SmallVec<[&'a dyn Law<T>; 8]>;

/// What acts on every body: in a world, resources.
#[derive(Debug)]
pub(super) struct Acting<T: Real> {
    pub gravity: Option<Gravity>,
    pub drag: Option<Drag>,
    pub wells: Option<Wells>,
    pub laws: Vec<Box<dyn Law<T>>>,
    pub attraction: Option<MutualGravity>,
    pub damping: Option<Damping>,
    pub solver: Solver,
    pub range: Option<Range>,
}

impl<T: Real> Default for Acting<T> {
    fn default() -> Self {
        Self {
            gravity: None,
            drag: None,
            wells: None,
            laws: Vec::new(),
            attraction: None,
            damping: None,
            solver: Solver::default(),
            range: None,
        }
    }
}

impl<T: Real> Acting<T> {
    pub fn declared(&self) -> Declared<'_, T> {
        Declared { drag: self.drag.as_ref(), wells: self.wells.as_ref(), more: &self.laws }
    }

    pub fn called(&self) -> Called<'_, T> {
        self.declared().called().collect()
    }

    /// Gravity that is on, m/s².
    pub fn gravity(&self) -> T::Vector {
        self.gravity.as_ref().and_then(Gravity::acting).map_or(T::Vector::ZERO, T::Vector::of)
    }

    /// What acts on every body, gravity aside: the affine ones of the laws `summed`, and those `called`.
    pub fn terms<'a, M: Integrator>(
        &self,
        summed: Declared<'_, T>,
        called: &'a [&'a dyn Law<T>],
        course: Course,
    ) -> Terms<'a, T> {
        // Laws change only where everything that was kept is forgotten.
        let epoch = 0;
        Terms::new::<M>(Affine::sum(summed.all()), self.damping, called, epoch, course)
            .within(Bounds::of(self.range.as_ref()))
    }
}
