//! A group as a linear system, linearized in its present state.

use std::cell::RefCell;

use bevy_ecs::prelude::*;
use glam::{DMat3, DVec3};

use super::coupling::{Coupling, SheetRow, add, in_air, is_open, rate_along};
use super::pull::{Linearized, Share, SpringRow, axis, positive};
use super::rows::{Row, row_of};
use super::states_of;
use crate::kernels::record::vector;
use crate::laws::damping::{Damping, DampingRate};
use crate::laws::{BodyState, Drag, EvaluationTime, Law, Well, Wells};
use crate::state::clock::StepClock;
use crate::state::components::AxisLocks;
use crate::state::threads::Threads;
use crate::units::Scalar;

/// A linearized spring.
#[derive(Clone, Copy, Debug)]
struct Stiff {
    ends: [usize; 2],
    n: DVec3,
    /// Stiffness along the axis, N/m.
    along: Scalar,
    /// Stiffness across the axis, N/m.
    across: Scalar,
    /// Damping along the axis, N s/m.
    damping: Scalar,
}

/// Factors, bounds or quotients of the two terms of a linear system.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Terms {
    /// Of A; a bound or a quotient in 1/s².
    pub stiffness: Scalar,
    /// Of C; a bound or a quotient in 1/s.
    pub damping: Scalar,
}

impl Terms {
    /// Factors that leave A alone.
    pub const STIFFNESS: Self = Self { stiffness: 1.0, damping: 0.0 };
    /// Factors that leave C alone.
    pub const DAMPING: Self = Self { stiffness: 0.0, damping: 1.0 };

    /// The [larger](larger) of each.
    pub fn larger(self, other: Self) -> Self {
        Self {
            stiffness: larger(self.stiffness, other.stiffness),
            damping: larger(self.damping, other.damping),
        }
    }
}

/// The movable bodies of a group as `y'' = -A y - C y'` with `y = W^-½ x`: three numbers per row.
///
/// Springs are linearized on the fly: a list of them would take more memory than the rest of a large world.
#[derive(Debug)]
pub(crate) struct LinearGroup<'a> {
    coupling: &'a Coupling,
    /// Positions by row, m.
    at: Vec<Row>,
    /// Square roots of inverse masses by row and axis; 0 along axes on which the row cannot move.
    root: Vec<DVec3>,
    /// Triangles in air: corners, normal and `m (c + k |u| + k (u·n)² / |u|) / 9`, kg/s.
    sheets: Vec<([usize; 3], DVec3, Scalar)>,
    /// Negative derivative of drag by velocity of every row, 1/s; empty without drag.
    drag: Vec<DMat3>,
    /// The restoring part of the negative derivative of wells by position, by row, 1/s²; empty without wells.
    wells: Vec<DMat3>,
    /// Rates of the scene's damping by row, 1/s; empty without damping.
    rates: Vec<Scalar>,
    /// Length of the interval over which the scene's damping acts, in steps of the laws.
    decays: Scalar,
    threads: Option<&'a Threads>,
    /// The shares of the threads in the forces of springs.
    shares: Vec<Share>,
    /// Arrays that a product needs, reused for the next one.
    spare: RefCell<[Vec<Row>; 2]>,
}

/// The part of a group that contributes most to a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Contributor {
    Spring([usize; 2]),
    Damper([usize; 2]),
    Drag(usize),
    Damping(usize),
    /// All wells at a row.
    Well(usize),
}

