//! The claims of the paper and of its journal version, and what was found. Verdicts are computed.

use crate::headline::{greatest, least};
use crate::seeds::{Values, interval};
use crate::study::{Change, Steady, Study};
use gaitshift_analysis::GaitClass;
use gaitshift_analysis::statistics::{median, wilson_interval};
use gaitshift_experiment::Estimate;
use serde::Serialize;

/// Numbers this near to the papers', as a share of theirs, count as theirs.
const NEAR: f64 = 0.1;
/// Numbers further than this factor from the papers' do not only differ.
const FAR: f64 = 2.0;
/// Amount from which a correlation counts as in phase or in antiphase.
const CLEAR: f64 = 0.5;
/// Names of the experiments that some claims are about; `gaitshift reproduce` runs them.
const WITHOUT_PHASE_ONE: &str = "paper, without phase I";
const WITHOUT_ENERGY_TERM: &str = "paper, without the energy term";

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It is so here, too.
    Holds,
    /// It is so in part, or with another number.
    Differs,
    /// It is not so here.
    Fails,
    /// The subjects tell nothing about it.
    NotMeasured,
}

impl Verdict {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Differs => "differs",
            Verdict::Fails => "fails",
            Verdict::NotMeasured => "not measured",
        }
    }
}

/// By which rule a claim is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rule {
    /// A number: it holds within a tenth of theirs, or if the interval over seeds holds theirs; differs within a factor of two.
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
}

/// A claim.
#[derive(Debug, Clone, Copy)]
pub struct Claim {
    /// Which version makes it.
    pub source: &'static str,
    /// What is claimed.
    pub claim: &'static str,
    /// Its number or words.
    pub theirs: &'static str,
    rule: Rule,
    /// What is measured of a seed; nothing if the seed lacks what the claim is about.
    of: fn(&Study) -> Option<f64>,
    /// Whether the seeds of an experiment tell anything about it.
    about: fn(&Study) -> bool,
    /// The command that shows it.
    pub command: &'static str,
}

/// A claim and what was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Which version makes the claim.
    pub source: &'static str,
    /// What is claimed.
    pub claim: &'static str,
    /// Its number or words.
    pub theirs: &'static str,
    /// One value per seed; nothing where a seed lacks what the claim is about.
    pub seeds: Vec<Option<f64>>,
    /// Over the seeds: interquartile mean with bootstrap interval; of shares the mean with Wilson's interval.
    pub estimate: Option<Estimate>,
    /// The rule in words.
    pub rule: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The command that shows it.
    pub command: &'static str,
}

impl Finding {
    /// The interval, where there are several seeds.
    pub fn interval(&self) -> [Option<f64>; 2] {
        interval(self.estimate, &self.seeds)
    }
}

