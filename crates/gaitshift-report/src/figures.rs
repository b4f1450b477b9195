//! The figures of a report, each with the numbers it shows.

use crate::headline::{clearance, least_steady_stair, motions, step_time_variation, two_gaits};
use crate::study::{Measured, Plan, Steady, StepHeight, Study};
use crate::table::{Table, cell};
use crate::trace::{Trace, TraceRow};
use crate::{ReportError, Subject};
use gaitshift_analysis::recording::column;
use gaitshift_analysis::support::{PhaseInterval, SupportPhase};
use gaitshift_analysis::{GaitClass, GaitSummary, Recording};
use gaitshift_figures::{
    Bar, COLUMN_WIDTH, Chart, Figure, FigureOptions, PAGE_WIDTH, Series, bars_figure,
    charts_figure, episode_returns_figure, phase_between, stride_at, strobe, transition_figure,
};

use std::f64::consts::PI;

const OMEGA_V: &str = "command ω\u{1d65} (s/m)";
const FROUDE: &str = "Froude number v/√(g l)";

/// A figure with its title, what it says, and its numbers.
pub(crate) struct Shown {
    /// Name of its files, without ending.
    pub name: String,
    pub title: &'static str,
    pub caption: String,
    pub figure: Figure,
    pub table: Table,
    /// Whether it needs the width of the page.
    pub wide: bool,
}

/// The values that a panel shows of a motion.
type Of = fn(&Steady) -> Option<f64>;

/// The figures over all subjects.
pub(crate) fn of_all(measured: &[Measured]) -> Result<Vec<Shown>, ReportError> {
    let studies: Vec<&Study> = measured.iter().map(|m| &m.study).collect();
    Ok(vec![sweep(&studies)?, cost(&studies)?])
}

/// The figures of one subject.
pub(crate) fn of_one(
    subject: &Subject,
    measured: &Measured,
    plan: &Plan,
) -> Result<Vec<Shown>, ReportError> {
    let m = measured;
    let mut shown = Vec::new();
    for ((recording, start_s), (name, title)) in m.changes.iter().zip([
        ("fig3-walk-to-run", "From walking to running (Fig. 3)"),
        ("fig3-run-to-walk", "From running to walking (Fig. 3)"),
    ]) {
        shown.extend(change(recording, *start_s, plan, name, title)?);
    }
    shown.extend(round_trip(m, plan)?);
    shown.extend(episodes(m)?);
    shown.extend(bifurcation(&m.study)?);
    shown.extend(hip_phase(&m.study)?);
    shown.extend(stride_energies(subject, m, plan)?);
    for (recording, omega_v, name, title) in [
        (
            &m.gaits[0],
            plan.gaits[0],
            "poses-walk",
            "Poses through a stride of the walk",
        ),
        (
            &m.gaits[1],
            plan.gaits[1],
            "poses-run",
            "Poses through a stride of the run",
        ),
    ] {
        shown.extend(poses(recording, omega_v, name, title)?);
    }
    shown.extend(work(&m.study, plan)?);
    shown.extend(ground_reaction(subject, m)?);
    shown.extend(leg_springs(subject, m)?);
    shown.extend(through_the_change(&m.study)?);
    shown.extend(steps_by_speed(&m.study)?);
    shown.extend(ground_steps(&m.study, plan)?);
    Ok(shown)
}

