//! The rows of groups in the tables: found, gathered before a tick and scattered after it.

use std::collections::BTreeMap;

use bevy_ecs::change_detection::ContiguousMut;
use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use super::Groups;
use super::coupling::Coupling;
use super::lanes::{Bundle, Bundles, LaneRun, Places, bundles};
use super::members::{Anchors, MemberOptions, Members, of_body};
use super::rows::{Element as _, Row};
use crate::kernels::{load_axes, store_axes};
use crate::laws::{Axes, BLOCK_BODIES};
use crate::simd::vectorize;
use crate::state::components::{Force, PhysicsBody, Transform};
use crate::state::method_state::LastStep;
use crate::state::range::Bounds;
use crate::state::threads::Threads;
use crate::tick::environment::EnvironmentParam;

/// The reason why tables are contiguous slices.
const DENSE: &str = "every component of a body is stored in tables";

/// The tables of a running system.
#[derive(Default)]
pub(super) struct Tables<'w> {
    members: SmallVec<[MemberTable<'w>; 16]>,
    anchors: SmallVec<[AnchorTable<'w>; 16]>,
}

/// The columns of a table of bodies that move in groups.
struct MemberTable<'w> {
    number: usize,
    entities: &'w [Entity],
    transforms: ContiguousMut<'w, Transform>,
    bodies: ContiguousMut<'w, PhysicsBody>,
    forces: &'w [Force],
    last: Option<ContiguousMut<'w, LastStep>>,
}

/// The columns of a table of bodies that move in no group.
struct AnchorTable<'w> {
    number: usize,
    entities: &'w [Entity],
    positions: &'w [[f64; 3]],
    bodies: &'w [Row],
}

impl MemberTable<'_> {
    /// Positions, (velocity, inverse mass) and lengths of last steps.
    fn states(&mut self) -> (&mut [[f64; 3]], &mut [Row], Option<&mut [f64]>) {
        let Self { transforms, bodies, last, .. } = self;
        (
            bytemuck::cast_slice_mut(transforms.bypass_change_detection()),
            bytemuck::cast_slice_mut(bodies.bypass_change_detection()),
            last.as_mut().map(|last| bytemuck::cast_slice_mut(last.bypass_change_detection())),
        )
    }
}

impl<'w> Tables<'w> {
    /// Lists the tables of members. Not a constructor: the lists are long, and moving them would take as long as the tick of a
    /// small group.
    pub fn list_members(&mut self, param: &EnvironmentParam, members: &'w mut Members) {
        let members = members.contiguous_iter_mut().expect(DENSE);
        self.members.extend(members.filter_map(|(entities, transforms, bodies, forces, last)| {
            let number = param.table_of(*entities.first()?)?;
            Some(MemberTable { number, entities, transforms, bodies, forces, last })
        }));
    }

    /// Lists the tables of anchors, which bundles read.
    pub fn list_anchors(&mut self, param: &EnvironmentParam, anchors: &'w Anchors) {
        self.anchors.clear();
        let anchors = anchors.contiguous_iter().expect(DENSE);
        self.anchors.extend(anchors.filter_map(|(entities, transforms, bodies)| {
            let number = param.table_of(*entities.first()?)?;
            let (positions, bodies) =
                (bytemuck::cast_slice(transforms), bytemuck::cast_slice(bodies));
            Some(AnchorTable { number, entities, positions, bodies })
        }));
    }

    /// State of a body and length of its last step, s.
    pub fn state_of(
        &self,
        param: &EnvironmentParam,
        body: Entity,
    ) -> Option<(Transform, PhysicsBody, f64)> {
        let (number, row) = param.place_of(body)?;
        let table = self.members.iter().find(|table| table.number == number)?;
        let last = table.last.as_ref().map_or(0.0, |last| last[row].0);
        Some((table.transforms[row], table.bodies[row], last))
    }
}

/// A table that holds rows of groups.
#[derive(Debug, Default)]
pub(super) struct Place {
    /// Its number in the world.
    table: usize,
    /// The bodies by row, if members are in the table.
    bodies: Vec<Entity>,
    /// Its number among the tables of members of the running system.
    members: Option<usize>,
    /// Its number among the tables of anchors of the running system.
    anchors: Option<usize>,
}

