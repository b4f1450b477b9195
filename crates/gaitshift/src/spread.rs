//! Motions from several starts under one command: mean, spread and falls.

use crate::gaits::Row;
use crate::output::{self, number};
use gaitshift_analysis::{GaitClass, GaitSummary};
use gaitshift_figures::SweepPoint;
use serde::Serialize;
use std::collections::BTreeMap;

/// Mean and standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Moments {
    /// Mean; `None` (null in JSON) without values.
    pub mean: Option<f64>,
    /// Standard deviation of the sample; `None` of fewer than two values.
    pub sd: Option<f64>,
}

impl Moments {
    /// Of the values that are defined.
    pub fn of(values: impl Iterator<Item = Option<f64>>) -> Self {
        let values: Vec<f64> = values.flatten().collect();
        let count = values.len() as f64;
        let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / count);
        let sd = mean.filter(|_| values.len() > 1).map(|mean| {
            let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            (squares / (count - 1.0)).sqrt()
        });
        Self { mean, sd }
    }

    /// As in a table.
    pub fn text(&self, decimals: usize) -> String {
        match self.sd {
            Some(sd) => format!("{} ± {sd:.decimals$}", number(self.mean, decimals)),
            None => number(self.mean, decimals),
        }
    }
}

/// The motions of one command. Gaits and falls count all of them, the figures those that did not fall.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// The command, if it was constant.
    pub omega_v: Option<f64>,
    /// Number of motions.
    pub motions: usize,
    /// Number of those that fell.
    pub falls: usize,
    /// Number of motions of each gait.
    pub gaits: BTreeMap<String, usize>,
    /// The gait of all of them, if it is one.
    #[serde(skip)]
    pub gait: Option<GaitClass>,
    /// Mean forward speed, m/s.
    pub speed_m_per_s: Moments,
    /// Froude number.
    pub froude: Moments,
    /// Share of time with both feet on the ground.
    pub double_support: Moments,
    /// Share of time with one foot on the ground.
    pub single_support: Moments,
    /// Share of time with no foot on the ground.
    pub flight: Moments,
    /// Cost of transport.
    pub cost_of_transport: Moments,
    /// Steps per second, Hz.
    pub step_frequency_hz: Moments,
    /// Way of the hip per step, m.
    pub step_length_m: Moments,
}

impl Spread {
    fn new(omega_v: Option<f64>, motions: &[&GaitSummary]) -> Self {
        let mut gaits = BTreeMap::new();
        for motion in motions {
            *gaits.entry(motion.gait.to_string()).or_insert(0) += 1;
        }
        let mut each = motions.iter().map(|motion| motion.gait);
        let gait = each.next().filter(|first| each.all(|gait| gait == *first));
        let moments = |value: fn(&GaitSummary) -> Option<f64>| {
            Moments::of(motions.iter().filter(|s| !s.fell).map(|s| value(s)))
        };
        Self {
            omega_v,
            motions: motions.len(),
            falls: motions.iter().filter(|s| s.fell).count(),
            gaits,
            gait,
            speed_m_per_s: moments(|s| s.speed_m_per_s),
            froude: moments(|s| s.froude),
            double_support: moments(|s| s.double_support),
            single_support: moments(|s| s.single_support),
            flight: moments(|s| s.flight),
            cost_of_transport: moments(|s| s.cost_of_transport),
            step_frequency_hz: moments(|s| s.step_frequency_hz),
            step_length_m: moments(|s| s.step_length_m),
        }
    }

    /// The means as a point of a figure, hollow if one of the motions fell.
    pub fn point(&self) -> Option<SweepPoint> {
        Some(SweepPoint {
            omega_v: self.omega_v?,
            fell: self.falls > 0,
            gait: self.gait,
            speed_m_per_s: self.speed_m_per_s.mean,
            froude: self.froude.mean,
            cost_of_transport: self.cost_of_transport.mean,
            double_support: self.double_support.mean,
            single_support: self.single_support.mean,
            flight: self.flight.mean,
            deviations: [
                self.speed_m_per_s.sd,
                self.froude.sd,
                self.cost_of_transport.sd,
                self.double_support.sd,
                self.single_support.sd,
                self.flight.sd,
            ],
        })
    }
}

/// One of all motions under the same command over time, whatever parts of it those that fell saw.
pub fn of_one(rows: &[Row]) -> Vec<Spread> {
    let first = rows.first().and_then(|row| row.omega_v);
    let held = first.filter(|_| rows.iter().all(|row| row.omega_v == first));
    let motions: Vec<&GaitSummary> = rows.iter().map(|row| &row.summary).collect();
    vec![Spread::new(held, &motions)]
}

/// One for each command, in the order in which they first appear.
pub fn of(rows: &[Row]) -> Vec<Spread> {
    let mut commands: Vec<(Option<f64>, Vec<&GaitSummary>)> = Vec::new();
    for row in rows {
        match commands
            .iter_mut()
            .find(|(omega_v, _)| *omega_v == row.omega_v)
        {
            Some((_, motions)) => motions.push(&row.summary),
            None => commands.push((row.omega_v, vec![&row.summary])),
        }
    }
    commands
        .iter()
        .map(|(omega_v, motions)| Spread::new(*omega_v, motions))
        .collect()
}

/// The lines of a table, with columns `names` after the command.
pub fn table<'a>(
    names: &[&str],
    rows: impl IntoIterator<Item = (Vec<String>, &'a Spread)>,
) -> Vec<String> {
    let mut heading = vec!["ω_v".to_owned()];
    heading.extend(names.iter().map(|&name| name.to_owned()));
    heading.extend(["falls", "speed, m/s", "Froude", "CoT", "gaits"].map(str::to_owned));
    let mut cells = vec![heading];
    for (mut names, s) in rows {
        let command = s
            .omega_v
            .map_or_else(|| "varying".to_owned(), |omega_v| omega_v.to_string());
        names.insert(0, command);
        let mut gaits: Vec<(&String, &usize)> = s.gaits.iter().collect();
        gaits.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let gaits: Vec<String> = gaits
            .iter()
            .map(|(gait, count)| format!("{gait} {count}"))
            .collect();
        names.extend([
            format!("{} of {}", s.falls, s.motions),
            s.speed_m_per_s.text(2),
            s.froude.text(2),
            s.cost_of_transport.text(3),
            gaits.join(", "),
        ]);
        cells.push(names);
    }
    let words: Vec<usize> = (1..=names.len()).chain([names.len() + 5]).collect();
    output::table(&cells, &words)
}
