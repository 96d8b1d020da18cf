//! Conversion of the world to a plain frame, in f32 relative to the camera.

use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3};
use motion::clock::StepClock;
use motion::{Dormant, Emission, Emitter, PhysicsBody, PreviousPosition, Transform};
use pick::Shape;
use render::{Camera, Frame, Instance, Light, Line, Particle, Sprite};
use scene::{Appearance, PointRadius};

use crate::stage::Stage;
use crate::stage::options::Words;
use crate::stage::query;
use crate::stage::things::{drawn, is_movable, points_of_soft_bodies};
use crate::view::on_device::{EXPOSURE_S, FADES_IN};
use crate::view::{View, art};

/// The tutorial's color of the selection.
pub(crate) const SELECTED: [f32; 4] = [0.0, 1.0, 0.0, 1.0];

/// The look of a thing without one in the scene.
pub(crate) const PLAIN: Appearance = Appearance { color: [1.0; 3], checker: false };

/// Trail color of a white body. Bodies without a color in the scene are white.
const TRAIL_COLOR: [f32; 3] = [1.0, 0.9, 0.4];

/// Minimum share of white in any other trail; the rest is the color of its body.
const TRAIL_PALER: f32 = 0.2;

/// Minimum lightness of a trail: darker trails vanish against the sky.
const TRAIL_LIGHTNESS: f32 = 0.55;

/// Opacity of the trails of particles, which are many.
const TRAIL_OF_MANY: f32 = 0.3;

/// Factor on the color of a body for its trail on paper.
const PAPER_TRAIL_DARKENING: f32 = 0.6;

/// Width of trails, pixels.
const TRAIL_WIDTH_PX: f32 = 2.0;

/// The color of outlines (crates/render/shaders/body.wgsl).
pub(super) const OUTLINE: [f32; 4] = [1.0, 0.87, 0.1, 1.0];

/// Width of the ring around a marked particle, pixels.
const MARK_PX: f64 = 3.0;

/// Opacity of bodies that the ground hides.
const HIDDEN: f32 = 0.25;

/// Opacity of the marked one of them: it keeps its color.
const MARKED: f32 = 0.6;

/// Depth in the ground from which on a body counts as hidden, as a share of its half height. Rounding may put a resting body
/// slightly below the ground.
const BELOW: f32 = 1e-3;

/// Radius of the glow of a body that shines, as a multiple of its own.
const GLOW_RADII: f32 = 2.4;

/// Opacity of that glow.
const GLOW: f32 = 0.3;

/// Factor on the distance from the camera that draws a thing just in front of another.
const NEARER: f32 = 0.999;

/// The stability ratio of the spring between two bodies: 1 at the limit of stability.
pub(crate) type StabilityRatio<'a> = Option<&'a dyn Fn([Entity; 2]) -> f64>;

impl View {
    /// Builds the picture of the present state, without ghosts, arrows and trails. `ratio` colors springs; `immovable`: whether
    /// hovering marks immovable bodies.
    pub(crate) fn begin_picture(
        &mut self,
        stage: &Stage,
        ratio: StabilityRatio<'_>,
        immovable: bool,
    ) -> Frame {
        self.see(stage);
        let eye = self.camera.position;
        let (view, own_look) = (self.viewpoint(), self.is_own_look(stage));
        let mut frame = Frame {
            size_px: self.size_px,
            view_px: self.view_px,
            surround: self.surround,
            camera: Camera {
                orientation: view.orientation.as_quat(),
                #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
                fov_y_rad: view.fov_y_rad as f32,
                #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
                near_m: view.near_m as f32,
                #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
                far_m: view.far_m as f32,
            },
            light: stage.sim().scene.light.map(|light| match own_look {
                true => self.lamp.seen_from(eye, light.shadows),
                false => Light {
                    position: (light.position - eye).as_vec3(),
                    target: (-eye).as_vec3(),
                    color: Vec3::from_array(light.color),
                    shadows: light.shadows,
                },
            }),
            space: !self.ground.has_up,
            soft: own_look,
            paper: stage.options().words == Words::Paper,
            ground: self.ground.seen_from(eye, own_look),
            ..Default::default()
        };
        let hovered = self.hovered(stage, immovable);
        self.add_shapes(stage, &mut frame, hovered);
        add_sunlight(&mut frame);
        self.add_soft_bodies(stage, &mut frame, ratio, hovered);
        self.add_springs(stage, &mut frame, ratio);
        self.add_particles(stage, &mut frame, hovered);
        self.add_particles_on_device(stage, &mut frame);
        frame
    }

    /// Adds the overlays: rings where bodies pass through the ground, arrows, the pull, the flash of a push, trails.
    pub(crate) fn finish_picture(&mut self, stage: &Stage, frame: &mut Frame) {
        self.add_passes(stage, frame);
        self.add_arrows(stage, frame);
        self.add_pull(stage, frame);
        self.add_flash(stage, frame);
        if self.trails {
            self.add_trails(stage, frame);
        }
    }