/// The numbers of steady motions as a table.
fn steady_table(name: &str, rows: &[(&str, &Steady)]) -> Table {
    const NUMBERS: [(&str, Of); 30] = [
        ("speed_m_per_s", |r| r.summary.speed_m_per_s),
        ("froude", |r| r.summary.froude),
        ("double_support", |r| r.summary.double_support),
        ("single_support", |r| r.summary.single_support),
        ("flight", |r| r.summary.flight),
        ("both_feet_touching", |r| r.summary.both_feet_touching),
        ("no_foot_touching", |r| r.summary.no_foot_touching),
        ("cost_of_transport", |r| r.summary.cost_of_transport),
        ("absolute_cost_of_transport", |r| {
            r.summary.absolute_cost_of_transport
        }),
        ("squared_force_n2_s_per_m", |r| {
            r.summary.squared_force_n2_s_per_m
        }),
        ("energy_change_j", |r| r.energy_change_j),
        ("energy_recovery", |r| r.summary.energy_recovery),
        ("kinetic_potential_correlation", |r| {
            r.summary.kinetic_potential_correlation
        }),
        ("step_frequency_hz", |r| r.summary.step_frequency_hz),
        ("step_length_m", |r| r.summary.step_length_m),
        ("duty_factor_right", |r| r.summary.duty_factor_right),
        ("duty_factor_left", |r| r.summary.duty_factor_left),
        ("clearance_right_m", |r| r.summary.clearance_right_m),
        ("clearance_left_m", |r| r.summary.clearance_left_m),
        ("slip_work_j_per_m", |r| r.summary.slip_work_j_per_m),
        ("drag_work_j_per_m", |r| r.summary.drag_work_j_per_m),
        ("scuffs_per_step", |r| r.summary.scuffs_per_step),
        ("step_time_variation_right", |r| {
            r.summary.step_time_variation_right
        }),
        ("step_time_variation_left", |r| {
            r.summary.step_time_variation_left
        }),
        ("step_length_variation_right", |r| {
            r.summary.step_length_variation_right
        }),
        ("step_length_variation_left", |r| {
            r.summary.step_length_variation_left
        }),
        ("hip_phase_rad", |r| r.summary.hip_phase_rad),
        ("hip_phase_deviation_rad", |r| {
            r.summary.hip_phase_deviation_rad
        }),
        ("peak_force_right_body_weights", |r| {
            r.summary.peak_force_right_body_weights
        }),
        ("peak_force_left_body_weights", |r| {
            r.summary.peak_force_left_body_weights
        }),
    ];
    let mut table = Table::new(name, &["series", "omega_v", "gait", "fell", "survived_s"]);
    table
        .columns
        .extend(NUMBERS.iter().map(|(name, _)| (*name).to_owned()));
    for (series, row) in rows {
        let mut cells = vec![
            (*series).to_owned(),
            cell(Some(row.omega_v)),
            row.summary.gait.to_string(),
            row.summary.fell.to_string(),
            cell(Some(row.summary.survived_s)),
        ];
        cells.extend(NUMBERS.iter().map(|(_, of)| cell(of(row))));
        table.rows.push(cells);
    }
    table
}

fn points<'a>(rows: impl IntoIterator<Item = &'a Steady>, x: Of, y: Of) -> Vec<(f64, f64)> {
    rows.into_iter()
        .filter_map(|row| Some((x(row)?, y(row)?)))
        .collect()
}

/// The marks of motions, a series for each gait.
fn by_gait<'a>(rows: impl Iterator<Item = &'a Steady> + Clone, x: Of, y: Of) -> Vec<Series> {
    [
        (GaitClass::Walking, "walking"),
        (GaitClass::Mixed, "neither"),
        (GaitClass::Running, "running"),
    ]
    .into_iter()
    .map(|(gait, label)| {
        let of_gait = rows.clone().filter(|row| row.summary.gait == gait);
        Series::marks(label, points(of_gait, x, y))
    })
    .collect()
}

/// The marks of the stairs, up and down.
fn on_stairs(study: &Study, of: Of) -> Vec<Series> {
    vec![
        Series::marks("command rising", points(&study.stairs_up, omega_v, of)),
        Series::marks("command falling", points(&study.stairs_down, omega_v, of)),
    ]
}

/// The numbers of the stairs as a table.
fn stairs_table(name: &str, study: &Study) -> Table {
    let up = study.stairs_up.iter().map(|row| ("rising", row));
    let down = study.stairs_down.iter().map(|row| ("falling", row));
    steady_table(name, &up.chain(down).collect::<Vec<_>>())
}

fn omega_v(row: &Steady) -> Option<f64> {
    Some(row.omega_v)
}

fn froude(row: &Steady) -> Option<f64> {
    row.summary.froude
}

