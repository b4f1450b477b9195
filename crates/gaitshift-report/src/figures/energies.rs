//! Energies over a stride, and where energy comes from and goes.

use super::Shown;
use crate::study::{Measured, Plan, Study};
use crate::table::{Table, cell};
use crate::trace::Trace;
use crate::{ReportError, Subject};
use gaitshift_analysis::support::{PhaseInterval, SupportPhase};
use gaitshift_figures::{
    Bar, Chart, PAGE_WIDTH, Series, bars_figure, charts_figure, phase_between,
};
use std::ops::Range;

/// Energies over a stride of each gait, phases shaded.
pub(super) fn stride_energies(
    subject: &Subject,
    m: &Measured,
    plan: &Plan,
) -> Result<Option<Shown>, ReportError> {
    let weight = subject.weight_n();
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
        for (phase, row) in trace.thinned(&stride) {
            let mut cells = vec![cell(Some(omega_v)), cell(Some(phase))];
            cells.extend(row.energies_j.map(|e| cell(Some(e))));
            table.rows.push(cells);
        }
        let line = |index: usize, offset: f64| -> Vec<(f64, f64)> {
            trace
                .thinned(&stride)
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
        caption: "From a touchdown of the right foot to its next, at the integration step. Potential energy counts from its lowest \
                  value in the stride. Springs of the legs and of the hips are shown separately; the paper's elastic energy is their sum."
            .to_owned(),
        figure: charts_figure(&ordered, columns, PAGE_WIDTH, 90.0)?,
        table,
        wide: true,
    }))
}

/// A whole stride of the right leg in a trace, from touchdown to touchdown.
fn stride(trace: &Trace, weight_n: f64) -> Option<Range<usize>> {
    let stances = trace.stances(0, weight_n);
    let middle = stances.len() / 2;
    Some(stances.get(middle.checked_sub(1)?)?.start..stances.get(middle)?.start)
}

/// The support phases of a stride, x from 0 to 1.
fn phases(trace: &Trace, stride: &Range<usize>, weight_n: f64) -> Vec<PhaseInterval> {
    // A foot may be on the ground since before the trace.
    let contacts = [0, 1].map(|leg| trace.contacts(leg, weight_n));
    let phase_of = |row: usize| {
        let down = |leg: usize| contacts[leg].iter().any(|contact| contact.contains(&row));
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

/// Where energy comes from and where it goes, walking and running.
pub(super) fn work(study: &Study, plan: &Plan) -> Result<Option<Shown>, ReportError> {
    let mut bars = Vec::new();
    let mut table = Table::new(
        "energy-flow",
        &[
            "omega_v",
            "kind",
            "element",
            "right_j_per_step",
            "left_j_per_step",
        ],
    );
    let mut balances = Vec::new();
    for omega_v in plan.gaits {
        let Some((summary, flow)) = study
            .at(omega_v)
            .and_then(|s| Some((s, s.energy_per_step?)))
        else {
            continue;
        };
        for (kind, parts) in [
            ("given", &flow.given()[..]),
            ("taken", &flow.taken()[..]),
            ("stored and returned", &flow.returned()[..]),
        ] {
            bars.push(Bar {
                label: format!("ω\u{1d65} = {omega_v}, {kind}"),
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
        let sum = |parts: &[(&str, [f64; 2])]| -> f64 {
            parts.iter().map(|(_, pair)| pair[0] + pair[1]).sum()
        };
        balances.push(format!(
            "{:.1} J given and {:.1} J taken at {omega_v} ({})",
            sum(&flow.given()),
            sum(&flow.taken()),
            summary.gait
        ));
    }
    if bars.is_empty() {
        return Ok(None);
    }
    Ok(Some(Shown {
        name: "energy-flow".to_owned(),
        title: "Where energy comes from and where it goes",
        caption: format!(
            "Per step, from a touchdown to the next of either foot; both legs, summed at the integration step. Given: positive work \
             of the actuators. Taken: their negative work (braking) and all losses; c1 and c2 are the dampers within each leg (Table 1 of the \
             paper). {}; the rest is what the body holds more or less at \
             the end of the strides measured. Elastic elements give back what they took up, so they stand apart.",
            balances.join(", ")
        ),
        figure: bars_figure(&bars, "energy per step (J)", PAGE_WIDTH)?,
        table,
        wide: true,
    }))
}
