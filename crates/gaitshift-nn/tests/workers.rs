//! The team of threads runs every task of every stage exactly once, whatever the numbers of threads and tasks, however short
//! the tasks, after the workers fell asleep too; a task that needs the result of another gets it; and a panic in a task reaches
//! the caller, also while others wait for that task. `loom.rs` shows the same in a model checker.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use gaitshift_nn::Workers;

/// Fewer under Miri, which interprets every instruction.
const ROUNDS: usize = if cfg!(miri) { 30 } else { 2000 };

#[test]
fn every_task_runs_once() {
    for threads in 1..=4 {
        let mut workers = Workers::new(threads);
        assert_eq!(workers.threads(), threads);
        for round in 0..ROUNDS {
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

/// With elements of the second stage that read one of the first each, and others beside.
#[test]
fn the_second_stage_reads_what_the_first_has_done() {
    for threads in 1..=4 {
        let mut workers = Workers::new(threads);
        let mut scratch = vec![0usize; threads];
        for round in 1..ROUNDS {
            let counts = [1 + round % 5, round % 3, round % 11];
            let [mut first, mut beside, mut second] = counts.map(|count| vec![0; count]);
            workers.two_stages(
                &mut scratch,
                (&mut first, |scratch, index, value| {
                    *scratch += 1;
                    *value += round + index;
                }),
                (&mut beside, |scratch, index, value| {
                    *scratch += 1;
                    *value += round * index;
                }),
                (&mut second, |scratch, index, value, first| {
                    *scratch += 1;
                    let needed = (index * 7) % counts[0];
                    *value += 1 + first.wait_for(needed);
                }),
            );
            assert!((0..counts[0]).all(|index| first[index] == round + index));
            assert!((0..counts[1]).all(|index| beside[index] == round * index));
            let expected = |index| 1 + round + (index * 7) % counts[0];
            assert!((0..counts[2]).all(|index| second[index] == expected(index)));
            // Each task ran once, and alone on its thread's scratch.
            assert_eq!(scratch.iter().sum::<usize>(), counts.iter().sum());
            scratch.fill(0);
        }
    }
}

#[test]
fn pieces_of_slices_are_worked_on_once() {
    for threads in 1..=3 {
        let mut workers = Workers::new(threads);
        for len in [1, 7, 8, 9, 40] {
            let [mut a, mut b, mut c] = [1, 2, 3].map(|value| vec![value; len]);
            let mut sums = vec![0; 2 * len.div_ceil(8) + 1];
            workers.for_each_piece(
                8,
                [[&mut a[..], &mut []], [&mut b, &mut c]],
                &mut sums,
                |group, from, [x, y], sum| {
                    for (index, x) in x.iter_mut().enumerate() {
                        *x += 10 * (from + index);
                    }
                    assert!(y.len() == x.len() * group);
                    y.iter_mut().for_each(|y| *y = 0);
                    *sum += x.len();
                },
            );
            assert!((0..len).all(|index| a[index] == 1 + 10 * index));
            assert!((0..len).all(|index| b[index] == 2 + 10 * index && c[index] == 0));
            assert_eq!(sums.iter().sum::<usize>(), 2 * len);
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

/// Tickets count in 32 bits, and a team that was given more tasks panicked before the first of them.
#[test]
fn more_tasks_than_tickets_can_count_begin_too() {
    let outcome = std::panic::catch_unwind(|| {
        Workers::new(2).run(1 << 32, &|task| panic!("task {task}, so it has begun"));
    });
    let message = outcome.expect_err("the task panics");
    let message = message.downcast_ref::<String>().map(String::as_str);
    assert_eq!(message, Some("task 0, so it has begun"));
}

#[test]
fn a_panic_reaches_the_caller() {
    for threads in [1, 2] {
        let outcome = std::panic::catch_unwind(|| {
            Workers::new(threads).run(4, &|task| assert!(task != 2, "task 2 fails"));
        });
        assert!(outcome.is_err());
        let outcome = std::panic::catch_unwind(|| {
            Workers::new(threads).two_stages(
                &mut vec![(); threads],
                (&mut [0], |(), _, _| panic!("the first stage fails")),
                (&mut [(); 0], |(), _, ()| {}),
                (&mut [0; 3], |(), _, value, first| {
                    *value = *first.wait_for(0)
                }),
            );
        });
        assert!(outcome.is_err());
    }
}
