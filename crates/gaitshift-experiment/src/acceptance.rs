//! Whether a controller meets what is asked of it, each criterion measured on rollouts without noise.

use crate::CommandProfile;
use crate::criteria::{AskedChange, AskedGait, Criteria};
use crate::rollout::Rollout;
use crate::simulation::Control;
use gaitshift_analysis::recording::{Recording, RowError};
use gaitshift_analysis::{
    AnalysisOptions, GaitClass, GaitSummary, TransitionOptions, TransitionSummary, summarise,
    summarise_transition,
};
use gaitshift_body::Body;
use gaitshift_task::{Environment, TaskParameters};
use serde::Serialize;

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
}

/// A steady motion under one command.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SteadyMotion {
    /// The command.
    pub omega_v: f64,
    /// The gait that is asked for under it, if one is.
    pub asked: Option<GaitClass>,
    /// The motion.
    #[serde(flatten)]
    pub summary: GaitSummary,
}

/// A change of gait that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TriedChange {
    /// The command before.
    pub from: f64,
    /// The command after.
    pub to: f64,
    /// The gaits that are asked for before and after.
    pub gaits: [GaitClass; 2],
    /// The motions, one for each phase of the stride; none if the motion before does not last.
    pub tries: Vec<TransitionSummary>,
}

/// The outcome of judging a controller.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// Steady motions, one per command.
    pub rows: Vec<SteadyMotion>,
    /// Changes of gait, one for each that is asked for.
    pub changes: Vec<TriedChange>,
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
    }
}

