//! A subject for the stage, and a hand-made client that can misbehave.
#![allow(dead_code)] // Each test file uses its own part.

use gaitshift_body::Body;
use gaitshift_experiment::Controller;
use gaitshift_view::{RECIPES_RANGE, Server, Show, Subject, ViewOptions};
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::time::Duration;

pub fn subject() -> Subject {
    let controller = Controller::shipped().unwrap();
    Subject {
        body: Body::new(controller.body.clone()).unwrap(),
        controller,
        name: "shipped".to_owned(),
        trained: RECIPES_RANGE,
        seed: None,
    }
}

/// Serves a live stage on a free loopback port for the rest of the test program.
pub fn serve() -> SocketAddr {
    serve_show(Show::Live(vec![subject()]))
}

pub fn serve_show(show: Show) -> SocketAddr {
    let server = Server::bind(&ViewOptions {
        address: SocketAddr::new(Ipv4Addr::LOCALHOST.into(), 0),
        names: vec!["biped.example".to_owned()],
    })
    .unwrap();
    let address = server.address();
    std::thread::spawn(move || server.run(show));
    address
}

pub fn connect(address: SocketAddr) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    stream
}

/// Sends a request as it stands and gives the answer up to the end of the connection.
pub fn ask(address: SocketAddr, request: &str) -> String {
    let mut stream = connect(address);
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    // A refused connection may be reset before it is read to its end.
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

pub fn get(address: SocketAddr, path: &str, host: &str, more: &str) -> String {
    ask(
        address,
        &format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{more}\r\n"),
    )
}

pub fn status(answer: &str) -> u16 {
    answer
        .split(' ')
        .nth(1)
        .and_then(|s| s.parse().ok())
        .unwrap_or(0)
}

/// A WebSocket, by hand.
pub struct Socket {
    pub stream: TcpStream,
    buffer: Vec<u8>,
}

impl Socket {
    /// Opens the stage's socket; gives the status of a refusal.
    pub fn open(address: SocketAddr, more: &str) -> Result<Self, u16> {
        let mut stream = connect(address);
        let request = format!(
            "GET /socket HTTP/1.1\r\nHost: {address}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{more}\r\n"
        );
        stream.write_all(request.as_bytes()).map_err(|_| 0_u16)?;
        let mut buffer = Vec::new();
        let mut byte = [0; 1024];
        loop {
            if let Some(end) = buffer.windows(4).position(|w| w == b"\r\n\r\n") {
                let head = String::from_utf8_lossy(&buffer[..end]).into_owned();
                buffer.drain(..end + 4);
                return match status(&head) {
                    101 => Ok(Self { stream, buffer }),
                    other => Err(other),
                };
            }
            match stream.read(&mut byte) {
                Ok(0) | Err(_) => return Err(0),
                Ok(n) => buffer.extend_from_slice(&byte[..n]),
            }
        }
    }

    /// A frame with any first byte and any announced length.
    pub fn frame(&mut self, first: u8, length: u64, payload: &[u8]) -> bool {
        let mut bytes = vec![first];
        match length {
            0..=125 => bytes.push(0x80 | length as u8),
            126..=65_535 => {
                bytes.push(0x80 | 126);
                bytes.extend((length as u16).to_be_bytes());
            }
            _ => {
                bytes.push(0x80 | 127);
                bytes.extend(length.to_be_bytes());
            }
        }
        // The mask of zeros leaves the payload as it is.
        bytes.extend([0; 4]);
        bytes.extend(payload);
        self.stream.write_all(&bytes).is_ok()
    }

    pub fn say(&mut self, text: &str) -> bool {
        self.frame(0x81, text.len() as u64, text.as_bytes())
    }

    /// The next frame: opcode and payload; `None` at the end.
    pub fn hear(&mut self) -> Option<(u8, Vec<u8>)> {
        loop {
            if let Some((head, length)) = self.announced()
                && self.buffer.len() >= head + length
            {
                let opcode = self.buffer[0] & 0x0f;
                let payload = self.buffer[head..head + length].to_vec();
                self.buffer.drain(..head + length);
                return Some((opcode, payload));
            }
            let mut bytes = [0; 4096];
            match self.stream.read(&mut bytes) {
                Ok(0) | Err(_) => return None,
                Ok(n) => self.buffer.extend_from_slice(&bytes[..n]),
            }
        }
    }

    fn announced(&self) -> Option<(usize, usize)> {
        let b = &self.buffer;
        match *b.get(1)? & 0x7f {
            126 => Some((4, usize::from(u16::from_be_bytes([*b.get(2)?, *b.get(3)?])))),
            127 => {
                let bytes: [u8; 8] = b.get(2..10)?.try_into().ok()?;
                Some((10, usize::try_from(u64::from_be_bytes(bytes)).ok()?))
            }
            short => Some((2, usize::from(short))),
        }
    }

    /// The next text message that contains `part`.
    pub fn hear_text(&mut self, part: &str) -> Option<String> {
        loop {
            let (opcode, payload) = self.hear()?;
            let text = String::from_utf8_lossy(&payload).into_owned();
            if opcode == 1 && text.contains(part) {
                return Some(text);
            }
        }
    }

    /// Whether the server ends the conversation.
    pub fn ends(&mut self) -> bool {
        loop {
            match self.hear() {
                None | Some((8, _)) => return true,
                Some(_) => {}
            }
        }
    }
}
