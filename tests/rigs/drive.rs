//! A session that is driven by literal input, frame by frame, without a window or a device.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use motion::{Method, PhysicsBody, Transform};
use sandbox::clock::FrameClock;
use sandbox::input::{Button, Input, InputFrame};
use sandbox::{Control, Options, Session};
use scene::{ChangeAction, Scene};

use super::{H, scene_of};

/// Size of the picture, pixels.
pub const SIZE: DVec2 = DVec2::new(1280.0, 720.0);

/// A session and the clock of its frames.
pub struct Drive {
    pub session: Session,
    pub clock: FrameClock,
}

impl Drive {
    pub fn of(scene: Scene) -> Self {
        Self::with(scene, Options { pictures: false, interpolate: true, ..Options::default() })
    }

    pub fn with(scene: Scene, options: Options) -> Self {
        Self { session: Session::new(scene, options), clock: FrameClock::default() }
    }

    /// The scene that `text` describes.
    pub fn text(text: &str) -> Self {
        Self::of(scene_of(text))
    }

    /// A shipped scene.
    pub fn shipped(name: &str) -> Self {
        Self::of(scene::load(name).unwrap())
    }

    pub fn tutorial() -> Self {
        Self::shipped("tutorial")
    }

    /// A scene of these bodies, with pushes, without gravity and damping, seen from the origin along -z.
    pub fn bodies(bodies: &str) -> Self {
        let text = format!(
            "(version: 1, push: (), camera: (position_m: (0, 0, 0), pitch_deg: 0, yaw_deg: 0), bodies: [{bodies}])"
        );
        Self::text(&text)
    }

    /// With a timeline.
    pub fn recording(mut self) -> Self {
        self.session.stage.keep_timeline();
        self
    }

    /// One frame of `length` seconds.
    pub fn frame(&mut self, length: f64, events: impl IntoIterator<Item = Input>) -> &mut Self {
        let time = self.clock.advance_by(length).unwrap();
        self.session.advance(&events.into_iter().collect(), time);
        self
    }

    /// `frames` frames without input.
    pub fn run(&mut self, frames: u32, length: f64) -> &mut Self {
        for _ in 0..frames {
            self.frame(length, []);
        }
        self
    }

    /// The same at 60 frames a second.
    pub fn frames(&mut self, frames: u32) -> &mut Self {
        self.run(frames, 1.0 / 60.0)
    }

    /// Ticks of the tutorial's length, a frame each.
    pub fn ticks(&mut self, ticks: u32) -> &mut Self {
        self.run(ticks, H)
    }

    /// Input in a frame that takes no time.
    pub fn give(&mut self, events: impl IntoIterator<Item = Input>) -> &mut Self {
        self.frame(0.0, events)
    }

    /// A key goes down and up in a frame that takes no time.
    pub fn press(&mut self, key: &str) -> &mut Self {
        self.give(tap(key))
    }

    /// Puts the pointer there and clicks, in a frame that takes no time.
    pub fn click(&mut self, button: Button, pixel: DVec2) -> &mut Self {
        self.give([at(pixel)].into_iter().chain(click(button)))
    }

    /// What a left click at `pixel` selects, by name.
    pub fn select(&mut self, pixel: DVec2) -> Option<String> {
        self.click(Button::Left, pixel);
        self.selected()
    }

    /// The first control that `is` so. The first call of [`Session::controls`] must be frames ago.
    #[track_caller]
    pub fn find(&self, is: impl FnMut(&Control) -> bool) -> Control {
        let mut controls = self.session.controls();
        let found = controls.iter().position(is);
        controls.swap_remove(found.unwrap_or_else(|| panic!("not among {controls:#?}")))
    }

    /// The control of that name, which is no label.
    #[track_caller]
    pub fn control(&self, name: &str) -> Control {
        assert!(self.has(name), "no {name} among {:#?}", self.session.controls());
        self.find(|control| control.name == name && control.role != "Label")
    }

    /// Whether there is a control of that name, which is no label.
    pub fn has(&self, name: &str) -> bool {
        self.session
            .controls()
            .iter()
            .any(|control| control.name == name && control.role != "Label")
    }

    /// Clicks the control of that name.
    #[track_caller]
    pub fn click_on(&mut self, name: &str) -> &mut Self {
        let middle = middle(&self.control(name));
        self.frame(H, [at(middle)]).frame(H, click(Button::Left)).ticks(2)
    }

    /// Name of the selection.
    pub fn selected(&self) -> Option<String> {
        self.session.stage.selection().map(|thing| self.session.stage.name(thing))
    }

    /// Where the camera of the session shows `point`.
    pub fn pixel(&self, point: DVec3) -> DVec2 {
        self.session.view.camera().viewpoint().project(point, SIZE).unwrap()
    }

    pub fn entity(&self, name: &str) -> Entity {
        self.session.stage.sim().named(name).unwrap()
    }

    pub fn x(&self, name: &str) -> DVec3 {
        self.session.stage.sim().world.get::<Transform>(self.entity(name)).unwrap().position
    }

    pub fn v(&self, name: &str) -> DVec3 {
        self.session.stage.sim().world.get::<PhysicsBody>(self.entity(name)).unwrap().velocity
    }

    /// The state's hash.
    pub fn hash(&self) -> u64 {
        sandbox::report::state_hash(&self.session.stage)
    }

    /// Hashes of the states after every tick of a frame.
    pub fn visited(&mut self, length: f64, events: impl IntoIterator<Item = Input>) -> Vec<u64> {
        let time = self.clock.advance_by(length).unwrap();
        let input: InputFrame = events.into_iter().collect();
        let mut hashes = Vec::new();
        self.session.advance_watched(&input, time, &mut |session, _| {
            hashes.push(sandbox::report::state_hash(session));
            std::ops::ControlFlow::Continue(())
        });
        hashes
    }
}

pub fn down(key: &str) -> Input {
    Input::KeyDown(key.parse().unwrap())
}

pub fn up(key: &str) -> Input {
    Input::KeyUp(key.parse().unwrap())
}

pub fn tap(key: &str) -> [Input; 2] {
    [down(key), up(key)]
}

/// A push, named and in newtons, for one tick.
pub fn push(body: &str, newtons: impl Into<[f64; 3]>) -> Input {
    Input::Change(ChangeAction::Push(body.to_owned(), DVec3::from_array(newtons.into())))
}

pub fn change(body: &str, action: fn(String, DVec3) -> ChangeAction, value: [f64; 3]) -> Input {
    Input::Change(action(body.to_owned(), DVec3::from_array(value)))
}

pub fn remove(body: &str) -> Input {
    Input::Change(ChangeAction::Remove(body.to_owned()))
}

pub fn own_method(body: &str, method: Method) -> Input {
    Input::Change(ChangeAction::SetBodyMethod(body.to_owned(), method))
}

/// The pointer at a pixel.
pub fn at(pixel: DVec2) -> Input {
    Input::Mouse(pixel.x, pixel.y)
}

pub fn click(button: Button) -> [Input; 2] {
    [Input::ButtonDown(button), Input::ButtonUp(button)]
}

/// The middle of a control, pixels.
pub fn middle(control: &Control) -> DVec2 {
    let [left, top, right, bottom] = control.rect_px;
    DVec2::new(left + right, top + bottom) / 2.0
}

/// Clicks the number `step_hz` of the settings, whose controls have names, which makes it a text field.
pub fn write_step_hz(drive: &mut Drive) {
    assert!(drive.click_on("Hz").session.takes_text());
}
