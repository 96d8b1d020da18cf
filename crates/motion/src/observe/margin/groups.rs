//! The forecast of groups: the fastest modes of springs and dampers.

use bevy_ecs::prelude::*;
use glam::DVec3;

use super::cure::LinearSystem;
use super::lanczos::{Largest, Pair, dot, largest, orthogonalize};
use super::matrix::Matrix;
use super::modes::{MOST_COORDINATES, Oscillators, Stepping};
use super::{LimitingPart, Margin, SpringMargin, single_bodies};
use crate::groups::{Contributor, Coupling, LinearGroup, Solver, Terms, states_of};
use crate::laws::damping::Damping;
use crate::laws::own::OwnLaws;
use crate::laws::{BodyState, EvaluationTime, Law, MutualGravity, SharedLaws, Well, Wells};
use crate::state::components::Transform;
use crate::units::Scalar;

/// The margin of a group, if anything acts in it. Adds the margins of its springs to `spring_margins`, if given.
pub(super) fn margin(
    world: &World,
    coupling: &Coupling,
    bodies: &[Entity],
    stepping: Stepping,
    spring_margins: Option<&mut Vec<SpringMargin>>,
) -> Option<Margin> {
    let damps_inside = stepping.method.traits().damps_inside;
    // Damping around a tick acts over the whole tick, damping inside the steps over a substep.
    let longer_by = if damps_inside { 1.0 } else { f64::from(stepping.substeps) };
    let group = LinearGroup::of(world, coupling, bodies).with_longer_decays(longer_by);
    let h = stepping.substep();
    let mut bounds = group.bounds().fold(Terms::default(), Terms::larger);
    bounds.stiffness += group.largest_pull();
    bounds.damping += group.largest_rate();
    let step_ratio = ratio_to_stable_step(bounds, h);
    if step_ratio == 0.0 {
        return None;
    }
    let is_linear = is_linear(world, coupling, bodies)
        // Such a method is stable only where damping acts, which changes as the bodies move.
        && (stepping.method.claims().stability_limit != 0.0 || bounds.damping == 0.0);
    let margin = if step_ratio.is_finite() {
        group_margin(world, &group, bounds, h / step_ratio, stepping, is_linear, bodies)?
    } else {
        let spring_ratios = group.bounds().map(|bound| ratio_to_stable_step(bound, h));
        infinite_margin(&group, spring_ratios, bodies, stepping, is_linear)
    };
    if let Some(springs) = spring_margins {
        let spring_ratios: Vec<_> =
            group.bounds().map(|bound| ratio_to_stable_step(bound, h)).collect();
        let most = spring_ratios.iter().copied().fold(0.0, f64::max);
        let ratio = |spring_ratio: Scalar| match spring_ratio {
            _ if !step_ratio.is_finite() => spring_ratio,
            0.0 => 0.0,
            spring_ratio => margin.ratio() * spring_ratio / most,
        };
        let each = group.ends().zip(spring_ratios);
        springs.extend(each.map(|(ends, spring_ratio)| SpringMargin {
            ends: ends.map(|end| bodies[end]),
            ratio: ratio(spring_ratio),
        }));
    }
    Some(margin)
}

/// Whether the laws of a group are linear, apart from the directions of its springs.
fn is_linear(world: &World, coupling: &Coupling, bodies: &[Entity]) -> bool {
    let at = EvaluationTime { time: 0.0, within_step: 0.0 };
    let state = BodyState { position: DVec3::X, velocity: DVec3::X, inverse_mass: 1.0 };
    let is_straight = |law: &dyn Law| single_bodies::is_linear(law, at, state);
    let own = |body: &Entity| world.get::<OwnLaws>(*body).map_or(&[][..], OwnLaws::laws);
    let is_bent = |body: &Entity| own(body).iter().any(|law| !is_straight(&**law));
    !coupling.attracts
        && coupling.springs.cords().is_empty()
        && SharedLaws::of(world).all().all(is_straight)
        && !bodies.iter().any(is_bent)
}

