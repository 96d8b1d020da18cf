//! Soft bodies and springs in the picture: surfaces, ropes, pins and the view of springs by strain.

use std::f32::consts::TAU;

use bevy_ecs::prelude::*;
use glam::{Quat, Vec3};
use motion::{Dormant, Elastic, PhysicsBody, Quarantined, SoftBody, Spring};
use pick::{BladeSurface, Blades, SoftPose};
use render::{Frame, Instance, Line, Particle, Surface};
use scene::Appearance;

use crate::stage::Stage;
use crate::stage::query;
use crate::view::View;
use crate::view::picture::{OUTLINE, PLAIN, SELECTED, StabilityRatio};

/// Color of a spring outside the view of springs.
const SPRING_COLOR: [f32; 4] = [0.30, 0.30, 0.34, 1.0];
/// Color of a spring on the dark sky of space.
const SPRING_IN_SPACE: [f32; 4] = [0.82, 0.84, 0.88, 1.0];
const SPRING_WIDTH_PX: f32 = 2.0;

/// Turns of a coil, which shows a spring between two bodies in the program's own look.
const TURNS: u16 = 9;
/// Lines per turn of a coil.
const LINES_PER_TURN: u16 = 8;
/// Radius of a coil, as a fraction of the length of its spring at rest.
const COIL_RADIUS: f64 = 0.035;
/// Greatest number of springs that are drawn as coils: those of a crowd are straight.
const MOST_COILS: usize = 100;

/// Strain at which a spring has its full color.
const FULL_STRAIN: f64 = 0.1;
/// Colors of springs that are shorter than at rest, at rest, and longer.
const STRAIN_COLORS: [Vec3; 3] =
    [Vec3::new(0.05, 0.25, 1.0), Vec3::splat(0.95), Vec3::new(1.0, 0.08, 0.04)];

/// How much nearer to white blades are that are selected or under the pointer, from 0 to 1.
const PALER_BLADES: f32 = 0.35;

/// Color of a pin, which holds a point in its place.
const PIN_COLOR: [f32; 4] = [0.16, 0.16, 0.19, 1.0];
/// Radius of a pin, as a multiple of that of a point.
const PIN_SIZE: f32 = 1.5;

/// How bright a line is, relative to a body of the same color: lines are not shaded, and no body is lit fully.
const LINE_SHADE: f32 = 0.7;
/// Width of the line of a rope that is too thin to be drawn as a body, pixels.
const ROPE_WIDTH_PX: f32 = 2.0;
/// Width of the line behind it that shows as the outline of a selected rope, pixels.
const OUTLINE_WIDTH_PX: f32 = 6.0;

/// Relative change of a spring's length, 0.1 for one tenth longer than at rest; for a rest length of 0 it is 0 if the length is
/// 0, and infinite otherwise.
fn strain(length: f64, rest_length: f64) -> f64 {
    if length == rest_length { 0.0 } else { length / rest_length - 1.0 }
}

/// The strain of a spring of that length; 0 for a cord that is slack.
fn elastic_strain(length: f64, elastic: &Elastic) -> f64 {
    let strain = strain(length, elastic.rest_length);
    if elastic.pull_only { strain.max(0.0) } else { strain }
}

/// Blue for a spring that is compressed, white at rest, red for a stretched one; linear between.
fn strain_color(strain: f64) -> [f32; 4] {
    #[expect(clippy::cast_possible_truncation, reason = "a color")]
    let share = (strain / FULL_STRAIN).clamp(-1.0, 1.0) as f32;
    let [short, rest, long] = STRAIN_COLORS;
    rest.lerp(if share < 0.0 { short } else { long }, share.abs()).extend(1.0).to_array()
}

/// Colors of springs by the used fraction of their limit: a spring is red before it grows.
const MARGIN_COLORS: [(f64, Vec3); 4] = [
    (0.0, Vec3::new(0.0, 0.55, 0.25)),
    (0.5, Vec3::new(0.35, 0.75, 0.2)),
    (0.8, Vec3::new(1.0, 0.8, 0.1)),
    (0.98, Vec3::new(1.0, 0.08, 0.04)),
];

