//! The criteria that a finished controller has to meet, each measured on rollouts without noise.

use crate::CommandProfile;
use crate::rollout::{Control, Rollout};
use gaitshift_analysis::recording::RowError;
use gaitshift_analysis::{
    AnalysisOptions, GaitClass, GaitSummary, TransitionOptions, TransitionSummary, summarise,
    summarise_transition,
};
use gaitshift_body::Body;
use gaitshift_task::{Environment, TaskParameters};
use serde::Serialize;

/// What a controller is tried on, and the bounds it has to keep. The defaults ask for what the paper
/// reports: walking at ω_v = 0, running at 3, its range of speeds, its costs of transport, and both
/// changes of gait from any phase of the stride.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Criteria {
    /// Commands held for `duration_s` each.
    pub omega_v: Vec<f64>,
    /// Duration of those motions, in s.
    pub duration_s: f64,
    /// The walking command.
    pub walking_omega_v: f64,
    /// The running command.
    pub running_omega_v: f64,
    /// Least Froude number of the walk.
    pub walking_froude: f64,
    /// The slowest motion has at most, the fastest at least this Froude number.
    pub froude_span: [f64; 2],
    /// Greatest cost of transport walking and running.
    pub cost_of_transport: [f64; 2],
    /// Duration of a command ramp, in s.
    pub ramp_s: f64,
    /// Number of different phases of the stride from which each change of gait is tried.
    pub phases: usize,
    /// Time of steady motion before the ramp and after it, in s.
    pub steady_s: f64,
    /// Least magnitude of the energy correlations.
    pub correlation: f64,
}

impl Default for Criteria {
    fn default() -> Self {
        Self {
            omega_v: (0..=7).map(|k| 0.5 * f64::from(k)).collect(),
            duration_s: 20.0,
            walking_omega_v: 0.0,
            running_omega_v: 3.0,
            walking_froude: 0.15,
            froude_span: [0.20, 0.93],
            cost_of_transport: [0.342, 0.347],
            ramp_s: 0.4,
            phases: 10,
            steady_s: 10.0,
            correlation: 0.5,
        }
    }
}

/// One criterion, what was measured and whether it holds. What is asked of a gait, its cost or its
/// correlations, holds only of a motion that is that gait; what is asked of a change, only of one from the
/// one gait to the other.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What is asked.
    pub name: String,
    /// What was measured, in the words or unit of the name; nothing if it is undefined.
    pub value: Option<f64>,
    /// Whether it holds.
    pub met: bool,
    /// Why it does not hold; nothing if it does.
    pub reason: Option<String>,
    /// How much of it is there, in [0, 1]; 1 exactly if it is met.
    pub credit: f64,
    /// Whether it is about the walk at the walking command alone.
    #[serde(skip)]
    pub walking: bool,
}

/// A steady motion under one command.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SteadyMotion {
    /// The command.
    pub omega_v: f64,
    /// The motion.
    #[serde(flatten)]
    pub summary: GaitSummary,
}

/// The outcome of judging a controller.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// Steady motions, one per command.
    pub rows: Vec<SteadyMotion>,
    /// Changes from walking to running, one per phase of the stride.
    pub to_running: Vec<TransitionSummary>,
    /// Changes from running to walking.
    pub to_walking: Vec<TransitionSummary>,
    /// All criteria.
    pub checks: Vec<Check>,
}

impl Judgement {
    /// Whether every criterion is met.
    pub fn accepted(&self) -> bool {
        self.checks.iter().all(|c| c.met)
    }

    /// Number of criteria met.
    pub fn met(&self) -> usize {
        self.checks.iter().filter(|c| c.met).count()
    }

    /// Orders controllers: the sum of the credits.
    pub fn score(&self) -> f64 {
        self.checks.iter().map(|c| c.credit).sum()
    }

    /// How good the walk alone is: the sum of the credits of its criteria.
    pub fn walking_score(&self) -> f64 {
        let walking = self.checks.iter().filter(|c| c.walking);
        walking.map(|c| c.credit).sum()
    }

