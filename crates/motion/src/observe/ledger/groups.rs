//! Groups in the ledger: energies and lines of springs, drag on sheets and mutual gravity.

use bevy_ecs::entity::{Entity, EntityHashMap};
use smallvec::SmallVec;

use super::bodies::{BodyTick, PhasePoint};
use super::lines::{Energies, LedgerTotals};
use super::path::{Path, QuadratureNode, cuts, nodes};
use super::tick::LedgerTick;
use crate::groups::{Coupling, Row, SpringRow, bisect_end, equal_parts, pulls, row_of};
use crate::kernels::record::vector;
use crate::laws::tick_times::TickTimes;
use crate::laws::{Drag, MutualGravity};
use crate::state::springs::Elastic;
use crate::units::{Scalar, Vector};

/// A group and its bodies.
pub(super) struct LedgerGroup<'w> {
    coupling: &'w Coupling,
    /// Index of the body of every row.
    body_of_row: Vec<usize>,
    inverse_masses: Vec<Scalar>,
    /// Whether a body has locked axes.
    locked: bool,
}

/// The rows of a group at a node of a tick.
struct GroupNode<'a> {
    bodies: &'a [BodyTick<'a>],
    x: Vec<Row>,
    v: Vec<Row>,
    /// Weight of the node, s.
    weight: Scalar,
}

/// The groups of a ledger. Marks those of `bodies` that are in sheets.
pub(super) fn ledger_groups<'w>(
    couplings: impl Iterator<Item = (&'w Coupling, &'w [Entity])>,
    bodies: &mut [BodyTick<'_>],
) -> Vec<LedgerGroup<'w>> {
    let numbers: EntityHashMap<usize> =
        bodies.iter().enumerate().map(|(i, body)| (body.entity, i)).collect();
    let mut found = Vec::new();
    for (coupling, members) in couplings {
        let number = |entity: &Entity| numbers.get(entity).copied();
        let Some(rows) = members.iter().map(number).collect::<Option<Vec<_>>>() else { continue };
        coupling.in_sheets.iter().for_each(|row| bodies[rows[*row as usize]].in_sheet = true);
        let inverse_masses = rows.iter().map(|body| bodies[*body].inverse_mass).collect();
        let locked = rows[..coupling.movable].iter().any(|body| bodies[*body].locks.is_some());
        found.push(LedgerGroup { coupling, body_of_row: rows, inverse_masses, locked });
    }
    found
}