impl<'a> LinearGroup<'a> {
    /// Linearizes a group in its present state; `bodies` are in the order of its rows.
    pub fn of(world: &'a World, coupling: &'a Coupling, bodies: &[Entity]) -> Self {
        let threads = Threads::for_rows(world.get_resource(), coupling.rows);
        let states = states_of(world, bodies);
        let movable = coupling.movable;
        let root = states[..movable].iter().zip(bodies).map(|(state, body)| {
            let locks = world.get::<AxisLocks>(*body).copied();
            let root = state.inverse_mass.max(0.0).sqrt();
            DVec3::from_array([0, 1, 2].map(|axis| if is_open(locks, axis) { root } else { 0.0 }))
        });
        let mut group = Self {
            coupling,
            at: states.iter().map(|state| row_of(state.position)).collect(),
            root: root.collect(),
            sheets: Vec::new(),
            drag: Vec::new(),
            wells: Vec::new(),
            rates: Vec::new(),
            decays: 1.0,
            threads,
            shares: threads.map_or_else(Vec::new, |threads| {
                coupling.springs.shares(coupling.rows, threads.count())
            }),
            spare: RefCell::default(),
        };
        if let Some(drag) = world.get_resource::<Drag>() {
            let time = world.get_resource::<StepClock>().map_or(0.0, StepClock::scene_seconds);
            group.add_drag(drag, time, &states);
        }
        if let Some(Wells(wells)) = world.get_resource() {
            let mut has_spring = vec![false; states.len()];
            let ends = coupling.springs.iter().flat_map(|spring| spring.ends);
            ends.for_each(|end| has_spring[end as usize] = true);
            let pull = |(state, has_spring): (&BodyState, &bool)| {
                // A well that repels throws a free body away before its mode has a period.
                let acts = |well: &&Well| *has_spring || well.strength > 0.0;
                let pulls = wells.iter().filter(acts).filter(|_| state.inverse_mass > 0.0);
                pulls
                    .map(|well| well.restoring(state.position))
                    .fold(DMat3::ZERO, |sum, pull| sum + pull)
            };
            group.wells = states[..movable].iter().zip(&has_spring).map(pull).collect();
        }
        if let Some(damping) = world.get_resource::<Damping>() {
            let rate = |body: &Entity| {
                world.get::<DampingRate>(*body).map_or(damping.rate, DampingRate::rate)
            };
            group.rates = bodies[..movable].iter().map(rate).collect();
        }
        group
    }

    fn add_drag(&mut self, drag: &Drag, time: Scalar, states: &[BodyState]) {
        let coupling = self.coupling;
        let rows = states.iter().map(|state| (row_of(state.position), row_of(state.velocity)));
        let (x, v): (Vec<_>, Vec<_>) = rows.unzip();
        let air = drag.wind.map(|wind| wind.air(time));
        for SheetRow { corners, mass } in &coupling.sheets {
            if let Some((u, n)) = in_air(air.as_ref(), *corners, &x, &v) {
                let strength = mass * rate_along(drag, u, n) / 9.0;
                self.sheets.push((corners.map(|corner| corner as usize), n, strength));
            }
        }
        let at = EvaluationTime { time, within_step: time };
        let single = |(row, state): (usize, &BodyState)| {
            let in_sheet =
                u32::try_from(row).is_ok_and(|row| coupling.in_sheets.binary_search(&row).is_ok());
            if in_sheet || state.inverse_mass <= 0.0 {
                return DMat3::ZERO;
            }
            -Law::jacobians(drag, at, *state).velocity
        };
        self.drag = states[..coupling.movable].iter().enumerate().map(single).collect();
    }

    /// Returns the system with the whole derivative of wells, not only its restoring part: A may then have negative eigenvalues.
    pub fn with_whole_wells(mut self, world: &World, bodies: &[Entity]) -> Self {
        if let Some(wells) = world.get_resource::<Wells>() {
            let at = EvaluationTime { time: 0.0, within_step: 0.0 };
            let states = states_of(world, &bodies[..self.movable()]);
            self.wells =
                states.iter().map(|state| -Law::jacobians(wells, at, *state).position).collect();
        }
        self
    }

    /// The number of movable bodies.
    pub const fn movable(&self) -> usize {
        self.root.len()
    }

    /// The number of coordinates: three per row.
    pub fn coordinates(&self) -> usize {
        3 * self.root.len()
    }

    fn springs(&self) -> impl Iterator<Item = Stiff> {
        self.coupling.springs.iter().map(|spring| Stiff::of(&spring, &self.at))
    }

    /// The rows that each spring joins.
    pub fn ends(&self) -> impl Iterator<Item = [usize; 2]> {
        self.coupling.springs.iter().map(|spring| spring.ends.map(|end| end as usize))
    }

    /// Returns the system with the scene's damping over intervals `times` as long.
    pub const fn with_longer_decays(mut self, times: Scalar) -> Self {
        self.decays = times;
        self
    }

    /// Rates of the scene's damping by row, 1/s; empty without damping.
    pub fn rates(&self) -> &[Scalar] {
        &self.rates
    }

