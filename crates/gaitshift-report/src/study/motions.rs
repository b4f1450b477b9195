//! Steady motions, the stairs of the command and random starts.

use super::plan::{Plan, commands};
use crate::{ReportError, Subject};
use gaitshift_analysis::recording::{Recording, Window, column};
use gaitshift_analysis::{AnalysisOptions, GaitClass, GaitSummary, summarise};
use gaitshift_experiment::{CommandProfile, Deterministic, Rollout, Simulation};
use gaitshift_task::Environment;
use serde::{Deserialize, Serialize};

/// A steady motion under one command, or one stair of the command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Steady {
    /// The command.
    pub omega_v: f64,
    /// Mean change of the total energy (2) within a control period, as an amount, in J.
    pub energy_change_j: Option<f64>,
    /// What the motion is.
    #[serde(flatten)]
    pub summary: GaitSummary,
}

/// A motion from a random start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StartedMotion {
    /// The command.
    pub omega_v: f64,
    /// Seed that draws the start.
    pub seed: u64,
    /// What it is in the end.
    pub gait: GaitClass,
    /// Its mean speed, in m/s.
    pub speed_m_per_s: Option<f64>,
    /// Share of the right leg's stride on the ground.
    pub duty_factor: Option<f64>,
    /// Share of time with both feet on the ground.
    pub double_support: Option<f64>,
    /// Share of time with no foot on the ground.
    pub flight: Option<f64>,
}

pub(super) fn record(
    subject: &mut Subject,
    profile: &CommandProfile,
    duration_s: f64,
    seed: Option<u64>,
) -> Result<Recording, ReportError> {
    let Subject {
        controller,
        body,
        name,
        ..
    } = subject;
    let recording = Rollout {
        body,
        task: &controller.task,
        start: Environment::start(body, &controller.task, seed),
        profile,
        duration_s,
        seed: seed.unwrap_or(0),
        disturbance: None,
        controller: name,
    }
    .record(&mut Deterministic(&mut controller.policy))?;
    Ok(recording)
}

pub(super) fn steady_motion(
    subject: &mut Subject,
    omega_v: f64,
    duration_s: f64,
) -> Result<Steady, ReportError> {
    let recording = record(
        subject,
        &CommandProfile::constant(omega_v),
        duration_s,
        None,
    )?;
    Ok(described(omega_v, &recording, &AnalysisOptions::default()))
}

fn described(omega_v: f64, recording: &Recording, options: &AnalysisOptions) -> Steady {
    let summary = summarise(recording, options);
    let window = summary
        .window_start_s
        .zip(summary.window_end_s)
        .and_then(|(from, to)| recording.window(from, to));
    Steady {
        omega_v,
        energy_change_j: window.and_then(|window| energy_change_j(recording, window)),
        summary,
    }
}

/// Mean |ΔE| of (2) over the periods of a window, in J.
fn energy_change_j(recording: &Recording, window: Window) -> Option<f64> {
    let total = |row: usize| -> f64 {
        [
            column::KINETIC_ENERGY_J,
            column::GRAVITATIONAL_ENERGY_J,
            column::ELASTIC_ENERGY_J,
        ]
        .iter()
        .map(|&column| recording.column(column)[row])
        .sum()
    };
    let changes: Vec<f64> = (window.start_row()..window.end_row())
        .map(|row| (total(row + 1) - total(row)).abs())
        .collect();
    gaitshift_analysis::statistics::mean(&changes)
}

/// Motions whose command climbs stairs from 0 and, another motion, comes down from the top. Where one falls, that stair says so,
/// and a fresh motion begins on the next; so the way down does not hang on the way up.
pub(super) fn stairs(
    subject: &mut Subject,
    plan: &Plan,
) -> Result<(Vec<Steady>, Vec<Steady>), ReportError> {
    let [top, step, hold_s] = plan.stairs;
    let up = commands([0.0, top, step]);
    let down: Vec<f64> = up.iter().rev().copied().collect();
    Ok((
        on_stairs(subject, &up, hold_s)?,
        on_stairs(subject, &down, hold_s)?,
    ))
}

/// A stair for each command; the first motion begins at the default start.
fn on_stairs(
    subject: &mut Subject,
    commands: &[f64],
    hold_s: f64,
) -> Result<Vec<Steady>, ReportError> {
    let Subject {
        controller, body, ..
    } = subject;
    let task = controller.task.clone();
    let options = AnalysisOptions {
        settling_time_s: 0.4 * hold_s,
        ..AnalysisOptions::default()
    };
    let mut rows = Vec::new();
    let mut moving: Option<Simulation> = None;
    for &omega_v in commands {
        let mut simulation = moving.take().unwrap_or_else(|| {
            let start = Environment::default_start(body, &task);
            let mut fresh = Simulation::new(body, &task, start, omega_v);
            fresh.record_details();
            fresh
        });
        let mut recording = Recording::new(simulation.metadata("", 0));
        let mut row = Vec::new();
        let mut ended = None;
        let mut survived_s = 0.0;
        for period in 1..=(hold_s / simulation.control_period_s()).round() as u64 {
            survived_s = period as f64 * simulation.control_period_s();
            ended = simulation.step(omega_v, None, &mut Deterministic(&mut controller.policy));
            if let Some(reason) = ended {
                recording.metadata.fell = true;
                recording.metadata.ended_by = task.end_name(reason).to_owned();
                break;
            }
            simulation.detailed_row(&mut row);
            recording.push_row(&row)?;
        }
        if ended.is_some() {
            // What led to the fall is no steady motion: of this stair only the fall and its time count.
            let mut fallen = described(
                omega_v,
                &Recording::new(recording.metadata.clone()),
                &options,
            );
            fallen.summary.survived_s = survived_s;
            rows.push(fallen);
        } else {
            rows.push(described(omega_v, &recording, &options));
            moving = Some(simulation);
        }
    }
    Ok(rows)
}

pub(super) fn random_starts(
    subject: &mut Subject,
    plan: &Plan,
) -> Result<Vec<StartedMotion>, ReportError> {
    let mut motions = Vec::new();
    for omega_v in commands([0.0, plan.stairs[0], plan.starts_step]) {
        for seed in 1..=plan.starts {
            let profile = CommandProfile::constant(omega_v);
            let recording = record(subject, &profile, 20.0, Some(seed))?;
            let options = AnalysisOptions {
                settling_time_s: 10.0,
                ..AnalysisOptions::default()
            };
            let summary = summarise(&recording, &options);
            motions.push(StartedMotion {
                omega_v,
                seed,
                gait: summary.gait,
                speed_m_per_s: summary.speed_m_per_s,
                duty_factor: summary.duty_factor_right,
                double_support: summary.double_support,
                flight: summary.flight,
            });
        }
    }
    Ok(motions)
}
