//! The page: one file with its style and its pictures in it, which fetches nothing.

mod findings;
mod tables;
mod text;

use crate::claims::{Judged, is_claimed};
use crate::figures::Shown;
use crate::group::Group;
use crate::recorded::RecordedExperiment;
use crate::source::Commands;
use crate::study::Study;

use std::fmt::Write;
use text::{Escaped, Prose, numbered};

const STYLE: &str = include_str!("page.css");

/// Choices that the papers leave open, and what the page assumes; in full in the documentation.
const ASSUMPTIONS: [&str; 10] = [
    "The papers do not give the body's inertias, the stroke of the actuators, the ground contact, the control period, the starts of \
     episodes and more. Every choice is a key of the experiment, listed with its reason in docs/deviations.md.",
    "The journal version used MuJoCo, whose contact model differs: its numbers need not be matched exactly.",
    "Motions are without action noise. Unless stated otherwise they begin at the default start, last 20 s or longer, and are \
     measured from 5 s on.",
    "A walk has double support and no flight in its steps, a run flight and no double support: in at least 95 % of them, for two control \
     periods or more. Otherwise it is standing, or mixed: neither walk nor run. A foot is in contact from 5 % of body weight until less \
     than 1 %; contacts shorter than 80 ms do not count (docs/learning.md).",
    "Fr is v/√(g l) as in the papers. The classic Froude number is its square.",
    "Steps in the ground are single ones in the claims, each height tried with the face at several places 5 cm apart; a height counts as \
     survived if at every place, and for every lower height, the body gets 4 m beyond it. Rows of steps that lead up and down by turns \
     every 50 cm are shown beside them.",
    "Noise is Gaussian, on one observation (of both legs) at a time, drawn anew in every control period. Its size is given in standard \
     deviations of the same observation in the undisturbed motion. Success is 10 m walked or 20 m run, as in the journal version.",
    "The journal version lets each motion of its sweep go 30 m. Here each lasts the same time, so that every command is described by \
     as many seconds: about 15 m at the slowest walk, more than 50 m at the fastest run.",
    "The walk and the run of a study are those at 0 and 3, or at the nearest commands that a run was trained with: the journal \
     version’s run is at 2.5. Its changes of gait have ramps of 0.6 s, the paper’s of 0.4 s.",
    "The sample size is the number of seeds. Over several seeds numbers are interquartile means with 95 % bootstrap intervals. \
     A share of seeds has Wilson's interval where each does it always or never, otherwise that of a bootstrap of the mean. A single controller has no interval.",
];

/// What the page shows.
pub(crate) struct Content<'a> {
    pub commands: &'a Commands,
    pub judged: &'a [Judged],
    /// Of these experiments some runs were measured earlier.
    pub recorded: &'a [RecordedExperiment],
    pub groups: &'a [Group],
    pub studies: &'a [Study],
    /// Figures over all studies.
    pub common: &'a [Shown],
    /// The first study of each experiment.
    pub full: &'a [InFull<'a>],
}

/// A study that is shown in full.
pub(crate) struct InFull<'a> {
    pub study: &'a Study,
    /// Folder of its figures' files.
    pub place: String,
    pub figures: Vec<Shown>,
}

