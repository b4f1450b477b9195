//! Who may connect, and how many: names against DNS rebinding, places against floods, time against silence.

use axum::http::{HeaderMap, Uri, header};
use axum::serve::Listener;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, Sleep, sleep_until};

/// Connections at a time; more are closed at once.
pub(crate) const MOST_CONNECTIONS: usize = 128;
/// A connection on which nothing moves for so long is closed.
const SILENCE: Duration = Duration::from_secs(45);

/// The names under which the server answers.
#[derive(Debug, Clone)]
pub(crate) struct Names {
    /// Whether addresses other than the loopback ones are its own too.
    pub any_address: bool,
    /// Further host names, given by the user.
    pub names: Vec<String>,
}

impl Names {
    /// Whether a request may be answered: its Host is ours, and a page that sent it is ours too.
    ///
    /// A page of another site can make the browser resolve that site's name to this machine; its requests then still
    /// carry that name as Host. Addresses and `localhost` cannot be rebound.
    ///
    /// # Errors
    /// Why not, in one sentence.
    pub fn check(&self, headers: &HeaderMap, uri: &Uri) -> Result<(), String> {
        let mut hosts = headers.get_all(header::HOST).iter();
        let host = match (hosts.next(), hosts.next()) {
            (Some(host), None) => host.to_str().unwrap_or(""),
            (None, _) => uri.authority().map_or("", |a| a.as_str()),
            (Some(_), Some(_)) => "",
        };
        if !self.is_ours(host) {
            return Err(format!(
                "this server does not answer to the name {host:?}; open it as http://localhost:PORT/, or start it with --name NAME"
            ));
        }
        let mut origins = headers.get_all(header::ORIGIN).iter();
        match (origins.next(), origins.next()) {
            // Only browsers send an origin, and they send it with every WebSocket.
            (None, _) => Ok(()),
            (Some(origin), None) if origin.to_str().ok() == Some(&format!("http://{host}")) => {
                Ok(())
            }
            _ => Err("this server answers no page but its own".to_owned()),
        }
    }

    fn is_ours(&self, host: &str) -> bool {
        let (name, port) = match host.strip_prefix('[') {
            // [::1]:8000
            Some(rest) => match rest.split_once(']') {
                Some((address, rest)) => (address, rest.strip_prefix(':').unwrap_or(rest)),
                None => return false,
            },
            None => host.rsplit_once(':').unwrap_or((host, "")),
        };
        if !port.is_empty() && port.parse::<u16>().is_err() {
            return false;
        }
        if let Ok(address) = name.parse::<IpAddr>() {
            return address.is_loopback() || self.any_address;
        }
        let same = |other: &String| other.eq_ignore_ascii_case(name);
        name.eq_ignore_ascii_case("localhost") || self.names.iter().any(same)
    }
}

/// A listener with a bounded number of places.
#[derive(Debug)]
pub(crate) struct Gate {
    listener: TcpListener,
    places: Arc<Semaphore>,
}

impl Gate {
    pub fn new(listener: TcpListener) -> Self {
        Self {
            listener,
            places: Arc::new(Semaphore::new(MOST_CONNECTIONS)),
        }
    }
}

impl Listener for Gate {
    type Io = Visitor;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Visitor, SocketAddr) {
        loop {
            match self.listener.accept().await {
                Ok((stream, address)) => {
                    // Whoever finds no place is told so by the closed connection.
                    if let Ok(place) = Arc::clone(&self.places).try_acquire_owned() {
                        // Frames are small and must not wait for each other.
                        let _ = stream.set_nodelay(true);
                        return (Visitor::new(stream, place), address);
                    }
                }
                // Out of file descriptors, or the connection is gone already.
                Err(_) => tokio::time::sleep(Duration::from_millis(50)).await,
            }
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// A connection that holds a place and loses it when nothing moves.
#[derive(Debug)]
pub(crate) struct Visitor {
    stream: TcpStream,
    silence: Pin<Box<Sleep>>,
    _place: OwnedSemaphorePermit,
}

impl Visitor {
    fn new(stream: TcpStream, place: OwnedSemaphorePermit) -> Self {
        Self {
            stream,
            silence: Box::pin(sleep_until(Instant::now() + SILENCE)),
            _place: place,
        }
    }

    fn watch<T>(
        &mut self,
        context: &mut Context<'_>,
        outcome: Poll<io::Result<T>>,
    ) -> Poll<io::Result<T>> {
        if outcome.is_ready() {
            self.silence.as_mut().reset(Instant::now() + SILENCE);
            return outcome;
        }
        match self.silence.as_mut().poll(context) {
            Poll::Ready(()) => Poll::Ready(Err(io::ErrorKind::TimedOut.into())),
            Poll::Pending => Poll::Pending,
        }
    }
}

impl AsyncRead for Visitor {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let outcome = Pin::new(&mut self.stream).poll_read(context, buffer);
        self.watch(context, outcome)
    }
}

impl AsyncWrite for Visitor {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let outcome = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.watch(context, outcome)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