/// Speed, phases, cost and change of energy over the range of the command.
fn sweep(studies: &[&Study]) -> Result<Shown, ReportError> {
    /// Of each panel its title, its axis, its value, and the paper's points.
    type Kind = (&'static str, &'static str, Of, &'static [(f64, f64)]);
    const PANELS: [Kind; 6] = [
        ("speed", FROUDE, froude, &[(0.0, 0.22), (3.0, 0.93)]),
        (
            "double support",
            "share of time",
            |r| r.summary.double_support,
            &[],
        ),
        ("flight", "share of time", |r| r.summary.flight, &[]),
        (
            "cost of transport (8)",
            "positive work/(m g d)",
            |r| r.summary.cost_of_transport,
            &[(0.0, 0.342), (3.0, 0.347)],
        ),
        (
            "variation of energy",
            "mean |ΔE| in a period (J)",
            |r| r.energy_change_j,
            &[],
        ),
        (
            "energy recovery",
            "share",
            |r| r.summary.energy_recovery,
            &[],
        ),
    ];
    let charts: Vec<Chart> = PANELS
        .iter()
        .map(|&(title, y_title, of, paper)| {
            let mut series: Vec<Series> = studies
                .iter()
                .map(|s| Series::marks(&s.name, points(&s.steady, omega_v, of)))
                .collect();
            series.push(Series::marks("the paper", paper.to_vec()));
            Chart {
                title: title.to_owned(),
                x_title: OMEGA_V.to_owned(),
                y_title: y_title.to_owned(),
                series,
                levels: match title {
                    "speed" => human_transition(),
                    "energy recovery" => human_recovery(),
                    _ => Vec::new(),
                },
                y_shows: vec![0.0],
                ..Chart::default()
            }
        })
        .collect();
    let rows: Vec<(&str, &Steady)> = studies
        .iter()
        .flat_map(|s| s.steady.iter().map(|row| (s.name.as_str(), row)))
        .collect();
    Ok(Shown {
        name: "sweep".to_owned(),
        title: "Over the range of the command",
        caption: "Each mark is one motion from the default start, without action noise; the first 5 s are not measured. \
                  The marks are not joined, because there is a gap between walk and run. People change between walk and run at v²/(g l) \
                  of about 0.5 (Kram, Domingo and Ferris, J. Exp. Biol. 200, 1997), and recover up to about 0.65 of the energy walking \
                  (Cavagna, Thys and Zamboni, J. Physiol. 262, 1976)."
            .to_owned(),
        figure: charts_figure(&charts, 3, PAGE_WIDTH, 130.0)?,
        table: steady_table("sweep", &rows),
        wide: true,
    })
}

/// Cost of transport against Froude number, beside published values.
fn cost(studies: &[&Study]) -> Result<Shown, ReportError> {
    let several = studies.len() > 1;
    let cost: Of = |r| r.summary.cost_of_transport;
    let mut series = Vec::new();
    let mut rows = Vec::new();
    for study in studies {
        rows.extend(study.steady.iter().map(|row| (study.name.as_str(), row)));
        if several {
            series.push(Series::marks(
                &study.name,
                points(&study.steady, froude, cost),
            ));
        } else {
            series.extend(by_gait(study.steady.iter(), froude, cost));
        }
    }
    series.push(Series::marks(
        "the paper",
        vec![(0.22, 0.342), (0.93, 0.347)],
    ));
    let chart = Chart {
        x_title: FROUDE.to_owned(),
        y_title: "cost of transport (8)".to_owned(),
        series,
        levels: vec![
            (0.20, "Cornell biped, total".to_owned()),
            (0.28, "Cornell Ranger, total".to_owned()),
        ],
        y_shows: vec![0.0],
        ..Chart::default()
    };
    Ok(Shown {
        name: "cost-of-transport".to_owned(),
        title: "Cost of transport against speed",
        caption: "(8) counts the positive mechanical work of the actuators alone. The dotted lines are total costs, including all \
                  power consumed: Collins, Ruina, Tedrake and Wisse, Science 307, 2005; Bhounsule and others, Int. J. Robot. Res. 33, \
                  2014. ASIMO's total, 3.2 at 0.18, lies far above the panel."
            .to_owned(),
        figure: charts_figure(&[chart], 1, COLUMN_WIDTH, 190.0)?,
        table: steady_table("cost-of-transport", &rows),
        wide: false,
    })
}

/// A time series of a recording as a table.
fn recording_table(name: &str, recording: &Recording, from_s: f64, to_s: f64) -> Table {
    let mut table = Table::new(name, &[]);
    let columns: Vec<(&str, &[f64])> = recording.every_column().collect();
    table.columns = columns.iter().map(|(name, _)| (*name).to_owned()).collect();
    if let Some(window) = recording.window(from_s, to_s) {
        for row in window.start_row()..=window.end_row() {
            let cells = columns.iter().map(|(_, series)| cell(Some(series[row])));
            table.rows.push(cells.collect());
        }
    }
    table
}

fn change(
    recording: &Recording,
    start_s: f64,
    plan: &Plan,
    name: &str,
    title: &'static str,
) -> Result<Option<Shown>, ReportError> {
    let ramp = (start_s, start_s + plan.ramp_s);
    if recording.duration_s() < ramp.1 {
        return Ok(None);
    }
    let figure = transition_figure(
        recording,
        ramp,
        &FigureOptions {
            width: COLUMN_WIDTH,
            ..FigureOptions::default()
        },
    )?;
    Ok(Some(Shown {
        name: name.to_owned(),
        title,
        caption: format!(
            "Energies and speed; the command changes within {} s (hatched). Potential energy counts from its lowest value.",
            plan.ramp_s
        ),
        figure,
        table: recording_table(name, recording, start_s - 2.5, start_s + plan.ramp_s + 2.5),
        wide: false,
    }))
}

fn round_trip(m: &Measured, plan: &Plan) -> Result<Option<Shown>, ReportError> {
    let recording = &m.round_trip;
    if recording.duration_s() < 20.0 + plan.ramp_s {
        return Ok(None);
    }
    let (from_s, to_s) = (6.0, 26.0);
    let time = recording.column(column::TIME_S);
    let window = recording.window(from_s, to_s);
    let series = |of: gaitshift_analysis::recording::Column| -> Vec<(f64, f64)> {
        window.map_or_else(Vec::new, |w| {
            (w.start_row()..=w.end_row())
                .map(|row| (time[row], recording.column(of)[row]))
                .collect()
        })
    };
    let charts = [
        ("speed (m/s)", "speed", column::X_VELOCITY_M_PER_S),
        ("ω\u{1d65} (s/m)", "command", column::OMEGA_V),
    ]
    .map(|(y_title, label, of)| Chart {
        x_title: "time (s)".to_owned(),
        y_title: y_title.to_owned(),
        series: vec![Series::line(label, series(of))],
        x_range: Some((from_s, to_s)),
        ..Chart::default()
    });
    let gaits: Vec<String> = m
        .study
        .walk_run_walk
        .iter()
        .map(GaitClass::to_string)
        .collect();
    let took = m.study.round_trip.iter().filter_map(|change| {
        let (from, to) = (change.gait_before?, change.gait_after?);
        let steps = change.steps_to_change?;
        let word = if steps == 1 { "step" } else { "steps" };
        Some(format!(" From {from} to {to} within {steps} {word}."))
    });
    let took: Vec<String> = took.collect();
    let table = recording_table("walk-run-walk", recording, from_s, to_s);
    Ok(Some(Shown {
        name: "walk-run-walk".to_owned(),
        title: "Walk, run and walk again",
        caption: format!(
            "One motion; its gaits: {}.{}",
            gaits.join(", "),
            took.join("")
        ),
        figure: charts_figure(&charts, 1, COLUMN_WIDTH, 100.0)?,
        table,
        wide: false,
    }))
}

fn episodes(m: &Measured) -> Result<Option<Shown>, ReportError> {
    let e = &m.episodes;
    if e.steps.is_empty() {
        return Ok(None);
    }
    let mut table = Table::new("fig4-returns", &["step", "omega_v", "return", "fell"]);
    for k in 0..e.steps.len() {
        table.rows.push(vec![
            cell(Some(e.steps[k])),
            cell(Some(e.omega_v[k])),
            cell(Some(e.returns[k])),
            e.fell[k].to_string(),
        ]);
    }
    Ok(Some(Shown {
        name: "fig4-returns".to_owned(),
        title: "Return of every episode over training (Fig. 4)",
        caption: "Each dot is an episode; its shade is the command.".to_owned(),
        figure: episode_returns_figure(&e.steps, &e.returns, &e.omega_v)?,
        table,
        wide: false,
    }))
}

/// The change of gait as a bifurcation: stairs of the command up and down, and random starts.
fn bifurcation(study: &Study) -> Result<Option<Shown>, ReportError> {
    if study.stairs_up.is_empty() {
        return Ok(None);
    }
    const PANELS: [(&str, Of); 4] = [
        ("Froude number", froude),
        ("duty factor, right", |r| r.summary.duty_factor_right),
        ("double support", |r| r.summary.double_support),
        ("flight", |r| r.summary.flight),
    ];
    let leg_m_g = study
        .stairs_up
        .iter()
        .find_map(|row| Some(row.summary.speed_m_per_s? / row.summary.froude?));
    let started: Vec<(f64, f64)> = study
        .starts
        .iter()
        .filter(|m| m.gait != GaitClass::Fallen)
        .filter_map(|m| Some((m.omega_v, m.speed_m_per_s? / leg_m_g?)))
        .collect();
    let started_duty: Vec<(f64, f64)> = study
        .starts
        .iter()
        .filter(|m| m.gait != GaitClass::Fallen)
        .filter_map(|m| Some((m.omega_v, m.duty_factor?)))
        .collect();
    let charts: Vec<Chart> = PANELS
        .iter()
        .enumerate()
        .map(|(k, &(y_title, of))| {
            let mut series = on_stairs(study, of);
            match k {
                0 => series.push(Series::marks("random starts", started.clone()).below()),
                1 => series.push(Series::marks("random starts", started_duty.clone()).below()),
                _ => {}
            }
            Chart {
                x_title: OMEGA_V.to_owned(),
                y_title: y_title.to_owned(),
                series,
                levels: if k == 0 {
                    human_transition()
                } else {
                    Vec::new()
                },
                y_shows: vec![0.0],
                ..Chart::default()
            }
        })
        .collect();
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

/// The speed at which people change between walk and run: v²/(g l) = 0.5.
fn human_transition() -> Vec<(f64, String)> {
    vec![(0.5_f64.sqrt(), "people change gait".to_owned())]
}

/// The greatest share of energy that people recover as a pendulum does.
fn human_recovery() -> Vec<(f64, String)> {
    vec![(0.65, "people walking, at best".to_owned())]
}

/// The phase between the hips and how steady the stride is, through the change of gait.
fn hip_phase(study: &Study) -> Result<Option<Shown>, ReportError> {
    let panels: [(&str, Of, f64); 4] = [
        ("left to right hip (rad)", |r| r.summary.hip_phase_rad, PI),
        (
            "its deviation (rad)",
            |r| r.summary.hip_phase_deviation_rad,
            0.0,
        ),
        (
            "step time variation",
            |r| step_time_variation(&r.summary),
            0.0,
        ),
        (
            "clearance (mm)",
            |r| Some(1e3 * clearance(&r.summary)?),
            0.0,
        ),
    ];
    if points(&study.stairs_up, omega_v, panels[0].1).is_empty() {
        return Ok(None);
    }
    let charts = panels.map(|(y_title, of, shows)| Chart {
        x_title: OMEGA_V.to_owned(),
        y_title: y_title.to_owned(),
        series: on_stairs(study, of),
        y_shows: vec![shows],
        ..Chart::default()
    });
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

/// Which heights of steps in the ground are passed.
fn ground_steps(study: &Study, plan: &Plan) -> Result<Option<Shown>, ReportError> {
    let kind = |row: &StepHeight| match (row.by_turns, row.height_m > 0.0) {
        (true, _) => "up and down by turns, every 50 cm",
        (false, true) => "one step up",
        (false, false) => "one step down",
    };
    let mut table = Table::new(
        "ground-steps",
        &["omega_v", "steps", "height_m", "passed", "tried"],
    );
    for row in &study.step_heights {
        table.rows.push(vec![
            cell(Some(row.omega_v)),
            kind(row).to_owned(),
            cell(Some(row.height_m)),
            row.successes.to_string(),
            row.trials.to_string(),
        ]);
    }
    let mut charts = Vec::new();
    for (omega_v, title, theirs_cm) in [
        (plan.gaits[0], "walking", 1.0),
        (plan.gaits[1], "running", 0.8),
    ] {
        let mut series: Vec<Series> = [
            "one step up",
            "one step down",
            "up and down by turns, every 50 cm",
        ]
        .into_iter()
        .map(|name| {
            let rows = study.step_heights.iter();
            let of_kind = rows.filter(|row| row.omega_v == omega_v && kind(row) == name);
            let share = |row: &StepHeight| row.successes as f64 / row.trials.max(1) as f64;
            let passed = of_kind.map(|row| (100.0 * row.height_m.abs(), share(row)));
            Series::marked_line(name, passed.collect())
        })
        .collect();
        series.push(Series::marks(
            "step up survived in the journal version",
            vec![(theirs_cm, 1.0)],
        ));
        charts.push(Chart {
            title: format!("{title}, ω\u{1d65} = {omega_v}"),
            x_title: "height of the step (cm)".to_owned(),
            y_title: "share of places passed".to_owned(),
            series,
            y_shows: vec![0.0],
            ..Chart::default()
        });
    }
    if study.step_heights.is_empty() {
        return Ok(None);
    }
    Ok(Some(Shown {
        name: "ground-steps".to_owned(),
        title: "Steps in the ground",
        caption: "Each height is tried with the first face at several places 5 cm apart, over half a metre; passed is what the body gets 4 m \
                  beyond. Heights after the first that is passed nowhere are not tried. By turns, the ground rises and falls again every \
                  50 cm until there."
            .to_owned(),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 130.0)?,
        table,
        wide: true,
    }))
}

fn hysteresis(study: &Study) -> String {
    use crate::headline::{running_begins, running_is_kept};
    match (running_begins(study), running_is_kept(study)) {
        (Some(begins), Some(kept)) => {
            format!("Running begins at {begins} on the way up and is kept down to {kept}. ")
        }
        _ => String::new(),
    }
}

/// A whole stride of the right leg in a trace, from touchdown to touchdown.
fn stride(trace: &Trace, weight_n: f64) -> Option<std::ops::Range<usize>> {
    let stances = trace.stances(0, weight_n);
    let middle = stances.len() / 2;
    Some(stances.get(middle.checked_sub(1)?)?.start..stances.get(middle)?.start)
}

/// The support phases of a stride, x from 0 to 1.
fn phases(trace: &Trace, stride: &std::ops::Range<usize>, weight_n: f64) -> Vec<PhaseInterval> {
    let stances = [0, 1].map(|leg| trace.stances(leg, weight_n));
    let phase_of = |row: usize| {
        let down = |leg: usize| stances[leg].iter().any(|stance| stance.contains(&row));
        match (down(0), down(1)) {
            (true, true) => SupportPhase::Double,
            (true, false) => SupportPhase::SingleRight,
            (false, true) => SupportPhase::SingleLeft,
            (false, false) => SupportPhase::Flight,
        }
    };
    let share = |row: usize| (row - stride.start) as f64 / stride.len() as f64;
    let mut intervals = Vec::new();
    let mut begun = stride.start;
    for row in stride.start + 1..=stride.end {
        if row == stride.end || phase_of(row) != phase_of(begun) {
            intervals.extend(phase_between(phase_of(begun), share(begun), share(row)));
            begun = row;
        }
    }
    intervals
}

fn weight_n(subject: &Subject) -> f64 {
    let p = subject.body.parameters();
    p.total_mass_kg() * p.gravity_m_per_s2
}

/// Every `n`th row of a trace's stretch, which is more than a figure needs.
fn thinned<'a>(
    trace: &'a Trace,
    range: &std::ops::Range<usize>,
) -> impl Iterator<Item = (f64, &'a TraceRow)> + use<'a> {
    let length = range.len().max(1);
    let every = (length / 400).max(1);
    trace.rows[range.clone()]
        .iter()
        .enumerate()
        .step_by(every)
        .map(move |(k, row)| (k as f64 / length as f64, row))
}

/// Energies over a stride of each gait, phases shaded.
fn stride_energies(
    subject: &Subject,
    m: &Measured,
    plan: &Plan,
) -> Result<Option<Shown>, ReportError> {
    let weight = weight_n(subject);
    let mut table = Table::new(
        "stride-energies",
        &[
            "omega_v",
            "phase",
            "kinetic_j",
            "gravitational_j",
            "leg_springs_j",
            "hip_springs_j",
        ],
    );
    let mut charts = Vec::new();
    for (omega_v, title) in plan.gaits.into_iter().zip(["walking", "running"]) {
        let Some((_, trace)) = m.traces.iter().find(|(w, _)| *w == omega_v) else {
            continue;
        };
        let Some(stride) = stride(trace, weight) else {
            continue;
        };
        let rows = &trace.rows[stride.clone()];
        let lowest = rows
            .iter()
            .map(|r| r.energies_j[1])
            .fold(f64::INFINITY, f64::min);
        for (phase, row) in thinned(trace, &stride) {
            let mut cells = vec![cell(Some(omega_v)), cell(Some(phase))];
            cells.extend(row.energies_j.map(|e| cell(Some(e))));
            table.rows.push(cells);
        }
        let line = |index: usize, offset: f64| -> Vec<(f64, f64)> {
            thinned(trace, &stride)
                .map(|(phase, row)| (phase, row.energies_j[index] - offset))
                .collect()
        };
        let kinds: [(&str, Vec<Series>); 3] = [
            ("kinetic (J)", vec![Series::line("kinetic", line(0, 0.0))]),
            (
                "potential (J)",
                vec![Series::line("potential", line(1, lowest))],
            ),
            (
                "elastic (J)",
                vec![
                    Series::line("leg springs", line(2, 0.0)),
                    Series::line("hip springs", line(3, 0.0)),
                ],
            ),
        ];
        for (k, (y_title, series)) in kinds.into_iter().enumerate() {
            charts.push(Chart {
                title: if k == 0 {
                    format!("{title}, ω\u{1d65} = {omega_v}")
                } else {
                    String::new()
                },
                x_title: "phase of the stride".to_owned(),
                y_title: y_title.to_owned(),
                series,
                phases: phases(trace, &stride, weight),
                x_range: Some((0.0, 1.0)),
                ..Chart::default()
            });
        }
    }
    if charts.is_empty() {
        return Ok(None);
    }
    // Gaits beside each other, energies below each other.
    let columns = charts.len() / 3;
    let ordered: Vec<Chart> = (0..3)
        .flat_map(|kind| (0..columns).map(move |gait| 3 * gait + kind))
        .map(|index| charts[index].clone())
        .collect();
    Ok(Some(Shown {
        name: "stride-energies".to_owned(),
        title: "Energies over one stride",
        caption: "From a touchdown of the right foot to its next, at the integration step. Springs of the legs and of the \
                  hips are shown separately; the paper's elastic energy is their sum."
            .to_owned(),
        figure: charts_figure(&ordered, columns, PAGE_WIDTH, 90.0)?,
        table,
        wide: true,
    }))
}

fn poses(
    recording: &Recording,
    omega_v: f64,
    name: &str,
    title: &'static str,
) -> Result<Option<Shown>, ReportError> {
    let Some((from_s, to_s)) = stride_at(recording, 0.75 * recording.duration_s()) else {
        return Ok(None);
    };
    Ok(Some(Shown {
        name: name.to_owned(),
        title,
        caption: format!("ω_v = {omega_v}. Below, filled: the foot is on the ground."),
        figure: strobe(recording, from_s, to_s, 10)?,
        table: recording_table(name, recording, from_s, to_s),
        wide: true,
    }))
}

/// Where energy comes from and where it goes, walking and running.
fn work(study: &Study, plan: &Plan) -> Result<Option<Shown>, ReportError> {
    let mut bars = Vec::new();
    let mut table = Table::new(
        "energy-flow",
        &[
            "omega_v",
            "kind",
            "element",
            "right_j_per_stride",
            "left_j_per_stride",
        ],
    );
    for (omega_v, gait) in plan.gaits.into_iter().zip(["walk", "run"]) {
        let Some(flow) = study.at(omega_v).and_then(|s| s.energy_flow) else {
            continue;
        };
        for (kind, parts) in [("given", &flow.sources()[..]), ("lost", &flow.losses()[..])] {
            bars.push(Bar {
                label: format!("{gait}, {kind}"),
                parts: parts
                    .iter()
                    .map(|(name, pair)| ((*name).to_owned(), (pair[0] + pair[1]).max(0.0)))
                    .collect(),
            });
            for (name, pair) in parts {
                table.rows.push(vec![
                    cell(Some(omega_v)),
                    kind.to_owned(),
                    (*name).to_owned(),
                    cell(Some(pair[0])),
                    cell(Some(pair[1])),
                ]);
            }
        }
    }
    if bars.is_empty() {
        return Ok(None);
    }
    Ok(Some(Shown {
        name: "energy-flow".to_owned(),
        title: "Where energy comes from and where it goes",
        caption: "Given: positive work of the actuators, and the energy returned by springs, end stops and the compressed \
                  contact. Lost: dissipated; the actuators' negative work is not shown. Both legs, summed at the integration step."
            .to_owned(),
        figure: bars_figure(&bars, "energy per stride (J)", PAGE_WIDTH)?,
        table,
        wide: true,
    }))
}

/// Bins of a stance in the mean course of a force.
const BINS: usize = 200;

/// The vertical force over stance in body weights, mean over the stances of both legs, as (share of stance, force).
fn mean_force(trace: &Trace, weight: f64) -> Vec<(f64, f64)> {
    let mut sums = vec![0.0; BINS];
    let mut count = 0.0;
    for leg in 0..2 {
        for stance in trace.stances(leg, weight) {
            count += 1.0;
            for (bin, sum) in sums.iter_mut().enumerate() {
                let from = stance.start + stance.len() * bin / BINS;
                let to = (stance.start + stance.len() * (bin + 1) / BINS).max(from + 1);
                let rows = &trace.rows[from..to.min(trace.rows.len())];
                let force: f64 = rows.iter().map(|row| row.normal_n[leg]).sum();
                *sum += force / rows.len().max(1) as f64 / weight;
            }
        }
    }
    if count == 0.0 {
        return Vec::new();
    }
    sums.iter()
        .enumerate()
        .map(|(bin, sum)| ((bin as f64 + 0.5) / BINS as f64, sum / count))
        .collect()
}

fn ground_reaction(subject: &Subject, m: &Measured) -> Result<Option<Shown>, ReportError> {
    let weight = weight_n(subject);
    let mut table = Table::new(
        "ground-reaction",
        &["omega_v", "share_of_stance", "vertical_body_weights"],
    );
    let mut panels = [Vec::new(), Vec::new()];
    for (omega_v, trace) in &m.traces {
        let points = mean_force(trace, weight);
        for &(x, y) in &points {
            table
                .rows
                .push(vec![cell(Some(*omega_v)), cell(Some(x)), cell(Some(y))]);
        }
        let runs = *omega_v > 0.5;
        panels[usize::from(runs)].push(Series::line(&format!("ω\u{1d65} = {omega_v}"), points));
    }
    let charts: Vec<Chart> = panels
        .into_iter()
        .zip(["low commands", "high commands"])
        .filter(|(series, _)| series.iter().any(|s| !s.points.is_empty()))
        .map(|(series, title)| Chart {
            title: title.to_owned(),
            x_title: "share of stance".to_owned(),
            y_title: "force (body weights)".to_owned(),
            series,
            levels: match title {
                "low commands" => vec![(1.2, "people walking, greatest".to_owned())],
                _ => vec![(2.5, "people running, greatest".to_owned())],
            },
            y_shows: vec![0.0],
            x_range: Some((0.0, 1.0)),
            ..Chart::default()
        })
        .collect();
    if charts.is_empty() {
        return Ok(None);
    }
    Ok(Some(Shown {
        name: "ground-reaction".to_owned(),
        title: "Vertical ground reaction over stance",
        caption: "Mean over the stances of both legs, from forces at the integration step; the peak at touchdown lasts a few \
                  milliseconds and is higher in each stance than in their mean. Human curves have two humps in walking and one in \
                  running, after a small impact; the greatest force is 1.2 body weights walking at 1.5 m/s and about 2.5 running at \
                  6 m/s (Keller and others, Clin. Biomech. 11, 1996)."
            .to_owned(),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 150.0)?,
        table,
        wide: true,
    }))
}

/// Force along the leg against leg length in the run.
fn leg_springs(subject: &Subject, m: &Measured) -> Result<Option<Shown>, ReportError> {
    let weight = weight_n(subject);
    let mut table = Table::new(
        "leg-force-length",
        &["omega_v", "leg", "time_s", "length_m", "force_body_weights"],
    );
    let mut charts = Vec::new();
    for (omega_v, trace) in m.traces.iter().filter(|(w, _)| [0.0, 3.0].contains(w)) {
        let mut series = Vec::new();
        // Left first: it is blue everywhere, and right vermilion.
        for (leg, name) in [(1, "left leg"), (0, "right leg")] {
            let Some(stance) = trace.stances(leg, weight).into_iter().nth(1) else {
                continue;
            };
            let line: Vec<(f64, f64)> = thinned(trace, &stance)
                .map(|(_, row)| (row.length_m[leg], row.axial_n[leg] / weight))
                .collect();
            for (_, row) in thinned(trace, &stance) {
                table.rows.push(vec![
                    cell(Some(*omega_v)),
                    name.to_owned(),
                    cell(Some(row.time_s)),
                    cell(Some(row.length_m[leg])),
                    cell(Some(row.axial_n[leg] / weight)),
                ]);
            }
            series.push(Series::line(name, line));
        }
        charts.push(Chart {
            title: format!("ω\u{1d65} = {omega_v}"),
            x_title: "leg length (m)".to_owned(),
            y_title: "force (body weights)".to_owned(),
            series,
            y_shows: vec![0.0],
            ..Chart::default()
        });
    }
    if charts.iter().all(|c| c.series.is_empty()) {
        return Ok(None);
    }
    let explained = m.study.landings.iter().filter_map(|l| {
        let share = l.spring_like?;
        Some(format!("{share:.2} at {}", l.omega_v))
    });
    let explained: Vec<String> = explained.collect();
    Ok(Some(Shown {
        name: "leg-force-length".to_owned(),
        title: "Leg force against leg length",
        caption: format!(
            "Ground reaction along the leg; one stance of each. A spring-mass leg would follow a single line up and \
             down. Share of the variance that a straight line explains, over all stances: {}.",
            explained.join(", ")
        ),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 150.0)?,
        table,
        wide: true,
    }))
}

