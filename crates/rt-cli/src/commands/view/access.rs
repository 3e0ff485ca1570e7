//! Access control: the token in the address, and the headers by which browsers name the page that sends a request.

use std::io;
use std::net::IpAddr;

use super::http::{Request, Status};

const TOKEN_BYTES: usize = 16;

/// Rules that a request has to satisfy.
#[derive(Debug)]
pub(super) struct Access {
    /// Hexadecimal digits.
    token: String,
    /// Only this machine can connect.
    is_loopback: bool,
}

impl Access {
    /// Access by a new random token to a server that listens on this address.
    pub(super) fn new(address: IpAddr) -> io::Result<Self> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).map_err(|error| io::Error::other(error.to_string()))?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { token, is_loopback: address.is_loopback() })
    }

    pub(super) fn page(&self) -> String {
        format!("/{}/", self.token)
    }

    /// The path below the token of a request that is allowed.
    ///
    /// A page of a foreign site can send requests here, and can have its own name resolve to this machine (DNS rebinding). The
    /// former shows in `Origin`, the latter in `Host`.
    pub(super) fn check<'r>(&self, request: &'r Request) -> Result<&'r str, Status> {
        let host = request.host.as_deref().filter(|host| self.allows_host(host)).ok_or(Status::FORBIDDEN)?;
        if request.origin.as_ref().is_some_and(|origin| origin.strip_prefix("http://") != Some(host)) {
            return Err(Status::FORBIDDEN);
        }
        let below_root = request.path.strip_prefix('/').unwrap_or_default();
        let (token, path) = below_root.split_once('/').ok_or(Status::FORBIDDEN)?;
        if is_equal(token.as_bytes(), self.token.as_bytes()) { Ok(path) } else { Err(Status::FORBIDDEN) }
    }

    /// True for this machine by its name `localhost` or its address, with any port, which may be forwarded. A server that others
    /// can reach goes by any address, and by no name.
    fn allows_host(&self, host: &str) -> bool {
        let (name, port) = match host.strip_prefix('[').and_then(|host| host.split_once(']')) {
            Some((name, port)) => (name, port),
            None => host.split_at(host.find(':').unwrap_or(host.len())),
        };
        let is_port = |port: &str| port.strip_prefix(':').is_some_and(|port| port.parse::<u16>().is_ok());
        let is_address = |name: &str| name.parse().is_ok_and(|ip: IpAddr| ip.is_loopback() || !self.is_loopback);
        (port.is_empty() || is_port(port)) && (name.eq_ignore_ascii_case("localhost") || is_address(name))
    }
}

/// Compares in a time that depends on the lengths only.
fn is_equal(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |difference, (a, b)| difference | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(address: &str, host: Option<&str>, origin: Option<&str>, path: &str) -> Result<String, Status> {
        let access =
            Access { token: "12ab".to_owned(), is_loopback: address.parse::<IpAddr>().expect("IP").is_loopback() };
        let lines = [("Host", host), ("Origin", origin)];
        let headers: String =
            lines.iter().filter_map(|(name, value)| Some(format!("{name}: {}\r\n", (*value)?))).collect();
        let text = format!("GET {path} HTTP/1.1\r\n{headers}\r\n");
        let (request, _) = Request::parse(text.as_bytes()).expect("sound").expect("complete");
        access.check(&request).map(str::to_owned)
    }

    #[test]
    fn this_machine_is_let_in_by_name_and_address_and_others_are_not() {
        let page = |host: &str| check("127.0.0.1", Some(host), None, "/12ab/frame").as_deref() == Ok("frame");
        for host in ["localhost", "LOCALHOST:8080", "127.0.0.1:1", "[::1]:65535", "127.0.0.1"] {
            assert!(page(host), "{host}");
        }
        for host in [
            "evil.example",
            "localhost.evil.example",
            "192.168.0.7",
            "127.0.0.1:x",
            "127.0.0.1:99999",
            "[::1",
            "",
            "a:1:2",
        ] {
            assert!(!page(host), "{host}");
        }
        assert!(check("0.0.0.0", Some("192.168.0.7:80"), None, "/12ab/").is_ok());
        assert!(check("0.0.0.0", Some("evil.example"), None, "/12ab/").is_err());
        assert!(check("127.0.0.1", None, None, "/12ab/").is_err());
    }

    #[test]
    fn pages_of_other_origins_are_refused() {
        let from = |origin: &str| check("127.0.0.1", Some("localhost:81"), Some(origin), "/12ab/").is_ok();
        assert!(from("http://localhost:81"));
        for origin in
            ["http://localhost:82", "http://127.0.0.1:81", "https://localhost:81", "null", "http://evil.example"]
        {
            assert!(!from(origin), "{origin}");
        }
    }

    #[test]
    fn only_the_token_opens() {
        let is_open = |path: &str| check("127.0.0.1", Some("localhost"), None, path).is_ok();
        assert!(is_open("/12ab/") && is_open("/12ab/a/b"));
        for path in ["/", "/12ab", "/12aB/", "/12abc/", "/12a/", "//12ab/", "/?12ab/"] {
            assert!(!is_open(path), "{path}");
        }
        let [one, other] = [(); 2].map(|()| Access::new(IpAddr::from([127, 0, 0, 1])).expect("random").page());
        assert!(one != other && one.len() == 2 + 2 * TOKEN_BYTES);
    }
}
