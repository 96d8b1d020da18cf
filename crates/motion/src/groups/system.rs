//! The system that integrates groups: gathers their rows from the tables, integrates a tick, and scatters them.

use bevy_ecs::prelude::*;
use bevy_ecs::system::{BoxedSystem, ParamBuilder, SystemParam, SystemState};

use super::field::{GroupEnvironment, GroupField, GroupKernel, GroupRows, Watch};
use super::members::{ByRow, MemberOptions, Members};
use super::rescue::Rescue;
use super::rows::Row;
use super::solver::Solver;
use super::{Group, Groups, TableRun};
use crate::kernels::StepStatistics;
use crate::laws::MutualGravity;
use crate::state::components::{PhysicsBody, Transform};
use crate::state::coupling::{CouplingChanged, Grouped};
use crate::state::range::Bounds;
use crate::state::threads::Threads;
use crate::tick::body_filter::BodyFilter;
use crate::tick::environment::{Environment, EnvironmentParam, TickOutput};
use crate::units::Vector;

/// The anchors of groups.
type Anchors<'w, 's> = Query<'w, 's, (&'static Transform, &'static PhysicsBody), Without<Grouped>>;

/// What the system reads and writes besides the environment and the members of its groups.
#[derive(SystemParam)]
struct GroupsParam<'w, 's> {
    groups: ResMut<'w, Groups>,
    changed: ResMut<'w, CouplingChanged>,
    solver: Option<Res<'w, Solver>>,
    attraction: Option<Res<'w, MutualGravity>>,
    anchors: Anchors<'w, 's>,
    options: MemberOptions<'w, 's>,
    summed: Local<'s, Vec<&'static str>>,
}

/// Makes the system that integrates a tick of `kernel` for the groups of the bodies that `which` selects.
pub(crate) fn integrate_groups(
    world: &mut World,
    kernel: GroupKernel,
    which: &BodyFilter,
    name: String,
) -> BoxedSystem {
    let state: SystemState<(EnvironmentParam, TickOutput, GroupsParam, Members)> =
        (ParamBuilder, ParamBuilder, ParamBuilder, which.query()).build_state(world);
    let system = state.build_system(move |param, output, groups, members| {
        advance_groups(kernel, param, output, groups, members);
    });
    Box::new(system.with_name(name))
}

fn advance_groups(
    kernel: GroupKernel,
    mut param: EnvironmentParam,
    mut output: TickOutput,
    groups: GroupsParam,
    mut members: Members,
) {
    let GroupsParam { mut groups, mut changed, solver, attraction, anchors, options, mut summed } = groups;
    param.prepare();
    let groups = &mut *groups;
    if !groups.gather(&param, &mut members) {
        groups.find(&param, &options);
        let found = groups.gather(&param, &mut members);
        debug_assert!(found, "bodies do not move between tables in the middle of a system");
        if !found {
            changed.0 = true;
            return;
        }
    }
    let shared = Environment { attraction: attraction.as_deref(), ..param.environment() };
    summed.clear();
    summed.extend(shared.summed(true));
    let called = shared.called();
    let solver = solver.as_deref().copied().unwrap_or_default();
    let mut environment =
        GroupEnvironment::new(kernel.single.traits, shared, &called, solver, &summed, param.threads());
    let substeps = environment.parameters.times.substeps;
    for number in 0..groups.list.len() {
        if groups.seen[number] != groups.list[number].coupling.movable {
            continue;
        }
        let own = groups.list[number].substeps.unwrap_or(substeps);
        if own != environment.parameters.times.substeps {
            environment.parameters.times.substeps = own;
            environment.parameters = environment.parameters.damped(environment.parameters.damping);
        }
        let Group { first, coupling, .. } = &mut groups.list[number];
        coupling.weigh(&groups.w[*first..*first + coupling.movable]);
        let holds = groups.hold(number, &anchors, environment.parameters.bounds, &mut changed);
        let record = output.records.recorder(groups.list[number].coupling.rows);
        let mut statistics = StepStatistics { record, ..StepStatistics::default() };
        if holds && groups.tick(kernel, number, &environment, &options, &mut statistics).is_ok() {
            output.evaluations.add(&statistics, &[], std::iter::empty());
            output.records.add(&groups.list[number].bodies, statistics.record);
        } else {
            // A tick that failed may have overwritten the anchors as well.
            let _ = groups.hold(number, &anchors, environment.parameters.bounds, &mut changed);
            let (environment, options, output) = (&environment, &options, &mut output);
            let mut rescue = Rescue { kernel, environment, options, output };
            rescue.run(groups, number, &mut |body| {
                let (_, transform, state, _, last) = members.get(body).ok()?;
                Some((*transform, *state, last.map_or(0.0, |last| last.0)))
            });
            changed.0 = true;
        }
    }
    groups.scatter(&param, &mut members);
}

