//! Live view of a render in the image viewer tev.
//!
//! A thread sends the tiles, so that a slow or lost viewer does not delay the render. Tiles are dropped while the queue is full; the
//! whole image is sent at the end.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::Duration;

use rt_image::Image;
use rt_render::{Crop, RenderSnapshot};
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use crate::console::Console;
use crate::error::CliError;

/// Time limit for connecting, and for progress of the queue.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Maximum number of queued tiles.
const MAX_QUEUE: usize = 256;

/// Pixels of the final image that are sent at a time.
const STRIP: usize = 1 << 18;

/// Channels; an opaque image has the first three.
const CHANNELS: [&str; 4] = ["R", "G", "B", "A"];

/// A connection to tev.
#[derive(Debug)]
pub(crate) struct Display {
    address: String,
    /// Rendered rectangle of the image.
    part: Crop,
    console: Console,
    /// `None` once the connection is lost.
    link: Option<Link>,
}

/// Connection to the sending thread.
#[derive(Debug)]
struct Link {
    updates: Sender<Update>,
    /// Number of queued updates.
    waiting: Arc<AtomicUsize>,
    ended: Receiver<io::Result<()>>,
}

/// Rectangle of the image with interleaved channels.
#[derive(Debug)]
struct Update {
    part: Crop,
    values: Vec<f32>,
}

impl Display {
    /// Connects to a viewer and shows a black image, with an alpha channel if `alpha` is set.
    ///
    /// # Errors
    /// [`CliError::Usage`] if no viewer listens at this address.
    pub(crate) fn connect(
        address: &str,
        name: &str,
        part: Crop,
        alpha: bool,
        console: Console,
    ) -> Result<Self, CliError> {
        let refused = |error: io::Error| {
            if error.kind() == io::ErrorKind::InvalidInput {
                let expected = "expected HOST:PORT, such as localhost:14158";
                return CliError::Usage(format!("--display-server {address}: {expected}"));
            }
            let advice = "start `tev` first, or remove --display-server";
            CliError::Usage(format!("--display-server {address}: {error}; {advice}"))
        };
        let mut client = open(address).map(TevClient::wrap).map_err(refused)?;
        // Names are zero-terminated.
        let name = name.replace('\0', " ");
        let channels = &CHANNELS[..if alpha { 4 } else { 3 }];
        client
            .send(PacketCreateImage {
                image_name: &name,
                grab_focus: true,
                width: part.width,
                height: part.height,
                channel_names: channels,
            })
            .map_err(refused)?;
        let (updates, arriving) = mpsc::channel();
        let (end, ended) = mpsc::channel();
        let waiting = Arc::new(AtomicUsize::new(0));
        let to_send = Arc::clone(&waiting);
        thread::spawn(move || {
            let sent = arriving.iter().try_for_each(|update| {
                send(&mut client, &name, channels, &update)?;
                to_send.fetch_sub(1, Ordering::Relaxed);
                Ok(())
            });
            // The receiver may be gone.
            let _ = end.send(sent);
        });
        Ok(Self { address: address.to_owned(), part, console, link: Some(Link { updates, waiting, ended }) })
    }

    /// Sends the finished tile, unless the queue is full.
    pub(crate) fn tile_done(&mut self, so_far: &RenderSnapshot<'_>) {
        if self.link.as_ref().is_some_and(|link| link.waiting.load(Ordering::Relaxed) < MAX_QUEUE) {
            let tile = so_far.tile();
            let part = Crop { x: tile.x - self.part.x, y: tile.y - self.part.y, ..tile };
            self.show(Update { part, values: interleaved(&so_far.pixels(), so_far.alpha().as_deref()) });
        }
    }

    pub(crate) fn finish(mut self, film: &Image) {
        let width = film.width() as usize;
        let rows = (STRIP / width.max(1)).max(1);
        for (index, pixels) in film.pixels().chunks(rows * width).enumerate() {
            let first = index * rows * width;
            let alpha = film.alpha().map(|alpha| &alpha[first..first + pixels.len()]);
            let (y, height) = ((index * rows) as u32, (pixels.len() / width) as u32);
            let part = Crop { x: 0, y, width: film.width(), height };
            self.show(Update { part, values: interleaved(pixels, alpha) });
        }
        let Some(Link { updates, waiting, ended }) = self.link.take() else { return };
        drop(updates);
        loop {
            let before = waiting.load(Ordering::Relaxed);
            match ended.recv_timeout(TIMEOUT) {
                Ok(Ok(())) => return,
                Ok(Err(error)) => return self.warn(&error.to_string()),
                Err(RecvTimeoutError::Timeout) if waiting.load(Ordering::Relaxed) < before => {}
                Err(_) => return self.warn("it stopped receiving the image"),
            }
        }
    }

    /// Queues an update; warns once if the thread has ended.
    fn show(&mut self, update: Update) {
        let Some(link) = &self.link else { return };
        link.waiting.fetch_add(1, Ordering::Relaxed);
        if link.updates.send(update).is_ok() {
            return;
        }
        let ended = self.link.take().and_then(|link| link.ended.recv().ok());
        let reason = ended
            .and_then(Result::err)
            .map_or_else(|| "it closed the connection".to_owned(), |error| error.to_string());
        self.warn(&reason);
    }

    fn warn(&self, reason: &str) {
        self.console.warn(format_args!("lost the display server at {}: {reason}; the render continues", self.address));
    }
}

/// Connects to the first address of the host that accepts.
fn open(address: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, TIMEOUT) {
            Ok(stream) => {
                stream.set_write_timeout(Some(TIMEOUT))?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

fn interleaved(pixels: &[[f32; 3]], alpha: Option<&[f32]>) -> Vec<f32> {
    match alpha {
        None => pixels.as_flattened().to_vec(),
        Some(alpha) => pixels.iter().zip(alpha).flat_map(|(&[r, g, b], &alpha)| [r, g, b, alpha]).collect(),
    }
}

fn send(client: &mut TevClient, name: &str, channels: &[&str], update: &Update) -> io::Result<()> {
    let count = channels.len() as u64;
    let Crop { x, y, width, height } = update.part;
    // The client panics unless the values are complete. A failed tile has none.
    if update.values.is_empty() || update.values.len() as u64 != count * u64::from(width) * u64::from(height) {
        return Ok(());
    }
    let (offsets, strides): (Vec<u64>, Vec<u64>) = (0..count).map(|channel| (channel, count)).unzip();
    client.send(PacketUpdateImage {
        image_name: name,
        grab_focus: false,
        channel_names: channels,
        channel_offsets: &offsets,
        channel_strides: &strides,
        x,
        y,
        width,
        height,
        data: &update.values,
    })
}