    /// The rate c of all laws if they are `-c v` on every row, 1/s.
    pub fn uniform_rate(&self) -> Option<Scalar> {
        // Not `unwrap_or_default`: the default matrix is the identity.
        let rate = self.drag.first().map_or(0.0, |first| first.x_axis.x);
        let damped = self.coupling.springs.damped();
        let uniform =
            self.drag.iter().all(|drag| *drag == DMat3::from_diagonal(DVec3::splat(rate)));
        (!damped && self.sheets.is_empty() && uniform).then_some(rate)
    }

    /// The rate of the scene's damping if it is the same on every row; the inner `None` is no damping.
    pub fn uniform_damping(&self) -> Option<Option<Scalar>> {
        let first = self.rates.first().copied();
        self.rates.iter().all(|rate| Some(*rate) == first).then_some(first)
    }

    /// Computes `out = stiffness A y + damping C y`, where C includes the scene's damping.
    pub fn apply(&self, terms: Terms, y: &[Scalar], out: &mut [Scalar]) {
        self.apply_laws(terms, y, out);
        self.damp(terms.damping, y, out);
    }

    /// [`Self::apply`] without the scene's damping.
    pub fn apply_laws(
        &self,
        Terms { stiffness, damping }: Terms,
        y: &[Scalar],
        out: &mut [Scalar],
    ) {
        // Once per row, because a row has many springs.
        let each = self.root.iter().zip(y.as_chunks().0);
        let [mut scaled, mut forces] = self.spare.take();
        scaled.clear();
        scaled.extend(each.map(|(root, y)| row_of(*root * DVec3::from_array(*y))));
        forces.clear();
        [&mut scaled, &mut forces]
            .into_iter()
            .for_each(|rows| rows.resize(self.at.len(), [0.0; 4]));
        let springs = &self.coupling.springs;
        if stiffness != 0.0 || springs.damped() {
            let shares = self.threads.map(|threads| (threads, &self.shares[..]));
            let change = Linearized {
                x: &self.at,
                axes: None,
                moves: &scaled,
                stiffness,
                damping,
                times: -1.0,
            };
            springs.add(shares, &change, &mut forces);
        }
        for (corners, n, strength) in &self.sheets {
            let sum = corners.iter().map(|corner| vector(&scaled[*corner])).sum::<DVec3>();
            let force = *n * (damping * strength * n.dot(sum));
            corners.iter().for_each(|corner| add(&mut forces[*corner], force));
        }
        let rows: &mut [[Scalar; 3]] = out.as_chunks_mut().0;
        for ((sum, force), root) in rows.iter_mut().zip(&forces).zip(&self.root) {
            *sum = (vector(force) * *root).to_array();
        }
        self.spare.replace([scaled, forces]);
        for (row, drag) in self.drag.iter().enumerate() {
            let open = self.root[row].cmpgt(DVec3::ZERO);
            let y = DVec3::select(open, DVec3::from_slice(&y[3 * row..]), DVec3::ZERO);
            let part = DVec3::select(open, *drag * y * damping, DVec3::ZERO).to_array();
            (0..3).for_each(|axis| out[3 * row + axis] += part[axis]);
        }
        for (row, pull) in self.wells.iter().enumerate() {
            let open = self.root[row].cmpgt(DVec3::ZERO);
            let y = DVec3::select(open, DVec3::from_slice(&y[3 * row..]), DVec3::ZERO);
            let part = DVec3::select(open, *pull * y * stiffness, DVec3::ZERO).to_array();
            (0..3).for_each(|axis| out[3 * row + axis] += part[axis]);
        }
    }

    /// Amplitude of each movable body in the mode y: the length of its part of `W^½ y`.
    pub fn amplitudes(&self, y: &[Scalar]) -> impl Iterator<Item = Scalar> {
        let rows = self.root.iter().zip(y.as_chunks().0);
        rows.map(|(root, y)| (*root * DVec3::from_array(*y)).length())
    }

    /// Adds `rate C y` to `out`, where C is the scene's damping alone.
    pub fn damp(&self, rate: Scalar, y: &[Scalar], out: &mut [Scalar]) {
        for (row, own) in self.rates.iter().enumerate() {
            let own = rate * self.decays * own;
            (0..3).for_each(|axis| out[3 * row + axis] += own * y[3 * row + axis]);
        }
    }

