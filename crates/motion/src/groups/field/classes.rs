//! Classes of rows by their options: most groups have one class.

use super::{GroupEnvironment, GroupField, Layout};
use crate::kernels::BodyOptions;
use crate::laws::damping::{Damping, Decay};
use crate::laws::{Affine, Law};
use crate::methods::Field as _;
use crate::state::components::AxisLocks;
use crate::units::Vector;

/// The laws and options that a class of rows shares: constant acceleration, linear drag, damping, limits and locks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Class {
    /// Constant acceleration, m/s².
    pub constant: Vector,
    /// Total rate of linear drag, 1/s, with exact damping where the method damps around its ticks.
    pub rate: f64,
    pub(super) damping: Option<Damping>,
    /// Factors of damping: around the tick, or in the current segment if the method damps inside each step.
    pub(super) decay: Decay,
    pub(super) limit: Option<f64>,
    pub locks: Option<AxisLocks>,
    /// Axes along which nothing accelerates the rows.
    pub(super) closed: Option<AxisLocks>,
    pub(super) gravity_off: bool,
}

/// The classes of all rows.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Classes {
    pub list: Vec<Class>,
    /// The class of every row; empty if there is only one class.
    pub of_row: Vec<u32>,
}

impl Clone for Classes {
    fn clone(&self) -> Self {
        Self { list: self.list.clone(), of_row: self.of_row.clone() }
    }

    fn clone_from(&mut self, other: &Self) {
        self.list.clone_from(&other.list);
        self.of_row.clone_from(&other.of_row);
    }
}

impl Classes {
    /// The class of a row.
    pub fn of(&self, row: usize) -> &Class {
        &self.list[self.of_row.get(row).map_or(0, |class| *class as usize)]
    }

    /// The class of all rows, if there is only one.
    pub fn uniform(&self) -> Option<Class> {
        match &self.list[..] {
            [class] => Some(*class),
            _ => None,
        }
    }
}

/// The class of rows in sheets without options, if air acts on sheets.
const IN_SHEET: u32 = 1;

impl<E: Layout> GroupField<'_, E> {
    /// Fills `classes`, and counts the rows on which gravity acts.
    pub(super) fn sort_into_classes(&mut self) {
        let GroupEnvironment { shared, parameters, .. } = self.environment;
        let (gravity, drag) = (shared.free_fall(), shared.laws.drag);
        let none = Affine { constant: Vector::ZERO, rate: 0.0 };
        let air = drag.and_then(Law::affine).unwrap_or(none);
        let Classes { list: classes, of_row: class_of } = &mut self.scratch.classes;
        classes.clear();
        class_of.clear();
        let sheets: &[u32] = if drag.is_some() { &self.coupling.in_sheets } else { &[] };
        // Sums only the terms that act: adding a term and subtracting it again would leave a rounding error.
        let class = |in_sheet: bool, options: &BodyOptions<'_>| {
            let air = if in_sheet { none } else { air };
            let gravity = if options.gravity_off { Vector::ZERO } else { gravity };
            let own = match options.damping_rate {
                Some(_) => &parameters.damped(options.damping(parameters.damping)),
                None => parameters,
            };
            Class {
                constant: parameters.gravity + gravity + air.constant,
                rate: own.rate + air.rate,
                damping: own.damping,
                decay: own.decay,
                limit: options.speed_limit,
                locks: options.locks,
                closed: options.closed_axes(parameters.traits.limits_after_kick),
                gravity_off: options.gravity_off,
            }
        };
        classes.push(class(false, &BodyOptions::NONE));
        if !sheets.is_empty() || !self.rows.with_options.is_empty() {
            class_of.resize(self.coupling.rows, 0);
        }
        if !sheets.is_empty() {
            classes.push(class(true, &BodyOptions::NONE));
            sheets.iter().for_each(|row| class_of[*row as usize] = IN_SHEET);
        }
        let mut without_gravity = 0;
        for row in self.rows.with_options {
            let options = self.options.row(*row as usize);
            without_gravity += u64::from(options.gravity_off);
            let class_of = &mut class_of[*row as usize];
            let class = class(*class_of == IN_SHEET && !sheets.is_empty(), &options);
            // Neighbors often have the same options.
            if classes.last() != Some(&class) {
                classes.push(class);
            }
            *class_of = u32::try_from(classes.len() - 1).unwrap_or(0);
        }
        self.with_gravity = if gravity == Vector::ZERO {
            0
        } else {
            self.coupling.movable as u64 - without_gravity
        };
    }

    pub(super) fn class(&self, row: usize) -> &Class {
        self.scratch.classes.of(row)
    }

    /// Whether any law is called.
    pub(super) fn calls(&self) -> bool {
        !self.environment.parameters.laws.is_empty() || !self.rows.with_laws.is_empty()
    }

    /// Whether a law or damping may reduce velocities to almost 0.
    pub(super) fn decays(&self) -> bool {
        self.depends_on_velocity()
            || self.scratch.classes.list.iter().any(|class| class.decay.multiplies())
    }

    /// The own laws of the rows.
    pub(super) fn own_laws(&self) -> impl Iterator<Item = &Box<dyn Law>> {
        self.rows.with_laws.iter().flat_map(|row| self.options.row(*row as usize).laws)
    }
}
