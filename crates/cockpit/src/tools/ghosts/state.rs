//! Ghosts: twins of the world, one per method, which get the same changes as the world, and a fine reference.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use history::{Distances, DistancesSoFar, FirstQuarantine, Simulation, Twin};
use motion::{Method, PreviousPosition, SoftBody, Transform};
use report::{Ink, ink};
use scene::{FileIndex, Substepping, unsolvable};

use crate::stage::Stage;
use crate::stage::things::drawn;
use crate::tools::ghosts::edges;
use crate::view::View;

/// Maximum number of bodies of a scene with ghosts, which simulate each body ten more times.
pub(super) const MOST_BODIES: usize = 10_000;

/// A row of the ghosts panel: one method, the solid bodies where several methods moved them, or the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct GhostRow {
    /// The method, if the row is about a run with this method alone; `None` for the solid bodies and the reference.
    pub method: Option<Method>,
    /// State of the ghost.
    pub state: GhostState,
    /// Whether the ghost is drawn, if it can be.
    pub shown: bool,
    /// Distance of the selected body from the same body of the reference, m; for a soft body, of its farthest point. If no
    /// moving thing is selected, the distance of the farthest of all bodies.
    pub distance: Option<f64>,
    /// Maximum of `distance` over all ticks since the ghosts started, m.
    pub largest: Option<f64>,
    /// Root mean square of the distances of all bodies over all ticks since the ghosts started, m.
    pub rms: Option<f64>,
}

/// State of a ghost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GhostState {
    /// The method of the solid bodies.
    Solid,
    /// The solid bodies, which several methods moved since the ghosts started.
    Mixed,
    /// The ghost runs.
    Runs,
    /// A body of the ghost was quarantined; the text says which, when and why.
    Failed(String),
    /// The method cannot solve a law of the scene; the text says why.
    Unsolvable(&'static str),
}

/// The ghosts of a session, while they are shown.
#[derive(Default)]
pub(crate) struct Ghosts {
    pub(super) twins: Option<Twins>,
    /// Number of times that ghosts were made. Ghosts of another generation are other runs.
    generation: u64,
    /// Substeps of the scene when the ghosts were made.
    substeps: Substepping,
}

/// A ghost, for graphs.
pub(crate) struct GhostRun<'a> {
    /// The method; `None` is the reference.
    pub method: Option<Method>,
    /// Whether the ghost is drawn.
    pub shown: bool,
    pub simulation: &'a Simulation,
}

/// The twins of a world.
pub(super) struct Twins {
    reference: Twin,
    /// In the order of [`motion::METHODS`], including the method of the solid bodies, which may change.
    twins: Vec<Twin>,
    pub hidden: BTreeSet<Option<Method>>,
    /// Stable ids of the ends of thin lines: the ends of springs, the points of ropes, the neighbors on surfaces.
    pub edges: Vec<[u32; 2]>,
    /// Distances after all ticks so far, per method for its twin, and under `None` for the solid bodies.
    so_far: BTreeMap<Option<Method>, DistancesSoFar>,
    /// The tick whose distances were added last.
    added: Option<u64>,
}

/// A run that is compared with the reference: the solid bodies or a ghost.
pub(super) struct Track<'a> {
    pub method: Method,
    pub solid: bool,
    pub simulation: &'a Simulation,
    /// Distances from the reference.
    pub distances: Distances,
}

/// A distance label in the picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GhostLabel {
    /// The middle between a body and the same body of the reference, pixels from the top left.
    pub at: DVec2,
    pub ink: Ink,
    /// Distance, m.
    pub distance: f64,
}

impl<'a> Track<'a> {
    fn new(simulation: &'a Simulation, solid: bool, reference: &Simulation) -> Self {
        let distances = Distances::between(simulation, reference);
        Self { method: simulation.method(), solid, simulation, distances }
    }

    pub fn ink(&self) -> Ink {
        ink(self.method)
    }
}

impl Twins {
    pub fn new(leader: &Simulation, hidden: BTreeSet<Option<Method>>) -> Self {
        let declared = leader.scene.mutual_gravity.is_some();
        let solving =
            Method::ALL.into_iter().filter(|method| unsolvable(*method, declared).is_none());
        let twins = solving.map(|method| Twin::new(leader, method, None)).collect();
        Self {
            reference: Twin::reference(leader),
            twins,
            hidden,
            edges: edges::of(&leader.scene),
            so_far: BTreeMap::new(),
            added: None,
        }
    }

