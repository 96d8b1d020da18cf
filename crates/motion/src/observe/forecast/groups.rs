//! Groups: the fastest modes of springs and dampers.

use bevy_ecs::prelude::*;

use super::cure::LinearSystem;
use super::lanczos::{Largest, dot, largest, orthogonalize};
use super::matrix::Matrix;
use super::modes::{MOST, Modes, Pace};
use super::{LimitingPart, Margin, SpringMargin};
use crate::groups::{Coupling, Holder, LinearGroup, Solver, larger};
use crate::laws::damping::Damping;
use crate::methods::table::Method;
use crate::methods::{Integrator, with_method};
use crate::units::Scalar;

/// The margin of a group, if anything acts in it; its springs get theirs through `tell`.
pub(super) fn look(
    world: &World,
    coupling: &Coupling<Scalar>,
    bodies: &[Entity],
    pace: Pace,
    solvable: &dyn Fn(Method) -> bool,
    tell: Option<&mut Vec<SpringMargin>>,
) -> Option<Margin> {
    let damps_inside = with_method!(pace.method, M => M::DAMPS_INSIDE);
    let times = if damps_inside { 1.0 } else { f64::from(pace.substeps) };
    let group = LinearGroup::of(world, coupling, bodies).with_longer_decays(times);
    let h = pace.tick / f64::from(pace.substeps);
    let most = |most: [Scalar; 2], bound: [Scalar; 2]| [0, 1].map(|i| larger(most[i], bound[i]));
    let [stiffest, rate] = group.bounds().fold([0.0; 2], most);
    let rate = rate + group.largest_rate();
    let over = times_over([stiffest, rate], h);
    if over == 0.0 {
        return None;
    }
    let shares = || group.bounds().map(|bound| times_over(bound, h));
    let margin = if over.is_finite() {
        group_margin(world, &group, [stiffest, rate], [h, h / over], pace, solvable, bodies)?
    } else {
        endless(&group, shares(), bodies, pace, solvable)
    };
    if let Some(springs) = tell {
        let most = shares().fold(0.0, f64::max);
        let ratio = |share: Scalar| match share {
            _ if !over.is_finite() => share,
            0.0 => 0.0,
            share => margin.ratio() * share / most,
        };
        let each = group.ends().zip(shares());
        springs.extend(
            each.map(|(ends, share)| SpringMargin { ends: ends.map(|end| bodies[end]), ratio: ratio(share) }),
        );
    }
    Some(margin)
}

/// The margin of a group that is stepped by `h` seconds, of which the bounds hold that are given; `short` is a step at
/// which it is at most just stable.
fn group_margin(
    world: &World,
    group: &LinearGroup<'_>,
    bounds: [Scalar; 2],
    [h, short]: [Scalar; 2],
    pace: Pace,
    solvable: &dyn Fn(Method) -> bool,
    bodies: &[Entity],
) -> Option<Margin> {
    let damping = world.get_resource::<Damping>().copied();
    let restless = (pace.method.claims().stability_limit == 0.0).then_some(h);
    let LimitingMode { system, mode: y, quotients: [stiffness, rate], excess } =
        modes_of(group, damping, short, bounds, restless)?;
    let name = |row: usize| bodies[row];
    let (part, value, above) = match group.holder([short * short, 2.0 * short], &y)? {
        Holder::Spring(ends) => (LimitingPart::Spring(ends.map(name)), h * stiffness.sqrt(), excess.sqrt()),
        Holder::Damper(ends) => (LimitingPart::Damper(ends.map(name)), h * rate, excess),
        Holder::Drag(row) => (LimitingPart::Drag(name(row)), h * rate, excess),
        Holder::Damping(row) => (LimitingPart::Damping(name(row)), h * rate, excess),
    };
    let solver = world.get_resource::<Solver>().copied().unwrap_or_default();
    let converges =
        |method| method != Method::ImplicitEuler || converges(solver, group, h * h * stiffness + h * rate);
    let solvable = |method| solvable(method) && converges(method);
    Some(system.margin(part, group.movable(), [value, value * above], pace, &solvable))
}

/// The margin of a group whose fastest mode may be faster than every number; `shares` are those of its springs in that.
fn endless(
    group: &LinearGroup<'_>,
    shares: impl Iterator<Item = Scalar>,
    bodies: &[Entity],
    pace: Pace,
    solvable: &dyn Fn(Method) -> bool,
) -> Margin {
    let spring = group.ends().zip(shares).find(|(_, share)| !share.is_finite());
    let part = match spring {
        Some((ends, _)) => LimitingPart::Spring(ends.map(|end| bodies[end])),
        None => LimitingPart::Drag(bodies[group.fastest_drag()]),
    };
    let value = Scalar::INFINITY;
    LinearSystem::one(Modes::one(value, 0.0, None)).margin(part, group.movable(), [value; 2], pace, solvable)
}

