//! Threads for large worlds.

use bevy_ecs::prelude::*;

/// Threads that share the bodies of a tick. A world without this resource uses one; the state comes out the
/// same, to the last bit, with any number.
#[derive(Resource, Debug)]
pub struct Threads {
    /// One less than there are: the thread that runs the tick is one of them.
    pool: Option<rayon::ThreadPool>,
    count: usize,
}

impl Threads {
    /// Bodies of a table from which sharing them pays.
    pub const FROM: usize = 20_000;

    /// `count` threads, at least 1; fewer where the system gives no more.
    #[must_use]
    pub fn new(count: usize) -> Self {
        let others = count.saturating_sub(1);
        let pool =
            (others > 0).then(|| rayon::ThreadPoolBuilder::new().num_threads(others).build().ok()).flatten();
        let count = pool.as_ref().map_or(1, |pool| pool.current_num_threads() + 1);
        Self { pool, count }
    }

    /// How many there are.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Runs every job, the first one on this thread.
    pub(crate) fn run<J: FnOnce() + Send>(&self, jobs: Vec<J>) {
        match &self.pool {
            Some(pool) => pool.in_place_scope(|scope| {
                let mut jobs = jobs.into_iter();
                let first = jobs.next();
                jobs.for_each(|job| scope.spawn(|_| job()));
                if let Some(job) = first {
                    job();
                }
            }),
            None => jobs.into_iter().for_each(|job| job()),
        }
    }
}
