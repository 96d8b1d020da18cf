//! Fingers on a touch screen, as a pointer and as gestures of two.

use glam::DVec2;

use crate::input::TouchPhase;

/// Something that fingers do; places and ways in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Gesture {
    /// The pointer moves to a place, by that way.
    Move { to: DVec2, by: DVec2 },
    /// A finger has rested for long: the right button goes down and comes up.
    Hold,
    /// The left button goes down.
    Press,
    /// The left button comes up.
    Release,
    /// What the left button began is given up.
    LetGo,
    /// Two fingers that keep their distance moved.
    Orbit(DVec2),
    /// Two fingers that changed their distance moved, and are `times` as far apart.
    Pinch { by: DVec2, times: f64 },
}

/// What the fingers on the screen do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Doing {
    /// The first finger may be a click, a drag or the first of two.
    #[default]
    Waits,
    /// It holds the left button.
    Presses,
    /// Two fingers have not moved yet; the way of their middle and the change of their distance since they came down.
    Two(DVec2, f64),
    Orbits,
    Pinches,
    /// One of two fingers was lifted.
    Ends,
}

/// Time after which a finger that rests is a click of the right button, s.
const HOLD_S: f64 = 0.5;

/// The fingers on the screen.
#[derive(Default)]
pub(crate) struct Fingers {
    /// Numbers and places, at most two, in the order in which they came down.
    down: Vec<(u64, DVec2)>,
    doing: Doing,
    /// Time for which the first finger has waited, s; `None` in the frame in which it came down, however long that was.
    waited: Option<f64>,
}

impl Fingers {
    /// Whether a finger is on the screen.
    pub const fn any(&self) -> bool {
        !self.down.is_empty()
    }

    /// Whether a finger rests that will become a click of the right button.
    pub fn waits(&self) -> bool {
        self.any() && self.doing == Doing::Waits
    }

    /// What the fingers do because `seconds` have passed.
    pub fn rest(&mut self, seconds: f64) -> Option<Gesture> {
        let waited = self.waited.map_or(0.0, |waited| waited + seconds);
        self.waited = Some(waited);
        let held = self.waits() && waited >= HOLD_S;
        held.then(|| {
            self.doing = Doing::Ends;
            Gesture::Hold
        })
    }

    /// The middle of the fingers and the distance between two, pixels.
    pub fn span(&self) -> (DVec2, f64) {
        match self.down[..] {
            [(_, first), (_, second)] => ((first + second) / 2.0, first.distance(second)),
            _ => self.down.first().map_or((DVec2::ZERO, 0.0), |(_, place)| (*place, 0.0)),
        }
    }

    /// Takes the motion of a finger to the pixel `at`. A press is held back until the finger moves by more than `click` pixels or
    /// is lifted, unless it is on a panel, because two fingers never come down at once.
    pub fn take(
        &mut self,
        finger: u64,
        phase: TouchPhase,
        at: DVec2,
        on_panel: bool,
        click: f64,
    ) -> Vec<Gesture> {
        let place = self.down.iter().position(|(other, _)| *other == finger);
        match (phase, place) {
            (TouchPhase::Down, None) if self.down.is_empty() => {
                self.down.push((finger, at));
                self.waited = None;
                self.doing = if on_panel { Doing::Presses } else { Doing::Waits };
                if on_panel { vec![Gesture::Press] } else { Vec::new() }
            }
            (TouchPhase::Down, None) if self.down.len() == 1 && !on_panel => {
                self.down.push((finger, at));
                let before = std::mem::replace(&mut self.doing, Doing::Two(DVec2::ZERO, 0.0));
                if before == Doing::Presses { vec![Gesture::LetGo] } else { Vec::new() }
            }
            (TouchPhase::Move, Some(place)) => self.slide(place, at, click),
            (TouchPhase::Up | TouchPhase::Cancel, Some(place)) => {
                self.down.remove(place);
                let lifted = phase == TouchPhase::Up;
                match std::mem::replace(&mut self.doing, Doing::Ends) {
                    Doing::Waits if lifted => vec![Gesture::Press, Gesture::Release],
                    Doing::Presses if lifted => vec![Gesture::Release],
                    Doing::Presses => vec![Gesture::LetGo],
                    Doing::Waits
                    | Doing::Two(..)
                    | Doing::Orbits
                    | Doing::Pinches
                    | Doing::Ends => Vec::new(),
                }
            }
            _ => Vec::new(),
        }
    }

    fn slide(&mut self, place: usize, at: DVec2, click: f64) -> Vec<Gesture> {
        let (middle, apart) = self.span();
        let before = std::mem::replace(&mut self.down[place].1, at);
        let (to, wide) = self.span();
        let by = to - middle;
        match self.doing {
            Doing::Waits if before.distance(at) <= click => {
                self.down[place].1 = before;
                Vec::new()
            }
            Doing::Waits => {
                self.doing = Doing::Presses;
                vec![Gesture::Press, Gesture::Move { to: at, by }]
            }
            Doing::Presses => vec![Gesture::Move { to: at, by }],
            Doing::Two(way, change) => {
                let (way, change) = (way + by, change + wide - apart);
                self.doing = match way.length().max(change.abs()) <= click {
                    true => Doing::Two(way, change),
                    false if way.length() >= change.abs() => Doing::Orbits,
                    false => Doing::Pinches,
                };
                Vec::new()
            }
            Doing::Orbits => vec![Gesture::Orbit(by)],
            Doing::Pinches if apart > 0.0 && wide > 0.0 => {
                vec![Gesture::Pinch { by, times: wide / apart }]
            }
            Doing::Pinches | Doing::Ends => Vec::new(),
        }
    }
}
