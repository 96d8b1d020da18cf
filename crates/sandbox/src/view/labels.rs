//! Words beside bodies: where in the picture they stand.

use bevy_ecs::entity::Entity;
use glam::{DQuat, DVec2, DVec3};
use motion::Orientation;
use pick::Shape;

use crate::app::session::Session;

/// A body's words in the picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Label {
    /// Where the body's middle is seen, pixels from the top left.
    pub at: DVec2,
    /// How far from there the body reaches, to the side where the words are or, of a ring around it, at most; pixels.
    pub reach: f64,
    pub text: String,
}

/// How far a shape reaches from its middle, m, in a direction of its own axes.
type Reach = fn(&Shape, DVec3) -> f64;

/// To its surface in that direction: the words of a thin body stand beside it.
fn beside(shape: &Shape, direction: DVec3) -> f64 {
    match shape {
        Shape::Cuboid { half_extents } => (*half_extents / direction.abs()).min_element(),
        Shape::Sphere { radius } => *radius,
    }
}

/// In any direction.
fn around(shape: &Shape, _: DVec3) -> f64 {
    shape.half_extents().max_element()
}

impl Session {
    /// The labels of the bodies whose middle is in the picture, the farthest first.
    pub(crate) fn visible_labels(&self) -> Vec<Label> {
        let labels = self.labels.iter();
        let mut seen: Vec<_> = labels
            .filter_map(|(id, text)| self.label(*self.sim.bodies.get(*id as usize)?, text, beside))
            .collect();
        seen.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        seen.into_iter().map(|(_, label)| label).collect()
    }

    /// What marks the body that a fault is about, while the run stands next to it.
    pub(crate) fn fault_mark(&self) -> Option<Label> {
        let fault = self.fault().filter(|_| self.paused())?;
        let words = match self.ticks().checked_sub(fault.tick) {
            None if self.ticks() + 1 == fault.tick => "goes wrong in the next tick".to_owned(),
            Some(0) => "went wrong in this tick".to_owned(),
            _ => format!("goes wrong in tick {}", fault.tick),
        };
        let body = *self.sim.bodies.get(fault.body? as usize)?;
        let label = self.label(body, &format!("{} {words}", self.name(body)), around);
        label.map(|(_, label)| label)
    }

    /// How far a thing is, m, and its label, if its middle is in the picture.
    fn label(&self, thing: Entity, text: &str, reach: Reach) -> Option<(f64, Label)> {
        let view = self.camera.viewpoint();
        let size = DVec2::from_array(self.options.size_px.map(f64::from));
        let place = self.drawn_position(thing)?;
        let distance = (place - view.position).dot(view.forward());
        let drawn = (view.near_m..=view.far_m).contains(&distance);
        let at = view.project(place, size).filter(|_| drawn)?;
        let inside = at.cmpge(DVec2::ZERO).all() && at.cmple(size).all();
        let turned = self.sim.world.get::<Orientation>(thing).map_or(DQuat::IDENTITY, |turned| turned.0);
        let reach = self
            .sim
            .world
            .get::<Shape>(thing)
            .map_or(0.0, |shape| reach(shape, turned.inverse() * view.right()));
        let side = view.project(place + view.right() * reach, size)?;
        inside.then(|| (distance, Label { at, reach: side.distance(at), text: text.to_owned() }))
    }
}

#[cfg(test)]
mod tests {
    use scene::Scene;

    use super::*;
    use crate::app::session::Options;

