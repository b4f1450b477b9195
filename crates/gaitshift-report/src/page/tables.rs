//! The tables: feet, changes of gait, noise, return maps, the finer integration step, controllers.

use super::Page;
use super::text::{Escaped, short, short_or_dash};
use crate::claims::by_sensitivity;
use crate::study::{Change, Measured, Plan, Steady, Study};
use gaitshift_analysis::statistics::wilson_interval;
use gaitshift_analysis::{GaitClass, GaitSummary};

/// A column by its title in HTML.
#[derive(Clone, Copy)]
enum Column<'a> {
    Text(&'a str),
    /// Numbers stand on the right.
    Number(&'a str),
}
use Column::{Number, Text};

impl Page {
    /// A table; cells are HTML.
    fn table(&mut self, columns: &[Column], rows: &[Vec<String>]) {
        self.push("<div class=\"scroll\"><table><thead><tr>");
        for column in columns {
            match column {
                Text(title) => self.write(format_args!("<th>{title}</th>")),
                Number(title) => self.write(format_args!("<th class=\"number\">{title}</th>")),
            }
        }
        self.push("</tr></thead><tbody>\n");
        for row in rows {
            self.push("<tr>");
            for (column, cell) in columns.iter().zip(row) {
                match column {
                    Text(_) => self.write(format_args!("<td>{cell}</td>")),
                    Number(_) => self.write(format_args!("<td class=\"number\">{cell}</td>")),
                }
            }
            self.push("</tr>\n");
        }
        self.push("</tbody></table></div>\n");
    }

    /// Whether it drags its feet, hops or stumbles: one row for each controller and gait.
    pub(super) fn feet(&mut self, measured: &[Measured], plan: &Plan) {
        type Values = fn(&GaitSummary) -> [Option<f64>; 2];
        const PAIRS: [(&str, Values); 4] = [
            ("clearance (m): right, left", |s| {
                [s.clearance_right_m, s.clearance_left_m]
            }),
            ("slip, drag (J/m)", |s| {
                [s.slip_work_j_per_m, s.drag_work_j_per_m]
            }),
            ("step time varies by: right, left", |s| {
                [s.step_time_variation_right, s.step_time_variation_left]
            }),
            ("step length varies by: right, left", |s| {
                [s.step_length_variation_right, s.step_length_variation_left]
            }),
        ];
        let mut columns = vec![Text("name"), Number("ω<sub>v</sub>"), Text("gait")];
        columns.extend(PAIRS.iter().map(|(title, _)| Number(title)));
        columns.extend([
            Number("scuffs per step"),
            Number("steps onto the other foot"),
            Number("left to right hip, deviation (rad)"),
        ]);
        let mut rows = Vec::new();
        for study in measured.iter().map(|m| &m.study) {
            for omega_v in plan.gaits {
                let Some(s) = study.at(omega_v) else { continue };
                let pair = |values: [Option<f64>; 2]| values.map(short_or_dash).join(", ");
                let mut row = vec![
                    Escaped(&study.name).to_string(),
                    omega_v.to_string(),
                    s.gait.to_string(),
                ];
                row.extend(PAIRS.iter().map(|(_, of)| pair(of(s))));
                row.extend([s.scuffs_per_step, s.steps_alternating].map(short_or_dash));
                row.push(pair([s.hip_phase_rad, s.hip_phase_deviation_rad]));
                rows.push(row);
            }
        }
        self.push("<h3>Feet and steadiness</h3>\n");
        self.table(&columns, &rows);
        self.push(
            "<p class=\"quiet\">Clearance: height of the sole’s lowest point as a leg swings past the other; none if \
             the legs swing together. Slip: friction of feet in stance, drag: of all others, per metre of way. Steps vary by their standard \
             deviation over their mean. The phase is π where legs alternate evenly, 0 in a hop; its circular deviation is from stride to \
             stride.</p>\n",
        );
    }

    pub(super) fn changes(&mut self, study: &Study) {
        self.push("<h3>Changes of gait by phase of the stride</h3>\n");
        for (name, changes, from, to) in [
            (
                "walk to run",
                &study.to_running,
                GaitClass::Walking,
                GaitClass::Running,
            ),
            (
                "run to walk",
                &study.to_walking,
                GaitClass::Running,
                GaitClass::Walking,
            ),
        ] {
            let led = changes.iter().filter(|c| c.leads(from, to)).count();
            let steps: Vec<String> = changes.iter().map(outcome).collect();
            let interval = match wilson_interval(led, changes.len()) {
                Some((low, high)) => format!(" [{low:.2}, {high:.2}]"),
                None => String::new(),
            };
            self.write(format_args!(
                "<p>{name}: {led} of {}{interval}; steps until every step is of the new gait, phase by phase: {}</p>\n",
                changes.len(),
                steps.join(", ")
            ));
        }
    }

    pub(super) fn noise(&mut self, study: &Study, plan: &Plan) {
        self.push("<h3>Noise on one observation at a time: attempts that succeed</h3>\n");
        for (omega_v, gait) in plan.gaits.into_iter().zip(["walking", "running"]) {
            let found: Vec<_> = study
                .noise
                .iter()
                .filter(|r| r.omega_v == omega_v)
                .collect();
            let mut levels: Vec<f64> = found.iter().map(|r| r.level).collect();
            levels.sort_by(f64::total_cmp);
            levels.dedup();
            if levels.is_empty() {
                continue;
            }
            let first = format!("{gait}, ω<sub>v</sub> = {omega_v}; most sensitive first");
            let titles: Vec<String> = levels.iter().map(|level| format!("{level} sd")).collect();
            let mut columns = vec![Text(&first)];
            columns.extend(titles.iter().map(|title| Number(title)));
            columns.push(Number("1 sd is"));
            let mut rows = Vec::new();
            for name in by_sensitivity(study, omega_v) {
                let own = || found.iter().filter(|r| r.observation == name);
                let mut row = vec![format!("<code>{name}</code>")];
                row.extend(levels.iter().map(|level| {
                    own().find(|r| r.level == *level).map_or_else(
                        || "0".to_owned(),
                        |r| format!("{} of {}", r.successes, r.trials),
                    )
                }));
                row.push(short(own().next().map_or(0.0, |r| r.deviation / r.level)));
                rows.push(row);
            }
            self.table(&columns, &rows);
        }
        self.push(
            "<p class=\"quiet\">At a level with no success the next ones are not tried and count as 0.</p>\n",
        );
    }

    pub(super) fn return_maps(&mut self, study: &Study) {
        self.push("<h3>Return map: largest multiplier of a stride</h3>\n");
        let columns = [
            "ω<sub>v</sub>",
            "stride (s)",
            "largest multiplier",
            "to one side: down, up",
            "widths of 10<sup>−6</sup>, 10<sup>−5</sup>, 10<sup>−3</sup>",
            "commands held for a period",
            "real deviation shrinks by",
            "change in a stride",
        ]
        .map(Number);
        let multiplier =
            |value: Option<f64>| value.map_or_else(|| "no fixed point".to_owned(), short);
        let several = |values: &[Option<f64>]| {
            let words = values.iter().copied().map(short_or_dash);
            words.collect::<Vec<_>>().join(", ")
        };
        let rows: Vec<Vec<String>> = study
            .return_maps
            .iter()
            .map(|map| {
                let [rounding, narrow, usual, wide] = map.differences;
                vec![
                    map.omega_v.to_string(),
                    short(map.stride_s),
                    multiplier(map.multiplier),
                    several(&[usual.backward, usual.forward]),
                    several(&[rounding.central, narrow.central, wide.central]),
                    multiplier(map.held),
                    multiplier(map.decay),
                    short(map.residual),
                ]
            })
            .collect();
        self.table(&columns, &rows);
        self.push(
            "<p class=\"quiet\">Below 1 a deviation shrinks from stride to stride. The section is where the right leg \
             passes the left; the controller acts every millisecond here, for a stride need not be a whole number of control periods, but in \
             one column, where its commands are held for such a period, which begins at the section. Central differences 10<sup>−4</sup> m, \
             rad, m/s and rad/s wide, and for comparison others: where contact begins or slips the map has a kink, and the two sides differ; \
             at 10<sup>−6</sup> the networks’ rounding shows. The deviation is of a millimetre, a millirad, a millimetre or a millirad per \
             second; the last column is 0 at a fixed point.</p>\n",
        );
    }

    pub(super) fn fine_step(&mut self, study: &Study, plan: &Plan) {
        type Value = fn(&Steady) -> Option<f64>;
        const VALUES: [(&str, Value); 4] = [
            ("Fr", |r| r.summary.froude),
            ("CoT", |r| r.summary.cost_of_transport),
            ("double support", |r| r.summary.double_support),
            ("flight", |r| r.summary.flight),
        ];
        self.write(format_args!(
            "<h3>Integration step of {} ms beside {} ms</h3>\n",
            short(1e3 * plan.fine_step_s),
            short(1e3 * study.time_step_s)
        ));
        let mut columns = vec![Number("ω<sub>v</sub>"), Text("gait"), Text("fine")];
        columns.extend(
            VALUES
                .iter()
                .flat_map(|(title, _)| [Number(title), Number("fine")]),
        );
        let mut rows = Vec::new();
        for fine in &study.fine_step {
            let Some(usual) = study.steady_at(fine.omega_v) else {
                continue;
            };
            let mut row = vec![
                fine.omega_v.to_string(),
                usual.summary.gait.to_string(),
                fine.summary.gait.to_string(),
            ];
            row.extend(
                VALUES
                    .iter()
                    .flat_map(|(_, of)| [usual, fine].map(|s| short_or_dash(of(s)))),
            );
            rows.push(row);
        }
        self.table(&columns, &rows);
    }

    pub(super) fn subjects(&mut self, measured: &[Measured]) {
        let columns = [
            Text("name"),
            Text("experiment"),
            Number("seed"),
            Number("steps"),
            Text("version"),
            Text("command"),
        ];
        let rows: Vec<Vec<String>> = measured
            .iter()
            .map(|m| {
                let p = &m.study.provenance;
                vec![
                    Escaped(&m.study.name).to_string(),
                    Escaped(&p.experiment).to_string(),
                    m.study.seed.to_string(),
                    p.environment_steps.to_string(),
                    Escaped(&p.version).to_string(),
                    format!("<code>{}</code>", Escaped(&p.command)),
                ]
            })
            .collect();
        self.table(&columns, &rows);
    }
}

/// What came of a change of gait, in a word or the number of steps.
fn outcome(change: &Change) -> String {
    match (change.survived, change.steps) {
        (false, _) => "fell".to_owned(),
        (true, Some(steps)) => steps.to_string(),
        (true, None) => "no change".to_owned(),
    }
}