/// The whole page.
pub(crate) fn html(content: &Content) -> String {
    let Content {
        commands,
        judged,
        recorded,
        groups,
        studies,
        common,
        full,
    } = content;
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
         controllers below do. Numbers in parentheses, such as (8), are the paper’s equations. Verdicts are computed by the rule in each row: a number that misses \
         it differs, and one that misses it by more than a factor of two fails. A number that meets it while its interval over seeds is \
         wider than the tolerance is undecided.</p>\n",
    );
    if let Some(note) = few_updates(studies) {
        page.write(format_args!("<p class=\"quiet\">{}</p>\n", Prose(&note)));
    }
    page.push("<nav>");
    for (id, name) in [
        ("claims", "Claims"),
        ("numbers", "Beyond the papers"),
        ("figures", "Figures"),
        ("tables", "Every run"),
        ("subjects", "Controllers"),
        ("assumptions", "Deviations and assumptions"),
    ] {
        page.write(format_args!("<a href=\"#{id}\">{name}</a>"));
    }
    page.push("</nav>\n");

    page.push("<h2 id=\"claims\">Claims</h2>\n");
    if studies.len() > 1 {
        page.push(
            "<p class=\"quiet\">Each claim is judged by the runs of the experiment that it is about; beside it stands what other \
             methods do. Small numbers are the single seeds. In a command, <code>RUN</code> stands for a run’s folder or a \
             controller’s file: it gives that seed’s value.</p>\n",
        );
    }
    page.recorded(judged, recorded);
    page.claims(judged, recorded, commands);
    page.push("<h2 id=\"numbers\">Beyond the papers</h2>\n");
    page.push(
        "<p class=\"quiet\">Measures that are usual in gait research. Human values are quoted from the sources named; \
         they are for people of different size and build, and are not claims of the papers.</p>\n",
    );
    // The method that is set beside the papers' first; what it leaves out or repeats can be unfolded.
    let open = groups.iter().position(|group| !group.claimed).unwrap_or(0);
    for (index, group) in groups.iter().enumerate() {
        page.folded(groups.len() > 1, index == open, &title(group), |page| {
            page.numbers(&group.numbers, commands);
        });
    }

    page.push("<h2 id=\"figures\">Figures</h2>\n<div class=\"figures\">\n");
    for shown in *common {
        page.figure(shown, "figures");
    }
    page.push("</div>\n");
    if full.len() < studies.len() {
        page.push(
            "<p class=\"quiet\">Of each experiment the first seed given is shown with figures and tables of its own; every run is in the \
             table of runs below, and <code>gaitshift report RUN</code> shows it in full.</p>\n",
        );
    }
    let open = groups.get(open).map(|group| group.name.as_str());
    for own in *full {
        let study = own.study;
        let title = format!("<b>{}</b>, seed {}", Escaped(&study.name), study.seed);
        let is_open = open == Some(study.group.as_str());
        page.folded(full.len() > 1, is_open, &title, |page| {
            page.push("<div class=\"figures\">\n");
            for shown in &own.figures {
                page.figure(shown, &own.place);
            }
            page.push("</div>\n");
            page.changes(study);
            page.ground_steps(study);
            page.noise(study);
            page.support(study);
            page.return_maps(study);
            page.fine_step(study);
        });
    }

    page.push("<h2 id=\"tables\">Every run</h2>\n");
    page.runs(studies);
    page.feet(studies);
    page.push("<h2 id=\"subjects\">Controllers</h2>\n");
    page.subjects(studies);
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

    /// Some content, which can be folded if there is other content beside it; paper shows all of it.
    fn folded(&mut self, fold: bool, open: bool, title: &str, content: impl FnOnce(&mut Self)) {
        if fold {
            let open = if open { " open" } else { "" };
            self.write(format_args!(
                "<details{open}>\n<summary>{title}</summary>\n"
            ));
        }
        content(self);
        if fold {
            self.push("</details>\n");
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

/// Says so where the papers' experiments learned from fewer updates than the papers', which have one for every step.
fn few_updates(studies: &[Study]) -> Option<String> {
    let fewer = |study: &&Study| {
        let p = &study.provenance;
        is_claimed(&study.group) && 2 * p.updates < p.environment_steps
    };
    let study = studies.iter().find(fewer)?;
    let p = &study.provenance;
    let steps = p.environment_steps as f64 / p.updates.max(1) as f64;
    Some(format!(
        "The papers update the networks at every step. Not all runs below do: that of {}, for example, has one update per {steps:.0} steps. \
         Steps and updates of each run are in the table of controllers.",
        study.name
    ))
}

/// An experiment with its seeds, as HTML.
fn title(group: &Group) -> String {
    format!(
        "<b>{}</b> ({})",
        Escaped(&group.name),
        numbered(&group.seeds)
    )
}

/// A picture within the page: its own size is what it takes at most, and its title what a screen reader says.
fn picture(svg: &str, title: &str) -> String {
    svg.replacen(
        "<svg ",
        &format!("<svg role=\"img\" aria-label=\"{}\" ", Escaped(title)),
        1,
    )
}
