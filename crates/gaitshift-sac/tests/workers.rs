//! The team of threads runs every task of every stage exactly once, whatever the numbers of threads and tasks, however short
//! the tasks, after the workers fell asleep too; a gate holds a task until the one it waits for is done; and a panic in a
//! task reaches the caller, from behind a gate too.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use gaitshift_sac::{Gate, Workers};

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
fn a_gate_holds_the_second_stage_until_the_first_is_done() {
    for threads in 1..=4 {
        let mut workers = Workers::new(threads);
        for round in 0..2000 {
            let (first, second) = (round % 5, round % 11);
            let mut gates: [Gate; 5] = Default::default();
            gates.iter_mut().for_each(Gate::close);
            let results: [AtomicU32; 5] = Default::default();
            let counts: [AtomicU32; 11] = Default::default();
            workers.run_stages([first, second], &|thread, stage, task| {
                assert!(thread < threads);
                if stage == 0 {
                    let _open_at_end = gates[task].open_at_end();
                    results[task].store(round as u32 + 1, Ordering::Relaxed);
                } else {
                    if first > 0 {
                        let needed = task % first;
                        gates[needed].wait();
                        let result = results[needed].load(Ordering::Relaxed);
                        assert_eq!(result, round as u32 + 1);
                    }
                    counts[task].fetch_add(1, Ordering::Relaxed);
                }
            });
            for (task, count) in counts.iter().enumerate() {
                let expected = u32::from(task < second);
                assert_eq!(count.load(Ordering::Relaxed), expected);
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

/// The number of tasks of a call was packed into 16 bits, and a call with more panicked, though only with two threads: a
/// learner with `critic_hidden = [6000, 6000]` has 70,000 ranges of parameters to step.
#[test]
fn more_tasks_than_fit_sixteen_bits() {
    for threads in [1, 2] {
        let tasks = 70_500;
        let counts: Vec<AtomicU32> = (0..tasks).map(|_| AtomicU32::new(0)).collect();
        Workers::new(threads).run(tasks, &|task| {
            counts[task].fetch_add(1, Ordering::Relaxed);
        });
        assert!(
            counts
                .iter()
                .all(|count| count.load(Ordering::Relaxed) == 1)
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
        let outcome = std::panic::catch_unwind(|| {
            let gate = Gate::default();
            Workers::new(threads).run_stages([1, 3], &|_, stage, _| {
                if stage == 0 {
                    let _open_at_end = gate.open_at_end();
                    panic!("the first stage fails");
                }
                gate.wait();
            });
        });
        assert!(outcome.is_err());
    }
}
