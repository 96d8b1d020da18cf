//! The clock of studies: thread CPU time, so that other work on the machine does not count. No other file of the crate reads a clock.

/// A clock that counts seconds.
pub type Clock = dyn Fn() -> f64 + Send;

/// Thread CPU time, s.
#[cfg(not(any(target_family = "wasm", windows)))]
pub(crate) fn thread_time() -> f64 {
    cpu_time::ThreadTime::now().as_duration().as_secs_f64()
}

/// Time since the first call, s: a page is not told the time of its thread, and Windows counts it in steps of 16 ms.
#[cfg(any(target_family = "wasm", windows))]
pub(crate) fn thread_time() -> f64 {
    static START: std::sync::OnceLock<web_time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(web_time::Instant::now).elapsed().as_secs_f64()
}

/// Whether the clock of studies counts the time of a thread, and not all that passes.
pub const IS_THREAD_TIME: bool = cfg!(not(any(target_family = "wasm", windows)));

/// Length of a block of ticks that is timed, s: long compared with the resolution of the clock, which is up to 1 ms in a page, and
/// short compared with the time slices of the system.
pub(crate) const BLOCK_S: f64 = if cfg!(target_family = "wasm") { 2e-2 } else { 1e-3 };

/// Gives this thread real-time priority, so that no other program takes its caches while it is timed: on Linux, as root or
/// with the right to it. Returns whether it has that priority now; `None` on other systems.
pub fn take_real_time_priority() -> Option<bool> {
    #[cfg(target_os = "linux")]
    {
        use thread_priority::{
            RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
            set_thread_priority_and_policy, thread_native_id,
        };
        let lowest = ThreadPriority::Crossplatform(1.try_into().unwrap_or_default());
        let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        Some(set_thread_priority_and_policy(thread_native_id(), lowest, policy).is_ok())
    }
    #[cfg(not(target_os = "linux"))]
    None
}