/// Pendular recovery and energy per step through the change of gait.
fn through_the_change(study: &Study) -> Result<Option<Shown>, ReportError> {
    if study.stairs_up.is_empty() {
        return Ok(None);
    }
    fn work_per_step(summary: &GaitSummary) -> Option<f64> {
        let flow = summary.energy_flow?;
        Some(0.5 * (flow.actuators[0] + flow.actuators[1]))
    }
    let panels: [(&str, Of); 2] = [
        ("energy recovery", |r| r.summary.energy_recovery),
        ("actuators' work per step (J)", |r| {
            work_per_step(&r.summary)
        }),
    ];
    let charts = panels.map(|(y_title, of)| Chart {
        x_title: OMEGA_V.to_owned(),
        y_title: y_title.to_owned(),
        series: on_stairs(study, of),
        levels: match y_title {
            "energy recovery" => human_recovery(),
            _ => Vec::new(),
        },
        y_shows: vec![0.0],
        ..Chart::default()
    });
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

fn steps_by_speed(study: &Study) -> Result<Option<Shown>, ReportError> {
    let speed: Of = |r| r.summary.speed_m_per_s;
    let panels: [(&str, Of); 2] = [
        ("step length (m)", |r| r.summary.step_length_m),
        ("step frequency (Hz)", |r| r.summary.step_frequency_hz),
    ];
    let charts = panels.map(|(y_title, of)| Chart {
        x_title: "speed (m/s)".to_owned(),
        y_title: y_title.to_owned(),
        series: by_gait(motions(study), speed, of),
        y_shows: vec![0.0],
        ..Chart::default()
    });
    if charts
        .iter()
        .all(|c| c.series.iter().all(|s| s.points.is_empty()))
    {
        return Ok(None);
    }
    let rows: Vec<(&str, &Steady)> = motions(study).map(|row| ("", row)).collect();
    Ok(Some(Shown {
        name: "steps-by-speed".to_owned(),
        title: "Step length and step frequency",
        caption: "All steady motions of the sweep and of the stairs.".to_owned(),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 140.0)?,
        table: steady_table("steps-by-speed", &rows),
        wide: true,
    }))
}
