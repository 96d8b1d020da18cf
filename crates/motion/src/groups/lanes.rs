//! Groups of one shape side by side: the same row of several groups is a block of bodies, and a spring is one loop.
//!
//! Groups have one shape if they have as many rows, the same springs between the same rows, as many substeps and the same
//! options, and if their rows are in the same tables. Masses, anchors, stiffnesses and forces are numbers: they differ by
//! lane. Each group has the same operations in the same order as alone, and so the same bits.

use std::collections::HashMap;

use bevy_ecs::entity::Entity;
use fearless_simd::{Simd, f64x4, prelude::*};

use super::Group;
use super::coupling::Coupling;
use super::field::{GroupCache, Scratch};
use super::pull::{AT_ONCE, FourElastic, tension};
use super::rows::{Array, Element as _};
use crate::kernels::BodyOptions;
use crate::laws::{Axes, BLOCK_BODIES};
use crate::simd::with_simd;
use crate::state::springs::Elastic;

/// Most rows of a group that is integrated beside others: the arrays of larger groups leave the caches.
const MOST_ROWS: usize = 256;

/// Approximate number of elements of the movable rows of a bundle: enough to share the fixed time of a tick, few enough that
/// the arrays of all stages stay in the second-level cache.
const ELEMENTS: usize = 16;

/// The fixed time of a tick, in units of the time per row of a group alone (measured in docs/performance.md).
const FIXED: usize = 40;
/// The time per row of a block of groups, in the same units.
const BLOCK_ROW: usize = 24;

/// Whether integrating `groups` groups of `rows` movable rows each side by side is faster than one by one.
fn is_worth(groups: usize, rows: usize) -> bool {
    groups > 1
        && groups * (FIXED + rows) >= FIXED + groups.div_ceil(BLOCK_BODIES) * BLOCK_ROW * rows
}

/// Groups that are integrated side by side, a lane each.
#[derive(Debug)]
pub(super) struct Bundle {
    /// The numbers of the groups by lane, ascending.
    pub groups: Vec<usize>,
    /// The number of elements.
    pub elements: usize,
    /// Elements of a row.
    pub width: usize,
    /// The table rows of the movable rows.
    pub members: Vec<LaneRun>,
    /// The table rows of the anchors.
    pub anchors: Vec<LaneRun>,
    pub springs: LaneSprings,
    pub cache: GroupCache<Axes>,
    /// Whether groups have caches of their own, because their rows were in other classes.
    pub has_other_caches: bool,
    /// Groups whose anchors are not finite or out of range, ascending.
    pub lost: Vec<usize>,
    /// Groups with an anchor that moves, ascending.
    pub moving: Vec<usize>,
}

impl Bundle {
    /// Element and lane of a row of a group.
    #[inline(always)]
    pub fn place(&self, row: usize, group: usize) -> (usize, usize) {
        Axes::place(self.width, row, group)
    }
}

/// Equally spaced rows of a table that hold the same row of consecutive groups of a bundle.
#[derive(Debug)]
pub(super) struct LaneRun {
    /// The number of the table among the [places](super::Groups::places).
    pub place: usize,
    pub start: usize,
    pub step: usize,
    pub row: usize,
    /// The first group.
    pub group: usize,
    pub bodies: Vec<Entity>,
}

impl LaneRun {
    /// Appends the body of the next group, at the row `at` of a table, if it continues the run. Returns whether it does.
    pub fn takes(&mut self, place: usize, at: usize, body: Entity) -> bool {
        let len = self.bodies.len();
        let step = match len {
            1 => at.checked_sub(self.start),
            _ => Some(self.step),
        };
        match step {
            Some(step) if place == self.place && self.start + len * step == at => {
                self.step = step;
                self.bodies.push(body);
                true
            }
            _ => false,
        }
    }

    /// Whether the bodies of the run are still at the same rows of their table, which now holds `entities`.
    pub fn is_in(&self, entities: &[Entity]) -> bool {
        let Self { start, step, bodies, .. } = self;
        match entities.get(*start..) {
            Some(rows) if *step == 1 => rows.starts_with(bodies),
            Some([first, ..]) if *step == 0 => bodies.iter().all(|body| body == first),
            Some(rows) if *step > 0 => rows.iter().step_by(*step).take(bodies.len()).eq(bodies),
            _ => false,
        }
    }

