//! Motions over the range of the command: speed, phases, cost, energies, steps.

use super::Shown;
use super::panels::{
    FROUDE, HUMAN_RECOVERY, HUMAN_TRANSITION, OMEGA_V, Of, Panel, SHARE_OF_TIME, by_gait, froude,
    has_fallen, named_rows, points, steady_table,
};
use super::seeds::{Experiment, OVER_SEEDS, over_commands, over_seeds};
use crate::ReportError;
use crate::headline::motions;
use crate::study::{Steady, Study};
use gaitshift_analysis::GaitClass;
use gaitshift_figures::{COLUMN_WIDTH, Chart, PAGE_WIDTH, Series, charts_figure};

/// Speed, phases, cost and change of energy over the range of the command.
pub(super) fn sweep(studies: &[&Study]) -> Result<Shown, ReportError> {
    const PANELS: [Panel; 6] = [
        Panel {
            paper: &[(0.0, 0.22), (3.0, 0.93)],
            levels: HUMAN_TRANSITION,
            ..Panel::new("speed", FROUDE, froude)
        },
        Panel::new("double support", SHARE_OF_TIME, |r| {
            r.summary.double_support
        }),
        Panel::new("flight", SHARE_OF_TIME, |r| r.summary.flight),
        Panel {
            paper: &[(0.0, 0.342), (3.0, 0.347)],
            ..Panel::new("cost of transport (8)", "positive work/(m g d)", |r| {
                r.summary.cost_of_transport
            })
        },
        Panel::new("change of energy", "mean |ΔE| (J)", |r| r.energy_change_j),
        Panel {
            levels: HUMAN_RECOVERY,
            ..Panel::new("energy recovery", "share", |r| r.summary.energy_recovery)
        },
    ];
    let experiments = Experiment::all(studies);
    let charts = PANELS.map(|panel| {
        let mut series: Vec<Series> = experiments
            .iter()
            .map(|experiment| over_commands(&panel, &experiment.label, &experiment.seeds))
            .collect();
        series.push(Series::marks("the paper", panel.paper.to_vec()));
        panel.chart(OMEGA_V, series)
    });
    let several = if experiments.iter().any(|e| e.seeds.len() > 1) {
        OVER_SEEDS
    } else {
        ""
    };
    Ok(Shown {
        name: "sweep".to_owned(),
        title: "Over the range of the command",
        caption: format!(
            "Motions from the default start, without action noise; the first 5 s are not measured, and of those that fell only the \
             fall is shown. {}{several}ΔE is the change of the total energy within a control period, so it grows with that period. People change between walk and \
             run at v²/(g l) of about 0.5 (Kram, Domingo and Ferris, J. Exp. Biol. 200, 1997), and recover up to about 0.65 of the \
             energy walking (Cavagna, Thys and Zamboni, J. Physiol. 262, 1976).",
            between_the_gaits(studies)
        ),
        figure: charts_figure(&charts, 3, PAGE_WIDTH, 130.0)?,
        table: steady_table("sweep", &named_rows(studies)),
        wide: true,
    })
}

/// Whether there is a gap in speed between walk and run, or what fills it, in a sentence.
fn between_the_gaits(studies: &[&Study]) -> String {
    // Of the motions of the sweep the fastest walk, the slowest run, and how many of neither gait lie between the two and above.
    let gap = |study: &Study| {
        let of_gait = |gait| {
            let rows = study
                .steady
                .iter()
                .filter(move |row| row.summary.gait == gait);
            rows.filter_map(froude)
        };
        let walk = of_gait(GaitClass::Walking).reduce(f64::max)?;
        let run = of_gait(GaitClass::Running).reduce(f64::min)?;
        let between = of_gait(GaitClass::Mixed).filter(|fr| (walk..run).contains(fr));
        let above = of_gait(GaitClass::Mixed).filter(|fr| *fr >= run);
        Some((walk, run, [between.count(), above.count()]))
    };
    let gaps: Vec<(f64, f64, [usize; 2])> =
        studies.iter().filter_map(|&study| gap(study)).collect();
    match (studies, &gaps[..]) {
        ([_], []) => "It does not have both a walk and a run. ".to_owned(),
        ([_], &[(walk, run, _), ..]) if walk >= run => format!(
            "The fastest walk of these has a Froude number of {walk:.2}, the slowest run one of {run:.2}: there is no gap between them. "
        ),
        ([_], &[(walk, run, [between, above]), ..]) => format!(
            "Between the fastest walk of these, with a Froude number of {walk:.2}, and the slowest run, with {run:.2}, lie {between} motions \
             of neither gait; {above} of neither are faster. "
        ),
        _ => format!(
            "Of {} controllers {} have a walk and a run; in {} of these motions of neither gait lie between the fastest walk and the \
             slowest run. ",
            studies.len(),
            gaps.len(),
            gaps.iter()
                .filter(|(_, _, [between, _])| *between > 0)
                .count()
        ),
    }
}

