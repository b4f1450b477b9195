//! The claims with their verdicts, and the numbers beside those of people.

use super::Page;
use super::text::{Escaped, Prose, estimate, numbered, seeds};
use crate::claims::{Finding, Judged, Verdict, other_learners};
use crate::headline::HeadlineNumber;
use crate::recorded::RecordedExperiment;
use crate::source::{Commands, Source};

impl Page {
    /// Which findings are of runs that are not measured for the page. Experiments that learned alike stand together.
    pub(super) fn recorded(&mut self, judged: &[Judged], recorded: &[RecordedExperiment]) {
        let used = |r: &&RecordedExperiment| {
            let mut findings = judged.iter().flat_map(Judged::findings);
            findings.any(|f| f.recorded && f.experiment == r.name)
        };
        let mut alike: Vec<Vec<&RecordedExperiment>> = Vec::new();
        for r in recorded.iter().filter(used) {
            match alike.iter_mut().find(|of| of[0].runs == r.runs) {
                Some(of) => of.push(r),
                None => alike.push(vec![r]),
            }
        }
        if alike.is_empty() {
            return;
        }
        self.push(
            "<p class=\"quiet\">What is marked <i>recorded</i> is of runs that were measured earlier. The figures over all \
             controllers show them, too.</p>\n<ul class=\"quiet\">\n",
        );
        for of in alike {
            self.push("<li>");
            for (index, r) in of.iter().enumerate() {
                let comma = if index > 0 { "; " } else { "" };
                self.write(format_args!(
                    "{comma}<b>{}</b>, {}",
                    Prose(&r.name),
                    numbered(&r.seeds)
                ));
            }
            self.write(format_args!(": {}</li>\n", Prose(&of[0].runs)));
        }
        self.push("</ul>\n");
    }

    /// One row for each claim; in columns what its own experiment says, with every learner of which runs were measured, and every
    /// method beside it.
    pub(super) fn claims(
        &mut self,
        judged: &[Judged],
        recorded: &[RecordedExperiment],
        commands: &Commands,
    ) {
        let own = |j: &&Judged| j.own.verdict != Verdict::NotMeasured;
        let mut columns: Vec<(String, Vec<&Finding>)> = Vec::new();
        for (index, learner) in other_learners(recorded).into_iter().enumerate() {
            let findings = judged.iter().map(|j| &j.other_learners[index]).collect();
            columns.push((learner.to_owned(), findings));
        }
        if let Some(first) = judged.iter().find(own) {
            let mut alike = recorded.iter().filter(|r| r.name == first.own.experiment);
            let learner = alike.find_map(|r| r.learner.clone());
            let name = learner.filter(|_| first.own.recorded);
            let findings = judged.iter().map(|j| &j.own).collect();
            columns.push((name.unwrap_or("its experiment".to_owned()), findings));
        }
        let others = judged.first().map_or(0, |j| j.beside.len());
        for index in 0..others {
            let findings: Vec<&Finding> = judged.iter().map(|j| &j.beside[index]).collect();
            columns.push((findings[0].experiment.clone(), findings));
        }
        for (name, findings) in &columns {
            let name = if columns.len() > 1 { name } else { "" };
            self.counts(name, findings);
        }
        self.push(
            "<div class=\"scroll\"><table class=\"stacked\">\n<thead><tr><th>from</th><th>claim, when it holds, command</th>\
             <th class=\"number\">theirs</th>",
        );
        for (name, _) in &columns {
            self.write(format_args!("<th class=\"number\">{}</th>", Prose(name)));
        }
        self.push("</tr></thead>\n<tbody>\n");
        for (row, j) in judged.iter().enumerate() {
            self.write(format_args!(
                "<tr><td>{}</td><td class=\"main\">{}<div class=\"quiet\">{}; {}</div></td>\
                 <td class=\"number\" data-name=\"theirs\">{}</td>",
                Escaped(j.source),
                Prose(j.claim),
                Prose(&j.rule),
                shown_by(j.shown_by, commands),
                Prose(j.theirs),
            ));
            for (name, findings) in &columns {
                self.write(format_args!(
                    "<td class=\"number\" data-name=\"{}\">{}</td>",
                    Escaped(name),
                    finding(findings[row])
                ));
            }
            self.push("</tr>\n");
        }
        self.push("</tbody></table></div>\n");
    }

    fn counts(&mut self, name: &str, findings: &[&Finding]) {
        self.push("<ul class=\"counts\">");
        if !name.is_empty() {
            self.write(format_args!("<li>{}</li>", Prose(name)));
        }
        for verdict in Verdict::ALL {
            let count = findings.iter().filter(|f| f.verdict == verdict).count();
            self.write(format_args!(
                "<li><b>{count}</b> <span class=\"verdict {}\">{}</span></li>",
                class(verdict),
                verdict.name()
            ));
        }
        self.push("</ul>\n");
    }

    pub(super) fn numbers(&mut self, numbers: &[HeadlineNumber], commands: &Commands) {
        self.push(
            "<div class=\"scroll\"><table class=\"stacked\">\n<thead><tr><th>number, command</th><th class=\"number\">ours</th><th>people</th>\
             </tr></thead>\n<tbody>\n",
        );
        for n in numbers {
            self.write(format_args!(
                "<tr><td class=\"main\">{}<div class=\"quiet\">{}</div></td><td class=\"number\" data-name=\"ours\">{}{}</td>\
                 <td data-name=\"people\">{}</td></tr>\n",
                Prose(n.name),
                shown_by(n.shown_by, commands),
                estimate(n.estimate, &n.seeds),
                seeds(&n.seeds),
                Prose(n.people)
            ));
        }
        self.push("</tbody></table></div>\n");
    }
}

/// The command, and which of its values.
fn shown_by(source: Source, commands: &Commands) -> String {
    let (command, value) = commands.of(source);
    let value = match value {
        "" => String::new(),
        value => format!(": {}", Escaped(value)),
    };
    format!("<code>{}</code>{value}", Escaped(&command))
}

/// A value with its seeds and its verdict.
fn finding(f: &Finding) -> String {
    let value = match f.verdict {
        Verdict::NotMeasured => String::new(),
        _ => estimate(f.estimate, &f.seeds) + &seeds(&f.seeds),
    };
    let recorded = if f.recorded { " <i>recorded</i>" } else { "" };
    format!(
        "{value} <span class=\"verdict {}\">{} {}</span>{recorded}",
        class(f.verdict),
        sign(f.verdict),
        f.verdict.name()
    )
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::Undecided | Verdict::Differs => "differs",
        Verdict::Fails => "fails",
        Verdict::NotMeasured => "unmeasured",
    }
}

/// So that a verdict needs no colour.
fn sign(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "✓",
        Verdict::Undecided => "?",
        Verdict::Differs => "≈",
        Verdict::Fails => "✗",
        Verdict::NotMeasured => "·",
    }
}