/// The margin of a group with these bounds. At steps of `short` seconds it is at or near the limit of stability.
fn group_margin(
    world: &World,
    group: &LinearGroup<'_>,
    bounds: Terms,
    short: Scalar,
    stepping: Stepping,
    is_linear: bool,
    bodies: &[Entity],
) -> Option<Margin> {
    let damping = world.get_resource::<Damping>().copied();
    let solver = world.get_resource::<Solver>().copied().unwrap_or_default();
    let h = stepping.substep();
    let with_threshold = |threshold| {
        let LimitingMode { system, mode: y, largest, quotients, excess } =
            limiting_mode(group, damping, short, bounds, threshold)?;
        let Terms { stiffness, damping: rate } = quotients;
        let factors = Terms { stiffness: short * short, damping: 2.0 * short };
        let contributor = group.largest_contributor(factors, &y)?;
        let (part, value, power) = part_of(world, bodies, contributor, h, quotients);
        let converges = converges(solver, group, h * h * stiffness + h * rate);
        let stepping =
            Stepping { may_be_implicit: stepping.may_be_implicit && converges, ..stepping };
        let at_most = value * libm::pow(excess, 1.0 / power);
        let margin = system.margin(part, group.movable(), value, at_most, stepping, is_linear);
        Some((margin, largest * libm::pow(margin.limit / value, power)))
    };
    let (margin, threshold) = with_threshold(None)?;
    if margin.may_be_unstable() {
        return Some(with_threshold(Some(threshold))?.0);
    }
    Some(margin)
}

/// The limiting part of a group at substeps of `h` seconds, its value, and the power of the value that the eigenvalue is
/// proportional to.
fn part_of(
    world: &World,
    bodies: &[Entity],
    contributor: Contributor,
    h: Scalar,
    Terms { stiffness, damping: rate }: Terms,
) -> (LimitingPart, Scalar, Scalar) {
    let name = |row: usize| bodies[row];
    match contributor {
        Contributor::Spring(ends) => {
            (LimitingPart::Spring(ends.map(name)), h * stiffness.sqrt(), 2.0)
        }
        Contributor::Damper(ends) => (LimitingPart::Damper(ends.map(name)), h * rate, 1.0),
        Contributor::Drag(row) => (LimitingPart::Drag(name(row)), h * rate, 1.0),
        Contributor::Well(row) => (strongest_well(world, name(row)), h * stiffness.sqrt(), 2.0),
        Contributor::Damping(row) => (LimitingPart::Damping(name(row)), h * rate, 1.0),
    }
}

/// The well that restores a body most.
fn strongest_well(world: &World, body: Entity) -> LimitingPart {
    let position = world.get::<Transform>(body).copied().unwrap_or_default().position;
    let wells = world.get_resource::<Wells>().into_iter().flat_map(|Wells(wells)| wells);
    let restoring = wells.map(|well| well.largest_restoring(position)).enumerate();
    let strongest =
        restoring.max_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(number, _)| number);
    LimitingPart::Well(strongest, body)
}

/// The margin of the mutual gravity of a group: that of the pair whose circular orbit at its present distance is the
/// fastest. `None` if no body attracts another.
pub(super) fn attraction_margin(
    world: &World,
    coupling: &Coupling,
    bodies: &[Entity],
    stepping: Stepping,
) -> Option<Margin> {
    let law = world.get_resource::<MutualGravity>().filter(|_| coupling.attracts)?;
    let states = states_of(world, bodies);
    let inverse_masses: Vec<_> = states.iter().map(|state| state.inverse_mass).collect();
    let pairs = (0..coupling.movable).flat_map(|a| (a + 1..coupling.rows).map(move |b| [a, b]));
    let squared = |pair: [usize; 2]| {
        let strength = coupling.pair_strength(law, pair, &inverse_masses);
        let well = Well { position: DVec3::ZERO, strength, softening: law.softening };
        let apart = states[pair[1]].position - states[pair[0]].position;
        // No force acts at the same position.
        if apart == DVec3::ZERO { 0.0 } else { well.squared_frequency(apart) }
    };
    let (most, pair) = pairs
        .map(|pair| (squared(pair), pair))
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .filter(|(most, _)| *most > 0.0)?;
    let part = LimitingPart::MutualGravity(pair.map(|row| bodies[row]));
    let value = stepping.substep() * most.sqrt();
    let system = LinearSystem::one(Oscillators::one(most, 0.0, None));
    Some(system.margin(part, coupling.movable, value, value, stepping, false))
}

