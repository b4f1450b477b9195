//! The change of gait on the stairs of the command: bifurcation, phase between the hips, recovery and work.

use super::Shown;
use super::panels::{
    FROUDE, HUMAN_RECOVERY, HUMAN_TRANSITION, OMEGA_V, Panel, SHARE_OF_TIME, falls, froude,
    omega_v, on_stairs, points, stairs_range, stairs_table,
};
use crate::ReportError;
use crate::headline::{
    clearance, depends_on_the_way, least_steady_stair, runs_from, step_time_variation, two_gaits,
};
use crate::study::{Plan, StartedMotion, Steady, Study};
use crate::table::{Table, cell};
use gaitshift_analysis::{GaitClass, GaitSummary};
use gaitshift_figures::{Chart, PAGE_WIDTH, Series, charts_figure};
use std::f64::consts::PI;

/// The change of gait as a bifurcation: stairs of the command up and down, and random starts.
pub(super) fn bifurcation(study: &Study, plan: &Plan) -> Result<Option<Shown>, ReportError> {
    const PANELS: [Panel; 4] = [
        Panel {
            levels: HUMAN_TRANSITION,
            ..Panel::new("speed", FROUDE, froude)
        },
        Panel::new("duty factor, right leg", "share of stride", |r| {
            r.summary.duty_factor_right
        }),
        Panel::new("double support", SHARE_OF_TIME, |r| {
            r.summary.double_support
        }),
        Panel::new("flight", SHARE_OF_TIME, |r| r.summary.flight),
    ];
    if study.stairs_up.is_empty() {
        return Ok(None);
    }
    let speed_of_froude = study
        .stairs_up
        .iter()
        .chain(&study.steady)
        .find_map(|row| Some(row.summary.speed_m_per_s? / row.summary.froude?));
    let started = |of: &dyn Fn(&StartedMotion) -> Option<f64>| -> Vec<(f64, f64)> {
        let stayed = study.starts.iter().filter(|m| m.gait != GaitClass::Fallen);
        stayed.filter_map(|m| Some((m.omega_v, of(m)?))).collect()
    };
    let fallen = study.starts.iter().filter(|m| m.gait == GaitClass::Fallen);
    let fallen: Vec<f64> = fallen.map(|m| m.omega_v).collect();
    let mut charts = stairs_charts(study, PANELS);
    for (chart, started) in charts.iter_mut().zip([
        started(&|m| Some(m.speed_m_per_s? / speed_of_froude?)),
        started(&|m| m.duty_factor),
        started(&|m| m.double_support),
        started(&|m| m.flight),
    ]) {
        let starts = Series::marks("random starts", started).fell_at(fallen.clone());
        chart.series.push(starts.below());
    }
    let both = two_gaits(study);
    let between = match (&both[..], both.last()) {
        ([only], _) => {
            format!("At one command, {only}, random starts end in either gait, walk or run.")
        }
        ([first, ..], Some(last)) => format!(
            "At {} commands from {first} to {last} random starts end in either gait, walk or run.",
            both.len()
        ),
        _ => "At no command tried do random starts end in both gaits.".to_owned(),
    };
    let [top, step, hold_s] = plan.stairs;
    Ok(Some(Shown {
        name: "bifurcation".to_owned(),
        title: "The change of gait as a bifurcation",
        caption: format!(
            "A motion whose command rises from 0 to {top} in stairs of {step}, each held for {hold_s} s, another that begins at {top} \
             and comes down, and motions from random starts. After a fall a fresh motion begins on the next stair. {}{} {between} Of \
             {} random starts {} fell. People change gait at v²/(g l) of about 0.5, v/√(g l) of 0.71 (Kram, Domingo and Ferris, \
             J. Exp. Biol. 200, 1997).",
            hysteresis(study),
            falls_in_words(study),
            study.starts.len(),
            fallen.len(),
        ),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 150.0)?,
        table: with_starts(stairs_table("bifurcation", study), study),
        wide: true,
    }))
}

/// The table with a row for each random start, of which less is known.
fn with_starts(mut table: Table, study: &Study) -> Table {
    for start in &study.starts {
        let known = |column: &str| match column {
            "series" => "random start".to_owned(),
            "omega_v" => cell(Some(start.omega_v)),
            "gait" => start.gait.to_string(),
            "fell" => (start.gait == GaitClass::Fallen).to_string(),
            "speed_m_per_s" => cell(start.speed_m_per_s),
            "double_support" => cell(start.double_support),
            "flight" => cell(start.flight),
            "duty_factor_right" => cell(start.duty_factor),
            _ => String::new(),
        };
        let row = table.columns.iter().map(|column| known(column)).collect();
        table.rows.push(row);
    }
    table
}

