//! Ghosts in the picture: translucent bodies, thin springs, and a line from each body to the same body of the reference.

use bevy_ecs::prelude::*;
use glam::{DVec3, Quat, Vec3};
use history::Simulation;
use motion::Orientation;
use motion::snapshot::SpringsOff;
use pick::Shape;
use render::{Frame, Instance, Line, Particle};
use report::{Ink, REFERENCE_INK};
use scene::{PointRadius, Scene};

use crate::stage::Stage;
use crate::tools::ghosts::state::{Track, Twins, focus, place};
use crate::view::View;
use crate::view::picture::add_translucent;

/// Opacity of a ghost's bodies.
const OPACITY: f32 = 0.35;
const EDGE_OPACITY: f32 = 0.45;
const EDGE_WIDTH_PX: f32 = 1.0;
const LINE_OPACITY: f32 = 0.9;
const LINE_WIDTH_PX: f32 = 1.5;

/// Maximum number of lines to the reference, of all ghosts together: first the lines of the selection, then the longest.
const MOST_LINES: usize = 200;

/// Maximum drawn coordinate relative to the camera, m: bodies that fly off to infinity would overflow.
const FARTHEST: f32 = 1e9;

/// A run, seen from the camera.
struct Looked<'a> {
    simulation: &'a Simulation,
    alpha: f64,
    eye: DVec3,
}

impl Looked<'_> {
    fn place(&self, body: EntityRef<'_>) -> Option<Vec3> {
        let place = (place(body, self.alpha)? - self.eye).as_vec3();
        (place.abs().max_element() < FARTHEST).then_some(place)
    }

    fn place_of(&self, id: u32) -> Option<Vec3> {
        self.place(self.simulation.present(id)?)
    }

    fn edge(&self, frame: &mut Frame, ends: [u32; 2], color: [f32; 4]) {
        if let [Some(from), Some(to)] = ends.map(|id| self.place_of(id)) {
            frame.lines.push(Line::new(from, to, color, EDGE_WIDTH_PX));
        }
    }

    fn body(&self, frame: &mut Frame, id: u32, color: [f32; 4]) {
        let Some(body) = self.simulation.moving(id) else { return };
        let Some(position) = self.place(body) else { return };
        let Some(shape) = body.get::<Shape>() else {
            let radius_m = body.get::<PointRadius>().copied().unwrap_or_default().0;
            frame.translucent.particles.push(Particle {
                position: position.to_array(),
                radius_m,
                color,
            });
            return;
        };
        let turned = body.get::<Orientation>().map_or(Quat::IDENTITY, |turned| turned.0.as_quat());
        let instance = Instance {
            position: position.to_array(),
            half_extents: shape.half_extents().as_vec3().to_array(),
            orientation: turned.to_array(),
            color,
            ..Instance::default()
        };
        add_translucent(frame, shape, instance);
    }
}

fn color(ink: Ink, alpha: f32) -> [f32; 4] {
    let [r, g, b] = ink.srgb.map(|channel| f32::from(channel) / 255.0);
    [r, g, b, alpha]
}

/// Number of bodies that are drawn as bodies. The points of soft bodies are not; they are the last bodies of a scene.
fn single_bodies(scene: &Scene) -> u32 {
    let first_point = scene.soft_bodies.iter().map(|soft| soft.points.start).min();
    first_point.unwrap_or(u32::try_from(scene.bodies.len()).unwrap_or(u32::MAX))
}

fn add_run(frame: &mut Frame, bodies: u32, edges: &[[u32; 2]], view: &Looked<'_>, ink: Ink) {
    (0..bodies).for_each(|id| view.body(frame, id, color(ink, OPACITY)));
    if !view.simulation.world.contains_resource::<SpringsOff>() {
        edges.iter().for_each(|ends| view.edge(frame, *ends, color(ink, EDGE_OPACITY)));
    }
}

/// The lines to draw, as run number and body id: first the lines of the selection, then the longest. Only the farthest point of
/// a soft body has a line: hundreds of lines would look like a surface.
fn longest_lines(
    scene: &Scene,
    tracks: &[Track<'_>],
    focus: &std::ops::Range<u32>,
) -> Vec<(usize, u32)> {
    let single = single_bodies(scene);
    let mut lines = Vec::new();
    for (run, track) in tracks.iter().enumerate() {
        let of_soft_bodies = scene
            .soft_bodies
            .iter()
            .filter_map(|soft| track.distances.farthest(|id| soft.points.contains(&id)));
        let singles = track.distances.each.iter().copied().filter(|(id, _)| *id < single);
        let apart = singles.chain(of_soft_bodies).filter(|(_, distance)| *distance > 0.0);
        lines.extend(apart.map(|(id, distance)| (run, id, distance)));
    }
    let of_focus = |id: u32| *focus != (0..u32::MAX) && focus.contains(&id);
    lines.sort_by(|(_, a, near), (_, b, far)| {
        of_focus(*b).cmp(&of_focus(*a)).then(far.total_cmp(near))
    });
    lines.into_iter().take(MOST_LINES).map(|(run, id, _)| (run, id)).collect()
}

/// Adds the ghosts to the picture.
pub(super) fn add_ghosts(twins: &Twins, stage: &Stage, view: &View, frame: &mut Frame) {
    let look =
        |simulation| Looked { simulation, alpha: stage.here().alpha, eye: view.camera.position };
    let (tracks, bodies) = (twins.tracks(stage), single_bodies(&stage.sim().scene));
    let shown = |track: &Track<'_>| twins.shows(Some(track.method));
    for track in tracks.iter().filter(|track| !track.solid && shown(track)) {
        add_run(frame, bodies, &twins.edges, &look(track.simulation), track.ink());
    }
    let Some(reference) = twins.reference().map(look) else { return };
    if twins.shows(None) {
        add_run(frame, bodies, &twins.edges, &reference, REFERENCE_INK);
    }
    for (run, id) in longest_lines(&stage.sim().scene, &tracks, &focus(stage)) {
        let track = &tracks[run];
        if let (Some(from), Some(to)) =
            (look(track.simulation).place_of(id), reference.place_of(id))
            && shown(track)
        {
            frame.lines.push(Line::new(from, to, color(track.ink(), LINE_OPACITY), LINE_WIDTH_PX));
        }
    }
}
