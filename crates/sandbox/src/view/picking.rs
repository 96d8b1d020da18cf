//! Where things are drawn, which is where rays find them.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use motion::{Dormant, Orientation, PhysicsBody, PreviousPosition, Quarantined, SoftBody, Transform};
use pick::{Chunk, Ray, Shape, SoftPoint, Viewpoint};

use crate::stage::Stage;
use crate::stage::things::{Picked, drawn};
use crate::view::{Mode, View};

/// Width below which nothing of a soft body is drawn, and hit, pixels.
const THINNEST_PX: f64 = 2.0;

/// Half the widest vertical field of view, radians.
const WIDEST: f64 = 1.2;

impl View {
    /// The ray that picks: through the pointer in selection mode, through the middle of the view otherwise.
    pub(crate) fn picking_ray(&self) -> Ray {
        let [corner, size] = self.view_area();
        let pixel = if self.mode == Mode::Selection { self.pointer - corner } else { size / 2.0 };
        self.viewpoint().ray_through(pixel, size)
    }

    /// The camera as rays and pictures need it. Beside panels the view may be narrow: it is widened to show what is
    /// seen from side to side without them.
    pub fn viewpoint(&self) -> Viewpoint {
        let mut view = self.camera.viewpoint();
        let [width, height] = self.size_px.map(f64::from);
        let DVec2 { x, y } = self.view_area()[1];
        let narrower = (width / height.max(1.0)) / (x / y.max(1.0));
        if narrower > 1.0 {
            view.fov_y_rad = 2.0 * ((0.5 * view.fov_y_rad).tan() * narrower).atan().min(WIDEST);
        }
        view
    }

    /// The part of the picture that shows the scene: its top left corner and its size, pixels.
    pub fn view_area(&self) -> [DVec2; 2] {
        let [width, height] = self.size_px;
        let [left, top, width, height] = self.view_px.unwrap_or([0, 0, width, height]).map(f64::from);
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
    pub(crate) fn cast(&mut self, stage: &Stage, ray: &Ray) -> Option<Picked> {
        self.see(stage);
        let solid = self.seen.targets.cast(ray);
        let soft = self.seen.soft.cast(ray, self.thinnest(), |body| stage.sim.world.get(body));
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

    /// What a click would select within the cockpit, `immovable` things, too, or not.
    pub(crate) fn hovered(&mut self, stage: &Stage, immovable: bool) -> Option<Entity> {
        let [corner, size] = self.view_area();
        let at = self.pointer - corner;
        let inside = at.cmpge(DVec2::ZERO).all() && at.cmple(size).all();
        if !self.has_bars() || self.mode == Mode::Camera || stage.here.pull.is_some() || !inside {
            return None;
        }
        let ray = self.picking_ray();
        self.cast(stage, &ray).map(|hit| hit.entity).filter(|thing| immovable || stage.is_movable(*thing))
    }

    /// Smallest radius with which ropes are drawn, as a share of the distance.
    pub(crate) fn thinnest(&self) -> f64 {
        let height = self.view_area()[1].y.max(1.0);
        THINNEST_PX * (0.5 * self.viewpoint().fov_y_rad).tan() / height
    }

    /// Takes over the poses of the present state, relative to the camera.
    pub(crate) fn see(&mut self, stage: &Stage) {
        let version = Some(stage.version);
        let Self { seen, camera, .. } = self;
        if seen.version == version && seen.targets.anchor() == camera.position {
            return;
        }
        let (world, alpha) = (&stage.sim.world, stage.here.alpha);
        let mut things = stage.query_filtered::<(
            Entity,
            &Transform,
            Option<&PreviousPosition>,
            &Shape,
            Option<&Orientation>,
        ), Without<Dormant>>();
        let tables = things.contiguous_iter(world).expect("every component of a thing is stored in tables");
        let chunks = tables.map(|(entities, transforms, previous, shapes, orientations)| Chunk {
            entities,
            transforms,
            previous,
            shapes,
            orientations,
        });
        seen.targets.update(camera.position, alpha, chunks);
        let mut bodies = stage.query::<(Entity, &SoftBody)>();
        let mut points = stage.query_filtered::<
            (&Transform, Option<&PreviousPosition>, &PhysicsBody),
            (Without<Quarantined>, Without<Dormant>),
        >();
        let points = points.query(world);
        let point = |entity| {
            let (now, before, body) = points.get(entity).ok()?;
            Some(SoftPoint { position: drawn(now, before, alpha), movable: body.inverse_mass > 0.0 })
        };
        seen.soft.update(camera.position, bodies.iter(world), point);
        seen.version = version;
    }
}
