//! Words beside bodies: where in the picture they stand.

use bevy_ecs::entity::Entity;
use glam::{DQuat, DVec2, DVec3};
use motion::Orientation;
use pick::Shape;

use crate::stage::Stage;
use crate::view::View;

/// A body's words in the picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Label {
    /// Place of the middle of the body, pixels from the top left.
    pub at: DVec2,
    /// How far from there the body reaches, pixels: to the side where the words are or, for a ring around it, at most.
    pub reach: f64,
    pub text: String,
}

/// How far a shape reaches from its middle, m, in a direction of its own axes.
type Reach = fn(&Shape, DVec3) -> f64;

/// Distance to the surface of a shape in that direction, m, so that the words of a thin body are beside it.
fn beside(shape: &Shape, direction: DVec3) -> f64 {
    match shape {
        Shape::Cuboid { half_extents } => (*half_extents / direction.abs()).min_element(),
        Shape::Sphere { radius } => *radius,
    }
}

/// Greatest half extent of a shape, m, whatever the direction.
pub(crate) fn around(shape: &Shape, _: DVec3) -> f64 {
    shape.half_extents().max_element()
}

impl View {
    /// The labels of the bodies whose middle is in the picture, the farthest first.
    pub(crate) fn visible_labels(&self, stage: &Stage) -> Vec<Label> {
        let labels = self.labels.iter();
        let mut seen: Vec<_> = labels
            .filter_map(|(id, text)| {
                self.label(stage, *stage.sim().bodies.get(*id as usize)?, text, beside)
            })
            .collect();
        seen.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        seen.into_iter().map(|(_, label)| label).collect()
    }

    /// The mark of the body at fault, while the run is paused.
    pub(crate) fn fault_mark(&self, stage: &Stage) -> Option<Label> {
        let fault = stage.recorder().fault().filter(|_| stage.playback().paused())?;
        let words = match stage.sim().ticks().checked_sub(fault.tick) {
            None if stage.sim().ticks() + 1 == fault.tick => {
                "goes wrong in the next tick".to_owned()
            }
            Some(0) => "went wrong in this tick".to_owned(),
            _ => format!("goes wrong at {}", stage.times().words(fault.tick)),
        };
        let body = *stage.sim().bodies.get(fault.body? as usize)?;
        let label = self.label(stage, body, &format!("{} {words}", stage.name(body)), around);
        label.map(|(_, label)| label)
    }

    /// The distance of a thing, m, and its label, if its middle is in the picture.
    pub(crate) fn label(
        &self,
        stage: &Stage,
        thing: Entity,
        text: &str,
        reach: Reach,
    ) -> Option<(f64, Label)> {
        let view = self.viewpoint();
        let place = stage.drawn_position(thing)?;
        let distance = (place - view.position).dot(view.forward());
        let drawn = (view.near_m..=view.far_m).contains(&distance);
        let (at, inside) = self.seen_at(place).filter(|_| drawn)?;
        let turned =
            stage.sim().world.get::<Orientation>(thing).map_or(DQuat::IDENTITY, |turned| turned.0);
        let reach = stage
            .sim()
            .world
            .get::<Shape>(thing)
            .map_or(0.0, |shape| reach(shape, turned.inverse() * view.right()));
        let (side, _) = self.seen_at(place + view.right() * reach)?;
        inside.then(|| (distance, Label { at, reach: side.distance(at), text: text.to_owned() }))
    }
}
