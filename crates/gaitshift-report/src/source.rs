//! Which command shows a number.

use crate::Subject;
use crate::study::Plan;

/// Where a number of the report can be had.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Source {
    /// `gaitshift evaluate --json` under one command: its row, and which key of it.
    Evaluated(f64, &'static str),
    /// The same under all commands of the plan: what of its rows.
    Swept(&'static str),
    /// `gaitshift report` alone.
    Report,
}

/// The commands of a page's numbers: of a single controller they name it, of several `RUN` stands for each.
#[derive(Debug, Clone)]
pub(crate) struct Commands {
    /// With a space before it; empty for the controller that comes with the program.
    controller: String,
    report: String,
    /// Options that give the plan's motions.
    duration: String,
    range: String,
}

impl Commands {
    pub fn new(subjects: &[Subject], plan: &Plan) -> Self {
        let named = |argument: &str| (format!(" --controller {argument}"), argument.to_owned());
        let (controller, report) = match subjects {
            [only] => match &only.argument {
                Some(argument) => named(argument),
                None => (String::new(), "shipped".to_owned()),
            },
            _ => named("RUN"),
        };
        let quick = if *plan == Plan::quick() {
            " --quick"
        } else {
            ""
        };
        // What `gaitshift evaluate` does anyway need not be said.
        let duration = if plan.steady_s == 20.0 {
            String::new()
        } else {
            format!(" --duration-s {}", plan.steady_s)
        };
        let [from, to, step] = plan.range;
        Self {
            controller,
            report: format!("gaitshift report{quick} {report}"),
            duration,
            range: format!("{from}:{to}:{step}"),
        }
    }

    /// The command, and which of the values that it gives.
    pub fn of(&self, source: Source) -> (String, &'static str) {
        let evaluate = |omega_v: &str| {
            let (controller, duration) = (&self.controller, &self.duration);
            format!("gaitshift evaluate{controller} --omega-v={omega_v}{duration} --json")
        };
        match source {
            Source::Evaluated(omega_v, key) => (evaluate(&omega_v.to_string()), key),
            Source::Swept(what) => (evaluate(&self.range), what),
            Source::Report => (self.report.clone(), ""),
        }
    }
}