    /// Calls `each` for each part within one element, with (first row of the table, number of rows) and (element, first lane).
    #[inline(always)]
    pub fn parts(&self, bundle: &Bundle, mut each: impl FnMut((usize, usize), (usize, usize))) {
        let (mut element, mut lane) = bundle.place(self.row, self.group);
        let (mut at, mut left) = (self.start, self.bodies.len());
        while left > 0 {
            let rows = left.min(BLOCK_BODIES - lane);
            each((at, rows), (element, lane));
            (at, left) = (at + rows * self.step, left - rows);
            (element, lane) = (element + 1, 0);
        }
    }
}

/// All bundles of a world. The rows are those of the bundle that is being integrated: one set of arrays stays in the caches.
#[derive(Debug, Default)]
pub(super) struct Bundles {
    pub list: Vec<Bundle>,
    pub x: Array<Axes>,
    pub v: Array<Axes>,
    /// Inverse masses, 1/kg, of every lane of every element.
    pub w: Vec<f64>,
    /// Lengths of last steps, s, of every lane of every element.
    pub last: Vec<f64>,
    pub scratch: Scratch<Axes>,
    pub lists: Lists,
}

/// Lists of lanes of the bundle that is being integrated, each ascending.
#[derive(Debug, Default)]
pub(super) struct Lists {
    /// Groups that are integrated alone in this tick.
    pub alone: Vec<usize>,
    /// The groups in `alone` and those whose anchors are not finite or out of range.
    pub apart: Vec<usize>,
    /// Groups that fail.
    pub failed: Vec<usize>,
}

impl Lists {
    /// Fills the lists at the start of a tick: `list` adds the groups to integrate alone, and the `lost` groups fail.
    pub fn fill(&mut self, lost: &[usize], list: impl FnOnce(&mut Vec<usize>)) {
        let Self { alone, apart, failed } = self;
        for list in [&mut *alone, &mut *apart, &mut *failed] {
            list.clear();
        }
        list(alone);
        alone.retain(|lane| lost.binary_search(lane).is_err());
        apart.extend(alone.iter().chain(lost));
        for list in [alone, apart] {
            list.sort_unstable();
            list.dedup();
        }
        failed.extend(lost);
    }
}

/// The properties that all groups of one bundle have in common.
#[derive(PartialEq, Eq, Hash)]
struct Shape {
    movable: usize,
    rows: usize,
    ends: Vec<[u32; 2]>,
    damped: bool,
    substeps: Option<u32>,
    /// The tables of the movable rows.
    tables: Vec<usize>,
    /// Rows with options other than own laws and substeps, and these options.
    options: Vec<(u32, OptionBits)>,
}

/// Options of a row that are not laws.
type OptionBits = (bool, Option<u64>, Option<u64>, Option<[bool; 3]>);

fn bits(options: &BodyOptions<'_>) -> OptionBits {
    let BodyOptions { gravity_off, damping_rate, speed_limit, locks, .. } = *options;
    let locks = locks.map(|locks| [locks.x, locks.y, locks.z]);
    (gravity_off, damping_rate.map(f64::to_bits), speed_limit.map(f64::to_bits), locks)
}

/// Table and row of every row of a group; `None` for one that is in no table.
pub(super) type Places = Vec<Option<(usize, usize)>>;

impl Shape {
    /// The shape of a group; `None` if it is integrated alone.
    fn of<'o>(
        group: &Group,
        places: &Places,
        options: impl Fn(u32) -> BodyOptions<'o>,
    ) -> Option<Self> {
        let Coupling {
            rows,
            movable,
            ref springs,
            ref sheets,
            attracts,
            ref sources,
            ref motions,
            ..
        } = group.coupling;
        let is_small = rows <= MOST_ROWS
            && sheets.is_empty()
            && !attracts
            && group.with_laws.is_empty()
            && springs.cords().is_empty()
            && motions.is_empty()
            && !group.chooses_substeps;
        if !is_small || !sources.iter().all(|source| source.is_finite()) {
            return None;
        }
        let placed: Option<Vec<_>> = places.iter().copied().collect();
        Some(Self {
            movable,
            rows,
            ends: springs.iter().map(|spring| spring.ends).collect(),
            damped: springs.damped(),
            substeps: group.substeps,
            tables: placed?[..movable].iter().map(|(table, _)| *table).collect(),
            options: group.with_options.iter().map(|row| (*row, bits(&options(*row)))).collect(),
        })
    }
}

