//! How feet come down and legs press.

use crate::trace::Trace;
use gaitshift_analysis::statistics;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// How feet come down and legs press under one command, from the motion at the integration step; means over its stances.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Landing {
    /// The command.
    pub omega_v: f64,
    /// Stances, both legs.
    pub stances: usize,
    /// Forward speed of the sole at touchdown, in m/s.
    pub sole_forward_m_per_s: f64,
    /// Downward speed of the sole at touchdown, in m/s.
    pub sole_down_m_per_s: f64,
    /// Greatest vertical force of a stance, in body weights.
    pub peak_body_weights: f64,
    /// When it comes, in s after touchdown.
    pub peak_after_s: f64,
    /// Share of the variance of the force along the leg that its length explains in a straight line, in [0, 1].
    pub spring_like: Option<f64>,
}

impl Landing {
    pub(super) fn of(omega_v: f64, trace: &Trace, weight_n: f64) -> Option<Self> {
        let stances: Vec<(usize, Range<usize>)> = (0..2)
            .flat_map(|leg| {
                trace
                    .stances(leg, weight_n)
                    .into_iter()
                    .map(move |s| (leg, s))
            })
            .collect();
        let mean = |of: &dyn Fn(usize, &Range<usize>) -> f64| {
            let values: Vec<f64> = stances.iter().map(|(leg, s)| of(*leg, s)).collect();
            statistics::mean(&values)
        };
        let highest = |leg: usize, stance: &Range<usize>| {
            let rows = stance.clone();
            rows.max_by(|&a, &b| {
                let force = |k: usize| trace.rows[k].normal_n[leg];
                force(a).total_cmp(&force(b))
            })
            .unwrap_or(stance.start)
        };
        let before = |leg: usize, stance: &Range<usize>| {
            // The step before the force passes its threshold: the sole is about to land.
            trace.rows[stance.start.saturating_sub(1)].sole_m_per_s[leg]
        };
        let (lengths, forces): (Vec<f64>, Vec<f64>) = stances
            .iter()
            .flat_map(|(leg, stance)| trace.rows[stance.clone()].iter().map(move |r| (leg, r)))
            .map(|(&leg, row)| (row.length_m[leg], row.axial_n[leg]))
            .unzip();
        Some(Self {
            omega_v,
            stances: stances.len(),
            sole_forward_m_per_s: mean(&|leg, s| before(leg, s)[0])?,
            sole_down_m_per_s: mean(&|leg, s| -before(leg, s)[1])?,
            peak_body_weights: mean(&|leg, s| {
                trace.rows[highest(leg, s)].normal_n[leg] / weight_n
            })?,
            peak_after_s: mean(&|leg, s| {
                trace.rows[highest(leg, s)].time_s - trace.rows[s.start].time_s
            })?,
            spring_like: statistics::correlation(&lengths, &forces)
                .map(|correlation| correlation * correlation),
        })
    }
}
