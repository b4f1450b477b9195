//! The page: one file with its style and its pictures in it, which fetches nothing.

use crate::claims::{Finding, Verdict, by_sensitivity};
use crate::figures::Shown;
use crate::headline::HeadlineNumber;
use crate::study::{Change, Measured, Plan, Steady, Study};
use crate::write::Group;
use gaitshift_analysis::statistics::wilson_interval;
use gaitshift_analysis::{GaitClass, GaitSummary};
use gaitshift_experiment::Estimate;
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

/// Choices that the papers leave open, and what the page assumes; in full in the documentation.
const ASSUMPTIONS: [&str; 8] = [
    "The papers do not give the body's inertias, the stroke of the actuators, the ground contact, the control period, the starts of \
     episodes and more. Every choice is a key of the experiment, listed with its reason in docs/deviations.md.",
    "The journal version used MuJoCo, whose contact model differs: its numbers need not be matched exactly.",
    "Motions are without action noise. Unless stated otherwise they begin at the default start, last 20 s or longer, and are \
     measured from 5 s on.",
    "A walk has double support and no flight in its steps, a run flight and no double support. A foot is in contact from 5 % of body \
     weight until less than 1 %; contacts shorter than 80 ms do not count (docs/learning.md).",
    "Fr is v/√(g l) as in the papers. The classic Froude number is its square.",
    "Steps in the ground are single ones in the claims, each height tried with the face at several places 5 cm apart; a height counts as \
     survived if at every place, and for every lower height, the body gets 4 m beyond it. Rows of steps that lead up and down by turns \
     every 50 cm are shown beside them.",
    "Noise is Gaussian, on one observation (of both legs) at a time, drawn anew in every control period. Its size is given in standard \
     deviations of the same observation in the undisturbed motion. Success is 10 m walked or 20 m run, as in the journal version.",
    "The sample size is the number of seeds. Over several seeds numbers are interquartile means with 95 % bootstrap intervals, and \
     shares of seeds have Wilson's interval; a single controller has no interval.",
];

