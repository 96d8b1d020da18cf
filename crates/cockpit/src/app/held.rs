//! Held keys, and how they fly the camera and push.

use glam::DVec3;

use crate::actions::Hold;
use crate::input::Key;

/// Force of a held push key, N.
const KEY_PUSH: f64 = 10.0;

/// Shift that is held for less than this before another key, s, only modifies that key and does not fly the camera.
const CHORD_S: f64 = 0.5;

/// A key and what it does while it is held.
type HeldKey = (Key, Hold);

/// A key that pushes.
#[derive(Clone, Debug)]
struct Pusher {
    key: HeldKey,
    /// When it went down, s of frame time; negative infinity if unknown: it acts from the next tick on.
    down: f64,
    /// When it came up, s of frame time; negative infinity if unknown: it acts no more.
    up: Option<f64>,
    /// Whether it acted in a tick.
    acted: bool,
}

impl Pusher {
    /// Whether it acts in the tick that ends at `due`, s, known to within `nearly` s. It acts in every tick that ends while it is
    /// held, and in one tick if it is held for less.
    fn acts(&self, due: f64, nearly: f64) -> bool {
        let is_held = self.up.is_none_or(|up| due <= up + nearly);
        due > self.down + nearly && (is_held || !self.acted)
    }
}

/// Keys that act as long as they are held.
#[derive(Clone, Debug, Default)]
pub(crate) struct Held {
    keys: Vec<HeldKey>,
    /// Keys that went down in this frame.
    pressed: Vec<HeldKey>,
    /// Keys that went down and came up in this frame: they fly for the whole frame.
    tapped: Vec<HeldKey>,
    pushers: Vec<Pusher>,
    /// How long shift has moved the camera since it went down, s.
    shifted_s: f64,
}

impl Held {
    pub const fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// Presses a key. `at` is when, and `until` when its push ends, s of frame time, if known.
    pub fn press(&mut self, key: &Key, hold: Hold, at: Option<f64>, until: Option<f64>) {
        let held = (key.clone(), hold);
        if self.keys.contains(&held) {
            for pusher in self.pushers.iter_mut().filter(|pusher| pusher.key == held) {
                pusher.up = pusher.up.zip(until).map(|(up, until)| up.max(until)).or(pusher.up);
            }
            return;
        }
        if is_shift(&held) {
            self.shifted_s = 0.0;
        }
        if let Hold::Push(_) = hold {
            let down = at.unwrap_or(f64::NEG_INFINITY);
            self.pushers.push(Pusher { key: held.clone(), down, up: until, acted: false });
        }
        self.keys.push(held.clone());
        self.pressed.push(held);
    }

    /// Releases a key. `at` is when, s of frame time, if known.
    pub fn release(&mut self, key: &Key, at: Option<f64>) {
        // By name: the control or the shift key may have gone down or up since the key did.
        let same = |(other, _): &HeldKey| other.name() == key.name();
        if let Some(at) = self.pressed.iter().position(same) {
            self.tapped.push(self.pressed.remove(at));
        }
        for pusher in self.pushers.iter_mut().filter(|pusher| same(&pusher.key)) {
            pusher.up.get_or_insert(at.unwrap_or(f64::NEG_INFINITY));
        }
        self.keys.retain(|held| !same(held));
    }

    pub fn release_all(&mut self) {
        *self = Self::default();
    }

    /// Treats a held shift as a modifier of another key. Returns how long it has moved the camera by mistake, s: 0 if it was held
    /// for [`CHORD_S`] or longer.
    pub fn take_shift(&mut self) -> f64 {
        if !self.keys.iter().any(is_shift) || self.shifted_s >= CHORD_S {
            return 0.0;
        }
        self.keys.retain(|key| !is_shift(key));
        self.pressed.retain(|key| !is_shift(key));
        std::mem::take(&mut self.shifted_s)
    }

    /// The direction in which the camera flies in a frame of `seconds`: right, up and forward, each -1, 0 or 1. Call it after all
    /// input of the frame.
    pub fn flight(&mut self, seconds: f64) -> DVec3 {
        self.pressed.clear();
        let tapped = std::mem::take(&mut self.tapped);
        let direction = sum(self.keys.iter().chain(&tapped), |hold| match hold {
            Hold::Fly(along) => Some(along),
            Hold::Push(_) | Hold::SelectImmovable | Hold::ChangeForce => None,
        });
        if direction.y < 0.0 {
            self.shifted_s += seconds;
        }
        direction
    }

    /// The number of keys that push.
    pub const fn pushing(&self) -> usize {
        self.pushers.len()
    }

    /// The push in the tick that ends at `due`, s of frame time, N. Call it once per tick, in order.
    pub fn push(&mut self, due: f64, nearly: f64) -> DVec3 {
        let mut acting: Vec<HeldKey> = Vec::new();
        for pusher in &mut self.pushers {
            // Of several taps of a key before one tick, each acts in a tick of its own.
            if pusher.acts(due, nearly) && !acting.contains(&pusher.key) {
                pusher.acted = true;
                acting.push(pusher.key.clone());
            }
        }
        let along = sum(acting.iter(), |hold| match hold {
            Hold::Push(along) => Some(along),
            Hold::Fly(_) | Hold::SelectImmovable | Hold::ChangeForce => None,
        });
        self.pushers.retain(|pusher| !pusher.acted || pusher.up.is_none_or(|up| up > due));
        along * KEY_PUSH
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

fn is_shift((key, _): &HeldKey) -> bool {
    key.name() == "Shift"
}

/// Sums the directions of `keys`. A key that is held and tapped counts once; opposite keys cancel.
fn sum<'a>(
    keys: impl Iterator<Item = &'a HeldKey>,
    along: impl Fn(Hold) -> Option<DVec3>,
) -> DVec3 {
    let mut holds: Vec<Hold> = Vec::new();
    for (_, hold) in keys {
        if !holds.contains(hold) {
            holds.push(*hold);
        }
    }
    holds.into_iter().filter_map(along).sum()
}
