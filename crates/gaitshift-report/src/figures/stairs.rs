//! The change of gait on the stairs of the command: bifurcation, phase between the hips, recovery and work.

use super::Shown;
use super::panels::{
    HUMAN_RECOVERY, HUMAN_TRANSITION, OMEGA_V, Panel, froude, omega_v, on_stairs, points,
    stairs_table,
};
use crate::ReportError;
use crate::headline::{
    clearance, least_steady_stair, running_begins, running_is_kept, step_time_variation, two_gaits,
};
use crate::study::{StartedMotion, Study};
use gaitshift_analysis::{GaitClass, GaitSummary};
use gaitshift_figures::{PAGE_WIDTH, Series, charts_figure};
use std::f64::consts::PI;

/// The change of gait as a bifurcation: stairs of the command up and down, and random starts.
pub(super) fn bifurcation(study: &Study) -> Result<Option<Shown>, ReportError> {
    if study.stairs_up.is_empty() {
        return Ok(None);
    }
    const PANELS: [Panel; 4] = [
        Panel {
            levels: HUMAN_TRANSITION,
            ..Panel::new("", "Froude number", froude)
        },
        Panel::new("", "duty factor, right", |r| r.summary.duty_factor_right),
        Panel::new("", "double support", |r| r.summary.double_support),
        Panel::new("", "flight", |r| r.summary.flight),
    ];
    let leg_m_g = study
        .stairs_up
        .iter()
        .find_map(|row| Some(row.summary.speed_m_per_s? / row.summary.froude?));
    let started = |of: &dyn Fn(&StartedMotion) -> Option<f64>| -> Vec<(f64, f64)> {
        study
            .starts
            .iter()
            .filter(|m| m.gait != GaitClass::Fallen)
            .filter_map(|m| Some((m.omega_v, of(m)?)))
            .collect()
    };
    let mut charts = PANELS.map(|panel| panel.chart(OMEGA_V, on_stairs(study, panel.of)));
    for (chart, started) in charts.iter_mut().zip([
        started(&|m| Some(m.speed_m_per_s? / leg_m_g?)),
        started(&|m| m.duty_factor),
    ]) {
        chart
            .series
            .push(Series::marks("random starts", started).below());
    }
    let both = two_gaits(study);
    let between = match (both.first(), both.last()) {
        (Some(first), Some(last)) => format!(
            "At {} commands from {first} to {last} random starts end in either gait, walk or run.",
            both.len()
        ),
        _ => "At no command tried do random starts end in both gaits.".to_owned(),
    };
    Ok(Some(Shown {
        name: "bifurcation".to_owned(),
        title: "The change of gait as a bifurcation",
        caption: format!(
            "One motion whose command rises in small steps and falls again, and motions from random starts. {}{between} People change \
             gait at v²/(g l) of about 0.5, v/√(g l) of 0.71 (Kram, Domingo and Ferris, J. Exp. Biol. 200, 1997).",
            hysteresis(study)
        ),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 150.0)?,
        table: stairs_table("bifurcation", study),
        wide: true,
    }))
}

/// Where running begins and how far down it is kept, in a sentence.
fn hysteresis(study: &Study) -> String {
    match (running_begins(study), running_is_kept(study)) {
        (Some(begins), Some(kept)) => {
            format!("Running begins at {begins} on the way up and is kept down to {kept}. ")
        }
        _ => String::new(),
    }
}

/// The phase between the hips and how steady the stride is, through the change of gait.
pub(super) fn hip_phase(study: &Study) -> Result<Option<Shown>, ReportError> {
    const PANELS: [Panel; 4] = [
        Panel {
            shows: PI,
            ..Panel::new("", "left to right hip (rad)", |r| r.summary.hip_phase_rad)
        },
        Panel::new("", "its deviation (rad)", |r| {
            r.summary.hip_phase_deviation_rad
        }),
        Panel::new("", "step time variation", |r| {
            step_time_variation(&r.summary)
        }),
        Panel::new("", "clearance (mm)", |r| Some(1e3 * clearance(&r.summary)?)),
    ];
    if points(&study.stairs_up, omega_v, PANELS[0].of).is_empty() {
        return Ok(None);
    }
    let charts = PANELS.map(|panel| panel.chart(OMEGA_V, on_stairs(study, panel.of)));
    let least = least_steady_stair(study).map_or_else(String::new, |stair| {
        format!(
            " It is greatest, {:.2} rad, at {}.",
            stair.summary.hip_phase_deviation_rad.unwrap_or_default(),
            stair.omega_v
        )
    });
    Ok(Some(Shown {
        name: "hip-phase".to_owned(),
        title: "Phase between the hips and steadiness of the stride through the change of gait",
        caption: format!(
            "On the stairs of the bifurcation. Where in the right leg’s cycle of the hip angle the left leg is foremost: π where legs \
             alternate evenly. Its circular standard deviation from stride to stride is the root of its variance.{least} In people \
             relative phases jump at the change of gait and fluctuate more before it (Diedrich and Warren, J. Exp. Psychol.: Human Percept. Perform. 21, 1995). \
             Variation: standard deviation over mean. Clearance: height of the sole’s lowest point as a leg swings past the other. \
             Means of right and left."
        ),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 120.0)?,
        table: stairs_table("hip-phase", study),
        wide: true,
    }))
}

/// Pendular recovery and energy per step through the change of gait.
pub(super) fn through_the_change(study: &Study) -> Result<Option<Shown>, ReportError> {
    if study.stairs_up.is_empty() {
        return Ok(None);
    }
    fn work_per_step(summary: &GaitSummary) -> Option<f64> {
        let flow = summary.energy_flow?;
        Some(0.5 * (flow.actuators[0] + flow.actuators[1]))
    }
    const PANELS: [Panel; 2] = [
        Panel {
            levels: HUMAN_RECOVERY,
            ..Panel::new("", "energy recovery", |r| r.summary.energy_recovery)
        },
        Panel::new("", "actuators' work per step (J)", |r| {
            work_per_step(&r.summary)
        }),
    ];
    let charts = PANELS.map(|panel| panel.chart(OMEGA_V, on_stairs(study, panel.of)));
    Ok(Some(Shown {
        name: "through-the-change".to_owned(),
        title: "Pendular recovery and work through the change of gait",
        caption: "From the motions of the bifurcation figure with rising and falling command. Recovery is that of the centre of \
                  mass, after Cavagna; people recover up to about 0.65 at medium walking speeds and 0 to 0.04 running (Cavagna, Thys and \
                  Zamboni, J. Physiol. 262, 1976). Work is the positive work of both actuators."
            .to_owned(),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 140.0)?,
        table: stairs_table("through-the-change", study),
        wide: true,
    }))
}