    fn add_shapes(&self, stage: &Stage, frame: &mut Frame, hovered: Option<Entity>) {
        let mut looks = query::<&Appearance, ()>(&stage.sim().world);
        let (own_look, has_ground) = (self.is_own_look(stage), frame.ground.is_some());
        let shines = frame.space && frame.soft && !frame.paper && !self.lamp.suns.is_empty();
        let targets = &self.seen.targets;
        let (xs, ys, zs) = targets.positions();
        for (i, entity) in targets.entities().iter().enumerate() {
            let look = looks.get(&stage.sim().world, *entity).copied().unwrap_or(PLAIN);
            let selected = stage.selection() == Some(*entity);
            let shape = targets.shape(i);
            let is_marked = selected || hovered == Some(*entity);
            // The ground is drawn in place of this body, unless it is marked.
            if own_look && has_ground && !is_marked && self.is_ground(stage, *entity, shape) {
                continue;
            }
            let mut surface = if look.checker && !own_look { render::CHECKER } else { 0 };
            let is_sun = |id| self.lamp.suns.binary_search(&id).is_ok();
            if shines && stage.sim().id(*entity).is_some_and(is_sun) {
                surface |= render::SHINES;
            }
            if is_marked {
                surface |= render::OUTLINED;
            }
            let [r, g, b] = match own_look {
                true => art::color(look, shape, is_movable(&stage.sim().world, *entity)),
                false => look.color,
            };
            let instance = Instance {
                position: [xs[i], ys[i], zs[i]],
                surface,
                half_extents: shape.half_extents().as_vec3().to_array(),
                orientation: targets.orientation(i).to_array(),
                color: if selected && !own_look { SELECTED } else { [r, g, b, 1.0] },
                ..Default::default()
            };
            match shape {
                Shape::Cuboid { .. } => frame.cuboids.push(instance),
                Shape::Sphere { .. } => frame.spheres.push(instance),
            }
            let is_hidden = frame.ground.is_some_and(|ground| {
                let reach = targets.reach(i).y;
                ys[i] - reach < ground.height_m - BELOW * reach
            });
            if is_hidden {
                let alpha = if is_marked { MARKED } else { HIDDEN };
                let hidden = Instance { surface: 0, color: [r, g, b, alpha], ..instance };
                add_translucent(frame, shape, hidden);
            }
        }
    }

    /// Adds single particles as discs, and emitted particles.
    fn add_particles(&self, stage: &Stage, frame: &mut Frame, hovered: Option<Entity>) {
        let (eye, forward) = (self.camera.position, self.viewpoint().forward());
        for Point { entity, position, radius: radius_m, velocity, color: [r, g, b], fade } in
            &self.seen.points
        {
            let depth = (*position - eye).dot(forward);
            let (position, radius_m) = ((*position - eye).as_vec3(), *radius_m);
            // Share of the distance to the point at which the line of sight crosses the ground; in 0..1 the ground hides it.
            let crossing = frame.ground.map(|ground| ground.height_m / position.y);
            let crossing = crossing.filter(|crossing| (0.0..1.0).contains(crossing));
            let is_marked = stage.selection() == Some(*entity) || hovered == Some(*entity);
            let disc = |position: Vec3, radius_m: f32, [r, g, b, _]: [f32; 4], alpha: f32| {
                Particle { position: position.to_array(), radius_m, color: [r, g, b, alpha] }
            };
            match (fade, crossing) {
                (Some(fade), _) => {
                    let streak = (velocity * EXPOSURE_S).as_vec3().to_array();
                    let (position, color) = (position.to_array(), [*r, *g, *b, *fade]);
                    frame.sprites.push(Sprite { position, radius_m, streak, _pad: 0.0, color });
                }
                (None, Some(crossing)) => {
                    let alpha = if is_marked { MARKED } else { HIDDEN };
                    let color = [*r, *g, *b, 1.0];
                    let hidden =
                        disc(position * (crossing * NEARER), radius_m * crossing, color, alpha);
                    frame.translucent.particles.push(hidden);
                }
                (None, None) => {
                    if is_marked {
                        let color = if frame.soft { OUTLINE } else { SELECTED };
                        #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
                        let radius_m = radius_m + (MARK_PX * self.pixel() * depth) as f32;
                        // Just behind the disc: at the same depth the two would z-fight.
                        frame.particles.push(disc(
                            position / NEARER,
                            radius_m / NEARER,
                            color,
                            1.0,
                        ));
                    }
                    frame.particles.push(disc(position, radius_m, [*r, *g, *b, 1.0], 1.0));
                }
            }
        }
    }

    /// Whether the ground is drawn in place of a body.
    pub(super) fn is_ground(&self, stage: &Stage, body: Entity, shape: &Shape) -> bool {
        let height = stage.drawn_position(body).map(|place| place.y);
        !is_movable(&stage.sim().world, body)
            && height.is_some_and(|height| self.ground.replaces(shape, height))
    }

