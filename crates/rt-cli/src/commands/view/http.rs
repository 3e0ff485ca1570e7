//! HTTP/1.1: requests are parsed within fixed limits, responses carry the headers that keep the page to itself.

use std::borrow::Cow;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Most bytes of the request line and headers.
pub(super) const MAX_HEAD: usize = 8 << 10;

/// Most headers of a request.
const MAX_HEADERS: usize = 64;

/// Most bytes of a body.
pub(super) const MAX_BODY: usize = 4 << 10;

/// Time without a request after which a connection is closed.
const IDLE: Duration = Duration::from_secs(15);

/// Time that a request may take to arrive once it has begun.
const ARRIVAL: Duration = Duration::from_secs(5);

/// Longest wait for a client to close a connection.
const LINGER: Duration = Duration::from_secs(1);

/// Headers of every response. Scripts, styles and images come from this server only, no other page may embed or read
/// its responses, and browsers store none on disk.
const HEADERS: &str = "\
Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; \
base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
Cross-Origin-Resource-Policy: same-origin\r\n\
Cross-Origin-Opener-Policy: same-origin\r\n\
Referrer-Policy: no-referrer\r\n\
X-Content-Type-Options: nosniff\r\n\
Cache-Control: no-store\r\n\
Allow: GET, POST\r\n";

/// Status code and reason phrase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Status(pub(super) u16, &'static str);

impl Status {
    pub(super) const OK: Self = Self(200, "OK");
    pub(super) const BAD_REQUEST: Self = Self(400, "Bad Request");
    pub(super) const FORBIDDEN: Self = Self(403, "Forbidden");
    pub(super) const NOT_FOUND: Self = Self(404, "Not Found");
    pub(super) const METHOD: Self = Self(405, "Method Not Allowed");
    pub(super) const TIMEOUT: Self = Self(408, "Request Timeout");
    pub(super) const BODY: Self = Self(413, "Content Too Large");
    pub(super) const HEAD: Self = Self(431, "Request Header Fields Too Large");
    pub(super) const INTERNAL: Self = Self(500, "Internal Server Error");
    pub(super) const ENCODING: Self = Self(501, "Not Implemented");
    pub(super) const BUSY: Self = Self(503, "Service Unavailable");
    pub(super) const VERSION: Self = Self(505, "HTTP Version Not Supported");
}

/// A request, with the headers that matter here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Request {
    pub(super) method: String,
    /// Begins with a slash.
    pub(super) path: String,
    /// Text after the question mark.
    pub(super) query: String,
    pub(super) host: Option<String>,
    pub(super) origin: Option<String>,
    pub(super) keeps_alive: bool,
    pub(super) body: Vec<u8>,
}

impl Request {
    /// Parses the request at the beginning of the bytes, and counts its bytes. `None` if more of it has to arrive.
    pub(super) fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, Status> {
        let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
        let mut head = httparse::Request::new(&mut headers);
        let start = match head.parse(bytes) {
            Ok(httparse::Status::Complete(start)) if start <= MAX_HEAD => start,
            Ok(httparse::Status::Partial) if bytes.len() < MAX_HEAD => return Ok(None),
            Ok(_) | Err(httparse::Error::TooManyHeaders) => return Err(Status::HEAD),
            Err(httparse::Error::Version) => return Err(Status::VERSION),
            Err(_) => return Err(Status::BAD_REQUEST),
        };
        let (method, target) = head.method.zip(head.path).ok_or(Status::BAD_REQUEST)?;
        if !target.starts_with('/') {
            return Err(Status::BAD_REQUEST);
        }
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let (mut host, mut origin, mut length) = (None, None, None);
        let mut keeps_alive = head.version == Some(1);
        for header in head.headers.iter() {
            let value = || str::from_utf8(header.value).map_err(|_| Status::BAD_REQUEST);
            match header.name.to_ascii_lowercase().as_str() {
                "host" => set_once(&mut host, value()?)?,
                "origin" => set_once(&mut origin, value()?)?,
                "content-length" => set_once(&mut length, value()?)?,
                "transfer-encoding" => return Err(Status::ENCODING),
                "connection" => {
                    keeps_alive &= !value()?.split(',').any(|item| item.trim().eq_ignore_ascii_case("close"))
                }
                _ => {}
            }
        }
        let length = match &length {
            None => 0,
            Some(digits) if !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()) => {
                digits.parse().ok().filter(|length| *length <= MAX_BODY).ok_or(Status::BODY)?
            }
            Some(_) => return Err(Status::BAD_REQUEST),
        };
        let Some(body) = bytes.get(start..start + length) else { return Ok(None) };
        let request = Self {
            method: method.to_owned(),
            path: path.to_owned(),
            query: query.to_owned(),
            host,
            origin,
            keeps_alive,
            body: body.to_owned(),
        };
        Ok(Some((request, start + length)))
    }

    /// Number of this name in the query.
    pub(super) fn number(&self, name: &str) -> Option<u64> {
        let pairs = self.query.split('&').filter_map(|pair| pair.split_once('='));
        pairs.filter(|(key, _)| *key == name).find_map(|(_, value)| value.parse().ok())
    }
}

