//! The flash of a push by a click: an arrow at the pushed body, with the force and the speed that it gave.

use bevy_ecs::prelude::*;
use egui::{Align2, FontId, Painter, Rect, Vec2};
use glam::DVec3;
use motion::{PhysicsBody, TimeStep};
use render::{Frame, Line};
use report::numbers::{digits, significant};

use crate::stage::Stage;
use crate::view::View;
use crate::view::arrows::color_of;
use crate::view::hud::{SIZE, as_in_picture, point, text};

/// How long it is shown, s.
const SHOWN_S: f64 = 1.2;

/// Length of the arrow, as a fraction of the distance from the camera.
const LENGTH: f64 = 0.12;

const WIDTH_PX: f32 = 4.0;

/// A push by a click.
pub(crate) struct Flash {
    body: Entity,
    /// From the middle of the body to where it was hit, m.
    offset: DVec3,
    newtons: DVec3,
    /// Until when it is shown, s of frame time.
    pub until: f64,
}

impl View {
    /// Shows from now on that `body` was pushed at `hit`, m.
    pub(crate) fn flash(&mut self, stage: &Stage, body: Entity, hit: DVec3, newtons: DVec3) {
        let offset = hit - stage.drawn_position(body).unwrap_or(hit);
        self.flash = Some(Flash { body, offset, newtons, until: stage.playback().now() + SHOWN_S });
    }

    /// Ends the flash once it was shown long enough.
    pub(crate) fn expire_flash(&mut self, now: f64) {
        self.flash.take_if(|flash| flash.until <= now);
    }

    /// Tail and head of the arrow, m.
    fn flash_arrow(&self, stage: &Stage) -> Option<[DVec3; 2]> {
        let flash = self.flash.as_ref()?;
        let at = stage.drawn_position(flash.body)? + flash.offset;
        let back = flash.newtons.try_normalize()? * (LENGTH * at.distance(self.camera.position));
        // Along the line of sight the arrow would look like a point, so it comes from below.
        let aside = -self.viewpoint().up() * (0.6 * back.length());
        Some([at - back + aside, at])
    }

    pub(super) fn add_flash(&self, stage: &Stage, frame: &mut Frame) {
        if let Some(ends) = self.flash_arrow(stage).filter(|_| frame.soft) {
            let [from, to] = ends.map(|end| (end - self.camera.position).as_vec3());
            Line::arrow(&mut frame.lines, from, to, color_of("push"), WIDTH_PX);
        }
    }

    /// Writes the newtons, and the speed that one tick of them gives, at the arrow.
    pub(crate) fn write_flash(&self, stage: &Stage, painter: &Painter) -> Option<Rect> {
        let (flash, [tail, _]) = self.flash.as_ref().zip(self.flash_arrow(stage))?;
        let (at, _) = self.seen_at(tail).filter(|(_, inside)| *inside)?;
        let (world, newtons) = (&stage.sim().world, flash.newtons.length());
        let inverse_mass =
            world.get::<PhysicsBody>(flash.body).map_or(0.0, |body| body.inverse_mass);
        let speed = newtons * inverse_mass * world.resource::<TimeStep>().0;
        let words =
            format!("{} N for one tick: {} m/s", digits(newtons), significant(speed, 2, 1e-3..1e4));
        let color = as_in_picture(color_of("push"));
        let at = point(painter, at) + Vec2::new(0.0, 6.0);
        Some(text(painter, at, Align2::CENTER_TOP, &words, FontId::proportional(SIZE), color))
    }
}
