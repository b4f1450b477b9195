//! Contract: once an environment exists, its steps, observations, resets and the curriculum's look-up allocate nothing, with
//! and without reward terms and rules of one's own.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use gaitshift_body::{Body, BodyParameters};
use gaitshift_task::{Curriculum, EnvironmentBatch, TaskParameters};

/// Counts the allocations of each thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: passes everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: passed on from the caller.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: passed on from the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn stepping_and_resetting_allocate_nothing() {
    runs_without_allocating(&TaskParameters::default());
}

#[test]
fn expressions_of_ones_own_allocate_nothing() {
    let text = r#"
        [[reward.extra]]
        name = "calm"
        weight = 0.5
        expression = "-abs(theta_velocity_rad_per_s)^1.5 - hypot(right_command - right_previous_command, left_command)"
        [[reward.extra]]
        name = "speed"
        weight = 0.1
        expression = "x_velocity_m_per_s > 1 && omega_v > 0 ? exp(-((x_velocity_m_per_s - 1.2) / 0.3)^2) : 0"
        [[termination.extra]]
        name = "bounce"
        expression = "com_z_m - ground_height_m > 2 || right_normal_force_n > 1e5"
    "#;
    runs_without_allocating(&toml::from_str(text).unwrap());
}

fn runs_without_allocating(task: &TaskParameters) {
    let curriculum = Curriculum::default();
    let mut settings = curriculum.at(5_000_000, &task.reward);
    settings.command.redraw_interval_s = 0.3;
    let body = Body::new(BodyParameters::default()).unwrap();
    let mut batch = EnvironmentBatch::new(body, task.clone(), 3, 7, &settings);
    let before = ALLOCATIONS.with(Cell::get);
    // The counter counts, or nothing below would mean anything.
    drop(std::hint::black_box(Box::new(1)));
    assert_eq!(ALLOCATIONS.with(Cell::get), before + 1);

    let mut episodes = 0;
    let mut sum = 0.0;
    for step in 0..600 {
        std::hint::black_box(curriculum.at(step, &task.reward));
        for i in 0..batch.len() {
            let command = [(step as f64 * 0.3).sin(), (step as f64 * 0.2).cos()];
            let (outcome, finished) = batch.step(i, command, 0.0, &settings);
            sum += outcome.terms.sum() + batch.environment(i).observation()[0];
            if finished.is_some() {
                batch.reset(i, &settings);
                episodes += 1;
            }
        }
    }
    assert_eq!(ALLOCATIONS.with(Cell::get), before + 1);
    assert!(sum.is_finite() && episodes > 2, "{episodes} episodes");
}
