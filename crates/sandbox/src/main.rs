//! The `sandbox` program.

use std::alloc::{GlobalAlloc, Layout, System};
use std::env;
use std::process::ExitCode;

/// The system's allocator. If there is no memory left, the program ends in words and with an exit code.
struct OrEnd;

impl OrEnd {
    fn checked(memory: *mut u8) -> *mut u8 {
        if memory.is_null() { sandbox::end_without_memory() } else { memory }
    }
}

#[expect(unsafe_code, reason = "every call reaches the system's allocator as it came")]
unsafe impl GlobalAlloc for OrEnd {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Self::checked(unsafe { System.alloc(layout) })
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        Self::checked(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        Self::checked(unsafe { System.realloc(memory, layout, size) })
    }
}

#[global_allocator]
static ALLOCATOR: OrEnd = OrEnd;

fn main() -> ExitCode {
    disable_wayland_device_select();
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // There is no memory for the stack of a thread, or there are too many threads.
        if panic
            .payload_as_str()
            .is_some_and(|what| what.contains("Resource temporarily unavailable"))
        {
            sandbox::end_without_memory();
        }
        hook(panic);
    }));
    // wgpu tries every driver and logs those that fail; what matters comes back as an error.
    let quiet = "error,wgpu_hal=off,wgpu_core=off";
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or(quiet)).init();
    match sandbox::commands::run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            sandbox::tell(&format!("sandbox: {failure}"));
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Keeps Mesa's device-selection layer from looking for a Wayland display where there can be none: the library that it asks would
/// complain on standard error.
fn disable_wayland_device_select() {
    let set = |name| env::var_os(name).is_some_and(|value| !value.is_empty());
    if !set("XDG_RUNTIME_DIR") && !set("MESA_VK_DEVICE_SELECT") {
        #[expect(unsafe_code, reason = "no other thread runs yet that could read the environment")]
        unsafe {
            env::set_var("NODEVICE_SELECT", "1");
        }
    }
}
