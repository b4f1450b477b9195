//! The claims with their verdicts, and the numbers beside those of people.

use super::Page;
use super::text::{Escaped, Prose, estimate};
use crate::claims::{Finding, Verdict};
use crate::headline::HeadlineNumber;

impl Page {
    pub(super) fn counts(&mut self, findings: &[Finding]) {
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

    pub(super) fn findings(&mut self, findings: &[Finding]) {
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

    pub(super) fn numbers(&mut self, numbers: &[HeadlineNumber]) {
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
