//! The pointer: free in selection mode, hidden and held in camera mode, where only its motion counts.

use glam::DVec2;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::window::{CursorGrabMode, Window};

use cockpit::input::Input;

/// How the pointer is held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Hold {
    /// The pointer moves freely.
    #[default]
    Free,
    /// The system locks the pointer and reports raw motion.
    Locked,
    /// The program puts the pointer back to the middle again and again. X11 cannot lock, and reports raw motion twice while it
    /// confines the pointer.
    Centered,
}

/// The state of the pointer.
#[derive(Debug, Default)]
pub(super) struct Pointer {
    hold: Hold,
    confined: bool,
    last: Option<PhysicalPosition<f64>>,
}

impl Pointer {
    /// Whether the pointer is hidden and held.
    pub fn holds(&self) -> bool {
        self.hold != Hold::Free
    }

    /// Holds or releases the pointer, in a view around the pixel `middle`.
    pub fn follow(&mut self, window: &Window, hold: bool, middle: DVec2) {
        if self.hold == Hold::Centered && hold && !self.confined {
            // A window that is not on the screen yet cannot hold the pointer.
            self.confined = window.set_cursor_grab(CursorGrabMode::Confined).is_ok();
        }
        if hold == self.holds() {
            return;
        }
        self.last = None;
        self.confined = false;
        if hold {
            self.hold = if window.set_cursor_grab(CursorGrabMode::Locked).is_ok() {
                Hold::Locked
            } else {
                self.confined = window.set_cursor_grab(CursorGrabMode::Confined).is_ok();
                self.center(window);
                Hold::Centered
            };
        } else {
            let _ = window.set_cursor_grab(CursorGrabMode::None);
            if self.hold == Hold::Centered {
                // Where this is not supported, the pointer appears where it was hidden.
                let _ = window.set_cursor_position(PhysicalPosition::new(middle.x, middle.y));
            }
            self.hold = Hold::Free;
        }
        window.set_cursor_visible(!hold);
    }

    /// Returns the input of a motion of the pointer to `position`, if there is any.
    pub fn moved(&mut self, window: &Window, position: PhysicalPosition<f64>) -> Option<Input> {
        match self.hold {
            Hold::Free => Some(Input::Mouse(position.x, position.y)),
            Hold::Locked => None,
            Hold::Centered => {
                let (center, reach) = middle(window.inner_size());
                let last = self.last.replace(position)?;
                let off = |from: PhysicalPosition<f64>| {
                    (position.x - from.x).abs().max((position.y - from.y).abs())
                };
                // After the pointer was put back, older events still arrive: the nearer origin is right.
                let from = if off(center) < off(last) && off(last) > reach { center } else { last };
                if off(center) > reach {
                    self.center(window);
                }
                let (right, down) = (position.x - from.x, position.y - from.y);
                (right != 0.0 || down != 0.0).then_some(Input::Mouse(right, down))
            }
        }
    }

    /// Returns the input of raw motion, if the pointer is locked.
    pub fn raw(&self, (right, down): (f64, f64)) -> Option<Input> {
        (self.hold == Hold::Locked).then_some(Input::Mouse(right, down))
    }

    fn center(&self, window: &Window) {
        // Where this is not supported the pointer stays at the edge, no worse than before.
        let _ = window.set_cursor_position(middle(window.inner_size()).0);
    }
}

/// The middle of the window, and how far from it the pointer may go, pixels.
fn middle(size: PhysicalSize<u32>) -> (PhysicalPosition<f64>, f64) {
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    (PhysicalPosition::new(width / 2.0, height / 2.0), width.min(height) / 4.0)
}