/// On which stairs it fell, in a sentence.
fn falls_in_words(study: &Study) -> String {
    let list = |rows: &[Steady]| {
        let falls = falls(rows).iter().map(f64::to_string).collect::<Vec<_>>();
        match &falls[..] {
            [] => "nowhere".to_owned(),
            [first, .., last] if falls.len() > 4 => {
                format!("on {} stairs between {} and {}", falls.len(), first, last)
            }
            _ => format!("at {}", falls.join(", ")),
        }
    };
    format!(
        "Rising, it fell {}; coming down, {}.",
        list(&study.stairs_up),
        list(&study.stairs_down)
    )
}

/// Panels over the stairs, all with the same commands.
fn stairs_charts<const N: usize>(study: &Study, panels: [Panel; N]) -> [Chart; N] {
    panels.map(|panel| Chart {
        x_range: stairs_range(study),
        ..panel.chart(OMEGA_V, on_stairs(study, panel.of))
    })
}

/// From where on it runs, up and down, and where the motion depends on the way, in two sentences.
fn hysteresis(study: &Study) -> String {
    let runs = |from: Option<f64>| match from {
        Some(command) => format!("from {command} on"),
        None => "nowhere".to_owned(),
    };
    let depends = depends_on_the_way(study);
    let depends = match (&depends[..], depends.last()) {
        ([only], _) => format!("At one stair, {only}, the"),
        ([first, ..], Some(last)) => {
            format!("At {} stairs from {first} to {last} the", depends.len())
        }
        _ => "At no stair does the".to_owned(),
    };
    let word = if depends.starts_with("At no") {
        "depend"
    } else {
        "depends"
    };
    format!(
        "It runs {} as the command rises, {} as it falls, without a break up to the greatest run. {depends} motion {word} on the way: \
         Froude numbers differ by more than 0.05. ",
        runs(runs_from(study.stairs_up.iter().rev())),
        runs(runs_from(study.stairs_down.iter()))
    )
}

/// The phase between the hips and how steady the stride is, through the change of gait.
pub(super) fn hip_phase(study: &Study) -> Result<Option<Shown>, ReportError> {
    const PANELS: [Panel; 4] = [
        Panel {
            shows: PI,
            levels: &[(PI, "π, even")],
            ..Panel::new("phase, left to right hip", "circular mean (rad)", |r| {
                r.summary.hip_phase_rad
            })
        },
        Panel::new(
            "its deviation from stride to stride",
            "circular s.d. (rad)",
            |r| r.summary.hip_phase_deviation_rad,
        ),
        Panel::new("variation of the step time", "deviation/mean", |r| {
            step_time_variation(&r.summary)
        }),
        Panel::new("clearance of the swinging foot", "height (mm)", |r| {
            Some(1e3 * clearance(&r.summary)?)
        }),
    ];
    if points(&study.stairs_up, omega_v, PANELS[0].of).is_empty() {
        return Ok(None);
    }
    let charts = stairs_charts(study, PANELS);
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
            "On the stairs of the bifurcation. The phase is where in the right leg’s cycle of the hip angle the left leg is foremost: π \
             where legs alternate evenly. Its circular standard deviation from stride to stride is the root of its variance.{least} In people \
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
        let [right, left] = summary.energy_per_step?.actuators;
        Some(right + left)
    }
    const PANELS: [Panel; 2] = [
        Panel {
            levels: HUMAN_RECOVERY,
            ..Panel::new("energy recovery", "share", |r| r.summary.energy_recovery)
        },
        Panel::new("positive work of the actuators", "work per step (J)", |r| {
            work_per_step(&r.summary)
        }),
    ];
    let charts = stairs_charts(study, PANELS);
    Ok(Some(Shown {
        name: "through-the-change".to_owned(),
        title: "Pendular recovery and work through the change of gait",
        caption: "From the motions of the bifurcation figure whose command rises and falls. Recovery is that of the centre of \
                  mass, after Cavagna; people recover up to about 0.65 at medium walking speeds and 0 to 0.04 running (Cavagna, Thys and \
                  Zamboni, J. Physiol. 262, 1976). Work is that of both actuators from a touchdown to the next of either foot."
            .to_owned(),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 140.0)?,
        table: stairs_table("through-the-change", study),
        wide: true,
    }))
}
