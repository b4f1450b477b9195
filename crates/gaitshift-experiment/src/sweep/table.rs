//! What the trials of a sweep reached, trial by trial and variant by variant.

use super::{Sweep, Variant};
use crate::evaluations::{EvaluatedChanges, EvaluatedMotion, Evaluation, RunName};
use crate::run_folder::is_finished;
use crate::training_error::TrainingError;
use gaitshift_analysis::GaitClass;
use gaitshift_analysis::statistics::{bootstrap_interval, interquartile_mean, mean};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Resamples of a bootstrap interval, and its confidence.
const RESAMPLES: usize = 10_000;
const CONFIDENCE: f64 = 0.95;
/// Changes of gait, out of those tried, that a controller must survive to count as changing gait.
const CHANGES_WANTED: f64 = 0.8;

/// A sweep's results.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepTable {
    /// Name of the sweep.
    pub name: String,
    /// One per variant: the reference first, without one the best first.
    pub variants: Vec<VariantSummary>,
    /// One per trial that has been evaluated at least once.
    pub trials: Vec<TrialSummary>,
}

/// The seeds of one variant together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VariantSummary {
    /// Name of the variant.
    pub variant: String,
    /// Why it was tried.
    pub reason: String,
    /// Where keys vary, each key with its value in TOML.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, String>,
    /// Number of seeds evaluated so far.
    pub seeds: usize,
    /// Number of those that took all their steps.
    pub finished: usize,
    /// Criteria met by each seed's best controller: interquartile mean and its bootstrap interval.
    pub best_met: Option<Estimate>,
    /// Criteria met on average over the last quarter of a run's evaluations, likewise.
    pub late_met: Option<Estimate>,
    /// Difference of `best_met` to the reference, seed by seed, where both are judged by as many criteria: mean and its
    /// bootstrap interval.
    pub effect: Option<Estimate>,
    /// Number of seeds whose best controller walks where that is asked for.
    pub walk: usize,
    /// Number of seeds whose best controller runs where that is asked for.
    pub run: usize,
    /// Number of seeds whose best controller makes every change asked for from at least eight of ten phases.
    pub change: usize,
    /// Number of seeds whose best controller has every gait and makes every change that is asked for.
    pub all: usize,
}

/// A figure over seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The figure.
    pub value: f64,
    /// Its bootstrap interval, 95 %.
    pub interval: [f64; 2],
}

impl Estimate {
    /// Interquartile mean over seeds with its interval; nothing without seeds.
    pub fn over_seeds(values: &[f64]) -> Option<Self> {
        estimate(values, interquartile_mean)
    }

    /// Mean over seeds with its interval; nothing without seeds.
    pub fn mean_over_seeds(values: &[f64]) -> Option<Self> {
        estimate(values, mean)
    }
}

impl std::fmt::Display for Estimate {
    /// The figure and its interval, to a tenth.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [low, high] = self.interval;
        write!(f, "{:.1} [{low:.1}, {high:.1}]", self.value)
    }
}

/// One trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrialSummary {
    /// Name of its variant.
    pub variant: String,
    /// Its seed.
    pub seed: u64,
    /// Whether it took all its steps.
    pub finished: bool,
    /// Wall-clock so far, in s.
    pub elapsed_s: f64,
    /// Number of evaluations so far.
    pub evaluations: usize,
    /// The evaluation whose controller is kept: that with the highest score, disturbed motions counted where phases randomize.
    pub best: EvaluationSummary,
    /// The last one.
    pub last: EvaluationSummary,
    /// Criteria met on average over the last quarter of the evaluations.
    pub late_met: f64,
}

/// What an evaluation says about the paper's claims.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EvaluationSummary {
    /// Environment steps.
    pub step: u64,
    /// Criteria met.
    pub met: usize,
    /// Number of criteria.
    pub criteria: usize,
    /// Whether it walks at the first command at which that is asked for.
    pub walks: bool,
    /// Whether it runs at the first command at which that is asked for.
    pub runs: bool,
    /// Gait at the first command at which walking is asked for, or at the lowest.
    pub slow_gait: String,
    /// Froude number there.
    pub slow_froude: Option<f64>,
    /// Gait at the first command at which running is asked for, or at the highest.
    pub fast_gait: String,
    /// Froude number there.
    pub fast_froude: Option<f64>,
    /// Number of commands held to the end without a fall.
    pub upright: usize,
    /// Changes from walking to running that were survived and ended in the other gait.
    pub to_running: usize,
    /// And back.
    pub to_walking: usize,
    /// Whether eight of ten tries of each change asked for were survived and ended in the other gait.
    pub changes: bool,
    /// Whether it has every gait and makes every change that is asked for.
    pub all: bool,
}

