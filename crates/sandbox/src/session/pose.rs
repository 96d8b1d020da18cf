//! Where things are drawn, which is where rays find them.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use motion::{Orientation, PreviousPosition, Transform};
use pick::{Chunk, Hit, Ray, Shape, Targets};

use super::Session;
use crate::control::Mode;

impl Session {
    /// Where a thing is drawn, m.
    pub(crate) fn drawn_position(&self, thing: Entity) -> Option<DVec3> {
        let now = self.world.get::<Transform>(thing)?.position;
        let before = self.world.get::<PreviousPosition>(thing).map_or(now, |before| before.0);
        Some(before + (now - before) * self.alpha)
    }

    /// The ray that picks: through the pointer in selection mode, through the middle of the view otherwise.
    pub(crate) fn picking_ray(&self) -> Ray {
        let size = DVec2::new(f64::from(self.options.size_px[0]), f64::from(self.options.size_px[1]));
        let pixel = if self.control.mode == Mode::Selection { self.control.pointer } else { size / 2.0 };
        self.camera.viewpoint().ray_through(pixel, size)
    }

    /// The closest thing on `ray` as drawn.
    pub(crate) fn cast(&mut self, ray: &Ray) -> Option<Hit> {
        self.update_targets();
        self.targets.cast(ray)
    }

    /// Drawn poses relative to the camera, brought up to date once a frame.
    pub(crate) fn update_targets(&mut self) {
        if self.targets_current && self.targets.anchor() == self.camera.position {
            return;
        }
        let mut things =
            self.world
                .query::<(Entity, &Transform, Option<&PreviousPosition>, &Shape, Option<&Orientation>)>();
        let tables =
            things.contiguous_iter(&self.world).expect("every component of a thing is stored in tables");
        let chunks = tables.map(|(entities, transforms, previous, shapes, orientations)| Chunk {
            entities,
            transforms,
            previous,
            shapes,
            orientations,
        });
        self.targets.update(self.camera.position, self.alpha, chunks);
        self.targets_current = true;
    }

    pub(crate) const fn targets(&self) -> &Targets {
        &self.targets
    }
}