/// Collects groups of equal shape into bundles where that is faster. Returns the group numbers of each bundle, in ascending
/// order.
pub(super) fn bundles<'o>(
    list: &[Group],
    places: &[Places],
    options: impl Fn(usize, u32) -> BodyOptions<'o>,
) -> Vec<Vec<usize>> {
    let mut alike: HashMap<Shape, Vec<usize>> = HashMap::new();
    for (number, (group, places)) in list.iter().zip(places).enumerate() {
        if let Some(shape) = Shape::of(group, places, |row| options(number, row)) {
            alike.entry(shape).or_default().push(number);
        }
    }
    let mut bundles: Vec<Vec<usize>> = Vec::new();
    for (Shape { movable, .. }, groups) in alike {
        let parts = groups.chunks(ELEMENTS.div_ceil(movable) * BLOCK_BODIES);
        bundles.extend(parts.filter(|part| is_worth(part.len(), movable)).map(<[usize]>::to_vec));
    }
    bundles.sort_unstable();
    bundles
}

impl Bundles {
    /// Makes bundles of these groups and moves the caches of the groups into them.
    pub fn make(&mut self, groups: Vec<Vec<usize>>, list: &mut [Group]) {
        for groups in groups {
            let Coupling { rows, .. } = list[groups[0]].coupling;
            let width = groups.len().div_ceil(BLOCK_BODIES);
            let mut bundle = Bundle {
                width,
                elements: rows * width,
                members: Vec::new(),
                anchors: Vec::new(),
                springs: LaneSprings::of(&groups, list, width),
                cache: GroupCache::default(),
                has_other_caches: false,
                lost: Vec::new(),
                moving: Vec::new(),
                groups,
            };
            for (lane, group) in bundle.groups.iter().enumerate() {
                bundle.has_other_caches |=
                    !bundle.cache.move_group_from(width, lane, &mut list[*group].cache);
            }
            self.list.push(bundle);
        }
        let most = self.list.iter().map(|bundle| bundle.elements).max().unwrap_or(0);
        self.x.resize(most);
        self.v.resize(most);
        self.w.resize(most * BLOCK_BODIES, 0.0);
        self.last.resize(most * BLOCK_BODIES, 0.0);
    }

    /// Dissolves all bundles; their groups get their caches back.
    pub fn dissolve(&mut self, list: &mut [Group]) {
        for mut bundle in self.list.drain(..) {
            for (lane, group) in bundle.groups.iter().enumerate() {
                let Group { coupling, cache, .. } = &mut list[*group];
                bundle.cache.move_group_to(bundle.width, coupling.rows, lane, cache);
            }
        }
    }

    /// Copies the first lane of the last block into the lanes beyond the last group of a bundle, so that they stay finite.
    pub fn fill_up(&mut self, number: usize) {
        let Bundle { elements, width, ref groups, .. } = self.list[number];
        let rest = groups.len() % BLOCK_BODIES;
        if rest == 0 {
            return;
        }
        for last in (width - 1..elements).step_by(width) {
            let (x, v) = (self.x[last].row(0), self.v[last].row(0));
            let w = &mut self.w[last * BLOCK_BODIES..][..BLOCK_BODIES];
            // Laws skip bodies of inverse mass 0; a block that is almost full is faster without such bodies.
            let filler = if rest > BLOCK_BODIES / 4 { w[0] } else { 0.0 };
            w[rest..].fill(filler);
            for lane in rest..BLOCK_BODIES {
                self.x[last].set_row(lane, x);
                self.v[last].set_row(lane, v);
            }
        }
    }

    /// Allocated bytes.
    pub fn bytes(&self) -> usize {
        let springs: usize = self.list.iter().map(|bundle| bundle.springs.bytes()).sum();
        let numbers = self.w.capacity() + self.last.capacity();
        springs
            + size_of_val(&*self.x)
            + size_of_val(&*self.v)
            + numbers * size_of::<f64>()
            + self.scratch.bytes()
    }
}

/// Stiffness, damping and rest length of a spring in a block of groups, in single numbers where they are all equal.
#[derive(Clone, Debug)]
pub(crate) enum ElasticLanes {
    Equal(Elastic),
    /// Stiffnesses, dampings and rest lengths.
    Each(Box<[[f64; BLOCK_BODIES]; 3]>),
}

