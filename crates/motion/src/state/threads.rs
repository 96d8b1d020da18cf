//! The threads that share the bodies of large worlds.

use bevy_ecs::prelude::*;
use bevy_tasks::{ComputeTaskPool, TaskPool, TaskPoolBuilder};

/// The threads that share the bodies of a tick. A world without this resource uses one thread. The state is the same,
/// bit for bit, with any number of threads.
///
/// ```
/// use bevy_ecs::prelude::*;
/// use motion::prelude::*;
/// use motion::{Threads, Transform};
///
/// let run = |threads| {
///     let mut world = World::new();
///     world.insert_resource(Threads::new(threads));
///     world.insert_resource(Drag::new(0.1, 0.2));
///     let body = |n: usize| PhysicsBody::with_mass(1.0).moving_at(Vector::X * n as f64);
///     let bodies: Vec<_> = (0..2 * Threads::FROM).map(|n| world.spawn(body(n)).id()).collect();
///     let mut stepper = Stepper::new(&mut world, Method::RungeKutta4, TimeStep(0.01));
///     (0..5).for_each(|_| stepper.tick(&mut world));
///     let position = |body| world.get::<Transform>(body).unwrap().position.x.to_bits();
///     bodies.into_iter().map(position).collect::<Vec<_>>()
/// };
/// assert_eq!(run(1), run(4));
/// ```
#[derive(Resource, Debug)]
pub struct Threads {
    pool: Pool,
}

/// A part of the work of a tick; not generic, because a scope of tasks is a lot of code for every type of job.
pub(crate) type Job<'a> = Box<dyn FnOnce() + Send + 'a>;

/// The threads besides the one that runs the tick, which is not in the pool.
#[derive(Debug)]
enum Pool {
    None,
    Own(TaskPool),
    App(&'static ComputeTaskPool),
}

impl Threads {
    /// Number of bodies in a table from which on sharing them among threads is faster.
    pub const FROM: usize = 20_000;

    /// Starts `count` threads, at least 1.
    #[must_use]
    pub fn new(count: usize) -> Self {
        let builder = || TaskPoolBuilder::new().thread_name("motion".to_owned());
        let pool = match count.saturating_sub(1) {
            0 => Pool::None,
            others => Pool::Own(builder().num_threads(others).build()),
        };
        Self { pool }
    }

    /// The threads of a Bevy app, which its systems share; one thread if there is no app.
    #[must_use]
    pub fn of_app() -> Self {
        Self { pool: ComputeTaskPool::try_get().map_or(Pool::None, Pool::App) }
    }

    /// Number of threads, with the one that runs the tick.
    #[must_use]
    pub fn count(&self) -> usize {
        self.pool().map_or(1, |pool| pool.thread_num() + 1)
    }

    fn pool(&self) -> Option<&TaskPool> {
        match &self.pool {
            Pool::None => None,
            Pool::Own(pool) => Some(pool),
            Pool::App(pool) => Some(pool),
        }
    }

    /// `threads`, if there are several and sharing `rows` rows among them is faster.
    pub(crate) fn for_rows(threads: Option<&Self>, rows: usize) -> Option<&Self> {
        threads.filter(|threads| threads.count() > 1 && rows >= Self::FROM)
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
        threads.run(
            parts
                .map(|(part, (rows, others))| -> Job<'_> {
                    Box::new(move || each(part * share, rows, others))
                })
                .collect(),
        );
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

    /// Runs every job; the current thread helps.
    pub(crate) fn run(&self, jobs: Vec<Job<'_>>) {
        match self.pool() {
            Some(pool) => {
                pool.scope(|scope| jobs.into_iter().for_each(|job| scope.spawn(async { job() })));
            }
            None => jobs.into_iter().for_each(|job| job()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_visited_once_by_the_threads_of_the_world_and_of_an_app() {
        assert_eq!(Threads::new(1).count(), 1);
        let pool = ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(2).build());
        let (own, app) = (Threads::new(3), Threads::of_app());
        assert_eq!((own.count(), app.count()), (3, pool.thread_num() + 1));
        for threads in [None, Some(&own), Some(&app)] {
            let (mut rows, mut others) = (vec![0; 1_001], vec![0; 1_001]);
            Threads::share_two(threads, &mut rows, &mut others, |first, rows, others| {
                rows.iter_mut().zip(others).enumerate().for_each(|(i, (row, other))| {
                    (*row, *other) = (*row + first + i, *other + 1);
                });
            });
            assert!(rows.iter().enumerate().all(|(i, row)| *row == i), "{rows:?}");
            assert!(others.iter().all(|times| *times == 1));
        }
    }
}
