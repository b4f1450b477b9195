//! One tab: its stage in real time, what it is sent, what it asks for.

use crate::biped::Subject;
use crate::message::{
    BipedsMessage, MOST_BYTES, Notice, NowMessage, Request, Samples, file_message, sample_columns,
};
use crate::run_folder::RunView;
use crate::save;
use crate::stage::{Change, Stage};
use axum::extract::WebSocketUpgrade;
use axum::extract::ws::{Message, Utf8Bytes, WebSocket};
use futures_util::stream::StreamExt;
use futures_util::{SinkExt, stream::SplitSink};
use gaitshift_analysis::recording::Column;
use serde::Serialize;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{Semaphore, mpsc};
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

/// Frames a second that the page is sent.
const FRAMES_PER_S: f64 = 60.0;
/// Frames between two sets of figures: ten a second.
const FRAMES_PER_FIGURES: u64 = 6;
/// Messages that may wait for a slow page; samples take only part of the places.
const MOST_WAITING: usize = 48;
const KEPT_FREE: usize = 16;
/// A page that takes no message for so long is gone.
const SEND_TIMEOUT: Duration = Duration::from_secs(20);
/// Time that is made up for after a pause of the machine, in s; what is more is left out.
const MOST_BEHIND_S: f64 = 0.25;
/// Messages a second that a page may send, and wrong ones until it is sent away.
const MOST_PER_SECOND: u32 = 240;
const MOST_WRONG: u32 = 20;
/// Samples in a message at most: whoever moves in steps of microseconds gets fewer pictures, not more memory.
const MOST_SAMPLES: u32 = 64;

/// Bounds what a message can make us keep.
pub(crate) fn limit(upgrade: WebSocketUpgrade) -> WebSocketUpgrade {
    upgrade
        .max_message_size(MOST_BYTES)
        .max_frame_size(MOST_BYTES)
        .read_buffer_size(8 * 1024)
        .write_buffer_size(0)
}

/// Time on the stage against the clock on the wall.
#[derive(Debug)]
struct Clock {
    since: Instant,
    periods: u64,
    pace: f64,
    paused: bool,
    behind_s: f64,
}

impl Clock {
    fn new() -> Self {
        Self {
            since: Instant::now(),
            periods: 0,
            pace: 1.0,
            paused: false,
            behind_s: 0.0,
        }
    }

    fn restart(&mut self) {
        self.since = Instant::now();
        self.periods = 0;
    }

    /// Control periods that are due. They are counted from one fixed instant, so that nothing adds up.
    fn due(&mut self, period_s: f64) -> u64 {
        if self.paused {
            return 0;
        }
        let elapsed_s = self.since.elapsed().as_secs_f64() * self.pace;
        let due = ((elapsed_s / period_s) as u64).saturating_sub(self.periods);
        let most = (MOST_BEHIND_S / period_s).ceil().max(1.0) as u64;
        if due > most {
            self.behind_s += (due - most) as f64 * period_s;
            self.restart();
            return most;
        }
        self.periods += due;
        due
    }
}

/// Serves a page until it is closed: a run whose evaluations it may ask for, places for films that are made at the same time.
pub(crate) async fn serve(
    socket: WebSocket,
    subjects: Vec<Subject>,
    run: Option<&RunView>,
    films: &Arc<Semaphore>,
) {
    let (sink, mut stream) = socket.split();
    let (outbox, waiting) = mpsc::channel(MOST_WAITING);
    let sender = tokio::spawn(send_all(sink, waiting));
    let mut tab = Tab {
        stage: Stage::new(subjects),
        clock: Clock::new(),
        outbox,
        columns: sample_columns(),
        frames: 0,
        dropped: 0,
        saving: None,
        run,
        films,
    };
    tab.tell_bipeds();
    tab.show();
    let mut ticks = interval(Duration::from_secs_f64(1.0 / FRAMES_PER_S));
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let (mut this_second, mut in_second, mut wrong) = (Instant::now(), 0, 0);
    loop {
        tokio::select! {
            _ = ticks.tick() => {
                if !tab.tick() {
                    break;
                }
            }
            message = stream.next() => {
                let Some(Ok(message)) = message else { break };
                if this_second.elapsed() > Duration::from_secs(1) {
                    (this_second, in_second) = (Instant::now(), 0);
                }
                in_second += 1;
                let outcome = match message {
                    _ if in_second > MOST_PER_SECOND => break,
                    Message::Text(text) => Request::read(&text),
                    Message::Binary(_) => Err("a page sends text, no binary messages".to_owned()),
                    Message::Close(_) => break,
                    Message::Ping(_) | Message::Pong(_) => continue,
                };
                let outcome = match outcome {
                    Ok(request) => tab.answer(request).await,
                    Err(reason) => {
                        wrong += 1;
                        Err(reason)
                    }
                };
                if let Err(message) = outcome {
                    tab.tell(&Notice::Error { message });
                }
                if wrong > MOST_WRONG {
                    break;
                }
            }
        }
    }
    // Whatever still waits to be sent, or for a place to be made, is of no use to a page that is gone.
    sender.abort();
    if let Some(saving) = tab.saving.take() {
        saving.abort();
    }
}