/// The margin of a group whose fastest mode may be infinitely fast; `spring_ratios` are the steps over the longest stable
/// one of each spring.
fn infinite_margin(
    group: &LinearGroup<'_>,
    spring_ratios: impl Iterator<Item = Scalar>,
    bodies: &[Entity],
    stepping: Stepping,
    is_linear: bool,
) -> Margin {
    let spring = group.ends().zip(spring_ratios).find(|(_, ratio)| !ratio.is_finite());
    let part = match spring {
        Some((ends, _)) => LimitingPart::Spring(ends.map(|end| bodies[end])),
        None => LimitingPart::Drag(bodies[group.fastest_drag()]),
    };
    let value = Scalar::INFINITY;
    LinearSystem::one(Oscillators::one(value, 0.0, None)).margin(
        part,
        group.movable(),
        value,
        value,
        stepping,
        is_linear,
    )
}

/// Step of `h` seconds over the longest stable step of semi-implicit Euler, which is at `h² stiffness + 2 h damping = 4`.
/// The limits of other methods differ by a factor of about 1 and are computed.
fn ratio_to_stable_step(bounds: Terms, h: Scalar) -> Scalar {
    // 1 / t, where t² p + 2 t q = 4.
    let (p, q) = (h * h * bounds.stiffness, h * bounds.damping);
    (q + (q * q + 4.0 * p).sqrt()) / 4.0
}

/// Whether implicit Euler's solver converges, where `largest_eigenvalue` is that of `h² A + h C`. Conjugate gradients
/// need at most as many iterations as the condition number demands (Luenberger 1973), or as there are numbers, times a
/// factor for rounding. Beyond a condition number of 1 / epsilon the inertia is below rounding.
fn converges(solver: Solver, group: &LinearGroup<'_>, largest_eigenvalue: Scalar) -> bool {
    let condition = 1.0 + largest_eigenvalue;
    let by_condition = 0.5 * condition.sqrt() * libm::log(2.0 / solver.tolerance);
    #[expect(clippy::cast_precision_loss, reason = "a count of numbers")]
    let by_numbers = 3.0 * group.coordinates() as Scalar;
    condition * Scalar::EPSILON < 1.0
        && by_condition.min(by_numbers) <= Scalar::from(solver.most_iterations)
}

/// `stiffness y·A y + damping y·C y`, with the scene's damping in C.
fn quotient(group: &LinearGroup<'_>, factors: Terms, y: &[Scalar]) -> Scalar {
    let mut product = vec![0.0; y.len()];
    group.apply(factors, y, &mut product);
    dot(y, &product).max(0.0)
}

/// The fastest mode of a group.
struct LimitingMode {
    system: LinearSystem,
    /// The mode, a vector of length 1.
    mode: Vec<Scalar>,
    /// The largest eigenvalue, scaled to about 1.
    largest: Scalar,
    /// Its Rayleigh quotients.
    quotients: Terms,
    /// Upper bound over lower bound of the largest eigenvalue; at least 1.
    excess: Scalar,
}

/// Finds the fastest mode of a group with these bounds at steps of about `h` seconds. With a `threshold`, the search continues
/// until it is known on which side of it the largest eigenvalue is.
///
/// Modes are Ritz vectors, which are never faster than the fastest mode: a stable group never appears unstable.
fn limiting_mode(
    group: &LinearGroup<'_>,
    damping: Option<Damping>,
    h: Scalar,
    bounds: Terms,
    threshold: Option<Scalar>,
) -> Option<LimitingMode> {
    let alike = group.uniform_rate().zip(group.uniform_damping());
    // Scales the numbers to about 1, whatever the stiffness.
    let factors = match alike {
        Some(_) if bounds.stiffness > 0.0 => {
            Terms { stiffness: (1.0 / bounds.stiffness).min(Scalar::MAX), damping: 0.0 }
        }
        Some(_) => Terms::default(),
        None => Terms { stiffness: h * h, damping: 2.0 * h },
    };
    let count = if alike.is_some() { 1 } else { MOST_COORDINATES };
    let bound = (factors.stiffness * bounds.stiffness + factors.damping * bounds.damping)
        .min(group.bound(factors));
    let apply = |y: &[Scalar], out: &mut [Scalar]| match alike {
        Some(_) => group.apply_laws(factors, y, out),
        None => group.apply(factors, y, out),
    };
    let Largest { pairs, at_most } = largest(group.coordinates(), count, bound, threshold, apply);
    // None if numbers have overflowed.
    let (value, mode) = pairs.first()?.clone();
    let excess = if value > 0.0 { (at_most / value).max(1.0) } else { 1.0 };
    let (system, quotients) = match alike {
        Some((laws_rate, scene_rate)) => {
            // By the eigenvalue itself: its Rayleigh quotient needs no further product with A.
            let stiffness = if value > 0.0 { value / factors.stiffness } else { 0.0 };
            let damping_of_scene = of_rate(damping, scene_rate);
            let quotients = Terms { stiffness, damping: quotient(group, Terms::DAMPING, &mode) };
            let parts = [stiffness, 0.0]
                .map(|stiffness| Oscillators::one(stiffness, laws_rate, damping_of_scene));
            (LinearSystem::apart(parts.to_vec()), quotients)
        }
        None => general_system(group, damping, pairs, &mode),
    };
    Some(LimitingMode { system, mode, largest: value, quotients, excess })
}