/// Green far from the limit, yellow near it, red at it and beyond; linear between.
pub(crate) fn margin_color(ratio: f64) -> [f32; 4] {
    let [first, .., last] = MARGIN_COLORS;
    let between = |pair: &[(f64, Vec3)]| {
        let [(low, from), (high, to)] = [pair[0], pair[1]];
        #[expect(clippy::cast_possible_truncation, reason = "a color")]
        let share = ((ratio - low) / (high - low)) as f32;
        (low..high).contains(&ratio).then(|| from.lerp(to, share))
    };
    let inside = MARGIN_COLORS.windows(2).find_map(between);
    // NaN gets the last color.
    let outside = if ratio < first.0 { first.1 } else { last.1 };
    inside.unwrap_or(outside).extend(1.0).to_array()
}

/// How one soft body is drawn.
struct Drawing<'a> {
    pose: &'a SoftPose,
    color: [f32; 4],
    outlined: bool,
    /// Smallest radius over distance that is drawn as a body.
    thinnest: f32,
    blades: Option<&'a Blades>,
}

impl Drawing<'_> {
    /// Whether something of that radius at `at` is large enough in the picture to be drawn as a body.
    fn shows_body(&self, at: Vec3, radius: f32) -> bool {
        radius >= self.thinnest * at.length()
    }

    /// Adds a ball, or a disc if it is too small for one.
    fn ball(&self, frame: &mut Frame, center: Vec3, radius: f32, color: [f32; 4], surface: u32) {
        if self.shows_body(center, radius) {
            frame.spheres.push(Instance {
                position: center.to_array(),
                half_extents: [radius; 3],
                surface,
                color,
                ..Instance::default()
            });
        } else {
            frame.particles.push(Particle { position: center.to_array(), radius_m: radius, color });
        }
    }

    /// Adds a rope between two points, or a line if it is too thin for one. Lines go to `thin`, their outlines into the frame at
    /// once: the outline of one spring must not cover its neighbor.
    fn rope(&self, frame: &mut Frame, thin: &mut Vec<Line>, [from, to]: [Vec3; 2], radius: f32) {
        let (middle, along) = ((from + to) / 2.0, to - from);
        let length = along.length();
        if !length.is_normal() {
            return;
        }
        if self.shows_body(middle, radius) {
            frame.cuboids.push(Instance {
                position: middle.to_array(),
                half_extents: [radius, radius, 0.5 * length],
                orientation: Quat::from_rotation_arc(Vec3::Z, along / length).to_array(),
                surface: self.outline(),
                color: self.color,
                ..Instance::default()
            });
        } else {
            if self.outlined {
                frame.lines.push(Line::new(from, to, OUTLINE, OUTLINE_WIDTH_PX));
            }
            let [r, g, b, a] = self.color;
            let shaded = [r * LINE_SHADE, g * LINE_SHADE, b * LINE_SHADE, a];
            thin.push(Line::new(from, to, shaded, ROPE_WIDTH_PX));
        }
    }

    fn outline(&self) -> u32 {
        if self.outlined { render::OUTLINED } else { 0 }
    }

    #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
    fn add(
        &self,
        frame: &mut Frame,
        body: &SoftBody,
        springs_alone: bool,
        ratio: StabilityRatio<'_>,
    ) {
        let pose = self.pose;
        let (radius, link_radius) = (pose.point_radius() as f32, pose.link_radius() as f32);
        if springs_alone {
            for link in body.springs.iter() {
                if let Some([from, to]) = pose.corners(link.ends) {
                    let length = from.as_dvec3().distance(to.as_dvec3());
                    let by_strain = || strain_color(elastic_strain(length, &link.elastic));
                    let ends = link.ends.map(|end| body.points[end as usize]);
                    let color = ratio.map_or_else(by_strain, |ratio| margin_color(ratio(ends)));
                    frame.lines.push(Line::new(from, to, color, SPRING_WIDTH_PX));
                }
            }
        } else if let (Some(surface), Some(blades)) = (pose.blades(), self.blades) {
            // Outlines of thousands of blades would be all that is seen.
            let paler = if self.outlined { PALER_BLADES } else { 0.0 };
            let color = self.color.map(|channel| channel + paler * (1.0 - channel));
            frame.surfaces.push(shaded_blades(surface, blades, color));
            return;
        } else if body.triangles.is_empty() {
            let mut thin = Vec::new();
            for link in body.springs.iter() {
                if let Some(ends) = pose.corners(link.ends) {
                    self.rope(frame, &mut thin, ends, link_radius);
                }
            }
            frame.lines.append(&mut thin);
        } else {
            let triangles = body.triangles.iter().copied();
            let surface = Surface::smooth(pose.points(), triangles, self.color);
            frame.surfaces.push(Surface { outlined: self.outlined, ..surface });
        }
        // On the line of a thin rope points would be dark beads; in the view of springs, points show the selection.
        let shown = |point: Vec3| match (springs_alone, body.triangles.is_empty()) {
            (true, _) => self.outlined,
            (false, rope) => {
                rope && (body.springs.is_empty() || self.shows_body(point, link_radius))
            }
        };
        // A surface has an outline of its own.
        let outline = if body.triangles.is_empty() { self.outline() } else { 0 };
        for (number, point) in (0..).zip(pose.points()).filter(|(_, point)| point.is_finite()) {
            if !pose.is_movable(number) {
                self.ball(frame, *point, PIN_SIZE * radius, PIN_COLOR, outline);
            } else if shown(*point) {
                self.ball(frame, *point, radius, self.color, outline);
            }
        }
    }
}

