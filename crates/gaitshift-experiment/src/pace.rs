//! How long a run will take, measured before it begins.

use crate::acceptance::Judgement;
use crate::config::Experiment;
use crate::training::{Observer, Progress, Training};
use crate::training_error::TrainingError;
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Environment steps per second of an experiment on this machine as busy as it is now: a run of `duration` with
/// updates, in a scratch folder that is removed again. Evaluations and checkpoints are left out. What comes before that is
/// as long at most; where a few updates take longer, they are what is measured. It ends early, with the pace so far, once `stop`
/// says so, which is asked before each control period of all environments.
///
/// # Errors
/// As [`Training::new`] and [`Training::run`]; checkpoints are not written.
pub fn steps_per_second(
    experiment: &Experiment,
    duration: Duration,
    stop: &dyn Fn() -> bool,
) -> Result<f64, TrainingError> {
    let mut e = experiment.clone();
    let environments = e.training.environments as u64;
    let first_update = (e.learner.batch_size as u64).max(4 * environments);
    e.training.learning_starts = e.training.learning_starts.min(first_update);
    // The longest that is accepted: none of them is reached.
    const NEVER: u64 = 1_000_000_000_000_000;
    e.training.evaluation_interval_steps = NEVER;
    e.training.checkpoint_interval_steps = NEVER;
    e.training.metrics_interval_steps = NEVER;
    let scratch = tempfile::tempdir().map_err(|e| {
        let cause = format!(
            "{e}; the pace is measured in a temporary folder: name another by the variable TMPDIR"
        );
        TrainingError::other(&std::env::temp_dir(), cause)
    })?;
    let periods = |steps: u64| steps.div_ceil(environments);
    let mut clock = Clock {
        first: periods(e.training.learning_starts.max(1)),
        warm: 2 * periods(first_update),
        cycle: periods(e.training.steps_per_update),
        periods: Cell::new(0),
        from: Cell::new(None),
        taken: Cell::new(None),
        duration,
        stop,
    };
    Training::try_out(e, &scratch.path().join("run"), &mut clock)?;
    // A run that is over before has not been measured.
    let (periods, taken) = clock
        .taken
        .get()
        .or_else(|| clock.so_far())
        .unwrap_or_default();
    Ok((periods * environments) as f64 / taken.as_secs_f64().max(1e-3))
}

/// Counts control periods and stops after `duration`, counted from the `warm`th period on. If that is not reached within
/// `duration` from the `first` one on, in which updates begin, it counts from there, whole cycles of an update.
struct Clock<'a> {
    first: u64,
    warm: u64,
    cycle: u64,
    periods: Cell<u64>,
    /// Period and time from which it counts.
    from: Cell<Option<(u64, Instant)>>,
    /// What it has counted.
    taken: Cell<Option<(u64, Duration)>>,
    duration: Duration,
    stop: &'a dyn Fn() -> bool,
}

impl Clock<'_> {
    /// Periods since it counts, and the time they took.
    fn so_far(&self) -> Option<(u64, Duration)> {
        let (period, from) = self.from.get()?;
        Some((self.periods.get() - period, from.elapsed()))
    }
}

impl Observer for Clock<'_> {
    fn progress(&mut self, _: &Progress) {}
    fn evaluated(&mut self, _: &Progress, _: &Judgement, _: bool) {}
    fn note(&mut self, _: &str) {}
    fn stop_requested(&self) -> bool {
        // Asked before each period: so many are over.
        let over = self.periods.get();
        if over + 1 == self.first || over == self.warm {
            self.from.set(Some((over, Instant::now())));
        }
        let counted = self.so_far().filter(|(periods, time)| {
            let whole = periods.is_multiple_of(self.cycle) || *time >= 2 * self.duration;
            *time >= self.duration && *periods > 0 && whole
        });
        self.taken.set(counted);
        if counted.is_none() {
            self.periods.set(over + 1);
        }
        counted.is_some() || (self.stop)()
    }
}