    /// The motion at a command, if it was tried.
    pub fn row(&self, omega_v: f64) -> Option<&GaitSummary> {
        self.rows
            .iter()
            .find(|r| r.omega_v == omega_v)
            .map(|r| &r.summary)
    }
}

/// What is left of the credit of a bound on a motion that is not the gait it is about.
const OTHER_GAIT_SHARE: f64 = 0.5;
/// Credit of a change of gait that is neither, for not falling and for each of the two gaits.
const FELL_CREDIT: f64 = 0.2;
const SURVIVED_CREDIT: f64 = 0.4;
const ONE_GAIT_CREDIT: f64 = 0.2;

/// Full credit if met, otherwise less than 1 in proportion to how near the value is.
fn check(name: String, value: Option<f64>, outcome: Result<(), String>, nearness: f64) -> Check {
    let credit = if outcome.is_ok() {
        1.0
    } else {
        nearness.clamp(0.0, 0.95)
    };
    Check {
        name,
        value,
        met: outcome.is_ok(),
        reason: outcome.err(),
        credit: if credit.is_finite() { credit } else { 0.0 },
        walking: false,
    }
}

impl Check {
    fn of_walk_if(self, walking: bool) -> Self {
        Self { walking, ..self }
    }

    /// Holds only if the motion is of that gait.
    fn only_if(self, motion: Option<&GaitSummary>, wanted: GaitClass) -> Self {
        match is_gait(motion, wanted) {
            Ok(()) => self,
            Err(reason) => Self {
                met: false,
                reason: Some(reason),
                credit: OTHER_GAIT_SHARE * self.credit,
                ..self
            },
        }
    }
}

/// Whether the motion lasts and is of that gait, and if not, what it is instead.
fn is_gait(motion: Option<&GaitSummary>, wanted: GaitClass) -> Result<(), String> {
    lasts(motion)?;
    match motion {
        Some(s) if s.gait == wanted => Ok(()),
        Some(s) => Err(format!("the motion is {}, not {wanted}", s.gait)),
        None => Err("no motion".to_owned()),
    }
}

fn lasts(motion: Option<&GaitSummary>) -> Result<(), String> {
    match motion {
        Some(s) if s.fell => Err(format!("fell after {:.2} s ({})", s.survived_s, s.ended_by)),
        _ => Ok(()),
    }
}

fn at_least(name: String, value: Option<f64>, bound: f64) -> Check {
    let v = value.unwrap_or(f64::NEG_INFINITY);
    let outcome = match value {
        Some(v) if v >= bound => Ok(()),
        Some(v) => Err(format!("{v:.4} is below {bound}")),
        None => Err(UNDEFINED.to_owned()),
    };
    check(name, value, outcome, v / bound)
}

fn at_most(name: String, value: Option<f64>, bound: f64) -> Check {
    let v = value.unwrap_or(f64::INFINITY);
    let outcome = match value {
        Some(v) if v <= bound => Ok(()),
        Some(v) => Err(format!("{v:.4} is above {bound}")),
        None => Err(UNDEFINED.to_owned()),
    };
    check(name, value, outcome, bound / v)
}

/// A correlation beyond `bound`, on the bound's side of 0.
fn correlation(name: String, value: Option<f64>, bound: f64) -> Check {
    let beyond = |v: f64| if bound < 0.0 { v < bound } else { v > bound };
    let outcome = match value {
        Some(v) if beyond(v) => Ok(()),
        Some(v) => {
            let side = if bound < 0.0 { "below" } else { "above" };
            Err(format!("{v:.4} is not {side} {bound}"))
        }
        None => Err(UNDEFINED.to_owned()),
    };
    check(name, value, outcome, value.unwrap_or(0.0) / bound)
}

const UNDEFINED: &str = "undefined for this motion";

