//! A number over the seeds of an experiment.

use crate::study::Study;
use gaitshift_experiment::Estimate;

/// One value per seed.
pub(crate) struct Values(pub Vec<Option<f64>>);

impl Values {
    pub fn of(studies: &[&Study], of: fn(&Study) -> Option<f64>) -> Self {
        let finite = |study: &&Study| of(study).filter(|value| value.is_finite());
        Self(studies.iter().map(finite).collect())
    }

    /// The values that there are.
    pub fn known(&self) -> Vec<f64> {
        self.0.iter().flatten().copied().collect()
    }

    /// Interquartile mean over the seeds that have a value; of one seed its value.
    pub fn estimate(&self) -> Option<Estimate> {
        Estimate::over_seeds(&self.known())
    }
}

/// Ends of an interval; of a single seed there is none.
pub(crate) fn interval(estimate: Option<Estimate>, seeds: &[Option<f64>]) -> [Option<f64>; 2] {
    let several = seeds.iter().flatten().count() > 1;
    estimate
        .filter(|_| several)
        .map_or([None; 2], |e| e.interval.map(Some))
}
