//! A motion that another program moves, shown while it moves: whoever looks sees the same.

use crate::message::{BipedMessage, BipedsMessage, NowMessage, Samples, sample_columns};
use crate::stage::{self, Now};
use axum::extract::ws::{Message, Utf8Bytes, WebSocket};
use futures_util::SinkExt;
use futures_util::stream::StreamExt;
use gaitshift_analysis::recording::{COLUMNS, Column, Recording, RecordingMetadata};
use gaitshift_body::BodyParameters;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::broadcast;
use tokio::time::{interval, timeout};

/// Messages that a slow page may lag behind; it loses what is older.
const MOST_WAITING: usize = 256;
const SEND_TIMEOUT: Duration = Duration::from_secs(20);
/// The most rows from which the figures are taken, and rows between two sets of them.
const MOST_ROWS: usize = 4000;
const ROWS_PER_FIGURES: u64 = 10;
/// A silent connection is closed ([`crate::guard`]); a program may think for long between two steps.
const PING_INTERVAL: Duration = Duration::from_secs(15);

/// A motion to be watched. Clones show the same motion.
#[derive(Debug, Clone)]
pub struct Watched {
    shared: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    name: String,
    columns: Vec<Column>,
    own_columns: Vec<String>,
    sender: broadcast::Sender<Message>,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    body: BodyParameters,
    metadata: RecordingMetadata,
    epoch: u32,
    count: u64,
    rows: VecDeque<f64>,
}

impl Watched {
    /// A motion of a body, which recordings of it would describe by `metadata`, with columns of reward terms of one's own.
    pub fn new(
        name: &str,
        body: &BodyParameters,
        metadata: RecordingMetadata,
        own_columns: Vec<String>,
    ) -> Self {
        Self {
            shared: Arc::new(Inner {
                name: name.to_owned(),
                columns: sample_columns(),
                own_columns,
                sender: broadcast::channel(MOST_WAITING).0,
                state: Mutex::new(State {
                    body: body.clone(),
                    metadata,
                    epoch: 0,
                    count: 0,
                    rows: VecDeque::new(),
                }),
            }),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.shared
            .state
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// A motion begins, of a body and on a ground that may be others: what is pushed from here on does not go on from
    /// what was before.
    pub fn begin(&self, body: &BodyParameters, metadata: RecordingMetadata) {
        let mut state = self.state();
        state.epoch += 1;
        state.rows.clear();
        (state.body, state.metadata) = (body.clone(), metadata);
        if let Some(text) = self.bipeds(&state) {
            // Nobody has to look.
            let _ = self.shared.sender.send(text);
        }
    }

    /// Shows the next row, in the order of the recording's columns and then of one's own.
    pub fn push(&self, row: &[f64]) {
        if row.len() != self.width() {
            return;
        }
        let mut state = self.state();
        state.count += 1;
        let shown = (stage::SHOWN_S / state.metadata.control_period_s).round() as usize + 1;
        if state.rows.len() >= shown.min(MOST_ROWS) * row.len() {
            state.rows.drain(..row.len());
        }
        state.rows.extend(row);
        // Nobody has to look.
        if self.shared.sender.receiver_count() == 0 {
            return;
        }
        let _ = self.shared.sender.send(self.sample(&state, row));
        if state.count.is_multiple_of(ROWS_PER_FIGURES)
            && let Some(text) = self.figures(&state)
        {
            let _ = self.shared.sender.send(text);
        }
    }

    fn width(&self) -> usize {
        COLUMNS.len() + self.shared.own_columns.len()
    }

    fn sample(&self, state: &State, row: &[f64]) -> Message {
        let mut samples = Samples::new(0, state.epoch);
        samples.push(row, [0.0; 2], &self.shared.columns);
        Message::Binary(samples.finish().into())
    }

    /// Who moves and where it is now, for a page that has seen nothing yet, or lost something.
    fn present(&self) -> VecDeque<Message> {
        let state = self.state();
        let mut messages: VecDeque<Message> = self.bipeds(&state).into_iter().collect();
        if let Some(begin) = state.rows.len().checked_sub(self.width()) {
            let row: Vec<f64> = state.rows.range(begin..).copied().collect();
            messages.push_back(self.sample(&state, &row));
        }
        messages
    }

    fn figures(&self, state: &State) -> Option<Message> {
        let mut recording = Recording::new(state.metadata.clone());
        let width = self.width();
        let mut row = Vec::with_capacity(COLUMNS.len());
        for k in 0..state.rows.len() / width {
            row.clear();
            row.extend(state.rows.range(k * width..k * width + COLUMNS.len()));
            if recording.push_row(&row).is_err() {
                break;
            }
        }
        let now: Now = stage::describe(&recording, None);
        let omega_v = row.get(1).copied().unwrap_or(0.0);
        text(&NowMessage {
            epoch: state.epoch,
            omega_v,
            paused: false,
            pace: 1.0,
            dropped: 0,
            behind_s: 0.0,
            bipeds: vec![now],
        })
    }

    fn bipeds(&self, state: &State) -> Option<Message> {
        let State { body, metadata, .. } = state;
        text(&BipedsMessage {
            epoch: state.epoch,
            control_period_s: metadata.control_period_s,
            bipeds: vec![BipedMessage {
                name: &self.shared.name,
                ground: metadata.ground_to_draw(),
                trained: crate::RECIPES_RANGE,
                body,
                given: body,
                weight_n: body.total_mass_kg() * body.gravity_m_per_s2,
                own_columns: &self.shared.own_columns,
            }],
            films: false,
            version: env!("CARGO_PKG_VERSION"),
        })
    }

    /// Shows the motion to a page until it is closed. What the page says is not listened to.
    pub(crate) async fn serve(&self, socket: WebSocket) {
        let (mut sink, mut stream) = socket.split();
        let mut motion = self.shared.sender.subscribe();
        let mut next = self.present();
        let mut pings = interval(PING_INTERVAL);
        loop {
            while let Some(message) = next.pop_front() {
                match timeout(SEND_TIMEOUT, sink.send(message)).await {
                    Ok(Ok(())) => {}
                    _ => return,
                }
            }
            tokio::select! {
                _ = pings.tick() => next.push_back(Message::Ping(Vec::new().into())),
                message = motion.recv() => match message {
                    Ok(message) => next.push_back(message),
                    // What it lost may have been the beginning of another motion.
                    Err(broadcast::error::RecvError::Lagged(_)) => {
                        motion = motion.resubscribe();
                        next = self.present();
                    }
                    Err(broadcast::error::RecvError::Closed) => break,
                },
                heard = stream.next() => match heard {
                    Some(Ok(Message::Close(_)) | Err(_)) | None => break,
                    Some(Ok(_)) => {}
                },
            }
        }
    }
}

fn text(message: &impl serde::Serialize) -> Option<Message> {
    let json = serde_json::to_string(message).ok()?;
    Some(Message::Text(Utf8Bytes::from(json)))
}
