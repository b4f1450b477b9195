//! The claims of the paper and of its journal version, and what was found. Verdicts are computed.

mod journal;
mod paper;

use crate::headline::by_command;
use crate::recorded::RecordedExperiment;
use crate::seeds::{Values, interval};
use crate::source::Source;
use crate::study::{Change, Steady, Study};
use gaitshift_analysis::statistics::{mean, median, wilson_interval};
use gaitshift_analysis::{GaitClass, GaitSummary};
use gaitshift_experiment::Estimate;
use serde::Serialize;

/// Numbers this near to the papers', as a share of theirs, count as theirs.
const NEAR: f64 = 0.1;
/// Numbers further than this factor from the papers' do not only differ.
const FAR: f64 = 2.0;
/// Amount from which a correlation counts as in phase or in antiphase.
const CLEAR: f64 = 0.5;
/// Ratio of an ablation's number to the method's from which it is clearly more or less.
const MORE: Rule = Rule::More(1.25);
const LESS: Rule = Rule::Less(0.8);
/// Slower than this a motion does not advance, in m/s, as in the gait rule.
const ADVANCES_M_PER_S: f64 = 0.1;

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It is so here, too.
    Holds,
    /// The number is theirs, but the seeds scatter too much to say so.
    Undecided,
    /// It is so in part, or with another number.
    Differs,
    /// It is not so here.
    Fails,
    /// The subjects tell nothing about it.
    NotMeasured,
}

impl Verdict {
    /// All, the best first.
    pub const ALL: [Self; 5] = [
        Self::Holds,
        Self::Undecided,
        Self::Differs,
        Self::Fails,
        Self::NotMeasured,
    ];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Undecided => "undecided",
            Verdict::Differs => "differs",
            Verdict::Fails => "fails",
            Verdict::NotMeasured => "not measured",
        }
    }
}

/// By which rule a claim is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rule {
    /// A number: it holds within a tenth of theirs, and differs within a factor of two. Where the interval over seeds is wider than
    /// that tolerance, it is undecided instead of holding.
    Near(f64),
    /// It holds at this or less, differs up to twice that.
    AtMost(f64),
    /// It holds at this or more, differs down to half of that.
    AtLeast(f64),
    /// A share of attempts: it holds at 1, differs between, fails at 0.
    Always,
    /// A correlation: it holds from -0.5 down, differs while negative, fails otherwise.
    Antiphase,
    /// A correlation: it holds from 0.5 up, differs while positive, fails otherwise.
    InPhase,
    /// A ratio that is more than 1: it holds from this up, differs above 1, fails otherwise.
    More(f64),
    /// A ratio that is less than 1: it holds from this down, differs below 1, fails otherwise.
    Less(f64),
}

/// A claim.
struct Claim {
    /// Which version makes it.
    source: &'static str,
    /// The experiment that it is about, by the name in `gaitshift reproduce`.
    experiment: &'static str,
    /// The experiment whose number the measured one is divided by, if it is a ratio.
    against: Option<&'static str>,
    /// What is claimed.
    claim: &'static str,
    /// Its number or words.
    theirs: &'static str,
    rule: Rule,
    /// What is measured of a seed; nothing if the seed lacks what the claim is about.
    of: fn(&Study) -> Option<f64>,
    /// Whether the seed tells anything about it.
    about: fn(&Study) -> bool,
    /// What shows it.
    shown_by: Source,
}

impl Claim {
    /// A claim about the whole method, which other experiments can be set beside.
    const fn new(
        source: &'static str,
        claim: &'static str,
        theirs: &'static str,
        rule: Rule,
        of: fn(&Study) -> Option<f64>,
        shown_by: Source,
    ) -> Self {
        Self {
            source,
            experiment: source,
            against: None,
            claim,
            theirs,
            rule,
            of,
            about: |_| true,
            shown_by,
        }
    }

    /// The same about an experiment that leaves out something.
    const fn of_ablation(mut self, experiment: &'static str) -> Self {
        self.experiment = experiment;
        self
    }

    /// The same as a ratio to the number of the method itself.
    const fn against_the_method(mut self) -> Self {
        self.against = Some(self.source);
        self
    }

