//! Steps in the ground.

use super::Shown;
use crate::ReportError;
use crate::study::{Plan, StepHeight, Study};
use crate::table::{Table, cell};
use gaitshift_figures::{Chart, PAGE_WIDTH, Series, charts_figure};

/// Which heights of steps in the ground are passed.
pub(super) fn ground_steps(study: &Study, plan: &Plan) -> Result<Option<Shown>, ReportError> {
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
    // A panel for each kind of step and gait: where all are passed, marks of several kinds would hide each other.
    let mut charts = Vec::new();
    for (omega_v, gait, theirs_cm) in [
        (plan.gaits[0], "walking", 1.0),
        (plan.gaits[1], "running", 0.8),
    ] {
        for (name, title) in [
            ("one step up", "one step up"),
            ("one step down", "one step down"),
            ("up and down by turns, every 50 cm", "up and down by turns"),
        ] {
            let rows = study.step_heights.iter();
            let of_kind = rows.filter(|row| row.omega_v == omega_v && kind(row) == name);
            let share = |row: &StepHeight| row.successes as f64 / row.trials.max(1) as f64;
            let passed = of_kind.map(|row| (100.0 * row.height_m.abs(), share(row)));
            let journal =
                (name == "one step up").then(|| (theirs_cm, "journal version".to_owned()));
            charts.push(Chart {
                title: title.to_owned(),
                x_title: "height of the step (cm)".to_owned(),
                y_title: "share of places passed".to_owned(),
                series: vec![Series::marked_line(
                    &format!("{gait}, ω\u{1d65} = {omega_v}"),
                    passed.collect(),
                )],
                x_levels: journal.into_iter().collect(),
                y_shows: vec![0.0, 1.0],
                x_range: Some((0.0, 105.0 * plan.step_heights_m[1])),
                ..Chart::default()
            });
        }
    }
    if study.step_heights.is_empty() {
        return Ok(None);
    }
    Ok(Some(Shown {
        name: "ground-steps".to_owned(),
        title: "Steps in the ground",
        caption: "Above walking, below running. Each height is tried with the first face at several places 5 cm apart; a place is passed \
                  if the body gets 4 m beyond it. The dotted line is the highest step up survived in the journal version. Heights after the first that is passed nowhere are not tried. By turns, the ground rises and falls again every \
                  50 cm until there."
            .to_owned(),
        figure: charts_figure(&charts, 3, PAGE_WIDTH, 90.0)?,
        table,
        wide: true,
    }))
}