impl View {
    pub(super) fn add_soft_bodies(
        &self,
        stage: &Stage,
        frame: &mut Frame,
        ratio: StabilityRatio<'_>,
        hovered: Option<Entity>,
    ) {
        type Look<'a> = (&'a SoftBody, Option<&'a Appearance>, Option<&'a Blades>);
        let mut looks = query::<Look<'_>, ()>(&stage.sim().world);
        #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
        let thinnest = self.thinnest() as f32;
        for pose in self.seen.soft.poses() {
            let Ok((body, look, blades)) = looks.get(&stage.sim().world, pose.entity()) else {
                continue;
            };
            let selected = stage.selection() == Some(pose.entity());
            let [r, g, b] = look.copied().unwrap_or(PLAIN).color;
            let outlined = selected || hovered == Some(pose.entity());
            let color = if selected && !frame.soft { SELECTED } else { [r, g, b, 1.0] };
            let alone = self.springs || ratio.is_some();
            Drawing { pose, color, outlined, thinnest, blades }.add(frame, body, alone, ratio);
        }
    }

    /// Adds the springs between bodies, except those with an end that is quarantined, dormant or without physics.
    pub(super) fn add_springs(&self, stage: &Stage, frame: &mut Frame, ratio: StabilityRatio<'_>) {
        let eye = self.camera.position;
        let mut springs = query::<&Spring, ()>(&stage.sim().world);
        let coiled = frame.soft && springs.iter(&stage.sim().world).count() <= MOST_COILS;
        let mut ends = query::<(), (With<PhysicsBody>, Without<Quarantined>, Without<Dormant>)>(
            &stage.sim().world,
        );
        let ends = ends.query(&stage.sim().world);
        for spring in springs.iter(&stage.sim().world) {
            let place = |end| stage.drawn_position(end).filter(|_| ends.contains(end));
            if let [Some(from), Some(to)] = spring.ends.map(place) {
                let color = if let Some(ratio) = ratio {
                    margin_color(ratio(spring.ends))
                } else if self.springs {
                    strain_color(elastic_strain(from.distance(to), &spring.elastic))
                } else if frame.soft && frame.space && !frame.paper {
                    SPRING_IN_SPACE
                } else {
                    SPRING_COLOR
                };
                let ends = [from, to].map(|end| (end - eye).as_vec3());
                let rest = spring.elastic.rest_length;
                match coiled && rest > 0.0 {
                    _ if spring.elastic.pull_only => add_cord(frame, ends, rest, color),
                    true => add_coil(frame, ends, rest, color),
                    false => frame.lines.push(Line::new(ends[0], ends[1], color, SPRING_WIDTH_PX)),
                }
            }
        }
    }
}

/// The surface of blades, each of its own brightness and darker toward the ground.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    reason = "colors are bytes"
)]
fn shaded_blades(surface: &BladeSurface, blades: &Blades, color: [f32; 4]) -> Surface {
    /// Brightness at the first point, relative to the tip.
    const SHADED: f32 = 0.35;
    /// Brightness of the dullest blade, relative to the brightest one.
    const DULL: f32 = 0.65;
    let mut drawn = Surface::smooth(&surface.corners, surface.triangles.iter().copied(), color);
    for (pair, number) in drawn.vertices.chunks_exact_mut(2).zip(0_u32..) {
        let light = DULL + (1.0 - DULL) * (0.618 * blades.blade(number) as f32).fract();
        let bright = light * (SHADED + (1.0 - SHADED) * blades.share(number));
        for channel in pair.iter_mut().flat_map(|vertex| &mut vertex.color[..3]) {
            *channel = (f32::from(*channel) * bright) as u8;
        }
    }
    drawn
}