/// Tries a controller on every command and every change of gait.
///
/// # Errors
/// A recording that refuses a row.
pub fn judge(
    body: &Body,
    task: &TaskParameters,
    criteria: &Criteria,
    control: &mut impl Control,
) -> Result<Judgement, RowError> {
    let c = criteria;
    let start = Environment::default_start(body, task);
    let mut run = |profile: &CommandProfile, duration_s: f64| {
        Rollout {
            body,
            task,
            start,
            profile,
            duration_s,
            seed: 0,
            disturbance: None,
            controller: "",
        }
        .record(control)
    };
    let mut rows = Vec::new();
    for &omega_v in &c.omega_v {
        let recording = run(&CommandProfile::constant(omega_v), c.duration_s)?;
        let summary = summarise(&recording, &AnalysisOptions::default());
        rows.push(SteadyMotion { omega_v, summary });
    }
    let mut judgement = Judgement {
        rows,
        to_running: Vec::new(),
        to_walking: Vec::new(),
        checks: Vec::new(),
    };
    let (walk_w, run_w) = (c.walking_omega_v, c.running_omega_v);
    let walk = judgement.row(walk_w).cloned();
    let running = judgement.row(run_w).cloned();
    for (from, to, steady) in [(walk_w, run_w, &walk), (run_w, walk_w, &running)] {
        // A motion that does not last has no phases from which to change.
        let Some(steady) = steady.as_ref().filter(|s| !s.fell) else {
            continue;
        };
        let stride_s = steady.step_frequency_hz.map_or(1.0, |f| 2.0 / f);
        for phase in 0..c.phases {
            let start_s = c.steady_s + stride_s * phase as f64 / c.phases as f64;
            let end_s = start_s + c.ramp_s;
            let profile = CommandProfile::ramp(from, to, start_s, c.ramp_s);
            let recording = run(&profile, end_s + c.steady_s)?;
            let options = TransitionOptions::default();
            let summary = summarise_transition(&recording, start_s, end_s, &options);
            if to == run_w {
                judgement.to_running.push(summary);
            } else {
                judgement.to_walking.push(summary);
            }
        }
    }
    judgement.checks = checks(&judgement, c, walk.as_ref(), running.as_ref());
    Ok(judgement)
}