impl Rule {
    fn words(self) -> String {
        match self {
            Rule::Near(theirs) => {
                format!("within 10 % of {theirs}, or {theirs} within the interval")
            }
            Rule::AtMost(bound) => format!("at most {bound}"),
            Rule::AtLeast(bound) => format!("at least {bound}"),
            Rule::Always => "every attempt".to_owned(),
            Rule::Antiphase => "correlation of at most -0.5".to_owned(),
            Rule::InPhase => "correlation of at least 0.5".to_owned(),
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
        let (value, [low, high]) = (estimate.value, estimate.interval);
        let graded = |holds: bool, differs: bool| match (holds, differs) {
            (true, _) => Verdict::Holds,
            (false, true) => Verdict::Differs,
            (false, false) => Verdict::Fails,
        };
        match self {
            Rule::Near(theirs) => {
                let near = (value - theirs).abs() <= NEAR * theirs.abs();
                let within = values.known().len() > 1 && (low..=high).contains(&theirs);
                let far = value > FAR * theirs || FAR * value < theirs;
                graded(near || within, !far)
            }
            Rule::AtMost(bound) => graded(value <= bound, value <= FAR * bound),
            Rule::AtLeast(bound) => graded(value >= bound, FAR * value >= bound),
            Rule::Always => graded(value >= 1.0, value > 0.0),
            Rule::Antiphase => graded(value <= -CLEAR, value < 0.0),
            Rule::InPhase => graded(value >= CLEAR, value > 0.0),
        }
    }
}

fn any(_: &Study) -> bool {
    true
}

fn has_episodes(study: &Study) -> bool {
    study.late_falls.is_some()
}

fn gait_at(study: &Study, omega_v: f64, gait: GaitClass) -> Option<f64> {
    Some(f64::from(u8::from(study.at(omega_v)?.gait == gait)))
}

/// The summary at a command if the motion is that gait.
fn walk_at_0(study: &Study) -> Option<&gaitshift_analysis::GaitSummary> {
    study.at(0.0).filter(|s| s.gait == GaitClass::Walking)
}

fn run_at_3(study: &Study) -> Option<&gaitshift_analysis::GaitSummary> {
    study.at(3.0).filter(|s| s.gait == GaitClass::Running)
}

fn share(changes: &[Change], from: GaitClass, to: GaitClass) -> Option<f64> {
    let led = changes.iter().filter(|c| c.leads(from, to)).count();
    // A motion that does not last has no phases from which to change: that is none of the attempts.
    Some(led as f64 / changes.len().max(1) as f64)
}

/// Median number of steps of the changes that lead from one gait to the other.
fn steps(changes: &[Change]) -> Option<f64> {
    let steps: Vec<f64> = changes
        .iter()
        .filter_map(|c| c.steps)
        .map(|n| n as f64)
        .collect();
    median(&steps)
}

/// Froude numbers, or speeds, of the motions that neither fell nor stand, from 0 up as the papers' ranges are.
fn moving(study: &Study) -> impl Iterator<Item = &Steady> {
    study
        .steady
        .iter()
        .filter(|row| matches!(row.summary.gait, GaitClass::Walking | GaitClass::Running))
}

fn highest_step_m(study: &Study, omega_v: f64) -> Option<f64> {
    let mut passed = 0.0;
    for row in study
        .step_heights
        .iter()
        .filter(|row| row.omega_v == omega_v && row.height_m > 0.0 && !row.by_turns)
    {
        if row.successes < row.trials {
            break;
        }
        passed = row.height_m;
    }
    study
        .at(omega_v)
        .filter(|s| !s.fell)
        .map(|_| 100.0 * passed)
}

/// Observations in the order of how little noise they bear: the level at which attempts succeed half of the time, summed up
/// as the successes over all levels.
pub(crate) fn by_sensitivity(study: &Study, omega_v: f64) -> Vec<&'static str> {
    let mut scores: Vec<(&'static str, usize)> = Vec::new();
    for row in study.noise.iter().filter(|row| row.omega_v == omega_v) {
        match scores.iter_mut().find(|(name, _)| *name == row.observation) {
            Some((_, score)) => *score += row.successes,
            None => scores.push((row.observation, row.successes)),
        }
    }
    scores.sort_by_key(|&(_, score)| score);
    scores.into_iter().map(|(name, _)| name).collect()
}

/// Of the observations named, the share that is among as many of the most sensitive ones.
fn most_sensitive(study: &Study, omega_v: f64, named: &[&str]) -> Option<f64> {
    let order = by_sensitivity(study, omega_v);
    let top = order.get(..named.len())?;
    Some(named.iter().filter(|name| top.contains(name)).count() as f64 / named.len() as f64)
}

/// All claims: those of the paper first.
#[rustfmt::skip]
const CLAIMS: [Claim; 36] = [
    Claim { source: "paper", claim: "it walks at ω_v = 0", theirs: "double support", rule: Rule::Always, of: |s| gait_at(s, 0.0, GaitClass::Walking), about: any, command: "gaitshift evaluate --omega-v 0" },
    Claim { source: "paper", claim: "it runs at ω_v = 3", theirs: "flight", rule: Rule::Always, of: |s| gait_at(s, 3.0, GaitClass::Running), about: any, command: "gaitshift evaluate --omega-v 3" },
    Claim { source: "paper", claim: "0 → 3 within 0.4 s leads from the walk to the run (phases of the stride)", theirs: "yes (Fig. 3)", rule: Rule::Always, of: |s| share(&s.to_running, GaitClass::Walking, GaitClass::Running), about: any, command: "gaitshift evaluate --criteria" },
    Claim { source: "paper", claim: "3 → 0 within 0.4 s leads from the run to the walk (phases of the stride)", theirs: "yes (Fig. 3)", rule: Rule::Always, of: |s| share(&s.to_walking, GaitClass::Running, GaitClass::Walking), about: any, command: "gaitshift evaluate --criteria" },
    Claim { source: "paper", claim: "Froude number at ω_v = 0", theirs: "0.22", rule: Rule::Near(0.22), of: |s| walk_at_0(s)?.froude, about: any, command: "gaitshift evaluate --omega-v 0" },
    Claim { source: "paper", claim: "Froude number at ω_v = 3", theirs: "0.93", rule: Rule::Near(0.93), of: |s| run_at_3(s)?.froude, about: any, command: "gaitshift evaluate --omega-v 3" },
    Claim { source: "paper", claim: "cost of transport (8) walking, ω_v = 0", theirs: "0.342", rule: Rule::Near(0.342), of: |s| walk_at_0(s)?.cost_of_transport, about: any, command: "gaitshift evaluate --omega-v 0" },
    Claim { source: "paper", claim: "cost of transport (8) running, ω_v = 3", theirs: "0.347", rule: Rule::Near(0.347), of: |s| run_at_3(s)?.cost_of_transport, about: any, command: "gaitshift evaluate --omega-v 3" },
    Claim { source: "paper", claim: "the cost of walking is a small part of ASIMO's 3.2", theirs: "0.342 against 3.2", rule: Rule::AtMost(0.342), of: |s| walk_at_0(s)?.cost_of_transport, about: any, command: "gaitshift evaluate --omega-v 0" },
    Claim { source: "paper", claim: "least Froude number of a walk or run", theirs: "0.16", rule: Rule::Near(0.16), of: |s| moving(s).filter_map(|r| r.summary.froude).reduce(f64::min), about: any, command: "gaitshift evaluate --omega-v=-0.5:3.5:0.05" },
    Claim { source: "paper", claim: "greatest Froude number of a walk or run", theirs: "0.93", rule: Rule::Near(0.93), of: |s| moving(s).filter_map(|r| r.summary.froude).reduce(f64::max), about: any, command: "gaitshift evaluate --omega-v=-0.5:3.5:0.05" },
    Claim { source: "paper", claim: "walking: kinetic and potential energy in antiphase", theirs: "antiphase", rule: Rule::Antiphase, of: |s| walk_at_0(s)?.kinetic_potential_correlation, about: any, command: "gaitshift evaluate --omega-v 0 --json" },
    Claim { source: "paper", claim: "running, single support: kinetic and potential energy in phase", theirs: "in phase", rule: Rule::InPhase, of: |s| run_at_3(s)?.kinetic_potential_correlation_single_support, about: any, command: "gaitshift evaluate --omega-v 3 --json" },
    Claim { source: "paper", claim: "running, single support: elastic and kinetic energy in antiphase", theirs: "antiphase", rule: Rule::Antiphase, of: |s| run_at_3(s)?.elastic_kinetic_correlation_single_support, about: any, command: "gaitshift evaluate --omega-v 3 --json" },
    Claim { source: "paper", claim: "running, single support: elastic and potential energy in antiphase", theirs: "antiphase", rule: Rule::Antiphase, of: |s| run_at_3(s)?.elastic_potential_correlation_single_support, about: any, command: "gaitshift evaluate --omega-v 3 --json" },
    Claim { source: "paper", claim: "running, single support: leg springs' and kinetic energy in antiphase", theirs: "antiphase (all springs)", rule: Rule::Antiphase, of: |s| run_at_3(s)?.leg_spring_kinetic_correlation_single_support, about: any, command: "gaitshift evaluate --omega-v 3 --json" },
    Claim { source: "paper", claim: "running, single support: leg springs' and potential energy in antiphase", theirs: "antiphase (all springs)", rule: Rule::Antiphase, of: |s| run_at_3(s)?.leg_spring_potential_correlation_single_support, about: any, command: "gaitshift evaluate --omega-v 3 --json" },
    Claim { source: "paper", claim: "Fig. 4: with phase I almost no late episode ends in a fall (share of falls, last fifth)", theirs: "almost none", rule: Rule::AtMost(0.1), of: |s| s.late_falls, about: |s| has_episodes(s) && s.group == "paper", command: "gaitshift reproduce" },
    Claim { source: "paper", claim: "Fig. 4: without phase I most late episodes end in a fall", theirs: "returns near 0", rule: Rule::AtLeast(0.5), of: |s| s.late_falls, about: |s| has_episodes(s) && s.group == WITHOUT_PHASE_ONE, command: "gaitshift reproduce" },
    Claim { source: "paper", claim: "without the energy term there is no walk at 0", theirs: "drags its legs, hops", rule: Rule::Always, of: |s| gait_at(s, 0.0, GaitClass::Walking).map(|walks| 1.0 - walks), about: |s| s.group == WITHOUT_ENERGY_TERM, command: "gaitshift reproduce" },
    Claim { source: "paper", claim: "without the energy term there is no run at 3", theirs: "drags its legs, hops", rule: Rule::Always, of: |s| gait_at(s, 3.0, GaitClass::Running).map(|runs| 1.0 - runs), about: |s| s.group == WITHOUT_ENERGY_TERM, command: "gaitshift reproduce" },
    Claim { source: "journal", claim: "least speed (m/s)", theirs: "0.51", rule: Rule::Near(0.51), of: |s| moving(s).filter_map(|r| r.summary.speed_m_per_s).reduce(f64::min), about: any, command: "gaitshift evaluate --omega-v=-0.5:3.5:0.05" },
    Claim { source: "journal", claim: "greatest speed (m/s)", theirs: "3.02", rule: Rule::Near(3.02), of: |s| moving(s).filter_map(|r| r.summary.speed_m_per_s).reduce(f64::max), about: any, command: "gaitshift evaluate --omega-v=-0.5:3.5:0.05" },
    Claim { source: "journal", claim: "walking up to Froude number", theirs: "0.22 (0.63 m/s)", rule: Rule::Near(0.225), of: |s| greatest(s, GaitClass::Walking), about: any, command: "gaitshift report" },
    Claim { source: "journal", claim: "running from Froude number", theirs: "0.65 (1.81 m/s)", rule: Rule::Near(0.646), of: |s| least(s, GaitClass::Running), about: any, command: "gaitshift report" },
    Claim { source: "journal", claim: "a transitional gait: steady motions that are neither walk nor run cover the Froude numbers between the two (share covered)", theirs: "0.63 to 1.81 m/s", rule: Rule::AtLeast(0.5), of: transitional, about: any, command: "gaitshift report" },
    Claim { source: "journal", claim: "greatest command without a fall", theirs: "2.93", rule: Rule::AtLeast(2.93), of: |s| s.steady.iter().filter(|r| !r.summary.fell).map(|r| r.omega_v).reduce(f64::max), about: any, command: "gaitshift evaluate --omega-v=-0.5:3.5:0.05" },
    Claim { source: "journal", claim: "steps from walk to run (median)", theirs: "under 2", rule: Rule::AtMost(2.0), of: |s| steps(&s.to_running), about: any, command: "gaitshift transition" },
    Claim { source: "journal", claim: "steps from run to walk (median)", theirs: "about 4", rule: Rule::Near(4.0), of: |s| steps(&s.to_walking), about: any, command: "gaitshift transition --from 3 --to 0" },
    Claim { source: "journal", claim: "walk, run and walk again in one motion", theirs: "shown", rule: Rule::Always, of: |s| Some(f64::from(u8::from(s.walk_run_walk == [GaitClass::Walking, GaitClass::Running, GaitClass::Walking]))), about: any, command: "gaitshift demo" },
    Claim { source: "journal", claim: "single step up survived walking (cm)", theirs: "1.0", rule: Rule::AtLeast(1.0), of: |s| highest_step_m(s, 0.0), about: any, command: "gaitshift evaluate --omega-v 0 --step-up 0.01@5" },
    Claim { source: "journal", claim: "single step up survived running (cm)", theirs: "0.8", rule: Rule::AtLeast(0.8), of: |s| highest_step_m(s, 3.0), about: any, command: "gaitshift evaluate --omega-v 3 --step-up 0.008@5" },
    Claim { source: "journal", claim: "most sensitive to noise walking: pitch rate, hip angle and its rate (share of the three)", theirs: "these three", rule: Rule::Always, of: |s| most_sensitive(s, 0.0, &["theta_velocity_rad_per_s", "phi_rad", "phi_velocity_rad_per_s"]), about: any, command: "gaitshift stress" },
    Claim { source: "journal", claim: "most sensitive to noise running: the same, pitch and h (share of the five)", theirs: "these five", rule: Rule::Always, of: |s| most_sensitive(s, 3.0, &["theta_velocity_rad_per_s", "phi_rad", "phi_velocity_rad_per_s", "theta_rad", "h_m"]), about: any, command: "gaitshift stress" },
    Claim { source: "journal", claim: "with the full range from the start it only walks", theirs: "no run", rule: Rule::Always, of: |s| gait_at(s, 3.0, GaitClass::Running).map(|runs| 1.0 - runs), about: |s| s.group == "journal, full range from the start", command: "gaitshift reproduce" },
    Claim { source: "journal", claim: "with the high range from the start it only runs", theirs: "no walk", rule: Rule::Always, of: |s| gait_at(s, 0.0, GaitClass::Walking).map(|walks| 1.0 - walks), about: |s| s.group == "journal, high range from the start", command: "gaitshift reproduce" },
];

/// The part of the papers' gap between walk and run, 0.22 to 0.65, that steady motions of neither gait cover, in steps of 0.05.
fn transitional(study: &Study) -> Option<f64> {
    let bins = 9;
    let mut covered = vec![false; bins];
    for row in &study.steady {
        let froude = row
            .summary
            .froude
            .filter(|_| row.summary.gait == GaitClass::Mixed);
        if let Some(froude) = froude {
            let bin = ((froude - 0.22) / 0.05).floor();
            if (0.0..bins as f64).contains(&bin) {
                covered[bin as usize] = true;
            }
        }
    }
    Some(covered.iter().filter(|&&c| c).count() as f64 / bins as f64)
}

/// Every claim and what the seeds of one experiment say to it.
pub fn judge_claims(studies: &[&Study]) -> Vec<Finding> {
    CLAIMS
        .iter()
        .map(|claim| {
            let about: Vec<&Study> = studies
                .iter()
                .copied()
                .filter(|s| (claim.about)(s))
                .collect();
            let values = Values::of(&about, claim.of);
            let estimate = match claim.rule {
                Rule::Always => share_of_seeds(&values),
                _ => values.estimate(),
            };
            let verdict = if about.is_empty() {
                Verdict::NotMeasured
            } else {
                claim.rule.verdict(&values, estimate.as_ref())
            };
            Finding {
                source: claim.source,
                claim: claim.claim,
                theirs: claim.theirs,
                rule: claim.rule.words(),
                estimate,
                verdict,
                command: claim.command,
                seeds: values.0,
            }
        })
        .collect()
}

/// Mean of shares, with Wilson's interval of the seeds that do it always.
fn share_of_seeds(values: &Values) -> Option<Estimate> {
    let known = values.known();
    let always = known.iter().filter(|&&share| share >= 1.0).count();
    let (low, high) = wilson_interval(always, known.len())?;
    Some(Estimate {
        value: gaitshift_analysis::statistics::mean(&known)?,
        interval: [low, high],
    })
}