    /// Seen from the origin along -z, 90 degrees high.
    fn session() -> Session {
        let text = "(version: 1,
            camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0, fov_y_deg: 90, near_m: 0.1, far_m: 100),
            bodies: [
                (name: \"ahead\", shape: sphere(radius_m: 2), position_m: (0, 0, -10)),
                (name: \"particle\", position_m: (5, 5, -20)),
                (name: \"behind\", shape: sphere(radius_m: 2), position_m: (0, 0, 10)),
                (name: \"beside\", position_m: (40, 0, -10)),
                (name: \"distant\", position_m: (0, 0, -200)),
            ])";
        let mut session =
            Session::new(Scene::parse("labels", text).expect("a good scene"), Options::default());
        let names: Vec<_> = session.sim.scene.names.iter().map(std::borrow::Cow::into_owned).collect();
        session.labels = (0..).zip(names).collect();
        // A body that there is not.
        session.labels.push((99, "nobody".to_owned()));
        session
    }

    #[test]
    fn labels_stand_where_their_bodies_are_seen_and_only_in_the_picture() {
        let seen = session().visible_labels();
        let words: Vec<_> = seen.iter().map(|label| label.text.as_str()).collect();
        assert_eq!(words, ["particle", "ahead"]);
        let close = |a: DVec2, b: DVec2| assert!((a - b).length() < 1e-9, "{a} is not {b}");
        // 360 pixels are 45 degrees.
        close(seen[0].at, DVec2::new(640.0 + 90.0, 360.0 - 90.0));
        close(seen[1].at, DVec2::new(640.0, 360.0));
        assert!(seen[0].reach == 0.0 && (seen[1].reach - 72.0).abs() < 1e-9);
    }

    #[test]
    fn words_stand_beside_thin_bodies_and_a_ring_goes_around_all_of_one() {
        let text = "(version: 1,
            camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0, fov_y_deg: 90, near_m: 0.1, far_m: 100),
            bodies: [(name: \"mast\", label: \"mast\", shape: cuboid(half_extents_m: (0.5, 5, 3)), position_m: (0, 0, -10))])";
        let mut session = Session::new(Scene::parse("thin", text).expect("a good scene"), Options::default());
        let reach = |session: &Session| session.visible_labels()[0].reach;
        assert!((reach(&session) - 18.0).abs() < 1e-9, "{}", reach(&session));
        let mast = session.sim.bodies[0];
        session
            .sim
            .world
            .entity_mut(mast)
            .insert(Orientation(DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2)));
        assert!((reach(&session) - 180.0).abs() < 1e-9, "{}", reach(&session));
        let (_, ring) = session.label(mast, "", around).expect("it is in the picture");
        assert!((ring.reach - 180.0).abs() < 1e-9);
    }

    #[test]
    fn the_label_of_a_removed_body_is_gone_and_others_stay_after_a_reset() {
        let mut session = session();
        let ahead = session.sim.bodies[0];
        session.ask(motion::Request::Remove(ahead));
        session.carry_out_requests();
        assert_eq!(session.visible_labels().len(), 1);
        session.reset_world();
        assert_eq!(session.visible_labels().len(), 2);
    }

    #[test]
    fn a_label_is_drawn_with_the_panels_of_the_frame() {
        let mut session = session();
        let words = |session: &mut Session, total: f64| {
            let time = motion::clock::FrameClock::default().advance_to(total).expect("a time");
            let frame = session.frame(&crate::input::InputFrame::NOTHING, time);
            let triangles = |primitive: &egui::ClippedPrimitive| match &primitive.primitive {
                egui::epaint::Primitive::Mesh(mesh) => mesh.indices.len(),
                egui::epaint::Primitive::Callback(_) => 0,
            };
            frame.panels.expect("a session with pictures").primitives.iter().map(triangles).sum::<usize>()
        };
        let labelled = words(&mut session, 0.0);
        session.labels.clear();
        assert!(words(&mut session, 0.0) < labelled);
    }

    #[test]
    fn a_reset_and_another_scene_have_no_frozen_bodies_and_a_run_keeps_all() {
        let mut session = session();
        let mut clock = motion::clock::FrameClock::default();
        let mut nan = |session: &mut Session| {
            let push = crate::input::Experiment::Push("ahead".to_owned(), [f64::NAN, 0.0, 0.0]);
            let input = [crate::input::Input::Experiment(push)].into_iter().collect();
            session.advance(&input, clock.advance_by(1.0 / 60.0).expect("a time"));
            let names: Vec<_> = session.frozen().iter().map(|frozen| frozen.body.as_str()).collect();
            assert_eq!(names, ["ahead"]);
            let body = session.body("ahead").expect("it is there");
            let why = session.frozen_because(body).expect("it is frozen");
            assert!(why.ends_with(" by integrate_acceleration"), "{why}");
        };
        nan(&mut session);
        session.reset_world();
        assert!(session.frozen().is_empty());
        assert_eq!(session.quarantined().len(), 1);
        nan(&mut session);
        session.open(session.scene().clone());
        assert!(session.frozen().is_empty());
        nan(&mut session);
        assert_eq!(session.all_quarantined().len(), 3);
    }

    #[test]
    fn the_body_that_goes_wrong_is_marked_while_the_run_stands_beside_that() {
        let mut session = session();
        session.keep_timeline();
        let mut clock = motion::clock::FrameClock::default();
        let mut frame = |session: &mut Session, input: crate::input::InputFrame| {
            session.advance(&input, clock.advance_by(1.0 / 60.0).expect("a time"));
        };
        let push = crate::input::Experiment::Push("ahead".to_owned(), [f64::NAN, 0.0, 0.0]);
        assert!(session.fault_mark().is_none());
        frame(&mut session, [crate::input::Input::Experiment(push)].into_iter().collect());
        let mark = session.fault_mark().expect("a mark");
        assert_eq!(mark.text, "ahead goes wrong in the next tick");
        assert!((mark.at - DVec2::new(640.0, 360.0)).length() < 1e-9 && (mark.reach - 72.0).abs() < 1e-9);
        session.seek(1);
        assert_eq!(session.fault_mark().expect("a mark").text, "ahead went wrong in this tick");
        session.control.paused = false;
        assert!(session.fault_mark().is_none());
    }
}