/// The scene's damping with another rate.
fn of_rate(damping: Option<Damping>, rate: Option<Scalar>) -> Option<Damping> {
    damping.zip(rate).map(|(damping, rate)| Damping { rate, ..damping })
}

/// The system of a group whose rows differ in their damping, in the basis of `pairs`, and the Rayleigh quotients of its
/// fastest mode.
fn general_system(
    group: &LinearGroup<'_>,
    damping: Option<Damping>,
    pairs: Vec<Pair>,
    fastest: &[Scalar],
) -> (LinearSystem, Terms) {
    let n = group.coordinates();
    let [stiffness, damping_quotient] =
        [Terms::STIFFNESS, Terms::DAMPING].map(|factors| quotient(group, factors, fastest));
    let mut by_scene = vec![0.0; n];
    group.damp(1.0, fastest, &mut by_scene);
    let by_laws = (damping_quotient - dot(&by_scene, fastest)).max(0.0);
    let rates = group.rates().iter().zip(fastest.chunks_exact(3));
    let rate = group.rates().first().map(|_| rates.map(|(rate, y)| rate * dot(y, y)).sum());
    // The mode alone, in which the scene's damping has its own formulas: the search for the limit begins near its limit.
    let guess = Oscillators::one(stiffness, by_laws, of_rate(damping, rate));
    let basis: Vec<Vec<Scalar>> = if n <= MOST_COORDINATES {
        (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect()
    } else {
        orthonormal(pairs.into_iter().map(|(_, y)| y))
    };
    let modes = reduced(group, damping, &basis);
    (LinearSystem::joined(modes, guess), Terms { stiffness, damping: damping_quotient })
}

/// An orthonormal basis of `vectors`; skips a vector that the earlier ones span.
fn orthonormal(vectors: impl Iterator<Item = Vec<Scalar>>) -> Vec<Vec<Scalar>> {
    let mut basis: Vec<Vec<Scalar>> = Vec::new();
    for mut vector in vectors {
        orthogonalize(&mut vector, &basis);
        let length = dot(&vector, &vector).sqrt();
        if length > 1e-3 {
            vector.iter_mut().for_each(|part| *part /= length);
            basis.push(vector);
        }
    }
    basis
}

/// The linear system of a group in an orthonormal basis.
fn reduced(
    group: &LinearGroup<'_>,
    damping: Option<Damping>,
    basis: &[Vec<Scalar>],
) -> Oscillators {
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
            for ((own, y), out) in
                group.rates().iter().zip(y.chunks_exact(3)).zip(out.chunks_exact_mut(3))
            {
                let share = if classes.of_rate(*own) == class { 1.0 } else { 0.0 };
                (0..3).for_each(|axis| out[axis] = share * y[axis]);
            }
        })
    };
    let rates = || classes.most.iter().copied().enumerate();
    let decays = damping
        .into_iter()
        .flat_map(|damping| rates().map(move |(class, rate)| (damping, class, rate)));
    Oscillators {
        stiffness: project(&|y, out| group.apply_laws(Terms::STIFFNESS, y, out)),
        damping: project(&|y, out| group.apply_laws(Terms::DAMPING, y, out)),
        decays: decays
            .map(|(damping, class, rate)| (Damping { rate, ..damping }, part(class)))
            .collect(),
    }
}

/// Classes of similar damping rates. Each counts as its largest rate.
struct Classes {
    /// Largest rate of each class, 1/s, ascending.
    most: Vec<Scalar>,
}

impl Classes {
    /// Largest number of classes. With no more rates than this, each is a class of its own.
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