    /// Adds the distances after the last tick, unless they were added before.
    pub fn add_distances(&mut self, stage: &Stage) {
        let now = Some(stage.sim().ticks());
        if self.added == now {
            return;
        }
        self.added = now;
        let Some(reference) = self.reference() else { return };
        let twins = self.running().map(|twin| (Some(twin.method()), twin.simulation()));
        let runs = twins.chain([(None, stage.sim())]);
        let distances: Vec<_> = runs
            .map(|(run, simulation)| (run, Distances::between(simulation, reference)))
            .collect();
        for (run, distances) in distances {
            self.so_far.entry(run).or_default().add(&distances);
        }
    }

    /// The twins that did not fail.
    fn running(&self) -> impl Iterator<Item = &Twin> {
        self.twins.iter().filter(|twin| twin.failure().is_none())
    }

    /// Distances after all ticks so far, of the twin of `method`, or of the solid bodies for `None`.
    fn so_far(&self, method: Option<Method>) -> Option<&DistancesSoFar> {
        self.so_far.get(&method).filter(|_| self.reference().is_some())
    }

    pub fn all(&mut self) -> impl Iterator<Item = &mut Twin> {
        self.twins.iter_mut().chain([&mut self.reference])
    }

    pub fn shows(&self, method: Option<Method>) -> bool {
        !self.hidden.contains(&method)
    }

    /// Shows or hides the ghost of `method`, or the reference for `None`.
    pub fn show(&mut self, method: Option<Method>, shown: bool) {
        if shown {
            self.hidden.remove(&method);
        } else {
            self.hidden.insert(method);
        }
    }

    /// The reference, unless it failed.
    pub fn reference(&self) -> Option<&Simulation> {
        self.reference.failure().is_none().then(|| self.reference.simulation())
    }

    /// All runs with known distances: the solid run and the ghosts that did not fail; none if the reference failed.
    pub fn tracks<'a>(&'a self, stage: &'a Stage) -> Vec<Track<'a>> {
        let Some(reference) = self.reference() else { return Vec::new() };
        let solid = stage.sim().method();
        let running = self.running().filter(|twin| twin.method() != solid);
        let mut tracks: Vec<_> = running
            .map(|twin| Track::new(twin.simulation(), false, reference))
            .chain([Track::new(stage.sim(), true, reference)])
            .collect();
        tracks.sort_by_key(|track| track.method);
        tracks
    }
}

/// Drawn position of a body of a run, m.
pub(super) fn place(body: EntityRef<'_>, alpha: f64) -> Option<DVec3> {
    Some(drawn(body.get::<Transform>()?, body.get::<PreviousPosition>(), alpha))
}

impl Ghosts {
    /// The rows of all methods, of the solid bodies if their distances differ from those of their method alone, and, last, of
    /// the reference. Empty while no ghosts are shown.
    pub fn rows(&self, stage: &Stage) -> Vec<GhostRow> {
        let Some(twins) = &self.twins else { return Vec::new() };
        let (focus, solid) = (focus(stage), stage.sim().method());
        let declared = stage.sim().scene.mutual_gravity.is_some();
        let counts = |id| focus.contains(&id);
        let row = |method, state, run: Option<&Simulation>| {
            let distances =
                run.zip(twins.reference()).map(|(run, other)| Distances::between(run, other));
            let so_far = twins.so_far(method).filter(|_| run.is_some());
            GhostRow {
                method,
                state,
                shown: twins.shows(method.or(Some(solid))),
                distance: distances
                    .and_then(|distances| distances.farthest(counts))
                    .map(|(_, d)| d),
                largest: so_far.and_then(|so_far| so_far.largest(counts)),
                rms: so_far.and_then(DistancesSoFar::rms),
            }
        };
        let of_method = |method| {
            let twin = twins.twins.iter().find(|twin| twin.method() == method);
            let failure = twin.and_then(Twin::failure);
            let state = match (failure, unsolvable(method, declared)) {
                (_, Some(why)) => GhostState::Unsolvable(why),
                (Some(failure), _) => GhostState::Failed(words_of(stage, failure)),
                (None, None) if method == solid => GhostState::Solid,
                (None, None) => GhostState::Runs,
            };
            row(Some(method), state, twin.filter(|_| failure.is_none()).map(Twin::simulation))
        };
        // A ghost that failed has no distances from then on.
        let own = twins.twins.iter().find(|twin| twin.method() == solid);
        let is_mixed = own.is_none_or(|own| own.failure().is_none())
            && twins.so_far(None) != twins.so_far(Some(solid));
        let mixed = is_mixed.then(|| row(None, GhostState::Mixed, Some(stage.sim())));
        let failed =
            twins.reference.failure().map(|failure| GhostState::Failed(words_of(stage, failure)));
        let reference = GhostRow {
            shown: twins.shows(None),
            ..row(None, failed.unwrap_or(GhostState::Runs), None)
        };
        Method::ALL.into_iter().map(of_method).chain(mixed).chain([reference]).collect()
    }

