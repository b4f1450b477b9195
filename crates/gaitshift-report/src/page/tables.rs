//! The tables: runs, feet, changes of gait, disturbances, phases of support, return maps, the finer integration step, controllers.

use super::Page;
use super::text::{Escaped, Prose, rate, short, short_or_dash};
use crate::claims::by_sensitivity;
use crate::headline::headline_numbers;
use crate::study::{Change, Steady, StepHeight, Study};
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

    /// What every run does, in short.
    pub(super) fn runs(&mut self, studies: &[Study]) {
        let columns = [
            Text("name"),
            Text("gait at walking, running command"),
            Number("Fr"),
            Number("CoT"),
            Number("walk to run, run to walk"),
            Number("falls between 0 and 3.5"),
            Number("late falls in training"),
        ];
        let rows: Vec<Vec<String>> = studies.iter().map(run).collect();
        self.table(&columns, &rows);
        self.push(
            "<p class=\"quiet\">Changes of gait: how many of those tried lead from the one gait to the other. Late falls: share of \
             the episodes in the last fifth of the training.</p>\n",
        );
    }

    /// Whether it drags its feet, hops or stumbles: one row for each controller and gait.
    pub(super) fn feet(&mut self, studies: &[Study]) {
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
        for study in studies {
            for omega_v in study.gaits {
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
        use GaitClass::{Running, Walking};
        self.push("<h3>Changes of gait by phase of the stride</h3>\n");
        let [slow_up, slow_down] = &study.journal_changes;
        let columns = [
            Text("change"),
            Number("lead to the gait"),
            Text("steps until every step is of the new gait, phase by phase"),
        ];
        let rows: Vec<Vec<String>> = [
            (
                "walk to run, paper’s ramp",
                &study.to_running,
                Walking,
                Running,
            ),
            (
                "run to walk, paper’s ramp",
                &study.to_walking,
                Running,
                Walking,
            ),
            (
                "walk to run, journal version’s ramp",
                slow_up,
                Walking,
                Running,
            ),
            (
                "run to walk, journal version’s ramp",
                slow_down,
                Running,
                Walking,
            ),
        ]
        .into_iter()
        .map(|(name, changes, from, to)| {
            let led = changes.iter().filter(|c| c.leads(from, to)).count();
            let steps: Vec<String> = changes.iter().map(outcome).collect();
            vec![name.to_owned(), rate(led, changes.len()), steps.join(", ")]
        })
        .collect();
        self.table(&columns, &rows);
    }

    pub(super) fn ground_steps(&mut self, study: &Study) {
        self.push("<h3>Steps in the ground: places passed</h3>\n");
        type Kind = fn(&StepHeight) -> bool;
        const KINDS: [(&str, Kind); 3] = [
            ("one up", |row| !row.by_turns && row.height_m > 0.0),
            ("one down", |row| !row.by_turns && row.height_m < 0.0),
            ("up and down by turns", |row| row.by_turns),
        ];
        let mut columns = vec![Number("height (cm)")];
        let titles: Vec<String> = study
            .gaits
            .iter()
            .flat_map(|w| KINDS.map(|(name, _)| format!("{name}, ω<sub>v</sub> = {w}")))
            .collect();
        columns.extend(titles.iter().map(|title| Number(title)));
        let mut heights: Vec<f64> = study
            .step_heights
            .iter()
            .map(|r| r.height_m.abs())
            .collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        let rows: Vec<Vec<String>> = heights
            .iter()
            .map(|&height_m| {
                let mut row = vec![format!("{:.1}", 100.0 * height_m)];
                for omega_v in study.gaits {
                    row.extend(KINDS.map(|(_, of_kind)| {
                        let tried = study.step_heights.iter().find(|r| {
                            r.omega_v == omega_v && r.height_m.abs() == height_m && of_kind(r)
                        });
                        tried.map_or_else(|| "–".to_owned(), |r| rate(r.successes, r.trials))
                    }));
                }
                row
            })
            .collect();
        self.table(&columns, &rows);
    }

    pub(super) fn noise(&mut self, study: &Study) {
        self.push("<h3>Noise on one observation at a time: attempts that succeed</h3>\n");
        for (omega_v, gait) in study.gaits.into_iter().zip(["walking", "running"]) {
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
                let (words, unit) = observation(name);
                let mut row = vec![words.to_owned()];
                row.extend(levels.iter().map(|level| {
                    let tried = own().find(|r| r.level == *level);
                    tried.map_or_else(|| "–".to_owned(), |r| rate(r.successes, r.trials))
                }));
                row.push(format!(
                    "{} {unit}",
                    short(own().next().map_or(0.0, |r| r.deviation / r.level))
                ));
                rows.push(row);
            }
            self.table(&columns, &rows);
        }
        self.push(
            "<p class=\"quiet\">Intervals are Wilson’s, 95 %. After a level, or a height, with no success the next ones are not tried \
             (–); in the order of the observations they count as no success.</p>\n",
        );
    }

    /// Phases of support by the rule and by the forces themselves.
    pub(super) fn support(&mut self, study: &Study) {
        self.push(
            "<h3>Phases of support by the rule, and by forces at every integration step</h3>\n",
        );
        let columns = [
            Number("ω<sub>v</sub>"),
            Text("gait"),
            Number("double support"),
            Number("both feet press"),
            Number("flight"),
            Number("no foot presses"),
        ];
        let rows: Vec<Vec<String>> = halves(study)
            .map(|row| {
                let s = &row.summary;
                let phases = [
                    s.double_support,
                    s.both_feet_touching,
                    s.flight,
                    s.no_foot_touching,
                ];
                let mut cells = vec![row.omega_v.to_string(), s.gait.to_string()];
                cells.extend(phases.map(short_or_dash));
                cells
            })
            .collect();
        self.table(&columns, &rows);
        self.write(format_args!(
            "<p class=\"quiet\">Shares of time. The rule judges mean forces of control periods, with a threshold and without short \
             contacts; beside it stand the shares of integration steps of {} ms in which both feet, or none, bear any force.</p>\n",
            short(1e3 * study.time_step_s)
        ));
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
                    short_or_dash(map.decay),
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
             at 10<sup>−6</sup> the networks’ rounding shows. The deviation is of a millimetre, a millirad, a millimetre per second or a \
             millirad per second (– where it shrinks too fast to be measured); the last column is 0 at a fixed point.</p>\n",
        );
    }

    /// Everything that is measured with both integration steps.
    pub(super) fn fine_step(&mut self, study: &Study) {
        type Value = fn(&Steady) -> Option<f64>;
        const VALUES: [(&str, Value); 4] = [
            ("Fr", |r| r.summary.froude),
            ("CoT", |r| r.summary.cost_of_transport),
            ("double support", |r| r.summary.double_support),
            ("flight", |r| r.summary.flight),
        ];
        let Some(fine) = &study.fine_step else { return };
        self.write(format_args!(
            "<h3>Integration step of {} ms beside {} ms</h3>\n",
            short(1e3 * fine.time_step_s),
            short(1e3 * study.time_step_s)
        ));
        let mut columns = vec![Number("ω<sub>v</sub>"), Text("gait"), Text("fine")];
        columns.extend(
            VALUES
                .iter()
                .flat_map(|(title, _)| [Number(title), Number("fine")]),
        );
        let mut rows = Vec::new();
        for fine in halves(fine) {
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
        let part = study.beside_fine_step();
        let columns = [Text("number"), Number("usual"), Number("fine")];
        let value = |n: &crate::HeadlineNumber| short_or_dash(n.seeds.first().copied().flatten());
        let rows: Vec<Vec<String>> = headline_numbers(&[&part])
            .iter()
            .zip(headline_numbers(&[fine]))
            .map(|(usual, fine)| {
                let name = Prose(usual.name).to_string();
                vec![name, value(usual), value(&fine)]
            })
            .collect();
        self.table(&columns, &rows);
        self.push(
            "<p class=\"quiet\">Motions are of the same length, and both columns are from the same commands, stairs and starts: steady \
             motions at every twentieth from 0 to 0.5 and every half from there on. So a number over all commands can differ from that \
             above.</p>\n",
        );
    }

    pub(super) fn subjects(&mut self, studies: &[Study]) {
        let columns = [
            Text("name"),
            Text("experiment"),
            Number("seed"),
            Number("steps"),
            Number("updates"),
            Text("version"),
            Text("command"),
        ];
        let rows: Vec<Vec<String>> = studies
            .iter()
            .map(|study| {
                let p = &study.provenance;
                vec![
                    Escaped(&study.name).to_string(),
                    Escaped(&p.experiment).to_string(),
                    study.seed.to_string(),
                    p.environment_steps.to_string(),
                    p.updates.to_string(),
                    Escaped(&p.version).to_string(),
                    format!("<code>{}</code>", Escaped(&p.command)),
                ]
            })
            .collect();
        self.table(&columns, &rows);
    }
}

