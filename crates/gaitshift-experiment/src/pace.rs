//! How long a run will take, measured before it begins.

use crate::acceptance::Judgement;
use crate::config::Experiment;
use crate::run_folder::TrainingError;
use crate::training::{Observer, Progress, Training};
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Environment steps per second of an experiment on this machine as busy as it is now: a run of `duration` with
/// updates, in a scratch folder that is removed again. Evaluations and checkpoints are left out.
///
/// # Errors
/// As [`Training::new`] and [`Training::run`].
pub fn steps_per_second(experiment: &Experiment, duration: Duration) -> Result<f64, TrainingError> {
    let mut e = experiment.clone();
    let environments = e.training.environments as u64;
    let first_update = (e.learner.batch_size as u64).max(4 * environments);
    e.training.learning_starts = e.training.learning_starts.min(first_update);
    // The longest that is accepted: none of them is reached.
    const NEVER: u64 = 1_000_000_000_000_000;
    e.training.evaluation_interval_steps = NEVER;
    e.training.checkpoint_interval_steps = NEVER;
    e.training.metrics_interval_steps = NEVER;
    let scratch = tempfile::tempdir()
        .map_err(|error| TrainingError::other(&std::env::temp_dir(), error.to_string()))?;
    let mut training = Training::new(e, &scratch.path().join("run"), "")?;
    let mut clock = Clock {
        skip: 2 * first_update.div_ceil(environments),
        periods: Cell::new(0),
        from: Cell::new(None),
        duration,
    };
    training.run(&mut clock)?;
    let timed = clock.periods.get().saturating_sub(clock.skip) * environments;
    let taken = clock.from.get().map_or(duration, |from| from.elapsed());
    Ok(timed as f64 / taken.as_secs_f64().max(1e-3))
}

/// Counts control periods from the `skip`th on and stops after `duration`.
struct Clock {
    skip: u64,
    periods: Cell<u64>,
    from: Cell<Option<Instant>>,
    duration: Duration,
}

impl Observer for Clock {
    fn progress(&mut self, _: &Progress) {}
    fn evaluated(&mut self, _: &Progress, _: &Judgement, _: bool) {}
    fn note(&mut self, _: &str) {}
    fn stop_requested(&self) -> bool {
        let period = self.periods.get() + 1;
        self.periods.set(period);
        if period == self.skip {
            self.from.set(Some(Instant::now()));
        }
        self.from
            .get()
            .is_some_and(|from| from.elapsed() >= self.duration)
    }
}
