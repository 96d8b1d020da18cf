//! The sandbox in a web page: what the page's script (`web/page.js`) calls, and what it is asked for.
//!
//! The script has the browser's events and its storage; this has the session. Both are one thread.

#![cfg(target_family = "wasm")]

#[cfg(feature = "checks")]
mod checks;
mod host;
mod orders;
mod shell;
mod shots;

use std::cell::RefCell;
use std::rc::Rc;

use cockpit::input::keyboard::Modifiers;
use cockpit::input::{Button, Input, TouchPhase};
use render::Screen;
use render::wgpu::util::new_instance_with_webgpu_detection;
use render::wgpu::{Backends, InstanceDescriptor, SurfaceTarget};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::future_to_promise;
use wasm_bindgen_futures::js_sys::{Promise, Uint8Array};
use web_sys::HtmlCanvasElement;

use host::{After, Host, Shared, inertia_failed};
use shell::{Link, Shell};

/// The program in a page.
#[wasm_bindgen]
pub struct Page(Rc<RefCell<Shell>>);

/// Memory that a scene may take, bytes: an allocation that fails ends a page.
const MOST_MEMORY: u64 = 1 << 30;

/// Says in the page why the program ended.
#[wasm_bindgen(start)]
pub fn prepare() {
    std::panic::set_hook(Box::new(|panic| inertia_failed(&panic.to_string())));
    scene::allow_memory(MOST_MEMORY);
}

#[wasm_bindgen]
impl Page {
    /// Opens the scene of a link: a `name` of a shipped scene, or the `text` of one. `bare` shows the tutorial's picture alone, and
    /// `narrow` begins with words for fingers. `draft` is the name under which unsaved changes are kept, and `left_behind` that of a page that is gone.
    #[wasm_bindgen(constructor)]
    pub fn new(
        host: Host,
        name: Option<String>,
        text: Option<String>,
        lesson: Option<String>,
        bare: bool,
        narrow: bool,
        draft: String,
        left_behind: Option<String>,
    ) -> Self {
        let link = Link { name, text, lesson, bare };
        Self(Rc::new(RefCell::new(Shell::new(host, link, narrow, draft, left_behind))))
    }

    /// Opens a graphics device that draws into `canvas`; with `webgl`, one of WebGL 2 even where there is WebGPU. Gives its name.
    pub fn draw_into(&self, canvas: HtmlCanvasElement, webgl: bool) -> Promise {
        let shell = Rc::clone(&self.0);
        future_to_promise(async move {
            let mut descriptor = InstanceDescriptor::new_without_display_handle();
            if webgl {
                descriptor.backends = Backends::GL;
            }
            let instance = new_instance_with_webgpu_detection(descriptor).await;
            let size_px = [canvas.width(), canvas.height()];
            let screen = Screen::open(instance, SurfaceTarget::Canvas(canvas), size_px).await;
            let screen = screen.map_err(|error| JsError::new(&error.to_string()))?;
            let name = screen.gpu.info.to_string();
            shell.borrow_mut().take_screen(screen);
            Ok(name.into())
        })
    }

    /// Forgets the device of a canvas that is gone.
    pub fn lose_device(&self) {
        self.0.borrow_mut().lose_device();
    }

    /// The canvas has another size, pixels, or another number of pixels per point.
    pub fn resize(&self, width: u32, height: u32, scale: f64) {
        self.0.borrow_mut().resize([width, height], scale);
    }

    /// A key went down or up, by its `key` and `code` of a `KeyboardEvent`. Returns whether the program uses it.
    #[expect(clippy::fn_params_excessive_bools, reason = "those of a KeyboardEvent")]
    #[expect(clippy::too_many_arguments, reason = "those of a KeyboardEvent")]
    pub fn key(
        &self,
        key: &str,
        code: &str,
        down: bool,
        repeats: bool,
        ctrl: bool,
        shift: bool,
        alt: bool,
        logo: bool,
    ) -> bool {
        let modifiers = Modifiers { ctrl, shift, alt, logo };
        let mut shell = self.0.borrow_mut();
        if down { shell.key_down(key, code, modifiers, repeats) } else { shell.key_up(code) }
    }

    /// Text was typed or pasted.
    pub fn text(&self, text: &str) {
        self.0.borrow_mut().input(Input::Text(text.lines().collect::<Vec<_>>().join(" ")));
    }

    /// An input method composes a text.
    pub fn compose(&self, text: &str) {
        self.0.borrow_mut().input(Input::Compose(text.to_owned()));
    }

    /// The pointer is at a pixel of the canvas, and has moved by that many.
    pub fn pointer(&self, x: f64, y: f64, right: f64, down: f64) {
        self.0.borrow_mut().pointer([x, y], [right, down]);
    }

    /// A button went down or up, by its number in a `MouseEvent`.
    pub fn button(&self, number: u32, down: bool) {
        let button = match number {
            0 => Button::Left,
            1 => Button::Middle,
            2 => Button::Right,
            _ => return,
        };
        self.0.borrow_mut().button(button, down);
    }

    /// The wheel turned by that many notches away from the person.
    pub fn wheel(&self, notches: f64) {
        self.0.borrow_mut().input(Input::Wheel(notches));
    }

    /// A finger touches a pixel of the canvas: it comes `down`, moves, comes `up`, or is taken away by the browser.
    pub fn touch(&self, finger: u32, phase: &str, x: f64, y: f64) {
        let phase = match phase {
            "down" => TouchPhase::Down,
            "move" => TouchPhase::Move,
            "up" => TouchPhase::Up,
            _ => TouchPhase::Cancel,
        };
        self.0.borrow_mut().input(Input::Touch(u64::from(finger), phase, x, y));
    }

    /// The page lost the keyboard.
    pub fn blur(&self) {
        self.0.borrow_mut().blur();
    }

    /// The browser has let go of the pointer, because Escape was pressed.
    pub fn pointer_freed(&self) {
        self.0.borrow_mut().session.free_pointer();
    }

    /// Opens files, each a name and its bytes: a scene, a bundle, or a lesson with its scene.
    pub fn open_files(&self, names: Vec<String>, contents: Vec<Uint8Array>) {
        let contents = contents.iter().map(Uint8Array::to_vec);
        self.0.borrow_mut().open_files(names.into_iter().zip(contents).collect());
    }

    /// Opens the scene or the lesson of a link in place of what is open.
    pub fn open_link(&self, name: Option<String>, text: Option<String>, lesson: Option<String>) {
        self.0.borrow_mut().open_link(Link { name, text, lesson, bare: false });
    }

    /// The scene for a link: its name if it is a shipped one without changes, else its text.
    pub fn shared(&self) -> Shared {
        self.0.borrow().shared()
    }

    /// Does a frame.
    pub fn frame(&self) -> After {
        self.0.borrow_mut().frame()
    }

    /// The present state as JSON, for tests of the page.
    pub fn state(&self) -> String {
        self.0.borrow_mut().state().to_string()
    }
}
