//! Held keys, and what they steer.

use glam::DVec3;

use crate::actions::Hold;
use crate::input::Key;

/// Newtons of a held push key.
const KEY_PUSH: f64 = 10.0;

/// A shift key that is held for less than this, s, before a key that it modifies does not fly.
const CHORD_S: f64 = 0.5;

/// A key and what it does while it is held.
type HeldKey = (Key, Hold);

/// Keys that went down and up before what they steer could see them.
pub(crate) struct Tapped {
    /// Within one frame: they fly for that frame.
    pub in_frame: Vec<HeldKey>,
    /// With no tick between: they push for one tick, as a click does.
    pub between_ticks: Vec<HeldKey>,
}

/// The taps of a span of time.
#[derive(Clone, Debug, Default)]
struct Taps {
    /// Keys that went down in it.
    pressed: Vec<HeldKey>,
    /// Those of them that came up in it, too.
    tapped: Vec<HeldKey>,
}

impl Taps {
    fn release(&mut self, same: impl Fn(&HeldKey) -> bool) {
        if let Some(at) = self.pressed.iter().position(same) {
            self.tapped.push(self.pressed.remove(at));
        }
    }
}

/// Keys that act as long as they are held.
#[derive(Clone, Debug, Default)]
pub(crate) struct Held {
    keys: Vec<HeldKey>,
    /// Those of this frame.
    in_frame: Taps,
    /// Those since the last tick.
    between_ticks: Taps,
    /// How long shift has moved the camera since it went down, s.
    shifted_s: f64,
}

impl Held {
    pub const fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    pub fn press(&mut self, key: &Key, hold: Hold) {
        if !self.keys.iter().any(|(other, _)| other == key) {
            let held = (key.clone(), hold);
            if is_shift(&held) {
                self.shifted_s = 0.0;
            }
            self.keys.push(held.clone());
            self.in_frame.pressed.push(held.clone());
            self.between_ticks.pressed.push(held);
        }
    }

    pub fn release(&mut self, key: &Key) {
        // By name: the control or the shift key may have gone down or up since the key did.
        let same = |(other, _): &HeldKey| other.name() == key.name();
        self.in_frame.release(same);
        self.between_ticks.release(same);
        self.keys.retain(|held| !same(held));
    }

    pub fn release_all(&mut self) {
        *self = Self::default();
    }

    /// Takes shift for a part of another key; how long it has moved the camera, s, which was not meant.
    pub fn take_shift(&mut self) -> f64 {
        if !self.keys.iter().any(is_shift) || self.shifted_s >= CHORD_S {
            return 0.0;
        }
        self.keys.retain(|key| !is_shift(key));
        self.in_frame.pressed.retain(|key| !is_shift(key));
        self.between_ticks.pressed.retain(|key| !is_shift(key));
        std::mem::take(&mut self.shifted_s)
    }

    /// Ends the input of a frame. Returns the keys that were only tapped in it: each acts once.
    pub fn end_input(&mut self) -> Tapped {
        self.in_frame.pressed.clear();
        Tapped {
            in_frame: std::mem::take(&mut self.in_frame.tapped),
            between_ticks: std::mem::take(&mut self.between_ticks.tapped),
        }
    }

    /// A tick begins: it sees the keys that are held now.
    pub fn begin_tick(&mut self) {
        self.between_ticks.pressed.clear();
    }

    /// Where the camera flies in a frame of `seconds`: right, up and forward, each -1, 0 or 1.
    pub fn flight(&mut self, tapped: &[HeldKey], seconds: f64) -> DVec3 {
        let direction = sum(&[&self.keys, tapped].concat(), |hold| match hold {
            Hold::Fly(along) => Some(along),
            _ => None,
        });
        if direction.y < 0.0 {
            self.shifted_s += seconds;
        }
        direction
    }

    /// The push of the held keys, N.
    pub fn push(&self) -> DVec3 {
        push(&self.keys)
    }

    /// Whether a key is held that lets clicks select what cannot be moved.
    pub fn selects_immovable(&self) -> bool {
        self.keys.iter().any(|(_, hold)| matches!(hold, Hold::SelectImmovable | Hold::ChangeForce))
    }

    /// Whether a key is held that lets the wheel change the force of a click.
    pub fn changes_force(&self) -> bool {
        self.keys.iter().any(|(_, hold)| *hold == Hold::ChangeForce)
    }
}

/// The push of `keys`, N.
pub(crate) fn push(keys: &[HeldKey]) -> DVec3 {
    let along = sum(keys, |hold| match hold {
        Hold::Push(along) => Some(along),
        _ => None,
    });
    along * KEY_PUSH
}

fn is_shift((key, _): &HeldKey) -> bool {
    key.name() == "Shift"
}

/// The sum of what `keys` do, where a key that is held and tapped counts once: of two opposite ones, 0.
fn sum(keys: &[HeldKey], along: impl Fn(Hold) -> Option<DVec3>) -> DVec3 {
    let mut holds: Vec<Hold> = Vec::new();
    for (_, hold) in keys {
        if !holds.contains(hold) {
            holds.push(*hold);
        }
    }
    holds.into_iter().filter_map(along).sum()
}
