//! Finds out why a row of a group failed.

use super::Group;
use super::coupling::Coupling;
use super::field::GroupEnvironment;
use super::members::ByRow;
use super::pull::SpringRow;
use super::rows::Row;
use crate::kernels::record::vector;
use crate::kernels::{BodyOptions, RowOptions};
use crate::state::components::PhysicsBody;
use crate::state::range::{Breach, Quantity};
use crate::state::springs::Elastic;
use crate::tick::diagnosis::{Evidence, Exposure, Suspect};
use crate::tick::quarantine::{Cause, Fault, place};
use crate::units::{Scalar, Vector};

/// States of the rows of a group, before the tick or after it.
pub(super) struct RowStates {
    pub x: Vec<Row>,
    pub v: Vec<Row>,
    pub w: Vec<Scalar>,
    pub last: Vec<Scalar>,
}

/// The rows of a group before the tick, and everything that acts on them.
pub(super) struct Suspects<'a, 'w, 's> {
    /// The springs of every row: the row at the other end, and the properties.
    pub springs: Vec<Vec<(usize, Elastic)>>,
    pub environment: &'a GroupEnvironment<'a>,
    pub group: &'a Group,
    pub options: ByRow<'a, 'w, 's>,
    /// Forces applied to rows, N.
    pub pushes: &'a [(usize, Row)],
    pub before: &'a RowStates,
}

/// The system that integrates groups.
const SYSTEM: &str = "integrate_groups";

/// The springs of every row, for [`Suspects`].
pub(super) fn springs_by_row(coupling: &Coupling) -> Vec<Vec<(usize, Elastic)>> {
    let mut of_row = vec![Vec::new(); coupling.rows];
    for SpringRow { ends, elastic } in coupling.springs.iter() {
        let [a, b] = ends.map(|end| end as usize);
        of_row[a].push((b, elastic));
        of_row[b].push((a, elastic));
    }
    of_row
}

