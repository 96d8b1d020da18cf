//! Independent work on several threads, whose results come in order.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::mpsc::channel;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

/// How far the threads may be ahead of the first result that is missing, per thread.
const AHEAD: u64 = 64;

/// What the threads have in common.
struct Queue {
    /// The next piece of work.
    next: u64,
    /// How many results were taken.
    taken: u64,
    over: bool,
}

/// Ends the work when its thread panics: the others must not wait for a result that never comes.
struct EndOnPanic<'a> {
    queue: &'a Mutex<Queue>,
    moved: &'a Condvar,
}

impl Drop for EndOnPanic<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.queue.lock().unwrap_or_else(PoisonError::into_inner).over = true;
            self.moved.notify_all();
        }
    }
}

/// Does `work` on 0, 1, ... `count - 1` on `threads` threads (at least 1) and calls `take` with each result, in this order, on
/// the calling thread, until `take` breaks. Results that wait for an earlier one are at most 64 per thread.
pub(crate) fn ordered<T: Send>(
    count: u64,
    threads: usize,
    work: impl Fn(u64) -> T + Sync,
    mut take: impl FnMut(T) -> ControlFlow<()>,
) {
    let window = AHEAD * threads.max(1) as u64;
    let (queue, moved) = (Mutex::new(Queue { next: 0, taken: 0, over: false }), Condvar::new());
    let locked =
        || -> MutexGuard<'_, Queue> { queue.lock().unwrap_or_else(PoisonError::into_inner) };
    let claim = || {
        let waits =
            |queue: &mut Queue| !queue.over && queue.next >= queue.taken.saturating_add(window);
        let mut queue = moved.wait_while(locked(), waits).unwrap_or_else(PoisonError::into_inner);
        let index = queue.next;
        (!queue.over && index < count).then(|| {
            queue.next += 1;
            index
        })
    };
    let (sender, results) = channel();
    thread::scope(|scope| {
        for number in 0..threads.max(1) {
            let sender = sender.clone();
            let (claim, work) = (&claim, &work);
            let guard = EndOnPanic { queue: &queue, moved: &moved };
            let spawned = thread::Builder::new().spawn_scoped(scope, move || {
                let _guard = guard;
                while let Some(index) = claim() {
                    if sender.send((index, work(index))).is_err() {
                        break;
                    }
                }
            });
            // Those that there are do all of it.
            match spawned {
                Err(error) if number == 0 => panic!("there is no thread to work on: {error}"),
                Err(_) => break,
                Ok(_) => {}
            }
        }
        drop(sender);
        let _guard = EndOnPanic { queue: &queue, moved: &moved };
        let (mut waiting, mut expected) = (BTreeMap::new(), 0);
        for (index, result) in results {
            waiting.insert(index, result);
            while let Some(result) = waiting.remove(&expected) {
                expected += 1;
                let ends = take(result).is_break();
                let mut queue = locked();
                queue.taken = expected;
                queue.over |= ends;
                drop(queue);
                moved.notify_all();
                if ends {
                    return;
                }
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_whoever_is_faster() {
        for threads in [1, 2, 5] {
            let mut found = Vec::new();
            let slow = |index| {
                // The earlier ones of a dozen take longer.
                thread::sleep(std::time::Duration::from_micros(200 * (12 - index % 12)));
                index * index
            };
            ordered(100, threads, slow, |square| {
                found.push(square);
                ControlFlow::Continue(())
            });
            assert_eq!(found, (0..100).map(|index| index * index).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_break_ends_it() {
        let mut taken = 0;
        ordered(
            u64::MAX,
            3,
            |index| index,
            |_| {
                taken += 1;
                if taken < 10 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            },
        );
        assert_eq!(taken, 10);
        ordered(0, 2, |index| index, |_| unreachable!("no work, no result"));
    }

    #[test]
    fn a_panic_ends_it() {
        for threads in [1, 3] {
            let work = |index: u64| {
                assert!(index != 5, "a panic of the work");
                index
            };
            let worked = std::panic::catch_unwind(|| {
                ordered(u64::MAX, threads, work, |_| ControlFlow::Continue(()));
            });
            assert!(worked.is_err());
            let take = |index: u64| {
                // The threads get as far ahead as they may.
                thread::sleep(std::time::Duration::from_millis(20));
                assert!(index < 2, "a panic of what takes the results");
                ControlFlow::Continue(())
            };
            let taken =
                std::panic::catch_unwind(|| ordered(u64::MAX, threads, |index| index, take));
            assert!(taken.is_err());
        }
    }
}
