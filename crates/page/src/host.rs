//! What passes between the page and its script.

use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// What the page's script does for the program.
    pub type Host;

    /// Whether this is a Mac, whose control key is Command.
    #[wasm_bindgen(method)]
    pub fn is_mac(this: &Host) -> bool;

    /// The text that is kept under a name, from visit to visit.
    #[wasm_bindgen(method)]
    pub fn get(this: &Host, name: &str) -> Option<String>;

    /// Keeps a text under a name; nothing if there is no text.
    #[wasm_bindgen(method)]
    pub fn set(this: &Host, name: &str, text: Option<&str>);

    /// Gives the person a file, as a download.
    #[wasm_bindgen(method)]
    pub fn save(this: &Host, name: &str, bytes: &[u8]);

    /// Says in the page that the program has ended, and why.
    #[wasm_bindgen(js_namespace = globalThis)]
    pub fn inertia_failed(why: &str);
}

/// What the script does after a frame.
#[wasm_bindgen(getter_with_clone)]
#[derive(Default)]
pub struct After {
    /// Time until the next frame, s; infinite if nothing changes before there is input.
    pub due_s: f64,
    /// Shape of the pointer, as CSS has it.
    pub cursor: String,
    /// Whether the pointer is to be hidden and held.
    pub holds_pointer: bool,
    /// Whether a field takes what is typed.
    pub takes_text: bool,
    /// A text for the clipboard.
    pub copied: Option<String>,
    /// A link to be opened.
    pub opens: Option<String>,
    /// Whether the graphics device is lost: the page needs another canvas.
    pub lost: bool,
}

/// The scene for a link.
#[wasm_bindgen(getter_with_clone)]
pub struct Shared {
    /// Name of a shipped scene.
    pub name: Option<String>,
    /// Text of another scene.
    pub text: Option<String>,
}
