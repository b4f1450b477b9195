//! Motions over the range of the command: speed, phases, cost, energies, steps.

use super::Shown;
use super::panels::{
    FROUDE, HUMAN_RECOVERY, HUMAN_TRANSITION, OMEGA_V, Of, Panel, by_gait, froude, omega_v, points,
    steady_table,
};
use crate::ReportError;
use crate::headline::motions;
use crate::study::{Steady, Study};
use gaitshift_figures::{COLUMN_WIDTH, Chart, PAGE_WIDTH, Series, charts_figure};

/// Speed, phases, cost and change of energy over the range of the command.
pub(super) fn sweep(studies: &[&Study]) -> Result<Shown, ReportError> {
    const PANELS: [Panel; 6] = [
        Panel {
            paper: &[(0.0, 0.22), (3.0, 0.93)],
            levels: HUMAN_TRANSITION,
            ..Panel::new("speed", FROUDE, froude)
        },
        Panel::new("double support", "share of time", |r| {
            r.summary.double_support
        }),
        Panel::new("flight", "share of time", |r| r.summary.flight),
        Panel {
            paper: &[(0.0, 0.342), (3.0, 0.347)],
            ..Panel::new("cost of transport (8)", "positive work/(m g d)", |r| {
                r.summary.cost_of_transport
            })
        },
        Panel::new("variation of energy", "mean |ΔE| in a period (J)", |r| {
            r.energy_change_j
        }),
        Panel {
            levels: HUMAN_RECOVERY,
            ..Panel::new("energy recovery", "share", |r| r.summary.energy_recovery)
        },
    ];
    let charts = PANELS.map(|panel| {
        let mut series: Vec<Series> = studies
            .iter()
            .map(|s| Series::marks(&s.name, points(&s.steady, omega_v, panel.of)))
            .collect();
        series.push(Series::marks("the paper", panel.paper.to_vec()));
        panel.chart(OMEGA_V, series)
    });
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
pub(super) fn cost(studies: &[&Study]) -> Result<Shown, ReportError> {
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

pub(super) fn steps_by_speed(study: &Study) -> Result<Option<Shown>, ReportError> {
    let speed: Of = |r| r.summary.speed_m_per_s;
    const PANELS: [Panel; 2] = [
        Panel::new("", "step length (m)", |r| r.summary.step_length_m),
        Panel::new("", "step frequency (Hz)", |r| r.summary.step_frequency_hz),
    ];
    let charts =
        PANELS.map(|panel| panel.chart("speed (m/s)", by_gait(motions(study), speed, panel.of)));
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
