//! What a system expects of a program with a window, before the window opens.

/// Leaves a console that was opened for the program alone: it would stay behind the window. A console that the program was started
/// from stays.
#[cfg(windows)]
pub(super) fn leave_own_console() {
    use windows_sys::Win32::System::Console::{FreeConsole, GetConsoleProcessList};

    let mut processes = [0; 2];
    #[expect(
        unsafe_code,
        reason = "no library does it; the list has as many places as it is said to"
    )]
    unsafe {
        if GetConsoleProcessList(processes.as_mut_ptr(), 2) == 1 {
            FreeConsole();
        }
    }
}

#[cfg(not(windows))]
pub(super) const fn leave_own_console() {}

/// Goes to the person's own folder from the root of the disk, where macOS starts what is opened in Finder: what a window saves
/// lies in the working folder.
pub(super) fn leave_root_folder() {
    if cfg!(target_os = "macos")
        && std::env::current_dir().is_ok_and(|here| here.parent().is_none())
        && let Some(home) = dirs::home_dir()
    {
        let _ = std::env::set_current_dir(home);
    }
}
