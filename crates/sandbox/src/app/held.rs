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

/// A key that pushes.
#[derive(Clone, Debug)]
struct Pusher {
    key: HeldKey,
    /// When it went down and came up, s of the clock of frames; negative infinity without a time: it acts from the next tick on,
    /// or no more.
    down: f64,
    up: Option<f64>,
    /// Whether it acted in a tick.
    acted: bool,
}

impl Pusher {
    /// Whether it acts in the tick that ends at `due`, s, up to `nearly` seconds: in each that ends while it is held, and in
    /// one where it is held for less.
    fn acts(&self, due: f64, nearly: f64) -> bool {
        let is_held = self.up.is_none_or(|up| due <= up + nearly);
        due > self.down + nearly && (is_held || !self.acted)
    }
}

/// Keys that act as long as they are held.
#[derive(Clone, Debug, Default)]
pub(crate) struct Held {
    keys: Vec<HeldKey>,
    /// Those that went down in this frame.
    pressed: Vec<HeldKey>,
    /// Those of them that came up in it, too: they fly for it.
    tapped: Vec<HeldKey>,
    pushers: Vec<Pusher>,
    /// How long shift has moved the camera since it went down, s.
    shifted_s: f64,
}

impl Held {
    pub const fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// A key goes down, at a time and with an end of what it pushes, s of the clock of frames, if they are known.
    pub fn press(&mut self, key: &Key, hold: Hold, [at, until]: [Option<f64>; 2]) {
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

    /// A key comes up.
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

    /// Takes shift for a part of another key; how long it has moved the camera, s, which was not meant.
    pub fn take_shift(&mut self) -> f64 {
        if !self.keys.iter().any(is_shift) || self.shifted_s >= CHORD_S {
            return 0.0;
        }
        self.keys.retain(|key| !is_shift(key));
        self.pressed.retain(|key| !is_shift(key));
        std::mem::take(&mut self.shifted_s)
    }

    /// Where the camera flies in a frame of `seconds`, whose input is complete: right, up and forward, each -1, 0 or 1.
    pub fn flight(&mut self, seconds: f64) -> DVec3 {
        self.pressed.clear();
        let tapped = std::mem::take(&mut self.tapped);
        let direction = sum(self.keys.iter().chain(&tapped), |hold| match hold {
            Hold::Fly(along) => Some(along),
            _ => None,
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

    /// The push in the tick that ends at `due`, s of the clock of frames, N. Each tick once, in their order.
    pub fn push(&mut self, due: f64, nearly: f64) -> DVec3 {
        let acting = self.pushers.iter().filter(|pusher| pusher.acts(due, nearly));
        let along = sum(acting.map(|pusher| &pusher.key), |hold| match hold {
            Hold::Push(along) => Some(along),
            _ => None,
        });
        for pusher in &mut self.pushers {
            pusher.acted |= pusher.acts(due, nearly);
        }
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

/// The sum of what `keys` do, where a key that is held and tapped counts once: of two opposite ones, 0.
fn sum<'a>(keys: impl Iterator<Item = &'a HeldKey>, along: impl Fn(Hold) -> Option<DVec3>) -> DVec3 {
    let mut holds: Vec<Hold> = Vec::new();
    for (_, hold) in keys {
        if !holds.contains(hold) {
            holds.push(*hold);
        }
    }
    holds.into_iter().filter_map(along).sum()
}
