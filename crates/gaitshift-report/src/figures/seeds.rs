//! The seeds of an experiment as one series: every seed thin, their mean thick, a band around it.

use super::panels::{Panel, falls_of, omega_v, points};
use crate::group::by_group;
use crate::study::Study;
use gaitshift_experiment::Estimate;
use gaitshift_figures::Series;

/// What a figure with such series says of them.
pub(super) const OVER_SEEDS: &str = "Of several seeds the thick line is the interquartile mean of those that did not fall, the band its \
    95 % bootstrap interval; each seed is a thin line, and crosses mark commands under which any of them fell. ";

/// The studies of one experiment.
pub(super) struct Experiment<'a> {
    /// Its name with the number of seeds.
    pub label: String,
    pub seeds: Vec<&'a Study>,
}

impl<'a> Experiment<'a> {
    /// The experiments of some studies, in the order in which they first come.
    pub fn all(studies: &[&'a Study]) -> Vec<Self> {
        let named = |seeds: Vec<&'a Study>| Self {
            label: match &seeds[..] {
                [only] => only.name.clone(),
                [first, ..] => format!("{} ({} seeds)", first.group, seeds.len()),
                [] => String::new(),
            },
            seeds,
        };
        by_group(studies).into_iter().map(named).collect()
    }
}

/// What a panel shows of the steady motions of an experiment's seeds, over the range of the command.
pub(super) fn over_commands(panel: &Panel, label: &str, seeds: &[&Study]) -> Series {
    let runs = seeds.iter();
    let runs = runs.map(|s| points(&s.steady, omega_v, panel.of)).collect();
    over_seeds(label, runs).fell_at(falls_of(seeds))
}

/// Courses of several seeds over the same x as one series; that of a single seed as marks.
pub(super) fn over_seeds(label: &str, runs: Vec<Vec<(f64, f64)>>) -> Series {
    if let [only] = &runs[..] {
        return Series::marks(label, only.clone());
    }
    let mut xs: Vec<f64> = runs.iter().flatten().map(|point| point.0).collect();
    xs.sort_by(f64::total_cmp);
    xs.dedup();
    let (mut means, mut band) = (Vec::new(), Vec::new());
    for x in xs {
        let at_x = |run: &Vec<(f64, f64)>| Some(run.iter().find(|point| point.0 == x)?.1);
        let values: Vec<f64> = runs.iter().filter_map(at_x).collect();
        if let Some(Estimate { value, interval }) = Estimate::over_seeds(&values) {
            means.push((x, value));
            band.push((x, interval[0], interval[1]));
        }
    }
    Series::line(label, means).of_runs(runs).within(band)
}
