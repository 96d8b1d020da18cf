//! The rescue of a group in which a row turns non-finite or leaves the range.

use bevy_ecs::entity::Entity;

use super::field::{GroupEnvironment, GroupField, GroupKernel, GroupRows, Push, Scratch, Watch};
use super::members::{ByRow, MemberOptions};
use super::rows::{Row, are_at_rest, row_of};
use super::split::Part;
use super::suspects::{RowStates, Suspects, springs_by_row};
use super::{Group, Groups};
use crate::kernels::record::vector;
use crate::kernels::{
    AppliedForces, Batch, BodyOptions, MethodStateRows, OfRows, RowOptions, StepStatistics,
    TickParameters,
};
use crate::laws::{Affine, Law};
use crate::methods::MethodStateKind;
use crate::state::components::{PhysicsBody, Transform};
use crate::state::range::{Breach, Quantity};
use crate::tick::environment::TickOutput;
use crate::tick::quarantine::{Cause, Refused};
use crate::units::{Scalar, Vector};

/// Repeats the tick of a group without the rows that failed.
pub(super) struct Rescue<'a, 'w, 's, 'n> {
    pub kernel: GroupKernel,
    pub environment: &'a GroupEnvironment<'a>,
    pub options: &'a MemberOptions<'w, 's>,
    pub output: &'a mut TickOutput<'n>,
}

impl Rescue<'_, '_, '_, '_> {
    /// Finds the rows that failed first, leaves them as they were before the tick, and repeats the tick of the others
    /// as if these rows had been removed before. Does so until no row fails. Rows that do not act on each other are
    /// removed together: in a net that fails as a whole, one at a time would take a tick per row.
    #[cold]
    pub fn run(
        &mut self,
        groups: &mut Groups,
        number: usize,
        state_of: &mut dyn FnMut(Entity) -> Option<(Transform, PhysicsBody, Scalar)>,
    ) {
        let Groups { list, pushes, x, v, w, last, .. } = groups;
        let group = &list[number];
        let (first, coupling) = (group.first, &group.coupling);
        let rows = first..first + coupling.rows;
        let pushes: Vec<_> =
            pushes.iter().filter(|push| push.0 == number).map(|push| (push.1, push.2)).collect();
        // Anchors have not changed; the state of movable rows is still in the tables.
        let mut before = RowStates {
            x: x[rows.clone()].to_vec(),
            v: v[rows.clone()].to_vec(),
            w: w[rows.clone()].to_vec(),
            last: last[rows.clone()].to_vec(),
        };
        for (row, body) in group.bodies[..coupling.movable].iter().enumerate() {
            if let Some((transform, body, last)) = state_of(*body) {
                (before.x[row], before.v[row]) =
                    (row_of(transform.position), row_of(body.velocity));
                (before.w[row], before.last[row]) = (body.inverse_mass, last);
            }
        }
        let whole = ByRow { bodies: &group.bodies, options: self.options };
        let suspects = Suspects {
            springs: springs_by_row(coupling),
            environment: self.environment,
            group,
            options: whole,
            pushes: &pushes,
            before: &before,
        };
        let mut removed = vec![false; coupling.rows];
        // Rows that fail regardless of the others are removed together: one at a time would take a tick of the group
        // for each.
        for (row, removed) in removed.iter_mut().enumerate() {
            if let Some(cause) = suspects.cause_by_itself(row) {
                *removed = true;
                self.output.quarantine.refuse(refused(group, &before, row, cause));
            }
        }
        let after = loop {
            let parts = coupling.parts(&removed);
            let mut after = RowStates {
                x: before.x.clone(),
                v: before.v.clone(),
                w: Vec::new(),
                last: before.last.clone(),
            };
            let record = self.output.records.recorder(coupling.rows);
            let mut statistics = StepStatistics { record, ..StepStatistics::default() };
            let culprits: Vec<_> = parts
                .iter()
                .flat_map(|part| {
                    self.part(group, part, &pushes, &before, &mut after, &mut statistics)
                })
                .collect();
            if culprits.is_empty() {
                self.output.evaluations.add(&statistics, std::iter::empty());
                self.output.records.add(&group.bodies, statistics.record.as_ref(), 0);
                break after;
            }
            for (row, breach) in culprits {
                let cause = suspects.cause(row, breach, &removed);
                removed[row] = true;
                self.output.quarantine.refuse(refused(group, &before, row, cause));
            }
        };
        x[rows.clone()].copy_from_slice(&after.x);
        v[rows.clone()].copy_from_slice(&after.v);
        last[rows].copy_from_slice(&after.last);
    }