impl LedgerGroup<'_> {
    /// Positions and velocities of the rows.
    fn rows(&self, state: impl Fn(usize) -> PhasePoint) -> (Vec<Row>, Vec<Row>) {
        let states = self.body_of_row.iter().map(|body| state(*body));
        states.map(|PhasePoint { position, velocity }| (row_of(position), row_of(velocity))).unzip()
    }

    /// Adds the energies at the start (0) or end (1) of the tick.
    pub fn add_energies(
        &self,
        tick: &LedgerTick<'_>,
        bodies: &[BodyTick<'_>],
        end: usize,
        energies: &mut Energies,
    ) {
        let (x, _) = self.rows(|body| bodies[body].ends[end]);
        if !self.coupling.springs.is_empty() {
            energies.add_potential("springs", self.coupling.elastic_energy(&x));
        }
        if let Some(law) = self.attraction(tick) {
            let pairs = self.coupling.attraction_energies(law, &x, &self.inverse_masses);
            let energy = pairs.fold(0.0, |sum, (_, energy)| sum + energy);
            energies.add_potential("mutual_gravity", energy);
        }
    }

    fn attraction<'a>(&self, tick: &LedgerTick<'a>) -> Option<&'a MutualGravity> {
        tick.environment.attraction.filter(|_| self.coupling.attracts)
    }

    /// Adds the tick of a group whose bodies moved along `paths` to `totals`.
    pub fn add_tick(
        &self,
        tick: &LedgerTick<'_>,
        bodies: &[BodyTick<'_>],
        paths: &[Path],
        totals: &mut LedgerTotals,
    ) {
        let times = &tick.environment.times;
        let cuts = self.cuts_at_cords(times, paths);
        for quadrature in nodes(times, &cuts) {
            let QuadratureNode { weight, at, .. } = quadrature;
            let (x, v) = self.rows(|body| paths[body].at_node(&quadrature));
            let node = GroupNode { bodies, x, v, weight };
            // A cord changes at the ends of its interval, so it is judged in the middle.
            let interval_middle = at.within_step - times.start;
            let taut = |spring: &SpringRow| {
                !spring.elastic.pull_only || self.pulls(spring, paths, interval_middle)
            };
            self.add_springs(&node, taut, totals);
            if let Some(drag) =
                tick.environment.laws.drag.filter(|_| !self.coupling.sheets.is_empty())
            {
                self.add_sheets(drag, &node, at.time, totals);
            }
            if let Some(law) = self.attraction(tick) {
                self.add_attraction(law, &node, totals);
            }
        }
    }

    /// Whether a spring pulls `after` seconds of the tick.
    fn pulls(&self, spring: &SpringRow, paths: &[Path], after: Scalar) -> bool {
        let [a, b] = spring.ends.map(|end| paths[self.body_of_row[end as usize]].at(after));
        pulls(&spring.elastic, b.position - a.position, b.velocity - a.velocity)
    }

    /// Cuts a tick where a cord tightens or slackens.
    fn cuts_at_cords(&self, times: &TickTimes, paths: &[Path]) -> SmallVec<[Scalar; 4]> {
        let springs = &self.coupling.springs;
        let cords = springs.cords().iter().map(|number| springs.get(*number));
        let mut changes = Vec::new();
        for cord in cords {
            let taut = |part: Scalar| self.pulls(&cord, paths, times.tick * part);
            for (from, to) in equal_parts().filter(|(from, to)| taut(*from) != taut(*to)) {
                let before = taut(from);
                changes.push(
                    times.start + times.tick * bisect_end(|part| taut(part) == before, from, to),
                );
            }
        }
        let motions = self.coupling.motions.iter().flat_map(|(_, motion)| motion.discontinuities());
        cuts(times, changes.iter().chain(motions))
    }

    /// Adds the springs. A spring that is not `taut` has no force, but the elastic energy that is left in it counts as lost.
    fn add_springs(
        &self,
        node: &GroupNode<'_>,
        taut: impl Fn(&SpringRow) -> bool,
        totals: &mut LedgerTotals,
    ) {
        let GroupNode { x, v, .. } = node;
        let movable = self.coupling.movable;
        if !self.coupling.springs.damped() && !self.locked && self.body_of_row.len() == movable {
            // Work is in the potential, and the impulses cancel.
            return;
        }
        let mut lost = 0.0;
        for spring in self.coupling.springs.iter() {
            let ends @ [a, b] = spring.ends.map(|end| end as usize);
            let (d, u) = (vector(&x[b]) - vector(&x[a]), vector(&v[b]) - vector(&v[a]));
            let length = d.length();
            if length > 0.0 {
                let rate = d.dot(u) / length;
                let Elastic { stiffness, damping, rest_length, .. } = spring.elastic;
                let stretch = length - rest_length;
                let (dissipating, pull) = match taut(&spring) {
                    true => (damping * rate, stiffness * stretch + damping * rate),
                    false => (-(stiffness * stretch.max(0.0)), 0.0),
                };
                lost += dissipating * rate;
                if self.locked || a >= movable || b >= movable {
                    self.add_pair(node, ends, d * (pull / length), totals);
                }
            }
        }
        if self.coupling.springs.damped() {
            totals.energy.add_law("spring_damping", -lost * node.weight);
        }
    }

    /// Adds a force on the first of two rows and the opposite force on the second to the line of anchors.
    fn add_pair(
        &self,
        node: &GroupNode<'_>,
        ends: [usize; 2],
        force: Vector,
        totals: &mut LedgerTotals,
    ) {
        let mut given = |end: usize, force: Vector| {
            let body = &node.bodies[self.body_of_row[end]];
            if end < self.coupling.movable {
                let impulse = body.along_open_axes(force) * node.weight;
                totals.angular_momentum.anchors += vector(&node.x[end]).cross(impulse);
                (impulse, 0.0)
            } else {
                (Vector::ZERO, -force.dot(vector(&node.v[end])))
            }
        };
        let [(first, by_first), (second, by_second)] =
            [given(ends[0], force), given(ends[1], -force)];
        totals.momentum.anchors += first + second;
        totals.energy.anchors += (by_first + by_second) * node.weight;
    }

    fn add_sheets(
        &self,
        drag: &Drag,
        node: &GroupNode<'_>,
        time: Scalar,
        totals: &mut LedgerTotals,
    ) {
        let GroupNode { bodies, x, v, .. } = node;
        let mut forces = vec![[0.0; 4]; x.len()];
        self.coupling.blow(drag, time, x, v, &mut forces);
        let (mut work, mut impulse, mut angular) = (0.0, Vector::ZERO, Vector::ZERO);
        for (i, body) in self.body_of_row[..self.coupling.movable].iter().enumerate() {
            let weighted = bodies[*body].along_open_axes(vector(&forces[i])) * node.weight;
            work += weighted.dot(vector(&v[i]));
            impulse += weighted;
            angular += vector(&x[i]).cross(weighted);
        }
        totals.add_impulse("drag", impulse, angular);
        totals.energy.add_law("drag", work);
    }

    fn add_attraction(&self, law: &MutualGravity, node: &GroupNode<'_>, totals: &mut LedgerTotals) {
        let coupling = self.coupling;
        for a in 0..coupling.movable {
            // Between two movable bodies the impulses cancel.
            let from = if self.locked { a + 1 } else { coupling.movable };
            for b in from..coupling.rows {
                if let Some(pull) =
                    coupling.attraction_between(law, [a, b], &node.x, &self.inverse_masses)
                {
                    self.add_pair(node, [a, b], pull, totals);
                }
            }
        }
    }
}
