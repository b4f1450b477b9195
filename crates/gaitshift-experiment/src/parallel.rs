//! Tasks shared out among threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Runs so many tasks, each given its number, on up to so many threads; gives their results in the order of the numbers.
pub(crate) fn in_parallel<T: Send>(
    threads: usize,
    tasks: usize,
    task: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new((0..tasks).map(|_| None).collect::<Vec<Option<T>>>());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= tasks {
                return;
            }
            let result = task(index);
            results.lock().unwrap_or_else(|e| e.into_inner())[index] = Some(result);
        }
    };
    with_team(threads.min(tasks), work);
    let results = results.into_inner().unwrap_or_else(|e| e.into_inner());
    results.into_iter().flatten().collect()
}

/// Does the work on up to so many threads at once, the calling one among them. Where the system refuses a thread they are
/// fewer, so the work must be done when any one of them returns.
pub(crate) fn with_team(threads: usize, work: impl Fn() + Sync) {
    std::thread::scope(|scope| {
        for _ in 1..threads {
            if std::thread::Builder::new()
                .spawn_scoped(scope, &work)
                .is_err()
            {
                break;
            }
        }
        work();
    });
}
