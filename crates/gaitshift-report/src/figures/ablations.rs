//! A method beside what leaves out a part of it: the gaits over the range of the command, and the course of the training.

use super::Shown;
use super::panels::{
    FROUDE, HUMAN_TRANSITION, OMEGA_V, Panel, SHARE_OF_TIME, froude, named_rows, steady_table,
};
use super::seeds::{OVER_SEEDS, over_commands, over_seeds};
use crate::group::by_group;
use crate::study::Study;
use crate::table::{Table, cell};
use crate::{ReportError, Stretch};
use gaitshift_figures::{Chart, PAGE_WIDTH, Series, charts_figure};

/// A method that the study leaves parts out of.
pub(super) struct Method {
    /// Its experiment.
    pub name: &'static str,
    over_commands: [&'static str; 2],
    over_steps: [&'static str; 2],
}

/// The papers' methods, with the names and titles of their figures.
pub(super) const METHODS: [Method; 2] = [
    Method {
        name: "paper",
        over_commands: [
            "paper-without-a-part",
            "The paper’s method without a part of it",
        ],
        over_steps: [
            "fig4-phase-one",
            "Training with and without phase I (the paper’s Fig. 4)",
        ],
    },
    Method {
        name: "journal",
        over_commands: [
            "journal-without-a-part",
            "The journal version’s method without a part of it",
        ],
        over_steps: [
            "journal-training",
            "Training by the journal version’s method and without a part of it",
        ],
    },
];

/// Of a training the middles of its stretches, in million steps, with a value of each.
fn course(study: &Study, of: fn(&Stretch) -> f64) -> Vec<(f64, f64)> {
    let middle = |s: &Stretch| (s.from_step + s.to_step) / 2e6;
    study.course.iter().map(|s| (middle(s), of(s))).collect()
}

impl Method {
    /// An experiment in the legend: what it leaves out, and of how many seeds.
    fn label(&self, seeds: &[&Study]) -> String {
        let group = seeds.first().map_or("", |study| study.group.as_str());
        let part = group.strip_prefix(self.name).unwrap_or(group);
        let part = match part.trim_start_matches([',', ' ']) {
            "" => "the method",
            part => &part.replace("ω_v", "ω\u{1d65}"),
        };
        match seeds.len() {
            1 => format!("{part}, one seed"),
            n => format!("{part}, {n} seeds"),
        }
    }

    /// Speed and phases over the range of the command, if there is a run without a part of the method.
    pub fn over_commands(&self, studies: &[&Study]) -> Result<Option<Shown>, ReportError> {
        if studies.iter().all(|study| study.group == self.name) {
            return Ok(None);
        }
        const PANELS: [Panel; 3] = [
            Panel {
                levels: HUMAN_TRANSITION,
                ..Panel::new("speed", FROUDE, froude)
            },
            Panel::new("double support", SHARE_OF_TIME, |r| {
                r.summary.double_support
            }),
            Panel::new("flight", SHARE_OF_TIME, |r| r.summary.flight),
        ];
        let experiments = by_group(studies);
        let charts = PANELS.map(|panel| {
            let series = experiments
                .iter()
                .map(|seeds| over_commands(&panel, &self.label(seeds), seeds));
            panel.chart(OMEGA_V, series.collect())
        });
        let [name, title] = self.over_commands;
        Ok(Some(Shown {
            name: name.to_owned(),
            title,
            caption: format!(
                "Motions from the default start, without action noise, under commands beyond those of the training too. {OVER_SEEDS}"
            ),
            figure: charts_figure(&charts, 3, PAGE_WIDTH, 130.0)?,
            table: steady_table(name, &named_rows(studies)),
            wide: true,
        }))
    }

    /// Returns and falls of the episodes over the training, if there are runs with and without a part of the method.
    pub fn over_steps(&self, studies: &[&Study]) -> Result<Option<Shown>, ReportError> {
        let mut studies = studies.to_vec();
        studies.retain(|study| !study.course.is_empty());
        let experiments = by_group(&studies);
        if experiments.len() < 2 {
            return Ok(None);
        }
        let chart = |y_title: &str, of: fn(&Stretch) -> f64| {
            let series = experiments.iter().map(|seeds| {
                let mut runs: Vec<_> = seeds.iter().map(|s| course(s, of)).collect();
                let label = self.label(seeds);
                match runs.len() {
                    1 => Series::line(&label, runs.remove(0)),
                    _ => over_seeds(&label, runs),
                }
            });
            Chart {
                x_title: "environment steps (millions)".to_owned(),
                y_title: y_title.to_owned(),
                series: series.collect(),
                y_shows: vec![0.0],
                ..Chart::default()
            }
        };
        let charts = [
            chart("mean return of episodes", |s| s.mean_return),
            chart("share of episodes that fell", |s| s.falls),
        ];
        let [name, title] = self.over_steps;
        let mut table = Table::new(
            name,
            &[
                "experiment",
                "seed",
                "from_step",
                "to_step",
                "mean_return",
                "falls",
            ],
        );
        for study in &studies {
            table.rows.extend(study.course.iter().map(|s| {
                vec![
                    study.group.clone(),
                    study.seed.to_string(),
                    cell(Some(s.from_step)),
                    cell(Some(s.to_step)),
                    cell(Some(s.mean_return)),
                    cell(Some(s.falls)),
                ]
            }));
        }
        Ok(Some(Shown {
            name: name.to_owned(),
            title,
            caption: "Mean return of the episodes that end within 100 000 steps, and the share of them that ended in a fall: thick the \
                interquartile mean over seeds with its 95 % bootstrap interval, thin each seed. A long episode under a high command has \
                a high return, so the range of the command moves it too; what changes the reward changes the scale of the returns."
                .to_owned(),
            figure: charts_figure(&charts, 2, PAGE_WIDTH, 190.0)?,
            table,
            wide: true,
        }))
    }
}
