//! The threads that share the bodies of large worlds.

use bevy_ecs::prelude::*;

/// The threads that share the bodies of a tick. A world without this resource uses one thread. The state is the same,
/// bit for bit, with any number of threads.
#[derive(Resource, Debug)]
pub struct Threads {
    /// The other threads: the one that runs the tick is not in the pool.
    pool: Option<rayon::ThreadPool>,
    count: usize,
}

impl Threads {
    /// Number of bodies in a table from which sharing them is faster.
    pub const FROM: usize = 20_000;

    /// Starts `count` threads, at least 1. Uses one thread if the system refuses the others.
    #[must_use]
    pub fn new(count: usize) -> Self {
        let others = count.saturating_sub(1);
        let pool =
            (others > 0).then(|| rayon::ThreadPoolBuilder::new().num_threads(others).build().ok()).flatten();
        let count = pool.as_ref().map_or(1, |pool| pool.current_num_threads() + 1);
        Self { pool, count }
    }

    /// Number of threads, with the one that runs the tick.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.count
    }

    /// `threads`, if there are several and sharing so many rows among them is faster.
    pub(crate) fn for_rows(threads: Option<&Self>, rows: usize) -> Option<&Self> {
        threads.filter(|threads| threads.count > 1 && rows >= Self::FROM)
    }

    /// Calls `each` for parts of `rows` and the rows of `others` beside them, a part on each thread, with the number of
    /// the first row. Without threads, there is one part.
    pub(crate) fn share_two<A: Send, B: Send>(
        threads: Option<&Self>,
        rows: &mut [A],
        others: &mut [B],
        each: impl Fn(usize, &mut [A], &mut [B]) + Sync,
    ) {
        let Some(threads) = threads else { return each(0, rows, others) };
        // Parts begin on a cache line.
        let share = rows.len().div_ceil(threads.count()).next_multiple_of(8).max(8);
        let parts = rows.chunks_mut(share).zip(others.chunks_mut(share)).enumerate();
        let each = &each;
        threads.run(parts.map(|(part, (rows, others))| move || each(part * share, rows, others)).collect());
    }

    /// [`Self::share_two`] without others.
    pub(crate) fn share<A: Send>(
        threads: Option<&Self>,
        rows: &mut [A],
        each: impl Fn(usize, &mut [A]) + Sync,
    ) {
        let mut none = vec![(); rows.len()];
        Self::share_two(threads, rows, &mut none, |first, rows, _| each(first, rows));
    }

    /// Runs every job, the first one on the current thread.
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