/// Costs of robots that walk, whose Froude numbers are not at hand.
const PUBLISHED: [(&str, f64); 2] = [
    ("Cornell biped, total", 0.20),
    ("Cornell Ranger, total", 0.28),
];

/// Width of the bins of the Froude number over which seeds are averaged.
const BIN: f64 = 0.05;

/// Cost of transport against Froude number, beside published values.
pub(super) fn cost(studies: &[&Study]) -> Result<Shown, ReportError> {
    // What goes backwards has a negative cost, which has no place on a logarithmic axis.
    let cost: Of = |r| r.summary.cost_of_transport.filter(|&cost| cost > 0.0);
    let experiments = Experiment::all(studies);
    let mut series = Vec::new();
    let mut several = "";
    for experiment in &experiments {
        match (&experiment.seeds[..], &experiments[..]) {
            ([only], [_]) => series.extend(by_gait(only.steady.iter(), froude, cost)),
            ([only], _) => {
                let marks = points(&only.steady, froude, cost);
                series.push(Series::marks(&experiment.label, marks));
            }
            (seeds, _) => {
                several = " Over seeds: of each seed the mean cost in bins of the Froude number of 0.05, of these the interquartile \
                           mean with its 95 % bootstrap interval; thin: each seed.";
                let runs = seeds
                    .iter()
                    .map(|s| in_bins(&points(&s.steady, froude, cost)));
                series.push(over_seeds(&experiment.label, runs.collect()));
            }
        }
    }
    let rows = named_rows(studies);
    let fallen = rows.iter().filter(|(_, row)| has_fallen(row)).count();
    series.push(Series::marks(
        "the paper, mechanical",
        vec![(0.22, 0.342), (0.93, 0.347)],
    ));
    series.push(Series::marks("ASIMO, total", vec![(0.184, 3.2)]));
    let chart = Chart {
        x_title: FROUDE.to_owned(),
        y_title: "cost of transport, energy/(m g d), log. scale".to_owned(),
        series,
        levels: PUBLISHED
            .map(|(name, total)| (total, name.to_owned()))
            .to_vec(),
        y_shows: vec![0.1],
        y_log: true,
        ..Chart::default()
    };
    Ok(Shown {
        name: "cost-of-transport".to_owned(),
        title: "Cost of transport against speed",
        caption: format!(
            "Ours and the paper’s is mechanical: (8), the positive work of the actuators alone. Totals count all power consumed: ASIMO \
             (the paper’s value) and, as dotted lines since their Froude numbers are not at hand, the Cornell biped (Collins, Ruina, \
             Tedrake and Wisse, Science 307, 2005) and Ranger (Bhounsule and others, Int. J. Robot. Res. 33, 2014).{several}{}",
            match fallen {
                0 => String::new(),
                n => format!(" Without {n} motions that fell."),
            }
        ),
        figure: charts_figure(&[chart], 1, COLUMN_WIDTH, 210.0)?,
        table: steady_table("cost-of-transport", &rows),
        wide: false,
    })
}

/// Means in bins of x, each at its bin's middle.
fn in_bins(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut bins: std::collections::BTreeMap<i64, Vec<f64>> = std::collections::BTreeMap::new();
    for &(x, y) in points {
        bins.entry((x / BIN).floor() as i64).or_default().push(y);
    }
    bins.into_iter()
        .map(|(bin, values)| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            ((bin as f64 + 0.5) * BIN, mean)
        })
        .collect()
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
        caption: "All motions of the sweep and of the stairs that did not fall; those of neither gait lie below the others.".to_owned(),
        figure: charts_figure(&charts, 2, PAGE_WIDTH, 140.0)?,
        table: steady_table("steps-by-speed", &rows),
        wide: true,
    }))
}