    /// Bounds of each spring's part in the largest eigenvalue of A, 1/s², and of C, 1/s: the stiffnesses and the dampings of all
    /// springs at its ends, summed and divided by the masses of the ends (Gershgorin 1931, on springs instead of bodies). The
    /// largest of these bounds hold for the eigenvalues.
    pub fn bounds(&self) -> impl Iterator<Item = Terms> {
        let mut sums = vec![Terms::default(); self.root.len()];
        for Stiff { ends, along, damping, .. } in self.springs() {
            for end in ends {
                if let Some(sum) = sums.get_mut(end) {
                    let w = square(self.root[end].max_element());
                    sum.stiffness += w * along;
                    sum.damping += w * damping;
                }
            }
        }
        self.ends().map(move |ends| {
            let [a, b] = ends.map(|end: usize| sums.get(end).copied().unwrap_or_default());
            Terms { stiffness: a.stiffness + b.stiffness, damping: a.damping + b.damping }
        })
    }

    /// An upper bound of the largest eigenvalue of the operator of [`Self::apply`]. Each spring is split
    /// between its ends by `(u - v)² <= (1 + t) u² + (1 + 1/t) v²`, where t is the ratio of their inverse masses; the bound is
    /// the largest eigenvalue of a single row. It is exact if neighbors can swing against each other, as in a lattice, for which
    /// Gershgorin's bound is three times as large.
    pub fn bound(&self, Terms { stiffness, damping }: Terms) -> Scalar {
        let squares: Vec<_> = self.root.iter().map(|root| square(root.max_element())).collect();
        let mut sums = vec![[0.0; 6]; self.root.len()];
        for spring in self.springs() {
            let along = stiffness * spring.along + damping * spring.damping;
            let across = stiffness * spring.across;
            let n = spring.n;
            let [xx, yy, zz] = (n * n * (along - across) + DVec3::splat(across)).to_array();
            let [yz, zx, xy] =
                (DVec3::new(n.y * n.z, n.z * n.x, n.x * n.y) * (along - across)).to_array();
            let of = |row: usize| squares.get(row).copied().unwrap_or(0.0);
            let [a, b] = spring.ends;
            for (row, other) in [(a, b), (b, a)] {
                if let Some(sum) = sums.get_mut(row).filter(|_| of(row) > 0.0) {
                    let share = 1.0 + of(other) / of(row);
                    sum.iter_mut()
                        .zip([xx, yy, zz, yz, zx, xy])
                        .for_each(|(sum, part)| *sum += share * part);
                }
            }
        }
        let most =
            sums.iter().zip(&self.root).fold(0.0, |most, ([xx, yy, zz, yz, zx, xy], root)| {
                let r = *root;
                let diagonal = DVec3::new(*xx, *yy, *zz) * r * r;
                let beside = DVec3::new(*yz * r.y * r.z, *zx * r.z * r.x, *xy * r.x * r.y);
                largest_of_three(diagonal, beside, most)
            });
        most + stiffness * self.largest_pull() + damping * self.largest_rate()
    }

    /// A bound of the squared frequency of wells at a row, 1/s².
    pub fn largest_pull(&self) -> Scalar {
        self.wells.iter().map(size).fold(0.0, larger)
    }

    /// Largest rate of drag and of the scene's damping on a row, 1/s.
    pub fn largest_rate(&self) -> Scalar {
        let drag = self.drag.iter().map(size).fold(0.0, larger);
        // A triangle's normal forces push on at most all three corners.
        let mut sheets = vec![0.0; self.root.len()];
        for (corners, _, strength) in &self.sheets {
            for corner in corners {
                if let Some(sum) = sheets.get_mut(*corner) {
                    *sum += 3.0 * strength * square(self.root[*corner].max_element());
                }
            }
        }
        let air = sheets.into_iter().fold(drag, larger);
        air + self.decays * self.rates.iter().copied().fold(0.0, larger)
    }

    /// The row with the largest drag or damping.
    pub fn fastest_drag(&self) -> usize {
        let rate = |row: usize| {
            let damping = self.decays * self.rates.get(row).copied().unwrap_or_default();
            larger(self.drag.get(row).map_or(0.0, size), damping)
        };
        (0..self.root.len()).max_by(|a, b| rate(*a).total_cmp(&rate(*b))).unwrap_or_default()
    }