/// Modes that are looked for besides the fastest, by methods that only damping keeps stable.
const MOST_UNDAMPED: usize = 4;

/// How many times too long a step of `h` seconds is for semi-implicit Euler: where `h² stiffness + 2 h rate` is 4 it is
/// just stable. Other methods differ by a factor of about 1, and find out.
fn times_over([stiffness, rate]: [Scalar; 2], h: Scalar) -> Scalar {
    // 1 / t of t² p + 2 t q = 4.
    let (p, q) = (h * h * stiffness, h * rate);
    (q + (q * q + 4.0 * p).sqrt()) / 4.0
}

/// Whether the iteration of implicit Euler comes to its end where `stiffest` is the largest of `h² w² + h c`: as many
/// iterations are left to conjugate gradients as they take at most of that condition (Luenberger 1973), or as many as
/// there are numbers, with some to make up for rounding. Beyond 1 / epsilon nothing is left of the inertia.
fn converges(solver: Solver, group: &LinearGroup<'_>, stiffest: Scalar) -> bool {
    let condition = 1.0 + stiffest;
    let by_condition = 0.5 * condition.sqrt() * libm::log(2.0 / solver.tolerance);
    #[expect(clippy::cast_precision_loss, reason = "a count of numbers")]
    let by_numbers = 3.0 * group.coordinates() as Scalar;
    condition * Scalar::EPSILON < 1.0 && by_condition.min(by_numbers) <= Scalar::from(solver.most_iterations)
}

/// `stiffness y·A y + rate y·C y`, the scene's damping in it.
fn quotient(group: &LinearGroup<'_>, factors: [Scalar; 2], y: &[Scalar]) -> Scalar {
    let mut product = vec![0.0; y.len()];
    group.apply(factors, true, y, &mut product);
    dot(y, &product).max(0.0)
}

/// What decides whether a group is stable.
struct LimitingMode {
    system: LinearSystem,
    /// The mode that limits it, of length 1.
    mode: Vec<Scalar>,
    /// What it has of stiffness, 1/s², and of damping, 1/s.
    quotients: [Scalar; 2],
    /// The square of how much faster the fastest mode may be, as far as is known; at least 1.
    excess: Scalar,
}

