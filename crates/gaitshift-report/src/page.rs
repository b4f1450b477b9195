//! The page: one file with its style and its pictures in it, which fetches nothing.

mod findings;
mod tables;
mod text;

use crate::figures::Shown;
use crate::group::Group;
use crate::study::{Measured, Plan};

use std::fmt::Write;
use text::{Escaped, Prose};

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
}

/// A picture within the page: its own size is what it takes at most, and its title what a screen reader says.
fn picture(svg: &str, title: &str) -> String {
    svg.replacen(
        "<svg ",
        &format!("<svg role=\"img\" aria-label=\"{}\" ", Escaped(title)),
        1,
    )
}