impl EvaluationSummary {
    fn of(e: &Evaluation) -> Self {
        let made = |from: GaitClass, to: GaitClass| {
            let between = e.changes.iter().filter(|c| c.gaits == [from, to]);
            between.map(EvaluatedChanges::made).sum()
        };
        let by_command =
            |a: &&EvaluatedMotion, b: &&EvaluatedMotion| a.omega_v.total_cmp(&b.omega_v);
        let walk = e.motion(GaitClass::Walking);
        let run = e.motion(GaitClass::Running);
        let slow = walk.or_else(|| e.rows.iter().min_by(by_command));
        let fast = run.or_else(|| e.rows.iter().max_by(by_command));
        let enough = |c: &EvaluatedChanges| {
            let tries = c.tries.len();
            tries > 0 && c.made() as f64 >= CHANGES_WANTED * tries as f64
        };
        let all_changes = e.changes.iter().all(enough);
        let all_gaits = e
            .rows
            .iter()
            .all(|row| row.asked.is_none_or(|asked| row.gait == asked));
        let gait = |motion: Option<&EvaluatedMotion>| {
            motion.map_or(String::new(), |motion| motion.gait.to_string())
        };
        Self {
            step: e.step,
            met: e.met,
            criteria: e.checks.len(),
            all: all_gaits && all_changes,
            changes: !e.changes.is_empty() && all_changes,
            walks: walk.is_some_and(|motion| motion.gait == GaitClass::Walking),
            runs: run.is_some_and(|motion| motion.gait == GaitClass::Running),
            slow_gait: gait(slow),
            slow_froude: slow.and_then(|r| r.froude),
            fast_gait: gait(fast),
            fast_froude: fast.and_then(|r| r.froude),
            upright: e.rows.iter().filter(|r| !r.fell).count(),
            to_running: made(GaitClass::Walking, GaitClass::Running),
            to_walking: made(GaitClass::Running, GaitClass::Walking),
        }
    }
}

impl TrialSummary {
    /// The run in a folder; nothing if it has not been evaluated yet.
    fn read(run: &Path, variant: &str, seed: u64) -> Result<Option<Self>, TrainingError> {
        let evaluations = Evaluation::read_all(run)?;
        let best = Evaluation::best(&evaluations);
        let (Some(best), Some(last)) = (best, evaluations.last()) else {
            return Ok(None);
        };
        let late = &evaluations[evaluations.len() - evaluations.len().div_ceil(4)..];
        let late: Vec<f64> = late.iter().map(|e| e.met as f64).collect();
        Ok(Some(Self {
            variant: variant.to_owned(),
            seed,
            // A damaged report is an error to whoever runs the trial; what was evaluated counts all the same.
            finished: is_finished(run).unwrap_or(false),
            elapsed_s: last.elapsed_s,
            evaluations: evaluations.len(),
            best: EvaluationSummary::of(best),
            last: EvaluationSummary::of(last),
            late_met: mean(&late).unwrap_or_default(),
        }))
    }
}

impl SweepTable {
    pub(super) fn read(sweep: &Sweep, folder: &Path) -> Result<Self, TrainingError> {
        let mut trials = Vec::new();
        for trial in &sweep.trials {
            let at = folder.join(&trial.folder);
            let variant = &sweep.variants[trial.variant].name;
            // A folder of other settings has no place in the table.
            trial.require_own(&at)?;
            trials.extend(TrialSummary::read(&at, variant, trial.experiment.seed)?);
        }
        let name = sweep.name.clone();
        Ok(Self::of(name, &sweep.variants, sweep.reference, trials))
    }

    /// The table of any runs: those of one experiment are the seeds of one variant, the first of them the reference.
    ///
    /// # Errors
    /// A folder that holds no run, or a file that cannot be read.
    pub fn of_runs(name: &str, runs: &[&Path]) -> Result<Self, TrainingError> {
        let (mut variants, mut trials): (Vec<Variant>, Vec<TrialSummary>) = Default::default();
        for (run, of) in runs.iter().zip(RunName::read_all(runs)?) {
            let RunName { name, seed, .. } = of;
            if variants.iter().all(|v| v.name != name) {
                variants.push(Variant {
                    name: name.clone(),
                    reason: String::new(),
                    values: Vec::new(),
                });
            }
            trials.extend(TrialSummary::read(run, &name, seed)?);
        }
        Ok(Self::of(name.to_owned(), &variants, true, trials))
    }

