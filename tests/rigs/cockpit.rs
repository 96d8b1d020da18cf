//! A session with the cockpit, which is driven by the names of its controls.

use glam::{DVec2, DVec3};
use pick::Viewpoint;
use sandbox::input::{Button, Input};
use sandbox::{Control, Options, Order, Overrides, Session};

use super::{Drive, at, middle};

/// A session with the cockpit, whose controls have names.
pub struct Cockpit {
    pub drive: Drive,
}

impl Cockpit {
    pub fn of(scene: &str, size_px: [u32; 2]) -> Self {
        Self::with(scene, size_px, Overrides::default())
    }

    pub fn with(scene: &str, size_px: [u32; 2], overrides: Overrides) -> Self {
        let options = Options {
            pictures: false,
            interpolate: true,
            size_px,
            overrides,
            ..Options::default()
        };
        let mut drive = Drive::with(scene::load(scene).unwrap(), options);
        let _ = drive.session.controls();
        drive.press("F10").ticks(3);
        Self { drive }
    }

    pub fn session(&self) -> &Session {
        &self.drive.session
    }

    pub fn has(&self, name: &str) -> bool {
        self.drive.has(name)
    }

    /// The middle of the control of that name, pixels.
    #[track_caller]
    pub fn middle_of(&self, name: &str) -> DVec2 {
        middle(&self.drive.control(name))
    }

    /// Clicks the control of that name.
    #[track_caller]
    pub fn click(&mut self, name: &str) {
        self.drive.click_on(name);
    }

    /// The table that is ordered to be saved.
    #[track_caller]
    pub fn saved_table(&mut self) -> String {
        let orders = self.drive.session.stage.take_orders();
        let [Order::Table(table)] = &orders[..] else { panic!("{orders:?}") };
        table.clone()
    }

    /// Drags with `button` from one pixel to another, over some frames.
    pub fn drag(&mut self, button: Button, from: DVec2, to: DVec2) {
        self.drive.give([at(from), Input::ButtonDown(button)]);
        for step in 1..=10 {
            self.drive.give([at(from.lerp(to, f64::from(step) / 10.0))]);
        }
        self.drive.give([Input::ButtonUp(button)]);
    }

    /// The view's corner and size, pixels.
    pub fn view(&self) -> [DVec2; 2] {
        self.session().view.view_area()
    }

    /// Where a place is seen, pixels.
    pub fn pixel(&self, place: DVec3) -> DVec2 {
        let [corner, size] = self.view();
        corner + self.viewpoint().project(place, size).unwrap()
    }

    pub fn viewpoint(&self) -> Viewpoint {
        self.session().view.viewpoint()
    }

    /// Where a body is seen, pixels.
    pub fn seen(&self, body: &str) -> DVec2 {
        self.pixel(self.drive.x(body))
    }

    /// The control that has the keyboard.
    pub fn focused(&self) -> Option<Control> {
        self.session().controls().into_iter().find(|control| control.focused)
    }

    pub fn press(&mut self, key: &str) -> &mut Self {
        self.drive.press(key).ticks(3);
        self
    }

    /// Presses `key` until the control of that name has the keyboard.
    pub fn go_to(&mut self, name: &str, key: &str) -> &mut Self {
        let arrives = (0..300).any(|_| {
            self.press(key);
            self.focused().is_some_and(|control| control.name == name)
        });
        assert!(arrives, "{key} never comes to {name}");
        self
    }
}
