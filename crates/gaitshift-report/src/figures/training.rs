//! The returns of a training's episodes.

use super::Shown;
use crate::ReportError;
use crate::study::Measured;
use crate::table::{Table, cell};
use gaitshift_figures::episode_returns_figure;

pub(super) fn episodes(m: &Measured) -> Result<Option<Shown>, ReportError> {
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
        title: "Return of every episode over training (the paper’s Fig. 4)",
        caption: "Each dot is an episode; its shade is the command.".to_owned(),
        figure: episode_returns_figure(&e.steps, &e.returns, &e.omega_v)?,
        table,
        wide: false,
    }))
}