    fn add_trails(&self, stage: &Stage, frame: &mut Frame) {
        let (world, eye) = (&stage.sim().world, self.camera.position);
        for (body, points) in self.trail.until(stage.here().drawn_at(stage.sim())) {
            let color = world.get::<Appearance>(body).copied().unwrap_or(PLAIN).color;
            let dark = || color.map(|channel| PAPER_TRAIL_DARKENING * channel);
            let [r, g, b] = if frame.paper { dark() } else { trail_color(color) };
            let seen = if world.get::<PointRadius>(body).is_some() { TRAIL_OF_MANY } else { 1.0 };
            let points = points.chain(stage.drawn_position(body));
            let count = points.clone().count();
            #[expect(clippy::cast_precision_loss, reason = "at most thousands of points")]
            let fade = |i: usize| seen * (i as f32 / count as f32).sqrt();
            for (i, (from, to)) in points.clone().zip(points.skip(1)).enumerate() {
                let (from, to) = ((from - eye).as_vec3(), (to - eye).as_vec3());
                frame.lines.push(Line::new(from, to, [r, g, b, fade(i + 1)], TRAIL_WIDTH_PX));
            }
        }
    }
}

/// Adds a glow around every ball that shines, and lights the others by the first of them.
fn add_sunlight(frame: &mut Frame) {
    let suns = frame.spheres.iter().filter(|ball| ball.surface & render::SHINES != 0);
    let unshadowed = frame.light.as_mut().filter(|light| !light.shadows);
    if let Some((light, sun)) = unshadowed.zip(suns.clone().next()) {
        light.position = Vec3::from(sun.position);
    }
    frame.sprites.extend(suns.map(|sun| {
        let Instance { position, half_extents: [radius, ..], color: [r, g, b, _], .. } = *sun;
        let (streak, color) = ([0.0; 3], [r, g, b, GLOW]);
        Sprite { position, radius_m: GLOW_RADII * radius, streak, _pad: 0.0, color }
    }));
}

/// Adds a translucent body.
pub(crate) fn add_translucent(frame: &mut Frame, shape: &Shape, instance: Instance) {
    match shape {
        Shape::Cuboid { .. } => frame.translucent.cuboids.push(instance),
        Shape::Sphere { .. } => frame.translucent.spheres.push(instance),
    }
}

/// A body without a shape, drawn as a point.
pub(super) struct Point {
    pub entity: Entity,
    /// Position in world space, m.
    pub position: DVec3,
    /// Radius, m.
    pub radius: f32,
    velocity: DVec3,
    color: [f32; 3],
    /// Opacity, if it is an emitted particle.
    pub fade: Option<f32>,
}

/// Sets `points` to all bodies that are drawn as points.
pub(super) fn find_points(stage: &Stage, points: &mut Vec<Point>) {
    let alpha = stage.here().alpha;
    let of_soft_bodies = points_of_soft_bodies(&stage.sim().world);
    let fades = fades(stage);
    let mut bodies = query::<
        (
            Entity,
            &Transform,
            &PhysicsBody,
            Option<&PreviousPosition>,
            Option<&Appearance>,
            Option<&PointRadius>,
        ),
        (Without<Shape>, Without<Dormant>),
    >(&stage.sim().world);
    let bodies =
        bodies.iter(&stage.sim().world).filter(|(entity, ..)| !of_soft_bodies.contains(*entity));
    points.clear();
    points.extend(bodies.map(|(entity, now, body, before, look, radius)| Point {
        entity,
        position: drawn(now, before, alpha),
        radius: radius.copied().unwrap_or_default().0,
        velocity: body.velocity,
        color: look.copied().unwrap_or(PLAIN).color,
        fade: fades.get(entity.index_u32() as usize).copied().flatten(),
    }));
}

/// Opacity of each particle of an emitter, by entity index.
fn fades(stage: &Stage) -> Vec<Option<f32>> {
    let now = stage.sim().world.resource::<StepClock>().scene_seconds();
    let mut fades = Vec::new();
    for (emitter, emission) in
        query::<(&Emitter, &Emission), ()>(&stage.sim().world).iter(&stage.sim().world)
    {
        let last = emitter.pool.iter().map(|body| body.index_u32() as usize + 1).max().unwrap_or(0);
        fades.resize(last.max(fades.len()), None);
        for (body, number) in emitter.pool.iter().zip(emission.state().slots) {
            #[expect(clippy::cast_precision_loss, reason = "millions of births")]
            let age = number.map(|number| now - number as f64 / emitter.rate);
            #[expect(clippy::cast_possible_truncation, reason = "a color")]
            let fade =
                age.map(|age| ((1.0 - age / emitter.life) / FADES_IN).clamp(0.0, 1.0) as f32);
            fades[body.index_u32() as usize] = fade;
        }
    }
    fades
}

/// The trail color for a body with this color.
fn trail_color(body: [f32; 3]) -> [f32; 3] {
    if body.iter().all(|channel| *channel >= 1.0) {
        return TRAIL_COLOR;
    }
    let lightness = Vec3::from(body).dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let paler = ((TRAIL_LIGHTNESS - lightness) / (1.0 - lightness)).max(TRAIL_PALER);
    body.map(|channel| channel + (1.0 - channel) * paler)
}