    /// Integrates a tick of a part; returns the rows that failed first, of which no two act on each other, and why.
    fn part(
        &self,
        group: &Group,
        part: &Part,
        pushes: &[(usize, Row)],
        before: &RowStates,
        after: &mut RowStates,
        statistics: &mut StepStatistics,
    ) -> Vec<(usize, Breach)> {
        let pick = |rows: &[Row]| part.rows.iter().map(|row| rows[*row]).collect::<Vec<_>>();
        let numbers = |from: &[Scalar]| part.rows.iter().map(|row| from[*row]).collect::<Vec<_>>();
        let pushes: Vec<_> = pushes
            .iter()
            .filter_map(|(row, force)| Some((part.rows.iter().position(|own| own == row)?, *force)))
            .collect();
        let whole = ByRow { bodies: &group.bodies, options: self.options };
        let (coupling, movable) = (&part.coupling, part.coupling.movable);
        let states = || RowStates {
            x: pick(&before.x),
            v: pick(&before.v),
            w: numbers(&before.w),
            last: numbers(&before.last),
        };
        let mut state = states();
        if coupling.springs.is_empty() && coupling.sheets.is_empty() && !coupling.attracts {
            // A row without coupling is integrated as a single body.
            let row = part.rows[0];
            let force = pushes
                .iter()
                .fold([0.0; 3], |sum, (_, [x, y, z, _])| [sum[0] + x, sum[1] + y, sum[2] + z]);
            if let Some(record) = &mut statistics.record {
                record.first = row;
            }
            let alone = self.alone(whole.row(row), force, &mut state, statistics);
            if let Err(breach) = alone {
                return vec![(row, breach)];
            }
        } else {
            let listed = |rows: &[u32]| {
                let of_whole = |row: &usize| rows.binary_search(&(*row as u32)).is_ok();
                let found =
                    part.rows[..movable].iter().enumerate().filter(|(_, row)| of_whole(row));
                found.map(|(row, _)| row as u32).collect::<Vec<_>>()
            };
            let (with_options, with_laws) = (listed(&group.with_options), listed(&group.with_laws));
            let options = OfRows { whole: &whole, rows: &part.rows };
            for watch in [Watch::Off, Watch::On] {
                let mut scratch = Scratch::default();
                let push = |(row, force): &(usize, Row)| Push { lane: 0, row: *row, force: *force };
                scratch.pushes.extend(pushes.iter().map(push));
                state = states();
                let anchors_rest = are_at_rest(&state.v[movable..]) && coupling.motions.is_empty();
                let rows = GroupRows {
                    x: &mut state.x,
                    v: &mut state.v,
                    w: &state.w,
                    groups: 1,
                    apart: &[],
                    last: &mut state.last[..movable],
                    with_options: &with_options,
                    with_laws: &with_laws,
                    cache: None,
                    anchors_rest,
                    springs: &[],
                };
                let record = self.output.records.recorder(part.rows.len());
                let mut own = StepStatistics { record, ..StepStatistics::default() };
                let field = GroupField::new(
                    coupling,
                    self.environment,
                    rows,
                    &options,
                    &mut scratch,
                    &mut own,
                );
                match (self.kernel.tick)(field, watch) {
                    Ok(()) => {
                        statistics.add(&own);
                        if let (Some(all), Some(own)) = (&mut statistics.record, &own.record) {
                            all.take_over(&part.rows, own);
                        }
                        break;
                    }
                    Err(first) if !first.is_empty() => {
                        let breach = |row: usize| {
                            let ([a, b, c, _], [d, e, f, _]) = (state.x[row], state.v[row]);
                            let breach = self
                                .environment
                                .parameters
                                .bounds
                                .breach(&[a, b, c], &[d, e, f, state.w[row]]);
                            // A row that failed within the tick may be finite at its end.
                            breach.unwrap_or(Breach { of: Quantity::Velocity, finite: false })
                        };
                        let apart = coupling.apart(&first).into_iter();
                        return apart.map(|row| (part.rows[row], breach(row))).collect();
                    }
                    Err(_) => {}
                }
            }
        }
        for (i, row) in part.rows[..movable].iter().enumerate() {
            (after.x[*row], after.v[*row], after.last[*row]) =
                (state.x[i], state.v[i], state.last[i]);
        }
        Vec::new()
    }

    /// Integrates a tick of a body without coupling.
    fn alone(
        &self,
        options: BodyOptions<'_>,
        force: [Scalar; 3],
        RowStates { x, v, w, last }: &mut RowStates,
        statistics: &mut StepStatistics,
    ) -> Result<(), Breach> {
        let GroupEnvironment { shared, parameters, .. } = self.environment;
        let none = Affine { constant: Vector::ZERO, rate: 0.0 };
        let air = shared.laws.drag.and_then(Law::affine).unwrap_or(none);
        let mut parameters: TickParameters<'_> = *parameters;
        parameters.gravity +=
            air.constant + if options.gravity_off { Vector::ZERO } else { shared.free_fall() };
        parameters.drag += air.rate;
        let parameters = parameters.damped(parameters.damping);
        // The substeps are the group's.
        let options = BodyOptions { substeps: None, ..options };
        let [a, b, c, _] = x[0];
        let (mut positions, mut bodies) = ([[a, b, c]], [[v[0][0], v[0][1], v[0][2], w[0]]]);
        let method_state = match self.kernel.single.traits.state {
            MethodStateKind::LastStep => MethodStateRows::LastStep(last),
            MethodStateKind::None | MethodStateKind::LastAcceleration => MethodStateRows::None,
        };
        let applied = Some(AppliedForces { forces: &[force], rows: &[(0, 0)], offset: 0 });
        let mut batch =
            Batch { positions: &mut positions, bodies: &mut bodies, applied, method_state };
        let outcome =
            self.kernel.single.integrate_row(&parameters, options, &mut batch, 0, statistics);
        let ([a, b, c], [d, e, f, _]) = (positions[0], bodies[0]);
        (x[0], v[0]) = ([a, b, c, 0.0], [d, e, f, 0.0]);
        outcome
    }
}

/// A refused row, in its state before the tick.
fn refused(group: &Group, before: &RowStates, row: usize, cause: Cause) -> Refused {
    let state = PhysicsBody { velocity: vector(&before.v[row]), inverse_mass: before.w[row] };
    Refused {
        body: group.bodies[row],
        transform: Transform::at(vector(&before.x[row])),
        state,
        cause,
    }
}