impl Check {
    /// Where there is a cause that makes the value undefined, it is the reason.
    fn because_of(self, cause: Result<(), String>) -> Self {
        match cause {
            Ok(()) => self,
            Err(cause) => Self {
                reason: Some(cause),
                ..self
            },
        }
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

/// Tries a controller on every command and every change of gait, from the default start.
///
/// # Errors
/// A recording that refuses a row.
pub fn judge(
    body: &Body,
    task: &TaskParameters,
    criteria: &Criteria,
    control: &mut impl Control,
) -> Result<Judgement, RowError> {
    judge_from(body, task, criteria, None, control)
}

/// [`judge`] from the start that a seed draws, as training episodes start.
///
/// # Errors
/// As [`judge`].
pub fn judge_from(
    body: &Body,
    task: &TaskParameters,
    criteria: &Criteria,
    seed: Option<u64>,
    control: &mut impl Control,
) -> Result<Judgement, RowError> {
    let c = criteria;
    let start = Environment::start(body, task, seed);
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
        let asked = c.gait_at(omega_v);
        rows.push(SteadyMotion {
            omega_v,
            asked,
            summary,
        });
    }
    let mut judgement = Judgement {
        rows,
        changes: Vec::new(),
        checks: Vec::new(),
    };
    for change in &c.changes {
        let AskedChange { from, to, .. } = *change;
        let tries = match judgement.row(from) {
            Some(steady) => tries_of_change(change, steady, &mut run)?,
            None => Vec::new(),
        };
        if let (Some(before), Some(after)) = (c.gait_at(from), c.gait_at(to)) {
            judgement.changes.push(TriedChange {
                from,
                to,
                gaits: [before, after],
                tries,
            });
        }
    }
    judgement.checks = checks(&judgement, c);
    Ok(judgement)
}

/// A change of gait begun at each of its phases of the stride, after the motion `steady` at its first command. A motion that falls has
/// no phases from which to change. `record` follows a command for so long, in s.
///
/// # Errors
/// As `record`.
pub fn tries_of_change<E>(
    change: &AskedChange,
    steady: &GaitSummary,
    mut record: impl FnMut(&CommandProfile, f64) -> Result<Recording, E>,
) -> Result<Vec<TransitionSummary>, E> {
    if steady.fell {
        return Ok(Vec::new());
    }
    let AskedChange {
        from,
        to,
        phases,
        ramp_s,
        steady_s,
    } = *change;
    let stride_s = steady.step_frequency_hz.map_or(1.0, |f| 2.0 / f);
    (0..phases)
        .map(|phase| {
            let start_s = steady_s + stride_s * phase as f64 / phases as f64;
            let end_s = start_s + ramp_s;
            let profile = CommandProfile::ramp(from, to, start_s, ramp_s);
            let recording = record(&profile, end_s + steady_s)?;
            let options = TransitionOptions::default();
            Ok(summarise_transition(&recording, start_s, end_s, &options))
        })
        .collect()
}

/// What was measured of a motion; of one that does not last it says nothing.
fn lasting(s: Option<&GaitSummary>, value: fn(&GaitSummary) -> Option<f64>) -> Option<f64> {
    s.filter(|s| !s.fell).and_then(value)
}

fn checks(j: &Judgement, c: &Criteria) -> Vec<Check> {
    let mut checks = Vec::new();
    for row in &j.rows {
        let s = &row.summary;
        checks.push(check(
            format!("survives {} s at omega_v = {}", c.duration_s, row.omega_v),
            Some(s.survived_s),
            lasts(Some(s)),
            s.survived_s / c.duration_s,
        ));
    }
    for asked in &c.gaits {
        checks.extend(gait_checks(asked, j.row(asked.omega_v)));
    }
    let froude = || {
        j.rows
            .iter()
            .filter(|r| !r.summary.fell)
            .filter_map(|r| r.summary.froude)
    };
    let (low, high) = (c.slowest_froude_max, c.fastest_froude_min);
    if low > 0.0 {
        let least = froude().reduce(f64::min);
        checks.push(at_most(
            format!("least Froude number at most {low}"),
            least,
            low,
        ));
    }
    if high > 0.0 {
        let greatest = froude().reduce(f64::max);
        checks.push(at_least(
            format!("greatest Froude number at least {high}"),
            greatest,
            high,
        ));
    }
    for asked in c.gaits.iter().filter(|g| g.cost_of_transport_max > 0.0) {
        let (gait, w, bound) = (asked.gait, asked.omega_v, asked.cost_of_transport_max);
        let s = j.row(w);
        let cost = at_most(
            format!("cost of transport {gait} at omega_v = {w} at most {bound}"),
            lasting(s, |s| s.cost_of_transport).filter(|v| *v > 0.0),
            bound,
        );
        checks.push(cost.only_if(s, gait));
    }
    for (asked, tried) in c.changes.iter().zip(&j.changes) {
        checks.extend(change_checks(asked, tried, j.row(asked.from)));
    }
    for asked in c.gaits.iter().filter(|g| g.correlation > 0.0) {
        let others = c.gaits.iter().filter(|g| g.gait == asked.gait).count() > 1;
        checks.extend(correlation_checks(asked, j.row(asked.omega_v), others));
    }
    checks
}

/// That the motion `s` is the gait asked for, and its speed.
fn gait_checks(asked: &AskedGait, s: Option<&GaitSummary>) -> Vec<Check> {
    let (w, gait) = (asked.omega_v, asked.gait);
    let (what, value): (_, fn(&GaitSummary) -> Option<f64>) = match gait {
        GaitClass::Walking => ("walks", |s| s.steps_with_double_support),
        GaitClass::Running => ("runs", |s| s.steps_with_flight),
        _ => ("stands", |s| s.speed_m_per_s),
    };
    let measured = match gait {
        GaitClass::Walking => "share of steps with double support",
        GaitClass::Running => "share of steps with flight",
        _ => "speed in m/s",
    };
    // How much there is of its support phases, and how little of the other gait's.
    let near = lasting(
        s,
        match gait {
            GaitClass::Walking => |s| {
                let double = s.steps_with_double_support.unwrap_or(0.0);
                Some(0.5 * double * (1.0 - s.flight.unwrap_or(0.0)))
            },
            GaitClass::Running => |s| {
                let flight = s.steps_with_flight.unwrap_or(0.0);
                Some(0.5 * flight * (1.0 - s.double_support.unwrap_or(0.0)))
            },
            _ => |s| s.speed_m_per_s.map(|v| 0.5 / (1.0 + v.abs())),
        },
    );
    let mut checks = vec![check(
        format!("{what} at omega_v = {w}: {measured}"),
        lasting(s, value),
        is_gait(s, gait),
        near.unwrap_or(0.0),
    )];
    let froude = lasting(s, |s| s.froude);
    if asked.froude_min > 0.0 {
        let bound = asked.froude_min;
        let name = format!("Froude number at omega_v = {w} at least {bound}");
        checks.push(at_least(name, froude, bound).because_of(lasts(s)));
    }
    if asked.froude_max > 0.0 {
        let bound = asked.froude_max;
        let name = format!("Froude number at omega_v = {w} at most {bound}");
        checks.push(at_most(name, froude, bound).because_of(lasts(s)));
    }
    checks
}

/// That the change goes from the one gait to the other from every phase of the stride; `steady` is the motion before.
fn change_checks(
    asked: &AskedChange,
    tried: &TriedChange,
    steady: Option<&GaitSummary>,
) -> Vec<Check> {
    let (from, to, phases) = (asked.from, asked.to, asked.phases);
    let of_phase = |k: usize| {
        let t = tried.tries.get(k);
        let outcome = match t {
            Some(t) => changes(t, tried.gaits),
            None => Err(lasts(steady).err().map_or_else(
                || "no motion to change from".to_owned(),
                |fell| format!("no motion to change from: at omega_v = {from} it {fell}"),
            )),
        };
        let near = t.map_or(0.0, |t| {
            if !t.survived {
                return FELL_CREDIT;
            }
            let [before, after] = tried.gaits;
            let right = [t.gait_before == Some(before), t.gait_after == Some(after)];
            let right = right.iter().filter(|&&right| right).count();
            SURVIVED_CREDIT + ONE_GAIT_CREDIT * right as f64
        });
        check(
            format!("changes {from} -> {to} from phase {k}/{phases} of the stride: survived, s"),
            t.map(|t| t.survived_s),
            outcome,
            near,
        )
    };
    (0..phases).map(of_phase).collect()
}

/// The energy correlations of a gait. Where it is asked for at several commands, the names say at which.
fn correlation_checks(asked: &AskedGait, s: Option<&GaitSummary>, several: bool) -> Vec<Check> {
    let (gait, b) = (asked.gait, asked.correlation);
    let at = if several {
        format!(" at omega_v = {}", asked.omega_v)
    } else {
        String::new()
    };
    let of = |value| lasting(s, value);
    let checks = match gait {
        GaitClass::Walking => vec![correlation(
            format!("kinetic-potential correlation walking{at} below -{b}"),
            of(|s| s.kinetic_potential_correlation),
            -b,
        )],
        _ => vec![
            correlation(
                format!("kinetic-potential correlation running{at} (single support) above {b}"),
                of(|s| s.kinetic_potential_correlation_single_support),
                b,
            ),
            correlation(
                format!("elastic-kinetic correlation running{at} (single support) below -{b}"),
                of(|s| s.elastic_kinetic_correlation_single_support),
                -b,
            ),
            correlation(
                format!("elastic-potential correlation running{at} (single support) below -{b}"),
                of(|s| s.elastic_potential_correlation_single_support),
                -b,
            ),
        ],
    };
    let only = checks.into_iter().map(|check| check.only_if(s, gait));
    only.collect()
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
