//! Progress of a training run on standard error: a bar where a person looks on, plain lines elsewhere.

use crate::output;
use gaitshift_analysis::GaitClass;
use gaitshift_experiment::{Judgement, Observer, Progress};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::VecDeque;
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(30);
/// Pace is measured over this much training time, in s.
const PACE_WINDOW_S: f64 = 60.0;

/// Watches a run, shows how it goes and stops it when asked to.
#[derive(Debug)]
pub struct Watcher {
    display: Display,
    pace: VecDeque<(f64, u64)>,
    verdict: Option<String>,
    interrupted: Arc<AtomicBool>,
    stop_at_step: Option<u64>,
    step: u64,
}

#[derive(Debug)]
enum Display {
    Bar(ProgressBar),
    Lines { next: Instant },
}

impl Watcher {
    /// Watches a run from environment step `step` on that ends when `interrupted` is set or at about `stop_at_step`.
    pub fn new(interrupted: Arc<AtomicBool>, step: u64, stop_at_step: Option<u64>) -> Self {
        let display = if std::io::stderr().is_terminal() {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(4));
            let template = "{bar:14.cyan/blue} {percent:>3} %  {prefix}\n{wide_msg}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            Display::Bar(bar)
        } else {
            Display::Lines {
                next: Instant::now(),
            }
        };
        Self {
            display,
            pace: VecDeque::new(),
            verdict: None,
            interrupted,
            stop_at_step,
            step,
        }
    }

    /// Whether the user interrupted the run.
    pub fn interrupted(&self) -> bool {
        self.interrupted.load(Ordering::SeqCst)
    }

    /// Leaves the last state standing.
    pub fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.abandon();
        }
    }

    /// Environment steps per second, lately.
    fn steps_per_s(&mut self, p: &Progress) -> Option<f64> {
        self.pace.push_back((p.elapsed_s, p.step));
        while self.pace.len() > 2
            && self
                .pace
                .front()
                .is_some_and(|f| p.elapsed_s - f.0 > PACE_WINDOW_S)
        {
            self.pace.pop_front();
        }
        let &(then_s, then) = self.pace.front()?;
        let rate = (p.step - then) as f64 / (p.elapsed_s - then_s);
        (rate.is_finite() && rate > 0.0).then_some(rate)
    }

    fn say(&self, text: &str) {
        match &self.display {
            Display::Bar(bar) => bar.println(text),
            Display::Lines { .. } => output::note(text),
        }
    }
}

impl Observer for Watcher {
    fn progress(&mut self, p: &Progress) {
        self.step = p.step;
        let pace = match self.steps_per_s(p) {
            Some(rate) => {
                let left_s = p.total_steps.saturating_sub(p.step) as f64 / rate;
                format!("{rate:.0} steps/s, {} left", duration(left_s))
            }
            None => "pace not known yet".to_owned(),
        };
        let steps = format!("{} of {} steps", count(p.step), count(p.total_steps));
        // Before the first episode ends there is nothing to average.
        let episodes = if p.mean_return == 0.0 && p.fall_share == 0.0 {
            String::new()
        } else {
            format!(
                ", return {:.0}, {:.0} % fall",
                p.mean_return,
                100.0 * p.fall_share
            )
        };
        let verdict = self.verdict.as_ref().unwrap_or(&p.verdict);
        match &mut self.display {
            Display::Bar(bar) => {
                bar.set_length(p.total_steps);
                bar.set_position(p.step);
                bar.set_prefix(format!("{steps}, {pace}"));
                bar.set_message(format!("phase {}{episodes}; {verdict}", p.phase));
            }
            Display::Lines { next } => {
                let now = Instant::now();
                if now >= *next {
                    *next = now + LINE_INTERVAL;
                    // As narrow as the lines of evaluations, which say the rest.
                    output::note(&format!(
                        "{steps}, {pace}, {:.0} % fall",
                        100.0 * p.fall_share
                    ));
                }
            }
        }
    }