impl Group {
    /// Shares the springs of a large group among the threads.
    fn share(&mut self, threads: Option<&Threads>) {
        let Self { coupling, shares, .. } = self;
        let count = Threads::for_rows(threads, coupling.rows).map_or(0, Threads::count);
        if shares.0 != count {
            let list = if count > 0 { coupling.springs.shares(coupling.rows, count) } else { Vec::new() };
            *shares = (count, list);
        }
    }
}

impl Groups {
    /// Copies the rows of the system's groups from the tables; `false` if they are not where they were.
    fn gather(&mut self, param: &EnvironmentParam, members: &mut Members) -> bool {
        self.seen.fill(0);
        self.pushes.clear();
        for chunk in members.contiguous_iter_mut().expect("every component of a body is stored in tables") {
            let (entities, mut transforms, mut bodies, forces, mut last) = chunk;
            let Some(table) = param.table_of(entities[0]) else { return false };
            let transforms = transforms.bypass_change_detection();
            let bodies = bodies.bypass_change_detection();
            let mut last = last.as_mut().map(|last| last.bypass_change_detection());
            let mut count = 0;
            for run in runs_of(&self.runs, table) {
                let TableRun { start, len, group, row, .. } = *run;
                let Group { first, bodies: members, .. } = &self.list[group];
                if entities.get(start..start + len) != Some(&members[row..row + len]) {
                    return false;
                }
                let to = first + row;
                let threads = Threads::for_rows(param.threads(), len);
                let (transforms, bodies) = (&transforms[start..], &bodies[start..]);
                Threads::share(threads, &mut self.x[to..to + len], |first, x| {
                    for (x, transform) in x.iter_mut().zip(&transforms[first..]) {
                        let [a, b, c] = transform.position.to_array();
                        *x = [a, b, c, 0.0];
                    }
                });
                let (v, w) = (&mut self.v[to..to + len], &mut self.w[to..to + len]);
                Threads::share_two(threads, v, w, |first, v, w| {
                    for ((v, w), body) in v.iter_mut().zip(w).zip(&bodies[first..]) {
                        let [a, b, c] = body.velocity.to_array();
                        (*v, *w) = ([a, b, c, 0.0], body.inverse_mass);
                    }
                });
                if let Some(last) = &mut last {
                    let steps = self.last[to..to + len].iter_mut().zip(&last[start..start + len]);
                    steps.for_each(|(to, from)| *to = from.0);
                }
                self.seen[group] += len;
                count += len;
                let pushed = param.pushed_in(table, start..start + len);
                self.pushes.extend(pushed.iter().map(|(_, pushed)| {
                    let [x, y, z] = forces[*pushed].newtons().to_array();
                    (group, row + pushed - start, [x, y, z, 0.0])
                }));
            }
            if count != entities.len() {
                return false;
            }
        }
        self.pushes.sort_unstable_by_key(|(group, row, _)| (*group, *row));
        true
    }

    /// The pushes on rows of a group.
    fn pushes_of(&self, number: usize) -> &[(usize, usize, Row)] {
        let start = self.pushes.partition_point(|(group, ..)| *group < number);
        let end = self.pushes.partition_point(|(group, ..)| *group <= number);
        &self.pushes[start..end]
    }

    /// Finds the rows of all groups in the tables, and the rows with options.
    #[cold]
    fn find(&mut self, param: &EnvironmentParam, options: &MemberOptions) {
        self.runs.clear();
        for (number, group) in self.list.iter_mut().enumerate() {
            group.with_options.clear();
            group.with_laws.clear();
            let mut run: Option<TableRun> = None;
            for (row, body) in group.bodies[..group.coupling.movable].iter().enumerate() {
                let Some((table, start)) = param.place_of(*body) else { continue };
                match &mut run {
                    Some(run)
                        if run.table == table && run.start + run.len == start && run.row + run.len == row =>
                    {
                        run.len += 1;
                    }
                    _ => {
                        self.runs.extend(run.take());
                        run = Some(TableRun { table, start, len: 1, group: number, row });
                    }
                }
                let Ok(columns) = options.get(*body) else { continue };
                #[expect(clippy::cast_possible_truncation, reason = "springs name rows by u32")]
                let row = row as u32;
                if columns.options().changes_row() {
                    group.with_options.push(row);
                }
                if columns.laws.is_some() {
                    group.with_laws.push(row);
                }
            }
            self.runs.extend(run);
        }
        self.runs.sort_unstable();
    }