/// Consecutive rows of a table that are consecutive rows of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct TableRun {
    table: usize,
    start: usize,
    len: usize,
    group: usize,
    row: usize,
}

/// One or several groups that are integrated at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// The group of this number alone.
    Group(usize),
    /// A bundle.
    Bundle(usize),
}

impl Groups {
    /// Finds the rows of all groups in the tables, and the rows with options, and decides which groups are integrated side
    /// by side.
    #[cold]
    pub(super) fn find(&mut self, param: &EnvironmentParam, options: &MemberOptions) {
        self.bundles.dissolve(&mut self.list);
        let mut places: Vec<Places> = Vec::with_capacity(self.list.len());
        let mut tables: BTreeMap<usize, Vec<(usize, Entity)>> = BTreeMap::new();
        for group in &mut self.list {
            group.with_options.clear();
            group.with_laws.clear();
            let of_group: Places = group.bodies.iter().map(|body| param.place_of(*body)).collect();
            for (row, (body, place)) in group.bodies.iter().zip(&of_group).enumerate() {
                let Some((table, at)) = *place else { continue };
                let bodies = tables.entry(table).or_default();
                if row >= group.coupling.movable {
                    continue;
                }
                bodies.push((at, *body));
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
            places.push(of_group);
        }
        let place = |(table, mut bodies): (usize, Vec<(usize, Entity)>)| {
            bodies.sort_unstable_by_key(|(at, _)| *at);
            Place {
                table,
                bodies: bodies.into_iter().map(|(_, body)| body).collect(),
                ..Place::default()
            }
        };
        self.places = tables.into_iter().map(place).collect();
        let list = &self.list;
        let bundled =
            bundles(list, &places, |group, row| of_body(options, list[group].bodies[row as usize]));
        self.bundles.make(bundled, &mut self.list);
        self.place(&places);
    }

    /// Forgets the places of the rows and the bundles, because the groups have changed.
    pub(super) fn forget_places(&mut self) {
        self.bundles.list.clear();
        self.places.clear();
        self.runs.clear();
        self.units.clear();
    }

    /// Makes the runs of all rows, and the order of groups and bundles.
    fn place(&mut self, places: &[Places]) {
        let mut units: Vec<_> =
            (0..self.list.len()).map(|group| Some(Unit::Group(group))).collect();
        let Self { bundles, list, places: tables, .. } = &mut *self;
        for (number, bundle) in bundles.list.iter_mut().enumerate() {
            bundle.groups.iter().for_each(|group| units[*group] = None);
            units[bundle.groups[0]] = Some(Unit::Bundle(number));
            let Coupling { rows, movable, .. } = list[bundle.groups[0]].coupling;
            let runs = |row: usize| {
                let bodies = bundle
                    .groups
                    .iter()
                    .map(|group| (places[*group][row], list[*group].bodies[row]));
                lane_runs(tables, row, bodies)
            };
            bundle.members = (0..movable).flat_map(runs).collect();
            bundle.anchors = (movable..rows).flat_map(runs).collect();
        }
        self.runs.clear();
        self.alone = 0;
        for (number, group) in self.list.iter_mut().enumerate() {
            if units[number] != Some(Unit::Group(number)) {
                continue;
            }
            group.first = self.alone;
            self.alone += group.coupling.rows;
            let mut run: Option<TableRun> = None;
            for (row, place) in places[number][..group.coupling.movable].iter().enumerate() {
                let Some((table, start)) = *place else { continue };
                match &mut run {
                    Some(run)
                        if run.table == table
                            && run.start + run.len == start
                            && run.row + run.len == row =>
                    {
                        run.len += 1;
                    }
                    _ => {
                        self.runs.extend(run.take());
                        run = Some(TableRun { table, start, len: 1, group: number, row });
                    }
                }
            }
            self.runs.extend(run);
        }
        self.runs.sort_unstable();
        self.fit(self.alone);
        self.units = units.into_iter().flatten().collect();
        self.seen.resize(self.list.len(), 0);
    }

    /// Makes room for `rows` rows of groups that are integrated alone.
    pub(super) fn fit(&mut self, rows: usize) {
        self.x.resize(rows);
        self.v.resize(rows);
        self.w.resize(rows, 0.0);
        self.last.resize(rows, 0.0);
    }

    /// Copies the rows of the system's groups that are integrated alone from the tables; `false` if rows of groups have moved
    /// within the tables.
    pub(super) fn gather(&mut self, param: &EnvironmentParam, tables: &mut Tables) -> bool {
        for unit in &self.units {
            if let Unit::Group(number) = unit {
                self.seen[*number] = 0;
            }
        }
        self.pushes.clear();
        self.places.iter_mut().for_each(|place| (place.members, place.anchors) = (None, None));
        for (number, table) in tables.members.iter().enumerate() {
            let Some(place) = number_of(&self.places, table.number) else { return false };
            let place = &mut self.places[place];
            if place.bodies != table.entities {
                return false;
            }
            place.members = Some(number);
        }
        for (number, table) in tables.anchors.iter().enumerate() {
            if let Some(place) = number_of(&self.places, table.number) {
                self.places[place].anchors = Some(number);
            }
        }
        let mut anchors = self.bundles.list.iter().flat_map(|bundle| &bundle.anchors);
        let is_there = |run: &LaneRun| {
            self.places[run.place]
                .anchors
                .is_some_and(|table| run.is_in(tables.anchors[table].entities))
        };
        if !anchors.all(is_there) {
            return false;
        }
        for table in &mut tables.members {
            let (number, forces) = (table.number, table.forces);
            let (positions, bodies, last) = table.states();
            for run in runs_of(&self.runs, number) {
                let TableRun { start, len, group, row, .. } = *run;
                let to = self.list[group].first + row;
                let threads = Threads::for_rows(param.threads(), len);
                Threads::share(threads, &mut self.x[to..to + len], |first, x| {
                    for (x, [a, b, c]) in x.iter_mut().zip(&positions[start + first..]) {
                        *x = [*a, *b, *c, 0.0];
                    }
                });
                let (v, w) = (&mut self.v[to..to + len], &mut self.w[to..to + len]);
                Threads::share_two(threads, v, w, |first, v, w| {
                    for ((v, w), [a, b, c, d]) in v.iter_mut().zip(w).zip(&bodies[start + first..])
                    {
                        (*v, *w) = ([*a, *b, *c, 0.0], *d);
                    }
                });
                if let Some(last) = &last {
                    self.last[to..to + len].copy_from_slice(&last[start..start + len]);
                }
                self.seen[group] += len;
                let pushed = param.pushed_in(number, start..start + len);
                self.pushes.extend(
                    pushed.iter().map(|(_, at)| (group, row + at - start, newtons(forces, *at))),
                );
            }
        }
        if param.pushes() {
            self.gather_pushes(param, tables);
        }
        self.pushes.sort_unstable_by_key(|(group, row, _)| (*group, *row));
        true
    }

    /// Collects the pushes on the groups of bundles.
    fn gather_pushes(&mut self, param: &EnvironmentParam, tables: &Tables) {
        let bundles = self.bundles.list.iter().filter(|bundle| is_seen(&self.places, bundle));
        for (bundle, run) in
            bundles.flat_map(|bundle| bundle.members.iter().map(move |run| (bundle, run)))
        {
            let LaneRun { start, step, row, group, ref bodies, .. } = *run;
            let Some(table) = self.places[run.place].members.map(|table| &tables.members[table])
            else {
                continue;
            };
            let pushed =
                param.pushed_in(table.number, start..start + (bodies.len() - 1) * step + 1);
            let pushed = pushed.iter().filter(|(_, at)| (at - start) % step == 0);
            self.pushes.extend(pushed.map(|(_, at)| {
                (bundle.groups[group + (at - start) / step], row, newtons(table.forces, *at))
            }));
        }
    }

    /// Copies the rows of groups that were integrated alone back to the tables.
    pub(super) fn scatter(&self, param: &EnvironmentParam, tables: &mut Tables) {
        for table in &mut tables.members {
            table.transforms.mark_all_as_changed();
            let number = table.number;
            let (positions, bodies, mut last) = table.states();
            for run in runs_of(&self.runs, number) {
                let TableRun { start, len, group, row, .. } = *run;
                if self.seen[group] != self.list[group].coupling.movable {
                    continue;
                }
                let from = self.list[group].first + row;
                let threads = Threads::for_rows(param.threads(), len);
                let rows = (&mut positions[start..start + len], &mut bodies[start..start + len]);
                Threads::share_two(threads, rows.0, rows.1, |first, positions, bodies| {
                    let rows = positions.iter_mut().zip(bodies);
                    let states = self.x[from + first..].iter().zip(&self.v[from + first..]);
                    for ((position, body), (x, v)) in rows.zip(states) {
                        position.copy_from_slice(&x[..3]);
                        body[..3].copy_from_slice(&v[..3]);
                    }
                });
                if let Some(last) = &mut last {
                    last[start..start + len].copy_from_slice(&self.last[from..from + len]);
                }
            }
        }
    }

    /// Copies the rows of a bundle from the tables; `false` if the running system does not have them.
    pub(super) fn load(&mut self, number: usize, tables: &mut Tables, bounds: Bounds) -> bool {
        let Self { places, bundles: Bundles { list, x, v, w, last: steps, .. }, .. } = self;
        let bundle = &mut list[number];
        if !is_seen(places, bundle) {
            return false;
        }
        let (x, v): (&mut [Axes], &mut [Axes]) = (x, v);
        for run in &bundle.members {
            let Some(table) = places[run.place].members else { continue };
            let (positions, bodies, last) = tables.members[table].states();
            run.parts(bundle, |(at, rows), (element, lane)| {
                load_rows(&mut x[element], lane, rows, &positions[at..], run.step);
                load_rows(&mut v[element], lane, rows, &bodies[at..], run.step);
                let w = &mut w[element * BLOCK_BODIES + lane..][..rows];
                w.iter_mut()
                    .zip(bodies[at..].iter().step_by(run.step))
                    .for_each(|(w, body)| *w = body[3]);
                if let Some(last) = &last {
                    let steps = steps[element * BLOCK_BODIES + lane..][..rows].iter_mut();
                    steps
                        .zip(last[at..].iter().step_by(run.step))
                        .for_each(|(to, step)| *to = *step);
                }
            });
        }
        let (mut lost, mut moving) =
            (std::mem::take(&mut bundle.lost), std::mem::take(&mut bundle.moving));
        lost.clear();
        moving.clear();
        for run in &bundle.anchors {
            let Some(table) = places[run.place].anchors.map(|table| &tables.anchors[table]) else {
                continue;
            };
            run.parts(bundle, |(at, rows), (element, lane)| {
                let (x, v) = (&mut x[element], &mut v[element]);
                load_rows(x, lane, rows, &table.positions[at..], run.step);
                load_rows(v, lane, rows, &table.bodies[at..], run.step);
                w[element * BLOCK_BODIES + lane..][..rows].fill(0.0);
                if is_regular(x, v, lane, rows, bounds) {
                    return;
                }
                for lane in lane..lane + rows {
                    let group = (element - run.row * bundle.width) * BLOCK_BODIES + lane;
                    let ([a, b, c, _], v @ [d, e, f, _]) = (x.row(lane), v.row(lane));
                    if !(bounds.holds_position(&[a, b, c]) && bounds.holds_velocity(&[d, e, f])) {
                        lost.push(group);
                    }
                    if v != [0.0; 4] {
                        moving.push(group);
                    }
                }
            });
        }
        for list in [&mut lost, &mut moving] {
            list.sort_unstable();
            list.dedup();
        }
        (bundle.lost, bundle.moving) = (lost, moving);
        true
    }

    /// Copies the rows of a bundle back to the tables.
    pub(super) fn store(&self, number: usize, tables: &mut Tables) {
        let Self { places, bundles: Bundles { list, x, v, w, last: steps, .. }, .. } = self;
        let bundle = &list[number];
        let (x, v): (&[Axes], &[Axes]) = (x, v);
        for run in &bundle.members {
            let Some(table) = places[run.place].members else { continue };
            let (positions, bodies, mut last) = tables.members[table].states();
            run.parts(bundle, |(at, rows), (element, lane)| {
                let (x, v) = (&x[element], &v[element]);
                if run.step == 1 && rows == BLOCK_BODIES {
                    let w = &w[element * BLOCK_BODIES..][..BLOCK_BODIES];
                    let table = (&mut positions[at..at + rows], &mut bodies[at..at + rows]);
                    vectorize(
                        #[inline(always)]
                        || {
                            store_axes(x, table.0, |x, _| x);
                            store_axes(v, table.1, |[x, y, z], k| [x, y, z, w[k]]);
                        },
                    );
                } else {
                    for k in 0..rows {
                        let at = at + k * run.step;
                        positions[at] = [x[0][lane + k], x[1][lane + k], x[2][lane + k]];
                        let body = &mut bodies[at];
                        (body[0], body[1], body[2]) =
                            (v[0][lane + k], v[1][lane + k], v[2][lane + k]);
                    }
                }
                if let Some(last) = &mut last {
                    let steps = &steps[element * BLOCK_BODIES + lane..][..rows];
                    steps.iter().enumerate().for_each(|(k, step)| last[at + k * run.step] = *step);
                }
            });
        }
    }
}

/// The number of the place with that table.
fn number_of(places: &[Place], table: usize) -> Option<usize> {
    places.binary_search_by_key(&table, |place| place.table).ok()
}

/// The runs of the same row of several groups, at these places.
fn lane_runs(
    tables: &[Place],
    row: usize,
    bodies: impl Iterator<Item = (Option<(usize, usize)>, Entity)>,
) -> Vec<LaneRun> {
    let mut runs: Vec<LaneRun> = Vec::new();
    for (group, (place, body)) in bodies.enumerate() {
        let Some((table, start)) = place else { continue };
        let Some(place) = number_of(tables, table) else { continue };
        if !runs.last_mut().is_some_and(|run| run.takes(place, start, body)) {
            runs.push(LaneRun { place, start, step: 1, row, group, bodies: vec![body] });
        }
    }
    runs
}

/// Whether the running system has found all rows of a bundle.
fn is_seen(places: &[Place], bundle: &Bundle) -> bool {
    bundle.members.iter().all(|run| places[run.place].members.is_some())
}

/// The force applied to a row, N.
fn newtons(forces: &[Force], row: usize) -> Row {
    let [x, y, z] = forces[row].newtons().to_array();
    [x, y, z, 0.0]
}

/// Copies `count` rows, every `step`th one, into the lanes from `lane` on.
#[inline(always)]
fn load_rows<const N: usize>(
    to: &mut Axes,
    lane: usize,
    count: usize,
    rows: &[[f64; N]],
    step: usize,
) {
    if let (1, BLOCK_BODIES, Some(rows)) = (step, count, rows.first_chunk()) {
        vectorize(
            #[inline(always)]
            || load_axes(to, rows),
        );
        return;
    }
    let [x, y, z] = to;
    for k in 0..count {
        let row = &rows[k * step];
        (x[lane + k], y[lane + k], z[lane + k]) = (row[0], row[1], row[2]);
    }
}

/// Whether the `count` rows from `lane` on are at rest, finite and in range.
fn is_regular(x: &Axes, v: &Axes, lane: usize, count: usize, bounds: Bounds) -> bool {
    let each = |axis: usize, lane: usize| {
        (x[axis][lane].abs() <= bounds.position) & (v[axis][lane] == 0.0)
    };
    if count < BLOCK_BODIES {
        return (0..3).all(|axis| (lane..lane + count).all(|lane| each(axis, lane)));
    }
    vectorize(
        #[inline(always)]
        || {
            let mut regular = true;
            for axis in 0..3 {
                for lane in 0..BLOCK_BODIES {
                    regular &= each(axis, lane);
                }
            }
            regular
        },
    )
}

fn runs_of(runs: &[TableRun], table: usize) -> &[TableRun] {
    let start = runs.partition_point(|run| run.table < table);
    let end = runs.partition_point(|run| run.table <= table);
    &runs[start..end]
}