    fn of(
        name: String,
        variants: &[Variant],
        has_reference: bool,
        trials: Vec<TrialSummary>,
    ) -> Self {
        let reference = variants.first().filter(|_| has_reference);
        let reference_trials = reference.map(|v| of_variant(&trials, &v.name));
        let reference_trials = reference_trials.unwrap_or_default();
        let mut summaries: Vec<VariantSummary> = variants
            .iter()
            .map(|variant| {
                let own = of_variant(&trials, &variant.name);
                let count = |holds: &dyn Fn(&EvaluationSummary) -> bool| {
                    own.iter().filter(|t| holds(&t.best)).count()
                };
                let figures = |of: &dyn Fn(&TrialSummary) -> f64| {
                    let values: Vec<f64> = own.iter().map(|t| of(t)).collect();
                    Estimate::over_seeds(&values)
                };
                let differences: Vec<f64> = own
                    .iter()
                    .filter_map(|t| {
                        let same = reference_trials.iter().find(|r| r.seed == t.seed)?;
                        // So many of other criteria are another number.
                        if t.best.criteria != same.best.criteria {
                            return None;
                        }
                        Some(t.best.met as f64 - same.best.met as f64)
                    })
                    .collect();
                let is_reference = reference.is_some_and(|v| v.name == variant.name);
                VariantSummary {
                    variant: variant.name.clone(),
                    reason: variant.reason.clone(),
                    values: variant.values.iter().cloned().collect(),
                    seeds: own.len(),
                    finished: own.iter().filter(|t| t.finished).count(),
                    best_met: figures(&|t| t.best.met as f64),
                    late_met: figures(&|t| t.late_met),
                    effect: estimate(&differences, mean).filter(|_| !is_reference),
                    walk: count(&|e| e.walks),
                    run: count(&|e| e.runs),
                    change: count(&|e| e.changes),
                    all: count(&|e| e.all),
                }
            })
            .collect();
        if !has_reference {
            let met = |v: &VariantSummary| v.best_met.map_or(f64::NEG_INFINITY, |e| e.value);
            summaries.sort_by(|a, b| met(b).total_cmp(&met(a)));
        }
        Self {
            name,
            variants: summaries,
            trials,
        }
    }

    /// As Markdown: the variants, then the trials.
    pub fn to_markdown(&self) -> String {
        let mut text = format!(
            "# Sweep {}\n\n\
             Seeds are the unit. `best` is the controller of a run that its evaluations score highest, `late` the mean \
             over the last quarter of its evaluations; both are criteria met, interquartile mean over seeds with a \
             95 % bootstrap interval. `effect` is the difference of `best` to the reference, the first \
             variant given, seed by seed; settings drawn at random have none and stand best first. `walks`, \
             `runs`, `changes`, `all` count seeds whose best controller does so.\n\n\
             | variant | seeds | finished | best | late | effect | walks | runs | changes | all |\n\
             | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
            self.name
        );
        let shown = |e: &Option<Estimate>| e.map_or("–".to_owned(), |e| e.to_string());
        for v in &self.variants {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                cell(&v.variant),
                v.seeds,
                v.finished,
                shown(&v.best_met),
                shown(&v.late_met),
                shown(&v.effect),
                v.walk,
                v.run,
                v.change,
                v.all
            );
        }
        text.push_str(
            "\nEach trial: its best and its last evaluation. Commands upright are out of those tried, changes of gait \
             (up, down) out of those tried.\n\n\
             | variant | seed | evaluation | step, M | met | slow | Fr | fast | Fr | upright | up | down |\n\
             | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
        );
        for t in &self.trials {
            for (name, e) in [("best", &t.best), ("last", &t.last)] {
                let froude = |f: Option<f64>| f.map_or("–".to_owned(), |f| format!("{f:.2}"));
                let _ = writeln!(
                    text,
                    "| {} | {} | {} | {:.2} | {} | {} | {} | {} | {} | {} | {} | {} |",
                    cell(&t.variant),
                    t.seed,
                    name,
                    e.step as f64 / 1e6,
                    e.met,
                    e.slow_gait,
                    froude(e.slow_froude),
                    e.fast_gait,
                    froude(e.fast_froude),
                    e.upright,
                    e.to_running,
                    e.to_walking
                );
            }
        }
        text
    }
}

/// A name within a row of Markdown's tables.
fn cell(name: &str) -> String {
    name.replace('|', "\\|")
}

fn of_variant<'a>(trials: &'a [TrialSummary], name: &str) -> Vec<&'a TrialSummary> {
    trials.iter().filter(|t| t.variant == name).collect()
}

fn estimate(values: &[f64], statistic: fn(&[f64]) -> Option<f64>) -> Option<Estimate> {
    let value = statistic(values)?;
    let (low, high) = bootstrap_interval(values, statistic, CONFIDENCE, RESAMPLES, 1)?;
    Some(Estimate {
        value,
        interval: [low, high],
    })
}