/// Adds a cord of length `rest`: straight if it is stretched, else hanging down between its ends as a parabola of about that
/// length, and where one end is above the other sideways as well, by a fifth of what is slack.
fn add_cord(frame: &mut Frame, [from, to]: [Vec3; 2], rest: f64, color: [f32; 4]) {
    const PARTS: u16 = 16;
    let along = to - from;
    #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
    let rest = rest as f32;
    let over = rest * rest - along.length_squared();
    // For small sags s the length is `d + 8 s² / (3 d)`; with no distance d, s is nearly half the length.
    let sag = if over > 0.0 { (3.0 * over).sqrt() / 4.0 } else { 0.0 };
    let across = |v: Vec3| along.try_normalize().map_or(v, |axis| v.reject_from_normalized(axis));
    let (down, slack) = (across(Vec3::NEG_Y), rest - along.length());
    let aside = across(Vec3::X).normalize_or(Vec3::Z) * (0.2 * slack * (1.0 - down.length()));
    let bow = down * sag + aside;
    let point = |number: u16| {
        let share = f32::from(number) / f32::from(PARTS);
        from + along * share + bow * (4.0 * share * (1.0 - share))
    };
    let parts = if sag > 0.0 { PARTS } else { 1 };
    let ends = (0..parts).map(|part| [part, part + 1].map(|end| point(end * (PARTS / parts))));
    frame.lines.extend(ends.map(|[from, to]| Line::new(from, to, color, SPRING_WIDTH_PX)));
}

/// Adds a helix from end to end, with a straight piece at each end.
fn add_coil(frame: &mut Frame, [from, to]: [Vec3; 2], rest: f64, color: [f32; 4]) {
    let along = to - from;
    let Some(axis) = along.try_normalize() else { return };
    let (right, up) = axis.any_orthonormal_pair();
    #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
    let radius = (COIL_RADIUS * rest) as f32;
    let lines = TURNS * LINES_PER_TURN;
    let point = |number: u16| {
        let (sin, cos) = (TAU * f32::from(number) / f32::from(LINES_PER_TURN)).sin_cos();
        let share = 0.1 + 0.8 * f32::from(number) / f32::from(lines);
        from + along * share + (right * cos + up * sin) * radius
    };
    let points = std::iter::once(from).chain((0..=lines).map(point)).chain([to]);
    let mut points = points.peekable();
    while let (Some(start), Some(end)) = (points.next(), points.peek()) {
        frame.lines.push(Line::new(start, *end, color, SPRING_WIDTH_PX));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn springs_are_blue_when_short_white_at_rest_and_red_when_long() {
        let [short, rest, long] = STRAIN_COLORS.map(|color| color.extend(1.0).to_array());
        for (length, color) in [(0.9, short), (0.5, short), (1.0, rest), (1.1, long), (3.0, long)] {
            let seen = strain_color(strain(length, 1.0));
            assert!(
                seen.iter().zip(color).all(|(a, b)| (a - b).abs() < 1e-6),
                "{length}: {seen:?}"
            );
        }
        let half = strain_color(strain(2.1, 2.0));
        assert!(half[0] > rest[0].min(long[0]) && half[1] < rest[1] && half[1] > long[1]);
    }

    #[test]
    fn margins_go_from_green_by_yellow_to_red_before_the_limit() {
        for (ratio, green_over_red) in
            [(0.0, true), (0.5, true), (0.98, false), (1.0, false), (f64::INFINITY, false)]
        {
            let [red, green, ..] = margin_color(ratio);
            assert_eq!(green > red, green_over_red, "{ratio}");
        }
        let [red, green, ..] = margin_color(0.8);
        assert!(red > 0.9 && green > 0.7);
        assert_eq!(margin_color(0.98), margin_color(f64::NAN));
        assert!(margin_color(0.9)[1] < margin_color(0.8)[1]);
    }

    #[test]
    fn a_spring_without_a_length_at_rest_is_white_or_red() {
        assert_eq!(strain(0.0, 0.0), 0.0);
        assert_eq!(strain(1e-9, 0.0), f64::INFINITY);
        assert_eq!(strain_color(f64::INFINITY), STRAIN_COLORS[2].extend(1.0).to_array());
    }
}