    /// Maximum distance of any body from the reference with `method` alone, m, over all ticks since the ghosts started.
    pub fn largest(&self, method: Method) -> Option<f64> {
        self.twins.as_ref()?.so_far(Some(method))?.largest(|_| true)
    }

    /// Makes ghosts of the present state.
    pub(super) fn begin(&mut self, leader: &Simulation, hidden: BTreeSet<Option<Method>>) {
        self.substeps = leader.scene.substeps;
        self.twins = Some(Twins::new(leader, hidden));
        self.generation += 1;
    }

    /// Remakes the ghosts if the substeps of the scene changed: a twin keeps the substeps that it started with.
    pub(super) fn keep_substeps(&mut self, stage: &Stage) {
        if self.substeps != stage.sim().scene.substeps
            && let Some(Twins { hidden, .. }) = self.twins.take()
        {
            self.begin(stage.sim(), hidden);
        }
    }

    /// The generation of the ghosts, if there are any.
    pub fn generation(&self) -> Option<u64> {
        self.twins.as_ref().map(|_| self.generation)
    }

    /// All ghosts that did not fail, including the reference. The ghost of `solid`, the method of the solid bodies, is not drawn.
    pub fn runs(&self, solid: Method) -> impl Iterator<Item = GhostRun<'_>> {
        self.twins.iter().flat_map(move |Twins { reference, twins, hidden, .. }| {
            let twins = twins.iter().map(|twin| (Some(twin.method()), twin));
            twins.chain([(None, reference)]).filter(|(_, twin)| twin.failure().is_none()).map(
                move |(method, twin)| GhostRun {
                    method,
                    shown: method != Some(solid) && !hidden.contains(&method),
                    simulation: twin.simulation(),
                },
            )
        })
    }

    /// Whether there are ghosts.
    pub const fn are_shown(&self) -> bool {
        self.twins.is_some()
    }

    /// The distance labels in the picture: per run, the distance of the selection or of the farthest body.
    pub(super) fn labels(&self, stage: &Stage, view: &View) -> Vec<GhostLabel> {
        let Some(twins) = &self.twins else { return Vec::new() };
        let Some(reference) = twins.reference() else { return Vec::new() };
        let (eye, focus) = (view.viewpoint(), focus(stage));
        let label = |track: &Track<'_>| {
            let (id, distance) =
                track.distances.farthest(|id| focus.contains(&id)).filter(|(_, d)| *d > 0.0)?;
            let place = |simulation: &Simulation| place(simulation.moving(id)?, stage.here().alpha);
            let middle = (place(track.simulation)? + place(reference)?) / 2.0;
            let depth = (middle - eye.position).dot(eye.forward());
            let (at, inside) =
                view.seen_at(middle).filter(|_| (eye.near_m..=eye.far_m).contains(&depth))?;
            inside.then(|| GhostLabel { at, ink: track.ink(), distance })
        };
        let tracks = twins.tracks(stage);
        tracks.iter().filter(|track| twins.shows(Some(track.method))).filter_map(label).collect()
    }
}

fn words_of(stage: &Stage, failure: FirstQuarantine) -> String {
    let (body, time) = (failure.name(&stage.sim().scene), stage.times().words(failure.tick));
    format!("{body} was quarantined at {time}: {}", failure.cause.what())
}

/// Stable ids of the bodies whose distances are shown: the selection, or all bodies if no moving thing is selected.
pub(super) fn focus(stage: &Stage) -> Range<u32> {
    let moves = |ids: &Range<u32>| ids.clone().any(|id| stage.sim().moving(id).is_some());
    ids_selected(stage).filter(moves).unwrap_or(0..u32::MAX)
}

fn ids_selected(stage: &Stage) -> Option<Range<u32>> {
    let selection = stage.selection()?;
    if stage.sim().world.get::<SoftBody>(selection).is_some() {
        let FileIndex(index) = stage.sim().world.get(selection)?;
        return stage.sim().scene.soft_bodies.get(*index as usize).map(|soft| soft.points.clone());
    }
    stage.sim().id(selection).map(|id| id..id + 1)
}

/// The name of the body whose distances are shown.
pub(super) fn subject(stage: &Stage) -> String {
    let all = focus(stage) == (0..u32::MAX);
    let selection = stage.selection().filter(|_| !all);
    selection.map_or_else(|| "the farthest body".to_owned(), |thing| stage.name(thing))
}
