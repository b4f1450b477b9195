//! One controller on one body: its motion under way and its latest rows.

use crate::history::History;
use gaitshift_analysis::recording::{COLUMNS, Recording, column};
use gaitshift_body::{Body, BodyParameters, BodyState, ParameterError};
use gaitshift_experiment::{Controller, Deterministic, Simulation};
use gaitshift_task::{EndReason, Environment};
use std::collections::VecDeque;

/// Kept for recordings, films and analyses, in s, and the most rows that are kept for it.
const KEPT_S: f64 = 60.0;
const MOST_ROWS: usize = 60_000;

/// A controller and the body it moves, as asked for.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The controller.
    pub controller: Controller,
    /// The body, which may differ from the one it was trained on.
    pub body: Body,
    /// What the page and recordings call it.
    pub name: String,
    /// Range of the command it was trained for.
    pub trained: [f64; 2],
    /// Seed that draws the start; `None` for the default start.
    pub seed: Option<u64>,
}

impl Subject {
    fn start(&self, body: &Body) -> BodyState {
        Environment::start(body, &self.controller.task, self.seed)
    }
}

/// A subject in motion.
#[derive(Debug)]
pub(crate) struct Biped {
    pub subject: Subject,
    /// The body as the sliders have it.
    body: Body,
    simulation: Simulation,
    /// Columns of the reward terms of one's own, which follow the recording's in every row.
    own_columns: Vec<String>,
    rows: VecDeque<f64>,
    row: Vec<f64>,
    pub history: History,
    push: Option<Push>,
    fell: Option<EndReason>,
}

/// A force on the hip, forward and up in N, for so many more control periods.
#[derive(Debug, Clone, Copy)]
struct Push {
    force_n: [f64; 2],
    periods: u32,
}

impl Biped {
    pub fn new(subject: Subject, omega_v: f64) -> Self {
        let body = subject.body.clone();
        let start = subject.start(&body);
        let task = &subject.controller.task;
        let simulation = Simulation::new(&body, task, start, omega_v);
        let own_columns = task.reward.extra.columns().collect();
        let mut biped = Self {
            subject,
            body,
            simulation,
            own_columns,
            rows: VecDeque::new(),
            row: Vec::new(),
            history: History::default(),
            push: None,
            fell: None,
        };
        biped.keep_row();
        biped
    }

    /// Begins again from the start, on the body as it is now.
    pub fn restart(&mut self, omega_v: f64) {
        let start = self.subject.start(&self.body);
        let task = &self.subject.controller.task;
        self.simulation = Simulation::new(&self.body, task, start, omega_v);
        self.rows.clear();
        self.history = History::default();
        let changed = self.body.parameters() != self.subject.body.parameters();
        if changed {
            self.history
                .remark("the body differs from the one the program was given".to_owned());
        }
        self.push = None;
        self.fell = None;
        self.keep_row();
    }

    /// Moves one control period; nothing if it has fallen. Gives whether it moved.
    pub fn step(&mut self, omega_v: f64) -> bool {
        if self.fell.is_some() {
            return false;
        }
        self.history.push(self.simulation.time_s(), omega_v);
        // A motion begins with the command that it goes on with, as its replay does.
        if self.simulation.time_s() == 0.0 {
            self.rows[column::OMEGA_V.index()] = omega_v;
        }
        let force_n = self.push.map(|push| push.force_n);
        if let Some(push) = &mut self.push {
            push.periods -= 1;
            if push.periods == 0 {
                self.push = None;
            }
        }
        let policy = &mut self.subject.controller.policy;
        let ended = self
            .simulation
            .step(omega_v, force_n, &mut Deterministic(policy));
        self.fell = ended;
        if !ended.is_some_and(EndReason::is_failure) {
            self.keep_row();
        }
        true
    }

    fn keep_row(&mut self) {
        self.simulation.row(&mut self.row);
        let own = &self.simulation.terms().extra[..self.own_columns.len()];
        self.row.extend(own);
        let kept = (KEPT_S / self.simulation.control_period_s()).ceil() as usize;
        if self.rows.len() >= kept.clamp(1, MOST_ROWS) * self.row.len() {
            self.rows.drain(..self.row.len());
        }
        self.rows.extend(&self.row);
    }

    /// Pushes the hip with a force, forward and up in N, from the next control period on.
    pub fn push(&mut self, force_n: [f64; 2], duration_s: f64) {
        let periods = (duration_s / self.simulation.control_period_s()).round();
        let periods = periods.max(1.0) as u32;
        self.push = Some(Push { force_n, periods });
        self.history.remark(format!(
            "pushed at {} s with {} N forward and {} N up for {} s",
            self.simulation.time_s(),
            force_n[0],
            force_n[1],
            f64::from(periods) * self.simulation.control_period_s()
        ));
    }

    /// Force on the hip now, in N.
    pub fn pushed_n(&self) -> [f64; 2] {
        self.push.map_or([0.0; 2], |push| push.force_n)
    }

    /// Goes on with other parameters of the body in the same state. Rows before the change are given up, since a
    /// recording is of one body.
    ///
    /// # Errors
    /// The first parameter out of range; nothing has changed then.
    pub fn change_body(&mut self, parameters: BodyParameters) -> Result<(), ParameterError> {
        let body = Body::new(parameters)?;
        self.body = body.clone();
        self.simulation.change_body(body);
        self.history.remark(format!(
            "the body was changed at {} s",
            self.simulation.time_s()
        ));
        self.rows.clear();
        self.keep_row();
        Ok(())
    }

    pub fn parameters(&self) -> &BodyParameters {
        self.body.parameters()
    }

    pub fn fell(&self) -> Option<EndReason> {
        self.fell
    }

    pub fn time_s(&self) -> f64 {
        self.simulation.time_s()
    }

    pub fn control_period_s(&self) -> f64 {
        self.simulation.control_period_s()
    }

    /// Columns of the reward terms of one's own.
    pub fn own_columns(&self) -> &[String] {
        &self.own_columns
    }

    /// The latest row, in the order of the recording's columns and then of one's own.
    pub fn row(&self) -> &[f64] {
        &self.row
    }

    /// The last `rows` rows as a recording.
    pub fn recording(&self, rows: usize) -> Recording {
        let mut metadata = self
            .simulation
            .metadata(&self.subject.name, self.subject.seed.unwrap_or(0));
        if let Some(ended) = self.fell {
            metadata.fell = true;
            metadata.ended_by = self.subject.controller.task.end_name(ended).to_owned();
        }
        let mut recording = Recording::new(metadata);
        let width = COLUMNS.len() + self.own_columns.len();
        let kept = self.rows.len() / width;
        let mut row = Vec::with_capacity(width);
        let mut own = vec![Vec::new(); self.own_columns.len()];
        for k in kept.saturating_sub(rows)..kept {
            row.clear();
            row.extend(self.rows.range(k * width..(k + 1) * width));
            // A row that no recording can hold ends it; the motion has diverged there.
            if recording.push_row(&row[..COLUMNS.len()]).is_err() {
                break;
            }
            for (series, value) in own.iter_mut().zip(&row[COLUMNS.len()..]) {
                series.push(*value);
            }
        }
        for (column, series) in self.own_columns.iter().zip(own) {
            // Such a column is one of a recording: the task has checked its name.
            let _ = recording.set_extra(column, series);
        }
        recording
    }
}
