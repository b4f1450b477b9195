//! What the panels over motions under constant commands share: axes, values of people, marks and the table of numbers.

use crate::study::{Steady, Study};
use crate::table::{Table, cell};
use gaitshift_analysis::GaitClass;
use gaitshift_figures::{Chart, Series};
use std::f64::consts::FRAC_1_SQRT_2;

pub(super) const OMEGA_V: &str = "command ω\u{1d65} (s/m)";

pub(super) const FROUDE: &str = "Froude number v/√(g l)";

pub(super) const SHARE_OF_TIME: &str = "share of time";

/// What stands, shuffles, limps or hops.
pub(super) const NEITHER: &str = "neither walk nor run";

/// The values that a panel shows of a motion.
pub(super) type Of = fn(&Steady) -> Option<f64>;

/// Lines at values that people have.
pub(super) type Levels = &'static [(f64, &'static str)];

/// The speed at which people change between walk and run: v²/(g l) = 0.5.
pub(super) const HUMAN_TRANSITION: Levels = &[(FRAC_1_SQRT_2, "people change gait")];

/// The greatest share of energy that people recover as a pendulum does.
pub(super) const HUMAN_RECOVERY: Levels = &[(0.65, "people walking, at best")];

/// A panel: one value of many motions.
#[derive(Clone, Copy)]
pub(super) struct Panel {
    pub title: &'static str,
    pub y_title: &'static str,
    pub of: Of,
    /// What the paper found, as (command, value).
    pub paper: &'static [(f64, f64)],
    pub levels: Levels,
    /// The value that its axis always has.
    pub shows: f64,
}

impl Panel {
    pub const fn new(title: &'static str, y_title: &'static str, of: Of) -> Self {
        Self {
            title,
            y_title,
            of,
            paper: &[],
            levels: &[],
            shows: 0.0,
        }
    }

    /// The panel with its marks.
    pub fn chart(&self, x_title: &str, series: Vec<Series>) -> Chart {
        Chart {
            title: self.title.to_owned(),
            x_title: x_title.to_owned(),
            y_title: self.y_title.to_owned(),
            series,
            levels: self
                .levels
                .iter()
                .map(|&(value, name)| (value, name.to_owned()))
                .collect(),
            y_shows: vec![self.shows],
            ..Chart::default()
        }
    }
}

/// The values of the motions that did not fall.
pub(super) fn points<'a>(
    rows: impl IntoIterator<Item = &'a Steady>,
    x: Of,
    y: Of,
) -> Vec<(f64, f64)> {
    rows.into_iter()
        .filter(|row| !has_fallen(row))
        .filter_map(|row| Some((x(row)?, y(row)?)))
        .collect()
}

/// The marks of motions, a series for each gait.
pub(super) fn by_gait<'a>(
    rows: impl Iterator<Item = &'a Steady> + Clone,
    x: Of,
    y: Of,
) -> Vec<Series> {
    let marks = |label: &str, of_gait: &dyn Fn(GaitClass) -> bool| {
        let rows = rows.clone().filter(|row| of_gait(row.summary.gait));
        Series::marks(label, points(rows, x, y))
    };
    let (walking, running) = (GaitClass::Walking, GaitClass::Running);
    vec![
        marks("walking", &|gait| gait == walking),
        marks(NEITHER, &|gait| gait != walking && gait != running).below(),
        marks("running", &|gait| gait == running),
    ]
}

/// The marks of the stairs, up and down, and where they fell.
pub(super) fn on_stairs(study: &Study, of: Of) -> Vec<Series> {
    [
        ("command rising", &study.stairs_up),
        ("command falling", &study.stairs_down),
    ]
    .map(|(label, rows)| Series::marks(label, points(rows, omega_v, of)).fell_at(falls(rows)))
    .to_vec()
}

/// The commands under which motions fell.
pub(super) fn falls<'a>(rows: impl IntoIterator<Item = &'a Steady>) -> Vec<f64> {
    let fallen = rows.into_iter().filter(|row| has_fallen(row));
    fallen.map(|row| row.omega_v).collect()
}

/// The commands under which a motion of any of the studies fell.
pub(super) fn falls_of(studies: &[&Study]) -> Vec<f64> {
    let mut commands: Vec<f64> = studies.iter().flat_map(|s| falls(&s.steady)).collect();
    commands.sort_by(f64::total_cmp);
    commands.dedup();
    commands
}

/// The steady motions of the studies, each with its study's name.
pub(super) fn named_rows<'a>(studies: &[&'a Study]) -> Vec<(&'a str, &'a Steady)> {
    let rows = |study: &&'a Study| study.steady.iter().map(|row| (study.name.as_str(), row));
    studies.iter().flat_map(rows).collect()
}

pub(super) fn has_fallen(row: &Steady) -> bool {
    row.summary.gait == GaitClass::Fallen
}

/// The range of the command on the stairs, with room for marks at its ends.
pub(super) fn stairs_range(study: &Study) -> Option<(f64, f64)> {
    let commands = || study.stairs_up.iter().map(|row| row.omega_v);
    let (least, greatest) = (commands().reduce(f64::min)?, commands().reduce(f64::max)?);
    let room = 0.04 * (greatest - least).max(0.1);
    Some((least - room, greatest + room))
}

pub(super) fn omega_v(row: &Steady) -> Option<f64> {
    Some(row.omega_v)
}

pub(super) fn froude(row: &Steady) -> Option<f64> {
    row.summary.froude
}

/// The numbers of steady motions as a table.
pub(super) fn steady_table(name: &str, rows: &[(&str, &Steady)]) -> Table {
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

/// The numbers of the stairs as a table.
pub(super) fn stairs_table(name: &str, study: &Study) -> Table {
    let up = study.stairs_up.iter().map(|row| ("rising", row));
    let down = study.stairs_down.iter().map(|row| ("falling", row));
    steady_table(name, &up.chain(down).collect::<Vec<_>>())
}