/// The whole page.
pub(crate) fn html(
    plan: &Plan,
    groups: &[Group],
    measured: &[Measured],
    common: &[Shown],
    each: &[Vec<Shown>],
    places: &[String],
) -> String {
    let mut page = Page::default();
    page.push(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>Gait transition of a passive-hipped biped: the study</title>\n<style>\n",
    );
    page.push(STYLE);
    page.push("</style>\n</head>\n<body>\n");
    page.push("<h1>Gait transition of a passive-hipped biped: the paper’s claims and what was found</h1>\n");
    page.push(
        "<p>One controller, trained with Soft Actor-Critic, walks, runs and changes gait on one command, ω<sub>v</sub>. This page sets every \
         result of Koseki, Kutsuzawa, Owaki and Hayashibe (in Japanese, and Frontiers in Neurorobotics 16, 2023) beside what the \
         controllers below do. Verdicts are computed by the rule in each row: a number that misses \
         it differs, and one that misses it by more than a factor of two fails.</p>\n",
    );
    page.push("<nav>");
    for (id, name) in [
        ("claims", "Claims"),
        ("numbers", "Beyond the papers"),
        ("figures", "Figures"),
        ("tables", "Tables"),
        ("subjects", "Controllers"),
        ("assumptions", "Deviations and assumptions"),
    ] {
        page.write(format_args!("<a href=\"#{id}\">{name}</a>"));
    }
    page.push("</nav>\n");

    page.push("<h2 id=\"claims\">Claims</h2>\n");
    for group in groups {
        page.group_title(group, groups.len());
        page.counts(&group.findings);
        page.findings(&group.findings);
    }
    page.push("<h2 id=\"numbers\">Beyond the papers</h2>\n");
    page.push(
        "<p class=\"quiet\">Measures that are usual in gait research. Human values are quoted from the sources named; \
         they are for people of different size and build, and are not claims of the papers.</p>\n",
    );
    for group in groups {
        page.group_title(group, groups.len());
        page.numbers(&group.numbers);
    }

    page.push("<h2 id=\"figures\">Figures</h2>\n<div class=\"figures\">\n");
    for shown in common {
        page.figure(shown, "figures");
    }
    page.push("</div>\n");
    for (((m, own), place), index) in measured.iter().zip(each).zip(places).zip(0..) {
        if measured.len() > 1 {
            let open = if index == 0 { " open" } else { "" };
            page.write(format_args!(
                "<details{open}>\n<summary><b>{}</b>, seed {}</summary>\n",
                Escaped(&m.study.name),
                m.study.seed
            ));
        }
        page.push("<div class=\"figures\">\n");
        for shown in own {
            page.figure(shown, place);
        }
        page.push("</div>\n");
        if measured.len() > 1 {
            page.push("</details>\n");
        }
    }

    page.push("<h2 id=\"tables\">Tables</h2>\n");
    page.feet(measured, plan);
    for m in measured {
        if measured.len() > 1 {
            page.write(format_args!("<h3>{}</h3>\n", Escaped(&m.study.name)));
        }
        page.changes(&m.study);
        page.noise(&m.study, plan);
        page.return_maps(&m.study);
        page.fine_step(&m.study, plan);
    }

    page.push("<h2 id=\"subjects\">Controllers</h2>\n");
    page.subjects(measured);
    page.push("<h2 id=\"assumptions\">Deviations and assumptions</h2>\n<ul>\n");
    for text in ASSUMPTIONS {
        page.write(format_args!("<li>{}</li>\n", Prose(text)));
    }
    page.write(format_args!(
        "</ul>\n<p class=\"quiet\">gaitshift {}. All numbers: <a href=\"report.json\">report.json</a>, \
         <a href=\"claims.csv\">claims.csv</a>, <a href=\"numbers.csv\">numbers.csv</a>, and beside each figure.</p>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    ));
    page.0
}

/// The page being written. Writing to a `String` cannot fail, so results of `write!` are dropped.
#[derive(Default)]
struct Page(String);

impl Page {
    fn push(&mut self, text: &str) {
        self.0.push_str(text);
    }

    fn write(&mut self, text: std::fmt::Arguments) {
        let _ = self.0.write_fmt(text);
    }

    fn group_title(&mut self, group: &Group, groups: usize) {
        if groups > 1 || group.seeds.len() > 1 {
            let seeds: Vec<String> = group.seeds.iter().map(u64::to_string).collect();
            self.write(format_args!(
                "<h3>{} (seed{} {})</h3>\n",
                Escaped(&group.name),
                if seeds.len() == 1 { "" } else { "s" },
                seeds.join(", ")
            ));
        }
    }

    fn counts(&mut self, findings: &[Finding]) {
        self.push("<ul class=\"counts\">");
        for verdict in [
            Verdict::Holds,
            Verdict::Differs,
            Verdict::Fails,
            Verdict::NotMeasured,
        ] {
            let count = findings.iter().filter(|f| f.verdict == verdict).count();
            self.write(format_args!(
                "<li><b>{count}</b> <span class=\"verdict {}\">{}</span></li>",
                class(verdict),
                verdict.name()
            ));
        }
        self.push("</ul>\n");
    }

    fn findings(&mut self, findings: &[Finding]) {
        self.push(
            "<div class=\"scroll\"><table class=\"stacked\">\n<thead><tr><th>from</th><th>claim, when it holds, command</th>\
             <th class=\"number\">theirs</th><th class=\"number\">ours</th><th>verdict</th></tr></thead>\n<tbody>\n",
        );
        for f in findings {
            let ours = match f.verdict {
                Verdict::NotMeasured => String::new(),
                _ => estimate(f.estimate, f.seeds.len()),
            };
            self.write(format_args!(
                "<tr><td>{}</td><td class=\"main\">{}<div class=\"quiet\">{}; <code>{}</code></div></td>\
                 <td class=\"number\" data-name=\"theirs\">{}</td><td class=\"number\" data-name=\"ours\">{ours}</td><td class=\"verdict {}\">{} {}</td></tr>\n",
                Escaped(f.source),
                Prose(f.claim),
                Prose(&f.rule),
                Escaped(f.command),
                Prose(f.theirs),
                class(f.verdict),
                sign(f.verdict),
                f.verdict.name(),
            ));
        }
        self.push("</tbody></table></div>\n");
    }

    fn numbers(&mut self, numbers: &[HeadlineNumber]) {
        self.push(
            "<div class=\"scroll\"><table class=\"stacked\">\n<thead><tr><th>number, command</th><th class=\"number\">ours</th><th>people</th>\
             </tr></thead>\n<tbody>\n",
        );
        for n in numbers {
            self.write(format_args!(
                "<tr><td class=\"main\">{}<div class=\"quiet\"><code>{}</code></div></td><td class=\"number\" data-name=\"ours\">{}</td>\
                 <td data-name=\"people\">{}</td></tr>\n",
                Prose(n.name),
                Escaped(n.command),
                estimate(n.estimate, n.seeds.len()),
                Prose(n.people)
            ));
        }
        self.push("</tbody></table></div>\n");
    }

    fn figure(&mut self, shown: &Shown, place: &str) {
        let wide = if shown.wide { " class=\"wide\"" } else { "" };
        let scroll = if shown.wide { "scroll" } else { "" };
        let file = format!("{place}/{}", shown.name);
        let mut files = String::new();
        for ending in ["svg", "png", "csv", "json"] {
            let _ = write!(
                files,
                " <a href=\"{}.{ending}\">{ending}</a>",
                Escaped(&file)
            );
        }
        self.write(format_args!(
            "<figure{wide}>\n<h3>{}</h3>\n<div class=\"{scroll}\">{}</div>\n<figcaption>{} <span class=\"files\">{files}</span>\
             </figcaption>\n</figure>\n",
            Escaped(shown.title),
            picture(&shown.figure.svg, shown.title),
            Prose(&shown.caption)
        ));
    }

    /// Whether it drags its feet, hops or stumbles: one row for each controller and gait.
    fn feet(&mut self, measured: &[Measured], plan: &Plan) {
        /// Title of a column, and the values in it.
        type Column = (&'static str, fn(&GaitSummary) -> [Option<f64>; 2]);
        const COLUMNS: [Column; 4] = [
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
        self.push(
            "<h3>Feet and steadiness</h3>\n<div class=\"scroll\"><table><thead><tr><th>name</th><th class=\"number\">ω<sub>v</sub></th>\
             <th>gait</th>",
        );
        for (title, _) in COLUMNS {
            self.write(format_args!("<th class=\"number\">{title}</th>"));
        }
        self.push(
            "<th class=\"number\">scuffs per step</th><th class=\"number\">steps onto the other foot</th>\
             <th class=\"number\">left to right hip, deviation (rad)</th></tr></thead><tbody>\n",
        );
        let word = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), short);
        for study in measured.iter().map(|m| &m.study) {
            for omega_v in plan.gaits {
                let Some(s) = study.at(omega_v) else { continue };
                self.write(format_args!(
                    "<tr><td>{}</td><td class=\"number\">{omega_v}</td><td>{}</td>",
                    Escaped(&study.name),
                    s.gait
                ));
                let pairs = COLUMNS.iter().map(|(_, of)| of(s));
                let phase = [s.hip_phase_rad, s.hip_phase_deviation_rad];
                let cells = pairs
                    .map(|pair| pair.map(word).join(", "))
                    .chain([word(s.scuffs_per_step), word(s.steps_alternating)])
                    .chain([phase.map(word).join(", ")]);
                for cell in cells {
                    self.write(format_args!("<td class=\"number\">{cell}</td>"));
                }
                self.push("</tr>\n");
            }
        }
        self.push(
            "</tbody></table></div>\n<p class=\"quiet\">Clearance: height of the sole’s lowest point as a leg swings past the other; none if \
             the legs swing together. Slip: friction of feet in stance, drag: of all others, per metre of way. Steps vary by their standard \
             deviation over their mean. The phase is π where legs alternate evenly, 0 in a hop; its circular deviation is from stride to \
             stride.</p>\n",
        );
    }

    fn changes(&mut self, study: &Study) {
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

    fn noise(&mut self, study: &Study, plan: &Plan) {
        self.push("<h3>Noise on one observation at a time: attempts that succeed</h3>\n");
        for (omega_v, gait) in plan.gaits.into_iter().zip(["walking", "running"]) {
            let rows: Vec<_> = study
                .noise
                .iter()
                .filter(|r| r.omega_v == omega_v)
                .collect();
            let mut levels: Vec<f64> = rows.iter().map(|r| r.level).collect();
            levels.sort_by(f64::total_cmp);
            levels.dedup();
            if levels.is_empty() {
                continue;
            }
            self.write(format_args!(
                "<div class=\"scroll\"><table><thead><tr><th>{gait}, ω<sub>v</sub> = {omega_v}; most sensitive first</th>"
            ));
            for level in &levels {
                self.write(format_args!("<th class=\"number\">{level} sd</th>"));
            }
            self.push("<th class=\"number\">1 sd is</th></tr></thead><tbody>\n");
            for name in by_sensitivity(study, omega_v) {
                self.write(format_args!("<tr><td><code>{name}</code></td>"));
                for level in &levels {
                    let found = rows
                        .iter()
                        .find(|r| r.observation == name && r.level == *level);
                    let text = found.map_or_else(
                        || "0".to_owned(),
                        |r| format!("{} of {}", r.successes, r.trials),
                    );
                    self.write(format_args!("<td class=\"number\">{text}</td>"));
                }
                let own = rows.iter().find(|r| r.observation == name);
                let own = own.map_or(0.0, |r| r.deviation / r.level);
                self.write(format_args!(
                    "<td class=\"number\">{}</td></tr>\n",
                    short(own)
                ));
            }
            self.push("</tbody></table></div>\n");
        }
        self.push(
            "<p class=\"quiet\">At a level with no success the next ones are not tried and count as 0.</p>\n",
        );
    }

    fn return_maps(&mut self, study: &Study) {
        self.push(
            "<h3>Return map: largest multiplier of a stride</h3>\n<div class=\"scroll\"><table><thead><tr><th class=\"number\">ω<sub>v</sub></th>\
             <th class=\"number\">stride (s)</th><th class=\"number\">largest multiplier</th>\
             <th class=\"number\">to one side: down, up</th>\
             <th class=\"number\">widths of 10<sup>−6</sup>, 10<sup>−5</sup>, 10<sup>−3</sup></th>\
             <th class=\"number\">commands held for a period</th>\
             <th class=\"number\">real deviation shrinks by</th><th class=\"number\">change in a stride</th></tr></thead><tbody>\n",
        );
        for map in &study.return_maps {
            let multiplier =
                |value: Option<f64>| value.map_or_else(|| "no fixed point".to_owned(), short);
            let several = |values: &[Option<f64>]| {
                let words = values
                    .iter()
                    .map(|value| value.map_or("–".to_owned(), short));
                words.collect::<Vec<_>>().join(", ")
            };
            let [rounding, narrow, usual, wide] = map.differences;
            self.push("<tr>");
            for cell in [
                map.omega_v.to_string(),
                short(map.stride_s),
                multiplier(map.multiplier),
                several(&[usual.backward, usual.forward]),
                several(&[rounding.central, narrow.central, wide.central]),
                multiplier(map.held),
                multiplier(map.decay),
                short(map.residual),
            ] {
                self.write(format_args!("<td class=\"number\">{cell}</td>"));
            }
            self.push("</tr>\n");
        }
        self.push(
            "</tbody></table></div>\n<p class=\"quiet\">Below 1 a deviation shrinks from stride to stride. The section is where the right leg \
             passes the left; the controller acts every millisecond here, for a stride need not be a whole number of control periods, but in \
             one column, where its commands are held for such a period, which begins at the section. Central differences 10<sup>−4</sup> m, \
             rad, m/s and rad/s wide, and for comparison others: where contact begins or slips the map has a kink, and the two sides differ; \
             at 10<sup>−6</sup> the networks’ rounding shows. The deviation is of a millimetre, a millirad, a millimetre or a millirad per \
             second; the last column is 0 at a fixed point.</p>\n",
        );
    }

    fn fine_step(&mut self, study: &Study, plan: &Plan) {
        self.write(format_args!(
            "<h3>Integration step of {} ms beside {} ms</h3>\n",
            short(1e3 * plan.fine_step_s),
            short(1e3 * study.time_step_s)
        ));
        self.push(
            "<div class=\"scroll\"><table><thead><tr><th class=\"number\">ω<sub>v</sub></th><th>gait</th><th>fine</th><th class=\"number\">Fr</th>\
             <th class=\"number\">fine</th><th class=\"number\">CoT</th><th class=\"number\">fine</th>\
             <th class=\"number\">double support</th><th class=\"number\">fine</th><th class=\"number\">flight</th><th class=\"number\">fine</th></tr></thead><tbody>\n",
        );
        for fine in &study.fine_step {
            let usual = study
                .steady
                .iter()
                .find(|r| (r.omega_v - fine.omega_v).abs() < 1e-9);
            let Some(usual) = usual else {
                continue;
            };
            self.write(format_args!(
                "<tr><td class=\"number\">{}</td><td>{}</td><td>{}</td>",
                fine.omega_v, usual.summary.gait, fine.summary.gait
            ));
            let values: [fn(&Steady) -> Option<f64>; 4] = [
                |r| r.summary.froude,
                |r| r.summary.cost_of_transport,
                |r| r.summary.double_support,
                |r| r.summary.flight,
            ];
            for of in values {
                for row in [usual, fine] {
                    let text = of(row).map_or_else(|| "–".to_owned(), short);
                    self.write(format_args!("<td class=\"number\">{text}</td>"));
                }
            }
            self.push("</tr>\n");
        }
        self.push("</tbody></table></div>\n");
    }

    fn subjects(&mut self, measured: &[Measured]) {
        self.push(
            "<div class=\"scroll\"><table><thead><tr><th>name</th><th>experiment</th><th class=\"number\">seed</th>\
             <th class=\"number\">steps</th><th class=\"number\">evaluations averaged</th><th>version</th><th>command</th></tr></thead><tbody>\n",
        );
        for m in measured {
            let p = &m.study.provenance;
            self.write(format_args!(
                "<tr><td>{}</td><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>\
                 <td>{}</td><td><code>{}</code></td></tr>\n",
                Escaped(&m.study.name),
                Escaped(&p.experiment),
                m.study.seed,
                p.environment_steps,
                p.averaged_evaluations,
                Escaped(&p.version),
                Escaped(&p.command)
            ));
        }
        self.push("</tbody></table></div>\n");
    }
}

/// A picture within the page: its own size is what it takes at most, and its title what a screen reader says.
fn picture(svg: &str, title: &str) -> String {
    svg.replacen(
        "<svg ",
        &format!("<svg role=\"img\" aria-label=\"{}\" ", Escaped(title)),
        1,
    )
}

/// What came of a change of gait, in a word or the number of steps.
fn outcome(change: &Change) -> String {
    match (change.survived, change.steps) {
        (false, _) => "fell".to_owned(),
        (true, Some(steps)) => steps.to_string(),
        (true, None) => "no change".to_owned(),
    }
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::Differs => "differs",
        Verdict::Fails => "fails",
        Verdict::NotMeasured => "unmeasured",
    }
}

/// So that a verdict needs no colour.
fn sign(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "✓",
        Verdict::Differs => "≈",
        Verdict::Fails => "✗",
        Verdict::NotMeasured => "·",
    }
}

/// A number to three figures.
fn short(value: f64) -> String {
    let value = value + 0.0;
    let size = value.abs();
    let decimals = if size >= 100.0 {
        0
    } else if size >= 10.0 {
        1
    } else if size >= 0.1 || size == 0.0 {
        2
    } else {
        3
    };
    let text = if size > 0.0 && size < 5e-4 {
        format!("{value:.1e}")
    } else {
        let decimals = if (0.1..1.0).contains(&size) {
            3
        } else {
            decimals
        };
        format!("{value:.decimals$}")
    };
    text.replace('-', "\u{2212}")
}

fn estimate(estimate: Option<Estimate>, seeds: usize) -> String {
    match estimate {
        None => "none".to_owned(),
        Some(e) if seeds < 2 => short(e.value),
        Some(e) => format!(
            "{} <small>[{}, {}]</small>",
            short(e.value),
            short(e.interval[0]),
            short(e.interval[1])
        ),
    }
}

/// A text as HTML has it.
struct Escaped<'a>(&'a str);

impl std::fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for character in self.0.chars() {
            match character {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                c => f.write_char(c)?,
            }
        }
        Ok(())
    }
}

/// A sentence: the same with the subscript of ω_v.
struct Prose<'a>(&'a str);

impl std::fmt::Display for Prose<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (k, part) in self.0.split("ω_v").enumerate() {
            if k > 0 {
                f.write_str("ω<sub>v</sub>")?;
            }
            write!(f, "{}", Escaped(part))?;
        }
        Ok(())
    }
}
