//! Finds a display to open a window on, and says plainly if there is none.

use std::panic;

use egui_winit::accesskit_winit::Event;
use winit::event_loop::{EventLoop, EventLoopBuilder};
use winit::window::WindowAttributes;

use crate::failure::Failure;

/// Makes the event loop of the display. Without a display, the error says how to run `scene` anyway.
pub(super) fn event_loop(scene: &str) -> Result<EventLoop<Event>, Failure> {
    let no_display = |reason: Option<String>| {
        let reason = reason.map_or(String::new(), |reason| format!(" ({reason})"));
        Failure::NoDisplay(format!(
            "no display found; type `sandbox run {scene}` to run without a window, `sandbox --help` for everything else{reason}"
        ))
    };
    let mut builder = EventLoop::with_user_event();
    if !choose(&mut builder) {
        return Err(no_display(None));
    }
    // winit panics if a library of the display is missing, above all libxkbcommon-x11.
    let silent = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let built = panic::catch_unwind(panic::AssertUnwindSafe(|| builder.build()));
    panic::set_hook(silent);
    match built {
        Ok(Ok(event_loop)) => Ok(event_loop),
        Ok(Err(error)) => Err(no_display(Some(without_place(&error.to_string())))),
        Err(payload) => {
            let text = payload.downcast_ref::<String>().cloned();
            let text =
                text.or_else(|| payload.downcast_ref::<&str>().map(|text| (*text).to_owned()));
            Err(Failure::NoDisplay(format!(
                "a library of the display could not be loaded ({}); on Debian or Ubuntu install \
                 libxkbcommon-x11-0 libxcursor1 libxi6 libx11-xcb1, or use `sandbox run {scene}`",
                text.unwrap_or_else(|| "unknown".to_owned()).lines().next().unwrap_or_default()
            )))
        }
    }
}

/// Ends the program with the exit code of a missing display when the X server ends. Xlib would call `exit(1)`, which means that
/// an expectation failed.
#[cfg(all(unix, not(target_vendor = "apple")))]
pub(super) fn end_with(event_loop: &EventLoop<Event>) {
    use winit::platform::x11::EventLoopExtX11 as _;
    use x11_dl::xlib::{Display, Xlib};

    extern "C" fn ended(_: *mut Display) -> std::ffi::c_int {
        let failure = Failure::NoDisplay("the display has ended".to_owned());
        eprintln!("sandbox: {failure}");
        crate::output::files::end(failure.exit_code().into())
    }
    if event_loop.is_x11()
        && let Ok(xlib) = Xlib::open()
    {
        #[expect(unsafe_code, reason = "winit has no function for it")]
        unsafe {
            (xlib.XSetIOErrorHandler)(Some(ended));
        }
    }
}

#[cfg(not(all(unix, not(target_vendor = "apple"))))]
pub(super) fn end_with(_: &EventLoop<Event>) {}

/// Gives a window the name by which a desktop finds `inertia.desktop`, and its icon.
#[cfg(all(unix, not(target_vendor = "apple")))]
pub(super) fn named(window: WindowAttributes) -> WindowAttributes {
    use winit::platform::wayland::WindowAttributesExtWayland as _;

    // On X11 it is the same field.
    window.with_name("inertia", "inertia")
}

#[cfg(not(all(unix, not(target_vendor = "apple"))))]
pub(super) fn named(window: WindowAttributes) -> WindowAttributes {
    window
}

/// winit's errors name a line of its own source (`os error at ...rs:788: what`), which is no cure. Returns only the rest.
pub(super) fn without_place(error: &str) -> String {
    let what = error.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": "));
    what.map_or(error, |(_, what)| what).lines().next().unwrap_or_default().to_owned()
}

/// Chooses between X11 and Wayland; `false` if there is no display.
#[cfg(all(unix, not(target_vendor = "apple")))]
fn choose(builder: &mut EventLoopBuilder<Event>) -> bool {
    use std::env;
    use std::os::unix::net::UnixStream;
    use std::path::{Path, PathBuf};

    use winit::platform::x11::EventLoopBuilderExtX11;

    let set = |name: &str| env::var_os(name).filter(|value| !value.is_empty());
    let (x11, wayland) = (set("DISPLAY"), set("WAYLAND_DISPLAY"));
    if x11.is_none() && wayland.is_none() && set("WAYLAND_SOCKET").is_none() {
        return false;
    }
    if let (Some(name), Some(_)) = (wayland, x11) {
        let socket = match set("XDG_RUNTIME_DIR") {
            Some(folder) if Path::new(&name).is_relative() => PathBuf::from(folder).join(name),
            _ => PathBuf::from(name),
        };
        // A compositor that is gone leaves its variable behind: winit would take Wayland and give up.
        if UnixStream::connect(socket).is_err() {
            builder.with_x11();
        }
    }
    true
}

/// Leaves out the menu of macOS, whose Quit would not ask about unsaved changes: so Command+Q is a key.
#[cfg(target_os = "macos")]
fn choose(builder: &mut EventLoopBuilder<Event>) -> bool {
    use winit::platform::macos::EventLoopBuilderExtMacOS as _;

    builder.with_default_menu(false);
    true
}

#[cfg(not(unix))]
fn choose(_: &mut EventLoopBuilder<Event>) -> bool {
    true
}
