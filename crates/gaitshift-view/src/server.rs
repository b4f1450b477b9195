//! Listening and answering: the page, its parts, the run's curves, the socket.

use crate::biped::Subject;
use crate::guard::{Gate, Names};
use crate::run_folder::RunView;
use crate::watch::Watched;
use crate::{page, socket};
use axum::Router;
use axum::extract::{Request, State, WebSocketUpgrade};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use tokio::net::TcpListener;
use tokio::sync::{Notify, Semaphore};

/// Live stages at a time; each is a simulation of its own.
const MOST_STAGES: usize = 16;
/// Films drawn at a time.
const MOST_FILMS: usize = 1;

/// Where to listen.
#[derive(Debug, Clone)]
pub struct ViewOptions {
    /// Address and port; port 0 takes a free one.
    pub address: SocketAddr,
    /// Host names to answer to besides `localhost` and addresses.
    pub names: Vec<String>,
}

/// What is shown.
#[derive(Debug)]
pub enum Show {
    /// One or two subjects on a live stage.
    Live(Vec<Subject>),
    /// The folder of a training run, and the subject that stands on the stage at first.
    Run(PathBuf, Box<Subject>),
    /// A motion that another program moves.
    Watched(Watched),
    /// A page that needs nothing but itself, as [`crate::replay_html`] makes it.
    Page(String),
}

impl Show {
    /// Whether it can be shown.
    ///
    /// # Errors
    /// None or more than two subjects on a live stage, or two with different control periods.
    pub fn validate(&self) -> Result<(), ViewError> {
        match self {
            Self::Live(subjects) => check_subjects(subjects),
            _ => Ok(()),
        }
    }
}

/// Why nothing can be shown.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The address is taken or not this machine's.
    #[error("cannot listen on {address}: {cause}; give another --port or --listen")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The operating system's reason.
        cause: io::Error,
    },
    /// Two bipeds cannot be moved in the same steps.
    #[error("{0}")]
    Subjects(String),
    /// The server stopped.
    #[error("the server stopped: {0}")]
    Stopped(io::Error),
}

/// A server that listens already and answers from [`Server::run`] on.
#[derive(Debug)]
pub struct Server {
    runtime: tokio::runtime::Runtime,
    listener: TcpListener,
    address: SocketAddr,
    names: Names,
    stop: Arc<Notify>,
}

/// Ends a server from elsewhere.
#[derive(Debug, Clone)]
pub struct Stopper(Arc<Notify>);

impl Stopper {
    /// Lets [`Server::run`] come back, now or as soon as it begins.
    pub fn stop(&self) {
        self.0.notify_one();
    }
}

/// What all connections share.
#[derive(Debug)]
struct Shared {
    names: Names,
    show: Show,
    run: Option<RunView>,
    stages: Arc<Semaphore>,
    films: Arc<Semaphore>,
}

impl Server {
    /// Takes the address.
    ///
    /// # Errors
    /// One that cannot be listened on.
    pub fn bind(options: &ViewOptions) -> Result<Self, ViewError> {
        let error = |cause| ViewError::Listen {
            address: options.address,
            cause,
        };
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            // Files of the run, pictures and films.
            .max_blocking_threads(4)
            .thread_name("view")
            .enable_all()
            .build()
            .map_err(error)?;
        let listener = runtime
            .block_on(TcpListener::bind(options.address))
            .map_err(error)?;
        let address = listener.local_addr().map_err(error)?;
        Ok(Self {
            runtime,
            listener,
            address,
            stop: Arc::default(),
            names: Names {
                any_address: !options.address.ip().is_loopback(),
                names: options.names.clone(),
            },
        })
    }

    /// The address with the port that was given or taken.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What to open in a browser on this machine.
    pub fn url(&self) -> String {
        let ip = self.address.ip();
        if ip.is_unspecified() {
            format!("http://localhost:{}/", self.address.port())
        } else {
            format!("http://{}/", self.address)
        }
    }

    /// What ends the server.
    pub fn stopper(&self) -> Stopper {
        Stopper(Arc::clone(&self.stop))
    }