impl ElasticLanes {
    /// The properties of a spring in the groups of a block; the first group fills the unused lanes.
    fn of(springs: &[Elastic]) -> Self {
        if springs.iter().all(|spring| spring.bits() == springs[0].bits()) {
            return Self::Equal(springs[0]);
        }
        let lane = |lane: usize| springs.get(lane).unwrap_or(&springs[0]);
        Self::Each(Box::new([
            std::array::from_fn(|k| lane(k).stiffness),
            std::array::from_fn(|k| lane(k).damping),
            std::array::from_fn(|k| lane(k).rest_length),
        ]))
    }
}

/// The springs of several groups of one shape, in the order in which their forces are summed.
#[derive(Debug)]
pub(crate) struct LaneSprings {
    /// The blocks of every spring.
    blocks: Vec<ElasticLanes>,
    width: usize,
}

impl LaneSprings {
    /// The springs of the groups numbered `groups` in `list`, each spring in `width` blocks.
    fn of(groups: &[usize], list: &[Group], width: usize) -> Self {
        let mut springs: Vec<_> =
            groups.iter().map(|group| list[*group].coupling.springs.iter()).collect();
        let of_each = list[groups[0]].coupling.springs.len();
        let mut blocks = Vec::with_capacity(of_each * width);
        let mut lanes = Vec::new();
        for _ in 0..of_each {
            for block in springs.chunks_mut(BLOCK_BODIES) {
                lanes.clear();
                lanes.extend(
                    block.iter_mut().filter_map(Iterator::next).map(|spring| spring.elastic),
                );
                blocks.push(ElasticLanes::of(&lanes));
            }
        }
        Self { blocks, width }
    }

    fn bytes(&self) -> usize {
        let each =
            self.blocks.iter().filter(|block| matches!(block, ElasticLanes::Each(_))).count();
        self.blocks.capacity() * size_of::<ElasticLanes>()
            + each * size_of::<[[f64; BLOCK_BODIES]; 3]>()
    }

    /// The springs of a block of groups.
    pub fn of_block(&self, block: usize) -> impl Iterator<Item = &ElasticLanes> {
        self.blocks.iter().skip(block).step_by(self.width)
    }

    /// Adds the forces of the springs in the state (`x`, `v`) to `sum` on the movable rows, N. Takes only the ends of the springs
    /// from `coupling`.
    pub fn pull(&self, coupling: &Coupling, x: &[Axes], v: &[Axes], sum: &mut [Axes]) {
        if coupling.springs.damped() {
            with_simd!(simd => self.add::<_, true>(simd, coupling, x, v, sum));
        } else {
            with_simd!(simd => self.add::<_, false>(simd, coupling, x, v, sum));
        }
    }

    #[inline(always)]
    fn add<S: Simd, const DAMPED: bool>(
        &self,
        simd: S,
        coupling: &Coupling,
        x: &[Axes],
        v: &[Axes],
        sum: &mut [Axes],
    ) {
        for (spring, blocks) in coupling.springs.iter().zip(self.blocks.chunks_exact(self.width)) {
            let [a, b] = spring.ends.map(|end| end as usize);
            let moves = [a < coupling.movable, b < coupling.movable];
            for (block, elastic) in blocks.iter().enumerate() {
                let ends = [a, b].map(|row| row * self.width + block);
                elastic.pull::<_, DAMPED>(simd, ends, moves, x, v, sum);
            }
        }
    }
}

impl ElasticLanes {
    /// The properties of four lanes.
    #[inline(always)]
    pub(super) fn four<S: Simd>(&self, simd: S, at: usize) -> FourElastic<S> {
        match self {
            Self::Equal(Elastic { stiffness, damping, rest_length, .. }) => FourElastic {
                stiffness: f64x4::splat(simd, *stiffness),
                damping: f64x4::splat(simd, *damping),
                rest_length: f64x4::splat(simd, *rest_length),
            },
            Self::Each(numbers) => each(simd, at, numbers),
        }
    }