/// Repeated headers are refused: a proxy might have checked the other one.
fn set_once(header: &mut Option<String>, value: &str) -> Result<(), Status> {
    if header.replace(value.to_owned()).is_some() { Err(Status::BAD_REQUEST) } else { Ok(()) }
}

/// A response of known length.
#[derive(Debug)]
pub(super) struct Response {
    pub(super) status: Status,
    pub(super) content_type: &'static str,
    /// Name under which a browser saves the body.
    pub(super) file_name: Option<String>,
    pub(super) body: Cow<'static, [u8]>,
    /// File after the body, which other responses may share.
    pub(super) file: Option<Arc<Vec<u8>>>,
}

impl Response {
    pub(super) fn new(content_type: &'static str, body: impl Into<Cow<'static, [u8]>>) -> Self {
        Self { status: Status::OK, content_type, file_name: None, body: body.into(), file: None }
    }

    /// Refusal with a reason for people.
    pub(super) fn refusal(status: Status, reason: &str) -> Self {
        let Status(code, phrase) = status;
        let text = if reason.is_empty() { format!("{code} {phrase}\n") } else { format!("{reason}\n") };
        Self { status, ..Self::new("text/plain; charset=utf-8", text.into_bytes()) }
    }
}

pub(super) struct Connection {
    stream: TcpStream,
    /// Bytes that have arrived and belong to no request so far.
    buffer: Vec<u8>,
    /// True if the last request was HEAD, whose response has no body.
    omits_body: bool,
}

