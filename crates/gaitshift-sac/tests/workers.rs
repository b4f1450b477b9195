//! The team of threads runs every task exactly once, whatever the numbers of threads and tasks, however short the
//! tasks, after the workers fell asleep too; and a panic in a task reaches the caller.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use gaitshift_sac::Workers;

#[test]
fn every_task_runs_once() {
    for threads in 1..=4 {
        let mut workers = Workers::new(threads);
        assert_eq!(workers.threads(), threads);
        for round in 0..2000 {
            let tasks = round % 9;
            let counts: [AtomicU32; 9] = Default::default();
            workers.run(tasks, &|task| {
                counts[task].fetch_add(1, Ordering::Relaxed);
            });
            for (task, count) in counts.iter().enumerate() {
                assert_eq!(count.load(Ordering::Relaxed), u32::from(task < tasks));
            }
        }
    }
}

#[test]
fn sleeping_workers_wake_or_are_not_needed() {
    let mut workers = Workers::new(3);
    let mut values = vec![0u32; 50];
    for round in 1..=5 {
        // Longer than the workers stay awake.
        std::thread::sleep(Duration::from_millis(5));
        workers.for_each(&mut values, |index, value| *value += index as u32);
        assert!(
            values
                .iter()
                .enumerate()
                .all(|(index, &value)| value == round * index as u32)
        );
    }
}

#[test]
fn pairs_of_elements_are_worked_on_once() {
    let mut workers = Workers::new(2);
    let (mut numbers, mut squares) = ([1, 2, 3, 4, 5], [0; 5]);
    workers.for_each_pair(&mut numbers, &mut squares, |index, number, square| {
        *square = *number * *number;
        *number = index;
    });
    assert_eq!((numbers, squares), ([0, 1, 2, 3, 4], [1, 4, 9, 16, 25]));
}

#[test]
fn a_panic_reaches_the_caller() {
    for threads in [1, 2] {
        let outcome = std::panic::catch_unwind(|| {
            Workers::new(threads).run(4, &|task| assert!(task != 2, "task 2 fails"));
        });
        assert!(outcome.is_err());
    }
}
