//! Ghosts: twins of the world by every method, which take in what it takes in, and a fine reference.

use std::collections::BTreeSet;
use std::ops::Range;

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use history::{Distances, Failure, Simulation, Twin};
use motion::{Method, PreviousPosition, SoftBody, TimeStep, Transform};
use report::{Ink, ink};
use scene::{FileIndex, unsolvable};

use super::edges;
use crate::app::session::{Session, drawn};
use crate::app::ui::{Panel, Topic};

/// Bodies of a scene up to which it has ghosts: each of them is there ten times more.
const MOST_BODIES: usize = 10_000;

/// What is said of a method while ghosts are shown.
#[derive(Clone, Debug, PartialEq)]
pub struct GhostRow {
    /// The method; `None` is the reference.
    pub method: Option<Method>,
    /// What became of it.
    pub state: GhostState,
    /// Whether it is drawn, if it can be.
    pub shown: bool,
    /// How far the selected body is from where the reference has it, m; of a soft body, its farthest point. Where
    /// nothing that moves is selected, the farthest of all bodies.
    pub distance: Option<f64>,
    /// Root of the mean square of the distances of all bodies, m.
    pub rms: Option<f64>,
}

/// What became of a ghost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GhostState {
    /// It is the method of the solid bodies; distances are theirs.
    Solid,
    /// It runs along.
    Runs,
    /// A body of it was quarantined: which, when and why.
    Failed(String),
    /// It cannot solve a law of the scene, and why.
    Unsolvable(&'static str),
}

/// The twins of a session.
pub(crate) struct Ghosts {
    reference: Twin,
    /// In the order of [`motion::METHODS`], that of the solid bodies too: it may be another one soon.
    twins: Vec<Twin>,
    hidden: BTreeSet<Option<Method>>,
    /// Stable ids of what thin lines join: the ends of springs, the points of ropes, the neighbors on surfaces.
    edges: Vec<[u32; 2]>,
}

/// One of the runs that are compared: solid or a ghost, not the reference.
pub(crate) struct Track<'a> {
    pub method: Method,
    pub solid: bool,
    pub simulation: &'a Simulation,
    /// From the reference.
    pub distances: Distances,
}

/// A distance that is written into the picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GhostLabel {
    /// The middle between a body and where the reference has it, pixels from the top left.
    pub at: DVec2,
    pub ink: Ink,
    /// m.
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

impl Ghosts {
    fn new(leader: &mut Simulation, hidden: BTreeSet<Option<Method>>) -> Self {
        let declared = leader.scene.mutual_gravity.is_some();
        let solving = Method::ALL.into_iter().filter(|method| unsolvable(*method, declared).is_none());
        let twins = solving.map(|method| Twin::new(leader, method, None)).collect();
        Self { reference: Twin::reference(leader), twins, hidden, edges: edges::of(&leader.scene) }
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Twin> {
        self.twins.iter_mut().chain([&mut self.reference])
    }

    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    pub fn shows(&self, method: Option<Method>) -> bool {
        !self.hidden.contains(&method)
    }

    /// The reference, unless it failed.
    pub fn reference(&self) -> Option<&Simulation> {
        self.reference.failure().is_none().then(|| self.reference.simulation())
    }
}

/// Where a body of one of the runs is drawn, m.
pub(crate) fn place(body: EntityRef<'_>, alpha: f64) -> Option<DVec3> {
    Some(drawn(body.get::<Transform>()?, body.get::<PreviousPosition>(), alpha))
}

impl Session {
    /// What there is to say of every method and, last, of the reference; nothing while no ghosts are shown.
    #[must_use]
    pub fn ghosts(&self) -> Vec<GhostRow> {
        let Some(ghosts) = &self.ghosts else { return Vec::new() };
        let (tracks, focus) = (self.ghost_tracks(), self.ghost_focus());
        let declared = self.sim.scene.mutual_gravity.is_some();
        let of_method = |method| {
            let track = tracks.iter().find(|track| track.method == method);
            let twin = ghosts.twins.iter().find(|twin| twin.method() == method);
            let state = match (twin.and_then(Twin::failure), unsolvable(method, declared)) {
                _ if method == self.sim.method() => GhostState::Solid,
                (_, Some(why)) => GhostState::Unsolvable(why),
                (Some(failure), _) => GhostState::Failed(self.words_of(failure)),
                (None, None) => GhostState::Runs,
            };
            GhostRow {
                method: Some(method),
                state,
                shown: ghosts.shows(Some(method)),
                distance: track
                    .and_then(|track| track.distances.farthest(|id| focus.contains(&id)))
                    .map(|(_, d)| d),
                rms: track.and_then(|track| track.distances.rms()),
            }
        };
        let failed = ghosts.reference.failure().map(|failure| GhostState::Failed(self.words_of(failure)));
        let reference = GhostRow {
            method: None,
            state: failed.unwrap_or(GhostState::Runs),
            shown: ghosts.shows(None),
            distance: None,
            rms: None,
        };
        Method::ALL.into_iter().map(of_method).chain([reference]).collect()
    }

    fn words_of(&self, failure: Failure) -> String {
        let Failure { body, tick, cause } = failure;
        let body = self.sim.scene.names.get(body).unwrap_or_default();
        format!("{body} was quarantined in tick {tick}: {}", cause.what())
    }