    /// The same, only of seeds with a log of their training.
    const fn of_training(mut self) -> Self {
        self.about = |study| study.late_falls.is_some();
        self
    }

    /// Whether it is about what is left out, so that other experiments tell nothing about it.
    fn is_of_ablation(&self) -> bool {
        self.experiment != self.source
    }

    /// What the seeds of an experiment say to it; `reference` are those of the experiment that it is compared with.
    fn judge(&self, experiment: &str, studies: &[&Study], reference: &[&Study]) -> Finding {
        let told: Vec<&Study> = studies
            .iter()
            .copied()
            .filter(|s| (self.about)(s))
            .collect();
        let mut values = Values::of(&told, self.of);
        let mut told_anything = !told.is_empty();
        if self.against.is_some() {
            let reference = Values::of(reference, self.of).estimate().map(|e| e.value);
            told_anything &= reference.is_some_and(|value| value != 0.0);
            for value in &mut values.0 {
                *value = value.zip(reference).map(|(own, method)| own / method);
            }
        }
        self.found(experiment, values, told_anything)
    }

    /// What recorded runs said when they were measured, if they did.
    fn recall(&self, recorded: &RecordedExperiment) -> Option<Finding> {
        let values = recorded.claims.get(self.claim)?;
        Some(Finding {
            recorded: true,
            ..self.found(&recorded.name, Values(values.clone()), true)
        })
    }

    fn found(&self, experiment: &str, values: Values, told: bool) -> Finding {
        let estimate = match self.rule {
            Rule::Always => share_of_seeds(&values),
            _ => values.estimate(),
        };
        let verdict = if told {
            self.rule.verdict(&values, estimate.as_ref())
        } else {
            Verdict::NotMeasured
        };
        Finding {
            experiment: experiment.to_owned(),
            seeds: values.0,
            estimate,
            verdict,
            recorded: false,
        }
    }
}

/// What the seeds of one experiment say to a claim.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The experiment.
    pub experiment: String,
    /// One value per seed; nothing where a seed lacks what the claim is about.
    pub seeds: Vec<Option<f64>>,
    /// Over the seeds: interquartile mean with bootstrap interval; of shares the mean, with Wilson's interval where each is 0 or 1.
    pub estimate: Option<Estimate>,
    /// The verdict.
    pub verdict: Verdict,
    /// Whether the values were measured earlier, of runs that are not on this page.
    pub recorded: bool,
}

impl Finding {
    /// The interval, where there are several seeds.
    pub fn interval(&self) -> [Option<f64>; 2] {
        interval(self.estimate, &self.seeds)
    }
}

/// A claim and what was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// Which version makes the claim.
    pub source: &'static str,
    /// What is claimed.
    pub claim: &'static str,
    /// Its number or words.
    pub theirs: &'static str,
    /// The rule in words.
    pub rule: String,
    /// What the experiment that the claim is about says.
    pub own: Finding,
    /// What recorded runs of the same experiment with other learners say, one for each learner.
    pub other_learners: Vec<Finding>,
    /// What every other method says: experiments that no claim is about, such as the recipe `fast`.
    pub beside: Vec<Finding>,
    #[serde(skip)]
    pub(crate) shown_by: Source,
}

impl Judged {
    /// Everything that is found.
    pub(crate) fn findings(&self) -> impl Iterator<Item = &Finding> {
        let own = std::iter::once(&self.own);
        own.chain(&self.other_learners).chain(&self.beside)
    }
}

impl Rule {
    fn words(self) -> String {
        match self {
            Rule::Near(theirs) => format!("within 10 % of {theirs}"),
            Rule::AtMost(bound) => format!("at most {bound}"),
            Rule::AtLeast(bound) => format!("at least {bound}"),
            Rule::Always => "every attempt".to_owned(),
            Rule::Antiphase => format!("correlation of at most \u{2212}{CLEAR}"),
            Rule::InPhase => format!("correlation of at least {CLEAR}"),
            Rule::More(bound) => format!("at least {bound}, differs above 1"),
            Rule::Less(bound) => format!("at most {bound}, differs below 1"),
        }
    }

