//! A pinch on a touch pad, which macOS reports as a magnification, as two fingers on the view.

use winit::dpi::PhysicalPosition;
use winit::event::TouchPhase as Phase;

use cockpit::input::{Input, TouchPhase};

/// Distance of the fingers at the start, pixels.
const APART_PX: f64 = 200.0;

/// Names of the two fingers: no screen has as many.
const FINGERS: [u64; 2] = [u64::MAX - 1, u64::MAX];

/// The pinch that is under way.
#[derive(Debug, Default)]
pub(super) struct Pinch {
    apart: f64,
    middle: PhysicalPosition<f64>,
    /// Where the pointer is.
    pub pointer: PhysicalPosition<f64>,
}

impl Pinch {
    /// The fingers' input for a magnification by 1 + `delta` around the place where the pointer was at its start.
    pub fn magnified(&mut self, delta: f64, phase: Phase) -> [Input; 2] {
        if phase == Phase::Started {
            (self.apart, self.middle) = (APART_PX, self.pointer);
        }
        // Fingers do not pass each other, whatever a pad reports.
        self.apart *= (1.0 + delta).max(0.1);
        let PhysicalPosition { x, y } = self.middle;
        let half = 0.5 * self.apart;
        [(FINGERS[0], x - half), (FINGERS[1], x + half)]
            .map(|(finger, x)| Input::Touch(finger, named(phase), x, y))
    }
}

/// The phase of a touch, as inputs name it.
pub(super) const fn named(phase: Phase) -> TouchPhase {
    match phase {
        Phase::Started => TouchPhase::Down,
        Phase::Moved => TouchPhase::Move,
        Phase::Ended => TouchPhase::Up,
        Phase::Cancelled => TouchPhase::Cancel,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fingers_move_apart_by_the_magnification_around_the_pointer() {
        let pointer = PhysicalPosition::new(400.0, 300.0);
        let mut pinch = Pinch { pointer, ..Pinch::default() };
        let mut places = |delta, phase| format!("{:?}", pinch.magnified(delta, phase));
        let both = |phase, [one, other]: [f64; 2]| {
            let places = [(FINGERS[0], one), (FINGERS[1], other)];
            format!("{:?}", places.map(|(finger, x)| Input::Touch(finger, phase, x, 300.0)))
        };
        assert_eq!(places(0.0, Phase::Started), both(TouchPhase::Down, [300.0, 500.0]));
        assert_eq!(places(0.5, Phase::Moved), both(TouchPhase::Move, [250.0, 550.0]));
        assert_eq!(places(-0.5, Phase::Moved), both(TouchPhase::Move, [325.0, 475.0]));
        assert_eq!(places(0.0, Phase::Ended), both(TouchPhase::Up, [325.0, 475.0]));
    }
}