fn checks(
    j: &Judgement,
    c: &Criteria,
    walk: Option<&GaitSummary>,
    running: Option<&GaitSummary>,
) -> Vec<Check> {
    let mut checks = Vec::new();
    for row in &j.rows {
        let s = &row.summary;
        let survives = check(
            format!("survives {} s at omega_v = {}", c.duration_s, row.omega_v),
            Some(s.survived_s),
            lasts(Some(s)),
            s.survived_s / c.duration_s,
        );
        checks.push(survives.of_walk_if(row.omega_v == c.walking_omega_v));
    }
    let (walk_w, run_w) = (c.walking_omega_v, c.running_omega_v);
    // What is measured of a motion that does not last says nothing.
    let lasting = |s: Option<&GaitSummary>, value: fn(&GaitSummary) -> Option<f64>| {
        s.filter(|s| !s.fell).and_then(value)
    };
    let of_walk = |value| lasting(walk, value);
    let of_run = |value| lasting(running, value);
    checks.push(
        check(
            format!("walks at omega_v = {walk_w}: share of steps with double support"),
            of_walk(|s| s.steps_with_double_support),
            is_gait(walk, GaitClass::Walking),
            of_walk(|s| {
                let double = s.steps_with_double_support.unwrap_or(0.0);
                Some(0.5 * double * (1.0 - s.flight.unwrap_or(0.0)))
            })
            .unwrap_or(0.0),
        )
        .of_walk_if(true),
    );
    let walking_froude = at_least(
        format!(
            "Froude number at omega_v = {walk_w} at least {}",
            c.walking_froude
        ),
        of_walk(|s| s.froude),
        c.walking_froude,
    );
    checks.push(
        match lasts(walk) {
            Ok(()) => walking_froude,
            Err(fell) => Check {
                reason: Some(fell),
                ..walking_froude
            },
        }
        .of_walk_if(true),
    );
    checks.push(check(
        format!("runs at omega_v = {run_w}: share of steps with flight"),
        of_run(|s| s.steps_with_flight),
        is_gait(running, GaitClass::Running),
        of_run(|s| {
            let flight = s.steps_with_flight.unwrap_or(0.0);
            Some(0.5 * flight * (1.0 - s.double_support.unwrap_or(0.0)))
        })
        .unwrap_or(0.0),
    ));
    let froude = || {
        j.rows
            .iter()
            .filter(|r| !r.summary.fell)
            .filter_map(|r| r.summary.froude)
    };
    let least = froude().reduce(f64::min);
    let greatest = froude().reduce(f64::max);
    let [low, high] = c.froude_span;
    checks.push(at_most(format!("least Froude number at most {low}"), least, low).of_walk_if(true));
    checks.push(at_least(
        format!("greatest Froude number at least {high}"),
        greatest,
        high,
    ));
    for (gait, s, w, bound) in [
        (GaitClass::Walking, walk, walk_w, c.cost_of_transport[0]),
        (GaitClass::Running, running, run_w, c.cost_of_transport[1]),
    ] {
        let cost = at_most(
            format!("cost of transport {gait} at omega_v = {w} at most {bound}"),
            lasting(s, |s| s.cost_of_transport).filter(|v| *v > 0.0),
            bound,
        );
        checks.push(cost.only_if(s, gait).of_walk_if(w == walk_w));
    }
    let (walking_gait, running_gait) = (GaitClass::Walking, GaitClass::Running);
    for (from, to, gaits, steady, list) in [
        (
            walk_w,
            run_w,
            [walking_gait, running_gait],
            walk,
            &j.to_running,
        ),
        (
            run_w,
            walk_w,
            [running_gait, walking_gait],
            running,
            &j.to_walking,
        ),
    ] {
        for k in 0..c.phases {
            let t = list.get(k);
            let outcome = match t {
                Some(t) => changes(t, gaits),
                None => Err(lasts(steady).err().map_or_else(
                    || "no motion to change from".to_owned(),
                    |fell| format!("no motion to change from: at omega_v = {from} it {fell}"),
                )),
            };
            let near = t.map_or(0.0, |t| {
                if !t.survived {
                    return FELL_CREDIT;
                }
                let [before, after] = gaits;
                let right = [t.gait_before == Some(before), t.gait_after == Some(after)];
                let right = right.iter().filter(|&&right| right).count();
                SURVIVED_CREDIT + ONE_GAIT_CREDIT * right as f64
            });
            checks.push(check(
                format!(
                    "changes {from} -> {to} from phase {k}/{} of the stride: survived, s",
                    c.phases
                ),
                t.map(|t| t.survived_s),
                outcome,
                near,
            ));
        }
    }
    let b = c.correlation;
    checks.push(
        correlation(
            format!("kinetic-potential correlation walking below -{b}"),
            of_walk(|s| s.kinetic_potential_correlation),
            -b,
        )
        .only_if(walk, GaitClass::Walking)
        .of_walk_if(true),
    );
    let running_correlations = [
        correlation(
            format!("kinetic-potential correlation running (single support) above {b}"),
            of_run(|s| s.kinetic_potential_correlation_single_support),
            b,
        ),
        correlation(
            format!("elastic-kinetic correlation running (single support) below -{b}"),
            of_run(|s| s.elastic_kinetic_correlation_single_support),
            -b,
        ),
        correlation(
            format!("elastic-potential correlation running (single support) below -{b}"),
            of_run(|s| s.elastic_potential_correlation_single_support),
            -b,
        ),
    ];
    checks.extend(running_correlations.map(|check| check.only_if(running, GaitClass::Running)));
    checks
}

/// Whether it went from the first gait to the second without a fall, and if not, why.
fn changes(t: &TransitionSummary, [from, to]: [GaitClass; 2]) -> Result<(), String> {
    if !t.survived {
        return Err(format!(
            "fell {:.2} s after the ramp began",
            t.survived_s - t.ramp_start_s
        ));
    }
    let is = |when: &str, gait: Option<GaitClass>, wanted: GaitClass| match gait {
        Some(gait) if gait == wanted => Ok(()),
        Some(gait) => Err(format!(
            "{when} the change the motion is {gait}, not {wanted}"
        )),
        None => Err(format!("nothing is recorded {when} the change")),
    };
    is("before", t.gait_before, from)?;
    is("after", t.gait_after, to)
}