/// An observation in words, with its unit.
fn observation(name: &str) -> (&str, &str) {
    match name {
        "x_velocity_m_per_s" => ("forward speed ẋ", "m/s"),
        "theta_rad" => ("pitch θ", "rad"),
        "theta_velocity_rad_per_s" => ("pitch rate θ̇", "rad/s"),
        "h_m" => ("thigh along the leg h", "m"),
        "h_velocity_m_per_s" => ("its rate ḣ", "m/s"),
        "phi_rad" => ("hip angle φ", "rad"),
        "phi_velocity_rad_per_s" => ("hip rate φ̇", "rad/s"),
        "d_velocity_m_per_s" => ("rate of the compression ḋ", "m/s"),
        other => (other, ""),
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

/// The steady motions at every half of the command, from 0 on.
fn halves(study: &Study) -> impl Iterator<Item = &Steady> {
    (0..=7).filter_map(|k| study.steady_at(0.5 * f64::from(k)))
}

/// A run in one row.
fn run(study: &Study) -> Vec<String> {
    let pair = |of: fn(&GaitSummary) -> String| {
        let words = study
            .gaits
            .map(|w| study.at(w).map_or_else(|| "–".to_owned(), of));
        words.join(", ")
    };
    let led = |changes: &[Change], [from, to]: [GaitClass; 2]| {
        let led = changes.iter().filter(|c| c.leads(from, to)).count();
        format!("{led} of {}", changes.len())
    };
    let (walk, run) = (GaitClass::Walking, GaitClass::Running);
    let up = study.steady.iter().filter(|row| row.omega_v >= 0.0);
    let falls = up.clone().filter(|row| row.summary.fell).count();
    vec![
        Escaped(&study.name).to_string(),
        pair(|s| s.gait.to_string()),
        pair(|s| short_or_dash(s.froude)),
        pair(|s| short_or_dash(s.cost_of_transport)),
        format!(
            "{}, {}",
            led(&study.to_running, [walk, run]),
            led(&study.to_walking, [run, walk])
        ),
        format!("{falls} of {}", up.count()),
        short_or_dash(study.late_falls),
    ]
}