async fn send_all(mut sink: SplitSink<WebSocket, Message>, mut waiting: mpsc::Receiver<Message>) {
    while let Some(message) = waiting.recv().await {
        match timeout(SEND_TIMEOUT, sink.send(message)).await {
            Ok(Ok(())) => {}
            _ => break,
        }
    }
}

/// A file under way, drawn on another thread.
type Saving = tokio::task::JoinHandle<Result<(String, Vec<u8>), String>>;

struct Tab<'a> {
    stage: Stage,
    clock: Clock,
    outbox: mpsc::Sender<Message>,
    columns: Vec<Column>,
    frames: u64,
    dropped: u64,
    saving: Option<Saving>,
    run: Option<&'a RunView>,
    films: &'a Arc<Semaphore>,
}

impl Tab<'_> {
    /// Moves on to the present and shows it. Gives whether the page is still there.
    fn tick(&mut self) -> bool {
        self.frames += 1;
        let due = self.clock.due(self.stage.control_period_s());
        self.move_on(due);
        if self.frames.is_multiple_of(FRAMES_PER_FIGURES) {
            self.show();
        }
        self.hand_over();
        !self.outbox.is_closed()
    }

    /// Moves on by some control periods and sends what happened.
    fn move_on(&mut self, periods: u64) {
        if periods == 0 {
            return;
        }
        let mut messages = self.messages();
        // Of many tiny periods only some are shown.
        let every = periods.div_ceil(u64::from(MOST_SAMPLES));
        for k in 1..=periods {
            if self.stage.step() {
                // What began anew must not be joined to what was before.
                self.send_samples(std::mem::replace(&mut messages, self.messages()));
            }
            if k % every == 0 || k == periods {
                for (biped, samples) in self.stage.bipeds.iter().zip(&mut messages) {
                    samples.push(biped.row(), biped.pushed_n(), &self.columns);
                }
            }
        }
        self.send_samples(messages);
    }

    fn messages(&self) -> Vec<Samples> {
        let epoch = self.stage.epoch;
        (0..self.stage.bipeds.len())
            .map(|biped| Samples::new(biped, epoch))
            .collect()
    }

    fn send_samples(&mut self, messages: Vec<Samples>) {
        for samples in messages {
            let count = samples.count();
            if count == 0 {
                continue;
            }
            if self.outbox.capacity() > KEPT_FREE {
                let _ = self
                    .outbox
                    .try_send(Message::Binary(samples.finish().into()));
            } else {
                self.dropped += u64::from(count);
            }
        }
    }

    /// Sends the figures.
    fn show(&mut self) {
        if self.outbox.capacity() <= KEPT_FREE {
            return;
        }
        let now = NowMessage {
            epoch: self.stage.epoch,
            omega_v: self.stage.omega_v(),
            paused: self.clock.paused,
            pace: self.clock.pace,
            dropped: self.dropped,
            behind_s: self.clock.behind_s,
            bipeds: (0..self.stage.len())
                .filter_map(|k| self.stage.now(k))
                .collect(),
        };
        self.tell(&now);
    }

    fn tell_bipeds(&self) {
        self.tell(&BipedsMessage::of(
            &self.stage,
            gaitshift_figures::find_ffmpeg().is_some(),
        ));
    }

    /// Sends something that must not be left out; a page that has no place for it is beyond help.
    fn tell(&self, message: &impl Serialize) {
        if let Ok(json) = serde_json::to_string(message) {
            let _ = self.outbox.try_send(Message::Text(Utf8Bytes::from(json)));
        }
    }

    /// Hands over a file that is ready.
    fn hand_over(&mut self) {
        if !self.saving.as_ref().is_some_and(Saving::is_finished) {
            return;
        }
        let Some(saving) = self.saving.take() else {
            return;
        };
        // It is finished, so this does not wait.
        let outcome = futures_util::FutureExt::now_or_never(saving);
        match outcome {
            Some(Ok(Ok((name, content)))) => {
                let message = file_message(&name, &content);
                let _ = self.outbox.try_send(Message::Binary(message.into()));
            }
            Some(Ok(Err(message))) => self.tell(&Notice::Error { message }),
            _ => self.tell(&Notice::Error {
                message: "the file could not be made".to_owned(),
            }),
        }
    }

    /// Does what the page asks for.
    async fn answer(&mut self, request: Request) -> Result<(), String> {
        match request {
            Request::OmegaV { value } => self.stage.set_omega_v(value)?,
            Request::Change { name } => {
                let change = Change::named(&name)
                    .ok_or_else(|| format!("there is no preset change `{name}`"))?;
                self.stage.change(change);
            }
            Request::Pause { on } => {
                self.clock.paused = on;
                self.clock.restart();
                self.show();
            }
            Request::Step { periods } => {
                if !(1..=100).contains(&periods) {
                    return Err("a step has 1 to 100 control periods".to_owned());
                }
                self.clock.paused = true;
                self.move_on(u64::from(periods));
                self.show();
            }
            Request::Pace { value } => {
                if !(0.01..=1.0).contains(&value) {
                    return Err("the pace is from 0.01 to 1".to_owned());
                }
                self.clock.pace = value;
                self.clock.restart();
            }
            Request::Reset {} => {
                self.stage.restart();
                self.begin_anew();
            }
            Request::Push {
                force_n,
                duration_s,
            } => self.stage.push(force_n, duration_s)?,
            Request::Body { values } => {
                self.stage.change_body(&values)?;
                self.send_present();
            }
            Request::Compare { on } => {
                self.stage.compare(on);
                self.begin_anew();
            }
            Request::Save {
                what,
                seconds,
                biped,
            } => self.save(what, seconds, biped)?,
            Request::Evaluation { step } => {
                let run = self.run.cloned();
                let run = run.ok_or_else(|| "no run is shown here".to_owned())?;
                let subject = tokio::task::spawn_blocking(move || run.subject(step))
                    .await
                    .map_err(|e| e.to_string())??;
                self.stage.replace(subject);
                self.begin_anew();
            }
        }
        Ok(())
    }

    fn begin_anew(&mut self) {
        self.clock.restart();
        self.send_present();
    }

    /// Shows who moves and where each is now; the page forgets what was before.
    fn send_present(&mut self) {
        self.tell_bipeds();
        let mut messages = self.messages();
        for (biped, samples) in self.stage.bipeds.iter().zip(&mut messages) {
            samples.push(biped.row(), biped.pushed_n(), &self.columns);
        }
        self.send_samples(messages);
        self.show();
    }

    fn save(&mut self, what: String, seconds: f64, biped: usize) -> Result<(), String> {
        if self.saving.is_some() {
            return Err("a file is being made; ask again when it is there".to_owned());
        }
        let order = save::Order::of(&self.stage, &what, seconds, biped)?;
        let films = Arc::clone(self.films);
        self.tell(&Notice::Saving { what });
        self.saving = Some(tokio::spawn(async move {
            let _place = films.acquire_owned().await.map_err(|e| e.to_string())?;
            tokio::task::spawn_blocking(move || order.fill())
                .await
                .map_err(|e| e.to_string())?
        }));
        Ok(())
    }
}