    /// Ghosts where there are none, and the other way round.
    pub(crate) fn toggle_ghosts(&mut self) {
        self.ui.retract(Topic::Ghosts);
        if self.ghosts.take().is_some() {
            self.ui.close(Panel::Ghosts);
        } else if self.sim.bodies.len() > MOST_BODIES {
            self.notice(format!("more than {MOST_BODIES} bodies: too many for ghosts"));
        } else {
            self.carry_out_requests();
            self.begin_ghosts(BTreeSet::new());
            self.ui.open(Panel::Ghosts);
        }
    }

    fn begin_ghosts(&mut self, hidden: BTreeSet<Option<Method>>) {
        self.ghosts = Some(Ghosts::new(&mut self.sim, hidden));
    }

    /// Lets ghosts begin anew with a world that was built anew.
    pub(crate) fn restart_ghosts(&mut self) {
        if let Some(ghosts) = self.ghosts.take() {
            self.begin_ghosts(ghosts.hidden);
        }
    }

    /// Lets the next method be the solid one.
    pub(crate) fn next_solid(&mut self) {
        if self.ghosts.is_some() {
            self.change_method(Method::next);
        } else {
            self.ui.notice(Topic::Ghosts, "there are no ghosts to choose from; T shows them".to_owned());
        }
    }

    /// Draws the ghost of that method, or of the reference, or leaves it out.
    pub(crate) fn show_ghost(&mut self, method: Option<Method>, shown: bool) {
        if let Some(ghosts) = &mut self.ghosts {
            if shown {
                ghosts.hidden.remove(&method);
            } else {
                ghosts.hidden.insert(method);
            }
        }
    }

    /// A tick of the ghosts, with what the coming one of the world takes in; `remember`: it is the last one of the
    /// frame.
    pub(crate) fn tick_ghosts(&mut self, remember: bool) {
        let Some(ghosts) = &mut self.ghosts else { return };
        let (step, inputs) = (*self.sim.world.resource::<TimeStep>(), self.sim.pending());
        for twin in ghosts.all() {
            if remember {
                twin.remember_positions();
            }
            twin.tick(step, &inputs);
        }
    }

    /// What is asked for, for the ghosts too.
    pub(crate) fn carry_out_in_ghosts(&mut self) {
        let Some(ghosts) = &mut self.ghosts else { return };
        let requests: Vec<_> = self.sim.requested().collect();
        ghosts.all().for_each(|twin| twin.carry_out(&requests));
    }

    /// Every run whose distances are known: the solid one and its ghosts, unless they or the reference failed.
    pub(crate) fn ghost_tracks(&self) -> Vec<Track<'_>> {
        let Some(ghosts) = &self.ghosts else { return Vec::new() };
        let Some(reference) = ghosts.reference() else { return Vec::new() };
        let solid = self.sim.method();
        let running = ghosts.twins.iter().filter(|twin| twin.failure().is_none() && twin.method() != solid);
        let mut tracks: Vec<_> = running
            .map(|twin| Track::new(twin.simulation(), false, reference))
            .chain([Track::new(&self.sim, true, reference)])
            .collect();
        tracks.sort_by_key(|track| track.method);
        tracks
    }

    /// Stable ids whose distances are told: those of the selection, or all where nothing that moves is selected.
    pub(crate) fn ghost_focus(&self) -> Range<u32> {
        let moves = |ids: &Range<u32>| ids.clone().any(|id| self.sim.moving(id).is_some());
        self.ids_selected().filter(moves).unwrap_or(0..u32::MAX)
    }

    fn ids_selected(&self) -> Option<Range<u32>> {
        let selection = self.control.selection?;
        if self.sim.world.get::<SoftBody>(selection).is_some() {
            let FileIndex(index) = self.sim.world.get(selection)?;
            return self.sim.scene.soft_bodies.get(*index as usize).map(|soft| soft.points.clone());
        }
        self.ids.get(&selection).map(|id| *id..*id + 1)
    }

    /// Whose distances are told, in words.
    pub(crate) fn ghost_subject(&self) -> String {
        let told = self.ghost_focus() == (0..u32::MAX);
        let selection = self.control.selection.filter(|_| !told);
        selection.map_or_else(|| "the farthest body".to_owned(), |thing| self.name(thing))
    }

    /// The distances that are written into the picture: of each run, that of the selection or the farthest.
    pub(crate) fn ghost_labels(&self) -> Vec<GhostLabel> {
        let Some(ghosts) = &self.ghosts else { return Vec::new() };
        let Some(reference) = ghosts.reference() else { return Vec::new() };
        let (view, focus) = (self.camera.viewpoint(), self.ghost_focus());
        let size = DVec2::from_array(self.options.size_px.map(f64::from));
        let label = |track: &Track<'_>| {
            let (id, distance) =
                track.distances.farthest(|id| focus.contains(&id)).filter(|(_, d)| *d > 0.0)?;
            let place = |simulation: &Simulation| place(simulation.moving(id)?, self.alpha);
            let middle = (place(track.simulation)? + place(reference)?) / 2.0;
            let depth = (middle - view.position).dot(view.forward());
            let at = view.project(middle, size).filter(|_| (view.near_m..=view.far_m).contains(&depth))?;
            let inside = at.cmpge(DVec2::ZERO).all() && at.cmple(size).all();
            inside.then(|| GhostLabel { at, ink: track.ink(), distance })
        };
        let tracks = self.ghost_tracks();
        tracks.iter().filter(|track| ghosts.shows(Some(track.method))).filter_map(label).collect()
    }
}