    /// Answers until the program ends, or until it is stopped.
    ///
    /// # Errors
    /// What [`Show::validate`] refuses; a listener that fails.
    pub fn run(self, show: Show) -> Result<(), ViewError> {
        show.validate()?;
        let run = match &show {
            Show::Run(folder, _) => Some(RunView::new(folder.clone())),
            _ => None,
        };
        let shared = Arc::new(Shared {
            names: self.names,
            show,
            run,
            stages: Arc::new(Semaphore::new(MOST_STAGES)),
            films: Arc::new(Semaphore::new(MOST_FILMS)),
        });
        let served = axum::serve(Gate::new(self.listener), router(shared)).into_future();
        let stop = self.stop;
        let outcome = self.runtime.block_on(async {
            tokio::select! {
                outcome = served => outcome,
                () = stop.notified() => Ok(()),
            }
        });
        // Films under way are not waited for.
        self.runtime.shutdown_background();
        outcome.map_err(ViewError::Stopped)
    }
}

fn check_subjects(subjects: &[Subject]) -> Result<(), ViewError> {
    let (Some(first), true) = (subjects.first(), subjects.len() <= 2) else {
        return Err(ViewError::Subjects(
            "one or two bipeds can be on the stage".to_owned(),
        ));
    };
    let period = |subject: &Subject| subject.controller.task.control_period_s;
    match subjects
        .iter()
        .find(|subject| period(subject) != period(first))
    {
        Some(other) => Err(ViewError::Subjects(format!(
            "{} has a control period of {} s and {} one of {} s; bipeds side by side need the same",
            first.name,
            period(first),
            other.name,
            period(other)
        ))),
        None => Ok(()),
    }
}

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/", get(index))
        .route("/page.css", get(|| part(page::STYLE, "text/css")))
        .route(
            "/page.js",
            get(|| part(page::live_script(), "text/javascript")),
        )
        .route("/icon.svg", get(|| part(page::ICON, "image/svg+xml")))
        .route("/run.json", get(run_json))
        .route("/socket", get(open_socket))
        .fallback(|| async {
            (
                StatusCode::NOT_FOUND,
                "there is no such page here; go to /\n",
            )
        })
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), admit))
        .with_state(shared)
}

/// Refuses what is not for us, and says in every answer what a page may do.
async fn admit(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    if let Err(reason) = shared.names.check(request.headers(), request.uri()) {
        return (StatusCode::FORBIDDEN, format!("{reason}\n")).into_response();
    }
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    // A replay carries its script and style in itself; it can reach nothing anyway.
    let policy = match shared.show {
        Show::Page(_) => {
            "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        }
        _ => {
            "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        }
    };
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, policy),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::CACHE_CONTROL, "no-store"),
        (header::REFERRER_POLICY, "no-referrer"),
        (
            HeaderName::from_static("cross-origin-resource-policy"),
            "same-origin",
        ),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

async fn part(content: &'static str, kind: &'static str) -> impl IntoResponse {
    (
        [(header::CONTENT_TYPE, format!("{kind}; charset=utf-8"))],
        content,
    )
}

async fn index(State(shared): State<Arc<Shared>>) -> Response {
    let html = match &shared.show {
        Show::Page(html) => html.clone(),
        Show::Live(_) => page::live_html("live"),
        Show::Watched(_) => page::live_html("watch"),
        Show::Run(..) => page::live_html("run"),
    };
    ([(header::CONTENT_TYPE, "text/html; charset=utf-8")], html).into_response()
}

async fn run_json(State(shared): State<Arc<Shared>>) -> Response {
    let Some(run) = shared.run.clone() else {
        return (StatusCode::NOT_FOUND, "no run is shown here\n").into_response();
    };
    match tokio::task::spawn_blocking(move || run.json()).await {
        Ok(json) => ([(header::CONTENT_TYPE, "application/json")], json).into_response(),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

async fn open_socket(State(shared): State<Arc<Shared>>, upgrade: WebSocketUpgrade) -> Response {
    let subjects = match &shared.show {
        Show::Live(subjects) => subjects.clone(),
        Show::Run(_, subject) => vec![(**subject).clone()],
        Show::Watched(_) => Vec::new(),
        Show::Page(_) => return StatusCode::NOT_FOUND.into_response(),
    };
    let Ok(place) = Arc::clone(&shared.stages).try_acquire_owned() else {
        let reason = format!("{MOST_STAGES} stages are open already; close one of them\n");
        return (StatusCode::SERVICE_UNAVAILABLE, reason).into_response();
    };
    socket::limit(upgrade).on_upgrade(move |socket| async move {
        match &shared.show {
            Show::Watched(watched) => watched.serve(socket).await,
            _ => {
                socket::serve(socket, subjects, shared.run.as_ref(), &shared.films).await;
            }
        }
        drop(place);
    })
}
