//! The wheel: each notch counted once.

use winit::event::{DeviceEvent, ElementState, MouseScrollDelta};

/// Points of a touch pad per notch of the wheel.
const POINTS_PER_NOTCH: f64 = 40.0;

/// Counts notches of the wheel, and remembers whether the last raw event was the release of a button.
///
/// An X11 pointer without a scrolling axis, such as that of xdotool or VNC, presses and releases a button for a notch, and winit
/// 0.30.13 reports both as a notch (fixed in rust-windowing/winit#4386). The raw event comes first and tells them apart.
#[derive(Debug, Default)]
pub(super) struct Wheel {
    released: bool,
}

impl Wheel {
    /// Takes a raw event of the system.
    pub fn raw(&mut self, event: &DeviceEvent) {
        self.released =
            matches!(event, DeviceEvent::Button { button: 4..=7, state: ElementState::Released });
    }

    /// The notches away from the person in an event of a window with `scale` pixels per point, if there are any.
    pub fn notches(&self, delta: MouseScrollDelta, scale: f64) -> Option<f64> {
        let notches = match delta {
            MouseScrollDelta::LineDelta(_, notches) => f64::from(notches),
            MouseScrollDelta::PixelDelta(pixels) => pixels.y / (POINTS_PER_NOTCH * scale),
        };
        (notches != 0.0 && !self.released).then_some(notches)
    }
}

#[cfg(test)]
mod tests {
    use winit::dpi::PhysicalPosition;

    use super::*;

    /// Notches of raw events, each followed by as many lines.
    fn notches(events: &[(DeviceEvent, Option<f32>)]) -> f64 {
        let mut wheel = Wheel::default();
        let counted = events.iter().filter_map(|(event, lines)| {
            wheel.raw(event);
            lines.and_then(|lines| wheel.notches(MouseScrollDelta::LineDelta(0.0, lines), 2.0))
        });
        counted.sum()
    }

    #[test]
    fn a_notch_counts_once_by_buttons_and_by_axes_with_winit_as_it_is_and_as_it_will_be() {
        let button = |state| DeviceEvent::Button { button: 4, state };
        let axis = DeviceEvent::Motion { axis: 3, value: -15.0 };
        let [press, release] = [button(ElementState::Pressed), button(ElementState::Released)];
        let now = [(press.clone(), Some(1.0)), (release.clone(), Some(1.0))];
        let mended = [(press, Some(1.0)), (release, None)];
        let smooth = [(axis.clone(), Some(0.25)), (axis, Some(0.75))];
        assert_eq!([&now, &mended, &smooth].map(|events| notches(events)), [1.0; 3]);
        for buttons in [&now, &mended] {
            assert_eq!(notches(&[&buttons[..], &smooth, buttons].concat()), 3.0);
        }
    }

    #[test]
    fn a_touch_pad_turns_as_far_on_a_display_of_every_scale() {
        for scale in [1.0, 1.5, 2.0] {
            let delta = MouseScrollDelta::PixelDelta(PhysicalPosition::new(0.0, 80.0 * scale));
            assert_eq!(Wheel::default().notches(delta, scale), Some(2.0));
        }
    }
}
