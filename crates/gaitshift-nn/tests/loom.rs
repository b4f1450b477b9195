//! The workers in a model checker, which tries every order in which threads can meet (with at most three preemptions), and every
//! value that the memory model lets a thread see: each task runs once, in every call; the second stage sees what the first
//! wrote, without a race; a worker that parks is woken or not needed; the team ends.
//!
//! `RUSTFLAGS="--cfg loom" cargo test --release -p gaitshift-nn --test loom`

#![cfg(loom)]

use gaitshift_nn::Workers;
use loom::model::Builder;

fn model(check: impl Fn() + Sync + Send + 'static) {
    let mut builder = Builder::new();
    builder.preemption_bound = Some(3);
    builder.max_branches = 100_000;
    builder.check(check);
}

#[test]
fn every_task_of_every_call_runs_once() {
    model(|| {
        let mut workers = Workers::new(2);
        let mut values = [0; 2];
        for call in 1..=2 {
            workers.for_each(&mut values, |index, value| *value += 1 + index);
            assert_eq!(values, [call, 2 * call]);
        }
    });
}

#[test]
fn the_second_stage_reads_what_the_first_has_done() {
    model(|| {
        let mut workers = Workers::new(2);
        let (mut first, mut second) = ([1, 2], [0, 0]);
        workers.two_stages(
            &mut [(); 2],
            (&mut first, |(), _, value| *value *= 10),
            (&mut [(); 0], |(), _, ()| {}),
            (&mut second, |(), index, value, first| {
                *value = *first.wait_for(1 - index);
            }),
        );
        assert_eq!(second, [20, 10]);
    });
}