    /// The largest contributor to `stiffness y·A y + damping y·C y`.
    pub fn largest_contributor(
        &self,
        Terms { stiffness, damping }: Terms,
        y: &[Scalar],
    ) -> Option<Contributor> {
        let of = |row: usize| match self.root.get(row) {
            Some(root) => *root * DVec3::from_slice(&y[3 * row..]),
            None => DVec3::ZERO,
        };
        let by_springs = self.springs().flat_map(|spring| {
            let [a, b] = spring.ends;
            let d = of(b) - of(a);
            let along = square(spring.n.dot(d));
            let held = spring.along * along + spring.across * (d.length_squared() - along);
            [
                (stiffness * held, Contributor::Spring(spring.ends)),
                (damping * spring.damping * along, Contributor::Damper(spring.ends)),
            ]
        });
        let by_sheets = self.sheets.iter().map(|(corners, n, strength)| {
            let sum = corners.iter().map(|corner| of(*corner)).sum::<DVec3>();
            (damping * strength * square(n.dot(sum)), Contributor::Drag(corners[0]))
        });
        let own = |row: usize| DVec3::from_slice(&y[3 * row..]);
        let by_drag =
            self.drag.iter().enumerate().map(|(row, drag)| {
                (damping * own(row).dot(*drag * own(row)), Contributor::Drag(row))
            });
        let by_damping = self
            .rates
            .iter()
            .enumerate()
            .map(|(row, rate)| (row, damping * self.decays * rate * own(row).length_squared()))
            .map(|(row, part)| (part, Contributor::Damping(row)));
        let by_wells = self.wells.iter().enumerate().map(|(row, pull)| {
            (stiffness * own(row).dot(*pull * own(row)), Contributor::Well(row))
        });
        let all = by_springs.chain(by_sheets).chain(by_drag).chain(by_damping).chain(by_wells);
        all.max_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, contributor)| contributor)
    }
}

impl Stiff {
    #[inline(always)]
    fn of(SpringRow { ends, elastic }: &SpringRow, at: &[Row]) -> Self {
        let ends = ends.map(|end| end as usize);
        let d = vector(&at[ends[1]]) - vector(&at[ends[0]]);
        let (n, taut) = axis(d, elastic.rest_length);
        let along = if n == DVec3::ZERO && taut == 0.0 { 0.0 } else { elastic.stiffness };
        let across = elastic.stiffness * positive(taut);
        Self { ends, n, along, across, damping: elastic.damping }
    }
}

/// The larger of `most` and the largest eigenvalue of a symmetric matrix of three rows (Smith 1961): its diagonal,
/// and `beside`, its entries yz, zx and xy.
fn largest_of_three(diagonal: DVec3, beside: DVec3, most: Scalar) -> Scalar {
    let mean = diagonal.element_sum() / 3.0;
    let from_mean = diagonal - DVec3::splat(mean);
    let spread = ((from_mean.length_squared() + 2.0 * beside.length_squared()) / 6.0).sqrt();
    // NaN does not return here: `larger` makes it infinite.
    if mean + 2.0 * spread <= most {
        return most;
    }
    let (d, o) = (from_mean / spread, beside / spread);
    let half = (d.x * d.y * d.z + 2.0 * o.x * o.y * o.z
        - d.x * o.x * o.x
        - d.y * o.y * o.y
        - d.z * o.z * o.z)
        / 2.0;
    let turn = if half.is_finite() { libm::acos(half.clamp(-1.0, 1.0)) / 3.0 } else { 0.0 };
    larger(most, mean + 2.0 * spread * libm::cos(turn))
}

/// A bound of the norm of a derivative.
fn size(drag: &DMat3) -> Scalar {
    drag.to_cols_array_2d()
        .map(|column| DVec3::from(column).abs().element_sum())
        .into_iter()
        .fold(0.0, larger)
}

/// The larger of two numbers; infinite if one of them is NaN.
pub(crate) fn larger(a: Scalar, b: Scalar) -> Scalar {
    if a.is_nan() || b.is_nan() { Scalar::INFINITY } else { a.max(b) }
}

fn square(x: Scalar) -> Scalar {
    x * x
}
