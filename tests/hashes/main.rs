//! Prints the state hashes of every scene by every method, as `tests/determinism/methods.txt` has them: hashes [LEFT OUT...].

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

fn main() {
    let left_out: Vec<_> = std::env::args().skip(1).collect();
    let scenes: Vec<_> = hashes::scenes().filter(|scene| !left_out.contains(&scene.name)).collect();
    let next = AtomicUsize::new(0);
    let take = || {
        let number = next.fetch_add(1, Ordering::Relaxed);
        scenes.get(number).map(|scene| (number, hashes::hashes_of(scene)))
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let mut found: Vec<_> = thread::scope(|scope| {
        let runs: Vec<_> = (0..threads)
            .map(|_| scope.spawn(|| std::iter::from_fn(take).collect::<Vec<_>>()))
            .collect();
        runs.into_iter().flat_map(|run| run.join().expect("every scene runs")).collect()
    });
    found.sort_unstable();
    for (_, lines) in found {
        print!("{lines}");
    }
}