    fn verdict(self, values: &Values, estimate: Option<&Estimate>) -> Verdict {
        let Some(estimate) = estimate else {
            return Verdict::Fails;
        };
        // What fewer than half of the seeds have at all is no result of the method.
        if 2 * values.known().len() < values.0.len() {
            return Verdict::Fails;
        }
        let value = estimate.value;
        let graded = |holds: bool, differs: bool| match (holds, differs) {
            (true, _) => Verdict::Holds,
            (false, true) => Verdict::Differs,
            (false, false) => Verdict::Fails,
        };
        match self {
            Rule::Near(theirs) => {
                let tolerance = NEAR * theirs.abs();
                let near = (value - theirs).abs() <= tolerance;
                let [low, high] = estimate.interval;
                if near && values.known().len() > 1 && high - low > 2.0 * tolerance {
                    return Verdict::Undecided;
                }
                let far = value > FAR * theirs || FAR * value < theirs;
                graded(near, !far)
            }
            Rule::AtMost(bound) => graded(value <= bound, value <= FAR * bound),
            Rule::AtLeast(bound) => graded(value >= bound, FAR * value >= bound),
            Rule::Always => graded(value >= 1.0, value > 0.0),
            Rule::Antiphase => graded(value <= -CLEAR, value < 0.0),
            Rule::InPhase => graded(value >= CLEAR, value > 0.0),
            Rule::More(bound) => graded(value >= bound, value > 1.0),
            Rule::Less(bound) => graded(value <= bound, value < 1.0),
        }
    }
}

fn gait_at(study: &Study, omega_v: f64, gait: GaitClass) -> Option<f64> {
    Some(f64::from(u8::from(study.at(omega_v)?.gait == gait)))
}

fn is_gait(row: &Steady) -> bool {
    matches!(row.summary.gait, GaitClass::Walking | GaitClass::Running)
}

/// Whether a motion gets forward without a fall.
fn advances(row: &Steady) -> bool {
    let speed_m_per_s = row.summary.speed_m_per_s;
    !row.summary.fell && speed_m_per_s.is_some_and(|speed| speed >= ADVANCES_M_PER_S)
}

/// The steady motions under commands from `low` to `high`.
fn within(study: &Study, [low, high]: [f64; 2]) -> Vec<&Steady> {
    by_command(&study.steady, [low, high]).collect()
}

/// Of some motions the share that has a property; nothing without motions.
fn share(rows: &[&Steady], has: impl Fn(&Steady) -> bool) -> Option<f64> {
    let having = rows.iter().filter(|row| has(row)).count();
    (!rows.is_empty()).then(|| having as f64 / rows.len() as f64)
}

/// Share of the changes that lead from one gait to the other.
fn led(changes: &[Change], from: GaitClass, to: GaitClass) -> Option<f64> {
    let led = changes.iter().filter(|c| c.leads(from, to)).count();
    // A motion that does not last has no phases from which to change: that is none of the attempts.
    Some(led as f64 / changes.len().max(1) as f64)
}

/// Median number of steps of the changes that lead from one gait to the other.
fn led_steps(changes: &[Change]) -> Option<f64> {
    let steps = changes.iter().filter_map(|c| c.steps);
    let steps: Vec<f64> = steps.map(|n| n as f64).collect();
    median(&steps)
}

/// Median of a quantity over some motions.
fn typical(rows: &[&Steady], of: fn(&GaitSummary) -> Option<f64>) -> Option<f64> {
    let values: Vec<f64> = rows.iter().filter_map(|row| of(&row.summary)).collect();
    median(&values)
}

/// Observations in the order of how little noise they bear: the level at which attempts succeed half of the time, summed up
/// as the successes over all levels.
pub(crate) fn by_sensitivity(study: &Study, omega_v: f64) -> Vec<&str> {
    let mut scores: Vec<(&str, usize)> = Vec::new();
    for row in study.noise.iter().filter(|row| row.omega_v == omega_v) {
        match scores.iter_mut().find(|(name, _)| *name == row.observation) {
            Some((_, score)) => *score += row.successes,
            None => scores.push((&row.observation, row.successes)),
        }
    }
    scores.sort_by_key(|&(_, score)| score);
    scores.into_iter().map(|(name, _)| name).collect()
}