    /// Adds the forces on the ends that move to `sum`, with the bits of [`Springs::pull`](super::pull::Springs::pull).
    #[inline(always)]
    fn pull<S: Simd, const DAMPED: bool>(
        &self,
        simd: S,
        [a, b]: [usize; 2],
        moves: [bool; 2],
        x: &[Axes],
        v: &[Axes],
        sum: &mut [Axes],
    ) {
        let (ends, x, v) = ([a, b], [&x[a], &x[b]], [&v[a], &v[b]]);
        match self {
            // With a rest length of 0 the force over the length is the stiffness.
            Self::Equal(Elastic { stiffness, rest_length: 0.0, .. }) if !DAMPED => {
                let stiffness = f64x4::splat(simd, *stiffness);
                pull_with(
                    simd,
                    ends,
                    moves,
                    x,
                    sum,
                    #[inline(always)]
                    |_, _| stiffness,
                );
            }
            Self::Equal(_) => {
                let elastic = self.four(simd, 0);
                pull_elastic::<_, DAMPED>(
                    simd,
                    ends,
                    moves,
                    x,
                    v,
                    sum,
                    #[inline(always)]
                    |_| elastic,
                );
            }
            Self::Each(numbers) => pull_elastic::<_, DAMPED>(
                simd,
                ends,
                moves,
                x,
                v,
                sum,
                #[inline(always)]
                |at| each(simd, at, numbers),
            ),
        }
    }
}

/// The properties of four lanes of [`ElasticLanes::Each`].
#[inline(always)]
fn each<S: Simd>(simd: S, at: usize, numbers: &[[f64; BLOCK_BODIES]; 3]) -> FourElastic<S> {
    let [stiffness, damping, rest_length] = three(simd, at, numbers);
    FourElastic { stiffness, damping, rest_length }
}

/// [`pull_with`] for springs with the properties that `elastic` returns for the four lanes from the given one on.
#[inline(always)]
fn pull_elastic<S: Simd, const DAMPED: bool>(
    simd: S,
    ends: [usize; 2],
    moves: [bool; 2],
    x: [&Axes; 2],
    v: [&Axes; 2],
    sum: &mut [Axes],
    elastic: impl Fn(usize) -> FourElastic<S>,
) {
    pull_with(
        simd,
        ends,
        moves,
        x,
        sum,
        #[inline(always)]
        |at, d| {
            let u = if DAMPED { differences(simd, at, v) } else { d };
            tension::<_, DAMPED>(simd, elastic(at), d, u)
        },
    );
}

/// Adds the forces of springs whose ends are at `x` to those on the ends that move; `tension` returns force over length,
/// N/m, for the four lanes from the given one on.
#[inline(always)]
fn pull_with<S: Simd>(
    simd: S,
    [a, b]: [usize; 2],
    [a_moves, b_moves]: [bool; 2],
    x: [&Axes; 2],
    sum: &mut [Axes],
    tension: impl Fn(usize, [f64x4<S>; 3]) -> f64x4<S>,
) {
    for at in (0..BLOCK_BODIES).step_by(AT_ONCE) {
        let d = differences(simd, at, x);
        let tension = tension(at, d);
        for axis in 0..3 {
            let pull = d[axis] * tension;
            if a_moves {
                let sum = &mut sum[a][axis];
                (four(simd, at, sum) + pull).store_slice(&mut sum[at..at + AT_ONCE]);
            }
            if b_moves {
                let sum = &mut sum[b][axis];
                (four(simd, at, sum) - pull).store_slice(&mut sum[at..at + AT_ONCE]);
            }
        }
    }
}

/// Four lanes from `at` on.
#[inline(always)]
pub(super) fn four<S: Simd>(simd: S, at: usize, numbers: &[f64; BLOCK_BODIES]) -> f64x4<S> {
    f64x4::from_slice(simd, &numbers[at..at + AT_ONCE])
}

/// Four lanes of three numbers each.
#[inline(always)]
pub(super) fn three<S: Simd>(
    simd: S,
    at: usize,
    [a, b, c]: &[[f64; BLOCK_BODIES]; 3],
) -> [f64x4<S>; 3] {
    [four(simd, at, a), four(simd, at, b), four(simd, at, c)]
}

/// x, y and z of the second minus those of the first. Without closures, which would be compiled without the vector
/// instructions of their caller.
#[inline(always)]
pub(super) fn differences<S: Simd>(
    simd: S,
    at: usize,
    [first, second]: [&Axes; 2],
) -> [f64x4<S>; 3] {
    let ([a, b, c], [d, e, f]) = (three(simd, at, first), three(simd, at, second));
    [d - a, e - b, f - c]
}