impl Suspects<'_, '_, '_> {
    /// The cause if a row fails in a tick whatever the other rows do: its state is not finite or out of range, or something that
    /// acts on it is not finite.
    pub fn cause_by_itself(&self, row: usize) -> Option<Cause> {
        let RowStates { x, v, w, .. } = self.before;
        let Group { coupling, .. } = self.group;
        let broken = Breach { of: Quantity::Velocity, finite: false };
        let cause = |evidence| Some(self.environment.shared.cause(SYSTEM, broken, Some(evidence)));
        if let Some(anchor) = row.checked_sub(coupling.movable)
            && coupling.sources.get(anchor).is_some_and(|source| !source.is_finite())
        {
            return cause((place::SOURCE_MASS, Fault::Found));
        }
        if let Some(evidence) = self.state_of(row).found() {
            return cause(evidence);
        }
        let ([a, b, c, _], [d, e, f, _]) = (x[row], v[row]);
        if let Some(breach) =
            self.environment.parameters.bounds.breach(&[a, b, c], &[d, e, f, w[row]])
        {
            // Only the range is left to be at fault.
            let broken_range = self.environment.shared.found(Exposure {
                kicks: false,
                gravity_off: true,
                own_rate: true,
            });
            return Some(self.environment.shared.cause(SYSTEM, breach, broken_range));
        }
        let BodyOptions { gravity_off, damping_rate, locks, .. } = self.options.row(row);
        // A law that is not finite may not affect a locked row.
        if row >= coupling.movable || locks.is_some() {
            return None;
        }
        if coupling.rows > 1 && self.attraction_is_invalid() {
            return cause((place::MUTUAL_GRAVITY, Fault::Found));
        }
        // Infinite damping is valid for some methods: it stops the body.
        let stops =
            self.environment.parameters.damping.is_some_and(|damping| damping.rate.is_infinite());
        let own_rate = damping_rate.is_some() || stops;
        self.environment
            .shared
            .found(Exposure { kicks: true, gravity_off, own_rate })
            .and_then(cause)
    }

    /// Why a row failed in a tick in which the rows `removed` took no part.
    pub fn cause(&self, row: usize, breach: Breach, removed: &[bool]) -> Cause {
        let BodyOptions { gravity_off, damping_rate, speed_limit, laws, .. } =
            self.options.row(row);
        let own_rate = damping_rate.is_some();
        let exposure = Exposure { kicks: true, gravity_off, own_rate };
        let last = self.before.last[row];
        let damping_rate = damping_rate.filter(|_| self.environment.parameters.damping.is_some());
        let suspect = Suspect {
            damping_rate,
            limit: speed_limit,
            last_step: Some(last),
            laws,
            ..self.state_of(row)
        };
        let evidence = suspect
            .found()
            .or_else(|| self.environment.shared.found(exposure))
            .or_else(|| {
                self.attraction_is_invalid().then_some((place::MUTUAL_GRAVITY, Fault::Found))
            })
            .or_else(|| self.spring_at_fault(row, removed))
            .or_else(|| suspect.own_law(self.environment.parameters.times.ends()))
            .or_else(|| self.environment.shared.law_at_fault(suspect.state()))
            .or_else(|| self.attraction_at_fault(row, removed));
        self.environment.shared.cause(SYSTEM, breach, evidence)
    }

    /// The state of a row and the force on it.
    fn state_of(&self, row: usize) -> Suspect<'static> {
        let RowStates { x, v, w, .. } = self.before;
        let body = PhysicsBody { velocity: vector(&v[row]), inverse_mass: w[row] };
        let pushes = self.pushes.iter().filter(|(pushed, _)| *pushed == row);
        let force = pushes.fold(Vector::ZERO, |sum, (_, force)| sum + vector(force));
        Suspect {
            position: vector(&x[row]),
            body,
            force,
            damping_rate: None,
            limit: None,
            last_step: None,
            laws: &[],
        }
    }

    /// The first spring of a row that is not finite or pulls with a non-finite force.
    fn spring_at_fault(&self, row: usize, removed: &[bool]) -> Option<Evidence> {
        let Group { bodies, .. } = self.group;
        let springs = self.springs[row].iter().filter(|(other, _)| !removed[*other]);
        let mut broken =
            springs.filter(|(other, elastic)| !self.tension(row, *other, elastic).is_finite());
        broken.next().map(|(other, Elastic { stiffness, damping, rest_length, .. })| {
            let finite = [stiffness, damping, rest_length].iter().all(|number| number.is_finite());
            (place::SPRING, if finite { Fault::Spring(bodies[*other]) } else { Fault::Found })
        })
    }

    /// Force of a spring between two rows, N.
    fn tension(&self, row: usize, other: usize, elastic: &Elastic) -> Scalar {
        let RowStates { x, v, .. } = self.before;
        let d = vector(&x[other]) - vector(&x[row]);
        let u = vector(&v[other]) - vector(&v[row]);
        let length = d.length();
        let rate = if length > 0.0 { u.dot(d / length) } else { 0.0 };
        elastic.stiffness * (length - elastic.rest_length) + elastic.damping * rate
    }

    fn attraction_is_invalid(&self) -> bool {
        let attraction =
            self.environment.shared.attraction.filter(|_| self.group.coupling.attracts);
        attraction.is_some_and(|law| !law.constant.is_finite() || law.softening.is_nan())
    }

    /// Whether mutual gravity pulls a row with a non-finite force.
    fn attraction_at_fault(&self, row: usize, removed: &[bool]) -> Option<Evidence> {
        let (Group { coupling, .. }, RowStates { x, w, .. }) = (self.group, self.before);
        let law = self.environment.shared.attraction.filter(|_| coupling.attracts)?;
        let pull = |other: usize| coupling.attraction_between(law, [row, other], x, w);
        let mut others = (0..coupling.rows).filter(|other| *other != row && !removed[*other]);
        others
            .any(|other| pull(other).is_some_and(|pull| !pull.is_finite()))
            .then_some((place::MUTUAL_GRAVITY, Fault::Law("mutual_gravity")))
    }
}