    /// Copies the state of the anchors; `false` if one of them is not finite or out of range.
    #[must_use]
    fn hold(
        &mut self,
        number: usize,
        anchors: &Anchors,
        bounds: Bounds,
        changed: &mut CouplingChanged,
    ) -> bool {
        let mut holds = true;
        let Group { first, coupling, bodies, .. } = &self.list[number];
        for (row, body) in bodies.iter().enumerate().skip(coupling.movable) {
            let row = first + row;
            if let Ok((transform, body)) = anchors.get(*body) {
                let ([x, y, z], [a, b, c]) = (transform.position.to_array(), body.velocity.to_array());
                (self.x[row], self.v[row], self.w[row]) = ([x, y, z, 0.0], [a, b, c, 0.0], 0.0);
                holds &= bounds.holds_position(&[x, y, z]) && bounds.holds_velocity(&[a, b, c]);
            } else {
                changed.0 = true;
            }
        }
        holds && coupling.sources.iter().all(|source| source.is_finite())
    }

    fn tick(
        &mut self,
        kernel: GroupKernel,
        number: usize,
        environment: &GroupEnvironment<'_>,
        options: &MemberOptions,
        statistics: &mut StepStatistics,
    ) -> Result<(), Vec<usize>> {
        let mut pushes = std::mem::take(&mut self.scratch.pushes);
        pushes.clear();
        pushes.extend(self.pushes_of(number).iter().map(|(_, row, force)| (*row, *force)));
        self.scratch.pushes = pushes;
        let group = &mut self.list[number];
        group.share(environment.threads);
        let rows = group.first..group.first + group.coupling.rows;
        let options = ByRow { bodies: &group.bodies, options };
        let movable = group.first..group.first + group.coupling.movable;
        let rows = GroupRows {
            x: &mut self.x[rows.clone()],
            v: &mut self.v[rows.clone()],
            w: &self.w[rows],
            last: &mut self.last[movable],
            with_options: &group.with_options,
            with_laws: &group.with_laws,
            cache: Some(&mut group.cache),
            shares: &group.shares.1,
        };
        let field =
            GroupField::new(&group.coupling, environment, rows, &options, &mut self.scratch, statistics);
        (kernel.tick)(field, Watch::Off)
    }

    /// Copies the rows of the system's groups back to the tables.
    fn scatter(&self, param: &EnvironmentParam, members: &mut Members) {
        for chunk in members.contiguous_iter_mut().expect("every component of a body is stored in tables") {
            let (entities, mut transforms, mut bodies, _, mut last) = chunk;
            let Some(table) = param.table_of(entities[0]) else { continue };
            let (transforms, bodies) = (&mut *transforms, bodies.bypass_change_detection());
            let mut last = last.as_mut().map(|last| last.bypass_change_detection());
            for run in runs_of(&self.runs, table) {
                let TableRun { start, len, group, row, .. } = *run;
                if self.seen[group] != self.list[group].coupling.movable {
                    continue;
                }
                let from = self.list[group].first + row;
                let threads = Threads::for_rows(param.threads(), len);
                let (transforms, bodies) =
                    (&mut transforms[start..start + len], &mut bodies[start..start + len]);
                Threads::share_two(threads, transforms, bodies, |first, transforms, bodies| {
                    let rows = transforms.iter_mut().zip(bodies);
                    let states = self.x[from + first..].iter().zip(&self.v[from + first..]);
                    for ((transform, body), (x, v)) in rows.zip(states) {
                        transform.position = Vector::new(x[0], x[1], x[2]);
                        body.velocity = Vector::new(v[0], v[1], v[2]);
                    }
                });
                if let Some(last) = &mut last {
                    let steps = last[start..start + len].iter_mut().zip(&self.last[from..]);
                    steps.for_each(|(to, from)| to.0 = *from);
                }
            }
        }
    }
}

fn runs_of(runs: &[TableRun], table: usize) -> &[TableRun] {
    let start = runs.partition_point(|run| run.table < table);
    let end = runs.partition_point(|run| run.table <= table);
    &runs[start..end]
}
