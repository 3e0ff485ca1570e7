//! Threads that serve connections, a bounded number of them.

use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use super::http::{Connection, Response, Status};
use super::routes::Session;

/// Most connections at a time. A browser opens six for each page.
const MAX_CONNECTIONS: usize = 64;

/// Most refusals at a time, each of which waits until the client closes the connection. Others are closed without a response.
const MAX_REFUSALS: usize = 8;

/// Pause after a connection that could not be accepted, as when there are too many open files.
const RETRY: Duration = Duration::from_millis(100);

/// Accepts connections as long as the program runs.
pub(super) fn serve(listener: &TcpListener, session: &Arc<Session>) {
    let (served, refused) = (Slots::new(MAX_CONNECTIONS), Slots::new(MAX_REFUSALS));
    for stream in listener.incoming() {
        let Ok(stream) = stream else {
            thread::sleep(RETRY);
            continue;
        };
        // Without a slot or a thread the connection is closed.
        if let Some(slot) = served.take() {
            let session = Arc::clone(session);
            spawn(slot, move || converse(stream, &session));
        } else if let Some(slot) = refused.take() {
            spawn(slot, move || refuse(stream));
        }
    }
}

/// Runs a connection in a thread that holds the slot.
fn spawn(slot: Arc<()>, connection: impl FnOnce() + Send + 'static) {
    let run = move || {
        connection();
        drop(slot);
    };
    let _ = thread::Builder::new().name("connection".to_owned()).spawn(run);
}

/// A bounded number of threads.
struct Slots {
    /// Each thread holds a clone.
    slot: Arc<()>,
    most: usize,
}

impl Slots {
    fn new(most: usize) -> Self {
        Self { slot: Arc::new(()), most }
    }

    /// Slot for a thread, if one is free.
    fn take(&self) -> Option<Arc<()>> {
        (Arc::strong_count(&self.slot) <= self.most).then(|| Arc::clone(&self.slot))
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