/// What decides whether a group is stable at steps of about `h` seconds, and the mode that limits it: the fastest. By a
/// method that only damping keeps stable, at steps of `restless` seconds, it is the one with too little of it.
/// `stiffest`, 1/s², and `rate`, 1/s, are bounds of the stiffness and of the damping.
///
/// Modes are Ritz vectors, which are no faster than the fastest: none makes a group look less stable than it is.
fn modes_of(
    group: &LinearGroup<'_>,
    damping: Option<Damping>,
    h: Scalar,
    [stiffest, rate]: [Scalar; 2],
    restless: Option<Scalar>,
) -> Option<LimitingMode> {
    let n = group.coordinates();
    let alike = group.uniform_rate().zip(group.uniform_damping());
    let scenes = |rate: Option<Scalar>| damping.zip(rate).map(|(damping, rate)| Damping { rate, ..damping });
    // Numbers of about 1, whatever the stiffness is.
    let factors = match alike {
        Some(_) if stiffest > 0.0 => [(1.0 / stiffest).min(Scalar::MAX), 0.0],
        Some(_) => [0.0; 2],
        None => [h * h, 2.0 * h],
    };
    let count = if alike.is_some() { 1 } else { MOST };
    let bound = (factors[0] * stiffest + factors[1] * rate).min(group.bound(factors));
    let Largest { pairs, at_most } =
        largest(n, count, bound, |y, out| group.apply(factors, alike.is_none(), y, out));
    // None where numbers have grown out of their range.
    let (value, fastest) = pairs.first()?.clone();
    let excess = if value > 0.0 { (at_most / value).max(1.0) } else { 1.0 };
    if let Some((all, own)) = alike {
        // As a product with the vector would say once more.
        let stiffness = if value > 0.0 { value / factors[0] } else { 0.0 };
        let parts = [stiffness, 0.0].map(|stiffness| Modes::one(stiffness, all, scenes(own)));
        let system = LinearSystem::apart(parts.to_vec());
        let quotients = [stiffness, quotient(group, [0.0, 1.0], &fastest)];
        return Some(LimitingMode { system, mode: fastest, quotients, excess });
    }
    let undamped: Vec<_> = restless.map_or_else(Vec::new, |h| {
        // A mode of explicit Euler grows where h² w² - h c is above 0; the shift lets no eigenvalue be below.
        let shift = h * rate;
        let less = |y: &[Scalar], out: &mut [Scalar]| {
            group.apply([h * h, -h], true, y, out);
            out.iter_mut().zip(y).for_each(|(out, y)| *out += shift * y);
        };
        largest(n, MOST_UNDAMPED, h * h * stiffest + shift, less).pairs.into_iter().map(|(_, y)| y).collect()
    });
    let limiting = undamped.first().unwrap_or(&fastest).clone();
    let basis: Vec<Vec<Scalar>> = if n <= MOST {
        (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect()
    } else {
        let fast = pairs.into_iter().map(|(_, y)| y);
        orthonormal(undamped.into_iter().chain(fast), MOST)
    };
    let modes = reduced(group, damping, &basis);
    let [stiffness, all] = [[1.0, 0.0], [0.0, 1.0]].map(|factors| quotient(group, factors, &limiting));
    // What of it is the scene's damping has its own formula; the guess need not be exact.
    let mut own = vec![0.0; n];
    group.damp(1.0, &limiting, &mut own);
    let own = dot(&own, &limiting);
    let rate = group.rates().iter().zip(limiting.chunks_exact(3)).map(|(rate, y)| rate * dot(y, y));
    let rate = group.rates().first().map(|_| rate.sum::<Scalar>());
    let guess = Modes::one(stiffness, (all - own).max(0.0), scenes(rate));
    let system = LinearSystem::joined(modes, guess);
    Some(LimitingMode { system, mode: limiting, quotients: [stiffness, all], excess })
}

/// At most `most` of `vectors`, made orthogonal and of length 1, without those that the ones before them span.
fn orthonormal(vectors: impl Iterator<Item = Vec<Scalar>>, most: usize) -> Vec<Vec<Scalar>> {
    let mut basis: Vec<Vec<Scalar>> = Vec::new();
    for mut vector in vectors {
        if basis.len() == most {
            break;
        }
        orthogonalize(&mut vector, &basis);
        let length = dot(&vector, &vector).sqrt();
        if length > 1e-3 {
            vector.iter_mut().for_each(|part| *part /= length);
            basis.push(vector);
        }
    }
    basis
}

/// The group in an orthonormal basis.
fn reduced(group: &LinearGroup<'_>, damping: Option<Damping>, basis: &[Vec<Scalar>]) -> Modes {
    let project = |apply: &dyn Fn(&[Scalar], &mut [Scalar])| {
        let mut matrix = Matrix::zero(basis.len());
        let mut product = vec![0.0; group.coordinates()];
        for (j, y) in basis.iter().enumerate() {
            apply(y, &mut product);
            basis.iter().enumerate().for_each(|(i, other)| matrix.set(i, j, dot(other, &product)));
        }
        matrix
    };
    let classes = Classes::of(group.rates());
    let part = |class: usize| {
        project(&|y, out| {
            for ((own, y), out) in group.rates().iter().zip(y.chunks_exact(3)).zip(out.chunks_exact_mut(3)) {
                let share = if classes.of_rate(*own) == class { 1.0 } else { 0.0 };
                (0..3).for_each(|axis| out[axis] = share * y[axis]);
            }
        })
    };
    let rates = || classes.most.iter().copied().enumerate();
    let decays =
        damping.into_iter().flat_map(|damping| rates().map(move |(class, rate)| (damping, class, rate)));
    Modes {
        stiffness: project(&|y, out| group.apply([1.0, 0.0], false, y, out)),
        damping: project(&|y, out| group.apply([0.0, 1.0], false, y, out)),
        decays: decays.map(|(damping, class, rate)| (Damping { rate, ..damping }, part(class))).collect(),
    }
}

/// Rates of damping that are reckoned with as one, the largest of them.
struct Classes {
    /// Ascending.
    most: Vec<Scalar>,
}

impl Classes {
    /// Rates of which there are no more are each a class.
    const MOST: usize = 16;

    fn of(rates: &[Scalar]) -> Self {
        let mut rates = rates.to_vec();
        rates.sort_by(Scalar::total_cmp);
        rates.dedup();
        let size = rates.len().div_ceil(Self::MOST).max(1);
        Self { most: rates.chunks(size).filter_map(|class| class.last().copied()).collect() }
    }

    fn of_rate(&self, rate: Scalar) -> usize {
        self.most.partition_point(|most| most.total_cmp(&rate).is_lt())
    }
}