/// The method whose claims are about an experiment: its own, or the one that it leaves a part of. Experiments without one are
/// methods of their own, to be set beside.
pub(crate) fn method_of(experiment: &str) -> Option<&'static str> {
    let claim = claims().find(|claim| claim.experiment == experiment);
    claim.map(|claim| claim.source)
}

/// Whether claims are about an experiment.
pub(crate) fn is_claimed(experiment: &str) -> bool {
    method_of(experiment).is_some()
}

/// All claims: those of the paper first.
fn claims() -> impl Iterator<Item = &'static Claim> {
    paper::CLAIMS.iter().chain(&journal::CLAIMS)
}

/// Every claim, what the seeds of its experiment say to it, and what those of every method beside it say. Of experiments that are
/// not among the studies, and of those with other learners, that is what is recorded.
pub fn judge_claims(studies: &[&Study], recorded: &[RecordedExperiment]) -> Vec<Judged> {
    let of_group = |name: &str| -> Vec<&Study> {
        let own = studies.iter().copied().filter(|s| s.group == name);
        own.collect()
    };
    let mut others: Vec<&str> = Vec::new();
    let measured = studies.iter().map(|study| study.group.as_str());
    let methods = recorded.iter().filter(|r| r.repeats.is_none());
    for name in measured.chain(methods.map(|r| r.name.as_str())) {
        if !is_claimed(name) && !others.contains(&name) {
            others.push(name);
        }
    }
    let learners = other_learners(recorded);
    let judged = |claim: &Claim| {
        let reference = claim.against.map(of_group).unwrap_or_default();
        let finding = |name: &str, studies: &[&Study]| {
            let mut known = recorded.iter().filter(|r| r.name == name);
            match known.find_map(|r| claim.recall(r)) {
                Some(recalled) if studies.is_empty() => recalled,
                _ => claim.judge(name, studies, &reference),
            }
        };
        let with_learner = |learner: &str| {
            let repeats = |r: &&RecordedExperiment| {
                r.repeats.as_deref() == Some(claim.experiment)
                    && r.learner.as_deref() == Some(learner)
            };
            let found = recorded.iter().find(repeats).and_then(|r| claim.recall(r));
            found.unwrap_or_else(|| {
                claim.judge(&format!("{}, {learner}", claim.experiment), &[], &[])
            })
        };
        let own = finding(claim.experiment, &of_group(claim.experiment));
        let beside = others.iter().map(|&name| {
            // A method that leaves out nothing tells nothing about what is left out.
            let told = if claim.is_of_ablation() {
                Vec::new()
            } else {
                of_group(name)
            };
            finding(name, &told)
        });
        Judged {
            source: claim.source,
            claim: claim.claim,
            theirs: claim.theirs,
            rule: claim.rule.words(),
            own,
            other_learners: learners
                .iter()
                .map(|learner| with_learner(learner))
                .collect(),
            beside: beside.collect(),
            shown_by: claim.shown_by,
        }
    };
    claims().map(judged).collect()
}

/// The learners of recorded runs that repeat an experiment, each once.
pub(crate) fn other_learners(recorded: &[RecordedExperiment]) -> Vec<&str> {
    let mut learners = Vec::new();
    for r in recorded.iter().filter(|r| r.repeats.is_some()) {
        match r.learner.as_deref() {
            Some(learner) if !learners.contains(&learner) => learners.push(learner),
            _ => {}
        }
    }
    learners
}

/// Mean of shares: with Wilson's interval where every seed does it always or never, otherwise with that of a bootstrap.
fn share_of_seeds(values: &Values) -> Option<Estimate> {
    let known = values.known();
    let always = known.iter().filter(|&&share| share >= 1.0).count();
    let never = known.iter().filter(|&&share| share <= 0.0).count();
    if always + never < known.len() {
        return Estimate::mean_over_seeds(&known);
    }
    let (low, high) = wilson_interval(always, known.len())?;
    Some(Estimate {
        value: mean(&known)?,
        interval: [low, high],
    })
}
