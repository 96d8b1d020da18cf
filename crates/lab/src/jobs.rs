//! Jobs that are done one after another, and how much of them is done.

use std::collections::VecDeque;

/// Jobs of which each may be a run of many pieces.
pub(crate) struct Jobs<J, R> {
    pub waiting: VecDeque<J>,
    pub current: Option<(J, R)>,
    /// Weight of the work that is done.
    pub done: f64,
    /// Weight of all work.
    pub total: f64,
}

impl<J, R> Default for Jobs<J, R> {
    fn default() -> Self {
        Self { waiting: VecDeque::new(), current: None, done: 0.0, total: 0.0 }
    }
}

impl<J, R> Jobs<J, R> {
    /// Whether everything is done.
    pub fn is_done(&self) -> bool {
        self.waiting.is_empty() && self.current.is_none()
    }

    /// The part of the work that is done, in [0, 1].
    pub fn progress(&self) -> f64 {
        if self.is_done() {
            1.0
        } else {
            (self.done / self.total.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
        }
    }
}
