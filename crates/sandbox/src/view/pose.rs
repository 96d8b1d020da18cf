//! Where things are drawn, which is where rays find them.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use motion::{Dormant, Orientation, PhysicsBody, PreviousPosition, Quarantined, SoftBody, Transform};
use pick::{Chunk, Ray, Shape, SoftPoint, Viewpoint};

use crate::view::soft::center_of_mass;
use crate::view::stage::Mode;
use crate::view::stage::Stage;

/// Width below which nothing of a soft body is drawn, and hit, pixels.
const THINNEST_PX: f64 = 2.0;

/// Half the widest vertical field of view, radians.
const WIDEST: f64 = 1.2;

/// What a ray found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Picked {
    /// The closest thing, as a whole.
    pub entity: Entity,
    /// From the ray's origin, m.
    pub distance: f64,
    /// The body that a push there acts on, if there is one.
    pub pushed: Option<Entity>,
}

/// Where a body is drawn, `alpha` of the way from the last tick to this one, m.
pub(crate) fn drawn(now: &Transform, before: Option<&PreviousPosition>, alpha: f64) -> DVec3 {
    before.map_or(now.position, |before| before.0 + (now.position - before.0) * alpha)
}

impl Stage {
    /// Where a thing is drawn, m; of a soft body, its center of mass.
    pub(crate) fn drawn_position(&self, thing: Entity) -> Option<DVec3> {
        match self.sim.world.get::<SoftBody>(thing) {
            Some(body) => center_of_mass(&self.sim.world, body, |point| self.drawn_body(point)),
            None => self.drawn_body(thing),
        }
    }

    fn drawn_body(&self, thing: Entity) -> Option<DVec3> {
        let now = self.sim.world.get::<Transform>(thing)?;
        Some(drawn(now, self.sim.world.get::<PreviousPosition>(thing), self.seen.alpha))
    }

    /// The ray that picks: through the pointer in selection mode, through the middle of the view otherwise.
    pub(crate) fn picking_ray(&self) -> Ray {
        let [corner, size] = self.view_area();
        let pixel = if self.view.mode == Mode::Selection { self.view.pointer - corner } else { size / 2.0 };
        self.viewpoint().ray_through(pixel, size)
    }

    /// The camera as rays and pictures need it. Beside panels the view may be narrow: it is widened to show what is
    /// seen from side to side without them.
    pub fn viewpoint(&self) -> Viewpoint {
        let mut view = self.view.camera.viewpoint();
        let [width, height] = self.run.options.size_px.map(f64::from);
        let DVec2 { x, y } = self.view_area()[1];
        let narrower = (width / height.max(1.0)) / (x / y.max(1.0));
        if narrower > 1.0 {
            view.fov_y_rad = 2.0 * ((0.5 * view.fov_y_rad).tan() * narrower).atan().min(WIDEST);
        }
        view
    }

    /// The part of the picture that shows the scene: its top left corner and its size, pixels.
    pub fn view_area(&self) -> [DVec2; 2] {
        let [width, height] = self.run.options.size_px;
        let [left, top, width, height] = self.run.view_px.unwrap_or([0, 0, width, height]).map(f64::from);
        [DVec2::new(left, top), DVec2::new(width, height)]
    }

    /// Where a place is seen, pixels from the top left of the picture, and whether that is inside the view; nothing where it
    /// is behind the camera.
    pub(crate) fn seen_at(&self, place: DVec3) -> Option<(DVec2, bool)> {
        let [corner, size] = self.view_area();
        let at = self.viewpoint().project(place, size)?;
        Some((at + corner, at.cmpge(DVec2::ZERO).all() && at.cmple(size).all()))
    }

    /// The closest thing on `ray` as drawn.
    pub(crate) fn cast(&mut self, ray: &Ray) -> Option<Picked> {
        self.update_targets();
        let solid = self.seen.targets.cast(ray);
        let soft = self.seen.soft.cast(ray, self.thinnest(), |body| self.sim.world.get(body));
        match (solid, soft) {
            (solid, Some(soft)) if solid.is_none_or(|solid| soft.distance < solid.distance) => {
                Some(Picked { entity: soft.entity, distance: soft.distance, pushed: soft.pushed })
            }
            (solid, _) => solid.map(|hit| Picked {
                entity: hit.entity,
                distance: hit.distance,
                pushed: Some(hit.entity),
            }),
        }
    }

    /// Whether forces move a thing, or did until it was quarantined; of a soft body, any of its points.
    pub(crate) fn is_movable(&self, thing: Entity) -> bool {
        let moves = |body: Entity| {
            let state = self.sim.world.get::<PhysicsBody>(body);
            state.is_some_and(|state| state.inverse_mass > 0.0)
                || self.sim.world.get::<Quarantined>(body).is_some()
        };
        match self.sim.world.get::<SoftBody>(thing) {
            Some(soft) => soft.points.iter().any(|point| moves(*point)),
            None => moves(thing),
        }
    }

    /// What a click would select within the cockpit, `immovable` things, too, or not.
    pub(crate) fn hovered(&mut self, immovable: bool) -> Option<Entity> {
        let [corner, size] = self.view_area();
        let at = self.view.pointer - corner;
        let inside = at.cmpge(DVec2::ZERO).all() && at.cmple(size).all();
        if self.run.view_px.is_none() || self.view.mode == Mode::Camera || self.seen.pull.is_some() || !inside
        {
            return None;
        }
        let ray = self.picking_ray();
        self.cast(&ray).map(|hit| hit.entity).filter(|thing| immovable || self.is_movable(*thing))
    }

    /// Smallest radius with which ropes are drawn, as a share of the distance.
    pub(crate) fn thinnest(&self) -> f64 {
        let height = self.view_area()[1].y.max(1.0);
        THINNEST_PX * (0.5 * self.viewpoint().fov_y_rad).tan() / height
    }

    /// Drawn poses relative to the camera, brought up to date once a frame.
    pub(crate) fn update_targets(&mut self) {
        if self.seen.targets_current && self.seen.targets.anchor() == self.view.camera.position {
            return;
        }
        let mut things = self.sim.world.query_filtered::<(
            Entity,
            &Transform,
            Option<&PreviousPosition>,
            &Shape,
            Option<&Orientation>,
        ), Without<Dormant>>();
        let tables =
            things.contiguous_iter(&self.sim.world).expect("every component of a thing is stored in tables");
        let chunks = tables.map(|(entities, transforms, previous, shapes, orientations)| Chunk {
            entities,
            transforms,
            previous,
            shapes,
            orientations,
        });
        self.seen.targets.update(self.view.camera.position, self.seen.alpha, chunks);
        self.update_soft();
        self.seen.targets_current = true;
    }

    fn update_soft(&mut self) {
        let mut bodies = self.sim.world.query::<(Entity, &SoftBody)>();
        let mut points = self.sim.world.query_filtered::<
            (&Transform, Option<&PreviousPosition>, &PhysicsBody),
            (Without<Quarantined>, Without<Dormant>),
        >();
        let (alpha, points) = (self.seen.alpha, points.query(&self.sim.world));
        let point = |entity| {
            let (now, before, body) = points.get(entity).ok()?;
            Some(SoftPoint { position: drawn(now, before, alpha), movable: body.inverse_mass > 0.0 })
        };
        self.seen.soft.update(self.view.camera.position, bodies.iter(&self.sim.world), point);
    }
}