    fn evaluated(&mut self, p: &Progress, judgement: &Judgement, best: bool) {
        if self.verdict.is_none() {
            self.say(&heading(judgement));
        }
        self.verdict = Some(verdict(judgement));
        self.say(&evaluation(p, judgement, best));
    }

    fn note(&mut self, text: &str) {
        self.say(text);
    }

    fn stop_requested(&self) -> bool {
        self.interrupted() || self.stop_at_step.is_some_and(|stop| self.step >= stop)
    }
}

/// Whether it has the gaits yet that are asked for.
fn verdict(judgement: &Judgement) -> String {
    let verbs = [
        (GaitClass::Walking, "walks", "does not walk yet"),
        (GaitClass::Running, "runs", "does not run yet"),
        (GaitClass::Standing, "stands", "does not stand yet"),
    ];
    let does = |(gait, does, not_yet): (GaitClass, &'static str, &'static str)| {
        let mut asked = judgement
            .rows
            .iter()
            .filter(|row| row.asked == Some(gait))
            .peekable();
        asked.peek()?;
        let all = asked.all(|row| row.summary.gait == gait);
        Some(if all { does } else { not_yet })
    };
    let all: Vec<&str> = verbs.into_iter().filter_map(does).collect();
    if all.is_empty() {
        return format!("{} of {} criteria", judgement.met(), judgement.checks.len());
    }
    all.join(", ")
}

/// Over the lines of evaluations, which fit 80 columns: what their columns are.
fn heading(judgement: &Judgement) -> String {
    let commands = judgement
        .rows
        .iter()
        .map(|row| format!(" {:<5}", row.omega_v));
    let line = format!(
        "{:>9} {:>6} {:>5} {:>5}  ω_v",
        "step", "time", "met", "score"
    );
    let explained = [
        "Each line is an evaluation without noise: criteria met; score, with part credit",
        "for those nearly met (* the best so far, which is kept); and at each command",
        "w walks, r runs, m neither, with the Froude number; s stands; f fell, time in s.",
    ];
    format!(
        "{}\n{}\n{}",
        explained.join("\n"),
        line,
        format!("{:BEFORE$}{}", "", in_columns(commands)).trim_end()
    )
}

/// Columns before those of the commands, and as many of these as a line of 80 columns holds.
const BEFORE: usize = 28;
const A_LINE: usize = 8;

/// What is told of each command, on further lines where there are many.
fn in_columns(each: impl Iterator<Item = String>) -> String {
    let each: Vec<String> = each.collect();
    let lines = each
        .chunks(A_LINE)
        .map(|line| line.concat().trim_end().to_owned());
    lines.collect::<Vec<_>>().join(&format!("\n{:BEFORE$}", ""))
}

/// One evaluation in a line; the best so far has a star.
fn evaluation(p: &Progress, judgement: &Judgement, best: bool) -> String {
    let gaits = judgement.rows.iter().map(|row| {
        let s = &row.summary;
        // A Froude number below 1 without its zero.
        let froude = || output::number(s.froude, 2).replacen("0.", ".", 1);
        let word = match s.gait {
            _ if s.fell => format!("f{:.1}", s.survived_s),
            GaitClass::Walking => format!("w{}", froude()),
            GaitClass::Running => format!("r{}", froude()),
            GaitClass::Standing => "s".to_owned(),
            _ => format!("m{}", froude()),
        };
        format!(" {word:<5}")
    });
    let line = format!(
        "{:>9} {:>6} {:>2}/{} {:>5.1}{}{}",
        count(p.step),
        duration(p.elapsed_s),
        judgement.met(),
        judgement.checks.len(),
        judgement.score(),
        if best { "*" } else { " " },
        in_columns(gaits),
    );
    line.trim_end().to_owned()
}

/// A number with its thousands apart.
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A duration in s, in words.
pub fn duration(seconds: f64) -> String {
    let minutes = seconds / 60.0;
    if seconds < 90.0 {
        format!("{seconds:.0} s")
    } else if minutes < 90.0 {
        format!("{minutes:.0} min")
    } else {
        format!("{:.1} h", minutes / 60.0)
    }
}