impl Connection {
    pub(super) fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(IDLE))?;
        Ok(Self { stream, buffer: Vec::new(), omits_body: false })
    }

    /// Reads the next request. `None` if the client has closed the connection or sent nothing for a while.
    pub(super) fn read(&mut self) -> Result<Option<Request>, Status> {
        self.omits_body = false;
        let mut deadline = Instant::now() + if self.buffer.is_empty() { IDLE } else { ARRIVAL };
        loop {
            if let Some((request, length)) = Request::parse(&self.buffer)? {
                self.buffer.drain(..length);
                self.omits_body = request.method == "HEAD";
                return Ok(Some(request));
            }
            let was_idle = self.buffer.is_empty();
            match self.receive(deadline) {
                Ok(0) => return Ok(None),
                Ok(_) if was_idle => deadline = Instant::now() + ARRIVAL,
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) if was_idle => return Ok(None),
                Err(_) => return Err(Status::TIMEOUT),
            }
        }
    }

    /// Receives some bytes; 0 if there are no more.
    fn receive(&mut self, deadline: Instant) -> io::Result<usize> {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left))?;
        let mut bytes = [0; 4096];
        let count = self.stream.read(&mut bytes)?;
        self.buffer.extend(bytes.iter().take(count));
        Ok(count)
    }

    pub(super) fn write(&mut self, response: &Response) -> io::Result<()> {
        self.send(response, "")
    }

    /// Writes the last response. Bytes that are still on their way are dropped first: closing before them would make the system
    /// of the client drop the response.
    pub(super) fn close_with(mut self, response: &Response) -> io::Result<()> {
        self.send(response, "Connection: close\r\n")?;
        self.stream.shutdown(Shutdown::Write)?;
        let deadline = Instant::now() + LINGER;
        while self.receive(deadline)? > 0 {
            self.buffer.clear();
        }
        Ok(())
    }

    fn send(&mut self, response: &Response, header: &str) -> io::Result<()> {
        let Response { status: Status(code, phrase), content_type, file_name, body, file } = response;
        let file = file.as_ref().map_or(&[][..], |file| file);
        let disposition =
            file_name.as_ref().map(|name| format!("Content-Disposition: attachment; filename=\"{name}\"\r\n"));
        let head = format!(
            "HTTP/1.1 {code} {phrase}\r\nContent-Type: {content_type}\r\nContent-Length: {}\r\n{HEADERS}{}{header}\r\n",
            body.len() + file.len(),
            disposition.unwrap_or_default()
        );
        self.stream.write_all(head.as_bytes())?;
        if self.omits_body {
            return Ok(());
        }
        self.stream.write_all(body)?;
        self.stream.write_all(file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_tests::Draw;

    const WHOLE: &str = "POST /t/camera?a=1&b=2 HTTP/1.1\r\nHost: localhost:80\r\nOrigin: http://localhost:80\r\n\
                         X-Other: \t any\u{e9} \r\ncontent-length: 4\r\n\r\n{\"a\"";

    fn status(text: &str) -> Status {
        Request::parse(text.as_bytes()).expect_err(text)
    }

    #[test]
    fn requests_are_parsed_when_they_are_complete() {
        let (request, length) = Request::parse(WHOLE.as_bytes()).expect("sound").expect("complete");
        assert_eq!(
            (length, request.path.as_str(), request.body.as_slice()),
            (WHOLE.len(), "/t/camera", &b"{\"a\""[..])
        );
        assert_eq!(
            (request.host.as_deref(), request.origin.as_deref()),
            (Some("localhost:80"), Some("http://localhost:80"))
        );
        assert_eq!((request.number("b"), request.number("c"), request.keeps_alive), (Some(2), None, true));
        for length in 0..WHOLE.len() {
            assert_eq!(Request::parse(&WHOLE.as_bytes()[..length]), Ok(None), "{length}");
        }
        let two = format!("{WHOLE}GET / HTTP/1.0\r\n\r\n");
        let (_, first) = Request::parse(two.as_bytes()).expect("sound").expect("complete");
        let (second, _) = Request::parse(&two.as_bytes()[first..]).expect("sound").expect("complete");
        assert!(second.method == "GET" && second.host.is_none() && !second.keeps_alive);
    }

    #[test]
    fn requests_beyond_the_rules_are_refused() {
        let with = |header: &str| status(&format!("GET / HTTP/1.1\r\nHost: a\r\n{header}\r\n\r\n"));
        assert_eq!(with("Host: b"), Status::BAD_REQUEST);
        assert_eq!(with("Content-Length: 1\r\nContent-Length: 1"), Status::BAD_REQUEST);
        assert_eq!(with("Content-Length: +1"), Status::BAD_REQUEST);
        assert_eq!(with("Content-Length: 99999999999999999999999"), Status::BODY);
        assert_eq!(with(&format!("Content-Length: {}", MAX_BODY + 1)), Status::BODY);
        assert_eq!(with("Transfer-Encoding: chunked"), Status::ENCODING);
        assert_eq!(with(" folded: line"), Status::BAD_REQUEST);
        assert_eq!(with("no colon"), Status::BAD_REQUEST);
        assert_eq!(with(&"a: b\r\n".repeat(MAX_HEADERS)), Status::HEAD);
        for line in ["GET  / HTTP/1.1", "GET http://a/ HTTP/1.1", "G\u{e9}T / HTTP/1.1", "GET /", "GET"] {
            assert_eq!(status(&format!("{line}\r\n\r\n")), Status::BAD_REQUEST, "{line}");
        }
        for line in ["GET / HTTP/2.0", "GET / FTP/1.1"] {
            assert_eq!(status(&format!("{line}\r\n\r\n")), Status::VERSION, "{line}");
        }
        assert_eq!(status(&"a".repeat(MAX_HEAD)), Status::HEAD);
    }

    /// Requests with some bytes replaced, removed, or repeated, and bytes at random.
    #[test]
    fn no_request_makes_the_parser_panic() {
        let mut draw = Draw::new(25);
        for round in 0..20_000 {
            let mut bytes = if round % 4 == 0 { Vec::new() } else { WHOLE.as_bytes().to_vec() };
            for _ in 0..draw.below(12) {
                let (at, byte) =
                    (draw.below(bytes.len() + 1), *b"\r\n :/?\0\xff9aH-".get(draw.below(12)).unwrap_or(&0));
                match draw.below(4) {
                    0 => bytes.truncate(at),
                    1 => bytes.insert(at, byte),
                    2 => bytes = [&bytes[..at], &bytes[at / 2..]].concat(),
                    _ => bytes.splice(at..at, (0..draw.below(9)).map(|_| draw.below(256) as u8)).for_each(drop),
                }
            }
            if let Ok(Some((_, length))) = Request::parse(&bytes) {
                assert!(length <= bytes.len());
            }
        }
    }
}
