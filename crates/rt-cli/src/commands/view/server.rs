//! Threads that serve connections, a bounded number of them.

use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use super::http::{Connection, Response, Status};
use super::routes::Session;

/// Most connections at a time. A browser opens six for each page.
const MAX_CONNECTIONS: usize = 64;

/// Pause after a connection that could not be accepted, as when there are too many open files.
const RETRY: Duration = Duration::from_millis(100);

/// Accepts connections as long as the program runs.
pub(super) fn serve(listener: &TcpListener, session: &Arc<Session>) {
    // Each connection holds a clone.
    let open = Arc::new(());
    for stream in listener.incoming() {
        let Ok(stream) = stream else {
            thread::sleep(RETRY);
            continue;
        };
        let (session, slot) = (Arc::clone(session), Arc::clone(&open));
        let is_free = Arc::strong_count(&open) <= MAX_CONNECTIONS + 1;
        let serve = move || {
            if is_free {
                converse(stream, &session)
            } else {
                refuse(stream)
            }
            drop(slot);
        };
        // Without a thread the connection is closed.
        let _ = thread::Builder::new().name("connection".to_owned()).spawn(serve);
    }
}

fn refuse(stream: TcpStream) {
    let refusal = Response::refusal(Status::BUSY, "503 Service Unavailable: too many connections");
    let _ = Connection::new(stream).and_then(|connection| connection.close_with(&refusal));
}

/// Answers requests until either side ends the connection.
fn converse(stream: TcpStream, session: &Session) {
    let Ok(mut connection) = Connection::new(stream) else { return };
    loop {
        let (response, keeps_alive) = match connection.read() {
            Ok(Some(request)) => (session.respond(&request), request.keeps_alive),
            Ok(None) => return,
            Err(status) => (Response::refusal(status, ""), false),
        };
        if !keeps_alive || response.status == Status::FORBIDDEN {
            // The client has gone if this fails.
            let _ = connection.close_with(&response);
            return;
        }
        if connection.write(&response).is_err() {
            return;
        }
        // A image may have been long on its way.
        session.shared.see_client();
    }
}
