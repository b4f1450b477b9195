//! `gaitshift view`: a controller, a run or a recording in the browser.

use crate::arguments::{ChangeArguments, ViewArguments};
use crate::failure::Failure;
use crate::motion::Subject;
use crate::output;
use gaitshift_analysis::Recording;
use gaitshift_experiment::{Controller, Experiment, quoted};
use gaitshift_view::{
    RECIPES_RANGE, Server, Show, ViewError, ViewOptions, replay_html, trained_range,
};
use std::io::{self, IsTerminal};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where the page is unless another port is asked for.
const PORT: u16 = 8420;

/// Runs the command.
pub fn run(arguments: &ViewArguments) -> Result<(), Failure> {
    let show = match &arguments.what {
        None => Show::Live(subjects(arguments)?),
        Some(path) if path.is_dir() => show_run(path)?,
        Some(path) => {
            let recording =
                Recording::read_csv(path).map_err(|e| match Controller::read(path) {
                    Ok(_) => Failure::input(format!(
                        "{} is a controller; move it with `gaitshift view --controller {}`",
                        path.display(),
                        quoted(&path.to_string_lossy())
                    )),
                    Err(_) => Failure::input(e),
                })?;
            let html = replay_html(&recording)
                .map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
            Show::Page(html)
        }
    };
    // Before anything says that there is a page.
    show.validate().map_err(failure)?;
    let server = bind(arguments.listen, arguments.port, &arguments.name)?;
    output::line(&format!("{} (Ctrl-C to stop)", server.url()))?;
    if !arguments.listen.is_loopback() {
        output::note(&format!(
            "listening on {}: whoever reaches this machine can see the page and move the biped",
            server.address()
        ));
    }
    if !arguments.no_open && io::stdout().is_terminal() {
        open(&server.url());
    }
    server.run(show).map_err(failure)
}

/// Shows a run that is about to train in this program, from a thread of its own.
pub fn beside_training(folder: &Path) -> Result<(), Failure> {
    let show = show_run(folder)?;
    let server = bind(Ipv4Addr::LOCALHOST.into(), None, &[])?;
    output::note(&format!("watch it at {}", server.url()));
    if io::stderr().is_terminal() {
        open(&server.url());
    }
    std::thread::Builder::new()
        .name("view".to_owned())
        .spawn(move || {
            if let Err(error) = server.run(show) {
                output::note(&format!("error: {error}"));
            }
        })
        .map_err(Failure::run)?;
    Ok(())
}

/// One biped, or two if two controllers or two bodies are given.
fn subjects(arguments: &ViewArguments) -> Result<Vec<gaitshift_view::Subject>, Failure> {
    let (controllers, bodies) = (&arguments.controller, &arguments.body);
    let count = controllers.len().max(bodies.len()).max(1);
    if count > 2 {
        return Err(Failure::input(
            "at most two bipeds can be side by side: give --controller and --body at most twice each",
        ));
    }
    let of = |given: &[PathBuf], k: usize| given.get(k).or(given.first()).cloned();
    (0..count)
        .map(|k| {
            let (controller, body) = (of(controllers, k), of(bodies, k));
            let trained = controller.as_deref().map_or(RECIPES_RANGE, range_beside);
            let changes = ChangeArguments {
                body: body.clone(),
                ..ChangeArguments::default()
            };
            let mut subject = Subject::of(controller.as_deref(), &changes)?;
            subject.start_at(arguments.seed);
            let mut subject = subject.for_view(trained);
            if let Some(body) = body {
                subject.name = format!("{}, {}", subject.name, body.display());
            }
            Ok(subject)
        })
        .collect()
}

/// The range that a run's controller was trained for, as the configuration beside it says.
fn range_beside(controller: &Path) -> [f64; 2] {
    // Beside one that comes with the program there is none, whatever the working folder holds.
    if Controller::is_name(controller) {
        return RECIPES_RANGE;
    }
    let config = Controller::file_of(controller).with_file_name("config.toml");
    Experiment::load(&config.display().to_string())
        .ok()
        .and_then(|experiment| trained_range(&experiment.curriculum))
        .unwrap_or(RECIPES_RANGE)
}

/// A run with its best controller on the stage, or the shipped one as long as it has none.
fn show_run(folder: &Path) -> Result<Show, Failure> {
    if !folder.join("config.toml").exists() {
        return Err(Failure::input(format!(
            "{} is not a run's folder: it has no config.toml; give the folder of a run that `gaitshift train` began",
            folder.display()
        )));
    }
    let own = Some(Controller::file_of(folder)).filter(|path| path != folder);
    let trained = range_beside(&folder.join("controller.safetensors"));
    let none = own.is_none();
    let subject = Subject::of(own.as_deref(), &ChangeArguments::default())?;
    let mut subject = subject.for_view(trained);
    if none {
        subject.name.push_str(" (the run has none yet)");
    }
    Ok(Show::Run(folder.to_owned(), Box::new(subject)))
}

fn bind(ip: IpAddr, port: Option<u16>, names: &[String]) -> Result<Server, Failure> {
    let at = |port: u16| {
        Server::bind(&ViewOptions {
            address: SocketAddr::new(ip, port),
            names: names.to_vec(),
        })
    };
    let bound = match port {
        Some(port) => at(port),
        // Another page may be shown already.
        None => at(PORT).or_else(|_| at(0)),
    };
    bound.map_err(failure)
}

fn failure(error: ViewError) -> Failure {
    match error {
        ViewError::Stopped(_) => Failure::run(error),
        _ => Failure::input(error),
    }
}

/// Opens the page where there is a desktop; whoever has none opens the printed address.
fn open(url: &str) {
    let program = if cfg!(target_os = "macos") {
        Some(("open", vec![url]))
    } else if cfg!(windows) {
        Some(("rundll32", vec!["url.dll,FileProtocolHandler", url]))
    } else {
        let desktop = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
        (desktop("DISPLAY") || desktop("WAYLAND_DISPLAY")).then(|| ("xdg-open", vec![url]))
    };
    if let Some((program, arguments)) = program {
        // The address stands on standard output in any case.
        let _ = Command::new(program)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
    }
}
